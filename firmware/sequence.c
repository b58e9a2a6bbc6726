#include "sequence.h"

#include "detmath.h"

#define HALVINGS 28              /* of 0..k/n: below the last place of a float */

/* x ln(x / m) + m - x >= 0 for x = k, m > 0: see interval.c; here in float, whatever the build. */
static float deviance(uint32_t k, float m)
{
    if (k == 0) {
        return m;
    }
    const float x = (float)k, t = (x - m) / (x + m);
    if (t > 0.2f || t < -0.2f) {
        return x * kelly_log32(x / m) + m - x;
    }
    const float t2 = t * t;
    return (x - m) * t + 2.0f * x * t * t2 * (0x1.555556p-2f + t2 * (0.2f + t2 * (0x1.24924ap-3f + t2 * 0x1.c71c72p-4f)));
}

/* c of the header. */
static float beyond_stirling(uint32_t k)
{
    return k > 0 ? 1.0f / (24.0f * (float)k) : 0x1.62e43p-2f;     /* ln(2) / 2 */
}

/* What n KL(k/n, p) must stay below, n >= 1. */
static float bound(uint32_t k, uint32_t n, float alpha)
{
    return 0.5f * kelly_log32(0x1.921fb6p+0f * (float)n) - kelly_log32(alpha)
           + (1.0f / (12.0f * (float)n) + beyond_stirling(k) + beyond_stirling(n - k));
}

/* n KL(k/n, p) falls from infinity at p = 0 to 0 at p = k/n. */
float kelly_sequence_lo(uint32_t k, uint32_t n, float alpha)
{
    if (k == 0) {
        return 0.0f;
    }
    const float share = (float)k / (float)n, most = bound(k, n, alpha);
    float lo = 0.0f, hi = share < 1.0f ? share : 1.0f;

    for (int i = 0; i < HALVINGS; i++) {
        const float p = 0.5f * (lo + hi);

        if (p <= lo || p >= hi) {                  /* no float lies between */
            break;
        }
        if (deviance(k, (float)n * p) + deviance(n - k, (float)n * (1.0f - p)) < most) {
            hi = p;
        } else {
            lo = p;
        }
    }
    return lo;
}

float kelly_sequence_hi(uint32_t k, uint32_t n, float alpha)
{
    return 1.0f - kelly_sequence_lo(n - k, n, alpha);
}

kelly_stop kelly_sequence_look(const kelly_stop_rule *rule, const kelly_tally *tally, float *lo, float *hi)
{
    *lo = kelly_sequence_lo(tally->stuck, tally->samples, rule->alpha);
    *hi = kelly_sequence_hi(tally->stuck + kelly_refused(tally), tally->samples, rule->alpha);
    if (rule->level > 0.0f && (*lo > rule->level || *hi < rule->level)) {
        return KELLY_DECIDED;
    }
    return rule->width > 0.0f && *hi - *lo <= rule->width ? KELLY_NARROW : KELLY_GO_ON;
}
