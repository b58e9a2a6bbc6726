/* gauge.h - what a rig display would read: the last seconds of the string that runs, and P of the last campaign.
 *
 * The bit speed's extremes and mean, ss and SSI are those of the last GAUGE_SECONDS seconds, several periods of stick-slip
 * (some 3 s); weight, torque and top speed those of the last whole second. Read from looks at the string,
 * in real time a hundredth of a second apart, in lockstep one a frame.
 */
#ifndef KELLY_GAUGE_H
#define KELLY_GAUGE_H

#include "../link/wits.h"
#include "../plant.h"
#include "../tally.h"

#define GAUGE_SECONDS 10u

/* Sums over the looks of one second of the string. */
typedef struct {
    real lowest, highest, speed;         /* of the bit [rad/s]: extremes, sum */
    real torque, torque_high;            /* at the surface [N m]: sum, largest */
    real weight, weight_high;            /* on the rock [N] */
    real bit_torque, bit_torque_high;    /* [N m], positive while it resists */
    real top;                            /* [rad/s] sum */
    uint32_t looks;
} kelly_gauge_second;

typedef struct {
    kelly_gauge_second last;                   /* the last whole second */
    kelly_gauge_second now;                    /* the present one */
    real lowest[GAUGE_SECONDS], highest[GAUGE_SECONDS], mean[GAUGE_SECONDS];
    uint32_t seconds;                    /* whole ones so far */
    uint32_t second;                     /* the present one, of the string's time */
    uint32_t job, next, samples, stuck;  /* of the last campaign */
} kelly_gauge;

/* Another string begins. */
void gauge_clear(kelly_gauge *gauge);

/* One look at it, after `tick` steps. */
void gauge_look(kelly_gauge *gauge, const kelly_sight *sight, uint32_t tick, uint32_t step_ns);

/* A campaign begins or goes on; one result of it. */
void gauge_job(kelly_gauge *gauge, uint32_t job);
void gauge_count(kelly_gauge *gauge, uint32_t index, const kelly_result *result);

/* The frame of all that is known, 0-terminated; room > KELLY_WITS_TEXT. */
void gauge_wits(const kelly_gauge *gauge, char *text, size_t room);

#endif
