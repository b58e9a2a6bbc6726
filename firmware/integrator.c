#include "form_m.h"
#include "form_s.h"

#define QUARTER_TURN ((uint64_t)1 << 62)
#define ALWAYS_FULL (sizeof(real) > sizeof(float))

#if defined(__clang__)
#define UNROLL _Pragma("unroll")
#elif defined(__GNUC__)
#define UNROLL _Pragma("GCC unroll 16")
#else
#define UNROLL
#endif

/* Everything of a step that follows the fourth torque of a vector, its first torque of the next step included. */
KELLY_INLINE void finish(kelly_block *block, unsigned v, kelly_lane *on, const stages *at, real al, real be, const int slow)
{
    vbits changed = { 0 };
    vreal lowest, highest;

    (void)vtake(&on->y1, &changed);
    (void)vtake(&on->y2, &changed);
    (void)vtake(&on->y3, &changed);
    (void)vtake(&on->y4, &changed);
    if (slow) {
        finish_s(on, block->slow[v], block->modes, at, al, be, &changed);
    } else {
        finish_m(on, block->mode[v], block->modes, at, al, be, &changed);
    }
    lowest = vtake(&on->lowest, &changed);
    highest = vtake(&on->highest, &changed);
    vput(&on->lowest, vmin(on->y1, lowest), &changed);
    vput(&on->highest, vmax(on->y1, highest), &changed);
    vput(&on->t1, first_torque(on), &changed);
    vguard(&on->guard, changed);
}

/* The second, third or fourth torque of a vector. */
KELLY_INLINE void torque(kelly_lane *on, stages *at, const unsigned stage)
{
    if (stage == 2) {
        second_torque(on, at);
    } else if (stage == 3) {
        third_torque(on, at);
    } else {
        fourth_torque(on, at);
    }
}

/* Advance a few vectors, a compile-time constant, by `ticks` steps, without looking at the exact phase: stage by stage. */
KELLY_INLINE void side_by_side(kelly_block *block, uint32_t ticks, const unsigned vectors, const int slow)
{
    const real al = block->al, be = block->be;      /* a write to a lane could be one to a real of the block, for all a compiler knows */
    stages at[KELLY_VECTORS];

    for (; ticks > 0; ticks--) {
        UNROLL
        for (unsigned stage = 2; stage <= 4; stage++) {
            UNROLL
            for (unsigned v = 0; v < vectors; v++) {
                torque(&block->lane[v], &at[v], stage);
            }
        }
        UNROLL
        for (unsigned v = 0; v < vectors; v++) {
            finish(block, v, &block->lane[v], &at[v], al, be, slow);
        }
    }
}

/* The same for four and more. One torque is a chain of some 60 cycles and needs the one before it, so the vectors are at different
 * stages: while one is finished, the next three are one, two and three torques behind, and no chain waits for another. */
KELLY_INLINE void in_turns(kelly_block *block, uint32_t ticks, const unsigned vectors, const int slow)
{
    const real al = block->al, be = block->be;
    stages at[KELLY_VECTORS];

    UNROLL
    for (unsigned stage = 2; stage <= 4; stage++) {
        UNROLL
        for (unsigned v = 0; v + stage <= 4; v++) {
            torque(&block->lane[v % vectors], &at[v % vectors], stage);
        }
    }
    for (; ticks > 0; ticks--) {
        UNROLL
        for (unsigned v = 0; v < vectors; v++) {
            finish(block, v, &block->lane[v], &at[v], al, be, slow);
            UNROLL
            for (unsigned lag = 1; lag <= 3; lag++) {
                if (v + lag < vectors || ticks > 1) {      /* the last step starts no other */
                    torque(&block->lane[(v + lag) % vectors], &at[(v + lag) % vectors], 5 - lag);
                }
            }
        }
    }
}

/* One loop for each number of vectors in use, so that the compiler can keep them all in flight. */
static void advance(kelly_block *block, uint32_t ticks)
{
#define STEPS(n) ((n) < 4 ? side_by_side : in_turns)
#define WITH(n) \
    case n: \
        if (ALWAYS_FULL || block->full) { \
            STEPS(n)(block, ticks, n, 0); \
        } else { \
            STEPS(n)(block, ticks, n, 1); \
        } \
        break;
    switch (block->vectors) {
    KELLY_EACH_COUNT(WITH)
    default:
        break;
    }
#undef WITH
#undef STEPS
}

/* The weight of a lane from its exact integer phase, and the torque that follows from it. */
void kelly_block_resync(kelly_block *block, unsigned lane)
{
    const uint64_t step = block->phase_step[lane], phase = step * block->tick;
    kelly_lane *const out = &block->lane[lane / KELLY_WIDTH];
    const unsigned l = lane % KELLY_WIDTH;
    const real swing = LANE(out->muf_swing, l), wave = swing * kelly_sin_turn(phase);
    const real muf = LANE(out->muf_mean, l) + wave;

    vput_lane(&out->wave, l, wave, &out->guard);
    vput_lane(&out->dwave, l, swing * (2 * kelly_sin_turn(phase + step / 2 + QUARTER_TURN) * kelly_sin_turn(step / 2)), &out->guard);
    vput_lane(&out->muf, l, muf < 0 ? muf : 0, &out->guard);
    const vreal t1 = first_torque(out);

    vput_lane(&out->t1, l, LANE(t1, l), &out->guard);    /* this lane's only: what has become of another's is not to be mended unseen */
}

void kelly_block_advance(kelly_block *block, uint32_t ticks)
{
    while (ticks > 0 && block->vectors <= KELLY_VECTORS && block->modes <= KELLY_MODES_MAX) {
        const uint32_t since = block->tick % KELLY_RESYNC;
        const uint32_t part = ticks < KELLY_RESYNC - since ? ticks : KELLY_RESYNC - since;

        if (since == 0) {
            for (unsigned lane = 0; lane < block->vectors * KELLY_WIDTH; lane++) {
                block->strayed[lane] |= (uint8_t)(block->tick > 0 && kelly_block_strays(block, lane));
                kelly_block_resync(block, lane);
            }
        }
        advance(block, part);
        block->tick += part;
        ticks -= part;
    }
}
