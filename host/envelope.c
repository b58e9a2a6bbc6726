/* envelope.c - what an ensemble does in time: mean, standard deviation and quantiles at every output time, and the traces.
 *
 * The whole ensemble is stored: 3 quantities x output times x realisations, sizeof(real) each, besides a column of a few
 * times for each thread and a batch of run_job. Memory is asked for before anything runs; the journal takes as much of the disk. Quantiles are pointwise: at each output time those of
 * the realisations at that time, numpy's "linear": with x sorted and k = (n - 1) p, between x[floor k] and the next.
 * sd has the divisor n. Refused realisations have no trace: they are left out of every statistic, and are rows of NaN in
 * the traces. Every sum is taken in the order of the indices, in double: no thread count can show.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host.h"
#include "journal.h"

#define QUANTITIES 3u
#define STATISTICS 5u
#define COLUMN 16u               /* times that are gathered together: a line of the cache each realisation */

static const struct {
    const char *name;
    double unit;                 /* in SI */
} quantities[QUANTITIES] = { { "bit_speed_rpm", RPM }, { "bit_axial_speed_m_s", 1.0 }, { "surface_torque_kNm", 1000.0 } };

static const char *const statistics[STATISTICS] = { "mean", "sd", "q025", "q500", "q975" };

const option_help envelope_options[] = {
    { "--envelope", "F.npy|F.csv", "mean, standard deviation, 2.5, 50 and 97.5 % quantiles over the realisations, at every output time, of bit_speed_rpm, "
      "bit_axial_speed_m_s and surface_torque_kNm: fields time_s, bit_speed_rpm_mean, ..._sd, ..._q025, ..._q500, ..._q975, ..." },
    { "--quantiles", "exact|streaming", "of the envelope: from all values, or as a microcontroller estimates them in fixed memory (default exact)" },
    { "--traces", "F.npy", "one quantity of every realisation at every output time, a row a realisation; NaN where it was refused" },
    { "--trace-of", "NAME", "that quantity, by its name above (default bit_speed_rpm)" },
    { 0 },
};

/* The ensemble in memory; one run, so one store. What one realisation leaves, here and in the journal, is 1 where it counts and 0 where
 * it was refused, then [quantity][time]. */
static struct {
    real *left;                  /* [realisation][1 + QUANTITIES * times] */
    uint32_t samples, times, used;
    int streaming;
    outfile envelope, traces;
} store;

typedef struct {
    double at[QUANTITIES][STATISTICS];
} row;

static int ends_with(const char *path, const char *suffix)
{
    const size_t n = strlen(path), m = strlen(suffix);

    return n > m && strcmp(path + n - m, suffix) == 0;
}

int envelope_option(void *request, const char *name, const char *value)
{
    envelope_request *const ask = request;

    if (strcmp(name, "--envelope") == 0) {
        ask->envelope = value;
    } else if (strcmp(name, "--traces") == 0) {
        ask->traces = value;
    } else if (strcmp(name, "--quantiles") == 0) {
        if (strcmp(value, "exact") != 0 && strcmp(value, "streaming") != 0) {
            die(EXIT_USAGE, "--quantiles %s: unknown; give exact or streaming", value);
        }
        ask->streaming = strcmp(value, "streaming") == 0;
        return 1;
    } else if (strcmp(name, "--trace-of") == 0) {
        for (ask->quantity = 0; strcmp(value, quantities[ask->quantity].name) != 0;) {
            if (++ask->quantity == QUANTITIES) {
                die(EXIT_USAGE, "--trace-of %s: unknown; give %s, %s or %s", value, quantities[0].name, quantities[1].name, quantities[2].name);
            }
        }
        return 1;
    } else {
        return 0;
    }
    if (!ends_with(value, ".npy") && !(ask->envelope == value && ends_with(value, ".csv"))) {
        die(EXIT_USAGE, "%s %s: unknown kind of file; give a name that ends in .npy%s", name, value, ask->envelope == value ? " or .csv" : "");
    }
    return 1;
}

/* Memory that can be had without swapping [bytes]: what the kernel says, or all there is. */
static double memory_free(void)
{
    static const char name[] = "MemAvailable:";
    FILE *const info = fopen("/proc/meminfo", "r");
    char line[128];
    double kilobytes = -1;

    while (info && kilobytes < 0 && fgets(line, sizeof(line), info)) {
        if (strncmp(line, name, strlen(name)) == 0) {
            kilobytes = strtod(line + strlen(name), 0);
        }
    }
    if (info) {
        (void)fclose(info);
    }
    return kilobytes < 0 ? HUGE_VAL : 1024.0 * kilobytes;
}

static size_t left_by_one(void)
{
    return 1 + (size_t)QUANTITIES * store.times;
}

static double memory_needed(const options *opts)
{
    const uint32_t points = opts->run.ticks / opts->out_ticks + 1;
    const double times = points, threads = threads_of(opts);

    return (double)opts->samples * (QUANTITIES * times + threads * COLUMN + 1) * sizeof(real) + times * sizeof(row);
}

void envelope_reserve(envelope_request *ask, const options *opts)
{
    const double need = memory_needed(opts), have = memory_free();

    if (!ask->envelope && !ask->traces) {
        return;
    }
    store.samples = opts->samples;
    store.times = opts->run.ticks / opts->out_ticks + 1;
    store.streaming = ask->streaming;
    ask->bytes = need;
    if (need < have && need < (double)(SIZE_MAX / 2)) {
        store.left = malloc(store.samples * left_by_one() * sizeof(real));
    }
    if (!store.left) {
        die(EXIT_USAGE, "%s: %u realisations at %u times need %.4g GB of memory, and %.4g GB are free; give fewer --samples, a longer --out-step "
            "or a shorter --duration", ask->envelope ? "--envelope" : "--traces", store.samples, store.times, need / 1e9, have / 1e9);
    }
    if (ask->envelope) {
        outfile_open(&store.envelope, ask->envelope);
    }
    if (ask->traces) {
        outfile_open(&store.traces, ask->traces);
    }
}

static int counted(uint32_t j)
{
    return store.left[j * left_by_one()] > 0;
}

static real *trace(real *left, unsigned quantity)
{
    return left + 1 + (size_t)quantity * store.times;
}

static void look(const kelly_plant *plant, real *left, uint32_t t)
{
    kelly_sight sight;

    kelly_plant_look(plant, &sight);
    trace(left, 0)[t] = sight.bit_speed;
    trace(left, 1)[t] = sight.axial_speed;
    trace(left, 2)[t] = sight.surface_torque;
}

static void run_one(const options *opts, uint32_t index, real *left, kelly_plant *plant)
{
    kelly_draw draw;

    memset(left, 0, left_by_one() * sizeof(real));
    kelly_draw_sample(&opts->run, opts->seed, index, &draw);
    if (kelly_plant_start(plant, &kelly_string, &opts->run, &draw) != KELLY_OK) {
        return;
    }
    look(plant, left, 0);
    for (uint32_t t = 1; t < store.times; t++) {
        kelly_plant_advance(plant, opts->out_ticks);
        look(plant, left, t);
    }
    kelly_plant_advance(plant, opts->run.ticks % opts->out_ticks);   /* whether it is sane is asked at the end, as in every run */
    left[0] = kelly_plant_sane(plant) ? R(1.0) : R(0.0);
}

static void run_piece(const options *opts, uint32_t first, uint32_t count, void *results, void *work)
{
    for (uint32_t i = 0; i < count; i++) {
        run_one(opts, first + i, (real *)results + i * left_by_one(), work);
    }
}

static void keep(void *context, uint32_t first, uint32_t count, const void *results)
{
    const uint32_t j = first - ((const options *)context)->first;

    memcpy(store.left + j * left_by_one(), results, count * left_by_one() * sizeof(real));
    for (uint32_t i = 0; i < count; i++) {
        store.used += (uint32_t)counted(j + i);
    }
}

/* ---- statistics ---------------------------------------------------------------------------------------------- */

static int ascending(const void *a, const void *b)
{
    const real x = *(const real *)a, y = *(const real *)b;

    return (x > y) - (x < y);
}

static double quantile(const real *sorted, uint32_t n, double p)
{
    const double k = p * (double)(n - 1);
    const uint32_t below = (uint32_t)k, above = below + 1 < n ? below + 1 : below;

    return (double)sorted[below] + ((double)sorted[above] - (double)sorted[below]) * (k - (double)below);
}

/* x[0..n-1] in the order of the indices; sorted afterwards. */
static void exact(real *x, uint32_t n, double at[STATISTICS])
{
    double sum = 0, square = 0;

    for (uint32_t j = 0; j < n; j++) {
        sum += (double)x[j];
    }
    at[0] = sum / n;
    for (uint32_t j = 0; j < n; j++) {
        square += ((double)x[j] - at[0]) * ((double)x[j] - at[0]);
    }
    at[1] = sqrt(square / n);
    qsort(x, n, sizeof(real), ascending);
    at[2] = quantile(x, n, 0.025);
    at[3] = quantile(x, n, 0.5);
    at[4] = quantile(x, n, 0.975);
}

static void streaming(const real *x, uint32_t n, double at[STATISTICS])
{
    kelly_envelope envelope;
    kelly_band band;

    kelly_envelope_clear(&envelope);
    for (uint32_t j = 0; j < n; j++) {
        (void)kelly_envelope_add(&envelope, x[j]);
    }
    kelly_envelope_read(&envelope, &band);
    at[0] = (double)band.mean;
    at[1] = (double)band.sd;
    at[2] = (double)band.low;
    at[3] = (double)band.median;
    at[4] = (double)band.high;
}

/* The values of `count` times, one column of store.used values after another. */
static void gather(real *columns, unsigned quantity, uint32_t time, uint32_t count)
{
    uint32_t used = 0;

    for (uint32_t j = 0; j < store.samples; j++) {
        if (counted(j)) {
            const real *const x = trace(store.left + j * left_by_one(), quantity);

            for (uint32_t i = 0; i < count; i++) {
                columns[(size_t)i * store.used + used] = x[time + i];
            }
            used++;
        }
    }
}

static void rows_piece(const options *opts, uint32_t first, uint32_t count, void *results, void *work)
{
    row *const rows = results;

    (void)opts;
    for (uint32_t done = 0; done < count; done += COLUMN) {
        const uint32_t now = count - done < COLUMN ? count - done : COLUMN;

        for (unsigned q = 0; q < QUANTITIES; q++) {
            gather(work, q, first + done, now);
            for (uint32_t i = 0; i < now; i++) {
                real *const column = (real *)work + (size_t)i * store.used;
                double *const at = rows[done + i].at[q];

                (store.streaming ? (void)streaming(column, store.used, at) : exact(column, store.used, at));
                for (unsigned s = 0; s < STATISTICS; s++) {
                    at[s] /= quantities[q].unit;
                }
            }
        }
    }
}

/* ---- files --------------------------------------------------------------------------------------------------- */

typedef struct {
    const options *opts;
    FILE *to;
    int text;
} writer;

/* time_s, then quantity_statistic; as a line of CSV or as the named fields of a numpy array. */
static void write_names(const writer *w)
{
    char type[1024] = "[('time_s', '<f8')";
    const uint64_t shape = store.times;
    size_t used = strlen(type);

    if (w->text) {
        fputs("time_s", w->to);
    }
    for (unsigned k = 0; k < QUANTITIES * STATISTICS; k++) {
        const char *const quantity = quantities[k / STATISTICS].name, *const statistic = statistics[k % STATISTICS];

        if (w->text) {
            fprintf(w->to, ",%s_%s", quantity, statistic);
        }
        used += (size_t)snprintf(type + used, sizeof(type) - used, ", ('%s_%s', '<f8')", quantity, statistic);
    }
    if (w->text) {
        fputc('\n', w->to);
    } else {
        snprintf(type + used, sizeof(type) - used, "]");
        npy_header(w->to, type, 1, &shape);
    }
}

static void write_rows(void *context, uint32_t first, uint32_t count, const void *results)
{
    const writer *const w = context;
    const row *const rows = results;

    for (uint32_t i = 0; i < count; i++) {
        const double time = case_seconds(&w->opts->run, (first + i) * w->opts->out_ticks), *const at = &rows[i].at[0][0];

        if (!w->text) {
            fwrite(&time, sizeof(time), 1, w->to);
            fwrite(at, sizeof(double), (size_t)QUANTITIES * STATISTICS, w->to);
            continue;
        }
        fprintf(w->to, "%.12g", time);
        for (unsigned k = 0; k < QUANTITIES * STATISTICS; k++) {
            fprintf(w->to, ",%.17g", at[k]);
        }
        fputc('\n', w->to);
    }
}

static void write_envelope(FILE *to, const char *path, const options *opts)
{
    options by_time = *opts;
    writer w = { opts, to, ends_with(path, ".csv") };

    by_time.first = 0;
    by_time.samples = store.times;
    write_names(&w);
    run_job(&by_time, &(job){ .work = rows_piece, .work_size = (size_t)store.used * COLUMN * sizeof(real), .result_size = sizeof(row),
                              .width = COLUMN, .lanes = COLUMN * 8, .lead_alone = 1 }, write_rows, &w);
}

static void write_traces(FILE *to, unsigned quantity)
{
    const uint64_t shape[2] = { store.samples, store.times };

    npy_header(to, sizeof(real) > sizeof(float) ? "<f8" : "<f4", 2, shape);
    for (uint32_t j = 0; j < store.samples; j++) {
        real *const x = trace(store.left + j * left_by_one(), quantity);

        for (uint32_t t = 0; t < store.times; t++) {
            x[t] = counted(j) ? (real)((double)x[t] / quantities[quantity].unit) : (real)NAN;
        }
        fwrite(x, sizeof(real), store.times, to);
    }
}

/* A realisation as the journal has it: a flag, and numbers that are finite where it counts. */
static int trace_sound(const void *payload, size_t size)
{
    for (size_t at = 0; at < size; at += sizeof(real)) {
        real x, counts;

        memcpy(&counts, payload, sizeof(counts));
        memcpy(&x, (const char *)payload + at, sizeof(x));
        if (counts != 0 && !(counts == 1 && isfinite(x))) {
            return 0;
        }
    }
    return 1;
}

void envelope_run(envelope_request *ask, const options *opts, const char *beside, journal *log)
{
    options all = *opts;         /* the context of a sink is not const */
    char path[4096];

    if (!ask->envelope && !ask->traces) {
        return;
    }
    snprintf(path, sizeof(path), "%s.envelope", beside ? beside : "");
    job_log(log, opts, beside ? path : 0, &(journal_run){ .kind = "envelope", .parameters = opts->out_ticks ^ (uint32_t)opts->run.axial << 24,
            .records = opts->samples, .payload = (uint32_t)(left_by_one() * sizeof(real)), .in_order = 1, .sound = trace_sound });
    store.samples = opts->samples;   /* of a run that stopped itself fewer than were asked for */
    run_job(opts, &(job){ .work = run_piece, .work_size = sizeof(kelly_plant), .result_size = left_by_one() * sizeof(real), .width = 1,
                          .lanes = 4, .log = log, .lead_alone = 1 }, keep, &all);
    if (ask->envelope && store.used == 0) {   /* the run's other files tell what was refused, and its exit status that there is no answer */
        fprintf(stderr, "kelly: --envelope %s: not written: every realisation was refused, and there is nothing to take quantiles of\n", ask->envelope);
        outfile_drop(&store.envelope);
    } else if (ask->envelope) {
        write_envelope(store.envelope.stream, ask->envelope, opts);
        outfile_close(&store.envelope);
    }
    if (ask->traces) {
        write_traces(store.traces.stream, ask->quantity);
        outfile_close(&store.traces);
    }
    ask->used = store.used;
    ask->times = store.times;
    free(store.left);
}
