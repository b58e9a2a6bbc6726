/* cmd_rare.c - small probabilities of stick-slip: the kernel's subset simulation over threads and lanes. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "map.h"
#include "outcome.h"
#include "team.h"

#define DEFAULT_SAMPLES 2400u
#define NEAR 0.02                /* a top speed this near 60 f_i, as a ratio, counts as resonance */
#define SHOWN 0.01               /* least share of the failures that is told */

/* One run. */
typedef struct {
    const options *opts;
    const kelly_engine *engine;
    uint32_t samples;            /* a level */
    kelly_rare rare;
    kelly_rare_estimate answer;
    outcome out;                 /* all realisations, their index the order of proposal */
    kelly_draw *draws;
    journal log;
    double seconds;
} search;

static search now_on;            /* what run_job's pieces are of */

static const char *const names[KELLY_PARAMETERS] = { "wob_kN", "mu", "alpha1", "alpha2", "rpm" };
static const double units[KELLY_PARAMETERS] = { 1000.0, 1.0, 1.0, 1.0, RPM };

/* ---- the search ---------------------------------------------------------------------------------------------- */

static void work_piece(const options *opts, uint32_t first, uint32_t count, void *results, void *work)
{
    now_on.engine->run_draws(&kelly_string, &opts->run, &now_on.draws[first], count, results, work);
}

static void take_batch(void *context, uint32_t first, uint32_t count, const void *results)
{
    search *const s = context;
    const kelly_result *const r = results;

    for (uint32_t i = 0; i < count; i++) {
        s->rare.samples[s->rare.first + first + i].guide = kelly_rare_guide(&kelly_string, &s->opts->run, &r[i]);
    }
    outcome_take(&s->out, s->out.tally.samples, count, results);
}

/* Run what the kernel has proposed; each proposal is an ensemble of its own for run_job. */
static void evaluate(search *s)
{
    options part = *s->opts;

    part.first = 0;
    part.samples = kelly_rare_count(&s->rare);
    part.progress = PROGRESS_NONE;
    for (uint32_t i = 0; i < part.samples; i++) {
        kelly_rare_draw(&s->opts->run, &s->rare.samples[s->rare.first + i], &s->draws[i]);
    }
    run_job(&part, &(job){ .work = work_piece, .work_size = s->engine->work_size, .result_size = sizeof(kelly_result),
                           .width = s->engine->width, .lanes = engine_lanes(s->engine, &s->opts->run), .log = &s->log,
                           .inputs = s->draws, .input_size = sizeof(*s->draws), .more = 1 }, take_batch, s);
}

static double now(void)
{
    struct timespec t;

    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* The total is not known before the end: it shows what is done of what the present level still needs. */
static void show(const search *s, double start)
{
    const uint64_t level = s->samples - s->samples / KELLY_RARE_STATES;

    if (progress_wanted(s->opts)) {
        progress_show(s->opts, s->rare.realisations, s->samples + s->rare.level * level, now() - start);
    }
}

static void run_search(search *s)
{
    const double start = now();
    kelly_rare_sample *const samples = calloc(s->samples, sizeof(*samples));
    uint32_t *const keys = calloc(s->samples, sizeof(*keys));
    const kelly_rare_string string = { &kelly_string, &s->opts->run };
    const char *error;

    s->draws = calloc(s->samples, sizeof(*s->draws));
    if (!samples || !keys || !s->draws) {
        die(EXIT_FAILED, "out of memory");
    }
    error = kelly_rare_start(&s->rare, s->opts->run.cov, s->opts->seed, s->samples, samples, keys);
    if (error) {
        die(EXIT_USAGE, "rare: %s", error);
    }
    kelly_rare_lead(&s->rare, kelly_rare_guess, &string);
    if (team_rank() > 0) {       /* which levels there are is the first process's to know */
        evaluate(s);
        return;
    }
    while (kelly_rare_count(&s->rare) > 0) {
        evaluate(s);
        show(s, start);
        kelly_rare_accept(&s->rare);
    }
    team_dismiss();
    if (s->rare.state == KELLY_RARE_DONE) {
        kelly_rare_read(&s->rare, &s->answer);
    }
    s->seconds = now() - start;
    if (progress_wanted(s->opts)) {
        progress_end(s->opts, s->rare.realisations, s->seconds);
    }
}

/* ---- where the failures lie ---------------------------------------------------------------------------------- */

typedef struct {
    double mean, sd, low, median, high;   /* 2.5, 50, 97.5 % */
} place;

static double parameter(const kelly_draw *draw, unsigned k)
{
    const double value[KELLY_PARAMETERS] = { (double)draw->fc, (double)draw->mu, (double)draw->a1, (double)draw->a2, (double)draw->w0 };

    return value[k] / units[k];
}

static int ascending(const void *a, const void *b)
{
    return (*(const double *)a > *(const double *)b) - (*(const double *)a < *(const double *)b);
}

/* Parameter k of the failures of the last level, ascending, into list; returns their number. */
static uint32_t failures(const search *s, unsigned k, double *list)
{
    uint32_t n = 0;

    for (uint32_t i = 0; i < s->samples; i++) {
        if (kelly_rare_failed(&s->rare.samples[i])) {
            kelly_draw draw;

            kelly_rare_draw(&s->opts->run, &s->rare.samples[i], &draw);
            list[n++] = parameter(&draw, k);
        }
    }
    qsort(list, n, sizeof(*list), ascending);
    return n;
}

static place place_of(const double *list, uint32_t n)
{
    place p = { .low = list[n * 25 / 1000], .median = list[n / 2], .high = list[n - 1 - n * 25 / 1000] };

    for (uint32_t i = 0; i < n; i++) {
        p.mean += list[i] / n;
    }
    for (uint32_t i = 0; i < n; i++) {
        p.sd += (list[i] - p.mean) * (list[i] - p.mean) / n;
    }
    p.sd = sqrt(p.sd);
    return p;
}

/* 60 f_i of mode i at the mean weight, and the share of the n failures with a top speed near it: a narrow peak there is resonance of the
 * weight with the string. */
static double resonance(const search *s, unsigned i, const double *rpm, uint32_t n, double *share)
{
    kelly_modes modes = { 0 };
    uint32_t near = 0;
    double at;

    (void)kelly_modes_at(&kelly_string, s->opts->run.fc, s->opts->run.torsional, &modes);
    at = sqrt((double)modes.w2[i]) / RPM;
    for (uint32_t k = 0; k < n; k++) {
        near += fabs(rpm[k] - at) <= NEAR * at;
    }
    *share = (double)near / n;
    return at;
}

/* ---- results ------------------------------------------------------------------------------------------------- */

static int done(const search *s)
{
    return s->rare.state == KELLY_RARE_DONE;
}

static double acceptance(const kelly_rare_level *level)
{
    return level->proposed > 0 ? (double)level->accepted / level->proposed : 0;
}

static void write_levels(FILE *to, const search *s)
{
    fprintf(to, "  \"levels\": %u,\n  \"acceptance\": [", s->rare.level + 1);
    for (uint32_t i = 1; i <= s->rare.level; i++) {
        fprintf(to, "%s%.6g", i > 1 ? ", " : "", acceptance(&s->rare.levels[i]));
    }
    fputs("],\n  \"acceptance_led\": [", to);
    for (uint32_t i = 1; i <= s->rare.level; i++) {
        const kelly_rare_level *const l = &s->rare.levels[i];

        fprintf(to, "%s%.6g", i > 1 ? ", " : "", l->led > 0 ? (double)l->led_accepted / l->led : 0.0);
    }
    fputs("],\n  \"refused_by_level\": [", to);
    for (uint32_t i = 0; i <= s->rare.level; i++) {
        fprintf(to, "%s%u", i ? ", " : "", s->rare.levels[i].refused);
    }
    fputs("],\n  \"by_level\": [\n", to);
    for (uint32_t i = 0; i <= s->rare.level; i++) {
        const kelly_rare_level *const l = &s->rare.levels[i];

        fprintf(to, "    {\"p\": %.9g, \"failed\": %u, \"guide\": ", (double)l->inside / s->samples, l->failed);
        fprintf(to, l->guide < KELLY_RARE_FAILED ? "%.9g" : "null", (double)l->guide);
        fprintf(to, ", \"cov\": %.6g, \"step\": %.6g}%s\n", sqrt((double)l->variance), i ? (double)l->step : 0.0, i < s->rare.level ? "," : "");
    }
    fputs("  ],\n", to);
}

/* Resonances with failures near them; `list` holds the rpm of n > 0 failures. */
static void write_resonances(FILE *to, const search *s, const double *list, uint32_t n)
{
    const char *comma = "";

    fputs("\n    \"resonances\": [", to);
    for (unsigned i = 0; i < s->opts->run.torsional; i++) {
        double share, at = resonance(s, i, list, n, &share);

        if (share > 0) {
            fprintf(to, "%s{\"rpm\": %.6g, \"share\": %.6g}", comma, at, share);
            comma = ", ";
        }
    }
    fputs("],", to);
}

static void write_failures(FILE *to, const search *s, double *list)
{
    uint32_t n = 0;

    fputs("  \"failures\": {", to);
    for (unsigned k = 0; k < KELLY_PARAMETERS && (n = failures(s, k, list)) > 0; k++) {
        const place p = place_of(list, n);

        fprintf(to, "\n    \"%s\": {\"mean\": %.9g, \"sd\": %.9g, \"quantiles\": {\"0.025\": %.9g, \"0.5\": %.9g, \"0.975\": %.9g}},", names[k],
                p.mean, p.sd, p.low, p.median, p.high);
    }
    if (n > 0) {
        write_resonances(to, s, list, n);
    }
    fprintf(to, "\n    \"count\": %u, \"distinct\": %u},\n", n, s->rare.distinct);
}

static void write_json(FILE *to, const search *s, double *list)
{
    if (done(s)) {
        fprintf(to, "{\n  \"probability\": %.17g,\n  \"ci95\": [%.17g, %.17g],\n  \"cov\": %.9g,\n  \"method\": \"%s\",\n  \"reason\": null,\n",
                (double)s->answer.probability, (double)s->answer.lo, (double)s->answer.hi, (double)s->answer.cov,
                s->answer.plain ? "Monte Carlo" : "subset simulation");
    } else {
        fprintf(to, "{\n  \"probability\": null,\n  \"ci95\": null,\n  \"cov\": null,\n  \"method\": \"subset simulation\",\n  \"reason\": \"%s\",\n",
                kelly_rare_reason(s->rare.state));
    }
    fprintf(to, "  \"realisations\": %u,\n  \"samples_per_level\": %u,\n  \"refused\": %u,\n", s->rare.realisations, s->samples,
            kelly_refused(&s->out.tally));
    outcome_write_refused(to, &s->out);
    write_levels(to, s);
    write_failures(to, s, list);
    fprintf(to, "  \"severity\": \"ss = (max - min)/(max + min)\",\n  \"seed\": %llu,\n  \"digest\": \"%08x\",\n  \"real\": \"%s\",\n"
            "  \"model\": \"%s\",\n", (unsigned long long)s->opts->seed, s->out.tally.digest, sizeof(real) > 4 ? "double" : "float", kelly_string.id);
    outcome_write_case(to, &s->out);
    fprintf(to, "  \"engine\": \"%s\",\n  \"seconds\": %.6f\n}\n", s->engine->name, s->seconds);
}

static void print_failures(const search *s, double *list)
{
    const char *before = "failures within 2 % of a resonance of the weight with the string: ";
    uint32_t n = 0;

    for (unsigned k = 0; k < KELLY_PARAMETERS && (n = failures(s, k, list)) > 0; k++) {
        const place p = place_of(list, n);

        printf("%-7s %10.5g +- %-10.4g 95 %% of them in %.5g .. %.5g\n", names[k], p.mean, p.sd, p.low, p.high);
    }
    for (unsigned i = 0; n > 0 && i < s->opts->run.torsional; i++) {
        double share, at = resonance(s, i, list, n, &share);

        if (share >= SHOWN) {
            printf("%s%.0f %% near %.4g rpm", before, 100 * share, at);
            before = ", ";
        }
    }
    if (before[0] == ',') {
        puts("");
    }
}

static void print_outcome(const search *s, double *list)
{
    outcome_print_case(&s->out);
    if (done(s)) {
        printf("P(stick-slip) = %.3g   95 %% interval %.3g .. %.3g   coefficient of variation %.2f   (%s, %u levels, %u realisations)\n",
               (double)s->answer.probability, (double)s->answer.lo, (double)s->answer.hi, (double)s->answer.cov,
               s->answer.plain ? "Monte Carlo" : "subset simulation", s->rare.level + 1, s->rare.realisations);
        printf("where the %u failures of the last level lie (%u different):\n", s->rare.levels[s->rare.level].failed, s->rare.distinct);
        print_failures(s, list);
    }
    for (uint32_t i = 1; i <= s->rare.level; i++) {
        printf("%s%.2f", i > 1 ? ", " : "acceptance ", acceptance(&s->rare.levels[i]));
    }
    printf("%srefused %u, seed %llu, digest %08x, %s, %s, %.2f s\n", s->rare.level > 0 ? "; " : "", kelly_refused(&s->out.tally),
           (unsigned long long)s->opts->seed, s->out.tally.digest, sizeof(real) > 4 ? "double" : "float", s->engine->name, s->seconds);
    outcome_print_refused(&s->out, "the first hundred with --json");
}

/* ---- the command --------------------------------------------------------------------------------------------- */

static const option_help own_options[] = {
    { "--samples-per-level", "N", "samples of a level, a multiple of 40 in 200..1000000 (default 2400)" },
    { "--cov", "D", "coefficients of variation 0..0.5: one for all, or fc=D,mu=D,a1=D,a2=D,rpm=D (default: the well file's)" },
    { "--seed", "S", "of the random streams (default 1)" },
    { "--threads", "T", "threads (default: one a processor); no result depends on it" },
    { "--engine", "NAME", "vector unit: scalar, sse2, avx2, avx512 (default: the widest here); no result depends on it" },
    { 0, 0, 0 },
};

const command_help rare_help = {
    .brief = "small probabilities of stick-slip, down to 1e-8, by subset simulation",
    .synopsis = "[case] [--cov D] [--limit S] [--samples-per-level N] [--seed S] [--json F] [--resume]",
    .takes = TAKES_CASE | TAKES_JSON | TAKES_RESUME,
    .own = own_options,
    .notes = "Takes 2400 realisations and 2160 more for each power of ten. Where the first level already holds a tenth of\n"
             "failures the answer is plain Monte Carlo, with the realisations of montecarlo for the same seed.\n"
             "JSON: probability, ci95 (95 %, log-normal), cov (of the estimate), realisations, levels, acceptance of the moves of each\n"
             "level, refused (index: order of proposal), failures (where they lie in each parameter, and near which resonance), digest.\n"
             "Where the answer cannot be trusted there is none: exit 1, and `reason` says why: no failure, under 50 different ones, moves\n"
             "hardly accepted, more than 12 levels, P below 1e-9, or realisations refused that may be failures.\n"
             "F.json.journal beside the JSON holds what is done and goes when all is written.",
    .example = "kelly rare --mu 0.004 --rpm 200 --cov 0.1 --json rare.json",
};

static int own_option(void *context, const char *name, const char *value)
{
    static const char right[] = "a multiple of 40 in 200..1000000, e.g. 2400";
    search *const s = context;

    if (strcmp(name, "--samples-per-level") != 0) {
        return 0;
    }
    s->samples = (uint32_t)option_whole(name, value, KELLY_RARE_MIN, KELLY_RARE_MAX, right);
    if (s->samples % 40 != 0) {
        die(EXIT_USAGE, "%s %s: not a multiple of 40; give %s", name, value, right);
    }
    return 1;
}

/* Options of an ensemble that have no meaning here. */
static void check_foreign(int argc, char **argv)
{
    static const char *const foreign[] = { "--samples", "--first", "--csv", "--convergence" };

    for (unsigned i = 0; i < sizeof(foreign) / sizeof(foreign[0]); i++) {
        if (has_option(argc, argv, foreign[i])) {
            die(EXIT_USAGE, "rare: unknown option %s; see kelly rare --help", foreign[i]);
        }
    }
}

int command_rare(int argc, char **argv)
{
    search *const s = &now_on;
    options opts;
    const char *beside;
    outfile json;
    double *list;

    s->samples = DEFAULT_SAMPLES;
    check_foreign(argc, argv);
    options_parse(&opts, argc, argv, TAKES_CASE | TAKES_ENSEMBLE | TAKES_JSON | TAKES_RESUME, "rare", own_option, s);
    s->opts = s->out.opts = &opts;
    s->engine = engine_choose(opts.engine);
    beside = outcome_beside(&opts);
    if (opts.json && team_rank() == 0) {
        outfile_open(&json, opts.json);
    }
    job_log(&s->log, &opts, beside, "rare", sizeof(kelly_result), s->samples * (KELLY_RARE_LEVELS + 1), s->samples);
    run_search(s);
    if (team_rank() > 0) {
        return EXIT_DONE;
    }
    list = calloc(s->samples, sizeof(*list));
    if (!list) {
        die(EXIT_FAILED, "out of memory");
    }
    if (opts.json) {
        write_json(json.stream, s, list);
        outfile_close(&json);
    }
    journal_remove(&s->log);
    if (outcome_speaks(&opts)) {
        print_outcome(s, list);
    }
    if (!done(s)) {
        die(EXIT_FAILED, "rare: no answer after %u realisations in %u levels: %s", s->rare.realisations, s->rare.level + 1,
            kelly_rare_reason(s->rare.state));
    }
    free(list);
    return EXIT_DONE;
}
