/* detmath.c - see detmath.h. Polynomials are minimax fits (Remez exchange); the error given is that of the fit. */
#undef KELLY_WIDTH                       /* scalars here, whatever the lanes are elsewhere */
#define KELLY_WIDTH 1
#include "detmath.h"

#if defined(KELLY_DOUBLE) || __STDC_HOSTED__
#define WIDE_DOUBLE 1
#else
#define WIDE_DOUBLE 0
#endif

typedef union { float value; uint32_t bits; } bits32;
typedef union { double value; uint64_t bits; } bits64;

/* 2^e, for exponents of normal numbers. */
#ifndef KELLY_DOUBLE
static float power2_32(int e)
{
    return (bits32){.bits = (uint32_t)(e + 127) << 23}.value;
}
#endif
#if WIDE_DOUBLE
static double power2_64(int e)
{
    return (bits64){.bits = (uint64_t)(e + 1023) << 52}.value;
}
#endif

real kelly_tanh(real w)
{
    vreal p, q;
    kelly_tanh_ratio(w, &p, &q);
    const real t = p / q;
    return t > R(1.0) ? R(1.0) : t < R(-1.0) ? R(-1.0) : t;
}

/* High half of a 64 x 64 bit product, exact. */
static uint64_t high_product(uint64_t a, uint64_t b)
{
    const uint64_t al = (uint32_t)a, ah = a >> 32, bl = (uint32_t)b, bh = b >> 32;
    const uint64_t mid = ah * bl + ((al * bl) >> 32);             /* <= (2^32 - 1)^2 + 2^32 - 2: no overflow */
    const uint64_t low = al * bh + (uint32_t)mid;
    return ah * bh + (mid >> 32) + (low >> 32);
}

/* m 2^e, 2^61 <= m < 2^63, as a real, from 32-bit halves: a conversion from 64 bits is slow, or goes through double, on
 * small machines. Rounded once; float first cuts at most 2^-29 of it. */
static real real_of(uint64_t m, int e)
{
#ifdef KELLY_DOUBLE
    return (R(4294967296.0) * (real)(uint32_t)(m >> 32) + (real)(uint32_t)m) * power2_64(e);
#else
    return (real)(int32_t)(m >> 32) * power2_32(e + 32);
#endif
}

/* a + a^3 S(a^2), 0 <= a <= pi / 4; fit 3.8e-9 of the sine (double 3.7e-18). */
static real sin_eighth(real a)
{
    const real u = a * a;
#ifdef KELLY_DOUBLE
    const real s = ((((R(0x1.5d8fba67e7a5fp-33) * u - R(0x1.ae5e5a439928ap-26)) * u + R(0x1.71de356772ec8p-19)) * u
                     - R(0x1.a01a019bfd83bp-13)) * u + R(0x1.111111110f7cdp-7)) * u - R(0x1.5555555555548p-3);
#else
    const real s = (R(-0x1.9943b4p-13) * u + R(0x1.11073ap-7)) * u - R(0x1.555546p-3);
#endif
    return a + a * (u * s);
}

/* 1 - a^2 / 2 + a^4 C(a^2), 0 <= a <= pi / 4; fit 1.2e-10 of the cosine (double 5.6e-20). */
static real cos_eighth(real a)
{
    const real u = a * a;
#ifdef KELLY_DOUBLE
    const real c = ((((R(-0x1.8fa48016f0688p-37) * u + R(0x1.1ee9d783f1e02p-29)) * u - R(0x1.27e4f7ea7e7c2p-22)) * u
                     + R(0x1.a01a019c83f09p-16)) * u - R(0x1.6c16c16c14f8ep-10)) * u + R(0x1.555555555554bp-5);
#else
    const real c = (R(0x1.99eb74p-16) * u - R(0x1.6c0c34p-10)) * u + R(0x1.55554ap-5);
#endif
    return R(1.0) - u * (R(0.5) - u * c);
}

/* Folded to x of a quarter turn, and to x of an eighth with sine or cosine. The angle is made in integers, so that it
 * is rounded only once: 0 < x <= 2^61 is shifted up to 2^62 <= x 2^shift < 2^63 and multiplied by (pi 2^62) / 2^64;
 * the angle x pi / 2^63 is this product / 2^(61 + shift). */
real kelly_sin_turn(uint64_t phase)
{
    const uint64_t quarter = (uint64_t)1 << 62;
    uint64_t x = phase & (quarter - 1);
    if (phase & quarter) {
        x = quarter - x;
    }
    const int near_top = x > quarter / 2;
    if (near_top) {
        x = quarter - x;
    }

    real a = R(0.0);
    if (x != 0) {
        const int shift = __builtin_clzll(x) - 1;
        a = real_of(high_product(x << shift, UINT64_C(0xc90fdaa22168c235)), -61 - shift);
    }
    const real s = near_top ? cos_eighth(a) : sin_eighth(a);
    return phase >> 63 ? -s : s;
}

/* w = m 2^e with 2^63 <= m < 2^64; m = 0 where w is not a positive normal number. */
static uint64_t digits_of(real w, int *e)
{
#ifdef KELLY_DOUBLE
    const uint64_t bits = (bits64){.value = w}.bits;
    const uint32_t field = (uint32_t)(bits >> 52), top = 0x7ff, bias = 1023;       /* sign and exponent */
    const uint64_t m = (bits << 11) | (uint64_t)1 << 63;
#else
    const uint32_t bits = (bits32){.value = w}.bits;
    const uint32_t field = bits >> 23, top = 0xff, bias = 127;
    const uint64_t m = (uint64_t)((bits << 8) | 0x80000000u) << 32;
#endif
    *e = (int)field - (int)bias - 63;
    return field == 0 || field >= top ? 0 : m;
}

/* step * K / 2^32 with K = floor(2^96 / (2 pi 10^9)) is the phase of 1 rad/s in one step. It is kept as c 2^-n with
 * 2^63 <= c < 2^64, and the product with w = m 2^e is (m c / 2^64) 2^(e + 64 - n). Cuts: 2^-63 in K, 2^-63 in c, 2^-62. */
uint64_t kelly_phase_step(real w, uint32_t step_ns)
{
    int e;
    const uint64_t m = digits_of(w, &e);
    const uint64_t low = step_ns * UINT64_C(0x48313b7d);
    const uint64_t high = step_ns * UINT64_C(0xaefe2247) + (low >> 32);
    if (m == 0 || high == 0) {
        return 0;
    }

    const int n = __builtin_clzll(high);
    const uint64_t c = (high << n) | (((uint64_t)(uint32_t)low << n) >> 32);
    const uint64_t product = high_product(m, c);
    const int shift = e + 64 - n;
    if (shift >= 0) {
        return shift < 64 ? product << shift : 0;
    }
    return shift < -64 ? 0 : ((product >> (-shift - 1)) + 1) >> 1;
}

/* x = 2^e (1 + f), sqrt(1/2) < 1 + f < sqrt(2). With s = f / (2 + f) and h = f^2 / 2:
 *     log(1 + f) = 2 atanh(s) = f - h + s (h + r),   r = (2 atanh(s) - 2 s) / s = s^2 (2/3 + ...)
 * so only the first term, which is exact, is large. log 2 is split so that e times its upper part is exact.
 * Fit: 8.1e-10 of the logarithm (double 1.3e-18). */
float kelly_log32(float x)
{
    const uint32_t bits = (bits32){.value = x}.bits;
    const float m = (bits32){.bits = (bits & 0x7fffffu) | 0x3f800000u}.value;
    const int up = m > 0x1.6a09e6p+0f;
    const float e = (float)((int)(bits >> 23) - 127 + up);
    const float f = (up ? 0.5f * m : m) - 1.0f;
    const float s = f / (2.0f + f), h = 0.5f * f * f, z = s * s;
    const float r = z * ((0x1.31e678p-2f * z + 0x1.995e9cp-2f) * z + 0x1.55557ap-1f);
    return e * 0x1.62ep-1f - ((h - (s * (h + r) + e * 0x1.0bfbe8p-15f)) - f);
}

#if WIDE_DOUBLE

wide kelly_log(wide x)
{
    const uint64_t bits = (bits64){.value = x}.bits;
    const wide m = (bits64){.bits = (bits & UINT64_C(0xfffffffffffff)) | UINT64_C(0x3ff0000000000000)}.value;
    const int up = m > 0x1.6a09e667f3bcdp+0;
    const wide e = (wide)((int)(bits >> 52) - 1023 + up);
    const wide f = (up ? 0.5 * m : m) - 1.0;
    const wide s = f / (2.0 + f), h = 0.5 * f * f, z = s * s;
    const wide r = z * ((((((0x1.2f0d8ea92ff11p-3 * z + 0x1.39a0f50122a2dp-3) * z + 0x1.7466462c93937p-3) * z
                           + 0x1.c71c51e7f758cp-3) * z + 0x1.2492494217a15p-2) * z + 0x1.999999997fb31p-2) * z
                        + 0x1.5555555555593p-1);
    return e * 0x1.62e42fefa2p-1 - ((h - (s * (h + r) + e * 0x1.9ef35793c7673p-41)) - f);
}

/* 1 + r + r^2 E(r), |r| <= log(2) / 2, fit 3.5e-18. */
static wide exp_reduced(wide r)
{
    const wide s = ((((((((0x1.af860b68bec44p-26 * r + 0x1.28b0a6e229e89p-22) * r + 0x1.71dddf79a8e49p-19) * r
                         + 0x1.a0199630e9010p-16) * r + 0x1.a01a01bb0696dp-13) * r + 0x1.6c16c185cac35p-10) * r
                      + 0x1.111111110d5d0p-7) * r + 0x1.555555554ff92p-5) * r + 0x1.5555555555561p-3) * r
                   + 0x1.000000000000cp-1;
    return 1.0 + (r + r * r * s);
}

#define LOG2_UPPER 0x1.62e42fefa2p-1                       /* 40 bits: times k exact */
#define LOG2_LOWER 0x1.9ef35793c7673p-41
#define POWER2 power2_64

#else

wide kelly_log(wide x)
{
    return kelly_log32(x);
}

/* 1 + r + r^2 E(r), |r| <= log(2) / 2, fit 3.2e-9. */
static wide exp_reduced(wide r)
{
    const wide s = (((0x1.6db4e8p-10f * r + 0x1.123bdep-7f) * r + 0x1.55545ep-5f) * r + 0x1.55548ep-3f) * r + 0x1.0p-1f;
    return 1.0f + (r + r * r * s);
}

#define LOG2_UPPER 0x1.62ep-1f                             /* 12 bits */
#define LOG2_LOWER 0x1.0bfbe8p-15f
#define POWER2 power2_32

#endif

/* exp(x) = 2^k exp(r), r = x - k log 2. */
wide kelly_exp(wide x)
{
    if (x < -KELLY_EXP_END) {
        return W(0.0);
    }
    if (x > KELLY_EXP_END) {
        x = KELLY_EXP_END;
    } else if (!(x <= KELLY_EXP_END)) {   /* NaN */
        return x;
    }
    const wide turns = x * W(1.44269504088896341);
    const int k = (int)(turns + (turns < W(0.0) ? W(-0.5) : W(0.5)));
    const wide r = (x - (wide)k * LOG2_UPPER) - (wide)k * LOG2_LOWER;
    return exp_reduced(r) * POWER2(k);
}

/* Digit by digit: 25 bits of the root of a 50-bit number, of which 24 count and one rounds. A root that ends in a half
 * of the last place would need a square of more digits than x has, so rounding to nearest has no ties. */
float kelly_sqrt32_integer(float x)
{
    const uint32_t bits = (bits32){.value = x}.bits;
    if (bits == 0 || bits >= 0x7f800000u) {   /* 0, infinity, NaN; negative is not allowed */
        return x;
    }

    int e = (int)(bits >> 23);
    uint32_t m = (bits & 0x7fffffu) | 0x800000u;                   /* x = m 2^(e - 150) */
    if (bits < 0x800000u) {   /* subnormal: at most 23 turns */
        m = bits;
        for (e = 1; m < 0x800000u; e--) {
            m <<= 1;
        }
    }
    const uint32_t even = e & 1 ? m : m << 1;                      /* e - 127 is even where e is odd */
    uint32_t digits = even << 7, root = 0, rest = 0;               /* 25 digits of even, in pairs from the top */
    for (int i = 0; i < 25; i++) {
        rest = rest << 2 | digits >> 30;                           /* rest <= 2 root < 2^26 before, < 2^28 after */
        digits <<= 2;
        const uint32_t trial = root << 2 | 1u;
        root <<= 1;
        if (rest >= trial) {
            rest -= trial;
            root |= 1u;
        }
    }
    const uint32_t half = (uint32_t)((e + 127 - (e & 1 ? 0 : 1)) / 2);
    return (bits32){.bits = (half << 23) + (((root + 1u) >> 1) - 0x800000u)}.value;
}

#if defined(__x86_64__) || defined(__SSE2__) || (defined(__ARM_FP) && (__ARM_FP & 4)) || \
    defined(__aarch64__) || (defined(__riscv_flen) && __riscv_flen >= 32)
float kelly_sqrt32(float x)
{
    return __builtin_sqrtf(x);
}
#else
float kelly_sqrt32(float x)
{
    return kelly_sqrt32_integer(x);
}
#endif
