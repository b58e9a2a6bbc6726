/* outcome.h - what comes out of an ensemble, and how it is written: the same whether one run made it or `kelly merge` put it together. */
#ifndef KELLY_OUTCOME_H
#define KELLY_OUTCOME_H

#include "host.h"

#define LISTED 100u              /* refused realisations that are named one by one */

extern const char outcome_csv_header[];
extern const char *const status_names[KELLY_STATUSES];

typedef struct {
    const options *opts;
    const char *engine;
    uint32_t identity;           /* run_identity */
    kelly_tally tally;
    uint32_t stuck_ssi;          /* counted realisations whose SSI exceeds the limit */
    FILE *csv;                   /* or 0 */
    uint32_t csv_crc;            /* CRC-32C of what was written there */
    uint32_t refused[LISTED];
    uint8_t why[LISTED];
    double seconds;
    convergence_table convergence;
    envelope_request envelope;
} outcome;

void outcome_json(FILE *to, const outcome *out);
void outcome_print(const outcome *out);

#endif
