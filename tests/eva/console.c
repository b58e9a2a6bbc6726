/* console.h: any text of up to 79 bytes, whatever the bench does and has kept. Stubs: the string and its readings (plant.c), what starts and
 * moves it, the frame of WITS (link.c). What compares and reads texts: lines.c; what writes: text.c. */
#include "app/bench.h"
#include "app/out.h"
#include "app/say.h"
#include "board.h"
#include "contracts.h"

#define any_speed() any_real(R(-1e6), R(1e6))

static int yes_or_no(void) { return Frama_C_interval(0, 1); }

const char *kelly_case_error(const kelly_table *table, const kelly_case *run) { (void)table, (void)run; return yes_or_no() ? "refused" : 0; }
int kelly_plant_allows(const kelly_plant *plant, real top_speed, real weight) { (void)plant, (void)top_speed, (void)weight; return yes_or_no(); }
int kelly_plant_sane(const kelly_plant *plant) { (void)plant; return yes_or_no(); }

void kelly_plant_look(const kelly_plant *plant, kelly_sight *sight)
{
    (void)plant;
    *sight = (kelly_sight){ .bit_speed = any_speed(), .top_speed = any_speed(), .bit_torque = any_real(R(-1e20), R(1e20)),
                            .surface_torque = any_real(R(-1e20), R(1e20)), .f_bit = any_real(R(-1e20), R(1e20)) };
}

kelly_status session_begin(kelly_bench *bench, uint32_t id, const kelly_msg_plant_start *ask)
{
    (void)bench, (void)id, (void)ask;
    return (kelly_status)Frama_C_interval(KELLY_OK, KELLY_RANGE);
}

void realtime_set(kelly_bench *bench, real top_speed, real weight, uint32_t ticks) { (void)bench, (void)top_speed, (void)weight, (void)ticks; }
uint32_t realtime_load(const kelly_realtime *rt) { (void)rt; return any_u32(); }
void bench_idle(kelly_bench *bench) { bench->state = KELLY_STATE_IDLE; }

void gauge_wits(const kelly_gauge *gauge, char *text, size_t room)
{
    (void)gauge;
    Frama_C_make_unknown(text, room);
    text[room - 1] = '\0';
}

/* ---- */

static kelly_bench bench;
static char line[LINE_MAX];

static void any_bench(void)
{
    bench.state = any_byte();
    bench.holds = any_byte();
    bench.case_set = any_byte();
    bench.run.fc = any_real(0, R(1e9));
    bench.run.mu = any_real(0, R(1e9));
    bench.run.w0 = any_real(0, R(1e9));
    bench.run.step_ns = any_u32();
    bench.now.session.id = any_u32();
    bench.now.session.status = any_byte();
    bench.now.session.known = any_byte();
    bench.now.session.by.real_time.period = Frama_C_unsigned_int_interval(1, UINT32_MAX);   /* realtime_begin */
    bench.now.session.by.real_time.steps = any_u32();
    bench.now.session.by.real_time.late = any_u32();
    bench.now.session.by.real_time.worst_late_us = any_u32();
    for (unsigned k = 0; k < CONSOLE_ERRORS; k++) {
        bench.console.errors[k] = (int16_t)Frama_C_interval(INT16_MIN, 0);
    }
    bench.console.first = Frama_C_unsigned_char_interval(0, CONSOLE_ERRORS - 1u);
    bench.console.count = Frama_C_unsigned_char_interval(0, CONSOLE_ERRORS);
    bench.console.wits = any_byte();
    bench.console.wits_tick = any_u32();
}

int main(void)
{
    any_bench();
    ANY(line);
    line[LINE_MAX - 1] = '\0';
    console_line(&bench, line);
    //@ assert bench.console.first < CONSOLE_ERRORS && bench.console.count <= CONSOLE_ERRORS;
    any_bench();
    console_tick(&bench);
    return 0;
}
