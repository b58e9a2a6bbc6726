/* common.c - the parts of a board that no board has to write: text, measurement, stack paint, the fault line. */
#include "fault.h"

#define PAINT 0x5AFE5AFEu

void board_text(const char *text)
{
    while (*text != '\0') {
        board_write((uint8_t)*text++);
    }
}

void board_hex(uint32_t value)
{
    for (int shift = 28; shift >= 0; shift -= 4) {
        board_write((uint8_t)"0123456789abcdef"[(value >> shift) & 15u]);
    }
}

void board_decimal(uint32_t value)
{
    char digits[11] = {0};   /* 2^32 has ten digits */
    int at = 10;

    do {
        digits[--at] = (char)('0' + value % 10u);
        value /= 10u;
    } while (value != 0);
    board_text(digits + at);
}

/* Emulator: one instruction is 2^shift ns, so counts / (2^shift ns * BOARD_COUNT_HZ), rounded to the nearest because
 * each reading is rounded down to a whole count, and every target's instruction is at least one count long. */
static uint32_t instructions(uint32_t counts)
{
    const uint64_t counts_per_G = (uint64_t)BOARD_COUNT_HZ << BOARD_ICOUNT_SHIFT;

    return (uint32_t)(((uint64_t)counts * 1000000000u + counts_per_G / 2) / counts_per_G);
}

uint32_t board_measure_start(void)
{
    board_quiet(1);
    return board_count();
}

uint32_t board_measure_end(uint32_t start)
{
    const uint32_t counts = board_count() - start;

    board_quiet(0);
    return board_counts_cycles() ? counts : instructions(counts);
}

const uint8_t *board_image(uint32_t *size)
{
    *size = (uint32_t)((uintptr_t)image_end - (uintptr_t)image_start);
    return image_start;
}

uint32_t stack_used(void)
{
    const volatile uint32_t *word = stack_base;

    while (word < stack_top && *word == PAINT) {
        word++;
    }
    return (uint32_t)((uintptr_t)stack_top - (uintptr_t)word);
}

uint32_t stack_size(void) { return (uint32_t)((uintptr_t)stack_top - (uintptr_t)stack_base); }

int stack_overrun(uintptr_t address)
{
    return address < (uintptr_t)stack_base && address >= (uintptr_t)stack_base - 0x10000u;
}

void start_memory(void)
{
    volatile uint32_t here = 0;   /* its address stands for the stack pointer */
    uint32_t *stop = (uint32_t *)(uintptr_t)((uintptr_t)&here - 64u);
    const uint32_t *from = data_load;

    for (volatile uint32_t *word = stack_base; word < stop; word++) {
        *word = PAINT;
    }
    for (uint32_t *to = data_start; to < data_end; to++) {
        *to = *from++;
    }
    for (uint32_t *to = bss_start; to < bss_end; to++) {
        *to = 0;
    }
}

static void item(const char *name, uint32_t value)
{
    if (value == FAULT_UNKNOWN) {
        return;
    }
    board_text(name);
    board_hex(value);
}

_Noreturn void fault_end(const struct fault *fault)
{
    board_text("\nfault: ");
    board_text(fault->name);
    item(", pc ", fault->pc);
    item(", from ", fault->from);
    item(", address ", fault->address);
    item(fault->status, fault->cause);
    board_text("\n");
    board_exit(BOARD_FAULT);
}
