#include "bench.h"
#include "out.h"

kelly_session *session_of(kelly_bench *bench, uint32_t id, uint8_t state, uint32_t seq, uint8_t type)
{
    kelly_session *const s = &bench->now.session;

    if (bench->holds != KELLY_STATE_LOCKSTEP && bench->holds != KELLY_STATE_REALTIME) {
        bench_error(seq, KELLY_ERR_ORDER, type, "no such session");
        return 0;
    }
    if (s->id != id || s->status != KELLY_OK) {
        bench_error(seq, KELLY_ERR_ORDER, type, "no such session");
        return 0;
    }
    if (bench->holds != state) {
        bench_error(seq, KELLY_ERR_MODE, type, "not in this mode");
        return 0;
    }
    return s;
}

static void reply(uint32_t seq, uint8_t status)
{
    const kelly_msg_plant_reply message = { .session = seq, .status = status, .reason = status == KELLY_OK ? 0 : KELLY_ERR_REFUSED };
    uint8_t wire[KELLY_WIRE_MAX];

    out_frame(wire, KELLY_MSG_PLANT_REPLY, seq, kelly_put_plant_reply(wire + KELLY_WIRE_BODY, &message));
}

kelly_status session_begin(kelly_bench *bench, uint32_t id, const kelly_msg_plant_start *ask)
{
    kelly_session *const s = &bench->now.session;
    kelly_draw draw;

    bench_idle(bench);
    bench_hold(bench, KELLY_STATE_IDLE);
    bench_hold(bench, ask->mode);
    gauge_clear(&bench->gauge);
    if (ask->source == KELLY_SOURCE_NOMINAL) {
        kelly_draw_nominal(&bench->run, &draw);
    } else {
        kelly_draw_sample(&bench->run, ask->seed, ask->index, &draw);
    }
    s->id = id;
    s->status = (uint8_t)kelly_plant_start_commanded(&s->plant, &kelly_string, &bench->run, &draw, ask->top_speed);
    if (s->status == KELLY_OK) {
        bench->state = ask->mode;
        if (ask->mode == KELLY_MODE_REALTIME) {
            realtime_begin(bench, ask, draw.fc);
        }
    }
    return (kelly_status)s->status;
}

void session_start(kelly_bench *bench, uint32_t seq, const kelly_msg_plant_start *ask)
{
    const kelly_session *const s = &bench->now.session;
    const int mine = bench->holds == KELLY_STATE_LOCKSTEP || bench->holds == KELLY_STATE_REALTIME;

    if (mine && s->known && s->id == seq) {
        reply(seq, s->status);
        return;
    }
    if (!bench->case_set || ask->case_crc != bench->case_crc) {
        bench_error(seq, KELLY_ERR_NO_CASE, KELLY_MSG_PLANT_START, "set the case first");
        return;
    }
    if (ask->mode == KELLY_MODE_REALTIME && (bench->run.step_ns < REALTIME_TICK_NS || bench->run.step_ns % REALTIME_TICK_NS != 0)) {
        bench_error(seq, KELLY_ERR_VALUE, KELLY_MSG_PLANT_START, "in real time the step is whole milliseconds");
        return;
    }
    (void)session_begin(bench, seq, ask);
    bench->now.session.known = 1;
    reply(seq, s->status);
}
