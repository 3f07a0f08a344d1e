#!/usr/bin/env python3
"""Run the cases of a sweep by Snakemake, as many at a time as there are cores, and make its table. docs/how-to/batches.md explains it.

All cases are checked first. Those that hampm refuses are listed, and not run; the same command goes on where a sweep was stopped.
Exit code: 0 all cases have been run; 1 some are refused, or cannot be run to an end; 2 the sweep makes no sense. Cases that fail in
the computation are rows of the table like others, as one may look for where that is: with --strict they are exit code 1 too, and no
case is run where one is refused. Behind `--` stand options of Snakemake.
"""

import argparse
import json
import os
import sys
from pathlib import Path

from package import ResultError, program_of_model, read_sweep, run

HERE = Path(__file__).resolve().parent


def main(arguments=None):
    options, further = split(sys.argv[1:] if arguments is None else arguments)
    sweep = read_sweep(options.sweep, options.program)
    program = options.program or program_of_model(sweep.namelist)
    try:
        import snakemake  # noqa: F401
    except ImportError as missing:
        raise ResultError(f"{missing}: run tools/setup.sh batch with a Python of 3.11 to 3.13, or make install packages='run batch'") from missing
    settings = {"sweep": options.sweep.resolve(), "program": program.resolve(), "strict": str(options.strict).lower()}
    command = [sys.executable, "-m", "snakemake", "-s", str(HERE / "Snakefile"), *further]
    if options.profile:
        command += ["--profile", str(HERE / "profiles" / options.profile)]
    if options.profile is None or options.cores:
        command += ["--cores", options.cores or "all"]
    command += ["--config", *(f"{key}={quoted(str(value))}" for key, value in settings.items())]
    sys.stdout.flush()
    os.execv(sys.executable, command)


def split(words):
    """Our own options and those of Snakemake."""
    further = words[words.index("--") + 1:] if "--" in words else []
    return parse(words[:words.index("--")] if "--" in words else words), further


def parse(arguments):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sweep", metavar="SWEEP.yaml", type=Path)
    parser.add_argument("--program", metavar="FILE", type=Path, help="hampm (default: that of these scripts, for a solid hampm3d)")
    parser.add_argument("--cores", metavar="N", help="cores to use (default: all)")
    parser.add_argument("--profile", metavar="NAME", choices=sorted(path.name for path in (HERE / "profiles").iterdir()),
                        help="of batch/profiles, such as slurm")
    parser.add_argument("--strict", action="store_true", help="run no case where one is refused; exit code 1 where one has failed, too")
    return parser.parse_args(arguments)


def quoted(text):
    """A text as Snakemake takes it for one, which takes quotes off at its ends and reads the rest as YAML."""
    return f"!!str {json.dumps(text)} #"


if __name__ == "__main__":
    run(main)
