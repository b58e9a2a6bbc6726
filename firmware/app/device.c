/* device.c - the device program: the paper's estimation on the board.
 *
 * Asks for one line over the UART (line.h) and runs what it says; an empty line runs the well file's case:
 *   seed=1 first=0 samples=4     realisations first .. first + samples - 1 of seed
 *   mu_e6=40000                  bit-rock factor in millionths
 *   seconds=100 from=50          duration and start of the window, which lasts to the end (without: the well file's)
 *   digest=1                     the case of `make digest`: mu 0.04, every law at 0.2
 *   count=1                      instructions a step, exact in an emulator (board.h), and nothing else
 * Prints each realisation, P with its interval, the stack's high-water mark and the digest, which is that of
 * `kelly montecarlo` of the same case.
 */
#include "../board/board.h"
#include "../kelly.h"
#include "line.h"

#define TO_RPM R(9.54929658551372)
#define MAX_SAMPLES 1000000u

static kelly_work work;

/* Fixed point with `digits` decimals, rounded to nearest; |value| < 2^31 / 10^digits. */
static void say_fixed(wide value, unsigned digits)
{
    uint32_t scale = 1, scaled;

    for (unsigned k = 0; k < digits; k++) {
        scale *= 10u;
    }
    if (value < 0) {
        board_text("-");
        value = -value;
    }
    scaled = (uint32_t)(int32_t)(value * (wide)scale + W(0.5));
    board_decimal(scaled / scale);
    board_text(".");
    for (uint32_t digit = scale / 10u; digit > 0; digit /= 10u) {
        board_decimal(scaled / digit % 10u);
    }
}

static void say_number(const char *name, uint32_t value)
{
    board_text(name);
    board_decimal(value);
}

static void say_value(const char *name, wide value, unsigned digits)
{
    board_text(name);
    say_fixed(value, digits);
}

static void say_result(uint32_t index, const kelly_result *result)
{
    static const char *const why[KELLY_STATUSES] = { "", "step", "range", "nonfinite" };

    say_number("realisation ", index);
    if (result->status != KELLY_OK) {
        board_text(" refused: ");
        board_text(why[result->status]);
    } else {
        say_value(" bit ", (wide)(result->lowest * TO_RPM), 2);
        say_value(" .. ", (wide)(result->highest * TO_RPM), 2);
        say_value(" rpm, ss ", (wide)result->ss, 4);
        board_text(result->stuck ? " stick-slip" : " free");
    }
    board_text("\n");
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
    board_text(" bytes\ndigest ");
    board_hex(tally->digest);
    board_text("\n");
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
    board_text(run->rotating ? ", start rotating, window " : ", start rest, window ");
    say_value("", (wide)run->window_first * ((wide)kelly_step_seconds(run)), 3);
    say_value(":", (wide)run->window_last * ((wide)kelly_step_seconds(run)), 3);
    board_text(" s\n");
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

static void estimate(const kelly_case *run, const char *line)
{
    const uint64_t seed = line_number(line, "seed", 1);
    const uint32_t first = (uint32_t)line_number(line, "first", 0), samples = (uint32_t)line_number(line, "samples", 4);
    kelly_tally tally = { 0 };

    for (uint32_t j = 0; j < samples && j < MAX_SAMPLES; j++) {
        kelly_result result;

        kelly_run(&kelly_string, run, seed, first + j, 1, &result, &work);
        kelly_tally_add(&tally, first + j, &result);
        say_result(first + j, &result);
    }
    say_outcome(&tally);
}

static void advance(void *ticks)
{
    kelly_block_advance(&work.block, *(const uint32_t *)ticks);
}

/* From tick 1 on, so that no evaluation of the exact phase falls into the stretch. */
static void count(const kelly_case *run)
{
    uint32_t one = 1, few = 500, many = 1000;
    kelly_draw draw;

    kelly_draw_nominal(run, &draw);
    (void)kelly_realise(&kelly_string, run, &draw, &work.modes);
    kelly_block_clear(&work.block, &kelly_string, run, 1);
    kelly_block_load(&work.block, 0, run, &draw, &work.modes);
    advance(&one);
    many = board_measure(advance, &many);
    few = board_measure(advance, &few);
    say_value("per step ", (wide)(int32_t)(many - few) / W(500.0), 1);
    board_text(board_counts_cycles() ? " cycles\n" : " instructions\n");
}

int main(void)
{
    char line[LINE_MAX];
    static const char *const keys[] = { "seed", "first", "samples", "mu_e6", "seconds", "from", "digest", "count" };
    const char *error = kelly_table_error(&kelly_string), *stranger;
    kelly_case run;

    board_text("kelly " KELLY_VERSION " on " BOARD_NAME "\n");
    if (line_ask(line) < 0) {
        board_text("no answer: the well file's case\n");
    }
    if (error) {   /* before any other field of the table is read */
        board_text(error);
        board_text("\n");
        return 1;
    }
    stranger = line_stranger(line, keys, (int)(sizeof(keys) / sizeof(keys[0])));
    if (stranger) {
        board_text("not understood: ");
        board_text(stranger);
        board_text("; give seed= first= samples= mu_e6= seconds= from= digest= count=, whole numbers\n");
        return 2;
    }
    run = asked_case(line);
    error = kelly_case_error(&kelly_string, &run);
    if (!error && line_number(line, "first", 0) + line_number(line, "samples", 4) > (uint64_t)UINT32_MAX + 1u) {
        error = "indices end at 4294967295";
    }
    if (error) {
        board_text(error);
        board_text("\n");
        return 1;
    }
    board_text(kelly_string.id);
    board_text(sizeof(real) > sizeof(float) ? ", double" : ", float");
    say_case(&run);
    if (line_number(line, "count", 0) != 0) {
        count(&run);
    } else {
        estimate(&run, line);
    }
    return 0;
}
