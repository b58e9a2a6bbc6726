/* parts.h - what `kelly merge` knows of a part: its report, and whether it belongs to the others. Everything that does not fit is named,
 * exit 2. */
#ifndef KELLY_PARTS_H
#define KELLY_PARTS_H

#include "outcome.h"

typedef struct {
    const char *given;           /* as on the command line */
    char *csv, *json;            /* files; csv may be 0 */
    char *text;                  /* of the report */
    uint32_t first, samples, digest, identity, csv_crc;
} part;

/* NAME.csv with NAME.json beside it, or NAME.json alone. */
void part_load(part *p, const char *given);

/* Dies unless both are of one run: string, precision, seed, case. */
void part_compare(const part *p, const part *base);

/* In the order of their indices; dies of gaps and overlaps. */
void parts_sort(part *parts, unsigned count);

/* The case as the report tells it: its numbers print again as they were printed. */
void part_case(const part *p, options *opts);

#endif
