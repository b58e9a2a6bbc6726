/* stored.h - a run of montecarlo as it lies in its two files: the CSV, a line a realisation, and the JSON, which names its laws. */
#ifndef KELLY_STORED_H
#define KELLY_STORED_H

#include "outcome.h"

/* What the JSON says of the run. */
typedef struct {
    char *path;
    kelly_case run;               /* means, spreads, limit; the rest of it only after stored_open_part */
    uint64_t seed;
    uint32_t first, samples, stuck, refused, csv_crc;
    int in_double, has_csv;       /* has_csv: csv_crc is there */
    char model[64];
} stored_run;

/* All that it says, for a run that is to be put together with others. */
typedef struct {
    stored_run of;
    kelly_tally tally;
    uint32_t stuck_ssi, identity;
    double seconds;
    char engine[32];
    char case_text[1024];         /* "name value" of every scalar of "case", a line each */
    uint32_t refused_index[LISTED];
    uint8_t refused_why[LISTED];
    uint32_t refused_listed;
} stored_part;

/* A line of the CSV. */
typedef struct {
    uint32_t index;
    double y[KELLY_PARAMETERS];   /* SI, in the order of the laws */
    double ss;
    uint8_t status, stuck, liftoff;
} stored_row;

/* Fields are not to be touched. */
typedef struct {
    FILE *stream;
    const char *path;
    char *line;
    size_t room;
    uint64_t number;              /* of the line that was read last */
    uint32_t crc;                 /* CRC-32C of all lines up to it */
} stored_rows;

/* Every scalar of a JSON text, with the keys that lead to it joined by dots (elements of arrays: none). Returns where the text is no
 * JSON (a character), or -1. `value` is the scalar as it stands, strings without their quotes. */
typedef void (*json_visit)(void *context, const char *path, const char *value);
long json_walk(const char *text, json_visit visit, void *context);

/* Dies with exit 2 where a file that the user named is not there. */
void stored_need(const char *path);

/* The JSON of a run; dies with exit 1 where it cannot be read, with exit 2 where it is not that of montecarlo, was changed (it ends with its
 * CRC) or the run stopped itself. */
void stored_open_run(stored_run *run, const char *path);

/* The same with all of it, dying where any is missing, its CRC too. */
void stored_open_part(stored_part *part, const char *path);

/* The CSV; dies like that, with the line. stored_next: 0 after the last line. */
void stored_open_rows(stored_rows *rows, const char *path);
int stored_next(stored_rows *rows, stored_row *row);

/* Dies where the run's JSON was written beside another CSV than this one of that CRC. */
void stored_check_csv(const stored_run *run, const char *csv, uint32_t crc);

/* Die unless the row is the one that the laws of this run give at its place: index, draw, and what sticks. */
void stored_check(const stored_rows *rows, const stored_run *run, uint32_t place, const stored_row *row);

#endif
