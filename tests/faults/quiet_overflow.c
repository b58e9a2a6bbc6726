/* expect: stack overflow
 * Interrupts held: the fault becomes a HardFault. */
#include "../../firmware/board/board.h"

static volatile uint32_t enough = 0xFFFFFFFFu;   /* a compiler refuses recursion that it can see has no end */

/* Small frames: the end of the stack is met by a push. */
static __attribute__((noinline)) uint32_t deeper(uint32_t n)
{
    volatile uint32_t here = n;

    return n == enough ? 0 : deeper(here + 1) + here;
}

int main(void)
{
    board_quiet(1);
    board_decimal(deeper(0));
    return 0;
}
