/* line.h - a few numbers for a program at run time, over the UART: `seed=1 first=0`.
 *
 * Bytes sent before a UART is up are lost, so the board asks: it prints a line `?` and waits for one line, ended by LF
 * or CR. Whoever runs it answers each `?`, with an empty line where there is nothing to say. A board that stands alone
 * goes on after LINE_WAIT_MS; the time is long because an emulator on a busy machine may be slow to be answered.
 * (Under -icount emulated time runs ahead of the host: always answer there.) The device program
 * asks in the same way and waits for ever (device.c).
 */
#ifndef KELLY_LINE_H
#define KELLY_LINE_H

#include <stdint.h>

#define LINE_MAX 80   /* bytes kept, the final 0 included; the rest of a longer line is dropped (bench.c marks what it cut) */
#define LINE_WAIT_MS 30000

/* Ask for a line. Returns its length, -1 (and an empty line) where none came. */
int line_ask(char line[LINE_MAX]);

/* A key of a line: the largest number that it takes, 0 for any below 2^64, and its value where the line has none. */
typedef struct {
    const char *name;
    uint32_t most, otherwise;
} line_key;

/* values[k]: the decimal number after `key=` of keys[k], of at most 32 keys. -> 0, or the first word, and what follows it, that is not
 * `key=number` with one of these keys, for the first time, and a number that it takes; the values are void then. */
const char *line_read(const char line[LINE_MAX], const line_key keys[], uint64_t values[], unsigned count);

#endif
