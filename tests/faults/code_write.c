/* expect: access to (forbidden memory|memory that is not there)
 * skip: microbit (no MPU, and the emulator drops writes to flash) */
#include "../../firmware/board/board.h"

int main(void)
{
    REG((uintptr_t)main & ~(uintptr_t)3) = 0;
    return 0;
}
