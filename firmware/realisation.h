/* realisation.h - one draw of the random parameters, and whether the step can be trusted with it.
 *
 * Y1..Y5 = |f_c|, mu, alpha_1, alpha_2, w0: independent gamma laws, mean = nominal value, coefficient of variation
 * cov[k]; cov 0 means not random. Draw j of seed s depends on (s, j) alone, and is the same in float and in double.
 */
#ifndef KELLY_REALISATION_H
#define KELLY_REALISATION_H

#include "string_model.h"

/* One realisation of the random parameters: positive, SI. */
typedef struct {
    real fc;                     /* weight on bit |f_c| [N] */
    real mu;                     /* bit-rock factor [m] */
    real a1, a2;                 /* alpha_1 [s/rad], alpha_2 [s2/rad2] */
    real w0;                     /* top speed [rad/s] */
} kelly_draw;

/* Whether a realisation can be trusted, and why not. */
typedef enum {
    KELLY_OK = 0,
    KELLY_STEP = 1,              /* the step is too long for its fastest rate, or too short for its slowest mode: not integrated */
    KELLY_RANGE = 2,             /* fc outside the fit of the table, or a parameter that is not in 0..1e30, 0 excluded: not integrated */
    KELLY_NONFINITE = 3,         /* the state left all bounds: integrated, not counted */
    KELLY_CORRUPT = 4            /* a number changed in memory that no step has changed (seal.h): not counted */
} kelly_status;

enum { KELLY_STATUSES = 5 };   /* no macro: an expansion counts as a line that may stay uncovered */

#define KELLY_REAL_AXIS R(2.785)       /* RK4 is stable to h lambda = 2.78529 on the negative real axis */
#define KELLY_IMAGINARY_AXIS R(2.8)    /* and to h w = 2 sqrt 2 = 2.82843 on the imaginary axis */
#define KELLY_TURN R(0.25)             /* most that a top of variable speed may turn in a step [rad]: drive.h */

/* Reason why this case cannot be run on this table, or 0. */
const char *kelly_case_error(const kelly_table *table, const kelly_case *run);

/* The parameters of realisation `index` of `seed`. */
void kelly_draw_sample(const kelly_case *run, uint64_t seed, uint32_t index, kelly_draw *draw);

/* The parameters with nothing random: the means. */
void kelly_draw_nominal(const kelly_case *run, kelly_draw *draw);

/* The draw's torsional modes and whether it may be integrated: KELLY_OK, KELLY_STEP or KELLY_RANGE (modes untouched).
 * A draw of the caller's own may hold anything: what is not finite and positive is KELLY_RANGE.
 * RK4 is stable on the negative real axis to h lambda = 2.785 and on the imaginary axis to h w = 2.8 (2 sqrt 2);
 * lambda <= mu |f|max (1 + a1) sum b_i^2 + max beta w_i^2 with |f|max = fc + f0. A soft drive, whose rotor s = J_d + J - sum d_i^2
 * swings with the modes, adds (1 - sum d_i b_i)^2 / s to sum b_i^2 and 4 Z / s to lambda, and max w_i^2 grows by the factor
 * 1 + sum d_i^2 / s, and by k_i / s. The weight swings with the top: w0 is a frequency as those of the modes are. */
kelly_status kelly_realise(const kelly_table *table, const kelly_case *run, const kelly_draw *draw, kelly_modes *modes);

/* Smallest step [s] that kelly_realise accepts for these modes: below it the slowest mode moves by less than some tens of
 * rounding errors a step (h w_1 = 1e-5 in float), and its motion would drown in them. */
real kelly_smallest_step(const kelly_modes *modes);

/* Fastest rate lambda [1/s] of these modes under a weight fc [N], as kelly_realise bounds it. */
real kelly_fastest_rate(const kelly_table *table, const kelly_case *run, const kelly_draw *draw, const kelly_modes *modes, real fc);

/* Largest step [s] that kelly_realise accepts for these modes. */
real kelly_largest_step(const kelly_table *table, const kelly_case *run, const kelly_draw *draw, const kelly_modes *modes);

/* Whether the weight on bit would change its sign, fc < 1.01 f0: it is held at 0 there, and the realisation is counted. */
int kelly_lifts_off(const kelly_case *run, const kelly_draw *draw);

/* The step [s] of a case. */
real kelly_step_seconds(const kelly_case *run);

#endif
