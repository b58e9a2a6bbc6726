#include "ensemble.h"

#include "severity.h"

/* Load one realisation, its draw in place, if it may be integrated. */
static void begin(const kelly_table *table, const kelly_case *run, unsigned lane, kelly_result *result, kelly_work *work)
{
    result->liftoff = (uint8_t)kelly_lifts_off(run, &result->draw);
    result->status = (uint8_t)kelly_realise(table, run, &result->draw, &work->modes);
    if (result->status == KELLY_OK) {
        kelly_block_load(&work->block, lane, run, &result->draw, &work->modes);
    }
}

/* Twist at the start of the window, kept in `mean` until the end. */
static void open_window(const kelly_table *table, const kelly_case *run, unsigned lane, kelly_result *result, kelly_work *work)
{
    if (result->status == KELLY_OK) {
        (void)kelly_modes_at(table, result->draw.fc, run->torsional, &work->modes);
        result->mean = kelly_block_twist(&work->block, lane, &work->modes);
    }
}

/* The present tick is the first of the window. */
static void open_windows(const kelly_table *table, const kelly_case *run, unsigned count, kelly_result *results, kelly_work *work)
{
    kelly_block_watch(&work->block);
    for (unsigned l = 0; l < count; l++) {
        open_window(table, run, l, &results[l], work);
    }
}

static void classify(const kelly_table *table, const kelly_case *run, unsigned lane, kelly_result *result, kelly_work *work)
{
    const real seconds = kelly_step_seconds(run) * (real)(run->window_last - run->window_first);

    if (result->status != KELLY_OK) {
        return;
    }
    (void)kelly_modes_at(table, result->draw.fc, run->torsional, &work->modes);
    if (!kelly_block_sane(&work->block, lane)) {
        result->status = KELLY_NONFINITE;
        result->mean = 0;
        return;
    }
    kelly_block_extremes(&work->block, lane, &result->lowest, &result->highest);
    result->mean = result->draw.w0 + (kelly_block_twist(&work->block, lane, &work->modes) - result->mean) / seconds;
    result->ss = kelly_severity(result->lowest, result->highest);
    result->stuck = result->ss > run->limit;
}

/* One block: up to KELLY_LANES realisations together, whose draws stand in results[], the rest of them zero. */
static void begin_block(const kelly_table *table, const kelly_case *run, unsigned count, kelly_result *results, kelly_work *work)
{
    kelly_block_clear(&work->block, table, run, count);
    for (unsigned l = 0; l < count; l++) {
        begin(table, run, l, &results[l], work);
    }
    if (run->window_first == 0) {
        open_windows(table, run, count, results, work);
    }
}

uint32_t kelly_run_advance(const kelly_table *table, const kelly_case *run, unsigned count, kelly_result *results,
                           kelly_work *work, uint32_t ticks)
{
    while (ticks > 0 && work->block.tick < run->window_last) {
        const uint32_t tick = work->block.tick, stop = tick < run->window_first ? run->window_first : run->window_last;
        const uint32_t part = ticks < stop - tick ? ticks : stop - tick;

        kelly_block_advance(&work->block, part);
        ticks -= part;
        if (tick + part == run->window_first) {
            open_windows(table, run, count, results, work);
        }
    }
    return run->window_last - work->block.tick;
}

void kelly_run_finish(const kelly_table *table, const kelly_case *run, unsigned count, kelly_result *results, kelly_work *work)
{
    for (unsigned l = 0; l < count; l++) {
        classify(table, run, l, &results[l], work);
    }
}

static void run_block(const kelly_table *table, const kelly_case *run, unsigned count, kelly_result *results, kelly_work *work)
{
    begin_block(table, run, count, results, work);
    (void)kelly_run_advance(table, run, count, results, work, run->window_last);
    kelly_run_finish(table, run, count, results, work);
}

void kelly_run_begin(const kelly_table *table, const kelly_case *run, uint64_t seed, uint32_t first, unsigned count,
                     kelly_result *results, kelly_work *work)
{
    for (unsigned l = 0; l < count; l++) {
        results[l] = (kelly_result){ .status = KELLY_OK };
        kelly_draw_sample(run, seed, first + l, &results[l].draw);
    }
    begin_block(table, run, count, results, work);
}

static unsigned lanes_of(uint32_t left)
{
    return left < KELLY_LANES ? (unsigned)left : (unsigned)KELLY_LANES;
}

void kelly_run(const kelly_table *table, const kelly_case *run, uint64_t seed, uint32_t first, uint32_t count,
               kelly_result *results, kelly_work *work)
{
    for (uint32_t done = 0; done < count;) {
        const unsigned lanes = lanes_of(count - done);

        kelly_run_begin(table, run, seed, first + done, lanes, &results[done], work);
        (void)kelly_run_advance(table, run, lanes, &results[done], work, run->window_last);
        kelly_run_finish(table, run, lanes, &results[done], work);
        done += lanes;
    }
}

void kelly_run_draws(const kelly_table *table, const kelly_case *run, const kelly_draw *draws, uint32_t count,
                     kelly_result *results, kelly_work *work)
{
    for (uint32_t done = 0; done < count;) {
        const unsigned lanes = lanes_of(count - done);

        for (unsigned l = 0; l < lanes; l++) {
            results[done + l] = (kelly_result){ .draw = draws[done + l], .status = KELLY_OK };
        }
        run_block(table, run, lanes, &results[done], work);
        done += lanes;
    }
}

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
