/* run.h - what the parts of the benchmark program share beyond bench.h. */
#ifndef BENCH_RUN_H
#define BENCH_RUN_H

#include "bench.h"

#define ROUNDS_MAX 64

/* Monotonic clock [s], for whole programs. */
double now(void);

/* Processor time of this process [s]: what others take of the core is not counted. */
double busy(void);

/* Of n <= ROUNDS_MAX values; NaN of none. */
double median(const double *x, unsigned n);

/* Bit speed every 1/FINE ms for SECONDS: textbook RK4 in double at that step. The caller frees it. */
double *make_reference(const problem *p);

/* One measurement into the results file, {"kind": "..", ...}; the format gives the other members. */
void record(const char *kind, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* Leave the one core for the children of this process (1) or come back to it (0). */
void spread(int out);

/* Time against samples, modes, lanes and threads; memory; the whole program. */
void growth(const char *program, const char *program_double, int is_long);

/* Machine instructions of the steps of one full block, by single-stepping a child over runs of two lengths: the
 * difference goes to the results file as address: count per step. */
void count_steps(const side *s, unsigned engine);

/* ---- the machine's peak (peak.c, built once for each vector unit) ----------------------------------------------- */

typedef struct {
    const char *name;            /* "sse2", "avx2", "avx512", with "+fma" */
    unsigned bits;
    double (*float_rate)(double seconds), (*double_rate)(double seconds);   /* [1e9 lane operations / s] */
} peak;

/* Measure all units as round `round`; write the medians of so many rounds. */
void peaks_round(unsigned round);
void peaks_record(unsigned rounds);

extern const peak peak_sse2, peak_avx2, peak_avx512, peak_fma_128, peak_fma_256, peak_fma_512;

#endif
