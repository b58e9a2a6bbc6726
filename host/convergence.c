/* convergence.c - the paper's convergence function, Fig. 3.
 *
 *     conv(n) = (1/n) sum_j  int |U(t, s_j)|^2 dt
 *
 * U holds displacement and twist of all nodes relative to u_S and to the top's rotation, in SI, unweighted; the integral
 * is the trapezoid at the out-step. |U|^2 = q' G q + p' Ga p with the Gram matrices of the shapes at the drawn weight.
 * Refused realisations have no response and are left out of sum and n.
 */
#include <math.h>
#include <string.h>

#include "host.h"
#include "journal.h"

typedef struct {
    kelly_plant plant;
    real twist_gram[KELLY_MODES_MAX * (KELLY_MODES_MAX + 1) / 2];
    real axial_gram[KELLY_MODES_MAX * (KELLY_MODES_MAX + 1) / 2];
} scratch;

typedef struct {
    convergence_table *table;
    double sum;
    uint32_t counted;
} fold;

static void gram_at(const real *polynomials, unsigned modes, real fc, real *gram)
{
    const real s = (fc - kelly_string.fc_mid) * kelly_string.fc_scale;
    const unsigned degree = kelly_string.degree;

    for (unsigned e = 0; e < modes * (modes + 1) / 2; e++) {
        gram[e] = kelly_poly(&polynomials[(size_t)e * (degree + 1)], degree, s);
    }
}

static double quadratic(const real *gram, const real *x, unsigned n)
{
    double sum = 0;

    for (unsigned i = 0; i < n; i++) {
        double row = 0.5 * (double)gram[i * (i + 1) / 2 + i] * (double)x[i];

        for (unsigned j = 0; j < i; j++) {
            row += (double)gram[i * (i + 1) / 2 + j] * (double)x[j];
        }
        sum += 2.0 * row * (double)x[i];
    }
    return sum;
}

static double norm2(const scratch *s)
{
    real q[KELLY_MODES_MAX], v[KELLY_MODES_MAX];

    kelly_plant_modal(&s->plant, q, v);
    return quadratic(s->twist_gram, q, s->plant.modes.count) + quadratic(s->axial_gram, s->plant.axial.p, s->plant.axial.count);
}

/* int |U|^2 dt of one realisation, or NaN where it was refused. */
static double response(const options *opts, uint32_t index, scratch *s)
{
    const double dt = case_seconds(&opts->run, opts->out_ticks);
    double sum, last;
    kelly_draw draw;

    kelly_draw_sample(&opts->run, opts->seed, index, &draw);
    if (kelly_plant_start(&s->plant, &kelly_string, &opts->run, &draw) != KELLY_OK) {
        return (double)NAN;
    }
    gram_at(kelly_string_shapes.twist_gram, s->plant.modes.count, draw.fc, s->twist_gram);
    gram_at(kelly_string_shapes.axial_gram, s->plant.axial.count, draw.fc, s->axial_gram);
    last = norm2(s);
    sum = 0;
    for (uint32_t left = opts->run.ticks; left >= opts->out_ticks; left -= opts->out_ticks) {
        double next;

        kelly_plant_advance(&s->plant, opts->out_ticks);
        next = norm2(s);
        sum += 0.5 * dt * (last + next);
        last = next;
    }
    return kelly_plant_sane(&s->plant) ? sum : (double)NAN;
}

static void work_piece(const options *opts, uint32_t first, uint32_t count, void *results, void *work)
{
    double *const value = results;

    for (uint32_t i = 0; i < count; i++) {
        value[i] = response(opts, first + i, work);
    }
}

/* 1, 2, 5, 10, 20, ... */
static int is_checkpoint(uint32_t n)
{
    while (n % 10 == 0) {
        n /= 10;
    }
    return n == 1 || n == 2 || n == 5;
}

static void report(fold *f)
{
    convergence_table *const t = f->table;

    if (f->counted > 0 && t->count < CHECKPOINTS_MAX && !(t->count > 0 && t->n[t->count - 1] == f->counted)) {
        t->n[t->count] = f->counted;
        t->value[t->count++] = f->sum / (double)f->counted;
    }
}

static void take_batch(void *context, uint32_t first, uint32_t count, const void *results)
{
    fold *const f = context;
    const double *const value = results;

    (void)first;
    for (uint32_t i = 0; i < count; i++) {
        if (isnan(value[i])) {
            continue;
        }
        f->sum += value[i];
        f->counted++;
        if (is_checkpoint(f->counted)) {
            report(f);
        }
    }
}

/* A response as the journal has it: a sum of squares, or that of a realisation that was refused, to the bit. */
static int response_sound(const void *payload, size_t size)
{
    const double refused = (double)NAN;
    double x;

    memcpy(&x, payload, size);
    return isnan(x) ? memcmp(&x, &refused, size) == 0 : isfinite(x) && x >= 0;
}

void convergence_run(const options *opts, const char *beside, journal *log, convergence_table *table)
{
    fold f = { .table = table };
    char path[4096];

    snprintf(path, sizeof(path), "%s.convergence", beside ? beside : "");
    *table = (convergence_table){ 0 };
    job_log(log, opts, beside ? path : 0, &(journal_run){ .kind = "convergence", .parameters = opts->out_ticks ^ (uint32_t)opts->run.axial << 24,
            .records = opts->samples, .payload = sizeof(double), .in_order = 1, .sound = response_sound });
    run_job(opts, &(job){ .work = work_piece, .work_size = sizeof(scratch), .result_size = sizeof(double), .width = 1, .lanes = 4,
                        .log = log }, take_batch, &f);
    report(&f);
}
