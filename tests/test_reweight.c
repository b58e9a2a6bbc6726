/* test_reweight.c - other laws from the same realisations: weights, effective size, and what must not be believed. */
#include "check.h"
#include "fixture.h"

static kelly_reweight sums;
static kelly_reweighted result;

/* One random parameter (mu, in units of its mean) with cov 0.2, unless said otherwise. */
static kelly_laws laws_of(wide mean, wide cov)
{
    return (kelly_laws){ .mean = { 1, mean, 1, 1, 1 }, .cov = { 0, cov, 0, 0, 0 } };
}

/* n draws of mu under mean 1, cov 0.2; sticks where it is above `limit`, refused where it is above `end`. */
static void reweight(const kelly_laws *to, uint64_t seed, uint32_t n, float limit, float end)
{
    const kelly_laws from = laws_of(1, W(0.2));

    kelly_reweight_start(&sums, &from, to);
    for (uint32_t j = 0; j < n; j++) {
        kelly_rng rng;

        kelly_rng_key(&rng, seed, j, 1);
        const float x = kelly_gamma(&rng, 1.0f, 0.2f);
        const wide y[KELLY_PARAMETERS] = { 1, (wide)x, 1, 1, 1 };

        kelly_reweight_add(&sums, y, x > end ? KELLY_STEP : KELLY_OK, x > limit && x <= end);
    }
    kelly_reweight_read(&sums, &result);
}

/* Nothing changed: Clopper and Pearson's interval of the plain counts. */
static void same_laws_change_nothing(void)
{
    const kelly_laws same = laws_of(1, W(0.2));
    uint32_t k = 0;

    for (uint32_t j = 0; j < 200; j++) {
        kelly_rng rng;

        kelly_rng_key(&rng, 4, j, 1);
        k += kelly_gamma(&rng, 1.0f, 0.2f) > 1.1f;
    }
    reweight(&same, 4, 200, 1.1f, 9.0f);
    CHECK(result.enough);
    CLOSE(result.ess, 200, 0);
    CLOSE(result.ess_predicted, 200, 0);
    CLOSE(result.probability, (wide)k / 200, 1e-7);
    CLOSE(result.lo, kelly_binomial_lo(k, 200, W(0.025)), 1e-7);
    CLOSE(result.hi, kelly_binomial_hi(k, 200, W(0.025)), 1e-7);
}

/* P(mu > 1.1) of gamma laws, and n / E(w^2), by scipy: gamma.sf, quad of pdf^2 / pdf. */
static const struct {
    wide mean, cov, p, square;
} other[] = {
    { W(1.05), W(0.2), W(0.381750086), W(1.06457776) },
    { W(0.95), W(0.2), W(0.206886974), W(1.06457776) },
    { W(1.0), W(0.15), W(0.24343978), W(1.11306434) },
    { W(1.0), W(0.22), W(0.303959003), W(1.0231877) },
    { W(1.1), W(0.18), W(0.476059468), W(1.25230398) },
    { W(1.0), W(0.05), W(0.0253799624), W(2.88238805) },
    { W(0.85), W(0.18), W(0.0599286438), W(1.66677455) },
};

/* Within four standard errors of an estimate with 20000 draws (boards: of 400), and the ess within a tenth. */
static void finds_other_laws(void)
{
    const uint32_t n = BY_LENGTH(400, 20000);

    for (unsigned i = 0; i < sizeof(other) / sizeof(other[0]); i++) {
        const kelly_laws to = laws_of(other[i].mean, other[i].cov);
        const wide p = other[i].p;

        reweight(&to, 8, n, 1.1f, 9.0f);
        CHECK(result.enough);
        CLOSE(result.ess_predicted * other[i].square / (wide)n, 1, BY_REAL(2e-3, 1e-6));
        CLOSE(result.ess / result.ess_predicted, 1, BY_LENGTH(0.4, 0.1));
        CHECK((result.probability - p) * (result.probability - p) < 16 * p * (1 - p) / result.ess_predicted);
        CHECK(result.lo < result.probability && result.probability < result.hi);
    }
}

/* Weights know no units: in 1/256 of them every number is the same. */
static void does_not_mind_units(void)
{
    const wide unit = W(0.00390625);
    const kelly_laws from = laws_of(unit, W(0.2)), to = laws_of(unit * W(1.0625), W(0.18));
    kelly_reweighted want;

    reweight(&(kelly_laws){ .mean = { 1, W(1.0625), 1, 1, 1 }, .cov = { 0, W(0.18), 0, 0, 0 } }, 8, 200, 1.1f, 9.0f);
    want = result;
    kelly_reweight_start(&sums, &from, &to);
    for (uint32_t j = 0; j < 200; j++) {
        kelly_rng rng;

        kelly_rng_key(&rng, 8, j, 1);
        const float x = kelly_gamma(&rng, 1.0f, 0.2f);
        const wide y[KELLY_PARAMETERS] = { 1, (wide)x * unit, 1, 1, 1 };

        kelly_reweight_add(&sums, y, KELLY_OK, x > 1.1f);
    }
    kelly_reweight_read(&sums, &result);
    CLOSE(result.probability, want.probability, W(1e-6));
    CLOSE(result.ess / want.ess, 1, W(1e-6));
}

/* 1000 repetitions of 800: intervals hold the true P in 95 % at least (four standard errors below it are 92.2 %). */
static void intervals_cover(void)
{
#if CHECK_LONG
    for (unsigned i = 0; i < sizeof(other) / sizeof(other[0]); i++) {
        const kelly_laws to = laws_of(other[i].mean, other[i].cov);
        unsigned held = 0;

        for (uint32_t r = 0; r < 1000; r++) {
            reweight(&to, 100 + r, 800, 1.1f, 9.0f);
            held += result.lo <= other[i].p && other[i].p <= result.hi;
        }
        check_text("  mean ");
        check_number(other[i].mean);
        check_text(", cov ");
        check_number(other[i].cov);
        check_text(": ");
        check_decimal(held);
        check_text(" of 1000 intervals hold P\n");
        CHECK(held >= 930);
    }
#endif
}

/* A spread of 0.3 for one of 0.2 gives weights without a variance: the sample's own size looks large and means nothing. */
static void refuses_what_reaches_too_far(void)
{
    const kelly_laws wide_law = laws_of(1, W(0.3)), far = laws_of(W(1.6), W(0.2)), heavy = laws_of(W(2.1), W(0.2));

    reweight(&wide_law, 8, 4000, 1.1f, 9.0f);
    CHECK(result.ess > 100 && result.ess_predicted == 0 && !result.enough);
    reweight(&far, 8, 4000, 1.1f, 9.0f);
    CHECK(result.ess_predicted < 100 && !result.enough);
    reweight(&heavy, 8, 4000, 1.1f, 9.0f);
    CHECK(result.ess_predicted == 0 && result.lo <= result.probability && result.probability <= result.hi && !result.enough);
    reweight(&(kelly_laws){ .mean = { 1, 1, 1, 1, 1 }, .cov = { 0, W(0.2), 0, 0, 0 } }, 8, 99, 1.1f, 9.0f);
    CHECK(!result.enough);
    kelly_reweight_start(&sums, &far, &far);
    kelly_reweight_read(&sums, &result);
    CHECK(!result.enough && result.lo == 0 && result.hi == 1);
}

/* Laws that leave a variance in each parameter but too much in all together, or none in two of them: no size is enough. */
static void refuses_what_all_make_too_wide(void)
{
    const kelly_laws from = { .mean = { 1, 1, 1, 1, 1 }, .cov = { W(0.05), W(0.05), W(0.05), W(0.05), W(0.05) } };
    kelly_laws to = from;

    to.mean[0] = W(0.4);
    kelly_reweight_start(&sums, &from, &to);
    CHECK((sums.square > 0) == (sizeof(wide) > sizeof(float)));        /* e^179: more than a float holds */
    for (unsigned k = 0; k < KELLY_PARAMETERS; k++) {
        to.mean[k] = W(0.4);
    }
    kelly_reweight_start(&sums, &from, &to);
    CHECK(sums.square == 0);
    to = from;
    to.mean[0] = to.mean[1] = 3;
    kelly_reweight_start(&sums, &from, &to);
    CHECK(sums.square == 0);
}

/* cov 1/2 to 1/4 at four times the mean: the rates are equal, and the weight is y^12. Of 1 and 2^(1/12), P is two thirds. */
static void weighs_by_a_power_where_rates_are_equal(void)
{
    const kelly_laws from = laws_of(1, W(0.5)), to = laws_of(4, W(0.25));
    const wide one[KELLY_PARAMETERS] = { 1, 1, 1, 1, 1 }, two[KELLY_PARAMETERS] = { 1, W(1.0594630943592953), 1, 1, 1 };

    kelly_reweight_start(&sums, &from, &to);
    kelly_reweight_add(&sums, one, KELLY_OK, 0);
    kelly_reweight_add(&sums, two, KELLY_OK, 1);
    kelly_reweight_read(&sums, &result);
    CLOSE(result.probability, W(2.0) / 3, BY_REAL(1e-5, 1e-14));
    CLOSE(result.share, W(2.0) / 3, BY_REAL(1e-5, 1e-14));
    CLOSE(result.ess, W(9.0) / 5, BY_REAL(1e-5, 1e-14));
}

/* 50 of weight 2 that stick and 900 of weight 1 that do not: P = 0.1, sum w^2 (z - P)^2 = 171, P (1 - P) (sum w)^2 / 171 = 526.3, which is
 * less than ess = 909. The interval is that of 52 of 526 below and 53 above: P n = 52.6, rounded outwards. */
static void counts_for_less_where_the_heavy_ones_stick(void)
{
    const kelly_laws from = laws_of(1, W(0.5)), to = laws_of(4, W(0.25));
    const wide one[KELLY_PARAMETERS] = { 1, 1, 1, 1, 1 }, two[KELLY_PARAMETERS] = { 1, W(1.0594630943592953), 1, 1, 1 };

    kelly_reweight_start(&sums, &from, &to);
    for (unsigned j = 0; j < 950; j++) {
        kelly_reweight_add(&sums, j < 50 ? two : one, KELLY_OK, j < 50);
    }
    kelly_reweight_read(&sums, &result);
    CLOSE(result.probability, W(0.1), BY_REAL(1e-5, 1e-13));
    CLOSE(result.ess, W(10000.0) / 11, BY_REAL(1e-2, 1e-9));
    CLOSE(result.lo, kelly_binomial_lo(52, 526, W(0.025)), BY_REAL(1e-6, 1e-12));
    CLOSE(result.hi, kelly_binomial_hi(53, 526, W(0.025)), BY_REAL(1e-6, 1e-12));
}

/* 1000 realisations of weight 1 and one of e^4.17 = 64.5: its share is 6 %, and both sizes are in hundreds. */
static void refuses_what_one_realisation_decides(void)
{
    const kelly_laws from = laws_of(1, W(0.2)), to = laws_of(W(1.05), W(0.2));
    const wide one[KELLY_PARAMETERS] = { 1, 1, 1, 1, 1 };
    wide heavy[KELLY_PARAMETERS] = { 1, W(4.5), 1, 1, 1 };

    kelly_reweight_start(&sums, &from, &to);
    for (unsigned j = 0; j < 1000; j++) {
        kelly_reweight_add(&sums, one, KELLY_OK, j & 1);
    }
    kelly_reweight_read(&sums, &result);
    CHECK(result.enough && result.probability == W(0.5));
    kelly_reweight_add(&sums, heavy, KELLY_OK, 0);
    kelly_reweight_read(&sums, &result);
    CHECK(result.ess > 200 && result.ess_predicted > 900 && result.share > W(0.06) && result.share < W(0.061) && !result.enough);
    heavy[1] = 90;                                         /* so heavy that the others weigh nothing */
    kelly_reweight_add(&sums, heavy, KELLY_STEP, 0);
    kelly_reweight_read(&sums, &result);
    CHECK(!result.enough && result.probability == 0 && result.lo == 0 && result.hi == 1);
}

/* Refused ones: free in lo, stuck in hi, and not in P. */
static void counts_the_refused_both_ways(void)
{
    const kelly_laws to = laws_of(W(1.05), W(0.19));
    wide lo;

    reweight(&to, 8, 2000, 1.2f, 9.0f);
    lo = result.lo;
    reweight(&to, 8, 2000, 1.2f, 1.3f);
    CHECK(result.lo < lo && result.hi - result.probability > W(0.1));
    reweight(&to, 8, 2000, 9.0f, 9.5f);
    CHECK(result.probability == 0 && result.lo == 0 && result.hi > 0 && result.hi < W(0.01));
    reweight(&to, 8, 2000, 0.0f, 9.0f);
    CHECK(result.probability == 1 && result.hi == 1 && result.lo < 1 && result.lo > W(0.99));
    reweight(&to, 8, 200, 0.0f, 0.0f);
    CHECK(!result.enough);
}

static void says_what_fits(void)
{
    const kelly_laws from = laws_of(1, W(0.2));
    kelly_laws to = from;

    EQUAL(kelly_law_fits(&from, &to, 0), KELLY_LAW_FITS);
    EQUAL(kelly_law_fits(&from, &to, 1), KELLY_LAW_FITS);
    to.mean[0] = W(1.1);
    to.cov[1] = 0;
    to.cov[2] = W(0.1);
    EQUAL(kelly_law_fits(&from, &to, 0), KELLY_LAW_FIXED);
    EQUAL(kelly_law_fits(&from, &to, 1), KELLY_LAW_POINT);
    EQUAL(kelly_law_fits(&from, &to, 2), KELLY_LAW_FIXED);
}

void test_reweight(void);
void test_reweight(void)
{
    same_laws_change_nothing();
    finds_other_laws();
    does_not_mind_units();
    intervals_cover();
    refuses_what_reaches_too_far();
    refuses_what_all_make_too_wide();
    weighs_by_a_power_where_rates_are_equal();
    counts_for_less_where_the_heavy_ones_stick();
    refuses_what_one_realisation_decides();
    counts_the_refused_both_ways();
    says_what_fits();
}
