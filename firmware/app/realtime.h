/* realtime.h - the string on the board's tick: step n is due n periods after the start, whatever the host does.
 *
 * A step is late when its tick came while the program was still at the step before, or when it starts a whole period after its
 * tick or later. What was missed is caught up step by step, each of them late. The lateness is the time from a step's tick to
 * its start; the worst one is kept of all steps, late or not.
 *
 * The host is watched: without a command for command_ms the policy acts (hold, ramp down, stop). Each step is checked, and the
 * watchdog is kicked only after a good one; a string whose state left all bounds is stopped.
 */
#ifndef KELLY_REALTIME_H
#define KELLY_REALTIME_H

#include "../link/messages.h"

#define REALTIME_TICK_NS 1000000u     /* of board_ticks */
#define REALTIME_WATCHDOG_MS 1000u

typedef struct kelly_bench kelly_bench;

typedef struct {
    /* as asked for */
    uint32_t duration;           /* [steps], 0: endless */
    uint32_t stream_ticks;       /* [steps] between samples, 0: none */
    uint32_t command_ms;         /* [ms], 0: not watched */
    uint32_t ramp_ticks;         /* [steps] */
    uint32_t overload_steps, overload_us;
    uint8_t policy;

    /* clock */
    uint32_t period;             /* of a step [ticks] */
    uint32_t start;              /* board_ticks of step 0 */
    uint32_t steps;              /* done */
    uint32_t tick_counts;        /* board_count of one tick */
    uint8_t overran;             /* the tick of the next step came while the last one was at work */

    /* commands */
    uint32_t number;             /* of the last one */
    uint32_t heard;              /* board_ticks of it */
    real weight;                 /* [N] */
    uint8_t state;               /* KELLY_RT_... */

    /* books */
    uint32_t late, worst_late_us;
    uint64_t busy;               /* [counts] since the start */
    uint64_t busy_second;        /* `busy` when the present second began */
    uint32_t busy_worst;         /* of one step [counts] */
    uint16_t load_permille;      /* of the last whole second */
    uint32_t commands, timeouts, samples, unsane;
} kelly_realtime;

/* The string of bench->now.session starts on the next tick, under `weight` [N]. */
void realtime_begin(kelly_bench *bench, const kelly_msg_plant_start *ask, real weight);

/* Requests `rt_command`, `rt_query`. */
void realtime_command(kelly_bench *bench, uint32_t seq, const kelly_msg_rt_command *ask);
void realtime_query(kelly_bench *bench, uint32_t seq, const kelly_msg_rt_query *ask);

/* Set top speed [rad/s], within `ticks` steps, and weight [N]. */
void realtime_set(kelly_bench *bench, real top_speed, real weight, uint32_t ticks);

/* The step that is due, if one is. Returns 0 where there is nothing to do. */
int realtime_slice(kelly_bench *bench);

/* Add what a pass of the loop has cost [counts]. */
void realtime_busy(kelly_bench *bench, uint32_t counts);

/* Load since the start and of the last whole second, of the longest step [1/1000 of a period]. */
uint32_t realtime_load(const kelly_realtime *rt);
uint32_t realtime_worst_load(const kelly_realtime *rt);

#endif
