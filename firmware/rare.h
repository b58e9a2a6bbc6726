/* rare.h - small probabilities of stick-slip by subset simulation (Au and Beck 2001), in the caller's memory.
 *
 * The rare event is reached over a chain of events of which each has p = 0.1 given the one before: P = p_0 p_1 ... p_m.
 * A level holds n samples. The tenth of them with the largest guide start Markov chains of ten states within the next event.
 *
 *     guide   g = R^4 ss,  and KELLY_RARE_FAILED where ss > limit, which alone is the event
 *             R = b_1^2 T'(w0) / (alpha + beta w_1^2), at least 1e-6: the negative damping by the rock over the damping of the first mode
 *             T' = mu fc [ a1 (a2 w^2 - 1) / (1 + a2 w^2)^2 - sech^2 w ], the slope of -T of eq. (B)
 *
 * ss alone traps the chains where f_a meets a torsional mode, w0 = w_i: there it rises and leads nowhere. R leads past.
 *
 *     walk    in the x of kelly_gamma_value, one x a random parameter. A straight move (conditional sampling) is
 *             x' = sqrt(1 - s^2) x + s u, u normal, which keeps the normal law whatever s, and with probability
 *             exp(log_weight(x') - log_weight(x)) the gamma law. One step s for all, moved after each quarter of the chains
 *             towards an acceptance of 0.35.
 *     hint    R^4 times the ss of the linear string: what f_a keeps up at w0, and what is left of the start. It costs no realisation,
 *             and is within a tenth or two of g while the motion is small. Two moves in three are led by it: a chain of 8 steps
 *             over the laws within hint > level, softened, proposes; a realisation decides. It goes far and is accepted about every
 *             second time, where straight moves creep. It cannot make an answer wrong, only slow: the moves keep the law of
 *             the event whatever the hint is, and one by which fewer than a fifth are accepted leads no more.
 *             On a plane in five normals at 1e-6 (2400 a level, 100 seeds) the spread is 0.21 with a hint along it, 0.30 with one
 *             that looks 25 degrees aside, 0.29 with none, 0.37 with one that points the other way.
 *
 * One region. Where failures lie in two places, the guide leads to one of them, and the answer would be that of this one, or of the chance
 * by which a sample of an early level lay in the other. Three things are looked at, and an answer that they contradict is none:
 *
 *     finds   a find is a failure that was proposed from a sample that was none; its copies and what was proposed from it descend from it.
 *             With m_i of the last level's F failures from find i there are F^2 / sum m_i^2 of them in effect, at least KELLY_RARE_FINDS.
 *     look    a search for each mode, over the ss by which the linear string resonates in that mode alone, and so without a realisation,
 *             for draws where it exceeds 0.4 limit. It goes where f_a meets the mode, and ends where that is far rarer than the
 *             answer; some of what it ends with are run. P of the look times the share that fails is P of the failures there. Where
 *             the search has less of them by 2.33 standard deviations of both (1 %), and by a fifth of its answer, it has missed them.
 *     limit   Where it is less than 1.5 times the ss of the linear string at the means, failures come by ripples of ss of which neither
 *             guide nor hint knows: 3 times too few were found at 1.25 times, all at 1.6 times.
 *
 * A first level with n / 10 failures is plain Monte Carlo, and read as such: its draws are those of kelly_run for the same seed.
 *
 * The caller evaluates: kelly_rare_start; then, while kelly_rare_count(rare) > 0, set the guide of each sample
 * rare->samples[rare->first ..], kelly_rare_count of them, in any order, and call kelly_rare_accept; then kelly_rare_read.
 *
 * Ranges  those of string_model.h, and speeds of 0.01 rad/s and more: the hint divides by them, and is proved free of overflow from there.
 * Random  stream (seed, level, chain, step): the same samples on every machine, at any number of lanes or threads.
 * Memory  sizeof(kelly_rare) + 36 n bytes, the caller's; as much again for a look.
 * Cost    n + 0.9 n a level beyond the first realisations, some 20 n log n operations a level, 8 hints a led move.
 */
#ifndef KELLY_RARE_H
#define KELLY_RARE_H

#include "random.h"
#include "tally.h"

#define KELLY_RARE_STATES 10u           /* of a chain, its seed included: 1 / p */
#define KELLY_RARE_LEVELS 12u           /* at most; p^12 */
#define KELLY_RARE_LEAST W(1e-9)        /* smallest P that is reported */
#define KELLY_RARE_DISTINCT 50u         /* fewest different failures in the last level */
#define KELLY_RARE_FINDS(n) (2.0f + (float)(int32_t)(n) / 240.0f)    /* fewest finds in effect; 19 of 2400 were the fewest of 900 runs */
#define KELLY_RARE_MIN 200u             /* samples a level: a multiple of 40 in MIN..MAX */
#define KELLY_RARE_MAX 1000000u
#define KELLY_RARE_COV 1e-4f            /* of less a parameter is not random: string_model.h */

#define KELLY_RARE_FAILED 0x1.fffffep127f
#define KELLY_RARE_REFUSED (-1.0f)

typedef struct {
    float x[KELLY_PARAMETERS];          /* 0 where the parameter is not random */
    float guide;                        /* >= 0, KELLY_RARE_FAILED, or KELLY_RARE_REFUSED: this draw cannot be run */
    uint32_t id;                        /* realisation that it came from, in the order of proposal: copies share it */
    uint32_t find;                      /* of a failure: id of the find that it descends from */
} kelly_rare_sample;

typedef enum {
    KELLY_RARE_RUNNING,
    KELLY_RARE_DONE,                    /* kelly_rare_read has the answer; below: why there is none */
    KELLY_RARE_NO_FAILURE,              /* not one, down to KELLY_RARE_LEAST */
    KELLY_RARE_TOO_RARE,                /* P < KELLY_RARE_LEAST */
    KELLY_RARE_FEW,                     /* under KELLY_RARE_DISTINCT different failures */
    KELLY_RARE_STILL,                   /* a level accepted under a tenth of its moves: the chains hardly move */
    KELLY_RARE_DEEP,                    /* more than KELLY_RARE_LEVELS levels */
    KELLY_RARE_LUCK,                    /* under KELLY_RARE_FINDS finds */
    KELLY_RARE_ELSEWHERE,               /* kelly_rare_compare: failures were missed */
    KELLY_RARE_NEAR,                    /* kelly_rare_doubt: the limit is hardly more than what the string does anyway */
    KELLY_RARE_UNKNOWN                  /* draws were refused, in a place that failures may share: no rejected move */
} kelly_rare_state;

#define KELLY_RARE_OUTCOMES 11

typedef struct {
    float guide;                        /* of the next event; KELLY_RARE_FAILED in the last level */
    float step;                         /* of the walk, at the end of the level */
    uint32_t failed, refused;           /* of its samples; of its realisations */
    uint32_t proposed, accepted;        /* moves; 0 in the first level */
    uint32_t led, led_accepted;         /* those of them that the hint led */
    uint32_t inside;                    /* samples in the next event, p = inside / n */
    wide variance;                      /* squared coefficient of variation of p, eq. 27 and 29 of Au and Beck */
} kelly_rare_level;

/* What the hint is taken from: a string and its case; or, where there is a plane, no string at all but ln hint = sum of plane[k] x[k], for
 * an event whose direction is known. */
typedef struct {
    const kelly_table *table;
    const kelly_case *run;
    const float *plane;                 /* [KELLY_PARAMETERS], up to 60 each, or 0 */
} kelly_rare_hint;

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
    uint32_t straight, straight_accepted;   /* moves of the present quarter */
    float step;                         /* of straight moves */
    const kelly_rare_hint *hint;
    int leads;                          /* the hint is used */
    float hint_level;                   /* of the present event, as the hint sees it */
    float guide;                        /* of the present event */
    uint32_t distinct;                  /* different failures in the last level */
    float finds;                        /* finds in effect that they descend from */
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

/* Let `hint` lead the moves; it stays in use. Right after kelly_rare_start, or never: then all moves are straight. */
void kelly_rare_lead(kelly_rare *rare, const kelly_rare_hint *hint);

/* Samples that wait for their guide, from rare->first on; 0 at the end, and rare->state says which. */
uint32_t kelly_rare_count(const kelly_rare *rare);

/* All of them have it: accept or reject the moves, and propose what comes next. */
void kelly_rare_accept(kelly_rare *rare);

/* The answer of a run that is KELLY_RARE_DONE. */
void kelly_rare_read(const kelly_rare *rare, kelly_rare_estimate *out);

/* A look at a mode, in a search that was just started: all of it, some 0.3 us a sample and level, unless what it looks for is rarer than
 * `least`. Then the first `count` samples, at most `most` > 0, wait for their guide (kelly_rare_guide): some of all that it has found;
 * none where it has no answer. */
void kelly_rare_look(kelly_rare *look, const kelly_rare_hint *hint, unsigned mode, wide least, uint32_t most);

/* What of P a look saw, its samples run: 0 where none of them failed. */
typedef struct {
    wide probability;
    wide variance;                      /* squared coefficient of variation */
    uint32_t tried, failed;
} kelly_rare_seen;

void kelly_rare_see(const kelly_rare *look, kelly_rare_seen *seen);

/* A run that is KELLY_RARE_DONE, not plain, becomes KELLY_RARE_ELSEWHERE where a look has seen more. */
void kelly_rare_compare(kelly_rare *rare, const kelly_rare_hint *hint, unsigned mode, const kelly_rare_seen *seen);

/* A run that is KELLY_RARE_DONE, not plain, becomes KELLY_RARE_NEAR where its limit is. Not for a plane. */
void kelly_rare_doubt(kelly_rare *rare, const kelly_rare_hint *hint);

/* For rare.c: P of the present level's event. */
wide kelly_rare_product(const kelly_rare *rare);

/* For rare.c: level of the hint that stands for the present event, from the seeds, the first `chains` samples. */
void kelly_rare_aim(kelly_rare *rare);

/* For rare.c: the next state of a chain, straight or led; 0 where it stays. */
int kelly_rare_move(const kelly_rare *rare, kelly_rng *rng, int led, const float old[KELLY_PARAMETERS], float next[KELLY_PARAMETERS]);

/* Whether a sample of a run that is over is one of its failures. */
int kelly_rare_failed(const kelly_rare_sample *sample);

/* One line, without a full stop, of what a state means. */
const char *kelly_rare_reason(kelly_rare_state state);

/* Parameters of a sample, and its guide once they have been run. */
void kelly_rare_draw(const kelly_case *run, const kelly_rare_sample *sample, kelly_draw *draw);
float kelly_rare_guide(const kelly_table *table, const kelly_case *run, const kelly_result *result);

/* ss of the linear string at x as if it had this mode alone; 0 where x cannot be run. Not for a plane. */
float kelly_rare_resonance(const kelly_rare_hint *hint, const float x[KELLY_PARAMETERS], unsigned mode);

/* ss of the linear string at the means; 0 where they cannot be run. Not for a plane. */
float kelly_rare_own(const kelly_rare_hint *hint);

/* Logarithm of the hint for that guide at x, from any scale; far below all others where x cannot be run. Some 40 operations a mode. */
float kelly_rare_guess(const kelly_rare_hint *hint, const float x[KELLY_PARAMETERS]);

#endif
