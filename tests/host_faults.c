/* host_faults.c - faults inside: bad numbers in every input and every state, and single flipped bits in state, coefficients and table.
 *
 * usage: faults [FLIPS]      of each kind, default 4000; built once with one lane and once for a vector unit
 *
 * A fault is put in between two steps of a block under way, or into a table before or while it is used. What became of it is told by
 * the clean run of the same block:
 *
 *   same       every bit of every result is that of the clean run
 *   near       each severity within NEAR of the clean one, and on the same side of the limit
 *   detected   a realisation has a status other than ok, at the latest when its block ends
 *   moved      none of these, but every realisation on its side of the limit: the count is right, a severity is not
 *   wrong      a silent wrong count
 *
 * Table and coefficients: nothing may be moved or wrong. State: a flipped bit in it is a small push to the string, or to an extreme that
 * has been seen, and which of them matter nobody can say without running it again; how many are moved or wrong is a figure, and with
 * engine_run's `twice` none may be.
 */
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "../host/host.h"
#include "check.h"

#define NEAR R(0.01)             /* of the severity: its limit is 0.8 */
#define TICKS 8000u
#define LANES_MAX 32u
#define SITES 4096u

enum { SAME, WITHIN, DETECTED, MOVED, WRONG, OUTCOMES };
static const char *const names[OUTCOMES] = { "same", "near", "detected", "moved", "wrong" };

/* One place where a fault may strike. */
typedef struct {
    void *at;
    unsigned bytes;
} site;

static kelly_work work;
static kelly_case run, base;
static kelly_result clean[LANES_MAX], results[LANES_MAX];
static site sites[SITES];
static unsigned site_count, lanes;
static uint32_t first;
static kelly_rng rng;

void check_put(char c)
{
    (void)putchar(c);
}

static uint32_t below(uint32_t n)
{
    return (uint32_t)((uint64_t)kelly_rng_next(&rng) * n >> 32);
}

/* ---- runs --------------------------------------------------------------------------------------------------------- */

/* A block of the case, struck by `strike` after `at` steps. */
static void run_struck(const kelly_table *table, uint32_t at, void (*strike)(void *), void *what)
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

static unsigned worst(const kelly_result *got)
{
    unsigned outcome = SAME;

    for (unsigned l = 0; l < lanes; l++) {
        const unsigned o = outcome_of(&clean[l], &got[l]);

        outcome = o > outcome ? o : outcome;
    }
    return outcome;
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

/* ---- places ------------------------------------------------------------------------------------------------------- */

static void add_site(void *at, size_t bytes)
{
    if (site_count == SITES) {
        exit(1);
    }
    sites[site_count++] = (site){ at, (unsigned)bytes };
}

static void add_vectors(vreal *from, unsigned count)
{
    for (unsigned i = 0; i < count; i++) {
        for (unsigned l = 0; l < KELLY_WIDTH; l++) {
            add_site((char *)&from[i] + l * sizeof(real), sizeof(real));
        }
    }
}

static unsigned span(size_t from, size_t to)
{
    return (unsigned)((to - from) / sizeof(vreal)) + 1;
}
#define SPAN(type, a, b) span(offsetof(type, a), offsetof(type, b))

static void stiff_places(int state)
{
    kelly_block *const b = &work.block;

    for (unsigned v = 0; v < b->vectors; v++) {
        if (state) {
            add_vectors(&b->lane[v].wave, SPAN(kelly_lane, wave, highest));
        } else {
            add_vectors(&b->lane[v].w0, SPAN(kelly_lane, w0, twice_g2));
        }
        for (unsigned i = 0; i < b->modes; i++) {
            kelly_mode *const m = &b->mode[v][i];
            kelly_slow_mode *const s = &b->slow[v][i];

            if (b->full) {
                add_vectors(state ? &m->xi : &m->w4, state ? 2 : SPAN(kelly_mode, w4, m3));
            } else {
                add_vectors(state ? &s->v : &s->t, state ? 2 : SPAN(kelly_slow_mode, t, w4));
            }
        }
    }
    if (state) {
        add_site(&b->tick, sizeof(b->tick));
        return;
    }
    add_site(&b->h, sizeof(real));
    add_site(&b->al, sizeof(real));
    add_site(&b->be, sizeof(real));
    for (unsigned l = 0; l < lanes; l++) {
        add_site(&b->phase_step[l], sizeof(b->phase_step[l]));
    }
}

static void soft_places(int state)
{
    kelly_driven *const d = &work.driven;

    for (unsigned v = 0; v < d->vectors; v++) {
        kelly_driven_lane *const on = &d->lane[v];

        if (state) {
            add_vectors(&on->eta, SPAN(kelly_driven_lane, eta, cosine));
            add_vectors(&on->speed, SPAN(kelly_driven_lane, speed, highest));
            add_vectors(on->y.at, 4);
            add_vectors(on->p.at, 4);
        } else {
            add_vectors(&on->w_ref, SPAN(kelly_driven_lane, w_ref, counted));
            add_vectors(on->y.of_t, 6);
            add_vectors(on->p.of_t, 6);
        }
        for (unsigned i = 0; i < d->modes; i++) {
            kelly_driven_mode *const m = &d->mode[v][i];

            add_vectors(state ? &m->v : &m->w, state ? 2 : SPAN(kelly_driven_mode, w, d11));
        }
    }
    for (unsigned l = 0; l < lanes; l++) {
        add_site(state ? &d->phase[l] : &d->phase_step[l], sizeof(uint64_t));
    }
    add_site(state ? (void *)&d->tick : (void *)&d->step_ns, 4);
}

/* What else a block under way relies on: the draws and the case; or its own books. */
static void other_places(int state)
{
    for (unsigned l = 0; l < lanes; l++) {
        for (unsigned k = 0; k < KELLY_PARAMETERS && !state; k++) {
            add_site((char *)&results[l].draw + k * sizeof(real), sizeof(real));
        }
        if (state) {
            add_site(&results[l].mean, sizeof(real));
        } else {
            add_site(&results[l].status, 1);
        }
    }
    if (state) {
        add_site(&work.tick, sizeof(work.tick));
        add_site(&work.seal, sizeof(work.seal));
        return;
    }
    for (unsigned k = 0; k < 6; k++) {
        add_site((char *)&run.fc + k * sizeof(real), sizeof(real));
    }
    for (unsigned k = 0; k < KELLY_PARAMETERS; k++) {
        add_site(&run.cov[k], sizeof(float));
    }
    add_site(&run.limit, sizeof(real));
    add_site(&run.step_ns, 4);
    add_site(&run.ticks, 4);
}

static void places(int soft, int state)
{
    site_count = 0;
    if (soft) {
        soft_places(state);
    } else {
        stiff_places(state);
    }
    other_places(state);
}

/* ---- flipped bits in a block under way ---------------------------------------------------------------------------- */

static void flip(const site *s, unsigned bit)
{
    ((uint8_t *)s->at)[bit / 8] ^= (uint8_t)(1u << (bit % 8));
}

static void flip_any(void *of)
{
    const site *const s = &sites[below(site_count)];

    (void)of;
    flip(s, below(8 * s->bytes));
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

typedef struct {
    uint32_t alone[OUTCOMES], twice[OUTCOMES], flips;
} tally;

static void add_outcome(tally *t)
{
    t->flips++;
    t->alone[worst(results)]++;
    t->twice[outcome_twice()]++;
}

static void flips_in_block(tally *t, int soft, int state, uint32_t flips)
{
    for (uint32_t i = 0; i < flips; i++) {
        run = base;
        places(soft, state);
        run_struck(&kelly_string, below(TICKS - 1) + 1, flip_any, 0);
        add_outcome(t);
    }
}

/* ---- words that say how far a loop goes: a flip may lead out of the memory, where the processor stops the program ------ */

static void flip_this(void *of)
{
    const uint32_t *const what = of;

    flip(&sites[what[0]], what[1]);
}

/* -> an outcome; DETECTED where a child was stopped by a signal. */
static unsigned in_child(uint32_t what[2])
{
    int status = 0;
    const pid_t child = fork();

    if (child == 0) {
        (void)alarm(20);
        run_struck(&kelly_string, TICKS / 3, flip_this, what);
        _exit((int)worst(results));
    }
    if (child < 0 || waitpid(child, &status, 0) != child) {
        exit(1);
    }
    return WIFEXITED(status) ? (unsigned)WEXITSTATUS(status) : DETECTED;
}

static void flips_in_counts(tally *t, int soft)
{
    run = base;
    site_count = 0;
    add_site(soft ? &work.driven.modes : &work.block.modes, 4);
    add_site(soft ? &work.driven.vectors : &work.block.vectors, 4);
    if (!soft) {
        add_site(&work.block.full, 4);
    }
    add_site(&run.window_first, 4);
    add_site(&run.torsional, 1);
    for (uint32_t s = 0; s < site_count; s++) {
        for (uint32_t bit = 0; bit < 8 * sites[s].bytes; bit++) {
            t->flips++;
            t->alone[in_child((uint32_t[2]){ s, bit })]++;
        }
    }
}

/* ---- the table ---------------------------------------------------------------------------------------------------- */

#define ARRAYS 7u
#define ARRAY_MAX (KELLY_MODES_MAX * (KELLY_DEGREE_MAX + 1u))
static kelly_table copy;
static real arrays[ARRAYS][ARRAY_MAX];

static void copy_table(void)
{
    const real **const at[ARRAYS] = { &copy.w2, &copy.b, &copy.d, &copy.axial_w2, &copy.axial_b, &copy.free_w2, &copy.axial_free_w2 };
    const unsigned n = kelly_string.degree + 1u, t = kelly_string.torsional, a = kelly_string.axial;
    const unsigned length[ARRAYS] = { t * n, t * n, t * n, a * n, a * n, t, a };

    copy = kelly_string;
    site_count = 0;
    add_site(&copy.schema, offsetof(kelly_table, id) - offsetof(kelly_table, schema));
    add_site(&copy.torsional, 4 * sizeof(uint16_t));
    add_site(&copy.fc_min, 8 * sizeof(real));
    add_site(&copy.nominal, offsetof(kelly_case, cov) + sizeof(copy.nominal.cov));
    add_site(&copy.nominal.limit, sizeof(real) + 4 * sizeof(uint32_t) + 3);
    add_site(&copy.nominal.drive, sizeof(kelly_drive));
    for (unsigned k = 0; k < ARRAYS; k++) {
        memcpy(arrays[k], *at[k], length[k] * sizeof(real));
        *at[k] = arrays[k];
        add_site(arrays[k], length[k] * sizeof(real));
    }
}

/* A bit of the whole table, each as likely. */
static void flip_table(void *of)
{
    uint32_t bits = 0, bit;
    const site *s = sites;

    (void)of;
    for (unsigned k = 0; k < site_count; k++) {
        bits += 8 * sites[k].bytes;
    }
    for (bit = below(bits); bit >= 8 * s->bytes; s++) {
        bit -= 8 * s->bytes;
    }
    flip(s, bit);
}

/* Before the start, where kelly_table_error must see it, and so must a block; or while a block is under way. */
static void flips_in_table(tally *t, uint32_t flips)
{
    for (uint32_t i = 0; i < flips; i++) {
        const int before = i % 2 == 0;

        run = base;
        copy_table();
        if (before) {
            flip_table(0);
            CHECK(kelly_table_error(&copy) != 0);
        }
        run_struck(&copy, below(TICKS - 1) + 1, before ? 0 : flip_table, 0);
        CHECK(results[0].status == KELLY_CORRUPT && results[lanes - 1].status == KELLY_CORRUPT);
        t->flips++;
        t->alone[worst(results)]++;
    }
}

/* ---- bad numbers -------------------------------------------------------------------------------------------------- */

static real quotient(real a, volatile real b)
{
    return a / b;
}

#define BAD 9u
static void bad_numbers(real bad[BAD], real of)
{
    const real list[BAD] = { quotient(0, 0), quotient(R(1.0), 0), quotient(R(-1.0), 0), R(1e38), R(-1e38),
                             sizeof(real) > 4 ? (real)4.9e-324 : (real)1e-45, 0, -of, R(-1.0) };

    memcpy(bad, list, sizeof(list));
}

/* Every state of a block under way set to every bad number, at two instants. */
static void put_number(void *of)
{
    const uint32_t *const what = of;
    real bad[BAD], old;

    memcpy(&old, sites[what[0]].at, sizeof(old));
    bad_numbers(bad, old);
    memcpy(sites[what[0]].at, &bad[what[1]], sizeof(real));
}

static void numbers_in_state(tally *far, tally *small, int soft, unsigned every)
{
    static const uint32_t when[] = { 1000, TICKS - 3000 };

    for (uint32_t s = 0; s < site_count; s += every) {
        for (uint32_t k = 0; sites[s].bytes == sizeof(real) && k < 2 * BAD; k++) {
            run = base;
            places(soft, 1);
            run_struck(&kelly_string, when[k / BAD], put_number, (uint32_t[2]){ s, k % BAD });
            add_outcome(k % BAD < 5 ? far : small);
        }
    }
}

static int finite(real x)
{
    return x - x == 0;
}

/* Whether a result is one that may be counted, or none at all. */
static int sound(const kelly_result *r)
{
    return r->status != KELLY_OK ? !r->stuck && r->ss == 0 :
           finite(r->lowest) && finite(r->highest) && finite(r->mean) && r->lowest <= r->highest && r->ss >= 0 && finite(r->ss);
}

/* Every parameter of a draw: refused, or a positive finite number. */
static void numbers_in_draws(int soft)
{
    real bad[BAD];

    for (unsigned k = 0; k < KELLY_PARAMETERS; k++) {
        bad_numbers(bad, ((const real *)&clean[0].draw)[k]);
        for (unsigned b = 0; b < BAD; b++) {
            kelly_draw draw = clean[0].draw;
            int holds;

            ((real *)&draw)[k] = bad[b];
            run = base;
            kelly_run_draws(&kelly_string, &run, &draw, 1, results, &work);
            holds = sound(&results[0]) && (results[0].status != KELLY_OK || (bad[b] > 0 && finite(bad[b])));
            CHECK(holds);
            if (!holds) {
                printf("    parameter %u, bad number %u, %s: status %u, ss %g\n", k, b, soft ? "soft" : "stiff", results[0].status, (double)results[0].ss);
            }
        }
    }
}

/* Every real of a case: refused with a reason, or in its documented range, and then its realisations are sound. */
static void numbers_in_case(void)
{
    const struct {
        size_t at;
        real lo, hi;             /* lo itself only where it is `closed` */
        int closed;
    } field[] = {
        { offsetof(kelly_case, fc), 0, R(1e30), 0 }, { offsetof(kelly_case, mu), 0, R(1e30), 0 }, { offsetof(kelly_case, a1), 0, R(1e30), 0 },
        { offsetof(kelly_case, a2), 0, R(1e30), 0 }, { offsetof(kelly_case, w0), 0, R(1e30), 0 }, { offsetof(kelly_case, f0), 0, R(1e30), 1 },
        { offsetof(kelly_case, limit), 0, R(10.0), 1 }, { offsetof(kelly_case, drive.inertia), R(1.0), R(1e12), 1 },
        { offsetof(kelly_case, drive.impedance), 0, R(1e12), 0 }, { offsetof(kelly_case, drive.hz), 0, R(1e3), 0 },
    };
    real bad[BAD], old;

    for (unsigned f = 0; f < sizeof(field) / sizeof(field[0]); f++) {
        memcpy(&old, (char *)&base + field[f].at, sizeof(old));
        bad_numbers(bad, old);
        for (unsigned b = 0; b < BAD; b++) {
            const int in_range = (bad[b] > field[f].lo || (field[f].closed && bad[b] == field[f].lo)) && bad[b] <= field[f].hi;

            run = base;
            memcpy((char *)&run + field[f].at, &bad[b], sizeof(real));
            if (kelly_case_error(&kelly_string, &run) != 0) {
                CHECK(!in_range || field[f].at == offsetof(kelly_case, drive.hz) || field[f].at == offsetof(kelly_case, drive.impedance));
                continue;
            }
            CHECK(in_range || run.drive.inertia == 0);
            kelly_run(&kelly_string, &run, 7, first, lanes, results, &work);
            for (unsigned l = 0; l < lanes; l++) {
                CHECK(sound(&results[l]));
            }
        }
    }
    for (unsigned k = 0; k < KELLY_PARAMETERS; k++) {
        static const float covs[] = { -1e-45f, -0.1f, 0.500001f, 1e38f, -1e38f };

        for (unsigned b = 0; b < sizeof(covs) / sizeof(covs[0]); b++) {
            run = base;
            run.cov[k] = covs[b];
            CHECK(kelly_case_error(&kelly_string, &run) != 0);
        }
        run.cov[k] = (float)quotient(0, 0);
        CHECK(kelly_case_error(&kelly_string, &run) != 0);
    }
}

/* Commands to a string that runs: none of these is allowed. */
static void numbers_in_commands(void)
{
    static kelly_plant plant;
    real bad[BAD];

    run = base;
    EQUAL(kelly_plant_start_commanded(&plant, &kelly_string, &run, &clean[0].draw, clean[0].draw.w0), KELLY_OK);
    bad_numbers(bad, R(1.0));
    for (unsigned b = 0; b < BAD; b++) {
        CHECK(!kelly_plant_allows(&plant, clean[0].draw.w0, bad[b]) || (bad[b] > 0 && bad[b] < R(1e-30)));
        CHECK(!kelly_plant_allows(&plant, bad[b], clean[0].draw.fc) || KELLY_ABS(bad[b]) <= R(1.0));
    }
}

/* ---- */

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
    tally table = { 0 }, coefficients = { 0 }, counts = { 0 }, state = { 0 }, far = { 0 }, small = { 0 };

    lanes = KELLY_WIDTH == 1 ? 1 : 2 * KELLY_WIDTH;
    kelly_rng_key(&rng, 20261127, 0, 0);
    for (unsigned c = 0; c < sizeof(cases) / sizeof(cases[0]); c++) {
        begin_case(cases[c].mu, cases[c].soft, cases[c].modes, cases[c].first);
        flips_in_table(&table, flips);
        flips_in_block(&coefficients, cases[c].soft, 0, flips);
        flips_in_counts(&counts, cases[c].soft);
        flips_in_block(&state, cases[c].soft, 1, flips);
        numbers_in_state(&far, &small, cases[c].soft, KELLY_WIDTH == 1 ? 1 : 11);
        numbers_in_draws(cases[c].soft);
    }
    numbers_in_case();
    numbers_in_commands();
    say("the table, bits", &table);
    say("coefficients, draws and case, bits", &coefficients);
    say("counts of loops, bits", &counts);
    say("the state, bits", &state);
    say("the state, set to NaN, Inf, 1e38", &far);
    say("the state, set to a denormal, 0, the other sign", &small);
    none_silent(table.alone);
    EQUAL(table.alone[SAME] + table.alone[WITHIN], 0);
    none_silent(coefficients.alone);
    none_silent(counts.alone);
    none_silent(state.twice);
    none_silent(far.twice);
    none_silent(small.twice);
    printf("%u passed, %u failed\n", check_passed, check_failed);
    return check_failed != 0;
}
