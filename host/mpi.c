/* mpi.c - team.h through MPI: mpirun -n R build/mpi/kelly ...
 *
 * A process knows its rank from its environment, so that MPI starts only where there is work to share: a mistake in the arguments is one
 * line and needs none. The leader's main thread looks for results that came, and naps between: on as many cores as
 * there are ranks it takes nothing from the thread that computes. So do the others while they wait. A process that is not
 * under mpirun is alone and has all threads.
 *
 * Between two ranks messages of one tag arrive in the order in which they were sent: an errand needs no number.
 */
#include <mpi.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "host.h"
#include "team.h"

enum { TAG_WORD = 1, TAG_INPUT, TAG_RESULTS };
enum { ERRAND, DISMISSED };         /* first of the four numbers of a word; first, count, bytes of the input follow */

static unsigned from_environment(const char *open_mpi, const char *others)
{
    const char *const text = getenv(open_mpi) ? getenv(open_mpi) : getenv(others);

    return text ? (unsigned)strtoul(text, 0, 10) : 0;
}

unsigned team_rank(void)
{
    return from_environment("OMPI_COMM_WORLD_RANK", "PMI_RANK");
}

unsigned team_others(void)
{
    const unsigned size = from_environment("OMPI_COMM_WORLD_SIZE", "PMI_SIZE");

    return size > 0 ? size - 1 : 0;
}

static void (*terminate_before)(int);   /* removes what is half-written */

/* mpirun ends all ranks when one is lost. */
static void on_terminate(int signal_number)
{
    static const char text[] = "kelly: ended from outside, or another rank was lost; what the journal holds is sound, go on with --resume\n";

    (void)!write(STDERR_FILENO, text, sizeof(text) - 1);
    if (terminate_before != SIG_DFL && terminate_before != SIG_IGN) {
        terminate_before(signal_number);
    }
    _exit(EXIT_FAILED);
}

static void start(void)
{
    int running, provided, rank, size;

    MPI_Initialized(&running);
    if (running) {
        return;
    }
    if (team_rank() == 0) {
        terminate_before = signal(SIGTERM, on_terminate);
    }
    if (MPI_Init_thread(0, 0, MPI_THREAD_FUNNELED, &provided) != MPI_SUCCESS || provided < MPI_THREAD_FUNNELED) {
        die(EXIT_FAILED, "MPI cannot be started with threads");
    }
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    MPI_Comm_size(MPI_COMM_WORLD, &size);
    if ((unsigned)rank != team_rank() || (unsigned)size != team_others() + 1) {
        die(EXIT_FAILED, "MPI counts rank %d of %d, the environment %u of %u; start with the mpirun of the library that this was built with",
            rank, size, team_rank(), team_others() + 1);
    }
}

/* 50 us, and longer the longer nothing has come: 0.8 ms, a small part of an errand. */
static void nap(unsigned *idle)
{
    const struct timespec time = { .tv_nsec = 50000 << (*idle < 4 ? (*idle)++ : 4u) };

    nanosleep(&time, 0);
}

static void say(unsigned rank, uint32_t kind, const errand *e)
{
    const uint32_t word[4] = { kind, e->first, e->count, (uint32_t)e->input_size };

    MPI_Send(word, 4, MPI_UINT32_T, (int)rank, TAG_WORD, MPI_COMM_WORLD);
    if (e->input_size > 0) {
        MPI_Send(e->input, (int)e->input_size, MPI_BYTE, (int)rank, TAG_INPUT, MPI_COMM_WORLD);
    }
}

/* ---- the leader ------------------------------------------------------------------------------------------------------ */

/* An errand of some rank, under way or to be given. */
typedef struct {
    errand what;
    MPI_Request request;
    int busy;
} slot;

static int took_results(const team_source *source, slot *s)
{
    int there = 0;

    if (s->busy) {
        MPI_Test(&s->request, &there, MPI_STATUS_IGNORE);
        if (there) {
            s->busy = 0;
            source->bring(source->context, &s->what);
        }
    }
    return there;
}

static int gave_errand(const team_source *source, slot *s, unsigned rank)
{
    if (s->busy || !source->take(source->context, &s->what)) {
        return 0;
    }
    MPI_Irecv(s->what.results, (int)(s->what.count * source->result_size), MPI_BYTE, (int)rank, TAG_RESULTS, MPI_COMM_WORLD, &s->request);
    say(rank, ERRAND, &s->what);
    s->busy = 1;
    return 1;
}

/* Every rank has its first errand before any has its second. */
void team_lead(const team_source *source)
{
    const unsigned others = team_others(), count = TEAM_DEPTH * others;
    slot *const slots = calloc(count, sizeof(*slots));
    unsigned idle = 0;

    if (!slots) {
        die(EXIT_FAILED, "out of memory");
    }
    start();
    for (;;) {
        unsigned busy = 0, moved = 0;

        for (unsigned i = 0; i < count; i++) {
            moved += (unsigned)took_results(source, &slots[i]);
            moved += (unsigned)gave_errand(source, &slots[i], i % others + 1);
            busy += (unsigned)slots[i].busy;
        }
        if (source->over(source->context) && busy == 0) {   /* asked every time: it shows the progress */
            break;
        }
        if (moved == 0) {
            nap(&idle);
        } else {
            idle = 0;
        }
    }
    free(slots);
}

void team_dismiss(void)
{
    for (unsigned rank = 1; rank <= team_others(); rank++) {
        start();
        say(rank, DISMISSED, &(errand){ 0 });
    }
}

/* ---- the others -------------------------------------------------------------------------------------------------------- */

/* Of one errand; grows. */
typedef struct {
    void *bytes;
    size_t size;
} space;

static void *at_least(space *s, size_t size)
{
    if (size > s->size) {
        free(s->bytes);
        s->bytes = malloc(size);
        s->size = size;
    }
    if (!s->bytes) {
        die(EXIT_FAILED, "out of memory");
    }
    return s->bytes;
}

static void hear(uint32_t word[4])
{
    unsigned idle = 0;
    int there = 0;

    for (;;) {
        MPI_Iprobe(0, TAG_WORD, MPI_COMM_WORLD, &there, MPI_STATUS_IGNORE);
        if (there) {
            break;
        }
        nap(&idle);
    }
    MPI_Recv(word, 4, MPI_UINT32_T, 0, TAG_WORD, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
}

void team_follow(void (*run)(void *context, const errand *e), void *context, size_t result_size)
{
    space results = { 0, 0 }, input = { 0, 0 };
    uint32_t word[4];

    start();
    for (hear(word); word[0] != DISMISSED; hear(word)) {
        const errand e = { .first = word[1], .count = word[2], .input_size = word[3], .input = word[3] > 0 ? at_least(&input, word[3]) : 0,
                           .results = at_least(&results, word[2] * result_size) };

        if (e.input) {
            MPI_Recv(input.bytes, (int)e.input_size, MPI_BYTE, 0, TAG_INPUT, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
        }
        memset(e.results, 0, e.count * result_size);
        run(context, &e);
        MPI_Send(e.results, (int)(e.count * result_size), MPI_BYTE, 0, TAG_RESULTS, MPI_COMM_WORLD);
    }
    free(input.bytes);
    free(results.bytes);
}

/* ---- the end ------------------------------------------------------------------------------------------------------------ */

void team_end(void)
{
    int running;

    MPI_Initialized(&running);
    if (running) {
        MPI_Finalize();
    }
}

void team_abort(int status)
{
    int running, ended;

    MPI_Initialized(&running);
    MPI_Finalized(&ended);
    if (running && !ended) {
        MPI_Abort(MPI_COMM_WORLD, status);
    }
}
