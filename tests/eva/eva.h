/* eva.h - what the drivers of Eva share: general inputs, and the three compiler builtins of the kernel in terms that Eva knows.
 *
 * A driver calls public functions with inputs that stand for every value of their documented ranges. It is analysed, never run.
 */
#ifndef KELLY_EVA_H
#define KELLY_EVA_H

#include <stddef.h>
#include <stdint.h>

#include <__fc_builtin.h>
#include <math.h>

#define volatile                        /* memory holds what was written to it: faults are struck, not proved */
#define __builtin_fabsf(x) ((x) < 0 ? -(x) : (x))
#define __builtin_fabs(x) ((x) < 0 ? -(x) : (x))
#define __builtin_sqrtf sqrtf            /* correctly rounded, as the instruction is */

/* Leading zeros of a number that is not 0, as gcc documents it. */
static inline int eva_clzll(unsigned long long x)
{
    int zeros = 0;

    if (x <= 0xffffffffull) { zeros += 32; x <<= 32; }
    if (x <= 0xffffffffffffull) { zeros += 16; x <<= 16; }
    if (x <= 0xffffffffffffffull) { zeros += 8; x <<= 8; }
    if (x <= 0xfffffffffffffffull) { zeros += 4; x <<= 4; }
    if (x <= 0x3fffffffffffffffull) { zeros += 2; x <<= 2; }
    return x <= 0x7fffffffffffffffull ? zeros + 1 : zeros;
}
#define __builtin_clzll eva_clzll

#define BOARD_NAME "eva"
#define BOARD_COUNT_HZ 1000u
#define BOARD_ICOUNT_SHIFT 0

#define ANY_FLOAT 0x1.fffffep127f
#define ANY_DOUBLE 0x1.fffffffffffffp1023
#ifdef KELLY_DOUBLE
#define any_real Frama_C_double_interval
#define ANY_REAL ANY_DOUBLE
#else
#define any_real Frama_C_float_interval
#define ANY_REAL ANY_FLOAT
#endif

/* wide (real.h): double on a host, float on a board (BOARD in tests/check_eva.py) unless real is double there. */
#if defined(KELLY_DOUBLE) || __STDC_HOSTED__
#define any_wide Frama_C_double_interval
#define WIDER(host, board) (host)
#else
#define any_wide Frama_C_float_interval
#define WIDER(host, board) (board)
#endif
#define ANY_WIDE WIDER(ANY_DOUBLE, ANY_FLOAT)
#define LEAST_WIDE WIDER(0x1p-1022, 0x1p-126f)     /* normal */
#define MOST_EXP WIDER(1.2e308, 3e38)

static inline unsigned char any_byte(void) { return Frama_C_unsigned_char_interval(0, 255); }
static inline uint32_t any_u32(void) { return Frama_C_unsigned_int_interval(0, 0xffffffffu); }
static inline uint64_t any_u64(void) { return Frama_C_unsigned_long_long_interval(0, 0xffffffffffffffff); }

/* Any bytes. */
#define ANY(object) Frama_C_make_unknown((char *)&(object), sizeof(object))

#include "cobs.h"

/* What has gone out over a board's line, and the last of it: contracts.h, out.c. */
/*@ ghost unsigned line_count; */
/*@ ghost unsigned char line_last; */

#endif
