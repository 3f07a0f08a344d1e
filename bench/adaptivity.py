"""What refinement by itself reaches on the double cantilever beam at rest, beside cells that are refined around the tip.

    known      meshes refined around the tip before the run: what is asked of the others
    gradient   from the unrefined grid, by the gradient of a field
    zz         from the unrefined grid, by the estimated error, with its effectivity index
    uniform    uniform grids, from which the strain energy is extrapolated

The effectivity index is the estimated over the true error in the energy norm. The true one is that of the strain energy U,
sqrt(1 - U/U_ref), with U_ref extrapolated from the uniform grids.

Run by `make -C bench adaptivity`, or for some parts: .venv/bin/python bench/adaptivity.py zz --output DIR
"""

import math

from program_runs import Program
from tables import ROOT, command_line, write

SCENE = ROOT / "tests/regression/dcb_settled/case.nml"
G_RATIO = 1.28737  # converged G/G_ref, tests/reference/dcb_static.csv
SETTINGS = {  # the beam is loaded, comes to rest, and is then looked at
    "load.history": "ramp", "load.rise_time": 4e-4, "run.end_time": 1.5e-3, "output.history_interval": 1e-5,
    "method.scheme": "usl", "method.courant": 0.3, "energy_release.estimators": "vcct", "energy_release.energy_balance": ".false."}
LOOKS = {"refine.start": 9e-4}
REGION = {"refine.region_lower": "0.04, 0", "refine.region_upper": "0.06, 0.01"}
KNOWN = [(5e-3, 6, 4), (2.5e-3, 4, 8)]  # cell, levels, rings
GRADIENT = [  # cell, asked error of G [%], asked particles, settings
    (5e-3, 0.8, 2272, {"field": "stress_norm", "max_level": 6, "r_crit": 0.01, "energy_floor": 0.2}),
    (5e-3, 0.8, 2272, {"field": "energy_density", "max_level": 6, "r_crit": 0.02, "energy_floor": 0.05}),
    (2.5e-3, 0.35, 6016, {"field": "stress_norm", "max_level": 4, "r_crit": 0.0022, "energy_floor": 0.135}),
    (2.5e-3, 0.35, 6016, {"field": "stress_norm", "max_level": 4, "r_crit": 0.002, "energy_floor": 0.13}),
    (2.5e-3, 0.35, 6016, {"field": "energy_density", "max_level": 4, "r_crit": 0.015, "energy_floor": 0.02})
]
ZZ = [(0.1, 6), (0.05, 6), (0.03, 7)]  # tolerance, levels


def run(program, cell, settings):
    """The last values of the history, with the error of G [%] and the processor time [s]."""
    columns = round(0.1 / cell)
    done = program(SCENE, {"grid.cell": cell, "grid.cells": f"{columns}, {columns // 10 + 1}", **SETTINGS, **settings})
    return done.last | {"error": 100 * (done.last["G_vcct_I"] / done.attributes["G_ref"] / G_RATIO - 1), "seconds": done.seconds}


def cost(h):
    return f"{h['particles']:.0f}", f"{h['finest_cell'] * 1e3:.3f}", f"{h['seconds']:.1f}"


def known(program):
    """Cells around the tip, from the start: scheme and step as elsewhere here."""
    rows = [("cell [mm]", "levels", "rings", "error of G [%]", "particles", "finest cell [mm]", "CPU [s]")]
    for cell, levels, rings in KNOWN:
        h = run(program, cell, {"refine.indicator": "tip", "refine.max_level": levels, "refine.rings": rings})
        rows.append((f"{cell * 1e3:g}", levels, rings, f"{h['error']:+.3f}", *cost(h)))
    return rows


def gradient(program):
    rows = [("cell [mm]", "settings", "asked error of G [%]", "measured", "asked particles", "measured", "finest cell [mm]",
             "CPU [s]")]
    for cell, asked, particles, settings in GRADIENT:
        keys = {"refine.indicator": "gradient", "refine.interval": 100} | LOOKS | {
            f"refine.{key}": value for key, value in settings.items()} | REGION
        h = run(program, cell, keys)
        text = " ".join(f"{key}={value}" for key, value in settings.items())
        rows.append((f"{cell * 1e3:g}", text, asked, f"{h['error']:+.3f}", particles, *cost(h)))
    return rows


def uniform(program):
    """Table of the uniform grids, and the strain energy extrapolated from them [J]."""
    rows = [("cell [mm]", "strain energy [J]", "order", "error of G [%]", "relative error", "estimate", "index", "particles",
             "finest cell [mm]", "CPU [s]")]
    cells = (5e-3, 2.5e-3, 1.25e-3, 0.625e-3)
    runs = [run(program, cell, {"refine.indicator": "zz", "refine.tolerance": 0.99}) for cell in cells]
    energy = [h["strain_energy"] for h in runs]
    reference = list(energy)
    for order in (1, 2, 3):  # the crack's terms c and the smooth ones
        reference = [(2**order * fine - coarse) / (2**order - 1) for coarse, fine in zip(reference, reference[1:])]
    for k, (cell, h) in enumerate(zip(cells, runs)):
        order = ""
        if k > 1:
            order = f"{math.log2((energy[k - 1] - energy[k - 2]) / (energy[k] - energy[k - 1])):.2f}"
        rows.append((f"{cell * 1e3:g}", f"{energy[k]:.5e}", order, f"{h['error']:+.3f}", *index(h, reference[0]), *cost(h)))
    rows.append(("0, extrapolated", f"{reference[0]:.5e}") + ("",) * 8)
    return rows, reference[0]


def index(h, reference):
    """True and estimated relative error in the energy norm, and their ratio."""
    true = math.sqrt(max(0.0, 1 - h["strain_energy"] / reference))
    return f"{true:.4f}", f"{h['error_estimate']:.4f}", f"{h['error_estimate'] / true:.2f}" if true > 0 else "none"


def zz(program, reference):
    rows = [("tolerance", "levels", "error of G [%]", "relative error", "estimate", "index, asked 0.7 to 1.5", "particles",
             "finest cell [mm]", "CPU [s]")]
    for tolerance, levels in ZZ:
        keys = {"refine.indicator": "zz", "refine.tolerance": tolerance, "refine.max_level": levels, "refine.interval": 400}
        h = run(program, 5e-3, keys | LOOKS)
        rows.append((tolerance, levels, f"{h['error']:+.3f}", *index(h, reference), *cost(h)))
    return rows


def main():
    arguments = command_line(__doc__, ["known", "gradient", "zz"], "results/adaptivity")
    program = Program(arguments.program, arguments.output)
    if "known" in arguments.part:
        write(known(program), "known", arguments.output)
    if "gradient" in arguments.part:
        write(gradient(program), "gradient", arguments.output)
    if "zz" in arguments.part:
        rows, reference = uniform(program)
        write(rows, "uniform", arguments.output)
        write(zz(program, reference), "zz", arguments.output)


if __name__ == "__main__":
    main()
