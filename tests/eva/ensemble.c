/* ensemble.h: every case, of any window, any results of the draws and of the two propagators, which are stubs here as is kelly_realise: load.c,
 * step.c, driven.c and strings.c have them. The table may have changed, or not. */
#include "ensemble.h"
#include "contracts.h"

#define any_speed() any_real(R(-1e6), R(1e6))

const char *kelly_table_error(const kelly_table *table) { (void)table; return Frama_C_nondet(0, 1) ? 0 : "damaged"; }
const char *kelly_table_head_error(const kelly_table *table) { (void)table; return Frama_C_nondet(0, 1) ? 0 : "damaged"; }
int kelly_lifts_off(const kelly_case *run, const kelly_draw *draw) { (void)run, (void)draw; return Frama_C_interval(0, 1); }
real kelly_step_seconds(const kelly_case *run) { (void)run; return any_real(R(1e-6), R(1.0)); }

int kelly_modes_at(const kelly_table *table, real fc, unsigned count, kelly_modes *out)
{
    (void)table, (void)fc;
    out->count = count;
    return 1;
}

kelly_status kelly_realise(const kelly_table *table, const kelly_case *run, const kelly_draw *draw, kelly_modes *modes)
{
    (void)table, (void)run, (void)draw, (void)modes;
    return (kelly_status)Frama_C_interval(KELLY_OK, KELLY_RANGE);
}

static kelly_draw any_draw(void)
{
    return (kelly_draw){ any_real(0, R(1e30)), any_real(0, R(1e30)), any_real(0, R(1e30)), any_real(0, R(1e30)), any_real(0, R(1e30)) };
}

void kelly_draw_sample(const kelly_case *run, uint64_t seed, uint32_t index, kelly_draw *draw)
{
    (void)run, (void)seed, (void)index;
    *draw = any_draw();
}

void kelly_block_clear(kelly_block *block, const kelly_table *table, const kelly_case *run, unsigned lanes)
{
    (void)table, (void)run, (void)lanes;
    *block = (kelly_block){ 0 };
    block->vectors = 1;
}

void kelly_block_load(kelly_block *block, unsigned lane, const kelly_case *run, const kelly_draw *draw, const kelly_modes *modes)
{
    (void)block, (void)lane, (void)run, (void)draw, (void)modes;
}

/* A fault may put it anywhere. */
void kelly_block_advance(kelly_block *block, uint32_t ticks) { block->tick += Frama_C_nondet(0, 1) ? ticks : any_u32(); }
void kelly_block_watch(kelly_block *block) { (void)block; }
int kelly_block_sane(const kelly_block *block, unsigned lane) { (void)block, (void)lane; return Frama_C_interval(0, 1); }
uint32_t kelly_block_seal(const kelly_block *block) { (void)block; return any_u32(); }

real kelly_block_twist(const kelly_block *block, unsigned lane, const kelly_modes *modes)
{
    (void)block, (void)lane, (void)modes;
    return any_speed();
}

void kelly_block_extremes(const kelly_block *block, unsigned lane, real *lowest, real *highest)
{
    (void)block, (void)lane;
    *lowest = any_speed();
    *highest = any_speed();
}

void kelly_driven_clear(kelly_driven *driven, const kelly_table *table, const kelly_case *run, unsigned lanes)
{
    (void)table, (void)run, (void)lanes;
    *driven = (kelly_driven){ 0 };
}

void kelly_driven_load(kelly_driven *driven, unsigned lane, const kelly_table *table, const kelly_case *run,
                       const kelly_draw *draw, const kelly_modes *modes, real top_speed)
{
    (void)driven, (void)lane, (void)table, (void)run, (void)draw, (void)modes, (void)top_speed;
}

void kelly_driven_advance(kelly_driven *driven, uint32_t ticks) { driven->tick += Frama_C_nondet(0, 1) ? ticks : any_u32(); }
void kelly_driven_watch(kelly_driven *driven) { (void)driven; }
int kelly_driven_sane(const kelly_driven *driven, unsigned lane) { (void)driven, (void)lane; return Frama_C_interval(0, 1); }
uint32_t kelly_driven_seal(const kelly_driven *driven) { (void)driven; return any_u32(); }
int kelly_driven_untouched(const kelly_driven *driven) { (void)driven; return Frama_C_interval(0, 1); }
int kelly_block_untouched(const kelly_block *block) { (void)block; return Frama_C_interval(0, 1); }

real kelly_driven_twist(const kelly_driven *driven, unsigned lane, const kelly_modes *modes)
{
    (void)driven, (void)lane, (void)modes;
    return any_speed();
}

void kelly_driven_extremes(const kelly_driven *driven, unsigned lane, real *lowest, real *highest)
{
    (void)driven, (void)lane;
    *lowest = any_speed();
    *highest = any_speed();
}

/* ---- */

static kelly_work work;
static kelly_case run;
static kelly_result results[8];
static kelly_draw draws[8];
static kelly_table table;

static void any_case(void)
{
    run.fc = run.mu = run.a1 = run.a2 = run.w0 = any_real(0, R(1e30));
    run.f0 = any_real(0, R(1e30));
    for (unsigned k = 0; k < KELLY_PARAMETERS; k++) {
        run.cov[k] = Frama_C_float_interval(0, 0.5f);
    }
    run.limit = any_real(0, R(10.0));
    run.step_ns = Frama_C_unsigned_int_interval(1000, 1000000000);
    run.ticks = Frama_C_unsigned_int_interval(1, UINT32_MAX);
    run.window_first = any_u32();
    run.window_last = any_u32();
    run.torsional = Frama_C_unsigned_char_interval(1, KELLY_MODES_MAX);
    run.axial = Frama_C_unsigned_char_interval(1, KELLY_MODES_MAX);
    run.rotating = Frama_C_unsigned_char_interval(0, 1);
    run.drive.inertia = Frama_C_nondet(0, 1) ? 0 : any_real(R(1.0), R(1e12));
    run.drive.impedance = run.drive.hz = any_real(0, R(1e12));
}

static void block(void)
{
    any_case();
    kelly_run_begin(&table, &run, any_u64(), any_u32(), 1, results, &work);
    while (kelly_run_advance(&table, &run, 1, results, &work, any_u32()) > 0) {
        if (Frama_C_nondet(0, 1)) {
            work.tick = any_u32();             /* a fault */
        }
    }
    kelly_run_finish(&table, &run, 1, results, &work);
}

int main(void)
{
    const kelly_engine *const engine = &kelly_engine_here;

    for (unsigned i = 0; i < 8; i++) {
        draws[i] = any_draw();
    }
    block();
    any_case();
    engine->run(&table, &run, any_u64(), any_u32(), 8, results, &work);
    engine->run_draws(&table, &run, draws, 8, results, &work);
    return 0;
}
