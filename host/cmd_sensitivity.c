/* cmd_sensitivity.c - which of the random parameters the probability of stick-slip and the severity depend on. */
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "outcome.h"
#include "team.h"

#define ROWS_LEAST (2 * KELLY_SOBOL_GROUPS)   /* that give an index: 64 */
#define SS_MOST 10.0             /* what ss is where max + min <= 0; nothing counts for more */

static const char *const names[KELLY_PARAMETERS] = { "fc", "mu", "a1", "a2", "rpm" };

enum { OF_STUCK, OF_SS, MEASURES };
static const char *const measures[MEASURES] = { "probability", "ss" };

/* What comes out. */
typedef struct {
    const options *opts;
    const kelly_engine *engine;
    unsigned random, which[KELLY_PARAMETERS];
    kelly_sobol of[MEASURES];
    kelly_tally tally;           /* over all runs of all rows */
    uint32_t rows, left_out;     /* asked for; without the ones that have a refused run */
    uint32_t refused[LISTED];
    uint8_t why[LISTED];
    double seconds;
} findings;

static const kelly_engine *engine;   /* chosen once, before the threads start */

/* Scratch of a thread: the engine's, then the draws of a piece. */
static size_t draws_at(void)
{
    return (engine->work_size + 63) / 64 * 64;
}

/* The rows of a piece, one after another; `width` rows fill whole vectors. */
static void work_rows(const options *opts, uint32_t first, uint32_t count, void *results, void *work)
{
    kelly_draw *const draws = (kelly_draw *)(void *)((char *)work + draws_at());
    kelly_result *const r = results;
    const unsigned most = engine_lanes(engine, &opts->run);
    uint32_t n = 0, step;

    for (uint32_t j = 0; j < count; j++) {
        n += kelly_sobol_row(&opts->run, opts->seed, first + j, &draws[n]);
    }
    for (uint32_t done = 0; done < n; done += step) {
        step = n - done < most ? n - done : most;
        engine_run_draws(engine, opts, draws + done, step, r + done, work);
    }
}

/* Why a row has a run without a result, or KELLY_OK. */
static uint8_t row_status(const kelly_result *r, unsigned runs)
{
    for (unsigned i = 0; i < runs; i++) {
        if (r[i].status != KELLY_OK) {
            return r[i].status;
        }
    }
    return KELLY_OK;
}

static void take_row(findings *out, uint32_t index, const kelly_result *r, unsigned runs)
{
    const uint8_t status = row_status(r, runs);
    double f[MEASURES][KELLY_SOBOL_ROW];

    for (unsigned i = 0; i < runs; i++) {
        kelly_tally_add(&out->tally, index, &r[i]);
        f[OF_STUCK][i] = r[i].stuck;
        f[OF_SS][i] = (double)r[i].ss < SS_MOST ? (double)r[i].ss : SS_MOST;
    }
    out->rows++;
    if (status != KELLY_OK) {
        if (out->left_out < LISTED) {
            out->refused[out->left_out] = index;
            out->why[out->left_out] = status;
        }
        out->left_out++;
        return;
    }
    for (unsigned m = 0; m < MEASURES; m++) {
        kelly_sobol_add(&out->of[m], f[m]);
    }
}

static void take_batch(void *context, uint32_t first, uint32_t count, const void *results)
{
    findings *const out = context;
    const kelly_result *const r = results;
    const unsigned runs = 2 + out->random;

    for (uint32_t j = 0; j < count; j++) {
        take_row(out, first + j, r + (size_t)j * runs, runs);
    }
}

static uint32_t listed(const findings *out)
{
    return out->left_out < LISTED ? out->left_out : LISTED;
}

static void write_estimate(FILE *to, const kelly_estimate *e)
{
    fprintf(to, "{\"value\": %.9g, \"ci95\": [%.9g, %.9g]}", (double)e->value, (double)e->lo, (double)e->hi);
}

/* Both indices of every parameter; null where there are none, one that is not random has none. */
static void write_measure(FILE *to, const findings *out, unsigned m)
{
    const kelly_sobol *const s = &out->of[m];
    wide mean, variance;

    kelly_sobol_moments(s, &mean, &variance);
    if (s->rows > 0) {
        fprintf(to, "  \"%s\": {\"mean\": %.17g, \"variance\": %.17g, \"indices\": {", measures[m], (double)mean, (double)variance);
    } else {
        fprintf(to, "  \"%s\": {\"mean\": null, \"variance\": null, \"indices\": {", measures[m]);
    }
    for (unsigned i = 0; i < out->random; i++) {
        kelly_estimate first, total;

        fprintf(to, "%s\n    \"%s\": ", i ? "," : "", names[out->which[i]]);
        if (kelly_sobol_read(s, i, &first, &total)) {
            fputs("{\"first\": ", to);
            write_estimate(to, &first);
            fputs(", \"total\": ", to);
            write_estimate(to, &total);
            fputs("}", to);
        } else {
            fputs("null", to);
        }
    }
    fputs("}},\n", to);
}

static void write_json(FILE *to, const findings *out)
{
    const kelly_case *const run = &out->opts->run;
    char drive[DRIVE_TEXT];

    fputs("{\n", to);
    for (unsigned m = 0; m < MEASURES; m++) {
        write_measure(to, out, m);
    }
    fprintf(to, "  \"method\": \"first: Saltelli 2010, total: Jansen 1999; interval: jackknife over %d groups\",\n", KELLY_SOBOL_GROUPS);
    fprintf(to, "  \"rows\": %u,\n  \"rows_left_out\": %u,\n  \"rows_left_out_first\": [", out->rows, out->left_out);
    for (uint32_t i = 0; i < listed(out); i++) {
        fprintf(to, "%s[%u, \"%s\"]", i ? ", " : "", out->refused[i], status_names[out->why[i]]);
    }
    fprintf(to, "],\n  \"realisations\": %u,\n  \"refused\": %u,\n  \"liftoff\": %u,\n  \"seed\": %llu,\n  \"first\": %u,\n  \"digest\": \"%08x\",\n",
            out->tally.samples, kelly_refused(&out->tally), out->tally.liftoff, (unsigned long long)out->opts->seed, out->opts->first,
            out->tally.digest);
    fprintf(to, "  \"case\": {\"rpm\": %.9g, \"wob_kN\": %.9g, \"mu\": %.9g, \"alpha1\": %.9g, \"alpha2\": %.9g, \"f0_kN\": %.9g, \"start\": \"%s\", \"limit\": %.9g,\n"
            "           \"drive\": \"%s\", \"cov\": {\"fc\": %.9g, \"mu\": %.9g, \"a1\": %.9g, \"a2\": %.9g, \"rpm\": %.9g}},\n",
            (double)run->w0 / RPM, (double)run->fc / 1000.0, (double)run->mu, (double)run->a1, (double)run->a2, (double)run->f0 / 1000.0,
            run->rotating ? "rotating" : "rest", (double)run->limit, drive_text(&run->drive, drive), (double)run->cov[0], (double)run->cov[1], (double)run->cov[2],
            (double)run->cov[3], (double)run->cov[4]);
    fprintf(to, "  \"real\": \"%s\",\n  \"model\": \"%s\",\n  \"engine\": \"%s\",\n  \"seconds\": %.6f\n}\n", sizeof(real) > 4 ? "double" : "float",
            kelly_string.id, out->engine->name, out->seconds);
}

static void print_measure(const findings *out, unsigned m)
{
    const kelly_sobol *const s = &out->of[m];
    const char *const what = m == OF_STUCK ? "stick-slip (P)" : "severity ss";
    wide mean, variance;

    if (s->rows == 0) {
        printf("%s: unknown: every row was left out\n", what);
        return;
    }
    kelly_sobol_moments(s, &mean, &variance);
    printf("%s: mean %.4f, variance %.4f\n", what, (double)mean, (double)variance);
    for (unsigned i = 0; i < out->random; i++) {
        kelly_estimate f, t;

        if (kelly_sobol_read(s, i, &f, &t)) {
            printf("  %-5s first %6.3f   %6.3f .. %6.3f     total %6.3f   %6.3f .. %6.3f\n", names[out->which[i]], (double)f.value, (double)f.lo,
                   (double)f.hi, (double)t.value, (double)t.lo, (double)t.hi);
        } else {
            printf("  %-5s no index: %s\n", names[out->which[i]], s->rows < ROWS_LEAST ? "under 64 rows count" : variance > 0 ? "it varies too seldom" : "it does not vary");
        }
    }
}

static void print_outcome(const findings *out)
{
    const kelly_case *const run = &out->opts->run;
    char drive[DRIVE_TEXT];

    printf("%s, %.6g rpm, %.6g kN, f0 %.6g kN, mu %.6g, alpha1 %.6g, alpha2 %.6g, start %s, limit %.6g%s\n", kelly_string.id, (double)run->w0 / RPM,
           (double)run->fc / 1000.0, (double)run->f0 / 1000.0, (double)run->mu, (double)run->a1, (double)run->a2, run->rotating ? "rotating" : "rest",
           (double)run->limit, drive_remark(&run->drive, drive));
    print_measure(out, OF_STUCK);
    print_measure(out, OF_SS);
    printf("%u rows, %u left out, %u realisations, seed %llu, digest %08x, %s, %s, %.2f s\n", out->rows, out->left_out, out->tally.samples,
           (unsigned long long)out->opts->seed, out->tally.digest, sizeof(real) > 4 ? "double" : "float", out->engine->name, out->seconds);
    outcome_warn(run, &out->tally);
    for (uint32_t i = 0; i < listed(out); i++) {
        printf("%s%u (%s)", i ? ", " : "left out: ", out->refused[i], status_names[out->why[i]]);
    }
    if (listed(out) > 0) {
        puts(out->left_out > LISTED ? ", ..." : "");
    }
}

static double now(void)
{
    struct timespec t;

    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static const option_help own_options[] = {
    { "--samples", "N", "rows, each of up to 7 realisations; 64 at least for intervals (default 400)" },
    { "--cov", "D", "coefficients of variation 0..0.5: one for all, or fc=D,mu=D,a1=D,a2=D,rpm=D (default: the well file's)" },
    { "--seed", "S", "of the random streams (default 1)" },
    { "--first", "J", "index of the first row (default 0)" },
    { "--threads", "T", "threads (default: one a processor); no result depends on it" },
    { "--engine", "NAME", "vector unit: scalar, sse2, avx2, avx512 (default: the widest here); no result depends on it" },
    { "--twice", 0, TWICE_HELP },
    { 0 },
};

const command_help sensitivity_help = {
    .brief = "which random parameter P and the severity depend on (Sobol indices)",
    .synopsis = "[case] [--samples N] [--cov D] [--seed S] [--json F] [--resume] ...",
    .takes = TAKES_CASE | TAKES_JSON | TAKES_RESUME,
    .own = own_options,
    .notes = "A sample is a row of 7 realisations: A, B, and A with one parameter of B for each that is random (--cov).\n"
             "first: share of the variance that goes once this parameter is known. total: share that stays while it alone is not.\n"
             "Their sum differs from 1 as far as parameters act together. Intervals of 95 % by the jackknife; they may pass 0 and 1.\n"
             "probability: of the indicator ss > limit; ss: of the severity itself, 10 at most. A row with a refused run is left out and named.\n"
             "F.json.journal beside the JSON holds what is done and goes when all is written.",
    .example = "kelly sensitivity --mu 0.004 --samples 2000 --json sobol.json",
};

int command_sensitivity(int argc, char **argv)
{
    static findings out;
    static journal log;
    options opts;
    outfile json = { 0 };
    const char *beside;
    char text[ADVICE_TEXT];
    const double start = now();

    options_parse(&opts, argc, argv, TAKES_CASE | TAKES_ENSEMBLE | TAKES_JSON | TAKES_RESUME, "sensitivity", 0, 0);
    if (opts.csv || opts.convergence) {
        die(EXIT_USAGE, "%s does not belong to sensitivity; give --json F", opts.csv ? "--csv" : "--convergence");
    }
    check_indices(&opts);
    engine = engine_choose(opts.engine);
    out.opts = &opts;
    out.engine = engine;
    out.random = kelly_sobol_random(&opts.run, out.which);
    if (out.random == 0) {
        die(EXIT_USAGE, "--cov: nothing is random; give --cov 0.2 or some of fc=,mu=,a1=,a2=,rpm=");
    }
    for (unsigned m = 0; m < MEASURES; m++) {
        kelly_sobol_clear(&out.of[m], out.random);
    }
    beside = outcome_beside(&opts);
    if (opts.json && team_rank() == 0) {
        outfile_open(&json, opts.json);
    }
    job_log(&log, &opts, beside, &(journal_run){ .kind = "sensitivity", .records = opts.samples,
            .payload = (uint32_t)((2 + out.random) * sizeof(kelly_result)), .in_order = 1, .sound = results_sound });
    run_job(&opts, &(job){ .work = work_rows, .work_size = draws_at() + (size_t)engine->width * KELLY_SOBOL_ROW * sizeof(kelly_draw),
                           .result_size = (2 + out.random) * sizeof(kelly_result), .width = engine->width, .lanes = engine->width,
                           .log = &log }, take_batch, &out);
    if (team_rank() > 0) {
        return EXIT_DONE;
    }
    out.seconds = now() - start;
    if (opts.json) {
        write_json(json.stream, &out);
        outfile_close(&json);
    }
    journal_remove(&log);
    if (!opts.quiet && !(opts.json && strcmp(opts.json, "-") == 0)) {
        print_outcome(&out);
    }
    if (out.left_out == out.rows || (out.rows >= ROWS_LEAST && out.rows - out.left_out < ROWS_LEAST)) {
        die(EXIT_FAILED, "sensitivity: no answer: %u of %u rows hold a realisation that cannot be trusted: %s", out.left_out, out.rows,
            advice_on(&opts.run, &out.tally, text));
    }
    return EXIT_DONE;
}
