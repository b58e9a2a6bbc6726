/* test_tally.c - counts, digest and interval. */
#include "../firmware/link/crc32c.h"
#include "check.h"
#include "fixture.h"

static void crc_has_its_known_answer(void)
{
    const uint8_t digits[9] = { '1', '2', '3', '4', '5', '6', '7', '8', '9' };

    EQUAL(kelly_crc32c(0, digits, 9), 0xe3069283u);
    EQUAL(kelly_crc32c(kelly_crc32c(0, digits, 4), digits + 4, 5), 0xe3069283u);
    EQUAL(kelly_crc32c(0, digits, 0), 0);
}

/* 1.5, -2, ...: every byte of the record is known without knowing how it is made. */
static const kelly_result plain = { .draw = { R(1.5), R(2.0), R(-2.0), R(0.5), R(1.0) },
                                    .lowest = R(-1.0), .highest = R(3.0), .mean = R(0.25), .ss = R(10.0), .status = KELLY_OK, .stuck = 1 };

#ifdef KELLY_DOUBLE
#define TOP(high, low) 0, 0, 0, 0, 0, 0, low, high
#define HEADS { TOP(0x3f, 0xf8), TOP(0x40, 0x00), TOP(0xc0, 0x00), TOP(0x3f, 0xe0), TOP(0x3f, 0xf0), \
                TOP(0xbf, 0xf0), TOP(0x40, 0x08), TOP(0x3f, 0xd0), TOP(0x40, 0x24) }
#else
#define TOP(high, low) 0, 0, low, high
#define HEADS { TOP(0x3f, 0xc0), TOP(0x40, 0x00), TOP(0xc0, 0x00), TOP(0x3f, 0x00), TOP(0x3f, 0x80), \
                TOP(0xbf, 0x80), TOP(0x40, 0x40), TOP(0x3e, 0x80), TOP(0x41, 0x20) }
#endif

/* u32 index, nine reals, u8 status, least significant byte first. */
static void digest_has_its_layout(void)
{
    static const uint8_t values[9 * sizeof(real)] = HEADS;
    uint8_t record[4 + sizeof(values) + 1] = { 0x44, 0x33, 0x22, 0x11 };
    kelly_tally tally = { 0 };
    kelly_result refused = plain;
    uint32_t one;

    for (unsigned k = 0; k < sizeof(values); k++) {
        record[4 + k] = values[k];
    }
    kelly_tally_add(&tally, 0x11223344u, &plain);
    one = kelly_crc32c(0, record, sizeof(record));
    EQUAL(tally.digest, one);
    refused.status = record[sizeof(record) - 1] = KELLY_RANGE;
    record[0]++;
    kelly_tally_add(&tally, 0x11223345u, &refused);
    EQUAL(tally.digest, kelly_crc32c(one, record, sizeof(record)));
}

static void add(kelly_tally *tally, unsigned times, uint8_t status, uint8_t stuck, uint8_t liftoff)
{
    kelly_result r = plain;

    r.status = status;
    r.stuck = stuck;
    r.liftoff = liftoff;
    for (unsigned k = 0; k < times; k++) {
        kelly_tally_add(tally, tally->samples, &r);
    }
}

static void counts(void)
{
    kelly_tally tally = { 0 };

    CHECK(kelly_probability(&tally) == 0);
    add(&tally, 2, KELLY_STEP, 0, 0);
    CHECK(kelly_probability(&tally) == 0);                 /* nothing that counts */
    add(&tally, 3, KELLY_OK, 1, 0);
    add(&tally, 5, KELLY_OK, 0, 1);
    add(&tally, 1, KELLY_RANGE, 0, 0);
    add(&tally, 4, KELLY_NONFINITE, 0, 1);
    EQUAL(tally.samples, 15);
    EQUAL(tally.stuck, 3);
    EQUAL(tally.liftoff, 9);
    EQUAL(tally.status[KELLY_OK], 8);
    EQUAL(tally.status[KELLY_STEP], 2);
    EQUAL(tally.status[KELLY_RANGE], 1);
    EQUAL(tally.status[KELLY_NONFINITE], 4);
    EQUAL(kelly_refused(&tally), 7);
    CLOSE(kelly_probability(&tally), W(0.375), W(1e-7));
}

/* k, n and the ends of the 95 % interval: scipy 1.10, beta.ppf(0.025, k, n - k + 1) and beta.ppf(0.975, k + 1, n - k). */
static const struct {
    uint32_t k, n;
    wide lo, hi;
} intervals[] = {
    { 0, 1, W(0.0), W(0.97499999999999998) },
    { 1, 1, W(0.025000000000000001), W(1.0) },
    { 0, 400, W(0.0), W(0.00917980458366526) },
    { 400, 400, W(0.9908201954163347), W(1.0) },
    { 198, 400, W(0.44494757285985886), W(0.54512692794907214) },
    { 3, 10, W(0.066739511177734467), W(0.65245285005999731) },
    { 1, 2, W(0.01257911709342505), W(0.98742088290657493) },
    { 5, 100000, W(1.6235056817057864e-05), W(0.00011667943042027703) },
    { 500000, 1000000, W(0.49901951919531184), W(0.50098048080468816) },
    { 999999, 1000000, W(0.99999442836934482), W(0.99999997468219237) },
};

/* Double: to 1e-9 of the value. A float board: to 4e-4 of it, which n p of some 1e6 in float leave of the exponent. */
static const wide relative = sizeof(wide) > sizeof(float) ? W(1e-9) : W(4e-4);

static void interval_is_clopper_pearson(void)
{
    for (unsigned row = 0; row < sizeof(intervals) / sizeof(intervals[0]); row++) {
        const uint32_t k = intervals[row].k, n = intervals[row].n;
        const wide lo = kelly_binomial_lo(k, n, W(0.025)), hi = kelly_binomial_hi(k, n, W(0.025));

        CLOSE(lo, intervals[row].lo, relative * intervals[row].lo);
        CLOSE(hi, intervals[row].hi, relative * intervals[row].hi);
        CHECK(lo >= 0 && hi <= 1 && lo < hi);
    }
    CLOSE(kelly_binomial_lo(3, 10, W(0.005)), W(0.03700722109623209), relative);
    CLOSE(kelly_binomial_hi(3, 10, W(0.005)), W(0.7351139852871307), relative);
}

/* Refused realisations count as free in lo and as stuck in hi. */
static void refused_ones_widen(void)
{
    kelly_tally tally = { 0 };
    wide lo, hi;

    add(&tally, 3, KELLY_OK, 1, 0);
    add(&tally, 5, KELLY_OK, 0, 0);
    kelly_interval(&tally, &lo, &hi);
    CLOSE(lo, kelly_binomial_lo(3, 8, W(0.025)), 0);
    CLOSE(hi, kelly_binomial_hi(3, 8, W(0.025)), 0);
    add(&tally, 1, KELLY_STEP, 0, 0);
    add(&tally, 1, KELLY_RANGE, 0, 0);
    kelly_interval(&tally, &lo, &hi);
    CLOSE(lo, kelly_binomial_lo(3, 10, W(0.025)), 0);
    CLOSE(hi, kelly_binomial_hi(5, 10, W(0.025)), 0);
    tally = (kelly_tally){ 0 };
    add(&tally, 4, KELLY_STEP, 0, 0);
    kelly_interval(&tally, &lo, &hi);
    CHECK(lo == 0 && hi == 1);                             /* nothing is known */
}

void test_tally(void);
void test_tally(void)
{
    crc_has_its_known_answer();
    digest_has_its_layout();
    counts();
    interval_is_clopper_pearson();
    refused_ones_widen();
}
