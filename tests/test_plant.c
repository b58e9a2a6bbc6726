/* test_plant.c - one string as a bench sees it: momentum is kept, and it is the very realisation of the ensemble. */
#include "check.h"
#include "fixture.h"

static kelly_case run;
static kelly_draw draw;
static kelly_plant *const plant = &fixture.plant;

/* Momentum of the modes, sum d_i q_i', and sum d_i q_i. */
static void momentum(wide *of_speed, wide *of_twist)
{
    real q[KELLY_MODES_MAX], v[KELLY_MODES_MAX];

    kelly_plant_modal(plant, q, v);
    *of_speed = *of_twist = 0;
    for (unsigned i = 0; i < plant->modes.count; i++) {
        *of_speed += (wide)plant->modes.d[i] * (wide)v[i];
        *of_twist += (wide)plant->modes.d[i] * (wide)q[i];
    }
}

/* Angular momentum of the whole string, J w0 + sum d q': its change plus what the mass-proportional damping takes is the
 * impulse of surface torque and bit torque. The trapezoid's own error at 1 ms is about 0.002 N m s here. */
static void keeps_momentum(void)
{
    const uint32_t ticks = BY_LENGTH(500, 5000);
    const wide seconds = (wide)ticks * W(0.001);
    wide speed0, twist0, speed1, twist1, impulse = 0, lost;
    kelly_sight sight;

    fixture_case(&run, 6000);
    kelly_draw_nominal(&run, &draw);
    EQUAL(kelly_plant_start(plant, &kelly_string, &run, &draw), KELLY_OK);
    kelly_plant_advance(plant, 500);
    momentum(&speed0, &twist0);
    for (uint32_t k = 0; k < ticks; k++) {
        kelly_plant_look(plant, &sight);
        impulse += W(0.0005) * ((wide)sight.surface_torque + (wide)sight.bit_torque);
        kelly_plant_advance(plant, 1);
        kelly_plant_look(plant, &sight);
        impulse += W(0.0005) * ((wide)sight.surface_torque + (wide)sight.bit_torque);
    }
    momentum(&speed1, &twist1);
    lost = (wide)kelly_string.alpha * ((wide)kelly_string.inertia * (wide)draw.w0 * seconds + (twist1 - twist0));
    CHECK(fixture_abs(speed1 - speed0) > W(20.0));         /* [N m s] */
    CLOSE(impulse, speed1 - speed0 + lost, BY_REAL(0.05, 0.03));
}

static void shows_forces_and_speeds(void)
{
    kelly_sight sight;

    fixture_case(&run, 1000);
    kelly_draw_nominal(&run, &draw);
    EQUAL(kelly_plant_start(plant, &kelly_string, &run, &draw), KELLY_OK);
    kelly_plant_look(plant, &sight);
    CLOSE((wide)sight.f_bit, W(-99500.0), W(0.05));        /* fc less 1 % of f0 */
    CHECK(sight.axial_speed == 0 && sight.top_speed == draw.w0);
    CLOSE((wide)sight.bit_torque, textbook_torque((wide)sight.bit_speed, W(-99500.0), W(0.04), 2, 1), W(0.01));
    kelly_plant_advance(plant, 150);                       /* a quarter turn of the top */
    kelly_plant_look(plant, &sight);
    CLOSE((wide)sight.f_bit, W(-49500.0), W(0.5));
    CLOSE((wide)sight.bit_torque, textbook_torque((wide)sight.bit_speed, (wide)sight.f_bit, W(0.04), 2, 1), W(0.01));
    CHECK(sight.axial_speed > 0);
    draw.fc = R(30000.0);
    EQUAL(kelly_plant_start(plant, &kelly_string, &run, &draw), KELLY_OK);
    kelly_plant_advance(plant, 150);
    kelly_plant_look(plant, &sight);
    CHECK(sight.f_bit == 0 && sight.bit_torque == 0);      /* lifted off */
}

static void refuses_as_the_ensemble_does(void)
{
    fixture_case(&run, 1000);
    kelly_draw_nominal(&run, &draw);
    draw.fc = R(2e6);
    EQUAL(kelly_plant_start(plant, &kelly_string, &run, &draw), KELLY_RANGE);
    draw.fc = run.fc;
    draw.mu = R(1.0);
    EQUAL(kelly_plant_start(plant, &kelly_string, &run, &draw), KELLY_STEP);
    EQUAL(kelly_plant_start_commanded(plant, &kelly_string, &run, &draw, R(10.0)), KELLY_STEP);
    draw.fc = R(2e6);
    EQUAL(kelly_plant_start_commanded(plant, &kelly_string, &run, &draw, R(10.0)), KELLY_RANGE);
}

/* The twist grows by what the bit turns less than w0 would: by the trapezoid, whose own error here is about 1e-6 rad. */
static void twists_by_what_the_bit_lags(real inertia)
{
    const uint32_t ticks = BY_LENGTH(200, 3000);
    wide turned = 0, before;
    kelly_sight sight;

    fixture_case(&run, 6000);
    kelly_draw_nominal(&run, &draw);
    run.drive = (kelly_drive){ .inertia = inertia, .impedance = R(289.0), .hz = R(0.2) };
    EQUAL(kelly_plant_start(plant, &kelly_string, &run, &draw), KELLY_OK);
    kelly_plant_advance(plant, 300);
    before = (wide)kelly_plant_twist(plant);
    for (uint32_t k = 0; k <= ticks; k++) {
        kelly_plant_look(plant, &sight);
        turned += ((wide)sight.bit_speed - (wide)draw.w0) * (k == 0 || k == ticks ? W(0.0005) : W(0.001));
        if (k < ticks) {
            kelly_plant_advance(plant, 1);
        }
    }
    CHECK(fixture_abs(turned) > W(0.3));                   /* [rad] */
    CLOSE((wide)kelly_plant_twist(plant) - before, turned, BY_REAL(1e-3, 1e-4));
}

/* As if a step had left it so. */
static void put_axial_speed(real speed)
{
    kelly_axial *const axial = &plant->axial;

    axial->v[0] = speed;
    axial->seal = kelly_seal(kelly_seal(0, axial->p, axial->count * sizeof(real)), axial->v, axial->count * sizeof(real));
}

/* A state that is no number, or is too large for one, is not sane, wherever it is. */
static void knows_the_insane(real inertia)
{
    const real bad[] = { CHECK_NAN, R(1e7), R(-1e7) };

    fixture_case(&run, 100);
    kelly_draw_nominal(&run, &draw);
    run.drive = (kelly_drive){ .inertia = inertia, .impedance = R(289.0), .hz = R(0.2) };
    EQUAL(kelly_plant_start(plant, &kelly_string, &run, &draw), KELLY_OK);
    for (unsigned k = 0; k < sizeof(bad) / sizeof(bad[0]); k++) {
        CHECK(kelly_plant_sane(plant));
        put_axial_speed(bad[k] / plant->axial.b[0]);
        CHECK(kelly_axial_untouched(&plant->axial) && !kelly_plant_sane(plant));
        put_axial_speed(0);
    }
    if (inertia > 0) {
        fixture_put(&plant->driven.lane[0].phi, &plant->driven.lane[0].guard, bad[0]);
        CHECK(kelly_driven_untouched(&plant->driven));
    } else {
        fixture_put(&plant->block.lane[0].y1, &plant->block.lane[0].guard, bad[0]);
        CHECK(kelly_block_untouched(&plant->block));
    }
    CHECK(!kelly_plant_sane(plant));
}

/* A coefficient that is no longer what it was when the string was started is told from the next look on: here that of the first step. */
static void knows_another_coefficient(real inertia)
{
    fixture_case(&run, 100);
    kelly_draw_nominal(&run, &draw);
    run.drive = (kelly_drive){ .inertia = inertia, .impedance = R(289.0), .hz = R(0.2) };
    EQUAL(kelly_plant_start(plant, &kelly_string, &run, &draw), KELLY_OK);
    plant->draw.mu *= R(1.001);
    CHECK(kelly_plant_sane(plant));
    kelly_plant_advance(plant, 1);
    CHECK(!kelly_plant_sane(plant));
    plant->draw.mu = draw.mu;
    kelly_plant_advance(plant, 1);
    CHECK(!kelly_plant_sane(plant));
}

/* Extremes of realisation `index` as the plant sees them, in uneven pieces. */
static void watch_plant(uint32_t index, real *lowest, real *highest)
{
    kelly_draw_sample(&run, 3, index, &draw);
    EQUAL(kelly_plant_start(plant, &kelly_string, &run, &draw), KELLY_OK);
    kelly_plant_advance(plant, run.window_first);
    kelly_plant_watch(plant);
    for (uint32_t tick = run.window_first; tick < run.window_last; tick += 7) {
        kelly_plant_advance(plant, run.window_last - tick < 7 ? run.window_last - tick : 7);
    }
    kelly_plant_extremes(plant, lowest, highest);
}

static void is_the_ensemble_realisation(void)
{
    real lowest[2], highest[2];

    fixture_case(&run, BY_LENGTH(200, 6000));
    for (unsigned k = 0; k < KELLY_PARAMETERS; k++) {
        run.cov[k] = 0.2f;
    }
    for (uint32_t j = 0; j < 2; j++) {
        watch_plant(1000 + j, &lowest[j], &highest[j]);
    }
    kelly_run(&kelly_string, &run, 3, 1000, 2, fixture.ensemble.results, &fixture.ensemble.work);
    for (uint32_t j = 0; j < 2; j++) {
        EQUAL(fixture_bits(lowest[j]), fixture_bits(fixture.ensemble.results[j].lowest));
        EQUAL(fixture_bits(highest[j]), fixture_bits(fixture.ensemble.results[j].highest));
    }
}

void test_plant(void);
void test_plant(void)
{
    shows_forces_and_speeds();
    keeps_momentum();
    refuses_as_the_ensemble_does();
    twists_by_what_the_bit_lags(0);
    twists_by_what_the_bit_lags(R(2900.0));
    knows_the_insane(0);
    knows_the_insane(R(2900.0));
    knows_another_coefficient(0);
    knows_another_coefficient(R(2900.0));
    is_the_ensemble_realisation();
}
