#include "bench.h"
#include "../board/board.h"
#include "out.h"
#include "requests.h"

#define STATUS_MS 100u           /* while idle or in a campaign */
#define DROPPED_MS 10u           /* not more often because of frames that were dropped */

void bench_start(kelly_bench *bench)
{
    bench->run = kelly_string.nominal;
    bench->state = KELLY_STATE_IDLE;
    bench->holds = KELLY_STATE_IDLE;
}

void bench_idle(kelly_bench *bench)
{
    if (bench->state == KELLY_STATE_REALTIME) {
        watchdog_stop();
        out_defer(0);
    }
    bench->state = KELLY_STATE_IDLE;
}

void bench_hold(kelly_bench *bench, uint8_t state)
{
    unsigned char *const memory = (unsigned char *)&bench->now;

    if (bench->holds == state) {
        return;
    }
    for (size_t k = 0; k < sizeof(bench->now); k++) {
        memory[k] = 0;
    }
    bench->holds = state;
}

__attribute__((noinline)) void bench_error(uint32_t seq, uint8_t code, uint8_t of_type, const char *text)
{
    kelly_msg_error message = { .code = code, .of_type = of_type };
    uint8_t wire[KELLY_WIRE_MAX];

    kelly_set_text(message.text, sizeof(message.text), text);
    out_frame(wire, KELLY_MSG_ERROR, seq, kelly_put_error(wire + KELLY_WIRE_BODY, &message));
}

void bench_status(kelly_bench *bench, uint32_t seq)
{
    const kelly_campaign *const c = &bench->now.campaign;
    kelly_msg_status message = { .state = bench->state, .good = bench->receiver.good, .bad = bench->receiver.bad };
    uint8_t wire[KELLY_WIRE_MAX];

    if (bench->holds == KELLY_STATE_CAMPAIGN) {
        message.next = c->next;
        message.end = c->next + c->left;
    }
    bench->status_tick = board_ticks();
    out_frame(wire, KELLY_MSG_STATUS, seq, kelly_put_status(wire + KELLY_WIRE_BODY, &message));
}

/* ---- bytes ---- */

static int is_text(uint8_t byte)
{
    return (byte >= ' ' && byte <= '~') || byte == '\r' || byte == '\n';
}

/* A line has ended. */
static int take_line(kelly_bench *bench)
{
    const int whole = !bench->dirty, empty = bench->length == 0;
    int sets = empty;

    bench->line[bench->length] = '\0';
    for (unsigned k = 0; k < bench->length; k++) {
        sets |= bench->line[k] == '=';
    }
    bench->length = 0;
    bench->dirty = 0;
    if (!whole) {
        return BENCH_GOES_ON;
    }
    if (!bench->decided && sets) {
        return BENCH_ESTIMATE;
    }
    bench->decided = 1;
    if (!empty) {
        console_line(bench, bench->line);
    }
    return BENCH_GOES_ON;
}

static int collect(kelly_bench *bench, uint8_t byte)
{
    if (byte == '\r' || byte == '\n') {
        return take_line(bench);
    }
    if (byte == 0) {             /* the edge of a frame */
        bench->length = 0;
        bench->dirty = 0;
    } else if (!is_text(byte)) {
        bench->dirty = 1;
    } else if (bench->length < LINE_MAX - 1) {
        bench->line[bench->length++] = (char)byte;
    } else {
        bench->line[LINE_MAX - 2] = '~';     /* cut: no command or number has this byte, so that the rest is not obeyed */
    }
    return BENCH_GOES_ON;
}

int bench_take(kelly_bench *bench, uint8_t byte)
{
    const int got = kelly_receive(&bench->receiver, byte);

    if (!is_text(byte)) {
        bench->decided = 1;
    }
    if (got > 0) {
        request(bench);
    } else if (got < 0 && bench->greeted && board_ticks() - bench->status_tick >= DROPPED_MS) {
        bench_status(bench, 0);
    }
    return collect(bench, byte);
}

/* ---- the loop ---- */

/* A slice of the present work; 0 where there is none. */
static int work(kelly_bench *bench)
{
    switch (bench->state) {
    case KELLY_STATE_CAMPAIGN:
        campaign_slice(bench);
        return 1;
    case KELLY_STATE_LOCKSTEP:
        return lockstep_slice(bench);
    case KELLY_STATE_REALTIME:
        return realtime_slice(bench);
    default:
        return 0;
    }
}

static void sign_of_life(kelly_bench *bench)
{
    if (bench->greeted && bench->state <= KELLY_STATE_CAMPAIGN && board_ticks() - bench->status_tick >= STATUS_MS) {
        bench_status(bench, 0);
    }
}

/* The estimation is none of the bench's work any more: lines are for the console. In real time a pass takes few bytes, so
 * that a step is not kept waiting. */
static int take_bytes(kelly_bench *bench)
{
    int taken = 0;

    for (int byte; taken < BENCH_BYTES && (byte = board_read()) >= 0; taken++) {
        (void)bench_take(bench, (uint8_t)byte);
    }
    return taken > 0;
}

_Noreturn void bench_loop(kelly_bench *bench)
{
    for (;;) {
        const uint32_t from = board_count();
        int busy;

        busy = take_bytes(bench);
        busy |= work(bench);
        sign_of_life(bench);
        console_tick(bench);
        if (busy) {
            realtime_busy(bench, board_count() - from);
        }
        if (!out_pump() && !busy) {
            board_idle();
        }
    }
}
