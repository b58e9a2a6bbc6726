/* integrator.h - classical RK4 of eq. (T), (W), (B), (F), for KELLY_LANES realisations at once, each with its own modes.
 *
 *     (T)  q_i'' + (alpha + beta w_i^2) q_i' + w_i^2 q_i = b_i T_bit - d_i alpha w0
 *     (W)  w_bit = w0 + sum b_i q_i'
 *     (F)  f_bit = -fc + f0 (sin(w0 t) + 0.01)
 *
 * The modes are linear and only the scalar torque is not, so one RK4 step is an affine map of the modes and of the four
 * stage torques T1..T4, exactly; it is carried out as such, in one of two bases.
 *
 *   Time unit h: w = h^2 w_i^2, al = alpha h, be = beta / h, c = al + be w, g = b_i^2.
 *   Modal scaling q_i = b_i Q: every mode is driven by T itself and weighs g in the bit speed.
 *   Drag shift: Q is measured from the drag equilibrium -alpha d_i w0 / (b_i w_i^2), where the constant term vanishes.
 *
 * Form M, exact for every mode: 30 operations a mode. Always in double.
 *   Basis xi = Q' + c Q/h, zeta = Q/h - be xi. Then x' = A x + (1, -be) T with A = [[-w be, -w], [1 - al be, -al]]
 *   and b, Ab, A^2 b, A^3 b = (1, -be), (0, 1), (-w, -al), (w^2 be + al w, al^2 - (1 - al be) w): polynomials in w whose
 *   scalars are common to all modes. xi and zeta are stored times 6/h.
 *   Increments: D = A + A^2/2 + A^3/6 + A^4/24 is stored, never I + D, which would lose all digits of (w_1 h)^2 = 5e-6 in float.
 *   Outputs X = g (v + be v'), Z = g v' of each mode give all four stage speeds from five sums over the modes.
 *
 * Form S, for slow modes in float: 17 operations a mode.
 *   In (Q', Q/h) A = [[-c, -w], [1, 0]], and by A^2 = -c A - w I the increments are D = p A + r w I and the input is b P + A b R, with
 *   p = 1 - c/2 + (c^2 - w)/6 + (2 c w - c^3)/24, r = -1/2 + c/6 - (c^2 - w)/24, and P, R polynomials in w. Let w e = det D.
 *   There is one x = s Q/h + (1/2 + k) Q', s = p/e, k = r/e, for which D's second row is that of the trapezoidal rule:
 *       V <- V + t V - d (X + f) + p_in,   X <- X + (V + V') + e_in,   V = 6 Q'/h, X = 12 x/h, t = w (2 r + e/2) - c p, d = w e / 2.
 *   To first order in w and al the inputs come out the same for every mode:
 *       p_in = T1 + 2 (T2 + T3) + T4 - al (T1 + T2 + T3),   e_in = T1 - T4,   f = T1 + T2 + 2 be (T1 + T2 + T3).
 *   V and the spring's w Q/h = w x/s + (c w/12) Q' give the stage speeds from four sums: over g V, m X and w times either.
 *   What is left out lies below half an ulp of what it would be added to where block.c says that the modes are slow.
 *
 * Stability of RK4 on the negative real axis needs h lambda <= 2.785, on the imaginary one h w <= 2.8: checked for each
 * realisation before it starts.
 *
 * Memory  sizeof(kelly_block), the caller's; for one float lane 1.1 KB. No other state anywhere.
 * Time    about 300 operations and 4 divisions a step and lane with 10 modes (double: 470).
 * Bits    do not depend on lanes, vectors, or on how a run is cut into calls of kelly_block_advance.
 */
#ifndef KELLY_INTEGRATOR_H
#define KELLY_INTEGRATOR_H

#include "isa.h"
#include "lanes.h"
#include "realisation.h"

#define KELLY_RESYNC 2048u       /* ticks between two exact evaluations of sin(w0 t) */
#define KELLY_STRAY R(0.001)     /* more than the recurrence may be off by then (5e-6 at 1 ms, 3e-4 at a quarter turn a step): a fault */

/* Coefficients and state of one mode in form M. */
typedef struct {
    vreal w4;                    /* w / 4 */
    vreal d00, d01, d10, d11;
    vreal m0, m1, m2, m3;
    vreal xi, zeta;
} kelly_mode;

/* The same in form S; loaded in this order. */
typedef struct {
    vreal t, d;                  /* of the move */
    vreal g, m, w4;              /* outputs: g h/6, that of the spring, w / 4 */
    vreal v, x;
} kelly_slow_mode;

/* What one vector of lanes needs beside its modes. */
typedef struct {
    vreal w0;
    vreal ratio, inverse;        /* a1 / (2 a2), 1 / a2 */
    vreal muf_mean, muf_swing;   /* 2 mu f = min(muf_mean + muf_swing sin, 0): doubled for kelly_bit_torque_folded */
    vreal wave_k, wave_half;     /* 4 sin^2(w0 h/2), 1 / (2 cos(w0 h/2)) */
    vreal g1, g2, g3;            /* torque to stage speed: (h/2) sum g, -(h/4) sum g c, (h/4) sum g (c^2 - w) */
    vreal twice_g1, twice_g2;
    vreal wave, dwave;           /* muf_swing sin(w0 t_n) and its step to t_n+1 */
    vreal muf;                   /* 2 mu f at t_n */
    vreal t1;                    /* bit torque at t_n */
    vreal y1, y2, y3, y4;        /* stage speeds of the next step without its own torques; y1 is the bit speed now */
    vreal lowest, highest;       /* of the bit speed since the last kelly_block_watch */
    vbits guard;                 /* of the state, from wave on and of the modes: seal.h */
} kelly_lane;

typedef struct {
    kelly_lane lane[KELLY_VECTORS];
    union {
        kelly_mode mode[KELLY_VECTORS][KELLY_MODES_MAX];        /* form M, */
        kelly_slow_mode slow[KELLY_VECTORS][KELLY_MODES_MAX];   /* or form S */
    };
    uint64_t phase_step[KELLY_LANES];   /* of w0 t a tick [turns / 2^64] */
    real h, al, be;
    unsigned modes;              /* in use */
    unsigned vectors;            /* in use */
    unsigned full;               /* nonzero: form M; always in double */
    uint32_t tick;
    uint8_t strayed[KELLY_LANES];       /* the weight of this lane was not where its phase is: 1 */
} kelly_block;

/* Prepare a block for `lanes` realisations (1..KELLY_LANES) of this case at tick 0. Every lane idles until it is loaded. */
void kelly_block_clear(kelly_block *block, const kelly_table *table, const kelly_case *run, unsigned lanes);

/* Put one checked realisation into lane `lane`, at tick 0. */
void kelly_block_load(kelly_block *block, unsigned lane, const kelly_case *run,
                      const kelly_draw *draw, const kelly_modes *modes);

/* Advance all lanes by `ticks` steps; none where a fault has changed the counts to what would lead out of the struct. */
void kelly_block_advance(kelly_block *block, uint32_t ticks);

/* Forget the extremes seen so far; the present tick is the first one watched. */
void kelly_block_watch(kelly_block *block);

/* Bit speed [rad/s] of a lane now, and the extremes since kelly_block_watch, both ends included. */
real kelly_block_speed(const kelly_block *block, unsigned lane);
void kelly_block_extremes(const kelly_block *block, unsigned lane, real *lowest, real *highest);

/* Modal displacements q_i [kg^1/2 m] and speeds of a lane, relative to the top's rotation (not to the drag equilibrium). */
void kelly_block_modal(const kelly_block *block, unsigned lane, const kelly_modes *modes, const kelly_table *table,
                       real q[KELLY_MODES_MAX], real v[KELLY_MODES_MAX]);

/* Twist of the bit against the drag equilibrium [rad]: sum b_i (q_i - q_i,drag). The mean bit speed between two ticks is w0 plus its
 * difference over the time, exactly: no sum over the steps is needed. */
real kelly_block_twist(const kelly_block *block, unsigned lane, const kelly_modes *modes);

/* Whether every state of the lane is a finite number of sane size, and the weight has kept to its phase. */
int kelly_block_sane(const kelly_block *block, unsigned lane);

/* A sum over everything in the vectors in use that does not change as they advance: see seal.h. */
uint32_t kelly_block_seal(const kelly_block *block);

/* Whether the state of every lane is, bit by bit, what the last step left: seal.h. Always, where KELLY_GUARD is 0. */
int kelly_block_untouched(const kelly_block *block);

/* sin(w0 t) of a lane now. */
real kelly_block_sine(const kelly_block *block, unsigned lane);

#endif
