/* plant.h: every checked or refused draw, every command, every reading. The two propagators are stubs here, any finite reading of a sane
 * string: step.c and load.c have them. */
#include "plant.h"
#include "contracts.h"

#ifndef FURTHER
#define FURTHER 19                       /* counts of modes: 1, all. tests/check_eva.py --rest has each */
#endif
#define any_speed() any_real(R(-1e6), R(1e6))

void kelly_block_clear(kelly_block *block, const kelly_table *table, const kelly_case *run, unsigned lanes)
{
    (void)table, (void)run, (void)lanes;
    block->tick = 0;
}

void kelly_block_load(kelly_block *block, unsigned lane, const kelly_case *run, const kelly_draw *draw, const kelly_modes *modes)
{
    (void)block, (void)lane, (void)run, (void)draw, (void)modes;
}

void kelly_block_advance(kelly_block *block, uint32_t ticks) { block->tick += ticks; }
void kelly_block_watch(kelly_block *block) { (void)block; }
real kelly_block_speed(const kelly_block *block, unsigned lane) { (void)block, (void)lane; return any_speed(); }
real kelly_block_sine(const kelly_block *block, unsigned lane) { (void)block, (void)lane; return any_real(R(-1.01), R(1.01)); }
int kelly_block_sane(const kelly_block *block, unsigned lane) { (void)block, (void)lane; return Frama_C_interval(0, 1); }
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

static void any_modal(real q[KELLY_MODES_MAX], real v[KELLY_MODES_MAX])
{
    for (unsigned i = 0; i < KELLY_MODES_MAX; i++) {
        q[i] = any_real(R(-1e15), R(1e15));
        v[i] = any_real(R(-1e15), R(1e15));
    }
}

void kelly_block_modal(const kelly_block *block, unsigned lane, const kelly_modes *modes, const kelly_table *table,
                       real q[KELLY_MODES_MAX], real v[KELLY_MODES_MAX])
{
    (void)block, (void)lane, (void)modes, (void)table;
    any_modal(q, v);
}

void kelly_driven_clear(kelly_driven *driven, const kelly_table *table, const kelly_case *run, unsigned lanes)
{
    (void)table, (void)run, (void)lanes;
    driven->tick = 0;
}

void kelly_driven_load(kelly_driven *driven, unsigned lane, const kelly_table *table, const kelly_case *run,
                       const kelly_draw *draw, const kelly_modes *modes, real top_speed)
{
    (void)lane, (void)table, (void)run, (void)draw, (void)modes, (void)top_speed;
    driven->lane[0].sine = any_real(R(-1.01), R(1.01));
    for (unsigned k = 0; k < 4; k++) {
        driven->lane[0].sines[k] = any_real(R(-1.01), R(1.01));
    }
}

void kelly_driven_advance(kelly_driven *driven, uint32_t ticks) { driven->tick += ticks; }
/* seal.c itself: ensemble.c */
uint32_t kelly_seal(uint32_t seal, const void *from, size_t bytes)
{
    (void)seal, (void)from, (void)bytes;
    /*@ assert bytes == 0 || \valid_read((const uint8_t *)from + (0 .. bytes - 1)); */
    return any_u32();
}

uint32_t kelly_driven_seal(const kelly_driven *driven) { (void)driven; return any_u32(); }
int kelly_driven_untouched(const kelly_driven *driven) { (void)driven; return Frama_C_interval(0, 1); }
int kelly_block_untouched(const kelly_block *block) { (void)block; return Frama_C_interval(0, 1); }
uint32_t kelly_block_seal(const kelly_block *block) { (void)block; return any_u32(); }
void kelly_driven_ramp(kelly_driven *driven, unsigned lane, real slope) { (void)driven, (void)lane, (void)slope; }
void kelly_driven_adjust(kelly_driven *driven, unsigned lane, real top_speed) { (void)driven, (void)lane, (void)top_speed; }
void kelly_driven_hold(kelly_driven *driven, unsigned lane, real top_speed) { (void)driven, (void)lane, (void)top_speed; }
void kelly_driven_watch(kelly_driven *driven) { (void)driven; }
real kelly_driven_speed(const kelly_driven *driven, unsigned lane) { (void)driven, (void)lane; return any_speed(); }
real kelly_driven_top_speed(const kelly_driven *driven, unsigned lane) { (void)driven, (void)lane; return any_speed(); }
int kelly_driven_sane(const kelly_driven *driven, unsigned lane) { (void)driven, (void)lane; return Frama_C_interval(0, 1); }

void kelly_driven_weigh(kelly_driven *driven, unsigned lane, const kelly_case *run, const kelly_draw *draw, real weight)
{
    (void)driven, (void)lane, (void)run, (void)draw, (void)weight;
}

void kelly_driven_extremes(const kelly_driven *driven, unsigned lane, real *lowest, real *highest)
{
    (void)driven, (void)lane;
    *lowest = any_speed();
    *highest = any_speed();
}

void kelly_driven_modal(const kelly_driven *driven, unsigned lane, const kelly_modes *modes,
                        real q[KELLY_MODES_MAX], real v[KELLY_MODES_MAX])
{
    (void)driven, (void)lane, (void)modes;
    any_modal(q, v);
}

real kelly_driven_twist(const kelly_driven *driven, unsigned lane, const kelly_modes *modes)
{
    (void)driven, (void)lane, (void)modes;
    return any_speed();
}

real kelly_driven_top_torque(const kelly_driven *driven, unsigned lane, real bit_torque)
{
    (void)driven, (void)lane, (void)bit_torque;
    return any_real(R(-1e20), R(1e20));
}

/* ---- */

static kelly_plant plant;
static kelly_case run;
static kelly_draw draw;

static void any_start(uint8_t torsional, uint8_t axial)
{
    run.f0 = any_real(0, R(1e9));
    run.step_ns = Frama_C_unsigned_int_interval(1000, 1000000000);
    run.torsional = torsional;
    run.axial = axial;
    run.rotating = Frama_C_unsigned_char_interval(0, 1);
    run.drive.inertia = Frama_C_nondet(0, 1) ? 0 : any_real(R(1.0), R(1e12));
    run.drive.impedance = any_real(0, R(1e12));
    run.drive.hz = any_real(0, R(1e3));
    draw.fc = any_real(0, R(1e9));
    draw.mu = any_real(0, R(3.0));
    draw.a1 = any_real(0, R(1000.0));
    draw.a2 = any_real(R(1e-4), R(1.8e7));
    draw.w0 = any_real(0, R(1e4));
}

static void use(void)
{
    real low, high, q[KELLY_MODES_MAX], v[KELLY_MODES_MAX];
    kelly_sight sight;

    kelly_plant_command(&plant, any_speed(), any_real(0, R(1e9)), any_u32());
    (void)kelly_plant_allows(&plant, any_real(R(-1e30), R(1e30)), any_real(R(-1e30), R(1e30)));
    kelly_plant_advance(&plant, 2);
    for (unsigned j = 0; j < plant.axial.count; j++) {
        plant.axial.v[j] = any_real(R(-1e9), R(1e9));
    }
    (void)kelly_plant_sane(&plant);
    kelly_plant_look(&plant, &sight);
    kelly_plant_watch(&plant);
    kelly_plant_extremes(&plant, &low, &high);
    kelly_plant_modal(&plant, q, v);
    (void)kelly_plant_twist(&plant);
}

static void start(uint8_t torsional, uint8_t axial)
{
    any_start(torsional, axial);
    if (kelly_plant_start(&plant, &kelly_string, &run, &draw) == KELLY_OK) {
        use();
    }
    any_start(torsional, axial);
    if (kelly_plant_start_commanded(&plant, &kelly_string, &run, &draw, any_real(R(-1e30), R(1e30))) == KELLY_OK) {
        use();
    }
}

int main(void)
{
    //@ loop unroll 20;
    for (uint8_t n = 1; n <= 20; n += FURTHER) {
        start(n, n < 11 ? n : 11);
    }
    return 0;
}
