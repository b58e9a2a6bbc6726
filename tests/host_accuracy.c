/* host_accuracy.c - the largest error of every function of detmath.h, found by sweeps over the whole range against the
 * host's long double functions. Prints the figures that detmath.h states and fails where one is exceeded.
 * The samplers are held against their formulas in double, on the same words.
 *
 * An ulp is that of the exact result in the format of the function. Exit status 1 if a budget is exceeded.
 */
#include "../firmware/detmath.h"
#include "../firmware/random.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#ifndef CHECK_LONG
#define CHECK_LONG 0                 /* 1: every float of the tanh, a minute */
#endif

typedef long double exact;

#ifdef KELLY_DOUBLE
#define DIGITS 53
#define TANH_BUDGET 6.0e-13L
#define SIN_BUDGET 1.6L
#else
#define DIGITS 24
#define TANH_BUDGET 4.5e-7L
#define SIN_BUDGET 1.6L
#endif

typedef struct {
    exact worst, at;
} tally;

static unsigned held, exceeded;    /* budgets */

static void note(tally *t, exact error, exact at)
{
    if (error != error) error = (exact)INFINITY;
    if (error > t->worst) {
        t->worst = error;
        t->at = at;
    }
}

static exact ulps(exact got, exact want, int digits)
{
    if (want == 0.0L) return got == 0.0L ? 0.0L : 1.0e9L;
    int e;
    (void)frexpl(want, &e);
    return fabsl(got - want) / ldexpl(1.0L, e - digits);
}

static void judge(int good)
{
    held += good != 0;
    exceeded += good == 0;
}

static void report(const char *name, const tally *t, const char *unit, exact budget)
{
    const int good = t->worst <= budget;
    printf("%-34s %10.4Lg %s at %.9Lg (budget %Lg)%s\n", name, t->worst, unit, t->at, budget, good ? "" : "  EXCEEDED");
    judge(!(!good));
}

static uint64_t word(void)
{
    static uint64_t state = 1;
    uint64_t z = (state += UINT64_C(0x9e3779b97f4a7c15));
    z = (z ^ z >> 30) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ z >> 27) * UINT64_C(0x94d049bb133111eb);
    return z ^ z >> 31;
}

static exact uniform(void) { return (exact)(word() >> 11) * 0x1p-53L; }

static float float_of(uint32_t bits)
{
    float f;
    memcpy(&f, &bits, sizeof f);
    return f;
}

/* ---- tanh ---- */

static tally tanh_relative, tanh_ulp, tanh_near;
static int tanh_odd = 1, tanh_bounded = 1, ratio_bounded = 1;

static void try_tanh(real w)
{
#ifdef KELLY_DOUBLE
    const exact want = tanhl((exact)w);
#else
    const exact want = (exact)tanh((double)w);      /* 29 bits more than are asked of it, and fast */
#endif
    const exact got = (exact)kelly_tanh(w);
    note(&tanh_relative, fabsl(got / want - 1.0L), (exact)w);
    note(&tanh_ulp, ulps(got, want, DIGITS), (exact)w);
    if (w < R(0.25)) note(&tanh_near, fabsl(got / want - 1.0L), (exact)w);
    tanh_odd &= kelly_tanh(-w) == -kelly_tanh(w);
    tanh_bounded &= kelly_tanh(w) <= R(1.0);
#if KELLY_WIDTH == 1
    real p, q;
    kelly_tanh_ratio(w, &p, &q);
    ratio_bounded &= p <= q;
#endif
}

static void sweep_tanh(void)
{
#ifdef KELLY_DOUBLE
    for (int i = 1; i < 4000000; i++) try_tanh((real)(20.0L * (exact)i / 4000000.0L));
    for (int i = 0; i < 2000000; i++) try_tanh((real)expl(-40.0L + 43.0L * uniform()));
#else
    for (uint32_t b = 0x30000000u; b <= 0x41a00000u; b += CHECK_LONG ? 1 : 11) try_tanh(float_of(b));   /* 5e-10 .. 20 */
    for (uint32_t b = 0x00800000u; b <= 0x30000000u; b += 997) try_tanh(float_of(b));
#endif
    report("tanh, relative", &tanh_relative, "", TANH_BUDGET);
    report("tanh, relative, |w| < 1/4", &tanh_near, "", TANH_BUDGET);
    printf("tanh is off by %.3Lg ulp at most, odd %d, |tanh| <= 1 %d; ratio p <= q %d\n", tanh_ulp.worst, tanh_odd,
           tanh_bounded, ratio_bounded);
    judge(!(!tanh_odd || !tanh_bounded));
}

/* ---- sine of a phase: the reference folds to the nearest quarter turn, the function downwards ---- */

static tally sin_ulp, sin_absolute;

static void try_sin(uint64_t phase)
{
    const exact tau = 6.283185307179586476925286766559L;
    const uint64_t k = (phase + ((uint64_t)1 << 61)) >> 62;
    const exact r = (exact)(int64_t)(phase - (k << 62)) * (tau * 0x1p-64L);
    const exact side = k & 1 ? cosl(r) : sinl(r);
    const exact want = k & 2 ? -side : side;
    const exact got = (exact)kelly_sin_turn(phase);
    if (want != 0.0L || got != 0.0L) note(&sin_ulp, ulps(got, want, DIGITS), (exact)phase * 0x1p-64L);
    note(&sin_absolute, fabsl(got - want), (exact)phase * 0x1p-64L);
}

static void sweep_sin(void)
{
    for (int i = 0; i < 6000000; i++) try_sin(word());
    for (int i = 0; i < 3000000; i++) try_sin(word() >> (word() & 63));
    for (int i = 0; i < 3000000; i++) try_sin(((word() & 7) << 61) + (word() >> (word() & 63)));
    for (int i = 0; i < 3000000; i++) try_sin(((word() & 7) << 61) - (word() >> (word() & 63)));
    for (uint64_t i = 0; i < 4096; i++)
        for (uint64_t q = 0; q < 8; q++) {
            try_sin((q << 61) + i);
            try_sin((q << 61) - i);
        }
    report("sine of a phase", &sin_ulp, "ulp", SIN_BUDGET);
    report("sine of a phase, absolute", &sin_absolute, "", SIN_BUDGET * powl(2.0L, -DIGITS));
}

/* ---- phase per step ---- */

static void sweep_phase(void)
{
    tally t = {0, 0};
    for (int i = 0; i < 3000000; i++) {
        const real w = (real)expl(-9.0L + 22.0L * uniform());
        const uint32_t step = (uint32_t)expl(logl(1000.0L) + logl(1.0e6L) * uniform());
        const exact turns = (exact)w * (exact)step / (6.283185307179586476925286766559L * 1.0e9L);
        if (turns >= 1.0L) continue;
        const exact want = turns * 0x1p64L, error = fabsl((exact)kelly_phase_step(w, step) - want);
        note(&t, (error > 0.51L ? error - 0.51L : 0.0L) / want, (exact)w);
    }
    report("phase per step, past 1/2 unit", &t, "", 0x1p-49L);
}

/* ---- square root and logarithm in float ---- */

static void sweep_root(void)
{
    unsigned wrong = 0;
    for (uint32_t b = 0; b < 0x7f800000u; b += 29)
        wrong += kelly_sqrt32_integer(float_of(b)) != sqrtf(float_of(b)) || kelly_sqrt32(float_of(b)) != sqrtf(float_of(b));
    for (uint32_t b = 0; b < 0x1000000u; b += 1)                      /* all subnormals and the first normals */
        wrong += kelly_sqrt32_integer(float_of(b)) != sqrtf(float_of(b));
    for (uint32_t b = 0x3f800000u; b < 0x40800000u; b++)              /* every significand, both parities: 1 <= x < 4 */
        wrong += kelly_sqrt32_integer(float_of(b)) != sqrtf(float_of(b));
    printf("square root, integer form          %u differ from the exact rounding\n", wrong);
    judge(!(wrong != 0));
}

static void sweep_log32(void)
{
    tally t = {0, 0}, near = {0, 0};
    for (uint32_t b = 0x00800000u; b < 0x7f800000u; b += 101)
        note(&t, ulps((exact)kelly_log32(float_of(b)), logl((exact)float_of(b)), 24), (exact)float_of(b));
    for (uint32_t b = 0x3f000000u; b < 0x40000000u; b++)              /* every float of 1/2 .. 2 */
        note(&near, ulps((exact)kelly_log32(float_of(b)), logl((exact)float_of(b)), 24), (exact)float_of(b));
    report("log32, normal floats", &t, "ulp", 1.0L);
    report("log32, 1/2 .. 2", &near, "ulp", 1.0L);
}

/* ---- log and exp of the statistics; in double on a hosted build, in float on a freestanding one ---- */

static void sweep_wide(void)
{
    const int digits = sizeof(wide) == 8 ? 53 : 24;
    const exact end = (exact)KELLY_EXP_END;
    tally l = {0, 0}, e = {0, 0};
    for (int i = 0; i < 4000000; i++) {
        const wide x = (wide)expl(i & 1 ? end * (2.0L * uniform() - 1.0L) : 0.8L * (2.0L * uniform() - 1.0L));
        note(&l, ulps((exact)kelly_log(x), logl((exact)x), digits), (exact)x);
        const wide y = (wide)(i & 1 ? end * (2.0L * uniform() - 1.0L) : expl(-40.0L * uniform()) * (i & 2 ? 1.0L : -1.0L));
        note(&e, ulps((exact)kelly_exp(y), expl((exact)y), digits), (exact)y);
    }
    printf("wide has %d digits\n", digits);
    report("log", &l, "ulp", 1.0L);
    report("exp", &e, "ulp", 1.1L);
}

/* ---- gamma: the same words through Marsaglia and Tsang's test as they print it, in double ---- */

static double plain_gamma(kelly_rng *rng, double mean, double cov)
{
    const double d = 1.0 / (cov * cov) - 1.0 / 3.0;
    for (;;) {
        const double x = (double)kelly_normal(rng), u = (double)kelly_open01(kelly_rng_next(rng));
        const double base = 1.0 + x / (3.0 * sqrt(d)), v = base * base * base;
        if (base > 0.0 && log(u) < 0.5 * x * x + d - d * v + d * log(v)) return mean * cov * cov * d * v;
    }
}

static void sweep_gamma(void)
{
    static const float covs[] = {0.001f, 0.05f, 0.2f, 0.35f, 0.5f};
    for (int k = 0; k < 5; k++) {
        tally t = {0, 0};
        unsigned other = 0;
        for (uint32_t i = 0; i < 500000; i++) {
            kelly_rng a, b;
            kelly_rng_key(&a, 3, i, (uint32_t)k);
            b = a;
            const double want = plain_gamma(&b, 10.0, (double)covs[k]);
            const double got = (double)kelly_gamma(&a, 10.0f, covs[k]);
            if (a.s[0] != b.s[0]) other++;                       /* another try was accepted */
            else note(&t, (exact)fabs(got / want - 1.0), (exact)want);
        }
        printf("gamma, cov %-5g %u of 500000 decided otherwise (budget 5)%s\n", (double)covs[k], other,
               other > 5 ? "  EXCEEDED" : "");
        judge(!(other > 5));
        report("gamma, relative", &t, "", 2.0e-6L);
    }
}

int main(void)
{
    sweep_gamma();
    sweep_tanh();
    sweep_sin();
    sweep_phase();
    sweep_root();
    sweep_log32();
    sweep_wide();
    printf("%u passed, %u failed\n", held, exceeded);
    return exceeded != 0;
}
