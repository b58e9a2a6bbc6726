#include "../board/board.h"
#include "bench.h"
#include "out.h"

#define LOOK_STEPS 10u           /* the gauge is read every so many */
#define SAMPLE_ROOM 128u         /* more than a sample needs on the wire */
#define SECOND 1000u             /* [ticks] */
#define CALIBRATION 4u           /* [ticks] */

/* Counts of one tick, awake: a core that sleeps may not count. */
static uint32_t counts_of_a_tick(void)
{
    uint32_t tick = board_ticks(), from;

    while (board_ticks() == tick) {
    }
    from = board_count();
    tick = board_ticks();
    while (board_ticks() - tick < CALIBRATION) {
    }
    return (board_count() - from) / CALIBRATION;
}

void realtime_begin(kelly_bench *bench, const kelly_msg_plant_start *ask, real weight)
{
    kelly_realtime *const rt = &bench->now.session.by.real_time;
    const uint32_t period = bench->run.step_ns / REALTIME_TICK_NS;

    *rt = (kelly_realtime){ .duration = ask->duration, .stream_ticks = ask->stream_ticks, .command_ms = ask->command_ms, .policy = ask->policy,
                      .ramp_ticks = ask->ramp_ms > period ? ask->ramp_ms / period : 1u,
                      .overload_steps = ask->overload_steps, .overload_us = ask->overload_us,
                      .period = period, .weight = weight, .state = KELLY_RT_RUNNING, .tick_counts = counts_of_a_tick() };
    out_defer(1);
    watchdog_start(REALTIME_WATCHDOG_MS + period);
    rt->start = board_ticks();
    rt->heard = rt->start;
}

/* ---- the books ---- */

static uint32_t permille(uint64_t part, uint64_t whole)
{
    return whole == 0 ? 0 : (uint32_t)(part * 1000u / whole);
}

void realtime_busy(kelly_bench *bench, uint32_t counts)
{
    if (bench->holds == KELLY_STATE_REALTIME) {
        bench->now.session.by.real_time.busy += counts;
    }
}

uint32_t realtime_load(const kelly_realtime *rt)
{
    return permille(rt->busy, (uint64_t)rt->tick_counts * rt->period * rt->steps);
}

uint32_t realtime_worst_load(const kelly_realtime *rt)
{
    return permille(rt->busy_worst, (uint64_t)rt->tick_counts * rt->period);
}

static void report(const kelly_bench *bench, uint32_t seq)
{
    const kelly_realtime *const rt = &bench->now.session.by.real_time;
    const kelly_msg_rt_report message = {
        .session = bench->now.session.id, .tick = rt->steps, .late = rt->late, .worst_late_us = rt->worst_late_us,
        .load_permille = realtime_load(rt), .load_worst_permille = realtime_worst_load(rt), .commands = rt->commands,
        .timeouts = rt->timeouts, .samples = rt->samples, .unsane = rt->unsane, .state = rt->state,
    };
    uint8_t wire[KELLY_WIRE_MAX];

    out_frame(wire, KELLY_MSG_RT_REPORT, seq, kelly_put_rt_report(wire + KELLY_WIRE_BODY, &message));
}

/* The session is over; its books stay to be asked for. */
static void end(kelly_bench *bench)
{
    bench_idle(bench);
    report(bench, 0);
}

/* ---- requests ---- */

void realtime_query(kelly_bench *bench, uint32_t seq, const kelly_msg_rt_query *ask)
{
    if (session_of(bench, ask->session, KELLY_STATE_REALTIME, seq, KELLY_MSG_RT_QUERY) != 0) {
        report(bench, seq);
    }
}

void realtime_set(kelly_bench *bench, real top_speed, real weight, uint32_t ticks)
{
    kelly_session *const s = &bench->now.session;

    kelly_plant_command(&s->plant, top_speed, weight, ticks);
    s->by.real_time.weight = weight;
    s->by.real_time.commands++;
    s->by.real_time.state = KELLY_RT_RUNNING;
}

void realtime_command(kelly_bench *bench, uint32_t seq, const kelly_msg_rt_command *ask)
{
    kelly_session *const s = session_of(bench, ask->session, KELLY_STATE_REALTIME, seq, KELLY_MSG_RT_COMMAND);
    const kelly_msg_rt_ack message = { .session = ask->session, .number = ask->number };
    uint8_t wire[KELLY_WIRE_MAX];

    if (s == 0) {
        return;
    }
    if (bench->state != KELLY_STATE_REALTIME) {
        bench_error(seq, KELLY_ERR_ORDER, KELLY_MSG_RT_COMMAND, "the session is over");
        return;
    }
    if (ask->number > s->by.real_time.number) {
        if (ask->ramp_ticks == 0 || !kelly_plant_allows(&s->plant, ask->top_speed, ask->weight)) {
            bench_error(seq, KELLY_ERR_VALUE, KELLY_MSG_RT_COMMAND,
                        "give ramp_ticks > 0, and a speed and a weight that the step can be trusted with");
            return;
        }
        realtime_set(bench, ask->top_speed, ask->weight, ask->ramp_ticks);
        s->by.real_time.number = ask->number;
    }
    s->by.real_time.heard = board_ticks();
    out_frame(wire, KELLY_MSG_RT_ACK, seq, kelly_put_rt_ack(wire + KELLY_WIRE_BODY, &message));
}

/* ---- one step ---- */

/* Its buffers are not on the stack of the step. */
static __attribute__((noinline)) void sample(kelly_bench *bench, const kelly_sight *sight)
{
    kelly_realtime *const rt = &bench->now.session.by.real_time;
    const kelly_msg_rt_sample message = {
        .session = bench->now.session.id, .tick = rt->steps, .bit_speed = sight->bit_speed, .bit_torque = sight->bit_torque,
        .f_bit = sight->f_bit, .surface_torque = sight->surface_torque, .axial_speed = sight->axial_speed, .top_speed = sight->top_speed,
        .late = rt->late, .worst_late_us = rt->worst_late_us, .load_permille = rt->load_permille, .state = rt->state,
    };
    if (out_room(SAMPLE_ROOM)) {   /* a line that is too slow gets fewer */
        uint8_t wire[KELLY_WIRE_MAX];

        out_frame(wire, KELLY_MSG_RT_SAMPLE, 0, kelly_put_rt_sample(wire + KELLY_WIRE_BODY, &message));
        rt->samples++;
    }
}

static void look(kelly_bench *bench)
{
    const kelly_realtime *const rt = &bench->now.session.by.real_time;
    const int stream = rt->stream_ticks != 0 && rt->steps % rt->stream_ticks == 0;
    kelly_sight sight;

    if (stream || rt->steps % LOOK_STEPS == 0) {
        kelly_plant_look(&bench->now.session.plant, &sight);
        gauge_look(&bench->gauge, &sight, rt->steps, bench->run.step_ns);
        if (stream) {
            sample(bench, &sight);
        }
    }
}

/* A silent host: what its policy says, once. Returns 1 where the string is to stop. */
static int watch_host(kelly_bench *bench)
{
    kelly_realtime *const rt = &bench->now.session.by.real_time;

    if (rt->command_ms == 0 || rt->state != KELLY_RT_RUNNING || board_ticks() - rt->heard < rt->command_ms) {
        return 0;
    }
    rt->timeouts++;
    rt->state = (uint8_t)(rt->policy + KELLY_RT_HOLD);
    if (rt->policy == KELLY_POLICY_RAMP) {
        kelly_plant_command(&bench->now.session.plant, 0, rt->weight, rt->ramp_ticks);
    }
    return rt->state == KELLY_RT_STOPPED;
}

/* Before the step that is due at `due`: is it late, and by how much? */
static void note_start(kelly_realtime *rt, uint32_t due)
{
    const uint32_t micros = board_micros() - due * 1000u;

    if (rt->overran || board_ticks() - due >= rt->period) {
        rt->late++;
    }
    if (micros > rt->worst_late_us) {
        rt->worst_late_us = micros;
    }
}

/* The test of the above: one step a second is not over before overload_us after its tick. */
static void overload(const kelly_realtime *rt, uint32_t due)
{
    const uint32_t each = SECOND / rt->period;

    if (rt->steps % each == 0 && rt->steps / each <= rt->overload_steps) {
        while (board_micros() - due * 1000u < rt->overload_us) {
        }
    }
}

/* Every whole second. */
static void note_load(kelly_realtime *rt)
{
    if (rt->steps * rt->period % SECOND < rt->period) {
        rt->load_permille = (uint16_t)permille(rt->busy - rt->busy_second, (uint64_t)rt->tick_counts * SECOND);
        rt->busy_second = rt->busy;
    }
}

/* One step; 0 where its state is out of bounds. */
static int step(kelly_bench *bench, uint32_t due)
{
    kelly_realtime *const rt = &bench->now.session.by.real_time;
    const uint32_t from = board_count();
    uint32_t counts;

    note_start(rt, due);
    kelly_plant_advance(&bench->now.session.plant, 1);
    rt->steps++;
    if (!kelly_plant_sane(&bench->now.session.plant)) {
        rt->unsane++;
        return 0;
    }
    watchdog_kick();
    note_load(rt);
    look(bench);
    overload(rt, due);
    counts = board_count() - from;
    if (counts > rt->busy_worst) {
        rt->busy_worst = counts;
    }
    rt->overran = (uint8_t)(board_ticks() - due >= rt->period);
    return 1;
}

int realtime_slice(kelly_bench *bench)
{
    kelly_realtime *const rt = &bench->now.session.by.real_time;
    const uint32_t due = rt->start + (rt->steps + 1u) * rt->period;

    if ((int32_t)(board_ticks() - due) < 0) {
        return 0;
    }
    if (watch_host(bench) || !step(bench, due)) {
        rt->state = KELLY_RT_STOPPED;
        end(bench);
    } else if (rt->steps == rt->duration) {
        end(bench);
    }
    return 1;
}
