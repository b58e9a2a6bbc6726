/* journal.h - what a long run has done so far, so that nothing is computed twice and nothing is lost.
 *
 * A file OUTPUT.journal beside the output: a header that names the run, then records
 *     u32 index | payload | u32 CRC-32C of both          little-endian
 * A record is there or it is not: what a crash tears off the end is dropped, and said, on the next start. Everything
 * behind the first unsound record counts as torn. An index may come more than once (a cell that has grown): the last
 * record holds. What an index means is the run's: a cell of a map, a realisation of an ensemble, a sample of a level.
 *
 * One writer: the file is locked for as long as it is open. A journal of another run (command, string, precision, seed,
 * parameters) is refused. Kill -9 loses what was not yet appended; a power cut also what came after the last sync, 5 s at most.
 */
#ifndef KELLY_JOURNAL_H
#define KELLY_JOURNAL_H

#include <stdio.h>

#include "../firmware/kelly.h"

/* Whose records they are. Two runs whose records may stand for one another agree in all of it. */
typedef struct journal_run {
    const char *kind;            /* the command, at most 15 characters */
    const char *model;           /* id of the table */
    uint64_t seed;
    uint32_t parameters;         /* CRC-32C of everything else that the records depend on */
    uint32_t records;            /* indices are 0 .. records - 1 */
    uint32_t payload;            /* bytes of one record's payload, at least 1 */
    int in_order;                /* indices come as 0, 1, 2, ...: another one is unsound */
    int twice;                   /* each record is of two runs that agreed (--twice) */
    int (*sound)(const void *payload, size_t size);   /* whether it can be one of this kind; 0: any can */
} journal_run;

/* Fields are not to be touched; `next` may be read. Zeros: not open. */
typedef struct journal {
    int fd;
    char *path;
    FILE *earlier;               /* records of an earlier run that were not handed out yet, or 0 */
    uint32_t payload, records;
    int in_order;
    int (*sound)(const void *payload, size_t size);
    uint32_t next;               /* records that were handed out or appended */
    double synced;               /* when, monotonic [s] */
} journal;

/* CRC-32C of a case and of the version: what realisations depend on besides string, precision, seed and index. */
uint32_t case_identity(const kelly_case *run);

/* Open `output`.journal, locked. With `resume`, journal_next hands out what it holds; without, or where there is none, it begins anew, and a
 * journal with records, whose ever, becomes `output`.journal.old, in place of an older one. Nothing reads that: to go on from it, rename it.
 * Dies with exit 2 for a journal of another run or a file that is no journal (which is left as it is), with exit 1
 * where another process writes it or the file cannot be read or written. Says on stderr what it drops and from where it goes on. */
void journal_open(journal *j, const char *output, const journal_run *run, int resume);

/* The next sound record of an earlier run, in the order in which they were written: whole, with its CRC, of an index and contents that can
 * be. 0: there is none any more, what was behind is cut off, and records may be appended; `index` and `payload` then hold nothing of use. */
int journal_next(journal *j, uint32_t *index, void *payload);

/* Append the records of indices first .. first + count - 1, payloads one behind the other, in few writes. Dies with exit 1 if that
 * cannot be done (what lies there stays good). Not for two threads at once. */
void journal_append(journal *j, uint32_t first, uint32_t count, const void *payloads);

/* The output is in place: remove the journal, where it is open. */
void journal_remove(journal *j);

/* Little-endian words for payloads. */
void put_u32(uint8_t *to, uint32_t x);
uint32_t get_u32(const uint8_t *from);

#endif
