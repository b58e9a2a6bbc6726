/* host_lanes.c - every vector unit that this processor has gives the bits of the plain one-lane kernel: ranges that do
 * not fill their vectors, any first index, few and many modes, refused realisations between good ones.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "../host/host.h"
#include "check.h"

#define MOST 130

void check_put(char c)
{
    (void)putchar(c);
}

/* The parts of a result that mean something; padding does not. */
static int same(const kelly_result *a, const kelly_result *b)
{
    return memcmp(&a->draw, &b->draw, sizeof(a->draw)) == 0 && memcmp(&a->lowest, &b->lowest, sizeof(real)) == 0 &&
           memcmp(&a->highest, &b->highest, sizeof(real)) == 0 && memcmp(&a->mean, &b->mean, sizeof(real)) == 0 &&
           memcmp(&a->ss, &b->ss, sizeof(real)) == 0 && a->status == b->status && a->stuck == b->stuck && a->liftoff == b->liftoff;
}

static void run_with(const kelly_engine *engine, const kelly_case *run, uint32_t first, uint32_t count, kelly_result *results)
{
    void *work = 0;

    if (posix_memalign(&work, 64, engine->work_size) != 0) {
        exit(1);
    }
    memset(work, 0xa5, engine->work_size);      /* contents of no meaning between calls */
    memset(results, 0x5a, count * sizeof(*results));
    engine->run(&kelly_string, run, 42, first, count, results, work);
    free(work);
}

static void compare(const kelly_engine *engine, const kelly_case *run, uint32_t first, uint32_t count, const char *what)
{
    static kelly_result one[MOST], many[MOST];
    const kelly_engine *list[4];
    unsigned differ = 0;

    (void)engines_usable(list);
    run_with(list[0], run, first, count, one);
    run_with(engine, run, first, count, many);
    for (uint32_t j = 0; j < count; j++) {
        differ += !same(&one[j], &many[j]);
    }
    EQUAL(differ, 0);
    if (differ > 0) {
        printf("    %s, %u realisations from %u on, %s\n", engine->name, count, first, what);
    }
}

static kelly_case nominal(uint32_t ticks)
{
    kelly_case run = kelly_string.nominal;

    run.ticks = ticks;
    run.window_first = ticks / 2;
    run.window_last = ticks;
    return run;
}

static void try_engine(const kelly_engine *engine)
{
    static const uint32_t counts[] = { 1, 3, 17, 65, MOST }, firsts[] = { 0, 1000, UINT32_MAX - (MOST - 1) };
    kelly_case run = nominal(2300);             /* past one fresh evaluation of the sine */

    for (unsigned c = 0; c < sizeof(counts) / sizeof(counts[0]); c++) {
        for (unsigned f = 0; f < sizeof(firsts) / sizeof(firsts[0]); f++) {
            compare(engine, &run, firsts[f], counts[c], "10 modes");
        }
    }
    run = nominal(500);
    run.torsional = 20;
    compare(engine, &run, 5, 65, "20 modes");
    run = nominal(500);
    run.torsional = 1;
    run.rotating = 1;
    compare(engine, &run, 5, 65, "1 mode, rotating");
    run = nominal(300);
    run.step_ns = 3000000;                      /* many are refused */
    compare(engine, &run, 0, MOST, "long step");
    run = nominal(500);
    run.fc = R(50000.0);                        /* many lift off */
    compare(engine, &run, 0, MOST, "lift-off");
}

/* The same under a soft drive, which has stepping of its own. */
static void try_soft(const kelly_engine *engine)
{
    static const uint32_t counts[] = { 1, 17, 65, MOST };
    kelly_case run = nominal(2300);

    run.drive = (kelly_drive){ .inertia = R(2900.0), .impedance = R(289.0), .hz = R(0.2) };
    for (unsigned c = 0; c < sizeof(counts) / sizeof(counts[0]); c++) {
        compare(engine, &run, 1000, counts[c], "10 modes, soft drive");
    }
    run.ticks = run.window_last = 500;
    run.window_first = 250;
    run.torsional = 20;
    run.rotating = 1;
    compare(engine, &run, 5, 65, "20 modes, rotating, soft drive");
    run.step_ns = 3000000;                      /* many are refused */
    compare(engine, &run, 0, MOST, "long step, soft drive");
}

/* Each number of vectors in a block has a loop of its own. */
static void try_each_number(const kelly_engine *engine)
{
    kelly_case run = nominal(300);

    for (unsigned soft = 0; soft < 2; soft++) {
        for (uint32_t vectors = 1; vectors <= engine->lanes / engine->width; vectors++) {
            compare(engine, &run, 7, (vectors - 1) * engine->width + 1, soft ? "part of a block, soft drive" : "part of a block");
        }
        run.drive = (kelly_drive){ .inertia = R(2900.0), .impedance = R(289.0), .hz = R(0.2) };
    }
}

int main(void)
{
    const kelly_engine *list[4];
    const unsigned engines = engines_usable(list);

    for (unsigned e = 0; e < engines; e++) {
        try_engine(list[e]);
        try_soft(list[e]);
        try_each_number(list[e]);
        printf("%s, %u realisations a vector, %u a block\n", list[e]->name, list[e]->width, list[e]->lanes);
    }
    printf("%u passed, %u failed\n", check_passed, check_failed);
    return check_failed != 0;
}
