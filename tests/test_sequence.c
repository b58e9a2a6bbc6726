/* test_sequence.c - the confidence sequence: its bounds against exact ones, and how often it misses P at any n. */
#include "check.h"
#include "fixture.h"

/* Exact bounds at alpha = 0.05: the p at which Beta(k + 1/2, n - k + 1/2) / (pi p^k (1-p)^(n-k)) is 20 (mpmath, 40 digits). */
static const struct {
    uint32_t k, n;
    float lo, hi;
} exact[] = {
    { 0, 1, 0.0f, 0.975f },
    { 1, 1, 0.025f, 1.0f },
    { 1, 2, 0.00628955855f, 0.993710441f },
    { 0, 10, 0.0f, 0.376987351f },
    { 1, 10, 0.000465624074f, 0.544008676f },
    { 3, 17, 0.0162885487f, 0.534398644f },
    { 5, 10, 0.117562924f, 0.882437076f },
    { 0, 1000, 0.0f, 0.00699750252f },
    { 10, 1000, 0.00240646828f, 0.0261644304f },
    { 493, 1000, 0.435486069f, 0.550638045f },
    { 990, 1000, 0.97383557f, 0.997593532f },
    { 5000, 10000, 0.480225526f, 0.519774474f },
    { 100, 100000, 0.000633981496f, 0.00148524774f },
    { 420000, 1000000, 0.417779609f, 0.422222552f },
    { 3, 10000000, 2.57948513e-09f, 1.99831973e-06f },
};

/* On the safe side, by less than what the header says: 0.005 of the bound on n KL, which is 4 at least. */
static void has_exact_bounds(void)
{
    for (unsigned i = 0; i < sizeof(exact) / sizeof(exact[0]); i++) {
        const float p = (float)exact[i].k / (float)exact[i].n;
        const float lo = kelly_sequence_lo(exact[i].k, exact[i].n, 0.05f), hi = kelly_sequence_hi(exact[i].k, exact[i].n, 0.05f);

        CHECK(lo <= exact[i].lo + 1e-6f && exact[i].lo - lo <= 1e-6f + 0.002f * (p - exact[i].lo));
        CHECK(hi >= exact[i].hi - 1e-6f && hi - exact[i].hi <= 1e-6f + 0.002f * (exact[i].hi - p));
    }
    CHECK(kelly_sequence_lo(0, 0, 0.05f) == 0.0f && kelly_sequence_hi(0, 0, 0.05f) == 1.0f);
    CHECK(kelly_sequence_lo(0, 50, 0.05f) == 0.0f && kelly_sequence_hi(50, 50, 0.05f) == 1.0f);
    CHECK(kelly_sequence_lo(999999999, 1000000000, 0.05f) < 1.0f);       /* the ratio rounds to 1: no infinity may come of it */
    CHECK(kelly_sequence_hi(1, 1000000000, 0.05f) > 0.0f);
    CLOSE(kelly_sequence_lo(7, 50, 0.05f), 1.0f - kelly_sequence_hi(43, 50, 0.05f), 1e-7);
}

/* At any confidence wider than Clopper and Pearson's, which holds at one n only. */
static void is_wider_than_at_one_n(void)
{
    for (uint32_t n = 1; n < 3000; n = 2 * n + 3) {
        for (uint32_t k = 0; k <= n; k += 1 + n / 7) {
            CHECK((wide)kelly_sequence_lo(k, n, 0.05f) <= kelly_binomial_lo(k, n, W(0.025)) + W(1e-6));
            CHECK((wide)kelly_sequence_hi(k, n, 0.05f) >= kelly_binomial_hi(k, n, W(0.025)) - W(1e-6));
        }
    }
}

/* One stream of realisations that stick with probability p: whether p ever lay outside, up to n, and where the rule stops. */
typedef struct {
    int ever, at_end, at_stop;   /* outside: at any n of the sequence, at the last one, where the rule stops */
    int fixed_ever;              /* outside at any n of the interval for one n */
    uint32_t stopped;
} story;

static story follow(uint32_t repetition, float p, uint32_t n, const kelly_stop_rule *rule, int fixed)
{
    kelly_tally tally = { 0 };
    kelly_rng rng;
    story s = { 0 };

    kelly_rng_key(&rng, 2026, repetition, 77);
    for (uint32_t i = 1; i <= n; i++) {
        float lo, hi;

        tally.samples++;
        tally.stuck += kelly_open01(kelly_rng_next(&rng)) < p;
        if (fixed) {
            s.fixed_ever |= kelly_binomial_lo(tally.stuck, i, W(0.025)) > (wide)p || kelly_binomial_hi(tally.stuck, i, W(0.025)) < (wide)p;
        }
        if (kelly_sequence_look(rule, &tally, &lo, &hi) != KELLY_GO_ON && s.stopped == 0) {
            s.stopped = i;
            s.at_stop = p < lo || p > hi;
        }
        s.at_end = p < lo || p > hi;
        s.ever |= s.at_end;
    }
    return s;
}

/* 1000 repetitions a probability on the host, looked at after every realisation. The bound is 5 %; 50 of 1000 plus three standard
 * errors is 71, and a sequence that is not far too wide misses some at P = 1/2. */
static void covers_at_all_n(void)
{
    static const float p[] = { 0.01f, 0.5f, 0.99f };
    const uint32_t repetitions = BY_LENGTH(2, 1000), n = BY_LENGTH(40, 2000);
    const kelly_stop_rule rule = { .alpha = 0.05f, .width = 0.12f };

    for (unsigned c = 0; c < 3; c++) {
        uint32_t ever = 0, at_end = 0, at_stop = 0, stopped = 0;

        for (uint32_t r = 0; r < repetitions; r++) {
            const story s = follow(r, p[c], n, &rule, 0);

            ever += (uint32_t)s.ever;
            at_end += (uint32_t)s.at_end;
            at_stop += (uint32_t)s.at_stop;
            stopped += s.stopped > 0;
        }
        CHECK(ever <= repetitions / 20);
        CHECK(at_end <= ever && at_stop <= ever);
#if CHECK_LONG
        EQUAL(stopped, repetitions);                       /* n is enough for the width */
        CHECK(c != 1 || ever > 0);
        check_text("  P ");
        check_number((wide)p[c]);
        check_text(": outside at any n of 1..2000 ");
        check_decimal(ever);
        check_text(", at the stop ");
        check_decimal(at_stop);
        check_text(" of 1000\n");
#endif
    }
}

/* What the sequence is there for: an interval for one n, looked at after every realisation, misses far more often than it says. */
static void replaces_what_does_not_cover(void)
{
#if CHECK_LONG
    const kelly_stop_rule rule = { .alpha = 0.05f };
    uint32_t misses = 0;

    for (uint32_t r = 0; r < 100; r++) {
        misses += (uint32_t)follow(r, 0.5f, 500, &rule, 1).fixed_ever;
    }
    CHECK(misses > 15);
#endif
}

/* Float in both builds, and nothing but + - * / and own logarithms: the bits are the same on every machine. */
static void has_the_same_bits_everywhere(void)
{
    const kelly_stop_rule rule = { .alpha = 0.05f, .width = 0.35f };
    uint32_t mix = 0;

    for (uint32_t n = 1; n < 4000000u; n = 3 * n + 1) {
        const union { float x; uint32_t bits; } u = { .x = kelly_sequence_lo((n + 2) / 3, n, 0.05f) };

        mix = mix * 31u + u.bits;
    }
    EQUAL(mix, 0x7258c5afu);
    EQUAL(follow(5, 0.3f, 150, &rule, 0).stopped, 71);
}

static kelly_tally tally_of(uint32_t stuck, uint32_t samples, uint32_t refused)
{
    return (kelly_tally){ .samples = samples, .stuck = stuck, .status = { samples - refused, refused, 0, 0 } };
}

static void stops_when_asked(void)
{
    float lo, hi, lo2, hi2;
    kelly_tally t = tally_of(60, 100, 0);

    EQUAL(kelly_sequence_look(&(kelly_stop_rule){ .alpha = 0.05f }, &t, &lo, &hi), KELLY_GO_ON);
    CHECK(lo < 0.5f && hi > 0.6f);
    EQUAL(kelly_sequence_look(&(kelly_stop_rule){ .alpha = 0.05f, .width = hi - lo }, &t, &lo2, &hi2), KELLY_NARROW);
    EQUAL(kelly_sequence_look(&(kelly_stop_rule){ .alpha = 0.05f, .width = 0.99f * (hi - lo) }, &t, &lo2, &hi2), KELLY_GO_ON);
    EQUAL(kelly_sequence_look(&(kelly_stop_rule){ .alpha = 0.05f, .level = 0.5f }, &t, &lo2, &hi2), KELLY_GO_ON);
    EQUAL(kelly_sequence_look(&(kelly_stop_rule){ .alpha = 0.05f, .level = 0.99f * lo }, &t, &lo2, &hi2), KELLY_DECIDED);
    EQUAL(kelly_sequence_look(&(kelly_stop_rule){ .alpha = 0.05f, .level = 1.01f * hi }, &t, &lo2, &hi2), KELLY_DECIDED);
    t = tally_of(60, 100, 10);                             /* the refused: free below, stuck above */
    (void)kelly_sequence_look(&(kelly_stop_rule){ .alpha = 0.05f }, &t, &lo2, &hi2);
    CHECK(lo2 == lo && hi2 == kelly_sequence_hi(70, 100, 0.05f) && hi2 > hi);
}

void test_sequence(void);
void test_sequence(void)
{
    has_exact_bounds();
    is_wider_than_at_one_n();
    covers_at_all_n();
    replaces_what_does_not_cover();
    has_the_same_bits_everywhere();
    stops_when_asked();
}
