#include "textbook.h"

#include "../firmware/detmath.h"

/* Series where the exponential form would lose digits; cut at w^11, 9e-14 of the result. */
wide textbook_tanh(wide w)
{
    const wide u = w * w;

    if (u < W(0.01)) {
        return w * (1 - u * (W(1.0) / 3 - u * (W(2.0) / 15 - u * (W(17.0) / 315 - u * (W(62.0) / 2835)))));
    }
    return 1 - 2 / (kelly_exp(2 * w) + 1);
}

/* Newton's iteration from above; for the sizes met here 40 rounds are more than enough. */
wide textbook_sqrt(wide x)
{
    wide root = x > 1 ? x : 1;

    for (int i = 0; i < 40; i++) {
        root = W(0.5) * (root + x / root);
    }
    return root;
}

/* Reduced to |r| <= pi / 4, then Taylor's series to r^17. */
static wide quadrant_sine(wide r, int cosine)
{
    wide term = cosine ? 1 : r, sum = term;

    for (int k = cosine ? 2 : 3; k < 19; k += 2) {
        term *= -(r * r) / (wide)(k * (k - 1));
        sum += term;
    }
    return sum;
}

wide textbook_sin(wide angle)
{
    const int quarter = (int)(angle * W(0.63661977236758134308) + (angle < 0 ? W(-0.5) : W(0.5)));
    /* pi / 2 in two parts, so that the first product is exact in double for some thousand turns, in float for a few */
    const wide r = (angle - (wide)quarter * W(1.5703125)) - (wide)quarter * W(4.8382679489661923e-4);
    const wide side = quadrant_sine(r, quarter & 1);

    return quarter & 2 ? -side : side;
}

wide textbook_cos(wide angle)
{
    return textbook_sin(angle + W(1.57079632679489661923));
}

wide textbook_torque(wide w, wide f, wide mu, wide a1, wide a2)
{
    return mu * (f < 0 ? f : 0) * (textbook_tanh(w) + a1 * w / (1 + a2 * w * w));
}

void textbook_start(textbook *book, const kelly_table *table, const kelly_case *run, const kelly_draw *draw, const kelly_modes *modes)
{
    *book = (textbook){ .count = modes->count, .h = (wide)kelly_step_seconds(run), .alpha = (wide)table->alpha, .beta = (wide)table->beta,
                        .fc = (wide)draw->fc, .f0 = (wide)run->f0, .mu = (wide)draw->mu, .a1 = (wide)draw->a1, .a2 = (wide)draw->a2,
                        .w0 = (wide)draw->w0, .phase_step = kelly_phase_step(draw->w0, run->step_ns), .modes = modes };
    for (unsigned i = 0; i < modes->count; i++) {
        book->now.v[i] = run->rotating ? 0 : -(wide)modes->d[i] * book->w0;
    }
}

static wide bit_speed(const textbook *book, const wide v[KELLY_MODES_MAX])
{
    wide speed = book->w0;

    for (unsigned i = 0; i < book->count; i++) {
        speed += (wide)book->modes->b[i] * v[i];
    }
    return speed;
}

wide textbook_speed(const textbook *book)
{
    return bit_speed(book, book->now.v);
}

/* slope = right-hand side of (T) at state x, (W), (B), (F) at a phase of the top */
static void derive(textbook *book, const textbook_state *x, uint64_t phase)
{
    const wide f = book->f0 * ((wide)kelly_sin_turn(phase) + W(0.01)) - book->fc;
    const wide torque = textbook_torque(bit_speed(book, x->v), f, book->mu, book->a1, book->a2);

    for (unsigned i = 0; i < book->count; i++) {
        const wide w2 = (wide)book->modes->w2[i], b = (wide)book->modes->b[i], d = (wide)book->modes->d[i];

        book->slope.q[i] = x->v[i];
        book->slope.v[i] = b * torque - d * book->alpha * book->w0 - (book->alpha + book->beta * w2) * x->v[i] - w2 * x->q[i];
    }
}

/* sum += weight slope; trial = now + part slope */
static void stage(textbook *book, wide weight, wide part)
{
    for (unsigned i = 0; i < book->count; i++) {
        book->sum.q[i] += weight * book->slope.q[i];
        book->sum.v[i] += weight * book->slope.v[i];
        book->trial.q[i] = book->now.q[i] + part * book->slope.q[i];
        book->trial.v[i] = book->now.v[i] + part * book->slope.v[i];
    }
}

void textbook_step(textbook *book)
{
    const wide h = book->h;
    const uint64_t phase = book->phase_step * book->tick;

    book->sum = (textbook_state){ .q = { 0 } };
    derive(book, &book->now, phase);
    stage(book, 1, h / 2);
    derive(book, &book->trial, phase + book->phase_step / 2);
    stage(book, 2, h / 2);
    derive(book, &book->trial, phase + book->phase_step / 2);
    stage(book, 2, h);
    derive(book, &book->trial, phase + book->phase_step);
    stage(book, 1, 0);
    for (unsigned i = 0; i < book->count; i++) {
        book->now.q[i] += h / 6 * book->sum.q[i];
        book->now.v[i] += h / 6 * book->sum.v[i];
    }
    book->tick++;
}
