/* fixture.h - what several tests share: one piece of memory, and the case they start from.
 *
 * Tests run one after another, so that one piece serves all of them: the smallest board has 16 KB of RAM in all.
 */
#ifndef KELLY_FIXTURE_H
#define KELLY_FIXTURE_H

#include "../firmware/kelly.h"
#include "check.h"
#include "textbook.h"

#define FIXTURE_RESULTS 8

/* Contents of no meaning between tests. */
typedef union {
    kelly_plant plant;
    kelly_block pair[2];
    struct {
        kelly_block block;
        textbook book;
    } against;
    struct {
        kelly_work work;
        kelly_result results[FIXTURE_RESULTS], again[FIXTURE_RESULTS];
    } ensemble;
} fixture_memory;

extern fixture_memory fixture;

/* Short runs for boards, long ones where CHECK_LONG is 1 (the host). */
#if CHECK_LONG
#define BY_LENGTH(brief, lengthy) (lengthy)
#else
#define BY_LENGTH(brief, lengthy) (brief)
#endif

/* A bound by the precision of the kernel, as a `wide`. */
#ifdef KELLY_DOUBLE
#define BY_REAL(in_float, in_double) W(in_double)
#else
#define BY_REAL(in_float, in_double) W(in_float)
#endif

/* The nominal case of the table for `ticks` steps, nothing random, the window its second half. */
void fixture_case(kelly_case *run, uint32_t ticks);

/* Infinity, which becomes so when the program runs; minus itself it is no number. A division by zero would stop a sanitised build. */
real fixture_endless(void);

/* Bits of a real, to tell -0 from 0 and to compare exactly. */
uint64_t fixture_bits(real x);

/* A number put into a state as if a step had left it there: its guard knows of it. */
void fixture_put(real *at, vbits *guard, real value);

/* Whether two results are equal in every bit of every field. */
int fixture_same(const kelly_result *a, const kelly_result *b);

/* A table of 20 modes far faster than the paper's, up to 1170 rad/s: a short, stiff string. */
extern const kelly_table fixture_fast;

wide fixture_abs(wide x);

#endif
