/* random.h - streams of random numbers that any machine can recompute alone.
 *
 * A stream is keyed by (seed, index, stream): realisation `index` of `seed`, parameter `stream`. Nothing is drawn in
 * an order that threads or lanes could change. Everything is computed in float, in both precisions of the kernel.
 *
 * splitmix64 (Steele, Lea, Flood 2014) makes keys; xoshiro128++ (Blackman, Vigna 2019), an xorshift generator on
 * 32-bit words, makes words; Marsaglia's polar method makes normals; Marsaglia and Tsang (2000) make gammas.
 */
#ifndef KELLY_RANDOM_H
#define KELLY_RANDOM_H

#include "real.h"

typedef struct {
    uint32_t s[4];               /* never all zero; not to be touched */
} kelly_rng;

/* Next word of splitmix64; any state is good. */
uint64_t kelly_splitmix64(uint64_t *state);

/* Start the stream (seed, index, stream): each of the three goes through the whole of splitmix64 in turn, so that
 * neighbours share nothing. Two of n streams coincide with probability n^2 / 2^65. */
void kelly_rng_key(kelly_rng *rng, uint64_t seed, uint32_t index, uint32_t stream);

/* Next word of xoshiro128++, period 2^128 - 1. */
uint32_t kelly_rng_next(kelly_rng *rng);

/* Skip 2^64 words. */
void kelly_rng_jump(kelly_rng *rng);

/* The uniform of a word: one of (2k + 1) 2^-24, k = 0 .. 2^23 - 1; never 0, never 1, symmetric about 1/2. */
float kelly_open01(uint32_t word);

/* Standard normal; |x| <= 9.3, the largest that 32-bit words give. Two words a try, 1.27 tries on average, at most 64. */
float kelly_normal(kelly_rng *rng);

/* Gamma law with this mean (> 0) and coefficient of variation cov, 1e-4 <= cov <= 0.5 (shape 1/cov^2 >= 4). Below 1e-4
 * the spread is lost in the 24 digits of float. At most 64 tries, each accepted with probability above 0.95. */
float kelly_gamma(kelly_rng *rng, float mean, float cov);

/* The same gamma in steps, for a walk in x: it is value(x) where x has the density of a standard normal times exp(log_weight(x)),
 * log_weight <= 0. kelly_gamma_normal draws that x; kelly_gamma is the value of it. The weight is KELLY_NO_WEIGHT where the
 * value would not be positive. |x| <= 1000 and a mean of 1e30 at most leave all of it finite. */
#define KELLY_NO_WEIGHT (-1e30f)
float kelly_gamma_normal(kelly_rng *rng, float cov);
float kelly_gamma_value(float x, float mean, float cov);
float kelly_gamma_log_weight(float x, float cov);

#endif
