/* ensemble.h - draw, integrate, classify a range of indices.
 *
 * Faults of the memory: the coefficients, the draws, the case and the number of steps are sealed (seal.h) when a block begins. Seal and
 * table (by its CRC) are looked at every KELLY_LOOK steps, before the window opens and when the block ends. Where one of them has
 * changed, the block goes no further and every realisation of it gets the status `corrupt`. So for the state where it is guarded (seal.h).
 * Where it is not, a change of it is found when the block ends, if it left all bounds then or the weight strayed from its exact phase
 * (integrator.h); for the rest, run twice and compare.
 *
 * The drive is that of the case, stiff or soft. kelly_run fills results[] for indices first .. first + count - 1: the same bits for any lane count and any way of
 * cutting the range.
 */
#ifndef KELLY_ENSEMBLE_H
#define KELLY_ENSEMBLE_H

#include "drive.h"
#include "integrator.h"
#include "seal.h"
#include "tally.h"

/* What one call of kelly_run needs beside its results: the caller's, contents of no meaning between calls. */
typedef struct {
    union {
        kelly_block block;       /* stiff drive */
        kelly_driven driven;     /* soft drive */
    };
    kelly_modes modes;
    uint32_t seal;               /* of what must not change: seal.h */
    uint32_t tick;               /* that the block must be at */
} kelly_work;

/* Realisations first .. first + count - 1 of `seed`; count >= 1, run and table checked by kelly_case_error and
 * kelly_table_error. Time: 450 count ticks operations (soft drive: 850). Stack: under 512 bytes. */
void kelly_run(const kelly_table *table, const kelly_case *run, uint64_t seed, uint32_t first, uint32_t count,
               kelly_result *results, kelly_work *work);

/* kelly_run of one block in pieces, for a program that has other things to do meanwhile: begin, advance until nothing is left,
 * finish; the same results[0 .. count - 1], however the steps are cut. count is 1..KELLY_LANES, and `work` is not to be used for
 * anything else in between. A realisation that is refused says so in its status after begin.
 * kelly_run_advance does at most `ticks` steps and returns how many are left. */
void kelly_run_begin(const kelly_table *table, const kelly_case *run, uint64_t seed, uint32_t first, unsigned count,
                     kelly_result *results, kelly_work *work);
uint32_t kelly_run_advance(const kelly_table *table, const kelly_case *run, unsigned count, kelly_result *results,
                           kelly_work *work, uint32_t ticks);
void kelly_run_finish(const kelly_table *table, const kelly_case *run, unsigned count, kelly_result *results, kelly_work *work);

/* The same for draws of the caller's: result i is that of draws[i], the status `range` where a parameter is not finite and positive. What
 * kelly_run gives for its own draws, bit for bit. */
void kelly_run_draws(const kelly_table *table, const kelly_case *run, const kelly_draw *draws, uint32_t count,
                     kelly_result *results, kelly_work *work);

/* One build of this file, for a program that holds several (see isa.h). `work` of its functions is a kelly_work of
 * that build, work_size bytes at an address that is a multiple of 64. Its two function pointers, in a const object that
 * only a host reads, are the only ones of firmware/. */
typedef struct {
    const char *name;            /* vector unit: "scalar", "sse2", "avx2", "avx512" */
    unsigned width;              /* realisations in a vector */
    unsigned lanes;              /* realisations in a block */
    size_t work_size;
    void (*run)(const kelly_table *table, const kelly_case *run, uint64_t seed, uint32_t first, uint32_t count,
                kelly_result *results, void *work);
    void (*run_draws)(const kelly_table *table, const kelly_case *run, const kelly_draw *draws, uint32_t count,
                      kelly_result *results, void *work);
} kelly_engine;

extern const kelly_engine kelly_engine_here;

#endif
