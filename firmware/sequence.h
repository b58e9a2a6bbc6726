/* sequence.h - when enough realisations have been run: an interval that holds at every n at once.
 *
 * Whoever stops when an interval looks good has chosen n by the data, and an interval for a fixed n (tally.h) then covers
 * less than it says. A confidence sequence covers P at all n together, with probability 95 % at least: it may be looked
 * at after every realisation, for ever, and the run stopped at will.
 *
 * Derivation (Ville 1939; Robbins 1970; the mixture is Krichevsky and Trofimov's, 1981). Under P = p the ratio
 *
 *     M_n(p) = int q^k (1-q)^(n-k) dB(q) / (p^k (1-p)^(n-k)),   k of n stuck, B = Beta(1/2, 1/2),
 *
 * is a martingale of mean 1 and never negative, so that P(M_n(p) >= 1/alpha for any n) <= alpha. The p with M_n(p) < 1/alpha
 * therefore hold P at all n, and they are an interval since p^k (1-p)^(n-k) has one peak. With the integral as gamma functions
 * and Stirling's formula, ln Gamma(k + 1/2) > k ln k - k + ln(2 pi)/2 - 1/(24 k) and ln n! < ... + 1/(12 n), M_n(p) < 1/alpha follows from
 *
 *     n KL(k/n, p) < ln(1/alpha) + ln(pi n / 2) / 2 + 1/(12 n) + c(k) + c(n - k),   c(0) = ln(2) / 2, c(k) = 1/(24 k),
 *
 * KL(a, p) = a ln(a/p) + (1-a) ln((1-a)/(1-p)). The bounds of the series err to the safe side, by 0.005 at most.
 *
 * Price     the interval is wider than that of a fixed n: 1.6 times at n = 100, twice at 1e4. A fixed n, if one knows it, is
 *           cheaper; one does not where P is unknown.
 * Refused   count as free in lo and as stuck in hi. Whatever they would have been, the interval is no narrower than
 *           that of the truth, so that it holds P over all realisations, refused ones included.
 * Bits      computed in float in both builds: n at which a run stops is the same on every machine, in float and in double
 *           (as far as the same realisations stick). Errors of rounding are below 1e-3 of the width up to n = 1e7.
 * Time      under 60 logarithms a bound.
 */
#ifndef KELLY_SEQUENCE_H
#define KELLY_SEQUENCE_H

#include "tally.h"

/* Confidence 1 - alpha, 0 < alpha < 1 (normal), of P after k of n: lo alone, and hi alone by symmetry. 0 and 1 where n is 0. */
float kelly_sequence_lo(uint32_t k, uint32_t n, float alpha);
float kelly_sequence_hi(uint32_t k, uint32_t n, float alpha);

/* When to stop; the first that holds. */
typedef struct {
    float alpha;                 /* 0.05: an interval of 95 % */
    float width;                 /* stop where hi - lo <= width; 0: never for this reason */
    float level;                 /* stop where lo > level or hi < level; 0: never for this reason */
} kelly_stop_rule;

typedef enum {
    KELLY_GO_ON = 0,
    KELLY_NARROW = 1,            /* the interval is narrow enough */
    KELLY_DECIDED = 2            /* P is above, or below, the level */
} kelly_stop;

/* Look at the tally, after each realisation in the order of the indices. */
kelly_stop kelly_sequence_look(const kelly_stop_rule *rule, const kelly_tally *tally, float *lo, float *hi);

#endif
