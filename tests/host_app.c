/* host_app.c - the device program on a line and a clock that the test holds: its pieces line.c, say.c, scpi.c, out.c, gauge.c, the lines that
 * an estimation takes, and what a board never does by itself: a string out of bounds. */
#include <string.h>
#include <stdio.h>

#include "../firmware/app/bench.h"
#include "../firmware/app/estimate.h"
#include "../firmware/app/gauge.h"
#include "../firmware/app/line.h"
#include "../firmware/app/out.h"
#include "../firmware/app/say.h"
#include "../firmware/app/scpi.h"
#include "../firmware/board/board.h"
#include "check.h"

/* The line: what is to be read, what has been sent, and how many bytes more it takes without waiting. */
static const char *coming = "";
static char sent[2 * OUT_RING];
static unsigned sent_count, takes;
static uint32_t now_ms, looks_a_ms;        /* 0: the clock stands until the program sleeps */

int board_read(void) { return *coming == '\0' ? -1 : (uint8_t)*coming++; }
uint32_t board_ticks(void)
{
    static uint32_t looks;

    now_ms += looks_a_ms > 0 && ++looks % looks_a_ms == 0;
    return now_ms;
}

uint32_t board_micros(void) { return board_ticks() * 1000u; }
uint32_t board_count(void) { return now_ms * 7u; }
int board_watchdog(void) { return 0; }
void board_vectors(int readable) { (void)readable; }
void watchdog_start(uint32_t ms) { (void)ms; }
void watchdog_kick(void) { }
void watchdog_stop(void) { }

const uint8_t *board_image(uint32_t *size)
{
    *size = 0;
    return (const uint8_t *)coming;
}

uint32_t board_measure_start(void) { return now_ms; }
uint32_t board_measure_end(uint32_t start) { return now_ms - start; }
int board_counts_cycles(void) { return 0; }
uint32_t stack_used(void) { return 0; }
uint32_t stack_size(void) { return 0; }
void board_idle(void) { now_ms += 1000; }
int board_ready(void) { return takes > 0; }

void board_write(uint8_t byte)
{
    takes -= takes > 0;
    sent[sent_count++] = (char)byte;
    sent[sent_count] = '\0';
}

void board_text(const char *text)
{
    for (; *text != '\0'; text++) {
        board_write((uint8_t)*text);
    }
}

void check_put(char c)
{
    (void)putchar(c);
}

/* Whether this has been sent since the last time. */
static int said(const char *text)
{
    const int same = strcmp(sent, text) == 0;

    sent_count = 0;
    sent[0] = '\0';
    return same;
}

/* ---- line.c ---- */

static void asks_for_a_line(void)
{
    char line[LINE_MAX], longer[LINE_MAX + 20];

    coming = "seed=7\nx";
    EQUAL(line_ask(line), 6);
    CHECK(said("?\n") && strcmp(line, "seed=7") == 0);
    coming = "\r";
    EQUAL(line_ask(line), 0);
    memset(longer, 'a', sizeof(longer) - 2);
    memcpy(&longer[sizeof(longer) - 2], "\n", 2);
    coming = longer;
    EQUAL(line_ask(line), LINE_MAX - 1);
    coming = "no end";
    now_ms = 0;
    CHECK(line_ask(line) == -1 && line[0] == '\0' && now_ms == LINE_WAIT_MS);
    (void)said("");
}

/* A text in as many bytes as a line has. */
static const char *line_of(const char *text)
{
    static char line[LINE_MAX];

    (void)snprintf(line, sizeof(line), "%s", text);
    return line;
}

/* What the line does not understand, "" where it understands all, and the values that it has read. */
static const char *read_line(const char *text, uint64_t values[3])
{
    static const line_key keys[] = { { "seed", 0, 9 }, { "first", UINT32_MAX, 0 }, { "count", 1, 0 } };
    const char *const stranger = line_read(line_of(text), keys, values, 3);

    return stranger == 0 ? "" : stranger;
}

static void reads_numbers(void)
{
    uint64_t values[3];

    CHECK(strcmp(read_line("first=4294967295 seed=18446744073709551615 count=1", values), "") == 0);
    CHECK(values[0] == UINT64_MAX && values[1] == UINT32_MAX && values[2] == 1);
    CHECK(strcmp(read_line("  first=012  ", values), "") == 0 && values[0] == 9 && values[1] == 12 && values[2] == 0);
    CHECK(strcmp(read_line("", values), "") == 0);
    CHECK(strcmp(read_line("first=1 seed=18446744073709551616", values), "seed=18446744073709551616") == 0);
    CHECK(strcmp(read_line("seed=1 first=4294967296", values), "first=4294967296") == 0);
    CHECK(strcmp(read_line("first=18446744073709551615 seed=1", values), "first=18446744073709551615 seed=1") == 0);
    CHECK(strcmp(read_line("count=2", values), "count=2") == 0);
    CHECK(strcmp(read_line("seed=1 first=2 seed=1", values), "seed=1") == 0);
    CHECK(strcmp(read_line("seedling=3", values), "seedling=3") == 0);
    CHECK(strcmp(read_line("seed=1 last=2", values), "last=2") == 0);
    CHECK(strcmp(read_line("seed=1, first=2", values), "seed=1, first=2") == 0);
    for (unsigned k = 0; k < 6; k++) {
        static const char *const none[] = { "seed=", "seed", "seed=-1", "seed=:", "seed=5x", "seed=1/" };

        CHECK(strcmp(read_line(none[k], values), none[k]) == 0);
    }
}

/* ---- say.c ---- */

static void writes_fixed_point(void)
{
    say_fixed(W(2.675), 1);
    CHECK(said("2.7"));
    say_fixed(W(-0.25), 2);
    CHECK(said("-0.25"));
    say_fixed(W(7.5), 0);
    CHECK(said("8"));
    say_fixed(W(1e20), 3);
    CHECK(said("2147483.520"));
    say_number("n ", UINT32_MAX);
    say_hex(0xBEEF01u);
    CHECK(said("n 429496729500beef01"));
}

/* ---- scpi.c ---- */

static int number_of(const char *text, real *value)
{
    *value = 0;
    return scpi_number(text, value);
}

static void reads_scpi(void)
{
    const char *rest = "";
    real value;

    CHECK(scpi_is("syst:err?", "SYSTem:ERRor?", &rest) && *rest == '\0');
    CHECK(scpi_is("SYSTEM:ERRor?  x", "SYSTem:ERRor?", &rest) && strcmp(rest, "x") == 0);
    CHECK(!scpi_is("SYSTe:ERR?", "SYSTem:ERRor?", &rest) && !scpi_is("SYS:ERR?", "SYSTem:ERRor?", &rest));
    CHECK(!scpi_is("START?", "STARt", &rest) && !scpi_is("[PM", "RPM", &rest));
    CHECK(number_of("+2.5", &value) == SCPI_NO_ERROR && value == R(2.5));
    CHECK(number_of("-.25 ", &value) == SCPI_NO_ERROR && value == R(-0.25));
    EQUAL(number_of("1.2.3", &value), SCPI_BAD_NUMBER);
    EQUAL(number_of("-", &value), SCPI_BAD_NUMBER);
    EQUAL(number_of("1234567890", &value), SCPI_BAD_NUMBER);
    EQUAL(number_of("", &value), SCPI_MISSING);
    for (int error = -350; error <= 0; error++) {
        CHECK(scpi_error_text(error)[0] != '\0');
    }
}

/* ---- out.c ---- */

/* What waits goes out in order; what does not fit pushes the oldest out. */
static void keeps_what_the_line_does_not_take(void)
{
    takes = 3;
    out_defer(1);
    say_text("abcdef");
    CHECK(said("") && out_room(OUT_RING - 6) && !out_room(OUT_RING - 5));
    CHECK(out_pump() && said("abc"));
    for (unsigned k = 0; k < OUT_RING; k++) {
        out_byte((uint8_t)('A' + k % 26u));
    }
    CHECK(said("def"));
    out_defer(0);
    CHECK(sent_count == OUT_RING && sent[0] == 'A' && sent[OUT_RING - 1] == (char)('A' + (OUT_RING - 1) % 26u));
    CHECK(!out_pump() && out_room(OUT_RING));
    (void)said("");
}

/* ---- gauge.c ---- */

static int has_item(const kelly_gauge *gauge, const char *item)
{
    char text[KELLY_WITS_TEXT + 1];

    gauge_wits(gauge, text, sizeof(text));
    return strstr(text, item) != 0;
}

static void shows_the_last_seconds(void)
{
    static kelly_gauge gauge;
    kelly_sight sight = { .f_bit = R(-1e5), .top_speed = R(10.0) };

    gauge_clear(&gauge);
    CHECK(has_item(&gauge, "0922-9999\r\n"));
    for (uint32_t tick = 0; tick <= 14000; tick += 500) {                /* 14 seconds of 1 ms, one look at 3, none at 4: 20 rpm and 40 in turn, at first 100 */
        sight.bit_speed = R(2.0943951) * (tick == 0 ? R(5.0) : tick % 1000 == 0 ? R(1.0) : R(2.0));
        if (tick < 3500 || tick >= 5000) {
            gauge_look(&gauge, &sight, tick, 1000000);
        }
        CHECK(tick != 3000 || has_item(&gauge, "0922100.00\r\n"));
    }
    EQUAL(gauge.seconds, 13);
    CHECK(has_item(&gauge, "092120.00\r\n") && has_item(&gauge, "092240.00\r\n") && has_item(&gauge, "0120"));
}

static void counts_a_campaign_once(void)
{
    static kelly_gauge gauge;
    const kelly_result stuck = { .status = KELLY_OK, .stuck = 1 }, clear = { .status = KELLY_OK }, refused = { .status = KELLY_STEP };

    gauge_job(&gauge, 5);
    gauge_count(&gauge, 0, &stuck);
    gauge_count(&gauge, 1, &clear);
    gauge_count(&gauge, 0, &stuck);
    gauge_count(&gauge, 2, &refused);
    gauge_job(&gauge, 5);
    CHECK(gauge.samples == 2 && gauge.stuck == 1 && has_item(&gauge, "09272\r\n"));
    gauge_job(&gauge, 6);
    CHECK(gauge.samples == 0 && gauge.next == 0);
}

/* ---- estimate.c ---- */

/* Whether an estimation of this line ends with this status and says this somewhere. */
static int ends(const char *text, int status, const char *word)
{
    static kelly_work work;
    const int got = estimate(line_of(text), &work), has = strstr(sent, word) != 0;

    (void)said("");
    return got == status && has;
}

static void estimates_what_is_asked(void)
{
    CHECK(ends("samples=1 seconds=1", 0, "mu 0.040000, alpha1 2.000, alpha2 1.000, start rest, window 0.000:1.000 s\n"));
    CHECK(ends("samples=1 seconds=2 from=0", 0, "window 0.000:2.000 s\n"));
    CHECK(ends("samples=1 from=99", 0, "window 99.000:100.000 s\n"));
    CHECK(ends("mu_e6=1000000000 seconds=1 samples=1", 0, "mu 1000.000000,"));
    CHECK(ends("digest=1 samples=1 seconds=4 from=2 first=4294967295", 0, "realisation 4294967295 "));
}

/* Numbers that do not fit their place, once cut to 32 bits or added modulo 2^64. (count=1: what is not refused ends soon.) */
static void refuses_what_cannot_be(void)
{
    static const char *const strange[] = { "mu_e6=4294967297", "mu_e6=4294967296", "mu_e6=1000000001", "first=18446744073709551615", "first=4294967296",
                                           "samples=18446744073709551614 first=4", "samples=1000001", "seconds=4294967298", "from=4294967297",
                                           "seed=1 seed=2", "digest=2" };
    char line[LINE_MAX];

    for (unsigned k = 0; k < sizeof(strange) / sizeof(strange[0]); k++) {
        (void)snprintf(line, sizeof(line), "count=1 %s", strange[k]);
        CHECK(ends(line, 2, "not understood: ") && ends(line, 2, strstr(strange[k], "seed=2") ? "seed=2" : strange[k]) && ends(line, 2, "each once, whole numbers within range\n"));
    }
    CHECK(ends("count=2", 2, "not understood: count=2;"));
    CHECK(ends("samples=2 seconds=8 from=4000000", 1, "the window must be a part of the run\n"));
    CHECK(ends("samples=1 seconds=8 from=4000001", 1, "the window must be a part of the run\n"));
    CHECK(ends("samples=2 seconds=8 from=8", 1, "the window must be a part of the run\n"));
    CHECK(ends("samples=1 from=3 seconds=0", 1, "the window must be a part of the run\n"));
    CHECK(ends("samples=1 from=100", 1, "the window must be a part of the run\n"));
    CHECK(ends("count=1 seconds=4000001", 1, "the window must be a part of the run\n"));
    CHECK(ends("samples=1 seconds=1 mu_e6=0", 1, "must be positive\n"));
    CHECK(ends("first=4294967295 samples=2", 1, "indices end at 4294967295\n"));
    CHECK(ends("samples=0 first=3", 1, "samples from 1 on"));
}

/* A line of one byte more than is kept: what is left of it would be another order. */
static void marks_a_line_that_it_cuts(void)
{
    static kelly_bench bench;
    char line[LINE_MAX + 2];

    (void)snprintf(line, sizeof(line), "seed=1 samples=%*d\n", LINE_MAX - 15, 12);
    bench_start(&bench);
    for (const char *byte = line; *byte != '\n'; byte++) {
        (void)bench_take(&bench, (uint8_t)*byte);
    }
    EQUAL(bench_take(&bench, '\n'), BENCH_ESTIMATE);
    CHECK(ends(bench.line, 2, "~"));
    (void)snprintf(line, sizeof(line), "RPM%*s20\n", LINE_MAX - 5, "1");
    bench.decided = 1;
    for (const char *byte = line; *byte != '\0'; byte++) {
        (void)bench_take(&bench, (uint8_t)*byte);
    }
    console_line(&bench, "SYST:ERR?");
    CHECK(said("-121,\"Invalid character in number\"\r\n"));
}

/* ---- console.c ---- */

/* Whether a setting is refused as out of range, and what it was stands. */
static int out_of_range(kelly_bench *bench, const char *set, const char *ask, const char *stands)
{
    int same;

    console_line(bench, set);
    console_line(bench, ask);
    same = said(stands);
    console_line(bench, "SYST:ERR?");
    return said("-222,\"Data out of range\"\r\n") && same;
}

static int sets(kelly_bench *bench, const char *set, const char *ask, const char *answer)
{
    console_line(bench, set);
    console_line(bench, ask);
    return said(answer);
}

/* As the host's --rpm, --wob, --mu; beyond them the answer to a question would be another number than the setting. */
static void bounds_settings(void)
{
    static kelly_bench bench;

    bench_start(&bench);
    CHECK(sets(&bench, "RPM 10000", "RPM?", "10000.00\r\n") && sets(&bench, "MU 1000", "MU?", "1000.000000\r\n"));
    CHECK(sets(&bench, "WOB 1000", "WOB?", "1000.00\r\n") && sets(&bench, "MU .000001", "MU?", "0.000001\r\n"));
    CHECK(sets(&bench, "MU 0.04", "MU?", "0.040000\r\n") && sets(&bench, "RPM .01", "RPM?", "0.01\r\n") && sets(&bench, "RPM 60", "RPM?", "60.00\r\n"));
    CHECK(out_of_range(&bench, "MU 5000", "MU?", "0.040000\r\n") && out_of_range(&bench, "MU 1000.01", "MU?", "0.040000\r\n"));
    CHECK(out_of_range(&bench, "MU 0", "MU?", "0.040000\r\n") && out_of_range(&bench, "MU -1", "MU?", "0.040000\r\n"));
    CHECK(out_of_range(&bench, "RPM 999999999", "RPM?", "60.00\r\n") && out_of_range(&bench, "RPM 10000.1", "RPM?", "60.00\r\n"));
    CHECK(out_of_range(&bench, "RPM .0009", "RPM?", "60.00\r\n") && out_of_range(&bench, "WOB 999999999", "WOB?", "1000.00\r\n"));
    console_line(&bench, "SYST:ERR?");
    CHECK(said("0,\"No error\"\r\n"));
}

/* ---- a string out of bounds ---- */

/* In real time the session ends and its books say so; the console has nothing to read, and lockstep answers that it is not sane. */
static void ends_a_string_out_of_bounds(void)
{
    static kelly_bench bench;
    kelly_session *const s = &bench.now.session;
    kelly_msg_plant_start ask = { .mode = KELLY_MODE_REALTIME, .source = KELLY_SOURCE_NOMINAL };
    const kelly_msg_lock_step next = { .session = 3, .frame = 1, .ticks = 1, .top_speed = R(10.0), .weight = R(1e5) };

    bench_start(&bench);
    ask.top_speed = bench.run.w0;
    looks_a_ms = 4;
    EQUAL(session_begin(&bench, 3, &ask), KELLY_OK);
    for (unsigned k = 0; k < 1000 && s->by.real_time.steps < 5; k++) {
        (void)realtime_slice(&bench);
    }
    CHECK(bench.state == KELLY_STATE_REALTIME && s->by.real_time.unsane == 0);
    s->plant.driven.mode[0][0].v = CHECK_NAN;
    for (unsigned k = 0; k < 1000 && bench.state == KELLY_STATE_REALTIME; k++) {
        (void)realtime_slice(&bench);
    }
    CHECK(s->by.real_time.unsane == 1 && s->by.real_time.state == KELLY_RT_STOPPED && s->by.real_time.steps == 6);
    console_line(&bench, "READ?");
    (void)said("");
    console_line(&bench, "SYST:ERR?");
    CHECK(said("-221,\"Settings conflict\"\r\n"));
    ask.mode = KELLY_MODE_LOCKSTEP;
    EQUAL(session_begin(&bench, 3, &ask), KELLY_OK);
    lockstep_step(&bench, 1, &next);
    s->plant.driven.mode[0][0].v = CHECK_NAN;
    while (lockstep_slice(&bench)) {
    }
    CHECK(s->by.lock.answer.frame == 1 && s->by.lock.answer.sane == 0 && s->by.lock.answer.tick == 1);
    looks_a_ms = 0;
}

int main(void)
{
    asks_for_a_line();
    reads_numbers();
    writes_fixed_point();
    reads_scpi();
    keeps_what_the_line_does_not_take();
    shows_the_last_seconds();
    counts_a_campaign_once();
    estimates_what_is_asked();
    refuses_what_cannot_be();
    marks_a_line_that_it_cuts();
    bounds_settings();
    ends_a_string_out_of_bounds();
    printf("%u passed, %u failed\n", check_passed, check_failed);
    return check_failed != 0;
}
