/* rare_search.h - a run of kelly rare, and its report. */
#ifndef KELLY_RARE_SEARCH_H
#define KELLY_RARE_SEARCH_H

#include "journal.h"
#include "outcome.h"

/* One run. */
typedef struct {
    const options *opts;
    const kelly_engine *engine;
    uint32_t samples;            /* a level */
    kelly_rare rare, look;
    kelly_rare *at_work;         /* which of the two is evaluated */
    kelly_rare_seen seen;        /* by the look that saw most */
    unsigned seen_at;            /* mode */
    kelly_rare_estimate answer;
    outcome out;                 /* all realisations, their index the order of proposal */
    kelly_draw *draws;
    journal log;
    double seconds;
} search;

/* Why a run that is over has no answer, and where realisations were refused what would help. */
#define REASON_TEXT (ADVICE_TEXT + 80)
const char *rare_reason(const search *s, char text[REASON_TEXT]);

/* The JSON of a run that is over, and its summary. `list` is scratch for `samples` numbers. */
void rare_write_json(FILE *to, const search *s, double *list);
void rare_print(const search *s, double *list);

#endif
