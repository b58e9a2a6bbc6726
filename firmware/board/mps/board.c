/* board.c - Arm MPS2 and MPS3 FPGA boards (application notes AN385, AN386, AN500, AN505, AN547): one board, five cores.
 *
 * The addresses and the clock are what differs: device_uart (CMSDK UART), its receive interrupt and device_fpgaio come from
 * linker/NAME.ld, BOARD_CPU_HZ from linker/NAME.mk. The counter is FPGAIO's, one count a cycle of the system clock.
 */
#include "../cortexm/core.h"

extern volatile uint32_t device_uart[];     /* DATA, STATE, CTRL, INTSTATUS, BAUDDIV */
extern const uint8_t device_uart_irq[];     /* the address is the number */
extern volatile uint32_t device_fpgaio[];   /* word 6 COUNTER, word 7 PRESCALE */

void board_init(void)
{
    device_uart[4] = (BOARD_CPU_HZ + 57600u) / 115200u;
    device_uart[2] = 11;   /* transmit, receive, interrupt on receive */
    interrupt_on((uint32_t)(uintptr_t)device_uart_irq);
    device_fpgaio[7] = 0;
    cycles_start();
    tick_start(BOARD_CPU_HZ);
}

/* Clear first: a byte that comes in between interrupts again. */
void board_interrupt(void)
{
    device_uart[3] = 2;
    while ((device_uart[1] & 2u) != 0) {
        received((uint8_t)device_uart[0]);
    }
}

int board_ready(void) { return (device_uart[1] & 1u) == 0; }

void board_write(uint8_t byte)
{
    for (uint32_t polls = 0; polls < BOARD_POLLS; polls++) {
        if (board_ready()) {
            device_uart[0] = byte;
            return;
        }
    }
}

uint32_t board_count(void) { return board_counts_cycles() ? DWT_CYCCNT : device_fpgaio[6]; }
