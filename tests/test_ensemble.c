/* test_ensemble.c - a range of realisations: the same bits however it is cut, and on every machine. */
#include "check.h"
#include "fixture.h"
#include "vectors/digests.h"

static kelly_case run;
static kelly_result *const results = fixture.ensemble.results;
static kelly_result *const again = fixture.ensemble.again;

/* All five laws at 20 %, `ticks` steps, the window the second half. */
static void random_case(uint32_t ticks)
{
    fixture_case(&run, ticks);
    for (unsigned k = 0; k < KELLY_PARAMETERS; k++) {
        run.cov[k] = 0.2f;
    }
}

static void run_into(kelly_result *to, uint64_t seed, uint32_t first, uint32_t count)
{
    kelly_run(&kelly_string, &run, seed, first, count, to, &fixture.ensemble.work);
}

static uint32_t digest(uint32_t first, uint32_t count)
{
    kelly_tally tally = { 0 };

    for (uint32_t j = 0; j < count; j++) {
        kelly_tally_add(&tally, first + j, &results[j]);
    }
    return tally.digest;
}

static void does_not_mind_cuts(void)
{
    const uint32_t count = BY_LENGTH(3, FIXTURE_RESULTS);

    random_case(BY_LENGTH(100, 3000));
    run_into(results, 9, 50, count);
    for (uint32_t piece = 1; piece < count; piece++) {
        for (uint32_t done = 0; done < count; done += piece) {
            run_into(&again[done], 9, 50 + done, count - done < piece ? count - done : piece);
        }
        for (uint32_t j = 0; j < count; j++) {
            CHECK(fixture_same(&results[j], &again[j]));
        }
    }
    CHECK(!fixture_same(&results[0], &results[1]));
}

/* Begin, advance, finish: the same results, whatever the pieces; a window that opens at tick 0 included. */
static void does_not_mind_pieces(void)
{
    static const uint32_t pieces[] = { 1, 7, 60, 1000 };

    random_case(120);
    for (uint32_t open = 0; open < 2; open++) {
        run.window_first = open == 0 ? 0 : 60;
        run_into(results, 9, 50, 1);
        for (unsigned k = 0; k < sizeof(pieces) / sizeof(pieces[0]); k++) {
            uint32_t left, calls = 0;

            kelly_run_begin(&kelly_string, &run, 9, 50, 1, again, &fixture.ensemble.work);
            do {
                left = kelly_run_advance(&kelly_string, &run, 1, again, &fixture.ensemble.work, pieces[k]);
                calls++;
            } while (left > 0);
            kelly_run_finish(&kelly_string, &run, 1, again, &fixture.ensemble.work);
            CHECK(fixture_same(&results[0], &again[0]));
            EQUAL(calls, (120u + pieces[k] - 1u) / pieces[k]);
        }
    }
}

/* Draws, extremes, means and severities in one number, of a small case; see vectors/digests.h. */
static void has_its_digest(void)
{
    random_case(200);
    run_into(results, 1, 0, 2);
    EQUAL(digest(0, 2), DIGEST_SHORT);
    run_into(results, UINT64_C(0x123456789abcdef0), UINT32_MAX - 1u, 2);   /* the last two indices there are */
    EQUAL(digest(UINT32_MAX - 1u, 2), DIGEST_LAST);
#if CHECK_LONG
    random_case(4000);
    run_into(results, 1, 0, 8);
    EQUAL(digest(0, 8), DIGEST_LONG);
#endif
}

/* Result by result what a step-by-step run of the same draw gives. */
static void classifies_what_it_ran(void)
{
    kelly_result one;
    kelly_modes modes;
    kelly_block *const block = &fixture.pair[0];
    real low, high;
    wide twist;

    random_case(120);
    run.limit = R(0.5);
    run_into(results, 4, 7, 1);
    one = results[0];
    CHECK(one.status == KELLY_OK && one.lowest < one.highest);
    EQUAL(kelly_realise(&kelly_string, &run, &one.draw, &modes), KELLY_OK);
    kelly_block_clear(block, &kelly_string, &run, 1);
    kelly_block_load(block, 0, &run, &one.draw, &modes);
    kelly_block_advance(block, 60);
    kelly_block_watch(block);
    twist = (wide)kelly_block_twist(block, 0, &modes);
    kelly_block_advance(block, 60);
    twist = (wide)kelly_block_twist(block, 0, &modes) - twist;
    kelly_block_extremes(block, 0, &low, &high);
    CHECK(one.lowest == low && one.highest == high);
    CLOSE((wide)one.mean, (wide)one.draw.w0 + twist / W(0.06), BY_REAL(1e-5, 1e-12));
    CHECK(one.ss == kelly_severity(low, high));
    CHECK(one.stuck == (one.ss > run.limit));
    run.limit = one.ss;                                    /* only above the limit counts */
    run_into(results, 4, 7, 1);
    CHECK(!results[0].stuck);
}

static void expect_refused(const kelly_result *r, kelly_status status)
{
    EQUAL(r->status, status);
    CHECK(r->lowest == 0 && r->highest == 0 && r->mean == 0 && r->ss == 0 && !r->stuck);
    CHECK(r->draw.fc > 0);                                 /* the draw is reported */
}

static void refuses_without_guessing(void)
{
    random_case(20);
    run.step_ns = 5000000;
    run_into(results, 1, 0, 1);
    expect_refused(&results[0], KELLY_STEP);
    random_case(20);
    run.fc = R(5e6);
    run_into(results, 1, 0, 1);
    expect_refused(&results[0], KELLY_RANGE);
    random_case(20);
    run.f0 = (real)BY_REAL(-1e30, -1e300);                 /* overflows in (B); kelly_case_error would not let it pass */
    run_into(results, 1, 0, 1);
    expect_refused(&results[0], KELLY_NONFINITE);
    random_case(20);
    run.window_first = run.window_last;                    /* no time to take a mean of; kelly_case_error would not let it pass */
    run_into(results, 1, 0, 1);
    expect_refused(&results[0], KELLY_NONFINITE);
}

static void expect_corrupt(kelly_result *r)
{
    expect_refused(r, KELLY_CORRUPT);
    *r = (kelly_result){ .status = KELLY_OK, .ss = R(3.0), .stuck = 1 };
}

/* A table that has changed begins nothing: the draw alone is told. */
static void begins_nothing_of_a_changed_table(void)
{
    kelly_table table = kelly_string;

    random_case(40);
    table.beta = table.beta * R(1.000001);
    kelly_run(&table, &run, 4, 7, 1, results, &fixture.ensemble.work);
    expect_corrupt(&results[0]);
    run.drive = (kelly_drive){ .inertia = R(2900.0), .impedance = R(289.0), .hz = R(0.2) };
    kelly_run(&table, &run, 4, 7, 1, results, &fixture.ensemble.work);
    expect_corrupt(&results[0]);
}

/* A run begun and advanced, its block spoilt by `spoil`, gives no result. The last one spoils nothing. */
static void gives_up_what_has_changed(void)
{
    enum { ARRAYS, TICK, BLOCK_TICK, DRAW, CASE, STATE, TWIST, NOTHING };
    real w2[KELLY_MODES_MAX * (KELLY_DEGREE_MAX + 1)];
    kelly_table table = kelly_string;

    table.w2 = w2;
    for (unsigned spoil = ARRAYS; spoil <= NOTHING; spoil++) {
        for (unsigned k = 0; k < kelly_string.torsional * (kelly_string.degree + 1u); k++) {
            w2[k] = kelly_string.w2[k];
        }
        random_case(40);
        kelly_run_begin(&table, &run, 4, 7, 1, results, &fixture.ensemble.work);
        EQUAL(kelly_run_advance(&table, &run, 1, results, &fixture.ensemble.work, 1000), 0);
        w2[3] += spoil == ARRAYS ? R(1.0) : R(0.0);
        fixture.ensemble.work.tick += spoil == TICK;
        fixture.ensemble.work.block.tick += spoil == BLOCK_TICK;
        results[0].draw.mu *= spoil == DRAW ? R(1.25) : R(1.0);
        fixture.ensemble.work.block.lane[0].lowest += spoil == STATE ? R(0.5) : R(0.0);
        results[0].mean += spoil == TWIST ? R(0.1) : R(0.0);
        run.limit += spoil == CASE ? R(0.1) : R(0.0);
        kelly_run_finish(&table, &run, 1, results, &fixture.ensemble.work);
        if (spoil == NOTHING || spoil == STATE) {
            EQUAL(results[0].status, spoil == STATE && KELLY_GUARD ? KELLY_CORRUPT : KELLY_OK);
        } else {
            expect_corrupt(&results[0]);
        }
    }
}

/* A table that changes after `at` steps is told before step `told`, though the block could go on to its end. */
static void stands_still(uint32_t at, uint32_t told)
{
    kelly_table table = kelly_string;

    kelly_run_begin(&table, &run, 4, 7, 1, results, &fixture.ensemble.work);
    EQUAL(kelly_run_advance(&table, &run, 1, results, &fixture.ensemble.work, at), run.window_last - at);
    table.fc_max *= R(2.0);
    EQUAL(kelly_run_advance(&table, &run, 1, results, &fixture.ensemble.work, run.window_last), 0);
    EQUAL(fixture.ensemble.work.tick, told);
    kelly_run_finish(&table, &run, 1, results, &fixture.ensemble.work);
    expect_corrupt(&results[0]);
}

static void looks_in_between(void)
{
    random_case(KELLY_LOOK + 20);
    run.window_first = 40;
    stands_still(30, 40);
    stands_still(50, KELLY_LOOK);
}

/* Counts that would lead out of the struct move nothing, and no more than the struct is sealed: of the sum only the count itself is another,
 * each time by as much. `of` is the member of the work area that `advance` and `seal` are of. */
#define FOLLOWS_NO_SENSELESS_COUNT(of, clear, advance, seal) \
    do { \
        uint32_t seals[3]; \
        clear(&(of), &kelly_string, &run, 1); \
        for (unsigned k = 0; k < 3; k++) { \
            (of).modes = KELLY_MODES_MAX + k; \
            seals[k] = seal(&(of)); \
        } \
        EQUAL(seals[2] - seals[1], seals[1] - seals[0]); \
        CHECK(seals[1] != seals[0]); \
        advance(&(of), 3); \
        EQUAL((of).tick, 0); \
        (of).modes = KELLY_MODES_MAX; \
        (of).vectors = KELLY_VECTORS + 1u; \
        advance(&(of), 3); \
        EQUAL((of).tick, 0); \
        (of).vectors = 0; \
        advance(&(of), 3); \
        EQUAL((of).tick, 3); \
    } while (0)

static void follows_no_senseless_count(void)
{
    kelly_work *const work = &fixture.ensemble.work;

    random_case(20);
    FOLLOWS_NO_SENSELESS_COUNT(work->block, kelly_block_clear, kelly_block_advance, kelly_block_seal);
    FOLLOWS_NO_SENSELESS_COUNT(work->driven, kelly_driven_clear, kelly_driven_advance, kelly_driven_seal);
}

/* A bad neighbour in the same range changes nothing. */
static void keeps_neighbours_apart(void)
{
    random_case(50);
    run.step_ns = 3000000;
    run_into(results, 2, 0, FIXTURE_RESULTS);
    for (uint32_t j = 0; j < FIXTURE_RESULTS; j++) {
        run_into(again, 2, j, 1);
        CHECK(fixture_same(&results[j], &again[0]));
    }
}

/* Draws from outside give what the same draws gave from the streams; a draw of its own gives its own. */
static void runs_given_draws(void)
{
    kelly_draw draws[3];

    random_case(BY_LENGTH(60, 600));
    run_into(results, 3, 11, 3);
    for (unsigned j = 0; j < 3; j++) {
        draws[j] = results[2 - j].draw;
    }
    kelly_run_draws(&kelly_string, &run, draws, 3, again, &fixture.ensemble.work);
    for (unsigned j = 0; j < 3; j++) {
        CHECK(fixture_same(&again[j], &results[2 - j]));
    }
#if __STDC_HOSTED__
    EQUAL(kelly_engine_here.work_size, sizeof(kelly_work));
    kelly_engine_here.run_draws(&kelly_string, &run, draws, 1, again, &fixture.ensemble.work);
    CHECK(fixture_same(&again[0], &results[2]));
#endif
    draws[0].mu = draws[0].mu * R(1.5);
    kelly_run_draws(&kelly_string, &run, draws, 1, again, &fixture.ensemble.work);
    CHECK(again[0].draw.mu == draws[0].mu && !fixture_same(&again[0], &results[2]));
}

static void marks_lift_off(void)
{
    random_case(20);
    run.fc = R(45000.0);
    run.cov[0] = 0.0f;
    run_into(results, 1, 0, 1);
    EQUAL(results[0].status, KELLY_OK);
    EQUAL(results[0].liftoff, 1);
    run.fc = R(60000.0);
    run_into(results, 1, 0, 1);
    EQUAL(results[0].liftoff, 0);
}

/* One lane of one realisation and everything that it needs: the 16 KB of a micro:bit hold it three times. */
static void fits_a_small_part(void)
{
    CHECK(sizeof(kelly_work) <= 4096);
}

void test_ensemble(void);
void test_ensemble(void)
{
    fits_a_small_part();
    does_not_mind_cuts();
    does_not_mind_pieces();
    has_its_digest();
    classifies_what_it_ran();
    refuses_without_guessing();
    begins_nothing_of_a_changed_table();
    gives_up_what_has_changed();
    looks_in_between();
    follows_no_senseless_count();
    keeps_neighbours_apart();
    runs_given_draws();
    marks_lift_off();
}
