/* peak.c - what the vector unit can do at most: independent chains in registers, half multiplies and half adds, or
 * fused ones with -DFUSED. Built with -DBITS=128|256|512 and the matching unit. A fused operation counts as two.
 */
#include "run.h"

#if BITS == 512
#define CHAINS 12                /* of each kind: 24 of 32 registers */
#else
#define CHAINS 6                 /* 12 of 16 registers */
#endif
#define TURNS 20000

/* x = x * m and y = y + a, CHAINS of each; the empty asm keeps every chain alive and in registers. */
#ifdef FUSED
#define MULTIPLY(x) x = x * m + a
#define ADD(y) y = y * m + a
#define EACH 2.0
#else
#define MULTIPLY(x) x = x * m
#define ADD(y) y = y + a
#define EACH 1.0
#endif
#define REGISTER "+x"
#if BITS == 512
#undef REGISTER
#define REGISTER "+v"
#endif

#define RATE(name, type) \
    typedef type name##_vector __attribute__((vector_size(BITS / 8))); \
    static double name(double seconds) \
    { \
        const name##_vector zero = { 0 }; \
        name##_vector m = zero + (type)0.999999, a = zero + (type)1e-6, x[CHAINS], y[CHAINS]; \
        const double begin = busy(); \
        double done = 0, took; \
        for (int i = 0; i < CHAINS; i++) { \
            x[i] = zero + (type)1 + (type)i; \
            y[i] = x[i]; \
        } \
        do { \
            for (int n = 0; n < TURNS; n++) { \
                _Pragma("GCC unroll 16") \
                for (int i = 0; i < CHAINS; i++) { \
                    MULTIPLY(x[i]); \
                    ADD(y[i]); \
                    __asm__ volatile("" : REGISTER(x[i]), REGISTER(y[i])); \
                } \
                if (n % 4096 == 0) {     /* the multiplied ones must not fade into subnormals */ \
                    _Pragma("GCC unroll 16") \
                    for (int i = 0; i < CHAINS; i++) { \
                        x[i] = zero + (type)1; \
                    } \
                } \
            } \
            done += 2.0 * CHAINS * TURNS; \
            took = busy() - begin; \
        } while (took < seconds); \
        return 1e-9 * EACH * done * (double)(BITS / 8 / sizeof(type)) / took; \
    }

RATE(rate_float, float)
RATE(rate_double, double)

const peak NAME = { UNIT, BITS, rate_float, rate_double };
