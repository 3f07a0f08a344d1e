"""What time steps that fit the size of the cells cost and change on the refined double cantilever beam.

    cost     user time and instructions against those of common steps, measured in turn
    motion   first frequency and G(t) without damping, against common steps of half the length

Run by `make local_steps`, or for one part: .venv/bin/python bench/local_time_steps.py cost. Instructions need
`make build=counted program` and valgrind.
"""

import statistics
import sys

from instructions import can_count, run_counted
from mass_matrices import Program
from tables import ROOT, command_line, write

sys.path.insert(0, str(ROOT / "postprocess"))
CASE = ROOT / "tests/regression/dcb_refined/case.nml"
COUNTED = ROOT / "build/counted/hampm"
BEAMS = {"5 mm, 6 levels, 4 rings": [],
         "2.5 mm, 4 levels, 8 rings": ["grid.cell=2.5e-3", "grid.cells=40,5", "refine.max_level=4", "refine.rings=8"]}
STEPS = ("global", "local")


def settings(steps, courant=0.5, interval=1e-5):
    return [f"method.time_steps={steps}", f"method.courant={courant}", f"output.history_interval={interval}",
            "energy_release.estimators='nodal_force'", "output.file=local.h5"]


def count(folder, beam, steps):
    """Instructions from 20 to 60 us of a run: without the start."""
    counts = []
    for end in (2e-5, 6e-5):
        words = [word for item in [*beam, *settings(steps), f"run.end_time={end}"] for word in ("--set", item)]
        counts.append(run_counted(COUNTED, CASE, "--quiet", "--output", folder, *words)[1])
    return counts[1] - counts[0]


def cost(program, repeats):
    rows = [("beam", "common: CPU [s]", "local", "ratio", "common: instructions", "local", "ratio", "target", "met")]
    for name, beam in BEAMS.items():
        times = [[program(CASE, [*beam, *settings(steps)])[0] for steps in STEPS] for _ in range(repeats)]
        ratio = statistics.median(local / common for common, local in times)
        counted = ("", "", "")
        if can_count() and COUNTED.is_file():
            counts = [count(program.folder, beam, steps) for steps in STEPS]
            counted = (f"{counts[0]:.3e}", f"{counts[1]:.3e}", f"{counts[1] / counts[0]:.3f}")
        target = ("0.5", "yes" if ratio <= 0.5 else "NO") if not beam else ("", "")
        rows.append((name, *(f"{statistics.median(column):.2f}" for column in zip(*times)), f"{ratio:.2f}", *counted, *target))
    return rows


def motion(program):
    import numpy as np
    from history import History, first_frequency
    beam = [*BEAMS["2.5 mm, 4 levels, 8 rings"], "damping.rate=0", "run.end_time=1.2e-3"]

    def history(steps, courant):
        program(CASE, [*beam, *settings(steps, courant, 2e-6)])
        return History(program.folder / "local.h5").columns

    reference = history("global", 0.25)["G_nodal_force_I"]
    rows = [("steps", "courant", "f1 [Hz]", "rms difference of G(t)")]
    for steps, courant in (("global", 0.5), ("local", 0.5), ("local", 0.25)):
        columns = history(steps, courant)
        difference = np.sqrt(np.mean((columns["G_nodal_force_I"] - reference)**2) / np.mean(reference**2))
        rows.append((steps, courant, f"{first_frequency(columns['time'], columns['crack_opening']):.2f}", f"{difference:.4f}"))
    return rows


def main():
    arguments = command_line(__doc__, ["cost", "motion"], "results/local_time_steps",
                             repeats=(5, "measurements of a time, of which the median"))
    program = Program(arguments.program, arguments.output.resolve())
    if "cost" in arguments.part:
        write(cost(program, arguments.repeats), "cost", arguments.output)
    if "motion" in arguments.part:
        write(motion(program), "motion", arguments.output)


if __name__ == "__main__":
    main()
