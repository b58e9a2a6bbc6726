/* host_faults.c - faults inside: bad numbers in every input and every state, and single flipped bits in state, coefficients and table.
 *
 * usage: faults [FLIPS]      of each kind, default 4000; built with one lane, and as faults-UNIT for each vector unit
 *
 * A fault is put in between two steps of a block under way, or into a table before or while it is used. What became of it is told by
 * the clean run of the same block:
 *
 *   same       every bit of every result is that of the clean run
 *   near       each severity within NEAR of the clean one, and on the same side of the limit
 *   detected   a realisation has a status other than ok
 *   moved      none of these, but every realisation on its side of the limit: the count is right, a severity is not
 *   wrong      a silent wrong count
 *
 * Table and coefficients: nothing may be moved or wrong, no flip may end the program, and the block stands still within KELLY_LOOK steps.
 * So for the state where it is guarded (seal.h), and a few strike at any instruction of a step, too, where a word that is read no more may
 * change without harm. Built with -DKELLY_GUARD=0 a flipped bit of the state is a small push to the string, or to an extreme that has
 * been seen; how many are moved or wrong is a figure then, and with engine_run's `twice` none may be.
 *
 * Here: how a fault is put in and judged, and all of them in order. host_faults_state.c: state and inputs; host_faults_table.c: table,
 * coefficients and counts of loops; host_faults_instant.c: at any instruction.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host_faults.h"

#define NEAR R(0.01)             /* of the severity: its limit is 0.8 */
#define SITES 16384u

static const char *const names[OUTCOMES] = { "same", "near", "detected", "moved", "wrong" };

kelly_work work;
kelly_case run, base;
kelly_result clean[LANES_MAX], results[LANES_MAX];
unsigned lanes;
uint32_t first;
site sites[SITES];
unsigned site_count;
static kelly_rng rng;

void check_put(char c)
{
    (void)putchar(c);
}

uint32_t below(uint32_t n)
{
    return (uint32_t)((uint64_t)kelly_rng_next(&rng) * n >> 32);
}

/* ---- runs --------------------------------------------------------------------------------------------------------- */

void run_struck(const kelly_table *table, uint32_t at, void (*strike)(void *), void *what)
{
    kelly_run_begin(table, &run, 7, first, lanes, results, &work);
    (void)kelly_run_advance(table, &run, lanes, results, &work, at);
    if (strike) {
        strike(what);
    }
    while (kelly_run_advance(table, &run, lanes, results, &work, TICKS) > 0) {
    }
    kelly_run_finish(table, &run, lanes, results, &work);
}

/* The clean run of the case and of the realisations from `from` on, and whether each has a result. */
static void begin_case(real mu, int soft, unsigned modes, uint32_t from)
{
    base = kelly_string.nominal;
    base.mu = mu;
    base.torsional = (uint8_t)modes;
    base.ticks = base.window_last = TICKS;
    base.window_first = TICKS / 2;
    if (soft) {
        base.drive = (kelly_drive){ .inertia = R(2900.0), .impedance = R(289.0), .hz = R(0.2) };
    }
    run = base;
    first = from;
    run_struck(&kelly_string, TICKS / 3, 0, 0);
    memcpy(clean, results, sizeof(clean));
    for (unsigned l = 0; l < lanes; l++) {
        EQUAL(clean[l].status, KELLY_OK);
    }
}

/* ---- outcomes ----------------------------------------------------------------------------------------------------- */

static real distance(real a, real b)
{
    return a > b ? a - b : b - a;
}

static unsigned outcome_of(const kelly_result *want, const kelly_result *got)
{
    if (memcmp(want, got, offsetof(kelly_result, liftoff) + 1) == 0) {
        return SAME;
    }
    if (got->status != KELLY_OK) {
        return got->stuck ? WRONG : DETECTED;
    }
    if (want->status != KELLY_OK || want->stuck != got->stuck) {
        return WRONG;
    }
    return distance(want->ss, got->ss) <= NEAR ? WITHIN : MOVED;
}

unsigned worst(const kelly_result *got)
{
    unsigned outcome = SAME;

    for (unsigned l = 0; l < lanes; l++) {
        const unsigned o = outcome_of(&clean[l], &got[l]);

        outcome = o > outcome ? o : outcome;
    }
    return outcome;
}

/* An engine that was struck in the first of two runs. */
static kelly_result struck[LANES_MAX];
static unsigned calls;

static void run_of_two(const kelly_table *table, const kelly_case *of, uint64_t seed, uint32_t from, uint32_t count, kelly_result *to, void *with)
{
    (void)table, (void)of, (void)seed, (void)from, (void)with;
    memcpy(to, calls++ == 0 ? struck : clean, count * sizeof(*to));
}

/* What --twice makes of the results. */
static unsigned outcome_twice(void)
{
    const kelly_engine two = { .run = run_of_two };
    const options opts = { .twice = 1 };
    kelly_result settled[LANES_MAX];

    memcpy(struck, results, sizeof(struck));
    calls = 0;
    engine_run(&two, &opts, &base, first, lanes, settled, 0);
    EQUAL(calls, 2);
    return worst(settled);
}

void add_outcome(tally *t)
{
    t->flips++;
    t->alone[worst(results)]++;
    t->twice[outcome_twice()]++;
}

/* ---- places ------------------------------------------------------------------------------------------------------- */

void add_site(void *at, size_t bytes)
{
    if (site_count == SITES) {
        exit(1);
    }
    sites[site_count++] = (site){ at, (unsigned)bytes };
}

void add_vectors(vreal *from, unsigned count)
{
    for (unsigned i = 0; i < count; i++) {
        for (unsigned l = 0; l < KELLY_WIDTH; l++) {
            add_site((char *)&from[i] + l * sizeof(real), sizeof(real));
        }
    }
}

/* ---- flipped bits in a block under way ---------------------------------------------------------------------------- */

void flip(const site *s, unsigned bit)
{
    ((uint8_t *)s->at)[bit / 8] ^= (uint8_t)(1u << (bit % 8));
}

void flip_any(void *of)
{
    const site *const s = &sites[below(site_count)];

    (void)of;
    flip(s, below(8 * s->bytes));
}

/* A fourth of them just before a resync, which writes some numbers anew and must not forgive what they were. */
void flips_in_block(tally *t, void (*add_places)(int soft), int soft, uint32_t flips)
{
    for (uint32_t i = 0; i < flips; i++) {
        run = base;
        site_count = 0;
        add_places(soft);
        run_struck(&kelly_string, i % 4 > 0 ? below(TICKS - 1) + 1 : (below((TICKS - 1) / KELLY_RESYNC) + 1) * KELLY_RESYNC, flip_any, 0);
        add_outcome(t);
    }
}

/* ---- all of them -------------------------------------------------------------------------------------------------- */

static void say(const char *what, const tally *t)
{
    printf("figure: faults in %s, %s%s: %u, of them", what, KELLY_ISA_NAME, sizeof(real) > 4 ? " double" : "", t->flips);
    for (unsigned o = 0; o < OUTCOMES; o++) {
        printf(" %s %u", names[o], t->alone[o]);
    }
    if (t->twice[SAME] + t->twice[DETECTED] > 0) {
        printf("; run twice same %u, detected %u", t->twice[SAME], t->twice[DETECTED]);
    }
    printf("\n");
}

static uint32_t larger(uint32_t a, uint32_t b)
{
    return a > b ? a : b;
}

static void none_silent(const uint32_t outcomes[OUTCOMES])
{
    EQUAL(outcomes[MOVED], 0);
    EQUAL(outcomes[WRONG], 0);
}

int main(int argc, char **argv)
{
    /* mu, soft drive, modes, first index: free and stuck realisations of both rocks, form S and form M */
    static const struct {
        real mu;
        int soft;
        unsigned modes;
        uint32_t first;
    } cases[] = { { R(0.04), 0, 10, 0 }, { R(0.004), 0, 10, 40 }, { R(0.01), 0, 20, 3 }, { R(0.004), 1, 10, 40 } };
    const uint32_t flips = (argc > 1 ? (uint32_t)atoi(argv[1]) : 4000u) / 4;
    tally table = { 0 }, coefficients = { 0 }, counts = { 0 }, state = { 0 }, far = { 0 }, small = { 0 }, instant = { 0 }, within = { 0 };
    tally resync = { 0 }, loading = { 0 };
    const uint32_t each = flips < 200 ? 1 : flips < 1000 ? 2 : 10;
    uint32_t most = 0;

    kelly_rng_key(&rng, 20261127, 0, 0);
    for (unsigned c = 0; c < sizeof(cases) / sizeof(cases[0]); c++) {
        lanes = KELLY_WIDTH == 1 ? 1 : c % 2 == 0 ? 2 * KELLY_WIDTH : KELLY_LANES;      /* vectors side by side and in turns */
        begin_case(cases[c].mu, cases[c].soft, cases[c].modes, cases[c].first);
        flips_in_table(&table, flips);
        flips_in_coefficients(&coefficients, cases[c].soft, flips);
        flips_in_counts(&counts, cases[c].soft);
        most = larger(most, steps_until_told(cases[c].soft, flips / 10));
        flips_in_state(&state, cases[c].soft, flips);
        if (KELLY_GUARD) {
            flips_at_any_instant(&instant, state_places, cases[c].soft, flips / 32);
        }
        if (KELLY_GUARD && KELLY_WIDTH > 1) {
            flips_between_loads(cases[c].soft, flips);
        }
        numbers_in_state(&far, &small, cases[c].soft, KELLY_WIDTH == 1 ? 1 : 2 * KELLY_WIDTH + 3);     /* every lane in its turn */
        numbers_in_draws(cases[c].soft);
        for (lanes = KELLY_WIDTH; KELLY_GUARD && lanes <= KELLY_LANES; lanes += KELLY_VECTORS > 1 ? KELLY_LANES - KELLY_WIDTH : 1u) {
            flips_within_steps(&within, cases[c].soft, each);     /* one vector, and all of them in turns */
        }
        lanes = KELLY_WIDTH;
        if (KELLY_GUARD) {
            flips_within_resync(&resync, cases[c].soft, 20 + flips / 8);
            flips_within_load(&loading, cases[c].soft, 20 + flips / 8);
        }
    }
    lanes = KELLY_WIDTH;
    numbers_in_case();
    numbers_in_commands();
    for (int top = 0; top < 3 && KELLY_WIDTH == 1; top++) {               /* its library has plants of one lane */
        flips_in_plant(top);
    }
    say("the table, bits", &table);
    say("coefficients, draws and case, bits", &coefficients);
    say("counts of loops, bits", &counts);
    say("the state, bits", &state);
    if (KELLY_GUARD) {
        say("the state, bits, at any instruction of a step", &instant);
        say("each number of the state, a bit, at any instruction of a few steps", &within);
        say("what a new phase writes, a bit, at any instruction of that", &resync);
        say("the state, a bit, at any instruction of a load", &loading);
    }
    say("the state, set to NaN, Inf, 1e38", &far);
    say("the state, set to a denormal, 0, the other sign", &small);
    printf("figure: steps from a flipped bit to the end of its block, %s%s: at most %u of %u\n", KELLY_ISA_NAME, sizeof(real) > 4 ? " double" : "", most, KELLY_LOOK);
    CHECK(most > KELLY_LOOK / 2 && most <= KELLY_LOOK);
    none_silent(table.alone);
    EQUAL(table.alone[SAME] + table.alone[WITHIN], 0);
    none_silent(coefficients.alone);
    EQUAL(counts.alone[DETECTED], counts.flips);
    none_silent(KELLY_GUARD ? state.alone : state.twice);
    none_silent(instant.alone);
    none_silent(within.alone);
    CHECK(!KELLY_GUARD || within.alone[DETECTED] > within.flips / 4);
    none_silent(resync.alone);
    CHECK(!KELLY_GUARD || resync.alone[DETECTED] > resync.flips / 4);
    none_silent(loading.alone);
    CHECK(!KELLY_GUARD || loading.alone[DETECTED] > loading.flips / 8);
    none_silent(KELLY_GUARD ? far.alone : far.twice);
    none_silent(KELLY_GUARD ? small.alone : small.twice);
    EQUAL(KELLY_GUARD ? state.alone[DETECTED] : state.flips, state.flips);
    printf("%u passed, %u failed\n", check_passed, check_failed);
    return check_failed != 0;
}
