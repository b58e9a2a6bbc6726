/* growth.c - how time and memory grow, and what the whole program takes. */
#include <fcntl.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#ifdef __linux__
#include <sys/ptrace.h>
#endif
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "run.h"

#define ROUNDS 5

/* Peak memory [MB] of a child that is stopped at its exit: VmHWM. The ru_maxrss of a child begins at its parent's. */
static double high_water(pid_t id)
{
    char path[64], line[128];
    double kilobytes = (double)NAN;
    FILE *file;

    snprintf(path, sizeof(path), "/proc/%ld/status", (long)id);
    file = fopen(path, "r");
    while (file && fgets(line, sizeof(line), file)) {
        (void)sscanf(line, "VmHWM: %lf kB", &kilobytes);
    }
    if (file) {
        fclose(file);
    }
    return kilobytes / 1024.0;
}

/* Let a child that traces itself run from its exec to its exit, and look there. */
static void watch_exit(pid_t id, double *megabytes)
{
    int status = 0;

#ifdef __linux__
    if (waitpid(id, &status, 0) == id && WIFSTOPPED(status)) {
        ptrace(PTRACE_SETOPTIONS, id, 0, PTRACE_O_TRACEEXIT);
        ptrace(PTRACE_CONT, id, 0, 0);
        waitpid(id, &status, 0);
        *megabytes = high_water(id);
        ptrace(PTRACE_CONT, id, 0, 0);
    }
#endif
}

/* Run the program with these arguments, its output thrown away: seconds, those of the processor, peak memory; NaN if it fails. */
static double child(const char *program, const char *const arguments[], double *processor, double *megabytes)
{
    const double begin = now();
    const pid_t id = fork();
    struct rusage use = { 0 };
    int status = 1;

    if (id == 0) {
        const int nothing = open("/dev/null", O_WRONLY);

        spread(1);
        dup2(nothing, STDOUT_FILENO);
        dup2(nothing, STDERR_FILENO);
#ifdef __linux__
        if (megabytes) {
            ptrace(PTRACE_TRACEME, 0, 0, 0);
        }
#endif
        execv(program, (char *const *)(uintptr_t)arguments);
        _exit(127);
    }
    if (id > 0 && megabytes) {
        watch_exit(id, megabytes);
    }
    if (id < 0 || wait4(id, &status, 0, &use) != id || status != 0) {
        return (double)NAN;
    }
    if (processor) {
        *processor = (double)(use.ru_utime.tv_sec + use.ru_stime.tv_sec) + 1e-6 * (double)(use.ru_utime.tv_usec + use.ru_stime.tv_usec);
    }
    return now() - begin;
}

static double montecarlo(const char *program, long samples, const char *duration, unsigned threads, double *processor,
                         double *megabytes)
{
    char n[24], t[24];
    const char *const arguments[] = { program, "montecarlo", "--samples", n, "--duration", duration, "--threads", t, 0 };

    snprintf(n, sizeof(n), "%ld", samples);
    snprintf(t, sizeof(t), "%u", threads);
    return child(program, arguments, processor, megabytes);
}

/* Runs of 4 s: the time of a sample is 4000 steps and one start. */
static void over_samples(const char *program, int is_long)
{
    for (long n = 100; n <= (is_long ? 1000000 : 100000); n *= 10) {
        double took[ROUNDS], megabytes = 0;
        const unsigned rounds = n < 100000 ? ROUNDS : 1;

        for (unsigned r = 0; r < rounds; r++) {
            took[r] = montecarlo(program, n, "4", 1, 0, &megabytes);
        }
        record("samples", "\"samples\": %ld, \"seconds\": %.6f, \"megabytes\": %.2f", n, median(took, rounds), megabytes);
    }
}

/* The paper's job, whole process; rounds over the thread counts, so that a busy moment hits all of them. */
static void over_threads(const char *program, const char *precision)
{
    const long processors = sysconf(_SC_NPROCESSORS_ONLN);
    const unsigned most = processors > 8 ? 8u : (unsigned)processors;
    double took[9][ROUNDS], used[9][ROUNDS];

    for (unsigned r = 0; r < ROUNDS; r++) {
        for (unsigned t = 1; t <= most; t++) {
            took[t][r] = montecarlo(program, 400, "100", t, &used[t][r], 0);
        }
    }
    for (unsigned t = 1; t <= most; t++) {
        double least = took[t][0];

        for (unsigned r = 1; r < ROUNDS; r++) {
            least = took[t][r] < least ? took[t][r] : least;
        }
        record("threads", "\"real\": \"%s\", \"threads\": %u, \"seconds\": %.6f, \"least\": %.6f, \"processor\": %.6f", precision, t,
               median(took[t], ROUNDS), least, median(used[t], ROUNDS));
    }
}

/* ns of one step of one realisation. */
static double time_steps(const side *s, unsigned engine, unsigned modes, unsigned count, uint32_t ticks)
{
    const double begin = busy();

    s->run(engine, 0.0, modes, ticks, 0, count);
    return 1e9 * (busy() - begin) / ((double)count * ticks);
}

static void over_modes(const side *s, unsigned engine, unsigned lanes)
{
    double took[21][ROUNDS];

    for (unsigned r = 0; r < ROUNDS; r++) {
        for (unsigned n = 1; n <= 20; n++) {
            took[n][r] = time_steps(s, engine, n, lanes, 20000);
        }
    }
    for (unsigned n = 1; n <= 20; n++) {
        record("modes", "\"real\": \"%s\", \"modes\": %u, \"ns\": %.4f", s->precision, n, median(took[n], ROUNDS));
    }
}

static void over_lanes(const side *s, unsigned engine, unsigned lanes)
{
    for (unsigned n = 1; n <= lanes; n = n < lanes && 2 * n > lanes ? lanes : 2 * n) {
        double took[ROUNDS];

        for (unsigned r = 0; r < ROUNDS; r++) {
            took[r] = time_steps(s, engine, MODES, n, 20000);
        }
        record("lanes", "\"real\": \"%s\", \"lanes\": %u, \"ns\": %.4f", s->precision, n, median(took, ROUNDS));
    }
}

void growth(const char *program, const char *program_double, int is_long)
{
    const side *const sides[] = { &side_float, &side_double };

    for (unsigned i = 0; i < 2; i++) {
        unsigned engine = 0, width = 0, lanes = 0;

        while (sides[i]->engine(engine + 1, &width, &lanes)) {
            engine++;
        }
        (void)sides[i]->engine(engine, &width, &lanes);
        over_modes(sides[i], engine, lanes);
        over_lanes(sides[i], engine, lanes);
    }
    over_threads(program, "float");
    over_threads(program_double, "double");
    over_samples(program, is_long);
}
