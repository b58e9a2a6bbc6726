/* core.h - registers of the Cortex-M core that kelly uses (Arm v6-M, v7-M, v8-M architecture manuals). */
#ifndef KELLY_CORE_H
#define KELLY_CORE_H

#include "../fault.h"

#define SYST_CSR   REG(0xE000E010)   /* SysTick: control, reload, value */
#define SYST_RVR   REG(0xE000E014)
#define SYST_CVR   REG(0xE000E018)
#define NVIC_ISER  ((volatile uint32_t *)0xE000E100)   /* enable interrupt n: bit n % 32 of word n / 32 */
#define SCB_VTOR   REG(0xE000ED08)
#define SCB_CCR    REG(0xE000ED14)
#define SCB_SHCSR  REG(0xE000ED24)
#define SCB_CFSR   REG(0xE000ED28)   /* what kind of MemManage, BusFault or UsageFault */
#define SCB_HFSR   REG(0xE000ED2C)
#define SCB_MMFAR  REG(0xE000ED34)
#define SCB_BFAR   REG(0xE000ED38)
#define SCB_CPACR  REG(0xE000ED88)
#define MPU_TYPE   REG(0xE000ED90)
#define MPU_CTRL   REG(0xE000ED94)
#define MPU_RNR    REG(0xE000ED98)
#define MPU_RBAR   REG(0xE000ED9C)
#define MPU_RASR   REG(0xE000EDA0)   /* v7-M; in v8-M this is RLAR, the end of the region */
#define MPU_MAIR0  REG(0xE000EDC0)
#define DHCSR      REG(0xE000EDF0)   /* bit 0: a debugger is attached */
#define DEMCR      REG(0xE000EDFC)
#define SFSR       REG(0xE000EDE4)   /* SecureFault, v8-M */
#define MVFR0      REG(0xE000EF40)   /* what the FPU can do */
#define DWT_CTRL   REG(0xE0001000)
#define DWT_CYCCNT REG(0xE0001004)

#if defined(__ARM_ARCH_6M__)
#define CORE_V6M 1   /* no MPU, no fault status, one fault: HardFault */
#else
#define CORE_V6M 0
#endif
#define CORE_V8M (__ARM_ARCH >= 8)   /* stack limit registers, another MPU */

/* Set by linker/NAME.ld from its MEMORY. */
extern const uint32_t rom_start[], rom_size[], ram_start[], ram_size[];

extern const uintptr_t vectors[64];

_Noreturn void reset(void);
_Noreturn void cortexm_start(void);
_Noreturn void fault_report(const uint32_t *frame, uint32_t exc_return);
void fault_entry(void);
_Noreturn void unexpected_interrupt(void);
_Noreturn void __aeabi_idiv0(void);
_Noreturn void __aeabi_ldiv0(void);

/* Forbid everything but code, RAM and devices; nothing on a core without an MPU. */
void protect_memory(void);

/* Until an interrupt is pending, let in or not. */
void core_sleep(void);

/* Traps and the FPU of this image; says so and ends where the core lacks the FPU that the image was built for. */
void enable_faults(void);
void check_fpu(void);

/* SysTick at 1 kHz from a core clock of hz; a board without SysTick calls tick() itself once a millisecond. */
void tick_start(uint32_t hz);
void tick(void);
void tick_interrupt(void);

/* [us] of the present tick that have passed, 0..999; SysTick's, or the board's own. */
uint32_t tick_micros(void);

/* Called by each tick. */
void watchdog_tick(void);

/* A watchdog of the part: start it (1) or kick it (0; no effect before). 0 where there is none, as long as no board says otherwise. */
int hardware_watchdog(int start);

/* Start DWT CYCCNT; afterwards board_counts_cycles() tells whether it runs. */
void cycles_start(void);

/* A byte from the UART's interrupt, for board_read. Interrupts are of one priority: they do not nest. */
void received(uint8_t byte);

/* Let device interrupt 0..47 in. */
void interrupt_on(uint32_t number);

/* All device interrupts; each board defines it. */
void board_interrupt(void);

#endif
