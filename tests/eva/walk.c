/* The walk of rare.h: any x, any laws, any hint. Stubs: the laws (random.c), the hint (guide.c). */
#define EVA_LOG32
#include "rare.h"
#include "contracts.h"

#define SAMPLES 40u
#define X 1e3f                           /* as they are accepted; a led move takes 8 steps from there */
#define FARTHEST 3e3f

/* random.c */
uint32_t kelly_rng_next(kelly_rng *rng)
{
    ANY(*rng);
    return any_u32();
}

float kelly_open01(uint32_t word)
{
    (void)word;
    return Frama_C_float_interval(0x1p-24f, 1 - 0x1p-24f);
}

float kelly_gamma_log_weight(float x, float cov)
{
    //@ assert -FARTHEST <= x <= FARTHEST;
    //@ assert 1e-4f <= cov <= 0.5;
    return Frama_C_float_interval(KELLY_NO_WEIGHT, 1e16f);
}

/* guide.c */
float kelly_rare_guess(const kelly_rare_hint *hint, const float x[KELLY_PARAMETERS])
{
    (void)hint;
    for (unsigned k = 0; k < KELLY_PARAMETERS; k++) {
        //@ assert -FARTHEST <= x[k] <= FARTHEST;
    }
    return Frama_C_float_interval(-1e6f, 1e6f);
}

/* rare.c */
int kelly_rare_failed(const kelly_rare_sample *sample) { return sample->guide >= KELLY_RARE_FAILED; }

static kelly_rare rare;
static kelly_rare_sample samples[SAMPLES];
static const kelly_rare_hint hint;

static void any_rare(void)
{
    for (unsigned i = 0; i < SAMPLES; i++) {
        for (unsigned k = 0; k < KELLY_PARAMETERS; k++) {
            samples[i].x[k] = Frama_C_float_interval(-X, X);
        }
        samples[i].guide = Frama_C_float_interval(0, ANY_FLOAT);
    }
    for (unsigned k = 0; k < KELLY_PARAMETERS; k++) {
        rare.cov[k] = Frama_C_float_interval(0, 0.5f);
    }
    rare.n = SAMPLES;
    rare.chains = SAMPLES / KELLY_RARE_STATES;
    rare.samples = samples;
    rare.step = Frama_C_float_interval(0.02f, 1.0f);
    rare.hint = &hint;
    rare.hint_level = Frama_C_float_interval(-1e9f, 1e9f);
    rare.guide = Frama_C_float_interval(0, ANY_FLOAT);
}

int main(void)
{
    float next[KELLY_PARAMETERS];
    kelly_rng rng;

    any_rare();
    ANY(rng);
    (void)kelly_rare_move(&rare, &rng, 0, samples[0].x, next);
    (void)kelly_rare_move(&rare, &rng, 1, samples[0].x, next);
    kelly_rare_aim(&rare);
    //@ assert -1e9 <= rare.hint_level <= 1e9;
    return 0;
}
