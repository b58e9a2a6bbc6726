/* main.c - the kelly command. */
#include <errno.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>

#include "host.h"
#include "team.h"

const subcommand commands[] = {
    { "montecarlo", command_montecarlo, &montecarlo_help, 1 },
    { "simulate", command_simulate, &simulate_help, 0 },
    { "modes", command_modes, &modes_help, 0 },
    { "map", command_map, &map_help, 1 },
    { "advise", command_advise, &advise_help, 1 },
    { "sensitivity", command_sensitivity, &sensitivity_help, 1 },
    { "whatif", command_whatif, &whatif_help, 0 },
    { "rare", command_rare, &rare_help, 1 },
    { "merge", command_merge, &merge_help, 0 },
    { "plan", command_plan, &plan_help, 1 },
    { "bench", command_bench, &bench_help, 0 },
    { "manual", command_manual, &manual_help, 0 },
};
const unsigned command_count = sizeof(commands) / sizeof(commands[0]);

static const subcommand *command_named(const char *name)
{
    for (unsigned i = 0; i < command_count; i++) {
        if (strcmp(name, commands[i].name) == 0) {
            return &commands[i];
        }
    }
    return 0;
}

static _Noreturn void no_command(const char *name)
{
    const char *const meant = help_like(0, name);
    char names[256] = "";

    if (meant) {
        die(EXIT_USAGE, "'%s' is not a command; did you mean %s?", name, meant);
    }
    for (unsigned i = 0; i < command_count; i++) {
        strncat(names, i == 0 ? "" : i + 1 < command_count ? ", " : " or ", sizeof(names) - strlen(names) - 1);
        strncat(names, commands[i].name, sizeof(names) - strlen(names) - 1);
    }
    die(EXIT_USAGE, "'%s' is not a command; give %s, or see kelly --help", name, names);
}

/* Results that could not be written are a failure. */
static int written(int status)
{
    if (fflush(stdout) != 0 || ferror(stdout)) {
        die(EXIT_FAILED, "the output could not be written: %s", strerror(errno));
    }
    return status;
}

/* Under mpirun, this program without MPI: each rank does the whole. */
static void tell_strangers(void)
{
#ifndef KELLY_MPI
    const char *const size = getenv("OMPI_COMM_WORLD_SIZE"), *const rank = getenv("OMPI_COMM_WORLD_RANK");

    if (size && strcmp(size, "1") != 0 && rank && strcmp(rank, "0") == 0) {
        fprintf(stderr, "kelly: this program knows no MPI, each of the %s ranks does the whole; to share it: make mpi, then mpirun build/mpi/kelly\n", size);
    }
#endif
}

/* Run a subcommand. One that does not share its work is that of the first process of a team. */
static int run(int argc, char **argv)
{
    const subcommand *const c = command_named(argv[1]);
    int status;

    if (!c) {
        no_command(argv[1]);
    }
    if (team_rank() > 0 && !c->shared) {
        return EXIT_DONE;
    }
    if (c->shared) {
        tell_strangers();
    }
    status = written(c->run(argc - 2, argv + 2));
    team_end();
    return status;
}

/* kelly --help, kelly help, kelly COMMAND ... --help, kelly help COMMAND: of that command, or of all. */
static int help(const char *name)
{
    const subcommand *const c = name ? command_named(name) : 0;

    if (name && !c) {
        no_command(name);
    }
    if (c) {
        help_command(stdout, c);
    } else {
        help_all(stdout);
    }
    return written(EXIT_DONE);
}

int main(int argc, char **argv)
{
    const char *error = kelly_table_error(&kelly_string);

    (void)signal(SIGXFSZ, SIG_IGN);   /* a limit on the size of files is told as a full disk is */
    error = error ? error : kelly_shapes_error(&kelly_string, &kelly_string_shapes);
    if (error) {
        die(EXIT_FAILED, "%.*s: %s", KELLY_ID_MAX, kelly_string.id, error);
    }
    if (team_rank() > 0 && !freopen("/dev/null", "w", stdout)) {   /* of several processes the first alone prints */
        die(EXIT_FAILED, "/dev/null: cannot be opened: %s", strerror(errno));
    }
    for (int i = 1; i < argc; i++) {
        if (strcmp(argv[i], "--help") == 0 || strcmp(argv[i], "-h") == 0) {
            return help(i > 1 ? argv[1] : 0);
        }
    }
    if (argc < 2) {
        help_short(stderr);
        return EXIT_USAGE;
    }
    if (strcmp(argv[1], "help") == 0) {
        return help(argc > 2 ? argv[2] : 0);
    }
    if (strcmp(argv[1], "--version") == 0) {
        printf("kelly " KELLY_VERSION " %s %s\n", kelly_string.id, sizeof(real) > 4 ? "double" : "float");
        return written(EXIT_DONE);
    }
    return run(argc, argv);
}
