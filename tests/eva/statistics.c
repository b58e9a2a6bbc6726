/* Severity and counts: any counts, any finite values of the documented ranges. */
#include "severity.h"
#include "tally.h"
#include "contracts.h"

static real any_speed(void) { return any_real(R(-1e8), R(1e8)); }

static void severity(void)
{
    (void)kelly_severity(any_speed(), any_speed());
    (void)kelly_ssi(any_speed(), any_speed(), any_speed());
}

static kelly_tally tally;

static void any_tally(void)
{
    tally.samples = any_u32();
    tally.stuck = any_u32();
    tally.liftoff = any_u32();
    for (unsigned k = 0; k < KELLY_STATUSES; k++) {
        tally.status[k] = any_u32();
    }
    tally.digest = any_u32();
}

static void counts(void)
{
    kelly_result result;

    any_tally();
    result.draw.fc = result.draw.mu = result.draw.a1 = result.draw.a2 = result.draw.w0 = any_real(0, R(1e35));
    result.lowest = any_speed();
    result.highest = any_speed();
    result.mean = any_real(-ANY_REAL, ANY_REAL);
    result.ss = any_real(0, R(1e30));
    result.status = Frama_C_unsigned_char_interval(0, KELLY_STATUSES - 1);
    result.stuck = Frama_C_unsigned_char_interval(0, 1);
    result.liftoff = Frama_C_unsigned_char_interval(0, 1);
    kelly_tally_add(&tally, any_u32(), &result);
    (void)kelly_probability(&tally);
    (void)kelly_refused(&tally);
}

int main(void)
{
    severity();
    counts();
    return 0;
}
