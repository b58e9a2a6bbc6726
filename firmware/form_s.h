/* form_s.h - the modes of one RK4 step in form S, for slow modes in float. See integrator.h for the form. */
#ifndef KELLY_FORM_S_H
#define KELLY_FORM_S_H

#include "stages.h"

/* Sums over the modes: v, w v / 4, u / 2 and w u / 8, where u = g w Q/h is the pull of the spring. */
typedef struct {
    vreal v, wv, u, wu;
} sums_s;

/* The torques of one step as the modes need them: they are the same for every mode. */
typedef struct {
    vreal p, e, f;
} inputs_s;

/* A mode comes into registers as one block, and the pointer goes on: one instruction on a Cortex-M with an FPU. */
#if defined(__arm__) && defined(__ARM_FP) && !defined(KELLY_DOUBLE) && KELLY_WIDTH == 1
KELLY_INLINE kelly_slow_mode fetch(kelly_slow_mode **from, vbits *guard)
{
    register real t __asm("s16"), d __asm("s17"), g __asm("s18"), m __asm("s19"), w __asm("s20");
    register real v __asm("s21"), x __asm("s22");

    __asm("vldmia %0!, {s16-s22}" : "+r"(*from), "=t"(t), "=t"(d), "=t"(g), "=t"(m), "=t"(w), "=t"(v), "=t"(x) : "m"(**from));
    vguard(guard, vbits_of(v) ^ vbits_of(x));
    return (kelly_slow_mode){ t, d, g, m, w, v, x };
}
#else
KELLY_INLINE kelly_slow_mode fetch(kelly_slow_mode **from, vbits *guard)
{
    const kelly_slow_mode *const mode = (*from)++;

    return (kelly_slow_mode){ mode->t, mode->d, mode->g, mode->m, mode->w4, vtake(&mode->v, guard), vtake(&mode->x, guard) };
}
#endif

KELLY_INLINE sums_s outputs_s(const kelly_slow_mode *mode)
{
    const vreal v = mode->g * mode->v, u = mode->m * mode->x;

    return (sums_s){ .v = v, .wv = mode->w4 * v, .u = u, .wu = mode->w4 * u };
}

KELLY_INLINE void add_s(sums_s *sum, sums_s one)
{
    sum->v = sum->v + one.v;
    sum->wv = sum->wv + one.wv;
    sum->u = sum->u + one.u;
    sum->wu = sum->wu + one.wu;
}

/* Move the mode that *mode points to, and the pointer on; returns its outputs. */
KELLY_INLINE sums_s next_s(kelly_slow_mode **mode, const inputs_s *in, vbits *guard)
{
    kelly_slow_mode now = fetch(mode, guard);
    const vreal v = now.v, x = now.x;

    now.v = v + ((now.t * v - now.d * (x + in->f)) + in->p);
    now.x = x + ((v + now.v) + in->e);
    vput(&(*mode)[-1].v, now.v, guard);
    vput(&(*mode)[-1].x, now.x, guard);
    return outputs_s(&now);
}

/* Stage speeds of the next step, torque-free: v, v + v'/2, v + v'/2 + v''/4, v + v' + v''/2 + v'''/4. */
KELLY_INLINE void stage_speeds_s(kelly_lane *lane, const sums_s *sum, real al, real be, vbits *guard)
{
    const real half = R(0.5) * al, twice = be + be, mixed = twice + al / R(6.0);
    const vreal q = (sum->u + half * sum->v) + mixed * sum->wv;        /* -v' / 2 */
    const vreal n = (sum->wv - twice * sum->wu) - half * q;            /* -v'' / 4 */
    const vreal third = (sum->wu + al * sum->wv) - n;                  /* v''' / 8 + v'' / 4 */
    const vreal y1 = lane->w0 + sum->v, y2 = y1 - q;

    vput(&lane->y1, y1, guard);
    vput(&lane->y2, y2, guard);
    vput(&lane->y3, y2 - n, guard);
    vput(&lane->y4, (y2 - q) + (third + third), guard);
}

KELLY_INLINE inputs_s inputs_of_s(vreal t1, const stages *at, real al, real be)
{
    const vreal t23 = at->t2 + at->t3, sum = t1 + t23;
    inputs_s in;

    in.p = (R(1.0) - al) * sum + (t23 + at->t4);
    in.e = t1 - at->t4;
    in.f = (t1 + at->t2) + (be + be) * sum;
    return in;
}

/* The modes under the four torques, and the stage speeds of the next step. */
KELLY_INLINE void finish_s(kelly_lane *on, kelly_slow_mode *mode, unsigned modes, const stages *at, real al, real be, vbits *changed)
{
    const inputs_s in = inputs_of_s(vtake(&on->t1, changed), at, al, be);
    const kelly_slow_mode *const end = mode + modes;
    sums_s sum = next_s(&mode, &in, changed);

    while (mode < end) {
        add_s(&sum, next_s(&mode, &in, changed));
    }
    stage_speeds_s(on, &sum, al, be, changed);
}

#endif
