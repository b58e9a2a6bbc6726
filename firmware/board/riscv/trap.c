/* trap.c - rest of the start-up, memory protection and the names of the traps (RISC-V privileged architecture 1.11). */
#include "core.h"

extern const uint8_t rom_start[], rom_size[], ram_start[], ram_size[];

#define CSR_READER(name) \
    static uintptr_t read_##name(void) { uintptr_t value; __asm volatile("csrr %0, " #name : "=r"(value)); return value; }
#define CSR_WRITE(name, value) __asm volatile("csrw " name ", %0" ::"r"((uintptr_t)(value)) : "memory")

CSR_READER(mcause)
CSR_READER(mepc)
CSR_READER(mtval)

static const char *const names[] = {
    "jump to an odd address", "jump to memory that is not there or forbidden", "undefined instruction",
    "division by zero", "unaligned access", "access to memory that is not there or forbidden",
    "unaligned access", "access to memory that is not there or forbidden",
};

/* The divide instructions of RISC-V do not trap. The compiler's own check (linker/rv*.mk) ends in ebreak, and nothing
 * else in the image does. */
static const char *trap_name(uintptr_t cause, uintptr_t address, uintptr_t sp)
{
    if (sp < (uintptr_t)stack_base || (cause != 2 && cause != 3 && stack_overrun(address))) {
        return "stack overflow";
    }
    return cause < sizeof names / sizeof names[0] ? names[cause] : "unexpected trap";
}

_Noreturn void trap_report(uintptr_t sp)
{
    uintptr_t cause = read_mcause(), address = read_mtval();

    fault_end(&(struct fault){trap_name(cause, address, sp), (uint32_t)read_mepc(), FAULT_UNKNOWN,
                              (uint32_t)address, ", mcause ", (uint32_t)cause});
}

/* PMP entries bind machine mode only when locked (bit 7). NAPOT address: base / 4 with size / 8 - 1 in its low bits, all
 * ones for everything; configuration R 1, W 2, X 4, NAPOT 24. The lowest number wins. Code below the stack is read only,
 * so that an overflow, which begins with a store, meets a fault. */
static uintptr_t napot(uintptr_t base, uintptr_t size) { return base >> 2 | (size / 8 - 1); }

static void protect_memory(void)
{
    CSR_WRITE("pmpaddr0", napot((uintptr_t)rom_start, (uintptr_t)rom_size));
    CSR_WRITE("pmpaddr1", napot((uintptr_t)ram_start, (uintptr_t)ram_size));
    CSR_WRITE("pmpaddr2", napot(0, 0x20000000));   /* devices */
    CSR_WRITE("pmpaddr3", UINTPTR_MAX);
    CSR_WRITE("pmpcfg0", 0x9Du | 0x9Bu << 8 | 0x9Bu << 16 | 0x98u << 24);   /* code; data; data; nothing */
}

#ifdef __riscv_flen
CSR_READER(misa)

static void check_fpu(void)
{
    const uintptr_t need = __riscv_flen == 64 ? 1u << 3 | 1u << 5 : 1u << 5;   /* misa: D, F */

    if ((read_misa() & need) != need) {
        fault_end(&(struct fault){"wrong FPU: the image needs one that this core does not have", FAULT_UNKNOWN,
                                  FAULT_UNKNOWN, FAULT_UNKNOWN, ", misa ", (uint32_t)read_misa()});
    }
}
#else
static void check_fpu(void) {}
#endif

_Noreturn void riscv_start(void)
{
    start_memory();
    board_init();
    protect_memory();
    check_fpu();
    board_exit(main());
}

void board_vectors(int readable) { (void)readable; }   /* there are none */

/* No interrupt is ever on, so nothing can watch. */
int board_watchdog(void) { return 0; }
void watchdog_start(uint32_t ms) { (void)ms; }
void watchdog_kick(void) {}
void watchdog_stop(void) {}

void board_quiet(int quiet) { (void)quiet; }   /* interrupts are never on */
int board_counts_cycles(void) { return 0; }    /* an emulator's count; a real part would say 1 */
