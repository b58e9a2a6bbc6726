/* drive.c - the stepping of drive.h. Set-up and reading are in drive_block.c. */
#include "bitrock.h"
#include "drive.h"

#define QUARTER_TURN ((uint64_t)1 << 62)

#if defined(__clang__)
#define UNROLL _Pragma("unroll")
#elif defined(__GNUC__)
#define UNROLL _Pragma("GCC unroll 16")
#else
#define UNROLL
#endif

/* One stage of a step: what goes in, and the torque, eta' and u that come out. */
typedef struct {
    vreal eta, phi, y, p, sine;
    vreal t, slope, u;
} stage;

/* Sums over the modes of g v, g v', g v'', g v''' and of k x, k v, k v', k v'', k v''', torque-free. */
typedef struct {
    vreal y0, y1, y2, y3;
    vreal p0, p1, p2, p3, p4;
} sums;

/* S_0 .. S_3 of one input. */
typedef struct {
    vreal s0, s1, s2, s3;
} impulses;

/* sin a and 1 - cos a of |a| <= KELLY_TURN, within 2e-11 (float: half an ulp). */
KELLY_SHARED void small_angle(vreal a, vreal *sine, vreal *versine)
{
    const vreal u = a * a;
#ifdef KELLY_DOUBLE
    const vreal s = u * (R(1.0) / R(6.0) - u * (R(1.0) / R(120.0) - u * (R(1.0) / R(5040.0))));
    const vreal c = R(0.5) - u * (R(1.0) / R(24.0) - u * (R(1.0) / R(720.0) - u * (R(1.0) / R(40320.0))));
#else
    const vreal s = u * (R(1.0) / R(6.0) - u * (R(1.0) / R(120.0)));
    const vreal c = R(0.5) - u * (R(1.0) / R(24.0) - u * (R(1.0) / R(720.0)));
#endif
    *sine = a - a * s;
    *versine = u * c;
}

/* sin(theta_top + a). */
KELLY_INLINE vreal sine_after(const kelly_driven_lane *on, vreal a)
{
    vreal sine, versine;

    small_angle(a, &sine, &versine);
    return on->sine + (on->cosine * sine - on->sine * versine);
}

KELLY_INLINE void turn(kelly_driven_lane *on, vreal a, vbits *changed)
{
    const vreal s = vtake(&on->sine, changed), c = vtake(&on->cosine, changed);
    vreal sine, versine;

    small_angle(a, &sine, &versine);
    vput(&on->sine, s + (c * sine - s * versine), changed);
    vput(&on->cosine, c - (s * sine + c * versine), changed);
}

/* Torque of the bit and slope of the top. */
KELLY_SHARED void respond(const kelly_driven_lane *on, stage *s, real alpha)
{
    const vreal muf = vmin(on->muf_mean + on->muf_swing * s->sine, vsplat(0));
    vreal push;

    s->t = kelly_bit_torque((on->w_ref + s->eta) + s->y, muf, on->a1, on->a2);
    push = ((on->rest * s->t + s->p) - on->drag) - (on->k_speed * s->eta + on->k_angle * s->phi);
    s->slope = on->slope + on->gain * push;
    s->u = s->slope + alpha * s->eta;
}

/* Speed, angle and weight of a stage that the slope and the speed of `from` lead to in the time dt. */
KELLY_SHARED void reach(const kelly_driven_lane *on, stage *s, const stage *from, real dt)
{
    s->eta = on->eta + dt * from->slope;
    s->phi = on->phi + dt * (from->eta - on->counted);
    s->sine = sine_after(on, dt * (on->w_ref + from->eta));
}

KELLY_SHARED vreal echo(const kelly_output *o, unsigned k, const stage *s)
{
    return o->of_t[k] * s->t + o->of_u[k] * s->u;
}

KELLY_INLINE void first(const kelly_driven_lane *on, stage *s, real alpha)
{
    s->eta = on->eta;
    s->phi = on->phi;
    s->sine = on->sine;
    s->y = on->y.at[0];
    s->p = on->p.at[0];
    respond(on, s, alpha);
}

KELLY_INLINE void second(const kelly_driven_lane *on, stage s[4], real h, real alpha)
{
    reach(on, &s[1], &s[0], R(0.5) * h);
    s[1].y = on->y.at[1] + echo(&on->y, 0, &s[0]);
    s[1].p = on->p.at[1] + echo(&on->p, 0, &s[0]);
    respond(on, &s[1], alpha);
}

KELLY_INLINE void third(const kelly_driven_lane *on, stage s[4], real h, real alpha)
{
    reach(on, &s[2], &s[1], R(0.5) * h);
    s[2].y = on->y.at[2] + (echo(&on->y, 1, &s[0]) + echo(&on->y, 0, &s[1]));
    s[2].p = on->p.at[2] + (echo(&on->p, 1, &s[0]) + echo(&on->p, 0, &s[1]));
    respond(on, &s[2], alpha);
}

KELLY_INLINE void fourth(const kelly_driven_lane *on, stage s[4], real h, real alpha)
{
    reach(on, &s[3], &s[2], h);
    s[3].y = on->y.at[3] + (echo(&on->y, 2, &s[0]) + R(2.0) * (echo(&on->y, 1, &s[1]) + echo(&on->y, 0, &s[2])));
    s[3].p = on->p.at[3] + (echo(&on->p, 2, &s[0]) + R(2.0) * (echo(&on->p, 1, &s[1]) + echo(&on->p, 0, &s[2])));
    respond(on, &s[3], alpha);
}

KELLY_SHARED impulses impulses_of(vreal f1, vreal f2, vreal f3, vreal f4, real h)
{
    const real sixth = h / R(6.0);
    const vreal f12 = f1 + f2, f123 = f12 + f3;
    impulses s;

    s.s0 = sixth * (f123 + (f2 + f3) + f4);
    s.s1 = sixth * f123;
    s.s2 = (R(0.5) * sixth) * f12;
    s.s3 = (R(0.25) * sixth) * f1;
    return s;
}

/* (v, x) <- (v, x) + D (v, x) + the impulses, by Horner's rule in A. */
KELLY_INLINE void move(kelly_driven_mode *m, const impulses *t, const impulses *u)
{
    const vreal s0 = t->s0 - m->r * u->s0, s1 = t->s1 - m->r * u->s1, s2 = t->s2 - m->r * u->s2, s3 = t->s3 - m->r * u->s3;
    const vreal z = s2 - m->c * s3, x1 = (s1 - m->c * z) - m->w * s3, v1 = (s0 - m->c * x1) - m->w * z;
    const vreal v = m->v, x = m->x;

    m->v = v + ((m->d00 * v + m->d01 * x) + v1);
    m->x = x + ((m->d10 * v + m->d11 * x) + x1);
}

KELLY_INLINE void add_outputs(sums *sum, const kelly_driven_mode *m)
{
    const vreal v1 = -(m->c * m->v + m->w * m->x);
    const vreal v2 = -(m->c * v1 + m->w * m->v);
    const vreal v3 = -(m->c * v2 + m->w * v1);

    sum->y0 = sum->y0 + m->g * m->v;
    sum->y1 = sum->y1 + m->g * v1;
    sum->y2 = sum->y2 + m->g * v2;
    sum->y3 = sum->y3 + m->g * v3;
    sum->p0 = sum->p0 + m->k * m->x;
    sum->p1 = sum->p1 + m->k * m->v;
    sum->p2 = sum->p2 + m->k * v1;
    sum->p3 = sum->p3 + m->k * v2;
    sum->p4 = sum->p4 + m->k * v3;
}

/* An output at the four stages from its value and its first three derivatives. */
KELLY_SHARED void stages_of(vreal at[4], vreal o0, vreal o1, vreal o2, vreal o3, vbits *guard)
{
    const vreal midway = o0 + R(0.5) * o1;

    vput(&at[0], o0, guard);
    vput(&at[1], midway, guard);
    vput(&at[2], midway + R(0.25) * o2, guard);
    vput(&at[3], (o0 + o1) + (R(0.5) * o2 + R(0.25) * o3), guard);
}

/* What the next step starts from, out of the sums. */
KELLY_SHARED void look_ahead(kelly_driven_lane *on, const sums *sum, real be, vbits *guard)
{
    stages_of(on->y.at, sum->y0, sum->y1, sum->y2, sum->y3, guard);
    stages_of(on->p.at, sum->p0 + be * sum->p1, sum->p1 + be * sum->p2, sum->p2 + be * sum->p3, sum->p3 + be * sum->p4, guard);
    vput(&on->speed, (on->w_ref + on->eta) + sum->y0, guard);
}

/* RK4 of the top itself. */
KELLY_INLINE void move_top(kelly_driven_lane *on, const stage s[4], real h, vbits *guard)
{
    const real sixth = h / R(6.0);
    const vreal gained = sixth * ((s[0].eta + s[3].eta) + R(2.0) * (s[1].eta + s[2].eta));
    const vreal phi = vtake(&on->phi, guard), eta = vtake(&on->eta, guard);

    turn(on, h * on->w_ref + gained, guard);
    vput(&on->phi, phi + (gained - h * on->counted), guard);
    vput(&on->eta, eta + sixth * ((s[0].slope + s[3].slope) + R(2.0) * (s[1].slope + s[2].slope)), guard);
    for (unsigned k = 0; k < 4; k++) {
        on->sines[k] = s[k].sine;
    }
}

KELLY_INLINE void finish(kelly_driven_lane *on, kelly_driven_mode *mode, unsigned modes, const stage s[4], real h, real be)
{
    const impulses t = impulses_of(s[0].t, s[1].t, s[2].t, s[3].t, h), u = impulses_of(s[0].u, s[1].u, s[2].u, s[3].u, h);
    sums sum = { .y0 = vsplat(0) };
    vbits changed = { 0 };
    vreal lowest, highest;

    for (unsigned k = 0; k < 4; k++) {
        (void)vtake(&on->y.at[k], &changed);
        (void)vtake(&on->p.at[k], &changed);
    }
    (void)vtake(&on->speed, &changed);
    for (unsigned i = 0; i < modes; i++) {
        kelly_driven_mode now = mode[i];

        now.v = vtake(&mode[i].v, &changed);
        now.x = vtake(&mode[i].x, &changed);
        move(&now, &t, &u);
        vput(&mode[i].v, now.v, &changed);
        vput(&mode[i].x, now.x, &changed);
        add_outputs(&sum, &now);
    }
    move_top(on, s, h, &changed);
    look_ahead(on, &sum, be, &changed);
    lowest = vtake(&on->lowest, &changed);
    highest = vtake(&on->highest, &changed);
    vput(&on->lowest, vmin(on->speed, lowest), &changed);
    vput(&on->highest, vmax(on->speed, highest), &changed);
    vguard(&on->guard, changed);
}

/* Advance `vectors` vectors, a compile-time constant, stage by stage, as in integrator.c. */
KELLY_INLINE void steps(kelly_driven *driven, uint32_t ticks, const unsigned vectors)
{
    const real h = driven->h, alpha = driven->alpha;

    for (; ticks > 0; ticks--) {
        stage at[KELLY_VECTORS][4];
        kelly_driven_lane *const on = driven->lane;

        UNROLL
        for (unsigned v = 0; v < vectors; v++) {
            first(&on[v], &at[v][0], alpha);
        }
        UNROLL
        for (unsigned v = 0; v < vectors; v++) {
            second(&on[v], at[v], h, alpha);
        }
        UNROLL
        for (unsigned v = 0; v < vectors; v++) {
            third(&on[v], at[v], h, alpha);
        }
        UNROLL
        for (unsigned v = 0; v < vectors; v++) {
            fourth(&on[v], at[v], h, alpha);
        }
        UNROLL
        for (unsigned v = 0; v < vectors; v++) {
            finish(&on[v], driven->mode[v], driven->modes, at[v], h, driven->be);
        }
    }
}

/* One loop for each number of vectors in use, so that the compiler can keep them all in flight. */
static void advance(kelly_driven *driven, uint32_t ticks)
{
#define WITH(n) \
    case n: \
        steps(driven, ticks, n); \
        break;
    switch (driven->vectors) {
    KELLY_EACH_COUNT(WITH)
    default:
        break;
    }
#undef WITH
}

void kelly_driven_outputs(kelly_driven *driven, unsigned lane)
{
    const unsigned vector = lane / KELLY_WIDTH;
    sums sum = { .y0 = vsplat(0) };

    kelly_driven_lane *const on = &driven->lane[vector];

    for (unsigned i = 0; i < driven->modes; i++) {
        add_outputs(&sum, &driven->mode[vector][i]);
    }
    for (unsigned k = 0; k < 4; k++) {
        (void)vtake(&on->y.at[k], &on->guard);
        (void)vtake(&on->p.at[k], &on->guard);
    }
    (void)vtake(&on->speed, &on->guard);
    look_ahead(on, &sum, driven->be, &on->guard);
}

/* Of theta_top. */
static uint64_t phase_of(const kelly_driven *driven, unsigned lane)
{
    return driven->phase[lane] + kelly_turns(LANE(driven->lane[lane / KELLY_WIDTH].phi, lane % KELLY_WIDTH), 1000000000u);
}

/* A commanded top's phi goes into the integer phase, where it does not grow; the drive's is its integral, and stays. */
void kelly_driven_resync(kelly_driven *driven, unsigned lane)
{
    kelly_driven_lane *const on = &driven->lane[lane / KELLY_WIDTH];
    const unsigned l = lane % KELLY_WIDTH;
    const uint64_t phase = phase_of(driven, lane);

    vput_lane(&on->sine, l, kelly_sin_turn(phase), &on->guard);
    vput_lane(&on->cosine, l, kelly_sin_turn(phase + QUARTER_TURN), &on->guard);
    if (!(LANE(on->gain, l) > 0)) {
        kelly_driven_put_phase(driven, lane, phase);
        vput_lane(&on->phi, l, 0, &on->guard);
    }
}

/* Whether sine or cosine is further from that of theta_top than rounding leads. A NaN in them would not be seen otherwise. */
int kelly_driven_strays(const kelly_driven *driven, unsigned lane)
{
    const kelly_driven_lane *const on = &driven->lane[lane / KELLY_WIDTH];
    const unsigned l = lane % KELLY_WIDTH;
    const uint64_t phase = phase_of(driven, lane);
    const real sine = LANE(on->sine, l) - kelly_sin_turn(phase), cosine = LANE(on->cosine, l) - kelly_sin_turn(phase + QUARTER_TURN);

    return !(KELLY_ABS(sine) <= KELLY_STRAY && KELLY_ABS(cosine) <= KELLY_STRAY);
}

void kelly_driven_advance(kelly_driven *driven, uint32_t ticks)
{
    while (ticks > 0 && driven->vectors <= KELLY_VECTORS && driven->modes <= KELLY_MODES_MAX) {
        const uint32_t since = driven->tick % KELLY_RESYNC;
        const uint32_t part = ticks < KELLY_RESYNC - since ? ticks : KELLY_RESYNC - since;

        for (unsigned lane = 0; since == 0 && lane < driven->vectors * KELLY_WIDTH; lane++) {
            driven->strayed[lane] |= (uint8_t)(driven->tick > 0 && kelly_driven_strays(driven, lane));
            kelly_driven_resync(driven, lane);
        }
        advance(driven, part);
        for (unsigned lane = 0; lane < driven->vectors * KELLY_WIDTH; lane++) {
            kelly_driven_put_phase(driven, lane, driven->phase[lane] + driven->phase_step[lane] * part);
        }
        driven->tick += part;
        ticks -= part;
    }
}
