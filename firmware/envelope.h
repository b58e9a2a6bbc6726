/* envelope.h - mean, standard deviation and the 2.5, 50 and 97.5 % quantiles of a stream of values, in fixed memory.
 *
 * The stream is held as clusters of neighbouring values, each a mean and a count, sorted. A new value enters as a cluster
 * of its own; where no place is left, neighbours merge as long as their joint count stays below
 *
 *     grain (s + d^2 / s),   s = sqrt(n p (1 - p)),   d = ranks between the cluster and the p-quantile,
 *
 * for each of the three p. s is the standard error of a quantile's rank: a cluster that holds a quantile covers less than
 * `grain` of the sampling error, whatever n is, and about 3 pi / grain clusters are enough. Clusters far away are large,
 * since a quantile moves by a few s at most while values keep coming in random order, as realisations do. Where the
 * clusters do not fit, `grain` grows.
 *
 * Error    exact (numpy's "linear") up to KELLY_CLUSTERS values. Beyond, in random order, in units of s, which is what the
 *          sample itself does not know of the quantile's rank: root mean square 0.1 at n = 400, 0.2 at 1e4, 0.55 at 1e5,
 *          1.1 at 1e6 (0.02 % of n). Ties and spikes, as of a bit that sticks, make no difference.
 * Memory   sizeof(kelly_envelope): 788 bytes in float. Nothing else, for any n up to 2^24.
 * Time     add: at most 96 comparisons and moves, and every 24 values or more a pass of some 2000 operations.
 */
#ifndef KELLY_ENVELOPE_H
#define KELLY_ENVELOPE_H

#include "real.h"

#define KELLY_CLUSTERS 96

typedef struct {
    uint32_t n;                  /* values so far */
    uint32_t used;               /* clusters */
    real grain;                  /* see above; grows where the clusters would not fit */
    real mean, m2;               /* sum of squared deviations from the mean */
    real value[KELLY_CLUSTERS];  /* ascending */
    uint32_t weight[KELLY_CLUSTERS];
} kelly_envelope;

/* What is read at one instant, in the unit of the values. */
typedef struct {
    real mean, sd;               /* sd with the divisor n; its root is taken in float */
    real low, median, high;      /* 2.5, 50 and 97.5 % */
} kelly_band;

void kelly_envelope_clear(kelly_envelope *envelope);

/* Take a value. 0, and nothing changed, where it is not a finite number below 1e14 or n has reached 2^24. */
int kelly_envelope_add(kelly_envelope *envelope, real x);

/* Quantile p, 0 <= p <= 1, interpolated between the middles of the clusters; only the three above carry the bound. 0 while n is 0. */
real kelly_envelope_quantile(const kelly_envelope *envelope, real p);

/* All five. Zeros while n is 0. */
void kelly_envelope_read(const kelly_envelope *envelope, kelly_band *band);

#endif
