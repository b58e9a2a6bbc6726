/* rare_guide.c - the drill string as rare.c sees it: parameters of a sample, guide of a result. See rare.h. */
#include "detmath.h"
#include "random.h"
#include "rare.h"

static real value(const kelly_case *run, const kelly_rare_sample *sample, unsigned parameter, real mean)
{
    return run->cov[parameter] > 0.0f ? (real)kelly_gamma_value(sample->x[parameter], (float)mean, run->cov[parameter]) : mean;
}

void kelly_rare_draw(const kelly_case *run, const kelly_rare_sample *sample, kelly_draw *draw)
{
    draw->fc = value(run, sample, 0, run->fc);
    draw->mu = value(run, sample, 1, run->mu);
    draw->a1 = value(run, sample, 2, run->a1);
    draw->a2 = value(run, sample, 3, run->a2);
    draw->w0 = value(run, sample, 4, run->w0);
}

float kelly_rare_guide(const kelly_table *table, const kelly_case *run, const kelly_result *result)
{
    const kelly_draw *const y = &result->draw;
    const real t = kelly_tanh(y->w0), q = y->a2 * (y->w0 * y->w0), s = R(1.0) + q;
    const real slope = y->mu * y->fc * (y->a1 * (q - R(1.0)) / (s * s) - (R(1.0) - t) * (R(1.0) + t));
    kelly_modes modes;
    real ratio;

    if (result->status != KELLY_OK || !kelly_modes_at(table, y->fc, 1, &modes)) {
        return KELLY_RARE_REFUSED;
    }
    if (result->ss > run->limit) {
        return KELLY_RARE_FAILED;
    }
    ratio = modes.b[0] * modes.b[0] * slope / (table->alpha + table->beta * modes.w2[0]);
    ratio = ratio > R(1e-4) ? ratio : R(1e-4);
    ratio = (ratio * ratio) * (ratio * ratio);
    return (float)(ratio * ratio * result->ss);            /* above 1e-32 ss: no underflow */
}
