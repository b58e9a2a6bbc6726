/* rare_events.h - what the tests of subset simulation share: its memory, events of known probability, and hints for them.
 *
 * One simulation for all of them, as in fixture.h: on a board the samples are most of the memory.
 */
#ifndef KELLY_RARE_EVENTS_H
#define KELLY_RARE_EVENTS_H

#include "check.h"
#include "fixture.h"

#define MOST BY_LENGTH(200, 2400)

extern kelly_rare rare;
extern kelly_rare_sample samples[MOST];
extern uint32_t keys[MOST];
extern kelly_rare_estimate answer;

/* Laws this narrow are normal to 1e-8 x^4 in the logarithm. */
extern const float normals[KELLY_PARAMETERS];
extern const float one_gamma[KELLY_PARAMETERS];

typedef enum { PLANE, FAR_OUT, CORNER, ISLAND, FREEZE, FLAT, REFUSE, REFUSE_FAR } event;

/* The guide of PLANE, a plane in five standard normals: P = Phi(-limit). */
float plane(const kelly_rare_sample *s, float limit);

/* Hints for it: a good one, one that looks 25 degrees aside, one that points the other way. */
extern const kelly_rare_hint good, blurred, wrong;
extern const kelly_rare_hint *advised;           /* leads simulate(); 0, no hint, between tests */

/* To the end; 1 if there is an answer. */
int simulate(event what, const float cov[KELLY_PARAMETERS], float limit, uint64_t seed, uint32_t n);

#endif
