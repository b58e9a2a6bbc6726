/* grid.c - axes of a map, and options of a subcommand's own. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "map.h"

#define AXIS_TEXT 128

static double as_text(double x)
{
    char text[40];

    snprintf(text, sizeof(text), "%.12g", x);
    return strtod(text, 0);
}

/* A whole number of 12 digits over a power of ten: both are exact in double, so the quotient is rounded as strtod rounds the text. Where
 * the thirteenth digit leaves a doubt, or x is beyond the powers, the text itself. An axis may have a million values. */
double decimal(double x)
{
    static const double ten[] = { 1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,  1e8,  1e9,  1e10, 1e11,
                                  1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22 };
    const double size = fabs(x);
    double scaled, whole;
    unsigned k = 0;

    if (!(size >= 1e-10 && size < 1e12)) {
        return as_text(x);
    }
    while (k < sizeof(ten) / sizeof(ten[0]) - 1 && size * ten[k + 1] < 1e12) {
        k++;
    }
    scaled = size * ten[k];
    whole = floor(scaled);
    if (fabs(scaled - whole - 0.5) < 1e-3) {
        return as_text(x);
    }
    return copysign((whole + (scaled - whole > 0.5)) / ten[k], x);
}

static axis axis_of(uint32_t count, double from, double step)
{
    axis a = { .count = count, .at = malloc(count * sizeof(double)) };

    if (!a.at) {
        die(EXIT_FAILED, "out of memory");
    }
    for (uint32_t i = 0; i < count; i++) {
        a.at[i] = decimal(from + step * (double)i);
    }
    return a;
}

/* Cut at the colons, in place; returns the number of parts, 4 for more than three. */
static unsigned split(char *text, char *part[3])
{
    unsigned parts = 0;

    while (text) {
        char *const colon = strchr(text, ':');

        if (parts == 3) {
            return 4;
        }
        part[parts++] = text;
        text = colon ? colon + 1 : 0;
        if (colon) {
            *colon = '\0';
        }
    }
    return parts;
}

axis axis_parse(const char *option, const char *text, double lo, double hi, const char *unit)
{
    char copy[AXIS_TEXT], right[160], *part[3];
    double from, to, step, intervals;
    unsigned parts;

    snprintf(right, sizeof(right), "FROM:TO:STEP or one value, in %s, %g..%g", unit, lo, hi);
    if (strlen(text) >= sizeof(copy)) {
        die(EXIT_USAGE, "%s: too long; give %s", option, right);
    }
    strcpy(copy, text);
    parts = split(copy, part);
    if (parts != 1 && parts != 3) {
        die(EXIT_USAGE, "%s %s: %s; give %s", option, text, parts == 2 ? "has no step" : "too many parts", right);
    }
    from = option_number(option, part[0], lo, hi, right);
    if (parts == 1) {
        return axis_of(1, from, 0);
    }
    to = option_number(option, part[1], lo, hi, right);
    step = option_number(option, part[2], 1e-6, 1e9, "a step > 0");
    if (to < from) {
        die(EXIT_USAGE, "%s %s: ends before it begins, a grid of no cells; give %s:%s:%s", option, text, part[1], part[0], part[2]);
    }
    intervals = floor((to - from) / step + 1e-9);
    if (intervals + 1 > (double)CELLS_MAX) {
        die(EXIT_USAGE, "%s %s: %.0f values, a map has at most %u cells; give a longer step", option, text, intervals + 1, CELLS_MAX);
    }
    return axis_of((uint32_t)intervals + 1, from, step);
}

axis axis_thinned(const axis *a, uint32_t most)
{
    const double from = a->at[0], to = a->at[a->count - 1];

    if (a->count <= most) {
        axis same = axis_of(a->count, from, 0);

        memcpy(same.at, a->at, a->count * sizeof(double));
        return same;
    }
    return axis_of(most, from, (to - from) / (most - 1));
}

double f0_at(const options *opts, int f0_given, double wob_kN)
{
    const kelly_case *const nominal = &kelly_string.nominal;

    return decimal(f0_given ? (double)opts->run.f0 / 1000.0 : wob_kN * ((double)nominal->f0 / (double)nominal->fc));
}

/* Options that need no value (parse_flag and parse_one in options.c): what follows them is an option again. */
static int is_flag(const char *name)
{
    static const char *const flags[] = { "--convergence", "--help", "--quiet", "--resume", "--twice" };

    for (unsigned k = 0; k < sizeof(flags) / sizeof(*flags); k++) {
        if (strcmp(name, flags[k]) == 0) {
            return 1;
        }
    }
    return 0;
}

/* 1 if argv[0] is `name` alone, 2 if it is name=value. */
static int matches(const char *argument, const char *name)
{
    const size_t length = strlen(name);

    return strncmp(argument, name, length) != 0 ? 0 : argument[length] == '\0' ? 1 : argument[length] == '=' ? 2 : 0;
}

/* Arguments that the option at i takes up, itself included. */
static int span(int argc, char **argv, int i)
{
    return is_flag(argv[i]) || strchr(argv[i], '=') || i + 1 == argc ? 1 : 2;
}

const char *take_option(int *argc, char **argv, const char *name)
{
    const char *found = 0;
    int kept = 0;

    for (int i = 0; i < *argc;) {
        const int n = span(*argc, argv, i), match = matches(argv[i], name);

        if (match) {
            found = match == 2 ? argv[i] + strlen(name) + 1 : n == 2 ? argv[i + 1] : "";
            if (!is_flag(name) && *found == '\0') {
                die(EXIT_USAGE, "%s: needs a value", name);
            }
            if (is_flag(name) && match == 2) {
                die(EXIT_USAGE, "%s: takes no value", argv[i]);
            }
            i += n;
        } else {
            for (int k = 0; k < n; k++) {
                argv[kept++] = argv[i++];
            }
        }
    }
    *argc = kept;
    return found;
}

int has_option(int argc, char **argv, const char *name)
{
    for (int i = 0; i < argc; i += span(argc, argv, i)) {
        if (matches(argv[i], name)) {
            return 1;
        }
    }
    return 0;
}
