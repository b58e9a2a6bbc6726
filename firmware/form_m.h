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

KELLY_INLINE sums_m outputs_m(const kelly_mode *mode)
{
    const vreal z = mode->m2 * mode->xi + mode->m3 * mode->zeta;
    const vreal x = mode->m0 * mode->xi + mode->m1 * mode->zeta;
    const vreal wx = mode->w * x;

    return (sums_m){ .x = x, .z = z, .wx = wx, .wz = mode->w * z, .wwx = mode->w * wx };
}

KELLY_INLINE void add_m(sums_m *sum, sums_m one)
{
    sum->x = sum->x + one.x;
    sum->z = sum->z + one.z;
    sum->wx = sum->wx + one.wx;
    sum->wz = sum->wz + one.wz;
    sum->wwx = sum->wwx + one.wwx;
}

/* x <- x + D x + inputs; returns the outputs. */
KELLY_INLINE sums_m move_m(kelly_mode *mode, const inputs_m *in)
{
    kelly_mode now = *mode;
    const vreal xi = now.xi, zeta = now.zeta;

    now.xi = xi + ((now.d00 * xi + now.d01 * zeta) + (in->s0 + now.w * (in->e1 + now.w * in->e2)));
    now.zeta = zeta + ((now.d10 * xi + now.d11 * zeta) + (in->e4 + now.w * in->e3));
    mode->xi = now.xi;
    mode->zeta = now.zeta;
    return outputs_m(&now);
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
    sums_m sum = move_m(mode, &in);

    while (++mode < end) {
        add_m(&sum, move_m(mode, &in));
    }
    stage_speeds_m(on, &sum, al, be);
}

#endif
