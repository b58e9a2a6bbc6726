/* Counts, intervals, weights and indices: any counts, any finite values of the documented ranges. envelope.c has the quantiles. */
#include "ensemble.h"
#include "reweight.h"
#include "sequence.h"
#include "severity.h"
#include "sobol.h"
#include "tally.h"
#include "contracts.h"

static real any_speed(void) { return any_real(R(-1e6), R(1e6)); }

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

/* Sums of up to 2^24 rows of |f| <= 1e6. */
static void indices(void)
{
    static kelly_sobol sobol;
    kelly_estimate first, total;
    kelly_case run;
    unsigned which[KELLY_PARAMETERS];
    wide f[KELLY_SOBOL_ROW], mean, variance;

    for (unsigned k = 0; k < KELLY_PARAMETERS; k++) {
        run.cov[k] = Frama_C_float_interval(0, 0.5f);
    }
    (void)kelly_sobol_random(&run, which);
    kelly_sobol_clear(&sobol, KELLY_PARAMETERS);
    for (unsigned k = 0; k < KELLY_SOBOL_ROW; k++) {
        f[k] = Frama_C_double_interval(-1e6, 1e6);
    }
    kelly_sobol_add(&sobol, f);
    sobol.rows = Frama_C_unsigned_int_interval(0, 1u << 24);
    sobol.origin = Frama_C_double_interval(-1e6, 1e6);
    for (unsigned g = 0; g < KELLY_SOBOL_GROUPS; g++) {
        sobol.group[g].n = Frama_C_unsigned_int_interval(2, 1u << 19);
        sobol.group[g].ab = Frama_C_double_interval(-1e13, 1e13);
        sobol.group[g].aabb = Frama_C_double_interval(0, 1e19);
        for (unsigned k = 0; k < KELLY_PARAMETERS; k++) {
            sobol.group[g].d[k] = Frama_C_double_interval(-1e13, 1e13);
            sobol.group[g].bd[k] = Frama_C_double_interval(-1e19, 1e19);
            sobol.group[g].dd[k] = Frama_C_double_interval(0, 1e19);
        }
    }
    kelly_sobol_add(&sobol, f);
    kelly_sobol_moments(&sobol, &mean, &variance);
    (void)kelly_sobol_read(&sobol, Frama_C_unsigned_int_interval(0, KELLY_PARAMETERS - 1), &first, &total);
}

int main(void)
{
    severity();
    counts();
    indices();
    return 0;
}
