/* map.h - probabilities at many settings: what `kelly map` and `kelly advise` share.
 *
 * A cell is one setting (speed, weight, start). Its first n realisations are those of `montecarlo --samples n` at that
 * setting, bit for bit, digest included: every cell sees the same draws (seed, index), so the map is smooth, and two
 * cells differ by their setting alone.
 *
 * Settings are decimal numbers as one would type them (decimal()), so that `montecarlo --rpm X` with the printed X is the same
 * cell.
 */
#ifndef KELLY_MAP_H
#define KELLY_MAP_H

#include "host.h"
#include "journal.h"

#define CELLS_MAX 1000000u       /* of one map: about 200 MB with both starts */
#define CELL_PAYLOAD 32u         /* bytes of a cell in a journal */

typedef struct {
    double rpm, wob_kN, f0_kN;   /* rpm 0: not a cell, nothing to be run */
    uint8_t rotating;            /* start */
    uint8_t nominal;             /* one run with nothing random instead of an ensemble */
    kelly_tally tally;
    double lo, hi;               /* 95 % interval of the tally */
} cell;

/* How cells are run. */
typedef struct {
    const options *opts;         /* case, seed, first, threads; samples: of every cell, the most of one where adaptive */
    const kelly_engine *engine;
    double width;                /* adaptive: a cell is done once its interval is narrower; 0: every cell runs all samples */
    journal *log;                /* or 0 */
    int silent;                  /* no progress */
} study;

/* Run cells[0..count-1] to their ends, from where their tallies stand. `record`: index of cells[0] in the journal. */
void cells_run(const study *s, cell *cells, uint32_t count, uint32_t record);

/* The other processes of a team: run what cells_run of the first one gives, until that lets them go. */
void cells_follow(const study *s);

/* The case of a cell. */
kelly_case cell_case(const study *s, const cell *c);

/* Whether any realisation of it can be trusted. */
int cell_trusted(const cell *c);

/* P, or NaN where every realisation was refused. */
double cell_probability(const cell *c);

/* A tally as a payload and back (with its interval). */
void cell_pack(const cell *c, uint8_t payload[CELL_PAYLOAD]);
void cell_unpack(cell *c, const uint8_t payload[CELL_PAYLOAD]);

/* Whether a payload is a tally that can be. */
int cell_sound(const void *payload, size_t size);

/* Tallies that a journal holds of an earlier run; cells[i] is record i. */
void cells_recall(journal *log, cell *cells);

/* How many realisations make an interval narrower than `width` whatever P is. */
uint32_t samples_for_width(double width);

/* ---- grids --------------------------------------------------------------------------------------------------- */

/* Rising values. */
typedef struct {
    uint32_t count;
    double *at;
} axis;

/* x to 12 significant decimal digits: what "%.12g" prints and strtod reads. */
double decimal(double x);

/* FROM:TO:STEP (TO included where it lies on the grid) or one value, all within lo..hi; dies with exit 2 on anything else. */
axis axis_parse(const char *option, const char *text, double lo, double hi, const char *unit);

/* At most `most` speeds over the range of a: a itself, or evenly spaced ones. */
axis axis_thinned(const axis *a, uint32_t most);

/* Amplitude of the weight [kN] at a weight: the well's ratio, or what --f0 says. */
double f0_at(const options *opts, int f0_given, double wob_kN);

/* Take an option of the subcommand's own out of argv: its last value, "" for --resume, or 0 where it is not there. Dies with
 * exit 2 where a value is missing. For what options_parse cannot hand over: flags, and names that it knows in another form. */
const char *take_option(int *argc, char **argv, const char *name);

/* Whether argv has this option. */
int has_option(int argc, char **argv, const char *name);

/* ---- onset and release --------------------------------------------------------------------------------------- */

/* Where the nominal run stops sticking as the speed rises. Searched from above: the highest speed of a scan at which it sticks, then
 * bisection in tenths of a rpm up to the next speed of the scan. Assumes that it changes once between two speeds of the scan. */
typedef enum { EDGE_FOUND, EDGE_ABOVE, EDGE_BELOW, EDGE_REFUSED } edge_kind;

typedef struct {
    edge_kind kind;              /* above: sticks at the highest speed; below: at none; refused: a run of the search could not be trusted */
    double rpm;                  /* FOUND: free here, sticks 0.1 rpm below (or less, at the end of a scan interval); NaN otherwise */
    uint32_t holes;              /* speeds of the scan below it at which it is free all the same */
} edge;

extern const char *const edge_names[4];

/* A map: all that is computed, in the order of its journal. */
typedef struct {
    axis rpm, wob, scan;
    unsigned rounds;             /* of the bisection, at most */
    double *f0_kN;               /* [wob] */
    uint32_t records;
    cell *cells;                 /* [records]: [2 starts, wob, rpm], then nominal: [2, wob, scan], [rounds, 2, wob] */
    edge *edges;                 /* [2, wob]: release (from rest), onset (already rotating) */
} driller_map;

/* Axes are set: the rest of the map, every cell with its setting, none run. Returns 0 where memory is short. */
int map_lay_out(driller_map *map, const options *opts, int f0_given);

/* Cell of a start (0 rest, 1 rotating), row and column. */
const cell *map_cell(const driller_map *map, unsigned rotating, uint32_t row, uint32_t column);

void edges_find(const study *s, driller_map *map);

/* ---- files --------------------------------------------------------------------------------------------------- */

void write_map_csv(FILE *to, const driller_map *map);
void write_map_npy(FILE *to, const driller_map *map);
void write_map_json(FILE *to, const driller_map *map, const study *s, int f0_given);
void print_map(const driller_map *map, const study *s);

#endif
