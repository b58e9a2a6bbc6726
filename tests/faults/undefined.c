/* expect: undefined instruction */
#include "../../firmware/board/board.h"

int main(void)
{
#ifdef __riscv
    __asm volatile(".word 0");
#else
    __asm volatile("udf #0");
#endif
    return 0;
}
