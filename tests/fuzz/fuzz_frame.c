/* fuzz_frame.c - what a line may carry, for libFuzzer (clang -fsanitize=fuzzer,address,undefined); run by tests/check_fuzz.py.
 *
 * The input is taken twice: as the bytes of a line, and as payloads, 255 marking the end of one, each of which gets the CRC that it
 * needs to be received: a fuzzer would never guess it, and nothing behind the CRC would be tried.
 */
#include <stdlib.h>
#include <string.h>

#include "../../firmware/link/crc32c.h"
#include "../each_message.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static void must(int holds)
{
    if (!holds) {
        abort();
    }
}

/* What get accepts, put writes the same. The body stands alone, so that reading past its end is seen. */
static void look(const kelly_receiver *receiver)
{
    uint8_t again[KELLY_BODY_MAX];
    size_t size;
    const uint8_t *const body = kelly_received_body(receiver, &size);
    uint8_t *const alone = malloc(size > 0 ? size : 1);
    int written;

    must(alone != 0 && size <= KELLY_FRAME_MAX - KELLY_FRAME_MIN);
    memcpy(alone, body, size);
    written = read_and_write(kelly_received_type(receiver), alone, size, again);
    must(written < 0 || ((size_t)written == size && memcmp(again, alone, size) == 0));
    free(alone);
}

static void raw(const uint8_t *data, size_t size)
{
    kelly_receiver receiver;

    memset(&receiver, 0, sizeof(receiver));
    for (size_t i = 0; i < size; i++) {
        const int got = kelly_receive(&receiver, data[i]);

        must(receiver.size <= KELLY_FRAME_MAX);
        if (got > 0) {
            look(&receiver);
        }
    }
}

/* One payload on the wire, and what it must come to. */
static void send(kelly_receiver *receiver, const uint8_t *data, size_t size)
{
    uint8_t wire[KELLY_WIRE_MAX];
    const size_t body = size > 5 ? size - 5 : 0;
    uint8_t head[5] = { 0 };
    size_t length;
    int got = 0;

    memcpy(head, data, size < 5 ? size : 5);
    length = kelly_frame(wire, head[0], (uint32_t)head[1] | (uint32_t)head[2] << 8 | (uint32_t)head[3] << 16 | (uint32_t)head[4] << 24,
                         data + (size - body), body);
    must((length == 0) == (body > KELLY_FRAME_MAX - KELLY_FRAME_MIN));
    for (size_t i = 0; i < length; i++) {
        must(i == 0 || i == length - 1 || wire[i] != 0);
        got = kelly_receive(receiver, wire[i]);
    }
    must(length == 0 || (got == (int)body + 1 && memcmp(receiver->payload, head, 5) == 0));
    must(length == 0 || memcmp(receiver->payload + 5, data + (size - body), body) == 0);
    if (length > 0) {
        look(receiver);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    kelly_receiver receiver;
    size_t begin = 0;

    raw(data, size);
    memset(&receiver, 0, sizeof(receiver));
    for (size_t i = 0; i <= size; i++) {
        if (i == size || data[i] == 255) {
            send(&receiver, data + begin, i - begin);
            begin = i + 1;
        }
    }
    return 0;
}
