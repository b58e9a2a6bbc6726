/* reweight.h - the probability under other laws, from realisations that have been run already.
 *
 * A realisation y drawn under the laws f counts under other laws g with the weight w = g(y) / f(y), a product over the parameters,
 * each a gamma law of mean m and coefficient of variation v, shape k = 1/v^2, scale m v^2:
 *
 *     ln w = sum of (k_g - k_f) ln(y/m_f) - k_g (y/m_g) + k_f (y/m_f) + const
 *
 * Estimate   self-normalised: P = sum w z / sum w, z = 1 where it sticks, over the realisations that have a result.
 * Size       effective sample size (Kish 1965) ess = (sum w)^2 / sum w^2, and the one that laws alone predict,
 *            n / E(w^2), in closed form: (k_f, k_g) -> shape 2 k_g - k_f, rate 2 r_g - r_f. Where one of these is not positive the
 *            weights have no variance at all, no sample however large is enough, and the predicted size is 0: from means or
 *            spreads much larger than those that were run. The sample's own ess cannot see that; so the smaller of both counts.
 * Interval   95 %, Clopper and Pearson's for an effective n: the smaller of ess and of P (1 - P) / var, var the variance of the
 *            estimate by the delta method, sum w^2 (z - P)^2 / (sum w)^2; counts rounded outwards. It holds at P = 0 and 1.
 *            Refused realisations count as free in lo and as stuck in hi, with their weights.
 * Memory     a few sums; weights are kept relative to the largest so far.
 */
#ifndef KELLY_REWEIGHT_H
#define KELLY_REWEIGHT_H

#include "tally.h"

#define KELLY_LEAST_ESS W(100.0)   /* fewer carry no estimate */
#define KELLY_MOST_SHARE W(0.05)   /* nor does a sum of which one realisation is more */

/* Laws of the five parameters, in their order: means 1e-30 .. 1e30 where wide is double, cov 1e-4 .. 0.5, or 0: not random. */
typedef struct {
    wide mean[KELLY_PARAMETERS], cov[KELLY_PARAMETERS];
} kelly_laws;

typedef enum {
    KELLY_LAW_FITS = 0,
    KELLY_LAW_FIXED = 1,         /* not random as run, and to be another value, or random */
    KELLY_LAW_POINT = 2          /* random as run, and to be a single value */
} kelly_law_fit;

/* Fields are not to be touched. */
typedef struct {
    wide slope[KELLY_PARAMETERS], rate[KELLY_PARAMETERS], mean[KELLY_PARAMETERS];   /* of ln w in ln(y/mean), in y/mean */
    wide square;                 /* E(w^2); 0: infinite */
    wide top;                    /* ln of the largest weight so far */
    wide w, ww, stuck, stuck2, refused;   /* sums of w, w^2, w z, w^2 z, and of w over the refused; all in units of the largest */
    uint32_t n, refused_n;
} kelly_reweight;

typedef struct {
    wide probability, lo, hi;
    wide ess, ess_predicted, share;   /* share of the largest weight */
    int enough;                  /* sizes are not below the stated ones; nothing else is worth reading otherwise */
} kelly_reweighted;

/* Whether parameter k can go from these laws to those. */
kelly_law_fit kelly_law_fits(const kelly_laws *from, const kelly_laws *to, unsigned k);

/* From laws that fit. */
void kelly_reweight_start(kelly_reweight *sums, const kelly_laws *from, const kelly_laws *to);

/* A realisation with parameters y, 1e-36 .. 1e36 where wide is double; status as in kelly_result. */
void kelly_reweight_add(kelly_reweight *sums, const wide y[KELLY_PARAMETERS], int status, int stuck);

void kelly_reweight_read(const kelly_reweight *sums, kelly_reweighted *result);

#endif
