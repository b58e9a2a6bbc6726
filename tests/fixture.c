#include "fixture.h"

fixture_memory fixture;

void fixture_case(kelly_case *run, uint32_t ticks)
{
    *run = kelly_string.nominal;
    for (unsigned k = 0; k < KELLY_PARAMETERS; k++) {
        run->cov[k] = 0.0f;
    }
    run->ticks = ticks;
    run->window_first = ticks / 2;
    run->window_last = ticks;
}

real fixture_endless(void)
{
    volatile real x = R(1e30);

    for (unsigned i = 0; i < 5; i++) {
        x = x * x;
    }
    return x;
}

uint64_t fixture_bits(real x)
{
#ifdef KELLY_DOUBLE
    return (union { real x; uint64_t bits; }){ .x = x }.bits;
#else
    return (union { real x; uint32_t bits; }){ .x = x }.bits;
#endif
}

void fixture_put(real *at, vbits *guard, real value)
{
    *guard ^= vbits_of(*at) ^ vbits_of(value);
    *at = value;
}

static int same(real a, real b)
{
    return fixture_bits(a) == fixture_bits(b);
}

int fixture_same(const kelly_result *a, const kelly_result *b)
{
    const kelly_draw *const x = &a->draw, *const y = &b->draw;

    return same(x->fc, y->fc) && same(x->mu, y->mu) && same(x->a1, y->a1) && same(x->a2, y->a2) && same(x->w0, y->w0) &&
           same(a->lowest, b->lowest) && same(a->highest, b->highest) && same(a->mean, b->mean) && same(a->ss, b->ss) &&
           a->status == b->status && a->stuck == b->stuck && a->liftoff == b->liftoff;
}

wide fixture_abs(wide x)
{
    return x < 0 ? -x : x;
}

/* w_i = 30 + 60 i rad/s, one weight on the bit: at 2 ms the fastest mode has h w = 2.34, far from negligible. */
#define W2(i) (R(30.0) + R(60.0) * i) * (R(30.0) + R(60.0) * i)
static const real fast_w2[KELLY_MODES_MAX] = { W2(0), W2(1), W2(2), W2(3), W2(4), W2(5), W2(6), W2(7), W2(8), W2(9),
                                               W2(10), W2(11), W2(12), W2(13), W2(14), W2(15), W2(16), W2(17), W2(18), W2(19) };
static const real fast_b[KELLY_MODES_MAX] = {
    R(0.08), R(0.08), R(0.08), R(0.08), R(0.08), R(0.08), R(0.08), R(0.08), R(0.08), R(0.08),
    R(0.08), R(0.08), R(0.08), R(0.08), R(0.08), R(0.08), R(0.08), R(0.08), R(0.08), R(0.08) };
static const real fast_d[KELLY_MODES_MAX] = {
    R(10.0), R(-3.0), R(2.0), R(-1.5), R(1.0), R(-0.8), R(0.7), R(-0.6), R(0.5), R(-0.4),
    R(0.4), R(-0.3), R(0.3), R(-0.3), R(0.2), R(-0.2), R(0.2), R(-0.2), R(0.2), R(-0.2) };
static const real rigid_w2[1] = { 0 }, rigid_b[1] = { R(0.004) };

const kelly_table fixture_fast = {
    .schema = KELLY_SCHEMA, .real_bytes = sizeof(real), .id = "fast", .torsional = KELLY_MODES_MAX, .axial = 1, .degree = 0, .nodes = 2,
    .fc_min = R(1000.0), .fc_max = R(1000000.0), .fc_mid = R(500500.0), .fc_scale = R(2.002002e-6),
    .alpha = R(0.1), .beta = R(8e-5), .inertia = R(200.0),
    .w2 = fast_w2, .b = fast_b, .d = fast_d, .axial_w2 = rigid_w2, .axial_b = rigid_b,
    .free_w2 = fast_w2, .axial_free_w2 = rigid_w2,
};
