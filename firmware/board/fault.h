/* fault.h - the last words of a program, shared by both core families. */
#ifndef KELLY_FAULT_H
#define KELLY_FAULT_H

#include "board.h"

/* Set by linker/sections.ld. The stack is at the bottom of RAM: running over its end meets forbidden memory. */
extern uint32_t stack_base[], stack_top[];
extern uint32_t data_start[], data_end[], bss_start[], bss_end[];
extern const uint32_t data_load[];
extern const uint8_t image_start[], image_end[];

/* A fault with the stack pointer this near to the end [bytes] is an overflow: one push plus the smallest frame. */
#define STACK_EDGE 72

#define FAULT_UNKNOWN 0xFFFFFFFFu   /* a pc, lr or address that the core did not keep */

struct fault {
    const char *name;      /* what went wrong, in words */
    uint32_t pc, from;     /* where; return address */
    uint32_t address;      /* of a failed access */
    const char *status;    /* name of the status register below */
    uint32_t cause;        /* CFSR, mcause */
};

/* Print the fault and end with BOARD_FAULT. Needs some 200 bytes of valid stack. */
_Noreturn void fault_end(const struct fault *fault);

/* Before main: paint the free stack, copy .data, clear .bss. */
void start_memory(void);

/* 1 where `address` is on the stack or in the 64 KB below it. */
int stack_overrun(uintptr_t address);

#endif
