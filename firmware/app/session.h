/* session.h - one string for a bench: started by `plant_start` or by the console, then in lockstep or on the tick. */
#ifndef KELLY_SESSION_H
#define KELLY_SESSION_H

#include "../link/messages.h"
#include "../plant.h"
#include "lockstep.h"
#include "realtime.h"

typedef struct kelly_bench kelly_bench;

typedef struct {
    kelly_plant plant;
    uint32_t id;                 /* seq of plant_start; 0: of the console */
    uint8_t status;              /* kelly_status of the start */
    uint8_t known;               /* 1: id is one that plant_start has asked for */
    union {
        kelly_lockstep lock;
        kelly_realtime real_time;
    } by;
} kelly_session;

/* Request `plant_start`. The same id again starts nothing. */
void session_start(kelly_bench *bench, uint32_t seq, const kelly_msg_plant_start *ask);

/* Start the string of the case in memory for ask->mode: nominal, or a realisation. */
kelly_status session_begin(kelly_bench *bench, uint32_t id, const kelly_msg_plant_start *ask);

/* The session of this id in this state's memory, over or not; 0, and an error for the request, where there is none. */
kelly_session *session_of(kelly_bench *bench, uint32_t id, uint8_t state, uint32_t seq, uint8_t type);

#endif
