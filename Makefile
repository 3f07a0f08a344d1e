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
	-larpack -lopenblas -Wl,-Bdynamic -l:libmetis.so.5 -ldl -lm -lpthread
endif
HDF5_LINK ?= $(hdf5_folder) -lhdf5_serial_hl -lhdf5_serial
ALGEBRA_LINK ?= -lumfpack -lcholmod -larpack -llapack -lblas
# With optimisation gfortran says of descriptors of arrays that are not allocated, and in solids of code for a plane alone, that they are not
# initialised. The debug build asks what is not; memcheck, and reals that begin as signalling NaN, find what is read before it is set
COMMON := -std=f2008 -fimplicit-none -fopenmp -fno-backtrace -Wall -Wextra -Wimplicit-interface -Wno-do-subscript \
	$(if $(filter debug,$(build)),,-Wno-uninitialized -Wno-maybe-uninitialized)

# Vectors of 512 bits are no faster on the processors that have them: cells come in blocks of four
width := $(if $(filter x86_64,$(shell uname -m)),-mprefer-vector-width=256)
# The release is optimised by how often code runs. Kernels of a step, and of sums over particles, are put into all procedures that call them,
# with what the rest of their folders has, as one piece (kernels.o). What runs once a run, a mesh or a front is compiled for a short build
release := -march=$(ARCH) $(width) -fno-tree-loop-distribute-patterns
release_kernels := -O3 --param inline-unit-growth=100 -finline-limit=1000 -flto
release_often := -O2 -fpeel-loops -fno-schedule-insns2 --param max-inline-insns-auto=200 -flto
release_seldom := -Og -ffrontend-optimize
kernels := $(notdir $(wildcard src/law/*.f90)) $(addsuffix .f90,audit_kernels basis domain_pass element_assembly element_kernels element_stiffness \
	energy_momentum front_integral ghost_penalty grid matching matter missing_energy nodal_kernels nodal_transfer numbering outline \
	particle_kernels particle_pass pass recovery rigid_motions sparse stencils stiffness support_pass tensors tip_domain)
seldom_folders := input simulation growth setup report output accuracy
seldom := $(addsuffix .f90,absorbing_edges archive balance bodies body_contact bonded_forces closed_faces cohesive_zone constraints crack_errors crack_lines \
	crack_measurements crack_values cracks domains edge_loads edge_parts error_context estimated_errors estimator estimators failure fatigue_rates \
	front front_closure front_values growth_laws hat_errors indicators instant interface_placement interface_transfer interruption json \
	kinks load_following load_sharing material_force moving_front nodal_release patch plane_cuts plane_points quadratic_children \
	quadratic_points quadratic_tip_offset reference_step static_equilibrium supports symmetric_turns t_stress text \
	tip_measurements turned_tips version)
# To compile what is edited, and run it, in a few seconds
quick := -O1
debug := -O0 -g -fcheck=all -ffpe-trap=invalid,zero,overflow -finit-real=snan
sanitize := -O1 -g -fsanitize=address,undefined -fno-omit-frame-pointer -finit-real=snan
# The checks of the debug build at half of its cost: of the tests, and of many short runs
checked := -O2 -g -fcheck=all,no-array-temps -ffpe-trap=invalid,zero,overflow -finit-real=snan
checked_seldom := -Og
# To be run under valgrind, which knows what was never set
memcheck := -O1 -g
# Threads that count at once lose counts, never the first one
coverage := -O1 -g --coverage
# Another compiler, by the first of its names that this machine has
portable := -O1
ifeq ($(build),portable)
FC := $(or $(shell for name in flang-new-19 flang-19 flang-new flang; do command -v $$name > /dev/null && echo $$name && break; done),flang-new-19)
COMMON := -std=f2018 -fopenmp
endif
FLAGS := $(COMMON) $($(build)) -J$(O)

SOURCES := $(wildcard src/*.f90 src/*/*.f90)
UNIT_TESTS := $(wildcard $(patsubst %,tests/unit/test_%.f90,$(if $(solid),energy_momentum transition_cells,*)))
UNIT_TOOLS := $(if $(solid),$(wildcard $(addprefix tests/unit/,harness.f90 samples.f90)),$(filter-out $(UNIT_TESTS),$(wildcard tests/unit/*.f90)))
objects = $(patsubst %,$(O)/%.o,$(basename $(notdir $(1))))
LIBRARY := $(call objects,$(filter-out src/main.f90,$(SOURCES)))
SELDOM := $(call objects,$(wildcard src/*.f90) $(foreach folder,$(seldom_folders),$(wildcard src/$(folder)/*.f90)) $(seldom))
ifneq ($($(build)_kernels),)
KERNELS := $(filter $(LIBRARY),$(call objects,$(kernels)))
OFTEN := $(filter-out $(KERNELS) $(SELDOM),$(LIBRARY))
LIBRARY := $(filter $(SELDOM),$(LIBRARY)) $(O)/kernels.o
endif
LIBRARY += $(O)/processor.o
TOOLS := $(addprefix $(O)/,forced_step newton_steps eigenvalue_limit)
DRIVERS := $(addprefix $(O)/,results_driver fuzz_driver)
MEASURED := $(O)/bench_step
UNIT_PROGRAMS := $(patsubst %.o,%,$(call objects,$(UNIT_TESTS)))
PROGRAMS := $(PROGRAM) $(TOOLS) $(DRIVERS) $(MEASURED) $(UNIT_PROGRAMS)

# What make check runs beside the command line: a case of each program
checks := tests/regression tests/program/test_solid.py -k "cli or static_bar or release_rate_of_a_slab"

# Files compiled, and tests run, at a time
JOBS := $(shell n=$$(nproc 2>/dev/null || echo 1); echo $$((n < 4 ? n : 4)))
# Of a make below this one: as many at a time, unless -j was given
parallel = --no-print-directory $(if $(filter -j%,$(MAKEFLAGS)),,-j$(JOBS))

VPATH := $(sort $(dir $(SOURCES))) tests/unit tests/output tests/fuzz tests/tools bench

# Targets that compile nothing themselves
TASKS := help setup lock bare clean run install uninstall wheel figures sweep slurm docs notebooks structure lab check test costs mutants verify verification portability coverage sanitize memcheck fuzz vtk extremes tradeoff benchmarks release-check dist
.PHONY: $(TASKS) program tools unit
.DELETE_ON_ERROR:

help:  ## list the targets
	@awk -F ':.*## ' '/^[a-z_-]+:.*## / {printf "make %-13s %s\n", $$1, $$2}' Makefile
	@echo 'make -C bench    list what there is to measure'

run:  ## install what is missing, build, run input/dcb.nml, draw G(t)/G_ref; with dim=3 build the program for solids, run and draw a beam
	@tools/setup.sh run
	@test -x $(PROGRAM) || echo "building $(PROGRAM): three minutes of processor time, with $(JOBS) files at a time"
	@$(MAKE) $(parallel) program
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
	@$(MAKE) $(parallel) program
	@$(if $(solid),$(MAKE) $(parallel) program dim=2)
	@PREFIX='$(PREFIX)' DESTDIR='$(DESTDIR)' packages='$(packages)' tools/install.sh build/$(build)/hampm $(if $(solid),$(PROGRAM))

uninstall:  ## remove what has been installed: make uninstall [PREFIX=/usr/local] [DESTDIR=...]
	@PREFIX='$(PREFIX)' DESTDIR='$(DESTDIR)' tools/install.sh --uninstall

wheel:  ## build a wheel of the Python package with both programs and their libraries in it, build/wheel; try=1: and try it in a bare Debian
	@tools/wheel.sh $(if $(try),--try)

dist:  ## make an archive of the sources of the last commit, which knows its commit: build/hampm-VERSION.tar.gz
	@mkdir -p build
	git archive --prefix=hampm-$(shell sed -n 1p VERSION)/ --output=build/hampm-$(shell sed -n 1p VERSION).tar.gz HEAD

figures: setup  ## draw the pictures of the docs in results/, listed in tools/figures.txt; with DOCS=1 replace those in docs/
	@$(MAKE) $(parallel) program tools
	tools/figures.sh $(O)/hampm $(PYTHON) $(if $(DOCS),--docs)

sweep:  ## run the cases of a sweep on all cores and make its table: make sweep file=input/dcb_sweep.yaml [strict=1]
	@tools/setup.sh run batch
	@$(MAKE) $(parallel) program
	$(PYTHON) batch/run_sweep.py "$(or $(file),input/dcb_sweep.yaml)" --program $(PROGRAM) $(if $(strict),--strict)

slurm:  ## run sweeps on a real Slurm of this machine, with jobs that are cancelled, killed, preempted and at their limit of time
	@tools/setup.sh run batch
	@$(MAKE) $(parallel) program
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
	@$(MAKE) $(parallel) program build=checked
	$(if $(exercise),$(PYTHON) -m pytest -q --tb=short tests/lab/exercises.py::test_$(exercise))

check:  ## compile what was edited in seconds, run tests/cli and a case of each program, in a minute once built
	@tools/setup.sh test
	@$(MAKE) $(parallel) program build=quick
	@$(MAKE) $(parallel) program build=quick dim=3
	HAMPM=build/quick/hampm HAMPM3D=build/quick3d/hampm3d $(PYTHON) -m pytest -q -n $(JOBS) -m "not verify" tests/cli $(checks)

test:  ## install what is missing, build, run all tests
	@tools/setup.sh test
	@$(MAKE) $(parallel) program tools build/release/bench_step $(patsubst %,build/release/test_%,manufactured crossing_levels patch)
	@$(MAKE) $(parallel) program unit build=checked build/checked/bench_step
	@$(MAKE) $(parallel) program $(patsubst %,build/release3d/test_%,energy_momentum transition_cells) dim=3
	$(PYTHON) -m pytest -q -n $(JOBS) --dist loadgroup -m "not verify" tests

costs:  ## measure the processor time of each test of `make test`, and leave to `make verify` what has become too long: tests/long_tests.csv
	@rm -rf build/costs
	-PYTHONPATH=tests $(PYTHON) -m pytest -q -p costs -n $(JOBS) --dist loadgroup -m "not verify" tests
	$(PYTHON) tests/costs.py

mutants:  ## put small faults into copies of src/, one at a time, and ask the tests to find them: 200 of seed 1; minutes=N to stop then
	@tools/setup.sh test
	$(PYTHON) tests/mutants.py $(if $(minutes),--minutes $(minutes)) --whole

verify: setup  ## run the tests that take long, which `make test` leaves out, and write the tables of docs/evidence/verification.md
	@$(MAKE) $(parallel) program unit
	@$(MAKE) $(parallel) program tools dim=3
	@$(MAKE) $(parallel) program unit build=checked
	$(PYTHON) -m pytest -q -n $(JOBS) --dist loadgroup -m verify --junitxml=results/verify.xml tests
	$(PYTHON) tools/verification_table.py results/verify.xml docs/evidence/verification.md

verification:  ## run tests/regression and write build/verification.html: references, errors, orders, machine, what was not run; quick=1: without long runs
	@tools/setup.sh test
	@$(MAKE) $(parallel) program
	@status=0; $(PYTHON) -m pytest -q -n $(JOBS) --dist loadgroup $(if $(quick),-m "not verify") --junitxml=results/regression.xml tests/regression || status=$$?; \
		$(PYTHON) tools/verification_table.py --html build/verification.html $(wildcard results/verify.xml) results/regression.xml; exit $$status

portability:  ## compile both programs and the tests by another compiler, flang, and run unit and regression tests, and cases of solids
	@tools/setup.sh flang-19
	@$(MAKE) $(parallel) build=portable program unit
	@$(MAKE) $(parallel) build=portable dim=3 program
	HAMPM=build/portable/hampm $(PYTHON) -m pytest -q -n $(JOBS) --dist loadgroup -m "not verify" tests/unit tests/regression
	HAMPM=build/portable/hampm HAMPM3D=build/portable3d/hampm3d $(PYTHON) -m pytest -q -n $(JOBS) -m "not verify" $(checks)

coverage:  ## count which lines of src/ the tests run: a table; an error below 90 %
	@tools/setup.sh test
	@$(MAKE) $(parallel) build=coverage program unit
	@$(MAKE) $(parallel) build=coverage dim=3 program unit
	$(PYTHON) tools/coverage.py

sanitize:  ## run unit tests, random input and the coarse cases with AddressSanitizer and UndefinedBehaviorSanitizer
	@tools/setup.sh test
	@$(MAKE) $(parallel) build=sanitize program unit
	$(PYTHON) tools/checked_runs.py sanitize

memcheck:  ## run unit tests and short cases under valgrind
	@tools/setup.sh valgrind
	@$(MAKE) $(parallel) build=memcheck program unit
	$(PYTHON) tools/checked_runs.py memcheck

fuzz:  ## read 1 000 000 namelists and command lines that are changed at random; set every key in scenes over all features; try 1000 runs that go wrong, 50 000 scenes at random, and 10 000 spoilt results and checkpoints each
	@tools/setup.sh test
	@$(MAKE) $(parallel) build=checked program build/checked/fuzz_driver
	$(PYTHON) tests/fuzz/fuzz.py --build checked --cases 1000000 --seed 100
	$(PYTHON) tests/fuzz/every_key.py --program build/checked/hampm
	$(PYTHON) tests/fuzz/runs.py --program build/checked/hampm --cases 1000 --seed 100
	$(PYTHON) tests/fuzz/combinations.py --program build/checked/hampm --cases 5000 --seed 100
	$(PYTHON) tests/fuzz/combinations.py --program build/checked/hampm --cases 370 --seed 46 --cracked
	@$(MAKE) $(parallel) program build=checked dim=3
	$(PYTHON) tests/fuzz/solid_scenes.py --cases 2000 --seed 100
	$(PYTHON) tests/fuzz/solid_keys.py
	$(PYTHON) tests/fuzz/advice.py --program build/checked/hampm --cases 2000
	$(PYTHON) tests/fuzz/growth_scenes.py --program build/checked/hampm --cases 10000 --seed 100
	$(PYTHON) tests/fuzz/rest_scenes.py --program build/checked/hampm --cases 10000 --seed 100
	$(PYTHON) tests/fuzz/shape_scenes.py --program build/checked/hampm --cases 10000 --seed 100
	$(PYTHON) tests/fuzz/meeting_scenes.py --program build/checked/hampm --cases 10000 --seed 100
	$(PYTHON) tests/fuzz/plain_scenes.py --program build/checked/hampm --cases 10000 --seed 100
	$(PYTHON) tests/fuzz/sweep_files.py --program build/checked/hampm --cases 10000 --seed 100
	$(PYTHON) tests/fuzz/checkpoint_files.py --program build/checked/hampm --cases 10000 --seed 100
	build/checked/hampm input/edge_crack.nml --output results --force --quiet
	$(PYTHON) tests/fuzz/result_files.py results/edge_crack.h5 --cases 10000 --seed 100

# The oldest version that reads the snapshots, unless another is named
version ?= 9.4.2
vtk: setup  ## hold the snapshots to another version of VTK than that of requirements/verify.txt: make vtk [version=9.4.2]
	@$(MAKE) $(parallel) $(O)/results_driver
	@test -x build/vtk-$(version)/bin/pytest || { $(PYTHON) -m venv build/vtk-$(version) && \
		build/vtk-$(version)/bin/python -m pip install --quiet --disable-pip-version-check vtk==$(version) \
		-r requirements/run.txt $(shell grep -h '^pytest=' requirements/test.txt); }
	build/vtk-$(version)/bin/python -m pytest -q tests/output

extremes:  ## run the extremes of every part of a scene and write docs/evidence/stability.md
	@tools/setup.sh test
	@$(MAKE) $(parallel) program
	$(PYTHON) bench/extremes.py --output results/extremes --document 1
	tools/figures.sh $(O)/hampm $(PYTHON) --docs stability

tradeoff:  ## measure accuracy against cost for every kind of setting and write docs/evidence/tradeoff.md
	@tools/setup.sh test
	@$(MAKE) $(parallel) program
	$(PYTHON) bench/tradeoff.py --output results/tradeoff --document 1
	$(PYTHON) bench/accuracy.py --fit
	tools/figures.sh $(O)/hampm $(PYTHON) --docs tradeoff

benchmarks:  ## run published benchmarks of the field and write docs/evidence/benchmarks.md, its CSV file and its picture: some minutes on one core
	@tools/setup.sh test
	@$(MAKE) $(parallel) program
	@$(MAKE) $(parallel) program dim=3
	$(PYTHON) tests/benchmarks/exam.py --write
	tools/figures.sh $(O)/hampm $(PYTHON) --docs benchmarks

release-check: setup  ## run all parts of a release that have not passed on this commit, at most 40 minutes each, and write docs/evidence/release.md; parts="test ledger": these
	$(PYTHON) tools/release_check.py $(parts)

setup:  ## install what is missing: compiler, libraries, Python environment
	@tools/setup.sh

lock:  ## resolve the versions of all Python packages anew, for every Python from 3.11.2 on: requirements.lock
	tools/lock.sh

bare:  ## try everything on bare Debians of their own, which debootstrap makes, as root: make bare [suites="bookworm trixie"] [steps="run docs"]
	tools/bare_root.sh $(addprefix --suite ,$(suites)) $(steps)

program: $(PROGRAM)

tools: $(TOOLS) $(DRIVERS)

# flang has no underflow modes
unit: $(UNIT_PROGRAMS) tools $(call objects,$(wildcard bench/*.f90))

clean:  ## remove what was built; results stay
	rm -rf build

# --- objects and programs -----------------------------------------------------------------------------------------------------

# A line for each file that is compiled, with its number among those of src/ in a first build; what the compiler says is shown, and kept in a file beside the object
say = $(if $(V),,@echo "$(1)")
counted = $(if $(filter src/%,$<),$$(n=$$(($$(ls $(O) | grep -c '\.o$$') + 1)); test $$n -gt $(n_sources) || printf '[%d/%d] ' $$n $(n_sources)))
n_sources = $(words $(SOURCES) src/processor.c)
quietly := $(if $(V),,@)
noting = 2> $@.log; status=$$?; cat $@.log >&2; exit $$status

$(PROGRAM): $(O)/main.o
$(PROGRAM): private with := $(ARCHIVES)
$(MEASURED): $(call objects,timing plain_scene minimal_kernel)
$(UNIT_PROGRAMS): $(call objects,$(UNIT_TOOLS))
$(filter-out $(PROGRAM),$(PROGRAMS)): $(O)/%: $(O)/%.o
$(PROGRAMS): $(LIBRARY)
	$(call say,$@)
	$(quietly){ $(if $(with),$(FC) $(filter-out -J%,$(FLAGS)) -o $@ $^ $(with) 2> $@.log || )$(FC) $(filter-out -J%,$(FLAGS)) -o $@ $^ $(HDF5_LINK) $(ALGEBRA_LINK) 2> $@.log; }; \
		status=$$?; cat $@.log >&2; exit $$status

# All laws, indicators, integrators and estimators are given what one of them needs
$(call objects,$(wildcard src/law/*.f90 src/adapt/*.f90 src/time/*.f90 src/fracture/*.f90)): private unused := $(if $(filter portable,$(build)),,-Wno-unused-dummy-argument)
$(KERNELS): private level = $($(build)_kernels)
$(OFTEN): private level = $($(build)_often)
$(SELDOM): private level = $($(build)_seldom)
$(call objects,$(wildcard bench/*.f90)): private level = $(filter-out -flto,$($(build)_kernels))
$(call objects,$(wildcard tests/*/*.f90)): private level = $(if $(filter debug,$(build)),,-Og)

# Arrays of run-time size are in these those of an element, a node or a tip: they need no memory from the heap
small_arrays := basis grid matter recovery element_stiffness element_assembly error_indicator missing_energy expected_error tip_domain \
                domain_integral support_pass support_operators patch crack_closure
ifneq ($(build),portable)
$(addprefix $(O)/,$(addsuffix .o,$(small_arrays))): private stack := -fstack-arrays
endif

$(O)/kinds.o: private dimensions := -cpp -DDIMENSIONS=$(dim)

# A changed flag, here or on the command line, builds everything anew
$(O)/%.o: %.f90 $(O)/flags
	$(call say,$(counted)$(FC) $<)
	$(quietly)$(FC) $(FLAGS) $(level) $(dimensions) $(stack) $(unused) -c -o $@ $< $(noting)

# `+` hands on the jobs of make, and runs the command in a dry run, too
is_dry := $(findstring n,$(firstword -$(MAKEFLAGS)))
$(O)/kernels.o: $(KERNELS) $(OFTEN)
	$(call say,$@)
	+$(quietly)$(if $(is_dry),true || )$(FC) $(FLAGS) $($(build)_often) -fPIE --param inline-unit-growth=100 -flto=auto -r -flinker-output=nolto-rel -o $@ $^ $(noting)

$(O)/processor.o: src/processor.c $(O)/flags
	$(call say,$(counted)$(FC) $<)
	$(quietly)$(if $(filter portable,$(build)),gcc,$(FC)) -Wall -Wextra -O1 $(filter -march=%,$(FLAGS)) -c -o $@ $< $(noting)

# The commit that a program is of. Only the main program has it: nothing else is built anew where it changes
$(O)/main.o: $(O)/version.inc
$(O)/main.o: private unused := -I$(O)
$(O)/version.inc: FORCE
	@mkdir -p $(O)
	@echo "character(*), parameter :: built_version = '$$(tools/version.sh)'" | cmp -s - $@ || \
		echo "character(*), parameter :: built_version = '$$(tools/version.sh)'" > $@

$(O)/flags: private flags = $(FC) $(FLAGS) $(foreach part,kernels often seldom,$($(build)_$(part))) $(if $($(build)_seldom),$(kernels) / $(seldom_folders) $(seldom))
$(O)/flags: FORCE
	@mkdir -p $(O)
	@echo '$(flags)' | cmp -s - $@ || { rm -f $(O)/*.o; echo '$(flags)' > $@; }
FORCE:

$(O)/depends.mk: $(SOURCES) $(UNIT_TESTS) $(UNIT_TOOLS) $(wildcard tests/output/*.f90 tests/fuzz/*.f90 tests/tools/*.f90 bench/*.f90) tools/depends.awk
	@mkdir -p $(O)
	@awk -v folder='$$(O)' -f tools/depends.awk $(filter %.f90,$^) > $@

ifneq ($(filter-out $(TASKS),$(or $(MAKECMDGOALS),help)),)
include $(O)/depends.mk
endif
