/* cmd_plan.c - how long a large ensemble takes, and in how much memory, on how many cores: on paper and in a simulated run.
 *
 * Measured here, in about a second: blocks of the case on one core, one after another, and what the leader does with each result. The
 * rest is assumed and said: what MPI takes to start, and the leader's time and the way of a message.
 * The simulation stands in simulate.c.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <time.h>

#include "../firmware/link/crc32c.h"
#include "plan.h"

#define RUN 64u                  /* cores of one run of an array */
#define ROWS 8u

typedef struct {
    uint32_t cores;
    double paper, simulated;     /* [s] */
    double efficiency;           /* simulated: work over cores x time */
    double first, all;           /* memory [bytes] */
    uint32_t runs;               /* of an array, RUN cores each or fewer */
    double array;                /* its time, all runs at once, and the merge [s] */
} row;

static const option_help plan_options[] = {
    { "--samples", "N", "realisations (default 1000000000)" },
    { "--cores", "N", "the largest number of cores, 1..1000000 (default 10000); 1, 10, 100, ... are shown up to it" },
    { "--lines", "yes|no", "with --csv, a line a realisation (default no)" },
    { "--startup", "S", "mpirun and MPI until the first errand [s] (default 1, and a millisecond a rank)" },
    { "--message", "US", "of the leader for an errand: to give it and to take its results [us] (default 10)" },
    { "--way", "US", "of a message between two ranks [us] (default 20)" },
    { "--measure", "S", "seconds of measuring, 0.05..60 (default 1)" },
    { "--engine", "NAME", "vector unit: scalar, sse2, avx2, avx512 (default: the widest here)" },
    { 0 },
};

const command_help plan_help = {
    .brief = "time and memory of a large ensemble on many cores, on paper and simulated",
    .synopsis = "[--samples N] [--cores N] [case] [--json F]",
    .takes = TAKES_CASE | TAKES_JSON,
    .own = plan_options,
    .notes = "Measures this case on one core of this machine; nothing else should run meanwhile. One MPI run ends where its leader has no\n"
             "time left; an array of runs (--first, --samples; kelly merge) does not.",
    .example = "kelly plan --samples 1000000000 --cores 10000 --mu 0.004",
};

static int own_option(void *context, const char *name, const char *value)
{
    plan *const p = context;

    if (strcmp(name, "--samples") == 0) {
        p->samples = (uint32_t)option_whole(name, value, 1, UINT32_MAX, "a number of realisations, 1..4294967295");
    } else if (strcmp(name, "--cores") == 0) {
        p->cores = (uint32_t)option_whole(name, value, 1, 1000000, "a number of cores, 1..1000000");
    } else if (strcmp(name, "--lines") == 0) {
        if (strcmp(value, "yes") != 0 && strcmp(value, "no") != 0) {
            die(EXIT_USAGE, "--lines %s: unknown; give yes or no", value);
        }
        p->lines = strcmp(value, "yes") == 0;
    } else if (strcmp(name, "--startup") == 0) {
        p->startup = option_number(name, value, 0.0, 3600.0, "seconds, 0..3600");
    } else if (strcmp(name, "--message") == 0) {
        p->message = 1e-6 * option_number(name, value, 0.0, 1e6, "microseconds, 0..1000000");
    } else if (strcmp(name, "--way") == 0) {
        p->way = 1e-6 * option_number(name, value, 0.0, 1e6, "microseconds, 0..1000000");
    } else if (strcmp(name, "--measure") == 0) {
        p->measure = option_number(name, value, 0.05, 60.0, "seconds, 0.05..60");
    } else if (strcmp(name, "--engine") == 0) {
        p->engine = engine_choose(value);
    } else {
        return 0;
    }
    return 1;
}

/* ---- measured ----------------------------------------------------------------------------------------------------- */

static double now(void)
{
    struct timespec t;

    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Tally, record of the journal and, where lines are wanted, their text: the leader's part of `count` results. */
static double leader_time(plan *p, const kelly_result *results, uint32_t count)
{
    const double start = now();
    kelly_tally tally = { 0 };
    char line[512];

    for (uint32_t i = 0; i < count; i++) {
        const kelly_result *const r = &results[i];
        int n = 0;

        kelly_tally_add(&tally, i, r);
        p->sum += kelly_crc32c(0, (const uint8_t *)r, sizeof(*r));
        if (p->lines) {
            n = sprintf(line, "%u,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g", i, (double)r->draw.fc, (double)r->draw.mu, (double)r->draw.a1,
                        (double)r->draw.a2, (double)r->draw.w0, (double)r->lowest, (double)r->highest, (double)r->mean, (double)r->ss);
            p->sum += kelly_crc32c(0, (const uint8_t *)line, (size_t)n);
        }
    }
    return (now() - start) / count;
}

static void measure(plan *p)
{
    const double start = now();
    kelly_result *const results = calloc(p->lanes, sizeof(*results));
    void *work = 0;
    double least = HUGE_VAL;

    if (!results || posix_memalign(&work, 64, p->engine->work_size) != 0) {
        die(EXIT_FAILED, "out of memory");
    }
    while (p->blocks < BLOCKS && (p->blocks < 3 || now() - start < p->measure)) {
        const double before = now();

        p->engine->run(&kelly_string, &p->opts.run, p->opts.seed, p->blocks * p->lanes, p->lanes, results, work);
        p->block[p->blocks++] = now() - before;
    }
    p->rate = p->blocks * p->lanes / (now() - start);
    for (unsigned k = 0; k < 20; k++) {
        least = fmin(least, leader_time(p, results, p->lanes));
    }
    p->leader = least;
    free(work);
    free(results);
}

/* ---- on paper ------------------------------------------------------------------------------------------------------- */

/* All cores at work; or as many errands as the leader can give, and the work of its own thread, where that takes longer. Then what the
 * leader does alone. */
static double on_paper(const plan *p, uint32_t cores, uint32_t samples)
{
    const double work = samples / (cores * p->rate), given = p->lanes / fmax(p->message, 1e-12);

    return plan_starting(p, cores) + fmax(work, samples / (given + p->rate)) + samples * p->leader;
}

static double memory_first(const plan *p, uint32_t cores)
{
    struct rusage use;
    const double batch = plan_batch(cores, p->samples);

    getrusage(RUSAGE_SELF, &use);
    return 1024.0 * (double)use.ru_maxrss + (cores > 1 ? p->process : 0.0) + batch * (sizeof(kelly_result) + 9.0) + (double)p->engine->work_size;
}

static row plan_row(const plan *p, uint32_t cores)
{
    const uint32_t per_run = cores < RUN ? cores : RUN, runs = (cores + per_run - 1) / per_run;
    const uint32_t share = (uint32_t)(((uint64_t)p->samples + runs - 1) / runs);
    const double other = memory_first(p, 1) - plan_batch(1, p->samples) * (sizeof(kelly_result) + 9.0) + p->process;
    row r = { .cores = cores, .runs = runs };
    double worked;

    r.paper = on_paper(p, cores, p->samples);
    r.simulated = plan_simulate(p, cores, p->samples, &worked);
    r.efficiency = worked / (cores * r.simulated);
    r.first = memory_first(p, cores);
    r.all = r.first + (cores - 1) * other;
    r.array = plan_simulate(p, per_run, share, &worked) + 1e-3 * runs;   /* merge: a millisecond a report */
    return r;
}

/* ---- output --------------------------------------------------------------------------------------------------------- */

static const char *human(double seconds, char text[24])
{
    const double size[] = { 1, 60, 3600, 86400 };
    static const char *const unit[] = { "s", "min", "h", "d" };
    const unsigned k = seconds < 120 ? 0 : seconds < 7200 ? 1 : seconds < 172800 ? 2 : 3;

    snprintf(text, 24, "%.4g %s", seconds / size[k], unit[k]);
    return text;
}

static void print_plan(const plan *p, const row *rows, unsigned count)
{
    const double record = 4 + 9.0 * sizeof(real) + 4 + 4;
    char a[24], b[24], c[24];

    printf("%u realisations, %u steps each, %s\n", p->samples, p->opts.run.window_last, sizeof(real) > 4 ? "double" : "float");
    printf("measured   %.0f realisations a second and core (%s, %u blocks of %u), leader %.2f us a result%s\n", p->rate, p->engine->name, p->blocks,
           p->lanes, 1e6 * p->leader, p->lines ? " with its line" : "");
    printf("assumed    start-up %.3g s and %.3g ms a rank, an errand %.3g us of the leader and %.3g us a way, %.0f MB a process for MPI\n", p->startup,
           1e3 * p->startup_rank, 1e6 * p->message, 1e6 * p->way, p->process / 1e6);
    printf("journal    %.4g GB%s\n\n", p->samples * record / 1e9, p->lines ? ", CSV about 115 bytes a line in float" : "");
    printf("%8s %12s %12s %11s %10s %10s   %s\n", "cores", "on paper", "simulated", "efficiency", "first rank", "all ranks", "array of runs, merged");
    for (unsigned i = 0; i < count; i++) {
        printf("%8u %12s %12s %11.3f %7.0f MB %7.2f GB   %u x %u cores: %s\n", rows[i].cores, human(rows[i].paper, a), human(rows[i].simulated, b),
               rows[i].efficiency, rows[i].first / 1e6, rows[i].all / 1e9, rows[i].runs, rows[i].cores < RUN ? rows[i].cores : RUN,
               human(rows[i].array, c));
    }
}

static void write_plan(FILE *to, const plan *p, const row *rows, unsigned count)
{
    fprintf(to, "{\n  \"samples\": %u,\n  \"rate\": %.17g,\n  \"blocks\": %u,\n  \"lanes\": %u,\n  \"engine\": \"%s\",\n  \"leader_s\": %.9g,\n", p->samples, p->rate,
            p->blocks, p->lanes, p->engine->name, p->leader);
    fprintf(to, "  \"assumed\": {\"startup_s\": %.9g, \"startup_rank_s\": %.9g, \"message_s\": %.9g, \"way_s\": %.9g, \"mpi_bytes\": %.9g},\n", p->startup,
            p->startup_rank, p->message, p->way, p->process);
    fputs("  \"rows\": [\n", to);
    for (unsigned i = 0; i < count; i++) {
        fprintf(to, "    {\"cores\": %u, \"paper_s\": %.9g, \"simulated_s\": %.9g, \"efficiency\": %.6f, \"first_bytes\": %.0f, \"all_bytes\": %.0f, "
                "\"runs\": %u, \"array_s\": %.9g}%s\n", rows[i].cores, rows[i].paper, rows[i].simulated, rows[i].efficiency, rows[i].first, rows[i].all,
                rows[i].runs, rows[i].array, i + 1 < count ? "," : "");
    }
    fputs("  ]\n}\n", to);
}

int command_plan(int argc, char **argv)
{
    static plan p = { .samples = 1000000000u, .cores = 10000, .measure = 1.0, .startup = 1.0, .startup_rank = 1e-3, .message = 10e-6, .way = 20e-6,
                      .process = 30e6 };
    row rows[ROWS];
    unsigned count = 0;
    outfile json;

    options_parse(&p.opts, argc, argv, TAKES_CASE | TAKES_JSON, "plan", own_option, &p);
    p.engine = p.engine ? p.engine : engine_choose(0);
    p.lanes = engine_lanes(p.engine, &p.opts.run);
    if (p.opts.json) {
        outfile_open(&json, p.opts.json);
    }
    measure(&p);
    for (uint32_t cores = 1; cores < p.cores; cores *= 10) {
        rows[count++] = plan_row(&p, cores);
    }
    rows[count++] = plan_row(&p, p.cores);
    if (p.opts.json) {
        write_plan(json.stream, &p, rows, count);
        outfile_close(&json);
    }
    if (!p.opts.quiet && !(p.opts.json && strcmp(p.opts.json, "-") == 0)) {
        print_plan(&p, rows, count);
    }
    return EXIT_DONE;
}
