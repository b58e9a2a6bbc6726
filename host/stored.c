/* stored.c - the JSON of a run, see stored.h. Nothing is guessed: a key that is not as montecarlo writes it ends the reading. */
#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "../firmware/link/crc32c.h"
#include "stored.h"

#define WINDOW "case.window_s"   /* the key of a list */
#define NEAR_TIME 1e-8           /* of a time, relative: twelve digits of it are on file, of older runs nine */
#define NEAR_REAL 1e-6           /* of a parameter, relative */

const char *const status_names[KELLY_STATUSES] = { "ok", "step", "range", "nonfinite", "corrupt" };

/* Keys of the JSON, and where their values go. Up to REAL_ they must be there for every use; CRC is the last that merge needs. */
enum { RPM_, WOB, MU, ALPHA1, ALPHA2, LIMIT, COV_FC, COV_MU, COV_A1, COV_A2, COV_RPM, FIRST, SAMPLES, STUCK, REFUSED, SEED, MODEL, REAL_,
       F0, DURATION, STEP, TORSIONAL, LIFTOFF, BY_STEP, BY_RANGE, BY_NONFINITE, BY_CORRUPT, STUCK_SSI, SECONDS, START, DRIVE, DIGEST,
       IDENTITY, ENGINE, CRC, CSV_CRC, STOPPED, KEYS };
static const char *const keys[KEYS] = { "case.rpm", "case.wob_kN", "case.mu", "case.alpha1", "case.alpha2", "case.limit", "case.cov.fc", "case.cov.mu",
                                        "case.cov.a1", "case.cov.a2", "case.cov.rpm", "first", "samples", "stuck", "refused", "seed", "model", "real",
                                        "case.f0_kN", "case.duration_s", "case.step_s", "case.torsional", "liftoff", "refused_by.step",
                                        "refused_by.range", "refused_by.nonfinite", "refused_by.corrupt", "ssi.stuck", "seconds", "case.start", "case.drive",
                                        "digest", "identity", "engine", "crc32c", "csv_crc32c", "sequence.stopped" };

typedef struct {
    const char *path;
    double number[KEYS];
    char text[KEYS][DRIVE_TEXT];
    int seen[KEYS];
    double window[2];
    unsigned windows;            /* numbers in it */
    stored_part *part;           /* or 0 */
    int index_taken;             /* of the pair of refused_first that is being read */
} found;

/* A line more of the case, for who compares two of them. */
static void note_case(stored_part *part, const char *name, const char *value)
{
    const size_t used = strlen(part->case_text);

    snprintf(part->case_text + used, sizeof(part->case_text) - used, "%s %s\n", name, value);
}

/* The pairs of refused_first: an index, then its status. */
static void take_refused(found *f, const char *value)
{
    stored_part *const part = f->part;
    const uint32_t at = part->refused_listed;

    if (at == LISTED) {
        return;
    }
    if (!f->index_taken) {
        part->refused_index[at] = (uint32_t)strtoul(value, 0, 10);
    } else {
        for (unsigned k = 0; k < KELLY_STATUSES; k++) {
            part->refused_why[at] = strcmp(value, status_names[k]) == 0 ? (uint8_t)k : part->refused_why[at];
        }
        part->refused_listed++;
    }
    f->index_taken = !f->index_taken;
}

static void take_key(void *context, const char *path, const char *value)
{
    found *const f = context;

    for (unsigned k = 0; k < KEYS; k++) {
        if (strcmp(path, keys[k]) == 0) {
            if (strlen(value) >= sizeof(f->text[k]) || f->seen[k]) {
                die(EXIT_USAGE, "%s: \"%s\" stands twice or is too long; give the JSON of a run of montecarlo", f->path, keys[k]);
            }
            strcpy(f->text[k], value);
            f->number[k] = strtod(value, 0);
            f->seen[k] = 1;
        }
    }
    if (strcmp(path, WINDOW) == 0 && f->windows < 2) {
        f->window[f->windows++] = strtod(value, 0);
    }
    if (f->part && strncmp(path, "case.", 5) == 0) {
        note_case(f->part, path + 5, value);
    }
    if (f->part && strcmp(path, "refused_first") == 0) {
        take_refused(f, value);
    }
}

void stored_need(const char *path)
{
    struct stat there;

    if (access(path, F_OK) != 0) {
        die(EXIT_USAGE, "%s: there is no such file; give what montecarlo --csv F.csv --json F.json wrote", path);
    }
    if (stat(path, &there) == 0 && S_ISDIR(there.st_mode)) {
        die(EXIT_USAGE, "%s: a directory; give what montecarlo --csv F.csv --json F.json wrote", path);
    }
}

static char *read_all(const char *path)
{
    FILE *const from = fopen(path, "r");
    char *text = 0;
    size_t room = 0;
    const ssize_t n = from ? getdelim(&text, &room, '\0', from) : 0;

    if (!from || (n < 0 && ferror(from))) {
        die(EXIT_FAILED, "%s: cannot be read: %s", path, strerror(errno));
    }
    if (n > 0 && strlen(text) < (size_t)n) {
        die(EXIT_USAGE, "%s: no JSON from character %ld on; give the JSON that the same run of montecarlo wrote", path, (long)n);
    }
    (void)fclose(from);
    text = text ? text : strdup("");
    if (!text) {
        die(EXIT_FAILED, "%s: out of memory", path);
    }
    return text;
}

static double number_in(const found *f, unsigned k, double lo, double hi)
{
    if (!f->seen[k] || !(f->number[k] >= lo && f->number[k] <= hi)) {
        die(EXIT_USAGE, "%s: no \"%s\" in %g..%g; give the JSON that the same run of montecarlo wrote", f->path, keys[k], lo, hi);
    }
    return f->number[k];
}

/* A parameter, which a float may have rounded beyond what was asked for. */
static double real_in(const found *f, unsigned k, double lo, double hi)
{
    return number_in(f, k, lo - NEAR_REAL * lo, hi + NEAR_REAL * hi);
}

static uint32_t whole_in(const found *f, unsigned k)
{
    const double x = number_in(f, k, 0, UINT32_MAX);

    if (x != floor(x)) {
        die(EXIT_USAGE, "%s: \"%s\" is no whole number; give the JSON that the same run of montecarlo wrote", f->path, keys[k]);
    }
    return (uint32_t)x;
}

/* A count of what there are at most `most` of. */
static uint32_t count_in(const found *f, unsigned k, uint32_t most)
{
    const uint32_t n = whole_in(f, k);

    if (n > most) {
        die(EXIT_USAGE, "%s: \"%s\" is %u of %u; give the JSON that the same run of montecarlo wrote", f->path, keys[k], n, most);
    }
    return n;
}

/* The text of a number without sign, point or exponent. */
static const char *digits_in(const found *f, unsigned k)
{
    if (strspn(f->text[k], "0123456789") != strlen(f->text[k])) {
        die(EXIT_USAGE, "%s: \"%s\" is no whole number; give the JSON that the same run of montecarlo wrote", f->path, keys[k]);
    }
    return f->text[k];
}

/* Whether it is the second of two words. */
static int second_in(const found *f, unsigned k, const char *first, const char *second)
{
    if (strcmp(f->text[k], first) != 0 && strcmp(f->text[k], second) != 0) {
        die(EXIT_USAGE, "%s: \"%s\" is neither %s nor %s; give the JSON that the same run of montecarlo wrote", f->path, keys[k], first, second);
    }
    return strcmp(f->text[k], second) == 0;
}

static uint32_t crc_in(const found *f, unsigned k)
{
    char *end;
    const unsigned long x = strtoul(f->text[k], &end, 16);

    if (strlen(f->text[k]) != 8 || *end != '\0' || !isxdigit((unsigned char)f->text[k][0])) {
        die(EXIT_USAGE, "%s: \"%s\" is no CRC of 8 hexadecimal digits; give the JSON that the same run of montecarlo wrote", f->path, keys[k]);
    }
    return (uint32_t)x;
}

/* Dies unless the report ends with the CRC of all before it. */
static void check_crc(const found *f, const char *text)
{
    char end[40];
    const size_t length = strlen(text), tail = (size_t)snprintf(end, sizeof(end), OUTCOME_END, 0u);
    const size_t before = length > tail ? length - tail : 0;

    snprintf(end, sizeof(end), OUTCOME_END, kelly_crc32c(0, (const uint8_t *)text, before));
    if (f->seen[CRC] && strcmp(text + before, end) != 0) {
        die(EXIT_USAGE, "%s: \"crc32c\" is not of what it holds: changed since it was written; give it as it was written, or run it again", f->path);
    }
}

static void open_run(stored_run *run, found *f)
{
    char *const text = read_all(f->path);
    const long wrong = json_walk(text, take_key, f);

    if (wrong >= 0) {
        die(EXIT_USAGE, "%s: no JSON from character %ld on; give the JSON that the same run of montecarlo wrote", f->path, wrong + 1);
    }
    if (f->part) {
        check_crc(f, text);
    }
    if (f->seen[STOPPED]) {
        die(EXIT_USAGE, "%s: a run that stopped itself (--until-...): no part of one with a given number, and intervals are of such; run it with --samples alone",
            f->path);
    }
    *run = (stored_run){ .path = strdup(f->path) };
    run->run.w0 = (real)(real_in(f, RPM_, 1e-3, 1e4) * RPM);
    run->run.fc = (real)(real_in(f, WOB, 1e-3, 1e6) * 1000.0);
    run->run.mu = (real)real_in(f, MU, 1e-9, 1e3);
    run->run.a1 = (real)real_in(f, ALPHA1, 1e-9, 1e6);
    run->run.a2 = (real)real_in(f, ALPHA2, 1e-9, 1e6);
    run->run.limit = (real)real_in(f, LIMIT, 0, 10);
    for (unsigned k = 0; k < KELLY_PARAMETERS; k++) {
        run->run.cov[k] = (float)real_in(f, COV_FC + k, 0, 0.5);
    }
    run->first = whole_in(f, FIRST);
    (void)number_in(f, SAMPLES, 1, UINT32_MAX);
    run->samples = whole_in(f, SAMPLES);
    run->refused = count_in(f, REFUSED, run->samples);
    run->stuck = count_in(f, STUCK, run->samples - run->refused);
    (void)number_in(f, SEED, 0, 1.9e19);
    run->seed = strtoull(digits_in(f, SEED), 0, 10);
    run->in_double = second_in(f, REAL_, "float", "double");
    run->has_csv = f->seen[CSV_CRC];
    run->csv_crc = run->has_csv ? crc_in(f, CSV_CRC) : 0;
    snprintf(run->model, sizeof(run->model), "%.63s", f->text[MODEL]);
    if (!f->part) {              /* last: what is wrong by itself is told by its name */
        check_crc(f, text);
    }
    free(text);
}

void stored_open_run(stored_run *run, const char *path)
{
    found f = { .path = path };

    open_run(run, &f);
}

/* A time of the case in steps. */
static uint32_t steps_in(const found *f, const char *key, double seconds, uint32_t step_ns)
{
    const double steps = nearbyint(seconds * 1e9 / step_ns), apart = fabs(seconds * 1e9 / step_ns - steps);

    if (!(steps >= 0 && steps <= STEPS_MOST && apart <= 1e-6 + NEAR_TIME * steps)) {
        die(EXIT_USAGE, "%s: \"%s\" holds %.12g, which is no 0..%g steps of %g s; give the JSON that the same run of montecarlo wrote", f->path, key,
            seconds, STEPS_MOST, 1e-9 * step_ns);
    }
    return (uint32_t)steps;
}

/* What a report tells of the case beside the laws: its numbers print again as they were printed. */
static void open_case(kelly_case *run, const found *f)
{
    run->f0 = (real)(real_in(f, F0, 0, 1e6) * 1000.0);
    run->torsional = (uint8_t)number_in(f, TORSIONAL, 1, KELLY_MODES_MAX);
    (void)digits_in(f, TORSIONAL);
    run->rotating = (uint8_t)second_in(f, START, "rest", "rotating");
    run->step_ns = steps_in(f, keys[STEP], number_in(f, STEP, 1e-6, 1), 1);
    run->ticks = steps_in(f, keys[DURATION], f->number[DURATION], run->step_ns);
    run->window_first = steps_in(f, WINDOW, f->window[0], run->step_ns);
    run->window_last = steps_in(f, WINDOW, f->window[1], run->step_ns);
    if (!(run->window_first < run->window_last && run->window_last <= run->ticks)) {
        die(EXIT_USAGE, "%s: \"" WINDOW "\" is no window within the duration; give the JSON that the same run of montecarlo wrote", f->path);
    }
    option_drive(&run->drive, f->text[DRIVE]);
}

/* The refused ones: by status, and those that are listed. */
static void open_refused(stored_part *part, const found *f)
{
    const stored_run *const run = &part->of;

    for (unsigned k = KELLY_STEP; k < KELLY_STATUSES; k++) {
        part->tally.status[k] = count_in(f, BY_STEP + k - KELLY_STEP, run->refused - kelly_refused(&part->tally));
    }
    if (kelly_refused(&part->tally) != run->refused || part->refused_listed != (run->refused < LISTED ? run->refused : LISTED) || f->index_taken) {
        die(EXIT_USAGE, "%s: \"refused\", \"refused_by\" and \"refused_first\" do not agree; give the JSON that montecarlo wrote", f->path);
    }
    for (uint32_t i = 0; i < part->refused_listed; i++) {
        if (part->refused_index[i] - run->first >= run->samples || part->refused_why[i] == KELLY_OK) {
            die(EXIT_USAGE, "%s: \"refused_first\" holds what is none of its realisations or no reason; give the JSON that montecarlo wrote", f->path);
        }
    }
}

void stored_open_part(stored_part *part, const char *path)
{
    found f = { .path = path, .part = part };

    *part = (stored_part){ 0 };
    open_run(&part->of, &f);
    for (unsigned k = F0; k <= CRC; k++) {
        if (!f.seen[k] || f.windows != 2) {
            die(EXIT_USAGE, "%s: no \"%s\"; give the JSON that this version of montecarlo wrote", path, f.seen[k] ? WINDOW : keys[k]);
        }
    }
    open_case(&part->of.run, &f);
    part->tally = (kelly_tally){ .samples = part->of.samples, .stuck = part->of.stuck, .liftoff = count_in(&f, LIFTOFF, part->of.samples), .digest = crc_in(&f, DIGEST) };
    open_refused(part, &f);
    part->stuck_ssi = count_in(&f, STUCK_SSI, part->of.samples - part->of.refused);
    part->identity = crc_in(&f, IDENTITY);
    part->seconds = number_in(&f, SECONDS, 0, 1e12);
    snprintf(part->engine, sizeof(part->engine), "%.31s", f.text[ENGINE]);
}
