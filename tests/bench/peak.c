/* peak.c - what the vector unit can do at most: independent chains in registers, half multiplies and half adds, or
 * fused ones with -DFUSED, which count as two operations. Built with -DBITS=128|256|512 and the matching unit.
 */
#include "run.h"

/* Chains of each kind: all of 16 registers, or 28 of 32, so that latency is not what limits. */
#if BITS == 512
#define CHAINS 14
#define ALL(M) M(0) M(1) M(2) M(3) M(4) M(5) M(6) M(7) M(8) M(9) M(10) M(11) M(12) M(13)
#define REGISTER "+v"
#else
#define CHAINS 8
#define ALL(M) M(0) M(1) M(2) M(3) M(4) M(5) M(6) M(7)
#define REGISTER "+x"
#endif
#define TURNS 4096

#ifdef FUSED
#define MULTIPLY(x) x = x * x + x
#define ADD(y) y = y * y + y
#define EACH 2.0
#define START zero
#else
#define MULTIPLY(x) x = x * x
#define ADD(y) y = y + y
#define EACH 1.0
#define START one
#endif

/* The empty asm keeps every chain alive and in its register. */
#define DECLARE(n) vector x##n = START, y##n = zero;
#define TURN(n) \
    MULTIPLY(x##n); \
    ADD(y##n); \
    __asm__ volatile("" : REGISTER(x##n), REGISTER(y##n));

/* 1 times 1 and 0 plus 0, which the compiler cannot know: no register for a constant, and nothing fades or overflows. */
#define RATE(name, type) \
    static double name(double seconds) \
    { \
        typedef type vector __attribute__((vector_size(BITS / 8))); \
        volatile type unity = 1, nothing = 0; \
        const vector zero = (vector){ 0 } + nothing, one = zero + unity; \
        const double begin = busy(); \
        double done = 0, took; \
        ALL(DECLARE) \
        (void)one; \
        do { \
            for (int n = 0; n < TURNS; n++) { \
                ALL(TURN) \
            } \
            done += 2.0 * CHAINS * TURNS; \
            took = busy() - begin; \
        } while (took < seconds); \
        return 1e-9 * EACH * done * (double)(BITS / 8 / sizeof(type)) / took; \
    }

RATE(rate_float, float)
RATE(rate_double, double)

const peak NAME = { UNIT, BITS, rate_float, rate_double };
