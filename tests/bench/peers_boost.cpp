/* peers_boost.cpp - Boost.odeint with its fastest state type, std::array.
 *
 * What limits dopri5 here is stability (stuck bit: 771 1/s, its bound 3.3: 4.3 ms), so its fastest setting is a longest step and hardly
 * any error control. bench --scan dopri5 shows how settings were found. */
#include <array>
#include <boost/numeric/odeint.hpp>

#define BENCH_RHS
#include "bench.h"

namespace odeint = boost::numeric::odeint;

typedef std::array<double, 2 * MODES> state;
typedef odeint::runge_kutta4<state, double, state, double, odeint::array_algebra> rk4;
typedef odeint::runge_kutta_dopri5<state, double, state, double, odeint::array_algebra> dopri5;

static void fixed(const problem *p, const setting *set, observer *o)
{
    const problem copy = *p;
    const long n = (long)(SECONDS / set->h + 0.5);
    const auto derive = [&copy](const state &y, state &dy, double t) { rhs(&copy, t, y.data(), dy.data()); };
    rk4 stepper;
    state y;

    start(p, y.data());
    observe(o, 0, speed_of(&copy, y.data()));
    for (long j = 0; j < n; j++) {
        stepper.do_step(derive, y, (double)j * set->h, set->h);
        observe(o, (double)(j + 1) * set->h, speed_of(&copy, y.data()));
    }
}

static void adaptive(const problem *p, const setting *set, observer *o)
{
    const problem copy = *p;
    const auto derive = [&copy](const state &y, state &dy, double t) { rhs(&copy, t, y.data(), dy.data()); };
    auto stepper = odeint::make_controlled(set->atol, set->rtol, set->h, dopri5());
    state y;
    double t = 0, h = 1e-4;

    start(p, y.data());
    observe(o, 0, speed_of(&copy, y.data()));
    while (t < SECONDS) {
        h = t + h > SECONDS ? SECONDS - t : h;
        if (stepper.try_step(derive, y, t, h) == odeint::success) {
            observe(o, t, speed_of(&copy, y.data()));
        }
        if (h < 1e-12) {
            break;
        }
    }
}

extern "C" const peer NAME[] = {
    { "Boost.odeint runge_kutta4", FLAGS, { 1e-3, 0, 0 }, ERROR_LIMIT, 1, fixed },
    { "Boost.odeint dopri5", FLAGS, { 4.4e-3, 1e-4, 1e-4 }, ERROR_LIMIT, 1, adaptive },
    { "Boost.odeint dopri5, step not limited", FLAGS, { 1, 1.8e-7, 1.8e-5 }, ERROR_LIMIT, 1, adaptive },
    { 0, 0, { 0, 0, 0 }, 0, 0, 0 },
};
