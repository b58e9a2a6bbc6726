/* The look of rare.h: searches in any state, of 40 samples; of a comparison, with each of them a failure in turn. Stubs: the search (rare.c), the
 * resonance (guide.c). */
#include "rare.h"
#include "contracts.h"

#define SAMPLES 40u
#define CHAINS (SAMPLES / KELLY_RARE_STATES)

static kelly_rare rare;
static kelly_rare_sample samples[SAMPLES];
static kelly_case run;
static const kelly_rare_hint hint = { .run = &run };

/* guide.c */
float kelly_rare_resonance(const kelly_rare_hint *at, const float x[KELLY_PARAMETERS], unsigned mode)
{
    (void)at, (void)x, (void)mode;
    return Frama_C_float_interval(0, 1e38f);
}

float kelly_rare_own(const kelly_rare_hint *at) { return kelly_rare_resonance(at, 0, 0); }

/* rare.c */
int kelly_rare_failed(const kelly_rare_sample *sample) { return sample->guide >= KELLY_RARE_FAILED; }
uint32_t kelly_rare_count(const kelly_rare *at) { return at->count; }

static void any_state(void)
{
    for (unsigned i = 0; i < SAMPLES; i++) {
        for (unsigned k = 0; k < KELLY_PARAMETERS; k++) {
            samples[i].x[k] = Frama_C_float_interval(-1e3f, 1e3f);
        }
        samples[i].guide = Frama_C_float_interval(KELLY_RARE_REFUSED, ANY_FLOAT);
    }
    for (unsigned i = 0; i < KELLY_RARE_LEVELS; i++) {
        rare.levels[i].failed = Frama_C_unsigned_int_interval(0, SAMPLES);
        rare.levels[i].inside = Frama_C_unsigned_int_interval(1, SAMPLES);
        rare.levels[i].variance = any_wide(0, 1e9);
    }
    rare.state = (kelly_rare_state)Frama_C_unsigned_int_interval(0, KELLY_RARE_OUTCOMES - 1);
    rare.level = Frama_C_unsigned_int_interval(0, KELLY_RARE_LEVELS - 1);
    rare.n = SAMPLES;
    rare.chains = CHAINS;
    rare.step = Frama_C_float_interval(0.02f, 1.0f);
    rare.quarter = Frama_C_unsigned_int_interval(0, 3);
    rare.at = Frama_C_unsigned_int_interval(1, KELLY_RARE_STATES - 1);
    rare.samples = samples;
    rare.finds = Frama_C_float_interval(1.0f, 1.1e12f);
    rare.first = Frama_C_nondet(0, 1) ? CHAINS : SAMPLES / 2;
    rare.count = Frama_C_nondet(0, 1) ? 0 : CHAINS / 4;
    run.limit = any_real(0, R(10.0));
}

void kelly_rare_accept(kelly_rare *at)
{
    (void)at;
    for (unsigned i = 0; i < SAMPLES; i++) {
        //@ assert samples[i].guide >= KELLY_RARE_REFUSED;
    }
    any_state();
}

/* interval.c */
wide kelly_binomial_lo(uint32_t k, uint32_t n, wide tail)
{
    (void)k, (void)tail;
    //@ assert n >= 1;
    return any_wide(0, 1);
}

wide kelly_binomial_hi(uint32_t k, uint32_t n, wide tail) { return kelly_binomial_lo(k, n, tail); }

static void look(void)
{
    any_state();
    kelly_rare_look(&rare, &hint, Frama_C_unsigned_int_interval(0, KELLY_MODES_MAX - 1), any_wide(0, 1),
                    Frama_C_unsigned_int_interval(1, KELLY_RARE_MAX));
    //@ assert rare.count <= SAMPLES;
}

static void see(uint32_t count)
{
    kelly_rare_seen seen;

    any_state();
    rare.count = count;
    kelly_rare_see(&rare, &seen);
    //@ assert 0 <= seen.probability <= 1e3;
    //@ assert -1e3 <= seen.variance <= WIDER(1e40, 1e37);
}

static void compare(uint32_t failed)
{
    const kelly_rare_seen seen = { .probability = any_wide(0, 1), .variance = any_wide(0, WIDER(1e40, 1e37f)),
                                   .tried = Frama_C_unsigned_int_interval(1, SAMPLES), .failed = Frama_C_unsigned_int_interval(0, SAMPLES) };

    any_state();
    samples[failed].guide = KELLY_RARE_FAILED;
    kelly_rare_compare(&rare, &hint, Frama_C_unsigned_int_interval(0, KELLY_MODES_MAX - 1), &seen);
}

int main(void)
{
    look();
    //@ loop unroll 41;
    for (uint32_t k = 0; k <= SAMPLES; k++) {
        see(k);
    }
    //@ loop unroll 40;
    for (uint32_t k = 0; k < SAMPLES; k++) {
        compare(k);
    }
    any_state();
    kelly_rare_doubt(&rare, &hint);
    return 0;
}
