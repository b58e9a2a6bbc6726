/* side.c - kelly in the precision that this file is compiled for, behind an interface without `real`. */
#include <math.h>
#include <stdlib.h>

#include "../../firmware/kelly.h"
#include "bench.h"

#ifdef KELLY_DOUBLE
#define PRECISION "double"
#else
#define PRECISION "float"
#endif

#define RESULTS_MAX 1024u

extern const kelly_engine kelly_engine_scalar;
#if defined(__x86_64__)
extern const kelly_engine kelly_engine_sse2, kelly_engine_avx2, kelly_engine_avx512;
#define ENGINES 4
static const kelly_engine *const engines[ENGINES] = { &kelly_engine_scalar, &kelly_engine_sse2, &kelly_engine_avx2, &kelly_engine_avx512 };
#else
extern const kelly_engine kelly_engine_vector;
#define ENGINES 2
static const kelly_engine *const engines[ENGINES] = { &kelly_engine_scalar, &kelly_engine_vector };
#endif

static kelly_case hard_rock(double cov, unsigned modes, uint32_t ticks)
{
    kelly_case run = kelly_string.nominal;

    for (unsigned k = 0; cov >= 0 && k < KELLY_PARAMETERS; k++) {
        run.cov[k] = (float)cov;
    }
    run.torsional = (uint8_t)modes;
    run.ticks = ticks;
    run.window_first = ticks / 2;
    run.window_last = ticks;
    return run;
}

/* The kernel's own kelly_block_advance of each engine: it is handed the block that begins a kelly_work of that engine. */
typedef void (*advance_function)(void *block, uint32_t ticks);
#if defined(__x86_64__)
void kelly_block_advance_sse2(void *block, uint32_t ticks);
void kelly_block_advance_avx2(void *block, uint32_t ticks);
void kelly_block_advance_avx512(void *block, uint32_t ticks);
static const advance_function advances[ENGINES] = { (advance_function)kelly_block_advance, kelly_block_advance_sse2, kelly_block_advance_avx2,
                                                    kelly_block_advance_avx512 };
#else
void kelly_block_advance_vector(void *block, uint32_t ticks);
static const advance_function advances[ENGINES] = { (advance_function)kelly_block_advance, kelly_block_advance_vector };
#endif
static void *work;

static void advance(unsigned engine, uint32_t ticks)
{
    advances[engine](work, ticks);
}

static uint32_t run_engine(unsigned engine, double cov, unsigned modes, uint32_t ticks, uint32_t first, uint32_t count)
{
    static kelly_result results[RESULTS_MAX];
    const kelly_case run = hard_rock(cov, modes, ticks);
    kelly_tally tally = { 0 };

    if (!work) {
        size_t most = 0;

        for (unsigned e = 0; e < ENGINES; e++) {
            most = engines[e]->work_size > most ? engines[e]->work_size : most;
        }
        if (posix_memalign(&work, 64, most) != 0) {
            abort();
        }
    }
    if (count > RESULTS_MAX) {
        abort();
    }
    engines[engine]->run(&kelly_string, &run, 1u, first, count, results, work);
    for (uint32_t j = 0; j < count; j++) {
        kelly_tally_add(&tally, first + j, &results[j]);
    }
    return tally.digest;
}

static kelly_case draw_of(long draw, kelly_draw *out)
{
    const kelly_case run = hard_rock(-1.0, MODES, STEPS);

    if (draw < 0) {
        kelly_draw_nominal(&run, out);
    } else {
        kelly_draw_sample(&run, 1u, (uint32_t)draw, out);
    }
    return run;
}

static void make_problem(long draw, problem *out)
{
    kelly_draw y;
    kelly_modes modes;
    const kelly_case run = draw_of(draw, &y);

    if (!kelly_modes_at(&kelly_string, y.fc, MODES, &modes)) {
        abort();
    }
    *out = (problem){ .fc = (double)y.fc, .f0 = (double)run.f0, .mu = (double)y.mu, .a1 = (double)y.a1, .a2 = (double)y.a2, .w0 = (double)y.w0 };
    for (unsigned i = 0; i < MODES; i++) {
        out->w2[i] = (double)modes.w2[i];
        out->b[i] = (double)modes.b[i];
        out->d[i] = (double)modes.d[i];
        out->c[i] = (double)kelly_string.alpha + (double)kelly_string.beta * out->w2[i];
        out->drag[i] = out->d[i] * (double)kelly_string.alpha * out->w0;
    }
}

static double trace(long draw, const double *reference)
{
    static kelly_plant plant;
    kelly_draw y;
    const kelly_case run = draw_of(draw, &y);
    double worst = 0;

    if (kelly_plant_start(&plant, &kelly_string, &run, &y) != KELLY_OK) {
        return (double)NAN;
    }
    for (uint32_t tick = 0;; tick++) {
        const double error = fabs((double)kelly_block_speed(&plant.block, 0) - reference[(size_t)tick * FINE]);

        worst = error <= worst ? worst : error;     /* a NaN stays */
        if (tick == STEPS) {
            return worst;
        }
        kelly_plant_advance(&plant, 1);
    }
}

/* Narrowest first; wider than this processor has are left out. */
static const char *engine(unsigned e, unsigned *width, unsigned *lanes)
{
    unsigned usable = ENGINES;

#if defined(__x86_64__)
    const int avx512 = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl");

    usable = __builtin_cpu_supports("avx2") ? (avx512 ? 4 : 3) : 2;
#endif
    if (e >= usable) {
        return 0;
    }
    *width = engines[e]->width;
    *lanes = engines[e]->lanes;
    return engines[e]->name;
}

const side SIDE = { .precision = PRECISION, .guarded = KELLY_GUARD, .engine = engine, .run = run_engine, .advance = advance, .problem = make_problem, .trace = trace };
