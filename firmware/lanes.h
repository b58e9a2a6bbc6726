/* lanes.h - one realisation a lane.
 *
 * vreal holds KELLY_WIDTH realisations. With KELLY_WIDTH 1 (every microcontroller, and any compiler without vector
 * extensions) it is a plain real, and the code reads as scalar C. Lanes never meet: no result depends on the width.
 * KELLY_VECTORS vectors are advanced together, so that the latency of one torque hides behind the work of the others.
 *
 * vmin and vmax are exactly `a < b ? a : b` and `a > b ? a : b` in every lane: b where either is a NaN and where both
 * are zeros. That is also what MINPS and MAXPS do, which gcc does not see through the masks, hence the intrinsics.
 */
#ifndef KELLY_LANES_H
#define KELLY_LANES_H

#include "real.h"

#ifndef KELLY_WIDTH
#define KELLY_WIDTH 1
#endif
#ifndef KELLY_VECTORS
#define KELLY_VECTORS 1
#endif
#define KELLY_LANES (KELLY_WIDTH * KELLY_VECTORS)

/* Whether the state is guarded from step to step (seal.h). */
#ifndef KELLY_GUARD
#define KELLY_GUARD 1
#endif

/* with(1) .. with(KELLY_VECTORS): a case of a switch for each number of vectors in use, 8 at the most. */
#define KELLY_UP_TO_1(with) with(1)
#define KELLY_UP_TO_2(with) KELLY_UP_TO_1(with) with(2)
#define KELLY_UP_TO_3(with) KELLY_UP_TO_2(with) with(3)
#define KELLY_UP_TO_4(with) KELLY_UP_TO_3(with) with(4)
#define KELLY_UP_TO_5(with) KELLY_UP_TO_4(with) with(5)
#define KELLY_UP_TO_6(with) KELLY_UP_TO_5(with) with(6)
#define KELLY_UP_TO_7(with) KELLY_UP_TO_6(with) with(7)
#define KELLY_UP_TO_8(with) KELLY_UP_TO_7(with) with(8)
#define KELLY_UP_TO(n, with) KELLY_UP_TO_##n(with)
#define KELLY_UP_TO_ALL(n, with) KELLY_UP_TO(n, with)
#define KELLY_EACH_COUNT(with) KELLY_UP_TO_ALL(KELLY_VECTORS, with)

/* Vectors wider than the registers may only go through inlined functions: no calling convention is settled for them. What several
 * places share has one copy a file where one lane is all, and flash is short. */
#define KELLY_INLINE static inline __attribute__((always_inline))
#if KELLY_WIDTH == 1
#define KELLY_SHARED static __attribute__((noinline, unused))
#else
#define KELLY_SHARED KELLY_INLINE
#endif

/* The same for what takes a few instructions inline, or a call and some forty where numbers are no floats of the processor's. */
#if defined(__SOFTFP__) || defined(__riscv_float_abi_soft)
#define KELLY_SHORT KELLY_SHARED
#else
#define KELLY_SHORT KELLY_INLINE
#endif

#if KELLY_WIDTH == 1

typedef real vreal;
#ifdef KELLY_DOUBLE
typedef uint64_t vbits;
#else
typedef uint32_t vbits;
#endif
#define LANE(v, l) ((&(v))[l])          /* l is 0 */

typedef union { vreal value; vbits bits; } vword;

KELLY_INLINE vbits vbits_of(vreal x) { return (vword){ .value = x }.bits; }
KELLY_INLINE vreal vsplat(real x) { return x; }
KELLY_INLINE vreal vmin(vreal a, vreal b) { return a < b ? a : b; }
KELLY_INLINE vreal vmax(vreal a, vreal b) { return a > b ? a : b; }

#else

#pragma GCC diagnostic ignored "-Wpsabi"

#ifdef KELLY_DOUBLE
#define KELLY_VECTOR_BYTES (KELLY_WIDTH * 8)
typedef int64_t kelly_word;
#else
#define KELLY_VECTOR_BYTES (KELLY_WIDTH * 4)
typedef int32_t kelly_word;
#endif
typedef real vreal __attribute__((vector_size(KELLY_VECTOR_BYTES)));
typedef kelly_word vmask __attribute__((vector_size(KELLY_VECTOR_BYTES)));
typedef vmask vbits;
#define LANE(v, l) ((v)[l])

KELLY_INLINE vbits vbits_of(vreal x) { return (vbits)x; }

KELLY_INLINE vreal vsplat(real x) { return x - (vreal){0}; }      /* exact for every x, -0 included */

KELLY_INLINE vreal vselect(vmask m, vreal a, vreal b) { return (vreal)(((vmask)a & m) | ((vmask)b & ~m)); }

#if defined(__SSE2__) && KELLY_VECTOR_BYTES == 16
#define KELLY_X86(op) _mm_##op
#elif defined(__AVX__) && KELLY_VECTOR_BYTES == 32
#define KELLY_X86(op) _mm256_##op
#elif defined(__AVX512F__) && KELLY_VECTOR_BYTES == 64
#define KELLY_X86(op) _mm512_##op
#endif

#ifndef KELLY_X86
KELLY_INLINE vreal vmin(vreal a, vreal b) { return vselect(a < b, a, b); }
KELLY_INLINE vreal vmax(vreal a, vreal b) { return vselect(a > b, a, b); }
#else
#include <immintrin.h>
#ifdef KELLY_DOUBLE
KELLY_INLINE vreal vmin(vreal a, vreal b) { return (vreal)KELLY_X86(min_pd)(a, b); }
KELLY_INLINE vreal vmax(vreal a, vreal b) { return (vreal)KELLY_X86(max_pd)(a, b); }
#else
KELLY_INLINE vreal vmin(vreal a, vreal b) { return (vreal)KELLY_X86(min_ps)(a, b); }
KELLY_INLINE vreal vmax(vreal a, vreal b) { return (vreal)KELLY_X86(max_ps)(a, b); }
#endif
#endif

#endif

KELLY_INLINE int vsame(vbits a, vbits b)
{
    for (unsigned l = 0; l < KELLY_WIDTH; l++) {
        if (LANE(a, l) != LANE(b, l)) {
            return 0;
        }
    }
    return 1;
}

/* A number of the state is taken out of the guard by the read that its last use is of, or a later one, and put into it as it is written: a
 * look at what the compiler has in a register would see no change of the memory that is read. */
#if KELLY_GUARD
KELLY_INLINE void vguard(vbits *guard, vbits bits) { *guard = *guard ^ bits; }

KELLY_INLINE vreal vtake(const vreal *at, vbits *guard)
{
    const vreal x = *(const volatile vreal *)at;

    vguard(guard, vbits_of(x));
    return x;
}

KELLY_INLINE void vput(vreal *at, vreal x, vbits *guard)
{
    vguard(guard, vbits_of(x));
    *(volatile vreal *)at = x;
}

/* A number of one lane anew, whatever it was. */
KELLY_SHARED void vput_lane(vreal *at, unsigned l, real x, vbits *guard)
{
    vreal all = vtake(at, guard);

    LANE(all, l) = x;
    vput(at, all, guard);
}
#else
KELLY_INLINE void vguard(vbits *guard, vbits bits) { (void)guard, (void)bits; }
#define vtake(at, guard) ((void)(guard), *(at))      /* no pointer: gcc knows that no other member of a struct has changed */
#define vput(at, x, guard) ((void)(guard), (void)(*(at) = (x)))
#define vput_lane(at, l, x, guard) ((void)(guard), (void)(LANE(*(at), l) = (x)))
#endif

/* x held within -limit .. limit. One lane asks the usual question first: it is seldom beyond. */
#if KELLY_WIDTH == 1
KELLY_INLINE vreal vclamp(vreal x, real limit)
{
    return KELLY_ABS(x) > limit ? (x < 0 ? -limit : limit) : x;
}
#elif defined(KELLY_X86) && KELLY_VECTOR_BYTES == 64 && defined(__AVX512DQ__)
/* The lesser of both sizes with the sign of x: one instruction, but a NaN gives the limit; it is seen elsewhere. */
#ifdef KELLY_DOUBLE
KELLY_INLINE vreal vclamp(vreal x, real limit) { return (vreal)_mm512_range_pd(x, vsplat(limit), 2); }
#else
KELLY_INLINE vreal vclamp(vreal x, real limit) { return (vreal)_mm512_range_ps(x, vsplat(limit), 2); }
#endif
#else
KELLY_INLINE vreal vclamp(vreal x, real limit) { return vmax(vsplat(-limit), vmin(vsplat(limit), x)); }
#endif

#endif
