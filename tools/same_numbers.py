"""Whether two programs give the same numbers on every namelist of the repository: those of input/, the lessons, the cases and the
regression tests with all their runs, and the models in code blocks of the documents.

    .venv/bin/python tools/same_numbers.py --before PROGRAM --revision REV [FILE ...]

The program of before reads the namelists as they are at REV, the present one those of this folder; tools/upgrade.py --columns tells the present names
of columns and fields. All columns of the history, all fields of the snapshots and all numeric attributes are compared. A difference is
given over the largest value of the column and of those of its kind (the same unit, such as all energies; the same tensor). A run ends where
the program of before has taken `--seconds`; the present one makes as many steps.

The difference allowed is 1e-12, and 1e-9 in static and implicit runs, whose equations Newton's iteration solves to 1e-11 of the forces and friction to
1e-9. What rounding changes more is measured where it is needed, for instance a reaction that is zero but for rounding: the program of before runs
again with the elastic constants and densities larger, and then smaller, by 4e-16, and ten times the difference of the column is allowed ("rounding").
Both programs should be of the same kind of build, release or checked: other optimisation may let faces stick, slip or part an iteration sooner or later.

The table is same_numbers.csv. Exit code 1 where numbers, exit codes or the names of columns differ.
"""

import argparse
import functools
import json
import math
import os
import re
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import NamedTuple

import h5py
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "bench"))

from tables import ROOT, write  # noqa: E402

try:
    import tomllib
except ImportError:  # Python 3.10
    import tomli as tomllib

ROUNDING, SOLVED = 1e-12, 1e-9
ITERATED = re.compile(r"\btime *= *'?(static|implicit)\b")
CONSTANT = re.compile(r"\b((?:young|shear|poisson|density)\w* *= *)([-+.\deE]+)")
PERTURBED = 1 + 2*np.finfo(float).eps, 1 - 2*np.finfo(float).eps    # factors of the constants
MARGIN = 10                                                         # of what rounding changes
PLACES = re.compile(r"_cell|length|_[xy]$")                         # columns with a unit whose sizes say nothing of each other's
COMPONENT = re.compile(r"_(xx|yy|zz|xy|[xyz]|I{1,3}|[123])$")
OF_COLUMN = re.compile(r"(_error)?(_tip\d+)?$")                     # what may follow the name of a column
STOPPED = re.compile(r"step (\d+), t = .* stopped by", re.DOTALL)
STOP = 5                                                            # exit code


class Case(NamedTuple):
    """A run: its name, its namelist and what --set overrides."""

    name: str
    file: Path
    settings: tuple = ()


# --- cases ------------------------------------------------------------------------------------------------------------

def models_in(document):
    """The complete models in the code blocks of a document."""
    return [block for block in re.findall(r"^```\w*\n(.*?)^```", document.read_text(), re.DOTALL | re.MULTILINE)
            if re.search(r"^ *&run\b", block, re.MULTILINE) and re.search(r"^ *&body\b", block, re.MULTILINE)]


def cases_in(tree, folder):
    """All runs of a tree, by name; models of documents are written into a folder."""
    found = []
    for file in sorted(path for part in ("input", "docs", "tests") for path in (tree / part).rglob("*.nml")):
        name = str(file.relative_to(tree))
        expected = file.with_name("expected.toml")
        runs = tomllib.loads(expected.read_text()).get("runs", {"": []}) if expected.exists() else {"": []}
        found += [Case(f"{name} {run}".strip(), file, tuple(settings)) for run, settings in runs.items()]
    for document in sorted([*tree.glob("*.md"), *(tree / "docs").rglob("*.md")]):
        for k, model in enumerate(models_in(document), 1):
            file = folder / f"{document.stem}_{k}.nml"
            file.write_text(model)
            found.append(Case(f"{document.relative_to(tree)} {k}", file))
    return {case.name: case for case in found}


def tree_of(revision, folder):
    """The files of a revision, in a folder."""
    archive = subprocess.run(["git", "-C", ROOT, "archive", revision], check=True, capture_output=True).stdout
    subprocess.run(["tar", "-x", "-C", folder], input=archive, check=True)
    return folder


def new_names():
    """Present names of columns and fields by earlier ones."""
    script = ROOT / "tools/upgrade.py"
    return json.loads(subprocess.run([sys.executable, script, "--columns"], check=True, capture_output=True).stdout) if script.exists() else {}


def renamed(name, names):
    """The present name of a column, a field or an attribute."""
    if name in names:
        return names[name]
    end = OF_COLUMN.search(name)[0]
    stem = name.removesuffix(end)
    return names.get(stem, stem) + end


# --- runs -------------------------------------------------------------------------------------------------------------

def run(program, case, folder, *more):
    """Run a case: exit code, messages, result file or None."""
    settings = [word for setting in case.settings for word in ("--set", setting)]
    outcome = subprocess.run([program, case.file, *settings, *more, "--quiet", "--force", "--threads", "1", "--output", folder],
                             capture_output=True, text=True, errors="replace", check=False, cwd=case.file.parent)
    return outcome.returncode, outcome.stderr, next(iter(sorted(Path(folder).glob("*.h5"))), None)


def content(path):
    """All numbers of a result: (part, name) -> (values, unit)."""
    found = {}

    def add(name, item):
        part, _, last = name.rpartition("/")
        if isinstance(item, h5py.Dataset) and item.dtype.kind in "fiub":
            found[part, last] = item[()], item.attrs.get("units", "")
        for key, value in item.attrs.items():
            if np.asarray(value).dtype.kind in "fiu":
                found[name, f"attribute {key}"] = np.asarray(value), ""
    with h5py.File(path) as file:
        file.visititems(add)
    return found


def in_order(found):
    """Order of particles: by number within a snapshot."""
    number = found.get(("VTKHDF/particles/PointData", "id"))
    if number is None:
        return None
    starts = found["VTKHDF/particles/Steps", "PointOffsets"][0]
    snapshot = np.searchsorted(starts, np.arange(number[0].size), side="right")
    return np.lexsort((number[0], snapshot))


def sorted_values(found):
    """The numbers with particles in the order of their numbers."""
    order = in_order(found)
    return {key: (values[order] if order is not None and len(values) == order.size and key[0].startswith("VTKHDF/particles") and
                  key[1] not in ("Connectivity", "Offsets", "Types") else values, unit)
            for key, (values, unit) in ((key, (np.atleast_1d(values), unit)) for key, (values, unit) in found.items())}


def difference(before, after):
    """Largest difference of two arrays; infinite where they have different shapes or one is not a number where the other is."""
    if before.shape != after.shape:
        return math.inf
    x, y = before.astype(float), after.astype(float)
    with np.errstate(invalid="ignore"):
        each = np.where((x == y) | (np.isnan(x) & np.isnan(y)), 0.0, np.abs(x - y))
    return float(np.max(np.where(np.isnan(each), np.inf, each), initial=0.0))


def size(values):
    """Largest finite value, in size."""
    values = values.astype(float)
    return float(np.max(np.abs(values[np.isfinite(values)]), initial=0.0))


def family(key, unit):
    """Of what sizes are compared together."""
    part, name = key
    if part == "history" and unit not in ("", "1") and not PLACES.search(name):
        return part, unit
    return part, COMPONENT.sub("", OF_COLUMN.sub("", name))


def gaps(before, after, names):
    """Relative differences of two results by column; infinite where one is missing in either."""
    ends = sorted_values(content(before)), sorted_values(content(after))
    new = {(part, name.replace(last, renamed(last, names))): value for (part, name), value in ends[0].items()
           for last in [name.removeprefix("attribute ")]}
    sizes = {}
    for key, (values, unit) in new.items():
        whole = family(key, unit)
        sizes[whole] = max(sizes.get(whole, 0.0), size(values), 1.0 if unit == "1" or "distance" in key[1] else 0.0)
    found = {key: math.inf for key in new.keys() ^ ends[1].keys()}
    for key in new.keys() & ends[1].keys():
        value = difference(new[key][0], ends[1][key][0])
        found[key] = value/sizes[family(key, new[key][1])] if value else 0.0
    return found


def perturbed(case, factor):
    """The case with other elastic constants and densities, in a file beside it."""
    text = CONSTANT.sub(lambda match: f"{match[1]}{float(match[2])*factor:.17g}", case.file.read_text())
    file = case.file.with_name(f"{case.file.stem}_perturbed.nml")
    file.write_text(text)
    return case._replace(file=file)


def rounding(program, case, result, folder, steps, names):
    """What rounding changes in the columns of a result of a program: the largest relative differences of the perturbed runs."""
    found = {}
    for k, factor in enumerate(PERTURBED):
        _, _, other = run(program, perturbed(case, factor), folder / f"perturbed_{k}", *steps)
        for (part, name), value in (gaps(result, other, {}) if other else {}).items():
            last = name.removeprefix("attribute ")
            key = part, name.replace(last, renamed(last, names))
            found[key] = max(found.get(key, 0.0), value)
    return found


def row(builds, pair, names, seconds):
    """The row of a case: its name, how far it goes, its worst column, the difference there, what is allowed, verdict."""
    before, after = pair
    if after is None:
        return [before.name, "", "no such namelist now", "", "", "DIFFERENT"]
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        code, messages, result = run(builds[0], before, folder / "before", "--time-limit", str(seconds))
        stopped = STOPPED.search(messages) if code == STOP else None
        steps = ("--steps", str(max(1, int(stopped[1])))) if stopped else ()
        if stopped and stopped[1] == "0":
            code, _, result = run(builds[0], before, folder / "before", *steps)
        other_code, _, other = run(builds[1], after, folder / "now", *steps)
        extent = f"{steps[1]} steps" if steps else "whole"
        if code != other_code or (result is None) != (other is None):
            return [before.name, extent, f"exit code {code}, now {other_code}", "", "", "DIFFERENT"]
        if result is None:
            return [before.name, "no result", f"exit code {code}", "", "", "same"]
        found = gaps(result, other, names)
        least = SOLVED if ITERATED.search(f"{before.file.read_text()} {before.settings}") else ROUNDING
        key = max(found, key=found.get)
        if found[key] <= least:
            return [before.name, extent, "/".join(key), f"{found[key]:.1e}", f"{least:.0e}", "same"]
        noise = rounding(builds[0], before, result, folder, steps, names)
        allowed = {key: max(least, MARGIN*noise.get(key, 0.0)) for key in found}
        key = max(found, key=lambda key: (found[key] > allowed[key], found[key]))
        return [before.name, extent, "/".join(key), f"{found[key]:.1e}", f"{allowed[key]:.0e}",
                "DIFFERENT" if found[key] > allowed[key] else "rounding"]


def main():
    os.environ |= {"OMP_WAIT_POLICY": "passive", "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file", nargs="*", default=[""], help="only runs whose name (path and run) holds one of these")
    parser.add_argument("--before", metavar="PROGRAM", type=Path, required=True, help="program of before")
    parser.add_argument("--revision", metavar="REV", required=True, help="of which it is")
    parser.add_argument("--now", metavar="PROGRAM", type=Path, default=ROOT / "build/release/hampm", help="default: build/release/hampm")
    parser.add_argument("--seconds", metavar="S", type=float, default=60, help="for which a run goes on with the program of before; default: 60")
    parser.add_argument("--jobs", metavar="N", type=int, default=os.cpu_count(), help="cases at a time; default: one a processor")
    parser.add_argument("--output", metavar="DIR", type=Path, default=Path("results"), help="folder of the table")
    options = parser.parse_args()
    options.output.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        folders = {name: Path(folder) / name for name in ("tree", "before", "now")}
        for path in folders.values():
            path.mkdir()
        before = cases_in(tree_of(options.revision, folders["tree"]), folders["before"])
        now = cases_in(ROOT, folders["now"])
        pairs = [(case, now.get(name)) for name, case in before.items() if any(word in name for word in options.file)]
        judge = functools.partial(row, (options.before.resolve(), options.now.resolve()), names=new_names(), seconds=options.seconds)
        rows = []
        with ThreadPoolExecutor(options.jobs) as several:
            for found in several.map(judge, pairs):
                rows.append(found)
                print(*found, sep="  ", file=sys.stderr, flush=True)
    rows.sort(key=lambda line: (("DIFFERENT", "rounding", "same").index(line[-1]), -float(line[3] or 0)))
    write([["run", "extent", "largest difference in", "relative", "allowed", "verdict"], *rows], "same_numbers", options.output)
    bad = sum(line[-1] == "DIFFERENT" for line in rows)
    print(f"{len(rows)} runs, {len(rows) - bad} with the same numbers, {bad} without")
    return bad > 0


if __name__ == "__main__":
    sys.exit(main())
