/* host_faults_instant.c - a bit of the state that flips at any instruction of a step, not only between two: a debugger of a child's. */
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ptrace.h>
#include <sys/wait.h>
#include <unistd.h>

#include "host_faults.h"

#define INSTRUCTIONS 3000u       /* some five steps of a stiff drive, three of a soft one */

static void stop_here(void *of)
{
    (void)of;
    (void)raise(SIGSTOP);
}

static int stopped(pid_t child)
{
    int status;

    return waitpid(child, &status, 0) == child && WIFSTOPPED(status);
}

/* A bit of the word that holds this place, which is where it is here: the child is a fork. */
static int poke(pid_t child, const site *s, unsigned bit)
{
    char *const at = (char *)s->at + bit / 8;
    long *const word = (long *)(at - (uintptr_t)at % sizeof(long));
    long value = ptrace(PTRACE_PEEKDATA, child, word, 0);

    ((uint8_t *)&value)[at - (char *)word] ^= (uint8_t)(1u << (bit % 8));
    return ptrace(PTRACE_POKEDATA, child, word, value) == 0;
}

/* The child's outcome, struck after so many instructions. */
static unsigned struck_within(uint32_t tick, uint32_t instructions, const site *s, unsigned bit)
{
    int good, status = 0;
    const pid_t child = fork();

    if (child == 0) {
        (void)ptrace(PTRACE_TRACEME, 0, 0, 0);
        run_struck(&kelly_string, tick, stop_here, 0);
        _exit(OF_OURS + (int)worst(results));
    }
    good = child > 0 && stopped(child);
    for (uint32_t k = 0; good && k < instructions; k++) {
        good = ptrace(PTRACE_SINGLESTEP, child, 0, 0) == 0 && stopped(child);
    }
    good = good && poke(child, s, bit) && ptrace(PTRACE_CONT, child, 0, 0) == 0 && waitpid(child, &status, 0) == child;
    CHECK(good && WIFEXITED(status));
    return outcome_of_child(status);
}

void flips_at_any_instant(tally *t, void (*add_places)(int soft), int soft, uint32_t flips)
{
    run = base;
    site_count = 0;
    add_places(soft);
    for (uint32_t i = 0; i < flips; i++) {
        const site *const s = &sites[below(site_count)];
        const uint32_t tick = below(TICKS - 100) + 1, instructions = below(INSTRUCTIONS);

        t->flips++;
        t->alone[struck_within(tick, instructions, s, below(8 * s->bytes))]++;
    }
}
