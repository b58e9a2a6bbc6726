/* What torque.h says of kelly_bit_torque_folded, over all that it requires, in slices of its sizes. */
#include "bitrock.h"

static void slice(float w_low, float w_high, float inverse)
{
    const real inverses = any_real(inverse, 4 * inverse), ratio = any_real(0, 8.95e6f * sqrtf(inverse));
    const real w = any_real(w_low, w_high);
    real t = kelly_bit_torque_folded(w, any_real(R(-8.0), 0), ratio, inverses);

    //@ assert -2.1e8 <= t <= 2.1e8;
    t = kelly_bit_torque_folded(-w, any_real(R(-8.0), 0), ratio, inverses);
    //@ assert -2.1e8 <= t <= 2.1e8;
    t = kelly_bit_torque_folded(w, any_real(R(-134217728.0), 0), ratio, inverses);
    //@ assert -3.5e15 <= t <= 3.5e15;
    t = kelly_bit_torque_folded(-w, any_real(R(-134217728.0), 0), ratio, inverses);
    //@ assert -3.5e15 <= t <= 3.5e15;
}

int main(void)
{
    float inverse = 4e-9f;

    //@ loop unroll 24;
    for (unsigned i = 0; i < 24; i++) {
        float w = 0x1p-14f;

        slice(0, w, inverse);
        //@ loop unroll 25;
        for (unsigned j = 0; j < 25; j++) {
            slice(w, 4 * w, inverse);
            w *= 4;
        }
        inverse *= 4;
    }
    return 0;
}
