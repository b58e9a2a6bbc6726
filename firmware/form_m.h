/* form_m.h - the modes of one RK4 step in form M, piece by piece. See integrator.h for the form. */
#ifndef KELLY_FORM_M_H
#define KELLY_FORM_M_H

#include "stages.h"

/* Sums over the modes of the outputs X and Z, and of w X, w Z, w w X. */
typedef struct {
    vreal x, z, wx, wz, wwx;
} sums_m;

/* The torques of one step as the modes need them: xi gains s0 + w (e1 + w e2), zeta gains e4 + w e3. */
typedef struct {
    vreal s0, e1, e2, e3, e4;
} inputs_m;

KELLY_INLINE void add_outputs_m(sums_m *sum, const kelly_mode *mode)
{
    const vreal z = mode->m2 * mode->xi + mode->m3 * mode->zeta;
    const vreal x = mode->m0 * mode->xi + mode->m1 * mode->zeta;
    const vreal wx = mode->w * x;

    sum->x = sum->x + x;
    sum->z = sum->z + z;
    sum->wx = sum->wx + wx;
    sum->wz = sum->wz + mode->w * z;
    sum->wwx = sum->wwx + mode->w * wx;
}

/* x <- x + D x + inputs */
KELLY_INLINE void move_m(kelly_mode *mode, const inputs_m *in)
{
    const vreal xi = mode->xi, zeta = mode->zeta;

    mode->xi = xi + ((mode->d00 * xi + mode->d01 * zeta) + (in->s0 + mode->w * (in->e1 + mode->w * in->e2)));
    mode->zeta = zeta + ((mode->d10 * xi + mode->d11 * zeta) + (in->e4 + mode->w * in->e3));
}

/* Stage speeds of the next step, torque-free, from the sums: v, v + v'/2, v + v'/2 + v''/4, v + v' + v''/2 + v'''/4. */
KELLY_INLINE void stage_speeds_m(kelly_lane *lane, const sums_m *sum, real al, real be)
{
    const vreal n = sum->wx + al * sum->z;                             /* -v'' */
    const vreal third = al * n - (R(1.0) - al * be) * sum->wz;         /* v''' without its term in w w X */

    lane->y1 = (lane->w0 + sum->x) - be * sum->z;
    lane->y2 = lane->y1 + R(0.5) * sum->z;
    lane->y3 = lane->y2 - R(0.25) * n;
    lane->y4 = (lane->y1 + sum->z) + (R(0.25) * (third + be * sum->wwx) - R(0.5) * n);
}

KELLY_INLINE inputs_m inputs_of_m(const kelly_lane *on, const stages *at, real al, real be)
{
    const vreal t23 = at->t2 + at->t3, quarter = R(0.25) * on->t1;
    inputs_m in;

    in.s0 = (on->t1 + at->t4) + (t23 + t23);
    in.e1 = al * quarter - R(0.5) * (on->t1 + at->t2);
    in.e2 = be * quarter;
    in.e3 = (al * be - R(1.0)) * quarter;
    in.e4 = ((on->t1 + t23) - be * in.s0) + al * in.e1;
    return in;
}

/* The modes under the four torques, and the stage speeds of the next step. */
KELLY_INLINE void finish_m(kelly_lane *on, kelly_mode *mode, unsigned modes, const stages *at, real al, real be)
{
    const inputs_m in = inputs_of_m(on, at, al, be);
    const kelly_mode *const end = mode + modes;
    sums_m sum = { .x = vsplat(0) };

    for (; mode < end; mode++) {
        kelly_mode now = *mode;

        move_m(&now, &in);
        mode->xi = now.xi;
        mode->zeta = now.zeta;
        add_outputs_m(&sum, &now);
    }
    stage_speeds_m(on, &sum, al, be);
}

#endif
