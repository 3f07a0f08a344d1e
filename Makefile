# hampm: `make help` lists what there is to do.

build ?= release
O := build/$(build)
FC := gfortran
PYTHON := .venv/bin/python

HDF5_COMPILE ?= -I/usr/include/hdf5/serial
HDF5_LINK ?= -L/usr/lib/$(shell $(FC) -dumpmachine 2>/dev/null)/hdf5/serial -lhdf5_serialhl_fortran -lhdf5_serial_fortran \
             -lhdf5_serial_hl -lhdf5_serial
ALGEBRA_LINK ?= -lumfpack -llapack -lblas
COMMON := -std=f2008 -fimplicit-none -fopenmp -fno-backtrace -Wall -Wextra -Wimplicit-interface -Wno-do-subscript

release := -O3 -march=native -flto=auto -ffat-lto-objects -finline-limit=1000
debug := -O0 -g -fcheck=all -ffpe-trap=invalid,zero,overflow -finit-real=snan
sanitize := -O1 -g -fsanitize=address,undefined -fno-omit-frame-pointer -finit-real=snan
FLAGS := $(COMMON) $($(build)) $(HDF5_COMPILE) -J$(O)

SOURCES := $(wildcard src/*.f90 src/*/*.f90)
UNIT_TESTS := $(wildcard tests/unit/test_*.f90)
UNIT_TOOLS := $(filter-out $(UNIT_TESTS),$(wildcard tests/unit/*.f90))
LIBRARY := $(patsubst %.f90,$(O)/%.o,$(notdir $(filter-out src/main.f90,$(SOURCES))))
UNIT_PROGRAMS := $(patsubst tests/unit/%.f90,$(O)/%,$(UNIT_TESTS))
UNIT_OBJECTS := $(patsubst tests/unit/%.f90,$(O)/%.o,$(UNIT_TOOLS))

# Files compiled, and tests run, at a time
JOBS := $(shell n=$$(nproc 2>/dev/null || echo 1); echo $$((n < 4 ? n : 4)))

VPATH := $(sort $(dir $(SOURCES))) tests/unit tests/output bench

.PHONY: help run figures test bench masses adaptivity program unit setup clean
.DELETE_ON_ERROR:

help:  ## list the targets
	@awk -F ':.*## ' '/^[a-z]+:.*## / {printf "make %-10s %s\n", $$1, $$2}' Makefile

run: setup  ## install what is missing, build, run input/dcb.nml, draw G(t)/G_ref
	@$(MAKE) --no-print-directory program
	$(O)/hampm input/dcb.nml --output results
	$(PYTHON) postprocess/plot_g.py results/dcb.h5 --converged 1.28737 --output results/dcb_G.png
	HAMPM_PYTHON=$(PYTHON) HAMPM_CONVERGED=1.28737 gnuplot -c postprocess/g_of_t.gp results/dcb_G_gnuplot.png results/dcb.h5
	@echo "results/dcb.h5: the results; results/dcb_G.png, results/dcb_G_gnuplot.png: G(t)/G_ref"

# K_I(t) of an input file, and on cells of 0.2 mm refined at the tip: its name, these cells, scale of K_I, axis, what the reference is
comma := ,
refined_once := --set refine.indicator=tip --set refine.rings=12 --set refine.max_level=1 --set grid.cell=0.2e-3
draw_k = $(O)/hampm input/$(1).nml --output results/figures && \
   $(O)/hampm input/$(1).nml --output results/figures $(refined_once) --set grid.cells=$(2) --set output.file=$(1)_refined.h5 && \
   $(PYTHON) postprocess/plot_g.py results/figures/$(1).h5 results/figures/$(1)_refined.h5 --column K_I --scale $(3) --label '$(4)' \
   --reference tests/regression/$(1)/reference.csv --reference-name '$(5)' --time-unit us --dpi 150 --output results/figures/$(1)_K.png

figures: setup  ## draw the mesh around the tip for three R_crit, animate a run, and draw K_I(t) of the verification cases
	@$(MAKE) --no-print-directory program
	$(O)/hampm input/dcb_mesh.nml --output results/figures --set refine.r_crit=0.24 --set output.file=mesh_r024.h5
	$(O)/hampm input/dcb_mesh.nml --output results/figures --set refine.r_crit=0.12 --set refine.max_level=1 \
	   --set output.file=mesh_r012.h5
	$(O)/hampm input/dcb_mesh.nml --output results/figures --set output.file=mesh_r003.h5
	for r in 024 012 003; do \
	   $(PYTHON) postprocess/plot_mesh.py results/figures/mesh_r$$r.h5 -o results/figures/mesh_r$$r.png || exit; done
	$(PYTHON) postprocess/plot_mesh.py $(patsubst %,results/figures/mesh_r%.h5,024 012 003) -o results/figures/mesh.png
	$(PYTHON) postprocess/animate.py results/figures/mesh_r003.h5 --window 12
	$(call draw_k,chen,51$(comma)101,86832,$$K_I / \sigma_0 \sqrt{\pi a}$$,finite elements)
	$(call draw_k,freund,100$(comma)51,128958,$$K_I(t) / K_I(2.6\,H/c_d)$$,closed form)

test: setup  ## install what is missing, build, run all tests
	@$(MAKE) -j$(JOBS) --no-print-directory program unit
	@$(MAKE) -j$(JOBS) --no-print-directory program unit build=debug
	$(PYTHON) -m pytest -q -n $(JOBS) --dist loadgroup tests

bench: setup  ## measure the time per particle and step beside the memory's speed
	@$(MAKE) --no-print-directory $(O)/bench_step
	$(O)/bench_step

masses: setup  ## measure what each mass matrix costs, dissipates and allows as time step
	@$(MAKE) --no-print-directory program
	$(PYTHON) bench/mass_matrices.py --output results/masses

adaptivity: setup  ## measure what refinement reaches on the double cantilever beam, costs and allows
	@$(MAKE) --no-print-directory program
	$(PYTHON) bench/adaptivity.py --output results/adaptivity
	$(PYTHON) bench/refined_meshes.py --output results/adaptivity

setup:  ## install what is missing: compiler, libraries, Python environment
	@tools/setup.sh

program: $(O)/hampm

unit: $(UNIT_PROGRAMS) $(O)/results_driver

clean:  ## remove what was built; results stay
	rm -rf build

$(O)/hampm: $(O)/main.o
$(O)/bench_step: $(O)/bench_step.o
$(O)/results_driver: $(O)/results_driver.o
$(UNIT_PROGRAMS): $(O)/%: $(O)/%.o $(UNIT_OBJECTS)
$(UNIT_PROGRAMS) $(O)/results_driver: LINK := -fno-lto   # many programs, each of which runs for a moment

$(O)/hampm $(O)/bench_step $(O)/results_driver $(UNIT_PROGRAMS): $(LIBRARY)
	$(FC) $(FLAGS) $(LINK) -o $@ $^ $(HDF5_LINK) $(ALGEBRA_LINK)

# A changed flag, here or on the command line, builds everything anew.
$(O)/%.o: %.f90 $(O)/flags
	$(FC) $(FLAGS) -c -o $@ $<

$(O)/flags: FORCE
	@mkdir -p $(O)
	@echo '$(FC) $(FLAGS)' | cmp -s - $@ || echo '$(FC) $(FLAGS)' > $@
FORCE:

$(O)/depends.mk: $(SOURCES) $(UNIT_TESTS) $(UNIT_TOOLS) $(wildcard tests/output/*.f90 bench/*.f90) tools/depends.awk
	@mkdir -p $(O)
	@awk -v folder='$$(O)' -f tools/depends.awk $(filter %.f90,$^) > $@

ifneq ($(filter-out help clean setup run figures test bench masses adaptivity,$(or $(MAKECMDGOALS),help)),)
include $(O)/depends.mk
endif
