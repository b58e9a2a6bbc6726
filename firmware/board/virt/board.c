/* board.c - the `virt` machine of qemu-system-riscv32 and -riscv64: 16550 UART, CLINT timer at 10 MHz, test finisher. */
#include "../riscv/core.h"

#define FINISHER REG(0x00100000)
#define MTIMECMP_LOW  REG(0x02004000)
#define MTIMECMP_HIGH REG(0x02004004)
#define MTIME_LOW     REG(0x0200BFF8)
#define MTIME_HIGH    REG(0x0200BFFC)
#define UART(offset) (*(volatile uint8_t *)(uintptr_t)(0x10000000u + (offset)))
#define PLIC_PRIORITY(n) REG(0x0C000000 + 4 * (n))
#define PLIC_ENABLE   REG(0x0C002000)   /* of hart 0 in machine mode, and so below */
#define PLIC_CLAIM    REG(0x0C200004)
enum { MTIME_PER_MS = 10000, UART_IRQ = 10 };

static uint64_t start;

/* The high half may step between the two reads: read it again. */
static uint64_t mtime(void)
{
    uint32_t high, low;

    do {
        high = MTIME_HIGH;
        low = MTIME_LOW;
    } while (high != MTIME_HIGH);
    return (uint64_t)high << 32 | low;
}

void board_init(void)
{
    UART(3) = 0x83;   /* divisor latch: 1 = 115200 at the classic 1.8432 MHz */
    UART(0) = 1;
    UART(1) = 0;
    UART(3) = 3;      /* 8N1 */
    UART(2) = 0xC7;   /* FIFO on and emptied, 14 bytes */
    UART(1) = 1;      /* says when a byte has come, to end a sleep: interrupts never trap here */
    PLIC_PRIORITY(UART_IRQ) = 1;
    PLIC_ENABLE = 1u << UART_IRQ;
    start = mtime();
}

int board_ready(void) { return (UART(5) & 0x20u) != 0; }

void board_write(uint8_t byte)
{
    for (uint32_t polls = 0; polls < BOARD_POLLS; polls++) {
        if (board_ready()) {
            UART(0) = byte;
            return;
        }
    }
}

/* The FIFO holds 16 bytes, more than come at 115200 in the tick that board_idle may sleep. */
int board_read(void) { return (UART(5) & 1u) != 0 ? (int)UART(0) : -1; }
uint32_t board_ticks(void) { return (uint32_t)((mtime() - start) / MTIME_PER_MS); }
uint32_t board_micros(void) { return (uint32_t)((mtime() - start) / (MTIME_PER_MS / 1000)); }

/* mcycle: under -icount shift=0 exactly the instructions. */
uint32_t board_count(void)
{
    uintptr_t cycles;

    __asm volatile("csrr %0, mcycle" : "=r"(cycles));
    return (uint32_t)cycles;
}

/* The timer and the UART wake wfi by being pending; they never trap, because interrupts stay off. What was pending is claimed
 * and given back, or the next sleep would end at once; a byte that is not read makes it so. The tick that is waited for is the
 * one behind that in which the last sleep ended: if it has come meanwhile, this one ends at once. */
void board_idle(void)
{
    static uint64_t seen;
    const uint64_t next = start + (seen + 1u) * MTIME_PER_MS;

    MTIMECMP_HIGH = 0xFFFFFFFFu;   /* no false match between the two writes */
    MTIMECMP_LOW = (uint32_t)next;
    MTIMECMP_HIGH = (uint32_t)(next >> 32);
    __asm volatile("csrs mie, %0\nwfi" ::"r"(1u << 7 | 1u << 11) : "memory");
    PLIC_CLAIM = PLIC_CLAIM;
    seen = (mtime() - start) / MTIME_PER_MS;
}

_Noreturn void board_exit(int status)
{
    FINISHER = status == 0 ? 0x5555u : (uint32_t)status << 16 | 0x3333u;
    for (;;) {
        __asm volatile("wfi");
    }
}
