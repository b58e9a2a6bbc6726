/* bench_realtime.c - the string on the board's own tick: commands in, samples out, the books at the end.
 *
 * With -icount an emulated board's second is not one of this machine's, so no commands are sent there, and neither a profile nor a frame a
 * second is taken: with --command-timeout the board acts as on a host that died.
 */
#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <signal.h>
#include <string.h>
#include <unistd.h>

#include "bench_session.h"

#define COMMAND_TIME 0.1         /* [s] between commands along a profile */
#define WITS_BAUD 9600u          /* what rig displays listen at */
#define QUIET_TIME 2.0           /* [s] without a sample, after which the board is asked how it goes */

typedef struct {
    bench_session s;
    bench_profile profile;
    outfile out;
    int wits;                    /* file descriptor, -1: none */
    int commands;                /* they are sent */
    double command_time;         /* [s] between them */
    uint32_t number;             /* of the last one */
    uint32_t samples, wits_frames, wits_lost;
    int wits_error;              /* errno of a frame that could not be written; one that waits is lost without */
    uint32_t last_tick;          /* of the last sample */
    uint8_t state;               /* KELLY_RT_..., as it said last */
    double begin, commanded, heard, displayed;
    int over;
    kelly_msg_rt_report books;
} realtime;

static const char *const states[] = { "running", "holding the last command", "ramping down", "stopped" };

/* ---- what the board says --------------------------------------------------------------------------------------- */

static void take_sample(realtime *r, const kelly_msg_rt_sample *m)
{
    const kelly_sight sight = { m->bit_speed, m->bit_torque, m->f_bit, m->axial_speed, m->surface_torque, m->top_speed };

    if (m->session != r->s.id || (r->samples > 0 && m->tick <= r->last_tick)) {
        return;
    }
    if (m->state != r->state && m->state <= KELLY_RT_STOPPED) {
        fprintf(stderr, "kelly: %s: %g s: %s\n", r->s.b->port.text, case_seconds(&r->s.run, m->tick), states[m->state]);
        r->state = m->state;
    }
    r->samples++;
    r->last_tick = m->tick;
    if (r->out.stream) {
        sight_line(r->out.stream, case_seconds(&r->s.run, m->tick), &sight);
        (void)fflush(r->out.stream);   /* outfile_close() tells */
    }
}

static void take_report(realtime *r, const kelly_msg_rt_report *m)
{
    if (m->session == r->s.id) {
        r->books = *m;
        r->over = r->over || m->state == KELLY_RT_STOPPED || m->tick >= r->s.run.ticks;
    }
}

static void take(void *context, uint8_t type, const uint8_t *body, size_t size)
{
    realtime *const r = context;
    union {
        kelly_msg_rt_sample sample;
        kelly_msg_rt_report report;
    } m;

    r->heard = port_now();
    if (type == KELLY_MSG_RT_SAMPLE && kelly_get_rt_sample(body, size, &m.sample)) {
        take_sample(r, &m.sample);
    } else if (type == KELLY_MSG_RT_REPORT && kelly_get_rt_report(body, size, &m.report)) {
        take_report(r, &m.report);
    }
}

/* ---- what it is told and asked --------------------------------------------------------------------------------- */

static void query(realtime *r)
{
    uint8_t body[KELLY_RT_QUERY_MAX];
    kelly_msg_rt_report m;

    session_call(&r->s, KELLY_MSG_RT_QUERY, body, kelly_put_rt_query(body, &(kelly_msg_rt_query){ r->s.id }), KELLY_MSG_RT_REPORT);
    r->heard = port_now();
    if (kelly_get_rt_report(r->s.reply, r->s.reply_size, &m)) {
        take_report(r, &m);
    }
}

/* Where the top and the weight are to be one command later. The string may have ended while the command was under way. */
static void command(realtime *r, double now)
{
    const double step = case_seconds(&r->s.run, 1);
    uint8_t body[KELLY_RT_COMMAND_MAX];
    kelly_msg_rt_command m = { .session = r->s.id, .number = ++r->number, .ramp_ticks = (uint32_t)fmax(1.0, r->command_time / step) };
    kelly_msg_error error;
    double rpm, wob;

    profile_at(&r->profile, now - r->begin + r->command_time, &rpm, &wob);
    m.top_speed = (real)(rpm * RPM);
    m.weight = (real)(wob * 1000.0);
    r->commanded = now;
    if (session_ask(&r->s, KELLY_MSG_RT_COMMAND, body, kelly_put_rt_command(body, &m), KELLY_MSG_RT_ACK, &error)) {
        return;
    }
    if (error.code != KELLY_ERR_ORDER) {
        board_refused(r->s.b, &error);
    }
    query(r);
}

/* A display that does not read loses frames; it holds nobody up. */
static void display(realtime *r)
{
    kelly_msg_wits m;

    r->displayed += 1.0;
    session_call(&r->s, KELLY_MSG_WITS_QUERY, 0, 0, KELLY_MSG_WITS);
    if (kelly_get_wits(r->s.reply, r->s.reply_size, &m)) {
        const size_t length = strlen(m.text);
        const ssize_t n = write(r->wits, m.text, length);

        r->wits_frames += n == (ssize_t)length;
        r->wits_lost += n != (ssize_t)length;
        r->wits_error = n < 0 && errno != EAGAIN && errno != EWOULDBLOCK ? errno : r->wits_error;
    }
}

static void watch(realtime *r)
{
    while (!r->over) {
        const double now = port_now();

        if (r->commands && now - r->commanded > r->command_time) {
            command(r, now);
        } else if (r->wits >= 0 && now > r->displayed) {
            display(r);
        } else if (now - r->heard > QUIET_TIME) {
            query(r);
        } else {
            link_wait(&r->s.set, 0.01);
        }
    }
}

/* ---- beginning and end ----------------------------------------------------------------------------------------- */

static void write_books(const realtime *r)
{
    const kelly_msg_rt_report *const m = &r->books;
    outfile file;

    outfile_open(&file, r->s.ask->opts.json);
    fprintf(file.stream, "{\n  \"mode\": \"realtime\",\n  \"steps\": %u,\n  \"step_s\": %.9g,\n  \"late\": %u,\n  \"worst_late_us\": %u,\n  \"load\": %.3f,\n"
            "  \"load_worst\": %.3f,\n  \"commands\": %u,\n  \"timeouts\": %u,\n  \"samples\": %u,\n  \"samples_received\": %u,\n  \"unsane\": %u,\n"
            "  \"state\": \"%s\",\n  \"wits_frames\": %u,\n  \"wits_lost\": %u,\n  \"board\": {", m->tick, case_seconds(&r->s.run, 1), m->late, m->worst_late_us,
            m->load_permille / 1000.0, m->load_worst_permille / 1000.0, m->commands, m->timeouts, m->samples, r->samples, m->unsane,
            m->state <= KELLY_RT_STOPPED ? states[m->state] : "unknown", r->wits_frames, r->wits_lost);
    bench_write_board(file.stream, r->s.b);
    fputs("}\n}\n", file.stream);
    outfile_close(&file);
}

/* Whether the board's time is that of its instructions. */
static int is_counted(const bench_request *ask, const board *b)
{
    return b->port.command[0] && (ask->icount || ask->port[0].icount);
}

static void print_books(const realtime *r)
{
    const kelly_msg_rt_report *const m = &r->books;

    printf("%s, %s: %u steps of %.6g ms, %u late, worst lateness %u us, load %.1f %%, longest step %.1f %% of a tick\n", r->s.b->port.text,
           r->s.b->is.board, m->tick, 1e3 * case_seconds(&r->s.run, 1), m->late, m->worst_late_us, m->load_permille / 10.0,
           m->load_worst_permille / 10.0);
    printf("%u commands, %u times without a host, %u samples sent and %u received, watchdog %s, %s\n", m->commands, m->timeouts, m->samples,
           r->samples, r->s.b->is.watchdog == KELLY_WATCHDOG_NONE ? "none" : "kicked after each checked step",
           m->state <= KELLY_RT_STOPPED ? states[m->state] : "in an unknown state");
    if (!is_counted(r->s.ask, r->s.b) && r->s.b->port.command[0]) {
        puts("an emulator without --icount: lateness and load are those of this machine");
    }
    if (r->wits >= 0) {
        printf("WITS: %u frames written, %u lost\n", r->wits_frames, r->wits_lost);
    }
}

static int finish(const realtime *r)
{
    const kelly_msg_rt_report *const m = &r->books;

    if (r->s.ask->opts.json) {
        write_books(r);
    }
    if (bench_speaks(&r->s.ask->opts)) {
        print_books(r);
    }
    if (m->unsane > 0) {
        die(EXIT_FAILED, "%s: step %u: the state left all bounds; the board stopped", r->s.b->port.text, m->tick);
    }
    if (r->wits_error != 0) {
        die(EXIT_FAILED, "--wits %s: %u of %u frames could not be written: %s", r->s.ask->wits, r->wits_lost, r->wits_lost + r->wits_frames,
            strerror(r->wits_error));
    }
    return EXIT_DONE;
}

static void start(realtime *r)
{
    const bench_request *const ask = r->s.ask;
    const int counted = is_counted(ask, r->s.b);
    const double timeout = ask->command_timeout >= 0 ? ask->command_timeout : counted ? 0 : 1;
    const double ticks = ask->stream_hz > 0 ? 1.0 / (ask->stream_hz * case_seconds(&r->s.run, 1)) : 0;
    kelly_msg_plant_start m = {
        .mode = KELLY_MODE_REALTIME, .top_speed = r->s.draw.w0, .duration = r->s.run.ticks,
        .stream_ticks = ticks > 0 && ticks < 1 ? 1 : (uint32_t)nearbyint(ticks), .command_ms = (uint32_t)nearbyint(1000.0 * timeout),
        .policy = (uint8_t)ask->policy, .ramp_ms = (uint32_t)nearbyint(1000.0 * ask->ramp),
        .overload_steps = ask->overload_steps, .overload_us = ask->overload_us,
    };

    if (r->s.run.step_ns % 1000000u != 0 || r->s.b->is.tick_hz != 1000) {
        die(EXIT_USAGE, "--step %g: in real time a step is whole milliseconds, the board's tick", case_seconds(&r->s.run, 1));
    }
    r->commands = !counted && (ask->profile || timeout > 0);
    r->command_time = ask->profile || timeout <= 0 ? COMMAND_TIME : timeout / 4;
    r->command_time = timeout > 0 && timeout / 4 < r->command_time ? timeout / 4 : r->command_time;
    session_start(&r->s, &m);
    r->begin = r->heard = r->commanded = port_now();
    r->displayed = r->begin + 1.0;
}

static void open_files(realtime *r)
{
    const bench_request *const ask = r->s.ask;

    r->wits = -1;
    if (ask->opts.out) {
        outfile_open(&r->out, ask->opts.out);
        fputs(SIGHT_HEADER, r->out.stream);
    }
    if (ask->wits) {
        (void)signal(SIGPIPE, SIG_IGN);   /* a display that went is told at the end */
        r->wits = open(ask->wits, O_WRONLY | O_CREAT | O_APPEND | O_NOCTTY | O_NONBLOCK | O_CLOEXEC, 0666);
        if (r->wits < 0 || (isatty(r->wits) && !port_settle(r->wits, WITS_BAUD))) {
            die(EXIT_FAILED, "--wits %s: cannot write here: %s", ask->wits, strerror(errno));
        }
    }
}

int bench_realtime(const bench_request *ask, board *b)
{
    static realtime r;

    if (ask->opts.run.drive.inertia > 0) {
        die(EXIT_USAGE, "--drive soft: not in --mode realtime, where the top is commanded; use lockstep, or command the board from a controller");
    }
    if (is_counted(ask, b) && (ask->profile || ask->wits)) {
        die(EXIT_USAGE, "%s: not with --icount, where the board's seconds are not this machine's; leave --icount out, or use lockstep",
            ask->profile ? "--profile" : "--wits");
    }
    profile_open(&r.profile, ask, 0);
    session_open(&r.s, ask, b);
    r.s.unasked = take;
    r.s.context = &r;
    open_files(&r);
    start(&r);
    watch(&r);
    if (r.out.stream) {
        outfile_close(&r.out);
    }
    return finish(&r);
}

/* ---- a rig display --------------------------------------------------------------------------------------------- */

int bench_wits(const bench_request *ask, board *b)
{
    static bench_session s;
    const double end = port_now() + (ask->duration_given ? case_seconds(&ask->opts.run, ask->opts.run.ticks) : 0);
    kelly_msg_wits m;
    double next;

    session_open(&s, ask, b);
    do {
        next = port_now() + 1.0;
        session_call(&s, KELLY_MSG_WITS_QUERY, 0, 0, KELLY_MSG_WITS);
        if (!kelly_get_wits(s.reply, s.reply_size, &m)) {
            die(EXIT_FAILED, "%s: the answer holds no WITS frame", b->port.text);
        }
        fputs(m.text, stdout);
        (void)fflush(stdout);   /* main() tells */
        while (next < end && port_now() < next) {
            link_wait(&s.set, 0.05);
        }
    } while (next < end);
    return EXIT_DONE;
}
