/* cmd_rare.c - small probabilities of stick-slip: the kernel's subset simulation over threads and lanes. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "map.h"
#include "rare_search.h"
#include "team.h"

#define DEFAULT_SAMPLES 2400u
#define LEAST_SAMPLES 1000u      /* with fewer the last level has too few failures too often, and what is refused for it is none at random */
#define FAR_RARER W(0.2)         /* of the answer: what is rarer is not looked at */
#define LOOK UINT64_C(0x6c6f6f6b00000000)   /* "look": another seed */

static search now_on;            /* what run_job's pieces are of */

/* ---- the search ---------------------------------------------------------------------------------------------- */

static void work_piece(const options *opts, uint32_t first, uint32_t count, void *results, void *work)
{
    engine_run_draws(now_on.engine, opts, &now_on.draws[first], count, results, work);
}

static void take_batch(void *context, uint32_t first, uint32_t count, const void *results)
{
    search *const s = context;
    const kelly_result *const r = results;

    for (uint32_t i = 0; i < count; i++) {
        check_intact(&r[i], s->out.tally.samples + i);
        s->at_work->samples[s->at_work->first + first + i].guide = kelly_rare_guide(&kelly_string, &s->opts->run, &r[i]);
    }
    outcome_take(&s->out, s->out.tally.samples, count, results);
}

/* Run what the search at work waits for; each proposal is an ensemble of its own for run_job. */
static void evaluate(search *s)
{
    options part = *s->opts;

    part.first = 0;
    part.samples = kelly_rare_count(s->at_work);
    part.progress = PROGRESS_NONE;
    for (uint32_t i = 0; i < part.samples; i++) {
        kelly_rare_draw(&s->opts->run, &s->at_work->samples[s->at_work->first + i], &s->draws[i]);
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

static void start(const search *s, kelly_rare *rare, uint64_t seed, uint32_t samples)
{
    kelly_rare_sample *const room = calloc(samples, sizeof(*room));
    uint32_t *const keys = calloc(samples, sizeof(*keys));
    const char *error;

    if (!room || !keys) {
        die(EXIT_FAILED, "out of memory");
    }
    error = kelly_rare_start(rare, s->opts->run.cov, seed, samples, room, keys);
    if (error) {
        die(EXIT_USAGE, "rare: %s", error);
    }
}

/* Failures where the guide does not lead: at each resonance. */
static void look_again(search *s, const kelly_rare_hint *hint)
{
    s->at_work = &s->look;
    for (unsigned mode = 0; mode < s->opts->run.torsional; mode++) {
        kelly_rare_seen seen;

        start(s, &s->look, s->opts->seed ^ (LOOK | mode), s->samples);
        kelly_rare_look(&s->look, hint, mode, FAR_RARER * kelly_rare_product(&s->rare), s->samples / KELLY_RARE_STATES);
        if (kelly_rare_count(&s->look) > 0) {
            evaluate(s);
            kelly_rare_see(&s->look, &seen);
            kelly_rare_compare(&s->rare, hint, mode, &seen);
            s->seen_at = seen.probability > s->seen.probability ? mode : s->seen_at;
            s->seen = seen.probability > s->seen.probability ? seen : s->seen;
        }
        free(s->look.samples);
        free(s->look.keys);
    }
}

static void run_search(search *s)
{
    const double began = now();
    const kelly_rare_hint hint = { .table = &kelly_string, .run = &s->opts->run };

    s->at_work = &s->rare;
    s->draws = calloc(s->samples, sizeof(*s->draws));
    if (!s->draws) {
        die(EXIT_FAILED, "out of memory");
    }
    start(s, &s->rare, s->opts->seed, s->samples);
    kelly_rare_lead(&s->rare, &hint);
    if (team_rank() > 0) {       /* which levels there are is the first process's to know */
        evaluate(s);
        return;
    }
    while (kelly_rare_count(&s->rare) > 0) {
        evaluate(s);
        show(s, began);
        kelly_rare_accept(&s->rare);
    }
    if (s->rare.state == KELLY_RARE_DONE && s->rare.level > 0) {
        look_again(s, &hint);
        kelly_rare_doubt(&s->rare, &hint);
    }
    team_dismiss();
    if (s->rare.state == KELLY_RARE_DONE) {
        kelly_rare_read(&s->rare, &s->answer);
    }
    s->seconds = now() - began;
    if (progress_wanted(s->opts)) {
        progress_end(s->opts, s->out.tally.samples, s->seconds);
    }
}

/* ---- the command --------------------------------------------------------------------------------------------- */

static const option_help own_options[] = {
    { "--samples-per-level", "N", "samples of a level, a multiple of 40 in 1000..1000000 (default 2400)" },
    { "--cov", "D", "coefficients of variation 0..0.5: one for all, or fc=D,mu=D,a1=D,a2=D,rpm=D (default: the well file's)" },
    { "--seed", "S", "of the random streams (default 1)" },
    { "--threads", "T", "threads (default: one a processor); no result depends on it" },
    { "--engine", "NAME", "vector unit: scalar, sse2, avx2, avx512 (default: the widest here); no result depends on it" },
    { "--twice", 0, TWICE_HELP },
    { 0, 0, 0 },
};

const command_help rare_help = {
    .brief = "small probabilities of stick-slip, down to 1e-8, by subset simulation",
    .synopsis = "[case] [--cov D] [--limit S] [--samples-per-level N] [--seed S] [--json F] [--resume]",
    .takes = TAKES_CASE | TAKES_JSON | TAKES_RESUME,
    .own = own_options,
    .notes = "Takes 2400 realisations and 2160 more for each power of ten, and up to 240 at each resonance that failures may lie at. Where the\n"
             "first level already holds a tenth of failures the answer is plain Monte Carlo, with the realisations of montecarlo for the same\n"
             "seed.\n"
             "JSON: probability, ci95 (95 %, log-normal), cov (of the estimate), realisations, levels, acceptance of the moves of each\n"
             "level, refused (index: order of proposal), failures (where they lie in each parameter, and near which resonance), digest.\n"
             "Where the answer cannot be trusted there is none: exit 1, and `reason` says why: no failure, under 50 different ones or all from\n"
             "few finds, failures at a resonance that the search has missed (JSON: look), a limit below 1.5 times the ss that the string has\n"
             "anyway, moves hardly accepted, more than 12 levels, P below 1e-9, or realisations refused that may be failures. Not looked for:\n"
             "failures apart that no resonance explains.\n"
             "F.json.journal beside the JSON holds what is done and goes when all is written.",
    .example = "kelly rare --mu 0.004 --rpm 200 --cov 0.1 --json rare.json",
};

static int own_option(void *context, const char *name, const char *value)
{
    static const char right[] = "a multiple of 40 in 1000..1000000, e.g. 2400";
    search *const s = context;

    if (strcmp(name, "--samples-per-level") != 0) {
        return 0;
    }
    s->samples = (uint32_t)option_whole(name, value, LEAST_SAMPLES, KELLY_RARE_MAX, right);
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

/* A corrupt one, by which a search ends (take_batch), is run again when it goes on. */
static int record_sound(const void *payload, size_t size)
{
    const kelly_result *const r = payload;

    return results_sound(payload, size) && r->status != KELLY_CORRUPT;
}

int command_rare(int argc, char **argv)
{
    search *const s = &now_on;
    options opts;
    const char *beside;
    outfile json = { 0 };
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
    job_log(&s->log, &opts, beside, &(journal_run){ .kind = "rare", .parameters = s->samples, .records = s->samples * (KELLY_RARE_LEVELS + 2),
            .payload = sizeof(kelly_result), .in_order = 1, .sound = record_sound });
    run_search(s);
    if (team_rank() > 0) {
        return EXIT_DONE;
    }
    list = calloc(s->samples, sizeof(*list));
    if (!list) {
        die(EXIT_FAILED, "out of memory");
    }
    if (opts.json) {
        rare_write_json(json.stream, s, list);
        outfile_close(&json);
    }
    journal_remove(&s->log);
    if (outcome_speaks(&opts)) {
        rare_print(s, list);
    }
    if (s->rare.state != KELLY_RARE_DONE) {
        char reason[REASON_TEXT];

        die(EXIT_FAILED, "rare: no answer after %u realisations in %u level%s: %s", s->out.tally.samples, s->rare.level + 1,
            s->rare.level > 0 ? "s" : "", rare_reason(s, reason));
    }
    free(list);
    return EXIT_DONE;
}
