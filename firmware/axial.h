/* axial.h - axial response of the string to the varying weight, eq. (A), the rigid mode included.
 *
 *     (A)  p_j'' + c_j p_j' + w_j^2 p_j = b_j f_a(t),   f_a = f0 (sin(w0 t) + 0.01),   c_j = alpha + beta w_j^2, rigid mode: c = w = 0
 *
 * It does not act on torsion, so a run for the probability leaves it out. The axial bit speed is the paper's "rate of
 * penetration"; at 0.4-0.7 m/s it is a vibration, not a drilling rate.
 */
#ifndef KELLY_AXIAL_H
#define KELLY_AXIAL_H

#include "realisation.h"

typedef struct {
    unsigned count;
    real h;                      /* step [s] */
    real f0;                     /* [N] */
    uint64_t phase_step;         /* of w0 t a tick [turns / 2^64] */
    real w2[KELLY_MODES_MAX], c[KELLY_MODES_MAX], b[KELLY_MODES_MAX];
    real p[KELLY_MODES_MAX];     /* modal displacement relative to u_S [kg^1/2 m] */
    real v[KELLY_MODES_MAX];     /* its speed [kg^1/2 m/s] */
    uint32_t seal;               /* of p and v as the last step left them: seal.h */
    uint8_t touched;             /* a step found others */
} kelly_axial;

/* From u = u_S at zero speed. KELLY_OK, KELLY_RANGE where fc is outside the fit, KELLY_STEP where RK4 would not be stable
 * for the modes asked for (the same two bounds as kelly_realise). */
kelly_status kelly_axial_start(kelly_axial *axial, const kelly_table *table, const kelly_case *run, const kelly_draw *draw);

/* Largest step [s] that kelly_axial_start accepts; 0 where fc is outside the fit. */
real kelly_axial_largest_step(const kelly_table *table, const kelly_case *run, const kelly_draw *draw);

/* One RK4 step from tick `tick` to the next. */
void kelly_axial_step(kelly_axial *axial, uint32_t tick);

/* One RK4 step under these forces f_a [N] of its four stages: for a top whose phase is not w0 t. */
void kelly_axial_push(kelly_axial *axial, const real f[4]);

/* Whether p and v are what the last step left. */
int kelly_axial_untouched(const kelly_axial *axial);

/* A sum over what `seal` covers and over all that does not change as it advances: seal.h. */
uint32_t kelly_axial_seal(uint32_t seal, const kelly_axial *axial);

/* Axial bit speed [m/s]: sum b_j p_j'. */
real kelly_axial_speed(const kelly_axial *axial);

#endif
