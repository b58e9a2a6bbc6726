/* peers_gsl.c - GSL odeiv2.
 *
 * Its rk4 takes every step twice, whole and in two halves, and returns the result of the halves: at 2 ms it is as
 * accurate as RK4 at 1 ms, and half as expensive as at 1 ms.
 */
#include <gsl/gsl_odeiv2.h>

#define BENCH_RHS
#include "bench.h"

static int derive(double t, const double y[], double dy[], void *params)
{
    rhs(params, t, y, dy);
    return 0;
}

static void fixed(const problem *p, const setting *set, observer *o)
{
    problem copy = *p;
    gsl_odeiv2_system system = { derive, 0, 2 * MODES, &copy };
    gsl_odeiv2_step *step = gsl_odeiv2_step_alloc(gsl_odeiv2_step_rk4, 2 * MODES);
    const long n = (long)(SECONDS / set->h + 0.5);
    double y[2 * MODES], error[2 * MODES], from[2 * MODES], to[2 * MODES];

    start(p, y);
    rhs(p, 0, y, from);
    observe(o, 0, speed_of(p, y));
    for (long j = 0; j < n; j++) {
        gsl_odeiv2_step_apply(step, (double)j * set->h, set->h, y, error, from, to, &system);
        for (int i = 0; i < 2 * MODES; i++) {
            from[i] = to[i];
        }
        observe(o, (double)(j + 1) * set->h, speed_of(p, y));
    }
    gsl_odeiv2_step_free(step);
}

static void adaptive_with(const gsl_odeiv2_step_type *type, const problem *p, const setting *set, observer *o)
{
    problem copy = *p;
    gsl_odeiv2_system system = { derive, 0, 2 * MODES, &copy };
    gsl_odeiv2_step *step = gsl_odeiv2_step_alloc(type, 2 * MODES);
    gsl_odeiv2_control *control = gsl_odeiv2_control_y_new(set->atol, set->rtol);
    gsl_odeiv2_evolve *evolve = gsl_odeiv2_evolve_alloc(2 * MODES);
    double y[2 * MODES], t = 0, h = 1e-4;

    start(p, y);
    observe(o, 0, speed_of(p, y));
    while (t < SECONDS && gsl_odeiv2_evolve_apply(evolve, control, step, &system, &t, SECONDS, &h, y) == 0) {
        h = h < set->h ? h : set->h;
        observe(o, t, speed_of(p, y));
    }
    gsl_odeiv2_evolve_free(evolve);
    gsl_odeiv2_control_free(control);
    gsl_odeiv2_step_free(step);
}

static void rkf45(const problem *p, const setting *set, observer *o)
{
    adaptive_with(gsl_odeiv2_step_rkf45, p, set, o);
}

const peer NAME[] = {
    { "GSL rk4, 2 ms", FLAGS, { .h = 2e-3 }, ERROR_LIMIT, 1, fixed },
    { "GSL rkf45", FLAGS, { .h = 3.6e-3, .rtol = 1e-4, .atol = 1e-4 }, ERROR_LIMIT, 1, rkf45 },
    { 0 },
};
