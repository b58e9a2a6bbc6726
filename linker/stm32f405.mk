# STM32F405, as on the Olimex H405, the Adafruit Feather STM32F405 and the Netduino Plus 2, which QEMU emulates.
CROSS := arm-none-eabi-
ARCH := -mcpu=cortex-m4 -mthumb -mfloat-abi=hard -mfpu=fpv4-sp-d16
FAMILY := cortexm
BOARD := stm32f405
FLOAT := hard
DOUBLE := soft
QEMU := qemu-system-arm -M netduinoplus2
CPU_HZ := 168000000
COUNT_HZ := 1000000000
ICOUNT_SHIFT := 0
OPENOCD := -f interface/stlink.cfg -f target/stm32f4x.cfg
PROBE := 0483
