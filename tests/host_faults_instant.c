/* host_faults_instant.c - a bit of the state that flips at any instruction of a step, not only between two: a debugger of a child's. */
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ptrace.h>
#include <sys/wait.h>
#include <unistd.h>

#include "host_faults.h"

#define WITHIN_STEPS 1200u       /* of each vector: some two steps */
#define INSTRUCTIONS 3000u       /* some five steps of a stiff drive, three of a soft one */
#define RESYNC_INSTRUCTIONS 500u /* of one lane */
#define LOAD_INSTRUCTIONS 4000u

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

/* What becomes of the results of a block that is struck after so many steps. */
static unsigned to_the_end(int soft, uint32_t tick)
{
    (void)soft;
    run_struck(&kelly_string, tick, stop_here, 0);
    return worst(results);
}

/* What becomes of the state itself in the next few steps. */
#define FEW 6u
static kelly_work wanted;

static void few_steps(int soft, uint32_t tick, void (*strike)(void *))
{
    kelly_run_begin(&kelly_string, &run, 7, first, lanes, results, &work);
    (void)kelly_run_advance(&kelly_string, &run, lanes, results, &work, tick);
    strike(0);
    if (soft) {
        kelly_driven_advance(&work.driven, FEW);
    } else {
        kelly_block_advance(&work.block, FEW);
    }
}

/* SAME: every bit is the wanted one. */
static unsigned outcome_of_state(int soft)
{
    if (!(soft ? kelly_driven_untouched(&work.driven) : kelly_block_untouched(&work.block))) {
        return DETECTED;
    }
    return memcmp(&work, &wanted, sizeof(work)) == 0 ? SAME : WRONG;
}

static unsigned for_a_few_steps(int soft, uint32_t tick)
{
    few_steps(soft, tick, stop_here);
    return outcome_of_state(soft);
}

/* A vector is loaded lane by lane, and makes a few steps. */
static void load_all(int soft, void (*strike)(void *))
{
    clear_block(soft);
    for (unsigned lane = 0; lane < KELLY_WIDTH; lane++) {
        load_lane(soft, lane, lane == KELLY_WIDTH - 1 ? strike : 0);
    }
    if (soft) {
        kelly_driven_advance(&work.driven, FEW);
    } else {
        kelly_block_advance(&work.block, FEW);
    }
}

static unsigned while_loading(int soft, uint32_t tick)
{
    (void)tick;
    load_all(soft, stop_here);
    return outcome_of_state(soft);
}

/* The child's outcome, struck after so many instructions. */
static unsigned struck_within(unsigned (*steps)(int soft, uint32_t tick), int soft, uint32_t tick, uint32_t instructions, const site *s, unsigned bit)
{
    int good, status = 0;
    const pid_t child = fork();

    if (child == 0) {
        (void)ptrace(PTRACE_TRACEME, 0, 0, 0);
        _exit(OF_OURS + (int)steps(soft, tick));
    }
    good = child > 0 && stopped(child);
    for (uint32_t k = 0; good && k < instructions; k++) {
        good = ptrace(PTRACE_SINGLESTEP, child, 0, 0) == 0 && stopped(child);
    }
    good = good && poke(child, s, bit) && ptrace(PTRACE_CONT, child, 0, 0) == 0 && waitpid(child, &status, 0) == child;
    CHECK(good && WIFEXITED(status));
    return outcome_of_child(status);
}

static void leave(void *of)
{
    (void)of;
}

/* One vector: each number of the state of its first lane, `each` times. Several, at different stages: as often, any number. */
void flips_within_steps(tally *t, int soft, uint32_t each)
{
    const uint32_t tick = KELLY_RESYNC - FEW / 2, vectors = lanes / KELLY_WIDTH;

    run = base;
    few_steps(soft, tick, leave);
    memcpy(&wanted, &work, sizeof(work));
    site_count = 0;
    motion_places(soft);
    for (uint32_t i = 0; i < each * (site_count / lanes); i++) {
        const site *const s = &sites[vectors > 1 ? below(site_count) : i * KELLY_WIDTH % site_count];

        t->flips++;
        t->alone[struck_within(for_a_few_steps, soft, tick, below(WITHIN_STEPS * vectors), s, below(8 * s->bytes))]++;
    }
}

/* What a resync writes anew of the first lane, from its begin on. */
void flips_within_resync(tally *t, int soft, uint32_t flips)
{
    run = base;
    few_steps(soft, KELLY_RESYNC, leave);
    memcpy(&wanted, &work, sizeof(wanted));
    for (uint32_t i = 0; i < flips; i++) {
        real *const at = soft ? (real *)(&work.driven.lane[0].eta + i % 4) : (real *)(&work.block.lane[0].wave + i % 4);
        const site s = { at, sizeof(real) };          /* eta, phi, sine, cosine; wave, dwave, muf, t1 */

        t->flips++;
        t->alone[struck_within(for_a_few_steps, soft, KELLY_RESYNC, below(RESYNC_INSTRUCTIONS), &s, below(8 * s.bytes))]++;
    }
}

/* Any number of a vector while its last lane is loaded. */
void flips_within_load(tally *t, int soft, uint32_t flips)
{
    run = base;
    load_all(soft, leave);
    memcpy(&wanted, &work, sizeof(wanted));
    site_count = 0;
    motion_places(soft);
    for (uint32_t i = 0; i < flips; i++) {
        const site *const s = &sites[below(site_count)];

        t->flips++;
        t->alone[struck_within(while_loading, soft, 0, below(LOAD_INSTRUCTIONS), s, below(8 * s->bytes))]++;
    }
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
        t->alone[struck_within(to_the_end, soft, tick, instructions, s, below(8 * s->bytes))]++;
    }
}
