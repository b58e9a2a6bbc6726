#include "parts.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "json.h"

static char *copy_of(const char *text, size_t length, const char *more)
{
    char *const copy = malloc(length + strlen(more) + 1);

    if (!copy) {
        die(EXIT_FAILED, "out of memory");
    }
    sprintf(copy, "%.*s%s", (int)length, text, more);
    return copy;
}

static uint32_t hexadecimal(const part *p, const char *name)
{
    char text[16], *end;
    unsigned long x;

    json_text(p->json, p->text, name, text, sizeof(text));
    x = strtoul(text, &end, 16);
    if (strlen(text) != 8 || *end) {
        die(EXIT_USAGE, "%s: \"%s\" is no CRC of 8 hexadecimal digits", p->json, name);
    }
    return (uint32_t)x;
}

static void refuse_unfinished(const char *path)
{
    char *const log = copy_of(path, strlen(path), ".journal");

    if (access(log, F_OK) == 0) {
        die(EXIT_USAGE, "%s: not finished, %s is beside it; go on with its run and --resume", path, log);
    }
    free(log);
}

/* NAME.csv with NAME.json beside it, or NAME.json alone. */
static void find_files(part *p, const char *given)
{
    const size_t length = strlen(given);
    const char *const end = length > 5 && strcmp(given + length - 5, ".json") == 0 ? ".json" : ".csv";
    const size_t stem = length - strlen(end);

    if (length <= strlen(end) || strcmp(given + stem, end) != 0) {
        die(EXIT_USAGE, "merge: '%s' is neither a CSV nor a report of montecarlo; give NAME.csv or NAME.json", given);
    }
    p->given = given;
    p->csv = strcmp(end, ".csv") == 0 ? copy_of(given, length, "") : 0;
    p->json = copy_of(given, stem, ".json");
    refuse_unfinished(given);
    refuse_unfinished(p->json);
    if (access(p->json, F_OK) != 0) {
        die(EXIT_USAGE, "%s: %s is not beside it, so nothing says whose run it is; run the part with --json %s", given, p->json, p->json);
    }
}

void part_load(part *p, const char *given)
{
    find_files(p, given);
    p->text = json_load(p->json);
    p->first = (uint32_t)json_whole(p->json, p->text, "first", UINT32_MAX);
    p->samples = (uint32_t)json_whole(p->json, p->text, "samples", UINT32_MAX);
    p->digest = hexadecimal(p, "digest");
    p->identity = hexadecimal(p, "identity");
    p->csv_crc = p->csv ? hexadecimal(p, "csv_crc32c") : 0;
    if (p->samples == 0 || (uint64_t)p->first + p->samples > (uint64_t)UINT32_MAX + 1) {
        die(EXIT_USAGE, "%s: realisations %u + %u are none", p->json, p->first, p->samples);
    }
}

static void same_text(const part *p, const char *name, const char *want, const char *where)
{
    char have[128];

    json_text(p->json, p->text, name, have, sizeof(have));
    if (strcmp(have, want) != 0) {
        die(EXIT_USAGE, "%s: of another run: %s %s, %s is %s", p->given, name, have, where, want);
    }
}

/* Name the first thing in which the cases differ. */
static _Noreturn void refuse_case(const part *p, const part *base)
{
    static const char *const names[] = { "rpm", "wob_kN", "mu", "alpha1", "alpha2", "f0_kN", "start", "duration_s", "window_s", "step_s", "limit",
                                         "torsional", "cov.fc", "cov.mu", "cov.a1", "cov.a2", "cov.rpm" };
    char name[32];

    for (unsigned k = 0; k < sizeof(names) / sizeof(names[0]); k++) {
        const char *here, *there;

        snprintf(name, sizeof(name), "case.%s", names[k]);
        here = json_find(p->text, name);
        there = json_find(base->text, name);
        if (here && there) {
            const unsigned n = json_length(here), m = json_length(there);

            if (n != m || strncmp(here, there, n) != 0) {
                die(EXIT_USAGE, "%s: of another run: %s %.*s, in %s %.*s", p->given, names[k], (int)n, here, base->given, (int)m, there);
            }
        }
    }
    die(EXIT_USAGE, "%s: of another run than %s: another version of kelly, or cases that differ behind the digits of the reports", p->given,
        base->given);
}

void part_compare(const part *p, const part *base)
{
    same_text(p, "model", kelly_string.id, "the string of this program");
    same_text(p, "real", sizeof(real) > 4 ? "double" : "float", "this program");
    if (json_whole(p->json, p->text, "seed", UINT64_MAX) != json_whole(base->json, base->text, "seed", UINT64_MAX)) {
        die(EXIT_USAGE, "%s: of another run: seed %llu, in %s %llu", p->given, (unsigned long long)json_whole(p->json, p->text, "seed", UINT64_MAX),
            base->given, (unsigned long long)json_whole(base->json, base->text, "seed", UINT64_MAX));
    }
    if (p->identity != base->identity) {
        refuse_case(p, base);
    }
}

static int by_first(const void *a, const void *b)
{
    const part *const p = a, *const q = b;

    return (p->first > q->first) - (p->first < q->first);
}

void parts_sort(part *parts, unsigned count)
{
    uint64_t total;

    qsort(parts, count, sizeof(*parts), by_first);
    total = parts[0].samples;
    for (unsigned i = 1; i < count; i++) {
        const part *const a = &parts[i - 1], *const b = &parts[i];
        const uint64_t end = (uint64_t)a->first + a->samples, last = (uint64_t)b->first + b->samples;

        if (b->first < end) {
            die(EXIT_USAGE, "%s and %s overlap: both hold %u..%llu", a->given, b->given, b->first, (unsigned long long)(end < last ? end : last) - 1);
        }
        if (b->first > end) {
            die(EXIT_USAGE, "a gap between %s and %s: %llu..%u are missing", a->given, b->given, (unsigned long long)end, b->first - 1);
        }
        total += b->samples;
    }
    if (total > UINT32_MAX) {
        die(EXIT_USAGE, "merge: %llu realisations; a report counts up to 4294967295", (unsigned long long)total);
    }
}

void part_case(const part *p, options *opts)
{
    kelly_case *const run = &opts->run;
    const char *const window = json_find(p->text, "case.window_s"), *const from = json_first(window), *const to = from ? json_next(from) : 0;
    static const char *const laws[KELLY_PARAMETERS] = { "case.cov.fc", "case.cov.mu", "case.cov.a1", "case.cov.a2", "case.cov.rpm" };
    char start[16];

    run->w0 = (real)(json_number(p->json, p->text, "case.rpm") * RPM);
    run->fc = (real)(json_number(p->json, p->text, "case.wob_kN") * 1000.0);
    run->f0 = (real)(json_number(p->json, p->text, "case.f0_kN") * 1000.0);
    run->mu = (real)json_number(p->json, p->text, "case.mu");
    run->a1 = (real)json_number(p->json, p->text, "case.alpha1");
    run->a2 = (real)json_number(p->json, p->text, "case.alpha2");
    run->limit = (real)json_number(p->json, p->text, "case.limit");
    run->torsional = (uint8_t)json_whole(p->json, p->text, "case.torsional", KELLY_MODES_MAX);
    json_text(p->json, p->text, "case.start", start, sizeof(start));
    run->rotating = strcmp(start, "rotating") == 0;
    run->step_ns = (uint32_t)nearbyint(json_number(p->json, p->text, "case.step_s") * 1e9);
    run->ticks = (uint32_t)nearbyint(json_number(p->json, p->text, "case.duration_s") * 1e9 / run->step_ns);
    run->window_first = from ? (uint32_t)nearbyint(strtod(from, 0) * 1e9 / run->step_ns) : 0;
    run->window_last = to ? (uint32_t)nearbyint(strtod(to, 0) * 1e9 / run->step_ns) : 0;
    for (unsigned k = 0; k < KELLY_PARAMETERS; k++) {
        run->cov[k] = (float)json_number(p->json, p->text, laws[k]);
    }
    opts->seed = json_whole(p->json, p->text, "seed", UINT64_MAX);
}
