/* drive.h - classical RK4 of eq. (T), (W), (B), (F) with a top whose speed varies: a soft drive, or a commanded speed.
 *
 * eta = theta_top' - w_ref is the top's own speed, w_ref that of the draw, u = eta' + alpha eta, phi' = eta (soft drive).
 *
 *     (T)  q_i'' + (alpha + beta w_i^2) q_i' + w_i^2 q_i = b_i T_bit - d_i u        q_i from the drag equilibrium at w_ref
 *     (W)  w_bit = w_ref + eta + sum b_i q_i'
 *     (F)  f_bit = -fc + f0 (sin(theta_top) + 0.01)
 *     (S)  T_top = J alpha w_ref + Jm u - (1 - sum d_i b_i) T_bit - p,   p = sum d_i w_i^2 (q_i + beta q_i'),   Jm = J - sum d_i^2
 *     (D)  J_d eta' = -k_p eta - k_i phi - T_top,   k_p = 4 Z,  k_i = (2 pi f)^2 J_d        the integral of the speed's error is -phi
 *
 * (S) is momentum with (T) put in for q_i''. With (D) it gives eta' at every stage,
 *
 *     (J_d + Jm) eta' = p + (1 - sum d_i b_i) T_bit - J alpha w_ref - (k_p + Jm alpha) eta - k_i phi
 *
 * and a commanded top has eta' = slope instead: one formula, eta' = slope + gain (...), serves both. Jm is what the modes
 * in use leave of the string's inertia: 3.2 kg m2 with the paper's ten.
 *
 * The modes are linear in their two inputs T and u, so that one RK4 step is an affine map, as in integrator.h:
 *
 *   Time unit h: w = h^2 w_i^2, c = h (alpha + beta w_i^2), be = beta / h.  Modal scaling q_i = b_i Q, r = d_i / b_i.
 *   State v = Q', x = Q / h:   (v, x)' = A (v, x) + (1, 0) h (T - r u),   A = [[-c, -w], [1, 0]].
 *   Step  (v, x) += D (v, x) + sum A^k (1, 0) S_k,   D = A + A^2/2 + A^3/6 + A^4/24 (never I + D: see integrator.h),
 *         S_0 = h/6 (T1 + 2 T2 + 2 T3 + T4), S_1 = h/6 (T1 + T2 + T3), S_2 = h/12 (T1 + T2), S_3 = h/24 T1, less r times the same of u.
 *   Two outputs: y = sum g v, g = b_i^2, and p = sum k (x + be v), k = d_i b_i w / h. The stages see of each, torque-free,
 *         o,  o + o'/2,  o + o'/2 + o''/4,  o + o' + o''/2 + o'''/4,
 *         and of the inputs of earlier stages, with M_k = h (output row) A^k (1, 0):
 *         stage 2: M_0/2 T1;  stage 3: M_1/4 T1 + M_0/2 T2;  stage 4: M_2/4 T1 + M_1/2 T2 + M_0 T3; of u likewise, times -r.
 *   sin and cos of theta_top are turned by the stages' angles with short polynomials, and every KELLY_RESYNC ticks taken
 *         anew from an integer phase, which holds w_ref t (a commanded top: all of theta_top), and phi.
 *
 * Steps are stable where kelly_realise says so; |h theta_top'| has to stay below KELLY_TURN.
 *
 * Memory  sizeof(kelly_driven), the caller's; for one float lane 1.1 KB.
 * Time    about 850 operations and 4 divisions a step and lane with 10 modes.
 * Bits    as in integrator.h.
 */
#ifndef KELLY_DRIVE_H
#define KELLY_DRIVE_H

#include "detmath.h"
#include "integrator.h"

/* An angle [rad], or what a speed [rad/s] turns in step_ns, in turns / 2^64; either sign. */
static inline uint64_t kelly_turns(real w, uint32_t step_ns)
{
    return w < 0 ? 0 - kelly_phase_step(-w, step_ns) : kelly_phase_step(w, step_ns);
}

/* Coefficients and state of one mode. */
typedef struct {
    vreal w, c, g, k, r;
    vreal d00, d01, d10, d11;    /* D */
    vreal v, x;
} kelly_driven_mode;

/* One of the two outputs at the four stages, and what the inputs of earlier stages add: M_0/2, M_1/4, M_2/4. */
typedef struct {
    vreal at[4];
    vreal of_t[3], of_u[3];
} kelly_output;

/* What one vector of lanes needs beside its modes. */
typedef struct {
    vreal w_ref, a1, a2;
    vreal muf_mean, muf_swing;   /* mu f = min(muf_mean + muf_swing sin, 0) */
    vreal rest, residue;         /* 1 - sum d b; Jm */
    vreal drag;                  /* J alpha w_ref [N m] */
    vreal k_speed, k_angle;      /* k_p + Jm alpha, k_i */
    vreal gain;                  /* 1 / (J_d + Jm); 0: commanded */
    vreal slope;                 /* eta' of a commanded top [rad/s2] */
    vreal counted;               /* the eta whose angle is in the integer phase, so that phi' = eta - counted; 0: soft */
    vreal eta, phi;              /* [rad/s], [rad] */
    vreal sine, cosine;          /* of theta_top */
    vreal sines[4];              /* of theta_top at the stages of the last step */
    kelly_output y, p;
    vreal speed;                 /* of the bit now */
    vreal lowest, highest;       /* of it since the last kelly_driven_watch */
    vbits guard;                 /* of the state: eta to cosine, y.at, p.at, from speed on, and of the modes; seal.h */
} kelly_driven_lane;

typedef struct {
    kelly_driven_lane lane[KELLY_VECTORS];
    kelly_driven_mode mode[KELLY_VECTORS][KELLY_MODES_MAX];
    uint64_t phase[KELLY_LANES];        /* of theta_top, phi left out [turns / 2^64] */
    uint64_t phase_step[KELLY_LANES];   /* what it gains a tick */
    real h, alpha, be;
    unsigned modes;              /* in use */
    unsigned vectors;            /* in use */
    uint32_t step_ns;
    uint32_t tick;
    uint8_t strayed[KELLY_LANES];       /* sine or cosine of this lane was not that of theta_top: 1 */
    uint64_t phases;             /* guard of phase[] */
} kelly_driven;

/* Over what a lane holds from one step to the next: its share of the guard. */
KELLY_SHARED vbits kelly_driven_held(const kelly_driven_lane *on)
{
    vbits bits = vbits_of(on->eta) ^ vbits_of(on->phi) ^ vbits_of(on->sine) ^ vbits_of(on->cosine) ^ vbits_of(on->speed) ^
                 vbits_of(on->lowest) ^ vbits_of(on->highest);

    for (unsigned k = 0; k < 4; k++) {
        bits = bits ^ vbits_of(on->y.at[k]) ^ vbits_of(on->p.at[k]);
    }
    return bits;
}

KELLY_SHARED void kelly_driven_put_phase(kelly_driven *driven, unsigned lane, uint64_t phase)
{
    driven->phases ^= driven->phase[lane] ^ phase;
    driven->phase[lane] = phase;
}

/* Prepare for `lanes` realisations (1..KELLY_LANES) of this case at tick 0. Every lane idles until it is loaded. */
void kelly_driven_clear(kelly_driven *driven, const kelly_table *table, const kelly_case *run, unsigned lanes);

/* Put one checked realisation into lane `lane`, at tick 0: under the drive of the case, or, where it has none, with a
 * commanded top. The top turns at top_speed [rad/s], which is that of the draw for a drive. */
void kelly_driven_load(kelly_driven *driven, unsigned lane, const kelly_table *table, const kelly_case *run,
                       const kelly_draw *draw, const kelly_modes *modes, real top_speed);

/* Advance all lanes by `ticks` steps; none where a fault has changed the counts to what would lead out of the struct. */
void kelly_driven_advance(kelly_driven *driven, uint32_t ticks);

/* Commanded tops: from now on the speed changes by `slope` [rad/s2]; on the way it is put to `top_speed` [rad/s], which it has but for
 * the rounding of many small gains; or it is `top_speed` and stays. */
void kelly_driven_ramp(kelly_driven *driven, unsigned lane, real slope);
void kelly_driven_adjust(kelly_driven *driven, unsigned lane, real top_speed);
void kelly_driven_hold(kelly_driven *driven, unsigned lane, real top_speed);

/* Put `weight` [N] in place of fc in (F). */
void kelly_driven_weigh(kelly_driven *driven, unsigned lane, const kelly_case *run, const kelly_draw *draw, real weight);

/* Sine and cosine of a lane from its integer phase and phi; what the next step starts from, from the state of its modes. */
void kelly_driven_resync(kelly_driven *driven, unsigned lane);
void kelly_driven_outputs(kelly_driven *driven, unsigned lane);
int kelly_driven_strays(const kelly_driven *driven, unsigned lane);

/* As their namesakes of integrator.h. The twist includes phi: with w0 it gives the mean bit speed under a soft drive. */
void kelly_driven_watch(kelly_driven *driven);
real kelly_driven_speed(const kelly_driven *driven, unsigned lane);
void kelly_driven_extremes(const kelly_driven *driven, unsigned lane, real *lowest, real *highest);
void kelly_driven_modal(const kelly_driven *driven, unsigned lane, const kelly_modes *modes,
                        real q[KELLY_MODES_MAX], real v[KELLY_MODES_MAX]);
real kelly_driven_twist(const kelly_driven *driven, unsigned lane, const kelly_modes *modes);
int kelly_driven_sane(const kelly_driven *driven, unsigned lane);
int kelly_driven_untouched(const kelly_driven *driven);

/* A sum over everything that does not change as tops that are not commanded advance: see seal.h. */
uint32_t kelly_driven_seal(const kelly_driven *driven);

/* Speed of the top now [rad/s], and the torque (S) that it takes where the bit's is bit_torque [N m]. */
real kelly_driven_top_speed(const kelly_driven *driven, unsigned lane);
real kelly_driven_top_torque(const kelly_driven *driven, unsigned lane, real bit_torque);

#endif
