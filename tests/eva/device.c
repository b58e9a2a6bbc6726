/* The device program from its start, for every byte that its line may bring and every clock: the entry is its own main.
 *
 * The plant is a stub here, any finite sight and any verdict: step.c and others have the plant itself. */
#include "board/board.h"
#include "board/fault.h"
#include "ensemble.h"
#include "plant.h"
#include "tally.h"

#define any_speed() any_real(R(-1e6), R(1e6))
#define any_value() any_real(R(-1e30), R(1e30))

/* ---- board ---- */

int board_read(void) { return Frama_C_interval(-1, 255); }
int board_ready(void) { return Frama_C_interval(0, 1); }
void board_write(uint8_t byte) { (void)byte; }
uint32_t board_ticks(void) { return any_u32(); }
uint32_t board_micros(void) { return any_u32(); }
uint32_t board_count(void) { return any_u32(); }
int board_counts_cycles(void) { return Frama_C_interval(0, 1); }
void board_idle(void) { }
void board_vectors(int readable) { (void)readable; }
int board_watchdog(void) { return Frama_C_interval(0, 2); }
void watchdog_start(uint32_t ms) { (void)ms; }
void watchdog_kick(void) { }
void watchdog_stop(void) { }
void board_text(const char *text)
{
    while (*text != '\0') {
        board_write((uint8_t)*text++);
    }
}
uint32_t board_measure(void (*work)(void *), void *of)
{
    work(of);
    return any_u32();
}
uint32_t stack_used(void) { return any_u32(); }
uint32_t stack_size(void) { return any_u32(); }
static const uint8_t image[1000] = { 1 };
const uint8_t *board_image(uint32_t *size)
{
    *size = Frama_C_unsigned_int_interval(1, sizeof(image));
    return image;
}

/* ---- kernel ---- */

static void any_result(kelly_result *result)
{
    result->lowest = any_speed();
    result->highest = any_speed();
    result->mean = any_value();
    result->ss = any_value();
    result->status = Frama_C_unsigned_char_interval(0, KELLY_STATUSES - 1);
    result->stuck = Frama_C_unsigned_char_interval(0, 1);
    result->liftoff = Frama_C_unsigned_char_interval(0, 1);
}

void kelly_run_begin(const kelly_table *table, const kelly_case *run, uint64_t seed, uint32_t first, unsigned count,
                     kelly_result *results, kelly_work *work)
{
    (void)table;
    (void)work;
    //@ assert count == 1;
    kelly_draw_sample(run, seed, first, &results[0].draw);
    any_result(&results[0]);
}

uint32_t kelly_run_advance(const kelly_table *table, const kelly_case *run, unsigned count, kelly_result *results,
                           kelly_work *work, uint32_t ticks)
{
    (void)table;
    (void)run;
    (void)results;
    (void)work;
    //@ assert count == 1 && ticks > 0;
    return any_u32();
}

void kelly_run_finish(const kelly_table *table, const kelly_case *run, unsigned count, kelly_result *results, kelly_work *work)
{
    (void)table;
    (void)run;
    (void)work;
    //@ assert count == 1;
    any_result(&results[0]);
}

void kelly_run(const kelly_table *table, const kelly_case *run, uint64_t seed, uint32_t first, uint32_t count,
               kelly_result *results, kelly_work *work)
{
    kelly_run_begin(table, run, seed, first, count, results, work);
}

void kelly_block_clear(kelly_block *block, const kelly_table *table, const kelly_case *run, unsigned lanes)
{
    (void)block, (void)table, (void)run, (void)lanes;
}

void kelly_block_load(kelly_block *block, unsigned lane, const kelly_case *run, const kelly_draw *draw, const kelly_modes *modes)
{
    (void)block, (void)lane, (void)run, (void)draw, (void)modes;
}

void kelly_block_advance(kelly_block *block, uint32_t ticks)
{
    (void)block, (void)ticks;
}

kelly_status kelly_plant_start_commanded(kelly_plant *plant, const kelly_table *table, const kelly_case *run, const kelly_draw *draw,
                                         real top_speed)
{
    (void)plant, (void)table, (void)run, (void)draw, (void)top_speed;
    return (kelly_status)Frama_C_interval(KELLY_OK, KELLY_RANGE);
}

int kelly_plant_allows(const kelly_plant *plant, real top_speed, real weight)
{
    (void)plant, (void)top_speed, (void)weight;
    return Frama_C_interval(0, 1);
}

void kelly_plant_command(kelly_plant *plant, real top_speed, real weight, uint32_t ticks)
{
    (void)plant, (void)top_speed, (void)weight;
    //@ assert ticks >= 1;
}

void kelly_plant_advance(kelly_plant *plant, uint32_t ticks)
{
    (void)plant, (void)ticks;
}

int kelly_plant_sane(const kelly_plant *plant)
{
    (void)plant;
    return Frama_C_interval(0, 1);
}

void kelly_plant_look(const kelly_plant *plant, kelly_sight *sight)
{
    (void)plant;
    sight->bit_speed = any_speed();
    sight->bit_torque = any_real(R(-1e12), R(1e12));
    sight->f_bit = any_real(R(-2e10), 0);
    sight->axial_speed = any_speed();
    sight->surface_torque = any_real(R(-1e12), R(1e12));
    sight->top_speed = any_speed();
}

void kelly_interval(const kelly_tally *tally, wide *lo, wide *hi)
{
    (void)tally;
    *lo = Frama_C_double_interval(0, 1);
    *hi = Frama_C_double_interval(0, 1);
}
