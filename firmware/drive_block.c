/* drive_block.c - set up the lanes of drive.h, command them, read them. The stepping is in drive.c. */
#include "drive.h"
#include "seal.h"

#define F_OFFSET R(0.01)          /* constant part of f_a / f0, eq. (F) */
#define SANE R(1e30)              /* states, finite in float with room for one more step */
#define SANE_SPEED R(1e6)         /* [rad/s], of the bit and of the top, and [rad] of phi */

void kelly_driven_clear(kelly_driven *driven, const kelly_table *table, const kelly_case *run, unsigned lanes)
{
    *driven = (kelly_driven){ 0 };   /* a lane without a realisation stands still: no torque, never a NaN */
    driven->h = kelly_step_seconds(run);
    driven->alpha = table->alpha;
    driven->be = table->beta / driven->h;
    driven->modes = run->torsional;
    driven->vectors = (lanes + KELLY_WIDTH - 1) / KELLY_WIDTH;
    driven->step_ns = run->step_ns;
}

/* D of one mode by Horner's rule in A: D <- (A + A D) / k. */
static void load_step(kelly_driven_mode *mode, unsigned l, real c, real w)
{
    real d00 = 0, d01 = 0, d10 = 0, d11 = 0;

    for (int k = 4; k > 0; k--) {
        const real r = (real)k;
        const real n00 = -(c + (c * d00 + w * d10)) / r, n01 = -(w + (c * d01 + w * d11)) / r;
        const real n10 = (R(1.0) + d00) / r, n11 = d01 / r;

        d00 = n00;
        d01 = n01;
        d10 = n10;
        d11 = n11;
    }
    LANE(mode->d00, l) = d00;
    LANE(mode->d01, l) = d01;
    LANE(mode->d10, l) = d10;
    LANE(mode->d11, l) = d11;
}

/* Start of one mode: q = 0 at tick 0, so that Q against the drag equilibrium is alpha r w_ref / w_i^2; q' = -d times the
 * speed of the top from rest, 0 if turning. */
static void start_mode(kelly_driven_mode *mode, unsigned l, real r, real drag_q, real over_h, real top_speed, int rotating, vbits *guard)
{
    vput_lane(&mode->v, l, rotating ? 0 : -(r * top_speed), guard);
    vput_lane(&mode->x, l, r * drag_q * over_h, guard);
}

/* What one unit of T and of u does to an output whose row is (ov, ox): M_0/2, M_1/4, M_2/4, summed over the modes. */
static void add_markov(kelly_output *o, unsigned l, real ov, real ox, real c, real w, real h, real r)
{
    const real m0 = R(0.5) * h * ov, m1 = R(0.25) * h * (ox - c * ov), m2 = R(0.25) * h * ((c * c - w) * ov - c * ox);

    LANE(o->of_t[0], l) += m0;
    LANE(o->of_t[1], l) += m1;
    LANE(o->of_t[2], l) += m2;
    LANE(o->of_u[0], l) -= r * m0;
    LANE(o->of_u[1], l) -= r * m1;
    LANE(o->of_u[2], l) -= r * m2;
}

static void clear_markov(kelly_output *o, unsigned l)
{
    for (unsigned k = 0; k < 3; k++) {
        LANE(o->of_t[k], l) = 0;
        LANE(o->of_u[k], l) = 0;
    }
}

static void load_modes(kelly_driven *driven, unsigned lane, const kelly_modes *modes, real w_ref, real top_speed, int rotating)
{
    const unsigned l = lane % KELLY_WIDTH;
    kelly_driven_lane *const on = &driven->lane[lane / KELLY_WIDTH];
    const real h = driven->h;

    clear_markov(&on->y, l);
    clear_markov(&on->p, l);
    for (unsigned i = 0; i < modes->count; i++) {
        kelly_driven_mode *const mode = &driven->mode[lane / KELLY_WIDTH][i];
        const real w = h * h * modes->w2[i], c = h * driven->alpha + driven->be * w;
        const real g = modes->b[i] * modes->b[i], k = modes->d[i] * modes->b[i] * (h * modes->w2[i]), r = modes->d[i] / modes->b[i];

        LANE(mode->w, l) = w;
        LANE(mode->c, l) = c;
        LANE(mode->g, l) = g;
        LANE(mode->k, l) = k;
        LANE(mode->r, l) = r;
        load_step(mode, l, c, w);
        start_mode(mode, l, r, driven->alpha * w_ref / modes->w2[i], R(1.0) / h, top_speed, rotating, &on->guard);
        add_markov(&on->y, l, g, 0, c, w, h, r);
        add_markov(&on->p, l, k * driven->be, k, c, w, h, r);
    }
}

/* The top: what the modes leave to it, its drive, its state. */
static void load_top(kelly_driven_lane *on, unsigned l, const kelly_table *table, const kelly_drive *drive, const kelly_modes *modes,
                     real w_ref, real top_speed)
{
    const real turn = 2 * KELLY_PI * drive->hz;
    real rest = R(1.0), residue = table->inertia;

    for (unsigned i = 0; i < modes->count; i++) {
        rest -= modes->d[i] * modes->b[i];
        residue -= modes->d[i] * modes->d[i];
    }
    LANE(on->rest, l) = rest;
    LANE(on->residue, l) = residue;
    LANE(on->drag, l) = table->inertia * table->alpha * w_ref;
    LANE(on->k_speed, l) = 4 * drive->impedance + residue * table->alpha;
    LANE(on->k_angle, l) = turn * turn * drive->inertia;
    LANE(on->gain, l) = drive->inertia > 0 ? R(1.0) / (drive->inertia + residue) : 0;
    LANE(on->slope, l) = 0;
    LANE(on->counted, l) = top_speed - w_ref;
    vput_lane(&on->eta, l, top_speed - w_ref, &on->guard);
    vput_lane(&on->phi, l, 0, &on->guard);
}

/* What the guard of a vector is between two steps. */
KELLY_SHARED vbits state_bits(const kelly_driven *driven, unsigned v)
{
    vbits bits = kelly_driven_held(&driven->lane[v]);

    for (unsigned i = 0; i < driven->modes && i < KELLY_MODES_MAX; i++) {
        bits = bits ^ vbits_of(driven->mode[v][i].v) ^ vbits_of(driven->mode[v][i].x);
    }
    return bits;
}

void kelly_driven_load(kelly_driven *driven, unsigned lane, const kelly_table *table, const kelly_case *run,
                       const kelly_draw *draw, const kelly_modes *modes, real top_speed)
{
    const unsigned l = lane % KELLY_WIDTH;
    kelly_driven_lane *const on = &driven->lane[lane / KELLY_WIDTH];

    kelly_driven_put_phase(driven, lane, 0);
    driven->strayed[lane] = 0;
    driven->phase_step[lane] = kelly_turns(top_speed, run->step_ns);
    LANE(on->w_ref, l) = draw->w0;
    LANE(on->a1, l) = draw->a1;
    LANE(on->a2, l) = draw->a2;
    kelly_driven_weigh(driven, lane, run, draw, draw->fc);
    load_top(on, l, table, &run->drive, modes, draw->w0, top_speed);
    load_modes(driven, lane, modes, draw->w0, top_speed, run->rotating);
    kelly_driven_outputs(driven, lane);
    kelly_driven_resync(driven, lane);
    vput_lane(&on->lowest, l, LANE(on->speed, l), &on->guard);
    vput_lane(&on->highest, l, LANE(on->speed, l), &on->guard);
}

void kelly_driven_weigh(kelly_driven *driven, unsigned lane, const kelly_case *run, const kelly_draw *draw, real weight)
{
    kelly_driven_lane *const on = &driven->lane[lane / KELLY_WIDTH];

    LANE(on->muf_mean, lane % KELLY_WIDTH) = draw->mu * (F_OFFSET * run->f0 - weight);
    LANE(on->muf_swing, lane % KELLY_WIDTH) = draw->mu * run->f0;
}

/* What the top turns from here on is counted in the integer phase where it stays at its present speed. */
static void count_from_here(kelly_driven *driven, unsigned lane)
{
    kelly_driven_lane *const on = &driven->lane[lane / KELLY_WIDTH];
    const unsigned l = lane % KELLY_WIDTH;

    kelly_driven_put_phase(driven, lane, driven->phase[lane] + kelly_turns(LANE(on->phi, l), 1000000000u));
    driven->phase_step[lane] = kelly_turns(LANE(on->w_ref, l) + LANE(on->eta, l), driven->step_ns);
    vput_lane(&on->phi, l, 0, &on->guard);
    LANE(on->counted, l) = LANE(on->eta, l);
}

void kelly_driven_ramp(kelly_driven *driven, unsigned lane, real slope)
{
    count_from_here(driven, lane);
    LANE(driven->lane[lane / KELLY_WIDTH].slope, lane % KELLY_WIDTH) = slope;
}

void kelly_driven_adjust(kelly_driven *driven, unsigned lane, real top_speed)
{
    kelly_driven_lane *const on = &driven->lane[lane / KELLY_WIDTH];
    const unsigned l = lane % KELLY_WIDTH;

    const real eta = top_speed - LANE(on->w_ref, l);

    vput_lane(&on->eta, l, eta, &on->guard);
    vput_lane(&on->speed, l, (LANE(on->w_ref, l) + eta) + LANE(on->y.at[0], l), &on->guard);
}

void kelly_driven_hold(kelly_driven *driven, unsigned lane, real top_speed)
{
    LANE(driven->lane[lane / KELLY_WIDTH].slope, lane % KELLY_WIDTH) = 0;
    kelly_driven_adjust(driven, lane, top_speed);
    count_from_here(driven, lane);
}

void kelly_driven_watch(kelly_driven *driven)
{
    for (unsigned v = 0; v < KELLY_VECTORS; v++) {
        kelly_driven_lane *const on = &driven->lane[v];

        (void)vtake(&on->lowest, &on->guard);
        (void)vtake(&on->highest, &on->guard);
        vput(&on->lowest, on->speed, &on->guard);
        vput(&on->highest, on->speed, &on->guard);
    }
}

real kelly_driven_speed(const kelly_driven *driven, unsigned lane)
{
    return LANE(driven->lane[lane / KELLY_WIDTH].speed, lane % KELLY_WIDTH);
}

void kelly_driven_extremes(const kelly_driven *driven, unsigned lane, real *lowest, real *highest)
{
    *lowest = LANE(driven->lane[lane / KELLY_WIDTH].lowest, lane % KELLY_WIDTH);
    *highest = LANE(driven->lane[lane / KELLY_WIDTH].highest, lane % KELLY_WIDTH);
}

void kelly_driven_modal(const kelly_driven *driven, unsigned lane, const kelly_modes *modes,
                        real q[KELLY_MODES_MAX], real v[KELLY_MODES_MAX])
{
    const unsigned l = lane % KELLY_WIDTH;
    const real drag = driven->alpha * LANE(driven->lane[lane / KELLY_WIDTH].w_ref, l);

    for (unsigned i = 0; i < modes->count && i < KELLY_MODES_MAX; i++) {
        const kelly_driven_mode *const mode = &driven->mode[lane / KELLY_WIDTH][i];

        q[i] = modes->b[i] * (driven->h * LANE(mode->x, l)) - drag * modes->d[i] / modes->w2[i];
        v[i] = modes->b[i] * LANE(mode->v, l);
    }
}

real kelly_driven_twist(const kelly_driven *driven, unsigned lane, const kelly_modes *modes)
{
    const unsigned l = lane % KELLY_WIDTH;
    real twist = LANE(driven->lane[lane / KELLY_WIDTH].phi, l);

    for (unsigned i = 0; i < modes->count && i < KELLY_MODES_MAX; i++) {
        const kelly_driven_mode *const mode = &driven->mode[lane / KELLY_WIDTH][i];

        twist += LANE(mode->g, l) * (driven->h * LANE(mode->x, l));
    }
    return twist;
}

static int within(real x, real limit)
{
    return x > -limit && x < limit;   /* false for a NaN */
}

int kelly_driven_sane(const kelly_driven *driven, unsigned lane)
{
    const unsigned v = lane / KELLY_WIDTH, l = lane % KELLY_WIDTH;
    const kelly_driven_lane *const on = &driven->lane[v];
    int good = !driven->strayed[lane] && !kelly_driven_strays(driven, lane) &&
               within(LANE(on->lowest, l), SANE_SPEED) && within(LANE(on->highest, l), SANE_SPEED) &&
               within(LANE(on->speed, l), SANE_SPEED) && within(LANE(on->eta, l), SANE_SPEED) && within(LANE(on->phi, l), SANE_SPEED);

    for (unsigned i = 0; i < driven->modes && i < KELLY_MODES_MAX; i++) {
        good = good && within(LANE(driven->mode[v][i].v, l), SANE) && within(LANE(driven->mode[v][i].x, l), SANE);
    }
    return good;
}

int kelly_driven_untouched(const kelly_driven *driven)
{
#if KELLY_GUARD
    uint64_t phases = driven->phases;

    for (unsigned lane = 0; lane < KELLY_LANES; lane++) {
        phases ^= driven->phase[lane];
    }
    for (unsigned v = 0; v < KELLY_VECTORS && v < driven->vectors; v++) {
        if (!vsame(state_bits(driven, v), driven->lane[v].guard)) {
            return 0;
        }
    }
    return phases == 0;
#else
    (void)driven;
    return 1;
#endif
}

uint32_t kelly_driven_seal(const kelly_driven *driven)
{
    uint32_t seal = KELLY_SEAL_MEMBERS(0, driven, kelly_driven, phase_step, step_ns);

    for (unsigned v = 0; v < KELLY_VECTORS && v < driven->vectors; v++) {
        const kelly_driven_lane *const on = &driven->lane[v];

        seal = KELLY_SEAL_MEMBERS(seal, on, kelly_driven_lane, w_ref, counted);
        seal = kelly_seal(seal, on->y.of_t, sizeof(on->y.of_t) + sizeof(on->y.of_u));
        seal = kelly_seal(seal, on->p.of_t, sizeof(on->p.of_t) + sizeof(on->p.of_u));
        for (unsigned i = 0; i < driven->modes && i < KELLY_MODES_MAX; i++) {
            seal = KELLY_SEAL_MEMBERS(seal, &driven->mode[v][i], kelly_driven_mode, w, d11);
        }
    }
    return seal;
}

real kelly_driven_top_speed(const kelly_driven *driven, unsigned lane)
{
    const kelly_driven_lane *const on = &driven->lane[lane / KELLY_WIDTH];

    return LANE(on->w_ref, lane % KELLY_WIDTH) + LANE(on->eta, lane % KELLY_WIDTH);
}

real kelly_driven_top_torque(const kelly_driven *driven, unsigned lane, real bit_torque)
{
    const kelly_driven_lane *const on = &driven->lane[lane / KELLY_WIDTH];
    const unsigned l = lane % KELLY_WIDTH;
    const real eta = LANE(on->eta, l), string = LANE(on->drag, l) - LANE(on->rest, l) * bit_torque - LANE(on->p.at[0], l);
    const real push = -(string + LANE(on->k_speed, l) * eta + LANE(on->k_angle, l) * LANE(on->phi, l));
    const real slope = LANE(on->slope, l) + LANE(on->gain, l) * push;

    return string + LANE(on->residue, l) * (slope + driven->alpha * eta);
}
