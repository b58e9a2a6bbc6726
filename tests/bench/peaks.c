/* peaks.c - the rates of peak.c, taken in turns with everybody else. */
#include <string.h>

#include "run.h"

static const peak *const peaks[] = { &peak_sse2, &peak_avx2, &peak_avx512, &peak_fma_128, &peak_fma_256, &peak_fma_512 };
#define PEAKS (sizeof(peaks) / sizeof(peaks[0]))
#define MOMENT 0.01              /* [s] of one measurement */

static double rates[PEAKS][2][ROUNDS_MAX];

static int usable(const peak *p)
{
    if (strstr(p->name, "fma") && !__builtin_cpu_supports("fma")) {
        return 0;
    }
    return p->bits == 512 ? __builtin_cpu_supports("avx512f") : p->bits == 256 ? __builtin_cpu_supports("avx2") : 1;
}

void peaks_round(unsigned round)
{
    for (unsigned p = 0; p < PEAKS; p++) {
        rates[p][0][round] = usable(peaks[p]) ? peaks[p]->float_rate(MOMENT) : 0;
        rates[p][1][round] = usable(peaks[p]) ? peaks[p]->double_rate(MOMENT) : 0;
    }
}

void peaks_record(unsigned rounds)
{
    for (unsigned p = 0; p < PEAKS; p++) {
        if (usable(peaks[p])) {
            record("peak", "\"unit\": \"%s\", \"bits\": %u, \"float\": %.2f, \"double\": %.2f", peaks[p]->name, peaks[p]->bits,
                   median(rates[p][0], rounds), median(rates[p][1], rounds));
        }
    }
}
