/* engine.c - which build of the kernel this processor runs. */
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
