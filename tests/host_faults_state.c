/* host_faults_state.c - bits and bad numbers in the state of a block under way, and bad numbers in what a caller gives. */
#include <stdio.h>
#include <string.h>

#include "host_faults.h"

/* ---- bad numbers -------------------------------------------------------------------------------------------------- */

#define BAD 9u
static void bad_numbers(real bad[BAD], real of)
{
    const real list[BAD] = { CHECK_NAN, (real)__builtin_inf(), -(real)__builtin_inf(), R(1e38), R(-1e38),
                             sizeof(real) > 4 ? (real)4.9e-324 : (real)1e-45, 0, -of, R(-1.0) };

    memcpy(bad, list, sizeof(list));
}

/* ---- the state ---------------------------------------------------------------------------------------------------- */

static void stiff_places(void)
{
    kelly_block *const b = &work.block;

    for (unsigned v = 0; v < b->vectors; v++) {
        add_vectors(&b->lane[v].wave, SPAN(kelly_lane, wave, highest));
        for (unsigned i = 0; i < b->modes; i++) {
            add_vectors(b->full ? &b->mode[v][i].xi : &b->slow[v][i].v, 2);
        }
    }
}

static void soft_places(void)
{
    kelly_driven *const d = &work.driven;

    for (unsigned v = 0; v < d->vectors; v++) {
        kelly_driven_lane *const on = &d->lane[v];

        add_vectors(&on->eta, SPAN(kelly_driven_lane, eta, cosine));
        add_vectors(&on->speed, SPAN(kelly_driven_lane, speed, highest));
        add_vectors(on->y.at, 4);
        add_vectors(on->p.at, 4);
        for (unsigned i = 0; i < d->modes; i++) {
            add_vectors(&d->mode[v][i].v, 2);
        }
    }
    for (unsigned l = 0; l < lanes; l++) {
        add_site(&d->phase[l], sizeof(d->phase[l]));
    }
}

/* The state of the string or drive. */
void motion_places(int soft)
{
    if (soft) {
        soft_places();
    } else {
        stiff_places();
    }
}

/* And the block's own books. */
void state_places(int soft)
{
    motion_places(soft);
    for (unsigned l = 0; l < lanes; l++) {
        add_site(&results[l].mean, sizeof(real));
    }
    add_site(soft ? &work.driven.tick : &work.block.tick, sizeof(work.tick));
    add_site(&work.tick, sizeof(work.tick));
    add_site(&work.seal, sizeof(work.seal));
}

void flips_in_state(tally *t, int soft, uint32_t flips)
{
    flips_in_block(t, state_places, soft, flips);
}

void clear_block(int soft)
{
    if (soft) {
        kelly_driven_clear(&work.driven, &kelly_string, &run, KELLY_WIDTH);
    } else {
        kelly_block_clear(&work.block, &kelly_string, &run, KELLY_WIDTH);
    }
}

void load_lane(int soft, unsigned lane, void (*strike)(void *))
{
    EQUAL(kelly_realise(&kelly_string, &run, &clean[lane].draw, &work.modes), KELLY_OK);
    if (strike) {
        strike(0);
    }
    if (soft) {
        kelly_driven_load(&work.driven, lane, &kelly_string, &run, &clean[lane].draw, &work.modes, clean[lane].draw.w0);
    } else {
        kelly_block_load(&work.block, lane, &run, &clean[lane].draw, &work.modes);
    }
}

/* The state of a vector struck between the loads of two of its lanes: found, whatever the second one writes over. */
void flips_between_loads(int soft, uint32_t flips)
{
    run = base;
    for (uint32_t i = 0; i <= flips; i++) {
        clear_block(soft);
        load_lane(soft, 0, 0);
        site_count = 0;
        motion_places(soft);
        if (i > 0) {                                                      /* the first goes without */
            flip_any(0);
        }
        load_lane(soft, 1, 0);
        EQUAL(soft ? kelly_driven_untouched(&work.driven) : kelly_block_untouched(&work.block), i == 0);
    }
}

static void put_number(void *of)
{
    const uint32_t *const what = of;
    real bad[BAD], old;

    memcpy(&old, sites[what[0]].at, sizeof(old));
    bad_numbers(bad, old);
    memcpy(sites[what[0]].at, &bad[what[1]], sizeof(real));
}

/* Every state of a block under way set to every bad number, at two instants. */
void numbers_in_state(tally *far, tally *small, int soft, unsigned every)
{
    static const uint32_t when[] = { 1000, TICKS - 3000 };

    site_count = 0;
    state_places(soft);
    for (uint32_t s = 0; s < site_count; s += every) {
        for (uint32_t k = 0; sites[s].bytes == sizeof(real) && k < 2 * BAD; k++) {
            run = base;
            site_count = 0;
            state_places(soft);
            run_struck(&kelly_string, when[k / BAD], put_number, (uint32_t[2]){ s, k % BAD });
            add_outcome(k % BAD < 5 ? far : small);
        }
    }
}

/* ---- inputs ------------------------------------------------------------------------------------------------------- */

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
void numbers_in_draws(int soft)
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
void numbers_in_case(void)
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
        run.cov[k] = (float)CHECK_NAN;
        CHECK(kelly_case_error(&kelly_string, &run) != 0);
    }
}

static kelly_plant plant;

/* Commands to a string that runs: none of these is allowed. */
void numbers_in_commands(void)
{
    real bad[BAD];

    run = base;
    EQUAL(kelly_plant_start_commanded(&plant, &kelly_string, &run, &clean[0].draw, clean[0].draw.w0), KELLY_OK);
    bad_numbers(bad, R(1.0));
    for (unsigned b = 0; b < BAD; b++) {
        CHECK(!kelly_plant_allows(&plant, clean[0].draw.w0, bad[b]) || (bad[b] > 0 && bad[b] < R(1e-30)));
        CHECK(!kelly_plant_allows(&plant, bad[b], clean[0].draw.fc) || KELLY_ABS(bad[b]) <= R(1.0));
    }
}

/* ---- a single string ---------------------------------------------------------------------------------------------- */

static void start_plant(int top)
{
    run = base;
    run.drive = top == 1 ? (kelly_drive){ .inertia = R(2900.0), .impedance = R(289.0), .hz = R(0.2) } : (kelly_drive){ .inertia = 0 };
    if (top == 2) {
        EQUAL(kelly_plant_start_commanded(&plant, &kelly_string, &run, &clean[0].draw, clean[0].draw.w0), KELLY_OK);
        kelly_plant_command(&plant, clean[0].draw.w0 * R(1.25), clean[0].draw.fc, 500);
    } else {
        EQUAL(kelly_plant_start(&plant, &kelly_string, &run, &clean[0].draw), KELLY_OK);
    }
    kelly_plant_advance(&plant, 1000);
}

static void plant_state(int top)
{
    if (top == 0) {
        add_site(&plant.block.lane[0].wave, SPAN(kelly_lane, wave, guard) * sizeof(real));
        add_site(&plant.block.slow[0][3].v, 2 * sizeof(real));
    } else {
        add_site(&plant.driven.lane[0].eta, SPAN(kelly_driven_lane, eta, cosine) * sizeof(real));
        add_site(&plant.driven.lane[0].speed, SPAN(kelly_driven_lane, speed, guard) * sizeof(real));
        add_site(plant.driven.lane[0].y.at, 4 * sizeof(real));
        add_site(plant.driven.lane[0].p.at, 4 * sizeof(real));
        add_site(&plant.driven.mode[0][3].v, 2 * sizeof(real));
        add_site(&plant.driven.phase[0], 8);
    }
    add_site(plant.axial.p, 2 * sizeof(real));
    add_site(plant.axial.v, 2 * sizeof(real));
}

static void plant_places(int top)
{
    site_count = 0;
    if (top == 0) {
        add_site(&plant.block.modes, 4);
        add_site(&plant.block.vectors, 4);
        add_site(&plant.block.h, sizeof(real));
        add_site(&plant.block.phase_step[0], 8);
        add_site(&plant.block.lane[0].w0, SPAN(kelly_lane, w0, twice_g2) * sizeof(real));
    } else {
        add_site(&plant.driven.modes, 4);
        add_site(&plant.driven.vectors, 4);
        add_site(&plant.driven.phase_step[0], 8);
        add_site(&plant.driven.lane[0].w_ref, SPAN(kelly_driven_lane, w_ref, counted) * sizeof(real));
        add_site(&plant.driven.mode[0][0].w, SPAN(kelly_driven_mode, w, d11) * sizeof(real));
    }
    plant_state(top);
    add_site(&plant.axial.h, sizeof(real));
    add_site(&plant.axial.f0, sizeof(real));
    add_site(&plant.axial.phase_step, 8);
    add_site(&plant.axial.b[1], sizeof(real));
    add_site(&plant.axial.c[1], sizeof(real));
    add_site(&plant.axial.w2[1], sizeof(real));
    add_site(&plant.draw, sizeof(plant.draw));
    add_site(&plant.weight, sizeof(real));
    add_site(&plant.modes.w2[1], sizeof(real));
    add_site(&plant.run.f0, sizeof(real));
    add_site(&plant.ramp, 4);
    add_site(&plant.ramp_inverse, 4);
    add_site(&plant.tick, 4);
    add_site(&plant.seal, 4);
}

/* Every third bit of the state and of what must not change: the string is not sane by the next look, and without a flip it is. */
void flips_in_plant(int top)
{
    start_plant(top);
    kelly_plant_advance(&plant, KELLY_LOOK);
    CHECK(kelly_plant_sane(&plant) && plant.tick == KELLY_LOOK + 1000);
    plant_places(top);
    for (unsigned s = 0; s < site_count; s++) {
        for (unsigned bit = 0; bit < 8 * sites[s].bytes; bit += 3) {
            start_plant(top);
            flip(&sites[s], bit);
            kelly_plant_advance(&plant, KELLY_LOOK);
            CHECK(!kelly_plant_sane(&plant));
        }
    }
}
