/* expect: division by zero */
#include "../../firmware/board/board.h"

int main(void)
{
    volatile uint64_t zero = 0, one = 1;

    board_decimal((uint32_t)(one / zero));
    return 0;
}
