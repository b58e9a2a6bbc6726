/* main.c - the kelly command. */
#include <errno.h>
#include <string.h>

#include "host.h"

static const char usage[] =
    "kelly " KELLY_VERSION ": how likely is this drill string to stick and slip?\n"
    "\n"
    "  kelly montecarlo [case] [--samples 400] [--cov 0.2 | --cov fc=..,mu=..,a1=..,a2=..,rpm=..] [--seed 1] [--first 0]\n"
    "                   [--threads T] [--json F] [--csv F] [--convergence] [--engine scalar|sse2|avx2|avx512]\n"
    "                                      probability of stick-slip with its 95 % interval\n"
    "  kelly simulate   [case] [--out F.csv] [--sample J --seed S [--cov ..]]\n"
    "                                      one run in time: the nominal case, or realisation J of seed S\n"
    "  kelly modes      [--json F]         natural frequencies, with and without prestress\n"
    "\n"
    "case (defaults are the well file's):\n"
    "  --rpm 100          top speed [rpm]            --start rest|rotating    state of the string at t = 0\n"
    "  --wob 100          weight on bit |f_c| [kN]   --duration 100           [s]\n"
    "  --f0 50            its amplitude [kN]         --window 50:100          where severity is taken [s]; last half\n"
    "  --mu 0.04          bit-rock factor            --step 0.001             RK4 step [s]\n"
    "  --alpha1 2         [s/rad]                    --out-step 0.01          between output lines [s]\n"
    "  --alpha2 1         [s2/rad2]                  --limit 0.8              severity that counts as stick-slip\n"
    "  --torsional 10     torsional modes            --axial 2                axial modes, the rigid one included\n"
    "\n"
    "--cov with names: parameters that are not named are not random. A file \"-\" is stdout.\n"
    "Exit 0 done, 1 the run failed, 2 bad usage or input.\n"
    "Try first:  kelly montecarlo --mu 0.004\n";

static const struct {
    const char *name;
    int (*run)(int argc, char **argv);
} commands[] = {
    { "montecarlo", command_montecarlo },
    { "simulate", command_simulate },
    { "modes", command_modes },
};

/* Run a subcommand; results that could not be written are a failure. */
static int run(int argc, char **argv)
{
    for (size_t i = 0; i < sizeof(commands) / sizeof(commands[0]); i++) {
        if (strcmp(argv[1], commands[i].name) == 0) {
            const int status = commands[i].run(argc - 2, argv + 2);

            if (fflush(stdout) != 0 || ferror(stdout)) {
                die(EXIT_FAILED, "the output could not be written: %s", strerror(errno));
            }
            return status;
        }
    }
    die(EXIT_USAGE, "'%s' is not a command; give montecarlo, simulate or modes, or see kelly --help", argv[1]);
}

int main(int argc, char **argv)
{
    const char *const error = kelly_table_error(&kelly_string);

    if (error) {
        die(EXIT_FAILED, "%s: %s", kelly_string.id, error);
    }
    for (int i = 1; i < argc; i++) {
        if (strcmp(argv[i], "--help") == 0 || strcmp(argv[i], "-h") == 0) {
            fputs(usage, stdout);
            return EXIT_DONE;
        }
    }
    if (argc < 2) {
        fputs(usage, stderr);
        return EXIT_USAGE;
    }
    if (strcmp(argv[1], "--version") == 0) {
        printf("kelly " KELLY_VERSION " %s %s\n", kelly_string.id, sizeof(real) > 4 ? "double" : "float");
        return EXIT_DONE;
    }
    return run(argc, argv);
}
