/* options.c - the command line: every value checked, every mistake one line. */
#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host.h"

#define DIGITS "0123456789"

/* Times as they were asked for, until the step is known. */
typedef struct {
    double step, duration, window[2];
    int window_given;
} times;

double case_seconds(const kelly_case *run, uint32_t ticks)
{
    return (double)ticks * (double)run->step_ns / 1e9;
}

/* The least step of 1 us has four digits down to whole nanoseconds. */
const char *step_text(double seconds, int least, char text[STEP_TEXT])
{
    const double unit = pow(10.0, floor(log10(seconds)) - 3.0);

    (void)snprintf(text, STEP_TEXT, "%.4g", (least ? ceil(seconds / unit) : floor(seconds / unit)) * unit);
    return text;
}

/* A finite number and nothing else; the bounds are part of the message. */
double option_number(const char *option, const char *text, double lo, double hi, const char *right)
{
    char *end;
    double x;

    errno = 0;
    x = strtod(text, &end);
    if (end == text || *end != '\0' || !isfinite(x) || isspace((unsigned char)text[0])) {
        die(EXIT_USAGE, "%s %s: not a finite number; give %s", option, text, right);
    }
    if (!(x >= lo && x <= hi)) {
        die(EXIT_USAGE, "%s %s: out of range; give %s", option, text, right);
    }
    return x;
}

#define POWER_MOST 100000L       /* of ten; no text has as many digits */

/* The whole number that digits are, or digits with a power of ten, 1e6 or 0.2e2: taken digit by digit, so that none is lost. `beyond`: it is
 * 2^64 or more. Returns 0 where it is none. */
static int read_whole(const char *text, uint64_t *whole, int *beyond)
{
    const long head = (long)strspn(text, DIGITS), point = text[head] == '.', all = head + (point ? (long)strspn(text + head + 1, DIGITS) : 0);
    const char *const mark = text + all + point, *const power = mark + 1 + (*mark == 'e' && (mark[1] == '+' || mark[1] == '-'));
    const long by = *mark == 'e' ? strtol(mark + 1, 0, 10) : 0, places = head + (by > POWER_MOST ? POWER_MOST : by < -POWER_MOST ? -POWER_MOST : by);

    if (head == 0 || (text[head] && (*mark != 'e' || !*power || power[strspn(power, DIGITS)]))) {
        return 0;
    }
    *whole = 0;
    *beyond = 0;
    for (long i = 0; i < places || i < all; i++) {
        const unsigned digit = i < all ? (unsigned)(text[i < head ? i : i + 1] - '0') : 0;

        if (i >= places && digit > 0) {
            return 0;            /* behind the point */
        }
        if (i < places) {
            *beyond |= *whole > (UINT64_MAX - digit) / 10;
            *whole = *whole * 10 + digit;
        }
    }
    return 1;
}

/* With a sign or beyond 2^64 it is still a whole number, but out of range. */
uint64_t option_whole(const char *option, const char *text, uint64_t lo, uint64_t hi, const char *right)
{
    const char *const digits = text + (text[0] == '-');
    uint64_t whole;
    int beyond;

    if (!read_whole(digits, &whole, &beyond)) {
        die(EXIT_USAGE, "%s %s: not a whole number; give %s", option, text, right);
    }
    if (digits != text || beyond || whole < lo || whole > hi) {
        die(EXIT_USAGE, "%s %s: out of range; give %s", option, text, right);
    }
    return whole;
}

/* Parameters by the names of the command line, in the order of the laws. */
static const char *const law_names[KELLY_PARAMETERS] = { "fc", "mu", "a1", "a2", "rpm" };

static unsigned law_index(const char *name, size_t length)
{
    for (unsigned k = 0; k < KELLY_PARAMETERS; k++) {
        if (strlen(law_names[k]) == length && strncmp(law_names[k], name, length) == 0) {
            return k;
        }
    }
    die(EXIT_USAGE, "--cov %s: no such parameter; give --cov 0.2 or some of fc=,mu=,a1=,a2=,rpm=", name);
}

/* One number for all, or name=number,...: those of parameters that are not named stay. */
void option_covs(float cov[KELLY_PARAMETERS], const char *text)
{
    static const char right[] = "0..0.5, one number or fc=..,mu=..,a1=..,a2=..,rpm=..";
    char copy[256], *rest = copy;
    unsigned seen = 0;
    char label[32];

    if (!strchr(text, '=')) {
        const float all = (float)option_number("--cov", text, 0.0, 0.5, right);

        for (unsigned k = 0; k < KELLY_PARAMETERS; k++) {
            cov[k] = all;
        }
        return;
    }
    if (strlen(text) >= sizeof(copy)) {
        die(EXIT_USAGE, "--cov %s: too long; give %s", text, right);
    }
    strcpy(copy, text);
    while (rest) {
        char *const part = strsep(&rest, ",");
        char *const equals = strchr(part, '=');
        unsigned k;

        if (!equals) {
            die(EXIT_USAGE, "--cov %s: '%s' is not name=number; give %s", text, part, right);
        }
        k = law_index(part, (size_t)(equals - part));
        if (seen & 1u << k) {
            die(EXIT_USAGE, "--cov %s: %s stands twice; give each parameter once", text, law_names[k]);
        }
        seen |= 1u << k;
        if (equals[1] == '\0') {
            die(EXIT_USAGE, "--cov %s: %s has no number; give %s", text, law_names[k], right);
        }
        snprintf(label, sizeof(label), "--cov %s:", law_names[k]);
        cov[k] = (float)option_number(label, equals + 1, 0.0, 0.5, right);
    }
}

static void parse_window(times *when, const char *text)
{
    static const char right[] = "FROM:TO in seconds within the duration, e.g. 50:100";
    const char *const colon = strchr(text, ':');
    char copy[128];

    if (!colon || strlen(text) >= sizeof(copy)) {
        die(EXIT_USAGE, "--window %s: not a window; give %s", text, right);
    }
    strcpy(copy, text);
    copy[colon - text] = '\0';
    when->window[0] = option_number("--window", copy, 0.0, 1e9, right);
    when->window[1] = option_number("--window", colon + 1, 0.0, 1e9, right);
    when->window_given = 1;
    if (!(when->window[0] < when->window[1])) {
        die(EXIT_USAGE, "--window %s: %s; give %s", text, when->window[0] > when->window[1] ? "ends before it begins" : "is empty", right);
    }
}

/* A time as whole steps, or one line of why not. */
static uint32_t ticks_of(const char *option, double seconds, uint32_t step_ns)
{
    const double ticks = seconds * 1e9 / (double)step_ns, nearest = nearbyint(ticks);

    if (fabs(ticks - nearest) > 1e-6 * (1.0 + 1e-6 * nearest)) {
        die(EXIT_USAGE, "%s %.12g: not a whole number of steps of %.12g s; give a multiple of the step", option, seconds, (double)step_ns / 1e9);
    }
    if (nearest > STEPS_MOST) {
        die(EXIT_USAGE, "%s %.12g: too long; at most %g steps, which is %.12g s here", option, seconds, STEPS_MOST, 1e-9 * STEPS_MOST * (double)step_ns);
    }
    return (uint32_t)nearest;
}

static uint32_t step_of(double seconds)
{
    const double ns = nearbyint(seconds * 1e9);

    if (fabs(seconds * 1e9 - ns) > 1e-12 * ns) {   /* what a double rounds off */
        die(EXIT_USAGE, "--step %.12g: not a whole number of nanoseconds; give e.g. 0.001", seconds);
    }
    return (uint32_t)ns;
}

/* Put the asked times onto the grid of the step. */
static void settle_times(options *out, const times *when)
{
    kelly_case *const run = &out->run;

    run->step_ns = step_of(when->step);
    run->ticks = ticks_of("--duration", when->duration, run->step_ns);
    if (run->ticks == 0) {
        die(EXIT_USAGE, "--duration %.12g: shorter than a step; give seconds > 0, e.g. 100", when->duration);
    }
    if (when->window_given) {
        run->window_first = ticks_of("--window", when->window[0], run->step_ns);
        run->window_last = ticks_of("--window", when->window[1], run->step_ns);
    } else {
        run->window_first = run->ticks / 2;
        run->window_last = run->ticks;
    }
    if (run->window_last > run->ticks) {
        die(EXIT_USAGE, "--window %.12g:%.12g: ends after the duration of %.12g s; give a window within 0:%.12g", when->window[0], when->window[1],
            when->duration, when->duration);
    }
    if (!(out->out_step > 0)) {   /* not asked for: 0.01 s, or the whole steps next below it */
        out->out_step = when->step * fmax(1.0, floor(0.01 / when->step + 1e-6));
    }
    out->out_ticks = ticks_of("--out-step", out->out_step, run->step_ns);
    if (out->out_ticks == 0) {
        die(EXIT_USAGE, "--out-step %.12g: shorter than a step of %.12g s; give a multiple of the step", out->out_step, when->step);
    }
}

static uint8_t option_modes(const char *name, const char *value, unsigned most)
{
    char right[64];

    snprintf(right, sizeof(right), "a number of modes that the table carries, 1..%u", most);
    return (uint8_t)option_whole(name, value, 1, most, right);
}

static int parse_case(options *out, times *when, const char *name, const char *value)
{
    kelly_case *const run = &out->run;

    if (strcmp(name, "--rpm") == 0) {
        run->w0 = (real)(option_number(name, value, 1e-3, 1e4, "top speed in rpm, 0.001..10000") * RPM);
    } else if (strcmp(name, "--wob") == 0) {
        run->fc = (real)(option_number(name, value, 1e-3, 1e6, "weight on bit in kN, 0.001..1000000") * 1000.0);
    } else if (strcmp(name, "--mu") == 0) {
        run->mu = (real)option_number(name, value, 1e-9, 1e3, "a bit-rock factor in m, 1e-9..1000, e.g. 0.04");
    } else if (strcmp(name, "--alpha1") == 0) {
        run->a1 = (real)option_number(name, value, 1e-9, 1e6, "alpha_1 in s/rad, 1e-9..1000000, e.g. 2");
    } else if (strcmp(name, "--alpha2") == 0) {
        run->a2 = (real)option_number(name, value, 1e-9, 1e6, "alpha_2 in s2/rad2, 1e-9..1000000, e.g. 1");
    } else if (strcmp(name, "--f0") == 0) {
        run->f0 = (real)(option_number(name, value, 0.0, 1e6, "amplitude of the weight in kN, 0..1000000") * 1000.0);
    } else if (strcmp(name, "--limit") == 0) {
        run->limit = (real)option_number(name, value, 0.0, 10.0, "a severity in 0..10, e.g. 0.8");
    } else if (strcmp(name, "--torsional") == 0) {
        run->torsional = option_modes(name, value, kelly_string.torsional);
    } else if (strcmp(name, "--axial") == 0) {
        run->axial = option_modes(name, value, kelly_string.axial);
    } else if (strcmp(name, "--step") == 0) {
        when->step = option_number(name, value, 1e-6, 1.0, "the RK4 step in seconds, 1e-6..1, e.g. 0.001");
    } else if (strcmp(name, "--duration") == 0) {
        when->duration = option_number(name, value, 1e-6, 1e9, "seconds, 1e-6..1e9, e.g. 100");
        when->window_given = when->window_given == 1;
    } else if (strcmp(name, "--window") == 0) {
        parse_window(when, value);
    } else if (strcmp(name, "--out-step") == 0) {
        out->out_step = option_number(name, value, 1e-6, 1e9, "seconds between output lines, 1e-6..1e9, e.g. 0.01");
    } else if (strcmp(name, "--start") == 0) {
        if (strcmp(value, "rest") != 0 && strcmp(value, "rotating") != 0) {
            die(EXIT_USAGE, "--start %s: unknown; give rest or rotating", value);
        }
        run->rotating = strcmp(value, "rotating") == 0;
    } else if (strcmp(name, "--drive") == 0) {
        option_drive(&run->drive, value);
    } else {
        return 0;
    }
    return 1;
}

static int parse_random(options *out, const char *name, const char *value, unsigned takes)
{
    if (strcmp(name, "--cov") == 0) {
        memset(out->run.cov, 0, sizeof(out->run.cov));   /* what is not named is not random */
        option_covs(out->run.cov, value);
        out->random_given = "--cov";
    } else if (strcmp(name, "--seed") == 0) {
        out->seed = option_whole(name, value, 0, UINT64_MAX, "a whole number 0..18446744073709551615");
        out->random_given = "--seed";
    } else if (takes & (TAKES_SIMULATE | TAKES_BENCH) && strcmp(name, "--sample") == 0) {
        out->sample = (uint32_t)option_whole(name, value, 0, UINT32_MAX, "the index of a realisation, 0..4294967295");
        out->sample_given = 1;
    } else if (takes & (TAKES_SIMULATE | TAKES_BENCH) && strcmp(name, "--out") == 0) {
        out->out = value;
    } else if (takes & TAKES_SIMULATE && strcmp(name, "--field") == 0) {
        out->field = value;
    } else if (takes & (TAKES_ENSEMBLE | TAKES_BENCH) && strcmp(name, "--samples") == 0) {
        out->samples = (uint32_t)option_whole(name, value, 1, UINT32_MAX, "a number of realisations, 1..4294967295");
    } else if (takes & (TAKES_ENSEMBLE | TAKES_BENCH) && strcmp(name, "--first") == 0) {
        out->first = (uint32_t)option_whole(name, value, 0, UINT32_MAX, "the first index, 0..4294967295");
    } else if (takes & TAKES_ENSEMBLE && strcmp(name, "--threads") == 0) {
        out->threads = (unsigned)option_whole(name, value, 1, 1024, "a number of threads, 1..1024");
    } else if (takes & (TAKES_ENSEMBLE | TAKES_BENCH) && strcmp(name, "--csv") == 0) {
        out->csv = value;
    } else if (takes & TAKES_ENSEMBLE && strcmp(name, "--engine") == 0) {
        out->engine = value;
    } else {
        return 0;
    }
    return 1;
}

/* Options of every subcommand that need no value: 1 if this is one. */
static int parse_flag(options *out, const char *name, unsigned takes)
{
    if (takes & TAKES_ENSEMBLE && strcmp(name, "--convergence") == 0) {
        out->convergence = 1;
    } else if (takes & TAKES_RESUME && strcmp(name, "--resume") == 0) {
        out->resume = 1;
    } else if (takes & TAKES_ENSEMBLE && strcmp(name, "--twice") == 0) {
        out->twice = 1;
    } else if (strcmp(name, "--quiet") == 0) {
        out->quiet = 1;
    } else {
        return 0;
    }
    return 1;
}

/* Options of every subcommand with a value. */
static int parse_common(options *out, const char *name, const char *value)
{
    if (strcmp(name, "--progress") != 0) {
        return 0;
    }
    if (strcmp(value, "json") == 0) {
        out->progress = PROGRESS_JSON;
    } else if (strcmp(value, "none") == 0) {
        out->progress = PROGRESS_NONE;
    } else if (strcmp(value, "auto") == 0) {
        out->progress = PROGRESS_AUTO;
    } else {
        die(EXIT_USAGE, "--progress %s: unknown; give auto, json or none", value);
    }
    return 1;
}

/* Dies where it is no option of the command. */
static void check_known(const char *command, const char *name)
{
    const char *const meant = help_like(command, name);

    if (!meant) {
        die(EXIT_USAGE, "%s: unknown option %s; see kelly %s --help", command, name, command);
    }
    if (strcmp(meant, name) != 0) {
        die(EXIT_USAGE, "%s: unknown option %s; did you mean %s?", command, name, meant);
    }
}

/* One "--name value" or "--name=value"; returns how many arguments it took. */
static int parse_one(options *out, times *when, int argc, char **argv, unsigned takes, const char *command, more_options more, void *context)
{
    char name[32];
    const char *value = 0, *equals = strchr(argv[0], '=');
    const size_t length = equals ? (size_t)(equals - argv[0]) : strlen(argv[0]);
    int known;

    if (strncmp(argv[0], "--", 2) != 0 || length >= sizeof(name)) {
        die(EXIT_USAGE, "%s: '%s' is not an option; see kelly %s --help", command, argv[0], command);
    }
    memcpy(name, argv[0], length);
    name[length] = '\0';
    if (parse_flag(out, name, takes)) {
        if (equals) {
            die(EXIT_USAGE, "%s: takes no value; give %s", argv[0], name);
        }
        return 1;
    }
    value = equals ? equals + 1 : argc > 1 ? argv[1] : "";
    if (*value == '\0') {
        check_known(command, name);
        die(EXIT_USAGE, "%s: needs a value; see kelly %s --help", name, command);
    }
    known = parse_common(out, name, value) || (takes & TAKES_CASE && parse_case(out, when, name, value)) ||
            (takes & (TAKES_ENSEMBLE | TAKES_SIMULATE | TAKES_BENCH) && parse_random(out, name, value, takes));
    if (!known && takes & TAKES_JSON && strcmp(name, "--json") == 0) {
        out->json = value;
        known = 1;
    }
    known = known || (more && more(context, name, value));
    if (!known) {
        check_known(command, name);
        die(EXIT_USAGE, "%s: %s is not for this use; see kelly %s --help", command, name, command);
    }
    return equals ? 1 : 2;
}

void check_nominal(const options *opts)
{
    if (opts->random_given && !opts->sample_given) {
        die(EXIT_USAGE, "%s: the nominal case is not random; give --sample J too, the realisation that is meant", opts->random_given);
    }
}

void check_indices(const options *opts)
{
    if ((uint64_t)opts->first + opts->samples > (uint64_t)UINT32_MAX + 1) {
        die(EXIT_USAGE, "--first %u: indices end at 4294967295, and there are %u realisations; give a lower one, or fewer --samples", opts->first, opts->samples);
    }
}

void options_parse(options *out, int argc, char **argv, unsigned takes, const char *command, more_options more, void *context)
{
    const kelly_case *const nominal = &kelly_string.nominal;
    times when = { .step = (double)nominal->step_ns / 1e9, .duration = case_seconds(nominal, nominal->ticks),
                   .window = { case_seconds(nominal, nominal->window_first), case_seconds(nominal, nominal->window_last) },
                   .window_given = 2 };   /* 2: the well file's, dropped when another duration is asked for */
    const char *error;

    *out = (options){ .run = *nominal, .seed = 1, .samples = 400 };
    for (int i = 0; i < argc;) {
        i += parse_one(out, &when, argc - i, &argv[i], takes, command, more, context);
    }
    settle_times(out, &when);
    error = kelly_case_error(&kelly_string, &out->run);
    if (error) {
        die(EXIT_USAGE, "%s: %s", command, error);
    }
}
