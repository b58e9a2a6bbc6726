/* sobol.h: any case, any number of rows up to 2^24, any values up to 1e12; sums of which each is what such rows can have made it. */
#include "contracts.h"
#include "../../firmware/sobol.c"

#define VALUE 1e12                       /* |f| */
#define ROWS 16777216u

void kelly_draw_sample(const kelly_case *run, uint64_t seed, uint32_t index, kelly_draw *draw)
{
    (void)run, (void)seed, (void)index;
    draw->fc = draw->mu = draw->a1 = draw->a2 = draw->w0 = any_real(0, R(1e30));
}

static kelly_sobol sobol;

static wide any_sum(double most) { return Frama_C_double_interval(-most * ROWS, most * ROWS); }

static void any_sums(void)
{
    sobol.parameters = Frama_C_unsigned_int_interval(1, KELLY_PARAMETERS);
    sobol.rows = KELLY_SOBOL_GROUPS * Frama_C_unsigned_int_interval(0, ROWS / KELLY_SOBOL_GROUPS - 1);
    sobol.origin = Frama_C_double_interval(-VALUE, VALUE);
    for (unsigned k = 0; k < KELLY_SOBOL_GROUPS; k++) {
        kelly_sobol_sums *const g = &sobol.group[k];

        g->n = Frama_C_unsigned_int_interval(1, ROWS / KELLY_SOBOL_GROUPS);
        g->ab = any_sum(4 * VALUE);
        g->aabb = any_sum(8 * VALUE * VALUE);
        for (unsigned i = 0; i < KELLY_PARAMETERS; i++) {
            g->d[i] = any_sum(2 * VALUE);
            g->bd[i] = any_sum(4 * VALUE * VALUE);
            g->dd[i] = any_sum(4 * VALUE * VALUE);
        }
    }
}

int main(void)
{
    wide f[KELLY_SOBOL_ROW], mean, spread;
    unsigned which[KELLY_PARAMETERS], n;
    kelly_draw draws[KELLY_SOBOL_ROW];
    kelly_estimate first, total;
    kelly_case run;

    for (unsigned k = 0; k < KELLY_PARAMETERS; k++) {
        run.cov[k] = Frama_C_float_interval(0, 0.5f);
    }
    n = kelly_sobol_random(&run, which);
    //@ assert n <= KELLY_PARAMETERS;
    n = kelly_sobol_row(&run, any_u64(), any_u32(), draws);
    //@ assert 2 <= n <= KELLY_SOBOL_ROW;
    for (unsigned i = 0; i < KELLY_SOBOL_ROW; i++) {
        f[i] = Frama_C_double_interval(-VALUE, VALUE);
    }
    kelly_sobol_clear(&sobol, Frama_C_unsigned_int_interval(1, KELLY_PARAMETERS));
    kelly_sobol_moments(&sobol, &mean, &spread);
    any_sums();
    kelly_sobol_add(&sobol, f);              /* into the first group, as into any */
    any_sums();
    kelly_sobol_moments(&sobol, &mean, &spread);
    //@ loop unroll 5;
    for (unsigned k = 0; k < KELLY_PARAMETERS; k++) {
        (void)kelly_sobol_read(&sobol, k, &first, &total);
    }
    return 0;
}
