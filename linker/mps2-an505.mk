# Arm MPS2 with AN505: Cortex-M33.
CROSS := arm-none-eabi-
ARCH := -mcpu=cortex-m33 -mthumb -mfloat-abi=hard -mfpu=fpv5-sp-d16
FAMILY := cortexm
BOARD := mps
FLOAT := hard
DOUBLE := soft
QEMU := qemu-system-arm -M mps2-an505
CPU_HZ := 20000000
COUNT_HZ := 20000000
ICOUNT_SHIFT := 10
