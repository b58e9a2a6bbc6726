/* random.c - see random.h. */
#include "random.h"
#include "detmath.h"

/* Tries of a rejection loop. A try fails with probability 0.2147 (normal) or below 0.05 (gamma), so that running out
 * has a probability below 1e-42; the middle of the law is returned then. */
#define TRIES 64

uint64_t kelly_splitmix64(uint64_t *state)
{
    *state += UINT64_C(0x9e3779b97f4a7c15);
    uint64_t z = *state;
    z = (z ^ z >> 30) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ z >> 27) * UINT64_C(0x94d049bb133111eb);
    return z ^ z >> 31;
}

/* seed, index and stream are mixed in one after another, each through the whole of splitmix64, so neighbours in any of
 * them share nothing. The last two words come from different states of a one-to-one map: they differ, so that the
 * generator's state is never all zero. */
void kelly_rng_key(kelly_rng *rng, uint64_t seed, uint32_t index, uint32_t stream)
{
    uint64_t key = seed;
    key = kelly_splitmix64(&key) ^ index;
    key = kelly_splitmix64(&key) ^ stream;
    const uint64_t first = kelly_splitmix64(&key), second = kelly_splitmix64(&key);
    rng->s[0] = (uint32_t)first;
    rng->s[1] = (uint32_t)(first >> 32);
    rng->s[2] = (uint32_t)second;
    rng->s[3] = (uint32_t)(second >> 32);
}

static uint32_t rotate(uint32_t x, int k)
{
    return x << k | x >> (32 - k);
}

uint32_t kelly_rng_next(kelly_rng *rng)
{
    uint32_t *s = rng->s;
    const uint32_t word = rotate(s[0] + s[3], 7) + s[0];
    const uint32_t t = s[1] << 9;
    s[2] ^= s[0];
    s[3] ^= s[1];
    s[1] ^= s[2];
    s[0] ^= s[3];
    s[2] ^= t;
    s[3] = rotate(s[3], 11);
    return word;
}

/* The step is linear over bits: 2^64 steps are a polynomial of it, whose coefficients these are. */
void kelly_rng_jump(kelly_rng *rng)
{
    static const uint32_t polynomial[4] = {0x8764000bu, 0xf542d2d3u, 0x6fa035c3u, 0x77f2db5bu};
    uint32_t a = 0, b = 0, c = 0, d = 0;
    for (int bit = 0; bit < 128; bit++) {
        const uint32_t take = 0u - (polynomial[bit / 32] >> (bit % 32) & 1u);
        a ^= rng->s[0] & take;
        b ^= rng->s[1] & take;
        c ^= rng->s[2] & take;
        d ^= rng->s[3] & take;
        (void)kelly_rng_next(rng);
    }
    rng->s[0] = a;
    rng->s[1] = b;
    rng->s[2] = c;
    rng->s[3] = d;
}

float kelly_open01(uint32_t word)
{
    return ((float)(int32_t)(word >> 9) + 0.5f) * 0x1.0p-23f;     /* 24 digits: exact */
}

/* Of (-1, 1), from all 32 bits: small values keep their digits, and with them the tails of the normal law. */
static float signed_unit(uint32_t word)
{
    return (float)(int32_t)word * 0x1.0p-31f;
}

/* One try of the polar method from two uniforms of (-1, 1): 0 where they do not lie in the unit circle. */
static int polar(float a, float b, float *x)
{
    const float s = a * a + b * b;                                /* 0, or at least 2^-62 */

    if (!(s >= 0x1.0p-62f && s < 1.0f)) {
        return 0;
    }
    *x = a * kelly_sqrt32(-2.0f * kelly_log32(s) / s);
    return 1;
}

/* The second normal of a pair is not used, so that a draw depends on nothing but the state. */
float kelly_normal(kelly_rng *rng)
{
    for (int i = 0; i < TRIES; i++) {
        const float a = signed_unit(kelly_rng_next(rng));
        const float b = signed_unit(kelly_rng_next(rng));
        float x = 0.0f;

        if (polar(a, b, &x)) {
            return x;
        }
    }
    return 0.0f;
}

/* log(1 + t) - t + t^2 / 2 - t^3 / 3 for t > -1. The direct form cancels; the series is cut at t^9 / 9, where its
 * relative error is below 2e-5. */
static float log_remainder(float t)
{
    const float t2 = t * t;
    if (t2 < 0x1.0p-6f) {
        return -t2 * t2 * (0.25f - t * (0.2f - t * (0x1.555556p-3f - t * (0x1.24924ap-3f - t * 0.125f))));
    }
    return kelly_log32(1.0f + t) - t + t2 * (0.5f - t * 0x1.555556p-2f);
}

/* Marsaglia and Tsang: with d = 1 / cov^2 - 1 / 3, t = x / (3 sqrt(d)) and v = (1 + t)^3, d v is a gamma of unit scale
 * and shape 1 / cov^2. The exact test log(u) < x^2 / 2 + d (1 - v + log(v)) loses all digits in float for a small cov;
 * put x^2 = 9 d t^2 in, and what cancels cancels on paper: log(u) < 3 d (log(1 + t) - t + t^2 / 2 - t^3 / 3). */
typedef struct {
    float d, c;
} shape;

static shape shape_of(float cov)
{
    const float d = 1.0f / (cov * cov) - 0x1.555556p-2f;
    return (shape){d, 1.0f / (3.0f * kelly_sqrt32(d))};
}

static float log_weight(const shape *law, float x)
{
    const float t = law->c * x;
    return 1.0f + t > 0.0f ? 3.0f * law->d * log_remainder(t) : KELLY_NO_WEIGHT;
}

float kelly_gamma_log_weight(float x, float cov)
{
    const shape law = shape_of(cov);
    return log_weight(&law, x);
}

float kelly_gamma_normal(kelly_rng *rng, float cov)
{
    const shape law = shape_of(cov);

    for (int i = 0; i < TRIES; i++) {
        const float x = kelly_normal(rng);

        if (kelly_log32(kelly_open01(kelly_rng_next(rng))) < log_weight(&law, x)) {
            return x;
        }
    }
    return 0.0f;
}

float kelly_gamma_value(float x, float mean, float cov)
{
    const shape law = shape_of(cov);
    const float base = 1.0f + law.c * x;
    const float scale = mean * (1.0f - cov * cov * 0x1.555556p-2f);    /* mean cov^2 d */
    return scale * (base * base * base);
}

float kelly_gamma(kelly_rng *rng, float mean, float cov)
{
    return kelly_gamma_value(kelly_gamma_normal(rng, cov), mean, cov);
}
