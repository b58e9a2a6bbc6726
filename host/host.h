/* host.h - what the subcommands share: options, files, threads. Nothing here is part of the kernel. */
#ifndef KELLY_HOST_H
#define KELLY_HOST_H

#include <stdio.h>

#include "../firmware/kelly.h"

#define RPM 0.10471975511965977   /* rad/s, the product that the generator uses too */

enum { EXIT_DONE = 0, EXIT_FAILED = 1, EXIT_USAGE = 2 };

/* One line on stderr, "kelly: ...", and exit with this status. What, where, what would be right. */
_Noreturn void die(int status, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* ---- options ------------------------------------------------------------------------------------------------- */

/* What the command line asked for. */
typedef struct {
    kelly_case run;
    double out_step;              /* [s] */
    uint32_t out_ticks;           /* the same in steps */
    uint64_t seed;
    uint32_t first, samples;
    unsigned threads;             /* 0: as many as there are processors */
    int sample_given;             /* simulate one realisation instead of the nominal case */
    uint32_t sample;
    int convergence;
    const char *json, *csv, *out; /* paths, "-" for stdout, or 0 */
    const char *engine;           /* vector unit by name, or 0 for the widest */
} options;

/* Options that a subcommand takes, or'ed. */
enum { TAKES_CASE = 1, TAKES_ENSEMBLE = 2, TAKES_SIMULATE = 4, TAKES_JSON = 8 };

/* A subcommand's own options: 1 if it knows this name and took the value, 0 if not; dies with exit 2 on a bad value. */
typedef int (*more_options)(void *context, const char *name, const char *value);

/* Parse argv[0..argc-1] (without the subcommand) for a command that takes `takes` and, where not 0, `more`; dies with
 * exit 2 on a mistake. Values start from the nominal case of the table. */
void options_parse(options *out, int argc, char **argv, unsigned takes, const char *command, more_options more, void *context);

/* A finite number in lo..hi, a whole number in lo..hi; die with exit 2, and `right` in the message, on anything else. */
double option_number(const char *option, const char *text, double lo, double hi, const char *right);
uint64_t option_whole(const char *option, const char *text, uint64_t lo, uint64_t hi, const char *right);

/* Seconds of a case from its ticks. */
double case_seconds(const kelly_case *run, uint32_t ticks);

/* ---- files --------------------------------------------------------------------------------------------------- */

/* A file that appears whole or not at all: written beside its place and renamed when it is closed. */
typedef struct {
    FILE *stream;
    char *path, *temporary;       /* both 0 for stdout */
} outfile;

/* Open for writing ("-": stdout); dies with exit 1 if that cannot be done. */
void outfile_open(outfile *file, const char *path);

/* Flush, check and rename; dies with exit 1, leaving nothing behind, if any byte was lost. */
void outfile_close(outfile *file);

/* ---- ensembles ----------------------------------------------------------------------------------------------- */

/* Engines in this program that this processor can run, narrowest first; returns their number. */
unsigned engines_usable(const kelly_engine *list[4]);

/* The engine of that name, or the widest usable one for 0; dies with exit 2 for a name that cannot run here. */
const kelly_engine *engine_choose(const char *name);

unsigned processors(void);

/* Work on one piece of a batch: realisations first .. first + count - 1 into results[0..count-1]. */
typedef void (*piece_work)(const options *opts, uint32_t first, uint32_t count, void *results, void *work);

/* What is handed each finished batch, in the order of the indices. */
typedef void (*batch_sink)(void *context, uint32_t first, uint32_t count, const void *results);

typedef struct {
    piece_work work;
    size_t work_size;             /* scratch of one thread [bytes] */
    size_t result_size;           /* of one realisation [bytes] */
    unsigned width, lanes;        /* pieces are whole vectors of `width`, at most `lanes` realisations */
} job;

/* Run all realisations of opts over its threads; results reach the sink in index order. Memory does not grow with samples. */
void run_job(const options *opts, const job *what, batch_sink sink, void *context);

/* ---- subcommands --------------------------------------------------------------------------------------------- */

int command_modes(int argc, char **argv);
int command_simulate(int argc, char **argv);
int command_montecarlo(int argc, char **argv);

/* The paper's convergence function over the realisations of opts: writes value[i] at checkpoint n[i]; see convergence.c. */
#define CHECKPOINTS_MAX 40
typedef struct {
    unsigned count;
    uint32_t n[CHECKPOINTS_MAX];
    double value[CHECKPOINTS_MAX];
} convergence_table;

void convergence_run(const options *opts, convergence_table *table);

#endif
