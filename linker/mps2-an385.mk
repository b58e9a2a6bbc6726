# Arm MPS2 with AN385: Cortex-M3, no FPU.
CROSS := arm-none-eabi-
ARCH := -mcpu=cortex-m3 -mthumb -mfloat-abi=soft
FAMILY := cortexm
BOARD := mps
FLOAT := soft
DOUBLE := soft
QEMU := qemu-system-arm -M mps2-an385
CPU_HZ := 25000000
COUNT_HZ := 25000000
ICOUNT_SHIFT := 10
