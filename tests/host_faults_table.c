/* host_faults_table.c - flipped bits in what a block only reads: the table, coefficients, draws and case, and words that end a loop. */
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "host_faults.h"

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
void flips_in_table(tally *t, uint32_t flips)
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

/* ---- coefficients ------------------------------------------------------------------------------------------------- */

static void stiff_places(void)
{
    kelly_block *const b = &work.block;

    for (unsigned v = 0; v < b->vectors; v++) {
        add_vectors(&b->lane[v].w0, SPAN(kelly_lane, w0, twice_g2));
        for (unsigned i = 0; i < b->modes; i++) {
            if (b->full) {
                add_vectors(&b->mode[v][i].w4, SPAN(kelly_mode, w4, m3));
            } else {
                add_vectors(&b->slow[v][i].t, SPAN(kelly_slow_mode, t, w4));
            }
        }
    }
    add_site(&b->h, sizeof(real));
    add_site(&b->al, sizeof(real));
    add_site(&b->be, sizeof(real));
    for (unsigned l = 0; l < lanes; l++) {
        add_site(&b->phase_step[l], sizeof(b->phase_step[l]));
    }
}

static void soft_places(void)
{
    kelly_driven *const d = &work.driven;

    for (unsigned v = 0; v < d->vectors; v++) {
        kelly_driven_lane *const on = &d->lane[v];

        add_vectors(&on->w_ref, SPAN(kelly_driven_lane, w_ref, counted));
        add_vectors(on->y.of_t, 6);
        add_vectors(on->p.of_t, 6);
        for (unsigned i = 0; i < d->modes; i++) {
            add_vectors(&d->mode[v][i].w, SPAN(kelly_driven_mode, w, d11));
        }
    }
    for (unsigned l = 0; l < lanes; l++) {
        add_site(&d->phase_step[l], sizeof(d->phase_step[l]));
    }
    add_site(&d->step_ns, sizeof(d->step_ns));
}

/* What else a block under way relies on. */
static void draws_and_case(void)
{
    for (unsigned l = 0; l < lanes; l++) {
        for (unsigned k = 0; k < KELLY_PARAMETERS; k++) {
            add_site((char *)&results[l].draw + k * sizeof(real), sizeof(real));
        }
        add_site(&results[l].status, 1);
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

static void add_places(int soft)
{
    if (soft) {
        soft_places();
    } else {
        stiff_places();
    }
    draws_and_case();
}

void flips_in_coefficients(tally *t, int soft, uint32_t flips)
{
    flips_in_block(t, add_places, soft, flips);
}

/* ---- words that say how far a loop goes: a flip may lead out of the memory, so each is tried in a child --------------- */

static void flip_this(void *of)
{
    const uint32_t *const what = of;

    flip(&sites[what[0]], what[1]);
}

unsigned outcome_of_child(int status)
{
    return WIFEXITED(status) && WEXITSTATUS(status) >= OF_OURS && WEXITSTATUS(status) < OF_OURS + OUTCOMES ? (unsigned)WEXITSTATUS(status) - OF_OURS : WRONG;
}

/* what: a site, a bit of it, a step. -> an outcome; WRONG where the child was stopped by a signal, its alarm against a loop without end
 * included, or by a sanitizer. */
static unsigned in_child(uint32_t what[3])
{
    int status = 0;
    const pid_t child = fork();

    if (child == 0) {
        (void)alarm(20);
        run_struck(&kelly_string, what[2], flip_this, what);
        _exit(OF_OURS + (int)worst(results));
    }
    if (child < 0 || waitpid(child, &status, 0) != child) {
        exit(1);
    }
    return outcome_of_child(status);
}

void flips_in_counts(tally *t, int soft)
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
    add_site(&run.window_last, 4);
    add_site(&run.drive, sizeof(run.drive));
    add_site(&work.tick, 4);
    add_site(soft ? &work.driven.tick : &work.block.tick, 4);
    for (uint32_t s = 0; s < site_count; s++) {
        for (uint32_t bit = 0; bit < 8 * sites[s].bytes; bit++) {
            const uint32_t when[] = { TICKS / 3, TICKS - 100 };      /* before the window opens, and in it */

            for (unsigned k = 0; k < 2; k++) {
                t->flips++;
                t->alone[in_child((uint32_t[3]){ s, bit, when[k] })]++;
            }
        }
    }
}

/* ---- how soon ----------------------------------------------------------------------------------------------------- */

static void flip_coefficient(void *of)
{
    site_count = 0;
    add_places(*(const int *)of);
    flip_any(0);
}

static void flip_state(void *of)
{
    site_count = 0;
    motion_places(*(const int *)of);
    flip_any(0);
}

/* Long blocks, struck anywhere, in turn in the table, in coefficients and, where it is guarded, in the state: -> the most steps that went by until the block stood still. */
uint32_t steps_until_told(int soft, uint32_t flips)
{
    static void (*const strikes[])(void *) = { flip_table, flip_coefficient, flip_state };
    uint32_t most = 0;

    for (uint32_t i = 0; i < flips; i++) {
        uint32_t at, left;

        run = base;
        run.ticks = run.window_last = 4 * KELLY_LOOK;
        run.window_first = KELLY_LOOK / 4;
        at = below(run.window_last - 1) + 1;
        copy_table();
        kelly_run_begin(&copy, &run, 7, first, lanes, results, &work);
        (void)kelly_run_advance(&copy, &run, lanes, results, &work, at);
        strikes[i % (KELLY_GUARD ? 3 : 2)](&soft);
        left = kelly_run_advance(&copy, &run, lanes, results, &work, 4 * KELLY_LOOK);
        kelly_run_finish(&copy, &run, lanes, results, &work);
        EQUAL(left, 0);
        CHECK(work.tick >= at && results[0].status == KELLY_CORRUPT && results[lanes - 1].status == KELLY_CORRUPT);
        most = work.tick - at > most ? work.tick - at : most;
    }
    return most;
}
