/* board.h - a board for the drivers: any byte received, any time, a line that is ready or not. */
#ifndef KELLY_EVA_BOARD_H
#define KELLY_EVA_BOARD_H

#include "board/board.h"

int board_read(void) { return Frama_C_interval(-1, 255); }
int board_ready(void) { return Frama_C_interval(0, 1); }
void board_write(uint8_t byte)
{
    (void)byte;
    /*@ ghost line_count = (uint32_t)(line_count + 1); */
    /*@ ghost line_last = byte; */
}

uint32_t board_ticks(void) { return any_u32(); }
uint32_t board_micros(void) { return any_u32(); }
uint32_t board_count(void) { return any_u32(); }
int board_counts_cycles(void) { return Frama_C_interval(0, 1); }
void board_idle(void) { }
void board_vectors(int readable) { (void)readable; }
int board_watchdog(void) { return Frama_C_interval(0, 2); }
void watchdog_start(uint32_t ms) { (void)ms; }
void watchdog_kick(void) { }
void watchdog_stop(void) { }
void board_text(const char *text)
{
    while (*text != '\0') {
        board_write((uint8_t)*text++);
    }
}

#endif
