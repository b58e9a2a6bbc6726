/* steps.c - the machine instructions of kelly's step, counted by single-stepping a child process. */
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <unistd.h>
#if defined(__x86_64__) && defined(__linux__)
#include <sys/ptrace.h>
#include <sys/user.h>
#endif

#include "run.h"

#define SHORT 4u                 /* ticks of the two runs */
#define LONG 24u

#if defined(__x86_64__) && defined(__linux__)

extern const char __executable_start[], etext[];

/* How often each address of the program was executed in so many steps; 0 if this system does not let us look. */
static int walk(const side *s, unsigned engine, unsigned lanes, uint32_t ticks, long sign, long *hits)
{
    const pid_t child = fork();
    struct user_regs_struct at;
    int status = 0;

    if (child < 0) {
        return 0;
    }
    if (child == 0) {
        s->run(engine, 0.0, MODES, 100, 0, lanes);
        if (ptrace(PTRACE_TRACEME, 0, 0, 0) != 0) {
            _exit(1);
        }
        raise(SIGSTOP);
        s->advance(engine, ticks);
        _exit(0);
    }
    waitpid(child, &status, 0);
    if (!WIFSTOPPED(status)) {
        return 0;
    }
    while (WIFSTOPPED(status)) {
        if (ptrace(PTRACE_GETREGS, child, 0, &at) != 0) {
            break;
        }
        if (at.rip >= (uintptr_t)__executable_start && at.rip < (uintptr_t)etext) {
            hits[at.rip - (uintptr_t)__executable_start] += sign;
        }
        if (ptrace(PTRACE_SINGLESTEP, child, 0, 0) != 0) {
            break;
        }
        waitpid(child, &status, 0);
    }
    return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

void count_steps(const side *s, unsigned engine)
{
    const size_t size = (size_t)(etext - __executable_start);
    long *const hits = calloc(size, sizeof(*hits));
    unsigned width = 0, lanes = 0;
    const char *const name = s->engine(engine, &width, &lanes);
    int comma = 0;

    if (hits && walk(s, engine, lanes, LONG, 1, hits) && walk(s, engine, lanes, SHORT, -1, hits)) {
        char *text = 0;
        size_t length = 0;
        FILE *const out = open_memstream(&text, &length);

        for (size_t i = 0; i < size; i++) {
            if (hits[i] != 0) {
                fprintf(out, "%s\"%zx\": %g", comma++ ? ", " : "", i + (uintptr_t)__executable_start, (double)hits[i] / (LONG - SHORT));
            }
        }
        fclose(out);
        record("steps", "\"engine\": \"%s\", \"real\": \"%s\", \"guarded\": %s, \"vectors\": %u, \"width\": %u, \"hits\": {%s}", name, s->precision,
               s->guarded ? "true" : "false", lanes / width, width, text);
        free(text);
    }
    free(hits);
}

#else

void count_steps(const side *s, unsigned engine)
{
    (void)s;
    (void)engine;
}

#endif
