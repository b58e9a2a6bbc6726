/* until.c - montecarlo that stops by itself: an interval that may be looked at after every realisation (firmware/sequence.h).
 *
 * The decision is taken in the order of the indices, and results beyond the index at which it falls are dropped: n, digest
 * and files do not depend on threads or lanes, and are those of --samples n.
 */
#include <string.h>

#include "host.h"

#define ALPHA 0.05f

const option_help until_options[] = {
    { "--until-width", "W", "stop once the 95 % interval is not wider than W, 0.0001..1; the interval is one that holds at every n, wider "
      "than that of a fixed n; --samples is the most (default then 1000000)" },
    { "--until-decided", "P", "stop once the 95 % interval lies above P or below P, 0 < P < 1; the same interval; --samples is the most" },
    { 0 },
};

int until_option(void *request, const char *name, const char *value)
{
    until_request *const ask = request;

    if (strcmp(name, "--until-width") == 0) {
        ask->width = option_number(name, value, 1e-4, 1.0, "the width of an interval of a probability, 0.0001..1, e.g. 0.02");
        ask->rule.width = (float)ask->width;
    } else if (strcmp(name, "--until-decided") == 0) {
        ask->level = option_number(name, value, 1e-6, 1.0 - 1e-6, "a probability between 0 and 1, e.g. 0.5");
        ask->rule.level = (float)ask->level;
    } else {
        return 0;
    }
    ask->rule.alpha = ALPHA;
    return 1;
}

int until_look(until_request *ask, const kelly_tally *tally)
{
    if (ask->rule.alpha > 0) {
        ask->enough = (int)kelly_sequence_look(&ask->rule, tally, &ask->lo, &ask->hi);
    }
    return ask->enough;
}

static const char *why(const until_request *ask)
{
    return ask->enough == KELLY_NARROW ? "width" : ask->enough == KELLY_DECIDED ? "decided" : "samples";
}

static void write_number(FILE *to, const char *name, double x)
{
    if (x > 0) {
        fprintf(to, ", \"%s\": %.9g", name, x);
    } else {
        fprintf(to, ", \"%s\": null", name);
    }
}

void until_write(FILE *to, const until_request *ask, uint32_t most)
{
    if (!(ask->rule.alpha > 0)) {
        return;
    }
    fprintf(to, "  \"sequence\": {\"method\": \"beta-binomial mixture, prior Beta(1/2, 1/2), holds at every n\", \"stopped\": \"%s\"", why(ask));
    write_number(to, "until_width", ask->width);
    write_number(to, "until_decided", ask->level);
    fprintf(to, ", \"samples_most\": %u, \"ci95\": [%.9g, %.9g]},\n", most, (double)ask->lo, (double)ask->hi);
}

void until_print(const until_request *ask, uint32_t n)
{
    if (ask->rule.alpha > 0) {
        printf("stopped after %u: %s; the interval holds at every n\n", n, ask->enough == KELLY_NARROW ? "it is narrow enough" :
               ask->enough == KELLY_DECIDED ? (double)ask->lo > ask->level ? "P is above the level" : "P is below the level" :
               "all samples are run and the aim is not reached");
    }
}
