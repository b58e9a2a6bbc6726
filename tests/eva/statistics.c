/* Counts, intervals, quantiles, indices, weights: any counts, any finite values of the documented ranges. */
#include "envelope.h"
#include "ensemble.h"
#include "reweight.h"
#include "sequence.h"
#include "severity.h"
#include "sobol.h"
#include "tally.h"
#include "contracts.h"

#define SPEED 1e6f                       /* [rad/s] what kelly_block_sane lets pass */

static real speed(void) { return any_real(-SPEED, SPEED); }

static void severity(void)
{
    real lowest = speed(), highest = speed();
    real ss;

    if (lowest > highest) {
        const real other = lowest;

        lowest = highest;
        highest = other;
    }
    ss = kelly_severity(lowest, highest);
    ss = kelly_ssi(lowest, highest, speed());
    (void)ss;
}

static void tally(void)
{
    kelly_tally tally;
    kelly_result result;
    wide p;

    tally.samples = any_u32();
    tally.stuck = any_u32();
    tally.liftoff = any_u32();
    for (unsigned k = 0; k < KELLY_STATUSES; k++) {
        tally.status[k] = any_u32();
    }
    tally.digest = any_u32();
    result.draw.fc = result.draw.mu = result.draw.a1 = result.draw.a2 = result.draw.w0 = any_real(0, 1e30f);
    result.lowest = speed();
    result.highest = speed();
    result.mean = any_real(-ANY_REAL, ANY_REAL);
    result.ss = any_real(0, 1e30f);
    result.status = Frama_C_unsigned_char_interval(0, KELLY_STATUSES - 1);
    result.stuck = Frama_C_unsigned_char_interval(0, 1);
    result.liftoff = Frama_C_unsigned_char_interval(0, 1);
    kelly_tally_add(&tally, any_u32(), &result);
    p = kelly_probability(&tally);
    (void)p;
}

static void envelope(void)
{
    kelly_envelope e;
    kelly_band band;

    kelly_envelope_clear(&e);
    while (Frama_C_nondet(0, 1)) {
        (void)kelly_envelope_add(&e, any_real(-ANY_REAL, ANY_REAL));
    }
    (void)kelly_envelope_quantile(&e, any_real(0, 1));
    kelly_envelope_read(&e, &band);
}

int main(void)
{
    severity();
    tally();
    envelope();
    return 0;
}
