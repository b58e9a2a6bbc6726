/* test_trajectories.c - whole runs against gen/reference.py, which shares no code and no table with the kernel: dense
 * matrices, LAPACK's modes at the very weight of the case, textbook RK4 in double at the same step, libm.
 *
 * In float the distance grows with time, as rounding does; the bounds are by the age of the run.
 */
#include "check.h"
#include "fixture.h"
#include "vectors/trajectories.h"

/* Bounds [rad/s] of the bit speed at tick k; other quantities in proportion. */
static wide bound(uint32_t tick)
{
    if (sizeof(real) > sizeof(float)) {
        return tick <= 500 ? W(5e-11) : tick <= 5000 ? W(1e-9) : W(2e-9);
    }
    return tick <= 500 ? W(5e-5) : W(3e-4);
}

static void compare(const kelly_plant *plant, const vector_point *want)
{
    const wide within = bound(want->tick);
    kelly_sight sight;

    kelly_plant_look(plant, &sight);
    CLOSE((wide)sight.bit_speed, (wide)want->bit_speed, within);
    CLOSE((wide)sight.f_bit, (wide)want->f_bit, BY_REAL(0.1, 1e-8));
    CLOSE((wide)sight.bit_torque, (wide)want->bit_torque, W(6000.0) * within + BY_REAL(0.1, 1e-8));
    CLOSE((wide)sight.axial_speed, (wide)want->axial_speed, BY_REAL(5e-5, 2e-11));
    CLOSE((wide)sight.surface_torque, (wide)want->surface_torque, W(1000.0) * within + BY_REAL(0.2, 1e-7));
}

static void follow(const vector_run *vector)
{
    kelly_plant *const plant = &fixture.plant;
    uint32_t tick = 0;
    kelly_case run;
    kelly_draw draw;

    fixture_case(&run, 100000);
    run.rotating = vector->rotating;
    kelly_draw_nominal(&run, &draw);
    draw.fc = vector->fc;
    draw.mu = vector->mu;
    draw.a1 = vector->a1;
    draw.a2 = vector->a2;
    draw.w0 = vector->w0;
    EQUAL(kelly_plant_start(plant, &kelly_string, &run, &draw), KELLY_OK);
    for (unsigned k = 0; k < VECTOR_POINTS && vector->point[k].tick <= BY_LENGTH(1000u, 100000u); k++) {
        kelly_plant_advance(plant, vector->point[k].tick - tick);
        tick = vector->point[k].tick;
        compare(plant, &vector->point[k]);
    }
}

void test_trajectories(void);
void test_trajectories(void)
{
    for (unsigned k = 0; k < VECTOR_RUNS; k++) {
        follow(&vector_runs[k]);
    }
}
