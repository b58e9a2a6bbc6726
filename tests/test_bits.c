/* test_bits.c - statistics and limits have the same bits on every machine, as the realisations do.
 *
 * The numbers say nothing by themselves; what they are numbers of is claimed in the other tests. Those of `wide` are of doubles
 * but on a board that computes in float. A change of one is a change of results: it wants a reason.
 */
#include "check.h"
#include "fixture.h"

/* Not in the frame of test_bits as well: the smallest stack has 3 KB. */
#define APART static __attribute__((noinline)) void

static kelly_case run;
static kelly_draw draw;
static uint64_t digest;

/* One piece of memory, for parts that have 16 KB of it. */
static union {
    kelly_envelope envelope;
    kelly_sobol sobol;
    kelly_modes modes;
    struct {
        real q[KELLY_MODES_MAX], v[KELLY_MODES_MAX];
    } modal;
} memory;

static void fold(uint64_t bits)
{
    for (int i = 0; i < 64; i += 32) {
        digest = (digest ^ (uint32_t)(bits >> i)) * UINT64_C(0x100000001b3);
    }
}

static void fold_real(real x) { fold(fixture_bits(x)); }

APART fold_wide(wide x)
{
    if (sizeof(wide) == sizeof(float)) {
        fold((union { float x; uint32_t bits; }){ .x = (float)x }.bits);
    } else {
        fold((union { double x; uint64_t bits; }){ .x = (double)x }.bits);
    }
}

static void is_in_real(uint64_t in_float, uint64_t in_double)
{
    EQUAL(digest, sizeof(real) == sizeof(float) ? in_float : in_double);
    digest = 0;
}

static void is_in_wide(uint64_t in_float, uint64_t in_double)
{
    EQUAL(digest, sizeof(wide) == sizeof(float) ? in_float : in_double);
    digest = 0;
}

/* Values in random order, then ascending, then descending: every cluster after every 500 of them. */
APART envelopes(void)
{
    kelly_envelope *const e = &memory.envelope;
    kelly_band band;
    uint32_t taken = 0;

    for (unsigned order = 0; order < 3; order++) {
        kelly_envelope_clear(e);
        for (uint32_t i = 0; i < 2000; i++) {
            const uint32_t word = order == 0 ? (i + 1) * 2654435769u : order == 1 ? i << 20 : (2000 - i) << 20;

            taken += (uint32_t)kelly_envelope_add(e, (real)(int32_t)(word >> 8) / R(65536.0));
            if (i % 500 == 499) {
                for (unsigned k = 0; k < e->used; k++) {
                    fold_real(e->value[k]);
                    fold(e->weight[k]);
                }
            }
        }
        kelly_envelope_read(e, &band);
        fold_real(band.mean);
        fold_real(band.sd);
        fold_real(band.low);
        fold_real(band.median);
        fold_real(band.high);
        fold_real(e->grain);
    }
    EQUAL(taken, 6000);
    is_in_real(UINT64_C(0x92d7d3a712c041c0), UINT64_C(0x029f1dfa0d6f26d8));
}

APART intervals(void)
{
    static const uint32_t n[] = { 1, 2, 7, 50, 1000, 1000000 };

    for (unsigned i = 0; i < sizeof(n) / sizeof(n[0]); i++) {
        const uint32_t k[] = { 0, 1, n[i] / 3, n[i] / 2, n[i] - 1, n[i] };

        for (unsigned j = 0; j < sizeof(k) / sizeof(k[0]); j++) {
            fold_wide(kelly_binomial_lo(k[j], n[i], W(0.025)));
            fold_wide(kelly_binomial_hi(k[j], n[i], W(0.005)));
        }
    }
    for (uint32_t x = 1; x < 40; x += 3) {
        fold_wide(kelly_stirling((wide)x));
    }
    is_in_wide(UINT64_C(0x345840d74c599322), UINT64_C(0xa881130a8b3c0e40));
}

/* In float in both builds. */
APART sequences(void)
{
    static const uint32_t n[] = { 1, 2, 7, 50, 1000, 1000000 };

    for (unsigned i = 0; i < sizeof(n) / sizeof(n[0]); i++) {
        const uint32_t k[] = { 0, 1, n[i] / 3, n[i] - 1, n[i] };

        for (unsigned j = 0; j < sizeof(k) / sizeof(k[0]); j++) {
            fold((union { float x; uint32_t bits; }){ .x = kelly_sequence_lo(k[j], n[i], 0.05f) }.bits);
            fold((union { float x; uint32_t bits; }){ .x = kelly_sequence_hi(k[j], n[i], 0.01f) }.bits);
        }
    }
    is_in_real(UINT64_C(0x0a551a95c6412d2c), UINT64_C(0x0a551a95c6412d2c));
}

APART indices(void)
{
    kelly_sobol *const sobol = &memory.sobol;
    kelly_rng rng;

    kelly_rng_key(&rng, 6, 0, 0);
    kelly_sobol_clear(sobol, 2);
    for (unsigned j = 0; j < 77; j++) {
        wide f[4];

        for (unsigned i = 0; i < 4; i++) {
            f[i] = (wide)kelly_open01(kelly_rng_next(&rng)) + (wide)i;
        }
        kelly_sobol_add(sobol, f);
    }
    for (unsigned i = 0; i < 2; i++) {
        kelly_estimate of[2];
        wide mean, variance;

        CHECK(kelly_sobol_read(sobol, i, &of[0], &of[1]));
        kelly_sobol_moments(sobol, &mean, &variance);
        fold_wide(mean);
        fold_wide(variance);
        for (unsigned k = 0; k < 2; k++) {
            fold_wide(of[k].value);
            fold_wide(of[k].lo);
            fold_wide(of[k].hi);
        }
    }
    is_in_wide(UINT64_C(0xc9317c1e6ed1befc), UINT64_C(0xacb12e13b09e19e5));
}

APART weights(void)
{
    static const kelly_laws from = { .mean = { 1, 1, 1, 1, 1 }, .cov = { W(0.2), W(0.2), W(0.2), 0, W(0.1) } };
    static const kelly_laws to = { .mean = { W(1.05), 1, W(0.97), 1, 1 }, .cov = { W(0.2), W(0.18), W(0.19), 0, W(0.1) } };
    static kelly_reweight sums;
    kelly_reweighted r;

    kelly_reweight_start(&sums, &from, &to);
    fold_wide(sums.square);
    for (uint32_t j = 0; j < 200; j++) {
        wide y[KELLY_PARAMETERS];

        for (uint32_t k = 0; k < KELLY_PARAMETERS; k++) {
            kelly_rng rng;

            kelly_rng_key(&rng, 9, j, k);
            y[k] = (wide)kelly_gamma(&rng, 1.0f, 0.2f);
        }
        kelly_reweight_add(&sums, y, j % 17 == 5 ? KELLY_STEP : KELLY_OK, y[1] > W(1.1));
    }
    kelly_reweight_read(&sums, &r);
    fold_wide(r.probability);
    fold_wide(r.lo);
    fold_wide(r.hi);
    fold_wide(r.ess);
    fold_wide(r.ess_predicted);
    fold_wide(r.share);
    is_in_wide(UINT64_C(0x927213058c21163c), UINT64_C(0x935680a952d14aa6));
}

/* Bounds of the step, stiff and soft, and of the axial modes. */
APART steps(void)
{
    kelly_modes *const modes = &memory.modes;

    fixture_case(&run, 1000);
    for (unsigned k = 0; k < KELLY_PARAMETERS; k++) {
        run.cov[k] = 0.2f;
    }
    run.axial = 5;
    for (uint32_t j = 0; j < 20; j++) {
        run.drive = (kelly_drive){ .inertia = j & 1 ? R(2900.0) : 0, .impedance = R(289.0), .hz = R(0.2) };
        kelly_draw_sample(&run, 12, j, &draw);
        draw.mu = j & 2 ? R(1e-9) : draw.mu;
        fold((uint64_t)kelly_realise(&kelly_string, &run, &draw, modes));
        fold_real(kelly_largest_step(&kelly_string, &run, &draw, modes));
        fold_real(kelly_fastest_rate(&kelly_string, &run, &draw, modes, R(90000.0)));
        fold_real(kelly_smallest_step(modes));
        fold_real(kelly_axial_largest_step(&kelly_string, &run, &draw));
    }
    is_in_real(UINT64_C(0xb3927e881b45ee2c), UINT64_C(0x43b1ed7478b8593a));
}

/* All that is seen of a string with a stiff top, and with a soft one. */
APART sights(void)
{
    kelly_plant *const plant = &fixture.plant;

    fixture_case(&run, 1000);
    run.axial = 5;
    kelly_draw_nominal(&run, &draw);
    for (unsigned soft = 0; soft < 2; soft++) {
        run.drive = (kelly_drive){ .inertia = soft ? R(2900.0) : 0, .impedance = R(289.0), .hz = R(0.2) };
        EQUAL(kelly_plant_start(plant, &kelly_string, &run, &draw), KELLY_OK);
        for (unsigned k = 0; k < 40; k++) {
            kelly_sight s;

            kelly_plant_advance(plant, 7);
            kelly_plant_look(plant, &s);
            fold_real(s.bit_speed);
            fold_real(s.bit_torque);
            fold_real(s.f_bit);
            fold_real(s.axial_speed);
            fold_real(s.surface_torque);
            fold_real(s.top_speed);
            fold_real(kelly_plant_twist(plant));
            kelly_plant_modal(plant, memory.modal.q, memory.modal.v);
            for (unsigned i = 0; i < plant->modes.count; i++) {
                fold_real(memory.modal.q[i]);
                fold_real(memory.modal.v[i]);
            }
        }
    }
    is_in_real(UINT64_C(0x0165b4293af2c06c), UINT64_C(0xbe39d6c578c89146));
}

void test_bits(void);
void test_bits(void)
{
    envelopes();
    intervals();
    sequences();
    indices();
    weights();
    steps();
    sights();
}
