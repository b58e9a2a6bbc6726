/* board.c - STM32F405 (Cortex-M4F, 168 MHz, 1 MB flash, 128 KB RAM besides 64 KB CCM, which is not used).
 *
 * Facts from ST's reference manual RM0090 (RCC, PWR, FLASH, GPIO, USART, TIM2-5) and the data sheet of the STM32F405.
 * An 8 MHz crystal is expected and not required: without it the PLL runs from the internal 16 MHz (1 %, good enough for
 * the UART); if the PLL does not lock either, the core stays on 16 MHz. UART: USART1, PA9 out, PA10 in, 115200 8N1.
 */
#include "../cortexm/core.h"

#define RCC_CR      REG(0x40023800)
#define RCC_PLLCFGR REG(0x40023804)
#define RCC_CFGR    REG(0x40023808)
#define RCC_AHB1ENR REG(0x40023830)
#define RCC_APB1ENR REG(0x40023840)
#define RCC_APB2ENR REG(0x40023844)
#define PWR_CR      REG(0x40007000)
#define FLASH_ACR   REG(0x40023C00)
#define GPIOA_MODER REG(0x40020000)
#define GPIOA_PUPDR REG(0x4002000C)
#define GPIOA_AFRH  REG(0x40020024)
#define USART1_SR   REG(0x40011000)
#define USART1_DR   REG(0x40011004)
#define USART1_BRR  REG(0x40011008)
#define USART1_CR1  REG(0x4001100C)
#define IWDG_KR     REG(0x40003000)
#define IWDG_PR     REG(0x40003004)
#define IWDG_RLR    REG(0x40003008)
#define DBG_FREEZE  REG(0xE0042008)   /* DBGMCU_APB1_FZ: bit 12 stops the IWDG while a debugger holds the core */
#define TIM2_CR1    REG(0x40000000)
#define TIM2_EGR    REG(0x40000014)
#define TIM2_CNT    REG(0x40000024)
#define TIM2_ARR    REG(0x4000002C)

#define HSI_HZ 16000000u
#define PLL_HZ 168000000u
#define CR_HSEON   (1u << 16)
#define CR_HSERDY  (1u << 17)
#define CR_PLLON   (1u << 24)
#define CR_PLLRDY  (1u << 25)
#define PLL_FROM_HSE (1u << 22)

/* Open a clock gate; the device answers two cycles later, and the read takes longer. */
static void clock_on(volatile uint32_t *gate, uint32_t bit)
{
    *gate |= bit;
    (void)*gate;
}

/* Wait for a bit of RCC_CR: crystal 2 ms, PLL 0.3 ms; this many polls take at least 20 ms at 16 MHz. */
static int ready(uint32_t bit)
{
    for (uint32_t polls = 0; polls < 50000; polls++) {
        if ((RCC_CR & bit) != 0) {
            return 1;
        }
    }
    return 0;
}

/* VCO = source / M * 336 = 336 MHz, core = VCO / 2, USB = VCO / 7. */
static int start_pll(void)
{
    RCC_CR |= CR_HSEON;
    RCC_PLLCFGR = ready(CR_HSERDY) ? PLL_FROM_HSE | 7u << 24 | 336u << 6 | 8u
                                   : 7u << 24 | 336u << 6 | 16u;
    RCC_CR |= CR_PLLON;
    return ready(CR_PLLRDY);
}

/* Returns the core clock [Hz]. 168 MHz at 3.3 V needs 5 wait states before the switch, regulator scale 1 (the reset
 * value, set again), APB1 at most 42 MHz, APB2 at most 84 MHz. RCC_CR of a real part is never 0: HSI is on after reset.
 * The emulator's is, and its core clock is fixed at 168 MHz. */
static uint32_t start_clock(void)
{
    if (RCC_CR == 0) {
        return PLL_HZ;
    }
    clock_on(&RCC_APB1ENR, 1u << 28);   /* PWR */
    PWR_CR |= 1u << 14;
    if (!start_pll()) {
        return HSI_HZ;
    }
    FLASH_ACR = 7u << 8 | 5u;   /* prefetch, instruction and data cache, 5 wait states; in force once it reads back */
    (void)FLASH_ACR;
    RCC_CFGR = 4u << 13 | 5u << 10;   /* APB2 / 2, APB1 / 4, AHB / 1 */
    RCC_CFGR |= 2u;
    for (uint32_t polls = 0; polls < 50000 && (RCC_CFGR & 12u) != 8u; polls++) {
    }
    return PLL_HZ;
}

static void start_uart(uint32_t apb2_hz)
{
    clock_on(&RCC_AHB1ENR, 1u);        /* GPIOA */
    clock_on(&RCC_APB2ENR, 1u << 4);   /* USART1 */
    GPIOA_MODER = (GPIOA_MODER & ~(15u << 18)) | 10u << 18;      /* PA9, PA10: alternate function */
    GPIOA_AFRH = (GPIOA_AFRH & ~(0xFFu << 4)) | 0x77u << 4;      /* AF7 */
    GPIOA_PUPDR = (GPIOA_PUPDR & ~(3u << 20)) | 1u << 20;        /* an open input must not look like a start bit */
    USART1_BRR = (apb2_hz + 57600u) / 115200u;
    USART1_CR1 = 1u << 13 | 1u << 5 | 1u << 3 | 1u << 2;         /* on, interrupt on receive, transmit, receive */
    interrupt_on(37);
}

/* TIM2 for the emulator, where it counts ns; on silicon CYCCNT runs and TIM2 is not read. */
static void start_counter(void)
{
    clock_on(&RCC_APB1ENR, 1u);
    TIM2_ARR = 0xFFFFFFFFu;
    TIM2_EGR = 1;
    TIM2_CR1 = 1;
    cycles_start();
}

void board_init(void)
{
    uint32_t hz = start_clock();

    start_uart(hz == PLL_HZ ? hz / 2u : hz);
    start_counter();
    tick_start(hz);
}

/* Reading SR, then DR, clears both the byte (bit 5) and an overrun (bit 3), which would interrupt for ever. */
void board_interrupt(void)
{
    uint32_t status = USART1_SR, byte = USART1_DR;

    if ((status & (1u << 5)) != 0) {
        received((uint8_t)byte);
    }
}

int board_ready(void) { return (USART1_SR & (1u << 7)) != 0; }

void board_write(uint8_t byte)
{
    for (uint32_t polls = 0; polls < BOARD_POLLS; polls++) {
        if (board_ready()) {
            USART1_DR = byte;
            return;
        }
    }
}

uint32_t board_count(void) { return board_counts_cycles() ? DWT_CYCCNT : TIM2_CNT; }

/* The independent watchdog runs from its own oscillator, 17..47 kHz: 32 kHz / 64, 250 counts, 0.34 to 0.94 s. Never in the
 * emulator, which RCC_CR tells. */
int hardware_watchdog(int start)
{
    if (RCC_CR == 0) {
        return 0;
    }
    if (start) {
        DBG_FREEZE |= 1u << 12;
        IWDG_KR = 0xCCCC;
        IWDG_KR = 0x5555;
        IWDG_PR = 4;
        IWDG_RLR = 250;
    }
    IWDG_KR = 0xAAAA;
    return 1;
}
