/* board.h - what a board gives to kelly: five functions, and what its core family adds.
 *
 * Start-up (cortexm/, riscv/) paints the stack, fills .data and .bss, switches the FPU on, calls board_init, then main,
 * then board_exit with main's value. A fault says its name over the UART and ends with BOARD_FAULT: nothing hangs.
 * No heap, no libc. Stack and fault stack are reserved by linker/sections.ld.
 */
#ifndef KELLY_BOARD_H
#define KELLY_BOARD_H

#include <stdint.h>

#define REG(address) (*(volatile uint32_t *)(uintptr_t)(address))

/* Polls of a status bit before giving up: some 1 s on silicon, more than any emulator needs. No wait is unbounded. */
#define BOARD_POLLS (1UL << 24)

/* Exit status of every fault, so that a runner can tell it from a failed check (1). */
#define BOARD_FAULT 70

/* ---- The five, in firmware/board/NAME/ ---- */

/* Clocks, pins, UART at 115200 8N1, tick and counter. */
void board_init(void);

/* Send one byte; waits for the transmitter, at most BOARD_POLLS (then the byte is lost). */
void board_write(uint8_t byte);

/* The next received byte, -1 when there is none. Does not wait. Received bytes are kept while the program computes (256 on
 * Cortex-M, 16 on virt), but not while interrupts are held. Wait for one with board_idle, not by spinning. */
int board_read(void);

/* Time since board_init [ms], wraps after 49 days. */
uint32_t board_ticks(void);

/* Free-running, wraps at 2^32. CPU cycles on silicon (DWT CYCCNT, mcycle). In the emulator, where no cycle counter
 * runs, a timer of BOARD_COUNT_HZ on the emulator's clock, which `-icount shift=S` ties to the instructions: one
 * instruction is 2^S ns. Without -icount it shows host time and means nothing. */
uint32_t board_count(void);

/* ---- Of the core family ---- */

/* End the program: exit status of the emulator, or of a debugger that listens; on a part alone the core sleeps. */
_Noreturn void board_exit(int status);

/* Sleep until the next tick or interrupt. */
void board_idle(void);

/* Hold interrupts (1) or let them in (0), so that a measured stretch counts only its own instructions. */
void board_quiet(int quiet);

/* 1 when board_count counts CPU cycles, 0 when it is an emulator's timer (see board_count). */
int board_counts_cycles(void);

/* ---- Common to all, firmware/board/common.c ---- */

/* Cost of work(of), the call included, interrupts held: exact instructions in an emulator run with the target's own
 * ICOUNT option (the same number every run; below 2^32 counts), CPU cycles on silicon. */
uint32_t board_measure(void (*work)(void *), void *of);

/* High-water mark and size of the stack [bytes]; the mark can only err low, by values that equal the paint. */
uint32_t stack_used(void);
uint32_t stack_size(void);

/* Plain text, eight hex digits, decimal. */
void board_text(const char *text);
void board_hex(uint32_t value);
void board_decimal(uint32_t value);

int main(void);

#endif
