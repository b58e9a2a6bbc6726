# kelly: how likely is this drill string to stick and slip? `make help` lists the targets.
#
#   REAL=double          the plant in double instead of float
#   WELL=path/NAME.toml  another string
#   TARGET=NAME          a board of linker/ instead of this machine
#   SEED=1 FIRST=0       of make digest
#   MAP='--rpm 60:180:5' options of kelly map, for make map and drives
#   V=1                  print the commands
#   CC, CFLAGS, LDFLAGS  as usual; what equal bits need is added behind them and cannot be overridden

Q := $(if $(V),,@)
.DEFAULT_GOAL := all
.DELETE_ON_ERROR:
MAKEFLAGS += --no-builtin-rules

ifeq ($(origin CC),default)
CC := $(firstword $(foreach c,gcc clang cc,$(if $(shell command -v $(c)),$(c))) cc)
endif
CFLAGS ?= -O2
# the interpreter that has numpy: python3 on PATH may lack what the system's own has
PYTHON ?= $(firstword $(foreach p,python3 /usr/bin/python3,$(if $(shell $(p) -c 'import numpy' 2>/dev/null && echo yes),$(p))) python3)
# the same, looked for when a recipe runs: it may have been installed a moment before
with_python = $$(for p in python3 /usr/bin/python3; do $$p -c 'import numpy' 2>/dev/null && echo $$p && break; done)
PREFIX ?= /usr/local

REAL ?= float
SEED ?= 1
FIRST ?= 0
CHECK_LONG ?= 1
ifneq ($(filter-out float double,$(REAL)),)
$(error REAL=$(REAL): give float or double)
endif
real_suffix := $(if $(filter double,$(REAL)),-double)
real_flag := $(if $(filter double,$(REAL)),-DKELLY_DOUBLE)

# ---- the string: the committed table, or one made from WELL ---------------------------------------------------------

WELL ?= gen/wells/paper.toml
ifneq ($(words $(WELL)),1)
$(error WELL=$(WELL): give the path of one well file, without spaces)
endif
ifeq ($(WELL),gen/wells/paper.toml)
name := paper
tables := firmware/tables
else
name := $(basename $(notdir $(WELL)))
ifneq ($(if $(filter double %_shapes,$(name)),bad,$(shell printf '%s' '$(name)' | tr -d 'A-Za-z0-9_.-')),)
$(error WELL=$(WELL): name the file of letters, digits, '_', '-' and '.', and neither double nor ..._shapes)
endif
tables := build/tables
name_suffix := -$(name)
endif

# ---- a board: images, their runs, flash -----------------------------------------------------------------------------

ifneq ($(filter-out host,$(TARGET)),)

TABLE := $(tables)/$(name).c
OUT := build/$(TARGET)$(real_suffix)$(name_suffix)
include linker/targets.mk
all: device

# Soft float is some fifty times slower: a shorter stretch, and the line that it prints says which.
run: device
	$(TARGET_RUN) --timeout 600 --line '$(if $(filter hard,$(if $(real_flag),$(DOUBLE),$(FLOAT))),samples=4,samples=2 seconds=10)' $(OUT)/device.elf

digest: device
	@$(TARGET_RUN) --timeout 600 --line 'digest=1 samples=8 seconds=4 from=2 seed=$(SEED) first=$(FIRST)' $(OUT)/device.elf > $(OUT)/digest.txt || \
	 { tail -2 $(OUT)/digest.txt >&2; exit 1; }; grep '^digest ' $(OUT)/digest.txt

size: device
	@$(CROSS)size $(OUT)/device.elf
	@$(TARGET_RUN_COUNTING) --timeout 600 --line 'count=1' $(OUT)/device.elf | grep '^per step'

else

# ---- flags ------------------------------------------------------------------------------------------------------

# Equal bits: no contraction, no libm in place of sqrt, and no gcc 12 bug with volatile registers (where the flag is known).
probe = $(shell echo 'int x;' | $(CC) $(1) -Werror -xc -c - -o /dev/null 2>/dev/null && echo $(1))
required := -std=c11 -ffp-contract=off -fno-math-errno -fno-trapping-math -fno-associative-math -fno-reciprocal-math -fsigned-zeros \
            $(call probe,-fno-move-loop-stores) $(call probe,-fno-single-precision-constant)
relaxed := $(filter -ffast-math -Ofast -funsafe-math-optimizations -ffinite-math-only,$(CFLAGS) $(CPPFLAGS))
ifneq ($(relaxed),)
$(error $(relaxed): kelly needs IEEE arithmetic, the bits would not be the same)
endif
warnings := -Wall -Wextra -pedantic -Wdouble-promotion -Wconversion -Wshadow -Wundef -Wcast-qual -Wstrict-prototypes -Wmissing-prototypes -Wvla
host_only := -D_GNU_SOURCE -pthread
machine := $(shell $(CC) -dumpmachine)

# ---- the host program -------------------------------------------------------------------------------------------

dir := build/$(if $(MPI),mpi,host)$(real_suffix)$(name_suffix)

ifdef MPI
host_only += -DKELLY_MPI $(patsubst -I%,-isystem %,$(shell mpicc --showme:compile))
mpi_link := $(shell mpicc --showme:link)
endif

# Flags in a file of their own: another CC or CFLAGS rebuilds.
all_flags = $(CC) $(CPPFLAGS) $(CFLAGS) $(LDFLAGS) $(required) $(real_flag) $(foreach e,$(engines),$($(e)_flags))
$(dir)/flags: FORCE
	@mkdir -p $(@D); [ "$$(cat $@ 2>/dev/null)" = '$(all_flags)' ] || \
	 echo '$(all_flags)' > $@
FORCE:

kernel := $(patsubst firmware/%.c,%,$(wildcard firmware/*.c firmware/link/*.c))
table_objects := $(dir)/tables/$(name).o $(dir)/tables/$(name)_shapes.o

# One build of the lane-dependent files for each vector unit; host/engine.c picks at run time. Lanes in bytes / vectors in flight.
# With the 32 registers of AVX-512 an early scheduling pass and a model of the machine pay (3 % in float, 6 in double); with 16 they do not.
ifneq ($(filter x86_64% amd64%,$(machine)),)
engines := sse2 avx2 avx512
host_only += -DKELLY_X86
else
engines := vector
endif
sse2_flags := -msse2 -DKELLY_VECTORS=4 -DKELLY_WIDTH=$(if $(real_flag),2,4)
avx2_flags := -mavx2 -mno-fma -DKELLY_VECTORS=4 -DKELLY_WIDTH=$(if $(real_flag),4,8)
avx512_flags := -mavx512f -mavx512dq -mavx512vl -mprefer-vector-width=512 -mno-fma $(call probe,-fschedule-insns) \
                $(call probe,-mtune=icelake-server) -DKELLY_VECTORS=$(if $(real_flag),4,5) -DKELLY_WIDTH=$(if $(real_flag),8,16)
vector_flags := -DKELLY_VECTORS=4 -DKELLY_WIDTH=$(if $(real_flag),2,4)
lane_files := integrator block drive drive_block ensemble

library := $(kernel:%=$(dir)/%.o) $(foreach e,$(engines),$(lane_files:%=$(dir)/$(e)/%.o))
host_objects := $(patsubst host/%.c,$(dir)/host/%.o,$(filter-out $(if $(MPI),,host/mpi.c),$(wildcard host/*.c)))

all: $(dir)/kelly                             ## build build/host/kelly (needs a C compiler and make)

$(dir)/kelly: $(host_objects) $(library) $(table_objects)
	$(Q)$(CC) $(CFLAGS) -pthread $(LDFLAGS) $(filter %.o,$^) $(mpi_link) -lm -o $@

$(dir)/%.o: firmware/%.c $(dir)/flags
	@mkdir -p $(@D); echo 'CC $<' >&2
	$(Q)$(CC) $(CPPFLAGS) $(CFLAGS) $(warnings) $(required) $(real_flag) -MMD -MP -c $< -o $@

$(dir)/tables/%.o: $(tables)/%.c $(dir)/flags
	@mkdir -p $(@D); echo 'CC $<' >&2
	$(Q)$(CC) $(CPPFLAGS) $(CFLAGS) $(warnings) $(required) $(real_flag) -Ifirmware/tables -MMD -MP -c $< -o $@

$(dir)/host/%.o: host/%.c $(dir)/flags
	@mkdir -p $(@D); echo 'CC $<' >&2
	$(Q)$(CC) $(CPPFLAGS) $(CFLAGS) $(warnings) $(required) $(host_only) $(real_flag) -MMD -MP -c $< -o $@

$(dir)/well: FORCE
	@mkdir -p $(@D); [ "$$(cat $@ 2>/dev/null)" = '$(name)' ] || echo '$(name)' > $@
$(dir)/host/emulator.o: $(dir)/well
$(dir)/host/emulator.o: private CPPFLAGS += -DWELL_SUFFIX='"$(name_suffix)"'

define engine_rule
$(dir)/$(1)/%.o: firmware/%.c $(dir)/flags
	@mkdir -p $$(@D); echo 'CC $$< for $(1)' >&2
	$(Q)$$(CC) $$(CPPFLAGS) $$(CFLAGS) $$(warnings) $$(required) $$(real_flag) $$($(1)_flags) -DKELLY_ISA=$(1) -MMD -MP -c $$< -o $$@
endef
$(foreach e,$(engines),$(eval $(call engine_rule,$(e))))

# ---- tests of the host --------------------------------------------------------------------------------------------

ifneq ($(tables),firmware/tables)
$(library) $(host_objects): | $(tables)/$(name).c      # a bad well file is told before anything is compiled
endif

unit_objects := $(patsubst tests/%.c,$(dir)/tests/%.o,tests/main.c tests/check.c tests/fixture.c tests/textbook.c tests/rare_events.c \
                $(wildcard tests/test_*.c))
engine_objects := $(dir)/host/engine.o $(dir)/host/files.o
fault_files := host_faults host_faults_state host_faults_table host_faults_instant

unit: $(dir)/unit $(dir)/lanes $(dir)/accuracy $(dir)/app-unit $(dir)/drive-numbers $(dir)/faults $(engines:%=$(dir)/faults-%) $(dir)/random-stream

app_files := $(filter-out device,$(patsubst firmware/app/%.c,%,$(wildcard firmware/app/*.c)))
$(dir)/app-unit: $(dir)/tests/host_app.o $(dir)/tests/check.o $(app_files:%=$(dir)/app/%.o) $(library) $(table_objects)
	$(Q)$(CC) $(CFLAGS) $(LDFLAGS) $(filter %.o,$^) -o $@
$(dir)/unit: $(unit_objects) $(library) $(table_objects)
	$(Q)$(CC) $(CFLAGS) $(LDFLAGS) $(filter %.o,$^) -o $@
$(dir)/lanes: $(dir)/tests/host_lanes.o $(dir)/tests/check.o $(engine_objects) $(library) $(table_objects)
	$(Q)$(CC) $(CFLAGS) $(LDFLAGS) $(filter %.o,$^) -o $@
$(dir)/drive-numbers: $(dir)/tests/host_drive.o $(library) $(table_objects)
	$(Q)$(CC) $(CFLAGS) $(LDFLAGS) $(filter %.o,$^) -o $@
$(dir)/faults: $(fault_files:%=$(dir)/tests/%.o) $(dir)/tests/check.o $(engine_objects) $(library) $(table_objects)
	$(Q)$(CC) $(CFLAGS) $(LDFLAGS) $(filter %.o,$^) -o $@
$(dir)/accuracy: $(dir)/tests/host_accuracy.o $(dir)/detmath.o $(dir)/random.o
	$(Q)$(CC) $(CFLAGS) $(LDFLAGS) $(filter %.o,$^) -lm -o $@

$(dir)/random-stream: $(dir)/tests/random_stream.o $(dir)/detmath.o $(dir)/random.o
	$(Q)$(CC) $(CFLAGS) $(LDFLAGS) $(filter %.o,$^) -o $@

# The device program as a process of this machine.
device_objects := $(patsubst firmware/%.c,$(dir)/%.o,$(wildcard firmware/app/*.c)) $(dir)/tests/board_here.o
$(device_objects): private CPPFLAGS += -DBOARD_NAME='"here"'
$(dir)/device: $(device_objects) $(library) $(table_objects)
	$(Q)$(CC) $(CFLAGS) $(LDFLAGS) $(filter %.o,$^) -o $@

$(dir)/tests/%.o: tests/%.c $(dir)/flags
	@mkdir -p $(@D); echo 'CC $<' >&2
	$(Q)$(CC) $(CPPFLAGS) $(CFLAGS) $(warnings) $(required) $(host_only) $(real_flag) -DCHECK_LONG=$(CHECK_LONG) -MMD -MP -c $< -o $@

# The same faults in the lanes of each vector unit.
define faults_rule
$(dir)/faults-$(1): $(fault_files:%=$(dir)/$(1)/tests/%.o) $(dir)/tests/check.o $(engine_objects) $(library) $(table_objects)
	$(Q)$$(CC) $$(CFLAGS) $$(LDFLAGS) $$(filter %.o,$$^) -o $$@
$(dir)/$(1)/tests/%.o: tests/%.c $(dir)/flags
	@mkdir -p $$(@D); echo 'CC $$< for $(1)' >&2
	$(Q)$$(CC) $$(CPPFLAGS) $$(CFLAGS) $$(warnings) $$(required) $$(filter-out -DKELLY_X86,$$(host_only)) $$(real_flag) $$($(1)_flags) -DKELLY_ISA=$(1) -MMD -MP -c $$< -o $$@
endef
$(foreach e,$(engines),$(eval $(call faults_rule,$(e))))

# ---- fuzzers: clang with its sanitisers, one lane; tests/check_fuzz.py runs them -------------------------------------

FUZZ_CC ?= $(firstword $(foreach c,clang-19 clang,$(if $(shell command -v $(c)),$(c))) clang)
fuzz := build/fuzz$(real_suffix)
fuzz_flags := -std=c11 -O1 -g -ffp-contract=off -fno-math-errno -fno-sanitize-recover=all -D_GNU_SOURCE $(real_flag) -Ifirmware/tables -DBOARD_NAME='"fuzz"'
fuzz_names := $(patsubst tests/fuzz/fuzz_%.c,%,$(wildcard tests/fuzz/fuzz_*.c))
fuzz_app := $(filter-out bench device estimate,$(basename $(notdir $(wildcard firmware/app/*.c))))
fuzz_kernel := $(kernel:%=firmware/%) firmware/tables/paper
fuzz_with_frame := firmware/link/frame firmware/link/crc32c firmware/link/fields firmware/link/messages
fuzz_with_wits := firmware/link/wits
fuzz_with_console := $(fuzz_kernel) $(fuzz_app:%=firmware/app/%)
fuzz_with_journal := firmware/link/crc32c
fuzz_with_elf := firmware/link/crc32c
fuzz_of_options := host/help host/until host/envelope host/npy host/screen host/threads host/journal
fuzz_with_stored := $(fuzz_kernel) host/json_read host/drive host/options $(fuzz_of_options)
fuzz_with_options := $(fuzz_kernel) $(fuzz_of_options)

fuzzers: $(fuzz_names:%=$(fuzz)/%)

$(fuzz)/%.o: %.c Makefile
	@mkdir -p $(@D); echo 'CC $< for the fuzzers' >&2
	$(Q)$(FUZZ_CC) $(fuzz_flags) -fsanitize=fuzzer-no-link,address,undefined -MMD -MP -c $< -o $@

define fuzz_rule
$(fuzz)/$(1): $(fuzz)/tests/fuzz/fuzz_$(1).o $(fuzz_with_$(1):%=$(fuzz)/%.o)
	$$(Q)$$(FUZZ_CC) -fsanitize=fuzzer,address,undefined -pthread $$^ -lm -o $$@
endef
$(foreach n,$(fuzz_names),$(eval $(call fuzz_rule,$(n))))

-include $(wildcard $(fuzz)/*/*.d $(fuzz)/*/*/*.d)

.SECONDARY:
-include $(wildcard $(dir)/*.d $(dir)/*/*.d $(dir)/*/tests/*.d)

run: $(dir)/kelly                             ## the main job: both rocks of the paper, P with its interval; TARGET=NAME: on a board
ifeq ($(name),paper)
	@echo "hard rock, mu = 0.04 (the paper: 100 %)"
	@$(dir)/kelly montecarlo --mu 0.04 --samples 4000
	@echo
	@echo "soft rock, mu = 0.004 (the paper: 50 %)"
	@$(dir)/kelly montecarlo --mu 0.004 --samples 4000
else
	@$(dir)/kelly montecarlo --samples 4000
endif

digest: $(dir)/kelly                          ## one line: digest of 8 realisations of SEED from FIRST; the same on every TARGET
	@$(dir)/kelly montecarlo --duration 4 --window 2:4 --mu 0.04 --cov 0.2 --samples 8 --seed $(SEED) --first $(FIRST) > $(dir)/digest.txt
	@sed -n 's/.*\(digest [0-9a-f]*\).*/\1/p' $(dir)/digest.txt

# The rock on which the start decides; MAP='--mu 0.02 --rpm 60:180:5' for another map.
MAP ?= $(if $(name_suffix),,--mu 0.004)
map_files := build/figures/map$(real_suffix)$(name_suffix)
map: $(dir)/kelly                             ## the driller's map: build/figures/map.png, .svg, .csv, .json, .npy (two minutes on two cores)
	@sh tests/install python3-matplotlib
	@mkdir -p build/figures
	$(dir)/kelly map $(MAP) --csv $(map_files).csv --json $(map_files).json --npy $(map_files).npy
	@$$(for p in python3 /usr/bin/python3; do $$p -c 'import matplotlib' 2>/dev/null && echo $$p && break; done) host/draw_map.py $(map_files).json $(map_files)

drives: $(dir)/kelly                          ## stiff against soft-torque drive over speed and weight: build/figures/drives.png, .svg (two minutes)
	@sh tests/install python3-matplotlib
	@mkdir -p build/figures
	$(dir)/kelly map $(MAP) --rpm 40:140:10 --wob 25:225:25 --quiet --json $(map_files)-stiff.json
	$(dir)/kelly map $(MAP) --rpm 40:140:10 --wob 25:225:25 --drive soft --quiet --json $(map_files)-soft.json
	@$$(for p in python3 /usr/bin/python3; do $$p -c 'import matplotlib' 2>/dev/null && echo $$p && break; done) host/draw_drives.py \
	 $(map_files)-stiff.json $(map_files)-soft.json build/figures/drives$(real_suffix)$(name_suffix)

figures: $(dir)/kelly                         ## Figures 1-8 of the paper and what was found: build/figures/index.html (a minute on two cores)
	@sh tests/install python3-numpy python3-matplotlib
	@$$(for p in python3 /usr/bin/python3; do $$p -c 'import numpy, matplotlib' 2>/dev/null && echo $$p && break; done) host/figures.py \
	 --kelly $(dir)/kelly --out build/figures$(real_suffix)$(name_suffix)

mpi:                                          ## build/mpi/kelly, for mpirun -n R build/mpi/kelly montecarlo|map|rare ... (Open MPI; installs it)
	@sh tests/install openmpi-bin libopenmpi-dev
	@$(MAKE) MPI=1 all

mpi-efficiency:                               ## two ranks against one, by the clock and by processor time (a minute on two idle cores)
	@$(with_python) tests/mpi_efficiency.py

# The man page comes out of the program itself.
install: $(dir)/kelly                         ## PREFIX=/usr/local DESTDIR=: the program, its man page, bash completion
	install -d '$(DESTDIR)$(PREFIX)/bin' '$(DESTDIR)$(PREFIX)/share/man/man1' '$(DESTDIR)$(PREFIX)/share/bash-completion/completions'
	$(dir)/kelly manual > $(dir)/kelly.1
	install -m 755 $(dir)/kelly '$(DESTDIR)$(PREFIX)/bin/kelly'
	install -m 644 $(dir)/kelly.1 '$(DESTDIR)$(PREFIX)/share/man/man1/kelly.1'
	install -m 644 host/kelly.bash '$(DESTDIR)$(PREFIX)/share/bash-completion/completions/kelly'

endif

# ---- the table of a string of the user's ---------------------------------------------------------------------------

ifneq ($(tables),firmware/tables)
build/tables/%_shapes.c: build/tables/%.c ;
build/tables/$(name).c: build/tables/$(name).toml $(wildcard gen/*.py)
	@$(PYTHON) gen '$(WELL)' --out build/tables --as '$(name)'

# A copy tells another file of the same name from this one.
build/tables/$(name).toml: FORCE
	@mkdir -p $(@D); [ -f '$(WELL)' ] && [ -r '$(WELL)' ] && [ "$$(cat '$(WELL)')" = "$$(cat $@ 2>/dev/null)" ] || cp '$(WELL)' $@ 2>/dev/null || : > $@
endif

# ---- the rest -----------------------------------------------------------------------------------------------------

test:                                         ## every gate of `make test`; installs what it needs (Debian packages)
	@sh tests/install $$(sed -n 's/^test: //p' tests/packages.txt)
	@$(with_python) tests/gates.py test

prove:                                        ## proof, static rules, coverage, mutation, fuzzing: beside make test; half an hour and more; installs what it needs
	@sh tests/install $$(sed -nE 's/^(test|prove): //p' tests/packages.txt)
	@$(with_python) tests/gates.py prove

campaign:                                     ## what takes hours: long fuzzing, every mutant, batteries for the random numbers; tests/campaign.md
	@sh tests/install $$(sed -E 's/^[a-z]+: //' tests/packages.txt)
	@$(with_python) tests/gates.py campaign

gate-%:                                       ## one gate of those alone, with its figures: gate-eva, gate-merge (an unknown name lists them)
	@sh tests/install $$(sed -E 's/^[a-z]+: //' tests/packages.txt)
	@$(with_python) tests/gates.py '$*'

bench:                                        ## time against the peers in one run: terminal, build/bench.json, build/bench.md; LONG=1 to 1e6
	@sh tests/bench/run

ifeq ($(filter-out host,$(TARGET)),)
study: all unit                               ## small probabilities, sensitivity, what-ifs, stopping, more than one machine: build/study.md; ten minutes
	@sh tests/install $$(sed -n 's/^test: //p' tests/packages.txt)
	@$(MAKE) -s all unit REAL=double
	@$(MAKE) -s mpi
	@$(with_python) tests/study.py build/study.md

size:                                         ## flash, RAM, stack, instructions a step of every board; TARGET=NAME: one
	@$(with_python) tests/size_table.py
endif

# What git tracks, or, unpacked from such an archive, all there is. Names in the order of their bytes, one time, one owner, the modes of
# a fresh clone: the same bytes wherever it is made.
version = $(shell sed -n 's/^.define KELLY_VERSION "\(.*\)"/\1/p' firmware/kelly.h)
archive = build/kelly-$(version)
dist:                                         ## build/kelly-VERSION.tar.gz: the source, the same bytes wherever it is made
	@mkdir -p build
	@if [ -e .git ]; then git ls-files; else find . -name .git -prune -o -path ./build -prune -o -name __pycache__ -prune -o -type f -print; fi > $(archive).all
	@sed 's,^\./,,' $(archive).all | LC_ALL=C sort > $(archive).txt
	@tar --create --file $(archive).tar --format=ustar --owner=0 --group=0 --numeric-owner --mode=u=rwX,go=rX --mtime=@946684800 \
	 --transform 's,^,kelly-$(version)/,' --no-recursion --verbatim-files-from --files-from $(archive).txt
	@gzip -9 -n < $(archive).tar > $(archive).tar.gz
	@rm $(archive).tar $(archive).txt $(archive).all
	@echo $(archive).tar.gz

readme: $(dir)/kelly size                     ## the tables of the README from runs on this tree (after make test, prove, study, bench and drives)
	@{ echo '    $$ make run'; $(MAKE) -s run | sed 's/^/    /'; } > build/run.md
	@$(dir)/kelly modes | sed 's/^/    /' > build/modes.md
	@$(with_python) tests/m4_cycles.py > build/cycles.md
	@for t in stm32f405 mps2-an500 rv32; do $(MAKE) -s TARGET=$$t device || exit 1; done
	@$(MAKE) -s mpi
	@for part in drives benches plan; do $(with_python) tests/readme_runs.py $$part > build/$$part.md || exit 1; done
	@{ printf '| what | figure | from |\n|---|---|---|\n'; cat build/gates-test.md build/gates-prove.md || exit 1; \
	   grep '^| ' tests/campaign.md | tail -n +2 | grep -v 'dieharder.*PASSED | .*batteries.py`'; } > build/gates.md
	@$(with_python) tests/readme_tables.py README.md run=build/run.md modes=build/modes.md digests=build/digests.md bench=build/bench.md \
	    size=build/size.md cycles=build/cycles.md drives=build/drives.md benches=build/benches.md rare=build/study-rare.md \
	    plan=build/plan.md gates=build/gates.md

convergence:                                  ## how many elements and modes are enough for WELL (a minute or two)
	@$(with_python) gen '$(WELL)' --convergence

tables:                                       ## regenerate firmware/tables from gen/wells/paper.toml (needs numpy), and the messages of the link
	$(PYTHON) gen gen/wells/paper.toml --out firmware/tables
	$(PYTHON) gen/protocol.py

clean:                                        ## remove build/
	rm -rf build

help:                                         ## this list
	@grep -hE '^[a-z%-]+:.*##' Makefile linker/targets.mk | sed -E 's/:.*## /\t/' | expand -t 14
	@echo; sed -n 's/^#   //p' Makefile

.PHONY: FORCE all unit convergence run digest size bench readme test prove campaign study map drives figures tables install clean help dist mpi mpi-efficiency fuzzers
