/* plan.h - what `kelly plan` knows of a run, and the simulated run. */
#ifndef KELLY_PLAN_H
#define KELLY_PLAN_H

#include "host.h"

#define BLOCKS 4096u             /* measured at most */

typedef struct {
    options opts;
    uint32_t samples, cores;
    int lines;
    double measure;              /* [s] */
    double startup, startup_rank, message, way, process;   /* [s, s, s, s, bytes]; negative: to be measured, or else assumed */
    int team;                    /* they were measured, between ranks */
    /* measured */
    const kelly_engine *engine;
    unsigned lanes;
    double block[BLOCKS];        /* [s] */
    uint32_t blocks;
    double rate;                 /* realisations a second and core */
    double leader;               /* of one result [s] */
    uint32_t sum;                /* of no meaning: what is timed must be done */
} plan;

/* Realisations of a batch: as in threads.c. */
uint32_t plan_batch(uint32_t cores, uint32_t samples);

/* Seconds until the first errand. */
double plan_starting(const plan *p, uint32_t cores);

/* Seconds of one simulated run, start-up included; the work in it, summed over the cores [s]. Costs a tenth of a second, and some
 * seconds where cores are many. */
double plan_simulate(const plan *p, uint32_t cores, uint32_t samples, double *worked);

#endif
