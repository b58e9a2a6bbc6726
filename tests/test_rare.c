/* test_rare.c - subset simulation on events whose probability is known, and where it must give no answer. */
#include "../firmware/detmath.h"
#include "../firmware/link/crc32c.h"
#include "check.h"
#include "fixture.h"

#define MOST BY_LENGTH(200, 2400)

static kelly_rare rare;
static kelly_rare_sample samples[MOST];
static uint32_t keys[MOST];
static kelly_rare_estimate answer;
static kelly_case looked;

/* Laws this narrow are normal to 1e-8 x^4 in the logarithm. */
static const float normals[KELLY_PARAMETERS] = { 0.001f, 0.001f, 0.001f, 0.001f, 0.001f };
static const float one_gamma[KELLY_PARAMETERS] = { 0.0f, 0.5f };

/* Grows like exp(1.2 x) over what is met. */
static float steep(float x)
{
    float y = x > -20.0f ? 1.0f + (x + 20.0f) / 32.0f : 1.0f;

    for (unsigned i = 0; i < 6; i++) {
        y *= y;
    }
    return y;
}

static float above(float x, float limit)
{
    return x > limit ? KELLY_RARE_FAILED : steep(x);
}

static float height(const float x[KELLY_PARAMETERS])
{
    return ((x[0] + x[1]) + (x[2] + x[3]) + x[4]) * 0.4472136f;
}

/* A plane in five standard normals: P = Phi(-limit). */
static float plane(const kelly_rare_sample *s, float limit)
{
    return above(height(s->x), limit);
}

/* One gamma of shape 4, mean 4: P = exp(-y) (1 + y + y^2/2 + y^3/6). */
static float far_out(const kelly_rare_sample *s, float limit)
{
    return above(kelly_gamma_value(s->x[1], 4.0f, 0.5f), limit);
}

/* Hints for it: a good one, 1.2 times the height, one that looks 25 degrees aside, one that points the other way. */
static const float along[KELLY_PARAMETERS] = { 0.5366563f, 0.5366563f, 0.5366563f, 0.5366563f, 0.5366563f };
static const float aside[KELLY_PARAMETERS] = { 0.9399773f, 0.3729754f, 0.3729754f, 0.3729754f, 0.3729754f };
static const float against[KELLY_PARAMETERS] = { -0.5366563f, -0.5366563f, -0.5366563f, -0.5366563f, -0.5366563f };
static const kelly_rare_hint good = { .plane = along }, blurred = { .plane = aside }, wrong = { .plane = against };
static const kelly_rare_hint *advised;

typedef enum { PLANE, FAR_OUT, CORNER, ISLAND, FREEZE, FLAT, REFUSE, REFUSE_FAR } event;

static float guide(event what, const kelly_rare_sample *s, float limit)
{
    switch (what) {
    case FAR_OUT:
        return far_out(s, limit);
    case CORNER:                                           /* two regions, none of which sees the other */
        return above(s->x[0] > 0 ? s->x[0] : -s->x[0], limit);
    case ISLAND:
        return s->x[0] < -3.0f ? KELLY_RARE_FAILED : plane(s, limit);
    case FREEZE:                                           /* beyond the first level nothing is let in */
        return rare.level > 0 ? 0.0f : plane(s, limit);
    case FLAT:                                             /* no way up */
        return 1.0f;
    case REFUSE:
        return height(s->x) > 1.9f ? KELLY_RARE_REFUSED : plane(s, limit);
    case REFUSE_FAR:                                       /* only where the first level does not come */
        return rare.level > 0 && height(s->x) > 2.0f ? KELLY_RARE_REFUSED : plane(s, limit);
    default:
        return plane(s, limit);
    }
}

/* To the end; 1 if there is an answer. */
static int simulate(event what, const float cov[KELLY_PARAMETERS], float limit, uint64_t seed, uint32_t n)
{
    CHECK(kelly_rare_start(&rare, cov, seed, n, samples, keys) == 0);
    if (advised) {
        kelly_rare_lead(&rare, advised);
    }
    while (kelly_rare_count(&rare) > 0) {
        for (uint32_t i = rare.first; i < rare.first + rare.count; i++) {
            samples[i].guide = guide(what, &samples[i], limit);
        }
        kelly_rare_accept(&rare);
    }
    if (rare.state == KELLY_RARE_DONE) {
        kelly_rare_read(&rare, &answer);
    }
    return rare.state == KELLY_RARE_DONE;
}

/* The last samples in one number: streams, laws, order and walk, the same on every machine and in both precisions. */
static uint32_t digest(uint32_t n)
{
    uint32_t crc = 0;

    for (uint32_t i = 0; i < n; i++) {
        uint8_t bytes[4 * (KELLY_PARAMETERS + 1)];

        for (unsigned k = 0; k <= KELLY_PARAMETERS; k++) {
            const union { float x; uint32_t bits; } u = { .x = k < KELLY_PARAMETERS ? samples[i].x[k] : samples[i].guide };

            for (unsigned b = 0; b < 4; b++) {
                bytes[4 * k + b] = (uint8_t)(u.bits >> (8 * b));
            }
        }
        crc = kelly_crc32c(crc, bytes, sizeof(bytes));
    }
    return crc;
}

static void has_the_same_bits_everywhere(void)
{
    CHECK(simulate(PLANE, normals, 2.3263f, 3, 200));
    EQUAL(rare.level, 2);
    EQUAL(digest(200), 0xf64c61ebu);
    CLOSE(answer.probability, W(0.01), W(0.006));
    (void)simulate(FAR_OUT, one_gamma, 9.0f, UINT64_C(0x123456789abcdef0), 200);
    EQUAL(digest(200), 0xcf846d9du);
    advised = &good;
    CHECK(simulate(PLANE, normals, 2.3263f, 3, 200));
    EQUAL(digest(200), 0x1f12a4dbu);
    advised = 0;
}

/* A good hint is accepted more often than straight moves are, a wrong one leads no more after one level. */
static void follows_a_hint_that_helps(void)
{
    advised = &good;
    CHECK(simulate(PLANE, normals, 3.0f, 5, 200) || rare.state == KELLY_RARE_FEW);
    CHECK(rare.leads);
    for (uint32_t l = 1; l <= rare.level; l++) {
        EQUAL(rare.levels[l].led, 120);                    /* six moves of nine, 20 chains */
        CHECK(rare.levels[l].led_accepted * 2 > rare.levels[l].led);
        CHECK(rare.levels[l].accepted >= rare.levels[l].led_accepted && rare.levels[l].proposed == 180);
    }
    advised = &wrong;
    (void)simulate(PLANE, normals, 4.0f, 5, 200);
    CHECK(!rare.leads && rare.level >= 2);
    EQUAL(rare.levels[rare.level].led, 0);
    advised = 0;
}

/* The hint leads on where a fifth of its moves is accepted, and not where fewer are. */
static void drops_a_hint_below_a_fifth(void)
{
    for (unsigned enough = 0; enough < 2; enough++) {
        kelly_rare_level *const level = &rare.levels[1];

        advised = &good;
        CHECK(kelly_rare_start(&rare, normals, 5, 200, samples, keys) == 0);
        kelly_rare_lead(&rare, advised);
        while (kelly_rare_count(&rare) > 0 && !(rare.level == 1 && rare.quarter == 0 && rare.at == KELLY_RARE_STATES - 1)) {
            for (uint32_t i = rare.first; i < rare.first + rare.count; i++) {
                samples[i].guide = plane(&samples[i], 3.0f);
            }
            kelly_rare_accept(&rare);
        }
        for (uint32_t i = rare.first; i < rare.first + rare.count; i++) {
            samples[i].guide = 0;                          /* none of these last five is accepted */
        }
        level->led = 1000 - (rare.at % 3 != 0 ? rare.count : 0);
        level->led_accepted = 199 + enough;
        kelly_rare_accept(&rare);
        EQUAL(level->led, 1000);
        EQUAL(rare.leads, enough);
    }
    advised = 0;
}

/* A move that the laws refuse leaves its sample as it was, to be run again. */
static void runs_a_refused_move_again(void)
{
    static const float wide_laws[KELLY_PARAMETERS] = { 0.5f, 0.5f, 0.5f, 0.5f, 0.5f };
    uint32_t again = 0, moves = 0;

    CHECK(kelly_rare_start(&rare, wide_laws, 3, 200, samples, keys) == 0);
    while (kelly_rare_count(&rare) > 0) {
        for (uint32_t i = rare.first; i < rare.first + rare.count; i++) {
            const kelly_rare_sample *const old = rare.level > 0 ? &samples[i - rare.chains] : 0;

            moves += rare.level > 0;
            if (old && samples[i].id == old->id) {
                again++;
                CHECK(samples[i].x[0] == old->x[0] && samples[i].x[4] == old->x[4] && samples[i].guide == old->guide);
            }
            samples[i].guide = plane(&samples[i], 4.0f);
        }
        kelly_rare_accept(&rare);
    }
    CHECK(again > 0 && again < moves / 4);
}

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
    looked.w0 = R(12.0);                                   /* the third mode is at 13.85 rad/s */
    looked.f0 = R(95000.0);
    looked.cov[4] = 0.05f;
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
        x[4] = kelly_gamma_normal(&rng, 0.05f);
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
}

/* An answer that has the failures a look has found stands, and one that lacks them does not, if they matter. */
static void compares_with_a_look(void)
{
    const kelly_rare_hint hint = { .table = &kelly_string, .run = &looked };

    for (unsigned k = 0; k < 4; k++) {                     /* none, none but few, all, none but uncertain */
        const wide ratio[4] = { 8, W(0.19), 1, 8 };
        kelly_rare_seen seen = { .tried = 20, .failed = 10, .variance = k == 3 ? W(9.0) : W(0.01) };

        CHECK(simulate(PLANE, normals, 2.3263f, 3, 200));
        for (uint32_t i = 0; i < 200; i++) {               /* at the mean, or where the third mode is */
            for (unsigned m = 0; m < KELLY_PARAMETERS; m++) {
                samples[i].x[m] = 0.0f;
            }
            samples[i].x[4] = k == 2 ? 2.95f : 0.0f;
        }
        CHECK((kelly_rare_resonance(&hint, samples[0].x, 2) > (float)looked.limit * 0.4f) == (k == 2));
        seen.probability = answer.probability * ratio[k];
        kelly_rare_compare(&rare, &hint, 2, &seen);
        EQUAL(rare.state, k == 0 ? KELLY_RARE_ELSEWHERE : KELLY_RARE_DONE);
    }
}

static void draws_what_kelly_run_draws(void)
{
    kelly_case run;

    fixture_case(&run, 100);
    run.cov[0] = run.cov[3] = 0.2f;
    run.cov[4] = 0.5f;
    CHECK(kelly_rare_start(&rare, run.cov, 11, 200, samples, keys) == 0);
    for (uint32_t j = 0; j < 200; j += 17) {
        kelly_draw one, other;

        kelly_rare_draw(&run, &samples[j], &one);
        kelly_draw_sample(&run, 11, j, &other);
        CHECK(one.fc == other.fc && one.mu == other.mu && one.a1 == other.a1 && one.a2 == other.a2 && one.w0 == other.w0);
        CHECK(one.mu == run.mu && samples[j].x[1] == 0);
    }
}

static void expect(kelly_rare_state state, event what, float limit, uint64_t seed)
{
    CHECK(!simulate(what, normals, limit, seed, 200));
    EQUAL(rare.state, state);
    EQUAL(kelly_rare_count(&rare), 0);
}

static void refuses_with_a_reason(void)
{
    static const float nothing[KELLY_PARAMETERS] = { 0 };

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

/* A led move goes only where the hint lets it, here down from the edge of a steep plane, and stays where none of its steps does; and where it
 * came from below the level, mostly, as that was less likely. */
static void stays_where_it_must(void)
{
    static const float down[KELLY_PARAMETERS] = { -1e6f }, up[KELLY_PARAMETERS] = { 1.0f };
    static const kelly_rare_hint cliff = { .plane = down }, slope = { .plane = up };
    const float old[KELLY_PARAMETERS] = { -6.0f }, low[KELLY_PARAMETERS] = { 0.5f };
    float next[KELLY_PARAMETERS];
    unsigned moved = 0;
    kelly_rng rng;

    CHECK(kelly_rare_start(&rare, normals, 1, 200, samples, keys) == 0);
    kelly_rare_lead(&rare, &cliff);
    rare.hint_level = 6e6f;
    for (uint32_t j = 0; j < 200; j++) {
        kelly_rng_key(&rng, 1, j, 0);
        if (kelly_rare_move(&rare, &rng, 1, old, next)) {
            CHECK(next[0] < old[0]);
            moved++;
        } else {
            CHECK(next[0] == old[0] && next[1] == old[1]);
        }
    }
    CHECK(moved > 0 && moved < 200);
    kelly_rare_lead(&rare, &slope);
    rare.hint_level = 1.0f;                                /* e^-4.5 of the weight that it has beyond 1 */
    moved = 0;
    for (uint32_t j = 0; j < 50; j++) {
        kelly_rng_key(&rng, 2, j, 0);
        moved += (unsigned)kelly_rare_move(&rare, &rng, 1, low, next);
    }
    CHECK(moved > 0 && moved < 25);
}

/* Seeds whose guides say nothing leave the hint's level at the guide's own. */
static void aims_without_seeds(void)
{
    CHECK(kelly_rare_start(&rare, normals, 1, 200, samples, keys) == 0);
    advised = &good;
    kelly_rare_lead(&rare, advised);
    for (uint32_t i = 0; i < rare.chains; i++) {
        samples[i].guide = i % 2 != 0 ? 0.0f : KELLY_RARE_FAILED;
    }
    rare.guide = 0;
    kelly_rare_aim(&rare);
    CLOSE((wide)rare.hint_level, W(-69.0775528), W(1e-4));     /* ln 1e-30 */
    advised = 0;
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

/* Logarithm of R^4 (forced + swing) at the means of a case by rare.h, otherwise than rare_guide.c: H is 1 / sum of admittances in wide. */
static wide log_guess(const kelly_case *run)
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
    return 4 * kelly_log(x > W(1e-6) ? x : W(1e-6)) + kelly_log(forced + decay * swing);
}

/* Negative and positive damping, short and long runs, from rest and turning; beyond the laws or the table: far below all others. */
static void guesses_from_the_linear_string(void)
{
    static const real speeds[] = { R(4.0), R(10.0), R(18.0), R(0.5) };
    float x[KELLY_PARAMETERS] = { 0 };
    kelly_case run;
    const kelly_rare_hint hint = { .table = &kelly_string, .run = &run };

    fixture_case(&run, 100000);
    run.mu = R(0.004);
    for (unsigned k = 0; k < 16; k++) {
        run.w0 = speeds[k / 4];
        run.rotating = k & 1u;
        run.window_first = (k & 2u) != 0 ? 2000000 : 50000;
        CLOSE((wide)kelly_rare_guess(&hint, x), log_guess(&run), W(2e-3));
    }
    run.cov[0] = 0.5f;
    CHECK(kelly_rare_guess(&hint, x) > -1e5f);
    run.fc = kelly_string.fc_max / 2;
    x[0] = 6.0f;                                           /* more weight than the table has */
    CHECK(kelly_rare_guess(&hint, x) < -1e5f);
    x[0] = -40.0f;                                         /* no gamma variable is negative */
    CHECK(kelly_rare_guess(&hint, x) < -1e5f);
    run.cov[1] = 0.5f;
    x[0] = 0.0f;
    x[1] = -40.0f;
    CHECK(kelly_rare_guess(&hint, x) == kelly_rare_guess(&hint, (const float[KELLY_PARAMETERS]){ -40.0f }));
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
    has_the_same_bits_everywhere();
    follows_a_hint_that_helps();
    drops_a_hint_below_a_fifth();
    runs_a_refused_move_again();
    leaves_samples_of_the_event();
    is_plain_where_that_is_enough();
    knows_luck();
    looks_at_resonances();
    compares_with_a_look();
    draws_what_kelly_run_draws();
    refuses_with_a_reason();
    reports_nothing_below_its_least();
    ends_its_interval_at_one();
    stays_where_it_must();
    aims_without_seeds();
    guesses_from_the_linear_string();
    guides_by_the_negative_damping();
    runs_given_draws();
#if CHECK_LONG
    is_right_on_average();
#endif
}
