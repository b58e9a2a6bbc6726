/* threads.c - an ensemble over the threads of one machine.
 *
 * A batch is cut into pieces of whole vectors beforehand; threads take the next piece from a counter. The number of
 * pieces is a multiple of the number of threads and their sizes differ by one vector at most, so that neither a slow core nor
 * the last piece leaves the others idle. Results lie at their index: no order of execution can show.
 */
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <time.h>
#include <unistd.h>

#include "host.h"

#define SHOW 0.25                /* [s] between two lines of progress */
#define BATCH 16384u             /* realisations whose results are in memory at once, for a few threads */

typedef struct {
    const options *opts;
    const job *what;
    uint32_t first, count;       /* of the batch */
    uint32_t vectors, pieces;
    uint8_t *results;
    atomic_uint next;            /* piece */
    atomic_uint done;            /* realisations */
    pthread_mutex_t lock;        /* of `running`, */
    pthread_cond_t over;         /* told when it comes to 0 */
    unsigned running;            /* threads */
    double shown;                /* when progress was, for all batches of a run: one may be over before it is due */
} batch;

unsigned processors(void)
{
    const long n = sysconf(_SC_NPROCESSORS_ONLN);

    return n > 0 ? (unsigned)n : 1u;
}

static double now(void)
{
    struct timespec t;

    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* First vector of a piece: the first `vectors % pieces` pieces have one more. */
static uint32_t piece_start(const batch *b, uint32_t piece)
{
    const uint32_t base = b->vectors / b->pieces, rest = b->vectors % b->pieces;

    return piece * base + (piece < rest ? piece : rest);
}

static void *worker(void *context)
{
    batch *const b = context;
    const uint32_t width = b->what->width;
    void *work = 0;

    if (posix_memalign(&work, 64, b->what->work_size) != 0) {
        die(EXIT_FAILED, "out of memory");
    }
    for (;;) {
        const uint32_t piece = atomic_fetch_add(&b->next, 1u);
        uint32_t from, to;

        if (piece >= b->pieces) {
            break;
        }
        from = piece_start(b, piece) * width;
        to = piece_start(b, piece + 1) * width;
        to = to < b->count ? to : b->count;
        b->what->work(b->opts, b->first + from, to - from, b->results + from * b->what->result_size, work);
        atomic_fetch_add(&b->done, to - from);
    }
    free(work);
    pthread_mutex_lock(&b->lock);
    if (--b->running == 0) {
        pthread_cond_signal(&b->over);
    }
    pthread_mutex_unlock(&b->lock);
    return 0;
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

static void watch_batch(batch *b, uint32_t before, double start)
{
    pthread_mutex_lock(&b->lock);
    do {
        if (b->running > 0) {
            wait_a_moment(b);
        }
        if (now() - b->shown > SHOW) {
            b->shown = now();
            progress_show(b->opts, (uint64_t)before + atomic_load(&b->done), b->opts->samples, b->shown - start);
        }
    } while (b->running > 0);
    pthread_mutex_unlock(&b->lock);
}

/* Cut a batch: as few pieces as hold it, rounded up to a multiple of the threads, at least a vector each. */
static void cut(batch *b, unsigned threads)
{
    const uint32_t whole = b->what->lanes / b->what->width;

    b->vectors = (b->count + b->what->width - 1) / b->what->width;
    b->pieces = (b->vectors + whole - 1) / whole;
    b->pieces = (b->pieces + threads - 1) / threads * threads;
    b->pieces = b->pieces < b->vectors ? b->pieces : b->vectors;
}

static void run_batch(batch *b, unsigned threads, pthread_t *ids, uint32_t before, double start)
{
    cut(b, threads);
    atomic_store(&b->next, 0u);
    atomic_store(&b->done, 0u);
    b->running = threads;
    for (unsigned t = 0; t < threads; t++) {
        if (pthread_create(&ids[t], 0, worker, b) != 0) {
            die(EXIT_FAILED, "cannot start thread %u of %u; give fewer --threads", t + 1, threads);
        }
    }
    if (progress_wanted(b->opts)) {
        watch_batch(b, before, start);
    }
    for (unsigned t = 0; t < threads; t++) {
        pthread_join(ids[t], 0);
    }
}

/* Realisations of the next batch. Where the run may end at any of them, a block a thread at first, then an eighth of what is
 * done, so that what has to be thrown away stays small. */
static uint32_t batch_count(const job *what, unsigned threads, uint32_t done, uint32_t most)
{
    const uint32_t least = threads * what->lanes;
    const uint32_t few = done / 8 > least ? done / 8 / least * least : least;

    return what->enough && few < most ? few : most;
}

void run_job(const options *opts, const job *what, batch_sink sink, void *context)
{
    const unsigned threads = opts->threads ? opts->threads : processors();
    const uint32_t batch_size = BATCH * ((threads + 7u) / 8u);
    const uint32_t most = opts->samples < batch_size ? opts->samples : batch_size;
    const double start = now();
    batch b = { .opts = opts, .what = what, .results = calloc(most, what->result_size), .lock = PTHREAD_MUTEX_INITIALIZER,
                .over = PTHREAD_COND_INITIALIZER, .shown = start };
    pthread_t *ids = calloc(threads, sizeof(*ids));

    if (!b.results || !ids) {
        die(EXIT_FAILED, "out of memory");
    }
    for (uint32_t done = 0; done < opts->samples && !(what->enough && *what->enough); done += b.count) {
        const uint32_t next = batch_count(what, threads, done, most);

        b.first = opts->first + done;
        b.count = opts->samples - done < next ? opts->samples - done : next;
        run_batch(&b, threads, ids, done, start);
        sink(context, b.first, b.count, b.results);
    }
    if (progress_wanted(opts)) {
        progress_end(opts, opts->samples, now() - start);
    }
    free(b.results);
    free(ids);
}
