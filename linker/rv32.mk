# RV32IMAFDC on QEMU's virt machine.
# The divide instructions do not trap: the compiler checks the divisor, and the check ends in ebreak as nothing else does.
CROSS := riscv64-unknown-elf-
ARCH := -march=rv32imafdc -misa-spec=2.2 -mabi=ilp32d -mcmodel=medany -msmall-data-limit=0 -fno-isolate-erroneous-paths-dereference \
        -fsanitize=integer-divide-by-zero -fsanitize-undefined-trap-on-error
FAMILY := riscv
BOARD := virt
FLOAT := hard
DOUBLE := hard
QEMU := qemu-system-riscv32 -M virt -bios none
COUNT_HZ := 1000000000
ICOUNT_SHIFT := 0
