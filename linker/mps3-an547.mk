# Arm MPS3 with AN547: Cortex-M55, FPU with double; its vector unit (MVE) flushes denormals and is not used.
CROSS := arm-none-eabi-
ARCH := -mcpu=cortex-m55+nomve -mthumb -mfloat-abi=hard -mfpu=fpv5-d16
FAMILY := cortexm
BOARD := mps
FLOAT := hard
DOUBLE := hard
QEMU := qemu-system-arm -M mps3-an547
CPU_HZ := 32000000
COUNT_HZ := 20000000
ICOUNT_SHIFT := 10
