/* lockstep.h - the string moves when a frame says so, by as many steps as it says; the host runs its own beside it. */
#ifndef KELLY_LOCKSTEP_H
#define KELLY_LOCKSTEP_H

#include "../link/messages.h"

typedef struct kelly_bench kelly_bench;

typedef struct {
    uint32_t frame;              /* the last one taken */
    uint32_t seq;                /* of its request */
    uint32_t left;               /* steps of it still to go; at 0 `answer` is that of the frame */
    kelly_msg_lock_answer answer;
} kelly_lockstep;

/* Request `lock_step`: the next frame moves the string, the last one is answered again, any other is an error. */
void lockstep_step(kelly_bench *bench, uint32_t seq, const kelly_msg_lock_step *ask);

/* Advance until the tick changes; answer when the frame is done. Returns 0 where there is nothing to do. */
int lockstep_slice(kelly_bench *bench);

#endif
