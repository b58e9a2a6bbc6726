#include "requests.h"
#include "../board/board.h"
#include "../kelly.h"
#include "../link/crc32c.h"
#include "bench.h"
#include "out.h"

static uint32_t image_crc(uint32_t *size)
{
    static uint32_t crc, bytes;  /* computed once: some 0.1 s on the slowest part */

    if (bytes == 0) {
        const uint8_t *const image = board_image(&bytes);

        board_vectors(1);
        crc = kelly_crc32c(0, image, bytes);
        board_vectors(0);
    }
    *size = bytes;
    return crc;
}

/* Each answer has buffers of its own: not on the stack of the others. */
#define APART __attribute__((noinline))

static APART void hello(kelly_bench *bench, uint32_t seq, const kelly_msg_hello *ask)
{
    kelly_msg_hello_reply message = { .schema = KELLY_LINK_SCHEMA, .nonce = ask->nonce, .real_bytes = sizeof(real),
                                      .watchdog = (uint8_t)board_watchdog(), .frame_max = KELLY_FRAME_MAX, .tick_hz = 1000 };
    uint8_t wire[KELLY_WIRE_MAX];

    bench_idle(bench);
    bench->greeted = ask->schema == KELLY_LINK_SCHEMA;
    bench->status_tick = board_ticks();
    if (bench->holds >= KELLY_STATE_LOCKSTEP) {
        bench->now.session.known = 0;   /* this host may count its requests anew */
    }
    message.image_crc = image_crc(&message.image_size);
    kelly_set_text(message.board, sizeof(message.board), BOARD_NAME);
    kelly_set_text(message.version, sizeof(message.version), KELLY_VERSION);
    kelly_set_text(message.model, sizeof(message.model), kelly_string.id);
    out_frame(wire, KELLY_MSG_HELLO_REPLY, seq, kelly_put_hello_reply(wire + KELLY_WIRE_BODY, &message));
}

static kelly_case case_of(const kelly_msg_case_set *ask)
{
    return (kelly_case){
        .fc = ask->fc, .mu = ask->mu, .a1 = ask->a1, .a2 = ask->a2, .w0 = ask->w0, .f0 = ask->f0,
        .cov = { ask->cov0, ask->cov1, ask->cov2, ask->cov3, ask->cov4 }, .limit = ask->limit,
        .step_ns = ask->step_ns, .ticks = ask->ticks, .window_first = ask->window_first, .window_last = ask->window_last,
        .torsional = ask->torsional, .axial = ask->axial, .rotating = ask->rotating,
        .drive = { .inertia = ask->drive_inertia, .impedance = ask->drive_impedance, .hz = ask->drive_hz },
    };
}

/* Another case ends what runs with the old one; a plant is not ended by it, only by name. */
static APART void case_set(kelly_bench *bench, uint32_t seq, const kelly_msg_case_set *ask, uint32_t crc)
{
    const kelly_msg_case_reply message = { .case_crc = crc };
    const kelly_case run = case_of(ask);
    const char *const why = kelly_case_error(&kelly_string, &run);
    uint8_t wire[KELLY_WIRE_MAX];

    if (why != 0) {
        bench_error(seq, KELLY_ERR_REFUSED, KELLY_MSG_CASE_SET, why);
        return;
    }
    if (!bench->case_set || bench->case_crc != crc) {
        if (bench->state > KELLY_STATE_CAMPAIGN) {
            bench_error(seq, KELLY_ERR_MODE, KELLY_MSG_CASE_SET, "a string is running: stop it first");
            return;
        }
        bench_idle(bench);
        bench->run = run;
        bench->case_crc = crc;
        bench->case_set = 1;
    }
    out_frame(wire, KELLY_MSG_CASE_REPLY, seq, kelly_put_case_reply(wire + KELLY_WIRE_BODY, &message));
}

static APART void wits_query(const kelly_bench *bench, uint32_t seq)
{
    kelly_msg_wits message;
    uint8_t wire[KELLY_WIRE_MAX];

    gauge_wits(&bench->gauge, message.text, sizeof(message.text));
    out_frame(wire, KELLY_MSG_WITS, seq, kelly_put_wits(wire + KELLY_WIRE_BODY, &message));
}

/* Requests about a campaign or a string; 0 where the body is wrong, -1 where the type is none. */
static int run_request(kelly_bench *bench, uint8_t type, uint32_t seq, const uint8_t *body, size_t size)
{
    union {
        kelly_msg_run run;
        kelly_msg_plant_start start;
        kelly_msg_lock_step step;
        kelly_msg_rt_command command;
        kelly_msg_rt_query query;
    } ask;

#define TAKE(name, field, handler) \
    if (!kelly_get_##name(body, size, &ask.field)) { \
        return 0; \
    } \
    handler(bench, seq, &ask.field); \
    return 1
    switch (type) {
    case KELLY_MSG_RUN:
        TAKE(run, run, campaign_run);
    case KELLY_MSG_PLANT_START:
        TAKE(plant_start, start, session_start);
    case KELLY_MSG_LOCK_STEP:
        TAKE(lock_step, step, lockstep_step);
    case KELLY_MSG_RT_COMMAND:
        TAKE(rt_command, command, realtime_command);
    case KELLY_MSG_RT_QUERY:
        TAKE(rt_query, query, realtime_query);
    default:
        return -1;
    }
}

static int set_request(kelly_bench *bench, uint32_t seq, const uint8_t *body, size_t size)
{
    kelly_msg_case_set ask;

    if (!kelly_get_case_set(body, size, &ask)) {
        return 0;
    }
    case_set(bench, seq, &ask, kelly_crc32c(0, body, size));
    return 1;
}

/* All but hello. */
static int other_request(kelly_bench *bench, uint8_t type, uint32_t seq, const uint8_t *body, size_t size)
{
    switch (type) {
    case KELLY_MSG_CASE_SET:
        return set_request(bench, seq, body, size);
    case KELLY_MSG_STOP:
        if (size == 0) {
            bench_idle(bench);
            bench_status(bench, seq);
        }
        return size == 0;
    case KELLY_MSG_WITS_QUERY:
        if (size == 0) {
            wits_query(bench, seq);
        }
        return size == 0;
    default:
        return run_request(bench, type, seq, body, size);
    }
}

void request(kelly_bench *bench)
{
    const uint8_t type = kelly_received_type(&bench->receiver);
    const uint32_t seq = kelly_received_seq(&bench->receiver);
    size_t size;
    const uint8_t *const body = kelly_received_body(&bench->receiver, &size);
    kelly_msg_hello ask;
    int done;

    if (type == KELLY_MSG_HELLO && kelly_get_hello(body, size, &ask)) {
        hello(bench, seq, &ask);
        return;
    }
    if (type != KELLY_MSG_HELLO && !bench->greeted) {
        bench_error(seq, KELLY_ERR_SCHEMA, type, "say hello, of this board's schema, first");
        return;
    }
    done = type == KELLY_MSG_HELLO ? 0 : other_request(bench, type, seq, body, size);
    if (done < 0) {
        bench_error(seq, KELLY_ERR_TYPE, type, "no such request");
    } else if (done == 0) {
        bench_error(seq, KELLY_ERR_BODY, type, "the body does not fit");
    }
}
