/* outcome.h - what an ensemble came to, whoever ran it: the files, the JSON and the summary of montecarlo. */
#ifndef KELLY_OUTCOME_H
#define KELLY_OUTCOME_H

#include "host.h"
#include "journal.h"

#define OUTCOME_HEADER "index,fc_kN,mu,alpha1,alpha2,rpm,bit_min_rpm,bit_max_rpm,bit_mean_rpm,ss,stuck,status,liftoff"
#define OUTCOME_END "  \"crc32c\": \"%08x\"\n}\n"   /* of the JSON: CRC-32C of every byte before it */
#define LISTED 100u              /* refused realisations that are named one by one in the JSON */

/* Start from zeros; `envelope`, `until`, `more` and `convergence` are the caller's, the rest is not to be touched. */
typedef struct {
    const options *opts;
    const char *engine;          /* who computed */
    kelly_tally tally;
    uint32_t asked;              /* --samples */
    uint32_t stuck_ssi;          /* counted realisations whose SSI exceeds the limit */
    uint32_t identity;           /* case_identity */
    outfile csv, json;
    uint32_t csv_crc;            /* CRC-32C of the CSV, where both are written */
    uint32_t refused[LISTED];
    uint8_t why[LISTED];
    double start, seconds;
    journal log, convergence_log, envelope_log;   /* open where the run keeps them; removed when the files are in their places */
    convergence_table convergence;
    envelope_request envelope;
    until_request until;
    void (*more)(FILE *to, const void *of);   /* further members of the JSON, each with its comma; or 0 */
    const void *more_of;
} outcome;

/* Open the files that opts ask for; dies where one cannot be written. */
void outcome_open(outcome *out, const options *opts, const char *engine);

/* Where the journal lies: beside the first of the outputs that is a file, or 0. Dies with exit 2 for --resume without one, and tells what to
 * give; outcome_beside is for a JSON alone. */
const char *first_output(const options *opts, const char *const outputs[], unsigned count, const char *give);
const char *outcome_beside(const options *opts);

/* Lines of the CSV, as text. */
void outcome_lines(outcome *out, const char *text, size_t length);

/* Take results of indices in increasing order: a batch_sink, its context an outcome. */
void outcome_take(void *context, uint32_t first, uint32_t count, const void *results);

/* Parts of the JSON, each with its comma, and of the summary, for what is reported otherwise: the case; the refused ones by index.
 * `where` names the place that lists more of these than the terminal does. */
void outcome_write_case(FILE *to, const outcome *out);
void outcome_write_refused(FILE *to, const outcome *out);
void outcome_print_case(const outcome *out);
void outcome_print_refused(const outcome *out, const char *where);

/* Whether a summary is wanted on stdout: no --quiet, and stdout is not one of the files. */
int outcome_speaks(const options *opts);

/* What a reader of the one number must know: lift-off, and many refused for their step or their weight. */
void outcome_warn(const kelly_case *run, const kelly_tally *t);

/* A probability of nothing is no answer: says so on stderr, and what would help; the exit status. */
int outcome_answered(const outcome *out);

/* What helps where none of these realisations of a case could be trusted; `text` may be used for it. */
#define ADVICE_TEXT 160
const char *advice_on(const kelly_case *run, const kelly_tally *t, char text[ADVICE_TEXT]);

/* Write what is left, close the files, remove the journal, print the summary. Returns the exit status: EXIT_FAILED, with one line of why on
 * stderr, where no realisation could be trusted. */
int outcome_close(outcome *out);

#endif
