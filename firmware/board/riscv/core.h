/* core.h - what start.S and the boards share on RISC-V (machine mode only). */
#ifndef KELLY_CORE_H
#define KELLY_CORE_H

#include "../fault.h"

_Noreturn void riscv_start(void);
_Noreturn void trap_report(uintptr_t sp);

#endif
