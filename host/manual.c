/* manual.c - `kelly manual`: the man page, from the tables of help.c, so that it says what --help says. */
#include <string.h>

#include "host.h"

/* Text as roff takes it: a hyphen that stays one, no line that begins with a control character, long lists that may break. */
static void roff(FILE *to, const char *text)
{
    int fresh = 1;

    for (; *text; text++) {
        if (fresh && (*text == '.' || *text == '\'')) {
            fputs("\\&", to);
        }
        fresh = *text == '\n';
        if (*text == '-') {
            fputs("\\-", to);
        } else if (*text == '\\') {
            fputs("\\e", to);
        } else {
            fputs(*text == ',' ? ",\\:" : (char[]){ *text, '\0' }, to);
        }
    }
}

static void roff_option(void *context, const char *title, const option_help *option, const char *fallback)
{
    FILE *const to = context;

    if (!option) {
        fputs(".PP\n", to);
        roff(to, title);
        fputs(":\n", to);
        return;
    }
    fputs(".TP\n.B ", to);
    roff(to, option->name);
    if (option->value) {
        fputs(" \\fI", to);
        roff(to, option->value);
        fputs("\\fR", to);
    }
    fputc('\n', to);
    roff(to, option->text);
    roff(to, fallback);
    fputc('\n', to);
}

static void roff_command(FILE *to, const subcommand *c)
{
    fputs(".SS kelly ", to);
    roff(to, c->name);
    fputc('\n', to);
    roff(to, c->help->brief);
    fputs(".\n.PP\n.B kelly ", to);
    roff(to, c->name);
    fputs("\n", to);
    roff(to, c->help->synopsis);
    fputc('\n', to);
    help_walk(c, roff_option, to);
    if (c->help->notes) {
        fputs(".PP\n", to);
        roff(to, c->help->notes);
        fputc('\n', to);
    }
    fputs(".PP\nExample:\n.PP\n.RS\n.nf\n", to);
    roff(to, c->help->example);
    fputs("\n.fi\n.RE\n", to);
}

const command_help manual_help = {
    .brief = "the man page, for man -l -",
    .synopsis = "",
    .example = "kelly manual | man -l -",
};

int command_manual(int argc, char **argv)
{
    options opts;

    options_parse(&opts, argc, argv, 0, "manual", 0, 0);
    puts(".TH KELLY 1 \"\" \"kelly " KELLY_VERSION "\" \"User Commands\"\n"
         ".ad l\n.SH NAME\nkelly \\- how likely is this drill string to stick and slip?\n"
         ".SH SYNOPSIS\n.B kelly\n\\fICOMMAND\\fR [\\fIOPTION\\fR ...]\n"
         ".SH DESCRIPTION\n"
         "Simulates the stochastic axial and torsional vibration of a drill string under bit\\-rock interaction and counts how\n"
         "often it sticks and slips. The string is part of the program; a program for another one is built from its well file.\n"
         "Realisation J of seed S has the same bits on every machine and at any number of threads.\n"
         ".PP\n"
         "Two measures of the severity of a run are reported, over the same window of the bit speed:\n"
         ".B ss\n= (max \\- min)/(max + min), that of the paper, and\n"
         ".B SSI\n= (max \\- min)/(2 mean), that of rig displays.\n"
         "P(stick\\-slip) counts ss above the limit; P by SSI is printed beside it.\n"
         ".SH COMMANDS");
    for (unsigned i = 0; i < command_count; i++) {
        roff_command(stdout, &commands[i]);
    }
    puts(".SH FILES\nCSV has a header line, a comma, a point, and enough digits to bring the numbers back unchanged; units are in the\n"
         "names of the columns. JSON is one object. NPY is version 1.0, for numpy.load. A file appears whole or not at all.\n"
         ".SH ENVIRONMENT\n.TP\n.B NO_COLOR\nif set and not empty, nothing is coloured. Only a terminal is ever sent colours.\n"
         ".SH EXIT STATUS\n.TP\n.B 0\n" EXIT_DONE_TEXT "\n.TP\n.B 1\n" EXIT_FAILED_TEXT "\n.TP\n.B 2\n" EXIT_USAGE_TEXT);
    return EXIT_DONE;
}
