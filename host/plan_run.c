/* plan_run.c - a run over many ranks, event by event.
 *
 * It is that of threads.c and mpi.c: batches cut into errands, TEAM_DEPTH of them with each rank, one leader that takes results
 * and gives errands one at a time, and the results of a batch handed on before the next one begins. Its errands last as long as
 * blocks that were measured, drawn at random: what the spread of their times costs is in it, and in no formula.
 */
#include <math.h>
#include <stdlib.h>

#include "plan.h"
#include "team.h"

#define ERRANDS 2000000u         /* simulated at most, but one batch; a longer run is so many of its batches, and the rest in proportion */

typedef struct {
    double ends;                 /* of the errand that it works on [s] */
    double arrives;              /* of the next one, or HUGE_VAL */
} rank;

typedef struct {
    const plan *p;
    rank *ranks;                 /* [cores]; 0 is the leader's own thread */
    uint32_t *heap;              /* of ranks that work, the first to end on top */
    uint32_t used;
    double leader;               /* until then it is busy [s] */
    double worked;               /* sum over the errands [s] */
    uint32_t left;               /* errands of the batch */
    uint32_t size;               /* realisations of an errand */
    uint64_t state;              /* of the draws */
} simulation;

static double draw_duration(simulation *s)
{
    double seconds;

    s->state = s->state * 6364136223846793005u + 1442695040888963407u;
    seconds = s->p->block[(s->state >> 33) % s->p->blocks] * s->size / s->p->lanes;
    s->worked += seconds;
    return seconds;
}

static void push(simulation *s, uint32_t r)
{
    uint32_t at = s->used++;

    while (at > 0 && s->ranks[s->heap[(at - 1) / 2]].ends > s->ranks[r].ends) {
        s->heap[at] = s->heap[(at - 1) / 2];
        at = (at - 1) / 2;
    }
    s->heap[at] = r;
}

static uint32_t pop(simulation *s)
{
    const uint32_t top = s->heap[0], r = s->heap[--s->used];
    uint32_t at = 0, child;

    while ((child = 2 * at + 1) < s->used) {
        child += child + 1 < s->used && s->ranks[s->heap[child + 1]].ends < s->ranks[s->heap[child]].ends;
        if (s->ranks[r].ends <= s->ranks[s->heap[child]].ends) {
            break;
        }
        s->heap[at] = s->heap[child];
        at = child;
    }
    s->heap[at] = r;
    return top;
}

/* An errand from the leader, when it has time; the time of its arrival. */
static double give(simulation *s, double asked)
{
    s->leader = fmax(s->leader, asked) + s->p->message;
    s->left--;
    return s->leader + s->p->way;
}

static void begin(simulation *s, uint32_t r, double at)
{
    s->ranks[r].ends = at + draw_duration(s);
    push(s, r);
}

/* A rank has ended an errand: its results are on the way, and it takes up the next one when that is there. */
static void finish(simulation *s, uint32_t r)
{
    rank *const me = &s->ranks[r];
    const double ended = me->ends, next = me->arrives;

    if (r == 0) {
        if (s->left > 0) {
            s->left--;
            begin(s, r, ended);
        }
        return;
    }
    if (s->left > 0) {
        me->arrives = give(s, ended + s->p->way);
    } else {
        s->leader = fmax(s->leader, ended + s->p->way) + s->p->message;
        me->arrives = HUGE_VAL;
    }
    if (next < HUGE_VAL) {
        begin(s, r, fmax(ended, next));
    } else if (me->arrives < HUGE_VAL) {   /* it waited for this one */
        const double arrives = me->arrives;

        me->arrives = HUGE_VAL;
        begin(s, r, arrives);
    }
}

/* One batch from `start` on; when it has been handed on. */
static double run_batch(simulation *s, uint32_t cores, uint32_t count, double start)
{
    const uint32_t pieces = (count + s->p->lanes - 1) / s->p->lanes, errands = (pieces + cores - 1) / cores * cores;
    double end = start;

    s->left = errands < count ? errands : count;
    s->size = (count + s->left - 1) / s->left;
    s->leader = start;
    s->left--;
    begin(s, 0, start);
    for (uint32_t r = 1; r < cores; r++) {
        s->ranks[r].arrives = HUGE_VAL;
        if (s->left > 0) {
            begin(s, r, give(s, start));
        }
    }
    for (uint32_t r = 1; r < cores && s->left > 0; r++) {
        s->ranks[r].arrives = give(s, start);
    }
    while (s->used > 0) {
        const uint32_t r = pop(s);

        end = fmax(end, s->ranks[r].ends);
        finish(s, r);
    }
    return fmax(end, s->leader) + count * s->p->leader;
}

/* The same where a batch has many more errands than ERRANDS: its beginning, twice of it, and more of what the second one has added. */
static double run_part(simulation *s, uint32_t cores, uint32_t count, double start)
{
    const uint64_t half = (uint64_t)(ERRANDS / cores + 1) * cores * s->p->lanes;
    const double before = s->worked;
    double first, second, more, worked;

    if (count <= 2 * half) {
        return run_batch(s, cores, count, start);
    }
    first = run_batch(s, cores, (uint32_t)half, start) - start;
    worked = s->worked - before;
    second = run_batch(s, cores, (uint32_t)(2 * half), start) - start;
    more = (double)(count - 2 * half) / (double)half;
    s->worked -= worked;
    s->worked += more * (s->worked - before - worked);
    return start + second + more * (second - first);
}

uint32_t plan_batch(uint32_t cores, uint32_t samples)
{
    const uint64_t size = job_batch(cores);

    return size < samples ? (uint32_t)size : samples;
}

double plan_starting(const plan *p, uint32_t cores)
{
    return cores > 1 ? p->startup + cores * p->startup_rank : 0.0;
}

double plan_simulate(const plan *p, uint32_t cores, uint32_t samples, double *worked)
{
    const uint32_t size = plan_batch(cores, samples), whole = samples / size, rest = samples % size;
    const uint32_t most = ERRANDS / (size / p->lanes + 1) + 1, batches = whole < most ? whole : most;
    simulation s = { .p = p, .ranks = calloc(cores, sizeof(rank)), .heap = calloc(cores, sizeof(uint32_t)), .state = 1 };
    double time = 0;

    if (!s.ranks || !s.heap) {
        die(EXIT_FAILED, "out of memory");
    }
    for (uint32_t k = 0; k < batches; k++) {
        time = run_part(&s, cores, size, time);
    }
    time *= (double)whole / batches;
    s.worked *= (double)whole / batches;
    if (rest > 0) {
        time = run_part(&s, cores, rest, time);
    }
    *worked = s.worked;
    free(s.ranks);
    free(s.heap);
    return plan_starting(p, cores) + time;
}
