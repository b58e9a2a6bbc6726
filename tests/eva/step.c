/* One step of the modes from every state whose speeds and modes are within bounds, in both forms, and every reading of it.
 *
 * A run is 100 000 such steps; that no step leaves the bounds is the stability of RK4, which kelly_realise checks before and
 * kelly_block_sane after a run: intervals cannot see it. */
#include "integrator.h"
#include "contracts.h"
#include "torque.h"

#define SPEED 1e7f                       /* [rad/s] of the stages, torque-free */
#define MOST (2 * SPEED / KELLY_MODES_MAX)   /* [rad/s] what one mode has in it: its state times its weight */

void kelly_block_resync(kelly_block *block, unsigned lane);

static kelly_block block;
static kelly_modes modes;

/* |2 mu f| is at most F = m / 13.42, so that m bounds what intervals make of the weight between two ticks. The lever of a torque is
 * h/2 (sum of b^2), and F > m / 26.84: h 2 mu f (sum of b^2) <= 2 2.785 (kelly_realise) leaves a lever of less than 76 / m. Slices of m go by
 * powers of 2. Of the lightest, h (sum of b^2) <= 2. */
static real lever_of(real m)
{
    return R(76.0) / m < R(1.0) ? R(76.0) / m : R(1.0);
}

static void any_lane(kelly_lane *on, real m, real a)
{
    const real lever = lever_of(m), f = m / R(13.42);

    on->w0 = any_real(0, R(1e4));
    on->ratio = any_real(0, LARGEST_A1 / (2 * a));
    on->inverse = any_real(1 / (20 * a), R(1.0001) / a);
    on->muf_mean = any_real(-f, f);
    on->muf_swing = any_real(0, f);
    on->wave_k = any_real(0, R(4.0001));
    on->wave_half = any_real(0, R(3.0));
    on->wave = any_real(-f, f);
    on->dwave = any_real(-2 * f, 2 * f);
    on->muf = any_real(-f, 0);
    on->t1 = any_real(-m * R(1e6), m * R(1e6));
    on->g1 = any_real(0, lever);
    on->twice_g1 = any_real(0, 2 * lever);
    on->g2 = any_real(-lever * R(1.4), 0);
    on->twice_g2 = any_real(-lever * R(2.8), 0);
    on->g3 = any_real(-lever * R(4.0), lever * R(4.0));
    on->y1 = any_real(-SPEED, SPEED);
    on->y2 = any_real(-SPEED, SPEED);
    on->y3 = any_real(-SPEED, SPEED);
    on->y4 = any_real(-SPEED, SPEED);
    on->lowest = any_real(-SPEED, SPEED);
    on->highest = any_real(-SPEED, SPEED);
}

/* `weight` is what a unit of torque adds to the speed through one mode in a step, at most: a third of the lever. */
static void any_mode(kelly_mode *mode, real weight)
{
    mode->w4 = any_real(0, R(1.96));
    mode->d00 = any_real(R(-2.0), R(2.0));
    mode->d01 = any_real(R(-8.0), R(8.0));
    mode->d10 = any_real(R(-2.0), R(2.0));
    mode->d11 = any_real(R(-2.0), R(2.0));
    mode->m0 = mode->m1 = mode->m2 = mode->m3 = any_real(-weight, weight);
    mode->xi = any_real(-MOST / weight, MOST / weight);
    mode->zeta = any_real(-MOST / weight, MOST / weight);
}

static void any_slow(kelly_slow_mode *mode, real weight)
{
    mode->t = any_real(R(-0.3), R(0.3));
    mode->d = any_real(0, R(0.01));
    mode->g = any_real(0, weight);
    mode->m = any_real(0, R(0.01) * weight);
    mode->w4 = any_real(0, R(0.001));
    mode->v = any_real(-MOST / weight, MOST / weight);
    mode->x = any_real(-MOST / weight, MOST / weight);
}

static void any_block(unsigned full, real m, real a)
{
    block.h = any_real(R(1e-6), R(1.0));
    block.al = any_real(0, full ? R(0.1) : R(3.2e-4));
    block.be = any_real(0, R(0.5));
    block.vectors = KELLY_VECTORS;
    block.full = full;
    for (unsigned v = 0; v < KELLY_VECTORS; v++) {
        block.phase_step[v] = Frama_C_unsigned_long_long_interval(0, 0x7300000000000000);
        any_lane(&block.lane[v], m, a);
        for (unsigned i = 0; i < KELLY_MODES_MAX; i++) {
            if (full) {
                any_mode(&block.mode[v][i], lever_of(m) / 3);
            } else {
                any_slow(&block.slow[v][i], lever_of(m) / 3);
            }
        }
    }
    for (unsigned i = 0; i < KELLY_MODES_MAX; i++) {
        modes.w2[i] = any_real(R(1e-3), full ? R(1e8) : R(0.0035));
        modes.b[i] = any_real(R(1e-4), R(1.0));
        modes.d[i] = any_real(R(-1e4), R(1e4));
    }
    block.modes = modes.count = Frama_C_unsigned_int_interval(1, KELLY_MODES_MAX);
}

/* From a tick of the exact phase, and from one between two. */
static void step(unsigned full, real m, real a)
{
    any_block(full, m, a);
    block.tick = Frama_C_unsigned_int_interval(1, KELLY_RESYNC - 2);
    kelly_block_advance(&block, 1);
}

static void at_exact_phase(void)
{
    any_block(1, (real)LARGEST_M, R(1.0));
    block.tick = KELLY_RESYNC * Frama_C_unsigned_int_interval(0, UINT32_MAX / KELLY_RESYNC);
    kelly_block_advance(&block, 1);
    any_block(1, (real)LARGEST_M, R(1.0));
    kelly_block_resync(&block, 0);
    //@ assert \is_finite(block.lane[0].wave) && -2e12 <= block.lane[0].wave <= 2e12;
    //@ assert \is_finite(block.lane[0].dwave) && -4e12 <= block.lane[0].dwave <= 4e12;
    //@ assert \is_finite(block.lane[0].muf) && \is_finite(block.lane[0].t1);
}

/* From rest, where intervals stay as they are: what a step hands to the next is where it belongs. */
static void steps_from_rest(unsigned full)
{
    block = (kelly_block){ .h = R(1e-3), .modes = KELLY_MODES_MAX, .vectors = KELLY_VECTORS, .full = full };
    for (unsigned v = 0; v < KELLY_VECTORS; v++) {
        block.lane[v].inverse = R(1.0);
    }
    block.tick = 1;
    kelly_block_advance(&block, 3);
}

int main(void)
{
    real a = R(1e-4);

    //@ loop unroll 9;
    for (unsigned j = 0; j < SLICES_A; j++) {
        step(1, (real)LEAST_M, a);
        step(1, (real)LARGEST_M, a);
        if (sizeof(real) == sizeof(float)) {
            step(0, (real)LEAST_M, a);
            step(0, (real)LARGEST_M, a);
        }
        a *= 20;
    }
    at_exact_phase();
    steps_from_rest(1);
    steps_from_rest(sizeof(real) > sizeof(float));
    return 0;
}
