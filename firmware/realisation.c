#include "realisation.h"

#include "detmath.h"
#include "random.h"

#define GRAIN (sizeof(real) > sizeof(float) ? R(1e-13) : R(1e-5))   /* least h w_1 that the digits of real carry */
#define F_OFFSET R(0.01)         /* the constant part of f_a / f0, eq. (F) */
#define LEAST_COV 1e-4f          /* of kelly_gamma: the spread of less is lost in the digits of float */

static int positive(real x)
{
    return x > 0 && x <= R(1e30);   /* false for a NaN */
}

static int drive_in_range(const kelly_drive *drive)
{
    return drive->inertia >= R(1.0) && drive->inertia <= R(1e12) && drive->impedance > 0 && drive->impedance <= R(1e12) &&
           drive->hz > 0 && drive->hz <= R(1e3);   /* false for a NaN */
}

static int covs_in_range(const kelly_case *run)
{
    for (unsigned k = 0; k < KELLY_PARAMETERS; k++) {
        if (!(run->cov[k] >= 0.0f && run->cov[k] <= 0.5f)) {
            return 0;
        }
    }
    return 1;
}

const char *kelly_case_error(const kelly_table *table, const kelly_case *run)
{
    if (!positive(run->fc) || !positive(run->mu) || !positive(run->a1) || !positive(run->a2) || !positive(run->w0)) {
        return "weight, mu, alpha1, alpha2 and top speed must be positive";
    }
    if (!(run->f0 >= 0 && run->f0 < R(1e30))) {
        return "f0 must not be negative";
    }
    if (!covs_in_range(run)) {
        return "coefficients of variation must lie in 0..0.5";
    }
    if (!(run->limit >= 0 && run->limit <= R(10.0))) {
        return "the severity limit must lie in 0..10";
    }
    if (run->step_ns < 1000u || run->step_ns > 1000000000u) {
        return "the step must lie between 1 us and 1 s";
    }
    if (run->ticks == 0 || run->window_first >= run->window_last || run->window_last > run->ticks) {
        return "the window must be a part of the run";
    }
    if (!(run->drive.inertia == 0) && !drive_in_range(&run->drive)) {
        return "a soft drive needs an inertia of at least 1 kg m2, an impedance and a frequency above 0";
    }
    if (run->torsional < 1 || run->torsional > table->torsional || run->axial < 1 || run->axial > table->axial) {
        return "the table does not carry so many modes";
    }
    return 0;
}

/* One parameter: its mean where it is not random, rounded to float where it is, as the sampler computes in float. */
static real sample(const kelly_case *run, uint64_t seed, uint32_t index, unsigned parameter, real mean)
{
    kelly_rng rng;

    if (!(run->cov[parameter] >= LEAST_COV)) {
        return mean;
    }
    kelly_rng_key(&rng, seed, index, parameter);
    return (real)kelly_gamma(&rng, (float)mean, run->cov[parameter]);
}

void kelly_draw_sample(const kelly_case *run, uint64_t seed, uint32_t index, kelly_draw *draw)
{
    draw->fc = sample(run, seed, index, 0, run->fc);
    draw->mu = sample(run, seed, index, 1, run->mu);
    draw->a1 = sample(run, seed, index, 2, run->a1);
    draw->a2 = sample(run, seed, index, 3, run->a2);
    draw->w0 = sample(run, seed, index, 4, run->w0);
}

void kelly_draw_nominal(const kelly_case *run, kelly_draw *draw)
{
    draw->fc = run->fc;
    draw->mu = run->mu;
    draw->a1 = run->a1;
    draw->a2 = run->a2;
    draw->w0 = run->w0;
}

real kelly_step_seconds(const kelly_case *run)
{
    return (real)run->step_ns / R(1000000000.0);   /* both exact in float for whole microseconds: one rounding */
}

/* What the modes leave of the string to the top, and what a soft drive makes of it. Stiff: all zero but `stiffer`. */
typedef struct {
    real yield;                  /* (1 - sum d b)^2 / s, s = J_d + J - sum d^2 [1 / kg m2] */
    real held;                   /* 4 Z / s [1/s] */
    real stiffer;                /* 1 + sum d^2 / s */
    real swing;                  /* k_i / s [1/s2] */
} softness;

static void soften(const kelly_table *table, const kelly_drive *drive, const kelly_modes *modes, softness *soft)
{
    const real turn = 2 * KELLY_PI * drive->hz;
    real rest = R(1.0), d2 = 0, rotor;

    for (unsigned i = 0; i < modes->count && i < KELLY_MODES_MAX; i++) {
        rest = rest - modes->d[i] * modes->b[i];
        d2 = d2 + modes->d[i] * modes->d[i];
    }
    rotor = drive->inertia + (table->inertia - d2);
    soft->yield = rest * rest / rotor;
    soft->held = 4 * drive->impedance / rotor;
    soft->stiffer = R(1.0) + d2 / rotor;
    soft->swing = turn * turn * drive->inertia / rotor;
}

/* Sum of b^2 and square of the highest frequency [rad2/s2]. */
static void shares(const kelly_modes *modes, real *sum_g, real *top)
{
    *sum_g = 0;
    *top = 0;
    for (unsigned i = 0; i < modes->count && i < KELLY_MODES_MAX; i++) {
        *sum_g = *sum_g + modes->b[i] * modes->b[i];
        *top = modes->w2[i] > *top ? modes->w2[i] : *top;
    }
}

/* Fastest rates of a realisation: lambda [1/s] and the square of the highest frequency [rad2/s2], that of the weight among them. */
static void fastest(const kelly_table *table, const kelly_case *run, const kelly_draw *draw, const kelly_modes *modes, real fc,
                    real *lambda, real *w2)
{
    softness soft;
    real sum_g, top;

    shares(modes, &sum_g, &top);
    if (run->drive.inertia > 0) {
        soften(table, &run->drive, modes, &soft);
        sum_g = sum_g + soft.yield;
        *lambda = draw->mu * (fc + run->f0) * (R(1.0) + draw->a1) * sum_g + table->beta * top * soft.stiffer + soft.held;
        *w2 = top * soft.stiffer + soft.swing;
    } else {
        *lambda = draw->mu * (fc + run->f0) * (R(1.0) + draw->a1) * sum_g + table->beta * top;
        *w2 = top;
    }
    *w2 = draw->w0 * draw->w0 > *w2 ? draw->w0 * draw->w0 : *w2;
}

real kelly_fastest_rate(const kelly_table *table, const kelly_case *run, const kelly_draw *draw, const kelly_modes *modes, real fc)
{
    real lambda, w2;

    fastest(table, run, draw, modes, fc, &lambda, &w2);
    return lambda;
}

real kelly_smallest_step(const kelly_modes *modes)
{
    return GRAIN / (real)kelly_sqrt32((float)modes->w2[0]);
}

static int sound(const kelly_draw *draw)
{
    return positive(draw->fc) && positive(draw->mu) && positive(draw->a1) && positive(draw->a2) && positive(draw->w0);
}

kelly_status kelly_realise(const kelly_table *table, const kelly_case *run, const kelly_draw *draw, kelly_modes *modes)
{
    const real h = kelly_step_seconds(run);
    real lambda, w2;

    if (!sound(draw) || !kelly_modes_at(table, draw->fc, run->torsional, modes)) {
        return KELLY_RANGE;
    }
    fastest(table, run, draw, modes, draw->fc, &lambda, &w2);
    if (h * h * modes->w2[0] < GRAIN * GRAIN || (run->drive.inertia > 0 && h * draw->w0 > KELLY_TURN)) {
        return KELLY_STEP;
    }
    return h * lambda <= KELLY_REAL_AXIS && h * h * w2 <= KELLY_IMAGINARY_AXIS * KELLY_IMAGINARY_AXIS ? KELLY_OK : KELLY_STEP;
}

real kelly_largest_step(const kelly_table *table, const kelly_case *run, const kelly_draw *draw, const kelly_modes *modes)
{
    real lambda, w2, on_real, on_imaginary;

    fastest(table, run, draw, modes, draw->fc, &lambda, &w2);
    on_real = KELLY_REAL_AXIS / lambda;
    on_imaginary = KELLY_IMAGINARY_AXIS * R(0.999999) * (real)kelly_sqrt32((float)(1 / w2));   /* a float's rounding below it */
    on_real = on_real < on_imaginary ? on_real : on_imaginary;
    return run->drive.inertia > 0 && draw->w0 > KELLY_TURN / on_real ? KELLY_TURN * R(0.999999) / draw->w0 : on_real;
}

int kelly_lifts_off(const kelly_case *run, const kelly_draw *draw)
{
    return draw->fc < (R(1.0) + F_OFFSET) * run->f0;
}
