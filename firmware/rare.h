/* rare.h - small probabilities of stick-slip by subset simulation (Au and Beck 2001), in the caller's memory.
 *
 * The rare event is reached over a chain of events of which each has p = 0.1 given the one before: P = p_0 p_1 ... p_m.
 * A level holds n samples. The tenth of them with the largest guide start Markov chains of ten states within the next event.
 *
 *     guide   g = R^8 ss,  and KELLY_RARE_FAILED where ss > limit, which alone is the event
 *             R = b_1^2 T'(w0) / (alpha + beta w_1^2), at least 1e-4: the negative damping by the rock over the damping of the first mode
 *             T' = mu fc [ a1 (a2 w^2 - 1) / (1 + a2 w^2)^2 - sech^2 w ], the slope of -T of eq. (B)
 *
 * ss alone traps the chains where f_a meets a torsional mode, w0 = w_i: there it rises and leads nowhere. R leads past. At 2.19e-8
 * (mu 0.004, 240 rpm, all laws at 0.1), 40 seeds: R^4 ss gave 1.15 of it in the median, 1.18 +- 0.06 in the mean, R^8 ss 1.00 and
 * 1.11 +- 0.07, with a long tail to large answers. At 1e-5 and above the mean is within 4 % and the spread at most 0.23.
 *
 *     walk    in the x of kelly_gamma_value, one x a random parameter, by conditional sampling: along each axis of the seeds' scatter
 *             x' = sqrt(1 - s^2) x + s u, u normal, keeps the normal law whatever s; s = step times the scatter along that axis, at
 *             most 1, so that a chain forgets quickly what the event leaves free. With probability exp(log_weight(x') - log_weight(x))
 *             it keeps the gamma law. One step, moved after each quarter of the chains towards an acceptance of 0.4.
 *
 * A first level with n / 10 failures is plain Monte Carlo, and read as such: its draws are those of kelly_run for the same seed.
 *
 * The caller evaluates: kelly_rare_start; then, while kelly_rare_count(rare) > 0, set the guide of each sample
 * rare->samples[rare->first ..], kelly_rare_count of them, in any order, and call kelly_rare_accept; then kelly_rare_read.
 *
 * Random  stream (seed, level, chain, step): the same samples on every machine, at any number of lanes or threads.
 * Memory  sizeof(kelly_rare) + 32 n bytes, the caller's.
 * Cost    n + 0.9 n a level beyond the first realisations, and some 20 n log n operations a level.
 */
#ifndef KELLY_RARE_H
#define KELLY_RARE_H

#include "random.h"
#include "tally.h"

#define KELLY_RARE_STATES 10u           /* of a chain, its seed included: 1 / p */
#define KELLY_RARE_LEVELS 12u           /* at most; p^12 */
#define KELLY_RARE_LEAST W(1e-9)        /* smallest P that is reported */
#define KELLY_RARE_DISTINCT 50u         /* fewest different failures in the last level */
#define KELLY_RARE_MIN 200u             /* samples a level: a multiple of 40 in MIN..MAX */
#define KELLY_RARE_MAX 1000000u

#define KELLY_RARE_FAILED 0x1.fffffep127f
#define KELLY_RARE_REFUSED (-1.0f)

typedef struct {
    float x[KELLY_PARAMETERS];          /* 0 where the parameter is not random */
    float guide;                        /* >= 0, KELLY_RARE_FAILED, or KELLY_RARE_REFUSED: this draw cannot be run */
    uint32_t id;                        /* realisation that it came from, in the order of proposal: copies share it */
} kelly_rare_sample;

typedef enum {
    KELLY_RARE_RUNNING,
    KELLY_RARE_DONE,                    /* kelly_rare_read has the answer; below: why there is none */
    KELLY_RARE_NO_FAILURE,              /* not one, down to KELLY_RARE_LEAST */
    KELLY_RARE_TOO_RARE,                /* P < KELLY_RARE_LEAST */
    KELLY_RARE_FEW,                     /* under KELLY_RARE_DISTINCT different failures */
    KELLY_RARE_STILL,                   /* a level accepted under a tenth of its moves: the chains hardly move */
    KELLY_RARE_DEEP,                    /* more than KELLY_RARE_LEVELS levels */
    KELLY_RARE_UNKNOWN                  /* draws were refused, in a place that failures may share: no rejected move */
} kelly_rare_state;

#define KELLY_RARE_OUTCOMES 8

typedef struct {
    float guide;                        /* of the next event; KELLY_RARE_FAILED in the last level */
    float step;                         /* of the walk, at the end of the level */
    uint32_t failed, refused;           /* of its samples; of its realisations */
    uint32_t proposed, accepted;        /* moves; 0 in the first level */
    uint32_t inside;                    /* samples in the next event, p = inside / n */
    wide variance;                      /* squared coefficient of variation of p, eq. 27 and 29 of Au and Beck */
} kelly_rare_level;

/* Not to be written, except the guides. */
typedef struct {
    float cov[KELLY_PARAMETERS];
    uint64_t seed;
    uint32_t n, chains;                 /* samples a level, n / KELLY_RARE_STATES */
    kelly_rare_sample *samples;         /* [n]; state s of chain c at s * chains + c */
    uint32_t *keys;                     /* [n] scratch */
    kelly_rare_state state;
    uint32_t level, quarter, at;        /* at: state of the chains that is proposed */
    uint32_t first, count;              /* samples to be evaluated */
    uint32_t realisations;
    uint32_t quarter_accepted;
    float step;
    float axis[KELLY_PARAMETERS][KELLY_PARAMETERS];   /* of the seeds' scatter, one a column */
    float scatter[KELLY_PARAMETERS];    /* along it, a standard deviation */
    float guide;                        /* of the present event */
    uint32_t distinct;                  /* different failures in the last level */
    kelly_rare_level levels[KELLY_RARE_LEVELS];
} kelly_rare;

typedef struct {
    wide probability;
    wide lo, hi;                        /* 95 %: log-normal, or Clopper and Pearson where `plain` */
    wide cov;                           /* coefficient of variation of the estimate */
    int plain;                          /* the first level was enough */
} kelly_rare_estimate;

/* Begin with n samples a level; samples[n] and keys[n] stay in use. 0, or what is wrong: n, or that nothing is random. */
const char *kelly_rare_start(kelly_rare *rare, const float cov[KELLY_PARAMETERS], uint64_t seed, uint32_t n,
                             kelly_rare_sample *samples, uint32_t *keys);

/* Samples that wait for their guide, from rare->first on; 0 at the end, and rare->state says which. */
uint32_t kelly_rare_count(const kelly_rare *rare);

/* All of them have it: accept or reject the moves, and propose what comes next. */
void kelly_rare_accept(kelly_rare *rare);

/* The answer of a run that is KELLY_RARE_DONE. */
void kelly_rare_read(const kelly_rare *rare, kelly_rare_estimate *out);

/* For rare.c: axes and scatter of the seeds, the first `chains` samples. */
void kelly_rare_fit(kelly_rare *rare);

/* For rare.c: the next state of a chain; 0 where the laws turn it down. */
int kelly_rare_move(const kelly_rare *rare, kelly_rng *rng, const float old[KELLY_PARAMETERS], float next[KELLY_PARAMETERS]);

/* Whether a sample of a run that is over is one of its failures. */
int kelly_rare_failed(const kelly_rare_sample *sample);

/* One line, without a full stop, of what a state means. */
const char *kelly_rare_reason(kelly_rare_state state);

/* Parameters of a sample, and its guide once they have been run. */
void kelly_rare_draw(const kelly_case *run, const kelly_rare_sample *sample, kelly_draw *draw);
float kelly_rare_guide(const kelly_table *table, const kelly_case *run, const kelly_result *result);

#endif
