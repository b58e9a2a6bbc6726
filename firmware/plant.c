#include "plant.h"

#include "bitrock.h"
#include "seal.h"

#define F_OFFSET R(0.01)         /* constant part of f_a / f0, eq. (F) */
#define SANE_AXIAL R(1e6)        /* [m/s] */

/* ---- what must not change ---- */

/* Over what only a start, a command and the end of its ramp change: all that a string is advanced and looked at by. */
static uint32_t seal_of(const kelly_plant *plant)
{
    const size_t modes = (plant->modes.count < KELLY_MODES_MAX ? plant->modes.count : KELLY_MODES_MAX) * sizeof(real);
    const uint32_t kinds = plant->varies | (uint32_t)plant->commanded << 8;
    uint32_t seal = plant->varies ? kelly_driven_seal(&plant->driven) : kelly_block_seal(&plant->block);

    seal = KELLY_SEAL_MEMBERS(seal, plant->table, kelly_table, alpha, inertia);
    seal = KELLY_SEAL_MEMBERS(seal, &plant->run, kelly_case, f0, f0);
    seal = KELLY_SEAL_MEMBERS(seal, &plant->run, kelly_case, step_ns, step_ns);
    seal = kelly_seal(seal, &kinds, sizeof(kinds));
    seal = KELLY_SEAL_MEMBERS(seal, plant, kelly_plant, draw, draw);
    seal = KELLY_SEAL_MEMBERS(seal, plant, kelly_plant, weight, gain);
    seal = kelly_axial_seal(seal, &plant->axial);
    seal = kelly_seal(seal, plant->modes.w2, modes);
    seal = kelly_seal(seal, plant->modes.b, modes);
    return kelly_seal(seal, plant->modes.d, modes);
}

/* Whether torsion and axial motion are as the last step left them. */
static int untouched(const kelly_plant *plant)
{
    return (plant->varies ? kelly_driven_untouched(&plant->driven) : kelly_block_untouched(&plant->block)) && kelly_axial_untouched(&plant->axial);
}

static int counts_ticks(const kelly_plant *plant)
{
    return plant->tick == (plant->varies ? plant->driven.tick : plant->block.tick) && plant->ramp == ~plant->ramp_inverse;
}

static void look(kelly_plant *plant)
{
    if (seal_of(plant) != plant->seal || plant->ramp != ~plant->ramp_inverse) {
        plant->changed = 1;
    }
}

/* ---- starts ---- */

static void put_ramp(kelly_plant *plant, uint32_t ticks)
{
    plant->ramp = ticks;
    plant->ramp_inverse = ~ticks;
}

/* What every start begins with. `run` is that of the plant. */
static kelly_status prepare(kelly_plant *plant, const kelly_table *table, const kelly_draw *draw)
{
    const kelly_status status = kelly_realise(table, &plant->run, draw, &plant->modes);

    if (status != KELLY_OK) {
        return status;
    }
    plant->table = table;
    plant->draw = *draw;
    plant->weight = draw->fc;
    plant->target = draw->w0;
    plant->gain = 0;
    put_ramp(plant, 0);
    plant->tick = 0;
    plant->changed = 0;
    plant->commanded = 0;
    plant->varies = plant->run.drive.inertia > 0;
    return kelly_axial_start(&plant->axial, table, &plant->run, draw);
}

static void load_driven(kelly_plant *plant, real top_speed)
{
    kelly_driven_clear(&plant->driven, plant->table, &plant->run, 1);
    kelly_driven_load(&plant->driven, 0, plant->table, &plant->run, &plant->draw, &plant->modes, top_speed);
}

kelly_status kelly_plant_start(kelly_plant *plant, const kelly_table *table, const kelly_case *run, const kelly_draw *draw)
{
    kelly_status status;

    plant->run = *run;
    status = prepare(plant, table, draw);
    if (status != KELLY_OK) {
        return status;
    }
    if (plant->varies) {
        load_driven(plant, draw->w0);
    } else {
        kelly_block_clear(&plant->block, table, run, 1);
        kelly_block_load(&plant->block, 0, run, draw, &plant->modes);
    }
    plant->seal = seal_of(plant);
    return KELLY_OK;
}

static int turns_slowly(const kelly_case *run, real top_speed)
{
    return kelly_step_seconds(run) * KELLY_ABS(top_speed) <= KELLY_TURN;   /* false for a NaN */
}

kelly_status kelly_plant_start_commanded(kelly_plant *plant, const kelly_table *table, const kelly_case *run, const kelly_draw *draw,
                                         real top_speed)
{
    kelly_status status;

    plant->run = *run;
    plant->run.drive = (kelly_drive){ .inertia = 0 };
    status = prepare(plant, table, draw);
    if (status != KELLY_OK || !turns_slowly(run, top_speed)) {
        return status != KELLY_OK ? status : KELLY_STEP;
    }
    plant->varies = 1;
    plant->commanded = 1;
    plant->target = top_speed;
    load_driven(plant, top_speed);
    plant->seal = seal_of(plant);
    return KELLY_OK;
}

int kelly_plant_allows(const kelly_plant *plant, real top_speed, real weight)
{
    const real rate = kelly_fastest_rate(plant->table, &plant->run, &plant->draw, &plant->modes, weight);

    return turns_slowly(&plant->run, top_speed) && weight > 0 && kelly_step_seconds(&plant->run) * rate <= KELLY_REAL_AXIS;
}

void kelly_plant_command(kelly_plant *plant, real top_speed, real weight, uint32_t ticks)
{
    if (!plant->commanded || ticks == 0) {
        return;
    }
    look(plant);
    plant->weight = weight;
    plant->target = top_speed;
    put_ramp(plant, ticks);
    plant->gain = (top_speed - kelly_driven_top_speed(&plant->driven, 0)) / (real)ticks;
    kelly_driven_weigh(&plant->driven, 0, &plant->run, &plant->draw, weight);
    kelly_driven_ramp(&plant->driven, 0, plant->gain / kelly_step_seconds(&plant->run));
    plant->seal = seal_of(plant);
}

/* Forces f_a of the stages of the step that was made last. */
static void push_axial(kelly_plant *plant)
{
    const vreal *const sines = plant->driven.lane[0].sines;
    real f[4];

    for (unsigned k = 0; k < 4; k++) {
        f[k] = plant->run.f0 * (sines[k] + F_OFFSET);
    }
    kelly_axial_push(&plant->axial, f);
}

/* A tick of the ramp is over: the speed from its end, so that rounding does not add up. */
static void follow_ramp(kelly_plant *plant)
{
    plant->ramp--;
    plant->ramp_inverse++;                 /* by itself, so that they part where one of them has changed */
    if (plant->ramp > 0) {
        kelly_driven_adjust(&plant->driven, 0, plant->target - plant->gain * (real)plant->ramp);
    } else {
        look(plant);
        kelly_driven_hold(&plant->driven, 0, plant->target);
        plant->seal = seal_of(plant);
    }
}

static void advance_driven(kelly_plant *plant, uint32_t ticks)
{
    for (; ticks > 0; ticks--) {
        kelly_driven_advance(&plant->driven, 1);
        push_axial(plant);
        if (plant->ramp > 0) {
            follow_ramp(plant);
        }
    }
}

static void advance(kelly_plant *plant, uint32_t ticks)
{
    if (plant->varies) {
        advance_driven(plant, ticks);
        return;
    }
    for (uint32_t k = 0; k < ticks; k++) {
        kelly_axial_step(&plant->axial, plant->block.tick + k);
    }
    kelly_block_advance(&plant->block, ticks);
}

void kelly_plant_advance(kelly_plant *plant, uint32_t ticks)
{
    while (ticks > 0) {
        const uint32_t since = plant->tick % KELLY_LOOK, part = ticks < KELLY_LOOK - since ? ticks : KELLY_LOOK - since;

        if (since == 0) {
            look(plant);
        }
        advance(plant, part);
        plant->tick += part;
        ticks -= part;
    }
}

/* Torque at the top [N m], eq. (S): momentum of the whole string. The sum of G Ip theta' over the modes converges slowly. */
static real surface_torque(const kelly_plant *plant, real bit_torque)
{
    const kelly_table *const table = plant->table;
    const real drag = table->alpha * plant->draw.w0;
    real q[KELLY_MODES_MAX], v[KELLY_MODES_MAX], torque = table->inertia * drag - bit_torque;

    kelly_block_modal(&plant->block, 0, &plant->modes, table, q, v);
    for (unsigned i = 0; i < plant->modes.count && i < KELLY_MODES_MAX; i++) {
        const real w2 = plant->modes.w2[i], d = plant->modes.d[i];

        torque += d * (plant->modes.b[i] * bit_torque - d * drag - w2 * (table->beta * v[i] + q[i]));
    }
    return torque;
}

void kelly_plant_look(const kelly_plant *plant, kelly_sight *sight)
{
    const kelly_draw *const draw = &plant->draw;
    const real sine = plant->varies ? plant->driven.lane[0].sine : kelly_block_sine(&plant->block, 0);
    const real weight = plant->run.f0 * (sine + F_OFFSET) - plant->weight;

    sight->bit_speed = plant->varies ? kelly_driven_speed(&plant->driven, 0) : kelly_block_speed(&plant->block, 0);
    sight->f_bit = weight < 0 ? weight : 0;
    sight->bit_torque = kelly_bit_torque(sight->bit_speed, draw->mu * sight->f_bit, draw->a1, draw->a2);
    sight->axial_speed = kelly_axial_speed(&plant->axial);
    sight->surface_torque = plant->varies ? kelly_driven_top_torque(&plant->driven, 0, sight->bit_torque)
                                          : surface_torque(plant, sight->bit_torque);
    sight->top_speed = plant->varies ? kelly_driven_top_speed(&plant->driven, 0) : draw->w0;
}

int kelly_plant_sane(const kelly_plant *plant)
{
    const real axial = kelly_axial_speed(&plant->axial);

    if (plant->changed || !counts_ticks(plant) || !untouched(plant)) {         /* its counts may lead anywhere */
        return 0;
    }
    return (plant->varies ? kelly_driven_sane(&plant->driven, 0) : kelly_block_sane(&plant->block, 0)) && axial > -SANE_AXIAL && axial < SANE_AXIAL;
}

void kelly_plant_watch(kelly_plant *plant)
{
    if (plant->varies) {
        kelly_driven_watch(&plant->driven);
    } else {
        kelly_block_watch(&plant->block);
    }
}

void kelly_plant_extremes(const kelly_plant *plant, real *lowest, real *highest)
{
    if (plant->varies) {
        kelly_driven_extremes(&plant->driven, 0, lowest, highest);
    } else {
        kelly_block_extremes(&plant->block, 0, lowest, highest);
    }
}

void kelly_plant_modal(const kelly_plant *plant, real q[KELLY_MODES_MAX], real v[KELLY_MODES_MAX])
{
    if (plant->varies) {
        kelly_driven_modal(&plant->driven, 0, &plant->modes, q, v);
    } else {
        kelly_block_modal(&plant->block, 0, &plant->modes, plant->table, q, v);
    }
}

real kelly_plant_twist(const kelly_plant *plant)
{
    return plant->varies ? kelly_driven_twist(&plant->driven, 0, &plant->modes) : kelly_block_twist(&plant->block, 0, &plant->modes);
}
