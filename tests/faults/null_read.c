/* expect: access to (forbidden memory|memory that is not there)
 * skip: microbit (no MPU, and address 0 is flash) */
#include "../../firmware/board/board.h"

int main(void)
{
    uint32_t *volatile nowhere = 0;

    board_decimal(nowhere[1]);
    return 0;
}
