/* expect: no coprocessor|undefined instruction
 * skip: soft (no FPU instruction in the image) */
#include "../../firmware/board/board.h"

int main(void)
{
    volatile float x = 1.0f;

#ifdef __riscv
    __asm volatile("csrc mstatus, %0" ::"r"(0x6000));
#else
    REG(0xE000ED88) = 0;
    __asm volatile("dsb\nisb");
#endif
    x = x * x;
    return 0;
}
