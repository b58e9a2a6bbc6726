/* bench.h - what the parts of the benchmark share.
 *
 * Everybody solves the same equations, model (T), (W), (B), (F), from the same modal values: those of kelly's table at
 * the draw's weight on bit. A peer reports the bit speed after each of its own steps, since severity needs the extremes;
 * kelly does the same. What it reports is compared with a reference (textbook RK4 in double at 1/8 ms, some 1e-5 rpm)
 * before its time counts.
 */
#ifndef BENCH_H
#define BENCH_H

#include <stdint.h>
#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

#define MODES 10                 /* of the peers, a constant so that their compiler can unroll */
#define SECONDS 100.0
#define STEPS 100000             /* of 1 ms: the unit of all times is ns per simulated 1 ms and realisation */
#define FINE 8                   /* reference points a millisecond */
#define RPM 0.10471975511965977  /* [rad/s] */
#define ERROR_LIMIT 0.05         /* [rpm] of RK4 at 1 ms, and of whom it is compared with: kelly has 0.0445 at its worst step */
#define DRAWS 8                  /* drawn realisations beside the nominal one */

/* One realisation of the string: SI. */
typedef struct {
    double w2[MODES], c[MODES];  /* squared frequency [rad2/s2], damping alpha + beta w2 [1/s] */
    double b[MODES], d[MODES];
    double drag[MODES];          /* d alpha w0 */
    double fc, f0, mu, a1, a2, w0;
} problem;

/* What watches a run: extremes of the bit speed in the second half always, the error if there is a reference. */
typedef struct {
    double lowest, highest;      /* [rad/s] */
    const double *reference;     /* FINE points a ms, or 0 */
    double error;                /* largest |bit speed - reference| [rad/s] */
    long steps;
} observer;

void observe_error(observer *o, double t, double w);

static inline void observe(observer *o, double t, double w)
{
    if (t >= 0.5 * SECONDS) {
        o->lowest = w < o->lowest ? w : o->lowest;
        o->highest = w > o->highest ? w : o->highest;
    }
    o->steps++;
    if (o->reference) {
        observe_error(o, t, w);
    }
}

/* How a peer is to integrate: a fixed step, or tolerances and the longest step. */
typedef struct {
    double h, rtol, atol;
} setting;

/* One way of integrating, built one way. */
typedef struct {
    const char *name, *flags;
    setting set;
    double limit;                /* largest error against the reference that it may have [rpm] */
    unsigned lanes;              /* realisations that one call advances together (copies of the same) */
    void (*run)(const problem *p, const setting *set, observer *o);
} peer;

/* A list that ends with a name of 0. */
extern const peer textbook_O2[], textbook_O3[], textbook_fast[], own_double_O2[], own_double_O3[], own_float_O2[], own_float_O3[];
extern const peer lanes_double[], lanes_float[];
extern const peer gsl_O2[], gsl_O3[], gsl_fast[], sundials_O2[], sundials_O3[], sundials_fast[], boost_O2[], boost_O3[], boost_fast[];

/* Bit torque and derivatives with libm, what everybody writes first; y = q then v. Returns the bit speed. */
#ifdef BENCH_RHS
#include <math.h>
static inline double speed_of(const problem *p, const double *y)
{
    double w = p->w0;

    for (int i = 0; i < MODES; i++) {
        w += p->b[i] * y[MODES + i];
    }
    return w;
}

static inline void rhs(const problem *p, double t, const double *y, double *dy)
{
    const double w = speed_of(p, y);
    const double f = p->f0 * (sin(p->w0 * t) + 0.01) - p->fc;
    const double torque = p->mu * (f < 0 ? f : 0) * (tanh(w) + p->a1 * w / (1 + p->a2 * w * w));

    for (int i = 0; i < MODES; i++) {
        dy[i] = y[MODES + i];
        dy[MODES + i] = p->b[i] * torque - p->drag[i] - p->c[i] * y[MODES + i] - p->w2[i] * y[i];
    }
}

static inline void start(const problem *p, double *y)
{
    for (int i = 0; i < MODES; i++) {
        y[i] = 0;
        y[MODES + i] = -p->d[i] * p->w0;
    }
}
#endif

/* ---- kelly, in one precision, its state guarded or not (side.c, linked four times) ------------------------------------------------------------- */

typedef struct {
    const char *precision;
    int guarded;                 /* as it is shipped; or built with -DKELLY_GUARD=0 */
    /* Vector units, narrowest first, the scalar build before them; 0 behind the last one that runs here. */
    const char *(*engine)(unsigned e, unsigned *width, unsigned *lanes);
    /* `count` realisations from `first` on one engine, hard rock: returns the digest. cov < 0: the well's laws. */
    uint32_t (*run)(unsigned engine, double cov, unsigned modes, uint32_t ticks, uint32_t first, uint32_t count);
    /* Steps of the block as the last run left it. */
    void (*advance)(unsigned engine, uint32_t ticks);
    void (*problem)(long draw, problem *out);                /* draw < 0: nominal */
    double (*trace)(long draw, const double *reference);     /* largest error over the run [rad/s]; NaN if refused */
} side;

extern const side side_float, side_double, side_float_bare, side_double_bare;

#ifdef __cplusplus
}
#endif

#endif
