/* rare_answer.c - what a run came to. See rare.h. */
#include "detmath.h"
#include "rare.h"

#define WIDER W(1.25)            /* seen: 92 % coverage without, see kelly_rare_read */

wide kelly_rare_product(const kelly_rare *rare)
{
    wide p = 1;

    for (uint32_t i = 0; i <= rare->level; i++) {
        p *= (wide)rare->levels[i].inside / (wide)rare->n;
    }
    return p;
}

/* The levels' variances add; the logarithm is taken as normal. Au and Beck's spread covered 92 % of what it should have
 * in 240 runs of five cases, as chains that share an ancestor agree more than it knows: hence WIDER. */
void kelly_rare_read(const kelly_rare *rare, kelly_rare_estimate *out)
{
    const kelly_rare_level *const level = &rare->levels[rare->level];
    wide variance = 0, width;

    for (uint32_t i = 0; i <= rare->level; i++) {
        variance += rare->levels[i].variance;
    }
    *out = (kelly_rare_estimate){ .probability = kelly_rare_product(rare), .cov = (wide)kelly_sqrt32((float)variance) };
    out->plain = rare->level == 0;
    if (out->plain) {
        const uint32_t counted = rare->n - level->refused;

        out->probability = (wide)level->failed / (wide)counted;
        out->lo = kelly_binomial_lo(level->failed, rare->n, W(0.025));
        out->hi = kelly_binomial_hi(level->failed + level->refused, rare->n, W(0.025));
        return;
    }
    width = kelly_exp(W(1.96) * WIDER * (wide)kelly_sqrt32((float)kelly_log(1 + variance)));
    out->cov *= WIDER;
    out->lo = out->probability / width;
    out->hi = out->probability * width < 1 ? out->probability * width : 1;
}

const char *kelly_rare_reason(kelly_rare_state state)
{
    static const char *const reasons[KELLY_RARE_OUTCOMES] = {
        "not over yet", "done", "no failure down to P of 1e-9", "P is below 1e-9",
        "under 50 different failures: give more samples a level",
        "under a tenth of the moves were accepted: give more samples a level",
        "more than 12 levels", "the failures descend from few finds: give montecarlo, or more samples a level",
        "failures lie in more than one place: give montecarlo",
        "the limit is below 1.5 times the ss that the string has anyway: give montecarlo",
        "refused realisations may be failures",
    };

    return (unsigned)state < KELLY_RARE_OUTCOMES ? reasons[state] : "no such state";
}
