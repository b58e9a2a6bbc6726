/* test_detmath.c - claims about detmath.h that every machine must confirm. The largest errors over whole ranges are found
 * by host_accuracy.c; here are known values (50-digit arithmetic), exact properties, and one digest a function over a
 * sweep, which is the same number on every machine. */
#include "../firmware/detmath.h"
#include "check.h"

void test_detmath(void);

typedef union { real value;
#ifdef KELLY_DOUBLE
    uint64_t bits;
#else
    uint32_t bits;
#endif
} bits_of_real;
typedef union { float value; uint32_t bits; } bits_of_float;

#ifdef KELLY_DOUBLE
#define ULP 0x1p-53                  /* half the distance of numbers above 1 */
#define TANH_ERROR R(6.0e-13)
#define GOLDEN(single, twofold) (twofold)
#else
#define ULP 0x1p-24f
#define TANH_ERROR R(4.5e-7)
#define GOLDEN(single, twofold) (single)
#endif
#define SWEEP (CHECK_LONG ? 1000000u : 2000u)

static uint64_t fold(uint64_t digest, uint64_t bits)
{
    for (int i = 0; i < 64; i += 32) digest = (digest ^ (uint32_t)(bits >> i)) * UINT64_C(0x100000001b3);
    return digest;
}

static uint64_t fold_real(uint64_t digest, real x) { return fold(digest, (bits_of_real){.value = x}.bits); }
static uint64_t fold_float(uint64_t digest, float x) { return fold(digest, (bits_of_float){.value = x}.bits); }
static real size(real x) { return x < R(0.0) ? -x : x; }

static void tanh_has_known_values(void)
{
    static const real known[][2] = {
        {R(1e-30), R(1e-30)},
        {R(1e-4), R(0.000099999999666666668)},
        {R(0.125), R(0.12435300177159620805)},
        {R(0.5), R(0.4621171572600097585)},
        {R(1.0), R(0.76159415595576488812)},
        {R(1.75), R(0.94137553849728736227)},
        {R(2.5), R(0.98661429815143028888)},
        {R(4.0), R(0.99932929973906704379)},
        {R(6.0), R(0.99998771165079557056)},
        {R(8.0), R(0.99999977492967588981)},
        {R(12.0), R(0.99999999992449730912)},
        {R(1e6), R(1.0)},
    };
    for (size_t i = 0; i < sizeof known / sizeof known[0]; i++)
        CLOSE(kelly_tanh(known[i][0]) / known[i][1], R(1.0), TANH_ERROR);
}

static void tanh_is_odd_bounded_and_rises(void)
{
    unsigned odd = 0, bounded = 0, rises = 0;
    real before = R(0.0);
    for (uint32_t i = 1; i <= SWEEP; i++) {
        const real w = R(20.0) * (real)(int32_t)i / (real)(int32_t)SWEEP, t = kelly_tanh(w);
        odd += kelly_tanh(-w) == -t;
        bounded += t > R(0.0) && t <= R(1.0);
        rises += t >= before - R(2.0) * TANH_ERROR;
        before = t;
    }
    EQUAL(odd, SWEEP);
    EQUAL(bounded, SWEEP);
    EQUAL(rises, SWEEP);
    CHECK(kelly_tanh(R(0.0)) == R(0.0));
    CHECK(kelly_tanh(R(1e30)) == kelly_tanh(KELLY_TANH_END));
}

static void lanes_agree_with_scalars(void)
{
    vreal w = vsplat(R(0.0)), p, q;
    for (int i = 0; i < 200; i++) {
        for (int l = 0; l < KELLY_WIDTH; l++) LANE(w, l) = R(0.0625) * (real)(i - 100) * (real)(l + 1);
        kelly_tanh_ratio(w, &p, &q);
        int same = 1;
        for (int l = 0; l < KELLY_WIDTH; l++) {
            const real t = LANE(p, l) / LANE(q, l), one = kelly_tanh(LANE(w, l));
            same &= t == one || (size(one) == R(1.0) && size(t) <= R(1.0) + R(4.0) * ULP);
        }
        if (!same || i == 199) CHECK(same);
    }
}

static void clamp_holds_lanes_and_keeps_a_nan(void)
{
    const float infinity = (bits_of_float){.bits = 0x7f800000u}.value;
    const vreal nan = vsplat((real)(infinity - infinity)), high = vsplat((real)infinity);
    const vreal out = vclamp(nan, R(8.0)), top = vclamp(high, R(8.0)), low = vclamp(-high, R(8.0));
    for (int l = 0; l < KELLY_WIDTH; l++) {
        CHECK(!(LANE(out, l) == LANE(out, l)));
        CHECK(LANE(top, l) == R(8.0) && LANE(low, l) == R(-8.0));
    }
    vreal zero = vsplat(R(-0.0));
    CHECK((bits_of_float){.value = (float)LANE(zero, KELLY_WIDTH - 1)}.bits == 0x80000000u);
}

static void sine_has_known_values(void)
{
    static const struct { uint64_t phase; real sine; } known[] = {
        {UINT64_C(0x0123456789abcdef), R(0.027921638723568879989)},
        {UINT64_C(0x1555555555555555), R(0.4999999999999999999)},
        {UINT64_C(0x3000000000000000), R(0.92387953251128675613)},
        {UINT64_C(0x5555555555555555), R(0.86602540378443864682)},
        {UINT64_C(0x9abcdef012345678), R(-0.61014514412006477217)},
        {UINT64_C(0xfffffffffffffffe), R(-6.8122431601731091787e-19)},
        {UINT64_C(0x0000000000000010), R(5.4497945281384873429e-18)},
        {UINT64_C(0x7fffffffffff0000), R(2.2322358387255244157e-14)},
    };
    for (size_t i = 0; i < sizeof known / sizeof known[0]; i++)
        CLOSE(kelly_sin_turn(known[i].phase) / known[i].sine, R(1.0), R(4.0) * ULP);
    CHECK(kelly_sin_turn(0) == R(0.0));
    CHECK(kelly_sin_turn(UINT64_C(1) << 62) == R(1.0));
    CHECK(kelly_sin_turn(UINT64_C(1) << 63) == R(0.0));
    CHECK(kelly_sin_turn(UINT64_C(3) << 62) == R(-1.0));
}

static void sine_is_symmetric(void)
{
    const uint64_t half = UINT64_C(1) << 63, quarter = UINT64_C(1) << 62;
    unsigned odd = 0, mirrored = 0, opposite = 0, unit = 0;
    for (uint32_t i = 1; i <= SWEEP; i++) {
        const uint64_t phase = i * UINT64_C(0x9e3779b97f4a7c15);
        const real s = kelly_sin_turn(phase), c = kelly_sin_turn(phase + quarter);
        odd += kelly_sin_turn(0 - phase) == -s;
        mirrored += kelly_sin_turn(half - phase) == s;
        opposite += kelly_sin_turn(half + phase) == -s;
        unit += size(s * s + c * c - R(1.0)) <= R(6.0) * ULP;
    }
    EQUAL(odd, SWEEP);
    EQUAL(mirrored, SWEEP);
    EQUAL(opposite, SWEEP);
    EQUAL(unit, SWEEP);
}

static void phase_steps_are_exact(void)
{
    static const struct { real w; uint32_t step_ns; uint64_t phase; } known[] = {
        {R(10.46875), 1000u, UINT64_C(0x1bf412f04479)},
        {R(10.46875), 1000000u, UINT64_C(0x6d3169fa8b7a6a)},
        {R(10.46875), 4294967295u, UINT64_C(0x27f476d313ceefed)},       /* 7.16 turns */
        {R(7.125), 1000u, UINT64_C(0x1306671009ec)},
        {R(7.125), 500000u, UINT64_C(0x2528814b536171)},
        {R(7.125), 1000000000u, UINT64_C(0x224c721c7b6945b3)},
        {R(0.0078125), 1000u, UINT64_C(0x557216bcd)},
        {R(286.5), 1000000u, UINT64_C(0xbac4dab73e0b767)},
        {R(1048575.0), 1000u, UINT64_C(0x2ab908b2d66a1e94)},
        {R(1048575.0), 1000000u, UINT64_C(0xe2c9fa958e877269)},         /* 166.9 turns */
    };
    for (size_t i = 0; i < sizeof known / sizeof known[0]; i++) {
        const uint64_t got = kelly_phase_step(known[i].w, known[i].step_ns), want = known[i].phase;
        CHECK((got > want ? got - want : want - got) <= (want >> 49) + 1);
    }
    EQUAL(kelly_phase_step(R(0.0), 1000000u), 0);
    EQUAL(kelly_phase_step(R(-5.0), 1000000u), 0);
    EQUAL(kelly_phase_step(R(5.0), 0), 0);
    EQUAL(kelly_phase_step(R(1e-30), 1000u), 0);
}

static void logarithms_have_known_values(void)
{
    static const struct { float x; wide log; } known[] = {
        {0x1p-13f, W(-9.0109133472792890224)},
        {0.5625f, W(-0.57536414490356185488)},
        {0.75f, W(-0.28768207245178092744)},
        {0.984375f, W(-0.015748356968139168608)},
        {1.015625f, W(0.015504186535965254151)},
        {1.375f, W(0.31845373111853461581)},
        {10.0f, W(2.302585092994045684)},
        {1024.0f, W(6.9314718055994530942)},
        {1e10f, W(23.02585092994045684)},
    };
    const wide wide_ulp = sizeof(wide) == 8 ? (wide)0x1p-53f : (wide)0x1p-24f;
    for (size_t i = 0; i < sizeof known / sizeof known[0]; i++) {
        CLOSE((wide)kelly_log32(known[i].x) / known[i].log, W(1.0), W(2.0) * (wide)0x1p-24f);
        CLOSE(kelly_log((wide)known[i].x) / known[i].log, W(1.0), W(2.0) * wide_ulp);
    }
    CHECK(kelly_log32(1.0f) == 0.0f);
    CHECK(kelly_log(W(1.0)) == W(0.0));
}

static void roots_are_exact(void)
{
    unsigned squares = 0, same = 0;
    for (uint32_t n = 0; n < 4096; n++) squares += kelly_sqrt32_integer((float)(int32_t)(n * n)) == (float)(int32_t)n;
    for (uint32_t i = 0; i < SWEEP; i++) {
        const float x = (bits_of_float){.bits = (uint32_t)(((uint64_t)0x7f800000u * i) / SWEEP)}.value;
        same += kelly_sqrt32_integer(x) == kelly_sqrt32(x);
    }
    EQUAL(squares, 4096);
    EQUAL(same, SWEEP);
    CHECK(kelly_sqrt32_integer(2.0f) == 0x1.6a09e6p0f);
    CHECK(kelly_sqrt32_integer(3.0f) == 0x1.bb67aep0f);
    CHECK(kelly_sqrt32_integer(0x1.fffffep-1f) == 0x1.fffffep-1f);
    CHECK(kelly_sqrt32_integer(0x1.000002p0f) == 1.0f);
    CHECK(kelly_sqrt32_integer(0x1.fffffep127f) == 0x1.fffffep63f);
    CHECK(kelly_sqrt32_integer(0x1p-149f) == 0x1.6a09e6p-75f);
    CHECK(kelly_sqrt32_integer(0x1p-148f) == 0x1p-74f);
    CHECK(kelly_sqrt32_integer((bits_of_float){.bits = 0x7f800000u}.value) == (bits_of_float){.bits = 0x7f800000u}.value);   /* infinity */
}

static void exponentials_have_known_values(void)
{
    static const wide known[][2] = {
        {W(-80.0), W(1.8048513878454151723e-35)}, {W(-20.5), W(1.2501528663867426289e-9)},
        {W(-1.0), W(0.3678794411714423216)},      {W(-0.015625), W(0.98449643700540840599)},
        {W(0.25), W(1.2840254166877414841)},      {W(1.0), W(2.7182818284590452354)},
        {W(10.0), W(22026.465794806716517)},      {W(80.0), W(5.5406223843935100526e+34)},
    };
    const wide wide_ulp = sizeof(wide) == 8 ? (wide)0x1p-53f : (wide)0x1p-24f;
    for (size_t i = 0; i < sizeof known / sizeof known[0]; i++)
        CLOSE(kelly_exp(known[i][0]) / known[i][1], W(1.0), W(3.0) * wide_ulp);
    CHECK(kelly_exp(W(0.0)) == W(1.0));
    CHECK(kelly_exp(-KELLY_EXP_END) > W(0.0));
    CHECK(kelly_exp(-KELLY_EXP_END - W(1.0)) == W(0.0));
    CHECK(kelly_exp(W(-3.0) * KELLY_EXP_END) == W(0.0));
    CHECK(kelly_exp(KELLY_EXP_END + W(1.0)) == kelly_exp(KELLY_EXP_END));
    const wide none = kelly_exp((wide)CHECK_NAN);
    CHECK(none != none);
}

/* The numbers say nothing by themselves: every compiler, level and machine must give them. */
static void bits_are_the_same_everywhere(void)
{
    uint64_t tanh = 0, sine = 0, phase = 0, logs = 0, roots = 0;
    for (uint32_t i = 1; i <= 2000; i++) {
        const real w = R(0.01) * (real)(int32_t)i;
        const float x = (bits_of_float){.bits = i * 1000003u}.value;
        tanh = fold_real(tanh, kelly_tanh(w));
        sine = fold_real(sine, kelly_sin_turn(i * UINT64_C(0x9e3779b97f4a7c15) >> (i & 31)));
        phase = fold(phase, kelly_phase_step(w, 1000u * i));
        if (i * 1000003u >= 0x00800000u && i * 1000003u < 0x7f800000u) logs = fold_float(logs, kelly_log32(x));
        if (i * 1000003u < 0x7f800000u) roots = fold_float(roots, kelly_sqrt32(x));
    }
    EQUAL(tanh, GOLDEN(UINT64_C(0x5870cd094a48e23e), UINT64_C(0x972ec882dd93693c)));
    EQUAL(sine, GOLDEN(UINT64_C(0x1020c71035142a50), UINT64_C(0x91ba4071eebacead)));
    EQUAL(phase, GOLDEN(UINT64_C(0xeb0db0f1e2eeb9b4), UINT64_C(0x7161a105d52c9169)));
    EQUAL(logs, UINT64_C(0x252e8b721680976f));
    EQUAL(roots, UINT64_C(0x83aa30376524ec6a));
}

void test_detmath(void)
{
    tanh_has_known_values();
    tanh_is_odd_bounded_and_rises();
    lanes_agree_with_scalars();
    clamp_holds_lanes_and_keeps_a_nan();
    sine_has_known_values();
    sine_is_symmetric();
    phase_steps_are_exact();
    logarithms_have_known_values();
    roots_are_exact();
    exponentials_have_known_values();
    bits_are_the_same_everywhere();
}
