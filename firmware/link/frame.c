#include "frame.h"
#include "crc32c.h"

#define GROUP 255u                       /* the code of 254 bytes that no 00 follows */

_Static_assert(KELLY_WIRE_BODY - 5u >= 1u + KELLY_FRAME_MAX / 254u + 1u, "a payload is packed in place: kelly_cobs");

static uint32_t word_at(const uint8_t *at)
{
    return (uint32_t)at[0] | (uint32_t)at[1] << 8 | (uint32_t)at[2] << 16 | (uint32_t)at[3] << 24;
}

static void set_word(uint8_t *at, uint32_t value)
{
    for (unsigned k = 0; k < 4; k++) {
        at[k] = (uint8_t)(value >> (8 * k));
    }
}

size_t kelly_cobs(uint8_t *to, const uint8_t *from, size_t n)
{
    size_t code_at = 0, at = 1;
    //@ ghost cobs_lead[0] = code_at; cobs_place[0] = at;

    /* Bytes written beyond those read, at - 1 - i, are the codes of full groups, each of which has taken 254; the open one has room. */
    /*@ loop invariant 0 <= i <= n && code_at < at <= code_at + GROUP && i + 1 <= at;
        loop invariant 254 * (at - 1 - i) + (at - code_at - 1) <= i;
        loop invariant code_at == cobs_lead[i] && at == cobs_place[i];
        loop invariant packed: cobs_packed(to, i);
        loop invariant room: at <= i + 1 + n / 254;
        loop invariant taken: cobs_apart(to, from, n) ==> cobs_taken{Pre, Here}(from, i);
        loop invariant unread: cobs_apart(to, from, n) ==> cobs_unread{Pre, Here}(from, i, n);
        loop assigns i, code_at, at, to[0 .. n + n / 254], cobs_lead[0 .. n], cobs_place[0 .. n], cobs_spot[0 .. n - 1], cobs_byte[0 .. n - 1];
        loop variant n - i; */
    for (size_t i = 0; i < n; i++) {
        const uint8_t byte = from[i];

        if (at - code_at == GROUP) {     /* full; closed only now, for a full last group needs no other behind it */
            to[code_at] = (uint8_t)GROUP;
            code_at = at++;
        }
        if (byte != 0) {
            to[at++] = byte;
        } else {
            to[code_at] = (uint8_t)(at - code_at);
            code_at = at++;
        }
        //@ ghost cobs_byte[i] = byte; cobs_spot[i] = at - 1; cobs_lead[i + 1] = code_at; cobs_place[i + 1] = at;
    }
    to[code_at] = (uint8_t)(at - code_at);
    return at;
}

size_t kelly_frame(uint8_t wire[KELLY_WIRE_MAX], uint8_t type, uint32_t seq, const uint8_t *body, size_t size)
{
    uint8_t *const payload = wire + KELLY_WIRE_BODY - 5u;   /* as far behind the packed bytes as COBS may need */
    size_t packed;

    if (size > KELLY_FRAME_MAX - KELLY_FRAME_MIN) {
        return 0;
    }
    payload[0] = type;
    set_word(payload + 1, seq);
    for (size_t i = 0; i < size; i++) {
        payload[5 + i] = body[i];
    }
    set_word(payload + 5 + size, kelly_crc32c(0, payload, 5 + size));
    wire[0] = 0;
    packed = kelly_cobs(wire + 1, payload, size + KELLY_FRAME_MIN);
    wire[1 + packed] = 0;
    return packed + 2u;
}

static int drop(kelly_receiver *receiver, uint8_t inside)
{
    receiver->bad++;
    receiver->inside = inside;
    return -1;
}

/* 00: the end of a frame, or of what was none. */
static int finish(kelly_receiver *receiver)
{
    const uint8_t begun = receiver->inside && receiver->code != 0, broken = receiver->left != 0;

    receiver->inside = 1;
    receiver->code = 0;
    receiver->left = 0;
    receiver->fresh = 1;
    if (!begun) {
        return 0;
    }
    if (broken || receiver->size < KELLY_FRAME_MIN) {
        return drop(receiver, 1);
    }
    const size_t size = receiver->size;
    if (word_at(receiver->payload + size - 4) != kelly_crc32c(0, receiver->payload, size - 4)) {
        return drop(receiver, 1);
    }
    receiver->good++;
    return (int)(size - KELLY_FRAME_MIN) + 1;
}

static int append(kelly_receiver *receiver, uint8_t byte)
{
    if (receiver->size >= KELLY_FRAME_MAX) {
        return drop(receiver, 0);
    }
    receiver->payload[receiver->size++] = byte;
    return 0;
}

int kelly_receive(kelly_receiver *receiver, uint8_t byte)
{
    const uint8_t last = receiver->code;

    if (byte == 0) {
        return finish(receiver);
    }
    if (!receiver->inside) {
        return 0;
    }
    if (receiver->fresh) {
        receiver->fresh = 0;
        receiver->size = 0;
    }
    if (receiver->left > 0) {
        receiver->left--;
        return append(receiver, byte);
    }
    receiver->code = byte;
    receiver->left = (uint8_t)(byte - 1u);
    return last != 0 && last != GROUP ? append(receiver, 0) : 0;
}

uint8_t kelly_received_type(const kelly_receiver *receiver)
{
    return receiver->payload[0];
}

uint32_t kelly_received_seq(const kelly_receiver *receiver)
{
    return word_at(receiver->payload + 1);
}

const uint8_t *kelly_received_body(const kelly_receiver *receiver, size_t *size)
{
    *size = receiver->size - KELLY_FRAME_MIN;
    return receiver->payload + 5;
}
