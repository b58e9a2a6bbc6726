/* test_energy.c - a top of variable speed: what the top puts in is what the bit, damping and storage take; a drive's rotor obeys (D).
 *
 *     T_top theta' + T_bit w_bit = d/dt [ J theta'^2 / 2 + theta' sum d q' + sum q'^2 / 2 + sum w^2 q^2 / 2 ]
 *                                  + alpha [ J theta'^2 + 2 theta' sum d q' + sum q'^2 ] + sum beta w^2 q'^2
 */
#include "check.h"
#include "fixture.h"

static kelly_case run;
static kelly_draw draw;
static kelly_plant *const plant = &fixture.plant;

static void soft_case(uint32_t ticks)
{
    fixture_case(&run, ticks);
    run.drive = (kelly_drive){ .inertia = R(2900.0), .impedance = R(289.0), .hz = R(0.2) };
    kelly_draw_nominal(&run, &draw);
}

/* Powers of the top, of the bit and of damping [W] at one instant, and the energy stored [J]. */
typedef struct {
    wide top, bit, damping, stored;
} energy;

static void measure(energy *e)
{
    const kelly_table *const t = plant->table;
    real q[KELLY_MODES_MAX], v[KELLY_MODES_MAX];
    wide speed, kinetic = 0, spring = 0, viscous = 0, momentum;
    kelly_sight sight;

    kelly_plant_look(plant, &sight);
    kelly_plant_modal(plant, q, v);
    speed = (wide)sight.top_speed;
    momentum = (wide)t->inertia * speed;
    for (unsigned i = 0; i < plant->modes.count; i++) {
        const wide qi = (wide)q[i], vi = (wide)v[i], w2 = (wide)plant->modes.w2[i], d = (wide)plant->modes.d[i];

        momentum += d * vi;
        kinetic += d * vi * speed + vi * vi;
        spring += w2 * qi * qi;
        viscous += (wide)t->beta * w2 * vi * vi;
    }
    kinetic += speed * momentum;
    e->top = (wide)sight.surface_torque * speed;
    e->bit = (wide)sight.bit_torque * (wide)sight.bit_speed;
    e->damping = (wide)t->alpha * kinetic + viscous;
    e->stored = W(0.5) * (kinetic + spring);
}

/* Work of a stretch of an even number of ticks by Simpson's rule, added to `sum`. Commands lie between stretches. */
static void follow(energy *sum, uint32_t ticks)
{
    const wide third = (wide)run.step_ns / W(3e9);
    energy now;

    for (uint32_t k = 0; k <= ticks; k++) {
        const wide weight = k == 0 || k == ticks ? third : k % 2 == 1 ? 4 * third : 2 * third;

        measure(&now);
        sum->top += weight * now.top;
        sum->bit += weight * now.bit;
        sum->damping += weight * now.damping;
        if (k < ticks) {
            kelly_plant_advance(plant, 1);
        }
    }
}

static void closes(const energy *first, const energy *sum, wide within)
{
    energy last;

    measure(&last);
    CHECK(sum->bit < 0 && sum->damping > 0 && sum->top != 0);
    CLOSE((sum->top + sum->bit - sum->damping - (last.stored - first->stored)) / sum->top, 0, within);
}

/* Float: sums of many rounded powers. Double: Simpson and RK4, both of fourth order, at 0.1 ms. */
static void soft_drive_keeps_energy(real mu)
{
    energy first, sum = { 0 };

    soft_case(200000);
    run.step_ns = 100000;
    draw.mu = mu;
    EQUAL(kelly_plant_start(plant, &kelly_string, &run, &draw), KELLY_OK);
    kelly_plant_advance(plant, 100);   /* past the first layer at the bit, where the torque falls off within 2 ms */
    measure(&first);
    follow(&sum, BY_LENGTH(600, 100000));
    closes(&first, &sum, BY_REAL(3e-3, 1e-6));
}

static void commanded_top_keeps_energy(void)
{
    energy first, sum = { 0 };

    fixture_case(&run, 200000);
    run.step_ns = 100000;
    kelly_draw_nominal(&run, &draw);
    EQUAL(kelly_plant_start_commanded(plant, &kelly_string, &run, &draw, R(8.0)), KELLY_OK);
    kelly_plant_advance(plant, 100);
    measure(&first);
    kelly_plant_command(plant, R(14.0), R(80000.0), BY_LENGTH(400, 20000));
    follow(&sum, BY_LENGTH(400, 20000));
    follow(&sum, BY_LENGTH(100, 20000));
    kelly_plant_command(plant, R(5.0), R(110000.0), BY_LENGTH(200, 30000));
    follow(&sum, BY_LENGTH(200, 30000));
    follow(&sum, BY_LENGTH(100, 30000));
    /* the torque jumps where a ramp ends: steep ones cost Simpson's rule a third of a tick of the jump */
    closes(&first, &sum, BY_REAL(3e-3, BY_LENGTH(2e-5, 1e-6)));
}

/* (D), integrated: the rotor's momentum is what spring, damper and string give it. phi and its integral by Simpson's rule and
 * the trapezoid from the speed that is seen. */
static void rotor_obeys_its_drive(void)
{
    const uint32_t ticks = BY_LENGTH(400, 8000);
    const wide h = W(0.001), ki = W(1.5791367041742974) * W(2900.0);   /* (2 pi 0.2)^2 J_d */
    wide eta0, eta = 0, phi = 0, angle = 0, torque = 0;
    kelly_sight s;

    soft_case(10000);
    EQUAL(kelly_plant_start(plant, &kelly_string, &run, &draw), KELLY_OK);
    kelly_plant_look(plant, &s);
    eta0 = (wide)s.top_speed - (wide)draw.w0;
    for (uint32_t k = 0; k < ticks; k++) {
        const wide before = (wide)s.surface_torque, last = eta;

        kelly_plant_advance(plant, 1);
        kelly_plant_look(plant, &s);
        eta = (wide)s.top_speed - (wide)draw.w0;
        torque += W(0.5) * h * (before + (wide)s.surface_torque);
        angle += h * (phi + W(0.25) * h * (last + eta));
        phi += W(0.5) * h * (last + eta);
    }
    CHECK(fixture_abs(phi) > W(0.005));
    CLOSE((W(2900.0) * (eta - eta0) + W(4.0) * W(289.0) * phi + ki * angle + torque) / torque, 0, BY_REAL(1e-4, 2e-5));
}

void test_energy(void);
void test_energy(void)
{
    soft_drive_keeps_energy(R(0.04));
    soft_drive_keeps_energy(R(0.004));
    commanded_top_keeps_energy();
    rotor_obeys_its_drive();
}
