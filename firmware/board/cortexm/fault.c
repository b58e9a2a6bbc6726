/* fault.c - gives every fault of a Cortex-M a name, and forbids the memory that nobody should touch. */
#include "core.h"

extern const uint16_t exit_breakpoint[];

/* The stack may be the very thing that broke: take the one kept for faults before anything is pushed. */
__attribute__((naked, section(".start"))) void fault_entry(void)
{
    __asm volatile(
        "mrs r0, msp\n"
        "mov r1, lr\n"
#if CORE_V8M
        "mov r2, #0\n"
        "msr msplim, r2\n"
#endif
        "ldr r2, =fault_stack_top\n"
        "mov sp, r2\n"
        "ldr r2, =fault_report\n"
        "bx r2\n"
        ".ltorg\n");
}

static _Noreturn void fault_named(const char *name, const void *from)
{
    fault_end(&(struct fault){name, FAULT_UNKNOWN, (uint32_t)(uintptr_t)from, FAULT_UNKNOWN, "", FAULT_UNKNOWN});
}

_Noreturn void unexpected_interrupt(void)
{
    uint32_t number;

    __asm volatile("mrs %0, ipsr" : "=r"(number));
    fault_end(&(struct fault){"unexpected interrupt", FAULT_UNKNOWN, FAULT_UNKNOWN, FAULT_UNKNOWN, ", number ", number});
}

/* Where there is no divide instruction, libgcc calls these. */
_Noreturn void __aeabi_idiv0(void) { fault_named("division by zero", __builtin_return_address(0)); }
_Noreturn void __aeabi_ldiv0(void) { fault_named("division by zero", __builtin_return_address(0)); }

/* An exception frame (r0-r3, r12, lr, pc, xPSR) was stored only if it lies wholly on the stack. */
static int frame_stored(const uint32_t *frame) { return frame > stack_base && frame + 8 <= stack_top; }

#if CORE_V6M
/* The M0 only says HardFault; the instruction that failed tells the rest. */
static const char *fault_name(const uint32_t *frame)
{
    uint32_t pc = frame[6], rom = (uint32_t)(uintptr_t)rom_start;

    if ((frame[7] & (1u << 24)) == 0) {
        return "bad state: jump to an even address";
    }
    if (pc - rom >= (uint32_t)(uintptr_t)rom_size) {
        return "jump out of the program";
    }
    if ((*(const uint16_t *)(uintptr_t)pc & 0xFF00u) == 0xDE00u) {
        return "undefined instruction";
    }
    return "bad memory access";
}

_Noreturn void fault_report(const uint32_t *frame, uint32_t exc_return)
{
    struct fault fault = {"stack overflow", FAULT_UNKNOWN, FAULT_UNKNOWN, FAULT_UNKNOWN, ", HardFault, exc_return ", exc_return};

    if (frame_stored(frame)) {
        fault.pc = frame[6];
        fault.from = frame[5];
        if (frame[6] == (uint32_t)(uintptr_t)exit_breakpoint) {
            for (;;) {   /* the program had ended, and no debugger was there to hear it */
                core_sleep();
            }
        }
        if ((uintptr_t)frame >= (uintptr_t)stack_base + STACK_EDGE) {
            fault.name = fault_name(frame);
        }
    }
    fault_end(&fault);
}

void enable_faults(void) {}
void protect_memory(void) {}
void board_vectors(int readable) { (void)readable; }

#else
/* CFSR: MemManage in bits 0-7, BusFault 8-15, UsageFault 16-31. The first match is the cause, the rest follows from it. */
static const struct { uint32_t bits; const char *name; } names[] = {
    {1u << 25, "division by zero"},
    {1u << 24, "unaligned access"},
    {1u << 20, "stack overflow"},
    {1u << 19, "no coprocessor: the image uses an FPU that is off or missing"},
    {1u << 18, "bad state: wrong return from an exception"},
    {1u << 17, "bad state: jump to an even address"},
    {1u << 16, "undefined instruction"},
    {1u << 0, "jump to forbidden memory"},
    {1u << 1, "access to forbidden memory"},
    {1u << 8, "jump to memory that is not there"},
    {3u << 9, "access to memory that is not there"},
    {0xFFFFFFFFu, "stacking for an exception"},
};

static const char *fault_name(uint32_t cfsr)
{
    for (unsigned i = 0; i < sizeof names / sizeof names[0]; i++) {
        if ((cfsr & names[i].bits) != 0) {
            return names[i].name;
        }
    }
    if ((SCB_HFSR & 2u) != 0) {
        return "HardFault: vector table not readable";
    }
    return CORE_V8M && SFSR != 0 ? "SecureFault" : "HardFault";
}

static uint32_t fault_address(uint32_t cfsr)
{
    if ((cfsr & (1u << 7)) != 0) {
        return SCB_MMFAR;
    }
    return (cfsr & (1u << 15)) != 0 ? SCB_BFAR : FAULT_UNKNOWN;
}

/* MSTKERR and STKERR say that not even the exception frame found room; near the edge an access below it says the same. */
static int overflowed(const uint32_t *frame, uint32_t cfsr, uint32_t address)
{
    return (uintptr_t)frame <= (uintptr_t)stack_base || (cfsr & (1u << 4 | 1u << 12 | 1u << 20)) != 0
        || ((uintptr_t)frame < (uintptr_t)stack_base + STACK_EDGE && stack_overrun(address));
}

_Noreturn void fault_report(const uint32_t *frame, uint32_t exc_return)
{
    uint32_t cfsr = SCB_CFSR, address = fault_address(cfsr);
    struct fault fault = {fault_name(cfsr), FAULT_UNKNOWN, FAULT_UNKNOWN, address, ", CFSR ", cfsr};

    (void)exc_return;
    if (frame_stored(frame) && (cfsr & (1u << 4 | 1u << 12)) == 0) {
        fault.pc = frame[6];
        fault.from = frame[5];
    }
    if (overflowed(frame, cfsr, address)) {
        fault.name = "stack overflow";
    }
    fault_end(&fault);
}

/* Own handlers for MemManage, BusFault, UsageFault and, on v8-M, SecureFault; integer division by zero traps. */
void enable_faults(void)
{
    SCB_SHCSR |= (CORE_V8M ? 15u : 7u) << 16;
    SCB_CCR |= 1u << 4;
    __asm volatile("dsb\nisb" ::: "memory");
}
#endif

/* An image with hard floats on a core without: CPACR keeps no bits. Double instructions: MVFR0 bits 8-11. */
void check_fpu(void)
{
#ifdef __ARM_FP
    if ((SCB_CPACR & (15u << 20)) != (15u << 20)) {
        fault_named("wrong FPU: the image needs one, this core has none", 0);
    }
#if __ARM_FP & 8
    if ((MVFR0 & (15u << 8)) == 0) {
        fault_named("wrong FPU: the image needs double precision, this core has single", 0);
    }
#endif
#endif
}
