/* rare_report.c - what kelly rare has found: the JSON and the summary, and where the failures lie. */
#include <math.h>
#include <stdlib.h>

#include "rare_search.h"

#define NEAR 0.02                /* a top speed this near 60 f_i, as a ratio, counts as resonance */
#define SHOWN 0.01               /* least share of the failures that is told */

static const char *const names[KELLY_PARAMETERS] = { "wob_kN", "mu", "alpha1", "alpha2", "rpm" };
static const double units[KELLY_PARAMETERS] = { 1000.0, 1.0, 1.0, 1.0, RPM };

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

        if (!(s->opts->run.cov[k] > 0)) {
            continue;
        }
        fprintf(to, "\n    \"%s\": {\"mean\": %.9g, \"sd\": %.9g, \"quantiles\": {\"0.025\": %.9g, \"0.5\": %.9g, \"0.975\": %.9g}},", names[k],
                p.mean, p.sd, p.low, p.median, p.high);
    }
    if (n > 0) {
        write_resonances(to, s, list, n);
    }
    fprintf(to, "\n    \"count\": %u, \"distinct\": %u, \"finds\": %.6g},\n", n, s->rare.distinct, (double)s->rare.finds);
    fprintf(to, "  \"look\": {\"mode\": %u, \"probability\": %.9g, \"cov\": %.6g, \"tried\": %u, \"failed\": %u},\n", s->seen_at + 1,
            (double)s->seen.probability, sqrt((double)s->seen.variance), s->seen.tried, s->seen.failed);
}

const char *rare_reason(const search *s, char text[REASON_TEXT])
{
    const char *const reason = kelly_rare_reason(s->rare.state);
    char help[ADVICE_TEXT];

    if (s->rare.state != KELLY_RARE_UNKNOWN) {
        return reason;
    }
    snprintf(text, REASON_TEXT, "%s: %s", reason, advice_on(&s->opts->run, &s->out.tally, help));
    return text;
}

void rare_write_json(FILE *to, const search *s, double *list)
{
    char reason[REASON_TEXT];

    if (done(s)) {
        fprintf(to, "{\n  \"probability\": %.17g,\n  \"ci95\": [%.17g, %.17g],\n  \"cov\": %.9g,\n  \"method\": \"%s\",\n  \"reason\": null,\n",
                (double)s->answer.probability, (double)s->answer.lo, (double)s->answer.hi, (double)s->answer.cov,
                s->answer.plain ? "Monte Carlo" : "subset simulation");
    } else {
        fprintf(to, "{\n  \"probability\": null,\n  \"ci95\": null,\n  \"cov\": null,\n  \"method\": \"subset simulation\",\n  \"reason\": \"%s\",\n",
                rare_reason(s, reason));
    }
    fprintf(to, "  \"realisations\": %u,\n  \"samples_per_level\": %u,\n  \"refused\": %u,\n", s->out.tally.samples, s->samples,
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

        if (s->opts->run.cov[k] > 0) {
            printf("%-7s %10.5g +- %-10.4g 95 %% of them in %.5g .. %.5g\n", names[k], p.mean, p.sd, p.low, p.high);
        }
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

void rare_print(const search *s, double *list)
{
    outcome_print_case(&s->out);
    if (done(s)) {
        printf("P(stick-slip) = %.3g   95 %% interval %.3g .. %.3g   coefficient of variation %.2f   (%s, %u level%s, %u realisations)\n",
               (double)s->answer.probability, (double)s->answer.lo, (double)s->answer.hi, (double)s->answer.cov,
               s->answer.plain ? "Monte Carlo" : "subset simulation", s->rare.level + 1, s->rare.level > 0 ? "s" : "",
               s->out.tally.samples);
        printf("where the %u failures of the last level lie (%u different):\n", s->rare.levels[s->rare.level].failed, s->rare.distinct);
        print_failures(s, list);
    }
    for (uint32_t i = 1; i <= s->rare.level; i++) {
        printf("%s%.2f", i > 1 ? ", " : "acceptance ", acceptance(&s->rare.levels[i]));
    }
    printf("%srefused %u, seed %llu, digest %08x, %s, %s, %.2f s\n", s->rare.level > 0 ? "; " : "", kelly_refused(&s->out.tally),
           (unsigned long long)s->opts->seed, s->out.tally.digest, sizeof(real) > 4 ? "double" : "float", s->engine->name, s->seconds);
    if (done(s)) {
        outcome_warn(&s->opts->run, &s->out.tally);
    }
    outcome_print_refused(&s->out, "the first hundred with --json");
}
