#include "reweight.h"

#include "detmath.h"

#define LEAST W(1e-16)           /* shapes are 4 and more: a difference that is above 0 is larger */
#define NOTHING W(1e-30)         /* of sums in units of the largest weight */

/* ln E(w^2) of one parameter: with shapes f, g, rates in units of 1/mean_f (f and g m), s = 2g - f, t = 2 gm - f:
 *     ln Gamma(f) + ln Gamma(s) - 2 ln Gamma(g) - f ln f + 2 g ln(gm) - s ln t
 * Stirling's formula and s ln s - s ln t together: no term is larger than the shapes times what differs.
 * Infinite unless s > 0 and t > 0: then 0 is returned. */
static int log_square(wide f, wide g, wide m, wide *sum)
{
    const wide gm = g / m, s = 2 * g - f, t = 2 * gm - f;

    if (!(s > LEAST) || !(t > LEAST)) {
        return 0;
    }
    *sum += s * kelly_log(s / t) - 2 * g * kelly_log(g / gm) - W(0.5) * kelly_log(f * s / (g * g)) + (kelly_stirling(f) + kelly_stirling(s) - 2 * kelly_stirling(g));
    return 1;
}

kelly_law_fit kelly_law_fits(const kelly_laws *from, const kelly_laws *to, unsigned k)
{
    if (!(from->cov[k] > 0)) {
        return to->cov[k] > 0 || to->mean[k] != from->mean[k] ? KELLY_LAW_FIXED : KELLY_LAW_FITS;
    }
    return to->cov[k] > 0 ? KELLY_LAW_FITS : KELLY_LAW_POINT;
}

void kelly_reweight_start(kelly_reweight *sums, const kelly_laws *from, const kelly_laws *to)
{
    wide log_sum = 0;
    int finite = 1;

    *sums = (kelly_reweight){ .n = 0 };
    for (unsigned k = 0; k < KELLY_PARAMETERS; k++) {
        sums->mean[k] = from->mean[k];
        if (!(from->cov[k] > 0) || (to->mean[k] == from->mean[k] && to->cov[k] == from->cov[k])) {
            continue;                                      /* the same law: weight 1 */
        }
        const wide f = 1 / (from->cov[k] * from->cov[k]), g = 1 / (to->cov[k] * to->cov[k]), m = to->mean[k] / from->mean[k];
        sums->slope[k] = g - f;
        sums->rate[k] = f - g / m;
        finite = finite && log_square(f, g, m, &log_sum);
    }
    sums->square = finite && log_sum < KELLY_EXP_END ? kelly_exp(log_sum > 0 ? log_sum : 0) : 0;   /* 1 and more */
}

/* ln w but for a constant, which the estimate does not need. */
static wide log_weight(const kelly_reweight *sums, const wide y[KELLY_PARAMETERS])
{
    wide sum = 0;

    for (unsigned k = 0; k < KELLY_PARAMETERS; k++) {
        if (sums->rate[k] != 0 || sums->slope[k] != 0) {
            const wide x = y[k] / sums->mean[k];

            sum += sums->slope[k] * kelly_log(x) + sums->rate[k] * (x - 1);
        }
    }
    return sum;
}

/* A weight in units of the largest, above which it is not. */
static wide relative(wide log_w, wide top)
{
    const wide under = log_w - top;

    return kelly_exp(under < 0 ? under : 0);
}

/* A new largest weight: all sums in units of it. */
static void rescale(kelly_reweight *sums, wide top)
{
    const wide by = sums->n > 0 ? relative(sums->top, top) : 0;

    sums->top = top;
    sums->w *= by;
    sums->refused *= by;
    sums->stuck *= by;
    sums->ww *= by * by;
    sums->stuck2 *= by * by;
}

void kelly_reweight_add(kelly_reweight *sums, const wide y[KELLY_PARAMETERS], int status, int stuck)
{
    const wide log_w = log_weight(sums, y);

    if (sums->n == 0 || log_w > sums->top) {
        rescale(sums, log_w);
    }
    const wide w = relative(log_w, sums->top);
    sums->n++;
    sums->w += w;
    sums->ww += w * w;
    if (status != KELLY_OK) {
        sums->refused_n++;
        sums->refused += w;
    } else if (stuck) {
        sums->stuck += w;
        sums->stuck2 += w * w;
    }
}

/* Whole numbers below and above; a thousandth is rounding, and no count. */
static uint32_t below(wide x)
{
    return x < W(4e9) ? (uint32_t)(x + W(1e-3)) : 4000000000u;
}

static uint32_t above(wide x)
{
    const uint32_t k = below(x);

    return x > (wide)k + W(1e-3) ? k + 1 : k;
}

/* The effective n of the interval; see the header. p: refused ones counted as free. */
static wide effective(const kelly_reweight *s, wide p, wide ess)
{
    const wide squares = s->stuck2 * (1 - 2 * p) + s->ww * p * p;   /* sum w^2 (z - p)^2 */

    if (!(p > 0) || !(p < 1) || !(squares > NOTHING)) {
        return ess;
    }
    const wide matched = p * (1 - p) * s->w * s->w / squares;
    return matched < ess ? matched : ess;
}

void kelly_reweight_read(const kelly_reweight *s, kelly_reweighted *r)
{
    const wide counted = s->w - s->refused;

    *r = (kelly_reweighted){ .hi = 1 };
    if (s->n == 0 || s->refused_n == s->n || !(counted > NOTHING)) {
        return;
    }
    r->probability = s->stuck / counted < 1 ? s->stuck / counted : 1;
    r->ess = s->w * s->w / s->ww;
    r->ess_predicted = s->square >= 1 ? (wide)s->n / s->square : 0;
    r->share = 1 / s->w;
    const wide p = s->stuck / s->w < 1 ? s->stuck / s->w : 1, high = (s->stuck + s->refused) / s->w;
    const uint32_t n = below(effective(s, p, r->ess));
    r->lo = kelly_binomial_lo(below(p * (wide)n), n, W(0.025));         /* 0 where n is 0 */
    r->hi = kelly_binomial_hi(above(high * (wide)n), n, W(0.025));      /* and 1 */
    r->enough = r->ess >= KELLY_LEAST_ESS && r->ess_predicted >= KELLY_LEAST_ESS && r->share <= KELLY_MOST_SHARE;
}
