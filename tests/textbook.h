/* textbook.h - classical RK4 of (T), (W), (B), (F) as a textbook writes it, in `wide`: the reference of form M.
 *
 * Takes the modes of a realisation as the kernel has them, so that nothing but the integration is compared; its tanh
 * comes from the exponential and is exact to the last digits of `wide`. One step costs what four evaluations cost.
 */
#ifndef KELLY_TEXTBOOK_H
#define KELLY_TEXTBOOK_H

#include "../firmware/realisation.h"

/* q_i and q_i' [kg^1/2 m, 1/s], or their derivatives. */
typedef struct {
    wide q[KELLY_MODES_MAX], v[KELLY_MODES_MAX];
} textbook_state;

typedef struct {
    unsigned count;
    wide h, alpha, beta;
    wide fc, f0, mu, a1, a2, w0;
    uint64_t phase_step;          /* of w0 t a step [turns / 2^64] */
    uint32_t tick;
    const kelly_modes *modes;
    textbook_state now, slope, trial, sum;   /* all but `now` are of one step only */
} textbook;

/* (B): torque on the bit [N m] at w [rad/s] under f [N]; f > 0 counts as 0. */
wide textbook_torque(wide w, wide f, wide mu, wide a1, wide a2);

/* Start at tick 0; `modes` are kept by address. */
void textbook_start(textbook *book, const kelly_table *table, const kelly_case *run, const kelly_draw *draw, const kelly_modes *modes);

void textbook_step(textbook *book);

/* (W): bit speed [rad/s] now. */
wide textbook_speed(const textbook *book);

wide textbook_tanh(wide w);
wide textbook_sqrt(wide x);

/* sin and cos of an angle [rad], |angle| < 1e5. */
wide textbook_sin(wide angle);
wide textbook_cos(wide angle);

#endif
