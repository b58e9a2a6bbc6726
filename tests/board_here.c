/* board_here.c - the device program as a process of this machine: firmware/board/board.h over stdin, stdout and the clock. With counters in
 * it, the scenarios of the bench show which lines and branches of firmware/app/ they reach (check_coverage.py).
 *
 * It ends with its input. The watchdog is looked at with the clock, which every loop of the program reads.
 */
#include <poll.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "../firmware/board/board.h"

#define IDLE_MS 1

static uint8_t received[256];
static unsigned received_count, received_next;
static uint32_t watched_ms, kicked_ms;

static uint64_t nanoseconds(void)
{
    static uint64_t start;
    struct timespec t;
    uint64_t now;

    (void)clock_gettime(CLOCK_MONOTONIC, &t);
    now = (uint64_t)t.tv_sec * 1000000000u + (uint64_t)t.tv_nsec;
    start = start == 0 ? now : start;
    return now - start;
}

static int ready(int file, short event, int wait_ms)
{
    struct pollfd p = { .fd = file, .events = event };

    return poll(&p, 1, wait_ms) > 0;
}

void board_write(uint8_t byte)
{
    if (write(STDOUT_FILENO, &byte, 1) != 1) {
        exit(EXIT_FAILURE);
    }
}

int board_ready(void)
{
    return ready(STDOUT_FILENO, POLLOUT, 0);
}

int board_read(void)
{
    if (received_next == received_count && ready(STDIN_FILENO, POLLIN, 0)) {
        const ssize_t got = read(STDIN_FILENO, received, sizeof(received));

        if (got <= 0) {
            exit(EXIT_SUCCESS);
        }
        received_count = (unsigned)got;
        received_next = 0;
    }
    return received_next < received_count ? received[received_next++] : -1;
}

uint32_t board_ticks(void)
{
    const uint32_t now_ms = (uint32_t)(nanoseconds() / 1000000u);

    if (watched_ms > 0 && now_ms - kicked_ms > watched_ms) {
        board_text("\nfault: watchdog\n");
        exit(BOARD_FAULT);
    }
    return now_ms;
}

uint32_t board_micros(void)
{
    return (uint32_t)(nanoseconds() / 1000u) + 0u * board_ticks();
}

uint32_t board_count(void) { return (uint32_t)nanoseconds(); }
uint32_t board_measure_start(void) { return board_count(); }
uint32_t board_measure_end(uint32_t start) { return board_count() - start; }
int board_counts_cycles(void) { return 0; }

void board_idle(void)
{
    (void)ready(STDIN_FILENO, POLLIN, IDLE_MS);
}

void board_quiet(int quiet) { (void)quiet; }
void board_vectors(int readable) { (void)readable; }
int board_watchdog(void) { return 1; }
void watchdog_kick(void) { kicked_ms = board_ticks(); }
void watchdog_stop(void) { watched_ms = 0; }

void watchdog_start(uint32_t ms)
{
    watched_ms = 0;
    watchdog_kick();
    watched_ms = ms;
}

uint32_t stack_used(void) { return 1000; }
uint32_t stack_size(void) { return 4096; }

const uint8_t *board_image(uint32_t *size)
{
    static const uint8_t image[] = { 'k', 'e', 'l', 'l', 'y' };

    *size = sizeof(image);
    return image;
}

void board_text(const char *text)
{
    for (; *text != '\0'; text++) {
        board_write((uint8_t)*text);
    }
}

_Noreturn void board_exit(int status)
{
    exit(status);
}
