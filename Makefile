# kelly: how likely is this drill string to stick and slip? `make help` lists the targets.
#
#   REAL=double          the plant in double instead of float
#   WELL=path/NAME.toml  another string
#   TARGET=NAME          a board of linker/ instead of this machine
#   CC, CFLAGS, LDFLAGS  as usual; what equal bits need is added behind them and cannot be overridden

.DEFAULT_GOAL := all
.DELETE_ON_ERROR:
MAKEFLAGS += --no-builtin-rules

ifeq ($(origin CC),default)
CC := $(firstword $(foreach c,gcc clang cc,$(if $(shell command -v $(c)),$(c))) cc)
endif
CFLAGS ?= -O2
# the interpreter that has numpy: python3 on PATH may lack what the system's own has
PYTHON ?= $(firstword $(foreach p,python3 /usr/bin/python3,$(if $(shell $(p) -c 'import numpy' 2>/dev/null && echo yes),$(p))) python3)
PREFIX ?= /usr/local

REAL ?= float
ifneq ($(filter-out float double,$(REAL)),)
$(error REAL=$(REAL): give float or double)
endif
real_suffix := $(if $(filter double,$(REAL)),-double)
real_flag := $(if $(filter double,$(REAL)),-DKELLY_DOUBLE)

# ---- the string: the committed table, or one made from WELL ---------------------------------------------------------

WELL ?= gen/wells/paper.toml
ifeq ($(WELL),gen/wells/paper.toml)
name := paper
tables := firmware/tables
else
name := $(basename $(notdir $(WELL)))
tables := build/tables
name_suffix := -$(name)
endif

# ---- flags ------------------------------------------------------------------------------------------------------

# Equal bits: no contraction, no libm in place of sqrt, and no gcc 12 bug with volatile registers (where the flag is known).
probe = $(shell echo 'int x;' | $(CC) $(1) -Werror -xc -c - -o /dev/null 2>/dev/null && echo $(1))
required := -std=c11 -ffp-contract=off -fno-math-errno -fno-trapping-math $(call probe,-fno-move-loop-stores)
warnings := -Wall -Wextra -pedantic -Wdouble-promotion -Wconversion -Wshadow -Wundef -Wcast-qual -Wstrict-prototypes -Wmissing-prototypes -Wvla
host_only := -D_GNU_SOURCE -pthread
machine := $(shell $(CC) -dumpmachine)

# ---- the host program -------------------------------------------------------------------------------------------

dir := build/host$(real_suffix)$(name_suffix)
kernel := $(patsubst firmware/%.c,%,$(wildcard firmware/*.c firmware/link/*.c))
table_objects := $(dir)/tables/$(name).o $(dir)/tables/$(name)_shapes.o

# One build of the lane-dependent files for each vector unit; host/engine.c picks at run time. Lanes in bytes / vectors in flight.
ifneq ($(filter x86_64% amd64%,$(machine)),)
engines := sse2 avx2 avx512
host_only += -DKELLY_X86
else
engines := vector
endif
sse2_flags := -msse2 -DKELLY_VECTORS=6 -DKELLY_WIDTH=$(if $(real_flag),2,4)
avx2_flags := -mavx2 -mno-fma -DKELLY_VECTORS=6 -DKELLY_WIDTH=$(if $(real_flag),4,8)
avx512_flags := -mavx512f -mavx512dq -mavx512vl -mprefer-vector-width=512 -mno-fma -DKELLY_VECTORS=4 -DKELLY_WIDTH=$(if $(real_flag),8,16)
vector_flags := -DKELLY_VECTORS=4 -DKELLY_WIDTH=$(if $(real_flag),2,4)
lane_files := integrator ensemble

library := $(kernel:%=$(dir)/%.o) $(foreach e,$(engines),$(lane_files:%=$(dir)/$(e)/%.o))
host_objects := $(patsubst host/%.c,$(dir)/host/%.o,$(wildcard host/*.c))

ifeq ($(filter-out host,$(TARGET)),)
all: $(dir)/kelly                             ## build build/host/kelly (needs a C compiler and make)

$(dir)/kelly: $(host_objects) $(library) $(table_objects)
	$(CC) $(CFLAGS) -pthread $(LDFLAGS) $^ -lm -o $@
endif

$(dir)/%.o: firmware/%.c
	@mkdir -p $(@D)
	$(CC) $(CPPFLAGS) $(CFLAGS) $(warnings) $(required) $(real_flag) -MMD -MP -c $< -o $@

$(dir)/tables/%.o: $(tables)/%.c
	@mkdir -p $(@D)
	$(CC) $(CPPFLAGS) $(CFLAGS) $(warnings) $(required) $(real_flag) -Ifirmware/tables -MMD -MP -c $< -o $@

$(dir)/host/%.o: host/%.c
	@mkdir -p $(@D)
	$(CC) $(CPPFLAGS) $(CFLAGS) $(warnings) $(required) $(host_only) $(real_flag) -MMD -MP -c $< -o $@

define engine_rule
$(dir)/$(1)/%.o: firmware/%.c
	@mkdir -p $$(@D)
	$$(CC) $$(CPPFLAGS) $$(CFLAGS) $$(warnings) $$(required) $$(real_flag) $$($(1)_flags) -DKELLY_ISA=$(1) -MMD -MP -c $$< -o $$@
endef
$(foreach e,$(engines),$(eval $(call engine_rule,$(e))))

ifneq ($(tables),firmware/tables)
build/tables/%_shapes.c: build/tables/%.c ;
build/tables/$(name).c: $(WELL) $(wildcard gen/*.py)
	@mkdir -p build/tables
	$(PYTHON) gen $(WELL) --out build/tables
endif

.SECONDARY:
-include $(wildcard $(dir)/*.d $(dir)/*/*.d)

# ---- what people run --------------------------------------------------------------------------------------------

run: $(dir)/kelly                             ## the main job: both rocks of the paper, P with its interval
	@echo "hard rock, mu = 0.04 (the paper: 100 %)"
	@$(dir)/kelly montecarlo --mu 0.04 --samples 4000
	@echo
	@echo "soft rock, mu = 0.004 (the paper: 50 %)"
	@$(dir)/kelly montecarlo --mu 0.004 --samples 4000

tables:                                       ## regenerate firmware/tables from gen/wells/paper.toml (needs numpy)
	$(PYTHON) gen gen/wells/paper.toml --out firmware/tables

clean:                                        ## remove build/
	rm -rf build

help:                                         ## this list
	@grep -hE '^[a-z-]+:.*##' $(MAKEFILE_LIST) | sed -E 's/:.*## /\t/' | expand -t 14

.PHONY: all run test tables clean help
