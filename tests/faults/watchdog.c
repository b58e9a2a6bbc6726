/* expect: watchdog: no checked step in time, ms 00000032
 * The first kicks come in time, then a step is wedged.
 * skip: riscv (no interrupt is on there: nothing watches) */
#include "../../firmware/board/board.h"

static volatile uint32_t wedged = 1;

int main(void)
{
    watchdog_start(50);
    for (uint32_t k = 0; k < 100; k++) {
        uint32_t start = board_ticks();

        while (board_ticks() - start < 2)
            board_idle();
        watchdog_kick();
    }
    board_text("kicked\n");
    while (wedged)
        ;
    return 0;
}
