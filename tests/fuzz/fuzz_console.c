/* fuzz_console.c - the device program on bytes from a line: console, and requests behind the CRC (firmware/app/).
 *
 * The first byte: 0 the rest are the bytes as they come; otherwise payloads (type, body), 255 marking the end of one, each in a frame
 * with the CRC that it needs, after a hello of this schema; one that begins with 254 is bytes as they come. After each the work that is
 * due is done for a few slices. The clock goes on by a millisecond at every look.
 */
#include <stdlib.h>
#include <string.h>

#include "../../firmware/board/board.h"
#include "../../firmware/app/bench.c"
#include "../../firmware/link/keys.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static uint32_t now_ms, out_bytes;

void board_write(uint8_t byte) { out_bytes += byte > 0; }
int board_ready(void) { return (now_ms & 3u) != 0; }
int board_read(void) { return -1; }
uint32_t board_ticks(void) { return ++now_ms; }
uint32_t board_micros(void) { return ++now_ms * 1000u; }
uint32_t board_count(void) { return now_ms * 7u; }
int board_counts_cycles(void) { return 0; }
int board_watchdog(void) { return 0; }
void board_idle(void) { now_ms++; }
void board_quiet(int quiet) { (void)quiet; }
void board_vectors(int readable) { (void)readable; }
void board_text(const char *text) { out_bytes += (uint32_t)strlen(text); }
void board_exit(int status) { exit(status); }
void watchdog_start(uint32_t ms) { (void)ms; }
void watchdog_kick(void) { }
void watchdog_stop(void) { }

const uint8_t *board_image(uint32_t *size)
{
    static const uint8_t image[4] = { 1, 2, 3, 4 };

    *size = sizeof(image);
    return image;
}

static void must(int holds)
{
    if (!holds) {
        abort();
    }
}

static void pass(kelly_bench *bench)
{
    for (unsigned k = 0; k < 3; k++) {
        (void)work(bench);
    }
    console_tick(bench);
    (void)out_pump();
    must(bench->length < LINE_MAX && bench->console.count <= CONSOLE_ERRORS && bench->state <= KELLY_STATE_REALTIME);
    must(kelly_case_error(&kelly_string, &bench->run) == 0);
}

static void as_they_come(kelly_bench *bench, const uint8_t *data, size_t size)
{
    for (size_t i = 0; i < size; i++) {
        (void)bench_take(bench, data[i]);
        if (data[i] == '\n' || data[i] == 0) {
            pass(bench);
        }
    }
    pass(bench);
}

static void framed(kelly_bench *bench, const uint8_t *data, size_t size)
{
    static uint32_t seq;
    uint8_t wire[KELLY_WIRE_MAX];
    uint8_t body[KELLY_FRAME_MAX];
    const uint32_t crc = bench->case_crc;
    size_t length = size > 1 ? size - 1 : 0;

    if (size == 0 || length > KELLY_FRAME_MAX - KELLY_FRAME_MIN) {
        return;
    }
    memcpy(body, data + 1, length);
    if ((data[0] == KELLY_MSG_RUN || data[0] == KELLY_MSG_PLANT_START) && length >= 4 && body[0] == 0) {   /* of the case that is set */
        memcpy(body, &crc, sizeof(crc));
    }
    length = kelly_frame(wire, data[0], ++seq, body, length);
    for (size_t i = 0; i < length; i++) {
        (void)bench_take(bench, wire[i]);
    }
    pass(bench);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static kelly_bench bench;
    const kelly_msg_hello hello = { .schema = KELLY_LINK_SCHEMA, .nonce = 1 };
    uint8_t first[1 + KELLY_BODY_MAX] = { KELLY_MSG_HELLO };
    size_t begin = 1;

    if (size == 0 || size > 2000) {
        return 0;
    }
    out_defer(0);
    memset(&bench, 0, sizeof(bench));
    bench_start(&bench);
    if (data[0] == 0) {
        as_they_come(&bench, data + 1, size - 1);
        return 0;
    }
    framed(&bench, first, 1 + kelly_put_hello(first + 1, &hello));
    must(bench.greeted);
    for (size_t i = 1; i <= size; i++) {
        if (i == size || data[i] == 255) {
            if (i > begin && data[begin] == 254) {
                as_they_come(&bench, data + begin + 1, i - begin - 1);
            } else {
                framed(&bench, data + begin, i - begin);
            }
            begin = i + 1;
        }
    }
    return 0;
}
