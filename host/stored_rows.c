/* stored_rows.c - the CSV of a run, see stored.h. Nothing is guessed: a line that is not as montecarlo writes it ends the reading. */
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "../firmware/link/crc32c.h"
#include "stored.h"

#define HEADER OUTCOME_HEADER
#define FIELDS 13
#define NEAR 1e-6                /* of a draw, relative: nine digits of it, and of the means of its law, are on file */

void stored_check_csv(const stored_run *run, const char *csv, uint32_t crc)
{
    if (run->has_csv && crc != run->csv_crc) {
        die(EXIT_USAGE, "%s: not the file that %s is of (CRC-32C %08x, there %08x): changed, cut short or of another run; run it again", csv,
            run->path, crc, run->csv_crc);
    }
}

static _Noreturn void bad_line(const stored_rows *rows, const char *what, const char *right)
{
    die(EXIT_USAGE, "%s, line %llu: %s; %s", rows->path, (unsigned long long)rows->number, what, right);
}

/* The next line without its end, or 0 after the last. A file that was cut off ends without one. */
static char *next_line(stored_rows *rows)
{
    const ssize_t n = getline(&rows->line, &rows->room, rows->stream);

    if (n < 0) {
        if (ferror(rows->stream)) {
            die(EXIT_FAILED, "%s: cannot be read: %s", rows->path, strerror(errno));
        }
        return 0;
    }
    rows->number++;
    rows->crc = kelly_crc32c(rows->crc, (const uint8_t *)rows->line, (size_t)n);
    if (rows->line[n - 1] != '\n' || strlen(rows->line) != (size_t)n) {
        bad_line(rows, "not a whole line", "give a CSV as montecarlo wrote it");
    }
    rows->line[n - 1] = '\0';
    return rows->line;
}

void stored_open_rows(stored_rows *rows, const char *path)
{
    const char *line;

    *rows = (stored_rows){ .stream = fopen(path, "r"), .path = path };
    if (!rows->stream) {
        die(EXIT_FAILED, "%s: cannot be read: %s", path, strerror(errno));
    }
    line = next_line(rows);
    if (!line || strcmp(line, HEADER) != 0) {
        rows->number = 1;
        bad_line(rows, "not the header of montecarlo's CSV", "give " HEADER);
    }
}

/* Nothing but a finite decimal number in lo..hi. */
static double number_of(const stored_rows *rows, const char *text, double lo, double hi)
{
    char *end, what[96];
    const double x = strtod(text, &end);

    if (text[0] == '\0' || *end != '\0' || strspn(text, "+-.0123456789eE") != strlen(text) || !(x >= lo && x <= hi)) {
        snprintf(what, sizeof(what), "'%.40s' is no number in %g..%g", text, lo, hi);
        for (char *c = what; *c; c++) {   /* one line, whatever the file holds */
            if (*c < ' ' || *c > '~') {
                *c = '?';
            }
        }
        bad_line(rows, what, "give a CSV as montecarlo wrote it");
    }
    return x;
}

static uint32_t whole_of(const stored_rows *rows, const char *text, uint32_t hi)
{
    const double x = number_of(rows, text, 0, hi);

    if (strspn(text, "0123456789") != strlen(text)) {
        bad_line(rows, "an index or a flag is no whole number", "give a CSV as montecarlo wrote it");
    }
    return (uint32_t)x;
}

static uint8_t status_of(const stored_rows *rows, const char *text)
{
    for (unsigned k = 0; k < KELLY_STATUSES; k++) {
        if (strcmp(text, status_names[k]) == 0) {
            return (uint8_t)k;
        }
    }
    bad_line(rows, "no such status", "there are ok, step, range, nonfinite and corrupt");
}

static void split(const stored_rows *rows, char *line, char *field[FIELDS])
{
    unsigned n = 0;
    char *rest = line;

    while (rest) {
        char *const part = strsep(&rest, ",");

        if (n < FIELDS) {
            field[n] = part;
        }
        n++;
    }
    if (n != FIELDS) {
        bad_line(rows, "not 13 fields", "give " HEADER);
    }
}

int stored_next(stored_rows *rows, stored_row *row)
{
    static const double unit[KELLY_PARAMETERS] = { 1000.0, 1.0, 1.0, 1.0, RPM };
    char *const line = next_line(rows), *field[FIELDS];

    if (!line) {
        (void)fclose(rows->stream);
        free(rows->line);
        return 0;
    }
    split(rows, line, field);
    *row = (stored_row){ .index = whole_of(rows, field[0], UINT32_MAX), .status = status_of(rows, field[11]),
                         .stuck = (uint8_t)whole_of(rows, field[10], 1), .liftoff = (uint8_t)whole_of(rows, field[12], 1) };
    for (unsigned k = 0; k < KELLY_PARAMETERS; k++) {
        row->y[k] = number_of(rows, field[1 + k], 1e-30, 1e30) * unit[k];
    }
    for (unsigned k = 6; k < 10; k++) {
        if (row->status == KELLY_OK) {
            row->ss = number_of(rows, field[k], k == 9 ? 0 : -1e30, 1e30);
        } else if (field[k][0] != '\0' || row->stuck) {
            bad_line(rows, "a refused realisation with a result", "give a CSV as montecarlo wrote it");
        }
    }
    return 1;
}

void stored_check(const stored_rows *rows, const stored_run *run, uint32_t place, const stored_row *row)
{
    kelly_draw d;
    char what[160];

    kelly_draw_sample(&run->run, run->seed, row->index, &d);
    const double drawn[KELLY_PARAMETERS] = { (double)d.fc, (double)d.mu, (double)d.a1, (double)d.a2, (double)d.w0 };
    if (row->index != run->first + place || place >= run->samples) {
        snprintf(what, sizeof(what), "index %u", row->index);
        bad_line(rows, what, "the run of the JSON has another one here, or none");
    }
    for (unsigned k = 0; k < KELLY_PARAMETERS; k++) {
        if (!(fabs(row->y[k] - drawn[k]) <= NEAR * drawn[k])) {
            snprintf(what, sizeof(what), "parameter %u is not what the laws and seed of %.80s give", k + 1, run->path);
            bad_line(rows, what, "give the JSON that the same run wrote with --case-json");
        }
    }
    if (row->status == KELLY_OK && row->stuck != ((float)row->ss > (float)run->run.limit)) {
        bad_line(rows, "stuck and ss do not agree with the limit of the JSON", "give the JSON that the same run wrote with --case-json");
    }
}
