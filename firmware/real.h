/* real.h - the number types of kelly.
 *
 * real   what the plant is computed in: float by default, double with -DKELLY_DOUBLE. The only precision switch.
 * wide   what statistics are reported in: double on a hosted build, `real` on a microcontroller (a float image
 *        must not pull in soft double). Nothing that enters a digest is computed in `wide`.
 * R(x)   a literal in `real`: R(0.5). W(x): in `wide`.
 *
 * Samplers use plain float in both builds, so that realisation j has the same parameters in float and in double.
 * Bits are equal on every machine only if the compiler does exactly the operations that are written.
 */
#ifndef KELLY_REAL_H
#define KELLY_REAL_H

#include <stddef.h>
#include <stdint.h>

#ifdef __FAST_MATH__
#error "kelly needs IEEE arithmetic: build without fast-math"
#endif
#if defined(__x86_64__) && defined(__GCC_IEC_559) && __GCC_IEC_559 < 2 && !defined(__clang__)   /* 0 for soft float as well */
#error "kelly needs IEEE arithmetic: one of the flags relaxes it"
#endif
#if defined(__FLT_EVAL_METHOD__) && __FLT_EVAL_METHOD__ != 0 && __FLT_EVAL_METHOD__ != 16   /* 16: _Float16 in its own range, float in float */
#error "kelly needs FLT_EVAL_METHOD 0: on 32-bit x86 build with -msse2 -mfpmath=sse"
#endif

#ifdef KELLY_DOUBLE
typedef double real;
#define R(x) ((real)(x))
#define KELLY_ABS(x) __builtin_fabs(x)    /* the sign bit cleared: an instruction, no libm */
#else
typedef float real;
#define R(x) ((real)(x##f))
#define KELLY_ABS(x) __builtin_fabsf(x)
#endif

#if defined(KELLY_DOUBLE) || __STDC_HOSTED__
typedef double wide;
#define W(x) ((wide)(x))
#else
typedef float wide;
#define W(x) ((wide)(x##f))
#endif

#define KELLY_PI R(3.14159265358979323846)

#endif
