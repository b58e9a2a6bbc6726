/* cmd_merge.c - parts of one ensemble, made anywhere, put together.
 *
 * A part is what `montecarlo --first J --samples N --csv F.csv --json F.json` leaves. The report beside a CSV says whose realisations it
 * holds (string, precision, seed, identity of the case, first, samples), their counts, their digest, and the CRC-32C of the CSV. That
 * is enough for a result that equals one run's to the last bit: lines are copied as they are, counts are added, and
 * digests are put together as CRCs are (see joined), which needs no number of the CSV to be converted back.
 * The convergence function and envelopes are not sums over parts, and are left out.
 */
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "../firmware/link/crc32c.h"
#include "json.h"
#include "parts.h"

#define RECORD (5u + 9u * (unsigned)sizeof(real))   /* bytes of a realisation in the digest, see tally.h */

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

/* ---- together ------------------------------------------------------------------------------------------------------- */

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

static uint32_t count_of(const part *p, const char *name)
{
    return (uint32_t)json_whole(p->json, p->text, name, p->samples);
}

static void add_refused(outcome *out, const part *p)
{
    uint32_t listed = kelly_refused(&out->tally) < LISTED ? kelly_refused(&out->tally) : LISTED;

    for (const char *e = json_first(json_find(p->text, "refused_first")); e && listed < LISTED; e = json_next(e)) {
        const char *const index = json_first(e), *const why = index ? json_next(index) : 0;

        out->refused[listed] = (uint32_t)strtoul(index ? index : "", 0, 10);
        for (uint8_t k = 1; why && k < KELLY_STATUSES; k++) {
            if (strncmp(why + 1, status_names[k], strlen(status_names[k])) == 0) {
                out->why[listed] = k;
            }
        }
        listed++;
    }
}

static void add_part(outcome *out, const part *p)
{
    kelly_tally *const t = &out->tally;
    char engine[32];
    static char all[32];

    add_refused(out, p);
    t->digest = joined(t->digest, p->digest, (uint64_t)p->samples * RECORD);
    t->samples += p->samples;
    t->stuck += count_of(p, "stuck");
    t->liftoff += count_of(p, "liftoff");
    t->status[KELLY_STEP] += count_of(p, "refused_by.step");
    t->status[KELLY_RANGE] += count_of(p, "refused_by.range");
    t->status[KELLY_NONFINITE] += count_of(p, "refused_by.nonfinite");
    out->stuck_ssi += count_of(p, "ssi.stuck");
    out->seconds += json_number(p->json, p->text, "seconds");
    json_text(p->json, p->text, "engine", engine, sizeof(engine));
    snprintf(all, sizeof(all), "%s", !out->engine || strcmp(out->engine, engine) == 0 ? engine : "several");
    out->engine = all;
}

/* ---- files ------------------------------------------------------------------------------------------------------------ */

/* Copy a part's lines, but for its header; dies if they are not those that its report is of. */
static void copy_csv(outcome *out, const part *p)
{
    static char block[1 << 16];
    FILE *const in = fopen(p->csv, "rb");
    const size_t header = strlen(outcome_csv_header);
    uint32_t crc = 0;
    uint64_t at = 0;
    size_t n;

    if (!in) {
        die(EXIT_FAILED, "%s: cannot be read: %s", p->csv, strerror(errno));
    }
    while ((n = fread(block, 1, sizeof(block), in)) > 0) {
        const size_t skip = at == 0 ? (n < header ? n : header) : 0;

        crc = kelly_crc32c(crc, (const uint8_t *)block, n);
        if (out->csv) {
            fwrite(block + skip, 1, n - skip, out->csv);
            out->csv_crc = kelly_crc32c(out->csv_crc, (const uint8_t *)block + skip, n - skip);
        }
        at += n;
    }
    if (ferror(in)) {
        die(EXIT_FAILED, "%s: cannot be read: %s", p->csv, strerror(errno));
    }
    fclose(in);
    if (crc != p->csv_crc) {
        die(EXIT_USAGE, "%s: not the file that %s is of (CRC-32C %08x, there %08x): changed, cut short or of another run; run the part again",
            p->csv, p->json, crc, p->csv_crc);
    }
}

static void write_csv(outcome *out, const part *parts, unsigned count, const char *path)
{
    outfile csv;

    if (path) {
        outfile_open(&csv, path);
        out->csv = csv.stream;
        fputs(outcome_csv_header, csv.stream);
        out->csv_crc = kelly_crc32c(0, (const uint8_t *)outcome_csv_header, strlen(outcome_csv_header));
    }
    for (unsigned i = 0; i < count; i++) {
        if (parts[i].csv) {
            copy_csv(out, &parts[i]);
        }
    }
    if (path) {
        outfile_close(&csv);
    }
}

/* ---- the command --------------------------------------------------------------------------------------------------------- */

/* What follows is its value, not a file. */
static int takes_next(const char *argument)
{
    return strncmp(argument, "--", 2) == 0 && !strchr(argument, '=') && strcmp(argument, "--quiet") != 0;
}

/* --csv belongs to ensembles in the shared parser, which this is not. */
static int own_option(void *context, const char *name, const char *value)
{
    options *const opts = context;

    if (strcmp(name, "--csv") == 0) {
        opts->csv = value;
        return 1;
    }
    return 0;
}

/* Files go to the front of argv, the rest behind them; returns the number of files. */
static unsigned files_first(int argc, char **argv, char **sorted)
{
    unsigned files = 0, at = 0;

    for (int pass = 0; pass < 2; pass++) {
        for (int i = 0; i < argc; i++) {
            const int option = strncmp(argv[i], "--", 2) == 0, two = takes_next(argv[i]) && i + 1 < argc;

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

int command_merge(int argc, char **argv)
{
    static outcome out;
    options opts, mine = { 0 };
    char **const sorted = calloc((size_t)argc + 1, sizeof(*sorted));
    part *const parts = calloc((size_t)argc + 1, sizeof(*parts));
    outfile json;
    unsigned count;

    if (!sorted || !parts) {
        die(EXIT_FAILED, "out of memory");
    }
    count = files_first(argc, argv, sorted);
    options_parse(&opts, argc - (int)count, sorted + count, TAKES_JSON, "merge", own_option, &mine);
    opts.csv = mine.csv;
    if (count == 0) {
        die(EXIT_USAGE, "merge: nothing to merge; give the parts, e.g. kelly merge a.csv b.csv --csv all.csv --json all.json");
    }
    if (opts.csv && opts.json && strcmp(opts.csv, opts.json) == 0) {
        die(EXIT_USAGE, "--csv %s --json %s: one place for two results; give each its own", opts.csv, opts.json);
    }
    for (unsigned i = 0; i < count; i++) {
        part_load(&parts[i], sorted[i]);
        part_compare(&parts[i], &parts[0]);
        if (opts.csv && !parts[i].csv) {
            die(EXIT_USAGE, "%s: a report without its lines, and --csv wants them; give the CSV", parts[i].given);
        }
    }
    parts_sort(parts, count);
    part_case(&parts[0], &opts);
    opts.first = parts[0].first;
    out.opts = &opts;
    out.identity = parts[0].identity;
    for (unsigned i = 0; i < count; i++) {
        add_part(&out, &parts[i]);
    }
    write_csv(&out, parts, count, opts.csv);
    if (opts.json) {
        outfile_open(&json, opts.json);
        outcome_json(json.stream, &out);
        outfile_close(&json);
    }
    if (!opts.quiet && !(opts.json && strcmp(opts.json, "-") == 0) && !(opts.csv && strcmp(opts.csv, "-") == 0)) {
        outcome_print(&out);
    }
    return EXIT_DONE;
}
