/* kernel.h - a checked case, a checked draw and its modes, in slices of the step: what kelly_realise lets pass. */
#ifndef KELLY_EVA_KERNEL_H
#define KELLY_EVA_KERNEL_H

#include "integrator.h"

/* Assumed of checked realisations, which turn by 2.8 rad a step at most: 2.8 / 2 pi turns and what is cut. tests/test_detmath.c compares. */
/*@ assigns \result \from w, step_ns;
    ensures \result <= 0x7300000000000000; */
uint64_t kelly_phase_step(real w, uint32_t step_ns);

/* step.c has it, for the weights of the torque that this would need slices for. */
/*@ requires \valid(block);
    assigns block->lane[0].wave, block->lane[0].dwave, block->lane[0].muf, block->lane[0].t1, block->lane[0].guard \from block->tick, block->phase_step[0];
    ensures \is_finite(block->lane[0].wave) && -2e12 <= block->lane[0].wave <= 2e12;
    ensures \is_finite(block->lane[0].dwave) && -4e12 <= block->lane[0].dwave <= 4e12;
    ensures \is_finite(block->lane[0].muf) && \is_finite(block->lane[0].t1); */
void kelly_block_resync(kelly_block *block, unsigned lane);

#ifndef MODES
#define MODES 20                         /* all of the committed table */
#endif

static kelly_case run;
static kelly_draw draw;
static kelly_modes modes;

/* Steps of low .. 8 low ns. The top turns by KELLY_TURN or, stiff, by 2.8 rad at most. */
static void any_checked(uint32_t low, int soft)
{
    const real most = (soft ? KELLY_TURN : KELLY_IMAGINARY_AXIS) * R(1e9) / (real)low;

    run.f0 = any_real(0, R(1e9));
    run.step_ns = Frama_C_unsigned_int_interval(low, low < 125000000 ? 8 * low : 1000000000);
    run.ticks = Frama_C_unsigned_int_interval(1, UINT32_MAX);
    run.window_first = Frama_C_unsigned_int_interval(0, UINT32_MAX - 1);
    run.window_last = Frama_C_unsigned_int_interval(1, UINT32_MAX);
    run.limit = any_real(0, R(10.0));
    run.torsional = Frama_C_unsigned_char_interval(1, MODES);
    run.axial = Frama_C_unsigned_char_interval(1, 11);
    run.rotating = Frama_C_unsigned_char_interval(0, 1);
    run.drive.inertia = soft ? any_real(R(1.0), R(1e12)) : 0;
    run.drive.impedance = any_real(0, R(1e12));
    run.drive.hz = any_real(0, R(1e3));
    draw.fc = any_real(R(1e3), R(1e6));
    draw.mu = any_real(0, R(1800.0));
    draw.a1 = any_real(0, R(1000.0));
    draw.a2 = any_real(R(1e-4), R(1.8e7));
    draw.w0 = any_real(0, most < R(1e4) ? most : R(1e4));
}

#endif
