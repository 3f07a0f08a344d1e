#!/usr/bin/env python3
"""Forget how cases of a sweep ended, so that the next run of the sweep runs them again from their beginning.

Without names these are the cases that were refused or failed; their folders are removed.
"""

import argparse
import shutil
from pathlib import Path

from declaration import ResultError, run
from run_case import known
from sweep import PROGRAM, meant, read_sweep


def main(arguments=None):
    options = parse(arguments)
    sweep = read_sweep(options.sweep, options.program)
    sweep.adopt()
    for name in options.case:
        if name not in sweep.cases:
            raise ResultError(f"the sweep has no case '{name}'{meant(name, sweep.cases)}")
    for name in sweep.cases if options.all else options.case or unsuccessful(sweep):
        print(name)
        shutil.rmtree(sweep.folder(name), ignore_errors=True)


def parse(arguments):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sweep", metavar="SWEEP.yaml", type=Path)
    parser.add_argument("case", metavar="CASE", nargs="*", help="name of a case, as in the table")
    parser.add_argument("--all", action="store_true", help="all cases, as after a change of hampm")
    parser.add_argument("--program", metavar="FILE", type=Path, default=PROGRAM, help="hampm, whose keys are allowed")
    return parser.parse_args(arguments)


def unsuccessful(sweep):
    """Names of the cases that were refused or failed."""
    ends = {name: known(sweep.folder(name) / "outcome.json").get("outcome") for name in sweep.cases}
    return [name for name, end in ends.items() if end in ("refused", "failed")]


if __name__ == "__main__":
    run(main)
