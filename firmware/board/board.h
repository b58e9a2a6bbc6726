/* board.h - what a board gives to kelly: six functions, and what its core family adds.
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

/* ---- The six, in firmware/board/NAME/ ---- */

/* Clocks, pins, UART at 115200 8N1, tick and counter. */
void board_init(void);

/* Send one byte; waits for the transmitter, at most BOARD_POLLS (then the byte is lost). */
void board_write(uint8_t byte);

/* 1 when board_write would not wait: for a program that has no time to. */
int board_ready(void);

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

/* Sleep until the next tick or interrupt; not at all if one has come since this returned last. So nothing that is looked for
 * between two calls is slept over. */
void board_idle(void);

/* Time since board_init [us], by the clock of the tick: a multiple of 1000 when the tick comes. Wraps after 71 minutes. */
uint32_t board_micros(void);

/* Hold interrupts (1) or let them in (0), so that a measured stretch counts only its own instructions. */
void board_quiet(int quiet);

/* 1 when board_count counts CPU cycles, 0 when it is an emulator's timer (see board_count). */
int board_counts_cycles(void);

/* Let the vector table, which is hidden from a null pointer, be read (1) or hide it again (0). */
void board_vectors(int readable);

/* What watches the program: 0 nothing (RISC-V here: interrupts are never on), 1 the tick interrupt, 2 a timer of the part besides. */
int board_watchdog(void);

/* From now on watchdog_kick must come again within ms (> 0) milliseconds, or the program ends with a fault, and where the
 * part has a timer of its own, it starts anew. watchdog_stop: nothing is asked any more. No effect where nothing watches. */
void watchdog_start(uint32_t ms);
void watchdog_kick(void);
void watchdog_stop(void);

/* ---- Common to all, firmware/board/common.c ---- */

/* The stretch between start and end, which takes what start returned; interrupts are held in between. Exact instructions in an
 * emulator run with the target's own ICOUNT option (the same number every run; below 2^32 counts), CPU cycles on silicon. It
 * holds some instructions of the two calls: subtract another stretch. */
uint32_t board_measure_start(void);
uint32_t board_measure_end(uint32_t start);

/* High-water mark and size of the stack [bytes]; the mark can only err low, by values that equal the paint. */
uint32_t stack_used(void);
uint32_t stack_size(void);

/* The image as it lies in ROM, from the first byte of ROM to the last that was loaded: what the ELF file's segments hold by
 * physical address. To read its beginning, see board_vectors. */
const uint8_t *board_image(uint32_t *size);

/* Plain text, eight hex digits, decimal. */
void board_text(const char *text);
void board_hex(uint32_t value);
void board_decimal(uint32_t value);

int main(void);

#endif
