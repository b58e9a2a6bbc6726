/* team.h - more processes than one. alone.c answers for a program that knows of no other, mpi.c through MPI.
 *
 * Every process of a team runs the same command with the same arguments. The first (rank 0) leads: it alone reads and writes files and
 * prints, gives errands to the others between those of its own threads, and takes their results. The others come to the same
 * run_job or cells_run and follow until they are dismissed. All of it is called by the main thread only.
 */
#ifndef KELLY_TEAM_H
#define KELLY_TEAM_H

#include "host.h"

/* Errands that a process has at once, so that it never waits for the next. */
#define TEAM_DEPTH 2u

/* Realisations first .. first + count - 1 of something (`item`: what the caller means by it). */
typedef struct {
    uint32_t item, first, count;
    void *results;               /* count of them, where they belong */
} errand;

/* What the leader has to give. */
typedef struct {
    void *context;
    int (*take)(void *context, errand *e);           /* the next errand, or 0: there is none now */
    void (*bring)(void *context, const errand *e);   /* its results are there */
    int (*over)(void *context);                      /* the leader's own threads have ended and nothing will come */
    size_t result_size;
} team_source;

/* This process in its team, 0 for one that is alone; how many others there are. */
unsigned team_rank(void);
unsigned team_others(void);

/* Leader: keep the others busy until it is over and all is brought. */
void team_lead(const team_source *source);

/* Leader: these results of a batch, for the sinks of the others; everybody goes on. */
void team_tell(uint32_t first, uint32_t count, const void *results, size_t result_size);
void team_dismiss(void);

/* The others: run errands (results belong at e->results) and take what is told, until dismissed. */
void team_follow(void (*run)(void *context, const errand *e), void *run_context, size_t result_size, batch_sink sink, void *sink_context);

/* All: the leader's bytes. */
void team_share(void *bytes, size_t count);

/* This process ends as it should; or it cannot go on, and no other shall wait for it. */
void team_end(void);
void team_abort(int status);

#endif
