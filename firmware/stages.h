/* stages.h - the four stage torques of one RK4 step: what both forms of the modes share. */
#ifndef KELLY_STAGES_H
#define KELLY_STAGES_H

#include "bitrock.h"
#include "integrator.h"

/* The stage torques of a step; the second and third at half of it, under the weight `half`. */
typedef struct {
    vreal half, t2, t3, t4;
} stages;

/* A lane's share of the guard: of what follows the phase of the top, and of what the modes leave. It goes out between the last use of
 * a number and the write of the next one: what has changed since it was written is in the guard for good. */
KELLY_INLINE vbits weighed(const kelly_lane *on)
{
    return vbits_of(on->wave) ^ vbits_of(on->dwave) ^ vbits_of(on->muf);
}

KELLY_INLINE vbits moved(const kelly_lane *on)
{
    return vbits_of(on->t1) ^ vbits_of(on->y1) ^ vbits_of(on->y2) ^ vbits_of(on->y3) ^ vbits_of(on->y4) ^ vbits_of(on->lowest) ^
           vbits_of(on->highest);
}

/* Torque at the present tick: the first stage of the step to come. */
KELLY_INLINE void first_torque(kelly_lane *on)
{
    on->t1 = kelly_bit_torque_folded(on->y1, on->muf, on->ratio, on->inverse);
}

#if KELLY_ON_COPY
KELLY_INLINE void take(kelly_lane *now, const kelly_lane *from)
{
    *now = *from;
    now->wave = vread(&from->wave);
    now->dwave = vread(&from->dwave);
    now->muf = vread(&from->muf);
    now->t1 = vread(&from->t1);
    now->y1 = vread(&from->y1);
    now->y2 = vread(&from->y2);
    now->y3 = vread(&from->y3);
    now->y4 = vread(&from->y4);
    now->lowest = vread(&from->lowest);
    now->highest = vread(&from->highest);
}

KELLY_INLINE void put_back(kelly_lane *to, const kelly_lane *now)
{
    vwrite(&to->wave, now->wave);
    vwrite(&to->dwave, now->dwave);
    vwrite(&to->muf, now->muf);
    vwrite(&to->t1, now->t1);
    vwrite(&to->y1, now->y1);
    vwrite(&to->y2, now->y2);
    vwrite(&to->y3, now->y3);
    vwrite(&to->y4, now->y4);
    vwrite(&to->lowest, now->lowest);
    vwrite(&to->highest, now->highest);
    to->guard = now->guard;
}
#endif

/* Second stage, at half a step; takes the weight to the next tick. */
KELLY_INLINE void second_torque(kelly_lane *on, stages *at)
{
    const vreal wave = on->wave + on->dwave;
    const vbits was = weighed(on);

    at->half = vmin(on->muf_mean + (on->wave + wave) * on->wave_half, vsplat(0));
    on->muf = vmin(on->muf_mean + wave, vsplat(0));
    on->dwave = on->dwave - on->wave_k * wave;
    on->wave = wave;
    vguard(&on->guard, was, weighed(on));
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
