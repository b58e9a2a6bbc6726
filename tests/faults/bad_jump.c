/* expect: jump to|jump out of the program|bad state */
#include "../../firmware/board/board.h"

int main(void)
{
    volatile uintptr_t address = 0x70000000u;   /* even as well: not Thumb */

    ((void (*)(void))address)();
    return 0;
}
