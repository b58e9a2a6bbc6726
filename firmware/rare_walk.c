/* rare_walk.c - one move of a chain: straight, or led by the hint. See rare.h. */
#include "detmath.h"
#include "rare.h"

#define SIZE KELLY_PARAMETERS
#define INNER 8u                 /* steps over the hint in a led move: twice as many gain nothing */
#define SHARP 9.0f               /* a hint that is short by a tenth counts as 0.39 times as likely */
#define LEAST 1e-30f             /* of a guide whose logarithm is taken */

/* Logarithm of the weights that turn the normal laws into the gamma laws. */
static float log_law(const kelly_rare *rare, const float x[SIZE])
{
    float sum = 0.0f;

    for (unsigned k = 0; k < SIZE; k++) {
        if (rare->cov[k] >= KELLY_RARE_COV) {
            sum += kelly_gamma_log_weight(x[k], rare->cov[k]);
        }
    }
    return sum;
}

/* x' = sqrt(1 - s^2) x + s u, u normal: keeps the normal law whatever s, 0 < s <= 1. */
static void stray(const kelly_rare *rare, kelly_rng *rng, float s, const float old[SIZE], float next[SIZE])
{
    const float keep = kelly_sqrt32(1.0f - s * s);

    for (unsigned k = 0; k < SIZE; k++) {
        next[k] = rare->cov[k] >= KELLY_RARE_COV ? keep * old[k] + s * kelly_normal(rng) : 0.0f;
    }
}

static int wins(kelly_rng *rng, float log_ratio)
{
    return kelly_log32(kelly_open01(kelly_rng_next(rng))) < log_ratio;
}

static int straight_move(const kelly_rare *rare, kelly_rng *rng, const float old[SIZE], float next[SIZE])
{
    stray(rare, rng, rare->step, old, next);
    return wins(rng, log_law(rare, next) - log_law(rare, old));
}

/* Logarithm of h = min(1, (hint / level)^SHARP): how likely the hint thinks it that x is in the event. */
static float log_share(const kelly_rare *rare, const float x[SIZE])
{
    const float beyond = kelly_rare_guess(rare->hint, x) - rare->hint_level;

    return beyond < 0.0f ? SHARP * beyond : 0.0f;
}

/* A short chain over the laws times h, which costs no realisation; where it ends is one proposal, that the laws within the event
 * accept with probability min(1, h(old) / h(next)) (Liu, Monte Carlo Strategies, 2001, 9.4.3). Its steps are of all lengths. */
static int led_move(const kelly_rare *rare, kelly_rng *rng, const float old[SIZE], float next[SIZE])
{
    const float old_share = log_share(rare, old);
    float share = old_share, law = log_law(rare, old), trial[SIZE];
    int moved = 0;

    for (unsigned k = 0; k < SIZE; k++) {
        next[k] = old[k];
    }
    for (unsigned i = 0; i < INNER; i++) {
        const float u = kelly_open01(kelly_rng_next(rng));
        float trial_law, trial_share;

        stray(rare, rng, u * u, next, trial);
        trial_law = log_law(rare, trial);
        trial_share = log_share(rare, trial);
        if (wins(rng, (trial_law - law) + (trial_share - share))) {
            for (unsigned k = 0; k < SIZE; k++) {
                next[k] = trial[k];
            }
            law = trial_law;
            share = trial_share;
            moved = 1;
        }
    }
    return wins(rng, old_share - share) && moved;
}

int kelly_rare_move(const kelly_rare *rare, kelly_rng *rng, int led, const float old[SIZE], float next[SIZE])
{
    return led ? led_move(rare, rng, old, next) : straight_move(rare, rng, old, next);
}

/* Guide over hint is near one in the mean, and no more: the seeds say by how much, and how much it scatters. */
void kelly_rare_aim(kelly_rare *rare)
{
    float sum = 0.0f, squares = 0.0f, n = 0.0f, mean, variance;

    /*@ loop invariant n <= i <= rare->chains;
        loop invariant -2000000 * n <= sum <= 2000000 * n && 0 <= squares <= 2000000000000 * n && (n == 0 || n >= 1);
        loop assigns i, sum, squares, n; */
    for (uint32_t i = 0; i < rare->chains; i++) {
        const kelly_rare_sample *const seed = &rare->samples[i];

        if (!kelly_rare_failed(seed) && seed->guide > LEAST) {
            const float ratio = kelly_log32(seed->guide) - kelly_rare_guess(rare->hint, seed->x);

            //@ assert apart: -1000100 <= ratio <= 1000100;
            //@ assert square: 0 <= ratio * ratio <= 1000200010000;
            sum += ratio;
            squares += ratio * ratio;
            n += 1.0f;
        }
    }
    mean = n > 0.0f ? sum / n : 0.0f;
    //@ assert mean: -2000000 <= mean <= 2000000;
    variance = n > 0.0f ? squares / n - mean * mean : 0.0f;
    //@ assert scatter: n > 0 ==> 0 <= squares / n <= 2000000000000 && 0 <= mean * mean;
    rare->hint_level = kelly_log32(rare->guide > LEAST ? rare->guide : LEAST) - mean - (variance > 0.0f ? kelly_sqrt32(variance) : 0.0f);
}
