/* cmd_plan.c - how long a large ensemble takes, and in how much memory, on how many cores: on paper and in a simulated run.
 *
 * Measured here, in about a second: blocks of the case on one core, one after another, and what the leader does with each result. Under
 * mpirun also what MPI takes to start, the leader's time for an errand and the way of a message; alone these are assumed, and said.
 * The simulation stands in plan_run.c.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <time.h>
#include <unistd.h>

#include "../firmware/link/crc32c.h"
#include "outcome.h"
#include "plan.h"
#include "team.h"

#define RUN 64u                  /* cores of one run of an array */
#define ROWS 8u
#define PINGS 1000u              /* errands of one measurement */

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
    { "--startup", "S", "mpirun and MPI until the first errand [s], and a millisecond a rank (default: measured under mpirun, else 1)" },
    { "--message", "US", "of the leader for an errand: to give it and to take its results [us] (default: measured, else 20)" },
    { "--way", "US", "of a message between two ranks [us] (default: measured, else 100)" },
    { "--measure", "S", "seconds of measuring, 0.05..60 (default 1)" },
    { "--engine", "NAME", "vector unit: scalar, sse2, avx2, avx512 (default: the widest here)" },
    { 0 },
};

const command_help plan_help = {
    .brief = "time and memory of a large ensemble on many cores, on paper and simulated",
    .synopsis = "[--samples N] [--cores N] [case] [--json F]",
    .takes = TAKES_CASE | TAKES_JSON,
    .own = plan_options,
    .notes = "Measures this case on one core of this machine; what else runs there is left out. One MPI run ends where its leader has no\n"
             "time left; an array of runs (--first, --samples; kelly merge) does not.\n"
             "mpirun -n 2 build/mpi/kelly plan measures what MPI takes too.",
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

static double seconds_of(clockid_t clock)
{
    struct timespec t;

    clock_gettime(clock, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Of this thread alone: what else runs on the machine is left out. */
static double busy(void)
{
    return seconds_of(CLOCK_THREAD_CPUTIME_ID);
}

/* Counts, record of the journal and, where lines are wanted, their text: the leader's part of `count` results. */
static double leader_time(plan *p, outcome *out, const kelly_result *results, uint32_t count)
{
    const double start = busy();

    outcome_take(out, 0, count, results);
    for (uint32_t i = 0; i < count; i++) {
        p->sum += kelly_crc32c(0, (const uint8_t *)&results[i], sizeof(results[i]));
    }
    return (busy() - start) / count;
}

/* Also who of what was measured can be trusted: EXIT_DONE, or EXIT_FAILED and said where nobody can. */
static int measure(plan *p)
{
    const double start = busy();
    kelly_result *const results = calloc(p->lanes, sizeof(*results));
    void *work = 0;
    static outcome out, all;
    options opts = p->opts;
    double least = HUGE_VAL;

    if (!results || posix_memalign(&work, 64, p->engine->work_size) != 0) {
        die(EXIT_FAILED, "out of memory");
    }
    while (p->blocks < BLOCKS && (p->blocks < 3 || busy() - start < p->measure)) {
        const double before = busy();

        p->engine->run(&kelly_string, &p->opts.run, p->opts.seed, p->blocks * p->lanes, p->lanes, results, work);
        p->block[p->blocks++] = busy() - before;
        for (uint32_t i = 0; i < p->lanes; i++) {
            kelly_tally_add(&all.tally, i, &results[i]);
        }
    }
    p->rate = p->blocks * p->lanes / (busy() - start);
    opts.csv = p->lines ? "/dev/null" : 0;
    opts.json = 0;
    outcome_open(&out, &opts, p->engine->name);
    for (unsigned k = 0; k < 20; k++) {
        least = fmin(least, leader_time(p, &out, results, p->lanes));
    }
    p->leader = least;
    free(work);
    free(results);
    all.opts = &opts;
    return outcome_answered(&all);
}

/* ---- measured between ranks -------------------------------------------------------------------------------------- */

typedef struct {
    uint32_t left, count;        /* errands to be given; results of each */
    uint32_t places;             /* errands under way at most */
    kelly_result *results;
} ping;

static int give_ping(void *context, errand *e)
{
    ping *const p = context;

    *e = (errand){ .count = p->count, .results = p->results + (size_t)(p->left % p->places) * p->count };
    return p->left > 0 && p->left-- > 0;
}

static void take_ping(void *context, const errand *e)
{
    (void)context, (void)e;
}

static int pings_over(void *context)
{
    const ping *const p = context;

    return p->left == 0;
}

static void answer_ping(void *context, const errand *e)
{
    (void)context, (void)e;
}

/* Seconds since the process that started this one began: that is mpirun, on the machine where it was called. */
static double since_mpirun(void)
{
    char path[64], text[1024] = "";
    unsigned long long ticks = 0;
    const char *at;
    char *end = 0;
    FILE *from;

    snprintf(path, sizeof(path), "/proc/%d/stat", (int)getppid());
    from = fopen(path, "r");
    if (from) {
        (void)!fgets(text, sizeof(text), from);
        (void)fclose(from);
    }
    at = strrchr(text, ')');
    for (unsigned field = 0; at && field < 20; field++) {   /* the 20th behind the name */
        at = strchr(at + 1, ' ');
    }
    ticks = at ? strtoull(at, &end, 10) : 0;
    if (!at || end == at) {
        die(EXIT_FAILED, "%s: cannot be read; give --startup S", path);
    }
    return seconds_of(CLOCK_BOOTTIME) - (double)ticks / (double)sysconf(_SC_CLK_TCK);
}

static double memory_used(void)
{
    struct rusage use;

    getrusage(RUSAGE_SELF, &use);
    return 1024.0 * (double)use.ru_maxrss;
}

/* One errand, there and back; the leader's own time in many. Other work on the machine can only add: the least of several. */
static void measure_team(plan *p)
{
    const uint32_t places = TEAM_DEPTH * team_others();
    ping all = { .count = p->lanes, .places = places, .results = places > 0 ? calloc((size_t)places * p->lanes, sizeof(kelly_result)) : 0 };
    const team_source source = { &all, give_ping, take_ping, pings_over, sizeof(kelly_result) };
    const double before = memory_used();
    double both = HUGE_VAL, own = HUGE_VAL, starting;

    if (!all.results) {
        die(EXIT_FAILED, "out of memory");
    }
    all.left = 1;
    team_lead(&source);
    starting = since_mpirun();
    for (unsigned k = 0; k < 100; k++) {
        const double at = seconds_of(CLOCK_MONOTONIC);

        all.left = 1;
        team_lead(&source);
        both = fmin(both, seconds_of(CLOCK_MONOTONIC) - at);
    }
    for (unsigned k = 0; k < 20; k++) {
        const double at = busy();

        all.left = PINGS;
        team_lead(&source);
        own = fmin(own, (busy() - at) / PINGS);
    }
    team_dismiss();
    free(all.results);
    p->startup = p->startup < 0 ? fmax(0, starting - p->startup_rank * (team_others() + 1)) : p->startup;
    p->message = p->message < 0 ? own : p->message;
    p->way = p->way < 0 ? fmax(0, both - own) / 2 : p->way;
    p->process = memory_used() - before;
    p->team = 1;
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
    const double batch = plan_batch(cores, p->samples);

    return memory_used() + (cores > 1 ? p->process : 0.0) + batch * (sizeof(kelly_result) + 9.0) + (double)p->engine->work_size;
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
    printf("%s   start-up %.3g s and %.3g ms a rank, an errand %.3g us of the leader and %.3g us a way, %.0f MB a process for MPI\n",
           p->team ? "measured" : "assumed ", p->startup,
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
    fprintf(to, "  \"mpi\": {\"measured\": %s, \"startup_s\": %.9g, \"startup_rank_s\": %.9g, \"message_s\": %.9g, \"way_s\": %.9g, \"process_bytes\": %.9g},\n",
            p->team ? "true" : "false", p->startup,
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
    static plan p = { .samples = 1000000000u, .cores = 10000, .measure = 1.0, .startup = -1, .startup_rank = 1e-3, .message = -1, .way = -1,
                      .process = 30e6 };
    row rows[ROWS];
    unsigned count = 0;
    outfile json = { 0 };

    options_parse(&p.opts, argc, argv, TAKES_CASE | TAKES_JSON, "plan", own_option, &p);
    p.engine = p.engine ? p.engine : engine_choose(0);
    p.lanes = engine_lanes(p.engine, &p.opts.run);
    if (team_rank() > 0) {
        team_follow(answer_ping, 0, sizeof(kelly_result));
        return EXIT_DONE;
    }
    if (p.opts.json) {
        outfile_open(&json, p.opts.json);
    }
    if (team_others() > 0) {
        measure_team(&p);
    }
    p.startup = p.startup < 0 ? 1.0 : p.startup;
    p.message = p.message < 0 ? 20e-6 : p.message;
    p.way = p.way < 0 ? 100e-6 : p.way;
    if (measure(&p) != EXIT_DONE) {
        if (p.opts.json) {
            outfile_drop(&json);
        }
        return EXIT_FAILED;
    }
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
