/* help.c - what `kelly`, `kelly --help` and `kelly COMMAND --help` print. The man page (manual.c) is made from the same
 * tables, and the bash completion asks --help: an option is described in one place. */
#include <string.h>

#include "host.h"

#define CASES 15

/* Options that several subcommands share; the parsers stand in options.c. */
static const option_help case_options[CASES + 1] = {
    { "--rpm", "R", "top speed [rpm]" },
    { "--wob", "KN", "weight on bit |f_c| [kN]" },
    { "--f0", "KN", "amplitude of the weight [kN]" },
    { "--mu", "M", "bit-rock factor mu [m]" },
    { "--alpha1", "A", "alpha_1 of the torque law [s/rad]" },
    { "--alpha2", "A", "alpha_2 of the torque law [s2/rad2]" },
    { "--start", "rest|rotating", "state of the string at t = 0" },
    { "--drive", "stiff|soft", "the top turns at --rpm whatever the torque, or yields as a soft-torque drive does; soft:Z=289,f=0.2,J=2900 sets "
      "some or all of impedance Z [N m s/rad] (default: the uppermost pipe's), return frequency f [Hz] (default 0.2), inertia J [kg m2] (default 2900);" },
    { "--duration", "T", "length of the run [s], a multiple of the step" },
    { "--window", "FROM:TO", "where severity is taken [s]; with --duration: its last half" },
    { "--step", "H", "RK4 step [s]" },
    { "--out-step", "H", "between output times [s]" },
    { "--limit", "S", "severity above which a run counts as stick-slip" },
    { "--torsional", "N", "torsional modes" },
    { "--axial", "N", "axial modes, the rigid one included" },
    { 0 },
};
static const option_help random_options[] = {
    { "--cov", "D", "coefficients of variation 0..0.5 of the gamma laws: one for all, or fc=D,mu=D,a1=D,a2=D,rpm=D, where what is not "
      "named is not random (default: the well file's)" },
    { "--seed", "S", "of the random streams (default 1)" },
    { 0 },
};
static const option_help ensemble_options[] = {
    { "--samples", "N", "realisations (default 400)" },
    { "--first", "J", "index of the first one (default 0)" },
    { "--threads", "T", "threads (default: one a processor); no result depends on it" },
    { "--csv", "F", "one line a realisation, in the order of the indices; - is stdout" },
    { "--twice", 0, TWICE_HELP },
    { "--convergence", 0, "the paper's convergence function, at 1, 2, 5, 10, 20, ... realisations" },
    { "--engine", "NAME", "vector unit: scalar, sse2, avx2, avx512 (default: the widest here); no result depends on it" },
    { 0 },
};
static const option_help simulate_options[] = {
    { "--out", "F.csv", "the run in time (default: stdout)" },
    { "--field", "F.npy|F.csv", "displacement [m] and twist [rad] along the string at every output time" },
    { "--sample", "J", "realisation J of --seed and --cov instead of the nominal case" },
    { 0 },
};
static const option_help resume_options[] = {
    { "--resume", 0, "go on from the journal that an interrupted run left beside its output, OUTPUT.journal" },
    { 0 },
};
static const option_help json_options[] = {
    { "--json", "F", "the result as JSON; - is stdout" },
    { 0 },
};
static const option_help common_options[] = {
    { "--quiet", 0, "no summary and no progress: only the files that were asked for, and errors" },
    { "--progress", "auto|json|none", "on stderr: a line on a terminal (auto, the default), JSON objects one a line, or nothing" },
    { "--help", 0, "this text" },
    { 0 },
};

static const option_group groups[] = {
    { "Case; the defaults are the well file's", TAKES_CASE, case_options },
    { "Randomness", TAKES_ENSEMBLE | TAKES_SIMULATE | TAKES_BENCH, random_options },
    { "Ensemble", TAKES_ENSEMBLE, ensemble_options },
    { "Output", TAKES_SIMULATE, simulate_options },
    { "Result", TAKES_JSON, json_options },
    { "Interrupted", TAKES_RESUME, resume_options },
};

/* Values that a run uses when nothing else is said, in the order of case_options. */
static void case_defaults(char text[CASES][DEFAULT_TEXT])
{
    const kelly_case *const run = &kelly_string.nominal;
    const double number[CASES] = {
        (double)run->w0 / RPM, (double)run->fc / 1000.0, (double)run->f0 / 1000.0, (double)run->mu, (double)run->a1, (double)run->a2, 0, 0,
        case_seconds(run, run->ticks), 0, case_seconds(run, 1), 0.01, (double)run->limit, run->torsional, run->axial,
    };

    for (unsigned i = 0; i < CASES; i++) {
        snprintf(text[i], DEFAULT_TEXT, " (default %.6g)", number[i]);
    }
    snprintf(text[6], DEFAULT_TEXT, " (default %s)", run->rotating ? "rotating" : "rest");
    snprintf(text[7], DEFAULT_TEXT, " (default stiff)");
    snprintf(text[9], DEFAULT_TEXT, " (default %.6g:%.6g)", case_seconds(run, run->window_first), case_seconds(run, run->window_last));
}

/* Whether a command describes this shared option itself, or refuses it. */
static int is_own(const command_help *help, const char *name)
{
    for (const option_help *own = help->own; own && own->name; own++) {
        if (strcmp(own->name, name) == 0) {
            return 1;
        }
    }
    return help->without && strcmp(help->without, name) == 0;
}

/* `shared`: the command whose own options take the place of the group's; or 0. */
static void walk_one(const option_group *group, const command_help *shared, option_visit visit, void *context)
{
    char text[CASES][DEFAULT_TEXT];

    case_defaults(text);
    visit(context, group->title, 0, "");
    for (unsigned i = 0; group->options[i].name; i++) {
        if (!shared || !is_own(shared, group->options[i].name)) {
            visit(context, group->title, &group->options[i], group->options == case_options ? text[i] : "");
        }
    }
}

void help_walk(const subcommand *c, option_visit visit, void *context)
{
    if (c->help->own) {
        walk_one(&(option_group){ "Its own", 0, c->help->own }, 0, visit, context);
    }
    if (c->help->also) {
        walk_one(&(option_group){ "And", 0, c->help->also }, 0, visit, context);
    }
    for (unsigned g = 0; g < sizeof(groups) / sizeof(groups[0]); g++) {
        if (c->help->takes & groups[g].takes) {
            walk_one(&groups[g], c->help, visit, context);
        }
    }
    walk_one(&(option_group){ "Always", 0, common_options }, 0, visit, context);
}

#define NAME_MOST 31u

/* Letters to be changed, put in or left out until a is b, a name of at most NAME_MOST. */
static size_t distance(const char *a, const char *b)
{
    const size_t length = strlen(b);
    size_t row[NAME_MOST + 1];   /* from what is read of a to the first letters of b */

    for (size_t j = 0; j <= length; j++) {
        row[j] = j;
    }
    for (size_t i = 0; a[i]; i++) {
        size_t before = row[0];

        row[0] = i + 1;
        for (size_t j = 0; j < length; j++) {
            const size_t same = before + (a[i] != b[j]), one = 1 + (row[j] < row[j + 1] ? row[j] : row[j + 1]);

            before = row[j + 1];
            row[j + 1] = same < one ? same : one;
        }
    }
    return row[length];
}

typedef struct {
    const char *given, *found;
    size_t away;                 /* letters of `found`; less than half of it */
} likeness;

static void compare(void *context, const char *title, const option_help *option, const char *fallback)
{
    likeness *const l = context;
    const size_t length = option ? strlen(option->name) : NAME_MOST + 1, away = length <= NAME_MOST ? distance(l->given, option->name) : l->away;

    (void)title, (void)fallback;
    if (away < l->away && 2 * away < length) {
        l->found = option->name;
        l->away = away;
    }
}

const char *help_like(const char *command, const char *name)
{
    likeness l = { name, 0, 3 };

    for (unsigned i = 0; i < command_count; i++) {
        if (!command) {
            compare(&l, "", &(option_help){ .name = commands[i].name }, "");
        } else if (strcmp(commands[i].name, command) == 0) {
            help_walk(&commands[i], compare, &l);
        }
    }
    return l.found;
}

/* Words of the text, a new line under the column of the first before 110 characters. */
static void print_wrapped(FILE *to, unsigned column, const char *text)
{
    unsigned at = column;

    while (*text) {
        const size_t word = strcspn(text, " ");

        if (at + 1 + word > 110 && at > column) {
            fprintf(to, "\n%*s", (int)column, "");
            at = column;
        }
        at += (unsigned)fprintf(to, "%s%.*s", at > column ? " " : "", (int)word, text);
        text += word + (text[word] == ' ');
    }
    fputc('\n', to);
}

static void print_option(void *context, const char *title, const option_help *option, const char *fallback)
{
    FILE *const to = context;
    char left[64], text[512];

    if (!option) {
        fprintf(to, "\n%s%s%s\n", ink(to, "1"), title, ink(to, "0"));
        return;
    }
    snprintf(left, sizeof(left), "%s%s%s", option->name, option->value ? " " : "", option->value ? option->value : "");
    snprintf(text, sizeof(text), "%s%s", option->text, fallback);
    fprintf(to, "  %-26s ", left);
    print_wrapped(to, 29, text);
}

void help_command(FILE *to, const subcommand *c)
{
    fprintf(to, "%skelly %s%s: %s\n\nusage: kelly %s%s%s\n", ink(to, "1"), c->name, ink(to, "0"), c->help->brief, c->name,
            c->help->synopsis[0] ? " " : "", c->help->synopsis);
    help_walk(c, print_option, to);
    if (c->help->notes) {
        fprintf(to, "\n%s\n", c->help->notes);
    }
    fprintf(to, "\n%sExample%s\n  %s\n", ink(to, "1"), ink(to, "0"), c->help->example);
}

static void print_commands(FILE *to)
{
    for (unsigned i = 0; i < command_count; i++) {
        fprintf(to, "  kelly %-12s %s\n", commands[i].name, commands[i].help->brief);
    }
}

void help_short(FILE *to)
{
    fprintf(to, "kelly " KELLY_VERSION ": how likely is this drill string to stick and slip?  (string %s)\n\n", kelly_string.id);
    fputs("Try first:  kelly montecarlo --mu 0.004\n\n", to);
    print_commands(to);
    fputs("\nkelly --help tells more, kelly COMMAND --help its options, units and defaults.\n", to);
}

void help_all(FILE *to)
{
    fprintf(to, "kelly " KELLY_VERSION ": how likely is this drill string to stick and slip?  (string %s)\n\n", kelly_string.id);
    print_commands(to);
    fputs("\nkelly COMMAND --help lists its options with units, defaults and an example.\n"
          "Options are --name VALUE or --name=VALUE. A file \"-\" is stdout. With NO_COLOR set nothing is coloured.\n"
          "Exit status: 0 " EXIT_DONE_TEXT ", 1 " EXIT_FAILED_TEXT ",\n2 " EXIT_USAGE_TEXT ".\n\n"
          "Examples:\n", to);
    for (unsigned i = 0; i < command_count; i++) {
        fprintf(to, "  %s\n", commands[i].help->example);
    }
}
