/* rare_guide.c - the drill string as rare.c sees it: parameters of a sample, guide of a result, hint of what it will be. See rare.h. */
#include "detmath.h"
#include "random.h"
#include "rare.h"

#define LEAST_RATIO R(1e-6)      /* of R: its fourth power, times ss, is a normal number, */
#define MOST_RATIO R(1e9)        /* and finite, below KELLY_RARE_FAILED */
#define LEAST_SWING R(1e-30)     /* of an ss whose logarithm is taken */
#define LEAST_SQUARE R(1e-14)    /* of |1 - T' H|^2: 1 - x has no digits below 1e-7 */
#define OUT_OF_REACH (-1e6f)     /* hint where there are no modes */

static real value(const kelly_case *run, const kelly_rare_sample *sample, unsigned parameter, real mean)
{
    return run->cov[parameter] >= KELLY_RARE_COV ? (real)kelly_gamma_value(sample->x[parameter], (float)mean, run->cov[parameter]) : mean;
}

void kelly_rare_draw(const kelly_case *run, const kelly_rare_sample *sample, kelly_draw *draw)
{
    draw->fc = value(run, sample, 0, run->fc);
    draw->mu = value(run, sample, 1, run->mu);
    draw->a1 = value(run, sample, 2, run->a1);
    draw->a2 = value(run, sample, 3, run->a2);
    draw->w0 = value(run, sample, 4, run->w0);
}

/* T' at w0 [N m s]: positive where the rock drives the bit. */
static real slope_of(const kelly_draw *y)
{
    const real t = kelly_tanh(y->w0), q = y->a2 * (y->w0 * y->w0), s = R(1.0) + q;

    return y->mu * y->fc * (y->a1 * (q - R(1.0)) / (s * s) - (R(1.0) - t) * (R(1.0) + t));
}

/* R of a slope. */
static real ratio_of(const kelly_table *table, const kelly_modes *modes, real slope)
{
    const real ratio = modes->b[0] * modes->b[0] * slope / (table->alpha + table->beta * modes->w2[0]);

    return ratio > LEAST_RATIO ? ratio < MOST_RATIO ? ratio : MOST_RATIO : LEAST_RATIO;
}

float kelly_rare_guide(const kelly_table *table, const kelly_case *run, const kelly_result *result)
{
    kelly_modes modes;
    real ratio;

    if (result->status != KELLY_OK || !kelly_modes_at(table, result->draw.fc, 1, &modes)) {
        return KELLY_RARE_REFUSED;
    }
    if (result->ss > run->limit) {
        return KELLY_RARE_FAILED;
    }
    ratio = ratio_of(table, &modes, slope_of(&result->draw));
    return (float)((ratio * ratio) * (ratio * ratio) * result->ss);
}

/* Amplitude over w0 of the bit speed that f_a keeps up at w0, by the modes from `from` on: with H = sum b_i^2 i w0 / (w_i^2 - w0^2 + i w0 c_i) it is
 * |H| mu f0 G / |1 - T' H|, G = tanh w0 + a1 w0 / (1 + a2 w0^2). */
static real forced(const kelly_table *table, const kelly_case *run, const kelly_draw *y, const kelly_modes *modes, unsigned from, real slope, real pull)
{
    real re = 0, im = 0, a, b, square;

    for (unsigned i = from; i < modes->count; i++) {
        const real stiff = modes->w2[i] - y->w0 * y->w0, loss = y->w0 * (table->alpha + table->beta * modes->w2[i]);
        const real g = modes->b[i] * modes->b[i] * y->w0 / (stiff * stiff + loss * loss);

        re += g * loss;
        im += g * stiff;
    }
    a = R(1.0) - slope * re;
    b = slope * im;
    square = a * a + b * b;
    square = square > LEAST_SQUARE ? square : LEAST_SQUARE;
    return y->mu * run->f0 * pull / y->w0 * (real)kelly_sqrt32((float)((re * re + im * im) / square));
}

/* What is left at the window's start of the first mode's swing: d_1 b_1 of w0 from rest, b_1^2 mu fc G / w_1 from a string that
 * turns untwisted. It decays with (1 - R) c_1 / 2; exp(x) as (1 - x / 64)^-64: no more is needed, and it has the same bits everywhere. */
static real swing(const kelly_table *table, const kelly_case *run, const kelly_draw *y, const kelly_modes *modes, real slope, real pull)
{
    const real seconds = (real)run->window_first * ((real)run->step_ns * R(1e-9));
    const real rate = R(0.5) * (table->alpha + table->beta * modes->w2[0] - modes->b[0] * modes->b[0] * slope);
    const real x = R(1.0) + rate * seconds / R(64.0);
    real decay = R(1.0) / (x < R(0.95) ? R(0.95) : x > R(2.0) ? R(2.0) : x);

    for (unsigned i = 0; i < 6; i++) {
        decay *= decay;
    }
    return decay * (run->rotating ? modes->b[0] * modes->b[0] * (y->mu * y->fc * pull) / (real)kelly_sqrt32((float)modes->w2[0]) / y->w0
                                  : KELLY_ABS(modes->d[0]) * modes->b[0]);
}

static float above_plane(const float plane[KELLY_PARAMETERS], const float x[KELLY_PARAMETERS])
{
    float sum = 0.0f;

    for (unsigned k = 0; k < KELLY_PARAMETERS; k++) {
        sum += plane[k] * x[k];
    }
    return sum;
}

/* The draw at x, its first `count` modes, and what the rock does at w0: T' and T over mu fc. 0 where x cannot be run. */
static int place(const kelly_rare_hint *hint, const float x[KELLY_PARAMETERS], unsigned count, kelly_draw *y, kelly_modes *modes, real *slope, real *pull)
{
    kelly_rare_sample sample;

    for (unsigned k = 0; k < KELLY_PARAMETERS; k++) {
        sample.x[k] = x[k];
        if (hint->run->cov[k] >= KELLY_RARE_COV && kelly_gamma_log_weight(x[k], hint->run->cov[k]) <= KELLY_NO_WEIGHT) {
            return 0;
        }
    }
    kelly_rare_draw(hint->run, &sample, y);
    if (!kelly_modes_at(hint->table, y->fc, count, modes)) {
        return 0;
    }
    *slope = slope_of(y);
    *pull = kelly_tanh(y->w0) + y->a1 * y->w0 / (R(1.0) + y->a2 * (y->w0 * y->w0));
    return 1;
}

/* ss of the linear string, and R. 0 where x cannot be run. */
static int linear(const kelly_rare_hint *hint, const float x[KELLY_PARAMETERS], real *ss, real *ratio)
{
    kelly_modes modes;
    kelly_draw y;
    real slope, pull;

    if (!place(hint, x, hint->run->torsional, &y, &modes, &slope, &pull)) {
        return 0;
    }
    *ss = forced(hint->table, hint->run, &y, &modes, 0, slope, pull) + swing(hint->table, hint->run, &y, &modes, slope, pull);
    *ratio = ratio_of(hint->table, &modes, slope);
    return 1;
}

float kelly_rare_guess(const kelly_rare_hint *hint, const float x[KELLY_PARAMETERS])
{
    real ss, ratio;

    if (hint->plane) {
        return above_plane(hint->plane, x);
    }
    if (!linear(hint, x, &ss, &ratio)) {
        return OUT_OF_REACH;
    }
    return 4.0f * kelly_log32((float)ratio) + kelly_log32((float)(ss > LEAST_SWING ? ss : LEAST_SWING));
}

float kelly_rare_own(const kelly_rare_hint *hint)
{
    static const float means[KELLY_PARAMETERS] = { 0.0f, 0.0f, 0.0f, 0.0f, 0.0f };
    real ss = 0, ratio;

    (void)linear(hint, means, &ss, &ratio);
    return (float)ss;
}

float kelly_rare_resonance(const kelly_rare_hint *hint, const float x[KELLY_PARAMETERS], unsigned mode)
{
    kelly_modes modes;
    kelly_draw y;
    real slope, pull;

    return place(hint, x, mode + 1, &y, &modes, &slope, &pull) ? (float)forced(hint->table, hint->run, &y, &modes, mode, slope, pull) : 0.0f;
}
