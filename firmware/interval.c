/* interval.c - Clopper and Pearson's interval from the incomplete beta function.
 *
 * P(X >= k | n, p) = I_p(k, n - k + 1), by Lentz's continued fraction, times a binomial probability in Loader's form:
 * deviances instead of differences of log-gammas, so that no digits are lost for large n, in float as in double.
 */
#include "detmath.h"
#include "tally.h"

#define HALF_LOG_2PI W(0.91893853320467274178)
#define TERMS 100000             /* bound of the continued fraction: enough for n = 1e9 */
#define TINY (sizeof(wide) > sizeof(float) ? W(1e-30) : W(1e-10))    /* 1 / (a + b) is more */
#define MOST W(1e12)             /* of the fraction, which stays below a + b */
#define EPS (sizeof(wide) > sizeof(float) ? W(1e-16) : W(6e-8))
#define HALVINGS (sizeof(wide) > sizeof(float) ? 60 : 30)

/* See tally.h. Stirling's series from 16 on, where its error is below 1e-16, and
 * S(n) = S(n + 1) + (n + 1/2) ln(1 + 1/n) - 1 below. */
wide kelly_stirling(wide n)
{
    wide s = 0, inv, inv2;

    while (n < W(16.0)) {
        s += (n + W(0.5)) * kelly_log((n + 1) / n) - 1;
        n += 1;
    }
    inv = 1 / n;
    inv2 = inv * inv;
    return s + inv * (W(1.0) / 12 - inv2 * (W(1.0) / 360 - inv2 * (W(1.0) / 1260 - inv2 * (W(1.0) / 1680 - inv2 * (W(1.0) / 1188)))));
}

/* x ln(x / m) + m - x >= 0, without cancellation where x is near m: with t = (x - m) / (x + m),
 * = (x - m) t + 2 x (t^3/3 + t^5/5 + ...). */
static wide deviance(wide x, wide m)
{
    const wide t = (x - m) / (x + m);
    wide power = 2 * x * t, sum = (x - m) * t;

    if (t > W(0.1) || t < W(-0.1)) {
        return x * kelly_log(x / m) + m - x;
    }
    for (int j = 3; j < 24; j += 2) {
        power *= t * t;
        sum += power / (wide)j;
    }
    return sum;
}

/* Logarithm of the binomial probability of k of n = k + rest, k and rest above 0, 0 < p < 1. */
static wide log_binomial(wide k, wide rest, wide n, wide p)
{
    const wide log_root = W(0.5) * kelly_log(n / (k * rest)) - HALF_LOG_2PI;

    return log_root + (kelly_stirling(n) - kelly_stirling(k) - kelly_stirling(rest)) - deviance(k, n * p) - deviance(rest, n * (1 - p));
}

static wide above_zero(wide x)
{
    return x > TINY ? x : TINY;
}

static wide bounded(wide x)
{
    return x < MOST ? x : MOST;
}

/* The factor by which one more partial numerator changes Lentz's fraction. */
static wide lentz(wide numerator, wide *c, wide *d)
{
    *d = 1 / above_zero(1 + numerator * *d);
    *c = above_zero(1 + numerator / *c);
    return sizeof(wide) > sizeof(float) ? *c * *d : bounded(*c * *d);      /* in double nothing overflows before f is bounded */
}

/* Continued fraction of I_x(a, b) without its front factor, for x < (a + 1) / (a + b + 2), where all that is divided by is above 0 but
 * for rounding. It times the front factor is a probability: it stays below a + b. */
static wide fraction(wide a, wide b, wide x)
{
    wide c = 1, d = 1 / above_zero(1 - (a + b) * x / (a + 1)), f = d;

    for (int j = 1; j < TERMS; j++) {
        const wide m = (wide)j, even = m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m));
        const wide odd = -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1));
        wide change;

        f *= lentz(even, &c, &d);
        change = lentz(odd, &c, &d);
        f = bounded(f * change);
        if (change - 1 < EPS && change - 1 > -EPS) {
            break;
        }
    }
    return f;
}

/* P(X >= k) for 1 <= k <= n, 0 < p < 1. */
static wide at_least(uint32_t k, uint32_t n, wide p)
{
    const uint32_t rest = n - k;
    const wide a = (wide)k, b = (wide)rest + 1, q = 1 - p;
    /* x^a (1-x)^b / (a B(a, b)) = q binomial(k; n, p); at k = n that is q p^n */
    const wide log_p = rest == 0 ? (wide)n * kelly_log(p) : log_binomial(a, (wide)rest, (wide)n, p);
    const wide front = q * kelly_exp(log_p < 0 ? log_p : 0);

    if (p < (a + 1) / (a + b + 2)) {
        return front * fraction(a, b, p);
    }
    return 1 - front * a / b * fraction(b, a, q);
}

wide kelly_binomial_lo(uint32_t k, uint32_t n, wide tail)
{
    wide lo = 0, hi = 1;

    if (k == 0) {
        return 0;
    }
    for (int i = 0; i < HALVINGS; i++) {
        const wide p = W(0.5) * (lo + hi);

        if (p <= lo || p >= hi) {    /* no number lies between */
            break;
        }
        if (at_least(k, n, p) < tail) {
            lo = p;
        } else {
            hi = p;
        }
    }
    return W(0.5) * (lo + hi);
}

/* By symmetry: P(X <= k | p) = P(n - X >= n - k | 1 - p). */
wide kelly_binomial_hi(uint32_t k, uint32_t n, wide tail)
{
    return k >= n ? 1 : 1 - kelly_binomial_lo(n - k, n, tail);
}

void kelly_interval(const kelly_tally *tally, wide *lo, wide *hi)
{
    const uint32_t refused = kelly_refused(tally);

    *lo = kelly_binomial_lo(tally->stuck, tally->samples, W(0.025));
    *hi = kelly_binomial_hi(tally->stuck + refused, tally->samples, W(0.025));
}
