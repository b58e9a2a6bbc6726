/* torque.h - the ranges for which one step of the modes is analysed, in slices: only together are the torque and its lever moderate.
 * The contract is proved by torque.c, slice by slice, and used by step.c. */
#ifndef KELLY_EVA_TORQUE_H
#define KELLY_EVA_TORQUE_H

#include "bitrock.h"

/* 2 mu |f| [N m]: the two slices that are analysed, each from half of it on. tests/check_eva.py --rest has those between, all powers of 2. */
#ifndef LEAST_M
#define LEAST_M 8.0
#define LARGEST_M 134217728.0
#endif
#ifndef SLICES_A
#define SLICES_A 9                       /* a2: 1e-4 .. 2e-3, .. to 5e7 s2/rad2 */
#endif
#define LARGEST_A1 1000                  /* [s/rad] */

#ifndef EVA_TORQUE
/* Of a1 / (2 a2) and 1 / a2 with a1 <= LARGEST_A1, a2 >= 1e-4. */
/*@ requires \is_finite(w) && \is_finite(twice_muf) && \is_finite(ratio) && \is_finite(inverse);
    requires -6.8e10 <= w <= 6.8e10 && -LARGEST_M <= twice_muf <= 0 && 0 <= ratio <= 5.1e6 && 1.5e-8 <= inverse <= 1.1e4;
    requires ratio * ratio <= 5.1e10 * inverse;
    assigns \result \from w, twice_muf, ratio, inverse;
    ensures \is_finite(\result);
    ensures twice_muf >= -LEAST_M ==> -1e6 * LEAST_M <= \result <= 1e6 * LEAST_M;
    ensures -1e6 * LARGEST_M <= \result <= 1e6 * LARGEST_M; */
vreal kelly_bit_torque_folded(vreal w, vreal twice_muf, vreal ratio, vreal inverse);

/* The other form, of the top of variable speed. */
/*@ requires \is_finite(w) && \is_finite(muf) && \is_finite(a1) && \is_finite(a2);
    requires -8e6 <= w <= 8e6 && -LARGEST_M <= muf <= 0 && 0 <= a1 <= 1000 && 9.99e-5 <= a2 <= 1.8e7;
    assigns \result \from w, muf, a1, a2;
    ensures \is_finite(\result);
    ensures muf >= -LEAST_M ==> -2.6e5 * LEAST_M <= \result <= 2.6e5 * LEAST_M;
    ensures -2.6e5 * LARGEST_M <= \result <= 2.6e5 * LARGEST_M; */
vreal kelly_bit_torque(vreal w, vreal muf, vreal a1, vreal a2);
#endif

#endif
