/* expect: status 3 */
#include "../../firmware/board/board.h"

int main(void)
{
    board_text("a program that fails says so by its status\n");
    return 3;
}
