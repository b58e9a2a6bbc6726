/* problem.c - the reference trajectory, the comparison with it, and the clock. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define BENCH_RHS
#include "run.h"

double now(void)
{
    struct timespec t;

    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

double busy(void)
{
    struct timespec t;

    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static int order(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;

    return (x > y) - (x < y);
}

double median(const double *x, unsigned n)
{
    double copy[ROUNDS_MAX];

    memcpy(copy, x, n * sizeof(*x));
    qsort(copy, n, sizeof(*copy), order);
    return n == 0 ? (double)NAN : n % 2 ? copy[n / 2] : 0.5 * (copy[n / 2 - 1] + copy[n / 2]);
}

double *make_reference(const problem *p)
{
    const double h = 1e-3 / FINE;
    double *const w = malloc((STEPS * FINE + 1) * sizeof(*w));
    double y[2 * MODES], at[2 * MODES], k[4][2 * MODES];

    start(p, y);
    for (long n = 0; w && n <= (long)STEPS * FINE; n++) {
        const double t = (double)n * h;

        w[n] = speed_of(p, y);
        for (int stage = 0; stage < 4; stage++) {
            const double part = stage == 0 ? 0 : stage == 3 ? h : h / 2;

            for (int i = 0; i < 2 * MODES; i++) {
                at[i] = stage == 0 ? y[i] : y[i] + part * k[stage - 1][i];
            }
            rhs(p, t + part, at, k[stage]);
        }
        for (int i = 0; i < 2 * MODES; i++) {
            y[i] += h / 6 * (k[0][i] + 2 * (k[1][i] + k[2][i]) + k[3][i]);
        }
    }
    return w;
}

/* The reference between its points: the cubic through the four nearest. */
void observe_error(observer *o, double t, double w)
{
    const double x = t * (1e3 * FINE);
    const long last = (long)STEPS * FINE - 2;
    long n = (long)x;
    double s, between, error;
    const double *r;

    n = n < 1 ? 1 : n > last ? last : n;
    s = x - (double)n;
    r = &o->reference[n];
    between = -s * (s - 1) * (s - 2) / 6 * r[-1] + (s + 1) * (s - 1) * (s - 2) / 2 * r[0] - (s + 1) * s * (s - 2) / 2 * r[1]
              + (s + 1) * s * (s - 1) / 6 * r[2];
    error = fabs(w - between);
    o->error = error <= o->error ? o->error : error;    /* a NaN stays */
}
