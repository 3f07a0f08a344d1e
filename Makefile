# hampm: `make help` lists what there is to do.

build ?= release
O := build/$(build)
FC := gfortran
PYTHON := .venv/bin/python

HDF5_LINK ?= -L/usr/lib/$(shell $(FC) -dumpmachine 2>/dev/null)/hdf5/serial -lhdf5_serial
ALGEBRA_LINK ?= -lumfpack -lcholmod -llapack -lblas
COMMON := -std=f2008 -fimplicit-none -fopenmp -fno-backtrace -Wall -Wextra -Wimplicit-interface -Wno-do-subscript

# Vectors of 512 bits are no faster on the processors that have them: cells come in blocks of four
width := $(if $(filter x86_64,$(shell uname -m)),-mprefer-vector-width=256)
# Kernels that several procedures call are to be put into all of them
release := -O3 --param inline-unit-growth=100 -fno-tree-loop-distribute-patterns -march=native $(width) -flto=auto -ffat-lto-objects -finline-limit=1000
debug := -O0 -g -fcheck=all -ffpe-trap=invalid,zero,overflow -finit-real=snan
# To be run under valgrind, which does not know every processor's instructions; the run apart, so that what it calls is
# counted by procedure
counted := $(subst -march=native,$(if $(filter x86_64,$(shell uname -m)),-march=x86-64-v3),$(release)) -g
counted_run := -fno-lto -fno-inline
counted_recording := $(counted_run)
counted_mesh_changes := $(counted_run)
counted_simulation := $(counted_run)
sanitize := -O1 -g -fsanitize=address,undefined -fno-omit-frame-pointer -finit-real=snan
# The checks of the debug build at half of its cost: of the tests, and of many short runs
checked := -O2 -g -fcheck=all,no-array-temps -ffpe-trap=invalid,zero,overflow -finit-real=snan
# To be run under valgrind, which knows what was never set
memcheck := -O1 -g
# Threads that count at once lose counts, never the first one
coverage := -O1 -g --coverage
FLAGS := $(COMMON) $($(build)) -J$(O)

SOURCES := $(wildcard src/*.f90 src/*/*.f90)
UNIT_TESTS := $(wildcard tests/unit/test_*.f90)
UNIT_TOOLS := $(filter-out $(UNIT_TESTS),$(wildcard tests/unit/*.f90))
LIBRARY := $(patsubst %.f90,$(O)/%.o,$(notdir $(filter-out src/main.f90,$(SOURCES))))
UNIT_PROGRAMS := $(patsubst tests/unit/%.f90,$(O)/%,$(UNIT_TESTS))
UNIT_OBJECTS := $(patsubst tests/unit/%.f90,$(O)/%.o,$(UNIT_TOOLS))

# Files compiled, and tests run, at a time
JOBS := $(shell n=$$(nproc 2>/dev/null || echo 1); echo $$((n < 4 ? n : 4)))

VPATH := $(sort $(dir $(SOURCES))) tests/unit tests/output tests/fuzz bench

# Targets that compile nothing themselves
TASKS := help setup clean run figures sweep slurm docs structure test verify coverage sanitize memcheck fuzz \
         bench against minimal peers masses adaptivity extremes tradeoff local_steps static quadratic implicit cracks growth tip vtk errors estimates domains contact
.PHONY: $(TASKS) program unit
.DELETE_ON_ERROR:

help:  ## list the targets
	@awk -F ':.*## ' '/^[a-z_]+:.*## / {printf "make %-11s %s\n", $$1, $$2}' Makefile

run: setup  ## install what is missing, build, run input/dcb.nml, draw G(t)/G_ref
	@$(MAKE) --no-print-directory program
	$(O)/hampm input/dcb.nml --output results --force
	$(PYTHON) postprocess/plot_g.py results/dcb.h5 --converged 1.28737 --output results/dcb_G.png
	HAMPM_PYTHON=$(PYTHON) HAMPM_CONVERGED=1.28737 gnuplot -c postprocess/g_of_t.gp results/dcb_G_gnuplot.png results/dcb.h5
	@echo "results/dcb.h5: the results; results/dcb_G.png, results/dcb_G_gnuplot.png: G(t)/G_ref"

figures: setup  ## draw the pictures of the docs in results/, listed in tools/figures.txt; with DOCS=1 replace those in docs/
	@$(MAKE) --no-print-directory program
	tools/figures.sh $(O)/hampm $(PYTHON) $(if $(DOCS),--docs)

sweep: setup  ## run the cases of a sweep on all cores and make its table: make sweep file=input/dcb_sweep.yaml
	@$(MAKE) --no-print-directory program
	@test -x .venv/bin/snakemake || { echo "batches need Python 3.11 or later: remove .venv, put one first in PATH"; exit 1; }
	.venv/bin/snakemake -s batch/Snakefile --cores all --config sweep=$(or $(file),input/dcb_sweep.yaml) program=$(O)/hampm

slurm: setup  ## run sweeps on a real Slurm of this machine, with jobs that are cancelled, killed, preempted and at their limit of time
	@$(MAKE) --no-print-directory program
	@test -x .venv/bin/snakemake || { echo "batches need Python 3.11 or later: remove .venv, put one first in PATH"; exit 1; }
	$(PYTHON) tools/slurm.py $(parts)

docs: setup  ## write pages of every module, type and procedure of src/: build/api/index.html
	$(PYTHON) tools/api_pages.py

structure:  ## count lines, arguments and uses between the folders of src/, and draw docs/rooms.svg
	$(PYTHON) tools/structure.py
	$(PYTHON) tools/structure.py --svg docs/rooms.svg

test: setup  ## install what is missing, build, run all tests
	@$(MAKE) -j$(JOBS) --no-print-directory program $(patsubst %,build/release/test_%,manufactured crossing_levels patch)
	@$(MAKE) -j$(JOBS) --no-print-directory program unit build=checked build/checked/bench_step
	@! command -v valgrind >/dev/null || $(MAKE) -j$(JOBS) --no-print-directory build=counted build/counted/bench_step
	$(PYTHON) -m pytest -q -n $(JOBS) --dist loadgroup -m "not verify" tests

verify: setup  ## run the tests that take long, which `make test` leaves out, and write the table of docs/verification.md
	@$(MAKE) -j$(JOBS) --no-print-directory program unit
	@$(MAKE) -j$(JOBS) --no-print-directory program unit build=checked
	$(PYTHON) -m pytest -q -n $(JOBS) --dist loadgroup -m verify --junitxml=results/verify.xml tests
	$(PYTHON) tools/verification_table.py results/verify.xml docs/verification.md

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
vtk: setup  ## hold the snapshots to another version of VTK than that of requirements.txt: make vtk [version=9.4.2]
	@$(MAKE) --no-print-directory $(O)/results_driver
	@test -x build/vtk-$(version)/bin/pytest || { $(PYTHON) -m venv build/vtk-$(version) && \
		build/vtk-$(version)/bin/python -m pip install --quiet --disable-pip-version-check vtk==$(version) \
		$(shell grep -E '^(numpy|h5py|pytest)=' requirements.txt); }
	build/vtk-$(version)/bin/python -m pytest -q tests/output

bench:  ## measure time, memory and instructions of a step beside the least that they could be: one table
	@tools/setup.sh valgrind
	@$(MAKE) --no-print-directory $(O)/bench_step
	@$(MAKE) --no-print-directory build=counted program build/counted/bench_step
	$(PYTHON) bench/speed.py --program $(O)/bench_step --output results

against: setup  ## hold results, instructions and time to those of an earlier version: make against before=REV [parts="results time"]
	@tools/setup.sh valgrind
	@test -n "$(before)" || { echo "beside which version? make against before=REV"; exit 1; }
	$(PYTHON) bench/against.py $(parts) --before $(before)

peers: setup  ## measure a step beside those of others, in C and in Python with numba, which it installs
	@$(MAKE) --no-print-directory $(O)/bench_step
	@$(PYTHON) -c 'import numba' 2>/dev/null || $(PYTHON) -m pip install --quiet --disable-pip-version-check -r bench/peers/requirements.txt
	$(PYTHON) bench/peers.py --output results/peers

minimal: setup  ## measure the least that a plain step needs beside what the program takes
	@$(MAKE) --no-print-directory $(O)/minimal_step
	$(O)/minimal_step

masses: setup  ## measure what each mass matrix costs, dissipates and allows as time step
	@$(MAKE) --no-print-directory program
	$(PYTHON) bench/mass_matrices.py --output results/masses

adaptivity: setup  ## measure what refinement reaches on the double cantilever beam, costs and allows
	@$(MAKE) --no-print-directory program
	$(PYTHON) bench/adaptivity.py --output results/adaptivity
	$(PYTHON) bench/refined_meshes.py --output results/adaptivity

extremes: setup  ## run the extremes of every part of a scene and write docs/stability.md
	@$(MAKE) --no-print-directory program
	$(PYTHON) bench/extremes.py --output results/extremes --document 1
	tools/figures.sh $(O)/hampm $(PYTHON) --docs stability

tradeoff: setup  ## measure accuracy against cost for every kind of setting and write docs/tradeoff.md
	@$(MAKE) --no-print-directory program
	$(PYTHON) bench/tradeoff.py --output results/tradeoff --document 1
	tools/figures.sh $(O)/hampm $(PYTHON) --docs tradeoff

local_steps: setup  ## measure what time steps that fit the size of the cells cost and change
	@tools/setup.sh valgrind
	@$(MAKE) --no-print-directory program
	@$(MAKE) --no-print-directory build=counted program
	$(PYTHON) bench/local_time_steps.py --output results/local_time_steps

static: setup  ## measure what equilibrium costs, and how near to it damped motions come
	@$(MAKE) --no-print-directory program
	$(PYTHON) bench/static.py

quadratic: setup  ## measure what quadratic cells give and cost
	@$(MAKE) --no-print-directory program
	$(PYTHON) bench/quadratic.py --output results/quadratic

implicit: setup  ## measure what implicit steps reach and cost
	@$(MAKE) --no-print-directory program
	$(PYTHON) bench/implicit.py --output results/implicit

cracks: setup  ## hold K and G of cracks that ignore the grid to independent solutions
	@$(MAKE) --no-print-directory program
	$(PYTHON) bench/cracks.py --output results/cracks

growth: setup  ## hold cracks that grow in motion to exact solutions
	@$(MAKE) --no-print-directory program
	$(PYTHON) bench/growth.py --output results/growth

tip: setup  ## measure how far from its node the discrete crack tip acts
	@$(MAKE) --no-print-directory program
	$(PYTHON) bench/effective_tip.py --output results/effective_tip

errors: setup  ## hold the estimated errors of G, J and K to the true ones on specimens with known G
	@$(MAKE) --no-print-directory program
	$(PYTHON) bench/error_specimens.py --output results/error_specimens

estimates: setup  ## ask of random cracked specimens of many kinds whether estimated errors cover the true ones; number=16 of each kind
	@$(MAKE) --no-print-directory program
	$(PYTHON) bench/estimate_coverage.py --output results/estimates $(if $(number),--number $(number))

domains: setup  ## hold particles with domains to what large deformation should give, and measure what they cost
	@$(MAKE) --no-print-directory program
	$(PYTHON) bench/domains.py

contact: setup  ## hold bodies that meet to what they should do
	@$(MAKE) --no-print-directory program
	$(PYTHON) bench/body_contact.py

setup:  ## install what is missing: compiler, libraries, Python environment
	@tools/setup.sh

program: $(O)/hampm $(O)/forced_step $(O)/newton_steps $(O)/eigenvalue_limit

unit: $(UNIT_PROGRAMS) $(O)/results_driver $(O)/fuzz_driver $(patsubst bench/%.f90,$(O)/%.o,$(wildcard bench/*.f90))

clean:  ## remove what was built; results stay
	rm -rf build

$(O)/hampm: $(O)/main.o
$(O)/bench_step $(O)/minimal_step: $(O)/%: $(O)/%.o $(addprefix $(O)/,timing.o plain_scene.o minimal_kernel.o)
$(O)/results_driver $(O)/fuzz_driver $(O)/forced_step $(O)/newton_steps $(O)/eigenvalue_limit: $(O)/%: $(O)/%.o
$(UNIT_PROGRAMS): $(O)/%: $(O)/%.o $(UNIT_OBJECTS)
$(UNIT_PROGRAMS) $(O)/results_driver $(O)/fuzz_driver $(O)/forced_step $(O)/newton_steps $(O)/eigenvalue_limit: LINK := -fno-lto   # many programs, each of which runs for a moment

$(O)/hampm $(O)/forced_step $(O)/newton_steps $(O)/eigenvalue_limit $(O)/bench_step $(O)/minimal_step $(O)/results_driver $(O)/fuzz_driver $(UNIT_PROGRAMS): $(LIBRARY)
	$(FC) $(FLAGS) $(LINK) -o $@ $^ $(HDF5_LINK) $(ALGEBRA_LINK)

# All integrators are given what one of them needs
$(addprefix $(O)/,$(addsuffix .o,integrator explicit implicit local_leapfrog static crack_closure path_closure)): private quiet := -Wno-unused-dummy-argument

# A changed flag, here or on the command line, builds everything anew.
$(O)/%.o: %.f90 $(O)/flags
	$(FC) $(FLAGS) $($(build)_$*) $(quiet) -c -o $@ $<

$(O)/flags: FORCE
	@mkdir -p $(O)
	@echo '$(FC) $(FLAGS)' | cmp -s - $@ || echo '$(FC) $(FLAGS)' > $@
FORCE:

$(O)/depends.mk: $(SOURCES) $(UNIT_TESTS) $(UNIT_TOOLS) $(wildcard tests/output/*.f90 tests/fuzz/*.f90 bench/*.f90) tools/depends.awk
	@mkdir -p $(O)
	@awk -v folder='$$(O)' -f tools/depends.awk $(filter %.f90,$^) > $@

ifneq ($(filter-out $(TASKS),$(or $(MAKECMDGOALS),help)),)
include $(O)/depends.mk
endif
