/* outcome.c - what an ensemble came to: counts as they come in, a line a realisation, JSON, a summary. */
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "../firmware/link/crc32c.h"
#include "outcome.h"

#define SHOWN 12u                /* refused realisations that are named on the terminal */
#define DIGITS (sizeof(real) > sizeof(float) ? 17 : 9)

/* Text of the CSV, and its CRC for the JSON beside it: `kelly merge` asks whether the two belong together. */
void outcome_lines(outcome *out, const char *text, size_t length)
{
    fwrite(text, 1, length, out->csv.stream);
    if (out->opts->json) {
        out->csv_crc = kelly_crc32c(out->csv_crc, (const uint8_t *)text, length);
    }
}

static void write_result(outcome *out, uint32_t index, const kelly_result *r)
{
    const kelly_draw *const d = &r->draw;
    char line[512];              /* a number has at most 24 characters */
    int n;

    n = sprintf(line, "%u,%.*g,%.*g,%.*g,%.*g,%.*g,", index, DIGITS, (double)d->fc / 1000.0, DIGITS, (double)d->mu, DIGITS, (double)d->a1,
                DIGITS, (double)d->a2, DIGITS, (double)d->w0 / RPM);
    if (r->status == KELLY_OK) {
        n += sprintf(line + n, "%.*g,%.*g,%.*g,%.*g,%u,ok,%u\n", DIGITS, (double)r->lowest / RPM, DIGITS, (double)r->highest / RPM,
                     DIGITS, (double)r->mean / RPM, DIGITS, (double)r->ss, r->stuck, r->liftoff);
    } else {
        n += sprintf(line + n, ",,,,0,%s,%u\n", status_names[r->status], r->liftoff);
    }
    outcome_lines(out, line, (size_t)n);
}

/* The field's definition beside the paper's: a bit that does not get on at all (mean <= 0) is stuck in both. */
static uint32_t stuck_by_ssi(const outcome *out, const kelly_result *r)
{
    return r->status == KELLY_OK && (r->mean <= 0 || kelly_ssi(r->lowest, r->highest, r->mean) > out->opts->run.limit);
}

void outcome_take(void *context, uint32_t first, uint32_t count, const void *results)
{
    outcome *const out = context;
    const kelly_result *const r = results;

    for (uint32_t i = 0; i < count && !out->until.enough; i++) {
        const uint32_t refused = kelly_refused(&out->tally);

        if (r[i].status != KELLY_OK && refused < LISTED) {
            out->refused[refused] = first + i;
            out->why[refused] = r[i].status;
        }
        kelly_tally_add(&out->tally, first + i, &r[i]);
        out->stuck_ssi += stuck_by_ssi(out, &r[i]);
        if (out->opts->csv) {
            write_result(out, first + i, &r[i]);
        }
        (void)until_look(&out->until, &out->tally);
    }
}

static uint32_t listed(const outcome *out)
{
    const uint32_t refused = kelly_refused(&out->tally);

    return refused < LISTED ? refused : LISTED;
}

void outcome_write_case(FILE *to, const outcome *out)
{
    const kelly_case *const run = &out->opts->run;
    char drive[DRIVE_TEXT];

    fprintf(to, "  \"case\": {\"rpm\": %.9g, \"wob_kN\": %.9g, \"mu\": %.9g, \"alpha1\": %.9g, \"alpha2\": %.9g, \"f0_kN\": %.9g, \"start\": \"%s\", "
            "\"duration_s\": %.12g, \"window_s\": [%.12g, %.12g], \"step_s\": %.12g, \"limit\": %.9g, \"torsional\": %u,\n",
            (double)run->w0 / RPM, (double)run->fc / 1000.0, (double)run->mu, (double)run->a1, (double)run->a2, (double)run->f0 / 1000.0,
            run->rotating ? "rotating" : "rest", case_seconds(run, run->ticks), case_seconds(run, run->window_first),
            case_seconds(run, run->window_last), case_seconds(run, 1), (double)run->limit, run->torsional);
    fprintf(to, "           \"drive\": \"%s\",\n", drive_text(&run->drive, drive));
    fprintf(to, "           \"cov\": {\"fc\": %.9g, \"mu\": %.9g, \"a1\": %.9g, \"a2\": %.9g, \"rpm\": %.9g}},\n",
            (double)run->cov[0], (double)run->cov[1], (double)run->cov[2], (double)run->cov[3], (double)run->cov[4]);
}

void outcome_write_refused(FILE *to, const outcome *out)
{
    fprintf(to, "  \"refused_by\": {\"step\": %u, \"range\": %u, \"nonfinite\": %u, \"corrupt\": %u},\n  \"refused_first\": [", out->tally.status[KELLY_STEP],
            out->tally.status[KELLY_RANGE], out->tally.status[KELLY_NONFINITE], out->tally.status[KELLY_CORRUPT]);
    for (uint32_t i = 0; i < listed(out); i++) {
        fprintf(to, "%s[%u, \"%s\"]", i ? ", " : "", out->refused[i], status_names[out->why[i]]);
    }
    fputs("],\n", to);
}

static void write_convergence(FILE *to, const convergence_table *table)
{
    fputs("  \"convergence\": [", to);
    for (unsigned i = 0; i < table->count; i++) {
        fprintf(to, "%s[%u, %.17g]", i ? ", " : "", table->n[i], table->value[i]);
    }
    fputs("],\n", to);
}

/* Counted, refused and limit as for ss; only the measure differs. */
static void write_ssi(FILE *to, const outcome *out)
{
    const uint32_t counted = out->tally.samples - kelly_refused(&out->tally);

    fputs("  \"ssi\": {\"severity\": \"SSI = (max - min)/(2 mean)\", \"probability\": ", to);
    if (counted > 0) {
        fprintf(to, "%.17g", (double)out->stuck_ssi / counted);
    } else {
        fputs("null", to);
    }
    fprintf(to, ", \"stuck\": %u},\n", out->stuck_ssi);
}

static void write_json(FILE *to, const outcome *out, double lo, double hi)
{
    const kelly_tally *const t = &out->tally;

    fputs("{\n", to);
    if (t->samples > kelly_refused(t)) {
        fprintf(to, "  \"probability\": %.17g,\n", (double)kelly_probability(t));
    } else {
        fputs("  \"probability\": null,\n", to);
    }
    fprintf(to, "  \"ci95\": [%.17g, %.17g],\n  \"samples\": %u,\n  \"stuck\": %u,\n  \"refused\": %u,\n  \"liftoff\": %u,\n", lo, hi,
            t->samples, t->stuck, kelly_refused(t), t->liftoff);
    fprintf(to, "  \"severity\": \"ss = (max - min)/(max + min)\",\n");
    write_ssi(to, out);
    fprintf(to, "  \"seed\": %llu,\n  \"first\": %u,\n  \"digest\": \"%08x\",\n  \"real\": \"%s\",\n  \"model\": \"%s\",\n",
            (unsigned long long)out->opts->seed, out->opts->first, t->digest, sizeof(real) > 4 ? "double" : "float", kelly_string.id);
    fprintf(to, "  \"identity\": \"%08x\",\n", out->identity);
    if (out->opts->csv) {
        fprintf(to, "  \"csv_crc32c\": \"%08x\",\n", out->csv_crc);
    }
    outcome_write_refused(to, out);
    until_write(to, &out->until, out->asked);
    if (out->opts->convergence) {
        write_convergence(to, &out->convergence);
    }
    outcome_write_case(to, out);
    if (out->more) {
        out->more(to, out->more_of);
    }
    fprintf(to, "  \"engine\": \"%s\",\n  \"seconds\": %.6f,\n", out->engine, out->seconds);
}

/* The JSON, and at its end the CRC of all before it. */
static void write_report(FILE *to, const outcome *out, double lo, double hi)
{
    char *text = 0;
    size_t length = 0;
    FILE *const memory = open_memstream(&text, &length);

    if (!memory) {
        die(EXIT_FAILED, "out of memory");
    }
    write_json(memory, out, lo, hi);
    if (fclose(memory) != 0) {
        die(EXIT_FAILED, "out of memory");
    }
    fwrite(text, 1, length, to);
    fprintf(to, OUTCOME_END, kelly_crc32c(0, (const uint8_t *)text, length));
    free(text);
}

void outcome_print_case(const outcome *out)
{
    const kelly_case *const run = &out->opts->run;
    char drive[DRIVE_TEXT];

    printf("%s, %.6g rpm, %.6g kN, f0 %.6g kN, mu %.6g, alpha1 %.6g, alpha2 %.6g, start %s, window %.12g:%.12g s, step %.12g s%s\n", kelly_string.id,
           (double)run->w0 / RPM, (double)run->fc / 1000.0, (double)run->f0 / 1000.0, (double)run->mu, (double)run->a1, (double)run->a2,
           run->rotating ? "rotating" : "rest", case_seconds(run, run->window_first), case_seconds(run, run->window_last),
           case_seconds(run, 1), drive_remark(&run->drive, drive));
}

/* Red where stick-slip is the likelier, green where it is certain to be rare, yellow between. */
static const char *colour(double lo, double hi)
{
    return lo > 0.5 ? "31" : hi < 0.05 ? "32" : "33";
}

/* What helps where realisations of a case were refused for their step, "" where few were or the nominal weight is outside the table. */
static const char *step_advice(const kelly_case *run, const kelly_tally *t, char text[ADVICE_TEXT])
{
    kelly_draw nominal;
    kelly_modes modes;
    char safe[STEP_TEXT];

    kelly_draw_nominal(run, &nominal);
    if (t->status[KELLY_STEP] <= t->samples / 100 || kelly_realise(&kelly_string, run, &nominal, &modes) == KELLY_RANGE) {
        return "";
    }
    if (case_seconds(run, 1) < (double)kelly_smallest_step(&modes)) {
        snprintf(text, ADVICE_TEXT, "the step is too short for this precision, whose rounding would drown the slowest mode; give at least %s s",
                 step_text((double)kelly_smallest_step(&modes), 1, safe));
    } else {
        snprintf(text, ADVICE_TEXT, "the step is too long for %u of %u; the nominal case allows %s s, its tails about a third of that",
                 t->status[KELLY_STEP], t->samples, step_text((double)kelly_largest_step(&kelly_string, run, &nominal, &modes), 0, safe));
    }
    return text;
}

void outcome_warn(const kelly_case *run, const kelly_tally *t)
{
    char text[ADVICE_TEXT];
    const char *const advice = step_advice(run, t, text);

    if (t->liftoff > t->samples / 100) {
        printf("warning: in %u of %u the weight would change its sign (|fc| < 1.01 f0): the bit would lift off, which this model leaves out\n",
               t->liftoff, t->samples);
    }
    if (*advice) {
        printf("warning: %s\n", advice);
    }
    if (t->status[KELLY_RANGE] > t->samples / 100 && t->samples > kelly_refused(t)) {
        printf("warning: in %u of %u the weight lies outside %.6g..%.6g kN, for which the table is fitted: they are not in P\n", t->status[KELLY_RANGE],
               t->samples, (double)kelly_string.fc_min / 1000.0, (double)kelly_string.fc_max / 1000.0);
    }
}

const char *advice_on(const kelly_case *run, const kelly_tally *t, char text[ADVICE_TEXT])
{
    if (*step_advice(run, t, text)) {
        return text;
    }
    if (t->status[KELLY_CORRUPT] > 0) {
        return "a number in memory changed while they ran; look at the memory of the machine, and run them again";
    }
    if (t->status[KELLY_RANGE] == 0) {
        return "give a shorter --step, or another case";
    }
    snprintf(text, ADVICE_TEXT, "the table is fitted for weights of %.6g..%.6g kN; give %s", (double)kelly_string.fc_min / 1000.0,
             (double)kelly_string.fc_max / 1000.0, run->fc >= kelly_string.fc_min && run->fc <= kelly_string.fc_max ?
             "a --wob, or a --cov fc=, whose draws lie there" : "such a --wob");
    return text;
}

int outcome_answered(const outcome *out)
{
    const kelly_tally *const t = &out->tally;
    char text[ADVICE_TEXT];

    if (t->samples > kelly_refused(t)) {
        return EXIT_DONE;
    }
    fprintf(stderr, "kelly: no answer: none of %u realisations can be trusted (step %u, range %u, nonfinite %u, corrupt %u): %s\n", t->samples,
            t->status[KELLY_STEP], t->status[KELLY_RANGE], t->status[KELLY_NONFINITE], t->status[KELLY_CORRUPT], advice_on(&out->opts->run, t, text));
    return EXIT_FAILED;
}

void outcome_print_refused(const outcome *out, const char *where)
{
    for (uint32_t i = 0; i < listed(out) && i < SHOWN; i++) {
        printf("%s%u (%s)", i ? ", " : "refused: ", out->refused[i], status_names[out->why[i]]);
    }
    if (kelly_refused(&out->tally) > SHOWN) {
        printf(", ... (%s)\n", where);
    } else if (listed(out) > 0) {
        puts("");
    }
}

static void print_outcome(const outcome *out, double lo, double hi)
{
    const kelly_tally *const t = &out->tally;
    const uint32_t counted = t->samples - kelly_refused(t);
    const int digits = hi - lo > 1e-3 ? 4 : hi - lo > 1e-5 ? 6 : 8;   /* as many as the interval's width needs */

    outcome_print_case(out);
    if (counted > 0) {
        printf("P(stick-slip) = %s%.*f%s   95 %% interval %.*f .. %.*f   (%u of %u with ss > %.6g)\n", ink(stdout, colour(lo, hi)), digits,
               (double)kelly_probability(t), ink(stdout, "0"), digits, lo, digits, hi, t->stuck, counted, (double)out->opts->run.limit);
        printf("ss = (max - min)/(max + min) of the bit speed, the paper's; by the field's SSI = (max - min)/(2 mean) > %.6g: P = %.4f (%u of %u)\n",
               (double)out->opts->run.limit, (double)out->stuck_ssi / counted, out->stuck_ssi, counted);
    } else {
        printf("P(stick-slip) is unknown: every realisation was refused   95 %% interval %.4f .. %.4f\n", lo, hi);
    }
    printf("refused %u (step %u, range %u, nonfinite %u), lift-off %u, seed %llu, first %u, digest %08x, %s, %s, %.2f s\n", kelly_refused(t),
           t->status[KELLY_STEP], t->status[KELLY_RANGE], t->status[KELLY_NONFINITE], t->liftoff, (unsigned long long)out->opts->seed,
           out->opts->first, t->digest, sizeof(real) > 4 ? "double" : "float", out->engine, out->seconds);
    if (t->status[KELLY_CORRUPT] > 0) {
        printf("corrupt %u: a number in memory changed while they ran; look at the memory of the machine, and run them again\n", t->status[KELLY_CORRUPT]);
    }
    until_print(&out->until, t->samples);
    outcome_warn(&out->opts->run, t);
    outcome_print_refused(out, "all with --csv");
    for (unsigned i = 0; i < out->convergence.count; i++) {
        printf("conv(%u) = %.6g m2 s\n", out->convergence.n[i], out->convergence.value[i]);
    }
    if (out->envelope.times > 0) {
        printf("envelope, traces: %u realisations at %u times, in %.1f MB of memory\n", out->envelope.used, out->envelope.times,
               out->envelope.bytes / 1e6);
    }
}

/* What is looked at as one goes has an interval of its own kind. */
static void interval(const outcome *out, double *lo, double *hi)
{
    kelly_interval(&out->tally, lo, hi);
    if (out->until.rule.alpha > 0) {
        *lo = (double)out->until.lo;
        *hi = (double)out->until.hi;
    }
}

static double now(void)
{
    struct timespec t;

    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

void outcome_open(outcome *out, const options *opts, const char *engine)
{
    out->opts = opts;
    out->asked = opts->samples;
    out->engine = engine;
    out->identity = case_identity(&opts->run);
    out->start = now();
    if (opts->csv) {
        outfile_open(&out->csv, opts->csv);
        outcome_lines(out, OUTCOME_HEADER "\n", strlen(OUTCOME_HEADER "\n"));
    }
    if (opts->json) {
        outfile_open(&out->json, opts->json);
    }
}

const char *first_output(const options *opts, const char *const outputs[], unsigned count, const char *give)
{
    const char *beside = 0;

    for (unsigned i = 0; i < count; i++) {
        beside = beside ? beside : is_plain_file(outputs[i]) ? outputs[i] : 0;
    }
    if (opts->resume && !beside) {
        die(EXIT_USAGE, "--resume: there is no journal without an output file; give %s", give);
    }
    return beside;
}

const char *outcome_beside(const options *opts)
{
    return first_output(opts, &opts->json, 1, "--json");
}

int outcome_speaks(const options *opts)
{
    return !opts->quiet && !(opts->json && strcmp(opts->json, "-") == 0) && !(opts->csv && strcmp(opts->csv, "-") == 0);
}

int outcome_close(outcome *out)
{
    const options *const opts = out->opts;
    double lo, hi;

    out->seconds = now() - out->start;
    interval(out, &lo, &hi);
    if (opts->json) {
        write_report(out->json.stream, out, lo, hi);
        outfile_close(&out->json);
    }
    if (opts->csv) {
        outfile_close(&out->csv);
    }
    journal_remove(&out->convergence_log);
    journal_remove(&out->envelope_log);
    journal_remove(&out->log);
    if (outcome_speaks(opts)) {
        print_outcome(out, lo, hi);
    }
    return outcome_answered(out);
}
