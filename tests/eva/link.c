/* link/ for every byte that a line may bring, every receiver that bytes can have made, every body of a frame, every text. Messages: messages.c. */
#include "link/crc32c.h"
#include "link/frame.h"
#include "link/keys.h"
#include "link/messages.h"
#include "link/wits.h"
#include "contracts.h"

/* A receiver of any state that its header allows takes any byte, and is such a receiver again. */
static void bytes(void)
{
    kelly_receiver receiver;
    size_t size = 0;
    int got;

    receiver.good = any_u32();
    receiver.bad = any_u32();
    receiver.size = Frama_C_unsigned_short_interval(0, KELLY_FRAME_MAX);
    receiver.left = any_byte();
    receiver.code = any_byte();
    receiver.inside = any_byte();
    receiver.fresh = any_byte();
    ANY(receiver.payload);
    got = kelly_receive(&receiver, any_byte());
    //@ assert receiver.size <= KELLY_FRAME_MAX;
    //@ assert -1 <= got <= KELLY_FRAME_MAX - KELLY_FRAME_MIN + 1;
    if (got > 0) {
        (void)kelly_received_type(&receiver);
        (void)kelly_received_seq(&receiver);
        receiver.size = Frama_C_unsigned_short_interval(KELLY_FRAME_MIN, KELLY_FRAME_MAX);   /* what a complete frame has */
        (void)kelly_received_body(&receiver, &size);
        //@ assert size <= KELLY_FRAME_MAX - KELLY_FRAME_MIN;
    }
}

static void frames(void)
{
    static uint8_t wire[KELLY_WIRE_MAX], body[KELLY_FRAME_MAX];
    size_t n;

    ANY(wire);
    ANY(body);
    n = kelly_frame(wire, any_byte(), any_u32(), Frama_C_nondet_ptr(body, wire + KELLY_WIRE_BODY), Frama_C_size_t_interval(0, SIZE_MAX));
    //@ assert n <= KELLY_WIRE_MAX;
}

static void texts(void)
{
    static char text[KELLY_WITS_TEXT + 1], from[64], to[32];
    kelly_wits values;

    ANY(from);
    from[63] = '\0';
    //@ loop unroll 33;
    for (size_t room = 1; room <= sizeof(to); room++) {
        kelly_set_text(to, room, from);
    }
    values.known = any_u32();
    values.activity = any_u32();
    values.date = any_u32();
    values.time = any_u32();
    values.samples = any_u32();
    values.depth = any_real(-1e30f, 1e30f);
    values.wob_mean = any_real(-1e30f, 1e30f);
    values.wob_max = any_real(-1e30f, 1e30f);
    values.torque_mean = any_real(-1e30f, 1e30f);
    values.torque_max = any_real(-1e30f, 1e30f);
    values.bit_wob_mean = any_real(-1e30f, 1e30f);
    values.bit_wob_max = any_real(-1e30f, 1e30f);
    values.bit_torque_mean = any_real(-1e30f, 1e30f);
    values.bit_torque_max = any_real(-1e30f, 1e30f);
    values.ss = any_real(-1e30f, 1e30f);
    values.probability = any_real(-1e30f, 1e30f);
    values.top_speed = any_real(-1e6f, 1e6f);
    values.bit_lowest = any_real(-1e6f, 1e6f);
    values.bit_highest = any_real(-1e6f, 1e6f);
    values.bit_mean = any_real(-1e6f, 1e6f);
    (void)kelly_wits_frame(text, Frama_C_size_t_interval(0, sizeof(text)), &values);
}

static void keys(void)
{
    static kelly_msg_case_set set;
    kelly_draw draw;
    uint8_t some[64];

    ANY(some);
    (void)kelly_crc32c(any_u32(), some, Frama_C_size_t_interval(0, sizeof(some)));
    set.fc = any_real(-ANY_REAL, ANY_REAL);
    set.cov0 = Frama_C_float_interval(-ANY_FLOAT, ANY_FLOAT);
    set.ticks = any_u32();
    (void)kelly_case_key(&set);
    (void)kelly_job_key(any_u32(), any_u64());
    draw.fc = draw.mu = draw.a1 = draw.a2 = draw.w0 = any_real(-ANY_REAL, ANY_REAL);
    (void)kelly_draw_key(&draw);
}

int main(void)
{
    bytes();
    frames();
    texts();
    keys();
    return 0;
}
