/* plant.h - one drill string, run and looked at: torsion and axial motion of one realisation, with everything a bench reads.
 *
 * With a stiff or a soft drive, by the case, torsion has the same bits as that realisation has in a Monte Carlo run. Or the
 * top turns as it is commanded, whatever the torque: a controller of one's own, a bench.
 */
#ifndef KELLY_PLANT_H
#define KELLY_PLANT_H

#include "axial.h"
#include "drive.h"
#include "integrator.h"

/* Fields are not to be written. */
typedef struct {
    const kelly_table *table;
    kelly_case run;
    kelly_draw draw;
    kelly_modes modes;
    union {
        kelly_block block;       /* stiff */
        kelly_driven driven;     /* soft or commanded */
    };
    kelly_axial axial;
    real weight;                 /* fc in (F) now [N] */
    real target;                 /* speed that the ramp ends at [rad/s] */
    real gain;                   /* of a tick of it [rad/s] */
    uint32_t ramp;               /* ticks that it still takes */
    uint32_t ramp_inverse;       /* its bits inverted */
    uint8_t varies;              /* the top's speed: `driven` is in use */
    uint8_t commanded;
    uint8_t changed;             /* a look found another seal than that of the start or of the last command */
    uint32_t tick;               /* steps */
    uint32_t seal;               /* of what only these change: seal.h */
} kelly_plant;

/* What can be seen of the string at one instant. */
typedef struct {
    real bit_speed;              /* [rad/s] */
    real bit_torque;             /* T_bit [N m], negative while it resists */
    real f_bit;                  /* weight as the rock feels it [N], <= 0 */
    real axial_speed;            /* of the bit [m/s] */
    real surface_torque;         /* eq. (S) [N m] */
    real top_speed;              /* [rad/s] */
} kelly_sight;

/* Start at tick 0, with the drive of the case. KELLY_OK, or why this draw cannot be run; plant->modes is filled unless KELLY_RANGE. */
kelly_status kelly_plant_start(kelly_plant *plant, const kelly_table *table, const kelly_case *run, const kelly_draw *draw);

/* The same with a top that turns at top_speed [rad/s] until it is commanded otherwise; the drive of the case is left out.
 * From rest or turning at top_speed, by run->rotating. KELLY_STEP also where a step turns it by more than KELLY_TURN. */
kelly_status kelly_plant_start_commanded(kelly_plant *plant, const kelly_table *table, const kelly_case *run, const kelly_draw *draw,
                                         real top_speed);

/* Command: the top's speed goes in a straight line to top_speed [rad/s], any sign, over the next `ticks` (>= 1) steps, and
 * stays; `weight` [N] takes the place of fc in (F) at once, the modes stay. Nothing where the plant was not started commanded. */
void kelly_plant_command(kelly_plant *plant, real top_speed, real weight, uint32_t ticks);

/* Whether the step can be trusted with such a command: numbers up to 1e30, weight > 0 and within the bound of kelly_realise,
 * |top_speed| within KELLY_TURN a step. One that it cannot be trusted with may lead to a state that is not sane. */
int kelly_plant_allows(const kelly_plant *plant, real top_speed, real weight);

/* Advance by `ticks` steps. */
void kelly_plant_advance(kelly_plant *plant, uint32_t ticks);

/* Look. Cost: about 12 operations a mode. */
void kelly_plant_look(const kelly_plant *plant, kelly_sight *sight);

/* Whether every state is a finite number of sane size and, bit by bit, what the last step left, as many steps were made as were asked for,
 * and no coefficient has changed in memory by the last look: at every KELLY_LOOK steps (seal.h), a command and the end of its ramp. */
int kelly_plant_sane(const kelly_plant *plant);

/* The kelly_block_... of the same names, whatever the drive. The twist of a commanded top means nothing. */
void kelly_plant_watch(kelly_plant *plant);
void kelly_plant_extremes(const kelly_plant *plant, real *lowest, real *highest);
void kelly_plant_modal(const kelly_plant *plant, real q[KELLY_MODES_MAX], real v[KELLY_MODES_MAX]);
real kelly_plant_twist(const kelly_plant *plant);

#endif
