"""Run models and hold their results to stored ones: for continuous integration of models, of a new version of hampm, or of a changed program.

REFERENCES is a folder with a result for each model, MODEL.h5. The results, gate.xml (JUnit) and gate.json are in --output, a new folder or one of an
earlier run, whose results go. HAMPM and HAMPM3D name other programs.

    --update            store the results as the references, without their snapshots, where all models have run
    --propose FILE      write a first file of tolerances: what two runs on other threads, and with half the step, differ by from the references

Exit code: 0 all agree; 1 some differ, are missing or have failed; 2 the request makes no sense; 4 a file cannot be read or written.
"""

from __future__ import annotations

import argparse
import math
import subprocess
import time
from argparse import Namespace
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from ..comparison import compare
from ..errors import UNREADABLE, HampmError, ResultError
from ..history import History, is_error
from ..program import program_of_model
from ..scene import Scene
from ..scripts import Parser, tell, whole
from .compare import rows_of
from .compare_folders import Run, compare_folders

KEPT = "history", "input"      # groups of a stored reference
LEAST = 1e-9                   # relative tolerance that is proposed at least
ROOM = 2.0                     # over what was found
SMALL = 0.01                   # a Courant number whose step is found for comparison
COUNTS = "step", "dt", "distance_to_equilibrium"   # columns that follow from the steps


def main(arguments: Sequence[str] | None = None) -> int:
    options = parse(arguments)
    models = chosen(options)
    if options.propose:
        return propose(models, options)
    clear(options.output)
    runs = run_all(models, options.output, options)
    if not options.update:
        return compare_folders(options, rows_of, runs)
    failed = [name for name, done in runs.items() if done.code]
    for name in failed:
        print(f"{name}: failed with exit code {runs[name].code}: {(runs[name].log.splitlines() or [''])[-1]}")
    if not failed:
        options.a.mkdir(parents=True, exist_ok=True)
        for name in models:
            store(options.output / f"{name}.h5", options.a / f"{name}.h5")
        print(f"{len(models)} references in {options.a}")
    return 1 if failed else 0


def parse(arguments: Sequence[str] | None) -> Namespace:
    parser = Parser(__doc__)
    parser.add_argument("a", metavar="REFERENCES", type=Path, help="folder of stored results")
    parser.add_argument("models", metavar="MODEL.nml", type=Path, nargs="+", help="models to run")
    what = parser.add_mutually_exclusive_group()
    what.add_argument("--update", action="store_true", help="store the results as the references")
    what.add_argument("--propose", metavar="FILE.yaml", type=Path, help="write a first file of tolerances")
    parser.add_argument("--only", metavar="NAME", action="append", help="run only models of this name (* and ? allowed); may be repeated")
    parser.add_argument("--tolerances", metavar="FILE.yaml", help="tolerances of cases and columns (compare --help has its form); else all agree to 1e-9")
    parser.add_argument("--output", metavar="FOLDER", type=Path, default=Path("gate"), help="of the results (default: %(default)s)")
    parser.add_argument("--threads", metavar="N", type=whole, default=1, help="of each run (default: %(default)s)")
    parser.add_argument("--jobs", metavar="N", type=whole, default=1, help="models that run at a time (default: %(default)s)")
    options = parser.parse_args(arguments)
    if (options.update or options.propose) and options.tolerances:
        parser.error("--tolerances is for a comparison, not for --update or --propose")
    if not (options.update or options.a.is_dir()):
        raise ResultError(f"{options.a}: there are no references; --update stores them")
    comparison = {"b": options.output, "rtol": LEAST, "atol": 0.0, "columns": ["*"], "ignore": [], "tolerance": [], "interpolate": False, "exact": False, "last": False,
                  "paths": None, "finite": True, "warnings": True, "only_differences": True, "json": options.output / "gate.json", "junit": options.output / "gate.xml"}
    return argparse.Namespace(**vars(options) | comparison)


def chosen(options: Namespace) -> dict[str, Path]:
    """Name -> path of the models to run."""
    models = {}
    for path in options.models:
        if path.stem in models:
            raise ResultError(f"{path.stem}: two models have this name")
        if not path.is_file():
            raise ResultError(f"{path}: there is no such model", UNREADABLE)
        models[path.stem] = path
    for pattern in options.only or ():
        if not any(fnmatchcase(name, pattern) for name in models):
            raise ResultError(f"--only {pattern}: no model has this name; there are {', '.join(models)}")
    return {name: path for name, path in models.items() if not options.only or any(fnmatchcase(name, pattern) for pattern in options.only)}


def clear(output: Path) -> None:
    """Remove the results of an earlier gate; refuse a folder of others."""
    if output.is_dir() and any(output.iterdir()) and not (output / "gate.json").is_file():
        raise ResultError(f"{output}: has files of others; name another folder")
    try:
        output.mkdir(parents=True, exist_ok=True)
        (output / "gate.json").write_text("{}\n")
        for path in [*output.glob("*.h5"), output / "gate.xml"]:
            path.unlink(missing_ok=True)
    except OSError as error:
        raise ResultError(f"{output}: cannot be written ({error.strerror or error})", UNREADABLE) from error


def run_all(models: Mapping[str, Path], output: Path, options: Namespace, **changed: Any) -> dict[str, Run]:
    """Name -> how each model was run, so many at a time; NAME.log has what the program said."""
    with ThreadPoolExecutor(options.jobs) as pool:
        done = pool.map(lambda item: run_one(item[0], item[1], output, changed.get("threads", options.threads), changed.get("settings", {}).get(item[0], {})), models.items())
        return dict(zip(models, done))


def run_one(name: str, model: Path, output: Path, threads: int, settings: Mapping[str, Any]) -> Run:
    """Run a model."""
    program = program_of_model(model)
    words = [word for key, value in settings.items() for word in ("--set", f"{key}={value}")]
    begin = time.monotonic()
    done = subprocess.run([program, model, "--quiet", "--threads", str(threads), "--output", output, "--set", f"output.file={name}.h5", *words, "--force"],
                          stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace")
    (output / f"{name}.log").write_text(done.stdout)
    if done.returncode:
        (output / f"{name}.h5").unlink(missing_ok=True)
    return Run(done.returncode, round(time.monotonic() - begin, 3), done.stdout)


def store(result: Path, reference: Path) -> None:
    """Copy the history and the model of a result, without its snapshots."""
    part = reference.with_name(reference.name + ".part")
    with h5py.File(result) as file, h5py.File(part, "w") as copy:
        copy.attrs.update(file.attrs)
        for group in KEPT:
            if group in file:
                file.copy(group, copy)
    part.replace(reference)


def propose(models: Mapping[str, Path], options: Namespace) -> int:
    """Write tolerances of each model, from runs that should differ from its reference by no more than its own accuracy."""
    if options.propose.exists():
        raise ResultError(f"{options.propose}: is there; a file of tolerances is not replaced", UNREADABLE)
    missing = [name for name in models if not (options.a / f"{name}.h5").is_file()]
    if missing:
        raise ResultError(f"{missing[0]}: has no reference in {options.a}; --update stores it")
    clear(options.output)
    steps = {name: half_the_step(path) for name, path in models.items()}
    lines = [f"# Proposed by hampm gate: {ROOM:g} times what runs on {options.threads + 1} threads and with half the step differ by. To be read, and changed, by people",
             f"rtol: {LEAST:g}", "cases:"]
    found: dict[str, dict[str, float]] = {name: {} for name in models}
    interpolate = set()
    for changed in ({"threads": options.threads + 1}, {"settings": steps}):
        for name, done in run_all(models, options.output, options, **changed).items():
            if done.code:
                tell(f"warning: {name}: failed with exit code {done.code} {'with ' + words_of(steps[name]) if 'settings' in changed else 'on more threads'}")
                continue
            a, b = History(options.a / f"{name}.h5"), History(options.output / f"{name}.h5")
            if a.times.size != b.times.size or not np.allclose(a.times, b.times, rtol=LEAST):
                interpolate.add(name)
            for row in compare(a, b, interpolate=name in interpolate).compared:
                if row.column in a and row.relative:
                    found[name][row.column] = max(found[name].get(row.column, 0.0), row.relative)
                elif row.difference:                 # a column that is zero in the reference
                    found[name][row.column] = math.inf
    for name, columns in found.items():
        ignored = [column for column in columns if column in COUNTS or not math.isfinite(columns[column])]
        lines += [f"  {name}:    # the step was halved by {words_of(steps[name])}"] + ["    interpolate: true"] * (name in interpolate)
        lines += [f"    ignore: [{', '.join(ignored)}]"] * bool(ignored) + ["    columns:"]
        lines += [f"      {column}: {rounded_up(ROOM * value):.0e}" for column, value in sorted(columns.items(), key=lambda item: (is_error(item[0]), item[0]))
                  if column not in ignored and value > LEAST / ROOM]
        if lines[-1] == "    columns:":
            lines[-1] = f"    rtol: {LEAST:g}"
    try:
        options.propose.write_text("\n".join(lines) + "\n")
    except OSError as error:
        raise ResultError(f"{options.propose}: cannot be written ({error.strerror or error})", UNREADABLE) from error
    print(options.propose)
    return 0


def half_the_step(model: Path) -> dict[str, Any]:
    """The settings by which a model takes steps of half their length, or twice as many load steps; none of one without steps."""
    try:
        scene = Scene(model)
        check = scene.check(warn=False)
        method = Scene(text=check.namelist).method
        if method.time == "static":
            return {"method.load_steps": 2 * (method.load_steps or 1)}
        if method.time == "modal":
            return {}
        if method.courant:
            return {"method.courant": method.courant / 2}
        if method.time == "implicit":
            return {"method.time_step": check.time_step / 2}
        return {"method.courant": SMALL * check.time_step / 2 / scene.with_settings({"method.courant": SMALL}).check(warn=False).time_step}
    except HampmError as error:
        raise ResultError(error, error.exit_code) from error


def words_of(settings: Mapping[str, Any]) -> str:
    return " ".join(f"{key} = {value:g}" for key, value in settings.items()) or "nothing: it has none"


def rounded_up(value: float) -> float:
    """A number with one digit, not below another."""
    power = 10.0 ** math.floor(math.log10(value))
    return power * math.ceil(value / power - 1e-9)
