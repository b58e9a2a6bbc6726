/* form_m.h - the modes of one RK4 step in form M, piece by piece. See integrator.h for the form. */
#ifndef KELLY_FORM_M_H
#define KELLY_FORM_M_H

#include "stages.h"

/* Sums over the modes of the outputs X and Z/2, of w X/4 and w Z/8, and of w w X/16: powers of two that the stage speeds want. */
typedef struct {
    vreal x, z, wx, wz, wwx;
} sums_m;

/* The torques of one step as the modes need them: xi gains s0 + w/4 (e1 + w/4 e2), zeta gains e4 + w/4 e3. */
typedef struct {
    vreal s0, e1, e2, e3, e4;
} inputs_m;

KELLY_INLINE sums_m outputs_m(const kelly_mode *mode)
{
    const vreal z = mode->m2 * mode->xi + mode->m3 * mode->zeta;
    const vreal x = mode->m0 * mode->xi + mode->m1 * mode->zeta;
    const vreal wx = mode->w4 * x;

    return (sums_m){ .x = x, .z = z, .wx = wx, .wz = mode->w4 * z, .wwx = mode->w4 * wx };
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
KELLY_INLINE sums_m move_m(kelly_mode *mode, const inputs_m *in, vbits *guard)
{
    kelly_mode now = *mode;
    const vreal xi = vtake(&mode->xi, guard), zeta = vtake(&mode->zeta, guard);

    now.xi = xi + ((now.d00 * xi + now.d01 * zeta) + (in->s0 + now.w4 * (in->e1 + now.w4 * in->e2)));
    now.zeta = zeta + ((now.d10 * xi + now.d11 * zeta) + (in->e4 + now.w4 * in->e3));
    vput(&mode->xi, now.xi, guard);
    vput(&mode->zeta, now.zeta, guard);
    return outputs_m(&now);
}

/* Stage speeds of the next step, torque-free, from the sums: v, v + v'/2, v + v'/2 + v''/4, v + v' + v''/2 + v'''/4. */
KELLY_INLINE void stage_speeds_m(kelly_lane *lane, const sums_m *sum, real al, real be, vbits *guard)
{
    const real b4 = R(4.0) * be, wz = R(2.0) * (al * be - R(1.0)), two = R(2.0) - al;
    const vreal n = sum->wx + R(0.5) * al * sum->z;                    /* -v'' / 4 */
    const vreal y1 = (lane->w0 + sum->x) - R(2.0) * be * sum->z, y2 = y1 + sum->z;

    vput(&lane->y1, y1, guard);
    vput(&lane->y2, y2, guard);
    vput(&lane->y3, y2 - n, guard);
    vput(&lane->y4, (y2 + sum->z) + ((b4 * sum->wwx + wz * sum->wz) - two * n), guard);
}

KELLY_INLINE inputs_m inputs_of_m(vreal t1, const stages *at, real al, real be)
{
    const vreal t12 = t1 + at->t2, t23 = at->t2 + at->t3, sum = t1 + t23;
    inputs_m in;

    in.s0 = sum + (t23 + at->t4);
    in.e1 = al * t1 - (t12 + t12);
    in.e2 = R(4.0) * be * t1;
    in.e3 = (al * be - R(1.0)) * t1;
    in.e4 = (sum - be * in.s0) + R(0.25) * al * in.e1;
    return in;
}

/* The modes under the four torques, and the stage speeds of the next step. */
KELLY_INLINE void finish_m(kelly_lane *on, kelly_mode *mode, unsigned modes, const stages *at, real al, real be, vbits *changed)
{
    const inputs_m in = inputs_of_m(vtake(&on->t1, changed), at, al, be);
    const kelly_mode *const end = mode + modes;
    sums_m sum = move_m(mode, &in, changed);

    while (++mode < end) {
        add_m(&sum, move_m(mode, &in, changed));
    }
    stage_speeds_m(on, &sum, al, be, changed);
}

#endif
