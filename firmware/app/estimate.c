#include "estimate.h"
#include "../board/board.h"
#include "line.h"
#include "say.h"

#define TO_RPM R(9.54929658551372)
#define SAMPLES_MOST 1000000u
#define MU_E6_MOST 1000000000u       /* 1e3, as the host has it */
#define STEPS_MOST 4000000000u       /* as the host has it; nor seconds, for a step is 1 s at most */
#define NOT_GIVEN UINT32_MAX

enum { SEED, FIRST, SAMPLES, MU_E6, SECONDS, FROM, DIGEST, COUNT, KEYS };

static const line_key keys[KEYS] = {
    [SEED] = { "seed", 0, 1 }, [FIRST] = { "first", UINT32_MAX, 0 }, [SAMPLES] = { "samples", SAMPLES_MOST, 4 },
    [MU_E6] = { "mu_e6", MU_E6_MOST, NOT_GIVEN }, [SECONDS] = { "seconds", STEPS_MOST, NOT_GIVEN },
    [FROM] = { "from", STEPS_MOST, NOT_GIVEN }, [DIGEST] = { "digest", 1, 0 }, [COUNT] = { "count", 1, 0 },
};

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

/* Steps of these seconds; `none` where they are not whole or too many. */
static uint32_t ticks_of(uint32_t seconds, const kelly_case *run, uint32_t none)
{
    const uint64_t ns = (uint64_t)seconds * 1000000000u;

    return ns % run->step_ns == 0 && ns / run->step_ns <= STEPS_MOST ? (uint32_t)(ns / run->step_ns) : none;
}

/* The case that the line asks for, on the step of the table. Of what cannot be, a case that kelly_case_error refuses: no steps, or a
 * window that opens behind the last. */
static kelly_case asked_case(const uint64_t asked[KEYS])
{
    kelly_case run = kelly_string.nominal;
    const uint32_t seconds = (uint32_t)asked[SECONDS], mu_e6 = (uint32_t)asked[MU_E6];
    uint32_t from = (uint32_t)asked[FROM];

    if (seconds != NOT_GIVEN) {
        run.ticks = ticks_of(seconds, &run, 0);
        from = from == NOT_GIVEN ? seconds / 2u : from;
    }
    if (from != NOT_GIVEN) {
        run.window_first = ticks_of(from, &run, UINT32_MAX);
        run.window_last = run.ticks;
    }
    if (asked[DIGEST] != 0) {
        run.mu = R(0.04);
        for (unsigned k = 0; k < KELLY_PARAMETERS; k++) {
            run.cov[k] = 0.2f;
        }
    }
    if (mu_e6 != NOT_GIVEN) {
        run.mu = (real)(int32_t)mu_e6 / R(1000000.0);
    }
    return run;
}

static void run_all(const kelly_case *run, const uint64_t asked[KEYS], kelly_work *work)
{
    const uint32_t first = (uint32_t)asked[FIRST], samples = (uint32_t)asked[SAMPLES];
    kelly_tally tally = { 0 };

    for (uint32_t j = 0; j < samples; j++) {
        kelly_result result;

        kelly_run(&kelly_string, run, asked[SEED], first + j, 1, &result, work);
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
    uint64_t asked[KEYS];
    const char *const stranger = line_read(line, keys, asked, KEYS);
    const char *error;
    kelly_case run;

    if (stranger) {
        say_text("not understood: ");
        say_text(stranger);
        say_text("; give seed= first= samples= mu_e6= seconds= from= digest= count=, each once, whole numbers within range\n");
        return 2;
    }
    run = asked_case(asked);
    error = kelly_case_error(&kelly_string, &run);
    if (!error && asked[SAMPLES] - 1u > UINT32_MAX - asked[FIRST]) {   /* of no samples: wraps, and is more */
        error = "samples from 1 on, indices end at 4294967295";
    }
    if (error) {
        say_text(error);
        say_text("\n");
        return 1;
    }
    say_text(kelly_string.id);
    say_text(sizeof(real) > sizeof(float) ? ", double" : ", float");
    say_case(&run);
    if (asked[COUNT] != 0) {
        count(&run, work);
    } else {
        run_all(&run, asked, work);
    }
    return 0;
}
