/* ledger.h - the journal of an ensemble: what an earlier run of it has done is taken over, what this one does is kept.
 *
 * A record is one realisation: index from --first, the result to the last bit, CRC-32C; 48 bytes in float, 84 in double. They come
 * in the order in which threads and ranks finish. On the way back the sink sees them in the order of the indices, as a
 * run would have handed them on: up to the first missing one while the journal is read, and the rest, which waits in memory (as much as
 * the run had under way), when the indices before it are done.
 */
#ifndef KELLY_LEDGER_H
#define KELLY_LEDGER_H

#include "host.h"
#include "journal.h"

/* Fields are not to be touched, but for `next`, which may be read. Start from zeros: a ledger that is not open keeps nothing. */
typedef struct {
    journal log;
    int open;
    const options *opts;
    batch_sink sink;
    void *context;
    uint32_t next;               /* realisations from --first on that the sink has seen */
    kelly_result *waiting;       /* [room], realisation i (from --first on) at i % room, next <= i < next + room */
    uint8_t *have;               /* [room] */
    uint32_t room;
    keeper keep;                 /* for run_job */
} ledger;

/* CRC-32C of the case: version, numbers, laws, times, modes, start. Runs whose realisations may stand for one another agree in it, in
 * the string, the precision and the seed. */
uint32_t run_identity(const options *opts);

/* A path that will be renamed into its place can have a journal beside it; stdout, devices and no path cannot. */
int is_file(const char *path);

/* Open OUTPUT.journal for the realisations of opts, which must outlive the ledger; --resume as in opts. Dies as journal_open does. */
void ledger_open(ledger *l, const options *opts, const char *output, batch_sink sink, void *context);

/* What is left to be run: opts from the first index on that the sink has not seen; samples may be 0. */
options ledger_rest(const ledger *l, const options *opts);

/* The outputs are in their places: the journal goes. */
void ledger_close(ledger *l);

#endif
