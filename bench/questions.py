"""What a user asks, in two versions of the program: processor time of whole runs, in turns, and what their numbers differ by.

Each question is one run that a user would make for an error that docs/how-to/choosing.md names. `difference` is the largest of what columns of
the two histories differ by, over the largest value of the column: only columns of G, K and J count. `error` is that of the later version
where there is an independent solution. The ratio is the median of those of turns that follow each other, with the middle half of them.

Run by `make -C bench questions before=PROGRAM`, or for some of them:
.venv/bin/python bench/questions.py "slanted 0.05 %" --before PROGRAM
"""

import os
import re
import resource
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import NamedTuple

import h5py
import numpy as np
from cracks import direction, rows, scene
from tables import ROOT, command_line, write

INPUT = ROOT / "input"
A = 8e-3  # half-length of the slanted crack [m]
STATIC = ("method.time=static",)
QUADRATIC = ("grid.order=2", "body.points_per_cell=3")
G_OF_T = ("method.frame=total", "method.courant=0", "energy_release.energy_balance=.false.", "energy_release.estimators=domain_integral",
          "output.snapshot_interval=0", "output.history_interval=1e-6", "run.end_time=6e-4", "damping.rate=0")


class Question(NamedTuple):
    """A run, and the factors K_I, K_II that are expected of its first tip, where they are known [Pa sqrt(m)]."""

    source: object     # path of a namelist, or its text
    settings: tuple = ()
    expected: tuple = ()


def tip(levels, rings):
    """Settings of cells that are refined around tips."""
    return ("refine.indicator=tip", f"refine.max_level={levels}", f"refine.rings={rings}")


def slanted(cells, levels, rings, *more):
    """A slanted crack of 30 degrees in the middle of a plate, the largest cell so many times in its half-length."""
    row = next(row for row in rows("a2_slanted_centre_plate.csv") if row["case"] == "beta=30" and row["tip"] == "1")
    return Question(scene([[-A * direction(30), A * direction(30)]], A / cells, levels=levels, rings=rings), more,
                    (float(row["K_I"]), float(row["K_II"])))


def beam(cells, *more):
    """G(t) of the beam of the paper, undamped, so many cells an arm."""
    return Question(INPUT / "dcb.nml", (*G_OF_T, f"grid.cell={0.01 / cells!r}", f"grid.cells={10 * cells},{cells + 1}", *more))


def quadratic_beam(cells, levels, step):
    """The same by quadratic cells in implicit steps [s], by closing the crack."""
    return beam(cells, *QUADRATIC, *tip(levels, 1), "method.time=implicit", f"method.time_step={step!r}", "energy_release.estimators=vcct",
                "run.end_time=7.2e-4")


def grown(name, *more):
    """An example of growth."""
    return Question(INPUT / f"{name}.nml", ("output.snapshot_interval=0", *more))


QUESTIONS = {
    "slanted 0.05 %": slanted(2, 4, 2, *QUADRATIC),
    "slanted 0.005 %": slanted(4, 6, 1, *QUADRATIC),
    "slanted, bilinear": slanted(8, 3, 8),
    "centre crack at rest": Question(ROOT / "tests/regression/centre_crack/case.nml", (*STATIC, "method.frame=total", *tip(3, 4), "output.snapshot_interval=0",
                                                                                   "energy_release.estimators=vcct,domain_integral")),
    "beam at rest": Question(INPUT / "dcb.nml", (*STATIC, "method.frame=total", *QUADRATIC, *tip(6, 2), "grid.cell=2.5e-3", "grid.cells=40,5",
                                                 "energy_release.estimators=vcct,domain_integral", "energy_release.energy_balance=.false.",
                                                 "output.snapshot_interval=0")),
    "G(t), uniform": beam(12),
    "G(t), one level": beam(8, *tip(1, 8)),
    "G(t), implicit": beam(4, "method.time=implicit", "method.mass=consistent", "method.time_step=0.25e-6", *tip(6, 2)),
    "G(t), 0.35 %": quadratic_beam(2, 4, 0.5e-6),
    "G(t), 0.07 %": quadratic_beam(4, 6, 0.25e-6),
    "freund_growth": grown("freund_growth"),
    "strip_growth": grown("strip_growth"),
    "two_cracks": grown("two_cracks"),
    "dcb": Question(INPUT / "dcb.nml"),
}


def run(program, question, folder):
    """Processor time of a run [s], and the history that it writes."""
    source = question.source
    if isinstance(source, str):
        source = folder / "scene.nml"
        source.write_text(question.source)
    words = [program, source, *(word for setting in (*question.settings, "output.file=scene.h5") for word in ("--set", setting)),
             "--force", "--quiet", "--threads", "1", "--output", folder]
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    end = subprocess.run([str(word) for word in words], capture_output=True, text=True,
                         env=os.environ | {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"})
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    if end.returncode:
        sys.exit(f"{words} has ended with {end.returncode}: {end.stderr}")
    with h5py.File(folder / "scene.h5") as file:
        history = {name: column[...] for name, column in file["history"].items()}
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, history


def difference(before, after):
    """The largest difference of the columns of G, K and J that both have, over the largest value of each."""
    largest = 0.0
    for name in sorted(set(before) & set(after)):
        if not re.match(r"[GKJ](_|$)", name) or name.endswith(("error", "dependence")):
            continue
        a, b = before[name], after[name]
        n = min(len(a), len(b))
        size = np.nanmax(np.abs(a), initial=0.0)
        if "_II" in name:  # which symmetry may make zero
            size = max(size, np.nanmax(np.abs(before[name.replace("_II", "_I", 1)])))
        if n and size > 0:
            largest = max(largest, float(np.nanmax(np.abs(a[:n] - b[:n]))) / size)
    return largest


def error(question, history):
    """Error of K of the first tip over its size [%], '' where it is not known."""
    if not question.expected:
        return ""
    k = np.array([history["K_I"][-1], history["K_II"][-1]])
    return f"{100 * np.linalg.norm(k - question.expected) / np.linalg.norm(question.expected):.4f}"


def main():
    arguments = command_line(__doc__, list(QUESTIONS), "results/questions", before=(Path(), "the program of the earlier version"),
                             turns=(5, "runs of each version for each question"))
    table = [["question", "before [s]", "after [s]", "ratio", "middle half", "difference", "error [%]"]]
    for name in arguments.part:
        question = QUESTIONS[name]
        with tempfile.TemporaryDirectory() as folder:
            pairs = [(run(arguments.before.resolve(), question, Path(folder)), run(arguments.program.resolve(), question, Path(folder)))
                     for _ in range(arguments.turns)]
        ratios = sorted(after[0] / before[0] for before, after in pairs)
        quarter = len(ratios) // 4
        table.append([name, *(f"{statistics.median(pair[side][0] for pair in pairs):.3f}" for side in (0, 1)), f"{statistics.median(ratios):.2f}",
                      f"{ratios[quarter]:.2f} to {ratios[-1 - quarter]:.2f}", f"{difference(pairs[-1][0][1], pairs[-1][1][1]):.1e}",
                      error(question, pairs[-1][1][1])])
        print(*table[-1], sep="  ", flush=True)
    write(table, "questions", arguments.output)


if __name__ == "__main__":
    main()
