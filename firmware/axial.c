#include "axial.h"

#include "detmath.h"
#include "seal.h"

/* Of the modes in use, and of none beyond, where a fault has changed their number. */
static size_t bytes_of(const kelly_axial *axial)
{
    return (axial->count < KELLY_MODES_MAX ? axial->count : KELLY_MODES_MAX) * sizeof(real);
}

/* Of the state. */
static uint32_t seal_of(const kelly_axial *axial)
{
    return kelly_seal(kelly_seal(0, axial->p, bytes_of(axial)), axial->v, bytes_of(axial));
}

uint32_t kelly_axial_seal(uint32_t seal, const kelly_axial *axial)
{
    seal = KELLY_SEAL_MEMBERS(seal, axial, kelly_axial, h, f0);
    seal = kelly_seal(seal, &axial->count, sizeof(axial->count));
    seal = kelly_seal(seal, &axial->phase_step, sizeof(axial->phase_step));
    seal = kelly_seal(seal, axial->w2, bytes_of(axial));
    seal = kelly_seal(seal, axial->c, bytes_of(axial));
    return kelly_seal(seal, axial->b, bytes_of(axial));
}

real kelly_axial_largest_step(const kelly_table *table, const kelly_case *run, const kelly_draw *draw)
{
    real w2[KELLY_MODES_MAX], b[KELLY_MODES_MAX], largest = R(1e3);

    if (!kelly_axial_modes_at(table, draw->fc, run->axial, w2, b)) {
        return 0;
    }
    for (unsigned j = 1; j < run->axial; j++) {
        const real damped = KELLY_REAL_AXIS / (table->alpha + table->beta * w2[j]);
        const real swinging = KELLY_IMAGINARY_AXIS * R(0.999999) / (real)kelly_sqrt32((float)w2[j]);

        largest = damped < largest ? damped : largest;
        largest = swinging < largest ? swinging : largest;
    }
    return largest;
}

kelly_status kelly_axial_start(kelly_axial *axial, const kelly_table *table, const kelly_case *run, const kelly_draw *draw)
{
    if (!kelly_axial_modes_at(table, draw->fc, run->axial, axial->w2, axial->b)) {
        return KELLY_RANGE;
    }
    if (kelly_step_seconds(run) > kelly_axial_largest_step(table, run, draw)) {
        return KELLY_STEP;
    }
    axial->count = run->axial;
    axial->h = kelly_step_seconds(run);
    axial->f0 = run->f0;
    axial->phase_step = kelly_phase_step(draw->w0, run->step_ns);
    for (unsigned j = 0; j < axial->count; j++) {
        axial->c[j] = j == 0 ? 0 : table->alpha + table->beta * axial->w2[j];
        axial->p[j] = 0;
        axial->v[j] = 0;
    }
    axial->seal = 0;                        /* that of zeros */
    axial->touched = 0;
    return KELLY_OK;
}

int kelly_axial_untouched(const kelly_axial *axial)
{
    return !axial->touched && seal_of(axial) == axial->seal;
}

/* Force f_a [N] at a phase of the top. */
static real force(const kelly_axial *axial, uint64_t phase)
{
    return axial->f0 * (kelly_sin_turn(phase) + R(0.01));
}

static real acceleration(const kelly_axial *axial, unsigned j, real f, real p, real v)
{
    return axial->b[j] * f - axial->c[j] * v - axial->w2[j] * p;
}

void kelly_axial_push(kelly_axial *axial, const real f[4])
{
    const real h = axial->h, half = R(0.5) * h;

    if (!kelly_axial_untouched(axial)) {
        axial->touched = 1;
    }
    for (unsigned j = 0; j < axial->count && j < KELLY_MODES_MAX; j++) {
        const real p = axial->p[j], v = axial->v[j];
        const real a1 = acceleration(axial, j, f[0], p, v), v2 = v + half * a1;
        const real a2 = acceleration(axial, j, f[1], p + half * v, v2), v3 = v + half * a2;
        const real a3 = acceleration(axial, j, f[2], p + half * v2, v3), v4 = v + h * a3;
        const real a4 = acceleration(axial, j, f[3], p + h * v3, v4);

        axial->p[j] = p + h / R(6.0) * ((v + v4) + 2 * (v2 + v3));
        axial->v[j] = v + h / R(6.0) * ((a1 + a4) + 2 * (a2 + a3));
    }
    axial->seal = seal_of(axial);
}

void kelly_axial_step(kelly_axial *axial, uint32_t tick)
{
    const uint64_t phase = axial->phase_step * tick;
    const real middle = force(axial, phase + axial->phase_step / 2);
    const real f[4] = { force(axial, phase), middle, middle, force(axial, phase + axial->phase_step) };

    kelly_axial_push(axial, f);
}

real kelly_axial_speed(const kelly_axial *axial)
{
    real speed = 0;

    for (unsigned j = 0; j < axial->count && j < KELLY_MODES_MAX; j++) {
        speed += axial->b[j] * axial->v[j];
    }
    return speed;
}
