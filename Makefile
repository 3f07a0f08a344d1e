# hampm: `make help` lists what there is to do; V=1 prints the commands that compile.

build ?= release
# Dimensions of space: dim=3 builds the program for solids
dim ?= 2
solid := $(if $(filter 3,$(dim)),3d)
O := build/$(build)$(solid)
PROGRAM := $(O)/hampm$(solid)
FC := gfortran
PYTHON := .venv/bin/python
# The processors that a release is for: x86-64-v3 is all that have AVX2 and FMA, native this one and its like
ARCH ?= $(if $(filter x86_64,$(shell uname -m)),x86-64-v3,native)

# Most of the time of a start is to load shared libraries, thirty of them for HDF5 alone: the release has them in it, where all of their
# archives are there. One that is named by hand is taken as it is
hdf5_folder := -L/usr/lib/$(shell gcc -dumpmachine 2>/dev/null)/hdf5/serial
ifeq ($(build) $(origin HDF5_LINK) $(origin ALGEBRA_LINK),release undefined undefined)
ARCHIVES ?= $(hdf5_folder) -Wl,-Bstatic -lhdf5_hl -lhdf5 -lsz -laec -lz -lumfpack -lcholmod -lcolamd -lccolamd -lcamd -lamd -lsuitesparseconfig \
	-lopenblas -Wl,-Bdynamic -l:libmetis.so.5 -ldl -lm -lpthread
endif
HDF5_LINK ?= $(hdf5_folder) -lhdf5_serial_hl -lhdf5_serial
ALGEBRA_LINK ?= -lumfpack -lcholmod -llapack -lblas
COMMON := -std=f2008 -fimplicit-none -fopenmp -fno-backtrace -Wall -Wextra -Wimplicit-interface -Wno-do-subscript

# Vectors of 512 bits are no faster on the processors that have them: cells come in blocks of four
width := $(if $(filter x86_64,$(shell uname -m)),-mprefer-vector-width=256)
# Kernels that several procedures call are to be put into all of them
release := -O3 --param inline-unit-growth=100 -fno-tree-loop-distribute-patterns -march=$(ARCH) $(width) -finline-limit=1000
# What a step computes is optimised as one piece in these builds
release_kernels := -flto
counted_kernels := -flto
kernel_folders := base solve law mesh points element interface problem time adapt fracture
# To compile what is edited, and run it, in a few seconds
quick := -O1 -Wno-maybe-uninitialized -Wno-uninitialized
debug := -O0 -g -fcheck=all -ffpe-trap=invalid,zero,overflow -finit-real=snan
# The release, to be run under valgrind; the run apart, so that what it calls is counted by procedure
counted := $(release) -g
counted_run := -fno-inline
counted_recording := $(counted_run)
counted_mesh_changes := $(counted_run)
counted_simulation := $(counted_run)
counted_nodal_state := $(counted_run)
sanitize := -O1 -g -fsanitize=address,undefined -fno-omit-frame-pointer -finit-real=snan
# The checks of the debug build at half of its cost: of the tests, and of many short runs
checked := -O2 -g -fcheck=all,no-array-temps -ffpe-trap=invalid,zero,overflow -finit-real=snan
# To be run under valgrind, which knows what was never set
memcheck := -O1 -g
# Threads that count at once lose counts, never the first one
coverage := -O1 -g --coverage
# Another compiler
portable := -O1
ifeq ($(build),portable)
FC := flang-new-19
COMMON := -std=f2018 -fopenmp
endif
FLAGS := $(COMMON) $($(build)) -J$(O)

SOURCES := $(wildcard src/*.f90 src/*/*.f90)
UNIT_TESTS := $(wildcard tests/unit/test_$(if $(solid),transition_cells,*).f90)
UNIT_TOOLS := $(if $(solid),$(wildcard $(addprefix tests/unit/,harness.f90 samples.f90)),$(filter-out $(UNIT_TESTS),$(wildcard tests/unit/*.f90)))
objects = $(patsubst %,$(O)/%.o,$(basename $(notdir $(1))))
LIBRARY := $(call objects,$(filter-out src/main.f90,$(SOURCES)))
ifneq ($($(build)_kernels),)
KERNELS := $(call objects,$(foreach folder,$(kernel_folders),$(wildcard src/$(folder)/*.f90)))
LIBRARY := $(filter-out $(KERNELS),$(LIBRARY)) $(O)/kernels.o
endif
LIBRARY += $(O)/processor.o
TOOLS := $(addprefix $(O)/,forced_step newton_steps eigenvalue_limit)
DRIVERS := $(addprefix $(O)/,results_driver fuzz_driver)
MEASURED := $(addprefix $(O)/,bench_step minimal_step)
UNIT_PROGRAMS := $(patsubst %.o,%,$(call objects,$(UNIT_TESTS)))
PROGRAMS := $(PROGRAM) $(TOOLS) $(DRIVERS) $(MEASURED) $(UNIT_PROGRAMS)

# Files compiled, and tests run, at a time
JOBS := $(shell n=$$(nproc 2>/dev/null || echo 1); echo $$((n < 4 ? n : 4)))

VPATH := $(sort $(dir $(SOURCES))) tests/unit tests/output tests/fuzz bench

# Targets that compile nothing themselves
TASKS := help setup lock bare clean run install uninstall wheel figures sweep slurm docs notebooks structure lab test verify verification portability coverage sanitize memcheck fuzz vtk extremes tradeoff
.PHONY: $(TASKS) program tools unit
.DELETE_ON_ERROR:

help:  ## list the targets
	@awk -F ':.*## ' '/^[a-z_]+:.*## / {printf "make %-11s %s\n", $$1, $$2}' Makefile
	@echo 'make -C bench    list what there is to measure'

run:  ## install what is missing, build, run input/dcb.nml, draw G(t)/G_ref; with dim=3 build the program for solids, run and draw a beam
	@tools/setup.sh run
	@$(MAKE) --no-print-directory program
ifeq ($(solid),)
	$(PROGRAM) input/dcb.nml --output results --force
	$(PYTHON) postprocess/plot_g.py results/dcb.h5 --converged 1.28737 --output results/dcb_G.png
	HAMPM_PYTHON=$(PYTHON) HAMPM_CONVERGED=1.28737 gnuplot -c postprocess/g_of_t.gp results/dcb_G_gnuplot.png results/dcb.h5
	@echo "results/dcb.h5: the results; results/dcb_G.png, results/dcb_G_gnuplot.png: G(t)/G_ref"
else
	$(PROGRAM) input/solid/beam.nml --output results --force
	$(PYTHON) postprocess/plot_field.py results/beam.h5 --field displacement --scale 500 --output results/beam.png
	@echo "results/beam.h5: the results; results/beam.png: the bent beam"
endif

# Where hampm is installed; what `packages` may be is in tools/install.sh
PREFIX ?= /usr/local
install:  ## install program, scripts, manual page and completions, with dim=3 hampm3d too: make install [PREFIX=/usr/local] [DESTDIR=...] [packages="run batch"]
	@tools/setup.sh program
	@$(MAKE) -j$(JOBS) --no-print-directory program
	@$(if $(solid),$(MAKE) -j$(JOBS) --no-print-directory program dim=2)
	@PREFIX='$(PREFIX)' DESTDIR='$(DESTDIR)' packages='$(packages)' tools/install.sh build/$(build)/hampm $(if $(solid),$(PROGRAM))

uninstall:  ## remove what has been installed: make uninstall [PREFIX=/usr/local] [DESTDIR=...]
	@PREFIX='$(PREFIX)' DESTDIR='$(DESTDIR)' tools/install.sh --uninstall

wheel:  ## build a wheel of the Python package with both programs and their libraries in it, build/wheel; try=1: and try it in a bare Debian
	@tools/wheel.sh $(if $(try),--try)

figures: setup  ## draw the pictures of the docs in results/, listed in tools/figures.txt; with DOCS=1 replace those in docs/
	@$(MAKE) --no-print-directory program tools
	tools/figures.sh $(O)/hampm $(PYTHON) $(if $(DOCS),--docs)

sweep:  ## run the cases of a sweep on all cores and make its table: make sweep file=input/dcb_sweep.yaml [strict=1]
	@tools/setup.sh run batch
	@$(MAKE) --no-print-directory program
	$(PYTHON) batch/run_sweep.py "$(or $(file),input/dcb_sweep.yaml)" --program $(PROGRAM) $(if $(strict),--strict)

slurm:  ## run sweeps on a real Slurm of this machine, with jobs that are cancelled, killed, preempted and at their limit of time
	@tools/setup.sh run batch
	@$(MAKE) --no-print-directory program
	@test -x .venv/bin/snakemake || { echo "batches need Python 3.11 to 3.13: remove .venv, put one first in PATH"; exit 1; }
	$(PYTHON) tools/slurm.py $(parts)

docs:  ## write the site of docs/, with pages of every module and procedure of src/: build/site/index.html, without a network
	@tools/setup.sh docs
	PYTHONPATH=. $(PYTHON) -m mkdocs build --strict --quiet
	$(PYTHON) tools/api_pages.py

notebooks:  ## make a Jupyter notebook of each lesson: docs/lessons/*.ipynb
	@tools/setup.sh docs
	$(PYTHON) tools/notebooks.py

structure:  ## count lines, arguments and uses between the folders of src/, and draw docs/images/rooms.svg
	$(PYTHON) tools/structure.py
	$(PYTHON) tools/structure.py --svg docs/images/rooms.svg

lab:  ## compile an edited step in seconds, with all checks, for the exercises of docs/lessons/exercises: make lab [exercise=scheme: and test it]
	@tools/setup.sh $(if $(exercise),test,program)
	@$(MAKE) -j$(JOBS) --no-print-directory program build=checked
	$(if $(exercise),$(PYTHON) -m pytest -q --tb=short tests/lab/exercises.py::test_$(exercise))

test:  ## install what is missing, build, run all tests
	@tools/setup.sh test
	@$(MAKE) -j$(JOBS) --no-print-directory program tools $(patsubst %,build/release/test_%,manufactured crossing_levels patch)
	@$(MAKE) -j$(JOBS) --no-print-directory program unit build=checked build/checked/bench_step
	@$(MAKE) -j$(JOBS) --no-print-directory program build/quick3d/test_transition_cells build=quick dim=3
	@! command -v valgrind >/dev/null || $(MAKE) -j$(JOBS) --no-print-directory build=counted build/counted/bench_step
	$(PYTHON) -m pytest -q -n $(JOBS) --dist loadgroup -m "not verify" tests

verify: setup  ## run the tests that take long, which `make test` leaves out, and write the tables of docs/evidence/verification.md
	@$(MAKE) -j$(JOBS) --no-print-directory program unit
	@$(MAKE) -j$(JOBS) --no-print-directory program dim=3
	@$(MAKE) -j$(JOBS) --no-print-directory program unit build=checked
	@! command -v valgrind >/dev/null || $(MAKE) -j$(JOBS) --no-print-directory build=counted build/counted/bench_step
	$(PYTHON) -m pytest -q -n $(JOBS) --dist loadgroup -m verify --junitxml=results/verify.xml tests
	$(PYTHON) tools/verification_table.py results/verify.xml docs/evidence/verification.md

verification: setup  ## run tests/regression and write build/verification.html: references, errors, orders, machine, what was not run; quick=1: without long runs
	@$(MAKE) -j$(JOBS) --no-print-directory program
	@status=0; $(PYTHON) -m pytest -q -n $(JOBS) --dist loadgroup $(if $(quick),-m "not verify") --junitxml=results/regression.xml tests/regression || status=$$?; \
		$(PYTHON) tools/verification_table.py --html build/verification.html $(wildcard results/verify.xml) results/regression.xml; exit $$status

portability: setup  ## compile everything by another compiler, flang, and run unit and regression tests with what it makes
	@tools/setup.sh flang-19
	@$(MAKE) -j$(JOBS) --no-print-directory build=portable program unit
	HAMPM=build/portable/hampm $(PYTHON) -m pytest -q -n $(JOBS) --dist loadgroup -m "not verify" tests/unit tests/regression

coverage: setup  ## count which lines of src/ the tests run: a table; an error below 90 %
	@$(MAKE) -j$(JOBS) --no-print-directory build=coverage program unit
	$(PYTHON) tools/coverage.py

sanitize: setup  ## run unit tests, random input and the coarse cases with AddressSanitizer and UndefinedBehaviorSanitizer
	@$(MAKE) -j$(JOBS) --no-print-directory build=sanitize program unit
	$(PYTHON) tools/checked_runs.py sanitize

memcheck:  ## run unit tests and short cases under valgrind
	@tools/setup.sh valgrind
	@$(MAKE) -j$(JOBS) --no-print-directory build=memcheck program unit
	$(PYTHON) tools/checked_runs.py memcheck

fuzz: setup  ## read 1 000 000 namelists and command lines that are changed at random; set every key in scenes over all features; try 1000 runs that go wrong, 50 000 scenes at random, and 10 000 spoilt results and checkpoints each
	@$(MAKE) -j$(JOBS) --no-print-directory build=checked program build/checked/fuzz_driver
	$(PYTHON) tests/fuzz/fuzz.py --build checked --cases 1000000 --seed 100
	$(PYTHON) tests/fuzz/every_key.py --program build/checked/hampm
	$(PYTHON) tests/fuzz/runs.py --program build/checked/hampm --cases 1000 --seed 100
	$(PYTHON) tests/fuzz/combinations.py --program build/checked/hampm --cases 5000 --seed 100
	$(PYTHON) tests/fuzz/combinations.py --program build/checked/hampm --cases 370 --seed 46 --cracked
	@$(MAKE) -j$(JOBS) --no-print-directory program build=checked dim=3
	$(PYTHON) tests/fuzz/solid_scenes.py --cases 2000 --seed 100
	$(PYTHON) tests/fuzz/solid_keys.py
	$(PYTHON) tests/fuzz/growth_scenes.py --program build/checked/hampm --cases 10000 --seed 100
	$(PYTHON) tests/fuzz/rest_scenes.py --program build/checked/hampm --cases 10000 --seed 100
	$(PYTHON) tests/fuzz/shape_scenes.py --program build/checked/hampm --cases 10000 --seed 100
	$(PYTHON) tests/fuzz/meeting_scenes.py --program build/checked/hampm --cases 10000 --seed 100
	$(PYTHON) tests/fuzz/plain_scenes.py --program build/checked/hampm --cases 10000 --seed 100
	$(PYTHON) tests/fuzz/local_scenes.py --program build/checked/hampm --cases 2000 --seed 100
	$(PYTHON) tests/fuzz/sweep_files.py --program build/checked/hampm --cases 10000 --seed 100
	$(PYTHON) tests/fuzz/checkpoint_files.py --program build/checked/hampm --cases 10000 --seed 100
	build/checked/hampm input/edge_crack.nml --output results --force --quiet
	$(PYTHON) tests/fuzz/result_files.py results/edge_crack.h5 --cases 10000 --seed 100

# The oldest version that reads the snapshots, unless another is named
version ?= 9.4.2
vtk: setup  ## hold the snapshots to another version of VTK than that of requirements/verify.txt: make vtk [version=9.4.2]
	@$(MAKE) --no-print-directory $(O)/results_driver
	@test -x build/vtk-$(version)/bin/pytest || { $(PYTHON) -m venv build/vtk-$(version) && \
		build/vtk-$(version)/bin/python -m pip install --quiet --disable-pip-version-check vtk==$(version) \
		-r requirements/run.txt $(shell grep -h '^pytest=' requirements/test.txt); }
	build/vtk-$(version)/bin/python -m pytest -q tests/output

extremes: setup  ## run the extremes of every part of a scene and write docs/evidence/stability.md
	@$(MAKE) --no-print-directory program
	$(PYTHON) bench/extremes.py --output results/extremes --document 1
	tools/figures.sh $(O)/hampm $(PYTHON) --docs stability

tradeoff: setup  ## measure accuracy against cost for every kind of setting and write docs/evidence/tradeoff.md
	@$(MAKE) --no-print-directory program
	$(PYTHON) bench/tradeoff.py --output results/tradeoff --document 1
	tools/figures.sh $(O)/hampm $(PYTHON) --docs tradeoff

setup:  ## install what is missing: compiler, libraries, Python environment
	@tools/setup.sh

lock:  ## resolve the versions of all Python packages anew, for every Python from 3.11.2 on: requirements.lock
	tools/lock.sh

bare:  ## try everything on bare Debians of their own, which debootstrap makes, as root: make bare [suites="bookworm trixie"] [steps="run docs"]
	tools/bare_root.sh $(addprefix --suite ,$(suites)) $(steps)

program: $(PROGRAM)

tools: $(TOOLS) $(DRIVERS)

# flang has no underflow modes
unit: $(UNIT_PROGRAMS) tools $(call objects,$(filter-out $(if $(filter portable,$(build)),%/minimal_step.f90),$(wildcard bench/*.f90)))

clean:  ## remove what was built; results stay
	rm -rf build

# --- objects and programs -----------------------------------------------------------------------------------------------------

say = $(if $(V),,@echo "$(1)")
quietly := $(if $(V),,@)

$(PROGRAM): $(O)/main.o
$(PROGRAM): private with := $(ARCHIVES)
$(MEASURED): $(call objects,timing plain_scene minimal_kernel)
$(UNIT_PROGRAMS): $(call objects,$(UNIT_TOOLS))
$(filter-out $(PROGRAM),$(PROGRAMS)): $(O)/%: $(O)/%.o
$(PROGRAMS): $(LIBRARY)
	$(call say,$@)
	$(quietly)$(if $(with),$(FC) $(FLAGS) -o $@ $^ $(with) 2>/dev/null || )$(FC) $(FLAGS) -o $@ $^ $(HDF5_LINK) $(ALGEBRA_LINK)

# All laws, indicators, integrators and estimators are given what one of them needs
$(call objects,$(wildcard src/law/*.f90 src/adapt/*.f90 src/time/*.f90 src/fracture/*.f90)): private unused := $(if $(filter portable,$(build)),,-Wno-unused-dummy-argument)
$(KERNELS): private kernels := $($(build)_kernels)

# Arrays of run-time size are in these those of an element, a node or a tip: they need no memory from the heap
small_arrays := basis grid matter recovery element_stiffness element_assembly error_indicator missing_energy expected_error tip_domain \
                domain_integral support_pass support_operators patch crack_closure
ifneq ($(build),portable)
$(addprefix $(O)/,$(addsuffix .o,$(small_arrays))): private stack := -fstack-arrays
endif

$(O)/kinds.o: private dimensions := -cpp -DDIMENSIONS=$(dim)

# A changed flag, here or on the command line, builds everything anew
$(O)/%.o: %.f90 $(O)/flags
	$(call say,$(FC) $<)
	$(quietly)$(FC) $(FLAGS) $($(build)_$*) $(dimensions) $(kernels) $(stack) $(unused) -c -o $@ $<

# Of a solid, code that is for a plane alone is inlined where it is never reached
$(O)/kernels.o: $(KERNELS)
	$(call say,$@)
	+$(quietly)$(FC) $(FLAGS) -Wno-maybe-uninitialized $(if $(solid),-Wno-uninitialized) -fPIE -flto=auto -r -flinker-output=nolto-rel -o $@ $^

$(O)/processor.o: src/processor.c $(O)/flags
	$(call say,$(FC) $<)
	$(quietly)$(if $(filter portable,$(build)),gcc,$(FC)) -Wall -Wextra -O1 $(filter -march=%,$(FLAGS)) -c -o $@ $<

# The commit that a program is of. Only the main program has it: nothing else is built anew where it changes
$(O)/main.o: $(O)/version.inc
$(O)/main.o: private unused := -I$(O)
$(O)/version.inc: FORCE
	@mkdir -p $(O)
	@echo "character(*), parameter :: built_version = '$$(tools/version.sh)'" | cmp -s - $@ || \
		echo "character(*), parameter :: built_version = '$$(tools/version.sh)'" > $@

$(O)/flags: FORCE
	@mkdir -p $(O)
	@echo '$(FC) $(FLAGS) $($(build)_kernels) $(kernel_folders)' | cmp -s - $@ || echo '$(FC) $(FLAGS) $($(build)_kernels) $(kernel_folders)' > $@
FORCE:

$(O)/depends.mk: $(SOURCES) $(UNIT_TESTS) $(UNIT_TOOLS) $(wildcard tests/output/*.f90 tests/fuzz/*.f90 bench/*.f90) tools/depends.awk
	@mkdir -p $(O)
	@awk -v folder='$$(O)' -f tools/depends.awk $(filter %.f90,$^) > $@

ifneq ($(filter-out $(TASKS),$(or $(MAKECMDGOALS),help)),)
include $(O)/depends.mk
endif
