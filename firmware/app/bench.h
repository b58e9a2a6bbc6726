/* bench.h - the board as the drill string of a bench: requests in, work in slices, answers out.
 *
 * Everything is in one endless loop. A byte goes to two receivers, the frames' (link/frame.h) and a collector of text lines; a
 * frame is a request (link/PROTOCOL.md, bench.c), a line a command for people (console.h). Then comes a slice of the present
 * work, short enough that no byte is lost meanwhile, and sleep where there is none:
 *
 *   campaign.h   realisations of a range, in order
 *   session.h    one string: in lockstep with the host (lockstep.h), or on the board's tick (realtime.h)
 *   gauge.h      what a rig display would read of it
 *
 * Memory   one struct bench; the modes share theirs, for only one runs.
 */
#ifndef KELLY_BENCH_H
#define KELLY_BENCH_H

#include "../link/frame.h"
#include "campaign.h"
#include "console.h"
#include "gauge.h"
#include "line.h"
#include "session.h"

#define BENCH_BYTES 64           /* taken in one pass of the loop: some 5 ms of line, less than a tick of work */

/* What bench_take says of a byte: nothing to decide, or that the program's first input was a line for estimate.h. */
enum { BENCH_GOES_ON, BENCH_ESTIMATE };

typedef struct kelly_bench {
    kelly_receiver receiver;
    char line[LINE_MAX];
    uint8_t length;              /* of the line so far */
    uint8_t dirty;               /* it holds what is no text, or begins inside a frame */
    uint8_t decided;             /* the first input was not for estimate.h */
    uint8_t greeted;             /* a hello of this schema has come */
    uint8_t state;               /* KELLY_STATE_... */
    uint8_t holds;               /* the state whose memory `now` is, over or not; KELLY_STATE_IDLE: none */
    uint8_t case_set;            /* `run` is that of case_crc */
    uint32_t case_crc;
    uint32_t status_tick;        /* of the last status */
    kelly_case run;              /* of every campaign and plant from now on */
    union {
        kelly_campaign campaign;
        kelly_session session;
        kelly_work work;         /* estimate.h */
    } now;
    kelly_gauge gauge;
    kelly_console console;
} kelly_bench;

/* Idle, with the nominal case. */
void bench_start(kelly_bench *bench);

/* Take one received byte, and do what it completes. */
int bench_take(kelly_bench *bench, uint8_t byte);

/* The endless loop. */
_Noreturn void bench_loop(kelly_bench *bench);

/* Drop what runs. */
void bench_idle(kelly_bench *bench);

/* The memory of the modes for `state`, cleared unless it is that already. */
void bench_hold(kelly_bench *bench, uint8_t state);

/* Messages that several files send. */
void bench_error(uint32_t seq, uint8_t code, uint8_t of_type, const char *text);
void bench_status(kelly_bench *bench, uint32_t seq);

#endif
