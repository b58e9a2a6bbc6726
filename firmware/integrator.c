#include "integrator.h"

#include "bitrock.h"
#include "detmath.h"

#define F_OFFSET R(0.01)          /* constant part of f_a / f0, eq. (F) */
#define QUARTER_TURN ((uint64_t)1 << 62)
#define SANE R(1e12)              /* states beyond are not physical: xi and zeta reach some 1e7 */

/* In float the terms be w^2 T1/24 of xi and be w^2 X/4 of y4 lie below half an ulp of what they are added to as long as
 * be w^2 < 24 * 2^-24; the paper's ten modes at 1 ms have 7e-7. Then they are left out. Never in double. */
#define NEGLIGIBLE R(1.4e-6)

#if defined(__clang__)
#define UNROLL _Pragma("unroll")
#elif defined(__GNUC__)
#define UNROLL _Pragma("GCC unroll 16")
#else
#define UNROLL
#endif

/* Sums over the modes of the outputs X and Z, and of w X, w Z, w w X. */
typedef struct {
    vreal x, z, wx, wz, wwx;
} sums;

/* Second to fourth stage torque of a step, and mu f at half of it. */
typedef struct {
    vreal half, t2, t3, t4;
} stages;

/* The torques of one step as the modes need them: xi gains s0 + w (e1 + w e2), zeta gains e4 + w e3. */
typedef struct {
    vreal s0, e1, e2, e3, e4;
} inputs;

/* A mode comes into registers as one block: with an FPU of its own register file, Cortex-M loads it with one instruction. */
#if defined(__arm__) && defined(__ARM_FP) && !defined(KELLY_DOUBLE) && KELLY_WIDTH == 1
KELLY_INLINE kelly_mode fetch(const kelly_mode *from)
{
    register real w __asm("s16"), d00 __asm("s17"), d01 __asm("s18"), d10 __asm("s19"), d11 __asm("s20");
    register real m0 __asm("s21"), m1 __asm("s22"), m2 __asm("s23"), m3 __asm("s24"), xi __asm("s25"), zeta __asm("s26");

    __asm("vldmia %11, {s16-s26}" : "=t"(w), "=t"(d00), "=t"(d01), "=t"(d10), "=t"(d11), "=t"(m0), "=t"(m1), "=t"(m2), "=t"(m3),
          "=t"(xi), "=t"(zeta) : "r"(from), "m"(*from));
    return (kelly_mode){ w, d00, d01, d10, d11, m0, m1, m2, m3, xi, zeta };
}
#else
KELLY_INLINE kelly_mode fetch(const kelly_mode *from)
{
    return *from;
}
#endif

KELLY_INLINE void add_outputs(sums *sum, const kelly_mode *mode, int full)
{
    const vreal z = mode->m2 * mode->xi + mode->m3 * mode->zeta;
    const vreal x = mode->m0 * mode->xi + mode->m1 * mode->zeta;
    const vreal wx = mode->w * x;

    sum->x = sum->x + x;
    sum->z = sum->z + z;
    sum->wx = sum->wx + wx;
    sum->wz = sum->wz + mode->w * z;
    if (full) {
        sum->wwx = sum->wwx + mode->w * wx;
    }
}

/* x <- x + D x + inputs */
KELLY_INLINE void move(kelly_mode *mode, const inputs *in, int full)
{
    const vreal xi = mode->xi, zeta = mode->zeta;
    const vreal e = full ? in->e1 + mode->w * in->e2 : in->e1;

    mode->xi = xi + ((mode->d00 * xi + mode->d01 * zeta) + (in->s0 + mode->w * e));
    mode->zeta = zeta + ((mode->d10 * xi + mode->d11 * zeta) + (in->e4 + mode->w * in->e3));
}

/* Stage speeds of the next step, torque-free, from the sums: v, v + v'/2, v + v'/2 + v''/4, v + v' + v''/2 + v'''/4. */
KELLY_INLINE void stage_speeds(kelly_lane *lane, const sums *sum, real al, real be, int full)
{
    const vreal n = sum->wx + al * sum->z;                             /* -v'' */
    const vreal third = al * n - (R(1.0) - al * be) * sum->wz;         /* v''' */

    lane->y1 = (lane->w0 + sum->x) - be * sum->z;
    lane->y2 = lane->y1 + R(0.5) * sum->z;
    lane->y3 = lane->y2 - R(0.25) * n;
    lane->y4 = (lane->y1 + sum->z) + (R(0.25) * (full ? third + be * sum->wwx : third) - R(0.5) * n);
}

KELLY_INLINE inputs inputs_of(vreal t1, vreal t2, vreal t3, vreal t4, real al, real be)
{
    const vreal t23 = t2 + t3, quarter = R(0.25) * t1;
    inputs in;

    in.s0 = (t1 + t4) + (t23 + t23);
    in.e1 = al * quarter - R(0.5) * (t1 + t2);
    in.e2 = be * quarter;
    in.e3 = (al * be - R(1.0)) * quarter;
    in.e4 = ((t1 + t23) - be * in.s0) + al * in.e1;
    return in;
}

/* Torque at the present tick: the first stage of the step to come. */
KELLY_INLINE void first_torque(kelly_lane *on)
{
    on->t1 = kelly_bit_torque(on->y1, on->muf, on->a1, on->a2);
}

/* Second stage, at half a step; takes the weight and the sine to the next tick. */
KELLY_INLINE void second_torque(kelly_lane *on, stages *at)
{
    const vreal sine = on->sine + on->dsine;

    at->half = vmin(on->muf_mean + on->muf_swing * ((on->sine + sine) * on->sine_half), vsplat(0));
    on->muf = vmin(on->muf_mean + on->muf_swing * sine, vsplat(0));
    on->dsine = on->dsine - on->sine_k * sine;
    on->sine = sine;
    at->t2 = kelly_bit_torque(on->y2 + on->g1 * on->t1, at->half, on->a1, on->a2);
}

KELLY_INLINE void third_torque(const kelly_lane *on, stages *at)
{
    at->t3 = kelly_bit_torque((on->y3 + on->g2 * on->t1) + on->g1 * at->t2, at->half, on->a1, on->a2);
}

KELLY_INLINE void fourth_torque(const kelly_lane *on, stages *at)
{
    const vreal y = (on->y4 + on->g3 * on->t1) + (on->g2 + on->g2) * at->t2;

    at->t4 = kelly_bit_torque(y + (on->g1 + on->g1) * at->t3, on->muf, on->a1, on->a2);
}

/* The modes under the four torques, and the stage speeds and first torque of the next step. */
KELLY_INLINE void finish(kelly_lane *on, kelly_mode *mode, unsigned modes, const stages *at, real al, real be, int full)
{
    const inputs in = inputs_of(on->t1, at->t2, at->t3, at->t4, al, be);
    sums sum = { .x = vsplat(0) };

    for (unsigned i = 0; i < modes; i++) {
        kelly_mode now = fetch(&mode[i]);

        move(&now, &in, full);
        mode[i].xi = now.xi;
        mode[i].zeta = now.zeta;
        add_outputs(&sum, &now, full);
    }
    stage_speeds(on, &sum, al, be, full);
    on->lowest = vmin(on->y1, on->lowest);
    on->highest = vmax(on->y1, on->highest);
    first_torque(on);
}

/* Advance `vectors` vectors, a compile-time constant, by `ticks` steps, without looking at the exact phase.
 * One torque is a chain of some 60 cycles: stage by stage over all vectors, so that chains stand side by side in the
 * instruction stream and hide each other. */
KELLY_INLINE void steps(kelly_block *block, uint32_t ticks, const unsigned vectors, const int full)
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
            finish(&block->lane[v], block->mode[v], modes, &at[v], al, be, full);
        }
    }
}

/* One loop for each number of vectors in use, so that the compiler can keep them all in flight. */
static void advance(kelly_block *block, uint32_t ticks)
{
#define WITH(n) \
    case n: \
        if (block->full) { \
            steps(block, ticks, n, 1); \
        } else { \
            steps(block, ticks, n, 0); \
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
    default:
        break;
    }
#undef WITH
}

/* The sine of a lane from its exact integer phase. */
static void resync(kelly_block *block, unsigned lane)
{
    const uint64_t step = block->phase_step[lane], phase = step * block->tick;
    kelly_lane *const out = &block->lane[lane / KELLY_WIDTH];
    const unsigned l = lane % KELLY_WIDTH;
    const real sine = kelly_sin_turn(phase);
    const real muf = LANE(out->muf_mean, l) + LANE(out->muf_swing, l) * sine;

    LANE(out->sine, l) = sine;
    LANE(out->dsine, l) = 2 * kelly_sin_turn(phase + step / 2 + QUARTER_TURN) * kelly_sin_turn(step / 2);
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
                resync(block, lane);
            }
        }
        advance(block, part);
        block->tick += part;
        ticks -= part;
    }
}

static real larger(real a, real b)
{
    return a > b ? a : b;
}

void kelly_block_clear(kelly_block *block, const kelly_table *table, const kelly_case *run, unsigned lanes)
{
    const real h = kelly_step_seconds(run);
    const real *const top = &table->w2[(run->torsional - 1u) * (table->degree + 1u)];
    const real w = h * h * larger(kelly_poly(top, table->degree, R(1.0)), kelly_poly(top, table->degree, R(-1.0)));

    *block = (kelly_block){ 0 };   /* a lane without a realisation stands still: no torque, never a NaN */
    block->h = h;
    block->al = table->alpha * h;
    block->be = table->beta / h;
    block->modes = run->torsional;
    block->vectors = (lanes + KELLY_WIDTH - 1) / KELLY_WIDTH;
    block->full = sizeof(real) > sizeof(float) || block->be * w * w >= NEGLIGIBLE;
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
    LANE(mode->w, l) = w;
    LANE(mode->d00, l) = d00;
    LANE(mode->d01, l) = d01;
    LANE(mode->d10, l) = d10;
    LANE(mode->d11, l) = d11;
    LANE(mode->m0, l) = gk * (R(1.0) - c * be) + be * z0;
    LANE(mode->m1, l) = be * z1 - gk * c;
    LANE(mode->m2, l) = z0;
    LANE(mode->m3, l) = z1;
}

/* Start of one mode: Q = 0 at tick 0, so Q against the drag equilibrium is al w0 (d/b) / w; Q' = -(d/b) w0 from rest, 0 if turning. */
static void start_mode(kelly_mode *mode, unsigned l, const kelly_block *block, real w, real d_over_b, real w0, int rotating)
{
    const real scale = R(6.0) / block->h, c = block->al + block->be * w;
    const real speed = rotating ? 0 : -(d_over_b * w0);
    const real q = block->al * w0 * d_over_b / w;
    const real xi = scale * (speed + c * q);

    LANE(mode->xi, l) = xi;
    LANE(mode->zeta, l) = scale * q - block->be * xi;
}

static void load_modes(kelly_block *block, unsigned lane, const kelly_modes *modes, const kelly_draw *draw, int rotating)
{
    const unsigned v = lane / KELLY_WIDTH, l = lane % KELLY_WIDTH;
    kelly_lane *const out = &block->lane[v];
    const real h = block->h;
    real sum_g = 0, sum_gc = 0, sum_gcc = 0;

    for (unsigned i = 0; i < modes->count; i++) {
        const real w = h * h * modes->w2[i], g = modes->b[i] * modes->b[i], c = block->al + block->be * w;

        load_mode(&block->mode[v][i], l, block, w, g);
        start_mode(&block->mode[v][i], l, block, w, modes->d[i] / modes->b[i], draw->w0, rotating);
        sum_g += g;
        sum_gc += g * c;
        sum_gcc += g * (c * c - w);
    }
    LANE(out->g1, l) = R(0.5) * h * sum_g;
    LANE(out->g2, l) = R(-0.25) * h * sum_gc;
    LANE(out->g3, l) = R(0.25) * h * sum_gcc;
}

static void watch(kelly_lane *lane)
{
    lane->lowest = lane->y1;
    lane->highest = lane->y1;
}

void kelly_block_load(kelly_block *block, unsigned lane, const kelly_case *run,
                      const kelly_draw *draw, const kelly_modes *modes)
{
    const unsigned l = lane % KELLY_WIDTH;
    const uint64_t step = kelly_phase_step(draw->w0, run->step_ns);
    const real half_sine = kelly_sin_turn(step / 2);
    kelly_lane *const out = &block->lane[lane / KELLY_WIDTH];
    sums sum = { .x = vsplat(0) };

    block->phase_step[lane] = step;
    LANE(out->w0, l) = draw->w0;
    LANE(out->a1, l) = draw->a1;
    LANE(out->a2, l) = draw->a2;
    LANE(out->muf_mean, l) = draw->mu * (F_OFFSET * run->f0 - draw->fc);
    LANE(out->muf_swing, l) = draw->mu * run->f0;
    LANE(out->sine_k, l) = 4 * half_sine * half_sine;
    LANE(out->sine_half, l) = R(0.5) / kelly_sin_turn(step / 2 + QUARTER_TURN);
    load_modes(block, lane, modes, draw, run->rotating);
    for (unsigned i = 0; i < block->modes; i++) {
        add_outputs(&sum, &block->mode[lane / KELLY_WIDTH][i], 1);
    }
    stage_speeds(out, &sum, block->al, block->be, 1);
    resync(block, lane);
    watch(out);
}

void kelly_block_watch(kelly_block *block)
{
    for (unsigned v = 0; v < KELLY_VECTORS; v++) {
        watch(&block->lane[v]);
    }
}

real kelly_block_speed(const kelly_block *block, unsigned lane)
{
    return LANE(block->lane[lane / KELLY_WIDTH].y1, lane % KELLY_WIDTH);
}

real kelly_block_sine(const kelly_block *block, unsigned lane)
{
    return LANE(block->lane[lane / KELLY_WIDTH].sine, lane % KELLY_WIDTH);
}

void kelly_block_extremes(const kelly_block *block, unsigned lane, real *lowest, real *highest)
{
    *lowest = LANE(block->lane[lane / KELLY_WIDTH].lowest, lane % KELLY_WIDTH);
    *highest = LANE(block->lane[lane / KELLY_WIDTH].highest, lane % KELLY_WIDTH);
}

/* Q [s units of h undone] and Q' of mode i against the drag equilibrium. */
static void scaled_state(const kelly_block *block, unsigned lane, unsigned i, real w2, real *q, real *speed)
{
    const kelly_mode *const mode = &block->mode[lane / KELLY_WIDTH][i];
    const real scale = block->h / R(6.0);
    const real xi = scale * LANE(mode->xi, lane % KELLY_WIDTH), zeta = scale * LANE(mode->zeta, lane % KELLY_WIDTH);
    const real over_h = zeta + block->be * xi;

    *q = block->h * over_h;
    *speed = xi - (block->al + block->be * (block->h * block->h * w2)) * over_h;
}

void kelly_block_modal(const kelly_block *block, unsigned lane, const kelly_modes *modes, const kelly_table *table,
                       real q[KELLY_MODES_MAX], real v[KELLY_MODES_MAX])
{
    const real w0 = LANE(block->lane[lane / KELLY_WIDTH].w0, lane % KELLY_WIDTH);

    for (unsigned i = 0; i < modes->count; i++) {
        real shifted, speed;

        scaled_state(block, lane, i, modes->w2[i], &shifted, &speed);
        q[i] = modes->b[i] * shifted - table->alpha * modes->d[i] * w0 / modes->w2[i];
        v[i] = modes->b[i] * speed;
    }
}

real kelly_block_twist(const kelly_block *block, unsigned lane, const kelly_modes *modes)
{
    real twist = 0;

    for (unsigned i = 0; i < modes->count; i++) {
        real shifted, speed;

        scaled_state(block, lane, i, modes->w2[i], &shifted, &speed);
        twist += modes->b[i] * modes->b[i] * shifted;
    }
    return twist;
}

static int sane(real x)
{
    return x > -SANE && x < SANE;   /* false for a NaN */
}

int kelly_block_sane(const kelly_block *block, unsigned lane)
{
    const unsigned v = lane / KELLY_WIDTH, l = lane % KELLY_WIDTH;
    int good = sane(LANE(block->lane[v].lowest, l)) && sane(LANE(block->lane[v].highest, l)) && sane(LANE(block->lane[v].y1, l));

    for (unsigned i = 0; i < block->modes; i++) {
        good = good && sane(LANE(block->mode[v][i].xi, l)) && sane(LANE(block->mode[v][i].zeta, l));
    }
    return good;
}
