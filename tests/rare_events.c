/* rare_events.c - see rare_events.h. */
#include "rare_events.h"

kelly_rare rare;
kelly_rare_sample samples[MOST];
uint32_t keys[MOST];
kelly_rare_estimate answer;
const kelly_rare_hint *advised;

const float normals[KELLY_PARAMETERS] = { 0.001f, 0.001f, 0.001f, 0.001f, 0.001f };
const float one_gamma[KELLY_PARAMETERS] = { 0.0f, 0.5f };

/* Grows like exp(1.2 x) over what is met. */
static float steep(float x)
{
    float y = x > -20.0f ? 1.0f + (x + 20.0f) / 32.0f : 1.0f;

    for (unsigned i = 0; i < 6; i++) {
        y *= y;
    }
    return y;
}

static float above(float x, float limit)
{
    return x > limit ? KELLY_RARE_FAILED : steep(x);
}

static float height(const float x[KELLY_PARAMETERS])
{
    return ((x[0] + x[1]) + (x[2] + x[3]) + x[4]) * 0.4472136f;
}

float plane(const kelly_rare_sample *s, float limit)
{
    return above(height(s->x), limit);
}

/* One gamma of shape 4, mean 4: P = exp(-y) (1 + y + y^2/2 + y^3/6). */
static float far_out(const kelly_rare_sample *s, float limit)
{
    return above(kelly_gamma_value(s->x[1], 4.0f, 0.5f), limit);
}

/* The first is 1.2 times the height. */
static const float along[KELLY_PARAMETERS] = { 0.5366563f, 0.5366563f, 0.5366563f, 0.5366563f, 0.5366563f };
static const float aside[KELLY_PARAMETERS] = { 0.9399773f, 0.3729754f, 0.3729754f, 0.3729754f, 0.3729754f };
static const float against[KELLY_PARAMETERS] = { -0.5366563f, -0.5366563f, -0.5366563f, -0.5366563f, -0.5366563f };
const kelly_rare_hint good = { .plane = along }, blurred = { .plane = aside }, wrong = { .plane = against };

static float guide(event what, const kelly_rare_sample *s, float limit)
{
    switch (what) {
    case FAR_OUT:
        return far_out(s, limit);
    case CORNER:                                           /* two regions, none of which sees the other */
        return above(s->x[0] > 0 ? s->x[0] : -s->x[0], limit);
    case ISLAND:
        return s->x[0] < -3.0f ? KELLY_RARE_FAILED : plane(s, limit);
    case FREEZE:                                           /* beyond the first level nothing is let in */
        return rare.level > 0 ? 0.0f : plane(s, limit);
    case FLAT:                                             /* no way up */
        return 1.0f;
    case REFUSE:
        return height(s->x) > 1.9f ? KELLY_RARE_REFUSED : plane(s, limit);
    case REFUSE_FAR:                                       /* only where the first level does not come */
        return rare.level > 0 && height(s->x) > 2.0f ? KELLY_RARE_REFUSED : plane(s, limit);
    default:
        return plane(s, limit);
    }
}

int simulate(event what, const float cov[KELLY_PARAMETERS], float limit, uint64_t seed, uint32_t n)
{
    CHECK(kelly_rare_start(&rare, cov, seed, n, samples, keys) == 0);
    if (advised) {
        kelly_rare_lead(&rare, advised);
    }
    while (kelly_rare_count(&rare) > 0) {
        for (uint32_t i = rare.first; i < rare.first + rare.count; i++) {
            samples[i].guide = guide(what, &samples[i], limit);
        }
        kelly_rare_accept(&rare);
    }
    if (rare.state == KELLY_RARE_DONE) {
        kelly_rare_read(&rare, &answer);
    }
    return rare.state == KELLY_RARE_DONE;
}
