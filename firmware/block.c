/* block.c - set up a block, put realisations into its lanes, read them. The stepping is in integrator.c. */
#include "form_m.h"
#include "form_s.h"
#include "seal.h"

#define F_OFFSET R(0.01)          /* constant part of f_a / f0, eq. (F) */
#define QUARTER_TURN ((uint64_t)1 << 62)
#define SANE R(1e30)              /* states, which grow as (d/b) / h^2, and finite in float with room for one more step */
#define SMALL_A2 R(1e-18)         /* below it a2 w^2 is nothing beside 1, and 1 / a2 might overflow */
#define SANE_SPEED R(1e6)         /* [rad/s], of the bit */

/* Form S leaves out terms in be w^2, w^2 and al^2, which lie below half an ulp of what they would be added to up to these
 * bounds; the paper's ten modes at 1 ms have be w^2 = 7e-7, w^2 = 9e-6, al^2 = 1e-8. Never in double. */
#define SLOW_BEWW R(1.4e-6)
#define SLOW_WW R(1.2e-5)
#define SLOW_ALAL R(1e-7)

static real larger(real a, real b)
{
    return a > b ? a : b;
}

void kelly_block_clear(kelly_block *block, const kelly_table *table, const kelly_case *run, unsigned lanes)
{
    const real h = kelly_step_seconds(run);
    const real *const top = &table->w2[(size_t)(run->torsional - 1u) * (table->degree + 1u)];
    const real w = h * h * larger(kelly_poly(top, table->degree, R(1.0)), kelly_poly(top, table->degree, R(-1.0)));

    *block = (kelly_block){ 0 };   /* a lane without a realisation stands still: no torque, never a NaN */
    for (unsigned lane = 0; lane < KELLY_LANES; lane++) {
        LANE(block->lane[lane / KELLY_WIDTH].inverse, lane % KELLY_WIDTH) = R(1.0);
    }
    block->h = h;
    block->al = table->alpha * h;
    block->be = table->beta / h;
    block->modes = run->torsional;
    block->vectors = (lanes + KELLY_WIDTH - 1) / KELLY_WIDTH;
    block->full = sizeof(real) > sizeof(float) || !(block->be * w * w < SLOW_BEWW && w * w < SLOW_WW && block->al * block->al < SLOW_ALAL);
}

/* Coefficients of one mode of one lane: D by Horner's rule in A, outputs with g h/6 in them. */
static void load_mode(kelly_mode *mode, unsigned l, const kelly_block *block, real w, real g)
{
    const real al = block->al, be = block->be, c = al + be * w, gk = g * block->h / R(6.0);
    const real a00 = -(w * be), a01 = -w, a10 = R(1.0) - al * be, a11 = -al;
    const real z0 = gk * ((R(1.0) - c * be) * a00 - c * a10), z1 = gk * ((R(1.0) - c * be) * a01 - c * a11);
    real d00 = 0, d01 = 0, d10 = 0, d11 = 0;

    for (int k = 4; k > 0; k--) {                       /* D <- (A + A D) / k */
        const real r = (real)k;
        const real n00 = (a00 + (a00 * d00 + a01 * d10)) / r, n01 = (a01 + (a00 * d01 + a01 * d11)) / r;
        const real n10 = (a10 + (a10 * d00 + a11 * d10)) / r, n11 = (a11 + (a10 * d01 + a11 * d11)) / r;

        d00 = n00;
        d01 = n01;
        d10 = n10;
        d11 = n11;
    }
    LANE(mode->w4, l) = R(0.25) * w;
    LANE(mode->d00, l) = d00;
    LANE(mode->d01, l) = d01;
    LANE(mode->d10, l) = d10;
    LANE(mode->d11, l) = d11;
    LANE(mode->m0, l) = gk * (R(1.0) - c * be) + be * z0;
    LANE(mode->m1, l) = be * z1 - gk * c;
    LANE(mode->m2, l) = R(0.5) * z0;
    LANE(mode->m3, l) = R(0.5) * z1;
}

/* The numbers of one mode that lead to form S, as distances from 1, -1/2 and 1, which are small: so the coefficients are right to
 * the last digit or two. p and r: D = p A + r w I;  w e = det D;  p - c r = 1 - w/6 + c w/24. */
typedef struct {
    real c, p, r, e;
} slow_numbers;

static slow_numbers slow_of(const kelly_block *block, real w)
{
    const real c = block->al + block->be * w, cc = c * c - w;
    const real n = c * w / R(24.0) - w / R(6.0);
    slow_numbers k = { .c = c };

    k.p = cc / R(6.0) + c * (w - cc) / R(24.0) - R(0.5) * c;
    k.r = c / R(6.0) - cc / R(24.0);
    k.e = (k.p + n) + (k.p * n + w * ((k.r - R(0.5)) * (k.r - R(0.5))));
    return k;
}

static void load_slow(kelly_slow_mode *mode, unsigned l, const kelly_block *block, real w, real g)
{
    const slow_numbers k = slow_of(block, w);
    const real gk = g * block->h / R(6.0), gw = R(0.25) * gk * w;

    LANE(mode->t, l) = (w * (2 * k.r + R(0.5) * k.e) - k.c * k.p) - (k.c + R(0.5) * w);
    LANE(mode->d, l) = R(0.5) * (w + w * k.e);
    LANE(mode->g, l) = gk;
    LANE(mode->m, l) = gw + gw * ((k.e - k.p) / (R(1.0) + k.p));
    LANE(mode->w4, l) = R(0.25) * w;
}

/* State of one mode from Q/h and Q' against the drag equilibrium. */
static void put_state(kelly_block *block, unsigned lane, unsigned i, real w, real over_h, real speed)
{
    const unsigned v = lane / KELLY_WIDTH, l = lane % KELLY_WIDTH;
    const real scale = R(6.0) / block->h;
    vbits *const guard = &block->lane[v].guard;

    if (block->full) {
        kelly_mode *const mode = &block->mode[v][i];
        const real xi = scale * (speed + (block->al + block->be * w) * over_h);

        vput_lane(&mode->xi, l, xi, guard);
        vput_lane(&mode->zeta, l, scale * over_h - block->be * xi, guard);
    } else {
        kelly_slow_mode *const mode = &block->slow[v][i];
        const slow_numbers k = slow_of(block, w);

        vput_lane(&mode->v, l, scale * speed, guard);
        vput_lane(&mode->x, l, scale * ((2 * (over_h + k.p * over_h) + (k.e + 2 * k.r) * speed) / (R(1.0) + k.e)), guard);
    }
}

/* Start of one mode: Q = 0 at tick 0, so Q against the drag equilibrium is al w0 (d/b) / w; Q' = -(d/b) w0 from rest, 0 if turning. */
static void start_mode(kelly_block *block, unsigned lane, unsigned i, real w, real d_over_b, real w0, int rotating)
{
    put_state(block, lane, i, w, block->al * w0 * d_over_b / w, rotating ? 0 : -(d_over_b * w0));
}

static void load_modes(kelly_block *block, unsigned lane, const kelly_modes *modes, const kelly_draw *draw, int rotating)
{
    const unsigned v = lane / KELLY_WIDTH, l = lane % KELLY_WIDTH;
    kelly_lane *const out = &block->lane[v];
    const real h = block->h;
    real sum_g = 0, sum_gc = 0, sum_gcc = 0;

    for (unsigned i = 0; i < modes->count; i++) {
        const real w = h * h * modes->w2[i], g = modes->b[i] * modes->b[i], c = block->al + block->be * w;

        if (block->full) {
            load_mode(&block->mode[v][i], l, block, w, g);
        } else {
            load_slow(&block->slow[v][i], l, block, w, g);
        }
        start_mode(block, lane, i, w, modes->d[i] / modes->b[i], draw->w0, rotating);
        sum_g += g;
        sum_gc += g * c;
        sum_gcc += g * (c * c - w);
    }
    LANE(out->g1, l) = R(0.5) * h * sum_g;
    LANE(out->g2, l) = R(-0.25) * h * sum_gc;
    LANE(out->g3, l) = R(0.25) * h * sum_gcc;
    LANE(out->twice_g1, l) = h * sum_g;
    LANE(out->twice_g2, l) = R(-0.5) * h * sum_gc;
}

/* Stage speeds of the first step, of the whole vector. */
static void first_speeds(kelly_block *block, unsigned v)
{
    kelly_lane *const on = &block->lane[v];

    (void)vtake(&on->y1, &on->guard);
    (void)vtake(&on->y2, &on->guard);
    (void)vtake(&on->y3, &on->guard);
    (void)vtake(&on->y4, &on->guard);
    if (block->full) {
        sums_m sum = outputs_m(&block->mode[v][0]);

        for (unsigned i = 1; i < block->modes; i++) {
            add_m(&sum, outputs_m(&block->mode[v][i]));
        }
        stage_speeds_m(on, &sum, block->al, block->be, &on->guard);
    } else {
        sums_s sum = outputs_s(&block->slow[v][0]);

        for (unsigned i = 1; i < block->modes; i++) {
            add_s(&sum, outputs_s(&block->slow[v][i]));
        }
        stage_speeds_s(on, &sum, block->al, block->be, &on->guard);
    }
}

static void watch(kelly_lane *on)
{
    (void)vtake(&on->lowest, &on->guard);
    (void)vtake(&on->highest, &on->guard);
    vput(&on->lowest, on->y1, &on->guard);
    vput(&on->highest, on->y1, &on->guard);
}

/* v and x, or xi and zeta, of a mode. */
static const vreal *state_of(const kelly_block *block, unsigned v, unsigned i)
{
    return block->full ? &block->mode[v][i].xi : &block->slow[v][i].v;
}

/* What the guard of a vector is between two steps. */
KELLY_SHARED vbits state_bits(const kelly_block *block, unsigned v)
{
    vbits bits = weighed(&block->lane[v]) ^ moved(&block->lane[v]);

    for (unsigned i = 0; i < block->modes && i < KELLY_MODES_MAX; i++) {
        const vreal *const state = state_of(block, v, i);

        bits = bits ^ vbits_of(state[0]) ^ vbits_of(state[1]);
    }
    return bits;
}

void kelly_block_load(kelly_block *block, unsigned lane, const kelly_case *run,
                      const kelly_draw *draw, const kelly_modes *modes)
{
    const unsigned l = lane % KELLY_WIDTH;
    const uint64_t step = kelly_phase_step(draw->w0, run->step_ns);
    const real half_sine = kelly_sin_turn(step / 2);
    const real a2 = larger(draw->a2, SMALL_A2);
    kelly_lane *const out = &block->lane[lane / KELLY_WIDTH];

    block->phase_step[lane] = step;
    block->strayed[lane] = 0;
    LANE(out->w0, l) = draw->w0;
    LANE(out->ratio, l) = draw->a1 / (2 * a2);
    LANE(out->inverse, l) = R(1.0) / a2;
    LANE(out->muf_mean, l) = 2 * draw->mu * (F_OFFSET * run->f0 - draw->fc);
    LANE(out->muf_swing, l) = 2 * draw->mu * run->f0;
    LANE(out->wave_k, l) = 4 * half_sine * half_sine;
    LANE(out->wave_half, l) = R(0.5) / kelly_sin_turn(step / 2 + QUARTER_TURN);
    load_modes(block, lane, modes, draw, run->rotating);
    first_speeds(block, lane / KELLY_WIDTH);
    kelly_block_resync(block, lane);
    watch(out);
}

void kelly_block_watch(kelly_block *block)
{
    for (unsigned v = 0; v < KELLY_VECTORS; v++) {
        watch(&block->lane[v]);
    }
}

int kelly_block_untouched(const kelly_block *block)
{
#if KELLY_GUARD
    for (unsigned v = 0; v < KELLY_VECTORS && v < block->vectors; v++) {
        if (!vsame(state_bits(block, v), block->lane[v].guard)) {
            return 0;
        }
    }
#else
    (void)block;
#endif
    return 1;
}

real kelly_block_speed(const kelly_block *block, unsigned lane)
{
    return LANE(block->lane[lane / KELLY_WIDTH].y1, lane % KELLY_WIDTH);
}

real kelly_block_sine(const kelly_block *block, unsigned lane)
{
    return kelly_sin_turn(block->phase_step[lane] * block->tick);
}

void kelly_block_extremes(const kelly_block *block, unsigned lane, real *lowest, real *highest)
{
    *lowest = LANE(block->lane[lane / KELLY_WIDTH].lowest, lane % KELLY_WIDTH);
    *highest = LANE(block->lane[lane / KELLY_WIDTH].highest, lane % KELLY_WIDTH);
}

/* Q [s units of h undone] and Q' of mode i against the drag equilibrium. */
static void scaled_state(const kelly_block *block, unsigned lane, unsigned i, real w2, real *q, real *speed)
{
    const unsigned v = lane / KELLY_WIDTH, l = lane % KELLY_WIDTH;
    const real scale = block->h / R(6.0), w = block->h * block->h * w2;
    real over_h;

    if (block->full) {
        const real xi = scale * LANE(block->mode[v][i].xi, l), zeta = scale * LANE(block->mode[v][i].zeta, l);

        over_h = zeta + block->be * xi;
        *speed = xi - (block->al + block->be * w) * over_h;
    } else {
        const slow_numbers k = slow_of(block, w);

        *speed = scale * LANE(block->slow[v][i].v, l);
        over_h = ((R(1.0) + k.e) * (scale * LANE(block->slow[v][i].x, l)) - (k.e + 2 * k.r) * *speed) / (2 * (R(1.0) + k.p));
    }
    *q = block->h * over_h;
}

void kelly_block_modal(const kelly_block *block, unsigned lane, const kelly_modes *modes, const kelly_table *table,
                       real q[KELLY_MODES_MAX], real v[KELLY_MODES_MAX])
{
    const real w0 = LANE(block->lane[lane / KELLY_WIDTH].w0, lane % KELLY_WIDTH);

    for (unsigned i = 0; i < modes->count && i < KELLY_MODES_MAX; i++) {
        real shifted, speed;

        scaled_state(block, lane, i, modes->w2[i], &shifted, &speed);
        q[i] = modes->b[i] * shifted - table->alpha * modes->d[i] * w0 / modes->w2[i];
        v[i] = modes->b[i] * speed;
    }
}

real kelly_block_twist(const kelly_block *block, unsigned lane, const kelly_modes *modes)
{
    real twist = 0;

    for (unsigned i = 0; i < modes->count && i < KELLY_MODES_MAX; i++) {
        real shifted, speed;

        scaled_state(block, lane, i, modes->w2[i], &shifted, &speed);
        twist += modes->b[i] * modes->b[i] * shifted;
    }
    return twist;
}

static int within(real x, real limit)
{
    return x > -limit && x < limit;   /* false for a NaN */
}

uint32_t kelly_block_seal(const kelly_block *block)
{
    uint32_t seal = KELLY_SEAL_MEMBERS(0, block, kelly_block, phase_step, full);

    for (unsigned v = 0; v < KELLY_VECTORS && v < block->vectors; v++) {
        seal = KELLY_SEAL_MEMBERS(seal, &block->lane[v], kelly_lane, w0, twice_g2);
        for (unsigned i = 0; i < block->modes && i < KELLY_MODES_MAX; i++) {
            if (block->full) {
                seal = KELLY_SEAL_MEMBERS(seal, &block->mode[v][i], kelly_mode, w4, m3);
            } else {
                seal = KELLY_SEAL_MEMBERS(seal, &block->slow[v][i], kelly_slow_mode, t, w4);
            }
        }
    }
    return seal;
}

/* Whether the weight has strayed from its exact phase. Near half a turn a step rounding grows until only its size can be judged. A NaN
 * would not be seen otherwise: the least of it and 0 is 0, and no weight acts until the next evaluation. */
int kelly_block_strays(const kelly_block *block, unsigned lane)
{
    const kelly_lane *const on = &block->lane[lane / KELLY_WIDTH];
    const unsigned l = lane % KELLY_WIDTH;
    const real swing = LANE(on->muf_swing, l), off = LANE(on->wave, l) - swing * kelly_sin_turn(block->phase_step[lane] * block->tick);

    return !(KELLY_ABS(off) <= swing * (LANE(on->wave_k, l) < R(2.0) ? KELLY_STRAY : R(1.0)));
}

int kelly_block_sane(const kelly_block *block, unsigned lane)
{
    const unsigned v = lane / KELLY_WIDTH, l = lane % KELLY_WIDTH;
    const kelly_lane *const lane_now = &block->lane[v];
    int good = !block->strayed[lane] && !kelly_block_strays(block, lane) && within(LANE(lane_now->dwave, l), SANE) &&
               within(LANE(lane_now->lowest, l), SANE_SPEED) && within(LANE(lane_now->highest, l), SANE_SPEED) &&
               within(LANE(lane_now->y1, l), SANE_SPEED);

    for (unsigned i = 0; i < block->modes && i < KELLY_MODES_MAX; i++) {
        const vreal *const state = state_of(block, v, i);

        good = good && within(LANE(state[0], l), SANE) && within(LANE(state[1], l), SANE);
    }
    return good;
}
