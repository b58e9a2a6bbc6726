#include "out.h"
#include "../board/board.h"

static uint8_t ring[OUT_RING];
static uint32_t in, out;
static int deferred;

/* The oldest byte, waiting for the line. */
static void send_one(void)
{
    board_write(ring[out++ % OUT_RING]);
}

void out_defer(int on)
{
    while (!on && in != out) {
        send_one();
    }
    deferred = on;
}

int out_pump(void)
{
    while (in != out && board_ready()) {
        send_one();
    }
    return in != out;
}

int out_room(size_t bytes)
{
    return !deferred || OUT_RING - (in - out) >= bytes;
}

void out_byte(uint8_t byte)
{
    if (!deferred) {
        board_write(byte);
        return;
    }
    if (in - out == OUT_RING) {
        send_one();
    }
    ring[in++ % OUT_RING] = byte;
}

void out_frame(uint8_t wire[KELLY_WIRE_MAX], uint8_t type, uint32_t seq, size_t size)
{
    const size_t bytes = kelly_frame(wire, type, seq, wire + KELLY_WIRE_BODY, size);

    for (size_t k = 0; k < bytes; k++) {
        out_byte(wire[k]);
    }
}
