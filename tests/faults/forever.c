/* expect: time-out */
#include "../../firmware/board/board.h"

int main(void)
{
    board_text("for ever\n");
    for (;;)
        (void)board_ticks();
}
