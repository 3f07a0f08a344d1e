#!/usr/bin/env python3
"""Forget how cases of a sweep ended, so that the next run of the sweep runs them again from their beginning.

Without names these are the cases that were refused or failed; their folders are removed.
"""

import argparse
from pathlib import Path

from package import PROGRAM, read_sweep, run


def main(arguments=None):
    options = parse(arguments)
    sweep = read_sweep(options.sweep, options.program)
    print(*sweep.forget(sweep.cases if options.all else options.case or None), sep="\n")


def parse(arguments):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sweep", metavar="SWEEP.yaml", type=Path)
    parser.add_argument("case", metavar="CASE", nargs="*", help="name of a case, as in the table")
    parser.add_argument("--all", action="store_true", help="all cases, as after a change of hampm")
    parser.add_argument("--program", metavar="FILE", type=Path, default=PROGRAM, help="hampm, whose keys are allowed")
    return parser.parse_args(arguments)


if __name__ == "__main__":
    run(main)
