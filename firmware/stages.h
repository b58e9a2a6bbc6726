/* stages.h - the four stage torques of one RK4 step: what both forms of the modes share. */
#ifndef KELLY_STAGES_H
#define KELLY_STAGES_H

#include "bitrock.h"
#include "integrator.h"

/* The stage torques of a step; the second and third at half of it, under the weight `half`. */
typedef struct {
    vreal half, t2, t3, t4;
} stages;

/* A lane's share of the guard: of what follows the phase of the top, and of what the modes leave. */
KELLY_SHORT vbits weighed(const kelly_lane *on)
{
    return vbits_of(on->wave) ^ vbits_of(on->dwave) ^ vbits_of(on->muf);
}

KELLY_SHORT vbits moved(const kelly_lane *on)
{
    return vbits_of(on->t1) ^ vbits_of(on->y1) ^ vbits_of(on->y2) ^ vbits_of(on->y3) ^ vbits_of(on->y4) ^ vbits_of(on->lowest) ^
           vbits_of(on->highest);
}

/* Torque at the present tick: the first stage of the step to come. */
KELLY_INLINE vreal first_torque(const kelly_lane *on)
{
    return kelly_bit_torque_folded(on->y1, on->muf, on->ratio, on->inverse);
}

/* Second stage, at half a step; takes the weight to the next tick. */
KELLY_INLINE void second_torque(kelly_lane *on, stages *at)
{
    vbits changed = { 0 };
    const vreal was = vtake(&on->wave, &changed), dwave = vtake(&on->dwave, &changed), wave = was + dwave;

    (void)vtake(&on->muf, &changed);
    at->half = vmin(on->muf_mean + (was + wave) * on->wave_half, vsplat(0));
    vput(&on->muf, vmin(on->muf_mean + wave, vsplat(0)), &changed);
    vput(&on->dwave, dwave - on->wave_k * wave, &changed);
    vput(&on->wave, wave, &changed);
    vguard(&on->guard, changed);
    at->t2 = kelly_bit_torque_folded(on->y2 + on->g1 * on->t1, at->half, on->ratio, on->inverse);
}

KELLY_INLINE void third_torque(const kelly_lane *on, stages *at)
{
    at->t3 = kelly_bit_torque_folded((on->y3 + on->g2 * on->t1) + on->g1 * at->t2, at->half, on->ratio, on->inverse);
}

KELLY_INLINE void fourth_torque(const kelly_lane *on, stages *at)
{
    const vreal y = (on->y4 + on->g3 * on->t1) + on->twice_g2 * at->t2;

    at->t4 = kelly_bit_torque_folded(y + on->twice_g1 * at->t3, on->muf, on->ratio, on->inverse);
}

/* The weight of a lane from its exact integer phase, and the torque that follows from it. */
void kelly_block_resync(kelly_block *block, unsigned lane);

/* Whether it is further from there than rounding leads. */
int kelly_block_strays(const kelly_block *block, unsigned lane);

#endif
