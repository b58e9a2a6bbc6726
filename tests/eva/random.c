/* random.h: any state, any key, any word; mean > 0, cov and x of the documented ranges. kelly_normal: normal.c. */
#include "random.h"
#include "contracts.h"

#define FARTHEST 3e3f                    /* a led move tries from 1000, in 8 steps: walk.c */

static void state(kelly_rng *rng)
{
    for (unsigned k = 0; k < 4; k++) {
        rng->s[k] = any_u32();
    }
}

int main(void)
{
    kelly_rng rng;
    uint64_t word = any_u64();
    float x;

    (void)kelly_splitmix64(&word);
    kelly_rng_key(&rng, any_u64(), any_u32(), any_u32());
    state(&rng);
    (void)kelly_rng_next(&rng);
    kelly_rng_jump(&rng);
    x = kelly_open01(any_u32());
    //@ assert 0x1p-24 <= x <= 1 - 0x1p-24;
    state(&rng);
    x = kelly_gamma(&rng, Frama_C_float_interval(0x1p-126f, 1e30f), Frama_C_float_interval(1e-4f, 0.5f));
    (void)kelly_gamma_normal(&rng, Frama_C_float_interval(1e-4f, 0.5f));
    (void)kelly_gamma_value(Frama_C_float_interval(-FARTHEST, FARTHEST), Frama_C_float_interval(0x1p-126f, 1e30f), Frama_C_float_interval(1e-4f, 0.5f));
    x = kelly_gamma_log_weight(Frama_C_float_interval(-FARTHEST, FARTHEST), Frama_C_float_interval(1e-4f, 0.5f));
    //@ assert KELLY_NO_WEIGHT <= x <= 1e16;
    return 0;
}
