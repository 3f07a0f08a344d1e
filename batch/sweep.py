#!/usr/bin/env python3
"""List the cases that a sweep declares, after looking for mistakes in it. Nothing is run. docs/how-to/batches.md explains the keys of a sweep."""

import argparse
from pathlib import Path

from package import PROGRAM, read_sweep, run


def main(arguments=None):
    options = parse(arguments)
    sweep = read_sweep(options.sweep, options.program)
    for name in sweep.cases:
        print(name, *(f"{key}={value}" for key, value in sweep.values(name).items()))


def parse(arguments):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sweep", metavar="SWEEP.yaml", type=Path)
    parser.add_argument("--program", metavar="FILE", type=Path, default=PROGRAM, help="hampm, whose keys are allowed")
    return parser.parse_args(arguments)


if __name__ == "__main__":
    run(main)
