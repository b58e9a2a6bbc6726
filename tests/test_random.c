/* test_random.c - claims about random.h. Known answers; the laws, with fixed seeds and bounds of five standard
 * deviations; and the first draws bit by bit, which every machine must confirm. */
#include "../firmware/random.h"
#include "../firmware/detmath.h"
#include "check.h"

void test_random(void);

typedef union { float value; uint32_t bits; } bits_of_float;

#define DRAWS (CHECK_LONG ? 1000000 : 4000)
#define BINS 20
#define FIXED 65536.0f               /* sums are taken in integers of 2^-16: no order, no rounding */

static const float covs[] = {0.0001f, 0.01f, 0.05f, 0.2f, 0.5f};
#define COVS ((int)(sizeof covs / sizeof covs[0]))

static void generators_give_known_answers(void)
{
    static const uint32_t words[] = {641, 1573767, 3222811527u, 3517856514u, 836907274, 4247214768u};
    uint64_t state = 0;
    EQUAL(kelly_splitmix64(&state), UINT64_C(0xe220a8397b1dcdaf));
    EQUAL(kelly_splitmix64(&state), UINT64_C(0x6e789e6aa1b965f4));
    EQUAL(kelly_splitmix64(&state), UINT64_C(0x06c45d188009454f));
    state = 1234567;
    EQUAL(kelly_splitmix64(&state), UINT64_C(6457827717110365317));
    EQUAL(kelly_splitmix64(&state), UINT64_C(3203168211198807973));

    kelly_rng rng = {{1, 2, 3, 4}};
    for (int i = 0; i < 6; i++) EQUAL(kelly_rng_next(&rng), words[i]);
    kelly_rng far = {{1, 2, 3, 4}};
    kelly_rng_jump(&far);
    EQUAL(far.s[0], 0xa9765206u);
    EQUAL(far.s[1], 0x797aa168u);
    EQUAL(far.s[2], 0x5b62e331u);
    EQUAL(far.s[3], 0x02abd971u);
}

static void uniforms_stay_inside(void)
{
    unsigned mirrored = 0;
    for (uint32_t i = 0; i < 1000; i++) {
        const uint32_t word = i * 0x9e3779b9u;
        mirrored += kelly_open01(word) + kelly_open01(~word) == 1.0f;
    }
    EQUAL(mirrored, 1000);
    CHECK(kelly_open01(0) == 0x1p-24f);
    CHECK(kelly_open01(0xffffffffu) == 1.0f - 0x1p-24f);
    CHECK(kelly_open01(0x7fffffffu) == 0.5f - 0x1p-24f);
    CHECK(kelly_open01(0x80000000u) == 0.5f + 0x1p-24f);
}

/* All-zero state is the one that gives nothing but zeros: loops must end, with the middle of the law. */
static void a_dead_generator_does_no_harm(void)
{
    kelly_rng dead = {{0, 0, 0, 0}};
    CHECK(kelly_normal(&dead) == 0.0f);
    const float g = kelly_gamma(&dead, 3.0f, 0.2f);
    CHECK(g > 2.8f && g < 3.2f);
}

static unsigned ones(uint32_t x)
{
    unsigned n = 0;
    for (; x; x &= x - 1) n++;
    return n;
}

/* Neighbouring keys: half of the bits of their first words differ, +- 5 sigma. */
static void neighbours_are_strangers(uint64_t seeds, uint32_t indices, uint32_t streams)
{
    const uint32_t pairs = 500;
    int64_t differ = 0;
    for (uint32_t i = 0; i < pairs; i++) {
        kelly_rng a, b;
        kelly_rng_key(&a, 1, i, 2);
        kelly_rng_key(&b, 1 + seeds, i + indices, 2 + streams);
        for (int j = 0; j < 4; j++) differ += (int64_t)ones(kelly_rng_next(&a) ^ kelly_rng_next(&b));
    }
    const int64_t bits = pairs * 128, away = 2 * differ - bits;
    CHECK(away * away <= 25 * bits);
}

static void keys_tell_their_parts_apart(void)
{
    kelly_rng a, b;
    neighbours_are_strangers(1, 0, 0);
    neighbours_are_strangers(0, 1, 0);
    neighbours_are_strangers(0, 0, 1);
    neighbours_are_strangers(UINT64_C(1) << 32, 0, 0);
    neighbours_are_strangers(0, 0x80000000u, 0);
    neighbours_are_strangers(1, 0xffffffffu, 0);
    kelly_rng_key(&a, 1, 2, 3);
    kelly_rng_key(&b, 1, 3, 2);
    CHECK(kelly_rng_next(&a) != kelly_rng_next(&b));
    kelly_rng_key(&a, 1, 2, 3);
    kelly_rng_key(&b, 2, 1, 3);
    CHECK(kelly_rng_next(&a) != kelly_rng_next(&b));
    kelly_rng_key(&a, 1, 2, 3);
    kelly_rng_key(&b, 1, 2, 3);
    CHECK(kelly_rng_next(&a) == kelly_rng_next(&b));
}

/* Is |count - n p| within five standard deviations of a binomial? p in millionths. */
static int plausible(int64_t count, int64_t n, int64_t p)
{
    const int64_t away = count - n * p / 1000000;
    return away * away <= 25 * (n * p / 1000000 + 1) * (1000000 - p) / 1000000 + 1;
}

static int64_t fixed(float x) { return (int64_t)(int32_t)(x * FIXED + (x < 0.0f ? -0.5f : 0.5f)); }

/* Sum and sum of squares of `n` standardised draws of kurtosis k/100: mean 0 and variance 1, +- 5 sigma. */
static void moments_are_right(int64_t sum, int64_t squares, int64_t n, int64_t kurtosis)
{
    const int64_t mean = sum / 65536, variance = squares / 65536 - n;
    CHECK(mean * mean <= 25 * n);
    CHECK(variance * variance <= n * (kurtosis - 100) / 4);
}

static void normals_follow_their_law(void)
{
    static const int64_t beyond[4] = {317311, 45500, 2700, 63};     /* P(|x| > 1, 2, 3, 4) in millionths */
    int64_t sum = 0, squares = 0, above = 0, tail[4];
    for (int k = 0; k < 4; k++) tail[k] = 0;
    kelly_rng rng;
    kelly_rng_key(&rng, 20, 26, 0);
    for (int i = 0; i < DRAWS; i++) {
        const float x = kelly_normal(&rng), size = x < 0.0f ? -x : x;
        sum += fixed(x);
        squares += fixed(x * x);
        above += x > 0.0f;
        for (int k = 0; k < 4; k++) tail[k] += size > (float)(k + 1);
    }
    moments_are_right(sum, squares, DRAWS, 300);
    CHECK(plausible(above, DRAWS, 500000));
    for (int k = 0; k < 4; k++) CHECK(plausible(tail[k], DRAWS, beyond[k]));
}

/* The same sums over one draw of each of many streams: what the realisations see. */
static void streams_follow_the_law_too(void)
{
    int64_t sum = 0, squares = 0, products = 0;
    float before = 0.0f;
    for (int i = 0; i < DRAWS; i++) {
        kelly_rng rng;
        kelly_rng_key(&rng, 1, (uint32_t)i, 3);
        const float x = kelly_normal(&rng);
        sum += fixed(x);
        squares += fixed(x * x);
        products += fixed(x * before);
        before = x;
    }
    moments_are_right(sum, squares, DRAWS, 300);
    products /= 65536;
    CHECK(products * products <= 25 * (int64_t)DRAWS);
}

/* Twentieths of the gamma law of mean 1 and covs[], by scipy.stats.gamma.ppf(i / 20, k, scale=1/k), k = 1 / cov^2. */
static const float twentieths[][BINS - 1] = {
    {0.999835520f, 0.999871847f, 0.999896357f, 0.999915837f, 0.999932549f, 0.999947558f, 0.999961465f, 0.999974662f,
     0.999987431f, 0.999999997f, 1.000012563f, 1.000025332f, 1.000038529f, 1.000052438f, 1.000067447f, 1.000084161f,
     1.000103644f, 1.000128157f, 1.000164491f},
    {0.983608511f, 0.987206088f, 0.989638310f, 0.991574212f, 0.993237056f, 0.994731926f, 0.996118485f, 0.997435384f,
     0.998710604f, 0.999966667f, 1.001223782f, 1.002502229f, 1.003824747f, 1.005219741f, 1.006726606f, 1.008406343f,
     1.010366636f, 1.012836737f, 1.016505191f},
    {0.919202935f, 0.936481546f, 0.948261524f, 0.957694338f, 0.965836717f, 0.973188158f, 0.980033653f, 0.986559021f,
     0.992899929f, 0.999166790f, 1.005459968f, 1.011881527f, 1.018547364f, 1.025603716f, 1.033255032f, 1.041819686f,
     1.051862210f, 1.064589022f, 1.083639253f},
    {0.695285034f, 0.753772968f, 0.795078583f, 0.828984213f, 0.858841676f, 0.886266140f, 0.912199952f, 0.937275523f,
     0.961972257f, 0.986698735f, 1.011845851f, 1.037831677f, 1.065152309f, 1.094455879f, 1.126672098f, 1.163275932f,
     1.206919883f, 1.263342420f, 1.350096131f},
    {0.341579599f, 0.436192391f, 0.509774887f, 0.574196702f, 0.633830053f, 0.690927761f, 0.746911140f, 0.802830695f,
     0.859578883f, 0.918015187f, 0.979063630f, 1.043815683f, 1.113669859f, 1.190557274f, 1.277356871f, 1.378761429f,
     1.503384220f, 1.670195767f, 1.938414132f},
};

static int bin_of(float x, const float edges[BINS - 1])
{
    int bin = 0;
    while (bin < BINS - 1 && x > edges[bin]) bin++;
    return bin;
}

static void gammas_follow_their_law(int which)
{
    const float cov = covs[which];
    int64_t sum = 0, squares = 0, count[BINS];
    for (int k = 0; k < BINS; k++) count[k] = 0;
    kelly_rng rng;
    kelly_rng_key(&rng, 1000, (uint32_t)which, 0);
    for (int i = 0; i < DRAWS; i++) {
        const float x = kelly_gamma(&rng, 1.0f, cov), deviation = (x - 1.0f) / cov;
        count[bin_of(x, twentieths[which])]++;
        sum += fixed(deviation);
        squares += fixed(deviation * deviation);
    }
    moments_are_right(sum, squares, DRAWS, 300 + (int64_t)(int32_t)(600.0f * cov * cov));
    for (int k = 0; k < BINS; k++) CHECK(plausible(count[k], DRAWS, 1000000 / BINS));
}

static void gammas_scale_with_the_mean(void)
{
    for (int k = 0; k < 20; k++) {
        kelly_rng a, b;
        kelly_rng_key(&a, 5, (uint32_t)k, 0);
        kelly_rng_key(&b, 5, (uint32_t)k, 0);
        CHECK(kelly_gamma(&a, 131072.0f, 0.2f) == 131072.0f * kelly_gamma(&b, 1.0f, 0.2f));
    }
}

/* s0 = 0, s1 = s3 = -1: the first word is -1 and the next 0, so that the polar method has a = -2^-31, b = 0. */
static void the_far_tail_is_there_and_harmless(void)
{
    const kelly_rng far = {{0, 0xffffffffu, 5, 0xffffffffu}};
    kelly_rng rng = far;
    const float x = kelly_normal(&rng);
    CHECK(x > -9.2710f && x < -9.2708f);                              /* -sqrt(124 log 2) */
    for (int k = 0; k < COVS; k++) {
        rng = far;
        const float y = kelly_gamma(&rng, 1.0f, covs[k]);             /* 1 + t is not positive where cov is 1/2: another try */
        CHECK(y > 0.0f && y < 1.0f + 5.0f * covs[k]);
    }
}

/* The numbers say nothing by themselves: every compiler, level and machine must give them, in both precisions. */
static void bits_are_the_same_everywhere(void)
{
    static const uint32_t first[4] = {0x972bfe76u, 0x593c64ecu, 0x5722c3eau, 0xe84b0913u};
    static const uint32_t draws[] = {0x42c7fe79u, 0x42c6640fu, 0x42cd60cfu, 0x429eed07u, 0x4270fdabu};
    kelly_rng rng;
    kelly_rng_key(&rng, 1, 0, 0);
    for (int i = 0; i < 4; i++) EQUAL(kelly_rng_next(&rng), first[i]);
    EQUAL((bits_of_float){.value = kelly_normal(&rng)}.bits, 0x3f34c3b0u);
    for (int i = 0; i < COVS; i++) EQUAL((bits_of_float){.value = kelly_gamma(&rng, 100.0f, covs[i])}.bits, draws[i]);

    uint64_t digest = 0;
    for (uint32_t i = 0; i < 2000; i++) {
        kelly_rng_key(&rng, 7, i, i % 5);
        const float x = kelly_gamma(&rng, 10.471976f, covs[i % (uint32_t)COVS]);
        digest = (digest ^ (bits_of_float){.value = x}.bits) * UINT64_C(0x100000001b3);
    }
    EQUAL(digest, UINT64_C(0x786c52b20f69db5f));
}

void test_random(void)
{
    generators_give_known_answers();
    uniforms_stay_inside();
    a_dead_generator_does_no_harm();
    keys_tell_their_parts_apart();
    normals_follow_their_law();
    streams_follow_the_law_too();
    for (int i = 0; i < COVS; i++) gammas_follow_their_law(i);
    gammas_scale_with_the_mean();
    the_far_tail_is_there_and_harmless();
    bits_are_the_same_everywhere();
}
