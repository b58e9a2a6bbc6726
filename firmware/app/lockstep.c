#include "../board/board.h"
#include "bench.h"
#include "out.h"

#define CHUNK 8u                 /* steps between two looks at the clock */

static void answer(const kelly_lockstep *lock, uint32_t seq)
{
    uint8_t wire[KELLY_WIRE_MAX];

    out_frame(wire, KELLY_MSG_LOCK_ANSWER, seq, kelly_put_lock_answer(wire + KELLY_WIRE_BODY, &lock->answer));
}

void lockstep_step(kelly_bench *bench, uint32_t seq, const kelly_msg_lock_step *ask)
{
    kelly_session *const s = session_of(bench, ask->session, KELLY_STATE_LOCKSTEP, seq, KELLY_MSG_LOCK_STEP);
    kelly_lockstep *const lock = &bench->now.session.by.lock;

    if (s == 0) {
        return;
    }
    if (bench->state != KELLY_STATE_LOCKSTEP) {
        bench_error(seq, KELLY_ERR_ORDER, KELLY_MSG_LOCK_STEP, "the session is over");
    } else if (ask->frame == lock->frame && ask->frame != 0) {
        lock->seq = seq;
        if (lock->left == 0) {
            answer(lock, seq);
        }
    } else if (ask->frame != lock->frame + 1u || lock->left != 0) {
        bench_error(seq, KELLY_ERR_ORDER, KELLY_MSG_LOCK_STEP, "not the next frame");
    } else if (ask->ticks == 0 || !kelly_plant_allows(&s->plant, ask->top_speed, ask->weight)) {
        bench_error(seq, KELLY_ERR_VALUE, KELLY_MSG_LOCK_STEP, "give ticks > 0, and a speed and a weight that the step can be trusted with");
    } else {
        lock->frame = ask->frame;
        lock->seq = seq;
        lock->left = ask->ticks;
        kelly_plant_command(&s->plant, ask->top_speed, ask->weight, ask->ticks);
        lock->answer = (kelly_msg_lock_answer){ .session = ask->session, .frame = ask->frame, .tick = lock->answer.tick };
    }
}

static void finish(kelly_bench *bench)
{
    kelly_session *const s = &bench->now.session;
    kelly_lockstep *const lock = &s->by.lock;
    kelly_sight sight;

    lock->answer.sane = (uint8_t)(kelly_plant_sane(&s->plant) != 0);
    if (lock->answer.sane) {
        kelly_plant_look(&s->plant, &sight);
        lock->answer.bit_speed = sight.bit_speed;
        lock->answer.bit_torque = sight.bit_torque;
        lock->answer.f_bit = sight.f_bit;
        lock->answer.surface_torque = sight.surface_torque;
        lock->answer.axial_speed = sight.axial_speed;
        lock->answer.top_speed = sight.top_speed;
        gauge_look(&bench->gauge, &sight, lock->answer.tick, bench->run.step_ns);
    }
    answer(lock, lock->seq);
}

int lockstep_slice(kelly_bench *bench)
{
    kelly_session *const s = &bench->now.session;
    kelly_lockstep *const lock = &s->by.lock;
    const uint32_t start = board_ticks();

    if (lock->left == 0) {
        return 0;
    }
    do {
        const uint32_t part = lock->left < CHUNK ? lock->left : CHUNK;

        kelly_plant_advance(&s->plant, part);
        lock->left -= part;
        lock->answer.tick += part;
    } while (lock->left > 0 && board_ticks() == start);
    if (lock->left == 0) {
        finish(bench);
    }
    return 1;
}
