/* team.h - more processes than one: mpi.c, in the program that `make mpi` builds; in any other, a process is alone.
 *
 * Every process of a team runs the same command with the same arguments. The first (rank 0) leads: it alone decides, reads and writes
 * files and prints. It gives errands to the others between those of its own threads, and takes their results. The others follow: they
 * run errands until they are dismissed, and then end. All of it is called by the main thread only.
 */
#ifndef KELLY_TEAM_H
#define KELLY_TEAM_H

#include <stddef.h>
#include <stdint.h>

/* Errands that a process has at once, so that it never waits for the next. */
#define TEAM_DEPTH 2u

/* Realisations first .. first + count - 1, of what both sides know, or of what `input` tells. */
typedef struct {
    const void *input;           /* that goes with it, or 0; of the leader: it stays as it is until the results are there */
    size_t input_size;           /* [bytes] */
    uint32_t first, count;
    void *results;               /* count of them: where they belong */
    uint32_t number;             /* of the leader's own */
} errand;

/* What the leader has to give. */
typedef struct {
    void *context;
    int (*take)(void *context, errand *e);           /* the next errand, or 0: there is none now */
    void (*bring)(void *context, const errand *e);   /* its results are there */
    int (*over)(void *context);                      /* the leader's own threads have ended and nothing will come */
    size_t result_size;
} team_source;

#ifdef KELLY_MPI

/* This process in its team, 0 for one that is alone; how many others there are. */
unsigned team_rank(void);
unsigned team_others(void);

/* Leader: keep the others busy until it is over and all is brought; and, later, let them go. */
void team_lead(const team_source *source);
void team_dismiss(void);

/* The others: run errands (results belong at e->results, which hold zeros) until dismissed. */
void team_follow(void (*run)(void *context, const errand *e), void *context, size_t result_size);

/* This process ends as it should; or it cannot go on, and no other shall wait for it. */
void team_end(void);
void team_abort(int status);

#else

static inline unsigned team_rank(void) { return 0; }
static inline unsigned team_others(void) { return 0; }
static inline void team_lead(const team_source *source) { (void)source; }
static inline void team_dismiss(void) { }
static inline void team_follow(void (*run)(void *context, const errand *e), void *context, size_t result_size)
{
    (void)run, (void)context, (void)result_size;
}
static inline void team_end(void) { }
static inline void team_abort(int status) { (void)status; }

#endif
#endif
