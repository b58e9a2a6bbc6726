/* bench_lockstep.c - processor in the loop: the board's string and this program's, frame by frame, bit by bit. */
#include <stdlib.h>
#include <string.h>

#include "bench_session.h"

#define FIELDS 6u

static const char *const field_names[FIELDS] = { "bit speed", "bit torque", "weight", "surface torque", "axial speed", "top speed" };

/* A soft drive in this program, fed with the torque that the board answers: J W' = 4 Z e + (2 pi f)^2 J int e - T, e = set - W. */
typedef struct {
    kelly_drive law;
    double speed, sum;           /* W [rad/s], int e [rad] */
} controller;

static double control(controller *c, double set, double torque, double dt)
{
    const double turn = 6.283185307179586 * (double)c->law.hz, e = set - c->speed;

    c->sum += e * dt;
    c->speed += dt * ((4.0 * (double)c->law.impedance * e - torque) / (double)c->law.inertia + turn * turn * c->sum);
    return c->speed;
}

typedef struct {
    bench_session s;
    kelly_plant plant;           /* this program's */
    bench_profile profile;
    controller drive;
    outfile out;
    uint32_t frames, tick;
    uint64_t values, bits;       /* compared, differing */
    double *trips;               /* [s] of each frame */
    double seconds;
} lockstep;

static kelly_msg_lock_step command_of(lockstep *l, const kelly_sight *now, uint32_t ticks)
{
    const kelly_case *const run = &l->s.run;
    double rpm, wob, speed;

    profile_at(&l->profile, case_seconds(run, l->tick + ticks), &rpm, &wob);
    speed = rpm * RPM;
    if (l->drive.law.inertia > 0) {
        speed = control(&l->drive, speed, (double)now->surface_torque, case_seconds(run, ticks));
    }
    return (kelly_msg_lock_step){ l->s.id, l->frames + 1, ticks, (real)speed, (real)(wob * 1000.0) };
}

static unsigned differing(real a, real b)
{
    uint64_t x = 0, y = 0;

    memcpy(&x, &a, sizeof(a));
    memcpy(&y, &b, sizeof(b));
    return (unsigned)__builtin_popcountll(x ^ y);
}

/* Equal bits, or the end: frame, field, both values. */
static void compare(lockstep *l, const kelly_msg_lock_answer *there, const kelly_sight *here)
{
    const real own[FIELDS] = { here->bit_speed, here->bit_torque, here->f_bit, here->surface_torque, here->axial_speed, here->top_speed };
    const real its[FIELDS] = { there->bit_speed, there->bit_torque, there->f_bit, there->surface_torque, there->axial_speed, there->top_speed };

    if (there->tick != l->tick) {
        die(EXIT_FAILED, "%s: frame %u: the board is at step %u and this program at %u", l->s.b->port.text, there->frame, there->tick, l->tick);
    }
    for (unsigned k = 0; k < FIELDS; k++) {
        const unsigned bits = differing(own[k], its[k]);

        l->values++;
        l->bits += bits;
        if (bits > 0) {
            die(EXIT_FAILED, "%s: frame %u, %g s: %s differs by %u bits: %.17g on the board, %.17g here", l->s.b->port.text, there->frame,
                case_seconds(&l->s.run, l->tick), field_names[k], bits, (double)its[k], (double)own[k]);
        }
    }
}

/* One frame: command, both strings, comparison. `now` is what was seen before it, and then after it. */
static void step(lockstep *l, kelly_sight *now, uint32_t ticks)
{
    const kelly_msg_lock_step ask = command_of(l, now, ticks);
    const double sent = port_now();
    uint8_t body[KELLY_LOCK_STEP_MAX];
    kelly_msg_lock_answer answer;

    if (!kelly_plant_allows(&l->plant, ask.top_speed, ask.weight)) {
        die(EXIT_USAGE, "%s, %g s: %.6g rpm at %.6g kN: more than a step of %.12g s can be trusted with; give less weight, or a shorter --step",
            l->s.ask->profile ? l->s.ask->profile : "the exercise", case_seconds(&l->s.run, l->tick), (double)ask.top_speed / RPM,
            (double)ask.weight / 1000.0, case_seconds(&l->s.run, 1));
    }
    session_call(&l->s, KELLY_MSG_LOCK_STEP, body, kelly_put_lock_step(body, &ask), KELLY_MSG_LOCK_ANSWER);
    if (!kelly_get_lock_answer(l->s.reply, l->s.reply_size, &answer) || answer.session != ask.session || answer.frame != ask.frame) {
        die(EXIT_FAILED, "%s: frame %u: the answer is none to it", l->s.b->port.text, ask.frame);
    }
    l->trips[l->frames++] = port_now() - sent;
    l->tick += ticks;
    kelly_plant_command(&l->plant, ask.top_speed, ask.weight, ticks);
    kelly_plant_advance(&l->plant, ticks);
    if (!answer.sane || !kelly_plant_sane(&l->plant)) {
        die(EXIT_FAILED, "%s: frame %u: the state left all bounds%s", l->s.b->port.text, ask.frame, answer.sane ? " here" : " on the board");
    }
    kelly_plant_look(&l->plant, now);
    compare(l, &answer, now);
    if (l->out.stream) {
        sight_line(l->out.stream, case_seconds(&l->s.run, l->tick), now);
    }
}

static int by_size(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;

    return (x > y) - (x < y);
}

static void write_json(const lockstep *l)
{
    outfile file;

    outfile_open(&file, l->s.ask->opts.json);
    fprintf(file.stream, "{\n  \"mode\": \"lockstep\",\n  \"frames\": %u,\n  \"frame_ticks\": %u,\n  \"steps\": %u,\n  \"values\": %llu,\n  \"differing_bits\": %llu,\n"
            "  \"round_trip_ms\": {\"median\": %.4f, \"p95\": %.4f, \"max\": %.4f},\n  \"frames_per_s\": %.1f,\n  \"seconds\": %.3f,\n  \"board\": {", l->frames,
            l->s.ask->frame_ticks, l->tick, (unsigned long long)l->values, (unsigned long long)l->bits, 1e3 * l->trips[l->frames / 2],
            1e3 * l->trips[l->frames - 1 - l->frames / 20], 1e3 * l->trips[l->frames - 1], l->frames / l->seconds, l->seconds);
    bench_write_board(file.stream, l->s.b);
    fputs("}\n}\n", file.stream);
    outfile_close(&file);
}

static void report(lockstep *l)
{
    qsort(l->trips, l->frames, sizeof(*l->trips), by_size);
    if (l->s.ask->opts.json) {
        write_json(l);
    }
    if (bench_speaks(&l->s.ask->opts)) {
        printf("%s, %s: %u frames of %u steps, %.6g s: %llu differing bits in %llu values\n", l->s.b->port.text, l->s.b->is.board, l->frames,
               l->s.ask->frame_ticks, case_seconds(&l->s.run, l->tick), (unsigned long long)l->bits, (unsigned long long)l->values);
        printf("round trip %.3f ms median, %.3f ms 95 %%, %.3f ms worst; %.0f frames/s; %u requests repeated\n", 1e3 * l->trips[l->frames / 2],
               1e3 * l->trips[l->frames - 1 - l->frames / 20], 1e3 * l->trips[l->frames - 1], l->frames / l->seconds, l->s.b->retries);
    }
}

/* Both strings at time 0. */
static void start(lockstep *l, kelly_sight *now)
{
    const options *const opts = &l->s.ask->opts;
    kelly_msg_plant_start ask = { .mode = KELLY_MODE_LOCKSTEP, .top_speed = l->s.draw.w0 };
    const kelly_status status = kelly_plant_start_commanded(&l->plant, &kelly_string, &l->s.run, &l->s.draw, ask.top_speed);

    if (status != KELLY_OK) {
        plant_refuse(&l->plant, opts, &l->s.draw, status);
    }
    session_start(&l->s, &ask);
    kelly_plant_look(&l->plant, now);
    l->drive = (controller){ .law = opts->run.drive, .speed = (double)ask.top_speed };
    if (opts->out) {
        outfile_open(&l->out, opts->out);
        fputs(SIGHT_HEADER, l->out.stream);
        sight_line(l->out.stream, 0, now);
    }
}

int bench_lockstep(const bench_request *ask, board *b)
{
    static lockstep l;
    const uint32_t ticks = ask->opts.run.ticks;
    kelly_sight now;
    double begin;

    profile_open(&l.profile, ask, 1);
    l.trips = calloc(ticks / ask->frame_ticks + 1, sizeof(*l.trips));
    if (!l.trips) {
        die(EXIT_FAILED, "out of memory; give a longer --frame-ticks");
    }
    session_open(&l.s, ask, b);
    start(&l, &now);
    begin = port_now();
    while (l.tick < ticks) {
        step(&l, &now, ticks - l.tick < ask->frame_ticks ? ticks - l.tick : ask->frame_ticks);
    }
    l.seconds = port_now() - begin;
    session_close(&l.s);
    if (l.out.stream) {
        outfile_close(&l.out);
    }
    report(&l);
    free(l.trips);
    return EXIT_DONE;
}
