/* test_bitrock.c - the torque of the rock, (B), against tanh itself. */
#include "../firmware/bitrock.h"
#include "check.h"
#include "fixture.h"

/* Speeds from 1e-6 to 40 rad/s, both the linear part and the far end. */
#define POINTS 60
static real speed_at(int k)
{
    return (real)kelly_exp(W(-13.8) + W(17.5) * (wide)k / (wide)(POINTS - 1));
}

static void equals_the_formula(real a1, real a2)
{
    const real muf = R(-4000.0);
    wide worst = 0;

    for (int k = 0; k < POINTS; k++) {
        const real w = speed_at(k);
        const wide want = textbook_torque((wide)w, (wide)muf, 1, (wide)a1, (wide)a2);
        const wide away = fixture_abs((wide)kelly_bit_torque(w, muf, a1, a2) / want - 1);

        worst = away > worst ? away : worst;
    }
    CLOSE(worst, 0, BY_REAL(7e-7, 8e-13));
}

static void is_odd_and_resists(void)
{
    int odd = 1, resists = 1;

    for (int k = 0; k < POINTS; k++) {
        const real w = speed_at(k), t = kelly_bit_torque(w, R(-4000.0), R(2.0), R(1.0));

        odd &= kelly_bit_torque(-w, R(-4000.0), R(2.0), R(1.0)) == -t;
        resists &= t < 0;
    }
    CHECK(odd);
    CHECK(resists);
    CHECK(kelly_bit_torque(R(0.0), R(-4000.0), R(2.0), R(1.0)) == 0);
    CHECK(kelly_bit_torque(R(3.0), R(0.0), R(2.0), R(1.0)) == 0);   /* lifted off: no torque */
}

/* |T| <= mu |f| (1 + a1 / (2 sqrt(a2))); the bound itself is never passed, also far outside of what a bit does. */
static void is_bounded(void)
{
    const real bound = R(4000.0) * (R(1.0) + R(3.0) / (R(2.0) * R(1.5))) * R(1.000001);
    const volatile real far = R(1e9);
    int bounded = 1;

    for (int k = 0; k < POINTS; k++) {
        bounded &= kelly_bit_torque(speed_at(k), R(-4000.0), R(3.0), R(2.25)) >= -bound;
    }
    CHECK(bounded);
    CLOSE((wide)kelly_bit_torque(far, R(-4000.0), R(3.0), R(2.25)), W(-4000.0), W(0.01));
}

/* Slope at 0: mu f (1 + a1), the fastest rate of the system. */
static void has_its_slope(void)
{
    const real w = R(1e-3);

    CLOSE((wide)kelly_bit_torque(w, R(-4000.0), R(2.0), R(1.0)) / (wide)w, W(-12000.0), W(0.05));
    CLOSE((wide)kelly_bit_torque(w, R(-4000.0), R(0.5), R(1.0)) / (wide)w, W(-6000.0), W(0.05));
}

void test_bitrock(void);
void test_bitrock(void)
{
    equals_the_formula(R(2.0), R(1.0));
    equals_the_formula(R(0.7), R(3.1));
    is_odd_and_resists();
    is_bounded();
    has_its_slope();
}
