/* expect: stack overflow */
#include "../../firmware/board/board.h"

static volatile uint32_t enough = 0xFFFFFFFFu;   /* a compiler refuses recursion that it can see has no end */

/* A large frame: the end of the stack is jumped over. */
static __attribute__((noinline)) uint32_t deeper(uint32_t n)
{
    volatile uint32_t here[500];

    here[n % 500] = n;
    return n == enough ? 0 : deeper(n + 1) + here[n % 500];
}

int main(void)
{
    board_decimal(deeper(0));
    return 0;
}
