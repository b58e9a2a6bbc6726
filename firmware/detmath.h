/* detmath.h - the few functions kelly needs, with the same bits on every machine.
 *
 * Only IEEE + - * / and exactly defined integer steps; no libm. Errors are stated in units in the last place (ulp)
 * of the result and are tested over the whole range by tests/.
 */
#ifndef KELLY_DETMATH_H
#define KELLY_DETMATH_H

#include "lanes.h"

/* tanh(w) = 2 a b / q for any w, with q = a^2 + b^2 > 0; 12 operations (double: 20) and a clamp, product and division left to
 * the caller, who may have a better place for the factor of two.
 *
 * tanh(w) = 2 t / (1 + t^2) with t = tanh(w / 2) = a / b, so p = 2 a b. A relative error e of t
 * leaves only e / cosh(w) in tanh(w), and near saturation e^2 / 2: so t may be a short odd rational a = w A(w^2),
 * b = B(w^2), and the result cannot pass 1 but by rounding. A and B are the minimax for tanh(w), not for t
 * (gen/tanh_fit.py); B is monic. The float coefficients were then moved by a few last places, by random descent on the
 * largest error after rounding. Beyond the clamp tanh is 1 to the last digit.
 *
 * Relative error of p / q, all roundings included: 4.5e-7 (double: 5.8e-13), measured (float: at every w).
 * Size: 1.1e6 <= q <= 4e8 (double: 5e16 <= q <= 3e21), |p| <= q (1 + 2^-23). A NaN gives NaN.
 */
#ifdef KELLY_DOUBLE
#define KELLY_TANH_END R(14.5)
#else
#define KELLY_TANH_END R(8.25)
#endif

KELLY_INLINE void kelly_tanh_parts(vreal w, vreal *a_out, vreal *b_out, vreal *q)
{
    const vreal x = vclamp(w, KELLY_TANH_END);
    const vreal u = x * x;
#ifdef KELLY_DOUBLE
    const vreal a = x * ((((R(0x1.470e826590ba0p-7) * u + R(0x1.7a2a73452034bp+5)) * u + R(0x1.b3eb48ab4fedfp+14)) * u
                          + R(0x1.ebb3246f4ae4cp+21)) * u + R(0x1.c3bed7d13e3bdp+26));
    const vreal b = (((u + R(0x1.5ae70be4765d4p+10)) * u + R(0x1.84d92dc9b8a8ep+18)) * u + R(0x1.a816ae51aebe3p+24)) * u
                    + R(0x1.c3bed7d13f5adp+27);
#else
    const vreal a = x * ((R(0x1.edd9d8p-6) * u + R(0x1.d5ab7p+3)) * u + R(0x1.0f4ad2p+9));
    const vreal b = (u + R(0x1.df2324p+6)) * u + R(0x1.0f4ad2p+10);
#endif
    *a_out = a;
    *b_out = b;
    *q = a * a + b * b;
}

/* The same as p / q. */
KELLY_INLINE void kelly_tanh_ratio(vreal w, vreal *p, vreal *q)
{
    vreal a, b;

    kelly_tanh_parts(w, &a, &b, q);
    *p = (a + a) * b;
}

/* tanh, odd, |result| <= 1, from the same ratio: same bits but where the ratio rounds past 1. */
real kelly_tanh(real w);

/* Sine of a phase in turns: sin(2 pi phase / 2^64), within 1.6 ulp (and 1.5 2^-24 in float, 1.5 2^-53 in double);
 * keeps its relative accuracy for small phases. Odd, and the same mirrored at a quarter turn, bit for bit. A quarter
 * turn more is the cosine. */
real kelly_sin_turn(uint64_t phase);

/* Phase per step [turns / 2^64] of the angular speed w [rad/s], 0 <= w < 2^20, step h [ns]: exact integer arithmetic,
 * whole turns dropped. Relative error below 2^-49 or 1/2 of a unit, whichever is more. 0 where w is not a positive
 * normal number. */
uint64_t kelly_phase_step(real w, uint32_t step_ns);

/* Natural logarithm of x, finite and > 0 (normal numbers), in float, for the samplers; within 0.85 ulp. */
float kelly_log32(float x);

/* sqrt of x >= 0 in float, correctly rounded: the instruction where there is one, integers where not. */
float kelly_sqrt32(float x);

/* The same from integers alone, on any machine. */
float kelly_sqrt32_integer(float x);

/* log (of a normal number > 0; within 0.85 ulp) and exp (1.1 ulp) of the statistics. exp is 0 below -KELLY_EXP_END and
 * stays at exp(KELLY_EXP_END) above KELLY_EXP_END. */
wide kelly_log(wide x);
wide kelly_exp(wide x);
#if defined(KELLY_DOUBLE) || __STDC_HOSTED__
#define KELLY_EXP_END W(708.0)
#else
#define KELLY_EXP_END W(87.0)
#endif

#endif
