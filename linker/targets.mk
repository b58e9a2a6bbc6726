# targets.mk - one microcontroller image. Included by the Makefile when TARGET is not host; works alone as well:
# `make -f linker/targets.mk TARGET=rv32 hello`, from the top of the tree.
#
# In     TARGET=NAME (linker/NAME.mk, linker/NAME.ld)   REAL=float|double   TABLE=firmware/tables/paper.c
#        OPT=-O2   WARN=... (warnings)   WERROR= (empty: warnings pass)   OUT=build/NAME[-double][-WELL]
# Out    $(call image,IMAGE,SOURCES)     rules for $(OUT)/IMAGE.elf, .bin, .hex, .map from SOURCES, the kernel and the
#                                        board. Unused sections are dropped. Every object leaves a .ci beside it (stack).
#        $(call bare_image,...)          the same without the kernel. Both are for $(eval ...)
#        $(TARGET_KERNEL_OBJECTS)        firmware/*.c, firmware/link/*.c and the table
#        $(TARGET_RUN) IMAGE.elf         runs it in QEMU;  $(TARGET_RUN_COUNTING) IMAGE.elf: with exact instruction counts
# Goals  device  hello  faults  tests-image (tests.elf: all tests)  one-tests (test_NAME.elf: one test each)
#        budgets  flash  flash-IMAGE
#
# A board: linker/NAME.mk with
#   CROSS, ARCH       compiler prefix; CPU flags, for compiling and linking
#   FAMILY, BOARD     directories of firmware/board/: core family, board functions
#   FLOAT, DOUBLE     hard or soft: who does the arithmetic of a real
#   QEMU              command and machine
#   CPU_HZ            core clock where board code needs it as a constant
#   COUNT_HZ, ICOUNT_SHIFT   board_count in QEMU: counts a second of emulated time, and `-icount shift=` at which one
#                     instruction is a known number of counts, not below one
#   OPENOCD, PROBE    arguments for a real board, USB vendor of its debug probe; or left out

TARGET_LIST := $(sort $(patsubst linker/%.mk,%,$(filter-out linker/targets.mk,$(wildcard linker/*.mk))))
ifeq ($(filter $(TARGET),$(TARGET_LIST)),)
$(error TARGET=$(TARGET) is none of: $(TARGET_LIST))
endif
include linker/$(TARGET).mk

REAL ?= float
OPT ?= -O2
TABLE ?= firmware/tables/paper.c
OUT ?= build/$(TARGET)$(if $(filter double,$(REAL)),-double)
TARGET_CC := $(CROSS)gcc
ifeq ($(shell command -v $(TARGET_CC)),)
$(error TARGET=$(TARGET) needs $(TARGET_CC) and QEMU; Debian: apt install gcc-arm-none-eabi libnewlib-arm-none-eabi \
 gcc-riscv64-unknown-elf picolibc-riscv64-unknown-elf qemu-system-arm qemu-system-misc)
endif
Q ?= $(if $(V),,@)
WARN ?= -Wall -Wextra -pedantic -Wconversion -Wshadow -Wundef -Wcast-qual -Wstrict-prototypes -Wmissing-prototypes -Wvla \
        $(if $(filter double,$(REAL)),,-Wdouble-promotion)
WERROR ?= -Werror

# gcc 12 moves a store out of a loop and repeats a write to a device register; other compilers do not know the flag.
TARGET_NO_MOVE := $(shell echo 'int x;' | $(TARGET_CC) -fno-move-loop-stores -x c -S -o /dev/null - 2>/dev/null && \
                          echo -fno-move-loop-stores)
# Last on every line, so that nothing overrides them: the arithmetic is what makes the bits equal.
TARGET_FIXED := -std=c11 -ffreestanding -ffp-contract=off -fno-math-errno -fno-associative-math -fno-reciprocal-math \
                -fsigned-zeros -fno-tree-vectorize $(TARGET_NO_MOVE)
TARGET_DEFINES := -Ifirmware/tables $(if $(filter double,$(REAL)),-DKELLY_DOUBLE) -DBOARD_NAME='"$(TARGET)"' -DBOARD_COUNT_HZ=$(COUNT_HZ)u \
                  -DBOARD_ICOUNT_SHIFT=$(ICOUNT_SHIFT) $(if $(CPU_HZ),-DBOARD_CPU_HZ=$(CPU_HZ)u)
TARGET_FLAGS := $(ARCH) $(OPT) -g -ffunction-sections -fdata-sections -fno-common -fcallgraph-info=su $(WARN) $(WERROR) \
                $(TARGET_DEFINES) -MMD -MP
TARGET_LINK := $(ARCH) -nostdlib -nostartfiles -L linker -T linker/$(TARGET).ld -Wl,--gc-sections,--fatal-warnings

TARGET_KERNEL := $(wildcard firmware/*.c) $(wildcard firmware/link/*.c) $(wildcard $(TABLE) $(TABLE:.c=_*.c))
TARGET_BOARD := $(wildcard firmware/board/*.c firmware/board/$(FAMILY)/*.[cS] firmware/board/$(BOARD)/*.c)
target_objects = $(addprefix $(OUT)/,$(addsuffix .o,$(basename $(1))))
TARGET_KERNEL_OBJECTS := $(call target_objects,$(TARGET_KERNEL))
TARGET_BOARD_OBJECTS := $(call target_objects,$(TARGET_BOARD))
TARGET_RUN = python3 tests/run_target.py --target $(TARGET)
TARGET_RUN_COUNTING = $(TARGET_RUN) --counting

# Flags in a file of their own: another OPT or REAL in the same OUT rebuilds.
$(OUT)/flags: FORCE
	@mkdir -p $(OUT); [ "$$(cat $@ 2>/dev/null)" = '$(subst ','"'"',$(TARGET_CC) $(TARGET_FLAGS) $(TARGET_FIXED))' ] || \
	 echo '$(subst ','"'"',$(TARGET_CC) $(TARGET_FLAGS) $(TARGET_FIXED))' > $@
FORCE:

$(OUT)/%.o: %.c $(OUT)/flags
	@mkdir -p $(@D); echo 'CC $<' >&2
	$(Q)$(TARGET_CC) $(TARGET_FLAGS) $(TARGET_EXTRA) $(TARGET_FIXED) -c $< -o $@
$(OUT)/%.o: %.S $(OUT)/flags
	@mkdir -p $(@D); echo 'CC $<' >&2
	$(Q)$(TARGET_CC) $(ARCH) -g -c $< -o $@
$(OUT)/firmware/board/memory.o: TARGET_EXTRA := -fno-tree-loop-distribute-patterns

# bare_image,IMAGE,SOURCES
define bare_image
$(OUT)/$(1).elf: $(call target_objects,$(2)) $(TARGET_BOARD_OBJECTS) linker/$(TARGET).ld linker/sections.ld
	@mkdir -p $$(@D)
	$$(Q)$(TARGET_CC) $(TARGET_LINK) -Wl,-Map=$(OUT)/$(1).map $$(filter %.o,$$^) -lgcc -o $$@
-include $(patsubst %.o,%.d,$(call target_objects,$(2)))
endef
define image
$(call bare_image,$(1),$(2))
$(OUT)/$(1).elf: $(TARGET_KERNEL_OBJECTS)
endef
-include $(patsubst %.o,%.d,$(TARGET_KERNEL_OBJECTS) $(TARGET_BOARD_OBJECTS))

%.bin: %.elf
	@$(CROSS)objcopy -O binary $< $@
%.hex: %.elf
	@$(CROSS)objcopy -O ihex $< $@

# The board alone.
FAULTS := $(wildcard tests/faults/*.c)
$(eval $(call bare_image,hello,tests/target_hello.c firmware/app/line.c))
$(foreach f,$(FAULTS),$(eval $(call bare_image,faults/$(basename $(notdir $(f))),$(f))))
hello: $(OUT)/hello.elf
faults: $(patsubst tests/faults/%.c,$(OUT)/faults/%.elf,$(FAULTS))

# The device program.
$(eval $(call image,device,$(wildcard firmware/app/*.c)))
device: $(OUT)/device.elf $(OUT)/device.bin $(OUT)/device.hex

# All tests in one image, and, for parts too small for that, one image a test: $(OUT)/test_NAME.elf.
TARGET_TESTS := $(sort $(wildcard tests/test_*.c))
TARGET_TEST_HELP := tests/check.c tests/on_target.c $(wildcard tests/fixture.c tests/textbook.c tests/rare_events.c)
$(eval $(call image,tests,tests/main.c $(TARGET_TEST_HELP) $(TARGET_TESTS)))
tests-image: $(OUT)/tests.elf
$(OUT)/one/%.o: tests/one_test.c $(OUT)/flags
	@mkdir -p $(@D); echo 'CC $<' >&2
	$(Q)$(TARGET_CC) $(TARGET_FLAGS) -DONE_TEST=$* $(TARGET_FIXED) -c $< -o $@
define one_test
$(call image,$(1),tests/$(1).c $(TARGET_TEST_HELP))
$(OUT)/$(1).elf: $(OUT)/one/$(1).o
endef
$(foreach t,$(TARGET_TESTS),$(eval $(call one_test,$(basename $(notdir $(t))))))
one-tests: $(patsubst tests/%.c,$(OUT)/%.elf,$(TARGET_TESTS))

# Limits of tests/budgets.txt.
budgets: device hello $(TARGET_KERNEL_OBJECTS)
	python3 tests/check_budgets.py --target $(TARGET) --real $(REAL) --out $(OUT) $(TARGET_KERNEL_OBJECTS)

# Prints the command; runs it when OpenOCD is installed and the probe is plugged in.
flash: flash-device                           ## TARGET=NAME: the device program onto a real board; prints OpenOCD's command, runs it if there is a probe
flash-%: $(OUT)/%.elf
	@$(if $(OPENOCD),,echo "$(TARGET) is an emulated board: nothing to flash" >&2; exit 1;) \
	 echo 'openocd $(OPENOCD) -c "program $< verify reset exit"'; \
	 if command -v openocd >/dev/null && grep -qs '$(PROBE)' /sys/bus/usb/devices/*/idVendor; \
	 then openocd $(OPENOCD) -c "program $< verify reset exit"; \
	 else echo 'not run: needs openocd and a debug probe (USB vendor $(PROBE))'; fi

.PHONY: device hello faults tests-image one-tests budgets flash FORCE
