"""This version beside an earlier one: whether it gives the same results, and what it costs.

    results       short scenes (against_scenes.py): the largest difference of each column of the history over its largest value ("over
                  own size"), and over the largest value of all columns of its unit but sizes of cells, which is what is judged: of
                  what is zero but for rounding all digits may differ
    instructions  of bench_step per particle and step, by valgrind
    programs      instructions of whole short runs of some of the scenes
    time          processor time of bench_step per particle and step: both programs at once on the same processor, which they share
                  in slices of milliseconds; the median of the ratios of turns that go together, and the range of the middle half

Run by `make -C bench against before=REV`, which clones the revision and builds both, or
.venv/bin/python bench/against.py results time --before REV --cases tip audit. FOLDER in place of REV is a clone that is there. The
table is against.csv, all columns of all scenes are in against_columns.csv. Exit code 1 where a target is not met.
"""

import argparse
import csv
import math
import os
import statistics
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
from against_scenes import COUNTED, SCENES
from instructions import can_count, instructions, run_counted
from speed import CELLS, SIZES, Case, judged, processors
from tables import ROOT, write

sys.path.insert(0, str(ROOT / "postprocess"))
from history import History  # noqa: E402

COLUMNS = ["part", "case", "quantity", "before", "after", "value", "range", "over own size", "target", "met"]
ROUNDING = 1e-11     # of results: builds with other optimisation differ by 4e-14 in these scenes
INSTRUCTIONS = 1.02  # of those before, at most
TIME = 1.03
NEEDS = {"results": "release/hampm", "instructions": "release/bench_step", "programs": "release/hampm",
         "time": "release/bench_step"}
CASES = [*(Case(cells) for cells in SIZES), *(Case(cells, frame="total") for cells in CELLS),
         *(Case(CELLS[0], frame=frame, scheme=scheme) for frame in ("updated", "total") for scheme in ("usl", "usf", "usavg")),
         *(Case(cells, threads=2) for cells in CELLS[1:] if processors() > 1)]
MOST_COUNTED = 158   # cells along an edge: larger ones would take minutes each


def row(part, case, quantity, **more):
    """A row of the table; `more`: other columns, with _ for a blank."""
    given = {"part": part, "case": case, "quantity": quantity} | {name.replace("_", " "): item for name, item in more.items()}
    assert not set(given) - set(COLUMNS)
    return [given.get(name, "") for name in COLUMNS]


# --- results ----------------------------------------------------------------------------------------------------------

def difference(before, after):
    """Largest difference of two columns; infinite where they have different lengths or one is not a number where the other is."""
    if after is None or before.shape != after.shape:
        return math.inf
    x, y = before.astype(float), after.astype(float)
    same = (x == y) | (np.isnan(x) & np.isnan(y))
    with np.errstate(invalid="ignore"):
        each = np.where(same, 0.0, np.abs(x - y))
    return float(np.max(np.where(np.isnan(each), np.inf, each), initial=0.0))


def size(*columns):
    """Largest finite value of some columns, in size."""
    return max((float(np.max(np.abs(column[np.isfinite(column)]), initial=0.0)) for column in columns), default=0.0)


def over(value, whole):
    """A ratio; 0/0 is 0."""
    return 0.0 if value == 0 else value / whole if whole > 0 else math.inf


def differences(before, after):
    """(column, difference over its largest value, over the largest value of its unit) of each column of the earlier history."""
    found = []
    for name, values in before.columns.items():
        value = difference(values, after.columns.get(name))
        alike = [other for key, other in before.columns.items()
                 if key == name or before.units[key] == before.units[name] and not key.endswith("_cell")]
        found.append((name, over(value, size(values)), over(value, size(*alike))))
    return found


def arguments_of(scene, folder, *more):
    """Words that run a scene in a folder."""
    path = scene.source
    if isinstance(path, str):
        path = folder / "scene.nml"
        path.write_text(scene.source)
    return [path, *(word for setting in (*scene.settings, "output.file=scene.h5", *more) for word in ("--set", setting)),
            "--quiet", "--force", "--output", folder, "--threads", scene.threads]


def run(program, scene, folder):
    """Run a scene: exit code and history, None where there is none."""
    words = [str(word) for word in (program, *arguments_of(scene, folder))]
    code = subprocess.run(words, capture_output=True, check=False).returncode
    result = folder / "scene.h5"
    return code, History(result) if result.exists() else None


def compare(builds, scene):
    """The row of a scene, and all its columns."""
    ends = []
    for build in builds:
        with tempfile.TemporaryDirectory() as folder:
            ends.append(run(build / NEEDS["results"], scene, Path(folder)))
    (before, history), (after, other) = ends
    if history is None or other is None or before != after:
        return row("results", scene.name, "exit code", before=before, after=after, target=before,
                   met="yes" if before == after else "NO"), []
    found = differences(history, other)
    name, _, value = max(found, key=lambda item: item[2])
    own = max(item[1] for item in found)
    return row("results", scene.name, f"difference, {name}" if own > 0 else "the same numbers", value=f"{value:.1e}",
               over_own_size=f"{own:.1e}", **judged(value, ROUNDING)), [(scene.name, *item) for item in found]


def results(builds, wanted, options):
    """Both programs on all scenes."""
    with ThreadPoolExecutor(processors()) as several:
        found = list(several.map(lambda scene: compare(builds, scene), [scene for scene in SCENES if wanted(scene.name)]))
    with open(options.output / "against_columns.csv", "w", newline="") as file:
        table = csv.writer(file)
        table.writerow(["scene", "column", "difference over its size", "over that of its unit"])
        table.writerows(line for _, lines in found for line in lines)
    return [line for line, _ in found]


# --- instructions -----------------------------------------------------------------------------------------------------

def ratio_row(part, case, quantity, before, after, target, digits=0):
    """A row of two counts."""
    return row(part, case, quantity, before=f"{before:.{digits}f}", after=f"{after:.{digits}f}", value=f"{after / before:.4f}",
               **judged(after / before, target))


def count_steps(builds, wanted, _):
    """Instructions of bench_step."""
    cases = [case for case in CASES if case.cells <= MOST_COUNTED and case.threads == 1 and wanted(str(case))]
    pairs = [(build / NEEDS["instructions"], case) for case in cases for build in builds]
    with ThreadPoolExecutor(processors()) as several:
        counts = list(several.map(lambda pair: instructions(*pair), pairs))
    return [ratio_row("instructions", str(case), "a particle and step", *counts[2 * k:2 * k + 2], INSTRUCTIONS, digits=1)
            for k, case in enumerate(cases)]


def count_run(build, scene):
    """Instructions of a short run of a scene."""
    with tempfile.TemporaryDirectory() as folder:
        words = arguments_of(scene, Path(folder), f"run.end_time={COUNTED[scene.name]}")
        return run_counted(build / NEEDS["programs"], *words)[1]


def count_runs(builds, wanted, _):
    """Instructions of whole runs."""
    scenes = [scene for scene in SCENES if scene.name in COUNTED and wanted(scene.name)]
    pairs = [(build, scene) for scene in scenes for build in builds]
    with ThreadPoolExecutor(processors()) as several:
        counts = list(several.map(lambda pair: count_run(*pair), pairs))
    return [ratio_row("programs", scene.name, "millions", *(n / 1e6 for n in counts[2 * k:2 * k + 2]), INSTRUCTIONS, digits=1)
            for k, scene in enumerate(scenes)]


# --- time -------------------------------------------------------------------------------------------------------------

def start(program, case, turns):
    """Start bench_step on a case, on as many processors as it has threads."""
    process = subprocess.Popen([program, "time", str(turns), str(case)], stdout=subprocess.PIPE, text=True)
    os.sched_setaffinity(process.pid, sorted(os.sched_getaffinity(0))[-case.threads:])
    return process


def times(process):
    """Processor time of each of its turns [ns], when it has ended."""
    text = process.communicate()[0]
    if process.returncode:
        sys.exit(f"{process.args} has failed")
    return [float(line.split()[3]) for line in text.splitlines()]


def time_case(builds, case, turns):
    """The row of a case of bench_step. Both programs run at once on the same processors, so that what slows these down meets both;
    three turns a process, as pages lie elsewhere in each."""
    spent = []
    for turn in range(0, turns, 3):
        both = [start(build / NEEDS["time"], case, min(3, turns - turn)) for build in builds]
        spent += zip(*map(times, both))
    ratios = [after / before for before, after in spent]
    value = statistics.median(ratios)
    low, _, high = statistics.quantiles(ratios, n=4) if turns > 1 else (value, value, value)
    before, after = (statistics.median(column) for column in zip(*spent))
    return row("time", str(case), "ns a particle and step", before=f"{before:.2f}", after=f"{after:.2f}", value=f"{value:.4f}",
               range=f"{low:.3f} to {high:.3f}", **judged(value, TIME))


def time(builds, wanted, options):
    """Processor time of bench_step."""
    rows = []
    for case in sorted(CASES, key=lambda case: case.cells):
        if wanted(str(case)):
            rows.append(time_case(builds, case, options.turns if case.cells <= CELLS[-1] else min(options.turns, 9)))
            print(*rows[-1][1:7], sep="  ", file=sys.stderr, flush=True)
    return rows


# --- builds -----------------------------------------------------------------------------------------------------------

PARTS = {"results": results, "instructions": count_steps, "programs": count_runs, "time": time}


def build(folder, parts, if_missing=False):
    """Build in a clone what the parts need; where its builds are."""
    targets = sorted({f"build/{NEEDS[part]}" for part in parts})
    if not (if_missing and all((folder / target).exists() for target in targets)):
        print(f"{folder}: make {' '.join(targets)}", file=sys.stderr)
        subprocess.run(["make", f"-j{min(processors(), 4)}", *targets], cwd=folder, check=True, stdout=subprocess.DEVNULL)
    return folder / "build"


def clone(revision, folder):
    """A clone of a revision of this repository."""
    subprocess.run(["git", "clone", "--quiet", "--shared", "--no-checkout", ROOT, folder], check=True)
    name = subprocess.run(["git", "-C", ROOT, "rev-parse", "--verify", f"{revision}^{{commit}}"], capture_output=True, text=True,
                          check=False)
    if name.returncode:
        sys.exit(f"{revision}: neither a revision nor the folder of a clone")
    subprocess.run(["git", "-C", folder, "checkout", "--quiet", "--detach", name.stdout.strip()], check=True)
    return folder


def main():
    os.environ["OMP_WAIT_POLICY"] = "passive"    # processor time of threads that wait would be counted
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("part", nargs="*", help=f"{', '.join(PARTS)}; default: all")
    parser.add_argument("--before", metavar="REV", required=True, help="revision, or folder of a clone")
    parser.add_argument("--cases", metavar="PART", nargs="+", default=[""], help="only cases whose name holds one of these")
    parser.add_argument("--turns", metavar="N", type=int, default=15, help="of the part time; default: 15")
    parser.add_argument("--output", metavar="DIR", type=Path, default=Path("results"), help="folder of the tables")
    options = parser.parse_args()
    parts = options.part or list(PARTS)
    if set(parts) - set(PARTS):
        parser.error(f"a part is one of {', '.join(PARTS)}")
    if not can_count():
        print("valgrind is missing: no instructions are counted", file=sys.stderr)
        parts = [part for part in parts if part not in ("instructions", "programs")]
    options.output.mkdir(parents=True, exist_ok=True)
    rows = [COLUMNS]
    with tempfile.TemporaryDirectory() as folder:
        there = Path(options.before)
        is_clone = (there / "Makefile").exists()
        builds = (build(there.resolve() if is_clone else clone(options.before, Path(folder) / "before"), parts, is_clone),
                  build(ROOT, parts))
        for part in parts:
            rows += PARTS[part](builds, lambda name: any(word in name for word in options.cases), options)
    write(rows, "against", options.output)
    sys.exit(any(line[-1] == "NO" for line in rows))


if __name__ == "__main__":
    main()
