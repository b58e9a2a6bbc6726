#include "envelope.h"

#include "detmath.h"

#define TARGETS 3
#define GRAIN R(0.3)             /* 3 pi / 0.3 = 31 clusters at least, about 60 as neighbours that just do not fit remain apart */
#define COARSEST R(1e12)         /* with less, all may merge that `most` lets */
#define KEEP 72u                 /* clusters left by a pass at most: the rest is room for values to come */
#define LARGEST R(1e14)            /* 2^24 squares of twice as much do not overflow */
#define COUNT_MAX 16777216u      /* 2^24: every rank is exact in float */

static const real targets[TARGETS] = { R(0.025), R(0.5), R(0.975) };

void kelly_envelope_clear(kelly_envelope *envelope)
{
    envelope->n = 0;
    envelope->used = 0;
    envelope->grain = GRAIN;
    envelope->mean = 0;
    envelope->m2 = 0;
}

/* Position of each target among the ranks 0..n-1, and the standard error of its rank. */
typedef struct {
    real rank[TARGETS], s[TARGETS];
    uint32_t most;               /* values in a cluster, wherever it is: keeps sorted streams within bounds */
} ruler;

static void measure(const kelly_envelope *envelope, ruler *r)
{
    const real n = (real)envelope->n;

    r->most = envelope->n / 32u;
    for (unsigned k = 0; k < TARGETS; k++) {
        r->rank[k] = targets[k] * (n - 1);
        r->s[k] = (real)kelly_sqrt32((float)(n * targets[k] * (1 - targets[k])));
    }
}

/* Whether the ranks first .. first + count - 1 may be one cluster. */
static int may_merge(const ruler *r, real grain, real first, uint32_t count)
{
    const real n = (real)count, last = first + n - 1;

    if (count > r->most) {
        return 0;
    }
    for (unsigned k = 0; k < TARGETS; k++) {
        const real below = first - r->rank[k], above = r->rank[k] - last;
        const real d = below > 0 ? below : above > 0 ? above : 0;

        if (n > grain * (r->s[k] + d * d / r->s[k])) {
            return 0;
        }
    }
    return 1;
}

/* The mean of two clusters lies between them: rounding carries it no further. */
static real joint(real low, real high, real share)
{
    const real mean = low + (high - low) * share;

    return mean < low ? low : mean > high ? high : mean;
}

/* One pass from the lowest value up: each cluster takes in its next neighbour where it may. */
static void merge_neighbours(kelly_envelope *e, const ruler *r)
{
    uint32_t to = 0, first = 0;

    for (uint32_t i = 1; i < e->used; i++) {
        const uint32_t count = e->weight[to] + e->weight[i];

        if (may_merge(r, e->grain, (real)first, count)) {
            e->value[to] = joint(e->value[to], e->value[i], (real)e->weight[i] / (real)count);
            e->weight[to] = count;
        } else {
            first += e->weight[to++];
            e->value[to] = e->value[i];
            e->weight[to] = e->weight[i];
        }
    }
    e->used = to + 1;
}

/* Make room. `most` leaves 64 clusters of n / 32 apart at worst, so that a larger grain always ends below KEEP. */
static void make_room(kelly_envelope *e)
{
    ruler r;

    measure(e, &r);
    merge_neighbours(e, &r);
    while (e->used > KEEP) {
        e->grain *= e->grain < COARSEST ? R(1.25) : R(1.0);
        merge_neighbours(e, &r);
    }
}

static void add_moments(kelly_envelope *e, real x)
{
    const real away = x - e->mean;

    e->mean += away / (real)e->n;
    e->m2 += away * (x - e->mean);
}

int kelly_envelope_add(kelly_envelope *e, real x)
{
    uint32_t at;

    if (!(x > -LARGEST && x < LARGEST) || e->n >= COUNT_MAX) {
        return 0;
    }
    if (e->used == KELLY_CLUSTERS) {
        make_room(e);
    }
    for (at = e->used; at > 0 && e->value[at - 1] > x; at--) {
        e->value[at] = e->value[at - 1];
        e->weight[at] = e->weight[at - 1];
    }
    e->value[at] = x;
    e->weight[at] = 1;
    e->used++;
    e->n++;
    add_moments(e, x);
    return 1;
}

real kelly_envelope_quantile(const kelly_envelope *e, real p)
{
    const real rank = p * ((real)e->n - 1);
    real last_middle = 0;
    uint32_t first = 0;

    for (uint32_t i = 0; i < e->used; i++) {
        const real middle = (real)first + R(0.5) * (real)(e->weight[i] - 1);
        if (rank <= middle) {
            if (i == 0) {
                return e->value[0];
            }
            const real apart = R(0.5) * (real)(e->weight[i - 1] + e->weight[i]);     /* the middles */
            return e->value[i - 1] + (e->value[i] - e->value[i - 1]) * ((rank - last_middle) / apart);
        }
        last_middle = middle;
        first += e->weight[i];
    }
    return e->used ? e->value[e->used - 1] : 0;
}

void kelly_envelope_read(const kelly_envelope *e, kelly_band *band)
{
    *band = (kelly_band){ 0 };
    if (e->n == 0) {
        return;
    }
    band->mean = e->mean;
    band->sd = (real)kelly_sqrt32((float)(e->m2 / (real)e->n));
    band->low = kelly_envelope_quantile(e, targets[0]);
    band->median = kelly_envelope_quantile(e, targets[1]);
    band->high = kelly_envelope_quantile(e, targets[2]);
}
