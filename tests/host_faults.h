/* host_faults.h - what the parts of host_faults.c share: the block that is struck, the places where, and what became of it. */
#ifndef KELLY_HOST_FAULTS_H
#define KELLY_HOST_FAULTS_H

#include "../host/host.h"
#include "check.h"

#define TICKS 8000u
#define LANES_MAX 80u            /* of AVX-512 */

/* As host_faults.c explains them, from harmless to the worst. */
enum { SAME, WITHIN, DETECTED, MOVED, WRONG, OUTCOMES };

/* How many faults ended how: with one run, and with --twice. */
typedef struct {
    uint32_t alone[OUTCOMES], twice[OUTCOMES], flips;
} tally;

/* One place where a fault may strike. */
typedef struct {
    void *at;
    unsigned bytes;
} site;

/* The block of one case: `base` is the case, `run` the copy that may be struck, `clean` what comes out without a fault. */
extern kelly_work work;
extern kelly_case run, base;
extern kelly_result clean[LANES_MAX], results[LANES_MAX];
extern unsigned lanes;
extern uint32_t first;

/* A block of the case into `results`, struck by `strike` after `at` steps. */
void run_struck(const kelly_table *table, uint32_t at, void (*strike)(void *), void *what);

/* The worst outcome of any realisation. */
unsigned worst(const kelly_result *got);

/* Count what became of `results`, alone and with --twice. */
void add_outcome(tally *t);

/* 0 .. n - 1, each as likely. */
uint32_t below(uint32_t n);

/* The places of a kind of fault; to begin anew, site_count = 0. */
extern site sites[];
extern unsigned site_count;
void add_site(void *at, size_t bytes);
void add_vectors(vreal *from, unsigned count);      /* each lane a place of its own */

/* Vectors from one member to another, both of them included. */
#define SPAN(type, a, b) ((unsigned)((offsetof(type, b) - offsetof(type, a)) / sizeof(vreal)) + 1)

void flip(const site *s, unsigned bit);
void flip_any(void *of);                            /* a bit of any of them */

/* A bit somewhere in the places that `add_places` gives, at any instant of a block under way. */
void flips_in_block(tally *t, void (*add_places)(int soft), int soft, uint32_t flips);

/* The outcome of a child that ends with _exit(OF_OURS + outcome): WRONG where something else has ended it. */
#define OF_OURS 32
unsigned outcome_of_child(int status);

/* host_faults_instant.c */
void flips_within_steps(tally *t, int soft, uint32_t each);
void flips_within_resync(tally *t, int soft, uint32_t flips);
void flips_within_load(tally *t, int soft, uint32_t flips);
void flips_at_any_instant(tally *t, void (*add_places)(int soft), int soft, uint32_t flips);

/* host_faults_state.c */
void motion_places(int soft);
void state_places(int soft);
void flips_in_state(tally *t, int soft, uint32_t flips);
void clear_block(int soft);                         /* for one vector */
void load_lane(int soft, unsigned lane, void (*strike)(void *));
void flips_between_loads(int soft, uint32_t flips);
void numbers_in_state(tally *far, tally *small, int soft, unsigned every);
void numbers_in_draws(int soft);
void numbers_in_case(void);
void numbers_in_commands(void);
void flips_in_plant(int top);                       /* stiff, soft or commanded: 0, 1, 2 */

/* host_faults_table.c */
void flips_in_table(tally *t, uint32_t flips);
void flips_in_coefficients(tally *t, int soft, uint32_t flips);
void flips_in_counts(tally *t, int soft);
uint32_t steps_until_told(int soft, uint32_t flips);         /* in the state, too, where it is guarded */

#endif
