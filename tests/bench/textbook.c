/* textbook.c - classical RK4 written straight from the equations, one realisation at a time or one a vector lane.
 *
 *   (nothing)    double, tanh and sin of libm: what everybody writes first
 *   -DOWN        kelly's tanh (one division a torque) and sine by recurrence; float without -DKELLY_DOUBLE
 *   -DKELLY_WIDTH=n -DOWN   n lanes with GNU vectors, each with its own modes
 */
#ifdef OWN
#include "../../firmware/bitrock.h"
#define BENCH_RHS
#include "bench.h"
#else
#define BENCH_RHS
#include "bench.h"
typedef double vreal, real;
#define R(x) x
#endif

#ifdef OWN
#ifdef KELLY_DOUBLE
#define LIMIT ERROR_LIMIT
#define PRECISION "double"
#else
#define LIMIT 0.2
#define PRECISION "float"
#endif
#define FIRST(v) ((const real *)&(v))[0]
#else
#define LIMIT ERROR_LIMIT
#define FIRST(v) (v)
#endif

typedef struct {
    vreal w2[MODES], c[MODES], b[MODES], drag[MODES];
    vreal w0, a1, a2, mu, fc, f0;
} constants;

typedef struct {
    vreal q[MODES], v[MODES];
} state;

static vreal all(double x)
{
#if defined(OWN) && KELLY_WIDTH > 1
    return vsplat((real)x);
#else
    return (vreal)x;
#endif
}

static void set_up(const problem *p, constants *k, state *s)
{
    for (int i = 0; i < MODES; i++) {
        k->w2[i] = all(p->w2[i]);
        k->c[i] = all(p->c[i]);
        k->b[i] = all(p->b[i]);
        k->drag[i] = all(p->drag[i]);
        s->q[i] = all(0);
        s->v[i] = all(-p->d[i] * p->w0);
    }
    k->w0 = all(p->w0);
    k->a1 = all(p->a1);
    k->a2 = all(p->a2);
    k->mu = all(p->mu);
    k->fc = all(p->fc);
    k->f0 = all(p->f0);
}

static inline vreal torque(const constants *k, vreal w, vreal sine)
{
    const vreal f = k->f0 * (sine + R(0.01)) - k->fc;

#ifdef OWN
    return kelly_bit_torque(w, k->mu * vmin(f, all(0)), k->a1, k->a2);
#else
    return k->mu * (f < 0 ? f : 0) * (tanh(w) + k->a1 * w / (1 + k->a2 * w * w));
#endif
}

static inline vreal speed(const constants *k, const state *s)
{
    vreal w = k->w0;

    for (int i = 0; i < MODES; i++) {
        w += k->b[i] * s->v[i];
    }
    return w;
}

static inline void derive(const constants *k, vreal w, vreal sine, const state *s, state *ds)
{
    const vreal t = torque(k, w, sine);

    for (int i = 0; i < MODES; i++) {
        ds->q[i] = s->v[i];
        ds->v[i] = k->b[i] * t - k->drag[i] - k->c[i] * s->v[i] - k->w2[i] * s->q[i];
    }
}

static inline void along(state *to, const state *from, const state *ds, real h)
{
    for (int i = 0; i < MODES; i++) {
        to->q[i] = from->q[i] + h * ds->q[i];
        to->v[i] = from->v[i] + h * ds->v[i];
    }
}

static inline void step(const constants *k, state *s, vreal w, const vreal sine[3], real h)
{
    state k1, k2, k3, k4, at;

    derive(k, w, sine[0], s, &k1);
    along(&at, s, &k1, h / 2);
    derive(k, speed(k, &at), sine[1], &at, &k2);
    along(&at, s, &k2, h / 2);
    derive(k, speed(k, &at), sine[1], &at, &k3);
    along(&at, s, &k3, h);
    derive(k, speed(k, &at), sine[2], &at, &k4);
    for (int i = 0; i < MODES; i++) {
        s->q[i] += h / 6 * (k1.q[i] + 2 * (k2.q[i] + k3.q[i]) + k4.q[i]);
        s->v[i] += h / 6 * (k1.v[i] + 2 * (k2.v[i] + k3.v[i]) + k4.v[i]);
    }
}

static void run(const problem *p, const setting *set, observer *o)
{
    const long n = (long)(SECONDS / set->h + 0.5);
    const real h = (real)set->h;
    constants k;
    state s;
    vreal w;
#ifdef OWN
    double half_turn = sin(0.5 * p->w0 * set->h);
    const vreal gain = all(4 * half_turn * half_turn), half = all(0.5 / cos(0.5 * p->w0 * set->h));
    vreal sine = all(0), change = all(0);
#endif

    set_up(p, &k, &s);
    w = speed(&k, &s);
    observe(o, 0, (double)FIRST(w));
    for (long j = 0; j < n; j++) {
        const double t = (double)j * set->h;
#ifdef OWN
        vreal at[3];

        if (j % 2048 == 0) {     /* the recurrence drifts in float */
            sine = all(sin(p->w0 * t));
            change = all(2 * cos(p->w0 * (t + 0.5 * set->h)) * half_turn);
        }
        at[0] = sine;
        at[2] = sine + change;
        at[1] = (at[0] + at[2]) * half;
        change = change - gain * at[2];
        sine = at[2];
#else
        const vreal at[3] = { sin(p->w0 * t), sin(p->w0 * (t + 0.5 * set->h)), sin(p->w0 * (t + set->h)) };
#endif
        step(&k, &s, w, at, h);
        w = speed(&k, &s);
        observe(o, (double)(j + 1) * set->h, (double)FIRST(w));
    }
}

#if !defined(OWN)
const peer NAME[] = { { "textbook C, libm, double", FLAGS, { .h = 1e-3 }, LIMIT, 1, run }, { 0 } };
#elif KELLY_WIDTH > 1
const peer NAME[] = { { "textbook C, own functions, all lanes, " PRECISION, FLAGS, { .h = 1e-3 }, LIMIT, KELLY_WIDTH, run }, { 0 } };
#else
const peer NAME[] = { { "textbook C, own functions, " PRECISION, FLAGS, { .h = 1e-3 }, LIMIT, 1, run }, { 0 } };
#endif
