# BBC micro:bit, version 1: Cortex-M0.
CROSS := arm-none-eabi-
ARCH := -mcpu=cortex-m0 -mthumb -mfloat-abi=soft
FAMILY := cortexm
BOARD := microbit
FLOAT := soft
DOUBLE := soft
QEMU := qemu-system-arm -M microbit
CPU_HZ := 16000000
COUNT_HZ := 16000000
ICOUNT_SHIFT := 10
OPENOCD := -f interface/cmsis-dap.cfg -f target/nrf51.cfg
PROBE := 0d28
