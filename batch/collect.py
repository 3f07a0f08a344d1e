#!/usr/bin/env python3
"""Make one table of all cases of a sweep, table.csv and table.h5 in its folder, and list those that have no result, by the reason that hampm gave.

A case is a row, with what it sets, how it ended, what its runs took, and the columns that the sweep asks for: docs/how-to/batches.md has them all. It can be
called at any time, also while cases run.
"""

import argparse
from pathlib import Path

from package import PROGRAM, read_sweep, run

from hampm.batch.table import collect, report


def main(arguments=None):
    options = parse(arguments)
    sweep = read_sweep(options.sweep, options.program)
    rows, about = collect(sweep)
    report(sweep, rows, about, options.brief)
    return 1 if options.strict and any(row["outcome"] != "done" for row in rows) else 0


def parse(arguments):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sweep", metavar="SWEEP.yaml", type=Path)
    parser.add_argument("--program", metavar="FILE", type=Path, default=PROGRAM, help="hampm, whose keys are allowed")
    parser.add_argument("--brief", action="store_true", help="count those that have no result, and do not list them")
    parser.add_argument("--strict", action="store_true", help="exit code 1 where a case is not done")
    return parser.parse_args(arguments)


if __name__ == "__main__":
    run(main)
