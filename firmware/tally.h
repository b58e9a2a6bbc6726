/* tally.h - counts, digest and interval of an ensemble, in fixed memory: 1e9 realisations need no more than one. */
#ifndef KELLY_TALLY_H
#define KELLY_TALLY_H

#include "realisation.h"

/* What became of one realisation. */
typedef struct {
    kelly_draw draw;
    real lowest, highest, mean;  /* bit speed over the window [rad/s]; 0 where refused */
    real ss;                     /* severity, see severity.h; 0 where refused */
    uint8_t status;              /* kelly_status */
    uint8_t stuck;               /* ss > limit */
    uint8_t liftoff;             /* the weight would have changed its sign and was held at 0 */
} kelly_result;

/* Streaming counts of an ensemble. */
typedef struct {
    uint32_t samples;
    uint32_t stuck;
    uint32_t liftoff;
    uint32_t status[KELLY_STATUSES];
    uint32_t digest;             /* CRC-32C over each index in order, see kelly_tally_add */
} kelly_tally;

/* Realisations that have no result: step + range + nonfinite + corrupt. */
uint32_t kelly_refused(const kelly_tally *tally);

/* Add the result of `index`; indices in increasing order. The digest covers, little-endian: u32 index, the draw (5 real),
 * lowest, highest, mean, ss (4 real), u8 status. Start from a zeroed tally. */
void kelly_tally_add(kelly_tally *tally, uint32_t index, const kelly_result *result);

/* stuck / (samples - refused); 0 where nothing counts. */
wide kelly_probability(const kelly_tally *tally);

/* Two-sided 95 % interval of Clopper and Pearson (1934) for the probability: its coverage is at least 95 % for every P,
 * and it stays right at 0 and at all of them stuck. Refused realisations count as free in lo and as stuck in hi.
 * Both computed in `wide`. Cost: some hundred evaluations of a continued fraction of O(sqrt(samples)) terms. */
void kelly_interval(const kelly_tally *tally, wide *lo, wide *hi);

/* The same for k of n, at confidence 1 - 2 tail, 0 < tail < 0.5: lo solves P(X >= k) = tail, hi solves P(X <= k) = tail. */
wide kelly_binomial_lo(uint32_t k, uint32_t n, wide tail);
wide kelly_binomial_hi(uint32_t k, uint32_t n, wide tail);

/* ln Gamma(n + 1) - (n + 1/2) ln n + n - ln(2 pi) / 2 for n of 1e-30 and more: what Stirling's formula leaves, 1 / (12 n) and less. */
wide kelly_stirling(wide n);

#endif
