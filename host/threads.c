/* threads.c - an ensemble over the threads of one machine, and over the other processes of a team (team.h).
 *
 * A batch is cut into pieces of whole vectors beforehand; threads and processes take the next piece from a counter. The number of
 * pieces is a multiple of the number of workers and their sizes differ by one vector at most, so that neither a slow core nor
 * the last piece leaves the others idle. Results lie at their index: no order of execution can show.
 *
 * The journal of a run holds its results in the order of the indices: a piece is appended when it and all before it are done. So what
 * it holds is always the beginning of the run, and to go on is to hand that to the sink and to run the rest. They lie there as in memory.
 */
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "../firmware/link/crc32c.h"
#include "host.h"
#include "journal.h"
#include "team.h"

#define SHOW 0.25                /* [s] between two lines of progress */
#define BATCH 16384u             /* realisations whose results are in memory at once, for a few workers */
#define BATCH_RESULT 1024u       /* [bytes], longer ones lie there in smaller numbers */

typedef struct {
    const options *opts;
    const job *what;
    unsigned workers;            /* threads here, and other processes */
    uint32_t first, count;       /* of the batch */
    uint32_t vectors, pieces;
    uint8_t *results;
    atomic_uint next;            /* piece */
    pthread_mutex_t lock;        /* of what follows */
    pthread_cond_t over;         /* told when `running` comes to 0 */
    unsigned running;            /* threads */
    uint32_t done;               /* realisations */
    uint8_t *finished;           /* [piece] */
    uint32_t kept;               /* pieces that are in the journal */
    uint32_t before, rest;       /* realisations of earlier batches; of all batches */
    double start, shown;         /* when the run began, when progress was shown: a batch may be over before it is due */
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

/* ---- pieces ------------------------------------------------------------------------------------------------------ */

/* Cut a batch: as few pieces as hold it, rounded up to a multiple of the workers, at least a vector each. */
static void cut(batch *b)
{
    const uint32_t whole = b->what->lanes / b->what->width;

    b->vectors = (b->count + b->what->width - 1) / b->what->width;
    b->pieces = (b->vectors + whole - 1) / whole;
    b->pieces = (b->pieces + b->workers - 1) / b->workers * b->workers;
    b->pieces = b->pieces < b->vectors ? b->pieces : b->vectors;
}

/* First realisation of a piece: the first `vectors % pieces` pieces have a vector more. */
static uint32_t piece_start(const batch *b, uint32_t piece)
{
    const uint32_t base = b->vectors / b->pieces, rest = b->vectors % b->pieces;
    const uint32_t start = (piece * base + (piece < rest ? piece : rest)) * b->what->width;

    return start < b->count ? start : b->count;
}

/* The next piece, or 0. */
static int take_piece(batch *b, errand *e)
{
    const uint32_t piece = atomic_load(&b->next) < b->pieces ? atomic_fetch_add(&b->next, 1u) : b->pieces;

    if (piece >= b->pieces) {
        return 0;
    }
    *e = (errand){ .first = b->first + piece_start(b, piece), .count = piece_start(b, piece + 1) - piece_start(b, piece), .number = piece,
                   .results = b->results + piece_start(b, piece) * b->what->result_size };
    return 1;
}

/* A piece is done: count it, and write down all that is done without a gap. */
static void bring_piece(batch *b, const errand *e)
{
    pthread_mutex_lock(&b->lock);
    b->done += e->count;
    b->finished[e->number] = 1;
    while (b->what->log && b->what->log->path && b->kept < b->pieces && b->finished[b->kept]) {
        const uint32_t from = piece_start(b, b->kept), to = piece_start(b, ++b->kept);

        journal_append(b->what->log, b->what->log->next, to - from, b->results + from * b->what->result_size);
    }
    pthread_mutex_unlock(&b->lock);
}

static void *worker(void *context)
{
    batch *const b = context;
    void *work = 0;
    errand e;

    if (posix_memalign(&work, 64, b->what->work_size) != 0) {
        die(EXIT_FAILED, "out of memory");
    }
    while (take_piece(b, &e)) {
        b->what->work(b->opts, e.first, e.count, e.results, work);
        bring_piece(b, &e);
    }
    free(work);
    pthread_mutex_lock(&b->lock);
    if (--b->running == 0) {
        pthread_cond_signal(&b->over);
    }
    pthread_mutex_unlock(&b->lock);
    return 0;
}

/* ---- batches ------------------------------------------------------------------------------------------------------ */

/* Where it is due; the lock is held. */
static void show(batch *b)
{
    if (progress_wanted(b->opts) && now() - b->shown > SHOW) {
        b->shown = now();
        progress_show(b->opts, (uint64_t)b->before + b->done, b->rest, b->shown - b->start);
    }
}

/* Wait until the batch is over or progress is due. The end is told, not looked for: a nap would go on while the processors idle. */
static void wait_a_moment(batch *b)
{
    struct timespec until;

    clock_gettime(CLOCK_REALTIME, &until);
    until.tv_nsec += (long)(1e9 * SHOW / 2);
    if (until.tv_nsec >= 1000000000) {
        until.tv_nsec -= 1000000000;
        until.tv_sec++;
    }
    pthread_cond_timedwait(&b->over, &b->lock, &until);
}

static void watch_batch(batch *b)
{
    pthread_mutex_lock(&b->lock);
    do {
        if (b->running > 0) {
            wait_a_moment(b);
        }
        show(b);
    } while (b->running > 0);
    pthread_mutex_unlock(&b->lock);
}

static int give_piece(void *context, errand *e)
{
    const batch *const b = context;

    if (!take_piece(context, e)) {
        return 0;
    }
    if (b->what->inputs) {
        e->input = (const char *)b->what->inputs + (e->first - b->opts->first) * b->what->input_size;
        e->input_size = e->count * b->what->input_size;
    }
    return 1;
}

static void take_back(void *context, const errand *e)
{
    bring_piece(context, e);
}

static int threads_over(void *context)
{
    batch *const b = context;
    int over;

    pthread_mutex_lock(&b->lock);
    show(b);
    over = b->running == 0;
    pthread_mutex_unlock(&b->lock);
    return over;
}

static void run_batch(batch *b, unsigned threads, pthread_t *ids)
{
    cut(b);
    atomic_store(&b->next, 0u);
    b->done = b->kept = 0;
    memset(b->finished, 0, b->pieces);
    b->running = threads;
    for (unsigned t = 0; t < threads; t++) {
        if (pthread_create(&ids[t], 0, worker, b) != 0) {
            die(EXIT_FAILED, "cannot start thread %u of %u; give fewer --threads", t + 1, threads);
        }
    }
    if (b->workers > threads) {
        team_lead(&(team_source){ b, give_piece, take_back, threads_over, b->what->result_size });
    } else if (progress_wanted(b->opts)) {
        watch_batch(b);
    }
    for (unsigned t = 0; t < threads; t++) {
        pthread_join(ids[t], 0);
    }
}

/* Realisations of the next batch. Where the run may end at any of them, a block a worker at first, then an eighth of what is
 * done, so that what has to be thrown away stays small. */
static uint32_t batch_count(const job *what, unsigned workers, uint32_t done, uint32_t most)
{
    const uint32_t least = workers * what->lanes;
    const uint32_t few = done / 8 > least ? done / 8 / least * least : least;

    return what->enough && few < most ? few : most;
}

uint64_t job_batch(unsigned workers)
{
    return (uint64_t)BATCH * ((workers + 7u) / 8u);
}

/* The most of one batch: fewer where results are long, but a piece a worker. */
static uint64_t batch_most(const job *what, unsigned workers)
{
    const uint64_t whole = job_batch(workers), fit = whole * BATCH_RESULT / what->result_size, least = (uint64_t)workers * what->lanes;

    return fit >= whole ? whole : fit > least ? fit : least;
}

/* Realisations first + done, ... of opts, to the end. */
static void lead(const options *opts, const job *what, uint32_t done, batch_sink sink, void *context)
{
    const unsigned threads = threads_of(opts), workers = threads + (what->lead_alone ? 0 : team_others());
    const uint64_t batch_size = batch_most(what, workers);
    const uint32_t left = opts->samples - done, most = left < batch_size ? left : (uint32_t)batch_size;
    const double start = now();
    batch b = { .opts = opts, .what = what, .workers = workers, .results = calloc(most, what->result_size), .finished = calloc(most, 1),
                .lock = PTHREAD_MUTEX_INITIALIZER, .over = PTHREAD_COND_INITIALIZER, .rest = left, .start = start, .shown = start };
    pthread_t *ids = calloc(threads, sizeof(*ids));

    if (!b.results || !b.finished || !ids) {
        die(EXIT_FAILED, "out of memory");
    }
    for (; b.before < left && !(what->enough && *what->enough); b.before += b.count) {
        const uint32_t next = batch_count(what, workers, done + b.before, most);

        b.first = opts->first + done + b.before;
        b.count = left - b.before < next ? left - b.before : next;
        run_batch(&b, threads, ids);
        sink(context, b.first, b.count, b.results);
    }
    if (progress_wanted(opts)) {
        progress_end(opts, left, now() - start);
    }
    free(b.results);
    free(b.finished);
    free(ids);
}

/* ---- journal ------------------------------------------------------------------------------------------------------ */

void job_log(journal *log, const options *opts, const char *beside, const journal_run *what)
{
    const uint32_t run[3] = { case_identity(&opts->run), opts->first, what->parameters };
    const real sample = R(1.0) / R(3.0);   /* another byte order is another run */
    journal_run all = *what;

    all.model = kelly_string.id;
    all.seed = opts->seed;
    all.twice = opts->twice;
    all.parameters = kelly_crc32c(kelly_crc32c(0, (const uint8_t *)run, sizeof(run)), (const uint8_t *)&sample, sizeof(sample));
    if (beside && team_rank() == 0) {
        journal_open(log, beside, &all, opts->resume);
    }
}

/* Hand on what an earlier run has done; how many realisations that is. */
static uint32_t recall(const options *opts, const job *what, batch_sink sink, void *context)
{
    void *const result = malloc(what->result_size);
    uint32_t done = 0, index;

    if (!result) {
        die(EXIT_FAILED, "out of memory");
    }
    while (what->log && done < opts->samples && journal_next(what->log, &index, result)) {
        sink(context, opts->first + done, 1, result);
        done++;
    }
    free(result);
    return done;
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
    const job *const what = f->what;

    if (e->input) {
        memcpy((char *)what->inputs + (e->first - f->opts->first) * what->input_size, e->input, e->input_size);
    }
    what->work(f->opts, e->first, e->count, e->results, f->work);
}

static void follow(const options *opts, const job *what)
{
    follower f = { opts, what, 0 };

    if (posix_memalign(&f.work, 64, what->work_size) != 0) {
        die(EXIT_FAILED, "out of memory");
    }
    team_follow(run_errand, &f, what->result_size);
    free(f.work);
}

void run_job(const options *opts, const job *what, batch_sink sink, void *context)
{
    if (team_rank() > 0 && !what->lead_alone) {
        follow(opts, what);
    } else if (team_rank() == 0) {
        const uint32_t done = recall(opts, what, sink, context);

        if (done < opts->samples) {
            lead(opts, what, done, sink, context);
        }
        if (!what->lead_alone && !what->more) {
            team_dismiss();
        }
    }
}
