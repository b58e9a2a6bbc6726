/* mpu.c - memory that may be used, everything else forbidden: code is read only, RAM and devices do not execute, below the
 * stack (which is at the bottom of RAM) and at address 0 there is nothing. Costs no RAM and no time.
 *
 * The first 256 bytes of code are the vector table, which only the core reads, and past the MPU: where code is at address
 * 0, hiding them is what catches a null pointer.
 */
#include "core.h"

#if !CORE_V6M

#define DEVICES 0x40000000u   /* up to 0x5FFFFFFF; the core's own registers at 0xE0000000 need no region */
#define VECTORS_SIZE 256u

#if CORE_V8M
/* RBAR: base | AP << 1 | XN, AP 0 = read and write, 2 = read only. RLAR: limit | attribute << 1 | on. Regions must not
 * overlap and cannot forbid: hence the code starts after the vectors. */
static void region(uint32_t number, uint32_t base, uint32_t end, uint32_t rights, uint32_t attribute)
{
    MPU_RNR = number;
    MPU_RBAR = base | rights;
    MPU_RASR = ((end - 1u) & ~31u) | attribute << 1 | 1u;
}

static void regions(uint32_t rom, uint32_t rom_end, uint32_t ram, uint32_t ram_end)
{
    MPU_MAIR0 = 0x04FF;   /* attribute 0: normal, cached; 1: device */
    region(0, rom + VECTORS_SIZE, rom_end, 2u << 1, 0);
    region(1, ram, ram_end, 1u, 0);
    region(2, DEVICES, 0x60000000u, 1u, 1);
}
#else
/* RASR: rights and memory type above, log2(size) - 1, on. Sizes are powers of two and bases multiples of them. */
static void region(uint32_t number, uint32_t base, uint32_t end, uint32_t rights)
{
    MPU_RNR = number;
    MPU_RBAR = base;
    MPU_RASR = rights | (uint32_t)(30 - __builtin_clz(end - base)) << 1 | 1u;
}

static void regions(uint32_t rom, uint32_t rom_end, uint32_t ram, uint32_t ram_end)
{
    region(0, rom, rom_end, 0x06020000u);                   /* read only, cached */
    region(1, ram, ram_end, 0x13030000u);                   /* read and write, no code, cached */
    region(2, DEVICES, 0x60000000u, 0x13050000u);           /* the same, device */
    region(3, rom, rom + VECTORS_SIZE, 0x10000000u);        /* nothing; the highest number wins */
}
#endif

/* Region 0 begins with the vectors or behind them; region 3 hides them or is off. */
void board_vectors(int readable)
{
    const uint32_t rom = (uint32_t)(uintptr_t)rom_start, hidden = readable ? 0u : VECTORS_SIZE;

    if ((MPU_TYPE & 0xFF00u) == 0) {
        return;
    }
#if CORE_V8M
    region(0, rom + hidden, rom + (uint32_t)(uintptr_t)rom_size, 2u << 1, 0);
#else
    region(3, rom, rom + VECTORS_SIZE, 0x10000000u);
    MPU_RASR &= ~(hidden == 0u ? 1u : 0u);
#endif
    __asm volatile("dsb\nisb" ::: "memory");
}

void protect_memory(void)
{
    uint32_t rom = (uint32_t)(uintptr_t)rom_start, ram = (uint32_t)(uintptr_t)ram_start;

    if ((MPU_TYPE & 0xFF00u) == 0) {
        return;
    }
    regions(rom, rom + (uint32_t)(uintptr_t)rom_size, ram, ram + (uint32_t)(uintptr_t)ram_size);
    MPU_CTRL = 1;   /* on, without the default map; off inside HardFault, so that it can report */
    __asm volatile("dsb\nisb" ::: "memory");
}

#endif
