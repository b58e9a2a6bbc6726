/* host.h - what the subcommands share: options, files, threads. Nothing here is part of the kernel. */
#ifndef KELLY_HOST_H
#define KELLY_HOST_H

#include <stdio.h>

#include "../firmware/kelly.h"

#define RPM 0.10471975511965977   /* rad/s, the product that the generator uses too */

enum { EXIT_DONE = 0, EXIT_FAILED = 1, EXIT_USAGE = 2 };
#define EXIT_DONE_TEXT "done"
#define EXIT_FAILED_TEXT "the run failed, has no answer that can be trusted, or a file could not be written"
#define EXIT_USAGE_TEXT "bad usage or input (one line on stderr: what, where, what would be right)"

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
    const char *random_given;     /* --cov or --seed, whichever was given last, or 0 */
    const char *engine;           /* vector unit by name, or 0 for the widest */
    const char *field;            /* simulate: displacement and twist along the string, F.npy or F.csv, or 0 */
    int resume;                   /* go on from the journal */
    int twice;                    /* run each realisation twice; where the two differ it is corrupt */
    int quiet;                    /* no summary */
    int progress;                 /* PROGRESS_... */
} options;

enum { PROGRESS_AUTO, PROGRESS_JSON, PROGRESS_NONE };

/* Options that a subcommand takes, or'ed. */
enum { TAKES_CASE = 1, TAKES_ENSEMBLE = 2, TAKES_SIMULATE = 4, TAKES_JSON = 8, TAKES_BENCH = 16, TAKES_RESUME = 32 };

/* A subcommand's own options: 1 if it knows this name and took the value, 0 if not; dies with exit 2 on a bad value. */
typedef int (*more_options)(void *context, const char *name, const char *value);

/* Parse argv[0..argc-1] (without the subcommand) for a command that takes `takes` and, where not 0, `more`; dies with
 * exit 2 on a mistake. Values start from the nominal case of the table. */
void options_parse(options *out, int argc, char **argv, unsigned takes, const char *command, more_options more, void *context);

/* Dies with exit 2 where --seed or --cov is given without --sample, for who takes a single run. */
void check_nominal(const options *opts);

/* Dies with exit 2 where first + samples runs over; for who takes both, once it knows how many there are. */
void check_indices(const options *opts);

/* A finite number in lo..hi, a whole number in lo..hi; die with exit 2, and `right` in the message, on anything else. */
double option_number(const char *option, const char *text, double lo, double hi, const char *right);
uint64_t option_whole(const char *option, const char *text, uint64_t lo, uint64_t hi, const char *right);

/* A --cov: one number for all, or name=number,... (see law_names in options.c); those of parameters not named stay. */
void option_covs(float cov[KELLY_PARAMETERS], const char *text);

/* A --drive: stiff, or soft with its values; see drive.c. Dies with exit 2. */
void option_drive(kelly_drive *drive, const char *text);

/* The drive as --drive takes it; for a summary, ", drive ..." or nothing where it is stiff. Both return `text`. */
#define DRIVE_TEXT 112
const char *drive_text(const kelly_drive *drive, char text[DRIVE_TEXT]);
const char *drive_remark(const kelly_drive *drive, char text[DRIVE_TEXT]);

/* Seconds of a case from its ticks; it has at most STEPS_MOST of them. */
#define STEPS_MOST 4e9
double case_seconds(const kelly_case *run, uint32_t ticks);

/* The largest safe step > 0 [s], or the `least`, in four digits, rounded so that --step may be given it. Returns `text`. */
#define STEP_TEXT 16
const char *step_text(double seconds, int least, char text[STEP_TEXT]);

/* ---- help ---------------------------------------------------------------------------------------------------- */

/* An option as --help, the man page and the completion show it. Lists end with a name of 0. */
typedef struct {
    const char *name, *value;     /* "--csv", "F"; value 0 where it takes none */
    const char *text;             /* what it means, [unit], (default ...) */
} option_help;

/* Help of a subcommand; stands in the file of the subcommand. */
typedef struct {
    const char *brief;            /* what it does, without a full stop */
    const char *synopsis;         /* what follows "kelly NAME" */
    unsigned takes;               /* the shared options, as in options_parse */
    const char *without;          /* the one of them that it refuses, or 0 */
    const option_help *own;       /* those of its `more_options`, or 0 */
    const option_help *also;      /* more of them, or 0 */
    const char *notes;            /* what else must be known, or 0 */
    const char *example;
} command_help;

typedef struct {
    const char *name;
    int (*run)(int argc, char **argv);
    const command_help *help;
    int shared;                   /* the other processes of a team take part */
} subcommand;

extern const subcommand commands[];
extern const unsigned command_count;

#define DEFAULT_TEXT 48

typedef struct {
    const char *title;
    unsigned takes;
    const option_help *options;
} option_group;

/* Called for each group (option 0) and for each of its options, with its default in words or "". */
typedef void (*option_visit)(void *context, const char *title, const option_help *option, const char *fallback);

void help_walk(const subcommand *c, option_visit visit, void *context);
/* The option of this command, or with 0 the command, whose name is this one but for two letters or fewer; 0 where there is none. */
const char *help_like(const char *command, const char *name);

void help_command(FILE *to, const subcommand *c);
void help_short(FILE *to);        /* for `kelly` alone */
void help_all(FILE *to);

/* ---- screen -------------------------------------------------------------------------------------------------- */

/* Escape sequence of a colour for this stream, or "": NO_COLOR, no terminal. */
const char *ink(FILE *to, const char *code);

/* Progress on stderr: whether anybody looks; `done` of `total` after `seconds`; and the end of it. */
int progress_wanted(const options *opts);
void progress_show(const options *opts, uint64_t done, uint64_t total, double seconds);
void progress_end(const options *opts, uint64_t total, double seconds);

/* ---- files --------------------------------------------------------------------------------------------------- */

/* A journal is open (1) or gone (-1): an interrupt tells of --resume where there is one. */
void journals_open(int by);

/* A file that appears whole or not at all: written as PATH.part and renamed when it is closed. What a killed run leaves of it, the next
 * one takes over. */
typedef struct {
    FILE *stream;
    const char *name;             /* as it was asked for */
    char *path, *temporary;       /* both 0 for stdout */
    int fd;                       /* of the stream, where there is a path */
} outfile;

/* Open for writing ("-": stdout); dies with exit 1 if that cannot be done, or another process writes there. */
void outfile_open(outfile *file, const char *path);

/* Flush, check, sync and rename; dies with exit 1, leaving nothing behind, if any byte was lost. */
void outfile_close(outfile *file);

/* Close, and leave what is at its path as it was. */
void outfile_drop(outfile *file);

/* Open for reading and for writing at its end, made where it is not there, locked until it is closed. Dies like outfile_open. */
int open_locked(const char *path);

/* Whether it names a file that will be renamed into its place, or 0: stdout, devices, no path. */
int is_plain_file(const char *path);

/* Before anything runs: dies with exit 2 where two of the outputs of a command (0: not asked for) are one file, or one is what is kept beside
 * another while it is made; where an output is a file that the command reads. */
void check_outputs(const char *const outputs[], unsigned count);
void check_input(const char *input, const char *const outputs[], unsigned count);

/* Header of a NPY 1.0 file, what numpy.load reads: type "<f8" or a list of fields as Python writes it, and the shape. Raw values in
 * C order follow; `<` in the type stands for this machine's byte order. */
void npy_header(FILE *to, const char *type, unsigned dimensions, const uint64_t *shape);

/* A plant in time: header and one line of CSV. */
#define SIGHT_HEADER "time_s,bit_speed_rpm,bit_torque_kNm,wob_kN,bit_axial_speed_m_s,surface_torque_kNm,top_speed_rpm\n"
void sight_line(FILE *to, double time, const kelly_sight *s);

/* Dies with exit 2: why this draw cannot be run, and what could be. `plant` as kelly_plant_start left it. */
_Noreturn void plant_refuse(const kelly_plant *plant, const options *opts, const kelly_draw *draw, kelly_status status);

/* Displacement and twist along the string, one instant after another; see field.c. */
typedef struct {
    outfile file;
    int npy;
    unsigned torsional, axial;    /* modes of the run; axial 0: no field is written */
    real *twist, *displacement;   /* shapes at the weight of the run, [mode * nodes] */
    double *row;                  /* [nodes * 4] */
} field_file;

/* Open for a run of opts with this draw; path 0: none. Exit 2 for a name that says neither .npy nor .csv. */
void field_open(field_file *field, const char *path, const options *opts, const kelly_draw *draw);
void field_write(field_file *field, const kelly_plant *plant, double time);
void field_close(field_file *field);

/* ---- ensembles ----------------------------------------------------------------------------------------------- */

/* Engines in this program that this processor can run, narrowest first; returns their number. */
unsigned engines_usable(const kelly_engine *list[4]);

/* The engine of that name, or the widest usable one for 0; dies with exit 2 for a name that cannot run here. */
const kelly_engine *engine_choose(const char *name);

/* Realisations that this engine best runs together: fewer than it holds where many modes would leave the cache. */
unsigned engine_lanes(const kelly_engine *engine, const kelly_case *run);

#define TWICE_HELP "run every realisation twice and count it only where both agree in every bit: finds a fault of the machine in between"

/* e->run and e->run_draws for a run of opts: once, or with --twice two times. `count` results. */
void engine_run(const kelly_engine *e, const options *opts, const kelly_case *run, uint32_t first, uint32_t count,
                kelly_result *results, void *work);
void engine_run_draws(const kelly_engine *e, const options *opts, const kelly_draw *draws, uint32_t count, kelly_result *results, void *work);

/* Whether these bytes are results that an engine can have given: statuses and flags that there are, numbers that are finite. */
int results_sound(const void *payload, size_t size);

/* Dies where a result is corrupt: for who has no place for one. */
void check_intact(const kelly_result *result, uint32_t index);

unsigned processors(void);

/* Threads of this process: those that were asked for, or one a processor; in a team one. */
unsigned threads_of(const options *opts);

/* Work on one piece of a batch: realisations first .. first + count - 1 into results[0..count-1]. */
typedef void (*piece_work)(const options *opts, uint32_t first, uint32_t count, void *results, void *work);

/* What is handed each finished batch, in the order of the indices. */
typedef void (*batch_sink)(void *context, uint32_t first, uint32_t count, const void *results);

struct journal;

typedef struct {
    piece_work work;
    size_t work_size;             /* scratch of one thread [bytes] */
    size_t result_size;           /* of one realisation [bytes] */
    unsigned width, lanes;        /* pieces are whole vectors of `width`, at most `lanes` realisations */
    const int *enough;            /* or 0: once the sink has set it, no further batch is begun; batches are short then */
    struct journal *log;          /* of a job_log, or 0 */
    void *inputs;                 /* what each realisation needs besides opts, one after another; in a follower of a team room for it; or 0 */
    size_t input_size;            /* of one realisation [bytes] */
    int more;                     /* more such jobs follow, until team_dismiss */
    int lead_alone;               /* of several processes the first alone runs it: `work` leaves more behind than results */
} job;

/* Run all realisations of opts over its threads, and the other processes of a team, but those that the journal still holds; results reach
 * the sink in index order, of the first process alone. Memory does not grow with samples. */
void run_job(const options *opts, const job *what, batch_sink sink, void *context);

/* Realisations whose results are in memory at once, for so many threads and processes. */
uint64_t job_batch(unsigned workers);

/* A journal for the results of realisations of opts beside an output; where `beside` is 0, or another process leads, it stays closed.
 * `what` says kind, records and payload, whether they come in order, and in `parameters` what results depend on besides string, precision,
 * case, seed and index. Dies as journal_open does. The caller removes it once its files are in their places. */
struct journal_run;
void job_log(struct journal *log, const options *opts, const char *beside, const struct journal_run *what);

/* --until-width and --until-decided: where to stop before all samples are run; see until.c. Start from zeros. */
typedef struct {
    kelly_stop_rule rule;         /* alpha 0: not asked for */
    double width, level;          /* as they were asked for */
    float lo, hi;                 /* the interval where it stopped */
    int enough;                   /* kelly_stop, of the last look */
} until_request;

#define UNTIL_MOST 1000000u       /* realisations where --samples does not say */
extern const option_help until_options[];
int until_option(void *request, const char *name, const char *value);              /* a more_options */

/* Look after one more realisation: 1 where it was the last one that counts. Never where nothing was asked for. */
int until_look(until_request *ask, const kelly_tally *tally);

/* `"sequence": {...},` of the JSON; one line of the summary. Nothing where nothing was asked for. */
void until_write(FILE *to, const until_request *ask, uint32_t most);
void until_print(const until_request *ask, uint32_t n);

/* A status as files and screens show it. */
extern const char *const status_names[KELLY_STATUSES];

/* ---- subcommands --------------------------------------------------------------------------------------------- */

int command_modes(int argc, char **argv);
int command_simulate(int argc, char **argv);
int command_montecarlo(int argc, char **argv);
int command_map(int argc, char **argv);
int command_advise(int argc, char **argv);
int command_sensitivity(int argc, char **argv);
int command_whatif(int argc, char **argv);
int command_rare(int argc, char **argv);
int command_plan(int argc, char **argv);
int command_merge(int argc, char **argv);
int command_bench(int argc, char **argv);
int command_manual(int argc, char **argv);
extern const command_help modes_help, simulate_help, montecarlo_help, map_help, advise_help, manual_help;
extern const command_help sensitivity_help, whatif_help, rare_help, plan_help, merge_help, bench_help;

/* The paper's convergence function over the realisations of opts: writes value[i] at checkpoint n[i]; see convergence.c. Its journal, where
 * there is an output for it to lie beside, is OUTPUT.convergence.journal; the caller removes it. */
#define CHECKPOINTS_MAX 40
typedef struct {
    unsigned count;
    uint32_t n[CHECKPOINTS_MAX];
    double value[CHECKPOINTS_MAX];
} convergence_table;

void convergence_run(const options *opts, const char *beside, struct journal *log, convergence_table *table);

/* Statistics in time, and traces, of the realisations of opts; see envelope.c. Start from zeros. */
typedef struct {
    const char *envelope, *traces;   /* files, or 0 */
    unsigned quantity;            /* of the traces */
    int streaming;
    double bytes;                 /* of memory: envelope_reserve */
    uint32_t used, times;         /* realisations and instants: envelope_run */
} envelope_request;

extern const option_help envelope_options[];
int envelope_option(void *request, const char *name, const char *value);           /* a more_options */

/* Take the memory and open the files; dies with exit 2 where it does not fit, with exit 1 where they cannot be written. Then run and write. Nothing
 * where nothing was asked for. The journal is that of convergence_run, OUTPUT.envelope.journal. */
void envelope_reserve(envelope_request *ask, const options *opts);
void envelope_run(envelope_request *ask, const options *opts, const char *beside, struct journal *log);

#endif
