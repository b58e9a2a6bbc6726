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

#define LINE_MAX 80   /* bytes kept, the final 0 included; the rest of a longer line is dropped */
#define LINE_WAIT_MS 30000

/* Ask for a line. Returns its length, -1 (and an empty line) where none came. */
int line_ask(char line[LINE_MAX]);

/* The number after `key=`, decimal, modulo 2^64; `otherwise` where the key is not in the line. */
uint64_t line_number(const char line[LINE_MAX], const char *key, uint64_t otherwise);

/* The first word of the line that is not `key=number` with a key of this list and a number below 2^64, 0-terminated; 0 where all are. */
const char *line_stranger(const char line[LINE_MAX], const char *const keys[], int count);

#endif
