# Arm MPS2 with AN500: Cortex-M7, FPU with double.
CROSS := arm-none-eabi-
ARCH := -mcpu=cortex-m7 -mthumb -mfloat-abi=hard -mfpu=fpv5-d16
FAMILY := cortexm
BOARD := mps
FLOAT := hard
DOUBLE := hard
QEMU := qemu-system-arm -M mps2-an500
CPU_HZ := 25000000
COUNT_HZ := 25000000
ICOUNT_SHIFT := 10
