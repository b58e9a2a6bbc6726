/* test_drive.c - a top of variable speed: commands, the stiff top as its limit, bounds of the step, and the same bits however it is run. */
#include "../firmware/link/crc32c.h"
#include "check.h"
#include "fixture.h"
#include "vectors/digests.h"

static kelly_case run;
static kelly_draw draw;
static kelly_plant *const plant = &fixture.plant;

static void soft_case(uint32_t ticks)
{
    fixture_case(&run, ticks);
    run.drive = (kelly_drive){ .inertia = R(2900.0), .impedance = R(289.0), .hz = R(0.2) };
    kelly_draw_nominal(&run, &draw);
}

/* ---- commands -------------------------------------------------------------------------------------------------------- */

static void follows_commands(void)
{
    kelly_sight s;

    fixture_case(&run, 1000);
    kelly_draw_nominal(&run, &draw);
    EQUAL(kelly_plant_start_commanded(plant, &kelly_string, &run, &draw, R(8.0)), KELLY_OK);
    kelly_plant_look(plant, &s);
    CHECK(s.top_speed == R(8.0));
    kelly_plant_command(plant, R(10.0), R(120000.0), 100);
    kelly_plant_look(plant, &s);
    CLOSE((wide)s.f_bit, W(-119500.0), W(0.05));           /* the weight at once */
    CHECK(s.top_speed == R(8.0));
    kelly_plant_advance(plant, 50);
    kelly_plant_look(plant, &s);
    CLOSE((wide)s.top_speed, 9, BY_REAL(1e-5, 1e-12));     /* half-way up the ramp */
    kelly_plant_advance(plant, 50);
    kelly_plant_look(plant, &s);
    CLOSE((wide)s.top_speed, 10, BY_REAL(2e-6, 1e-14));
    kelly_plant_advance(plant, 50);
    kelly_plant_command(plant, R(-1.0), R(1000.0), 1);     /* backwards, and the rock lets go */
    kelly_plant_advance(plant, 7);
    kelly_plant_look(plant, &s);
    CLOSE((wide)s.top_speed, -1, BY_REAL(2e-6, 1e-14));
    CHECK(s.f_bit == 0 && s.bit_torque == 0);
    CHECK(kelly_plant_sane(plant));
}

/* sin(theta_top): an integer phase where the speed stands still, so that hours make no difference. */
static void counts_turns_exactly(void)
{
    kelly_sight s;

    fixture_case(&run, 1000);
    kelly_draw_nominal(&run, &draw);
    EQUAL(kelly_plant_start_commanded(plant, &kelly_string, &run, &draw, R(4.0)), KELLY_OK);
    kelly_plant_command(plant, R(6.0), R(100000.0), 200);  /* 0.2 s at 5 rad/s on the average */
    kelly_plant_advance(plant, BY_LENGTH(1200, 6200));
    kelly_plant_look(plant, &s);
    CLOSE((wide)s.f_bit, W(50000.0) * (textbook_sin(W(1.0) + W(0.001) * W(6.0) * (wide)BY_LENGTH(1000, 6000)) + W(0.01)) - W(100000.0),
          BY_REAL(2.0, 1e-5));
}

/* Sine and cosine between two settings by the phase, at a turn close to the longest: a term of either series that is off would add up. */
static void turns_by_the_series(void)
{
    const uint32_t steps = 60;
    const kelly_driven_lane *const on = &plant->driven.lane[0];
    const wide angle = W(0.24) * (wide)steps;

    fixture_case(&run, 1000);
    kelly_draw_nominal(&run, &draw);
    EQUAL(kelly_plant_start_commanded(plant, &kelly_string, &run, &draw, R(240.0)), KELLY_OK);
    kelly_plant_advance(plant, steps);
    CLOSE((wide)on->sine, textbook_sin(angle), BY_REAL(1e-5, 1e-9));
    CLOSE((wide)on->cosine, textbook_cos(angle), BY_REAL(1e-5, 1e-9));
}

static void only_what_is_commanded_obeys(void)
{
    kelly_sight before, after;

    soft_case(1000);
    EQUAL(kelly_plant_start(plant, &kelly_string, &run, &draw), KELLY_OK);
    kelly_plant_look(plant, &before);
    kelly_plant_command(plant, R(1.0), R(1.0), 1);
    kelly_plant_look(plant, &after);
    CHECK(before.f_bit == after.f_bit && before.top_speed == after.top_speed && before.surface_torque == after.surface_torque);
    EQUAL(kelly_plant_start_commanded(plant, &kelly_string, &run, &draw, R(10.0)), KELLY_OK);
    kelly_plant_look(plant, &before);
    kelly_plant_command(plant, R(1.0), R(1.0), 0);         /* a command of no time is none */
    kelly_plant_look(plant, &after);
    CHECK(before.f_bit == after.f_bit && before.top_speed == after.top_speed && plant->target == R(10.0));
}

static void says_what_it_allows(void)
{
    fixture_case(&run, 1000);
    kelly_draw_nominal(&run, &draw);
    EQUAL(kelly_plant_start_commanded(plant, &kelly_string, &run, &draw, R(10.0)), KELLY_OK);
    CHECK(kelly_plant_allows(plant, 0, R(1.0)) && kelly_plant_allows(plant, R(-249.0), R(400000.0)));
    CHECK(!kelly_plant_allows(plant, R(251.0), R(100000.0)));       /* more than a quarter of a radian a step */
    CHECK(!kelly_plant_allows(plant, R(10.0), R(600000.0)));        /* the rock's rate at 1 ms */
    CHECK(!kelly_plant_allows(plant, R(10.0), 0) && !kelly_plant_allows(plant, R(10.0), R(-5.0)));
    EQUAL(kelly_plant_start_commanded(plant, &kelly_string, &run, &draw, R(251.0)), KELLY_STEP);
}

/* ---- limits ---------------------------------------------------------------------------------------------------------- */

/* Largest distance of the bit speed and of the surface torque from those of the stiff top, at a few ticks. */
#define LOOKS 6
static void compare_with_stiff(wide within_speed, wide within_torque)
{
    const uint32_t every = BY_LENGTH(50, 1000);
    real speed[LOOKS], torque[LOOKS], axial[LOOKS];
    kelly_sight s;

    for (unsigned k = 0; k < LOOKS; k++) {
        kelly_plant_look(plant, &s);
        speed[k] = s.bit_speed;
        torque[k] = s.surface_torque;
        axial[k] = s.axial_speed;
        kelly_plant_advance(plant, every);
    }
    run.drive = (kelly_drive){ .inertia = 0 };
    EQUAL(kelly_plant_start(plant, &kelly_string, &run, &draw), KELLY_OK);
    for (unsigned k = 0; k < LOOKS; k++) {
        kelly_plant_look(plant, &s);
        CLOSE((wide)speed[k], (wide)s.bit_speed, within_speed);
        CLOSE((wide)torque[k], (wide)s.surface_torque, within_torque);
        CLOSE((wide)axial[k], (wide)s.axial_speed, within_speed);
        kelly_plant_advance(plant, every);
    }
}

static void ends_at_the_stiff_top(int rotating)
{
    soft_case(20000);
    run.rotating = (uint8_t)rotating;
    EQUAL(kelly_plant_start_commanded(plant, &kelly_string, &run, &draw, draw.w0), KELLY_OK);
    compare_with_stiff(BY_REAL(2e-3, 1e-9), BY_REAL(3.0, 1e-6));
    soft_case(20000);
    run.rotating = (uint8_t)rotating;
    run.drive = (kelly_drive){ .inertia = R(1e9), .impedance = R(1e7), .hz = R(0.1) };
    EQUAL(kelly_plant_start(plant, &kelly_string, &run, &draw), KELLY_OK);
    compare_with_stiff(BY_REAL(5e-3, 2e-3), BY_REAL(10.0, 5.0));
}

/* At the longest step that kelly_realise takes nothing grows, whatever the drive; a fifth more is refused. */
static void is_stable_where_accepted(real inertia, real impedance, real hz)
{
    kelly_modes modes;
    real longest;

    soft_case(4000);
    run.drive = (kelly_drive){ .inertia = inertia, .impedance = impedance, .hz = hz };
    EQUAL(kelly_realise(&kelly_string, &run, &draw, &modes) == KELLY_RANGE, 0);
    longest = kelly_largest_step(&kelly_string, &run, &draw, &modes);
    run.step_ns = (uint32_t)(int32_t)(longest * R(0.999e9));
    EQUAL(kelly_plant_start(plant, &kelly_string, &run, &draw), KELLY_OK);
    kelly_plant_advance(plant, BY_LENGTH(200, 4000));
    CHECK(kelly_plant_sane(plant));
    CHECK(kelly_driven_top_speed(&plant->driven, 0) < R(200.0));
    run.step_ns = (uint32_t)(int32_t)(longest * R(1.2e9));
    EQUAL(kelly_plant_start(plant, &kelly_string, &run, &draw), KELLY_STEP);
}

/* With one mode the bounds can be had from the 2 x 2 mass matrix of mode and top itself. */
static void bounds_are_those_of_mode_and_rotor(void)
{
    const wide total = W(5.0) + (wide)kelly_string.inertia, ki = W(39.47841760435743) * W(5.0);   /* (2 pi)^2 J_d */
    kelly_modes modes;
    wide b, d, w2, rotor, rate;

    soft_case(1000);
    run.torsional = 1;
    run.drive = (kelly_drive){ .inertia = R(5.0), .impedance = R(3.0), .hz = R(1.0) };
    EQUAL(kelly_realise(&kelly_string, &run, &draw, &modes), KELLY_OK);
    b = (wide)modes.b[0];
    d = (wide)modes.d[0];
    w2 = (wide)modes.w2[0];
    rotor = total - d * d;
    rate = W(0.04) * W(150000.0) * W(3.0) * (b * b * total - 2 * b * d + 1) / rotor + W(8e-5) * w2 * total / rotor + W(12.0) / rotor;
    CLOSE((wide)kelly_fastest_rate(&kelly_string, &run, &draw, &modes, draw.fc) / rate, 1, BY_REAL(1e-4, 1e-9));
    draw.mu = R(1e-9);
    draw.w0 = R(0.001);
    run.drive.impedance = R(0.001);
    CLOSE((wide)kelly_largest_step(&kelly_string, &run, &draw, &modes) * textbook_sqrt((w2 * total + ki) / rotor), W(2.8), BY_REAL(1e-3, 1e-5));
    run.drive.inertia = R(1.0);                            /* the lightest top turns a quarter of a radian a step, too */
    draw.w0 = R(2000.0);
    CLOSE((wide)kelly_largest_step(&kelly_string, &run, &draw, &modes) * W(2000.0), W(0.25), W(1e-6));
}

static void refuses_bad_drives(void)
{
    static const kelly_drive bad[] = {
        { R(0.5), R(289.0), R(0.2) }, { R(-1.0), R(289.0), R(0.2) }, { R(2900.0), 0, R(0.2) }, { R(2900.0), R(-1.0), R(0.2) },
        { R(2900.0), R(289.0), 0 }, { R(1e13), R(289.0), R(0.2) }, { R(2900.0), R(1e13), R(0.2) }, { R(2900.0), R(289.0), R(1e4) },
    };

    soft_case(1000);
    CHECK(kelly_case_error(&kelly_string, &run) == 0);
    for (unsigned k = 0; k < sizeof(bad) / sizeof(bad[0]); k++) {
        run.drive = bad[k];
        CHECK(kelly_case_error(&kelly_string, &run) != 0);
    }
    soft_case(1000);
    draw.w0 = R(260.0);                                    /* more than a quarter of a radian a step */
    EQUAL(kelly_plant_start(plant, &kelly_string, &run, &draw), KELLY_STEP);
    CLOSE((wide)kelly_largest_step(&kelly_string, &run, &draw, &plant->modes) * W(260.0), W(0.25), W(1e-6));
    run.drive.inertia = 0;
    EQUAL(kelly_plant_start(plant, &kelly_string, &run, &draw), KELLY_OK);
}

/* Every number of the state, spoilt alone: not a number, infinite, too large on either side. */
static void knows_the_insane(void)
{
    kelly_driven *const driven = &plant->driven;
    kelly_driven_lane *const on = &driven->lane[0];
    const real bad[] = { CHECK_NAN, CHECK_INFINITY, -CHECK_INFINITY, R(1e31), R(-1e31) };
    vreal *const place[] = { &on->lowest, &on->highest, &on->speed, &on->eta, &on->phi, &driven->mode[0][0].v, &driven->mode[0][0].x,
                             &driven->mode[0][9].v, &driven->mode[0][9].x };

    soft_case(100);
    EQUAL(kelly_plant_start(plant, &kelly_string, &run, &draw), KELLY_OK);
    for (unsigned p = 0; p < sizeof(place) / sizeof(place[0]); p++) {
        const vreal good = *place[p];

        CHECK(kelly_driven_sane(driven, 0));
        for (unsigned k = 0; k < sizeof(bad) / sizeof(bad[0]); k++) {
            *place[p] = bad[k];
            CHECK(!kelly_driven_sane(driven, 0));
        }
        *place[p] = good;
    }
    on->speed = R(999999.5);                               /* the bound is 1e6 rad/s */
    CHECK(kelly_driven_sane(driven, 0));
    on->speed = R(1e6);
    CHECK(!kelly_driven_sane(driven, 0));
}

/* Sine or cosine off theta_top is seen at once, and still known after the next exact evaluation has put it right. */
static void knows_an_angle_astray(void)
{
    kelly_driven *const driven = &plant->driven;
    vreal *const place[] = { &driven->lane[0].sine, &driven->lane[0].cosine };

    for (unsigned p = 0; p < 2; p++) {
        soft_case(4000);
        EQUAL(kelly_plant_start(plant, &kelly_string, &run, &draw), KELLY_OK);
        kelly_plant_advance(plant, KELLY_RESYNC);
        CHECK(!kelly_driven_strays(driven, 0) && kelly_driven_sane(driven, 0));
        *place[p] += R(0.01);
        CHECK(kelly_driven_strays(driven, 0) && !kelly_driven_sane(driven, 0));
        kelly_plant_advance(plant, 1);
        CHECK(!kelly_driven_strays(driven, 0) && driven->strayed[0] && !kelly_driven_sane(driven, 0));
    }
}

/* ---- bits ------------------------------------------------------------------------------------------------------------ */

static void plant_is_the_ensemble_realisation(void)
{
    real lowest, highest;

    soft_case(BY_LENGTH(200, 6000));
    run.cov[0] = run.cov[1] = run.cov[2] = run.cov[3] = run.cov[4] = 0.2f;
    kelly_draw_sample(&run, 3, 1000, &draw);
    EQUAL(kelly_plant_start(plant, &kelly_string, &run, &draw), KELLY_OK);
    kelly_plant_advance(plant, run.window_first);
    kelly_plant_watch(plant);
    for (uint32_t tick = run.window_first; tick < run.window_last; tick += 7) {
        kelly_plant_advance(plant, run.window_last - tick < 7 ? run.window_last - tick : 7);
    }
    kelly_plant_extremes(plant, &lowest, &highest);
    kelly_run(&kelly_string, &run, 3, 1000, 1, fixture.ensemble.results, &fixture.ensemble.work);
    EQUAL(fixture_bits(lowest), fixture_bits(fixture.ensemble.results[0].lowest));
    EQUAL(fixture_bits(highest), fixture_bits(fixture.ensemble.results[0].highest));
}

static void mean_is_that_of_the_bit(void)
{
    const uint32_t ticks = BY_LENGTH(200, 6000);
    const kelly_result *const result = fixture.ensemble.results;
    wide sum = 0;

    soft_case(ticks);
    EQUAL(kelly_plant_start(plant, &kelly_string, &run, &draw), KELLY_OK);
    kelly_plant_advance(plant, run.window_first);
    for (uint32_t tick = run.window_first; tick < run.window_last; tick++) {
        sum += W(0.5) * (wide)kelly_driven_speed(&plant->driven, 0);
        kelly_plant_advance(plant, 1);
        sum += W(0.5) * (wide)kelly_driven_speed(&plant->driven, 0);
    }
    kelly_run_draws(&kelly_string, &run, &draw, 1, fixture.ensemble.results, &fixture.ensemble.work);
    CLOSE((wide)result->mean, sum / (wide)(run.window_last - run.window_first), BY_REAL(2e-3, 1e-3));
}

static uint32_t add_real(uint32_t crc, real x)
{
    const uint64_t bits = fixture_bits(x);
    uint8_t bytes[8];

    for (unsigned k = 0; k < sizeof(real); k++) {
        bytes[k] = (uint8_t)(bits >> (8 * k));
    }
    return kelly_crc32c(crc, bytes, sizeof(real));
}

/* All that is seen of a commanded plant at each of 400 ticks, as host_drive.c and make_vectors.py have it. */
static void gives_the_bits_of_the_host(void)
{
    uint32_t crc = 0;
    kelly_sight s;

    fixture_case(&run, 400);
    kelly_draw_nominal(&run, &draw);
    EQUAL(kelly_plant_start_commanded(plant, &kelly_string, &run, &draw, R(10.0)), KELLY_OK);
    for (uint32_t tick = 0; tick <= 400; tick++) {
        if (tick == 50) {
            kelly_plant_command(plant, R(8.0), R(120000.0), 100);
        }
        if (tick == 200) {
            kelly_plant_command(plant, 0, R(90000.0), 1);
        }
        kelly_plant_look(plant, &s);
        crc = add_real(add_real(add_real(crc, s.bit_speed), s.bit_torque), s.f_bit);
        crc = add_real(add_real(add_real(crc, s.axial_speed), s.surface_torque), s.top_speed);
        kelly_plant_advance(plant, 1);
    }
    EQUAL(crc, DIGEST_COMMANDED);
}

static void ensemble_gives_the_bits_of_the_host(void)
{
    kelly_tally tally = { 0 };

    soft_case(200);
    run.cov[0] = run.cov[1] = run.cov[2] = run.cov[3] = run.cov[4] = 0.2f;
    kelly_run(&kelly_string, &run, 1, 0, 2, fixture.ensemble.results, &fixture.ensemble.work);
    kelly_tally_add(&tally, 0, &fixture.ensemble.results[0]);
    kelly_tally_add(&tally, 1, &fixture.ensemble.results[1]);
    EQUAL(tally.digest, DIGEST_SOFT);
}

void test_drive(void);
void test_drive(void)
{
    follows_commands();
    counts_turns_exactly();
    turns_by_the_series();
    only_what_is_commanded_obeys();
    says_what_it_allows();
    ends_at_the_stiff_top(0);
    ends_at_the_stiff_top(1);
    is_stable_where_accepted(R(2900.0), R(289.0), R(0.2));
    is_stable_where_accepted(R(1.0), R(1000.0), R(5.0));
    is_stable_where_accepted(R(20.0), R(1.0), R(10.0));
    bounds_are_those_of_mode_and_rotor();
    refuses_bad_drives();
    knows_the_insane();
    knows_an_angle_astray();
    plant_is_the_ensemble_realisation();
    mean_is_that_of_the_bit();
    gives_the_bits_of_the_host();
    ensemble_gives_the_bits_of_the_host();
}
