/* plant.h - one drill string, run and looked at: torsion and axial motion of one realisation, with everything a bench reads.
 *
 * Torsion takes lane 0 of a one-lane block: the same bits as that realisation has in a Monte Carlo run.
 */
#ifndef KELLY_PLANT_H
#define KELLY_PLANT_H

#include "axial.h"
#include "integrator.h"

typedef struct {
    const kelly_table *table;
    kelly_case run;
    kelly_draw draw;
    kelly_modes modes;
    kelly_block block;
    kelly_axial axial;
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

/* Start at tick 0. KELLY_OK, or why this draw cannot be run; plant->modes is filled unless KELLY_RANGE. */
kelly_status kelly_plant_start(kelly_plant *plant, const kelly_table *table, const kelly_case *run, const kelly_draw *draw);

/* Advance by `ticks` steps. */
void kelly_plant_advance(kelly_plant *plant, uint32_t ticks);

/* Look. Cost: about 12 operations a mode. */
void kelly_plant_look(const kelly_plant *plant, kelly_sight *sight);

#endif
