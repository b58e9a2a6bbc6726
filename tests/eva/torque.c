/* What torque.h says of kelly_bit_torque_folded, over all that it requires, in slices of its sizes. */
#define EVA_TORQUE
#include "torque.h"

/* The other form; a2 of 1.8e7 down to 1e-4. */
static void unfolded(real w, real a2)
{
    const real a1 = any_real(0, R(1000.0));
    real t = kelly_bit_torque(w, any_real(-(real)LEAST_M, 0), a1, a2);

    //@ assert -2.6e5 * LEAST_M <= t <= 2.6e5 * LEAST_M;
    t = kelly_bit_torque(-w, any_real(-(real)LEAST_M, 0), a1, a2);
    //@ assert -2.6e5 * LEAST_M <= t <= 2.6e5 * LEAST_M;
    t = kelly_bit_torque(w, any_real(-(real)LARGEST_M, 0), a1, a2);
    //@ assert -2.6e5 * LARGEST_M <= t <= 2.6e5 * LARGEST_M;
    t = kelly_bit_torque(-w, any_real(-(real)LARGEST_M, 0), a1, a2);
    //@ assert -2.6e5 * LARGEST_M <= t <= 2.6e5 * LARGEST_M;
}

static void slice(float w_low, float w_high, float inverse)
{
    const real inverses = any_real(inverse, 4 * inverse), ratio = any_real(0, 4.52e5f * sqrtf(inverse));
    const real w = any_real(w_low, w_high);
    real t = kelly_bit_torque_folded(w, any_real(-(real)LEAST_M, 0), ratio, inverses);

    //@ assert -1e6 * LEAST_M <= t <= 1e6 * LEAST_M;
    t = kelly_bit_torque_folded(-w, any_real(-(real)LEAST_M, 0), ratio, inverses);
    //@ assert -1e6 * LEAST_M <= t <= 1e6 * LEAST_M;
    t = kelly_bit_torque_folded(w, any_real(-(real)LARGEST_M, 0), ratio, inverses);
    //@ assert -1e6 * LARGEST_M <= t <= 1e6 * LARGEST_M;
    t = kelly_bit_torque_folded(-w, any_real(-(real)LARGEST_M, 0), ratio, inverses);
    //@ assert -1e6 * LARGEST_M <= t <= 1e6 * LARGEST_M;
    if (w_low <= 8e6f && inverse >= 1.3e-8f && inverse <= 1.1e4f) {
        unfolded(any_real(w_low, w_high < 8e6f ? w_high : 8e6f), any_real(1 / (4 * inverse), 1 / inverse));
    }
}

/* Sizes of w: q changes fast between 1 and the end of tanh, so the slices are finer there. */
static void sizes(float inverse)
{
    float w = 0x1p-14f;

    slice(0, w, inverse);
    //@ loop unroll 64;
    for (unsigned j = 0; j < 64; j++) {
        float next = w * (w < 0.25f || w > 16.0f ? 4.0f : 1.125f);

        next = next < 6.8e10f ? next : 6.8e10f;
        slice(w, next, inverse);
        w = next;
    }
}

int main(void)
{
    float inverse = 1.5e-8f;

    //@ loop unroll 20;
    for (unsigned i = 0; i < 20; i++) {
        sizes(inverse);
        inverse *= 4;
    }
    return 0;
}
