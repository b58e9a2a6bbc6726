#include "../board/board.h"
#include "../kelly.h"
#include "bench.h"
#include "out.h"
#include "say.h"
#include "scpi.h"

#define TO_RPM R(9.54929658551372)
#define KILO R(1000.0)
#define SECOND_MS 1000u

static void end_line(void)
{
    say_text("\r\n");
}

static void queue(kelly_console *console, int error)
{
    if (error == SCPI_NO_ERROR) {
        return;
    }
    if (console->count == CONSOLE_ERRORS) {   /* the newest gives way to the notice */
        console->errors[(console->first + console->count - 1u) % CONSOLE_ERRORS] = SCPI_QUEUE;
        return;
    }
    console->errors[(console->first + console->count) % CONSOLE_ERRORS] = (int16_t)error;
    console->count++;
}

static void say_error(kelly_console *console)
{
    int error = SCPI_NO_ERROR;

    if (console->count > 0) {
        error = console->errors[console->first];
        console->first = (uint8_t)((console->first + 1u) % CONSOLE_ERRORS);
        console->count--;
    }
    if (error < 0) {
        say_text("-");
    }
    say_decimal((uint32_t)(error < 0 ? -error : error));
    say_text(",\"");
    say_text(scpi_error_text(error));
    say_text("\"");
    end_line();
}

/* The console's own string, running; 0 where there is none. */
static kelly_session *own(kelly_bench *bench)
{
    kelly_session *const s = &bench->now.session;

    return bench->state == KELLY_STATE_REALTIME && s->id == 0 && !s->known ? s : 0;
}

/* ---- settings ---- */

/* Whether the table has the case. */
static int takes(const kelly_case *run)
{
    return kelly_case_error(&kelly_string, run) == 0 && run->fc >= kelly_string.fc_min && run->fc <= kelly_string.fc_max;
}

enum { RPM, WOB, MU, SETTINGS };

/* What the host takes (host/options.c), from the last digit that is said on; the weight's bounds are the table's. */
static int in_range(int what, real value)
{
    static const real least[SETTINGS] = { [RPM] = R(0.01), [WOB] = 0, [MU] = R(1e-6) }, most[SETTINGS] = { [RPM] = R(1e4), [WOB] = R(1e6), [MU] = R(1e3) };

    return value >= least[what] && value <= most[what];
}

static int set_value(kelly_bench *bench, int what, const char *text)
{
    kelly_session *const s = own(bench);
    kelly_case run = bench->run;
    real value;
    int error = scpi_number(text, &value);

    if (error != SCPI_NO_ERROR) {
        return error;
    }
    if (!in_range(what, value)) {
        return SCPI_RANGE;
    }
    if (bench->state != KELLY_STATE_IDLE && (s == 0 || what == MU)) {
        return SCPI_CONFLICT;
    }
    if (what == RPM) {
        run.w0 = value / TO_RPM;
    } else if (what == WOB) {
        run.fc = value * KILO;
    } else {
        run.mu = value;
    }
    if (!takes(&run) || (s != 0 && !kelly_plant_allows(&s->plant, run.w0, run.fc))) {
        return SCPI_RANGE;
    }
    bench->run = run;
    bench->case_set = 0;         /* a case that the link has set is no longer that */
    if (s != 0) {
        realtime_set(bench, run.w0, run.fc, 1u + SECOND_MS / s->by.real_time.period);
    }
    return SCPI_NO_ERROR;
}

static void say_setting(const kelly_bench *bench, int what)
{
    if (what == RPM) {
        say_fixed((wide)(bench->run.w0 * TO_RPM), 2);
    } else if (what == WOB) {
        say_fixed((wide)(bench->run.fc / KILO), 2);
    } else {
        say_fixed((wide)bench->run.mu, 6);
    }
    end_line();
}

/* ---- the string ---- */

static int start(kelly_bench *bench)
{
    const kelly_msg_plant_start ask = { .mode = KELLY_MODE_REALTIME, .source = KELLY_SOURCE_NOMINAL, .top_speed = bench->run.w0 };

    if (bench->state != KELLY_STATE_IDLE || bench->run.step_ns < REALTIME_TICK_NS || bench->run.step_ns % REALTIME_TICK_NS != 0) {
        return SCPI_CONFLICT;
    }
    return session_begin(bench, 0, &ask) == KELLY_OK ? SCPI_NO_ERROR : SCPI_CONFLICT;
}

/* The string in memory, if it has been started. */
static kelly_session *present(kelly_bench *bench)
{
    return bench->holds == KELLY_STATE_REALTIME && bench->now.session.status == KELLY_OK ? &bench->now.session : 0;
}

static int say_reading(kelly_bench *bench)
{
    const kelly_session *const s = present(bench);
    kelly_sight sight;

    if (s == 0 || !kelly_plant_sane(&s->plant)) {
        return SCPI_CONFLICT;
    }
    kelly_plant_look(&s->plant, &sight);
    say_fixed((wide)(s->by.real_time.steps * s->by.real_time.period) / W(1000.0), 3);
    say_value(",", (wide)(sight.bit_speed * TO_RPM), 2);
    say_value(",", (wide)(sight.top_speed * TO_RPM), 2);
    say_value(",", (wide)(sight.surface_torque / KILO), 3);
    say_value(",", (wide)(-sight.bit_torque / KILO), 3);
    say_value(",", (wide)(-sight.f_bit / KILO), 2);
    end_line();
    return SCPI_NO_ERROR;
}

static int say_books(kelly_bench *bench)
{
    const kelly_session *const s = present(bench);

    if (s == 0) {
        return SCPI_CONFLICT;
    }
    say_decimal(s->by.real_time.late);
    say_number(",", s->by.real_time.worst_late_us);
    say_number(",", realtime_load(&s->by.real_time) / 10u);
    say_number(".", realtime_load(&s->by.real_time) % 10u);
    end_line();
    return SCPI_NO_ERROR;
}

static void say_wits(const kelly_bench *bench)
{
    char text[KELLY_WITS_TEXT + 1];

    gauge_wits(&bench->gauge, text, sizeof(text));
    if (out_room(sizeof(text))) {   /* the next one will do */
        say_text(text);
    }
}

static int switch_wits(kelly_bench *bench, const char *text)
{
    const char *rest;

    if (*text == '\0') {
        return SCPI_MISSING;
    }
    if (scpi_is(text, "ON", &rest) || scpi_is(text, "1", &rest)) {
        bench->console.wits = 1;
        bench->console.wits_tick = board_ticks();
    } else if (scpi_is(text, "OFF", &rest) || scpi_is(text, "0", &rest)) {
        bench->console.wits = 0;
    } else {
        return SCPI_RANGE;
    }
    return SCPI_NO_ERROR;
}

static void restore(kelly_bench *bench)
{
    bench_idle(bench);
    bench->run = kelly_string.nominal;
    bench->case_set = 0;
    bench->console.wits = 0;
}

static void say_name(void)
{
    say_text("kelly," BOARD_NAME ",");
    say_text(kelly_string.id);
    say_text("," KELLY_VERSION);
    end_line();
}

/* ---- lines ---- */

enum { IDN, RST, CLS, ERR, SET_RPM, ASK_RPM, SET_WOB, ASK_WOB, SET_MU, ASK_MU, START, STOP, READ, STATUS, ASK_WITS, SET_WITS, COMMANDS };

static const char *const patterns[COMMANDS] = {
    [IDN] = "*IDN?", [RST] = "*RST", [CLS] = "*CLS", [ERR] = "SYSTem:ERRor?", [SET_RPM] = "RPM", [ASK_RPM] = "RPM?",
    [SET_WOB] = "WOB", [ASK_WOB] = "WOB?", [SET_MU] = "MU", [ASK_MU] = "MU?", [START] = "STARt", [STOP] = "STOP",
    [READ] = "READ?", [STATUS] = "STATus?", [ASK_WITS] = "WITS?", [SET_WITS] = "WITS",
};

static int takes_parameter(int which)
{
    return which == SET_RPM || which == SET_WOB || which == SET_MU || which == SET_WITS;
}

/* -> the error to queue. */
static int carry_out(kelly_bench *bench, int which, const char *text)
{
    switch (which) {
    case IDN:
        say_name();
        break;
    case RST:
        restore(bench);
        break;
    case CLS:
        bench->console.count = 0;
        break;
    case ERR:
        say_error(&bench->console);
        break;
    case SET_RPM:
    case SET_WOB:
    case SET_MU:
        return set_value(bench, (which - SET_RPM) / 2, text);
    case ASK_RPM:
    case ASK_WOB:
    case ASK_MU:
        say_setting(bench, (which - ASK_RPM) / 2);
        break;
    case START:
        return start(bench);
    case STOP:
        bench_idle(bench);
        break;
    case READ:
        return say_reading(bench);
    case STATUS:
        return say_books(bench);
    case ASK_WITS:
        say_wits(bench);
        break;
    case SET_WITS:
        return switch_wits(bench, text);
    default:
        return SCPI_UNDEFINED;
    }
    return SCPI_NO_ERROR;
}

void console_line(kelly_bench *bench, const char *line)
{
    const char *text = "";
    int which = 0;

    while (*line == ' ') {
        line++;
    }
    while (which < COMMANDS && !scpi_is(line, patterns[which], &text)) {
        which++;
    }
    if (which < COMMANDS && *text != '\0' && !takes_parameter(which)) {
        queue(&bench->console, SCPI_NOT_ALLOWED);
        return;
    }
    queue(&bench->console, carry_out(bench, which, text));
}

void console_tick(kelly_bench *bench)
{
    if (bench->console.wits && board_ticks() - bench->console.wits_tick >= SECOND_MS) {
        bench->console.wits_tick += SECOND_MS;
        say_wits(bench);
    }
}
