/* bitrock.h - torque of the rock on the bit, eq. (B).
 *
 *     (B)  T = mu min(f, 0) [ tanh(w) + a1 w / (1 + a2 w^2) ],   w in rad/s
 *
 * Bounds  |T| <= mu |f| (1 + a1 / (2 sqrt(a2))).  Odd in w.  Slope at w = 0: mu |f| (1 + a1), the fastest rate of the system.
 * Cost    one division, shared by both terms; no branch, so lanes stay together.
 */
#ifndef KELLY_BITROCK_H
#define KELLY_BITROCK_H

#include "detmath.h"

/* Bit torque [N m] at bit speed w [rad/s]; muf = mu min(f, 0) <= 0 [N m]: negative for w > 0, it resists. */
static inline vreal kelly_bit_torque(vreal w, vreal muf, vreal a1, vreal a2)
{
    const vreal s = a2 * (w * w) + R(1.0);
    vreal p, q;

    kelly_tanh_ratio(w, &p, &q);
    return (muf * (p * s + (a1 * w) * q)) / (q * s);
}

/* The same from 2 mu min(f, 0), a1 / (2 a2) and 1 / a2: with the factors of 2 and a2 taken out, two operations less. */
KELLY_INLINE vreal kelly_bit_torque_folded(vreal w, vreal twice_muf, vreal ratio, vreal inverse)
{
    const vreal s = w * w + inverse;
    vreal a, b, q;

    kelly_tanh_parts(w, &a, &b, &q);
    return (twice_muf * ((a * b) * s + (ratio * w) * q)) / (q * s);
}

#endif
