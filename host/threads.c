/* threads.c - an ensemble over the threads of one machine, and over the other processes of a team (team.h).
 *
 * A batch is cut into pieces of whole vectors beforehand; threads and processes take the next piece from a counter. The number of
 * pieces is a multiple of the number of workers and their sizes differ by one vector at most, so that neither a slow core nor
 * the last piece leaves the others idle. Results lie at their index: no order of execution can show.
 * What is known already (job.keep) is no part of any piece.
 */
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "host.h"
#include "team.h"

#define BATCH 16384u             /* realisations whose results are in memory at once, for a few workers */

typedef struct {
    uint32_t from, to;           /* within the batch */
} piece;

typedef struct {
    const options *opts;
    const job *what;
    unsigned workers;            /* here and elsewhere */
    uint32_t first, count;       /* of the batch */
    uint32_t known;              /* realisations of it */
    uint8_t *results;
    uint8_t *have;               /* [count], or 0 where nothing is kept */
    piece *pieces;
    uint32_t piece_count;
    atomic_uint next;            /* piece */
    atomic_uint done;            /* realisations */
    atomic_uint running;         /* threads */
    pthread_mutex_t saving;
    uint32_t before;             /* realisations of earlier batches */
    double start, shown;         /* [s] */
} batch;

unsigned processors(void)
{
    const long n = sysconf(_SC_NPROCESSORS_ONLN);

    return n > 0 ? (unsigned)n : 1u;
}

/* A process of a team has a core; one that is alone has them all. */
unsigned threads_of(const options *opts)
{
    return opts->threads ? opts->threads : team_others() > 0 ? 1u : processors();
}

static double now(void)
{
    struct timespec t;

    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* ---- pieces ----------------------------------------------------------------------------------------------------- */

/* Cut realisations that are to be run: as few pieces as hold them, rounded up to a multiple of the workers, at least a vector each. The
 * first `vectors % pieces` pieces have one vector more. */
static void cut(batch *b, uint32_t from, uint32_t to)
{
    const uint32_t width = b->what->width, whole = b->what->lanes / width, vectors = (to - from + width - 1) / width;
    uint32_t pieces = (vectors + whole - 1) / whole;

    pieces = (pieces + b->workers - 1) / b->workers * b->workers;
    pieces = pieces < vectors ? pieces : vectors;
    for (uint32_t k = 0; k < pieces; k++) {
        const uint32_t vector = vectors / pieces + (k < vectors % pieces), left = to - from;
        const uint32_t count = vector * width < left ? vector * width : left;

        b->pieces[b->piece_count++] = (piece){ from, from + count };
        from += count;
    }
}

/* Ask what is known of the batch and cut the rest. */
static void cut_batch(batch *b)
{
    b->piece_count = b->known = 0;
    if (b->have) {
        memset(b->have, 0, b->count);
        b->what->keep->recall(b->what->keep->context, b->first, b->count, b->results, b->have);
    }
    for (uint32_t from = 0, to; from < b->count; from = to) {
        const int known = b->have && b->have[from];

        for (to = from + 1; to < b->count && (b->have && b->have[to]) == known; to++) {
        }
        if (known) {
            b->known += to - from;
        } else {
            cut(b, from, to);
        }
    }
}

static const piece *take_piece(batch *b)
{
    const uint32_t k = atomic_load(&b->next) < b->piece_count ? atomic_fetch_add(&b->next, 1u) : UINT32_MAX;

    return k < b->piece_count ? &b->pieces[k] : 0;
}

static void finish_piece(batch *b, uint32_t from, uint32_t count)
{
    const keeper *const keep = b->what->keep;

    if (keep) {
        pthread_mutex_lock(&b->saving);
        keep->save(keep->context, b->first + from, count, b->results + from * b->what->result_size);
        pthread_mutex_unlock(&b->saving);
    }
    atomic_fetch_add(&b->done, count);
}

static void *worker(void *context)
{
    batch *const b = context;
    const piece *p;
    void *work = 0;

    if (posix_memalign(&work, 64, b->what->work_size) != 0) {
        die(EXIT_FAILED, "out of memory");
    }
    while ((p = take_piece(b)) != 0) {
        b->what->work(b->opts, b->first + p->from, p->to - p->from, b->results + p->from * b->what->result_size, work);
        finish_piece(b, p->from, p->to - p->from);
    }
    free(work);
    atomic_fetch_sub(&b->running, 1u);
    return 0;
}

/* ---- what the other processes are told -------------------------------------------------------------------------- */

static int take_errand(void *context, errand *e)
{
    batch *const b = context;
    const piece *const p = take_piece(b);

    if (p) {
        *e = (errand){ .first = b->first + p->from, .count = p->to - p->from, .results = b->results + p->from * b->what->result_size };
    }
    return p != 0;
}

static void bring_errand(void *context, const errand *e)
{
    batch *const b = context;

    finish_piece(b, e->first - b->first, e->count);
}

static void show(batch *b)
{
    if (progress_wanted(b->opts) && now() - b->shown > 0.25) {
        b->shown = now();
        progress_show(b->opts, (uint64_t)b->before + b->known + atomic_load(&b->done), b->opts->samples, b->shown - b->start);
    }
}

static int over(void *context)
{
    batch *const b = context;

    show(b);
    return atomic_load(&b->running) == 0;
}

/* ---- batches ------------------------------------------------------------------------------------------------------ */

static void watch(batch *b)
{
    const struct timespec nap = { .tv_nsec = 20000000 };

    while (!over(b)) {
        nanosleep(&nap, 0);
    }
}

static void run_batch(batch *b, unsigned threads, pthread_t *ids, int alone)
{
    cut_batch(b);
    atomic_store(&b->next, 0u);
    atomic_store(&b->done, 0u);
    atomic_store(&b->running, threads);
    for (unsigned t = 0; t < threads; t++) {
        if (pthread_create(&ids[t], 0, worker, b) != 0) {
            die(EXIT_FAILED, "cannot start thread %u of %u; give fewer --threads", t + 1, threads);
        }
    }
    if (!alone) {
        team_lead(&(team_source){ b, take_errand, bring_errand, over, b->what->result_size });
    } else if (progress_wanted(b->opts)) {
        watch(b);
    }
    for (unsigned t = 0; t < threads; t++) {
        pthread_join(ids[t], 0);
    }
}

/* The run of an only process, or of the first of a team. */
static void lead(const options *opts, const job *what, int alone, batch_sink sink, void *context)
{
    const unsigned threads = threads_of(opts), workers = threads + (alone ? 0 : team_others());
    const uint64_t batch_size = (uint64_t)BATCH * ((workers + 7u) / 8u);
    const uint32_t asked = opts->samples < batch_size ? opts->samples : (uint32_t)batch_size;
    const uint32_t most = asked > 0 ? asked : 1;
    batch b = { .opts = opts, .what = what, .workers = workers, .results = calloc(most, what->result_size), .start = now(),
                .have = what->keep ? calloc(most, 1) : 0, .pieces = calloc(most, sizeof(piece)), .saving = PTHREAD_MUTEX_INITIALIZER };
    pthread_t *ids = calloc(threads, sizeof(*ids));

    if (!b.results || !b.pieces || !ids || (what->keep && !b.have)) {
        die(EXIT_FAILED, "out of memory");
    }
    for (; b.before < opts->samples; b.before += b.count) {
        b.first = opts->first + b.before;
        b.count = opts->samples - b.before < most ? opts->samples - b.before : most;
        run_batch(&b, threads, ids, alone);
        if (!alone && !what->lead_only) {
            team_tell(b.first, b.count, b.results, what->result_size);
        }
        sink(context, b.first, b.count, b.results);
    }
    if (progress_wanted(opts)) {
        progress_end(opts, opts->samples, now() - b.start);
    }
    free(b.results);
    free(b.have);
    free(b.pieces);
    free(ids);
}

/* ---- a process that is not the first ----------------------------------------------------------------------------- */

typedef struct {
    const options *opts;
    const job *what;
    void *work;
} follower;

static void run_errand(void *context, const errand *e)
{
    const follower *const f = context;

    f->what->work(f->opts, e->first, e->count, e->results, f->work);
}

static void follow(const options *opts, const job *what, batch_sink sink, void *context)
{
    follower f = { opts, what, 0 };

    if (posix_memalign(&f.work, 64, what->work_size) != 0) {
        die(EXIT_FAILED, "out of memory");
    }
    team_follow(run_errand, &f, what->result_size, sink, context);
    free(f.work);
}

void run_job(const options *opts, const job *what, batch_sink sink, void *context)
{
    if (team_rank() > 0 && !what->lead_alone) {
        follow(opts, what, sink, context);
    } else if (team_rank() == 0) {
        lead(opts, what, what->lead_alone || team_others() == 0, sink, context);
        if (!what->lead_alone) {
            team_dismiss();
        }
    }
}
