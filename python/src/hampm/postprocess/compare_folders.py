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

import argparse
import json
import math
from collections import namedtuple
from fnmatch import fnmatchcase
from pathlib import Path
from textwrap import indent
from xml.sax.saxutils import escape, quoteattr

import numpy as np

from ..errors import UNREADABLE, ResultError
from ..history import History

from ..comparison import Comparison, Tolerance

KEYS = {"rtol", "atol", "columns", "ignore", "interpolate"}
OF_CASE = KEYS | {"skip"}

Case = namedtuple("Case", "name verdict rows")  # verdict: "equal", "differs", "missing in A", "missing in B", "skipped: why", or an error


def compare_folders(options, rows_of):
    """Compare all results of two folders, and print and write what was found. Returns the exit code.

    `rows_of(a, b, options)` compares two histories with the options of one case.
    """
    rules = read_tolerances(options.tolerances) if options.tolerances else {}
    names = {which: results(folder) for which, folder in (("A", options.a), ("B", options.b))}
    if not names["A"] and not names["B"]:
        raise ResultError(f"neither {options.a} nor {options.b} has a result (*.h5)")
    together = sorted(set(names["A"]) | set(names["B"]))
    for pattern in rules.get("cases", {}):
        if not any(fnmatchcase(name, pattern) for name in map(case_name, together)):
            raise ResultError(f"{options.tolerances}: no case '{pattern}'; there are {', '.join(map(case_name, together))}")
    cases = [compare_case(name, names, rules, options, rows_of) for name in together]
    show(cases, options)
    report(cases, options)
    return 1 if any(is_bad(case) for case in cases) else 0


def report(cases, options):
    """Write what was found as JSON and JUnit's XML, where that is asked for."""
    if options.json:
        write(options.json, json.dumps(as_json(cases, options), indent=1) + "\n")
    if options.junit:
        write(options.junit, as_junit(cases))


def case_of(path, rows):
    """The case of one result."""
    return Case(Path(path).stem, "equal" if all(row.verdict == "equal" for row in rows) else "differs", rows)


def not_finite(a, b, rows):
    """The rows, where each that agrees has to have finite values."""
    bad = {name: which for which, history in (("A", a), ("B", b)) for name, values in history.columns.items() if not np.all(np.isfinite(values))}
    return [row._replace(verdict=f"not finite in {bad[row.column]}") if row.verdict == "equal" and row.column in bad else row for row in rows]


def last_sample(history):
    """A history of which only the last sample is left."""
    history.columns = {name: values[-1:] for name, values in history.columns.items()}
    return history


def results(folder):
    """Places of the results below a folder."""
    if not Path(folder).is_dir():
        raise ResultError(f"{folder}: there is no such folder", UNREADABLE)
    return [str(path.relative_to(folder)) for path in Path(folder).rglob("*.h5") if path.is_file()]


def case_name(place):
    return place.removesuffix(".h5")


def is_bad(case):
    return case.verdict != "equal" and not case.verdict.startswith("skipped")


def compare_case(place, names, rules, options, rows_of):
    """A case, compared by its own rules."""
    name = case_name(place)
    own = rules_of(name, rules, options)
    if own.skip:
        return Case(name, f"skipped: {own.skip}", [])
    for which in "AB":
        if place not in names[which]:
            return Case(name, f"missing in {which}", [])
    paths = [Path(folder) / place for folder in (options.a, options.b)]
    try:
        a, b = (History(path, may_be_empty=True) for path in paths)
        known = [*a.columns, *b.columns]
        of_case = argparse.Namespace(**vars(options) | {
            "a": paths[0], "b": paths[1], "rtol": own.rtol, "atol": own.atol, "interpolate": own.interpolate, "ignore": [*options.ignore, *own.ignore],
            "tolerance": [item for item in own.columns if any(fnmatchcase(column, item.pattern) for column in known)]})
        rows = rows_of(a, b, of_case)
    except ResultError as error:
        return Case(name, str(error), [])
    return case_of(place, rows)._replace(name=name)


def rules_of(name, rules, options):
    """What counts for a case: the command line, the file, and its parts for cases that match, each before the next."""
    found = {"rtol": options.rtol, "atol": options.atol, "ignore": [], "interpolate": options.interpolate, "skip": ""}
    columns = []
    for part in (rules, *(part for pattern, part in rules.get("cases", {}).items() if fnmatchcase(name, pattern))):
        found |= {key: part[key] for key in ("rtol", "atol", "interpolate", "skip") if key in part}
        found["ignore"] = [*found["ignore"], *part.get("ignore", [])]
        columns += [Tolerance(pattern, *numbers, *[0.0] * (2 - len(numbers))) for pattern, numbers in part.get("columns", {}).items()]
    return argparse.Namespace(**found, columns=[*columns, *options.tolerance])


def read_tolerances(path):
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


def checked(path, where, part, known):
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


def tolerance(path, where, value):
    try:
        number = float(value)
    except (TypeError, ValueError):
        number = math.nan
    if not number >= 0 or isinstance(value, bool):
        raise ResultError(f"{path}: {where}: {value} is not a number >= 0")
    return number


def show(cases, options):
    """Print a line a case, and below it the columns; with --only-differences those alone that differ."""
    for case in cases:
        if case.verdict == "equal" and options.only_differences:
            continue
        differing = [row for row in case.rows if row.verdict != "equal"]
        print(f"{case.name}: {f'{len(differing)} of {len(case.rows)} columns differ' if case.verdict == 'differs' else case.verdict}")
        rows = differing if case.verdict == "differs" else []
        if rows:
            print(indent(str(Comparison(rows)), "  "))
    counts = {"equal": sum(case.verdict == "equal" for case in cases), "different": sum(map(is_bad, cases)),
              "skipped": sum(case.verdict.startswith("skipped") for case in cases)}
    print(f"{len(cases)} cases: {', '.join(f'{count} {what}' for what, count in counts.items() if count)}")


def as_json(cases, options):
    """What was found, for programs."""
    return {"a": str(options.a), "b": str(options.b), "agree": not any(map(is_bad, cases)),
            "cases": [{"name": case.name, "verdict": case.verdict, "columns": [row._asdict() for row in case.rows]} for case in cases]}


def as_junit(cases):
    """What was found, as services that build and test show it: a test a case."""
    lines = ['<?xml version="1.0" encoding="UTF-8"?>',
             f'<testsuite name="compare" tests="{len(cases)}" failures="{sum(map(is_bad, cases))}" errors="0" '
             f'skipped="{sum(case.verdict.startswith("skipped") for case in cases)}">']
    for case in cases:
        folder, _, name = case.name.rpartition("/")
        lines.append(f"  <testcase classname={quoteattr(folder or 'results')} name={quoteattr(name)}>")
        if case.verdict.startswith("skipped"):
            lines.append(f"    <skipped message={quoteattr(case.verdict.removeprefix('skipped: '))}/>")
        elif is_bad(case):
            found = str(Comparison([row for row in case.rows if row.verdict != "equal"])) if case.rows else case.verdict
            lines.append(f"    <failure message={quoteattr(case.verdict)}>{escape(found)}</failure>")
        lines.append("  </testcase>")
    return "\n".join([*lines, "</testsuite>", ""])


def write(path, text):
    try:
        Path(path).write_text(text, encoding="utf-8")
    except OSError as error:
        raise ResultError(f"{path}: cannot be written ({error.strerror or error})", UNREADABLE) from error
