/* test_envelope.c - moments and quantiles of a stream: exact while they fit, and within a share of the sampling error after. */
#include "check.h"
#include "fixture.h"

static kelly_envelope envelope;
static kelly_band band;

/* 0, 1 / n, 2 / n, ... in an order without a pattern: i -> i step mod n, step and n without a common factor. */
static void add_grid(uint32_t n, uint32_t step, real scale)
{
    int taken = 0;

    kelly_envelope_clear(&envelope);
    for (uint32_t i = 0; i < n; i++) {
        taken += kelly_envelope_add(&envelope, scale * ((real)((uint32_t)((uint64_t)i * step % n)) / (real)n));
    }
    CHECK(taken == (int)n);
    kelly_envelope_read(&envelope, &band);
}

static void nothing_is_zero(void)
{
    kelly_envelope_clear(&envelope);
    kelly_envelope_read(&envelope, &band);
    CHECK(band.mean == 0 && band.sd == 0 && band.low == 0 && band.median == 0 && band.high == 0);
    CHECK(kelly_envelope_quantile(&envelope, R(0.5)) == 0);
}

/* 3 1 4 1 5 9 2 6: numpy.quantile (0.025, 0.5, 0.975) is 1, 3.5, 8.475; mean 3.875, std 2.5708705. */
static void few_values_are_exact(void)
{
    static const real digits[8] = { 3, 1, 4, 1, 5, 9, 2, 6 };

    kelly_envelope_clear(&envelope);
    for (unsigned i = 0; i < 8; i++) {
        CHECK(kelly_envelope_add(&envelope, digits[i]));
    }
    kelly_envelope_read(&envelope, &band);
    CLOSE(band.low, 1, W(1e-6));
    CLOSE(band.median, W(3.5), W(1e-6));
    CLOSE(band.high, W(8.475), W(1e-5));
    CLOSE(band.mean, W(3.875), W(1e-6));
    CLOSE(band.sd, W(2.5708704751503917), W(1e-6));
    CLOSE(kelly_envelope_quantile(&envelope, 0), 1, 0);
    CLOSE(kelly_envelope_quantile(&envelope, 1), 9, 0);
}

static void full_is_still_exact(void)
{
    add_grid(KELLY_CLUSTERS, 37, KELLY_CLUSTERS);
    EQUAL(envelope.used, KELLY_CLUSTERS);
    CLOSE(band.low, W(0.025) * (KELLY_CLUSTERS - 1), W(1e-4));
    CLOSE(band.median, W(0.5) * (KELLY_CLUSTERS - 1), W(1e-4));
    CLOSE(band.high, W(0.975) * (KELLY_CLUSTERS - 1), W(1e-4));
}

static void refuses_what_is_no_number(void)
{
    real huge = R(1e30);

    add_grid(5, 2, 1);
    for (int k = 0; k < 5; k++) {
        huge *= huge;                                      /* infinite, in double as well */
    }
    CHECK(!kelly_envelope_add(&envelope, R(2e18)));
    CHECK(!kelly_envelope_add(&envelope, R(1e14)) && !kelly_envelope_add(&envelope, R(-1e14)));
    CHECK(!kelly_envelope_add(&envelope, huge));
    CHECK(!kelly_envelope_add(&envelope, -huge));
    CHECK(!kelly_envelope_add(&envelope, huge - huge));    /* not a number */
    EQUAL(envelope.n, 5);
    envelope.n = 16777216;                                 /* as many as are counted */
    CHECK(!kelly_envelope_add(&envelope, R(0.5)));
    EQUAL(envelope.n, 16777216);
    EQUAL(envelope.used, 5);
    kelly_envelope_clear(&envelope);
    EQUAL(kelly_envelope_add(&envelope, R(1e14) - R(0.5)), sizeof(real) > sizeof(float));      /* in float that is 1e14 */
}

/* 2^24 of the largest values that are taken, on both sides of 0, have a finite spread. */
static void takes_what_it_can_square(void)
{
    const real taken = R(9.9e13), beyond[3] = { R(1e14), R(1.1e14), R(9e17) };

    add_grid(5, 2, 1);
    for (unsigned i = 0; i < 3; i++) {
        CHECK(!kelly_envelope_add(&envelope, beyond[i]));
        CHECK(!kelly_envelope_add(&envelope, -beyond[i]));
    }
    EQUAL(envelope.n, 5);
    kelly_envelope_clear(&envelope);
    CHECK(kelly_envelope_add(&envelope, taken));
    CHECK(kelly_envelope_add(&envelope, -taken));
    envelope.n *= 8388607u;                                /* as if each had come so often, all but two of 2^24 */
    envelope.m2 *= R(8388607.0);
    CHECK(kelly_envelope_add(&envelope, taken));
    CHECK(kelly_envelope_add(&envelope, -taken));
    EQUAL(envelope.n, 16777216);
    kelly_envelope_read(&envelope, &band);
    CLOSE(band.sd, W(9.9e13), W(1e9));
}

/* Random values, a third of them within 1e-3 of 0 and the rest spread as 250 u^2: a bit that sticks. Its exact quantiles
 * over all u are known: the error of the estimate, less that of the sample, is a rank of some n. */
static real sticking(real u)
{
    return u < R(0.3333) ? R(1e-3) * u : R(250.0) * u * u;
}

static wide rank_of(wide value)
{
    wide lo = 0, hi = 1;

    for (int k = 0; k < 40; k++) {
        const wide u = W(0.5) * (lo + hi);

        if ((wide)sticking((real)u) < value) {
            lo = u;
        } else {
            hi = u;
        }
    }
    return lo;
}

/* A Weyl sequence covers [0, 1) so evenly that its own quantiles are exact to some 3 / n: what is left is the estimator's. */
static void error_is_a_share_of_the_sampling_error(void)
{
    const uint32_t n = BY_LENGTH(3000, 100000);
    const wide s_tail = W(0.1561) * (wide)kelly_sqrt32((float)n), s_middle = W(0.5) * (wide)kelly_sqrt32((float)n);
    uint32_t u = 0;
    int taken = 0;

    kelly_envelope_clear(&envelope);
    for (uint32_t i = 0; i < n; i++) {
        u += 2654435769u;
        taken += kelly_envelope_add(&envelope, sticking((real)(u >> 8) / R(16777216.0)));
    }
    CHECK(taken == (int)n);
    kelly_envelope_read(&envelope, &band);
    EQUAL(envelope.n, n);
    CHECK(envelope.used <= KELLY_CLUSTERS);
    CLOSE(rank_of((wide)band.low) * (wide)n, W(0.025) * (wide)n, s_tail);
    CLOSE(rank_of((wide)band.median) * (wide)n, W(0.5) * (wide)n, s_middle);
    CLOSE(rank_of((wide)band.high) * (wide)n, W(0.975) * (wide)n, s_tail);
}

static void add_sorted(uint32_t n, int down)
{
    int taken = 0;

    kelly_envelope_clear(&envelope);
    for (uint32_t i = 0; i < n; i++) {
        const real u = (real)(down ? n - 1 - i : i) / (real)n;

        taken += kelly_envelope_add(&envelope, sticking(u));
    }
    CHECK(taken == (int)n);
    kelly_envelope_read(&envelope, &band);
}

/* Sorted streams are not what it is made for: clusters stay within n / 32, and so does the rank. */
static void sorted_streams_stay_bounded(void)
{
    for (int down = 0; down < 2; down++) {
        add_sorted(BY_LENGTH(3000, 100000), down);
        CLOSE(rank_of((wide)band.low), W(0.025), W(0.005));
        CLOSE(rank_of((wide)band.median), W(0.5), W(0.005));
        CLOSE(rank_of((wide)band.high), W(0.975), W(0.005));
    }
}

/* Weights add up to n, values ascend, whatever came. */
static void clusters_are_sound(void)
{
    uint32_t sum = 0;

    add_grid(4999, 1237, 7);
    for (uint32_t i = 0; i < envelope.used; i++) {
        sum += envelope.weight[i];
        CHECK(envelope.weight[i] > 0);
        CHECK(i == 0 || envelope.value[i - 1] <= envelope.value[i]);
    }
    EQUAL(sum, 4999);
    CHECK(kelly_envelope_quantile(&envelope, 0) == envelope.value[0]);
    CHECK(kelly_envelope_quantile(&envelope, 1) == envelope.value[envelope.used - 1]);
    CLOSE(band.mean, W(7.0) * W(2499.0) / W(4999.0), W(1e-4));
    CLOSE(band.sd, W(7.0) * W(0.2886751288), W(1e-4));     /* sqrt((1 - 1 / n^2) / 12) */
}

void test_envelope(void);
void test_envelope(void)
{
    nothing_is_zero();
    few_values_are_exact();
    full_is_still_exact();
    refuses_what_is_no_number();
    takes_what_it_can_square();
    error_is_a_share_of_the_sampling_error();
    sorted_streams_stay_bounded();
    clusters_are_sound();
}
