/* device.c - the device program: an estimation, a bench, or a console, as the first input says.
 *
 * It says who it is and, with a line `?`, that it listens (line.h). Then
 *   a line of key=value words, or an empty one     the paper's estimation, and the end       (estimate.h)
 *   any other line of text                         a console for people, and the bench       (console.h)
 *   a frame, or any byte that is not text          the bench, and the console                (bench.h)
 */
#include "../board/board.h"
#include "bench.h"
#include "estimate.h"
#include "out.h"
#include "say.h"

static kelly_bench the_bench;

/* Wait for the first input; BENCH_ESTIMATE where it was a line for it. */
static int first_input(kelly_bench *bench)
{
    while (!bench->decided) {
        const int byte = board_read();

        if (byte < 0) {
            board_idle();
        } else if (bench_take(bench, (uint8_t)byte) == BENCH_ESTIMATE) {
            return BENCH_ESTIMATE;
        }
    }
    return BENCH_GOES_ON;
}

/* A table that does not fit the program: nothing of it may be read. */
static int broken(const char *why)
{
    while (board_read() < 0) {
        board_idle();
    }
    say_text(why);
    say_text("\n");
    return 1;
}

int main(void)
{
    const char *const error = kelly_table_error(&kelly_string);

    say_text("kelly " KELLY_VERSION " on " BOARD_NAME "\n?\n");
    if (error) {
        return broken(error);
    }
    bench_start(&the_bench);
    if (first_input(&the_bench) == BENCH_ESTIMATE) {
        return estimate(the_bench.line, &the_bench.now.work);
    }
    bench_loop(&the_bench);
}
