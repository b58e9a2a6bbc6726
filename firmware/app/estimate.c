#include "estimate.h"
#include "../board/board.h"
#include "line.h"
#include "say.h"

#define TO_RPM R(9.54929658551372)
#define MAX_SAMPLES 1000000u

static void say_result(uint32_t index, const kelly_result *result)
{
    static const char *const why[KELLY_STATUSES] = { "", "step", "range", "nonfinite", "corrupt" };

    say_number("realisation ", index);
    if (result->status != KELLY_OK) {
        say_text(" refused: ");
        say_text(why[result->status]);
    } else {
        say_value(" bit ", (wide)(result->lowest * TO_RPM), 2);
        say_value(" .. ", (wide)(result->highest * TO_RPM), 2);
        say_value(" rpm, ss ", (wide)result->ss, 4);
        say_text(result->stuck ? " stick-slip" : " free");
    }
    say_text("\n");
}

static void say_outcome(const kelly_tally *tally)
{
    wide lo, hi;

    kelly_interval(tally, &lo, &hi);
    say_value("P(stick-slip) = ", kelly_probability(tally), 4);
    say_value("   95 % interval ", lo, 4);
    say_value(" .. ", hi, 4);
    say_number("   (", tally->stuck);
    say_number(" of ", tally->samples - kelly_refused(tally));
    say_number(", refused ", kelly_refused(tally));
    say_number(", lift-off ", tally->liftoff);
    say_number(")\nstack ", stack_used());
    say_number(" of ", stack_size());
    say_text(" bytes\ndigest ");
    say_hex(tally->digest);
    say_text("\n");
}

/* The case, as the host prints it. */
static void say_case(const kelly_case *run)
{
    say_value(", ", (wide)(run->w0 * TO_RPM), 2);
    say_value(" rpm, ", (wide)(run->fc / R(1000.0)), 2);
    say_value(" kN, f0 ", (wide)(run->f0 / R(1000.0)), 2);
    say_value(" kN, mu ", (wide)run->mu, 6);
    say_value(", alpha1 ", (wide)run->a1, 3);
    say_value(", alpha2 ", (wide)run->a2, 3);
    say_text(run->rotating ? ", start rotating, window " : ", start rest, window ");
    say_value("", (wide)run->window_first * ((wide)kelly_step_seconds(run)), 3);
    say_value(":", (wide)run->window_last * ((wide)kelly_step_seconds(run)), 3);
    say_text(" s\n");
}

/* Steps of whole seconds; 0, which no case may have, where they are not whole or too many. */
static uint32_t ticks_of(uint64_t seconds, const kelly_case *run)
{
    const uint64_t ns = seconds * 1000000000u;

    return seconds < 4000000u && ns % run->step_ns == 0 && ns / run->step_ns <= UINT32_MAX ? (uint32_t)(ns / run->step_ns) : 0u;
}

/* The case that the line asks for, on the step of the table. */
static kelly_case asked_case(const char *line)
{
    kelly_case run = kelly_string.nominal;
    const uint64_t seconds = line_number(line, "seconds", 0);
    const uint32_t mu_e6 = (uint32_t)line_number(line, "mu_e6", 0);

    if (seconds > 0) {
        run.ticks = ticks_of(seconds, &run);
        run.window_first = ticks_of(line_number(line, "from", seconds / 2u), &run);
        run.window_last = run.ticks;
    }
    if (line_number(line, "digest", 0) != 0) {
        run.mu = R(0.04);
        for (unsigned k = 0; k < KELLY_PARAMETERS; k++) {
            run.cov[k] = 0.2f;
        }
    }
    if (mu_e6 > 0) {
        run.mu = (real)(int32_t)mu_e6 / R(1000000.0);
    }
    return run;
}

static void run_all(const kelly_case *run, const char *line, kelly_work *work)
{
    const uint64_t seed = line_number(line, "seed", 1);
    const uint32_t first = (uint32_t)line_number(line, "first", 0), samples = (uint32_t)line_number(line, "samples", 4);
    kelly_tally tally = { 0 };

    for (uint32_t j = 0; j < samples && j < MAX_SAMPLES; j++) {
        kelly_result result;

        kelly_run(&kelly_string, run, seed, first + j, 1, &result, work);
        kelly_tally_add(&tally, first + j, &result);
        say_result(first + j, &result);
    }
    say_outcome(&tally);
}

/* Not inlined: the same instructions whatever the number of ticks. */
static __attribute__((noinline)) uint32_t cost(kelly_block *block, uint32_t ticks)
{
    const uint32_t start = board_measure_start();

    kelly_block_advance(block, ticks);
    return board_measure_end(start);
}

/* From tick 1 on, so that no evaluation of the exact phase falls into the stretch. */
static void count(const kelly_case *run, kelly_work *work)
{
    static const volatile uint32_t ticks[2] = { 1000, 500 };   /* volatile: no copy of cost() for each */
    uint32_t few, many;
    kelly_draw draw;

    kelly_draw_nominal(run, &draw);
    (void)kelly_realise(&kelly_string, run, &draw, &work->modes);
    kelly_block_clear(&work->block, &kelly_string, run, 1);
    kelly_block_load(&work->block, 0, run, &draw, &work->modes);
    kelly_block_advance(&work->block, 1);
    many = cost(&work->block, ticks[0]);
    few = cost(&work->block, ticks[1]);
    say_value("per step ", (wide)(int32_t)(many - few) / W(500.0), 1);
    say_text(board_counts_cycles() ? " cycles\n" : " instructions\n");
}

int estimate(const char *line, kelly_work *work)
{
    static const char *const keys[] = { "seed", "first", "samples", "mu_e6", "seconds", "from", "digest", "count" };
    const char *const stranger = line_stranger(line, keys, (int)(sizeof(keys) / sizeof(keys[0])));
    const char *error;
    kelly_case run;

    if (stranger) {
        say_text("not understood: ");
        say_text(stranger);
        say_text("; give seed= first= samples= mu_e6= seconds= from= digest= count=, whole numbers\n");
        return 2;
    }
    run = asked_case(line);
    error = kelly_case_error(&kelly_string, &run);
    if (!error && line_number(line, "first", 0) + line_number(line, "samples", 4) > (uint64_t)UINT32_MAX + 1u) {
        error = "indices end at 4294967295";
    }
    if (error) {
        say_text(error);
        say_text("\n");
        return 1;
    }
    say_text(kelly_string.id);
    say_text(sizeof(real) > sizeof(float) ? ", double" : ", float");
    say_case(&run);
    if (line_number(line, "count", 0) != 0) {
        count(&run, work);
    } else {
        run_all(&run, line, work);
    }
    return 0;
}
