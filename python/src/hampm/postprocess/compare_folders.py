"""The folder mode of compare.py: the results of two folders, case by case, with tolerances for cases and columns from a YAML file.

A case is a result file by its place below the folder: `edge_crack.h5`, `cases/mass-lumped/mass-lumped.h5`. The file of tolerances:

    rtol: 1e-9                     of all columns (default: that of --rtol)
    columns:                       of some; the last that matches counts; a number, or [relative, absolute]
      G_*: 1e-6
      K_II: [1e-6, 1e2]
    ignore: [step]                 columns that are left out
    cases:                         the same keys for cases whose names match; what they say comes after what stands above
      fine_*:
        columns: {J: 1e-4}
        interpolate: true          B has other times
        skip: known to differ      is not compared, and told with its reason
"""

from __future__ import annotations

import argparse
import json
import math
import xml.etree.ElementTree as ET
from argparse import Namespace
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase
from pathlib import Path
from textwrap import indent
from typing import Any

import numpy as np

from ..comparison import Comparison, Row, Tolerance
from ..errors import UNREADABLE, ResultError, printable
from ..history import History

KEYS = {"rtol", "atol", "columns", "ignore", "interpolate"}
OF_CASE = KEYS | {"skip"}

RowsOf = Callable[[History, History, Namespace], list[Row]]

NO_COLUMN = "there is no column '{}' in any case that it is for; they have {}"


@dataclass(frozen=True)
class Run:
    """How a model has been run for a comparison: exit code, wall time [s], and what the program said."""

    code: int = 0
    seconds: float | None = None
    log: str = ""


@dataclass(frozen=True)
class Case:
    """A result that was compared. The verdict is "equal", "differs", "skipped: why", or says why nothing could be compared, which is an error."""

    name: str
    verdict: str
    rows: Sequence[Row] = ()
    columns: tuple[str, ...] = ()           # of both files
    versions: tuple[str, ...] = ("", "")    # of the programs of A and B
    run: Run = Run()

    @property
    def is_skipped(self) -> bool:
        return self.verdict.startswith("skipped")

    @property
    def is_error(self) -> bool:
        return self.verdict not in ("equal", "differs") and not self.is_skipped

    @property
    def is_bad(self) -> bool:
        return self.verdict == "differs" or self.is_error


def compare_folders(options: Namespace, rows_of: RowsOf, runs: Mapping[str, Run] | None = None) -> int:
    """Compare all results of two folders, and print and write what was found. Returns the exit code.

    `rows_of(a, b, options)` compares two histories with the options of one case. Of a gate, `runs` has by name how models were run: these are compared.
    """
    rules = read_tolerances(options.tolerances) if options.tolerances else {}
    names = {which: results(folder) for which, folder in (("A", options.a), ("B", options.b))}
    together = sorted({*names["A"], *names["B"], *(f"{name}.h5" for name in runs or ())})
    if not together:
        raise ResultError(f"neither {options.a} nor {options.b} has a result (*.h5)")
    for pattern in rules.get("cases", {}):
        if not any(fnmatchcase(name, pattern) for name in map(case_name, together)):
            raise ResultError(f"{options.tolerances}: no case '{pattern}'; there are {', '.join(map(case_name, together))}")
    asked = [place for place in together if runs is None or case_name(place) in runs]
    cases = [compare_case(place, names, rules, options, rows_of, (runs or {}).get(case_name(place), Run())) for place in asked]
    refuse_unknown_columns(cases, rules if asked == together else {}, options)
    show(cases, options)
    report(cases, options)
    return 1 if any(case.is_bad for case in cases) else 0


def refuse_unknown_columns(cases: Sequence[Case], rules: Mapping[str, Any], options: Namespace) -> None:
    """Refuse patterns that mean no column of any case that they are for: a wrong name would allow what it is to find."""
    given = ("*", "", [*options.columns, *options.ignore, *(item.pattern for item in options.tolerance)])
    parts: list[tuple[str, str, list[str]]] = [given, *(("*" if part is rules else of, f"{options.tolerances}: ", [*part.get("columns", {}), *part.get("ignore", [])])
                                                        for of, part in (("*", rules), *rules.get("cases", {}).items()))]
    for of, where, patterns in parts:
        known = sorted({column for case in cases if fnmatchcase(case.name, of) for column in case.columns})
        for pattern in patterns if known else ():
            if not any(fnmatchcase(column, pattern) for column in known):
                raise ResultError(where + NO_COLUMN.format(pattern, ", ".join(known)))


def report(cases: Sequence[Case], options: Namespace) -> None:
    """Write what was found as JSON and JUnit's XML, where that is asked for."""
    if options.json:
        write(options.json, json.dumps(as_json(cases, options), indent=1, allow_nan=False) + "\n")
    if options.junit:
        write(options.junit, as_junit(cases))


def case_of(path: str | Path, rows: Sequence[Row], histories: Sequence[History] = ()) -> Case:
    """The case of one result."""
    return Case(Path(path).stem, "equal" if all(row.verdict == "equal" for row in rows) else "differs", rows,
                tuple(name for history in histories for name in history), tuple(history.version for history in histories) or ("", ""))


def not_finite(a: History, b: History, rows: Sequence[Row]) -> list[Row]:
    """The rows, where each that agrees has to have finite values."""
    bad = {name: which for which, history in (("A", a), ("B", b)) for name, values in history.columns.items() if not np.all(np.isfinite(values))}
    return [row._replace(verdict=f"not finite in {bad[row.column]}") if row.verdict == "equal" and row.column in bad else row for row in rows]


def last_sample(history: History) -> History:
    """A history of which only the last sample is left."""
    history.columns = {name: values[-1:] for name, values in history.columns.items()}
    return history


def results(folder: str | Path) -> list[str]:
    """Places of the results below a folder."""
    if not Path(folder).is_dir():
        raise ResultError(f"{folder}: there is no such folder", UNREADABLE)
    return [str(path.relative_to(folder)) for path in Path(folder).rglob("*.h5") if path.is_file()]


def case_name(place: str) -> str:
    return place.removesuffix(".h5")


def compare_case(place: str, names: Mapping[str, Sequence[str]], rules: Mapping[str, Any], options: Namespace, rows_of: RowsOf, run: Run) -> Case:
    """A case, compared by its own rules."""
    name = case_name(place)
    own = rules_of(name, rules, options)
    if own.skip:
        return Case(name, f"skipped: {own.skip}", run=run)
    if run.code:
        return Case(name, f"failed with exit code {run.code}: {(run.log.splitlines() or [''])[-1]}", run=run)
    for which in "AB":
        if place not in names[which]:
            return Case(name, f"missing in {which}", run=run)
    paths = [Path(folder) / place for folder in (options.a, options.b)]
    try:
        histories = [History(path, may_be_empty=True) for path in paths]
        known = {name for history in histories for name in history}

        def of_case(patterns: Iterable[Any]) -> list[Any]:
            return [item for item in patterns if any(fnmatchcase(column, getattr(item, "pattern", item)) for column in known)]
        of_this = argparse.Namespace(**vars(options) | {
            "a": paths[0], "b": paths[1], "rtol": own.rtol, "atol": own.atol, "interpolate": own.interpolate, "columns": of_case(options.columns),
            "ignore": of_case([*options.ignore, *own.ignore]), "tolerance": of_case(own.columns)})
        found = case_of(place, rows_of(histories[0], histories[1], of_this), histories)
    except ResultError as error:
        return Case(name, str(error), run=run)
    return replace(found, name=name, run=run)


def rules_of(name: str, rules: Mapping[str, Any], options: Namespace) -> Namespace:
    """What counts for a case: the command line, the file, and its parts for cases that match, each before the next."""
    found = {"rtol": options.rtol, "atol": options.atol, "ignore": [], "interpolate": options.interpolate, "skip": ""}
    columns = []
    for part in (rules, *(part for pattern, part in rules.get("cases", {}).items() if fnmatchcase(name, pattern))):
        found |= {key: part[key] for key in ("rtol", "atol", "interpolate", "skip") if key in part}
        found["ignore"] = [*found["ignore"], *part.get("ignore", [])]
        columns += [Tolerance(pattern, *numbers, *[0.0] * (2 - len(numbers))) for pattern, numbers in part.get("columns", {}).items()]
    return argparse.Namespace(**found, columns=[*columns, *options.tolerance])


def read_tolerances(path: str | Path) -> dict[str, Any]:
    """The rules of a YAML file; ResultError where it has others than are known."""
    try:
        import yaml
    except ImportError as missing:
        raise ResultError(f"{missing}: --tolerances needs it: tools/setup.sh batch") from missing
    try:
        rules = yaml.safe_load(Path(path).read_text(encoding="utf-8")) or {}
    except (OSError, UnicodeDecodeError) as error:
        raise ResultError(f"{path}: cannot be read ({getattr(error, 'strerror', None) or error})", UNREADABLE) from error
    except (yaml.YAMLError, RecursionError) as error:
        raise ResultError(f"{path}: no YAML: {' '.join(str(error).split())}") from error
    cases = checked(path, "", rules, KEYS | {"cases"}).pop("cases", {})
    if not isinstance(cases, dict):
        raise ResultError(f"{path}: cases: names of cases with rules are needed")
    return rules | {"cases": {str(name): checked(path, f"cases: {name}: ", part, OF_CASE) for name, part in cases.items()}}


def checked(path: str | Path, where: str, part: Any, known: set[str]) -> dict[str, Any]:
    """A part of the rules with numbers as numbers and lists as lists."""
    if not isinstance(part, dict):
        raise ResultError(f"{path}: {where}rules are needed, such as 'rtol: 1e-6'")
    if other := [key for key in part if key not in known]:
        raise ResultError(f"{path}: {where}there is no rule '{other[0]}'; there are {', '.join(sorted(known))}")
    for key in ("rtol", "atol"):
        if key in part:
            part[key] = tolerance(path, f"{where}{key}", part[key])
    columns = part.get("columns", {})
    if not isinstance(columns, dict):
        raise ResultError(f"{path}: {where}columns: names with tolerances are needed, such as 'G_*: 1e-6'")
    part["columns"] = {str(name): [tolerance(path, f"{where}columns: {name}", number) for number in (value if isinstance(value, list) else [value])]
                       for name, value in columns.items()}
    if wrong := [name for name, numbers in part["columns"].items() if len(numbers) not in (1, 2) or "=" in name]:
        raise ResultError(f"{path}: {where}columns: {wrong[0]}: a relative tolerance is needed, or [relative, absolute]")
    part["ignore"] = [str(name) for name in (part["ignore"] if isinstance(part.get("ignore"), list) else [part["ignore"]])] if "ignore" in part else []
    if not isinstance(part.get("interpolate", False), bool):
        raise ResultError(f"{path}: {where}interpolate: true or false is needed")
    if "skip" in part and not (isinstance(part["skip"], str) and part["skip"]):
        raise ResultError(f"{path}: {where}skip: a reason is needed")
    return part


def tolerance(path: str | Path, where: str, value: Any) -> float:
    try:
        number = float(value)
    except (TypeError, ValueError):
        number = math.nan
    if not number >= 0 or isinstance(value, bool):
        raise ResultError(f"{path}: {where}: {value} is not a number >= 0")
    return number


def show(cases: Sequence[Case], options: Namespace) -> None:
    """Print a line a case, and below it the columns; with --only-differences those alone that differ. Then how many, and by which programs."""
    for case in cases:
        if case.verdict == "equal" and options.only_differences:
            continue
        differing = [row for row in case.rows if row.verdict != "equal"]
        print(f"{case.name}: {f'{len(differing)} of {len(case.rows)} columns differ' if case.verdict == 'differs' else case.verdict}")
        if case.verdict == "differs":
            print(indent(str(Comparison(differing)), "  "))
    for which, found in versions(cases).items():
        if len(found) > 1 or any(found != other for other in versions(cases).values()):
            print(f"{which}: {', '.join(found)}")
    counts = {"equal": sum(case.verdict == "equal" for case in cases), "different": sum(case.verdict == "differs" for case in cases),
              "in error": sum(case.is_error for case in cases), "skipped": sum(case.is_skipped for case in cases)}
    print(f"{len(cases)} cases: {', '.join(f'{count} {what}' for what, count in counts.items() if count)}")


def versions(cases: Sequence[Case]) -> dict[str, list[str]]:
    """The programs that have written the results of A and of B."""
    return {which: sorted({case.versions[k] for case in cases if case.versions[k]}) for k, which in enumerate("AB")}


def as_json(cases: Sequence[Case], options: Namespace) -> dict[str, Any]:
    """What was found, for programs: numbers as numbers, null where there is none or it is not finite."""
    def number(value: Any) -> Any:
        return value if not isinstance(value, float) or math.isfinite(value) else None
    return {"a": str(options.a), "b": str(options.b), "versions": {which.lower(): found for which, found in versions(cases).items()},
            "agree": not any(case.is_bad for case in cases),
            "cases": [{"name": case.name, "verdict": case.verdict, "is_error": case.is_error, "exit_code": case.run.code, "seconds": case.run.seconds,
                       "columns": [{key: number(value) for key, value in row._asdict().items()} for row in case.rows]} for case in cases]}


def as_junit(cases: Sequence[Case]) -> str:
    """What was found, as services that build and test show it: a test a case. A result that differs is a failure, one that is not there an error."""
    counts = {"tests": len(cases), "failures": sum(case.verdict == "differs" for case in cases), "errors": sum(case.is_error for case in cases),
              "skipped": sum(case.is_skipped for case in cases)}
    suite = ET.Element("testsuite", {"name": "compare", "time": f"{sum(case.run.seconds or 0 for case in cases):.3f}"} | {key: str(count) for key, count in counts.items()})
    if any(versions(cases).values()):
        properties = ET.SubElement(suite, "properties")
        for which, found in versions(cases).items():
            ET.SubElement(properties, "property", name=which, value=", ".join(found))
    for case in cases:
        folder, _, name = case.name.rpartition("/")
        test = ET.SubElement(suite, "testcase", classname=folder or "results", name=name, time=f"{case.run.seconds or 0:.3f}")
        differing = [row for row in case.rows if row.verdict != "equal"]
        if case.is_skipped:
            ET.SubElement(test, "skipped", message=case.verdict.removeprefix("skipped: "))
        elif case.is_error:
            ET.SubElement(test, "error", message=case.verdict).text = case.verdict
        elif differing:
            worst = max(differing, key=lambda row: math.inf if row.relative is None else row.relative)
            words = f"{len(differing)} of {len(case.rows)} columns differ, {worst.column}: {worst.verdict}" + (f" by {worst.relative:.1e}" if worst.relative is not None else "")
            ET.SubElement(test, "failure", message=words).text = str(Comparison(differing))
        if case.run.log:
            ET.SubElement(test, "system-out").text = printable(case.run.log, keep="\n\t")
    ET.indent(suite)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + ET.tostring(suite, encoding="unicode") + "\n"


def write(path: str | Path, text: str) -> None:
    try:
        Path(path).write_text(text, encoding="utf-8")
    except OSError as error:
        raise ResultError(f"{path}: cannot be written ({error.strerror or error})", UNREADABLE) from error
