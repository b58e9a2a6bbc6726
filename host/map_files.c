/* map_files.c - a map as CSV, NPY, JSON, and on the screen. Nothing in a file depends on threads, engine or time. */
#include <math.h>

#include "map.h"

static const char *const starts[2] = { "rest", "rotating" };
static const char *const edge_of[2] = { "release", "onset" };

/* A number, or nothing at all where there is none. */
static void csv_number(FILE *to, double x)
{
    if (isnan(x)) {
        fputc(',', to);
    } else {
        fprintf(to, "%.12g,", x);
    }
}

static void csv_cell(FILE *to, const cell *c)
{
    const kelly_tally *const t = &c->tally;

    csv_number(to, cell_probability(c));
    fprintf(to, "%.12g,%.12g,%u,%u,%u,%u,%u,%u,", c->lo, c->hi, t->samples, t->stuck, t->status[KELLY_STEP], t->status[KELLY_RANGE],
            t->status[KELLY_NONFINITE], t->liftoff);
}

/* A line a cell, weights rising, speeds rising within; onset and release are those of the weight. */
void write_map_csv(FILE *to, const driller_map *map)
{
    fputs("rpm,wob_kN,f0_kN", to);
    for (unsigned b = 0; b < 2; b++) {
        fprintf(to, ",%s_p,%s_lo95,%s_hi95,%s_samples,%s_stuck,%s_refused_step,%s_refused_range,%s_refused_nonfinite,%s_liftoff", starts[b],
                starts[b], starts[b], starts[b], starts[b], starts[b], starts[b], starts[b], starts[b]);
    }
    fputs(",release_rpm,onset_rpm\n", to);
    for (uint32_t row = 0; row < map->wob.count; row++) {
        const edge *const release = &map->edges[row], *const onset = &map->edges[map->wob.count + row];

        for (uint32_t i = 0; i < map->rpm.count; i++) {
            fprintf(to, "%.12g,%.12g,%.12g,", map->rpm.at[i], map->wob.at[row], map->f0_kN[row]);
            csv_cell(to, map_cell(map, 0, row, i));
            csv_cell(to, map_cell(map, 1, row, i));
            csv_number(to, release->rpm);
            if (isnan(onset->rpm)) {
                fputc('\n', to);
            } else {
                fprintf(to, "%.12g\n", onset->rpm);
            }
        }
    }
}

/* P, shape (2 starts, weights, speeds); NaN where every realisation was refused. */
void write_map_npy(FILE *to, const driller_map *map)
{
    const uint64_t shape[3] = { 2, map->wob.count, map->rpm.count };
    const size_t cells = 2 * (size_t)map->wob.count * map->rpm.count;

    npy_header(to, "<f8", 3, shape);
    for (size_t i = 0; i < cells; i++) {
        const double p = cell_probability(&map->cells[i]);

        fwrite(&p, sizeof(p), 1, to);
    }
}

/* ---- JSON ------------------------------------------------------------------------------------------------------- */

static void json_number(FILE *to, double x)
{
    if (isnan(x)) {
        fputs("null", to);
    } else {
        fprintf(to, "%.17g", x);
    }
}

static void json_axis(FILE *to, const char *name, const double *at, uint32_t count)
{
    fprintf(to, "  \"%s\": [", name);
    for (uint32_t i = 0; i < count; i++) {
        fprintf(to, "%s%.12g", i ? ", " : "", at[i]);
    }
    fputs("],\n", to);
}

/* What the grids of a start hold, in this order. */
enum { P, LO, HI, SAMPLES, STUCK, STEP, RANGE, NONFINITE, LIFTOFF, DIGEST, GRIDS };
static const char *const grid_names[GRIDS] = { "probability", "lo95", "hi95", "samples", "stuck", "refused_step", "refused_range",
                                               "refused_nonfinite", "liftoff", "digest" };

static void json_value(FILE *to, const cell *c, unsigned what)
{
    const kelly_tally *const t = &c->tally;
    const uint32_t counts[GRIDS] = { [SAMPLES] = t->samples, [STUCK] = t->stuck, [STEP] = t->status[KELLY_STEP],
                                     [RANGE] = t->status[KELLY_RANGE], [NONFINITE] = t->status[KELLY_NONFINITE], [LIFTOFF] = t->liftoff };

    if (what == DIGEST) {
        fprintf(to, "\"%08x\"", t->digest);
    } else if (what >= SAMPLES) {
        fprintf(to, "%u", counts[what]);
    } else {
        json_number(to, what == P ? cell_probability(c) : what == LO ? c->lo : c->hi);
    }
}

static void json_start(FILE *to, const driller_map *map, unsigned start)
{
    fprintf(to, "  \"%s\": {\n", starts[start]);
    for (unsigned what = 0; what < GRIDS; what++) {
        fprintf(to, "    \"%s\": [", grid_names[what]);
        for (uint32_t row = 0; row < map->wob.count; row++) {
            fputs(row ? ",\n      [" : "\n      [", to);
            for (uint32_t i = 0; i < map->rpm.count; i++) {
                fputs(i ? ", " : "", to);
                json_value(to, map_cell(map, start, row, i), what);
            }
            fputs("]", to);
        }
        fprintf(to, "\n    ]%s\n", what + 1 < GRIDS ? "," : "");
    }
    fputs("  },\n", to);
}

static void json_edges(FILE *to, const driller_map *map, unsigned start)
{
    const uint32_t rows = map->wob.count;
    const edge *const e = &map->edges[(size_t)start * rows];

    fprintf(to, "  \"%s_rpm\": [", edge_of[start]);
    for (uint32_t row = 0; row < rows; row++) {
        fputs(row ? ", " : "", to);
        json_number(to, e[row].rpm);
    }
    fprintf(to, "],\n  \"%s\": [", edge_of[start]);
    for (uint32_t row = 0; row < rows; row++) {
        fprintf(to, "%s\"%s\"", row ? ", " : "", edge_names[e[row].kind]);
    }
    fprintf(to, "],\n  \"%s_free_below\": [", edge_of[start]);
    for (uint32_t row = 0; row < rows; row++) {
        fprintf(to, "%s%u", row ? ", " : "", e[row].holes);
    }
    fputs(start ? "]\n" : "],\n", to);
}

static void json_case(FILE *to, const kelly_case *run)
{
    char drive[DRIVE_TEXT];

    fprintf(to, "  \"case\": {\"rpm\": %.7g, \"wob_kN\": %.7g, \"mu\": %.9g, \"alpha1\": %.9g, \"alpha2\": %.9g, \"duration_s\": %.9g, "
            "\"window_s\": [%.9g, %.9g], \"step_s\": %.9g, \"limit\": %.9g, \"torsional\": %u,\n",
            (double)kelly_string.nominal.w0 / RPM, (double)kelly_string.nominal.fc / 1000.0, (double)run->mu, (double)run->a1,
            (double)run->a2, case_seconds(run, run->ticks), case_seconds(run, run->window_first), case_seconds(run, run->window_last),
            case_seconds(run, 1), (double)run->limit, run->torsional);
    fprintf(to, "           \"drive\": \"%s\",\n", drive_text(&run->drive, drive));
    fprintf(to, "           \"cov\": {\"fc\": %.9g, \"mu\": %.9g, \"a1\": %.9g, \"a2\": %.9g, \"rpm\": %.9g}},\n", (double)run->cov[0],
            (double)run->cov[1], (double)run->cov[2], (double)run->cov[3], (double)run->cov[4]);
}

/* Grids are lists of rows: ["rest"]["probability"][weight][speed]. rpm and wob of the case: the operating point of the well file. */
void write_map_json(FILE *to, const driller_map *map, const study *s, int f0_given)
{
    const options *const opts = s->opts;

    fprintf(to, "{\n  \"model\": \"%s\",\n  \"real\": \"%s\",\n  \"seed\": %llu,\n  \"first\": %u,\n  \"samples\": %u,\n", kelly_string.id,
            sizeof(real) > 4 ? "double" : "float", (unsigned long long)opts->seed, opts->first, opts->samples);
    fputs("  \"adaptive_width\": ", to);
    json_number(to, s->width > 0 ? s->width : (double)NAN);
    fputs(",\n", to);
    json_axis(to, "rpm", map->rpm.at, map->rpm.count);
    json_axis(to, "wob_kN", map->wob.at, map->wob.count);
    json_axis(to, "f0_kN", map->f0_kN, map->wob.count);
    fprintf(to, "  \"f0_by\": \"%s\",\n", f0_given ? "--f0" : "ratio of the well file");
    json_case(to, &opts->run);
    json_start(to, map, 0);
    json_start(to, map, 1);
    json_axis(to, "scan_rpm", map->scan.at, map->scan.count);
    json_edges(to, map, 0);
    json_edges(to, map, 1);
    fputs("}\n", to);
}
