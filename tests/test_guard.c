/* test_guard.c - the guard over the state of a single string: no bit of it flips unseen, before a step, after it or over a new phase, and
 * nothing that may be done to a string sets it off. Built with -DKELLY_GUARD=0 a small flip is not seen, and the rest is. */
#include "../firmware/kelly.h"
#include "check.h"
#include "fixture.h"

enum { STIFF, SOFT, COMMANDED, TOPS };

static kelly_case run;
static kelly_draw draw;
static kelly_plant *const plant = &fixture.plant;

static void start(unsigned top)
{
    fixture_case(&run, 4000);
    kelly_draw_nominal(&run, &draw);
    if (top == COMMANDED) {
        EQUAL(kelly_plant_start_commanded(plant, &kelly_string, &run, &draw, R(8.0)), KELLY_OK);
        return;
    }
    if (top == SOFT) {
        run.drive = (kelly_drive){ .inertia = R(2900.0), .impedance = R(289.0), .hz = R(0.2) };
    }
    EQUAL(kelly_plant_start(plant, &kelly_string, &run, &draw), KELLY_OK);
}

/* ---- every number of the state ------------------------------------------------------------------------------------- */

#define PLACES 64u

static unsigned stiff_places(real *places[PLACES])
{
    kelly_lane *const on = &plant->block.lane[0];
    unsigned n = 0;

    for (real *at = &on->wave; at <= &on->highest; at++) {        /* wave, dwave, muf, t1, y1 .. y4, lowest, highest */
        places[n++] = at;
    }
    EQUAL(n, 10);
    for (unsigned i = 0; i < 10; i++) {
        real *const state = plant->block.full ? &plant->block.mode[0][i].xi : &plant->block.slow[0][i].v;

        places[n++] = &state[0];
        places[n++] = &state[1];
    }
    return n;
}

static unsigned varying_places(real *places[PLACES])
{
    kelly_driven_lane *const on = &plant->driven.lane[0];
    real *const single[] = { &on->eta, &on->phi, &on->sine, &on->cosine, &on->speed, &on->lowest, &on->highest };
    unsigned n = 0;

    for (; n < sizeof(single) / sizeof(single[0]); n++) {
        places[n] = single[n];
    }
    for (unsigned k = 0; k < 4; k++) {
        places[n++] = &on->y.at[k];
        places[n++] = &on->p.at[k];
    }
    for (unsigned i = 0; i < 10; i++) {
        places[n++] = &plant->driven.mode[0][i].v;
        places[n++] = &plant->driven.mode[0][i].x;
    }
    return n;
}

static unsigned all_places(unsigned top, real *places[PLACES])
{
    unsigned n = top == STIFF ? stiff_places(places) : varying_places(places);

    for (unsigned j = 0; j < 2; j++) {
        places[n++] = &plant->axial.p[j];
        places[n++] = &plant->axial.v[j];
    }
    return n;
}

static void flip(real *at, unsigned bit)
{
    ((uint8_t *)at)[bit / 8] ^= (uint8_t)(1u << bit % 8);
}

static void sees_every_number(unsigned top)
{
    real *places[PLACES];
    unsigned n, flips = 0, seen = 0, restored = 0;

    start(top);
    kelly_plant_advance(plant, 3);
    n = all_places(top, places);
    for (unsigned p = 0; p < n; p++) {
        for (unsigned bit = 0; bit < 8 * sizeof(real); bit += 5) {
            flips++;
            flip(places[p], bit);
            seen += !kelly_plant_sane(plant);
            flip(places[p], bit);
            restored += kelly_plant_sane(plant) != 0;
        }
    }
    EQUAL(flips, n * ((8 * sizeof(real) + 4) / 5));
    EQUAL(seen == flips, KELLY_GUARD);
    EQUAL(restored, flips);
}

/* A lowest bit: too little for any bound. `steps` later it is still known, also where a new phase has put the weight right, and a look has
 * been taken or a command given. */
static void keeps_what_it_saw(unsigned top, uint32_t steps)
{
    real *places[PLACES];
    unsigned struck = 0, known = 0;

    start(top);
    for (unsigned p = 0; p < all_places(top, places); p += BY_LENGTH(11, 3)) {
        start(top);
        kelly_plant_advance(plant, KELLY_RESYNC - 2);
        CHECK(kelly_plant_sane(plant));
        flip(places[p], 0);
        kelly_plant_advance(plant, steps);
        kelly_plant_watch(plant);
        struck++;
        known += !kelly_plant_sane(plant);
    }
    CHECK(struck > 0);
    EQUAL(known == struck, KELLY_GUARD);
}

static void sees_the_phase(void)
{
    start(COMMANDED);
    kelly_plant_advance(plant, 5);
    plant->driven.phase[0] ^= 1;
    EQUAL(!kelly_plant_sane(plant), KELLY_GUARD);
    kelly_plant_advance(plant, 5);
    kelly_plant_command(plant, R(9.0), R(100000.0), 2);
    kelly_plant_advance(plant, BY_LENGTH(10, KELLY_RESYNC));
    EQUAL(!kelly_plant_sane(plant), KELLY_GUARD);
}

/* ---- counts, coefficients ------------------------------------------------------------------------------------------- */

/* Whatever is asked before the next look stays within the arrays. */
static void asks_everything(void)
{
    real q[KELLY_MODES_MAX + 1] = { 0 }, v[KELLY_MODES_MAX + 1] = { 0 };
    kelly_sight sight;

    q[KELLY_MODES_MAX] = v[KELLY_MODES_MAX] = R(3.0);
    kelly_plant_look(plant, &sight);
    kelly_plant_modal(plant, q, v);
    (void)kelly_plant_twist(plant);
    (void)kelly_plant_allows(plant, R(8.0), R(1e5));
    CHECK(q[KELLY_MODES_MAX] == R(3.0) && v[KELLY_MODES_MAX] == R(3.0));
}

/* Counts that lead beyond the arrays are told, and nothing beyond is read. */
static void counts_lead_nowhere(unsigned top)
{
    start(top);
    plant->axial.count = 1000;
    kelly_plant_advance(plant, 1);
    CHECK(!kelly_plant_sane(plant));
    start(top);
    *(top == STIFF ? &plant->block.modes : &plant->driven.modes) = 1000;
    CHECK(kelly_plant_sane(plant));                        /* modes that are not in use hold zeros; the next look tells */
    kelly_plant_advance(plant, 1);
    CHECK(!kelly_plant_sane(plant));
    start(top);
    kelly_plant_advance(plant, 5);
    *(top == STIFF ? &plant->block.tick : &plant->driven.tick) += 1;
    CHECK(!kelly_plant_sane(plant));
    start(top);
    plant->modes.count = 1000;
    asks_everything();
    kelly_plant_advance(plant, 1);
    CHECK(!kelly_plant_sane(plant));
}

/* The ramp of a command, and what the string is kept in. */
static void sees_the_ramp_and_the_kind(void)
{
    start(COMMANDED);
    kelly_plant_command(plant, R(9.0), R(100000.0), 20);
    kelly_plant_advance(plant, 3);
    CHECK(kelly_plant_sane(plant));
    plant->ramp ^= 1;
    CHECK(!kelly_plant_sane(plant));
    kelly_plant_advance(plant, 3);
    CHECK(!kelly_plant_sane(plant));
    kelly_plant_command(plant, R(9.0), R(100000.0), 20);
    CHECK(!kelly_plant_sane(plant));
    start(COMMANDED);
    plant->commanded = 0;
    kelly_plant_advance(plant, 1);
    CHECK(!kelly_plant_sane(plant));
    start(STIFF);
    plant->run.f0 += R(0.5);
    kelly_plant_advance(plant, 1);
    CHECK(!kelly_plant_sane(plant));
    start(STIFF);
    plant->run.step_ns += 1;
    kelly_plant_advance(plant, 1);
    CHECK(!kelly_plant_sane(plant));
}

/* What a string still asks of its table after its start. */
static void sees_the_table_change(void)
{
    for (unsigned k = 0; k < 3; k++) {
        kelly_table table = kelly_string;
        real *const of[] = { &table.alpha, &table.beta, &table.inertia };

        fixture_case(&run, 4000);
        kelly_draw_nominal(&run, &draw);
        EQUAL(kelly_plant_start(plant, &table, &run, &draw), KELLY_OK);
        kelly_plant_advance(plant, 1);
        CHECK(kelly_plant_sane(plant));
        start(STIFF);
        plant->table = &table;
        flip(of[k], 0);
        kelly_plant_advance(plant, 1);
        CHECK(!kelly_plant_sane(plant));
    }
}

static void seals_the_axial_coefficients(void)
{
    kelly_axial *const axial = &plant->axial;
    real *const places[] = { &axial->h, &axial->f0, &axial->w2[1], &axial->c[1], &axial->b[0] };

    for (unsigned p = 0; p <= sizeof(places) / sizeof(places[0]); p++) {
        start(STIFF);
        if (p < sizeof(places) / sizeof(places[0])) {
            flip(places[p], 0);
        } else {
            axial->phase_step ^= 1;
        }
        kelly_plant_advance(plant, 1);
        CHECK(!kelly_plant_sane(plant));
    }
}

/* ---- what may be done ----------------------------------------------------------------------------------------------- */

static void nothing_lawful_sets_it_off(unsigned top)
{
    start(top);
    for (unsigned k = 0; k < 4; k++) {
        kelly_plant_advance(plant, BY_LENGTH(70, KELLY_RESYNC / 2 + 7));
        CHECK(kelly_plant_sane(plant));
        kelly_plant_watch(plant);
        CHECK(kelly_plant_sane(plant));
        kelly_plant_command(plant, k % 2 ? R(7.0) : R(9.0), R(90000.0), 40 + 300 * k);
        CHECK(kelly_plant_sane(plant));
    }
}

void test_guard(void);
void test_guard(void)
{
    for (unsigned top = STIFF; top < TOPS; top++) {
        sees_every_number(top);
        keeps_what_it_saw(top, 3);
#if CHECK_LONG
        keeps_what_it_saw(top, 1);
#endif
        counts_lead_nowhere(top);
        nothing_lawful_sets_it_off(top);
    }
    sees_the_phase();
    sees_the_ramp_and_the_kind();
    sees_the_table_change();
    seals_the_axial_coefficients();
}
