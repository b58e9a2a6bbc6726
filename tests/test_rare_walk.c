/* test_rare_walk.c - the walk of subset simulation: its bits, the hint that leads it, and moves that stay. */
#include "../firmware/link/crc32c.h"
#include "check.h"
#include "rare_events.h"

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

/* A spread below the mean of ln guide - ln hint over the seeds that know both. */
static void aims_at_the_guide(void)
{
    static const float along[KELLY_PARAMETERS] = { 1.0f };
    static const kelly_rare_hint hint = { .plane = along };

    CHECK(kelly_rare_start(&rare, normals, 1, 200, samples, keys) == 0);
    kelly_rare_lead(&rare, &hint);
    for (uint32_t i = 0; i < rare.chains; i++) {           /* ln guide - ln hint is -2 or 1, of a failure nothing */
        samples[i].x[0] = i % 2 != 0 ? 2.0f : -1.0f;
        samples[i].guide = i % 5 == 4 ? KELLY_RARE_FAILED : 1.0f;
    }
    rare.guide = 1.0f;
    kelly_rare_aim(&rare);
    CLOSE((wide)rare.hint_level, W(0.5) - W(1.5), W(1e-5));
    for (uint32_t i = 0; i < rare.chains; i++) {           /* one alone has no spread */
        samples[i].guide = i == 1 ? 1.0f : KELLY_RARE_FAILED;
    }
    kelly_rare_aim(&rare);
    CLOSE((wide)rare.hint_level, W(2.0), W(1e-5));
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

void test_rare_walk(void);
void test_rare_walk(void)
{
    has_the_same_bits_everywhere();
    follows_a_hint_that_helps();
    drops_a_hint_below_a_fifth();
    runs_a_refused_move_again();
    stays_where_it_must();
    aims_at_the_guide();
    aims_without_seeds();
}
