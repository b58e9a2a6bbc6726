# Arm MPS2 with AN386: Cortex-M4F.
CROSS := arm-none-eabi-
ARCH := -mcpu=cortex-m4 -mthumb -mfloat-abi=hard -mfpu=fpv4-sp-d16
FAMILY := cortexm
BOARD := mps
FLOAT := hard
DOUBLE := soft
QEMU := qemu-system-arm -M mps2-an386
CPU_HZ := 25000000
COUNT_HZ := 25000000
ICOUNT_SHIFT := 10
