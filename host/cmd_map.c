/* cmd_map.c - the driller's map: P(stick-slip) over speed and weight, from rest and already rotating. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "../firmware/link/crc32c.h"
#include "map.h"
#include "outcome.h"
#include "team.h"

#define WIDTH_MIN 0.002          /* of --adaptive: a million realisations in the worst cell */

/* What the command line asked for. */
typedef struct {
    options opts;
    study how;
    driller_map map;
    const char *npy;
    int f0_given;
    journal log;
} map_run;

static const option_help map_options[] = {
    { "--rpm", "FROM:TO:STEP", "speeds [rpm], or one (default 40:140:5)" },
    { "--wob", "FROM:TO:STEP", "weights on bit [kN], or one (default 25:225:10)" },
    { "--f0", "F", "amplitude of the weight [kN] in every cell (default: its ratio to the weight stays the well file's)" },
    { "--npy", "F", "P as float64, shape (2 starts: rest and rotating, weights, speeds); - is stdout" },
    { "--adaptive", "W", "a cell ends once its interval is narrower than W, 0.002..1, or P is shown to lie on one side of 0.5; at most --samples "
      "each (default: as many as W needs)" },
    { "--samples", "N", "realisations of every cell (default 400)" },
    { "--csv", "F", "a line a cell; - is stdout" },
    { "--cov", "D", "coefficients of variation 0..0.5: one for all, or fc=D,mu=D,a1=D,a2=D,rpm=D (default: the well file's)" },
    { "--seed", "S", "of the random streams (default 1)" },
    { "--first", "J", "index of the first realisation (default 0)" },
    { "--threads", "T", "threads (default: one a processor); no result depends on it" },
    { "--engine", "NAME", "vector unit: scalar, sse2, avx2, avx512 (default: the widest here); no result depends on it" },
    { "--twice", 0, TWICE_HELP },
    { 0 },
};

const command_help map_help = {
    .brief = "P(stick-slip) over speed and weight, from rest and already rotating",
    .synopsis = "[--rpm A:B:S] [--wob A:B:S] [--samples N] [case] [--json F] [--csv F] [--npy F] [--resume] ...",
    .takes = TAKES_CASE | TAKES_JSON | TAKES_RESUME,
    .without = "--start",
    .own = map_options,
    .notes = "Every cell runs the same realisations, those of montecarlo with its speed, weight, f0 and start, bit for bit.\n"
             "CSV: a line a cell; rest_* and rotating_*: p, lo95, hi95, samples, stuck, refused_*, liftoff.\n"
             "JSON: grids [weight][speed] under rest and rotating, digest included; NPY: P.\n"
             "release_rpm, onset_rpm: the speed at which the nominal run from rest, or already rotating, stops sticking: free there, stuck\n"
             "0.1 rpm below. Searched downwards through the speeds of the grid (41 at most), then by bisection; empty where it is out of\n"
             "range. JSON says which (above: stuck at all speeds; below: at none) and counts lower speeds that are free all the same.\n"
             "OUTPUT.journal beside the first output holds what is done and goes when all is written.",
    .example = "kelly map --mu 0.004 --rpm 40:140:5 --wob 25:225:10 --csv map.csv --json map.json",
};

/* ---- what is asked for -------------------------------------------------------------------------------------------- */

static void check_output(const char *path)
{
    char directory[4096];
    const char *const slash = strrchr(path, '/');

    if (strcmp(path, "-") == 0) {
        return;
    }
    snprintf(directory, sizeof(directory), "%.*s", slash ? (int)(slash - path) + 1 : 1, slash ? path : ".");
    if (access(directory, W_OK | X_OK) != 0) {
        die(EXIT_FAILED, "%s: cannot write here: there is no such directory, or it may not be written", path);
    }
}

static void parse_adaptive(map_run *m, const char *width, int samples_given)
{
    if (!width) {
        return;
    }
    m->how.width = option_number("--adaptive", width, WIDTH_MIN, 1.0, "the width of an interval, 0.002..1");
    if (!samples_given) {
        m->opts.samples = samples_for_width(m->how.width);
    }
}

static void parse(map_run *m, int argc, char **argv)
{
    const char *const rpm = take_option(&argc, argv, "--rpm"), *const wob = take_option(&argc, argv, "--wob");
    const char *const width = take_option(&argc, argv, "--adaptive");
    const int samples_given = has_option(argc, argv, "--samples");

    m->npy = take_option(&argc, argv, "--npy");
    m->f0_given = has_option(argc, argv, "--f0");
    if (has_option(argc, argv, "--start") || has_option(argc, argv, "--convergence")) {
        die(EXIT_USAGE, "map: %s does not belong here%s", has_option(argc, argv, "--start") ? "--start" : "--convergence",
            has_option(argc, argv, "--start") ? ": a map shows both starts" : "; see kelly map --help");
    }
    options_parse(&m->opts, argc, argv, TAKES_CASE | TAKES_ENSEMBLE | TAKES_JSON | TAKES_RESUME, "map", 0, 0);
    parse_adaptive(m, width, samples_given);
    check_indices(&m->opts);
    m->map.rpm = axis_parse("--rpm", rpm ? rpm : "40:140:5", 1e-3, 1e4, "rpm");
    m->map.wob = axis_parse("--wob", wob ? wob : "25:225:10", 1e-3, 1e6, "kN");
    if ((uint64_t)m->map.rpm.count * m->map.wob.count > CELLS_MAX) {
        die(EXIT_USAGE, "map: %u speeds x %u weights are %llu cells; at most %u, give longer steps", m->map.rpm.count, m->map.wob.count,
            (unsigned long long)m->map.rpm.count * m->map.wob.count, CELLS_MAX);
    }
    m->how.opts = &m->opts;
    m->how.engine = engine_choose(m->opts.engine);
}

/* ---- journal --------------------------------------------------------------------------------------------------------- */

/* CRC-32C of all that the cells depend on: case, grid, samples. Numbers as hexadecimal floats, exact. */
static uint32_t parameters(const map_run *m)
{
    char text[64];
    uint32_t crc = case_identity(&m->opts.run);

    for (unsigned a = 0; a < 2; a++) {
        const axis *const at = a ? &m->map.wob : &m->map.rpm;

        for (uint32_t i = 0; i < at->count; i++) {
            const int n = snprintf(text, sizeof(text), "%a%c", at->at[i], i + 1 < at->count ? ',' : ';');

            crc = kelly_crc32c(crc, (const uint8_t *)text, (size_t)n);
        }
    }
    snprintf(text, sizeof(text), "%u %u %a f0 %d", m->opts.samples, m->opts.first, m->how.width, m->f0_given);
    return kelly_crc32c(crc, (const uint8_t *)text, strlen(text));
}

static void open_journal(map_run *m)
{
    const char *const outputs[3] = { m->opts.csv, m->opts.json, m->npy };
    const char *const beside = first_output(&m->opts, outputs, 3, "--csv, --json or --npy");

    check_outputs(outputs, 3);
    for (unsigned i = 0; i < 3; i++) {
        if (outputs[i]) {
            check_output(outputs[i]);
        }
    }
    if (beside) {
        journal_open(&m->log, beside, &(journal_run){ .kind = "map", .model = kelly_string.id, .seed = m->opts.seed, .parameters = parameters(m),
                     .records = m->map.records, .payload = CELL_PAYLOAD, .twice = m->opts.twice, .sound = cell_sound }, m->opts.resume);
        cells_recall(&m->log, m->map.cells);
        m->how.log = &m->log;
    }
}

/* ---- output ------------------------------------------------------------------------------------------------------------ */

static void write_outputs(const map_run *m)
{
    outfile csv, json, npy;

    if (m->opts.csv) {
        outfile_open(&csv, m->opts.csv);
        write_map_csv(csv.stream, &m->map);
        outfile_close(&csv);
    }
    if (m->opts.json) {
        outfile_open(&json, m->opts.json);
        write_map_json(json.stream, &m->map, &m->how, m->f0_given);
        outfile_close(&json);
    }
    if (m->npy) {
        outfile_open(&npy, m->npy);
        write_map_npy(npy.stream, &m->map);
        outfile_close(&npy);
    }
}

static int on_stdout(const char *path)
{
    return path && strcmp(path, "-") == 0;
}

/* A map without one P is no answer. What would help is told of a cell within the table, where there is one: there it is the step. */
static int answered(const map_run *m)
{
    const size_t cells = 2 * (size_t)m->map.wob.count * m->map.rpm.count;
    const cell *of = m->map.cells;
    char text[ADVICE_TEXT];
    kelly_case run;

    for (size_t i = 0; i < cells; i++) {
        const cell *const c = &m->map.cells[i];

        if (cell_trusted(c)) {
            return EXIT_DONE;
        }
        of = c->tally.status[KELLY_RANGE] < of->tally.status[KELLY_RANGE] ? c : of;
    }
    run = cell_case(&m->how, of);
    fprintf(stderr, "kelly: map: no answer: no realisation of any cell can be trusted: %s\n", advice_on(&run, &of->tally, text));
    return EXIT_FAILED;
}

int command_map(int argc, char **argv)
{
    static map_run m;
    uint32_t ensembles;

    parse(&m, argc, argv);
    if (!map_lay_out(&m.map, &m.opts, m.f0_given)) {
        die(EXIT_FAILED, "map: out of memory for %u cells; give a smaller grid", m.map.rpm.count * m.map.wob.count);
    }
    if (team_rank() > 0) {
        cells_follow(&m.how);
        return EXIT_DONE;
    }
    open_journal(&m);
    ensembles = 2 * m.map.wob.count * (m.map.rpm.count + m.map.scan.count);
    cells_run(&m.how, m.map.cells, ensembles, 0);
    edges_find(&m.how, &m.map);
    team_dismiss();
    write_outputs(&m);
    journal_remove(&m.log);
    if (!m.opts.quiet && !on_stdout(m.opts.csv) && !on_stdout(m.opts.json) && !on_stdout(m.npy)) {
        print_map(&m.map, &m.how);
    }
    return answered(&m);
}
