/* reweight.h: any laws, any realisations, sums that such realisations can have made. */
#include "reweight.h"
#include "contracts.h"

#define SUM 1e12                         /* of 2^32 weights, each in units of the largest */

static kelly_laws from, to;
static kelly_reweight sums;

wide kelly_binomial_lo(uint32_t k, uint32_t n, wide tail) { (void)k, (void)n, (void)tail; return Frama_C_double_interval(0, 1); }
wide kelly_binomial_hi(uint32_t k, uint32_t n, wide tail) { (void)k, (void)n, (void)tail; return Frama_C_double_interval(0, 1); }

/* interval.c */
wide kelly_stirling(wide n)
{
    //@ assert 1e-300 <= n <= 1e300;
    return Frama_C_double_interval(-1e6, 1e6);
}

static void any_laws(kelly_laws *laws, int random)
{
    for (unsigned k = 0; k < KELLY_PARAMETERS; k++) {
        laws->mean[k] = Frama_C_double_interval(1e-30, 1e30);
        laws->cov[k] = random ? Frama_C_double_interval(1e-4, 0.5) : 0;
    }
}

static wide any_sum(void) { return Frama_C_double_interval(0, SUM); }

static void any_sums(void)
{
    for (unsigned k = 0; k < KELLY_PARAMETERS; k++) {
        sums.mean[k] = Frama_C_double_interval(1e-30, 1e30);
        sums.slope[k] = Frama_C_double_interval(-1e9, 1e9);
        sums.rate[k] = Frama_C_double_interval(-1e70, 1e70);
    }
    sums.square = Frama_C_double_interval(0, 1.2e308);
    sums.top = Frama_C_double_interval(-1e140, 1e140);
    sums.w = Frama_C_double_interval(0.25, SUM);             /* the largest is 1 */
    sums.ww = Frama_C_double_interval(0.25, SUM);
    sums.stuck = any_sum();
    sums.stuck2 = any_sum();
    sums.refused = any_sum();
    sums.n = Frama_C_unsigned_int_interval(0, UINT32_MAX);
    sums.refused_n = any_u32();
}

int main(void)
{
    kelly_reweighted result;
    wide y[KELLY_PARAMETERS];

    //@ loop unroll 4;
    for (int random = 0; random < 4; random++) {
        any_laws(&from, random & 1);
        any_laws(&to, random >> 1);
        (void)kelly_law_fits(&from, &to, Frama_C_unsigned_int_interval(0, KELLY_PARAMETERS - 1));
    }
    kelly_reweight_start(&sums, &from, &to);             /* all of them random; none: */
    //@ assert 0 <= sums.square <= 1.3e308;
    any_laws(&from, 0);
    kelly_reweight_start(&sums, &from, &to);
    for (unsigned k = 0; k < KELLY_PARAMETERS; k++) {
        y[k] = Frama_C_double_interval(1e-36, 1e36);
    }
    any_sums();
    kelly_reweight_add(&sums, y, Frama_C_interval(0, KELLY_STATUSES - 1), Frama_C_interval(0, 1));
    any_sums();
    kelly_reweight_read(&sums, &result);
    return 0;
}
