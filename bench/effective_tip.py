#!/usr/bin/env python3
"""How far from its node a discrete crack tip acts: K by the interaction integral against the energy release rate.

On the double cantilever beam at rest (mode I) and on the split beam under a moment on one arm (both modes), with cells of several
sizes, several points a cell, Poisson's ratios and both plane conditions, each K is compared with sqrt(E' G) of VCCT
closure, which sees the same mesh. hampm takes K of a tip that lies a part of a cell behind its node: `setback` in
src/fracture/domain_integral.f90. Where that part is right, what is left is of second order in the cells.
"""

import numpy as np
from program_runs import Program
from tables import ROOT, command_line, write

YOUNG = 70e9
CASES = ROOT / "tests/regression"
MODES = {"beam": ["I"], "split beam": ["I", "II"]}


def main():
    arguments = command_line(__doc__, list(MODES), "results/effective_tip")
    for part in arguments.part:
        rows = [["cell [mm]", "points", "poisson", "plane"] + [f"K_{m}/sqrt(E'G) - 1 [%]" for m in MODES[part]]]
        for cell, points, poisson, plane in variants(part):
            history = at_rest(Program(arguments.program, arguments.output), part, cell, points, poisson, plane)
            modulus = YOUNG / (1 - poisson**2) if plane == "strain" else YOUNG
            errors = [abs(history[f"K_{m}"]) / np.sqrt(modulus * abs(history[f"G_vcct_{m}"])) - 1 for m in MODES[part]]
            rows.append([cell, points, poisson, plane] + [f"{100 * error:.2f}" for error in errors])
        write(rows, part.replace(" ", "_"), arguments.output)


def variants(part):
    """Cell [mm], points a cell and direction, Poisson's ratio, plane condition."""
    cells = [2.5, 1.25, 0.625] if part == "beam" else [1.25, 0.625, 0.3125]
    middle = cells[1]
    return ([(cell, 2, 0.3, "stress") for cell in cells] + [(middle, points, 0.3, "stress") for points in (3, 4)]
            + [(middle, 2, poisson, "stress") for poisson in (0.0, 0.45)] + [(middle, 2, 0.3, "strain")])


def at_rest(program, part, cell, points, poisson, plane):
    """The last values of the columns of a run."""
    case, root, cells = {"beam": ("dcb_static", 1.25, (80, 9)), "split beam": ("mixed_mode", 1.25, (41, 24))}[part]
    count = [int(np.ceil(n * root / cell)) for n in cells]
    overrides = [f"grid.cell={cell}e-3", f"grid.cells={count[0]},{count[1]}", f"body.points_per_cell={points}",
                 f"material.poisson={poisson}", f"run.plane={plane}", "refine.indicator=none",
                 "energy_release.radii=6.0e-3,7.5e-3,9.0e-3"]
    return program(CASES / case / "case.nml", overrides).last


if __name__ == "__main__":
    main()
