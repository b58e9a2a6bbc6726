/* expect: division by zero */
#include "../../firmware/board/board.h"

int main(void)
{
    volatile uint32_t zero = 0, one = 1;

    board_decimal(one / zero);
    return 0;
}
