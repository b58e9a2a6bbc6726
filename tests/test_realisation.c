/* test_realisation.c - draws, and what is refused before it is integrated. */
#include "../firmware/random.h"
#include "check.h"
#include "fixture.h"
#include "vectors/draws.h"

static kelly_case run;
static kelly_draw draw;
static kelly_modes modes;

static real parameter(const kelly_draw *of, unsigned k)
{
    const real all[KELLY_PARAMETERS] = { of->fc, of->mu, of->a1, of->a2, of->w0 };

    return all[k];
}

static int equal(const kelly_draw *a, const kelly_draw *b)
{
    int same = 1;

    for (unsigned k = 0; k < KELLY_PARAMETERS; k++) {
        same &= fixture_bits(parameter(a, k)) == fixture_bits(parameter(b, k));
    }
    return same;
}

static void nominal_laws(void)
{
    fixture_case(&run, 1000);
    for (unsigned k = 0; k < KELLY_PARAMETERS; k++) {
        run.cov[k] = 0.2f;
    }
}

/* Every value is a float, the same in both precisions; the reference draws in double, and agrees but for rounding. */
static void draws_golden_values(void)
{
    nominal_laws();
    for (unsigned row = 0; row < VECTOR_DRAWS; row++) {
        const vector_draw *const want = &vector_draws[row];

        for (unsigned k = 0; k < KELLY_PARAMETERS; k++) {
            run.cov[k] = want->cov;
        }
        kelly_draw_sample(&run, want->seed, want->index, &draw);
        for (unsigned k = 0; k < KELLY_PARAMETERS; k++) {
            EQUAL((union { float x; uint32_t bits; }){ .x = (float)parameter(&draw, k) }.bits, want->bits[k]);
            CHECK((real)(float)parameter(&draw, k) == parameter(&draw, k));
            CLOSE((wide)parameter(&draw, k) / (wide)want->reference[k], 1, W(4e-6));
        }
    }
}

/* Order does not matter, neighbours share nothing, and a parameter does not depend on which others are random. */
static void draws_by_key(void)
{
    kelly_draw first, other;

    nominal_laws();
    kelly_draw_sample(&run, 5, 100, &first);
    kelly_draw_sample(&run, 5, 101, &other);
    kelly_draw_sample(&run, 5, 100, &draw);
    CHECK(equal(&first, &draw));
    for (unsigned k = 0; k < KELLY_PARAMETERS; k++) {
        CHECK(parameter(&first, k) != parameter(&other, k));
    }
    kelly_draw_sample(&run, 6, 100, &other);
    CHECK(first.fc != other.fc && first.w0 != other.w0);
    for (unsigned k = 0; k < KELLY_PARAMETERS; k++) {
        kelly_draw nominal;

        for (unsigned j = 0; j < KELLY_PARAMETERS; j++) {
            run.cov[j] = j == k ? 0.2f : 0.0f;
        }
        kelly_draw_sample(&run, 5, 100, &draw);
        kelly_draw_nominal(&run, &nominal);
        for (unsigned j = 0; j < KELLY_PARAMETERS; j++) {
            CHECK(parameter(&draw, j) == parameter(j == k ? &first : &nominal, j));
        }
    }
}

static void nothing_random_is_the_mean(void)
{
    fixture_case(&run, 1000);
    kelly_draw_sample(&run, 1, 1, &draw);
    CHECK(draw.fc == run.fc && draw.mu == run.mu && draw.a1 == run.a1 && draw.a2 == run.a2 && draw.w0 == run.w0);
    kelly_draw_nominal(&run, &draw);
    CHECK(draw.fc == run.fc && draw.mu == run.mu && draw.a1 == run.a1 && draw.a2 == run.a2 && draw.w0 == run.w0);
}

static kelly_status status_at(real fc, real mu, uint32_t step_ns)
{
    run.step_ns = step_ns;
    kelly_draw_nominal(&run, &draw);
    draw.fc = fc;
    draw.mu = mu;
    return kelly_realise(&kelly_string, &run, &draw, &modes);
}

/* A spread that float cannot hold is none: 1 / cov^2 would overflow, and the sampler run out of tries. */
static void tiny_spread_is_none(void)
{
    fixture_case(&run, 1000);
    run.cov[1] = 1e-25f;
    run.mu = R(0.1);                                       /* what is drawn is rounded to float, what is not random is not */
    kelly_draw_sample(&run, 1, 0, &draw);
    CHECK(fixture_bits(draw.mu) == fixture_bits(run.mu));
}

/* Nominal rate 771 1/s + beta w^2: 2.785 / rate is 3.61 ms. Without rock the highest mode, 54.77 rad/s, says 51.1 ms. */
static void refuses_what_it_cannot_trust(void)
{
    fixture_case(&run, 1000);
    EQUAL(status_at(R(100000.0), R(0.04), 3600000), KELLY_OK);
    EQUAL(status_at(R(100000.0), R(0.04), 3620000), KELLY_STEP);
    EQUAL(status_at(R(160000.0), R(0.04), 3000000), KELLY_STEP);
    EQUAL(status_at(R(100000.0), R(0.16), 1000000), KELLY_STEP);
    EQUAL(status_at(R(100000.0), R(1e-9), 51000000), KELLY_OK);
    EQUAL(status_at(R(100000.0), R(1e-9), 51300000), KELLY_STEP);
    run.w0 = R(54.0);                                      /* 2.75 rad a step */
    EQUAL(status_at(R(100000.0), R(1e-9), 51000000), KELLY_OK);
    run.w0 = R(61.6);                                      /* half a turn: the weight between two steps would be 0 / 0 */
    EQUAL(status_at(R(100000.0), R(1e-9), 51000000), KELLY_STEP);
    fixture_case(&run, 1000);
    modes.count = 77;
    EQUAL(status_at(R(999.0), R(0.04), 1000000), KELLY_RANGE);
    EQUAL(status_at(R(1000100.0), R(0.04), 1000000), KELLY_RANGE);
    EQUAL(modes.count, 77);                                /* untouched */
    EQUAL(status_at(R(1000.0), R(0.04), 1000000), KELLY_OK);
    EQUAL(modes.count, 10);
}

/* The step it names passes, a step 1e-4 longer does not. */
static void largest_step_at(real mu)
{
    wide largest;

    EQUAL(status_at(R(100000.0), mu, 1000000), KELLY_OK);
    largest = (wide)kelly_largest_step(&kelly_string, &run, &draw, &modes) * W(1e6);
    EQUAL(status_at(R(100000.0), mu, (uint32_t)largest * 1000u), KELLY_OK);
    EQUAL(status_at(R(100000.0), mu, (uint32_t)(largest * W(1.0003) + 1) * 1000u), KELLY_STEP);
}

static void names_the_largest_step(void)
{
    fixture_case(&run, 1000);
    largest_step_at(R(0.04));
    largest_step_at(R(0.004));
    largest_step_at(R(1e-9));
}

/* Below it the digits of a float do not carry a step's change of the slowest mode; a double's do at the shortest step there is. */
static void names_the_smallest_step(void)
{
    wide smallest;

    fixture_case(&run, 1000);
    EQUAL(status_at(R(100000.0), R(0.04), 1000000), KELLY_OK);
    smallest = (wide)kelly_smallest_step(&modes);
    CLOSE(smallest * textbook_sqrt((wide)modes.w2[0]), BY_REAL(1e-5, 1e-13), BY_REAL(1e-11, 1e-19));
    if (smallest > W(1e-6)) {
        EQUAL(status_at(R(100000.0), R(0.04), (uint32_t)(smallest * W(1.001e9))), KELLY_OK);
        EQUAL(status_at(R(100000.0), R(0.04), (uint32_t)(smallest * W(0.999e9))), KELLY_STEP);
    } else {
        EQUAL(status_at(R(100000.0), R(0.04), 1000), KELLY_OK);
    }
}

/* The fastest mode is the fastest wherever it stands. */
static void does_not_mind_the_order_of_modes(void)
{
    real rate, w2, step;

    fixture_case(&run, 1000);
    run.torsional = 2;
    EQUAL(status_at(R(100000.0), R(1e-9), 1000000), KELLY_OK);
    rate = kelly_fastest_rate(&kelly_string, &run, &draw, &modes, draw.fc);
    step = kelly_largest_step(&kelly_string, &run, &draw, &modes);
    w2 = modes.w2[0];
    modes.w2[0] = modes.w2[1];
    modes.w2[1] = w2;
    CHECK(modes.w2[0] > modes.w2[1] && kelly_fastest_rate(&kelly_string, &run, &draw, &modes, draw.fc) == rate);
    CHECK(kelly_largest_step(&kelly_string, &run, &draw, &modes) == step);
}

static void lifts_off_below_the_amplitude(void)
{
    fixture_case(&run, 1000);
    kelly_draw_nominal(&run, &draw);
    CHECK(!kelly_lifts_off(&run, &draw));
    draw.fc = R(50501.0);
    CHECK(!kelly_lifts_off(&run, &draw));
    draw.fc = R(50499.0);
    CHECK(kelly_lifts_off(&run, &draw));
    run.f0 = 0;
    CHECK(!kelly_lifts_off(&run, &draw));
}

/* One field of a good case spoilt: `value` where `field` says. */
#define SPOILT(field, value) \
    do { \
        fixture_case(&run, 1000); \
        run.field = (value); \
        CHECK(kelly_case_error(&kelly_string, &run) != 0); \
    } while (0)
#define FINE(field, value) \
    do { \
        fixture_case(&run, 1000); \
        run.field = (value); \
        CHECK(kelly_case_error(&kelly_string, &run) == 0); \
    } while (0)

static void refuses_bad_physics(void)
{
    const real nan = CHECK_NAN, infinity = CHECK_INFINITY;

    SPOILT(fc, 0);
    SPOILT(fc, R(-1.0));
    SPOILT(fc, nan);
    SPOILT(fc, infinity);
    SPOILT(mu, 0);
    SPOILT(mu, nan);
    SPOILT(a1, 0);
    SPOILT(a1, nan);
    SPOILT(a2, R(-2.0));
    SPOILT(a2, infinity);
    SPOILT(w0, 0);
    SPOILT(w0, nan);
    SPOILT(f0, R(-1.0));
    SPOILT(f0, nan);
    SPOILT(f0, infinity);
    FINE(f0, 0);
    SPOILT(limit, R(-0.1));
    SPOILT(limit, R(10.1));
    SPOILT(limit, nan);
    FINE(limit, 0);
    FINE(limit, R(10.0));
    for (unsigned k = 0; k < KELLY_PARAMETERS; k++) {
        SPOILT(cov[k], -0.1f);
        SPOILT(cov[k], 0.51f);
        SPOILT(cov[k], (float)nan);
        FINE(cov[k], 0.5f);
    }
}

static void refuses_bad_numerics(void)
{
    SPOILT(step_ns, 999);
    SPOILT(step_ns, 1000000001u);
    SPOILT(step_ns, 0);
    FINE(step_ns, 1000);
    FINE(step_ns, 1000000000u);
    SPOILT(ticks, 0);
    SPOILT(ticks, 999);                                    /* the window ends at 1000 */
    SPOILT(window_first, 1000);
    SPOILT(window_first, 1001);
    SPOILT(window_last, 1001);
    FINE(window_first, 999);
    FINE(window_first, 0);
    SPOILT(torsional, 0);
    SPOILT(torsional, (uint8_t)(kelly_string.torsional + 1));
    SPOILT(axial, 0);
    SPOILT(axial, (uint8_t)(kelly_string.axial + 1));
    FINE(torsional, (uint8_t)kelly_string.torsional);
    FINE(axial, (uint8_t)kelly_string.axial);
    CHECK(kelly_case_error(&kelly_string, &kelly_string.nominal) == 0);
}

/* A draw that no law gives is out of range, whichever parameter it is. */
static void refuses_unsound_draws(void)
{
    const real endless = fixture_endless(), bad[] = { 0, R(-1.0), endless - endless, endless };

    fixture_case(&run, 100);
    for (unsigned k = 0; k < sizeof(bad) / sizeof(bad[0]); k++) {
        for (unsigned parameter = 0; parameter < KELLY_PARAMETERS; parameter++) {
            real *const place[KELLY_PARAMETERS] = { &draw.fc, &draw.mu, &draw.a1, &draw.a2, &draw.w0 };

            kelly_draw_nominal(&run, &draw);
            EQUAL(kelly_realise(&kelly_string, &run, &draw, &modes), KELLY_OK);
            *place[parameter] = bad[k];
            EQUAL(kelly_realise(&kelly_string, &run, &draw, &modes), KELLY_RANGE);
        }
    }
}

void test_realisation(void);
void test_realisation(void)
{
    draws_golden_values();
    draws_by_key();
    nothing_random_is_the_mean();
    refuses_what_it_cannot_trust();
    names_the_largest_step();
    names_the_smallest_step();
    does_not_mind_the_order_of_modes();
    tiny_spread_is_none();
    lifts_off_below_the_amplitude();
    refuses_bad_physics();
    refuses_bad_numerics();
    refuses_unsound_draws();
}
