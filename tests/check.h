/* check.h - the whole test framework: a claim is true or it is not. Runs on the host and, unchanged, on a board.
 *
 * A file test_NAME.c has one `void test_NAME(void)` and is listed in tests/main.c. No libc: output goes through
 * check_put, which the host and each board provide.
 */
#ifndef KELLY_CHECK_H
#define KELLY_CHECK_H

#include "../firmware/real.h"

#ifndef CHECK_LONG
#define CHECK_LONG 0                              /* 1: the sample sizes that only a host has time for */
#endif

/* Without a division by zero, which the sanitizers report. */
#define CHECK_NAN ((real)__builtin_nanf(""))
#define CHECK_INFINITY ((real)__builtin_inff())

extern unsigned check_passed, check_failed;

void check_put(char c);
void check_text(const char *text);
void check_hex(uint64_t value, int digits);
void check_decimal(int64_t value);
void check_number(wide value);                    /* nine digits and a power of ten */

/* Count one claim; a false one prints file, line and the claim. */
void check_claim(int holds, const char *file, int line, const char *claim);
#define CHECK(holds) check_claim((holds) != 0, __FILE__, __LINE__, #holds)

/* As CHECK, and prints the two values that should have been equal within `within` (an absolute bound). */
void check_close(wide got, wide want, wide within, const char *file, int line, const char *claim);
#define CLOSE(got, want, within) check_close((wide)(got), (wide)(want), (wide)(within), __FILE__, __LINE__, #got)

/* As CHECK for integers, and prints both. */
void check_equal(uint64_t got, uint64_t want, const char *file, int line, const char *claim);
#define EQUAL(got, want) check_equal((uint64_t)(got), (uint64_t)(want), __FILE__, __LINE__, #got)

#endif
