"""How far each number of the regression cases is off over what it may be off, the least first.

    .venv/bin/python tests/regression/tolerances.py [--program build/release/hampm] [--case NAME ...] [--all]

Tolerances of more than ten times the deviation say little of a change; `--all` makes the runs that are left to `make verify` too.
"""

import argparse
import os
import subprocess
import sys
import tempfile
from fnmatch import fnmatchcase
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / folder) for folder in ("tests/regression", "tests", "postprocess", "python/src")]

from test_regression import CASES, Run, expected_of, runs_of  # noqa: E402

LOOSE = 10             # times the deviation


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", type=Path, default=ROOT / "build/release/hampm", metavar="FILE")
    parser.add_argument("--case", action="append", default=[], metavar="NAME")
    parser.add_argument("--all", action="store_true")
    options = parser.parse_args()
    program, rows = options.program.resolve(), []

    def hampm(*words, cwd):
        return subprocess.run([program, *map(str, words)], cwd=cwd, capture_output=True, text=True, env={**os.environ, "OMP_NUM_THREADS": "1"})

    for case in CASES:
        expected = expected_of(case)
        for name in runs_of(case):
            if options.case and case.name not in options.case or not options.all and any(fnmatchcase(name, pattern) for pattern in expected.get("verify", [])):
                continue
            with tempfile.TemporaryDirectory() as folder:
                run = Run(hampm, Path(folder), case, name, expected)
                for one in expected["expect"]:
                    if fnmatchcase(name, one.get("runs", "*")):
                        measured, asked = run.value(one["measured"]), run.value(one["asked"])
                        tolerance = run.value(one.get("atol", 0.0)) + run.value(one.get("rtol", 0.0)) * abs(asked)
                        rows.append((abs(measured - asked) / tolerance if tolerance else 0.0, case.name, name, one["what"], asked, measured, tolerance))
                        print("| {1} {2} | {3} | {4:.6g} | {5:.6g} | {6:.2g} | {0:.2f} |".format(*rows[-1]), flush=True)
    worst = {}                                                             # of all runs that share a tolerance
    for part, name, _, what, *_ in rows:
        worst[name, what] = max(worst.get((name, what), 0.0), part)
    print(f"\n{sum(part < 1 / LOOSE for part in worst.values())} of {len(worst)} quantities have tolerances of more than {LOOSE} times their largest deviation")


if __name__ == "__main__":
    main()
