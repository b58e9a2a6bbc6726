/* The device program from its own main: any first input, any line for an estimation, the endless loop around any work. Stubs: what is asked
 * for (requests.c), the console (console.c), realisations (ensemble.c), texts read (lines.c) and written (text.c). */
#include "app/requests.h"
#include "board.h"
#include "contracts.h"
#define main device_main
#include "../../firmware/app/device.c"
#undef main

#define any_speed() any_real(R(-1e6), R(1e6))

static int yes_or_no(void) { return Frama_C_interval(0, 1); }

uint32_t board_measure_start(void) { return any_u32(); }
uint32_t board_measure_end(uint32_t start) { (void)start; return any_u32(); }
uint32_t stack_used(void) { return any_u32(); }
uint32_t stack_size(void) { return any_u32(); }

/* ---- texts ---- */

void say_text(const char *text)
{
    while (*text != '\0') {
        text++;
    }
}

void say_decimal(uint32_t value) { (void)value; }
void say_hex(uint32_t value) { (void)value; }

void say_fixed(wide value, unsigned digits)
{
    //@ assert digits <= 7 && -1e31 <= value <= 1e31;
}

void say_number(const char *name, uint32_t value)
{
    (void)value;
    say_text(name);
}

void say_value(const char *name, wide value, unsigned digits)
{
    say_text(name);
    say_fixed(value, digits);
}

int out_pump(void) { return yes_or_no(); }
void out_defer(int on) { (void)on; }
void out_frame(uint8_t wire[KELLY_WIRE_MAX], uint8_t type, uint32_t seq, size_t size) { (void)wire, (void)type, (void)seq, (void)size; }

const char *line_read(const char line[LINE_MAX], const line_key keys[], uint64_t values[], unsigned count)
{
    (void)line;
    for (unsigned k = 0; k < count; k++) {
        say_text(keys[k].name);
        values[k] = any_u64();
    }
    return yes_or_no() ? "stranger" : 0;
}

void kelly_set_text(char *to, size_t room, const char *from)
{
    (void)from;
    Frama_C_make_unknown(to, room);
}

size_t kelly_put_error(uint8_t *to, const kelly_msg_error *message) { (void)to, (void)message; return KELLY_BODY_MAX; }
size_t kelly_put_status(uint8_t *to, const kelly_msg_status *message) { (void)to, (void)message; return KELLY_BODY_MAX; }

/* ---- work ---- */

int kelly_receive(kelly_receiver *receiver, uint8_t byte) { (void)receiver, (void)byte; return Frama_C_interval(-1, KELLY_FRAME_MAX); }

/* A request may begin anything, and end it. */
void request(kelly_bench *bench)
{
    bench->greeted = any_byte();
    bench->state = any_byte();
    bench->holds = any_byte();
}

void console_line(kelly_bench *bench, const char *line) { (void)line; request(bench); }
void console_tick(kelly_bench *bench) { (void)bench; }
void campaign_slice(kelly_bench *bench) { (void)bench; }
int lockstep_slice(kelly_bench *bench) { (void)bench; return yes_or_no(); }
int realtime_slice(kelly_bench *bench) { (void)bench; return yes_or_no(); }
void realtime_busy(kelly_bench *bench, uint32_t counts) { (void)bench, (void)counts; }

/* ---- an estimation ---- */

const char *kelly_table_error(const kelly_table *table) { (void)table; return yes_or_no() ? "damaged" : 0; }
const char *kelly_case_error(const kelly_table *table, const kelly_case *run) { (void)table, (void)run; return yes_or_no() ? "refused" : 0; }
real kelly_step_seconds(const kelly_case *run) { (void)run; return any_real(R(1e-6), R(1.0)); }

void kelly_draw_nominal(const kelly_case *run, kelly_draw *draw)
{
    (void)run;
    draw->fc = draw->mu = draw->a1 = draw->a2 = draw->w0 = any_real(0, R(1e30));
}

kelly_status kelly_realise(const kelly_table *table, const kelly_case *run, const kelly_draw *draw, kelly_modes *modes)
{
    (void)table, (void)run, (void)draw, (void)modes;
    return (kelly_status)Frama_C_interval(KELLY_OK, KELLY_RANGE);
}

void kelly_block_clear(kelly_block *block, const kelly_table *table, const kelly_case *run, unsigned lanes)
{
    (void)block, (void)table, (void)run, (void)lanes;
}

void kelly_block_load(kelly_block *block, unsigned lane, const kelly_case *run, const kelly_draw *draw, const kelly_modes *modes)
{
    (void)block, (void)lane, (void)run, (void)draw, (void)modes;
}

void kelly_block_advance(kelly_block *block, uint32_t ticks) { (void)block, (void)ticks; }

void kelly_run(const kelly_table *table, const kelly_case *run, uint64_t seed, uint32_t first, uint32_t count,
               kelly_result *results, kelly_work *work)
{
    (void)table, (void)run, (void)seed, (void)first, (void)count, (void)work;
    results->lowest = results->highest = results->mean = any_speed();
    results->ss = any_real(0, R(1e30));
    results->status = Frama_C_unsigned_char_interval(0, KELLY_STATUSES - 1);
    results->stuck = results->liftoff = Frama_C_unsigned_char_interval(0, 1);
}

void kelly_tally_add(kelly_tally *tally, uint32_t index, const kelly_result *result)
{
    (void)index, (void)result;
    tally->samples = any_u32();
    tally->stuck = any_u32();
}

uint32_t kelly_refused(const kelly_tally *tally) { (void)tally; return any_u32(); }
wide kelly_probability(const kelly_tally *tally) { (void)tally; return Frama_C_double_interval(0, 1); }

void kelly_interval(const kelly_tally *tally, wide *lo, wide *hi)
{
    (void)tally;
    *lo = *hi = Frama_C_double_interval(0, 1);
}

int main(void)
{
    //@ widen_hints "global":the_bench.length, 79;
    return device_main();
}
