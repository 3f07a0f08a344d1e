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

OBSERVED = 4  # every which scene runs again with snapshots


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
    """What differs with snapshots that are no multiples of rows; '' for nothing."""
    with tempfile.TemporaryDirectory() as other:
        interval = 0.37 * (plain["time"][-1] - plain["time"][0]) / 3
        code, fault = try_run(program, Path(other), text, [f"output.snapshot_interval={interval}"])
        if code or fault:
            return fault or f"ends with {code} with snapshots"
        seen = columns(other)
    differing = [name for name, values in plain.items() if not np.array_equal(values, seen.get(name), equal_nan=values.dtype.kind == "f")]
    return f"with snapshots {', '.join(differing)} differ" if differing else ""


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
