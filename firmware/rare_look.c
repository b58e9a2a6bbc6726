/* rare_look.c - a second look for failures, over the linear string, where the guide of a search does not lead. See rare.h. */
#include "detmath.h"
#include "rare.h"

#define NEARLY R(0.4)            /* of the limit: from there on other modes and the rock may do the rest */
#define SURE W(2.33)             /* standard deviations: 1 % on one side */
#define APART 1.5f               /* limit over the ss that the string has anyway */
#define MATTERS W(0.2)           /* of the answer, that may be missed */

/* Probability of the event that the samples of the present level are of. */
static wide reached(const kelly_rare *look)
{
    wide p = 1;

    /*@ loop invariant i <= look->level;
        loop assigns i, p; */
    for (uint32_t i = 0; i < look->level; i++) {
        p *= (wide)look->levels[i].inside / (wide)look->n;
    }
    return p;
}

static float enough_of(const kelly_rare_hint *hint)
{
    return (float)(NEARLY * hint->run->limit);
}

void kelly_rare_look(kelly_rare *look, const kelly_rare_hint *hint, unsigned mode, wide least, uint32_t most)
{
    const float enough = enough_of(hint);
    uint32_t found = 0, kept = 0, every;

    /*@ loop invariant look->n == \at(look->n, Pre) && look->chains == \at(look->chains, Pre) && look->level < KELLY_RARE_LEVELS;
        loop invariant look->leads != 0 ==> \valid_read(look->hint);
        loop invariant look->samples == \at(look->samples, Pre) && look->keys == \at(look->keys, Pre);
        loop invariant look->count > 0 ==> look->first + look->count <= look->n;
        loop invariant look->count > 0 && look->level > 0 ==> look->first >= look->chains && look->quarter < 4 && 1 <= look->at < KELLY_RARE_STATES;
        loop invariant look->count > 0 ==> look->straight_accepted <= look->straight <= (look->level > 0 ? 100000 * look->at : 0) && 0.01 <= look->step <= 1;
        loop invariant look->count > 0 && look->level > 0 ==> look->count == look->chains / 4;
        loop assigns *look, *(\at(look->samples, Pre) + (0 .. \at(look->n, Pre) - 1)), *(\at(look->keys, Pre) + (0 .. \at(look->n, Pre) - 1)); */
    while (kelly_rare_count(look) > 0 && reached(look) >= least) {
        /*@ loop invariant \at(look->first, LoopEntry) <= i <= \at(look->first, LoopEntry) + \at(look->count, LoopEntry);
            loop assigns i, look->samples[0 .. \at(look->n, Pre) - 1]; */
        for (uint32_t i = look->first; i < look->first + look->count; i++) {
            const float ss = kelly_rare_resonance(hint, look->samples[i].x, mode);

            look->samples[i].guide = ss > enough ? KELLY_RARE_FAILED : ss;
        }
        kelly_rare_accept(look);
    }
    look->count = 0;
    if (look->state != KELLY_RARE_DONE) {
        return;
    }
    every = look->levels[look->level].failed / most;
    /*@ loop invariant front: found <= i && kept <= i <= \at(look->n, Pre) && kept <= most;
        loop assigns i, found, kept, look->samples[0 .. \at(look->n, Pre) - 1]; */
    for (uint32_t i = 0; i < look->n && kept < most; i++) {                /* every so many of them, to the front */
        kelly_rare_sample sample;

        sample = look->samples[i];
        if (kelly_rare_failed(&sample) && ++found % (every > 0 ? every : 1) == 0) {
            look->samples[kept++] = sample;
        }
    }
    look->first = 0;
    look->count = kept;
}

void kelly_rare_see(const kelly_rare *look, kelly_rare_seen *seen)
{
    *seen = (kelly_rare_seen){ .probability = 0 };
    seen->tried = look->count;
    seen->failed = 0;                                      /* WP cannot look into the literal */
    /*@ loop invariant seen->failed <= i <= look->count;
        loop assigns i, seen->failed; */
    for (uint32_t i = 0; i < look->count; i++) {
        seen->failed += kelly_rare_failed(&look->samples[i]) ? 1u : 0u;
    }
    if (seen->failed > 0) {
        const wide share = (wide)seen->failed / (wide)seen->tried;
        kelly_rare_estimate of;

        //@ assert share: 0 < share <= 1;

        kelly_rare_read(look, &of);
        seen->probability = of.probability * share;
        seen->variance = of.cov * of.cov + (1 - share) / (wide)seen->failed;
    }
}

/* Share of the failures of a search that such a look sees, and what it is at most by the number of finds that they descend from. */
static wide share_seen(const kelly_rare *rare, const kelly_rare_hint *hint, unsigned mode, wide *most)
{
    const float enough = enough_of(hint);
    uint32_t failed = 0, seen = 0;
    wide share;

    /*@ loop invariant seen <= failed <= i <= rare->n && ((\exists integer j; 0 <= j < i && rare->samples[j].guide >= KELLY_RARE_FAILED) ==> failed > 0);
        loop assigns i, failed, seen; */
    for (uint32_t i = 0; i < rare->n; i++) {
        if (kelly_rare_failed(&rare->samples[i])) {
            failed++;
            seen += kelly_rare_resonance(hint, rare->samples[i].x, mode) > enough ? 1u : 0u;
        }
    }
    share = (wide)seen / (wide)failed;
    //@ assert share: 0 <= share <= 1;
    *most = share + SURE * (wide)kelly_sqrt32((float)(share * (1 - share) / (wide)rare->finds)) + W(3.0) / (wide)rare->finds;
    return share;
}

void kelly_rare_doubt(kelly_rare *rare, const kelly_rare_hint *hint)
{
    if (rare->state == KELLY_RARE_DONE && rare->level > 0 && (float)hint->run->limit < APART * kelly_rare_own(hint)) {
        rare->state = KELLY_RARE_NEAR;
    }
}

void kelly_rare_compare(kelly_rare *rare, const kelly_rare_hint *hint, unsigned mode, const kelly_rare_seen *seen)
{
    kelly_rare_estimate answer;
    wide share, most, least;

    if (rare->state != KELLY_RARE_DONE || rare->level == 0 || seen->failed == 0) {
        return;
    }
    kelly_rare_read(rare, &answer);
    share = share_seen(rare, hint, mode, &most);
    least = seen->probability * kelly_exp(-SURE * (wide)kelly_sqrt32((float)kelly_log(1 + seen->variance + answer.cov * answer.cov)));
    if (least > answer.probability * most && seen->probability > answer.probability * (share + MATTERS)) {
        rare->state = KELLY_RARE_ELSEWHERE;
    }
}
