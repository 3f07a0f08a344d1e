"""Runs of scenes made at random, for the scripts that make them.

Every run has to end with exit code 0, 2 or 3 as those of `runs.py` do; one that ends with 0 also has to pass the script's own look at its result. A part of them
runs again with snapshots at other times than rows: no column may differ in any byte.
"""

import argparse
import random
import sys
import tempfile
from collections import Counter
from pathlib import Path

import h5py
import numpy as np
from runs import PROGRAM, try_run

OBSERVED = 4  # every which scene runs again with snapshots, and with other rows


def try_scenes(program, cases, seed, scene, look):
    """How many runs ended with which exit code, and what is wrong with some. `scene`: a chance -> the text of a namelist; `look`: the folder
    of a result and the text -> what is wrong, '' where nothing is."""
    ends, findings = Counter(), []
    for case in range(cases):
        text = scene(random.Random(f"{seed} {case}"))
        with tempfile.TemporaryDirectory() as folder:
            code, fault = try_run(program, Path(folder), text, [])
            if code == 0 and not fault:
                before = columns(folder) if case % OBSERVED == 0 else {}
                fault = look(Path(folder), text)
                if before and not fault:
                    fault = look_at_observed(program, folder, text, before)
        ends[code] += 1
        if fault:
            findings.append(f"seed {seed} case {case}: {fault}")
    return ends, findings


def columns(folder):
    """The columns of a result, and nothing where there is none."""
    files = list(Path(folder).glob("*.h5"))
    if len(files) != 1:
        return {}
    with h5py.File(files[0]) as file:
        return {name: column[()] for name, column in file["history"].items() if isinstance(column, h5py.Dataset)}


def look_at_observed(program, folder, text, plain):
    """What differs with snapshots that are no multiples of rows, and with half as many rows; '' for nothing."""
    span = plain["time"][-1] - plain["time"][0]
    fault = differing(program, text, plain, f"output.snapshot_interval={0.37 * span / 3}")
    if fault or len(plain["time"]) < 4 or "time = 'static'" in text:
        return fault
    return differing(program, text, plain, f"output.history_interval={2 * (plain['time'][2] - plain['time'][1])}", is_exact="time = 'implicit'" in text)


def differing(program, text, plain, setting, is_exact=True):
    """Which columns a setting of the output changes in rows of the same step; '' for none. Steps that end at rows are others unless their length is the same, and let
    particles follow nodes in other sums: of these the errors and what they are of, and what goes on from row to row, are looked at, which are not rounding alone."""
    with tempfile.TemporaryDirectory() as other:
        code, fault = try_run(program, Path(other), text, [setting])
        if code or fault:
            return fault or f"ends with {code} with {setting}"
        seen = columns(other)
    if not is_exact and np.ptp(np.concatenate([plain["dt"][1:], seen["dt"][1:]])) > 1e-9 * plain["dt"][-1]:
        return ""
    _, here, there = np.intersect1d(plain["step"], seen["step"], return_indices=True)
    names = set(plain) if is_exact else {"integral_of_G"} | {name for error in plain if error.endswith("_error") for name in (error, error[:-len("_error")])}
    differ = [name for name, values in plain.items() if name in names & set(seen) and not are_same(values[here], seen[name][there], is_exact)]
    return f"with {setting} {', '.join(differ)} differ" if differ else ""


def are_same(values, others, are_exact):
    """Whether the values of a column are the same, to the last digit or but for rounding."""
    if are_exact:
        return np.array_equal(values, others, equal_nan=values.dtype.kind == "f")
    return np.allclose(values, others, rtol=1e-5, atol=1e-5 * np.nanmax(np.abs(values), initial=0), equal_nan=True)


def main(description, scene, look):
    """The command line of a script that makes scenes."""
    parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cases", type=int, default=1000, metavar="N")
    parser.add_argument("--seed", type=int, default=1, metavar="N")
    parser.add_argument("--program", type=Path, default=PROGRAM, metavar="FILE")
    parser.add_argument("--show", type=int, metavar="CASE", help="print the namelist of a case")
    options = parser.parse_args()
    if options.show is not None:
        print(scene(random.Random(f"{options.seed} {options.show}")))
        return
    ends, findings = try_scenes(options.program.resolve(), options.cases, options.seed, scene, look)
    print(", ".join(f"{count} ended with {code}" for code, count in sorted(ends.items(), key=str)))
    sys.exit("\n".join(findings) or 0)
