/* map_screen.c - a map in figures on the screen. */
#include <math.h>

#include "map.h"

#define COLUMNS 24u              /* wider and higher grids are left to the files */
#define ROWS 60u

/* P of one start in per cent, the heaviest weight on top as in the picture; - where every realisation was refused. */
static void print_start(const driller_map *map, unsigned start)
{
    printf("\nP(stick-slip | %s) in %%\n  kN \\ rpm", start ? "already rotating" : "started from rest");
    for (uint32_t i = 0; i < map->rpm.count; i++) {
        printf(" %5.4g", map->rpm.at[i]);
    }
    for (uint32_t row = map->wob.count; row-- > 0;) {
        printf("\n%10.4g", map->wob.at[row]);
        for (uint32_t i = 0; i < map->rpm.count; i++) {
            const cell *const c = map_cell(map, start, row, i);
            const double p = cell_probability(c);

            if (isnan(p)) {
                printf("     -");
            } else {
                printf(" %s%5.0f%s", ink(stdout, c->lo > 0.5 ? "31" : c->hi < 0.05 ? "32" : "33"), 100.0 * p, ink(stdout, "0"));
            }
        }
    }
    putchar('\n');
}

static void print_edge(const edge *e, const axis *scan)
{
    char text[40];

    if (e->kind == EDGE_FOUND) {
        snprintf(text, sizeof(text), "%.1f", e->rpm);
    } else if (e->kind == EDGE_REFUSED) {
        snprintf(text, sizeof(text), "refused");
    } else {
        snprintf(text, sizeof(text), e->kind == EDGE_ABOVE ? "> %.4g" : "< %.4g", scan->at[e->kind == EDGE_ABOVE ? scan->count - 1 : 0]);
    }
    printf(" %12s%s", text, e->holes ? "*" : " ");
}

static void print_edges(const driller_map *map)
{
    uint32_t holes = 0;

    printf("\nNominal case: from rest it sticks below the release speed, already rotating below the onset speed [rpm]\n"
           "        kN      release        onset\n");
    for (uint32_t row = map->wob.count; row-- > 0;) {
        const edge *const release = &map->edges[row], *const onset = &map->edges[map->wob.count + row];

        printf("%10.4g", map->wob.at[row]);
        print_edge(release, &map->scan);
        print_edge(onset, &map->scan);
        putchar('\n');
        holes += release->holes + onset->holes;
    }
    if (holes > 0) {
        puts("* free at some lower speeds too");
    }
}

void print_map(const driller_map *map, const study *s)
{
    const size_t cells = 2 * (size_t)map->wob.count * map->rpm.count;
    uint64_t samples = 0, refused = 0, by[KELLY_STATUSES] = { 0 };
    size_t touched = 0;

    printf("%s, mu %.6g, %u cells of %u speeds and %u weights, %s%u samples each, seed %llu\n", kelly_string.id, (double)s->opts->run.mu,
           map->rpm.count * map->wob.count, map->rpm.count, map->wob.count, s->width > 0 ? "at most " : "", s->opts->samples,
           (unsigned long long)s->opts->seed);
    if (map->rpm.count <= COLUMNS && map->wob.count <= ROWS) {
        print_start(map, 0);
        print_start(map, 1);
    } else {
        puts("(too large for the screen: see --csv, --json, --npy)");
    }
    if (map->wob.count <= ROWS) {
        print_edges(map);
    }
    for (size_t i = 0; i < cells; i++) {
        const uint32_t no = kelly_refused(&map->cells[i].tally);

        samples += map->cells[i].tally.samples;
        refused += no;
        touched += no > 0;
        for (unsigned k = 0; k < KELLY_STATUSES; k++) {
            by[k] += map->cells[i].tally.status[k];
        }
    }
    printf("\n%llu realisations, refused %llu in %zu of %zu cells (step %llu, range %llu, nonfinite %llu)\n", (unsigned long long)samples,
           (unsigned long long)refused, touched, cells, (unsigned long long)by[KELLY_STEP], (unsigned long long)by[KELLY_RANGE],
           (unsigned long long)by[KELLY_NONFINITE]);
}
