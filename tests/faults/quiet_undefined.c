/* expect: undefined instruction
 * Interrupts held: the fault becomes a HardFault, and keeps its name. */
#include "../../firmware/board/board.h"

int main(void)
{
    board_quiet(1);
#ifdef __riscv
    __asm volatile(".word 0");
#else
    __asm volatile("udf #0");
#endif
    return 0;
}
