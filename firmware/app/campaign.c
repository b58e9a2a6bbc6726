#include "../board/board.h"
#include "../link/keys.h"
#include "bench.h"
#include "out.h"

#define CHUNK_MAX 64u            /* some 0.3 ms on an FPU: the line holds 256 bytes for 20 ms */

void campaign_run(kelly_bench *bench, uint32_t seq, const kelly_msg_run *ask)
{
    kelly_campaign *const c = &bench->now.campaign;

    if (!bench->case_set || ask->case_crc != bench->case_crc) {
        bench_error(seq, KELLY_ERR_NO_CASE, KELLY_MSG_RUN, "set the case first");
        return;
    }
    if (ask->count == 0 || ask->first > UINT32_MAX - ask->count) {
        bench_error(seq, KELLY_ERR_VALUE, KELLY_MSG_RUN, "give count > 0 and first + count <= 4294967295");
        return;
    }
    bench_idle(bench);
    bench_hold(bench, KELLY_STATE_CAMPAIGN);
    bench->state = KELLY_STATE_CAMPAIGN;
    c->seed = ask->seed;
    c->job = kelly_job_key(ask->case_crc, ask->seed);
    c->next = ask->first;
    c->left = ask->count;
    if (c->chunk == 0) {
        c->chunk = 1;
    }
    gauge_job(&bench->gauge, c->job);
}

static void send_result(const kelly_kept *of)
{
    const kelly_result *const r = &of->result;
    const kelly_msg_result message = {
        .job = of->job, .index = of->index, .draw_crc = kelly_draw_key(&r->draw),
        .lowest = r->lowest, .highest = r->highest, .mean = r->mean, .ss = r->ss,
        .status = r->status, .stuck = r->stuck, .liftoff = r->liftoff,
    };
    uint8_t wire[KELLY_WIRE_MAX];

    out_frame(wire, KELLY_MSG_RESULT, 0, kelly_put_result(wire + KELLY_WIRE_BODY, &message));
}

static const kelly_kept *find(const kelly_campaign *c)
{
    for (unsigned k = 0; k < CAMPAIGN_KEPT; k++) {
        if (c->kept[k].filled && c->kept[k].job == c->job && c->kept[k].index == c->next) {
            return &c->kept[k];
        }
    }
    return 0;
}

static void sent(kelly_bench *bench)
{
    kelly_campaign *const c = &bench->now.campaign;

    c->next++;
    c->left--;
    if (c->left == 0) {
        bench->state = KELLY_STATE_IDLE;
    }
}

static void finish(kelly_bench *bench)
{
    kelly_campaign *const c = &bench->now.campaign;

    if (c->at.result.status == KELLY_OK) {
        kelly_run_finish(&kelly_string, &bench->run, 1, &c->at.result, &c->work);
    }
    c->kept[c->kept_next++ % CAMPAIGN_KEPT] = c->at;
    c->at.filled = 0;
    gauge_count(&bench->gauge, c->at.index, &c->at.result);
    send_result(&c->at);
    sent(bench);
}

/* Steps until the tick changes: twice as many between two looks as long as it does not, half as many when it did. */
static uint32_t advance(kelly_bench *bench)
{
    kelly_campaign *const c = &bench->now.campaign;
    const uint32_t start = board_ticks();
    uint32_t left;

    do {
        left = kelly_run_advance(&kelly_string, &bench->run, 1, &c->at.result, &c->work, c->chunk);
        if (board_ticks() == start && c->chunk < CHUNK_MAX) {
            c->chunk *= 2u;
        }
    } while (left > 0 && board_ticks() == start);
    if (c->chunk > 1) {
        c->chunk /= 2u;
    }
    return left;
}

void campaign_slice(kelly_bench *bench)
{
    kelly_campaign *const c = &bench->now.campaign;
    const kelly_kept *const known = find(c);

    if (known != 0) {
        send_result(known);
        sent(bench);
        return;
    }
    if (!c->at.filled || c->at.job != c->job || c->at.index != c->next) {
        c->at.filled = 1;
        c->at.job = c->job;
        c->at.index = c->next;
        kelly_run_begin(&kelly_string, &bench->run, c->seed, c->next, 1, &c->at.result, &c->work);
    }
    if (c->at.result.status != KELLY_OK || advance(bench) == 0) {
        finish(bench);
    }
}
