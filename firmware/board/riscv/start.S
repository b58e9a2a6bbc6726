/* start.S - first instructions of every RISC-V board, and the door of every trap. */

    .section .start, "ax"
    .globl reset
reset:
    .option push
    .option norelax
    la gp, __global_pointer$
    .option pop
    la sp, stack_top
    la t0, trap_entry
    csrw mtvec, t0
    csrr t0, mhartid
    bnez t0, 2f
#ifdef __riscv_flen
    /* FPU on. An image for an FPU on a core without: FS stays 0, and riscv_start says so. */
    li t0, 0x6000
    csrs mstatus, t0
    csrr t1, mstatus
    and t1, t1, t0
    beqz t1, 1f
    csrw fcsr, zero
1:
#endif
    call riscv_start
2:  wfi
    j 2b

/* The stack may be the very thing that broke: take the one kept for faults first. Interrupts are never enabled, so a
 * trap is always a fault. */
    .balign 4
trap_entry:
    mv a0, sp
    la sp, fault_stack_top
    j trap_report
