#include "ensemble.h"

#include "seal.h"
#include "severity.h"

/* One copy for its callers: boards have little flash. */
#define SHARED static __attribute__((noinline))

static int soft(const kelly_case *run)
{
    return run->drive.inertia > 0;
}

static void advance(const kelly_case *run, uint32_t ticks, kelly_work *work)
{
    if (soft(run)) {
        kelly_driven_advance(&work->driven, ticks);
    } else {
        kelly_block_advance(&work->block, ticks);
    }
}

/* Twist of a lane at the weight of its draw. */
SHARED real twist(const kelly_table *table, const kelly_case *run, unsigned lane, const kelly_result *result, kelly_work *work)
{
    (void)kelly_modes_at(table, result->draw.fc, run->torsional, &work->modes);
    return soft(run) ? kelly_driven_twist(&work->driven, lane, &work->modes) : kelly_block_twist(&work->block, lane, &work->modes);
}

static int sane(const kelly_case *run, unsigned lane, const kelly_work *work)
{
    return soft(run) ? kelly_driven_sane(&work->driven, lane) : kelly_block_sane(&work->block, lane);
}

/* Load one realisation, its draw in place, if it may be integrated. */
static void begin(const kelly_table *table, const kelly_case *run, unsigned lane, kelly_result *result, kelly_work *work)
{
    result->liftoff = (uint8_t)kelly_lifts_off(run, &result->draw);
    result->status = (uint8_t)kelly_realise(table, run, &result->draw, &work->modes);
    if (result->status != KELLY_OK) {
        return;
    }
    if (soft(run)) {
        kelly_driven_load(&work->driven, lane, table, run, &result->draw, &work->modes, result->draw.w0);
    } else {
        kelly_block_load(&work->block, lane, run, &result->draw, &work->modes);
    }
}

static void classify(const kelly_table *table, const kelly_case *run, unsigned lane, kelly_result *result, kelly_work *work)
{
    const uint32_t steps = run->window_last - run->window_first;   /* 0: of a case that nobody has checked */

    if (result->status != KELLY_OK) {
        return;
    }
    if (steps == 0 || !sane(run, lane, work)) {
        result->status = KELLY_NONFINITE;
        result->mean = 0;
        return;
    }
    if (soft(run)) {
        kelly_driven_extremes(&work->driven, lane, &result->lowest, &result->highest);
    } else {
        kelly_block_extremes(&work->block, lane, &result->lowest, &result->highest);
    }
    result->mean = result->draw.w0 + (twist(table, run, lane, result, work) - result->mean) / (kelly_step_seconds(run) * (real)steps);
    result->ss = kelly_severity(result->lowest, result->highest);
    result->stuck = result->ss > run->limit;
}

/* The window opens: twists at its start, kept in `mean` until the end. */
static void open_window(const kelly_table *table, const kelly_case *run, unsigned count, kelly_result *results, kelly_work *work)
{
    if (soft(run)) {
        kelly_driven_watch(&work->driven);
    } else {
        kelly_block_watch(&work->block);
    }
    for (unsigned l = 0; l < count; l++) {
        if (results[l].status == KELLY_OK) {
            results[l].mean = twist(table, run, l, &results[l], work);
        }
    }
}

/* Over all that the rest of the block relies on and does not change. */
static uint32_t seal_of(const kelly_case *run, unsigned count, const kelly_result *results, const kelly_work *work)
{
    const uint32_t modes = run->torsional | (uint32_t)run->rotating << 8;
    uint32_t seal = soft(run) ? kelly_driven_seal(&work->driven) : kelly_block_seal(&work->block);

    seal = KELLY_SEAL_MEMBERS(seal, run, kelly_case, fc, cov);            /* what lies between is not the same in every copy */
    seal = KELLY_SEAL_MEMBERS(seal, run, kelly_case, limit, window_last);
    seal = KELLY_SEAL_MEMBERS(seal, run, kelly_case, drive, drive);
    seal = kelly_seal(seal, &modes, sizeof(modes));
    for (unsigned l = 0; l < count; l++) {
        const uint32_t flags = results[l].status | (uint32_t)results[l].liftoff << 8;

        seal = kelly_seal(seal, &results[l].draw, sizeof(results[l].draw));
        seal = kelly_seal(seal, &results[l].mean, sizeof(results[l].mean));      /* the twist where the window opened */
        seal = kelly_seal(seal, &flags, sizeof(flags));
    }
    return seal;
}

static void give_up(unsigned count, kelly_result *results)
{
    for (unsigned l = 0; l < count; l++) {
        results[l] = (kelly_result){ .draw = results[l].draw, .status = KELLY_CORRUPT, .liftoff = results[l].liftoff };
    }
}

/* One block: up to KELLY_LANES realisations together, whose draws stand in results[], the rest of them zero. A table that has
 * changed may lead anywhere: nothing of it is used. */
static void begin_block(const kelly_table *table, const kelly_case *run, unsigned count, kelly_result *results, kelly_work *work)
{
    if (kelly_table_head_error(table) != 0) {
        *work = (kelly_work){ 0 };
        give_up(count, results);
        return;
    }
    if (soft(run)) {
        kelly_driven_clear(&work->driven, table, run, count);
    } else {
        kelly_block_clear(&work->block, table, run, count);
    }
    for (unsigned l = 0; l < count; l++) {
        begin(table, run, l, &results[l], work);
    }
    work->tick = 0;
    work->seal = seal_of(run, count, results, work);
}

static uint32_t tick_of(const kelly_case *run, const kelly_work *work)
{
    return soft(run) ? work->driven.tick : work->block.tick;
}

static int untouched(const kelly_case *run, const kelly_work *work)
{
    return soft(run) ? kelly_driven_untouched(&work->driven) : kelly_block_untouched(&work->block);
}

/* Whether all is as it was when the block began, and the state as the last step left it. Asked before the table is used, which may lead anywhere else. */
SHARED int intact(const kelly_table *table, const kelly_case *run, unsigned count, const kelly_result *results, const kelly_work *work)
{
    return tick_of(run, work) == work->tick && untouched(run, work) && kelly_table_error(table) == 0 &&
           seal_of(run, count, results, work) == work->seal;
}

static uint32_t lesser(uint32_t a, uint32_t b)
{
    return a < b ? a : b;
}

/* What is not intact stays where it is, for kelly_run_finish to say so. */
uint32_t kelly_run_advance(const kelly_table *table, const kelly_case *run, unsigned count, kelly_result *results,
                           kelly_work *work, uint32_t ticks)
{
    while (ticks > 0 && work->tick < run->window_last) {
        const uint32_t tick = work->tick, stop = tick < run->window_first ? run->window_first : run->window_last;
        const uint32_t part = lesser(ticks, lesser(stop - tick, KELLY_LOOK - tick % KELLY_LOOK));

        if ((tick % KELLY_LOOK == 0 || tick == run->window_first) && !intact(table, run, count, results, work)) {
            return 0;
        }
        if (tick == run->window_first) {
            open_window(table, run, count, results, work);
            work->seal = seal_of(run, count, results, work);
        }
        advance(run, part, work);
        work->tick += part;
        ticks -= part;
    }
    return work->tick < run->window_last ? run->window_last - work->tick : 0;   /* beyond it only where a fault has put it: an end, too */
}

void kelly_run_finish(const kelly_table *table, const kelly_case *run, unsigned count, kelly_result *results, kelly_work *work)
{
    if (work->tick != run->window_last || !intact(table, run, count, results, work)) {
        give_up(count, results);
        return;
    }
    for (unsigned l = 0; l < count; l++) {
        classify(table, run, l, &results[l], work);
    }
}

SHARED void draw(const kelly_case *run, uint64_t seed, uint32_t first, uint32_t count, kelly_result *results)
{
    for (uint32_t k = 0; k < count; k++) {
        results[k] = (kelly_result){ .status = KELLY_OK };
        kelly_draw_sample(run, seed, first + k, &results[k].draw);
    }
}

void kelly_run_begin(const kelly_table *table, const kelly_case *run, uint64_t seed, uint32_t first, unsigned count,
                     kelly_result *results, kelly_work *work)
{
    draw(run, seed, first, count, results);
    begin_block(table, run, count, results, work);
}

/* Realisations whose draws stand in results[], the rest of them zero. */
static void run_drawn(const kelly_table *table, const kelly_case *run, uint32_t count, kelly_result *results, kelly_work *work)
{
    unsigned lanes;

    for (uint32_t done = 0; done < count; done += lanes) {
        lanes = (unsigned)lesser(count - done, KELLY_LANES);
        begin_block(table, run, lanes, &results[done], work);
        (void)kelly_run_advance(table, run, lanes, &results[done], work, run->window_last);
        kelly_run_finish(table, run, lanes, &results[done], work);
    }
}

void kelly_run(const kelly_table *table, const kelly_case *run, uint64_t seed, uint32_t first, uint32_t count,
               kelly_result *results, kelly_work *work)
{
    draw(run, seed, first, count, results);
    run_drawn(table, run, count, results, work);
}

void kelly_run_draws(const kelly_table *table, const kelly_case *run, const kelly_draw *draws, uint32_t count,
                     kelly_result *results, kelly_work *work)
{
    for (uint32_t k = 0; k < count; k++) {
        results[k] = (kelly_result){ .draw = draws[k], .status = KELLY_OK };
    }
    run_drawn(table, run, count, results, work);
}

#if __STDC_HOSTED__
static void run_any(const kelly_table *table, const kelly_case *run, uint64_t seed, uint32_t first, uint32_t count,
                    kelly_result *results, void *work)
{
    kelly_run(table, run, seed, first, count, results, (kelly_work *)work);
}

static void run_any_draws(const kelly_table *table, const kelly_case *run, const kelly_draw *draws, uint32_t count,
                          kelly_result *results, void *work)
{
    kelly_run_draws(table, run, draws, count, results, (kelly_work *)work);
}

const kelly_engine kelly_engine_here = { .name = KELLY_ISA_NAME, .width = KELLY_WIDTH, .lanes = KELLY_LANES,
                                         .work_size = sizeof(kelly_work), .run = run_any, .run_draws = run_any_draws };
#endif
