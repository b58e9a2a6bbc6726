/* form_m.h - one RK4 step in form M, piece by piece: what integrator.c and block.c share. See integrator.h for the form. */
#ifndef KELLY_FORM_M_H
#define KELLY_FORM_M_H

#include "bitrock.h"
#include "integrator.h"

/* Sums over the modes of the outputs X and Z, and of w X, w Z, w w X. */
typedef struct {
    vreal x, z, wx, wz, wwx;
} sums;

/* Second to fourth stage torque of a step, and mu f at half of it. */
typedef struct {
    vreal half, t2, t3, t4;
} stages;

/* The torques of one step as the modes need them: xi gains s0 + w (e1 + w e2), zeta gains e4 + w e3. */
typedef struct {
    vreal s0, e1, e2, e3, e4;
} inputs;

/* A mode comes into registers as one block, and the pointer goes on: one instruction on a Cortex-M with an FPU. */
#if defined(__arm__) && defined(__ARM_FP) && !defined(KELLY_DOUBLE) && KELLY_WIDTH == 1
KELLY_INLINE kelly_mode fetch(kelly_mode **from)
{
    register real w __asm("s16"), d00 __asm("s17"), d01 __asm("s18"), d10 __asm("s19"), d11 __asm("s20");
    register real m0 __asm("s21"), m1 __asm("s22"), m2 __asm("s23"), m3 __asm("s24"), xi __asm("s25"), zeta __asm("s26");

    __asm("vldmia %0!, {s16-s26}" : "+r"(*from), "=t"(w), "=t"(d00), "=t"(d01), "=t"(d10), "=t"(d11), "=t"(m0), "=t"(m1), "=t"(m2),
          "=t"(m3), "=t"(xi), "=t"(zeta) : "m"(**from));
    return (kelly_mode){ w, d00, d01, d10, d11, m0, m1, m2, m3, xi, zeta };
}
#else
KELLY_INLINE kelly_mode fetch(kelly_mode **from)
{
    return *(*from)++;
}
#endif

KELLY_INLINE void add_outputs(sums *sum, const kelly_mode *mode, int full)
{
    const vreal z = mode->m2 * mode->xi + mode->m3 * mode->zeta;
    const vreal x = mode->m0 * mode->xi + mode->m1 * mode->zeta;
    const vreal wx = mode->w * x;

    sum->x = sum->x + x;
    sum->z = sum->z + z;
    sum->wx = sum->wx + wx;
    sum->wz = sum->wz + mode->w * z;
    if (full) {
        sum->wwx = sum->wwx + mode->w * wx;
    }
}

/* x <- x + D x + inputs */
KELLY_INLINE void move(kelly_mode *mode, const inputs *in, int full)
{
    const vreal xi = mode->xi, zeta = mode->zeta;
    const vreal e = full ? in->e1 + mode->w * in->e2 : in->e1;

    mode->xi = xi + ((mode->d00 * xi + mode->d01 * zeta) + (in->s0 + mode->w * e));
    mode->zeta = zeta + ((mode->d10 * xi + mode->d11 * zeta) + (in->e4 + mode->w * in->e3));
}

/* Stage speeds of the next step, torque-free, from the sums: v, v + v'/2, v + v'/2 + v''/4, v + v' + v''/2 + v'''/4. */
KELLY_INLINE void stage_speeds(kelly_lane *lane, const sums *sum, real al, real be, int full)
{
    const vreal n = sum->wx + al * sum->z;                             /* -v'' */
    const vreal third = al * n - (R(1.0) - al * be) * sum->wz;         /* v''' */

    lane->y1 = (lane->w0 + sum->x) - be * sum->z;
    lane->y2 = lane->y1 + R(0.5) * sum->z;
    lane->y3 = lane->y2 - R(0.25) * n;
    lane->y4 = (lane->y1 + sum->z) + (R(0.25) * (full ? third + be * sum->wwx : third) - R(0.5) * n);
}

KELLY_INLINE inputs inputs_of(vreal t1, vreal t2, vreal t3, vreal t4, real al, real be)
{
    const vreal t23 = t2 + t3, quarter = R(0.25) * t1;
    inputs in;

    in.s0 = (t1 + t4) + (t23 + t23);
    in.e1 = al * quarter - R(0.5) * (t1 + t2);
    in.e2 = be * quarter;
    in.e3 = (al * be - R(1.0)) * quarter;
    in.e4 = ((t1 + t23) - be * in.s0) + al * in.e1;
    return in;
}

/* Torque at the present tick: the first stage of the step to come. */
KELLY_INLINE void first_torque(kelly_lane *on)
{
    on->t1 = kelly_bit_torque(on->y1, on->muf, on->a1, on->a2);
}

/* Second stage, at half a step; takes the weight and the sine to the next tick. */
KELLY_INLINE void second_torque(kelly_lane *on, stages *at)
{
    const vreal sine = on->sine + on->dsine;

    at->half = vmin(on->muf_mean + on->muf_swing * ((on->sine + sine) * on->sine_half), vsplat(0));
    on->muf = vmin(on->muf_mean + on->muf_swing * sine, vsplat(0));
    on->dsine = on->dsine - on->sine_k * sine;
    on->sine = sine;
    at->t2 = kelly_bit_torque(on->y2 + on->g1 * on->t1, at->half, on->a1, on->a2);
}

KELLY_INLINE void third_torque(const kelly_lane *on, stages *at)
{
    at->t3 = kelly_bit_torque((on->y3 + on->g2 * on->t1) + on->g1 * at->t2, at->half, on->a1, on->a2);
}

KELLY_INLINE void fourth_torque(const kelly_lane *on, stages *at)
{
    const vreal y = (on->y4 + on->g3 * on->t1) + (on->g2 + on->g2) * at->t2;

    at->t4 = kelly_bit_torque(y + (on->g1 + on->g1) * at->t3, on->muf, on->a1, on->a2);
}

/* The modes under the four torques, and the stage speeds and first torque of the next step. */
KELLY_INLINE void finish(kelly_lane *on, kelly_mode *mode, unsigned modes, const stages *at, real al, real be, int full)
{
    const inputs in = inputs_of(on->t1, at->t2, at->t3, at->t4, al, be);
    const kelly_mode *const end = mode + modes;
    sums sum = { .x = vsplat(0) };

    while (mode < end) {
        kelly_mode now = fetch(&mode);

        move(&now, &in, full);
        mode[-1].xi = now.xi;
        mode[-1].zeta = now.zeta;
        add_outputs(&sum, &now, full);
    }
    stage_speeds(on, &sum, al, be, full);
    on->lowest = vmin(on->y1, on->lowest);
    on->highest = vmax(on->y1, on->highest);
    first_torque(on);
}

/* The sine of a lane from its exact integer phase, and the weight and torque that follow from it. */
void kelly_block_resync(kelly_block *block, unsigned lane);

#endif
