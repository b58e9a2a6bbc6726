/* rare.h but its walk and the string: levels of 40 samples from the first to the last, any guides, any state of the chains. What a move
 * comes to and where the hint stands (rare_walk.c) are stubs, and so are the laws (random.c) and the interval (interval.c). */
#include "rare.h"
#include "contracts.h"

#define SAMPLES 40u                      /* of a level; at the start KELLY_RARE_MIN */
#define CHAINS (SAMPLES / KELLY_RARE_STATES)
#define X 1e3f                           /* random.h */

/* random.c */
uint64_t kelly_splitmix64(uint64_t *state)
{
    *state = any_u64();
    return any_u64();
}

void kelly_rng_key(kelly_rng *rng, uint64_t seed, uint32_t index, uint32_t stream)
{
    (void)seed, (void)index, (void)stream;
    ANY(*rng);
}

float kelly_gamma_normal(kelly_rng *rng, float cov)
{
    (void)rng;
    //@ assert 1e-4f <= cov <= 0.5;
    return Frama_C_float_interval(-X, X);
}

/* walk.c */
int kelly_rare_move(const kelly_rare *rare, kelly_rng *rng, int led, const float old[KELLY_PARAMETERS], float next[KELLY_PARAMETERS])
{
    (void)rare, (void)rng, (void)led;
    for (unsigned k = 0; k < KELLY_PARAMETERS; k++) {
        //@ assert -X <= old[k] <= X;
        next[k] = Frama_C_float_interval(-X, X);
    }
    return Frama_C_interval(0, 1);
}

void kelly_rare_aim(kelly_rare *rare) { rare->hint_level = Frama_C_float_interval(-1e9f, 1e9f); }

/* interval.c */
wide kelly_binomial_lo(uint32_t k, uint32_t n, wide tail)
{
    (void)k, (void)tail;
    //@ assert n >= 1;
    return any_wide(0, 1);
}

wide kelly_binomial_hi(uint32_t k, uint32_t n, wide tail) { return kelly_binomial_lo(k, n, tail); }

static kelly_rare rare;
static kelly_rare_sample first[KELLY_RARE_MIN], samples[SAMPLES];
static uint32_t keys[KELLY_RARE_MIN];
static const kelly_rare_hint hint;

static void any_samples(float least)
{
    for (unsigned i = 0; i < SAMPLES; i++) {
        for (unsigned k = 0; k < KELLY_PARAMETERS; k++) {
            samples[i].x[k] = Frama_C_float_interval(-X, X);
        }
        samples[i].guide = Frama_C_float_interval(least, ANY_FLOAT);
        samples[i].id = any_u32();
        samples[i].find = any_u32();
    }
}

static void any_levels(void)
{
    for (unsigned i = 0; i < KELLY_RARE_LEVELS; i++) {
        kelly_rare_level *const level = &rare.levels[i];

        level->guide = Frama_C_float_interval(0, ANY_FLOAT);
        level->step = Frama_C_float_interval(0.02f, 1.0f);
        level->failed = Frama_C_unsigned_int_interval(0, SAMPLES);
        level->refused = Frama_C_unsigned_int_interval(0, SAMPLES);
        level->proposed = Frama_C_unsigned_int_interval(0, SAMPLES);
        level->accepted = Frama_C_unsigned_int_interval(0, SAMPLES);
        level->led = Frama_C_unsigned_int_interval(0, SAMPLES);
        level->led_accepted = Frama_C_unsigned_int_interval(0, SAMPLES);
        level->inside = Frama_C_unsigned_int_interval(1, SAMPLES);
        level->variance = any_wide(0, 1e9);
    }
}

static void any_rare(void)
{
    any_samples(0);
    ANY(keys);
    any_levels();
    for (unsigned k = 0; k < KELLY_PARAMETERS; k++) {
        rare.cov[k] = Frama_C_float_interval(0, 0.5f);
    }
    rare.seed = any_u64();
    rare.n = SAMPLES;
    rare.chains = CHAINS;
    rare.samples = samples;
    rare.keys = keys;
    rare.state = KELLY_RARE_RUNNING;
    rare.realisations = any_u32();
    rare.straight = Frama_C_unsigned_int_interval(0, SAMPLES);
    rare.straight_accepted = Frama_C_unsigned_int_interval(0, SAMPLES);
    rare.step = Frama_C_float_interval(0.02f, 1.0f);
    rare.hint = &hint;
    rare.leads = Frama_C_interval(0, 1);
    rare.hint_level = Frama_C_float_interval(-1e9f, 1e9f);
    rare.guide = Frama_C_float_interval(0, ANY_FLOAT);
    rare.distinct = Frama_C_unsigned_int_interval(0, SAMPLES);
    rare.finds = Frama_C_float_interval(0, 1e6f);
}

static void check(void)
{
    //@ assert rare.level < KELLY_RARE_LEVELS;
    //@ assert rare.first + rare.count <= SAMPLES;
    //@ assert 0.02f <= rare.step <= 1;
    //@ assert 0 <= rare.finds <= 1e6;
    for (unsigned i = 0; i < KELLY_RARE_LEVELS; i++) {
        //@ assert rare.levels[i].inside <= SAMPLES;
        //@ assert 0 <= rare.levels[i].variance <= 1e9;
    }
    (void)kelly_rare_count(&rare);
}

/* A level of which no draw is refused; or one that has one from the start, for those that have one. */
static void first_level(uint32_t refused)
{
    any_rare();
    any_samples(refused > 0 ? KELLY_RARE_REFUSED : 0);
    rare.level = rare.first = 0;
    rare.count = SAMPLES;
    rare.levels[0].refused = refused;
    kelly_rare_accept(&rare);
    check();
}

/* The moves to state `at` of a quarter of the chains are judged, which all can be run, or none. */
static void further_level(uint32_t low, uint32_t high, uint32_t quarter, uint32_t at, int refused)
{
    any_rare();
    rare.level = Frama_C_unsigned_int_interval(low, high);
    rare.quarter = quarter;
    rare.at = at;
    rare.first = at * CHAINS + quarter * (CHAINS / 4);
    rare.count = CHAINS / 4;
    for (uint32_t i = rare.first; i < rare.first + rare.count; i++) {
        samples[i].guide = refused ? KELLY_RARE_REFUSED : Frama_C_float_interval(0, ANY_FLOAT);
    }
    kelly_rare_accept(&rare);
    check();
}

/* Of levels of n samples. */
static void answer(uint32_t low, uint32_t high, uint32_t n)
{
    kelly_rare_estimate estimate;

    any_rare();
    for (unsigned i = 0; i < KELLY_RARE_LEVELS; i++) {
        rare.levels[i].inside = Frama_C_unsigned_int_interval(1, n);
    }
    rare.n = n;
    rare.level = Frama_C_unsigned_int_interval(low, high);
    rare.levels[0].failed = Frama_C_unsigned_int_interval(n / KELLY_RARE_STATES, n);
    rare.levels[0].refused = Frama_C_unsigned_int_interval(0, n - n / KELLY_RARE_STATES);
    kelly_rare_read(&rare, &estimate);
    //@ assert 0 <= estimate.cov <= 1e20;
}

int main(void)
{
    float cov[KELLY_PARAMETERS];

    for (unsigned k = 0; k < KELLY_PARAMETERS; k++) {
        cov[k] = Frama_C_float_interval(0, 0.5f);
    }
    (void)kelly_rare_start(&rare, cov, any_u64(), Frama_C_unsigned_int_interval(0, KELLY_RARE_MIN - 1), first, keys);
    (void)kelly_rare_start(&rare, cov, any_u64(), KELLY_RARE_MIN + 1, first, keys);
    (void)kelly_rare_start(&rare, cov, any_u64(), Frama_C_unsigned_int_interval(KELLY_RARE_MAX + 1, UINT32_MAX), first, keys);
    (void)kelly_rare_start(&rare, cov, any_u64(), KELLY_RARE_MIN, first, keys);
    kelly_rare_lead(&rare, &hint);
    first_level(0);
    first_level(1);
    //@ loop unroll 4;
    for (uint32_t quarter = 0; quarter < 4; quarter++) {
        //@ loop unroll 9;
        for (uint32_t at = 1; at < KELLY_RARE_STATES; at++) {
            further_level(1, KELLY_RARE_LEVELS - 2, quarter, at, 0);
            further_level(1, KELLY_RARE_LEVELS - 2, quarter, at, 1);
        }
    }
    further_level(KELLY_RARE_LEVELS - 1, KELLY_RARE_LEVELS - 1, 3, KELLY_RARE_STATES - 1, 0);
    rare.count = 0;
    kelly_rare_accept(&rare);
    answer(0, 0, KELLY_RARE_MIN);
    answer(0, 0, KELLY_RARE_MAX);
    answer(1, KELLY_RARE_LEVELS - 1, KELLY_RARE_MIN);
    answer(1, KELLY_RARE_LEVELS - 1, KELLY_RARE_MAX);
    (void)kelly_rare_failed(&samples[0]);
    (void)kelly_rare_reason((kelly_rare_state)any_u32());
    return 0;
}
