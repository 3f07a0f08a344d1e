"""Instructions of whole runs, from the namelist to the result: what users ask, each question by a model of input/ that is made short.

The counts are those of valgrind's callgrind on one thread, and do not depend on how busy the machine is. A run counts as a whole: reading,
building, steps or equilibrium, measuring, writing; only what is flushed before the end is left out, as the clock decides on it.

    .venv/bin/python bench/whole_runs.py [QUESTION ...]                           # count
    .venv/bin/python bench/whole_runs.py [QUESTION ...] --before PLANE SOLIDS     # beside earlier programs: ratio, largest difference of G, K and J
    .venv/bin/python bench/whole_runs.py [QUESTION ...] --ledger                  # hold the release to bench/ledger.csv
    .venv/bin/python bench/whole_runs.py [QUESTION ...] --why REASON              # write in the questions that cost more or less now

The ledger has what each question costs, the error that it then has, and why either has changed. The error is the estimated error of G over G, means
over the rows of the history, of tips and of fronts. Memory is the most that a run takes. Counts are held to rows of the same compiler only.
"""

import argparse
import csv
import datetime
import re
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import NamedTuple

import h5py
import numpy as np
from instructions import can_count, costs_of_calls, run_counted
from tables import ROOT, write

INPUT = ROOT / "input"
FLUSHES = "__hampm_results_MOD_flush_results"
LEDGER = ROOT / "bench" / "ledger.csv"
MOST, LEAST = 1.01, 0.97  # of the instructions of the ledger: beyond, a change has cost something; below, its gain is to be written in


class Question(NamedTuple):
    """A model of input/ and its settings."""

    model: str
    settings: tuple = ()

    @property
    def is_solid(self):
        return self.model.startswith("solid/")


ONE_STEP = "run.end_time=1", "method.load_steps=1", "output.snapshot_interval=0"


def at_rest(levels, *more):
    """Settings of a beam at rest, refined around its tip."""
    return ("method.time=static", "method.frame=total", "refine.indicator=tip", f"refine.max_level={levels}", "refine.rings=4", "energy_release.energy_balance=.false.",
            "output.snapshot_interval=0", *more)


def moving(end, *more):
    """Settings of a motion that ends early [s], without snapshots."""
    return (f"run.end_time={end}", "output.snapshot_interval=0", *more)


QUESTIONS = {
    "K at rest, DCB": Question("dcb", at_rest(3)),
    "K at rest, slanted": Question("two_cracks", ONE_STEP),
    "K at rest, quadratic cells": Question("dcb", at_rest(4, "grid.order=2", "body.points_per_cell=3", "grid.cell=2.5e-3", "grid.cells=40,5", "energy_release.estimators=vcct,domain_integral")),
    "path at rest": Question("bend_path", (*ONE_STEP, "grid.cell=2e-3", "grid.cells=62,17")),
    "fatigue": Question("fatigue_centre_crack", (*ONE_STEP, "refine.max_level=2")),
    "nucleation": Question("v_notch", (*ONE_STEP, "refine.max_level=6", "growth.increment=6.25e-5", "nucleation.increment=3.125e-5")),
    "G(t), explicit": Question("dcb", moving(4e-5, "method.frame=total")),
    "G(t), implicit": Question("dcb", moving(1e-4, "method.frame=total", "method.time=implicit", "method.courant=0", "method.time_step=1e-6")),
    "G(t), weighted mass": Question("dcb", moving(5e-6, "method.mass=weighted")),
    "G(t), refined by gradient": Question("fig10_adaptive", moving(4e-5)),
    "Freund": Question("freund", moving(4e-7, "grid.cell=0.2e-3", "grid.cells=100,51")),
    # lumped masses, as in the rows so far: by default steps of models with growth in motion are shorter
    "growth by toughness": Question("dcb_growth_dynamic", moving(1e-4, "method.mass=lumped")),
    "growth at a given speed": Question("freund_growth", moving(4e-7)),
    "contact of faces": Question("kalthoff", moving(1e-5, "method.mass=lumped")),
    "meeting bodies": Question("kalthoff_striker", moving(2e-6, "method.mass=lumped")),
    "updated frame": Question("dcb", moving(4e-5, "method.frame=updated")),
    "DCB, a solid at rest": Question("solid/dcb", ("grid.cell=2.5e-3", "grid.cells=40,5,2", "output.snapshot_interval=0")),
    "penny, a solid at rest": Question("solid/penny", ("refine.max_level=0", "output.snapshot_interval=0")),
    "beam, a solid in motion": Question("solid/beam", moving(2e-4)),
    "front that grows": Question("solid/fatigue_ellipse", (*ONE_STEP, "refine.max_level=1", "crack.radii=0.016,0.014", "growth.increment=1e-3")),
}


def count(program, question):
    """Instructions of a run, and its history by column."""
    with tempfile.TemporaryDirectory() as folder:
        _, instructions = run_counted(program, *arguments(question, folder), profile=Path(folder) / "profile")
        instructions -= costs_of_calls(Path(folder) / "profile")[FLUSHES]
        return instructions, history(folder)


def arguments(question, folder):
    """Arguments of a run of a question with its result in a folder."""
    words = [word for setting in (*question.settings, "output.file=run.h5") for word in ("--set", setting)]
    return INPUT / f"{question.model}.nml", *words, "--quiet", "--force", "--threads", "1", "--output", folder


def history(folder):
    """The columns of the result there."""
    with h5py.File(Path(folder) / "run.h5") as file:
        return {name: column[...] for name, column in file["history"].items()}


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


def row(name, programs, before):
    """The row of a question; both programs are given as that of the plane and that of solids."""
    question = QUESTIONS[name]
    now, history = count(programs[question.is_solid], question)
    if not before:
        return [name, f"{now / 1e6:.1f}", "", "", ""]
    earlier, earlier_history = count(before[question.is_solid], question)
    return [name, f"{now / 1e6:.1f}", f"{earlier / 1e6:.1f}", f"{now / earlier:.4f}", f"{difference(earlier_history, history):.1e}"]


# --- ledger ---------------------------------------------------------------------------------------------------------

def ledger():
    """The last row of each question, by its name."""
    with open(LEDGER, newline="") as file:
        return {row["question"]: row for row in csv.DictReader(file)}


def error_of(columns):
    """The estimated error of G over G, means over the rows [%]; None where none is known."""
    for name in ("G", "G_mean"):
        if f"{name}_error" in columns and np.any(columns[name] != 0):
            return 100 * np.nanmean(columns[f"{name}_error"]) / np.nanmean(np.abs(columns[name]))
    return None


def run(program, question):
    """Error of a question, memory of its run [MB], and the compiler of the program."""
    with tempfile.TemporaryDirectory() as folder:
        process = subprocess.Popen([str(word) for word in (program, *arguments(question, folder))], stderr=subprocess.DEVNULL)
        most = 0
        while process.poll() is None:  # that of a child begins with what its parent has
            most = max([most, *map(int, re.findall(r"VmHWM:\s+(\d+)", Path(f"/proc/{process.pid}/status").read_text()))])
            time.sleep(0.002)
        if process.returncode:
            raise subprocess.CalledProcessError(process.returncode, process.args)
        with h5py.File(Path(folder) / "run.h5") as file:
            compiler = file["input"].attrs["compiler"]
        return error_of(history(folder)), most / 1024, compiler.decode() if isinstance(compiler, bytes) else compiler


def held(name, instructions, compiler):
    """The instructions of a question over those of the ledger; None where that has none by this compiler."""
    row = ledger().get(name)
    return instructions / 1e6 / float(row["instructions [1e6]"]) if row and row["compiler"] == compiler else None


def hold(names, programs, jobs, why, date):
    """Hold questions to the ledger, or write in those that have changed, and why."""
    with ThreadPoolExecutor(jobs) as several:
        counts = dict(zip(names, several.map(lambda name: count(programs[QUESTIONS[name].is_solid], QUESTIONS[name])[0], names)))
    is_held = True
    for name in names:
        error, memory, compiler = run(programs[QUESTIONS[name].is_solid], QUESTIONS[name])
        ratio = held(name, counts[name], compiler)
        error = "" if error is None else f"{error:.3g}"
        print(f"{name:28} {counts[name] / 1e6:9.1f}  {ratio or 0:.4f}  error {error} %", flush=True)
        is_new = ratio is None or not LEAST <= ratio <= MOST
        is_held = is_held and not is_new
        if why and is_new:
            with open(LEDGER, "a", newline="") as file:
                csv.writer(file, lineterminator="\n").writerow([name, error, f"{counts[name] / 1e6:.1f}", f"{memory:.0f}", date, compiler, why])
    if not (is_held or why):
        sys.exit(f"instructions beyond {MOST} or below {LEAST} of the ledger: write them in with --why, beside the error that they buy")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("question", nargs="*", help=f"parts of {', '.join(QUESTIONS)}; default: all")
    parser.add_argument("--programs", metavar="PROGRAM", type=Path, nargs=2, default=(ROOT / "build/release/hampm", ROOT / "build/release3d/hampm3d"),
                        help="of the plane and of solids; default: those of the release")
    parser.add_argument("--before", metavar="PROGRAM", type=Path, nargs=2, help="earlier programs of the plane and of solids")
    parser.add_argument("--ledger", action="store_true", help="hold the programs to bench/ledger.csv")
    parser.add_argument("--why", metavar="REASON", help="write into the ledger what has changed, and why")
    parser.add_argument("--date", default=datetime.date.today().isoformat(), help="of the program, default: today")
    parser.add_argument("--jobs", metavar="N", type=int, default=2, help="runs at a time; default: 2")
    parser.add_argument("--output", metavar="DIR", type=Path, default=Path("results"), help="folder of the table")
    options = parser.parse_args()
    if not can_count():
        sys.exit("valgrind is missing: no instructions are counted")
    options.output.mkdir(parents=True, exist_ok=True)
    names = [name for name in QUESTIONS if not options.question or any(word in name for word in options.question)]
    if options.ledger or options.why:
        hold(names, options.programs, options.jobs, options.why, options.date)
        return
    with ThreadPoolExecutor(options.jobs) as several:
        rows = list(several.map(lambda name: row(name, options.programs, options.before), names))
    write([["question", "instructions [1e6]", "before [1e6]", "ratio", "difference of G, K, J"], *rows], "whole_runs", options.output)


if __name__ == "__main__":
    main()
