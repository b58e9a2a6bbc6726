/* test_rare.c - subset simulation on events whose probability is known, and where it must give no answer. */
#include "check.h"
#include "rare_events.h"

static int is_first(uint32_t i)
{
    for (uint32_t j = 0; j < i; j++) {
        if (samples[j].id == samples[i].id) {
            return 0;
        }
    }
    return 1;
}

/* Squared coefficient of variation of the last level's p, eq. 27 and 29 of Au and Beck: of chains `chains` apart in the samples. */
static wide spread_of_the_last_level(void)
{
    const wide n = (wide)rare.n, p = (wide)rare.levels[rare.level].failed / n;
    wide gamma = 0;

    for (uint32_t lag = 1; lag < KELLY_RARE_STATES; lag++) {
        uint32_t both = 0;

        for (uint32_t i = 0; i < rare.n - lag * rare.chains; i++) {
            both += kelly_rare_failed(&samples[i]) && kelly_rare_failed(&samples[i + lag * rare.chains]);
        }
        gamma += 2 * (1 - W(0.1) * (wide)lag) * ((wide)both / (n - (wide)(lag * rare.chains)) - p * p) / (p - p * p);
    }
    return (1 - p) / (p * n) * (1 + (gamma > 0 ? gamma : 0));
}

/* Copies share their id and everything else; the last event holds its samples. */
static void leaves_samples_of_the_event(void)
{
    uint32_t failed = 0, distinct = 0;

    CHECK(simulate(PLANE, normals, 2.3263f, 3, 200));
    for (uint32_t i = 0; i < 200; i++) {
        CHECK(samples[i].guide >= rare.guide);
        CHECK(samples[i].guide == plane(&samples[i], 2.3263f));
        CHECK(samples[i].id < rare.realisations);
        failed += (uint32_t)kelly_rare_failed(&samples[i]);
        distinct += kelly_rare_failed(&samples[i]) && is_first(i);
    }
    EQUAL(failed, rare.levels[rare.level].failed);
    EQUAL(rare.realisations, 200 + 180 * rare.level);
    EQUAL(rare.distinct, distinct);
    CLOSE(rare.levels[rare.level].variance / spread_of_the_last_level(), 1, W(1e-5));
    CHECK(spread_of_the_last_level() > W(1.2) * (200 - (wide)failed) / (200 * (wide)failed));    /* the chains do depend */
    CHECK(distinct >= KELLY_RARE_DISTINCT && distinct < failed);
}

/* An event without a spread is the guide's own zero, whatever its sign, and lies below all others. */
static void orders_guides_of_both_zeros(void)
{
    CHECK(kelly_rare_start(&rare, normals, 1, 200, samples, keys) == 0);
    for (uint32_t i = 0; i < 200; i++) {
        samples[i].guide = i % 5 == 0 ? 1.0f + (float)(int32_t)i : i % 2 != 0 ? -0.0f : 0.0f;
    }
    kelly_rare_accept(&rare);
    CHECK(rare.level == 1 && rare.guide == 101.0f);        /* the twentieth of 1, 6, .. 196 */
}

/* A law of hardly any width is none, as in kelly_draw_sample: its parameter stays at the mean. */
static void leaves_narrow_laws_alone(void)
{
    static const float mixed[KELLY_PARAMETERS] = { 0.01f, 0.9e-4f, 0.01f, 1e-4f, 1e-30f };

    CHECK(kelly_rare_start(&rare, mixed, 1, 200, samples, keys) == 0);
    for (uint32_t i = 0; i < 200; i++) {
        CHECK(samples[i].x[0] != 0 && samples[i].x[1] == 0 && samples[i].x[2] != 0 && samples[i].x[3] != 0 && samples[i].x[4] == 0);
    }
}

/* The first level holds a tenth of failures: counts, as montecarlo has them. */
static void is_plain_where_that_is_enough(void)
{
    CHECK(simulate(PLANE, normals, 0.0f, 3, 200));
    CHECK(answer.plain && rare.level == 0 && rare.realisations == 200);
    /* (1 - p) / (p n) */
    CLOSE(rare.levels[0].variance * 200 * (wide)rare.levels[0].failed / (wide)(200 - rare.levels[0].failed), 1, W(1e-6));
    CLOSE(answer.probability, (wide)rare.levels[0].failed / 200, W(1e-7));
    CHECK(answer.lo == kelly_binomial_lo(rare.levels[0].failed, 200, W(0.025)));
    CHECK(answer.hi == kelly_binomial_hi(rare.levels[0].failed, 200, W(0.025)));
    CHECK(simulate(PLANE, normals, -30.0f, 3, 200));       /* P = 1: no spread, no 0/0 */
    CHECK(answer.probability == 1 && answer.hi == 1 && answer.lo > W(0.98) && answer.cov == 0);
    CHECK(simulate(REFUSE, normals, -0.5f, 3, 200) && answer.plain);
}

/* Two places: an island of P = Phi(-3) that nothing leads to, and a rarer one up the plane. Where a sample of the first level lies on the
 * island, all failures descend from the one or two that do; where none does, from many, up the plane. */
static void knows_luck(void)
{
    unsigned lucky = 0;

    for (uint64_t seed = 1; seed <= 12; seed++) {
        const int answered = simulate(ISLAND, normals, 4.0f, seed, 200);
        uint32_t on_island = 0;

        for (uint32_t i = 0; i < 200; i++) {
            on_island += kelly_rare_failed(&samples[i]) && samples[i].x[0] < -2.0f ? 1u : 0u;
        }
        if (on_island > 20) {
            lucky++;
            CHECK(!answered && rare.state == KELLY_RARE_LUCK && rare.finds >= 1.0f && rare.finds < KELLY_RARE_FINDS(200));
        } else {
            CHECK(!answered || rare.finds >= KELLY_RARE_FINDS(200));
        }
    }
    CHECK(lucky > 0);
}

static void expect(kelly_rare_state state, event what, float limit, uint64_t seed)
{
    CHECK(!simulate(what, normals, limit, seed, 200));
    EQUAL(rare.state, state);
    EQUAL(kelly_rare_count(&rare), 0);
}

static void refuses_with_a_reason(void)
{
    static const float nothing[KELLY_PARAMETERS] = { 0 }, hardly[KELLY_PARAMETERS] = { 0.9e-4f };

    expect(KELLY_RARE_NO_FAILURE, PLANE, 50.0f, 1);
    CHECK(rare.level >= 8 && rare.level + 1 < KELLY_RARE_LEVELS);
    expect(KELLY_RARE_STILL, FREEZE, 4.0f, 1);
    EQUAL(rare.level, 1);
    expect(KELLY_RARE_DEEP, FLAT, 4.0f, 1);
    CHECK(rare.levels[1].inside == 200 && rare.levels[1].variance == 0);   /* p = 1: no 0/0 */
    expect(KELLY_RARE_UNKNOWN, REFUSE, 4.0f, 1);
    CHECK(rare.levels[rare.level].refused > 0);
    expect(KELLY_RARE_FEW, PLANE, 2.6f, 3);
    CHECK(rare.distinct < KELLY_RARE_DISTINCT && rare.levels[rare.level].failed >= 20);
    expect(KELLY_RARE_UNKNOWN, REFUSE_FAR, 4.0f, 1);
    CHECK(rare.level > 0 && rare.levels[0].refused == 0 && rare.levels[rare.level].refused > 0);
    kelly_rare_accept(&rare);                              /* over is over */
    EQUAL(rare.state, KELLY_RARE_UNKNOWN);
    CHECK(kelly_rare_start(&rare, nothing, 1, 200, samples, keys) != 0);
    CHECK(kelly_rare_start(&rare, hardly, 1, 200, samples, keys) != 0);
    CHECK(kelly_rare_start(&rare, normals, 1, 160, samples, keys) != 0);
    CHECK(kelly_rare_start(&rare, normals, 1, 210, samples, keys) != 0);
    CHECK(kelly_rare_start(&rare, normals, 1, KELLY_RARE_MAX + 40u, samples, keys) != 0);
    for (int state = 0; state < KELLY_RARE_OUTCOMES; state++) {
        CHECK(kelly_rare_reason((kelly_rare_state)state)[0] != 0);
    }
    CHECK(kelly_rare_reason((kelly_rare_state)KELLY_RARE_OUTCOMES)[0] != 0);
}

/* With failures under 1e-9: too few to end a level there, or enough. */
static void reports_nothing_below_its_least(void)
{
    expect(KELLY_RARE_TOO_RARE, PLANE, 6.3f, 1);
    CHECK(rare.levels[rare.level].failed > 0 && rare.levels[rare.level].failed < rare.chains);
    expect(KELLY_RARE_TOO_RARE, PLANE, 6.1f, 1);
    CHECK(rare.levels[rare.level].failed >= rare.chains && kelly_rare_product(&rare) < KELLY_RARE_LEAST);
}

/* P = 0.81 known within a factor of ten: the interval ends at 1. */
static void ends_its_interval_at_one(void)
{
    rare = (kelly_rare){ .n = 200, .level = 1, .levels = { { .inside = 180, .variance = W(0.02) }, { .inside = 180, .variance = W(0.03) } } };
    kelly_rare_read(&rare, &answer);
    CLOSE(answer.probability, W(0.81), W(1e-6));
    CLOSE(answer.cov, W(0.2795085), W(1e-6));              /* 1.25 sqrt(0.05) */
    CLOSE(answer.lo, W(0.4714750), W(1e-5));               /* P exp(-1.96 1.25 sqrt(ln 1.05)) */
    CHECK(!answer.plain && answer.hi == 1);
    rare.levels[1].inside = 20;
    kelly_rare_read(&rare, &answer);
    CLOSE(answer.hi, W(0.1546211), W(1e-5));
}

#if CHECK_LONG
/* Mean of `runs` answers within four standard errors of P, and at least `most` intervals hold it. */
static void study(event what, const float cov[KELLY_PARAMETERS], float limit, wide p, unsigned runs, unsigned hold, wide most_spread)
{
    wide sum = 0, squares = 0, mean, variance;
    unsigned held = 0;

    for (unsigned seed = 1; seed <= runs; seed++) {
        CHECK(simulate(what, cov, limit, seed, MOST));
        sum += answer.probability / p;
        squares += answer.probability / p * (answer.probability / p);
        held += answer.lo <= p && p <= answer.hi;
    }
    mean = sum / runs;
    variance = squares / runs - mean * mean;
    CHECK((mean - 1) * (mean - 1) * runs < 16 * variance);
    CLOSE(variance, 0, most_spread * most_spread);
    CHECK(held >= hold);
}

static void is_right_on_average(void)
{
    static const kelly_rare_hint *const advices[] = { 0, &good, &blurred, &wrong };

    for (unsigned i = 0; i < 4; i++) {
        advised = advices[i];
        study(PLANE, normals, 2.326348f, W(1e-2), 100, 90, W(0.17));
        study(PLANE, normals, 4.753424f, W(1e-6), 100, advised == &wrong ? 85 : 90, advised == &good ? W(0.25) : W(0.42));
    }
    advised = 0;
    study(PLANE, normals, 0.0f, W(0.5), 100, 90, W(0.05));
    study(PLANE, normals, 2.326348f, W(1e-2), 100, 90, W(0.15));
    study(PLANE, normals, 3.090232f, W(1e-3), 100, 90, W(0.2));
    study(PLANE, normals, 4.753424f, W(1e-6), 100, 90, W(0.35));
    study(PLANE, normals, 5.612001f, W(1e-8), 100, 90, W(0.55));
    study(FAR_OUT, one_gamma, 15.913814f, W(1e-4), 100, 90, W(0.25));
    study(CORNER, normals, 3.0902323f, W(2e-3), 100, 90, W(0.2));
}
#endif

void test_rare(void);
void test_rare(void)
{
    leaves_samples_of_the_event();
    orders_guides_of_both_zeros();
    leaves_narrow_laws_alone();
    is_plain_where_that_is_enough();
    knows_luck();
    refuses_with_a_reason();
    reports_nothing_below_its_least();
    ends_its_interval_at_one();
#if CHECK_LONG
    is_right_on_average();
#endif
}
