/* One step under a soft drive or a commanded top, from every state of moderate size. The sizes belong together as kelly_realise has them:
 * a step turns the top by KELLY_TURN or so, and what a torque, the drive or a mode does to a speed in a step is of the size of the speeds. */
#include "drive.h"
#include "contracts.h"
#include "torque.h"

static kelly_driven driven;

static void any_output(kelly_output *o, real size, real of_t, real of_u)
{
    for (unsigned k = 0; k < 4; k++) {
        o->at[k] = any_real(-size, size);
    }
    for (unsigned k = 0; k < 3; k++) {
        o->of_t[k] = any_real(-of_t, of_t);
        o->of_u[k] = any_real(-of_u, of_u);
    }
}

/* h: the step; m: the largest mu |f|; t: the largest torque. */
static void any_driven(real h, real m)
{
    const real t = R(2.6e5) * m, speed = R(0.25) / h < R(1e4) ? R(0.25) / h : R(1e4), slope = speed / (16 * h);
    kelly_driven_lane *const on = &driven.lane[0];

    driven.h = any_real(h, 2 * h);
    driven.alpha = any_real(0, R(1.0));
    driven.be = any_real(0, R(0.5));
    driven.modes = Frama_C_unsigned_int_interval(1, KELLY_MODES_MAX);
    driven.vectors = 1;
    driven.step_ns = any_u32();
    driven.phase[0] = any_u64();
    driven.phase_step[0] = any_u64();
    on->w_ref = any_real(0, speed);
    on->a1 = any_real(0, LARGEST_A1);
    on->a2 = any_real(R(1e-4), R(1.8e7));
    on->muf_mean = any_real(-m / 64, m / 64);
    on->muf_swing = any_real(0, m / 64);
    on->rest = any_real(R(-1.0), R(1.0));
    on->drag = any_real(0, t);
    on->k_speed = any_real(0, t / speed);
    on->k_angle = any_real(0, t / R(1e3));
    on->gain = Frama_C_nondet(0, 1) ? 0 : any_real(slope / t * R(1e-6), slope / t);
    on->slope = any_real(-slope, slope);
    on->counted = any_real(-speed, speed);
    on->eta = any_real(-speed, speed);
    on->phi = any_real(R(-1e3), R(1e3));
    on->sine = any_real(R(-1.01), R(1.01));
    on->cosine = any_real(R(-1.01), R(1.01));
    on->lowest = on->highest = on->speed = any_real(R(-1e6), R(1e6));
    any_output(&on->y, speed, speed / t, h);
    any_output(&on->p, t, R(1.0), t / slope);
    for (unsigned i = 0; i < KELLY_MODES_MAX; i++) {
        kelly_driven_mode *const mode = &driven.mode[0][i];

        mode->w = any_real(0, R(8.0));
        mode->c = any_real(0, R(3.0));
        mode->g = any_real(0, speed / (h * t));
        mode->k = any_real(0, R(1.0) / h);
        mode->r = any_real(-t / slope, t / slope);
        mode->d00 = any_real(R(-8.0), R(8.0));
        mode->d01 = any_real(R(-8.0), R(8.0));
        mode->d10 = any_real(R(-8.0), R(8.0));
        mode->d11 = any_real(R(-8.0), R(8.0));
        mode->v = any_real(-h * t, h * t);
        mode->x = any_real(-h * t, h * t);
    }
}

static void step(real h, real m)
{
    any_driven(h, m);
    driven.tick = Frama_C_unsigned_int_interval(1, KELLY_RESYNC - 2);
    kelly_driven_advance(&driven, 1);
    any_driven(h, m);
    driven.tick = KELLY_RESYNC * Frama_C_unsigned_int_interval(0, UINT32_MAX / KELLY_RESYNC);
    kelly_driven_advance(&driven, 1);
}

int main(void)
{
    real h = R(1e-6);

    //@ loop unroll 20;
    for (unsigned k = 0; k < 20; k++) {                        /* 1 us .. 1.05 s, each to twice as long */
        step(h, (real)LEAST_M);
        step(h, (real)LARGEST_M);
        h *= 2;
    }
    return 0;
}
