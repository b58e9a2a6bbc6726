/* start.c - reset, vector table, tick, cycle counter and end of every Cortex-M. */
#include "core.h"

/* The stack is set again, because a debugger or a boot loader may jump here with its own. The FPU comes on before any C:
 * the compiler is free to use its registers anywhere. FPSCR needs no care: the first FP instruction after reset copies
 * FPDSCR, whose reset value is IEEE (round to nearest, denormals kept). */
__attribute__((naked, section(".start"))) void reset(void)
{
    __asm volatile(
        "ldr r0, =stack_top\n"
        "msr msp, r0\n"
#if CORE_V8M
        "ldr r0, =stack_base\n"
        "msr msplim, r0\n"
#endif
#ifdef __ARM_FP
        "ldr r0, =0xE000ED88\n"
        "ldr r1, [r0]\n"
        "orr r1, r1, #0xF00000\n"
        "str r1, [r0]\n"
        "dsb\n"
        "isb\n"
#endif
        "ldr r0, =cortexm_start\n"
        "bx r0\n"
        ".ltorg\n");
}

__attribute__((section(".start"))) _Noreturn void cortexm_start(void)
{
    start_memory();
#if !CORE_V6M
    SCB_VTOR = (uint32_t)(uintptr_t)vectors;
#endif
    board_init();
    enable_faults();
    protect_memory();
    check_fpu();
    board_exit(main());
}

#define WRONG (uintptr_t)unexpected_interrupt
#define FAULT (uintptr_t)fault_entry
#define DEVICE (uintptr_t)board_interrupt
#define DEVICES_8 DEVICE, DEVICE, DEVICE, DEVICE, DEVICE, DEVICE, DEVICE, DEVICE

/* 16 of the core, 48 of devices: 256 bytes, which the MPU then hides, so that a null pointer meets nothing. */
__attribute__((section(".vectors"), used)) const uintptr_t vectors[64] = {
    (uintptr_t)stack_top, (uintptr_t)reset,
    WRONG, FAULT, FAULT, FAULT, FAULT, FAULT,       /* NMI; HardFault, MemManage, BusFault, UsageFault, SecureFault */
    WRONG, WRONG, WRONG, WRONG, WRONG, WRONG, WRONG, (uintptr_t)tick_interrupt,
    DEVICES_8, DEVICES_8, DEVICES_8, DEVICES_8, DEVICES_8, DEVICES_8,
};

static volatile uint32_t ticks;
static int counts_cycles;

void tick(void)
{
    ticks++;
    watchdog_tick();
}

void tick_interrupt(void) { tick(); }
uint32_t board_ticks(void) { return ticks; }

__attribute__((weak)) uint32_t tick_micros(void) { return (SYST_RVR - SYST_CVR) * 1000u / (SYST_RVR + 1u); }

/* A tick between the two reads: read again. */
uint32_t board_micros(void)
{
    uint32_t now, part;

    do {
        now = ticks;
        part = tick_micros();
    } while (now != ticks);
    return now * 1000u + part;
}

void tick_start(uint32_t hz)
{
    SYST_RVR = hz / 1000u - 1u;
    SYST_CVR = 0;
    SYST_CSR = 7;   /* core clock, interrupt, on */
}

/* Received bytes wait here until the program asks, so that it may compute or sleep meanwhile: 20 ms at 115200. One writer,
 * the interrupt, and one reader. Polling the UART instead would starve an emulator's other thread, which brings the bytes. */
#define RING 256u
static volatile uint8_t ring[RING];
static volatile uint32_t ring_in, ring_out;

void received(uint8_t byte)
{
    if (ring_in - ring_out == RING) {
        return;   /* nobody reads: the newest is lost */
    }
    ring[ring_in % RING] = byte;
    ring_in++;
}

int board_read(void)
{
    int byte;

    if (ring_in == ring_out) {
        return -1;
    }
    byte = ring[ring_out % RING];
    ring_out++;
    return byte;
}

void interrupt_on(uint32_t number) { NVIC_ISER[number / 32u] = 1u << number % 32u; }

/* QEMU has no DWT: CYCCNT reads 0 for ever. */
void cycles_start(void)
{
#if !CORE_V6M
    DEMCR |= 1u << 24;
    DWT_CYCCNT = 0;
    DWT_CTRL |= 1;
    counts_cycles = DWT_CYCCNT != DWT_CYCCNT;   /* two reads of a running counter differ */
#endif
}

int board_counts_cycles(void) { return counts_cycles; }
void core_sleep(void) { __asm volatile("wfi" ::: "memory"); }

void board_quiet(int quiet)
{
    if (quiet) {
        __asm volatile("cpsid i" ::: "memory");
    } else {
        __asm volatile("cpsie i" ::: "memory");
    }
}

/* Interrupts are held from the look at what has come until the core sleeps, and one that is pending ends a sleep all the same:
 * none is served in between, to be slept over. */
void board_idle(void)
{
    static uint32_t tick_seen, byte_seen;

    board_quiet(1);
    if (ticks == tick_seen && ring_in == byte_seen) {
        core_sleep();
        board_quiet(0);
        __asm volatile("isb" ::: "memory");   /* here it is served */
        board_quiet(1);
    }
    tick_seen = ticks;
    byte_seen = ring_in;
    board_quiet(0);
}

/* A breakpoint that nobody catches is a fault. Silicon shows an attached debugger in DHCSR; an emulator has no DWT. The
 * M0 can see neither from inside: there the breakpoint is tried, and fault.c knows its address. */
static int someone_listens(void)
{
#if CORE_V6M
    return 1;
#else
    return (DHCSR & 1u) != 0 || DWT_CTRL == 0;
#endif
}

/* SYS_EXIT_EXTENDED with ADP_Stopped_ApplicationExit (Arm semihosting, version 3). */
_Noreturn void board_exit(int status)
{
    const uint32_t block[2] = {0x20026, (uint32_t)status};
    register uint32_t operation __asm("r0") = 0x20;
    register const uint32_t *argument __asm("r1") = block;

    if (someone_listens()) {
        __asm volatile(".global exit_breakpoint\nexit_breakpoint: bkpt 0xAB"
                       : "+r"(operation) : "r"(argument) : "memory");
    }
    board_quiet(1);
    for (;;) {
        core_sleep();
    }
}
