#include "out.h"
#include "../board/board.h"

static uint8_t ring[OUT_RING];
static uint32_t oldest, waiting;   /* of the bytes that are kept: the place of the first, how many */
static int deferred;

/* line_count, line_last: what has gone out over the line, and the last of it (tests/eva/contracts.h). */
/*@ predicate sound = oldest < OUT_RING && waiting <= OUT_RING && (!deferred ==> waiting == 0); */

/* The oldest byte, waiting for the line. */
/*@ requires sound && waiting > 0;
    assigns oldest, waiting, line_count, line_last;
    ensures sound && waiting == \old(waiting) - 1 && oldest == (\old(oldest) + 1) % OUT_RING;
    ensures line_count == (uint32_t)(\old(line_count) + 1) && line_last == \old(ring[oldest]); */
static void send_one(void)
{
    board_write(ring[oldest]);
    oldest = (oldest + 1u) % OUT_RING;
    waiting--;
}

/*@ requires sound;
    assigns oldest, waiting, deferred, line_count, line_last;
    ensures sound && deferred == on && (on || waiting == 0); */
void out_defer(int on)
{
    /*@ loop invariant sound;
        loop assigns oldest, waiting, line_count, line_last;
        loop variant waiting; */
    while (!on && waiting > 0) {
        send_one();
    }
    deferred = on;
}

/*@ requires sound;
    assigns oldest, waiting, line_count, line_last;
    ensures sound && (\result == 0 <==> waiting == 0); */
int out_pump(void)
{
    /*@ loop invariant sound;
        loop assigns oldest, waiting, line_count, line_last;
        loop variant waiting; */
    while (waiting > 0 && board_ready()) {
        send_one();
    }
    return waiting > 0;
}

/*@ requires sound;
    assigns \nothing;
    ensures \result && deferred ==> waiting + bytes <= OUT_RING; */
int out_room(size_t bytes)
{
    return !deferred || OUT_RING - waiting >= bytes;
}

/* A byte goes behind those that wait, into a place of its own. */
/*@ requires sound;
    assigns ring[0 .. OUT_RING - 1], oldest, waiting, line_count, line_last;
    ensures sound;
    ensures last: deferred ==> waiting > 0 && ring[(oldest + waiting - 1) % OUT_RING] == byte;
    ensures others: \forall integer k; 0 <= k < OUT_RING && k != (oldest + waiting - 1) % OUT_RING ==> ring[k] == \old(ring[k]);
    ensures its_own: deferred ==> \forall integer k; 0 <= k < waiting - 1 ==> (oldest + k) % OUT_RING != (oldest + waiting - 1) % OUT_RING;
    ensures no_more_than_one_sent: deferred ==> waiting == (\old(waiting) < OUT_RING ? \old(waiting) + 1 : OUT_RING);
    ensures at_once: !deferred ==> line_count == (uint32_t)(\old(line_count) + 1) && line_last == byte;
    ensures pushed: deferred && \old(waiting) == OUT_RING ==> line_count == (uint32_t)(\old(line_count) + 1) && line_last == \old(ring[oldest]);
    ensures quiet: deferred && \old(waiting) < OUT_RING ==> line_count == \old(line_count) && oldest == \old(oldest); */
void out_byte(uint8_t byte)
{
    if (!deferred) {
        board_write(byte);
        return;
    }
    if (waiting == OUT_RING) {
        send_one();
    }
    ring[(oldest + waiting) % OUT_RING] = byte;
    waiting++;
}

void out_frame(uint8_t wire[KELLY_WIRE_MAX], uint8_t type, uint32_t seq, size_t size)
{
    const size_t bytes = kelly_frame(wire, type, seq, wire + KELLY_WIRE_BODY, size);

    for (size_t k = 0; k < bytes; k++) {
        out_byte(wire[k]);
    }
}
