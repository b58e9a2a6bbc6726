/* cmd_merge.c - parts of one ensemble, made anywhere, put together.
 *
 * A part is what `montecarlo --first J --samples N --csv F.csv --json F.json` leaves. The report beside a CSV says whose realisations it
 * holds (string, precision, seed, identity of the case, first, samples), their counts, their digest, the CRC-32C of the CSV, and at its
 * end that of itself: a change of either is noticed, and counts must be those of the lines. That is enough for a result that equals one
 * run's to the last bit: lines are copied as they are, counts are added, and digests are put together as CRCs are (see joined), so that no
 * number of the CSV has to be converted back.
 * The convergence function and envelopes are not sums over parts, and are left out.
 */
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "../firmware/link/crc32c.h"
#include "stored.h"

#define RECORD (5u + 9u * (unsigned)sizeof(real))   /* bytes of a realisation in the digest, see tally.h */

typedef struct {
    const char *given;           /* as on the command line */
    const char *csv;             /* the same, or 0 where it is a report */
    stored_part is;
} part;

static const option_help merge_options[] = {
    { "--csv", "F", "all lines, as one run would have written them; - is stdout" },
    { 0 },
};

const command_help merge_help = {
    .brief = "parts of an ensemble put together: the files and the digest of one run",
    .synopsis = "a.csv b.csv ... [--csv F] [--json F]",
    .takes = TAKES_JSON,
    .own = merge_options,
    .notes = "Parts are runs of montecarlo that differ in --first and --samples alone, each with --csv NAME.csv and --json NAME.json: the report\n"
             "beside a CSV says what the CSV holds. Reports may be given alone, NAME.json, where no CSV is wanted.\n"
             "In any order. Gaps, overlaps, parts of other runs and files that were changed are named, exit 2. \"seconds\" is the sum.",
    .example = "kelly merge part0.csv part1.csv part2.csv --csv all.csv --json all.json",
};

/* ---- parts ------------------------------------------------------------------------------------------------------------ */

static void refuse_unfinished(const char *path)
{
    char log[4200];

    snprintf(log, sizeof(log), "%s.journal", path);
    if (access(log, F_OK) == 0) {
        die(EXIT_USAGE, "%s: not finished, %s is beside it; go on with its run and --resume", path, log);
    }
}

/* NAME.csv with NAME.json beside it, or NAME.json alone. */
static void load(part *p, const char *given)
{
    const size_t length = strlen(given);
    const int is_csv = length > 4 && strcmp(given + length - 4, ".csv") == 0;
    char json[4096];

    if ((!is_csv && (length < 6 || strcmp(given + length - 5, ".json") != 0)) || length + 2 > sizeof(json)) {
        die(EXIT_USAGE, "merge: '%s' is neither a CSV nor a report of montecarlo; give NAME.csv or NAME.json", given);
    }
    snprintf(json, sizeof(json), "%.*s.json", (int)length - (is_csv ? 4 : 5), given);
    refuse_unfinished(given);
    refuse_unfinished(json);
    stored_need(given);
    if (access(json, F_OK) != 0) {
        die(EXIT_USAGE, "%s: %s is not beside it, so nothing says whose run it is; run the part with --json %s", given, json, json);
    }
    p->given = given;
    p->csv = is_csv ? given : 0;
    stored_open_part(&p->is, json);
    if ((uint64_t)p->is.of.first + p->is.of.samples > (uint64_t)UINT32_MAX + 1) {
        die(EXIT_USAGE, "%s: indices %u + %u; they end at 4294967295", json, p->is.of.first, p->is.of.samples);
    }
    if (is_csv && !p->is.of.has_csv) {
        die(EXIT_USAGE, "%s: %s is of a run without --csv; give the report of the run that wrote it", given, json);
    }
}

/* Name the first thing in which two cases differ; their lines stand in the same order. */
static _Noreturn void refuse_case(const part *p, const part *base)
{
    const char *here = p->is.case_text, *there = base->is.case_text;

    while (*here && *there) {
        const size_t n = strcspn(here, "\n"), m = strcspn(there, "\n"), name = strcspn(here, " ");

        if (n != m || strncmp(here, there, n) != 0) {
            die(EXIT_USAGE, "%s: of another run: %.*s, in %s %.*s", p->given, (int)n, here, base->given, (int)(m > name ? m - name - 1 : 0),
                there + (m > name ? name + 1 : m));
        }
        here += n + (here[n] != '\0');
        there += m + (there[m] != '\0');
    }
    die(EXIT_USAGE, "%s: of another run than %s: another version of kelly, or cases that differ behind the digits of the reports", p->given,
        base->given);
}

/* Dies where the CSV is not the one that its report is of, which is told before what the report says. */
static void check_pair(const part *p)
{
    FILE *const in = p->csv ? fopen(p->csv, "rb") : 0;
    uint8_t piece[4096];
    uint32_t crc = 0;
    size_t n;

    while (in && (n = fread(piece, 1, sizeof(piece), in)) > 0) {
        crc = kelly_crc32c(crc, piece, n);
    }
    if (in && !ferror(in)) {
        stored_check_csv(&p->is.of, p->csv, crc);
    }
    if (in) {
        (void)fclose(in);
    }
}

/* Dies unless both are of one run. */
static void compare(const part *p, const part *base)
{
    const stored_run *const a = &p->is.of, *const b = &base->is.of;

    if (strcmp(a->model, kelly_string.id) != 0 || a->in_double != (sizeof(real) > 4) || a->seed != b->seed || p->is.identity != base->is.identity) {
        check_pair(p);
        check_pair(base);
    }
    if (strcmp(a->model, kelly_string.id) != 0) {
        die(EXIT_USAGE, "%s: of another run: string %s, this program's is %s", p->given, a->model, kelly_string.id);
    }
    if (a->in_double != (sizeof(real) > 4)) {
        die(EXIT_USAGE, "%s: of another run: in %s, this program is in %s", p->given, a->in_double ? "double" : "float", a->in_double ? "float" : "double");
    }
    if (a->seed != b->seed) {
        die(EXIT_USAGE, "%s: of another run: seed %llu, in %s %llu", p->given, (unsigned long long)a->seed, base->given, (unsigned long long)b->seed);
    }
    if (p->is.identity != base->is.identity) {
        refuse_case(p, base);
    }
}

static int by_first(const void *a, const void *b)
{
    const stored_run *const p = &((const part *)a)->is.of, *const q = &((const part *)b)->is.of;

    return (p->first > q->first) - (p->first < q->first);
}

/* In the order of their indices; dies of gaps and overlaps. */
static void sort(part *parts, unsigned count)
{
    uint64_t total;

    qsort(parts, count, sizeof(*parts), by_first);
    total = parts[0].is.of.samples;
    for (unsigned i = 1; i < count; i++) {
        const stored_run *const a = &parts[i - 1].is.of, *const b = &parts[i].is.of;
        const uint64_t end = (uint64_t)a->first + a->samples, last = (uint64_t)b->first + b->samples;

        if (b->first != end) {
            check_pair(&parts[i - 1]);
            check_pair(&parts[i]);
        }
        if (b->first < end) {
            die(EXIT_USAGE, "%s and %s overlap: both hold %u..%llu; leave one of them out", parts[i - 1].given, parts[i].given, b->first,
                (unsigned long long)(end < last ? end : last) - 1);
        }
        if (b->first > end) {
            die(EXIT_USAGE, "a gap between %s and %s: %llu..%u are missing; give the part that holds them", parts[i - 1].given, parts[i].given,
                (unsigned long long)end, b->first - 1);
        }
        total += b->samples;
    }
    if (total > UINT32_MAX) {
        die(EXIT_USAGE, "merge: %llu realisations; a report counts up to 4294967295", (unsigned long long)total);
    }
}

/* ---- together --------------------------------------------------------------------------------------------------------- */

/* Product of two polynomials over GF(2) modulo that of CRC-32C, bit 31 being x^0. */
static uint32_t product(uint32_t a, uint32_t b)
{
    uint32_t sum = 0;

    for (uint32_t bit = 1u << 31; bit; bit >>= 1) {
        sum ^= a & bit ? b : 0;
        b = b >> 1 ^ (b & 1 ? 0x82F63B78u : 0);
    }
    return sum;
}

/* CRC of A followed by B, from their CRCs and the length of B: that of A times x^(8 length), plus that of B. */
static uint32_t joined(uint32_t a, uint32_t b, uint64_t length)
{
    uint32_t power = 1u << 23, shift = 1u << 31;   /* x^8, x^0 */

    for (; length; length >>= 1) {
        shift = length & 1 ? product(shift, power) : shift;
        power = product(power, power);
    }
    return product(shift, a) ^ b;
}

static void add_part(outcome *out, const stored_part *p)
{
    kelly_tally *const t = &out->tally;

    for (uint32_t i = 0, at = kelly_refused(t); i < p->refused_listed && at < LISTED; i++, at++) {
        out->refused[at] = p->refused_index[i];
        out->why[at] = p->refused_why[i];
    }
    t->digest = joined(t->digest, p->tally.digest, (uint64_t)p->tally.samples * RECORD);
    t->samples += p->tally.samples;
    t->stuck += p->tally.stuck;
    t->liftoff += p->tally.liftoff;
    for (unsigned k = 0; k < KELLY_STATUSES; k++) {
        t->status[k] += p->tally.status[k];
    }
    out->stuck_ssi += p->stuck_ssi;
    out->start -= p->seconds;
    out->engine = strcmp(out->engine, p->engine) == 0 ? out->engine : "several";
}

/* What a line says in its last three fields. One that says something else makes the sum wrong. */
static void count_line(kelly_tally *sum, const char *line)
{
    const char *field = line;

    for (unsigned k = 0; k < 10 && field; k++) {
        field = strchr(field, ',');
        field += field != 0;
    }
    if (!field || strlen(field) < 7) {
        return;
    }
    for (unsigned k = 0; k < KELLY_STATUSES; k++) {
        const size_t n = strlen(status_names[k]);

        if (strncmp(field + 2, status_names[k], n) == 0 && field[2 + n] == ',') {
            sum->samples++;
            sum->status[k]++;
            sum->stuck += field[0] == '1';
            sum->liftoff += field[3 + n] == '1';
        }
    }
}

/* Dies unless the counts of a report are those of its lines. */
static void check_counts(const part *p, const kelly_tally *lines)
{
    const kelly_tally *const said = &p->is.tally;
    char by[32] = "";

    for (unsigned k = KELLY_STEP; k < KELLY_STATUSES; k++) {
        if (said->status[k] != lines->status[k]) {
            snprintf(by, sizeof(by), "refused_by.%s", status_names[k]);
        }
    }
    if (said->samples != lines->samples || said->stuck != lines->stuck || said->liftoff != lines->liftoff || by[0]) {
        die(EXIT_USAGE, "%s: \"%s\" is not what the lines of %s say; run the part again", p->is.of.path, said->samples != lines->samples ? "samples" :
            said->stuck != lines->stuck ? "stuck" : said->liftoff != lines->liftoff ? "liftoff" : by, p->csv);
    }
}

/* Copy a part's lines, but for its header; dies if they are not those that its report is of. */
static void add_csv(outcome *out, const part *p)
{
    FILE *const in = fopen(p->csv, "rb");
    kelly_tally lines = { 0 };
    char *line = 0;
    size_t room = 0;
    ssize_t n;
    uint32_t crc = 0;

    if (!in) {
        die(EXIT_FAILED, "%s: cannot be read: %s", p->csv, strerror(errno));
    }
    for (int header = 1; (n = getline(&line, &room, in)) > 0; header = 0) {
        crc = kelly_crc32c(crc, (const uint8_t *)line, (size_t)n);
        if (!header) {
            count_line(&lines, line);
            if (out->opts->csv) {
                outcome_lines(out, line, (size_t)n);
            }
        }
    }
    if (ferror(in)) {
        die(EXIT_FAILED, "%s: cannot be read: %s", p->csv, strerror(errno));
    }
    free(line);
    (void)fclose(in);
    stored_check_csv(&p->is.of, p->csv, crc);
    check_counts(p, &lines);
}

/* ---- the command ------------------------------------------------------------------------------------------------------- */

/* --csv belongs to ensembles in the shared parser, which this is not. */
static int own_option(void *context, const char *name, const char *value)
{
    const char **const csv = context;

    if (strcmp(name, "--csv") == 0) {
        *csv = value;
        return 1;
    }
    return 0;
}

/* Files go to the front of argv, options with their values behind them; returns the number of files. */
static unsigned files_first(int argc, char **argv, char **sorted)
{
    unsigned files = 0, at = 0;

    for (int pass = 0; pass < 2; pass++) {
        for (int i = 0; i < argc; i++) {
            const int option = strncmp(argv[i], "--", 2) == 0;
            const int two = option && !strchr(argv[i], '=') && strcmp(argv[i], "--quiet") != 0 && i + 1 < argc;

            if (option == pass) {
                sorted[at++] = argv[i];
                if (two) {
                    sorted[at++] = argv[i + 1];
                }
            }
            i += two;
        }
        files = pass == 0 ? at : files;
    }
    return files;
}

static part *load_all(char **names, unsigned count, const options *opts)
{
    part *const parts = calloc(count, sizeof(*parts));

    if (!parts) {
        die(EXIT_FAILED, "out of memory for %u parts", count);
    }
    for (unsigned i = 0; i < count; i++) {
        load(&parts[i], names[i]);
        compare(&parts[i], &parts[0]);
        check_input(names[i], (const char *const[]){ opts->csv, opts->json }, 2);
        check_input(parts[i].is.of.path, (const char *const[]){ opts->csv, opts->json }, 2);
        if (opts->csv && !parts[i].csv) {
            die(EXIT_USAGE, "%s: a report without its lines, and --csv wants them; give the CSV", parts[i].given);
        }
    }
    sort(parts, count);
    return parts;
}

int command_merge(int argc, char **argv)
{
    static outcome out;
    options opts;
    const char *csv = 0;
    char **const sorted = calloc((size_t)argc + 1, sizeof(*sorted));
    const unsigned count = sorted ? files_first(argc, argv, sorted) : 0;
    part *parts;

    options_parse(&opts, argc - (int)count, sorted + count, TAKES_JSON, "merge", own_option, &csv);
    opts.csv = csv;
    if (count == 0) {
        die(EXIT_USAGE, "merge: nothing to merge; give the parts, e.g. kelly merge a.csv b.csv --csv all.csv --json all.json");
    }
    check_outputs((const char *const[]){ opts.csv, opts.json }, 2);
    parts = load_all(sorted, count, &opts);
    opts.run = parts[0].is.of.run;
    opts.seed = parts[0].is.of.seed;
    opts.first = parts[0].is.of.first;
    outcome_open(&out, &opts, parts[0].is.engine);
    out.identity = parts[0].is.identity;
    for (unsigned i = 0; i < count; i++) {
        add_part(&out, &parts[i].is);
        if (parts[i].csv) {
            add_csv(&out, &parts[i]);
        }
    }
    return outcome_close(&out);
}
