/* envelope.h: any value, any clusters that values below 1e14 can have made, any quantile. */
#include "envelope.h"
#include "contracts.h"

#define N 16777216u

static kelly_envelope envelope;

static void any_envelope(uint32_t used)
{
    envelope.n = Frama_C_unsigned_int_interval(1, N);
    envelope.used = used;
    envelope.grain = any_real(R(0.25), R(1.25e12));
    envelope.mean = any_real(R(-1e14), R(1e14));
    envelope.m2 = any_real(0, R(1e36));
    for (uint32_t k = 0; k < KELLY_CLUSTERS; k++) {
        envelope.value[k] = any_real(R(-1e14), R(1e14));
        envelope.weight[k] = Frama_C_unsigned_int_interval(1, N);
    }
}

int main(void)
{
    kelly_band band;

    kelly_envelope_clear(&envelope);
    (void)kelly_envelope_quantile(&envelope, R(0.5));
    kelly_envelope_read(&envelope, &band);
    any_envelope(Frama_C_unsigned_int_interval(0, KELLY_CLUSTERS - 1));
    (void)kelly_envelope_add(&envelope, any_real(-ANY_REAL, ANY_REAL));
    any_envelope(KELLY_CLUSTERS);
    (void)kelly_envelope_add(&envelope, any_real(-ANY_REAL, ANY_REAL));
    //@ assert envelope.used <= KELLY_CLUSTERS;
    any_envelope(Frama_C_unsigned_int_interval(1, KELLY_CLUSTERS));
    (void)kelly_envelope_quantile(&envelope, any_real(0, R(1.0)));
    kelly_envelope_read(&envelope, &band);
    return 0;
}
