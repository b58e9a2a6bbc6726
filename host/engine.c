/* engine.c - which build of the kernel this processor runs. */
#include <math.h>
#include <stddef.h>
#include <string.h>

#include "host.h"

extern const kelly_engine kelly_engine_scalar;
#ifdef KELLY_X86
extern const kelly_engine kelly_engine_sse2, kelly_engine_avx2, kelly_engine_avx512;
#else
extern const kelly_engine kelly_engine_vector;
#endif

unsigned engines_usable(const kelly_engine *list[4])
{
    unsigned n = 0;

    list[n++] = &kelly_engine_scalar;
#ifdef KELLY_X86
    list[n++] = &kelly_engine_sse2;
    if (__builtin_cpu_supports("avx2")) {
        list[n++] = &kelly_engine_avx2;
    }
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl")) {
        list[n++] = &kelly_engine_avx512;
    }
#else
    list[n++] = &kelly_engine_vector;
#endif
    return n;
}

const kelly_engine *engine_choose(const char *name)
{
    const kelly_engine *list[4];
    const unsigned n = engines_usable(list);

    if (!name) {
        return list[n - 1];
    }
    for (unsigned i = 0; i < n; i++) {
        if (strcmp(list[i]->name, name) == 0) {
            return list[i];
        }
    }
    die(EXIT_USAGE, "--engine %s: not in this program or not on this processor; the widest here is %s", name, list[n - 1]->name);
}

/* Coefficients and state of the modes of one block should stay within the first-level cache (48 KB on what has AVX-512). */
#define CACHE 43008u

unsigned engine_lanes(const kelly_engine *e, const kelly_case *run)
{
    const size_t stiff = run->torsional * sizeof(kelly_mode), soft = run->torsional * sizeof(kelly_driven_mode) + sizeof(kelly_driven_lane);
    const unsigned vector = (unsigned)((run->drive.inertia > 0 ? soft : stiff) / sizeof(vreal) * e->width * sizeof(real));
    const unsigned fit = CACHE / vector, whole = e->lanes / e->width;

    return e->width * (fit < 1 ? 1 : fit < whole ? fit : whole);
}

#define TOGETHER 256u            /* results of a second run on the stack */

/* Members side by side, without what fills the struct. */
static int same(const kelly_result *a, const kelly_result *b)
{
    return memcmp(a, b, offsetof(kelly_result, liftoff) + sizeof(a->liftoff)) == 0;
}

/* What came out of two runs: where they differ, neither is to be believed. */
static void settle(kelly_result *results, const kelly_result *again, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        if (!same(&results[i], &again[i])) {
            results[i] = (kelly_result){ .draw = results[i].draw, .status = KELLY_CORRUPT, .liftoff = results[i].liftoff };
        }
    }
}

void check_intact(const kelly_result *result, uint32_t index)
{
    if (result->status == KELLY_CORRUPT) {
        die(EXIT_FAILED, "realisation %u: a number in memory changed while it ran; look at this machine's memory, and run again", index);
    }
}

int results_sound(const void *payload, size_t size)
{
    for (size_t at = 0; at + sizeof(kelly_result) <= size; at += sizeof(kelly_result)) {
        kelly_result r;

        memcpy(&r, (const char *)payload + at, sizeof(r));
        if (r.status >= KELLY_STATUSES || r.stuck > (r.status == KELLY_OK) || r.liftoff > 1 || !isfinite(r.lowest) || !isfinite(r.highest) ||
            !isfinite(r.mean) || !isfinite(r.ss)) {
            return 0;
        }
    }
    return 1;
}

void engine_run(const kelly_engine *e, const options *opts, const kelly_case *run, uint32_t first, uint32_t count,
                kelly_result *results, void *work)
{
    kelly_result again[TOGETHER];

    e->run(&kelly_string, run, opts->seed, first, count, results, work);
    for (uint32_t done = 0, part; opts->twice && done < count; done += part) {
        part = count - done < TOGETHER ? count - done : TOGETHER;
        e->run(&kelly_string, run, opts->seed, first + done, part, again, work);
        settle(results + done, again, part);
    }
}

void engine_run_draws(const kelly_engine *e, const options *opts, const kelly_draw *draws, uint32_t count, kelly_result *results, void *work)
{
    kelly_result again[TOGETHER];

    e->run_draws(&kelly_string, &opts->run, draws, count, results, work);
    for (uint32_t done = 0, part; opts->twice && done < count; done += part) {
        part = count - done < TOGETHER ? count - done : TOGETHER;
        e->run_draws(&kelly_string, &opts->run, draws + done, part, again, work);
        settle(results + done, again, part);
    }
}
