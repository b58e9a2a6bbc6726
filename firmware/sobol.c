#include "sobol.h"

#include "random.h"

#define T_31 W(2.039513446396408)   /* Student's t, 97.5 %, 31 degrees of freedom */
#define LEAST_VARIANCE W(1e-30)      /* f that varies by less does not vary; a quotient by more is finite */

/* Square root by Newton's method from above: no float is enough where wide is double. 60 steps are enough from
 * x = 1e-30 on; 0 where x is not positive. */
static wide root(wide x)
{
    wide r;

    if (!(x > 0)) {
        return 0;
    }
    r = 1 + x;                   /* halved at most in every step: never 0 */
    for (int i = 0; i < 60; i++) {
        r = W(0.5) * (r + x / r);
    }
    return r;
}

unsigned kelly_sobol_random(const kelly_case *run, unsigned which[KELLY_PARAMETERS])
{
    unsigned n = 0;

    for (unsigned k = 0; k < KELLY_PARAMETERS; k++) {
        if (run->cov[k] > 0.0f) {
            which[n++] = k;
        }
    }
    return n;
}

static void take(kelly_draw *to, const kelly_draw *from, unsigned parameter)
{
    switch (parameter) {
    case 0: to->fc = from->fc; break;
    case 1: to->mu = from->mu; break;
    case 2: to->a1 = from->a1; break;
    case 3: to->a2 = from->a2; break;
    default: to->w0 = from->w0; break;
    }
}

unsigned kelly_sobol_row(const kelly_case *run, uint64_t seed, uint32_t index, kelly_draw draws[KELLY_SOBOL_ROW])
{
    uint64_t other = seed;
    unsigned which[KELLY_PARAMETERS];
    const unsigned n = kelly_sobol_random(run, which);

    kelly_draw_sample(run, seed, index, &draws[0]);
    kelly_draw_sample(run, kelly_splitmix64(&other), index, &draws[1]);
    for (unsigned i = 0; i < n; i++) {
        draws[2 + i] = draws[0];
        take(&draws[2 + i], &draws[1], which[i]);
    }
    return 2 + n;
}

void kelly_sobol_clear(kelly_sobol *sobol, unsigned parameters)
{
    *sobol = (kelly_sobol){ .parameters = parameters };
}

void kelly_sobol_add(kelly_sobol *sobol, const wide f[])
{
    kelly_sobol_sums *const g = &sobol->group[sobol->rows % KELLY_SOBOL_GROUPS];

    if (sobol->rows == 0) {
        sobol->origin = f[0];
    }
    const wide a = f[0] - sobol->origin, b = f[1] - sobol->origin;
    sobol->rows++;
    g->n++;
    g->ab += a + b;
    g->aabb += a * a + b * b;
    for (unsigned i = 0; i < sobol->parameters; i++) {
        const wide d = f[2 + i] - f[0];

        g->d[i] += d;
        g->bd[i] += b * d;
        g->dd[i] += d * d;
    }
}

/* Sums over all groups but one (KELLY_SOBOL_GROUPS: over all), of one parameter in place 0. */
static void total_sums(const kelly_sobol *sobol, unsigned without, unsigned parameter, kelly_sobol_sums *sum)
{
    *sum = (kelly_sobol_sums){ .n = 0 };
    for (unsigned k = 0; k < KELLY_SOBOL_GROUPS; k++) {
        const kelly_sobol_sums *const g = &sobol->group[k];

        if (k == without) {
            continue;
        }
        sum->n += g->n;
        sum->ab += g->ab;
        sum->aabb += g->aabb;
        sum->d[0] += g->d[parameter];
        sum->bd[0] += g->bd[parameter];
        sum->dd[0] += g->dd[parameter];
    }
}

static wide variance(const kelly_sobol_sums *sum)
{
    const wide n = 2 * (wide)sum->n, mean = sum->ab / n, v = sum->aabb / n - mean * mean;

    return v > 0 ? v : 0;
}

/* Both indices from sums; 0 where f does not vary. */
static int indices(const kelly_sobol_sums *sum, wide *first, wide *total)
{
    const wide n = (wide)sum->n, v = variance(sum), mean = sum->ab / (2 * n);

    if (!(v > LEAST_VARIANCE)) {
        return 0;
    }
    *first = (sum->bd[0] - mean * sum->d[0]) / (n * v);
    *total = sum->dd[0] / (2 * n * v);
    return 1;
}

void kelly_sobol_moments(const kelly_sobol *sobol, wide *mean, wide *spread)
{
    kelly_sobol_sums sum;

    total_sums(sobol, KELLY_SOBOL_GROUPS, 0, &sum);
    *mean = sum.n > 0 ? sobol->origin + sum.ab / (2 * (wide)sum.n) : 0;
    *spread = sum.n > 0 ? variance(&sum) : 0;
}

/* What leaving groups out has changed: sum and sum of squares. */
typedef struct {
    wide sum, squares;
} changes;

static void change(changes *c, wide by)
{
    c->sum += by;
    c->squares += by * by;
}

/* Variance of the jackknife: (G - 1) / G times the squares of the changes about their mean. */
static void widen(kelly_estimate *e, const changes *c)
{
    const wide about = c->squares - c->sum * c->sum / KELLY_SOBOL_GROUPS;
    const wide half = T_31 * root(about * (KELLY_SOBOL_GROUPS - 1) / KELLY_SOBOL_GROUPS);

    e->lo = e->value - half;
    e->hi = e->value + half;
}

int kelly_sobol_read(const kelly_sobol *sobol, unsigned parameter, kelly_estimate *first, kelly_estimate *total)
{
    kelly_sobol_sums sum;
    changes of_first = { 0, 0 }, of_total = { 0, 0 };
    wide f, t;

    total_sums(sobol, KELLY_SOBOL_GROUPS, parameter, &sum);
    if (sobol->rows < 2 * KELLY_SOBOL_GROUPS || !indices(&sum, &first->value, &total->value)) {
        return 0;
    }
    for (unsigned k = 0; k < KELLY_SOBOL_GROUPS; k++) {
        total_sums(sobol, k, parameter, &sum);
        if (!indices(&sum, &f, &t)) {
            return 0;
        }
        change(&of_first, f - first->value);
        change(&of_total, t - total->value);
    }
    widen(first, &of_first);
    widen(total, &of_total);
    return 1;
}
