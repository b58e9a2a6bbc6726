/* test_rare_guide.c - subset simulation and the string: draws of a sample, the guide of a realisation, the guess from the linear string. */
#include "../firmware/detmath.h"
#include "check.h"
#include "rare_events.h"

static kelly_case looked;             /* by the hint of a look */

static void draws_what_kelly_run_draws(void)
{
    kelly_case run;

    fixture_case(&run, 100);
    run.cov[0] = run.cov[3] = 0.2f;
    run.cov[4] = 0.5f;
    run.cov[1] = 0.00009f;                                 /* too little to be random */
    CHECK(kelly_rare_start(&rare, run.cov, 11, 200, samples, keys) == 0);
    for (uint32_t j = 0; j < 200; j += 17) {
        kelly_draw one, other;

        kelly_rare_draw(&run, &samples[j], &one);
        kelly_draw_sample(&run, 11, j, &other);
        CHECK(one.fc == other.fc && one.mu == other.mu && one.a1 == other.a1 && one.a2 == other.a2 && one.w0 == other.w0);
        CHECK(one.mu == run.mu && samples[j].x[1] == 0);
    }
}

/* A run of given draws is the run of the seed that drew them. */
static void runs_given_draws(void)
{
    kelly_result *const of_seed = fixture.ensemble.results, *const given = fixture.ensemble.again;
    kelly_draw draws[2];
    kelly_case run;

    fixture_case(&run, BY_LENGTH(60, 3000));
    run.cov[1] = run.cov[4] = 0.2f;
    kelly_run(&kelly_string, &run, 8, 5, 2, of_seed, &fixture.ensemble.work);
    draws[0] = of_seed[1].draw;
    draws[1] = of_seed[0].draw;
    kelly_run_draws(&kelly_string, &run, draws, 2, given, &fixture.ensemble.work);
    CHECK(fixture_same(&given[0], &of_seed[1]));
    CHECK(fixture_same(&given[1], &of_seed[0]));
}

/* (b_1^2 T' / c_1)^4 ss in floating point from elsewhere; above the limit it is a failure, without a result it is refused. */
static void guides_by_the_negative_damping(void)
{
    kelly_result r = { .ss = R(0.5), .status = KELLY_OK };
    kelly_case run;
    float before;

    fixture_case(&run, 100);
    run.limit = R(0.8);
    run.mu = R(0.004);
    kelly_draw_nominal(&run, &r.draw);
    before = kelly_rare_guide(&kelly_string, &run, &r);
    CLOSE((wide)before / W(0.0655589), W(1.0), W(1e-4));
    r.ss = R(0.25);
    CLOSE((wide)kelly_rare_guide(&kelly_string, &run, &r) / (wide)before, W(0.5), W(1e-6));
    r.draw.w0 = R(0.5);                                    /* positive damping: clamped, and still ordered by ss */
    CHECK(kelly_rare_guide(&kelly_string, &run, &r) > 0 && kelly_rare_guide(&kelly_string, &run, &r) < 1e-20f);
    r.ss = R(0.81);
    CHECK(kelly_rare_guide(&kelly_string, &run, &r) == KELLY_RARE_FAILED);
    r.status = KELLY_STEP;
    CHECK(kelly_rare_guide(&kelly_string, &run, &r) == KELLY_RARE_REFUSED);
    r.status = KELLY_OK;
    r.draw.fc = kelly_string.fc_max * R(2.0);
    CHECK(kelly_rare_guide(&kelly_string, &run, &r) == KELLY_RARE_REFUSED);
}

/* ss = forced + swing, and R, at the means of a case by rare.h, otherwise than rare_guide.c: H is 1 / sum of admittances in wide. */
static wide linear_ss(const kelly_case *run, wide *ratio)
{
    const wide w = (wide)run->w0, q = (wide)run->a2 * w * w, up = kelly_exp(w), down = kelly_exp(-w), t = (up - down) / (up + down);
    const wide slope = (wide)run->mu * (wide)run->fc * ((wide)run->a1 * (q - 1) / ((1 + q) * (1 + q)) - (1 - t * t));
    const wide pull = t + (wide)run->a1 * w / (1 + q);
    kelly_modes modes;
    wide re = 0, im = 0, forced, swing, c1, b1, decay, x;

    CHECK(kelly_modes_at(&kelly_string, run->fc, run->torsional, &modes));
    for (unsigned i = 0; i < modes.count; i++) {
        const wide b = (wide)modes.b[i], loss = (wide)kelly_string.alpha + (wide)kelly_string.beta * (wide)modes.w2[i];
        const wide p = ((wide)modes.w2[i] - w * w) / w;    /* b^2 / (loss - i p), over the square of its size */

        re += b * b * loss / (loss * loss + p * p);
        im += b * b * p / (loss * loss + p * p);
    }
    forced = (wide)run->mu * (wide)run->f0 * pull / w *
             textbook_sqrt((re * re + im * im) / ((1 - slope * re) * (1 - slope * re) + slope * im * slope * im));
    c1 = (wide)kelly_string.alpha + (wide)kelly_string.beta * (wide)modes.w2[0];
    b1 = (wide)modes.b[0];
    x = 1 + (c1 - b1 * b1 * slope) / 2 * (wide)run->window_first * (wide)run->step_ns * W(1e-9) / 64;
    decay = kelly_exp(-64 * kelly_log(x < W(0.95) ? W(0.95) : x > 2 ? 2 : x));
    swing = run->rotating ? b1 * b1 * (wide)run->mu * (wide)run->fc * pull / textbook_sqrt((wide)modes.w2[0]) / w : fixture_abs((wide)modes.d[0]) * b1;
    x = b1 * b1 * slope / c1;
    *ratio = x > W(1e-6) ? x : W(1e-6);
    return forced + decay * swing;
}

/* Negative and positive damping, short and long runs, from rest and turning; beyond the laws or the table: far below all others. */
static void guesses_from_the_linear_string(void)
{
    static const real speeds[] = { R(4.0), R(10.0), R(18.0), R(0.5) };
    float x[KELLY_PARAMETERS] = { 0 };
    kelly_case run;
    const kelly_rare_hint hint = { .table = &kelly_string, .run = &run };
    wide ss, ratio;

    fixture_case(&run, 100000);
    run.mu = R(0.004);
    for (unsigned k = 0; k < 16; k++) {
        run.w0 = speeds[k / 4];
        run.rotating = k & 1u;
        run.window_first = (k & 2u) != 0 ? 2000000 : 50000;
        ss = linear_ss(&run, &ratio);
        CLOSE((wide)kelly_rare_guess(&hint, x), 4 * kelly_log(ratio) + kelly_log(ss), W(2e-3));
        CLOSE((wide)kelly_rare_own(&hint) / ss, 1, W(1e-3));
    }
    run.cov[0] = 0.5f;
    CHECK(kelly_rare_guess(&hint, x) > -1e5f);
    run.fc = kelly_string.fc_max / 2;
    x[0] = 6.0f;                                           /* more weight than the table has */
    CHECK(kelly_rare_guess(&hint, x) < -1e5f && kelly_rare_resonance(&hint, x, 0) == 0);
    x[0] = -40.0f;                                         /* no gamma variable is negative */
    CHECK(kelly_rare_guess(&hint, x) < -1e5f);
    run.cov[1] = 0.5f;
    x[0] = 0.0f;
    x[1] = -40.0f;
    CHECK(kelly_rare_guess(&hint, x) == kelly_rare_guess(&hint, (const float[KELLY_PARAMETERS]){ -40.0f }));
}

/* Far beyond the ranges of string_model.h: a guide is a failure by its ss alone, and a hint of nothing is not the least of all. */
static void stays_in_bounds(void)
{
    kelly_result r = { .ss = R(0.5), .status = KELLY_OK };
    kelly_case run;
    const kelly_rare_hint hint = { .table = &kelly_string, .run = &run };
    const float x[KELLY_PARAMETERS] = { 0 };
    float nothing;

    fixture_case(&run, 100);
    run.limit = R(0.8);
    kelly_draw_nominal(&run, &r.draw);
    r.draw.mu = R(1e9);
    CHECK(kelly_rare_guide(&kelly_string, &run, &r) > 1e30f && kelly_rare_guide(&kelly_string, &run, &r) < KELLY_RARE_FAILED);
    run.mu = R(1e-36);
    run.f0 = 0;
    run.rotating = 1;
    nothing = kelly_rare_guess(&hint, x);
    CHECK(nothing > -125.0f && nothing < -124.0f);         /* 1e-24 1e-30 */
}

/* P of the linear string's resonance, as draws alone give it; and an answer that lacks the failures that a look has found is none. */
static void looks_at_resonances(void)
{
    const uint32_t n = BY_LENGTH(200, 2400), draws = BY_LENGTH(20000, 1000000);
    const kelly_rare_hint hint = { .table = &kelly_string, .run = &looked };
    uint32_t above = 0;
    kelly_rare_seen seen;
    kelly_rng rng;
    wide p;

    fixture_case(&looked, 100000);
    looked.mu = R(0.004);
    looked.w0 = BY_LENGTH(R(13.85), R(12.0));              /* the third mode is at 13.85 rad/s */
    looked.f0 = R(95000.0);
    looked.cov[4] = BY_LENGTH(0.01f, 0.05f);
    CHECK(kelly_rare_start(&rare, looked.cov, 1, n, samples, keys) == 0);
    kelly_rare_look(&rare, &hint, 2, W(1e-6), n / 10);
    EQUAL(rare.state, KELLY_RARE_DONE);
    EQUAL(kelly_rare_count(&rare), n / 10);
    for (uint32_t i = 0; i < n / 10; i++) {
        CHECK(kelly_rare_resonance(&hint, samples[i].x, 2) > (float)looked.limit * 0.4f);
        samples[i].guide = i % 4 == 0 ? KELLY_RARE_FAILED : 0.0f;
    }
    kelly_rare_read(&rare, &answer);
    for (uint32_t j = 0; j < draws; j++) {
        float x[KELLY_PARAMETERS] = { 0 };

        kelly_rng_key(&rng, 5, j, 4);
        x[4] = kelly_gamma_normal(&rng, looked.cov[4]);
        above += kelly_rare_resonance(&hint, x, 2) > (float)looked.limit * 0.4f ? 1u : 0u;
    }
    p = (wide)above / (wide)draws;
    CHECK(above > 20);
    CLOSE(answer.probability / p, 1, 4 * (wide)kelly_sqrt32((float)(answer.cov * answer.cov + 1 / (wide)above)));
    kelly_rare_see(&rare, &seen);
    EQUAL(seen.tried, n / 10);
    EQUAL(seen.failed, (n / 10 + 3) / 4);
    CLOSE(seen.probability / answer.probability, (wide)seen.failed / (wide)seen.tried, W(1e-6));
    CHECK(seen.variance > answer.cov * answer.cov);
    CHECK(kelly_rare_start(&rare, looked.cov, 1, n, samples, keys) == 0);
    kelly_rare_look(&rare, &hint, 9, W(1e-6), n / 10);     /* 54.8 rad/s: too rare */
    EQUAL(kelly_rare_count(&rare), 0);
    CHECK(kelly_rare_start(&rare, looked.cov, 1, n, samples, keys) == 0);
    kelly_rare_look(&rare, &hint, 2, W(1e-6), n);          /* more than it finds: all that it finds */
    EQUAL(kelly_rare_count(&rare), rare.levels[rare.level].failed);
    for (uint32_t i = 0; i < kelly_rare_count(&rare); i++) {
        samples[i].guide = 0;
    }
    kelly_rare_see(&rare, &seen);
    CHECK(seen.tried == kelly_rare_count(&rare) && seen.failed == 0 && seen.probability == 0);
}

/* An answer that has the failures a look has found stands, and one that lacks them does not, if they matter. */
static void compares_with_a_look(void)
{
    const kelly_rare_hint hint = { .table = &kelly_string, .run = &looked };

    const uint32_t n = BY_LENGTH(200, 2400);

    looked.w0 = R(12.0);
    looked.cov[4] = 0.05f;
    for (unsigned k = 0; k < 5; k++) {                     /* none, none but few, all, none but uncertain, half, which may be more */
        const wide ratio[5] = { 8, W(0.19), 1, 1, BY_LENGTH(W(2.2), W(0.78)) };
        kelly_rare_seen seen = { .tried = 20, .failed = 10, .variance = k == 3 ? W(9.0) : W(0.01) };

        CHECK(simulate(PLANE, normals, 2.3263f, 3, n));
        for (uint32_t i = 0; i < n; i++) {                 /* at the mean, or where the third mode is */
            for (unsigned m = 0; m < KELLY_PARAMETERS; m++) {
                samples[i].x[m] = 0.0f;
            }
            samples[i].x[4] = k == 2 || (k == 4 && i % 2 == 1) ? 2.95f : 0.0f;
        }
        CHECK((kelly_rare_resonance(&hint, samples[0].x, 2) > (float)looked.limit * 0.4f) == (k == 2));
        seen.probability = answer.probability * ratio[k];
        kelly_rare_compare(&rare, &hint, 2, &seen);
        EQUAL(rare.state, k == 0 ? KELLY_RARE_ELSEWHERE : KELLY_RARE_DONE);
        if (k == 0) {                                      /* what is no answer stays none */
            kelly_rare_compare(&rare, &hint, 2, &seen);
            EQUAL(rare.state, KELLY_RARE_ELSEWHERE);
        }
        seen.failed = 0;
        kelly_rare_compare(&rare, &hint, 2, &seen);
    }
    EQUAL(rare.state, KELLY_RARE_DONE);                    /* nothing failed where the look was */
    CHECK(simulate(PLANE, normals, 0.0f, 3, n));
    kelly_rare_compare(&rare, &hint, 2, &(kelly_rare_seen){ .probability = 1, .variance = W(0.01), .tried = 20, .failed = 20 });
    EQUAL(rare.state, KELLY_RARE_DONE);                    /* plain Monte Carlo sees all */
}

/* A limit that the string comes near anyway is doubted, but not what plain Monte Carlo has seen, nor what is no answer. */
static void doubts_a_limit_that_is_near(void)
{
    const kelly_rare_hint hint = { .table = &kelly_string, .run = &looked };
    const uint32_t n = BY_LENGTH(200, 2400);
    float own;

    fixture_case(&looked, 100000);
    looked.mu = R(0.004);
    looked.w0 = R(12.0);
    own = kelly_rare_own(&hint);
    CHECK(own > 0.05f && own < 0.5f);
    for (unsigned k = 0; k < 4; k++) {                     /* near; not near; near, but plain; near, but no answer */
        looked.limit = (real)own * (k == 1 ? R(1.51) : R(1.49));
        CHECK(simulate(PLANE, normals, k == 2 ? 0.0f : 2.3263f, 3, n));
        rare.state = k == 3 ? KELLY_RARE_FEW : rare.state;
        kelly_rare_doubt(&rare, &hint);
        EQUAL(rare.state, k == 0 ? KELLY_RARE_NEAR : k == 3 ? KELLY_RARE_FEW : KELLY_RARE_DONE);
    }
    looked.fc = kelly_string.fc_max * R(2.0);              /* beyond the table */
    CHECK(kelly_rare_own(&hint) == 0);
}

void test_rare_guide(void);
void test_rare_guide(void)
{
    draws_what_kelly_run_draws();
    runs_given_draws();
    guides_by_the_negative_damping();
    guesses_from_the_linear_string();
    stays_in_bounds();
    looks_at_resonances();
    compares_with_a_look();
    doubts_a_limit_that_is_near();
}
