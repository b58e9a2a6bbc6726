/* edges.c - layout of a map, and where the nominal run stops sticking.
 *
 * From rest the string sticks up to the release speed; once it rotates it sticks only below the onset speed, which is lower:
 * between the two the start decides. Every run of the search is a cell of its own, so it runs on all threads and lies in
 * the journal like the rest.
 */
#include <math.h>
#include <stdlib.h>

#include "map.h"

#define SCANNED 41u              /* speeds of the scan at most */
#define TENTH 0.1                /* resolution of an edge [rpm] */

const char *const edge_names[4] = { "found", "above", "below", "refused" };

/* Tenths of a rpm from speed k of the scan to the next, the last one perhaps shorter. */
static uint32_t tenths(const axis *scan, uint32_t k)
{
    return (uint32_t)ceil((scan->at[k + 1] - scan->at[k]) / TENTH - 1e-9);
}

/* Speed j tenths above speed k of the scan; the next speed itself at the end. */
static double between(const axis *scan, uint32_t k, uint32_t j)
{
    return j >= tenths(scan, k) ? scan->at[k + 1] : decimal(scan->at[k] + TENTH * (double)j);
}

static unsigned rounds_of(const axis *scan)
{
    uint32_t most = 1;
    unsigned rounds = 0;

    for (uint32_t k = 0; k + 1 < scan->count; k++) {
        most = tenths(scan, k) > most ? tenths(scan, k) : most;
    }
    for (; most > 1; most = (most + 1) / 2) {
        rounds++;
    }
    return rounds;
}

static cell setting(const driller_map *map, unsigned rotating, uint32_t row, double rpm, int nominal)
{
    return (cell){ .rpm = rpm, .wob_kN = map->wob.at[row], .f0_kN = map->f0_kN[row], .rotating = (uint8_t)rotating,
                   .nominal = (uint8_t)nominal, .hi = 1.0 };
}

/* Both starts, all rows, these speeds. */
static cell *lay_out(const driller_map *map, cell *at, const axis *speeds, int nominal)
{
    for (unsigned rotating = 0; rotating < 2; rotating++) {
        for (uint32_t row = 0; row < map->wob.count; row++) {
            for (uint32_t i = 0; i < speeds->count; i++) {
                *at++ = setting(map, rotating, row, speeds->at[i], nominal);
            }
        }
    }
    return at;
}

int map_lay_out(driller_map *map, const options *opts, int f0_given)
{
    const uint32_t rows = map->wob.count;

    map->scan = axis_thinned(&map->rpm, SCANNED);
    map->rounds = rounds_of(&map->scan);
    map->records = 2 * rows * (map->rpm.count + map->scan.count + map->rounds);
    map->cells = calloc(map->records, sizeof(cell));
    map->edges = calloc(2 * (size_t)rows, sizeof(edge));
    map->f0_kN = calloc(rows, sizeof(double));
    if (!map->cells || !map->edges || !map->f0_kN) {
        return 0;
    }
    for (uint32_t row = 0; row < rows; row++) {
        map->f0_kN[row] = f0_at(opts, f0_given, map->wob.at[row]);
    }
    (void)lay_out(map, lay_out(map, map->cells, &map->rpm, 0), &map->scan, 1);
    return 1;
}

const cell *map_cell(const driller_map *map, unsigned rotating, uint32_t row, uint32_t column)
{
    return &map->cells[((size_t)rotating * map->wob.count + row) * map->rpm.count + column];
}

/* A search under way: sticks `lo` tenths above speed k, free `hi` tenths above it. */
typedef struct {
    uint32_t k, lo, hi;
} bracket;

/* What the scan says of one start and row: no edge within it, or where to bisect. */
static void look_at_scan(const driller_map *map, const cell *run, edge *e, bracket *b)
{
    const uint32_t last = map->scan.count - 1;
    uint32_t stuck = 0;          /* one more than the highest speed that sticks */

    *e = (edge){ .kind = EDGE_FOUND, .rpm = (double)NAN };
    for (uint32_t i = 0; i <= last; i++) {
        stuck = run[i].tally.stuck ? i + 1 : stuck;
        e->kind = kelly_refused(&run[i].tally) ? EDGE_REFUSED : e->kind;
    }
    for (uint32_t i = 0; i + 1 < stuck; i++) {
        e->holes += !run[i].tally.stuck;
    }
    if (e->kind == EDGE_FOUND) {
        e->kind = stuck == 0 ? EDGE_BELOW : stuck > last ? EDGE_ABOVE : EDGE_FOUND;
    }
    if (e->kind == EDGE_FOUND) {
        *b = (bracket){ .k = stuck - 1, .lo = 0, .hi = tenths(&map->scan, stuck - 1) };
    }
}

static int unfinished(const edge *e, const bracket *b)
{
    return e->kind == EDGE_FOUND && b->hi - b->lo > 1;
}

/* One halving of every bracket; `at`: the cells of this round. */
static void halve(const study *s, driller_map *map, bracket *brackets, cell *at)
{
    const uint32_t rows = map->wob.count;

    for (uint32_t i = 0; i < 2 * rows; i++) {
        const bracket *const b = &brackets[i];

        if (unfinished(&map->edges[i], b)) {   /* its tally may have come from a journal: the setting alone is set */
            cell c = setting(map, i / rows, i % rows, between(&map->scan, b->k, (b->lo + b->hi) / 2), 1);

            c.tally = at[i].tally;
            at[i] = c;
        }
    }
    cells_run(s, at, 2 * rows, (uint32_t)(at - map->cells));
    for (uint32_t i = 0; i < 2 * rows; i++) {
        bracket *const b = &brackets[i];
        const uint32_t middle = (b->lo + b->hi) / 2;

        if (!unfinished(&map->edges[i], b)) {
            continue;
        }
        if (kelly_refused(&at[i].tally)) {
            map->edges[i].kind = EDGE_REFUSED;
        } else if (at[i].tally.stuck) {
            b->lo = middle;
        } else {
            b->hi = middle;
        }
    }
}

void edges_find(const study *s, driller_map *map)
{
    const uint32_t rows = map->wob.count;
    cell *const scan = map->cells + 2 * (size_t)rows * map->rpm.count, *const first = scan + 2 * (size_t)rows * map->scan.count;
    bracket *const brackets = calloc(2 * (size_t)rows, sizeof(*brackets));
    study quiet = *s;

    if (!brackets) {
        die(EXIT_FAILED, "out of memory");
    }
    quiet.silent = 1;
    for (uint32_t i = 0; i < 2 * rows; i++) {
        look_at_scan(map, scan + (size_t)i * map->scan.count, &map->edges[i], &brackets[i]);
    }
    for (unsigned round = 0; round < map->rounds; round++) {
        halve(&quiet, map, brackets, first + (size_t)round * 2 * rows);
    }
    for (uint32_t i = 0; i < 2 * rows; i++) {
        if (map->edges[i].kind == EDGE_FOUND) {
            map->edges[i].rpm = between(&map->scan, brackets[i].k, brackets[i].hi);
        }
    }
    free(brackets);
}
