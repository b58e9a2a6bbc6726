/* on_target.c - where the checks print on a board. */
#include "../firmware/board/board.h"
#include "check.h"

void check_put(char c) { board_write((uint8_t)c); }
