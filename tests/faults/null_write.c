/* expect: access to (forbidden memory|memory that is not there)
 * skip: microbit (no MPU, and the emulator drops writes to flash) */
#include "../../firmware/board/board.h"

int main(void)
{
    volatile uint32_t *volatile nowhere = 0;

    nowhere[1] = 1;
    return 0;
}
