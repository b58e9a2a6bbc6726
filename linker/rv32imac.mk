# RV32IMAC on QEMU's virt machine, its FPU taken away.
# The divide instructions do not trap: the compiler checks the divisor, and the check ends in ebreak as nothing else does.
CROSS := riscv64-unknown-elf-
ARCH := -march=rv32imac -misa-spec=2.2 -mabi=ilp32 -mcmodel=medany -msmall-data-limit=0 -fno-isolate-erroneous-paths-dereference \
        -fsanitize=integer-divide-by-zero -fsanitize-undefined-trap-on-error
FAMILY := riscv
BOARD := virt
FLOAT := soft
DOUBLE := soft
QEMU := qemu-system-riscv32 -M virt -bios none -cpu rv32,f=false,d=false
COUNT_HZ := 1000000000
ICOUNT_SHIFT := 0
