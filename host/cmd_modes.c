/* cmd_modes.c - natural frequencies with and without prestress: Tables 1 and 2 of the paper. */
#include <math.h>
#include <string.h>

#include "host.h"

#define SHOWN 10                 /* elastic modes of each kind, as in the paper; fewer where the table carries fewer */

typedef struct {
    unsigned torsional, axial;   /* elastic modes shown */
    double torsion[SHOWN], torsion_free[SHOWN], axial_hz[SHOWN], axial_free[SHOWN];
} spectrum;

static double hertz(real w2)
{
    return sqrt((double)w2) / (2.0 * 3.14159265358979323846);
}

static void spectrum_of(spectrum *s)
{
    const kelly_table *const table = &kelly_string;
    real w2[KELLY_MODES_MAX], b[KELLY_MODES_MAX];
    kelly_modes modes;

    s->torsional = table->torsional < SHOWN ? table->torsional : SHOWN;
    s->axial = table->axial - 1u < SHOWN ? table->axial - 1u : SHOWN;
    if (!kelly_modes_at(table, table->nominal.fc, s->torsional, &modes) ||
        !kelly_axial_modes_at(table, table->nominal.fc, s->axial + 1, w2, b)) {
        die(EXIT_FAILED, "modes: the nominal weight lies outside the fit of the table");
    }
    for (unsigned i = 0; i < s->torsional; i++) {
        s->torsion[i] = hertz(modes.w2[i]);
        s->torsion_free[i] = hertz(table->free_w2[i]);
    }
    for (unsigned j = 0; j < s->axial; j++) {
        s->axial_hz[j] = hertz(w2[j + 1]);
        s->axial_free[j] = hertz(table->axial_free_w2[j + 1]);
    }
}

static void print_row(const char *name, const double *hz, unsigned count)
{
    printf("%-22s", name);
    for (unsigned i = 0; i < count; i++) {
        printf(" %8.4f", hz[i]);
    }
    putchar('\n');
}

static void print_json(FILE *to, const char *name, const double *hz, unsigned count, const char *end)
{
    fprintf(to, "  \"%s\": [", name);
    for (unsigned i = 0; i < count; i++) {
        fprintf(to, "%s%.9g", i ? ", " : "", hz[i]);
    }
    fprintf(to, "]%s\n", end);
}

static void write_json(const char *path, const spectrum *s)
{
    outfile file;

    outfile_open(&file, path);
    fprintf(file.stream, "{\n  \"model\": \"%s\",\n", kelly_string.id);
    print_json(file.stream, "torsion_hz", s->torsion_free, s->torsional, ",");
    print_json(file.stream, "torsion_prestressed_hz", s->torsion, s->torsional, ",");
    print_json(file.stream, "axial_hz", s->axial_free, s->axial, ",");
    print_json(file.stream, "axial_prestressed_hz", s->axial_hz, s->axial, "");
    fputs("}\n", file.stream);
    outfile_close(&file);
}

const command_help modes_help = {
    .brief = "natural frequencies in Hz, with and without prestress",
    .synopsis = "[--json F]",
    .takes = TAKES_JSON,
    .notes = "JSON: torsion_hz, torsion_prestressed_hz, axial_hz, axial_prestressed_hz, at most ten each, the rigid mode left out.\n"
             "The prestress is that of gravity and of the well file's weight on bit.",
    .example = "kelly modes --json modes.json",
};

int command_modes(int argc, char **argv)
{
    options opts;
    spectrum s;

    options_parse(&opts, argc, argv, TAKES_JSON, "modes", 0, 0);
    spectrum_of(&s);
    if (opts.json) {
        write_json(opts.json, &s);
    }
    if (!opts.quiet && (!opts.json || strcmp(opts.json, "-") != 0)) {
        printf("natural frequencies in Hz, %s, weight on bit %.6g kN\n", kelly_string.id, (double)kelly_string.nominal.fc / 1000.0);
        print_row("torsion, no prestress", s.torsion_free, s.torsional);
        print_row("torsion, prestressed", s.torsion, s.torsional);
        print_row("axial, no prestress", s.axial_free, s.axial);
        print_row("axial, prestressed", s.axial_hz, s.axial);
    }
    return EXIT_DONE;
}
