"""Run the tests with the coverage builds of both programs and count which lines of src/ they run in either: one table, by file.

    python tools/coverage.py [--keep] [--missing PART]

--keep counts what earlier runs left, without running anything; --missing lists the lines of files whose path holds PART that
never ran. Exit code 1 where a test fails or less than 90 % of the lines ran. The tests are the unit tests and what `make test` runs of tests/cli and
tests/program. A line counts that the compiler has kept in one of the builds, since what is for solids alone is left out of that of the plane.
"""

import argparse
import gzip
import json
import os
import subprocess
import sys
import tempfile
from collections import defaultdict
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
BUILDS = {"plane": ROOT / "build/coverage", "solids": ROOT / "build/coverage3d"}
ALONE = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "OMP_WAIT_POLICY": "passive"}
LEAST = 90  # percent
TESTS = ["tests/cli", "tests/program"]


def run_tests():
    """Run unit tests and the program's tests; whether all went well."""
    good = True
    for build in BUILDS.values():
        for old in build.glob("*.gcda"):
            old.unlink()
        for program in sorted(path for path in build.glob("test_*") if not path.suffix):
            run = subprocess.run([program], capture_output=True, text=True, timeout=600, env=os.environ | ALONE)
            if run.returncode:
                print(f"{program} failed\n{run.stdout}{run.stderr}")
                good = False
    tests = subprocess.run([sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-m", "not verify", "-n", str(os.cpu_count()), *TESTS],
                           cwd=ROOT, env=os.environ | {"HAMPM": str(BUILDS["plane"] / "hampm"), "HAMPM3D": str(BUILDS["solids"] / "hampm3d")})
    return good and tests.returncode == 0


def lines_run():
    """How often each line of each file of src/ ran, as `counts[file][line]`, and the same by program."""
    of = {name: lines_of(build) for name, build in BUILDS.items()}
    counts = defaultdict(lambda: defaultdict(int))
    for found in of.values():
        for path, of_file in found.items():
            for number, count in of_file.items():
                counts[path][number] += count
    for path in ROOT.glob("src/**/*.f90"):      # what no test even loads counts as a file without lines that ran
        if str(path.relative_to(ROOT)) not in counts and "subroutine" in path.read_text():
            print(f"{path.relative_to(ROOT)}: no test runs anything of it")
    return counts, of


def lines_of(build):
    """The same of one build."""
    counts = defaultdict(lambda: defaultdict(int))
    with tempfile.TemporaryDirectory() as folder:
        data = sorted(build.glob("*.gcda"))
        subprocess.run(["gcov", "--json-format", *data], cwd=folder, capture_output=True, check=True)
        for report in Path(folder).glob("*.gcov.json.gz"):
            for file in json.loads(gzip.decompress(report.read_bytes()))["files"]:
                path = Path(file["file"])
                if path.parts[0] != "src":
                    continue
                for line in file["lines"]:
                    counts[str(path)][line["line_number"]] += line["count"]
    return counts


def table(counts):
    """The counts as text, and the percentage of all lines that ran."""
    lines = ["| file | lines | run | % |", "|---|---|---|---|"]
    everything = [0, 0]
    for path, of_file in sorted(counts.items()):
        total, ran = len(of_file), sum(n > 0 for n in of_file.values())
        everything = [everything[0] + total, everything[1] + ran]
        lines.append(f"| {path} | {total} | {ran} | {100 * ran / total:.1f} |")
    percent = 100 * everything[1] / everything[0]
    return "\n".join([*lines, f"| all | {everything[0]} | {everything[1]} | {percent:.1f} |"]), percent


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--keep", action="store_true", help="run nothing")
    parser.add_argument("--missing", metavar="PART", help="list lines that never ran")
    options = parser.parse_args()
    good = options.keep or run_tests()
    counts, of = lines_run()
    text, percent = table(counts)
    print(text)
    for name, found in of.items():
        print(f"{name} alone: {table(found)[0].splitlines()[-1]}")
    for path, of_file in sorted(counts.items()):
        if options.missing is None or options.missing not in path:
            continue
        source = (ROOT / path).read_text().splitlines()
        for number in sorted(number for number, n in of_file.items() if n == 0):
            print(f"{path}:{number}: {source[number - 1].strip()}")
    if percent < LEAST:
        print(f"less than {LEAST} % of the lines ran")
    sys.exit(not good or percent < LEAST)


if __name__ == "__main__":
    main()
