/* sobol.h - which parameter the answer depends on: first-order and total indices of Sobol, in fixed memory.
 *
 *     first_i = V(E(f | Y_i)) / V(f)          what would go, on average, if Y_i were known
 *     total_i = E(V(f | all but Y_i)) / V(f)  what would stay, on average, if all but Y_i were known
 *
 * A row takes two independent draws A and B and, for each parameter, A with that parameter from B:
 *
 *     V first_i = mean of (f(B) - m) (f(AB_i) - f(A))      Saltelli et al. (2010), table 2 (b), about the mean m
 *     V total_i = mean of (f(A) - f(AB_i))^2 / 2           Jansen (1999), table 2 (f)
 *
 * with m and V from all f(A) and f(B). Taking m off changes no expectation and most of the variance.
 *
 * Intervals  95 %, jackknife over KELLY_SOBOL_GROUPS groups (row j in group j mod 32), each left out in turn, Student's t with
 *            31 degrees of freedom. They are of the estimate, and may pass 0 and 1. They want 10 rows a group or so; there are
 *            none before every group has 2. Where f is constant there is no index.
 * Memory     sizeof(kelly_sobol), 5 KB on a host; any number of rows up to 2^24.
 */
#ifndef KELLY_SOBOL_H
#define KELLY_SOBOL_H

#include "realisation.h"

#define KELLY_SOBOL_GROUPS 32
#define KELLY_SOBOL_ROW (KELLY_PARAMETERS + 2)   /* draws of a row, at most */

/* Sums of a group. Values are taken relative to the first one, so that a large mean takes no digits away. */
typedef struct {
    uint32_t n;
    wide ab, aabb;               /* f(A) + f(B); their squares */
    wide d[KELLY_PARAMETERS];    /* f(AB_i) - f(A) */
    wide bd[KELLY_PARAMETERS];   /* f(B) times it */
    wide dd[KELLY_PARAMETERS];   /* its square */
} kelly_sobol_sums;

typedef struct {
    unsigned parameters;         /* 1..KELLY_PARAMETERS */
    uint32_t rows;
    wide origin;
    kelly_sobol_sums group[KELLY_SOBOL_GROUPS];
} kelly_sobol;

typedef struct {
    wide value, lo, hi;
} kelly_estimate;

/* Parameters that are random in this case, in the order of the laws; returns their number. */
unsigned kelly_sobol_random(const kelly_case *run, unsigned which[KELLY_PARAMETERS]);

/* Draws of row `index`: A, B, AB_i for each of the random parameters; returns their number. A is realisation `index` of
 * `seed`; B is that of the seed that splitmix64 makes of it. */
unsigned kelly_sobol_row(const kelly_case *run, uint64_t seed, uint32_t index, kelly_draw draws[KELLY_SOBOL_ROW]);

void kelly_sobol_clear(kelly_sobol *sobol, unsigned parameters);

/* f(A), f(B), f(AB_i): finite, [parameters + 2], up to 1e12 where wide is double: nothing overflows then. In the order of the indices. */
void kelly_sobol_add(kelly_sobol *sobol, const wide f[]);

/* Mean and variance of f, from all f(A) and f(B); zeros while there are none. */
void kelly_sobol_moments(const kelly_sobol *sobol, wide *mean, wide *spread);

/* Indices of one parameter; 0 where there are none (see above). */
int kelly_sobol_read(const kelly_sobol *sobol, unsigned parameter, kelly_estimate *first, kelly_estimate *total);

#endif
