/* test_sobol.c - Sobol's indices against a function whose indices are known, and the rows they are taken from. */
#include "check.h"
#include "fixture.h"

/* Ishigami and Homma (1990): sin x1 + a sin^2 x2 + b x3^4 sin x1 over (-pi, pi)^3, a = 7, b = 0.1. With
 * V = a^2/8 + b pi^4/5 + b^2 pi^8/18 + 1/2:  V first = (1 + b pi^4/5)^2/2, a^2/8, 0;  V total = V first_1 + V_13, a^2/8, V_13,
 * V_13 = 8 b^2 pi^8 / 225. */
static const wide first_true[3] = { W(0.3139051911), W(0.4424111448), W(0.0) };
static const wide total_true[3] = { W(0.5575888552), W(0.4424111448), W(0.2436836641) };
#define ISHIGAMI_MEAN W(3.5)
#define ISHIGAMI_VARIANCE W(13.844587940719254)

static kelly_sobol sobol;

/* x as a phase: any angle of the circle; sin x and x^2 of it. */
static wide ishigami(const uint32_t x[3])
{
    const wide s1 = (wide)kelly_sin_turn((uint64_t)x[0] << 32), s2 = (wide)kelly_sin_turn((uint64_t)x[1] << 32);
    const wide turn = (wide)(int32_t)x[2] * W(1.4629180792671596e-9);    /* 2 pi / 2^32 */

    return s1 + 7 * s2 * s2 + W(0.1) * (turn * turn) * (turn * turn) * s1;
}

static void add_ishigami(uint64_t seed, uint32_t rows, int scaled)
{
    kelly_sobol_clear(&sobol, 3);
    for (uint32_t j = 0; j < rows; j++) {
        uint32_t x[5][3];
        wide f[5];

        for (uint32_t i = 0; i < 3; i++) {
            kelly_rng rng;

            kelly_rng_key(&rng, seed, j, i);
            x[0][i] = kelly_rng_next(&rng);
            kelly_rng_key(&rng, seed + 1000000, j, i);
            x[1][i] = kelly_rng_next(&rng);
        }
        for (unsigned i = 0; i < 3; i++) {
            for (unsigned k = 0; k < 3; k++) {
                x[2 + i][k] = x[i == k][k];
            }
        }
        for (unsigned i = 0; i < 5; i++) {
            f[i] = scaled ? 1000 + 3 * ishigami(x[i]) : ishigami(x[i]);
        }
        kelly_sobol_add(&sobol, f);
    }
}

#if CHECK_LONG
static void show(const char *what, const kelly_estimate *found, wide truth)
{
    check_text(what);
    check_number(found->value);
    check_text(" (");
    check_number(found->lo);
    check_text(" .. ");
    check_number(found->hi);
    check_text("), analytic ");
    check_number(truth);
    check_put('\n');
}
#endif

/* A twentieth, then ten times less: errors fall as the root of the rows. */
static void finds_the_indices_of_ishigami(void)
{
    const uint32_t rows = BY_LENGTH(1000, 200000);
    const wide within = BY_LENGTH(W(0.15), W(0.01));
    wide mean, variance;

    add_ishigami(1, rows, 0);
    kelly_sobol_moments(&sobol, &mean, &variance);
    CLOSE(mean, ISHIGAMI_MEAN, 3 * within);
    CLOSE(variance, ISHIGAMI_VARIANCE, 10 * within);
    for (unsigned i = 0; i < 3; i++) {
        kelly_estimate first, total;

        CHECK(kelly_sobol_read(&sobol, i, &first, &total));
        CLOSE(first.value, first_true[i], within);
        CLOSE(total.value, total_true[i], within);
        CHECK(first.lo < first.value && first.value < first.hi && first.hi - first.lo < 6 * within);
        CHECK(total.lo < total.value && total.value < total.hi && total.hi - total.lo < 6 * within);
#if CHECK_LONG
        show("  Ishigami, first ", &first, first_true[i]);
        show("  Ishigami, total ", &total, total_true[i]);
#endif
    }
}

/* The formulas of the header once more, from all rows at once; the first row is an outlier. */
static void keeps_its_formulas(void)
{
    wide f[70][3], mean = 0, v = 0, first_sum = 0, total_sum = 0;
    kelly_estimate first, total;
    kelly_rng rng;

    kelly_rng_key(&rng, 6, 0, 0);
    kelly_sobol_clear(&sobol, 1);
    for (unsigned j = 0; j < 70; j++) {
        for (unsigned i = 0; i < 3; i++) {
            f[j][i] = (wide)kelly_open01(kelly_rng_next(&rng)) + (j == 0 ? 5 : 0);
        }
        mean += (f[j][0] + f[j][1]) / 140;
        kelly_sobol_add(&sobol, f[j]);
    }
    for (unsigned j = 0; j < 70; j++) {
        v += ((f[j][0] - mean) * (f[j][0] - mean) + (f[j][1] - mean) * (f[j][1] - mean)) / 140;
        first_sum += (f[j][1] - mean) * (f[j][2] - f[j][0]) / 70;
        total_sum += (f[j][0] - f[j][2]) * (f[j][0] - f[j][2]) / 140;
    }
    CHECK(kelly_sobol_read(&sobol, 0, &first, &total));
    CLOSE(first.value, first_sum / v, 1e-4);
    CLOSE(total.value, total_sum / v, 1e-4);
}

/* 500 repetitions of 640 rows, six intervals each: 95 % of them hold the truth, within four standard errors of a repetition. */
static void intervals_cover(void)
{
#if CHECK_LONG
    unsigned held = 0;

    for (uint32_t r = 0; r < 500; r++) {
        unsigned here = 0;

        add_ishigami(10 + r, 640, 0);
        for (unsigned i = 0; i < 3; i++) {
            kelly_estimate first, total;

            CHECK(kelly_sobol_read(&sobol, i, &first, &total));
            here += first.lo <= first_true[i] && first_true[i] <= first.hi;
            here += total.lo <= total_true[i] && total_true[i] <= total.hi;
        }
        held += here;
    }
    check_text("  intervals that hold Ishigami's indices: ");
    check_decimal(held);
    check_text(" of 3000\n");
    CHECK(held > 2800 && held < 2910);
#endif
}

/* Indices have no unit and no origin. */
static void do_not_mind_scale(void)
{
    kelly_estimate first, total, first2, total2;

    add_ishigami(3, 640, 0);
    CHECK(kelly_sobol_read(&sobol, 0, &first, &total));
    add_ishigami(3, 640, 1);
    CHECK(kelly_sobol_read(&sobol, 0, &first2, &total2));
    CLOSE(first2.value, first.value, BY_REAL(2e-3, 1e-9));
    CLOSE(total2.hi, total.hi, BY_REAL(2e-3, 1e-9));
}

static void says_where_there_are_none(void)
{
    const wide constant[3] = { 4, 4, 4 };
    kelly_estimate first, total;
    wide mean, variance;

    kelly_sobol_clear(&sobol, 1);
    CHECK(!kelly_sobol_read(&sobol, 0, &first, &total));
    kelly_sobol_moments(&sobol, &mean, &variance);
    CHECK(mean == 0 && variance == 0);
    for (unsigned j = 0; j < 100; j++) {
        kelly_sobol_add(&sobol, constant);
    }
    CHECK(!kelly_sobol_read(&sobol, 0, &first, &total));
    kelly_sobol_moments(&sobol, &mean, &variance);
    CHECK(mean == 4 && variance == 0);
    add_ishigami(1, 63, 0);
    CHECK(!kelly_sobol_read(&sobol, 0, &first, &total));   /* a group of one row */
    add_ishigami(1, 64, 0);
    CHECK(kelly_sobol_read(&sobol, 0, &first, &total));
}

/* 64 rows, f 0 but in one of them: without its group nothing varies. */
static void one_group_is_not_enough(void)
{
    const wide still[3] = { 0, 0, 0 }, other[3] = { 1, 0, 1 };
    kelly_estimate first, total;

    kelly_sobol_clear(&sobol, 1);
    for (unsigned j = 0; j < 64; j++) {
        kelly_sobol_add(&sobol, j == 5 ? other : still);
    }
    CHECK(!kelly_sobol_read(&sobol, 0, &first, &total));
}

/* Where every group holds the same rows, leaving one out changes nothing. f(A) 0 1, f(B) 1 0, f(AB) 1 0: all of it is that parameter. */
static void equal_groups_leave_no_doubt(void)
{
    const wide row[2][3] = { { 0, 1, 1 }, { 1, 0, 0 } };
    kelly_estimate first, total;

    kelly_sobol_clear(&sobol, 1);
    for (unsigned j = 0; j < 64; j++) {
        kelly_sobol_add(&sobol, row[j / 32]);
    }
    CHECK(kelly_sobol_read(&sobol, 0, &first, &total));
    CHECK(first.value == 2 && first.lo == 2 && first.hi == 2);        /* two rows: B is always the other side of A */
    CHECK(total.value == 2 && total.lo == 2 && total.hi == 2);
}

/* 64 rows of 0 and `size` in f(A) and f(B), each group with both: a variance of size^2 / 4. */
static int reads_a_variance_of(wide size, kelly_estimate *first, kelly_estimate *total)
{
    const wide row[2][3] = { { 0, size, 1 }, { size, 0, 0 } };

    kelly_sobol_clear(&sobol, 1);
    for (unsigned j = 0; j < 64; j++) {
        kelly_sobol_add(&sobol, row[j / 32]);
    }
    return kelly_sobol_read(&sobol, 0, first, total);
}

/* What varies by rounding errors alone does not vary: a quotient by less than 1e-30 would leave the floats. */
static void hardly_varying_is_not_varying(void)
{
    kelly_estimate first, total;

    CHECK(reads_a_variance_of(W(1e-14), &first, &total));
    CHECK(total.value > W(1e27) && total.value < W(1e29));
    CHECK(!reads_a_variance_of(W(1e-16), &first, &total));
    CHECK(!reads_a_variance_of(W(1e-19), &first, &total));
}

static int same_draw(const kelly_draw *a, const kelly_draw *b)
{
    return a->fc == b->fc && a->mu == b->mu && a->a1 == b->a1 && a->a2 == b->a2 && a->w0 == b->w0;
}

/* A is the ensemble's own; B differs in all that is random; AB_i is A but for one parameter. */
static void draws_its_rows(void)
{
    kelly_case run;
    kelly_draw d[KELLY_SOBOL_ROW], own;

    fixture_case(&run, 100);
    EQUAL(kelly_sobol_row(&run, 5, 3, d), 2);              /* nothing random */
    for (unsigned k = 0; k < KELLY_PARAMETERS; k++) {
        run.cov[k] = k == 2 ? 0.0f : 0.2f;
    }
    EQUAL(kelly_sobol_row(&run, 5, 3, d), 6);
    kelly_draw_sample(&run, 5, 3, &own);
    CHECK(same_draw(&own, &d[0]));
    CHECK(d[1].fc != d[0].fc && d[1].mu != d[0].mu && d[1].a1 == d[0].a1 && d[1].a2 != d[0].a2 && d[1].w0 != d[0].w0);
    CHECK(same_draw(&d[2], &(kelly_draw){ d[1].fc, d[0].mu, d[0].a1, d[0].a2, d[0].w0 }));
    CHECK(same_draw(&d[3], &(kelly_draw){ d[0].fc, d[1].mu, d[0].a1, d[0].a2, d[0].w0 }));
    CHECK(same_draw(&d[4], &(kelly_draw){ d[0].fc, d[0].mu, d[0].a1, d[1].a2, d[0].w0 }));
    CHECK(same_draw(&d[5], &(kelly_draw){ d[0].fc, d[0].mu, d[0].a1, d[0].a2, d[1].w0 }));
    run.cov[2] = 0.2f;
    EQUAL(kelly_sobol_row(&run, 5, 3, d), 7);
    CHECK(d[1].a1 != d[0].a1);
    CHECK(same_draw(&d[4], &(kelly_draw){ d[0].fc, d[0].mu, d[1].a1, d[0].a2, d[0].w0 }));
}

void test_sobol(void);
void test_sobol(void)
{
    finds_the_indices_of_ishigami();
    keeps_its_formulas();
    intervals_cover();
    do_not_mind_scale();
    says_where_there_are_none();
    one_group_is_not_enough();
    equal_groups_leave_no_doubt();
    hardly_varying_is_not_varying();
    draws_its_rows();
}
