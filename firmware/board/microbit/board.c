/* board.c - BBC micro:bit, version 1 (nRF51822: Cortex-M0, 16 MHz, 256 KB flash, 16 KB RAM, no SysTick, no cycle counter).
 *
 * Facts from Nordic's nRF51 Series Reference Manual (CLOCK, GPIO, UART, TIMER) and the micro:bit schematic: P0.24 out,
 * P0.25 in, to the interface chip's USB serial port. TIMER0, the only one with 32 bits, counts the 16 MHz of the core;
 * TIMER1 gives the tick.
 */
#include "../cortexm/core.h"

#define CLOCK_HFCLKSTART   REG(0x40000000)
#define CLOCK_HFCLKSTARTED REG(0x40000100)
#define GPIO_OUTSET        REG(0x50000508)
#define GPIO_DIRSET        REG(0x50000518)
#define UART(offset)   REG(0x40002000u + (offset))
#define TIMER0(offset) REG(0x40008000u + (offset))
#define TIMER1(offset) REG(0x40009000u + (offset))
enum { TX_PIN = 24, RX_PIN = 25 };

/* Both timers and the UART want the crystal; it takes 1 ms. Its absence costs accuracy only. */
static void start_clock(void)
{
    CLOCK_HFCLKSTART = 1;
    for (uint32_t polls = 0; polls < 50000 && CLOCK_HFCLKSTARTED == 0; polls++) {
    }
}

static void start_uart(void)
{
    GPIO_OUTSET = 1u << TX_PIN;       /* idle is high */
    GPIO_DIRSET = 1u << TX_PIN;
    UART(0x50C) = TX_PIN;
    UART(0x514) = RX_PIN;
    UART(0x524) = 0x01D7E000;         /* 115200 */
    UART(0x500) = 4;
    UART(0x304) = 1u << 2;            /* interrupt at RXDRDY */
    UART(0x008) = 1;                  /* STARTTX, STARTRX */
    UART(0x000) = 1;
    interrupt_on(2);
}

static void start_timers(void)
{
    TIMER0(0x508) = 3;                /* 32 bits */
    TIMER0(0x510) = 0;                /* 16 MHz */
    TIMER0(0x000) = 1;
    TIMER1(0x508) = 0;                /* 16 bits */
    TIMER1(0x510) = 4;                /* 1 MHz */
    TIMER1(0x540) = 1000;
    TIMER1(0x200) = 1;                /* clear at compare 0 */
    TIMER1(0x304) = 1u << 16;         /* interrupt at compare 0 */
    TIMER1(0x000) = 1;
    interrupt_on(9);
}

void board_init(void)
{
    start_clock();
    start_uart();
    start_timers();
}

void board_interrupt(void)
{
    if (TIMER1(0x140) != 0) {
        TIMER1(0x140) = 0;
        tick();
    }
    if (UART(0x108) != 0) {
        UART(0x108) = 0;              /* before the byte is taken: the next one may be behind it */
        received((uint8_t)UART(0x518));
    }
}

/* The UART announces the byte that has left (TXDRDY), not room for the next one: none is on its way after reset. */
static int sending;

int board_ready(void) { return !sending || UART(0x11C) != 0; }

void board_write(uint8_t byte)
{
    for (uint32_t polls = 0; polls < BOARD_POLLS && !board_ready(); polls++) {
    }
    UART(0x11C) = 0;
    UART(0x51C) = byte;
    sending = 1;
}

/* TIMER1 counts the microseconds of a tick: capture into CC[1]. */
uint32_t tick_micros(void)
{
    TIMER1(0x044) = 1;
    return TIMER1(0x544);
}

uint32_t board_count(void)
{
    TIMER0(0x040) = 1;                /* capture into CC[0] */
    return TIMER0(0x540);
}
