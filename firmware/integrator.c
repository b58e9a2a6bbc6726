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

KELLY_INLINE void watch(kelly_lane *on)
{
    on->lowest = vmin(on->y1, on->lowest);
    on->highest = vmax(on->y1, on->highest);
}

/* Advance `vectors` vectors, a compile-time constant, by `ticks` steps, without looking at the exact phase.
 * One torque is a chain of some 60 cycles: stage by stage over all vectors, so that chains stand side by side in the
 * instruction stream and hide each other. */
KELLY_INLINE void steps(kelly_block *block, uint32_t ticks, const unsigned vectors, const int slow)
{
    const unsigned modes = block->modes;
    const real al = block->al, be = block->be;

    for (; ticks > 0; ticks--) {
        stages at[KELLY_VECTORS];

        UNROLL
        for (unsigned v = 0; v < vectors; v++) {
            second_torque(&block->lane[v], &at[v]);
        }
        UNROLL
        for (unsigned v = 0; v < vectors; v++) {
            third_torque(&block->lane[v], &at[v]);
        }
        UNROLL
        for (unsigned v = 0; v < vectors; v++) {
            fourth_torque(&block->lane[v], &at[v]);
        }
        UNROLL
        for (unsigned v = 0; v < vectors; v++) {
            if (slow) {
                finish_s(&block->lane[v], block->slow[v], modes, &at[v], al, be);
            } else {
                finish_m(&block->lane[v], block->mode[v], modes, &at[v], al, be);
            }
            watch(&block->lane[v]);
            first_torque(&block->lane[v]);
        }
    }
}

/* One loop for each number of vectors in use, so that the compiler can keep them all in flight. */
static void advance(kelly_block *block, uint32_t ticks)
{
#define WITH(n) \
    case n: \
        if (ALWAYS_FULL || block->full) { \
            steps(block, ticks, n, 0); \
        } else { \
            steps(block, ticks, n, 1); \
        } \
        break;
    switch (block->vectors) {
    WITH(1)
#if KELLY_VECTORS >= 2
    WITH(2)
#endif
#if KELLY_VECTORS >= 3
    WITH(3)
#endif
#if KELLY_VECTORS >= 4
    WITH(4)
#endif
#if KELLY_VECTORS >= 5
    WITH(5)
#endif
#if KELLY_VECTORS >= 6
    WITH(6)
#endif
#if KELLY_VECTORS >= 7
    WITH(7)
#endif
#if KELLY_VECTORS >= 8
    WITH(8)
#endif
    default:
        break;
    }
#undef WITH
}

/* The weight of a lane from its exact integer phase, and the torque that follows from it. */
void kelly_block_resync(kelly_block *block, unsigned lane)
{
    const uint64_t step = block->phase_step[lane], phase = step * block->tick;
    kelly_lane *const out = &block->lane[lane / KELLY_WIDTH];
    const unsigned l = lane % KELLY_WIDTH;
    const real swing = LANE(out->muf_swing, l), wave = swing * kelly_sin_turn(phase);
    const real muf = LANE(out->muf_mean, l) + wave;

    LANE(out->wave, l) = wave;
    LANE(out->dwave, l) = swing * (2 * kelly_sin_turn(phase + step / 2 + QUARTER_TURN) * kelly_sin_turn(step / 2));
    LANE(out->muf, l) = muf < 0 ? muf : 0;
    first_torque(out);
}

void kelly_block_advance(kelly_block *block, uint32_t ticks)
{
    while (ticks > 0) {
        const uint32_t since = block->tick % KELLY_RESYNC;
        const uint32_t part = ticks < KELLY_RESYNC - since ? ticks : KELLY_RESYNC - since;

        if (since == 0) {
            for (unsigned lane = 0; lane < block->vectors * KELLY_WIDTH; lane++) {
                kelly_block_resync(block, lane);
            }
        }
        advance(block, part);
        block->tick += part;
        ticks -= part;
    }
}
