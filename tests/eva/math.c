/* detmath.h over its documented ranges: every finite number, and for the logarithms every normal one above 0. */
#include "bitrock.h"
#include "detmath.h"

/* log(x) >= 0 from x = 1 on: in slices where f - f^2 / 2 is seen to be. */
static void from_one(double low, double high)
{
    const double log64 = kelly_log(any_wide(low, high));

    //@ assert log64 >= 0;
}

static void logarithms(void)
{
    double t = 0.25;

    from_one(1, 1);
    //@ loop unroll 50;
    for (unsigned k = 0; k < WIDER(50, 21); k++) {
        from_one(1 + t / 2, 1 + t);
        t /= 2;
    }
    from_one(1.25, 1.4);
    from_one(1.4, 1.5);
    from_one(1.5, WIDER(0x1.fffffffffffffp0, 0x1.fffffep0));
    from_one(2, ANY_WIDE);
}

int main(void)
{
    const float normal = Frama_C_float_interval(0x1p-126f, ANY_FLOAT), not_negative = Frama_C_float_interval(0, ANY_FLOAT);
    const float log32 = kelly_log32(normal), root = kelly_sqrt32(not_negative);
    const real sine = kelly_sin_turn(any_u64()), tanh = kelly_tanh(any_real(-ANY_REAL, ANY_REAL));
    const uint64_t step = kelly_phase_step(any_real(0, 1048576), any_u32());
    const double log64 = kelly_log(any_wide(LEAST_WIDE, ANY_WIDE));
    const float small_root = kelly_sqrt32(Frama_C_float_interval(0, 4e12f));

    (void)kelly_sqrt32_integer(not_negative);
    logarithms();
    //@ assert -88 <= log32 <= 89;
    //@ assert 0 <= root <= 0x1p64;
    //@ assert small_root <= 4000000;
    //@ assert -7 <= sine <= 7;
    //@ assert -1 <= tanh <= 1;
    //@ assert -709 <= log64 <= 710;
    return 0;
}
