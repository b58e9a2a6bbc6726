/* watchdog.c - the tick interrupt watches the program, and a timer of the part, where there is one, watches the tick.
 *
 * The program kicks (board.h); each tick counts down and ends the program at 0. A hardware watchdog cannot be stopped once it
 * runs, so it is the tick that kicks it: always while nothing is asked of the program, else as long as the program kicks. It
 * bites where even interrupts are dead, and after the fault line, when the core sleeps: the board starts anew.
 */
#include "core.h"

static volatile uint32_t limit, left;   /* [ms] */

__attribute__((weak)) int hardware_watchdog(int start)
{
    (void)start;
    return 0;
}

int board_watchdog(void) { return hardware_watchdog(0) ? 2 : 1; }

void watchdog_start(uint32_t ms)
{
    left = ms;
    limit = ms;
    (void)hardware_watchdog(1);
}

void watchdog_kick(void) { left = limit; }
void watchdog_stop(void) { limit = 0; }

void watchdog_tick(void)
{
    if (limit != 0) {
        if (left == 0) {
            fault_end(&(struct fault){"watchdog: no checked step in time, ms", FAULT_UNKNOWN, FAULT_UNKNOWN, FAULT_UNKNOWN, " ", limit});
        }
        left--;
    }
    (void)hardware_watchdog(0);
}
