"""Study of convergence from the table of a sweep: errors, observed orders, extrapolated values, and what accuracy costs.

    study.py SWEEP.yaml --error G_vcct_I --reference 1287.4 --by grid.cell

The cases that differ only in the key of --by, and in keys that follow from it, are a group; of each is printed, from coarse to fine: the
value of the column, its error, and the order that this error and the one before show. From the last three cases of a group follow the
order that they show without a reference and the value that they tend to (Richardson). Sizes are the values of --by, or their inverse
where cases get more particles as it grows (--inverse, --direct: as it is said).

--reference is a number, a column of the table, or 'extrapolated' (of each group, where it is left out). Written are STUDY.csv, a row a
case, and the figure STUDY.png of error over processor time and particles with the Pareto front, below the folder of the sweep; other
names by --output. Given a table.csv in the place of a sweep, that is taken.
"""

from __future__ import annotations

import csv
import math
import sys
from argparse import Namespace
from collections.abc import Sequence
from pathlib import Path
from textwrap import indent
from typing import Any

from ..errors import UNREADABLE, ResultError
from ..extrapolation import observed, richardson
from ..scripts import Parser
from ..tables import Table
from . import plot_work_precision
from .pareto import number

OWN = ("case", "outcome", "message", "starts")


def main(arguments: Sequence[str] | None = None) -> None:
    options = parse(arguments)
    table = options.sweep if options.sweep.suffix == ".csv" else collected(options.sweep)
    rows = read_table(table, options)
    groups = grouped(rows, options)
    stem = options.output or table.with_name(f"study_{options.error}")
    results = [row for label, group in groups.items() for row in study(label, group, options)]
    path = stem.with_name(stem.name + ".csv")
    write(path, results)
    print(f"{path}: {len(results)} cases in {len(groups)} {'group' if len(groups) == 1 else 'groups'}\n")
    if any(math.isfinite(number(row, "error_percent")) for row in results):
        plot_work_precision.main([str(path), "--output", str(stem.with_name(stem.name + ".png")), *(["--title", options.title] if options.title else [])])


def parse(arguments: Sequence[str] | None) -> Namespace:
    parser = Parser(__doc__)
    parser.add_argument("sweep", metavar="SWEEP.yaml", type=Path, help="a sweep that has been run, or table.csv of one")
    parser.add_argument("--error", required=True, metavar="COLUMN", help="column of the table whose error is asked for")
    parser.add_argument("--by", required=True, metavar="KEY", help="key or own name that is refined, such as grid.cell")
    parser.add_argument("--reference", default="extrapolated", metavar="X", help="number, column or 'extrapolated' (default)")
    direction = parser.add_mutually_exclusive_group()
    direction.add_argument("--inverse", action="store_true", help="larger values of --by are finer")
    direction.add_argument("--direct", action="store_true", help="smaller values of --by are finer")
    parser.add_argument("--title", metavar="TEXT", help="above the figure")
    parser.add_argument("-o", "--output", type=Path, metavar="STUDY", help="names of what is written, without .csv and .png")
    return parser.parse_args(arguments)


def collected(path: Path) -> Path:
    """The table of a sweep as it is now."""
    from ..batch.declaration import read_sweep
    from ..batch.table import collect, report
    sweep = read_sweep(path)
    report(sweep, *collect(sweep), brief=True)
    return sweep.output / "table.csv"


def read_table(path: Path, options: Namespace) -> list[dict[str, Any]]:
    """Rows of the cases that are done; those that are not are counted."""
    rows = plot_work_precision.read_rows(path, [options.error, options.by, *([] if is_word(options.reference) else [options.reference])])
    good = [row for row in rows if math.isfinite(number(row, options.error))]
    if len(good) < len(rows):
        print(f"{len(rows) - len(good)} of {len(rows)} cases without a number in {options.error} left out", file=sys.stderr)
    if not good:
        raise ResultError(f"{path}: no case has a number in {options.error}")
    if wrong := [row[options.by] for row in good if not number(row, options.by) > 0]:
        raise ResultError(f"{path}: {options.by}: '{wrong[0]}' is no size: a number above 0 is needed")
    return good


def is_word(text: str) -> bool:
    """Whether --reference is a number or asks for the extrapolated value."""
    return text == "extrapolated" or math.isfinite(number({"": text}, ""))


def settings(rows: Sequence[dict[str, Any]]) -> list[str]:
    """Columns that are settings of a sweep: keys and own names."""
    return [name for name in rows[0] if "." in name or name.startswith("$")]


def grouped(rows: Sequence[dict[str, Any]], options: Namespace) -> dict[str, list[dict[str, Any]]]:
    """Label -> its cases from coarse to fine. What follows from --by, and from what is a reason for another group already, is none."""
    by, apart = options.by, list[str]()
    for name in settings(rows):
        if name != by and len({row[name] for row in rows}) > 1 and not follows(rows, name, (by, *apart)):
            apart.append(name)
    last = [name.lstrip("$").rpartition(".")[2] for name in apart]
    words = {name: word if last.count(word) == 1 else name for name, word in zip(apart, last)}
    groups: dict[str, list[dict[str, Any]]] = {}
    for row in rows:
        groups.setdefault(" ".join(f"{word}={row[name]}" for name, word in words.items()) or "all cases", []).append(row)
    for label, group in groups.items():
        group.sort(key=lambda row: size(row, by, is_inverse(rows, options)), reverse=True)
        sizes = [number(row, by) for row in group]
        if len(set(sizes)) < len(sizes):
            raise ResultError(f"{label}: several cases have the same {by}; what differs in them is no number of the table")
    return groups


def follows(rows: Sequence[dict[str, Any]], name: str, others: Sequence[str]) -> bool:
    """Whether a column has one value for each combination of others."""
    return len({tuple(row[other] for other in (*others, name)) for row in rows}) == len({tuple(row[other] for other in others) for row in rows})


def is_inverse(rows: Sequence[dict[str, Any]], options: Namespace) -> bool:
    """Whether larger values of --by are finer: as is said, or where the case of the largest value has more particles than that of the least."""
    if options.inverse or options.direct:
        return options.inverse
    ends = [max(number(row, "particles") for row in rows if number(row, options.by) == end)
            for end in (extreme(number(row, options.by) for row in rows) for extreme in (min, max))]
    return ends[1] > ends[0]


def size(row: dict[str, Any], by: str, inverse: bool) -> float:
    return 1 / number(row, by) if inverse else number(row, by)


def study(label: str, group: Sequence[dict[str, Any]], options: Namespace) -> list[dict[str, Any]]:
    """Print the study of a group; its rows for the table that is written."""
    inverse = is_inverse(group, options)
    sizes = [size(row, options.by, inverse) for row in group]
    values = [number(row, options.error) for row in group]
    order, limit = richardson(sizes[-3:], values[-3:])
    references = [reference(row, limit, options) for row in group]
    errors = [100 * (value / exact - 1) if exact else math.nan for value, exact in zip(values, references)]
    orders = [math.nan, *(observed(sizes[k - 1:k + 1], errors[k - 1:k + 1]) for k in range(1, len(group)))]
    print(f"{label}:")
    lines = [[f"{number(row, options.by):.6g}", f"{value:.6g}", shown(error, "+.3g"), shown(p, ".2f"), row.get("particles") or "-", row.get("cpu_seconds") or "-"]
             for row, value, error, p in zip(group, values, errors, orders)]
    print(indent(str(Table([options.by, options.error, "error [%]", "order", "particles", "processor time [s]"], lines)), "  "))
    print(f"  {extrapolation(order, limit, references[-1], options)}\n")
    before = f"{label} " if label != "all cases" else ""
    return [{"name": f"{before}{options.by.lstrip('$').rpartition('.')[2]}={number(row, options.by):.6g}", "family": label,
             "case": row.get("case", ""), options.by: row[options.by], "value": value, "reference": exact, "error_percent": shown(error, ".10g", ""),
             "order": shown(p, ".6g", ""), "extrapolated": shown(limit, ".10g", ""), "particles": row.get("particles", ""),
             "cpu_seconds": row.get("cpu_seconds", "")}
            for row, value, exact, error, p in zip(group, values, references, errors, orders)]


def reference(row: dict[str, Any], limit: float, options: Namespace) -> float:
    """What the value of a case is held to; not a number where it is not known."""
    if options.reference == "extrapolated":
        return limit
    value = number({"": options.reference}, "")
    return value if math.isfinite(value) else number(row, options.reference)


def extrapolation(order: float, limit: float, exact: float, options: Namespace) -> str:
    """What the last three cases say, in words."""
    if not math.isfinite(limit):
        return "no order without a reference: three cases are needed whose values tend to one"
    words = f"the last three tend to {limit:.6g} with the order {order:.2f}"
    if options.reference != "extrapolated" and exact:
        words += f", {100 * (limit / exact - 1):+.3g} % from the reference"
    return words


def shown(value: float, form: str, none: str = "-") -> str:
    return f"{value:{form}}" if math.isfinite(value) else none


def write(path: Path, rows: Sequence[dict[str, Any]]) -> None:
    try:
        with open(path, "w", newline="") as file:
            table = csv.DictWriter(file, list(rows[0]))
            table.writeheader()
            table.writerows(rows)
    except OSError as error:
        raise ResultError(f"{path}: cannot be written ({error.strerror or error})", UNREADABLE) from error
