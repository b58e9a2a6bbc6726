/* test_axial.c - axial motion against its analytic solution: linear, so nothing is left to chance. */
#include "../firmware/axial.h"
#include "check.h"
#include "fixture.h"

static kelly_case run;
static kelly_draw draw;

/* Speed of p'' + c p' + w^2 p = b f0 (sin(W t) + 0.01) from rest. Steady part S sin + C cos + 0.01 b f0 / w^2. */
static wide elastic_speed(wide w2, wide c, wide force, wide W0, wide t)
{
    const wide stiff = w2 - W0 * W0, drag = c * W0, over = force / (stiff * stiff + drag * drag);
    const wide S = over * stiff, C = -over * drag, p0 = -(C + W(0.01) * force / w2), v0 = -S * W0;
    const wide wd = textbook_sqrt(w2 - c * c / 4), decay = kelly_exp(-c * t / 2);
    const wide steady = W0 * (S * textbook_cos(W0 * t) - C * textbook_sin(W0 * t));

    return steady + decay * (v0 * textbook_cos(wd * t) - (w2 * p0 + c * v0 / 2) / wd * textbook_sin(wd * t));
}

/* The rigid mode: b f0 ((1 - cos W t) / W + 0.01 t); 1 - cos by the half angle. */
static wide rigid_speed(wide force, wide W0, wide t)
{
    const wide half = textbook_sin(W0 * t / 2);

    return force * (2 * half * half / W0 + W(0.01) * t);
}

static wide analytic(const kelly_axial *axial, wide t)
{
    const wide W0 = (wide)draw.w0, f0 = (wide)run.f0, b0 = (wide)axial->b[0];
    wide speed = b0 * rigid_speed(b0 * f0, W0, t);

    for (unsigned j = 1; j < axial->count; j++) {
        const wide w2 = (wide)axial->w2[j], b = (wide)axial->b[j];

        speed += b * elastic_speed(w2, (wide)kelly_string.alpha + (wide)kelly_string.beta * w2, b * f0, W0, t);
    }
    return speed;
}

static void follows_the_solution(real w0, unsigned count, wide within)
{
    kelly_axial *const axial = &fixture.plant.axial;
    const uint32_t ticks = BY_LENGTH(300, 20000);
    wide largest = 0;

    fixture_case(&run, ticks);
    run.axial = (uint8_t)count;
    kelly_draw_nominal(&run, &draw);
    draw.w0 = w0;
    CHECK(kelly_axial_start(axial, &kelly_string, &run, &draw) == KELLY_OK);
    CHECK(kelly_axial_speed(axial) == 0);
    for (uint32_t tick = 0; tick < ticks; tick++) {
        kelly_axial_step(axial, tick);
        if ((tick + 1) % (ticks / 10) == 0) {
            const wide want = analytic(axial, (wide)(tick + 1) * W(0.001));

            CLOSE((wide)kelly_axial_speed(axial), want, within);
            largest = fixture_abs(want) > largest ? fixture_abs(want) : largest;
        }
    }
    CHECK(largest > W(0.05));                              /* [m/s]: there is something to compare */
}

static void refuses_other_weights(void)
{
    fixture_case(&run, 10);
    kelly_draw_nominal(&run, &draw);
    draw.fc = R(2e6);
    CHECK(kelly_axial_start(&fixture.plant.axial, &kelly_string, &run, &draw) == KELLY_RANGE);
    CHECK(kelly_axial_largest_step(&kelly_string, &run, &draw) == 0);
}

/* A step just within the bound starts, one just beyond does not. */
static void step_is_bounded_by(const kelly_table *table, wide bound)
{
    const wide largest = (wide)kelly_axial_largest_step(table, &run, &draw);

    CLOSE(largest / bound, 1, W(1e-5));
    run.step_ns = (uint32_t)(largest * W(0.999e6)) * 1000u;
    CHECK(kelly_axial_start(&fixture.plant.axial, table, &run, &draw) == KELLY_OK);
    run.step_ns = (uint32_t)(largest * W(1.001e6)) * 1000u;
    CHECK(kelly_axial_start(&fixture.plant.axial, table, &run, &draw) == KELLY_STEP);
}

/* RK4 on the real axis to 2.785, on the imaginary one to 2.8: the fastest mode by its frequency, or by its damping where that is strong. */
static void refuses_steps_of_unstable_modes(void)
{
    kelly_table strong = kelly_string;
    kelly_axial *const axial = &fixture.plant.axial;

    fixture_case(&run, 10);
    run.axial = 5;
    kelly_draw_nominal(&run, &draw);
    CHECK(kelly_axial_start(axial, &kelly_string, &run, &draw) == KELLY_OK);
    step_is_bounded_by(&kelly_string, W(2.8) / textbook_sqrt((wide)axial->w2[4]));
    strong.beta = R(1.0);
    run.step_ns = 1000;
    CHECK(kelly_axial_start(axial, &strong, &run, &draw) == KELLY_OK);
    step_is_bounded_by(&strong, W(2.785) / (W(0.1) + (wide)axial->w2[4]));
}

static void no_force_no_motion(void)
{
    fixture_case(&run, 10);
    run.f0 = 0;
    kelly_draw_nominal(&run, &draw);
    CHECK(kelly_axial_start(&fixture.plant.axial, &kelly_string, &run, &draw) == KELLY_OK);
    for (uint32_t tick = 0; tick < 10; tick++) {
        kelly_axial_step(&fixture.plant.axial, tick);
    }
    CHECK(kelly_axial_speed(&fixture.plant.axial) == 0);
}

void test_axial(void);
void test_axial(void)
{
    follows_the_solution(R(10.471975512), 2, BY_LENGTH(BY_REAL(5e-6, 1e-9), BY_REAL(5e-5, 5e-9)));
    follows_the_solution(R(5.0), 1, BY_LENGTH(BY_REAL(5e-6, 1e-9), BY_REAL(5e-5, 5e-9)));
    follows_the_solution(R(13.0), 5, BY_LENGTH(BY_REAL(5e-6, 2e-8), BY_REAL(5e-5, 5e-8)));
    refuses_other_weights();
    refuses_steps_of_unstable_modes();
    no_force_no_motion();
}
