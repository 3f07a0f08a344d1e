"""Runs that go wrong: scenes with settings at random, most of them refused, unstable, torn or out of the grid.

Every run has to end with exit code 0, 2 or 3 and a message of the program's own, in time, and with a result that can be read and says how
the run has ended.

    .venv/bin/python tests/fuzz/runs.py --cases 700 --seed 2 --program build/checked/hampm
"""

import argparse
import os
import random
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path

import h5py

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = ROOT / "build/release/hampm"
ACCIDENTS = "backtrace", "runtime error", "SIG", "array temporary", "Sanitizer"
LONGEST = 300  # that a run may take, in the checked build on a busy machine [s]

# Keys that any of the scenes may be given, with values up to those that no run survives
METHOD = {
    "method.scheme": ("musl", "usf", "usl", "usavg"), "method.frame": ("updated", "total"),
    "method.courant": (0.02, 0.05, 0.1, 0.2, 0.3, 0.5, 1.9), "method.mass": ("lumped", "lumped", "consistent", "fmpm", "weighted"),
    "method.solver": ("cg", "direct"), "damping.rate": (0, 1, 1e4, 1e6),
    "refine.indicator": ("none", "gradient", "gradient", "zz"), "refine.field": ("energy_density", "stress_norm", "speed"),
    "refine.max_level": (1, 2, 3), "refine.interval": (3, 10, 50), "refine.r_crit": (0.01, 0.05), "refine.r_coarsen": (0, 0.005),
    "refine.tolerance": (0.05, 0.2), "refine.max_particles": (1000, 3000)}
CRACKED = {
    "energy_release.estimators": ("vcct", "vcct,domain_integral", "stress_closure"), "energy_release.energy_balance": (".true.", ".false."),
    "refine.indicator": ("none", "gradient", "zz", "tip"),
    "load.force": ("0,1", "0,1e4", "0,1e6", "0,1e8", "0,1e9"), "run.end_time": (1e-5, 2e-5), "output.history_interval": (1e-6, 5e-6)}
FLIGHT = """\
&run end_time = 0.04 /
&grid cell = 1.0 cells = 8, 4 /
&material name = 'soft' law = 'neo_hookean' young = 1e5 density = 1000 poisson = 0.3 /
&material name = 'hard' young = 1e6 density = 2000 /
&body material = 'soft' lower = 1.3, 1.2 upper = 2.3, 2.8 points_per_cell = 4 /
&body material = 'hard' lower = 4.6, 1.0 upper = 5.6, 3.0 velocity = -10, 0 /
&load kind = 'traction' lower = 1.3, 1.2 upper = 1.3, 2.8 force = 1e3, 0 history = 'sine' frequency = 30 /
&output history_interval = 4e-3 snapshot_interval = 13e-3 /
"""
CLOSED = """\
&run thickness = 0.01 /
&grid lower = 0.0, -0.0125 cell = 2.5e-3 cells = 20, 10 /
&material name = 'aluminium' young = 70e9 density = 2700 poisson = 0.3 /
&body material = 'aluminium' lower = 0.0, -0.01 upper = 0.05, 0.01 /
&constraint lower = 0.05, -0.01 upper = 0.05, 0.01 fix = 'xy' /
&load kind = 'traction' lower = 0.0, 0.0 upper = 0.0, 0.01 /
&crack kind = 'line' tip = 0.025, 0.0 contact = 'frictionless' /
&output snapshot_interval = 1e-5 /
"""
SCENES = {
    "flight": (FLIGHT, METHOD | {"method.frame": ("updated",), "method.courant": (0.02, 0.05, 0.1, 0.2), "load.force": ("1e3,0", "1e5,0", "1e7,0"), "body(1).velocity": ("3,3", "30,3", "300,3", "3000,3"),
                       "material(1).law": ("neo_hookean", "linear_elastic"), "energy_release.energy_balance": (".true.",)}),
    "closed crack": (CLOSED, METHOD | CRACKED),
    "input/dcb.nml": ((ROOT / "input/dcb.nml").read_text(), METHOD | CRACKED | {
        "grid.cell": (5e-3,), "grid.cells": ("20,3",), "output.snapshot_interval": (1e-5,), "output.file": ("case.h5",)})}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cases", type=int, default=700, metavar="N")
    parser.add_argument("--seed", type=int, default=1, metavar="N")
    parser.add_argument("--program", type=Path, default=PROGRAM, metavar="FILE")
    options = parser.parse_args()
    ends, findings = try_runs(options.program.resolve(), options.cases, options.seed)
    print(", ".join(f"{count} ended with {code}" for code, count in sorted(ends.items())))
    sys.exit("\n".join(findings) or 0)


def try_runs(program, cases, seed):
    """How many runs ended with which exit code, and what is wrong with some."""
    chance, ends, findings = random.Random(seed), Counter(), []
    for _ in range(cases):
        name = chance.choice(list(SCENES))
        text, keys = SCENES[name]
        settings = [f"{key}={chance.choice(values)}" for key, values in keys.items()]
        with tempfile.TemporaryDirectory() as folder:
            code, fault = try_run(program, Path(folder), text, settings)
        ends[code] += 1
        if fault:
            findings.append(f"{name} {' '.join(settings)}: {fault}")
    return ends, findings


def try_run(program, folder, text, settings):
    """The exit code of a run, and what is wrong with its end; '' where nothing is."""
    (folder / "case.nml").write_text(text)
    command = [program, folder / "case.nml", "--output", folder, "--quiet", "--threads", "1"]
    command += [word for setting in settings for word in ("--set", setting)]
    try:
        run = subprocess.run(command, capture_output=True, text=True, errors="replace", timeout=LONGEST,
                             env={**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"})
    except subprocess.TimeoutExpired:
        return None, f"has not ended after {LONGEST} s"
    said = run.stdout + run.stderr
    if run.returncode not in (0, 2, 3) or any(word in said for word in ACCIDENTS):
        return run.returncode, f"ended with {run.returncode}: {said[-1000:]}"
    if run.returncode == 2:
        return run.returncode, ""
    try:
        with h5py.File(folder / "case.h5") as file:
            ended, samples = file["history"].attrs["ended"], len(file["history/time"])
            at_rest = b"'static'" in (folder / "case.nml").read_bytes()      # which may have no equilibrium to begin with
    except (OSError, KeyError) as error:
        return run.returncode, f"its result cannot be read: {error}"
    told = (ended == "done") == (run.returncode == 0) and (samples > 0 or at_rest and run.returncode == 3)
    return run.returncode, "" if told else f"ended with {run.returncode}, and its result says '{ended}' after {samples} samples"


if __name__ == "__main__":
    main()
