/* cells.c - cells over the threads of one machine.
 *
 * The realisations of a cell still to come, up to SEGMENT, are cut into pieces of whole vectors. A thread takes a piece of a cell
 * that is under way, or else begins the next cell; who finishes the last piece of a segment adds it up, in the order
 * of the indices, writes it to the journal, and opens the cell's next segment. So both the only cell of a map and the last of
 * many keep all threads busy, and no order of execution can show. The other processes of a team take pieces in the same way.
 */
#include <math.h>
#include <pthread.h>
#include <stdlib.h>
#include <time.h>

#include "map.h"
#include "team.h"

#define SEGMENT 16384u           /* realisations of a cell whose results are in memory at once */
#define FIRST_LOOK 32u           /* adaptive: realisations before the first decision */
#define SHOW 0.25                /* [s] between two lines of progress */
#define LOOKS 48.0               /* there are fewer up to 2^32: 32 1.5^k */

/* Part of a cell that is under way; cell 0: a free place. */
typedef struct {
    cell *cell;
    kelly_case run;
    uint32_t base, count;        /* realisations of this segment: the first, how many */
    uint32_t vectors, pieces, next, left;
    kelly_result *results;
} segment;

typedef struct {
    const study *s;
    cell *cells;
    uint32_t count, record;
    uint32_t begun, done;        /* cells */
    uint32_t before;             /* done by an earlier run */
    unsigned places;
    segment *at;                 /* [places], one a piece that is under way is enough: see take_piece */
    int watched;                 /* progress is shown */
    double start, shown;         /* [s] */
    pthread_mutex_t lock;
    pthread_cond_t changed;
} workshop;

/* The width is largest at P = 1/2, about 1.96 / sqrt n + 1 / n, which is `width` at n = 3.84 / width^2 + 2 / width; a little is added. */
uint32_t samples_for_width(double width)
{
    return (uint32_t)ceil(3.9 / (width * width) + 4.0 / width);
}

/* ---- adaptive: when to look, when to stop -------------------------------------------------------------------------- */

/* The first look after n realisations: 32, 64, 96, 160, 256, 384, ...: times 1.5, whole vectors of any width. */
static uint32_t look_after(uint32_t n)
{
    uint64_t look = FIRST_LOOK;

    while (look <= n) {
        look = (look + look / 2 + 31) / 32 * 32;
    }
    return look < UINT32_MAX ? (uint32_t)look : UINT32_MAX;
}

/* Which side of 0.5 P is on has been decided, at 95 % over all looks together: the tail is shared out among them. */
static int decided(const kelly_tally *t)
{
    const double tail = 0.025 / LOOKS;

    return kelly_binomial_lo(t->stuck, t->samples, tail) > 0.5 || kelly_binomial_hi(t->stuck + kelly_refused(t), t->samples, tail) < 0.5;
}

/* Realisations that this cell needs next; 0 where it is done. */
static uint32_t still_to_run(const study *s, const cell *c)
{
    const uint32_t n = c->tally.samples;
    uint32_t aim = c->nominal ? 1 : s->opts->samples;

    if (!(c->rpm > 0) || n >= aim) {
        return 0;
    }
    if (s->width > 0 && !c->nominal) {
        const int looking = n > 0 && look_after(n - 1) == n;

        if (looking && (c->hi - c->lo < s->width || decided(&c->tally))) {
            return 0;
        }
        aim = look_after(n) < aim ? look_after(n) : aim;
    }
    return aim - n < SEGMENT ? aim - n : SEGMENT;
}

/* ---- the threads ----------------------------------------------------------------------------------------------------- */

/* As few pieces as blocks hold the segment, of equal size but for one vector. */
static void open_segment(const workshop *w, segment *g, cell *c, uint32_t count)
{
    const uint32_t width = w->s->engine->width, whole = engine_lanes(w->s->engine, &w->s->opts->run) / width;

    g->cell = c;
    g->run = cell_case(w->s, c);
    g->base = w->s->opts->first + c->tally.samples;
    g->count = count;
    g->vectors = (count + width - 1) / width;
    g->pieces = (g->vectors + whole - 1) / whole;
    g->next = 0;
    g->left = g->pieces;
}

static uint32_t piece_start(const workshop *w, const segment *g, uint32_t piece)
{
    const uint32_t base = g->vectors / g->pieces, rest = g->vectors % g->pieces;
    const uint32_t start = (piece * base + (piece < rest ? piece : rest)) * w->s->engine->width;

    return start < g->count ? start : g->count;
}

/* Begin the next cell that is not done already. */
static int begin_cell(workshop *w, segment *g)
{
    while (w->begun < w->count) {
        cell *const c = &w->cells[w->begun++];
        const uint32_t count = still_to_run(w->s, c);

        if (count > 0) {
            open_segment(w, g, c, count);
            return 1;
        }
        w->done++;
    }
    return 0;
}

/* A piece of a cell under way, else of a new one. With a place for every piece that can be under way there is one free whenever it is
 * needed: a place without a piece to give away is kept by one that somebody works on. */
static segment *take_piece(workshop *w, uint32_t *piece)
{
    segment *open = 0, *unused = 0;

    for (unsigned i = 0; i < w->places && !open; i++) {
        if (!w->at[i].cell) {
            unused = &w->at[i];
        } else if (w->at[i].next < w->at[i].pieces) {
            open = &w->at[i];
        }
    }
    if (!open && unused && begin_cell(w, unused)) {
        open = unused;
    }
    *piece = open ? open->next++ : 0;
    return open;
}

/* All pieces of a segment are there: add them up, write it down, go on with the cell. */
static void close_segment(workshop *w, segment *g)
{
    cell *const c = g->cell;
    uint32_t more;

    for (uint32_t i = 0; i < g->count; i++) {
        check_intact(&g->results[i], g->base + i);
        kelly_tally_add(&c->tally, g->base + i, &g->results[i]);
    }
    kelly_interval(&c->tally, &c->lo, &c->hi);
    if (w->s->log) {
        uint8_t payload[CELL_PAYLOAD];

        cell_pack(c, payload);
        journal_append(w->s->log, w->record + (uint32_t)(c - w->cells), 1, payload);
    }
    more = still_to_run(w->s, c);
    if (more > 0) {
        open_segment(w, g, c, more);
    } else {
        g->cell = 0;
        w->done++;
    }
    pthread_cond_broadcast(&w->changed);
}

static void run_piece(const workshop *w, const segment *g, uint32_t piece, void *work)
{
    const uint32_t from = piece_start(w, g, piece), to = piece_start(w, g, piece + 1);

    engine_run(w->s->engine, w->s->opts, &g->run, g->base + from, to - from, &g->results[from], work);
}

static void *worker(void *context)
{
    workshop *const w = context;
    void *work = 0;

    if (posix_memalign(&work, 64, w->s->engine->work_size) != 0) {
        die(EXIT_FAILED, "out of memory");
    }
    pthread_mutex_lock(&w->lock);
    for (;;) {
        uint32_t piece;
        segment *const g = take_piece(w, &piece);

        if (g) {
            pthread_mutex_unlock(&w->lock);
            run_piece(w, g, piece, work);
            pthread_mutex_lock(&w->lock);
            if (--g->left == 0) {
                close_segment(w, g);
            }
        } else if (w->done == w->count) {
            break;
        } else {
            pthread_cond_wait(&w->changed, &w->lock);   /* a cell under way may have more to give */
        }
    }
    pthread_cond_broadcast(&w->changed);
    pthread_mutex_unlock(&w->lock);
    free(work);
    return 0;
}

/* ---- the other processes of a team --------------------------------------------------------------------------------- */

static int give_piece(void *context, errand *e)
{
    workshop *const w = context;
    segment *g;
    uint32_t piece;

    pthread_mutex_lock(&w->lock);
    g = take_piece(w, &piece);
    pthread_mutex_unlock(&w->lock);
    if (g) {
        const uint32_t from = piece_start(w, g, piece), to = piece_start(w, g, piece + 1);

        *e = (errand){ .input = &g->run, .input_size = sizeof(g->run), .first = g->base + from, .count = to - from,
                       .results = &g->results[from], .number = (uint32_t)(g - w->at) };
    }
    return g != 0;
}

static void take_back(void *context, const errand *e)
{
    workshop *const w = context;

    pthread_mutex_lock(&w->lock);
    if (--w->at[e->number].left == 0) {
        close_segment(w, &w->at[e->number]);
    }
    pthread_mutex_unlock(&w->lock);
}

typedef struct {
    const study *s;
    void *work;
} follower;

static void run_errand(void *context, const errand *e)
{
    const follower *const f = context;

    engine_run(f->s->engine, f->s->opts, e->input, e->first, e->count, e->results, f->work);
}

void cells_follow(const study *s)
{
    follower f = { s, 0 };

    if (posix_memalign(&f.work, 64, s->engine->work_size) != 0) {
        die(EXIT_FAILED, "out of memory");
    }
    team_follow(run_errand, &f, sizeof(kelly_result));
    free(f.work);
}

/* ---- all ------------------------------------------------------------------------------------------------------------- */

static double now(void)
{
    struct timespec t;

    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Where it is due; the lock is held. */
static void show(workshop *w)
{
    if (w->watched && w->done < w->count && now() - w->shown > SHOW) {
        w->shown = now();
        progress_show(w->s->opts, w->done > w->before ? w->done - w->before : 0, w->count - w->before, w->shown - w->start);
    }
}

static int cells_over(void *context)
{
    workshop *const w = context;
    int over;

    pthread_mutex_lock(&w->lock);
    show(w);
    over = w->done == w->count;
    pthread_mutex_unlock(&w->lock);
    return over;
}

/* Until all cells are done. */
static void watch(workshop *w)
{
    struct timespec until;

    pthread_mutex_lock(&w->lock);
    while (w->done < w->count) {
        show(w);
        clock_gettime(CLOCK_REALTIME, &until);
        until.tv_nsec += (long)(1e9 * SHOW / 2);
        until.tv_sec += until.tv_nsec / 1000000000;
        until.tv_nsec %= 1000000000;
        pthread_cond_timedwait(&w->changed, &w->lock, &until);
    }
    pthread_mutex_unlock(&w->lock);
}

static void run_threads(workshop *w, unsigned threads, pthread_t *ids)
{
    for (unsigned t = 0; t < threads; t++) {
        if (pthread_create(&ids[t], 0, worker, w) != 0) {
            die(EXIT_FAILED, "cannot start thread %u of %u; give fewer --threads", t + 1, threads);
        }
    }
    if (team_others() > 0) {
        team_lead(&(team_source){ w, give_piece, take_back, cells_over, sizeof(kelly_result) });
    } else if (w->watched) {
        watch(w);
    }
    for (unsigned t = 0; t < threads; t++) {
        pthread_join(ids[t], 0);
    }
    if (w->watched) {
        progress_end(w->s->opts, w->count - w->before, now() - w->start);
    }
}

void cells_run(const study *s, cell *cells, uint32_t count, uint32_t record)
{
    const unsigned threads = threads_of(s->opts), places = threads + TEAM_DEPTH * team_others();
    const uint32_t most = s->opts->samples < SEGMENT ? s->opts->samples : SEGMENT;
    workshop w = { .s = s, .cells = cells, .count = count, .record = record, .places = places, .at = calloc(places, sizeof(segment)),
                   .watched = !s->silent && progress_wanted(s->opts), .start = now(), .shown = now() };
    kelly_result *const results = calloc((size_t)places * most, sizeof(kelly_result));
    pthread_t *const ids = calloc(threads, sizeof(*ids));

    if (!w.at || !results || !ids) {
        die(EXIT_FAILED, "out of memory");
    }
    for (uint32_t i = 0; i < count; i++) {
        w.before += still_to_run(s, &cells[i]) == 0;
    }
    pthread_mutex_init(&w.lock, 0);
    pthread_cond_init(&w.changed, 0);
    for (unsigned t = 0; t < places; t++) {   /* every place, before any thread looks for one */
        w.at[t].results = results + (size_t)t * most;
    }
    run_threads(&w, threads, ids);
    pthread_cond_destroy(&w.changed);
    pthread_mutex_destroy(&w.lock);
    free(ids);
    free(results);
    free(w.at);
}
