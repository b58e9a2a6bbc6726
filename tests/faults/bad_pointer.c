/* expect: access to (forbidden memory|memory that is not there)|bad memory access */
#include "../../firmware/board/board.h"

int main(void)
{
    volatile uintptr_t address = 0x70000000u;   /* no board has anything there */

    board_decimal(REG(address));
    return 0;
}
