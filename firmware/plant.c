#include "plant.h"

#include "bitrock.h"

kelly_status kelly_plant_start(kelly_plant *plant, const kelly_table *table, const kelly_case *run, const kelly_draw *draw)
{
    const kelly_status status = kelly_realise(table, run, draw, &plant->modes);

    if (status != KELLY_OK) {
        return status;
    }
    plant->table = table;
    plant->run = *run;
    plant->draw = *draw;
    kelly_block_clear(&plant->block, table, run, 1);
    kelly_block_load(&plant->block, 0, run, draw, &plant->modes);
    return kelly_axial_start(&plant->axial, table, run, draw);
}

void kelly_plant_advance(kelly_plant *plant, uint32_t ticks)
{
    for (uint32_t k = 0; k < ticks; k++) {
        kelly_axial_step(&plant->axial, plant->block.tick + k);
    }
    kelly_block_advance(&plant->block, ticks);
}

/* Torque at the top [N m], eq. (S): momentum of the whole string. The sum of G Ip theta' over the modes converges slowly. */
static real surface_torque(const kelly_plant *plant, real bit_torque)
{
    const kelly_table *const table = plant->table;
    const real drag = table->alpha * plant->draw.w0;
    real q[KELLY_MODES_MAX], v[KELLY_MODES_MAX], torque = table->inertia * drag - bit_torque;

    kelly_block_modal(&plant->block, 0, &plant->modes, table, q, v);
    for (unsigned i = 0; i < plant->modes.count; i++) {
        const real w2 = plant->modes.w2[i], d = plant->modes.d[i];

        torque += d * (plant->modes.b[i] * bit_torque - d * drag - w2 * (table->beta * v[i] + q[i]));
    }
    return torque;
}

void kelly_plant_look(const kelly_plant *plant, kelly_sight *sight)
{
    const kelly_draw *const draw = &plant->draw;
    const real weight = plant->run.f0 * (kelly_block_sine(&plant->block, 0) + R(0.01)) - draw->fc;

    sight->bit_speed = kelly_block_speed(&plant->block, 0);
    sight->f_bit = weight < 0 ? weight : 0;
    sight->bit_torque = kelly_bit_torque(sight->bit_speed, draw->mu * sight->f_bit, draw->a1, draw->a2);
    sight->axial_speed = kelly_axial_speed(&plant->axial);
    sight->surface_torque = surface_torque(plant, sight->bit_torque);
    sight->top_speed = draw->w0;
}
