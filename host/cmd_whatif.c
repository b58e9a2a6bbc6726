/* cmd_whatif.c - the probability under other means and spreads, from a run that is on file. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "stored.h"

static const char *const names[KELLY_PARAMETERS] = { "fc", "mu", "a1", "a2", "rpm" };
static const double units[KELLY_PARAMETERS] = { 1000.0, 1.0, 1.0, 1.0, RPM };   /* of the options, in SI */

typedef struct {
    const char *from, *case_json;
    double mean[KELLY_PARAMETERS];   /* SI; NaN: as it was run */
    float cov[KELLY_PARAMETERS];     /* the same */
    double limit;
    stored_run run;
    kelly_laws was, is;
    uint32_t samples, stuck, refused;
    kelly_reweight sums;
    kelly_reweighted result;
} request;

static int own_option(void *context, const char *name, const char *value)
{
    request *const ask = context;

    if (strcmp(name, "--from") == 0) {
        ask->from = value;
    } else if (strcmp(name, "--case-json") == 0) {
        ask->case_json = value;
    } else if (strcmp(name, "--cov") == 0) {
        option_covs(ask->cov, value);
    } else if (strcmp(name, "--limit") == 0) {
        ask->limit = option_number(name, value, 0.0, 10.0, "a severity in 0..10, e.g. 0.8");
    } else if (strcmp(name, "--wob") == 0) {
        ask->mean[0] = option_number(name, value, 1e-3, 1e6, "weight on bit in kN, 0.001..1000000") * units[0];
    } else if (strcmp(name, "--mu") == 0) {
        ask->mean[1] = option_number(name, value, 1e-9, 1e3, "a bit-rock factor in m, 1e-9..1000, e.g. 0.04");
    } else if (strcmp(name, "--alpha1") == 0) {
        ask->mean[2] = option_number(name, value, 1e-9, 1e6, "alpha_1 in s/rad, 1e-9..1000000, e.g. 2");
    } else if (strcmp(name, "--alpha2") == 0) {
        ask->mean[3] = option_number(name, value, 1e-9, 1e6, "alpha_2 in s2/rad2, 1e-9..1000000, e.g. 1");
    } else if (strcmp(name, "--rpm") == 0) {
        ask->mean[4] = option_number(name, value, 1e-3, 1e4, "top speed in rpm, 0.001..10000") * units[4];
    } else {
        return 0;
    }
    return 1;
}

/* The JSON beside run.csv is run.json. */
static char *case_beside(const char *csv)
{
    const size_t n = strlen(csv);
    char *const path = malloc(n + 6);

    if (!path) {
        die(EXIT_FAILED, "out of memory");
    }
    sprintf(path, "%.*s.json", (int)(n > 4 && strcmp(csv + n - 4, ".csv") == 0 ? n - 4 : n), csv);
    if (access(path, F_OK) != 0) {
        die(EXIT_USAGE, "%s: its laws are unknown, there is no %s; give --case-json F, the JSON that the same run of montecarlo wrote", csv, path);
    }
    return path;
}

/* Laws as they were run, and as they are asked for: both as the sampler takes them, in float. */
static void settle_laws(request *ask)
{
    const kelly_case *const run = &ask->run.run;
    const double was[KELLY_PARAMETERS] = { (double)run->fc, (double)run->mu, (double)run->a1, (double)run->a2, (double)run->w0 };

    for (unsigned k = 0; k < KELLY_PARAMETERS; k++) {
        kelly_law_fit fit;

        ask->was.mean[k] = was[k];
        ask->was.cov[k] = (double)run->cov[k];
        ask->is.mean[k] = isnan(ask->mean[k]) || (real)ask->mean[k] == (real)was[k] ? was[k] : ask->mean[k];
        ask->is.cov[k] = isnan(ask->cov[k]) ? (double)run->cov[k] : (double)ask->cov[k];
        fit = kelly_law_fits(&ask->was, &ask->is, k);
        if (fit == KELLY_LAW_FIXED) {
            die(EXIT_USAGE, "%s: %s was not random there and cannot become another; leave it at %.9g, cov 0, or run montecarlo", ask->from, names[k],
                was[k] / units[k]);
        }
        if (fit == KELLY_LAW_POINT) {
            die(EXIT_USAGE, "--cov: %s was random in %s and no realisation has one single value; give %s > 0, or run montecarlo", names[k], ask->from,
                names[k]);
        }
    }
}

static void read_rows(request *ask)
{
    stored_rows rows;
    stored_row row;

    stored_open_rows(&rows, ask->from);
    while (stored_next(&rows, &row)) {
        stored_check(&rows, &ask->run, ask->samples, &row);
        ask->samples++;
        ask->stuck += row.stuck;
        ask->refused += row.status != KELLY_OK;
        kelly_reweight_add(&ask->sums, row.y, row.status, row.status == KELLY_OK && (float)row.ss > (float)ask->limit);
    }
    stored_check_csv(&ask->run, ask->from, rows.crc);
    if (ask->samples != ask->run.samples || ask->stuck != ask->run.stuck || ask->refused != ask->run.refused) {
        die(EXIT_USAGE, "%s: %u realisations, %u stuck, %u refused, but %s says %u, %u, %u; give both files of one run", ask->from, ask->samples, ask->stuck,
            ask->refused, ask->run.path, ask->run.samples, ask->run.stuck, ask->run.refused);
    }
}

static void refuse_if_too_far(const request *ask)
{
    const kelly_reweighted *const r = &ask->result;

    if ((wide)(ask->samples - ask->refused) < KELLY_LEAST_ESS) {
        die(EXIT_USAGE, "%s: holds %u realisations that count, and at least %g are wanted; run montecarlo with more --samples", ask->from,
            ask->samples - ask->refused, (double)KELLY_LEAST_ESS);
    }
    if (!r->enough) {
        die(EXIT_USAGE, "%s: too far from what was run: effective samples %.1f (predicted by the laws %.1f) of %u, largest share %.3f, wanted at least %g and at "
            "most %g; give laws nearer to it, or run montecarlo", ask->from, (double)r->ess, (double)r->ess_predicted, ask->samples, (double)r->share,
            (double)KELLY_LEAST_ESS, (double)KELLY_MOST_SHARE);
    }
}

static void write_laws(FILE *to, const char *name, const kelly_laws *l)
{
    fprintf(to, "  \"%s\": {\"rpm\": %.9g, \"wob_kN\": %.9g, \"mu\": %.9g, \"alpha1\": %.9g, \"alpha2\": %.9g, \"cov\": {", name, (double)l->mean[4] / RPM,
            (double)l->mean[0] / 1000.0, (double)l->mean[1], (double)l->mean[2], (double)l->mean[3]);
    for (unsigned k = 0; k < KELLY_PARAMETERS; k++) {
        fprintf(to, "%s\"%s\": %.9g", k ? ", " : "", names[k], (double)l->cov[k]);
    }
    fputs("}},\n", to);
}

static void write_json(FILE *to, const request *ask)
{
    const kelly_reweighted *const r = &ask->result;

    fprintf(to, "{\n  \"probability\": %.17g,\n  \"ci95\": [%.17g, %.17g],\n  \"ess\": %.9g,\n  \"ess_predicted\": %.9g,\n  \"largest_share\": %.9g,\n",
            (double)r->probability, (double)r->lo, (double)r->hi, (double)r->ess, (double)r->ess_predicted, (double)r->share);
    write_laws(to, "laws", &ask->is);
    write_laws(to, "laws_run", &ask->was);
    fprintf(to, "  \"limit\": %.9g,\n  \"samples\": %u,\n  \"stuck_run\": %u,\n  \"refused\": %u,\n  \"seed\": %llu,\n  \"first\": %u,\n", ask->limit, ask->samples,
            ask->stuck, ask->refused, (unsigned long long)ask->run.seed, ask->run.first);
    fprintf(to, "  \"method\": \"self-normalised likelihood ratio\",\n  \"real\": \"%s\",\n  \"model\": \"%s\"\n}\n", ask->run.in_double ? "double" : "float",
            ask->run.model);
}

static void print_result(const request *ask)
{
    const kelly_reweighted *const r = &ask->result;

    printf("%s: %u realisations of %s, %u refused, reweighted\n", ask->from, ask->samples, ask->run.model, ask->refused);
    for (unsigned k = 0; k < KELLY_PARAMETERS; k++) {
        printf("  %-5s mean %.6g, cov %.4g   as run %.6g, %.4g\n", names[k], (double)ask->is.mean[k] / units[k], (double)ask->is.cov[k],
               (double)ask->was.mean[k] / units[k], (double)ask->was.cov[k]);
    }
    printf("P(stick-slip) = %.4f   95 %% interval %.4f .. %.4f   (ss > %.6g)\n", (double)r->probability, (double)r->lo, (double)r->hi, ask->limit);
    printf("effective samples %.0f (predicted by the laws %.0f), largest share %.4f\n", (double)r->ess, (double)r->ess_predicted, (double)r->share);
}

static const option_help own_options[] = {
    { "--from", "F.csv", "the CSV of a run of montecarlo" },
    { "--case-json", "F.json", "the JSON that the same run wrote; its laws are checked against every line (default: F.json beside F.csv)" },
    { "--cov", "D", "coefficients of variation of the other laws: one for all, or fc=D,mu=D,a1=D,a2=D,rpm=D (default: as run)" },
    { "--rpm", "R", "mean top speed [rpm] (default: as run)" },
    { "--wob", "KN", "mean weight on bit [kN]; its amplitude stays as it was run (default: as run)" },
    { "--mu", "M", "mean bit-rock factor [m] (default: as run)" },
    { "--alpha1", "A", "mean alpha_1 [s/rad] (default: as run)" },
    { "--alpha2", "A", "mean alpha_2 [s2/rad2] (default: as run)" },
    { "--limit", "S", "severity above which a run counts as stick-slip (default: as run)" },
    { 0 },
};

const command_help whatif_help = {
    .brief = "P under other means and spreads, from a run on file, without running",
    .synopsis = "--from run.csv [--case-json run.json] [--cov D] [--mu M] [--rpm R] [--wob KN] [--json F] ...",
    .takes = TAKES_JSON,
    .own = own_options,
    .notes = "Each realisation counts with the ratio of its likelihoods under the other laws and those that were run. Nothing is said where\n"
             "the effective sample size, measured or predicted by the laws alone, is below 100, or one realisation has more than 5 %\n"
             "of the weight. Run with wide laws and ask for narrower ones: that reaches furthest. f0, start, times and string stay.",
    .example = "kelly whatif --from run.csv --mu 0.0042 --cov 0.15",
};

int command_whatif(int argc, char **argv)
{
    static request ask;
    options opts;
    outfile json = { 0 };

    for (unsigned k = 0; k < KELLY_PARAMETERS; k++) {
        ask.mean[k] = (double)NAN;
        ask.cov[k] = NAN;
    }
    ask.limit = (double)NAN;
    options_parse(&opts, argc, argv, TAKES_JSON, "whatif", own_option, &ask);
    if (!ask.from) {
        die(EXIT_USAGE, "whatif: nothing to start from; give --from F.csv, what montecarlo --csv F.csv --json F.json wrote");
    }
    stored_need(ask.from);
    ask.case_json = ask.case_json ? ask.case_json : case_beside(ask.from);
    stored_need(ask.case_json);
    stored_open_run(&ask.run, ask.case_json);
    check_input(ask.from, &opts.json, 1);
    check_input(ask.run.path, &opts.json, 1);
    ask.limit = isnan(ask.limit) ? (double)ask.run.run.limit : ask.limit;
    settle_laws(&ask);
    kelly_reweight_start(&ask.sums, &ask.was, &ask.is);
    read_rows(&ask);
    kelly_reweight_read(&ask.sums, &ask.result);
    refuse_if_too_far(&ask);
    if (opts.json) {
        outfile_open(&json, opts.json);
        write_json(json.stream, &ask);
        outfile_close(&json);
    }
    if (!opts.quiet && !(opts.json && strcmp(opts.json, "-") == 0)) {
        print_result(&ask);
    }
    return EXIT_DONE;
}
