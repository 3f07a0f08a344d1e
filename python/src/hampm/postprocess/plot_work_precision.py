"""Work-precision diagrams of a table of runs: how small the error gets for what cost, and which settings are worth it.

A table is a CSV file with a row for each run and the columns `name` (its settings in words), `family` (of settings that belong
together), `cpu_seconds`, `particles` and `error_percent`, whose sign does not count; others are ignored, and so are rows
without an error, which are counted. Several tables are taken as one. Left the error over the cost, right over the
particles; stepped the Pareto front, of settings that no other beats in both, numbered as in the list below where they are few. Of more than
five families those are drawn that are on the front most often. The front and the cheapest setting for each accuracy are printed.
"""

from __future__ import annotations

import argparse
import csv
import sys
from argparse import Namespace
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from textwrap import indent
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..errors import UNREADABLE, ResultError
from ..tables import Table
from .pareto import cheapest, front, measured, number, size
from .pictures import COLOURS, picture_parser, plt, verbatim, write

MARKERS = "osD^vP*X<>"
LIMITS = (5, 2, 1, 0.5, 0.3)  # of the error [%]
ENDINGS = {"_percent": "%", "_seconds": "s", "_bytes": "B"}
CLOSE = 14  # distance of points on a front that share a label, in hundredths of an inch
MOST_FAMILIES = 5
MOST_NUMBERS = 12  # settings on the front that are numbered
AXES = {"cpu_seconds": "processor time [s]", "particles": "particles", "error_percent": "error [%]",
        "sustained_percent": "sustained error [%]"}


def main(arguments: Sequence[str] | None = None) -> None:
    options = parse(arguments)
    rows = runs_of(options)
    write_tables(rows, options)
    write(lambda _: draw(rows, options), options, "_work_precision")


def figure(options: Namespace) -> Figure:
    """The picture that these options ask for."""
    return draw(runs_of(options), options)


def runs_of(options: Namespace) -> list[Mapping[str, Any]]:
    """The rows of the tables that have an error and a cost; on standard error how many have not."""
    needed = [options.cost, options.error, options.family, *options.only]
    rows = [row for path in options.files for row in read_table(path, needed)
            if all(row[column] == value for column, value in options.only.items())]
    good = measured(rows, options.cost, options.error)
    if not good:
        raise ResultError(f"{', '.join(options.files)}: no row has numbers in {options.cost} and {options.error}")
    if len(good) < len(rows):
        print(f"{len(rows) - len(good)} of {len(rows)} rows without a number in {options.cost} or {options.error} left out",
              file=sys.stderr)
    return good


def parse(arguments: Sequence[str] | None) -> Namespace:
    parser = picture_parser(__doc__, "_work_precision", "table of runs", "TABLE.csv")
    parser.add_argument("--error", default="error_percent", metavar="COLUMN", help="error [%%] (default: %(default)s)")
    parser.add_argument("--cost", default="cpu_seconds", metavar="COLUMN", help="cost (default: %(default)s)")
    parser.add_argument("--family", default="family", metavar="COLUMN",
                        help="runs that share a colour and a marker (default: %(default)s)")
    parser.add_argument("--only", type=condition, action="append", default=[], metavar="COLUMN=VALUE",
                        help="take rows with this value alone; may be repeated")
    options = parser.parse_args(arguments)
    options.only = dict(options.only)
    return options


def condition(text: str) -> tuple[str, str]:
    column, equals, value = text.partition("=")
    if not (column and equals):
        raise argparse.ArgumentTypeError(f"{text} is not COLUMN=VALUE")
    return column, value


def read_table(path: str | Path, needed: Sequence[str]) -> list[dict[str, Any]]:
    """Rows of a CSV file of named runs as dictionaries."""
    return read_rows(path, ["name", *needed])


def read_rows(path: str | Path, needed: Sequence[str]) -> list[dict[str, Any]]:
    """Rows of a CSV file with certain columns as dictionaries."""
    try:
        with open(path, newline="") as file:
            reader = csv.DictReader(file)
            rows, columns = list(reader), reader.fieldnames or []
    except (OSError, UnicodeDecodeError) as error:
        raise ResultError(f"{path}: cannot be read ({getattr(error, 'strerror', None) or error})", UNREADABLE) from error
    if missing := [name for name in needed if name not in columns]:
        raise ResultError(f"{path}: no column '{missing[0]}'; it has {', '.join(columns) or 'none'}")
    return rows


def write_tables(rows: Sequence[Mapping[str, Any]], options: Namespace) -> None:
    """Print the Pareto front and the cheapest setting for each accuracy."""
    heading = ["setting", options.family, options.cost, "particles", options.error]
    best = front(rows, options.cost, options.error)
    print_table("Pareto front", heading, [words(row, options) for row in best])
    within = [(limit, cheapest(rows, options.cost, options.error, limit)) for limit in LIMITS]
    print_table("cheapest within", ["[%]", *heading],
                [[f"{limit:g}", *(words(row, options) if row else ["none", "", "", "", ""])] for limit, row in within])


def words(row: Mapping[str, Any], options: Namespace) -> list[str]:
    return [row["name"], row[options.family], f"{number(row, options.cost):.4g}", row.get("particles") or "-",
            f"{number(row, options.error):+.3g}"]


def print_table(title: str, heading: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    print(f"{title}:\n{indent(str(Table(heading, rows)), '  ')}")


def draw(rows: Sequence[Mapping[str, Any]], options: Namespace) -> Figure:
    """The figure: the error over each cost, and below the settings on the fronts."""
    costs = [options.cost]
    if options.cost != "particles" and measured(rows, "particles", options.error):
        costs.append("particles")
    figure, axes = plt.subplots(1, len(costs), figsize=(1.0 + 4.4 * len(costs), 4.4), squeeze=False, sharey=True,
                                layout="constrained")
    fronts = [front(rows, cost, options.error) for cost in costs]
    numbers: dict[str, int] = {}
    for row in (row for best in fronts for row in best):
        numbers.setdefault(row["name"], len(numbers) + 1)
    if len(numbers) > MOST_NUMBERS:
        numbers = {}
    drawn = main_families(rows, fronts, options.family)
    for panel, cost, best in zip(axes[0], costs, fronts):
        draw_runs(panel, [row for row in rows if row[options.family] in drawn], cost, options)
        panel.set(xscale="log", yscale="log", xlabel=axis_words(cost))
        draw_front(panel, best, cost, options.error, numbers)
        panel.yaxis.set_major_formatter("{x:g}")
        panel.yaxis.set_minor_formatter(plt.LogFormatter())
    draw_limits(axes[0])
    axes[0, 0].set_ylabel(axis_words(options.error))
    if options.title:
        figure.suptitle(options.title)
    write_key(figure, axes[0, 0], numbers)
    return figure


def main_families(rows: Sequence[Mapping[str, Any]], fronts: Sequence[Sequence[Mapping[str, Any]]], family: str) -> list[str]:
    """The families that are drawn, in the order of the table: all, or those that are on the fronts most often."""
    every = list(dict.fromkeys(row[family] for row in rows))
    on_front = Counter(row[family] for best in fronts for row in best)
    chosen = sorted(every, key=lambda name: -on_front[name])[:MOST_FAMILIES]
    return [name for name in every if name in chosen]


def axis_words(column: str) -> str:
    """What an axis shows: relative_percent -> relative [%]."""
    for ending, unit in ENDINGS.items():
        if column.endswith(ending) and column not in AXES:
            return verbatim(f"{column.removesuffix(ending).replace('_', ' ')} [{unit}]")
    return AXES.get(column, verbatim(column.replace("_", " ")))


def draw_runs(axes: Axes, rows: Sequence[Mapping[str, Any]], cost: str, options: Namespace) -> None:
    """All runs, each family in its colour and marker."""
    rows = measured(rows, cost, options.error)
    for k, family in enumerate(dict.fromkeys(row[options.family] for row in rows)):
        of_family = [row for row in rows if row[options.family] == family]
        axes.plot([number(row, cost) for row in of_family], heights(of_family, rows, options.error), linestyle="none",
                  marker=MARKERS[k % len(MARKERS)], color=COLOURS[k % len(COLOURS)], markersize=5, alpha=0.8,
                  markeredgewidth=0, label=verbatim(family))


def heights(rows: Sequence[Mapping[str, Any]], among: Sequence[Mapping[str, Any]], error: str) -> list[float]:
    """Errors for a logarithmic axis: one of zero stands at half of the least among all others."""
    least = min((size(row, error) for row in among if size(row, error) > 0), default=1.0)
    return [size(row, error) or least / 2 for row in rows]


def draw_front(axes: Axes, best: Sequence[Mapping[str, Any]], cost: str, error: str, numbers: Mapping[str, int]) -> None:
    """The least error for each cost as a stepped line, its points numbered, those that are close by their first and last."""
    costs, errors = [number(row, cost) for row in best], heights(best, best, error)
    axes.step(costs, errors, where="post", color="0.2", linewidth=1.0, zorder=1, label="Pareto front")
    if not numbers:
        return
    places = axes.transData.transform(list(zip(costs, errors)))
    first = 0
    for k in range(len(best)):
        if k + 1 == len(best) or max(abs(places[k + 1] - places[first])) > CLOSE:
            ends = dict.fromkeys(str(numbers[best[end]["name"]]) for end in (first, k))
            axes.annotate("–".join(ends), (costs[first], errors[first]), xytext=(-3, -4), textcoords="offset points", ha="right",
                          va="top", fontsize=8)
            first = k + 1


def draw_limits(panels: Any) -> None:
    """Lines at round errors within the picture, named at its right edge."""
    low, high = panels[0].get_ylim()
    for limit in (limit for limit in LIMITS if low < limit < high):
        for axes in panels:
            axes.axhline(limit, color="0.6", linestyle=(0, (1, 2)), linewidth=0.9, zorder=0)
        panels[-1].annotate(f"{limit:g} %", (1, limit), xycoords=("axes fraction", "data"), xytext=(4, 0), ha="left", va="center",
                            textcoords="offset points", fontsize=8, color="0.4")


def write_key(figure: Figure, axes: Axes, numbers: Mapping[str, int]) -> None:
    """Under the panels the families, and what the numbers on the fronts stand for."""
    handles, labels = axes.get_legend_handles_labels()
    handles += [plt.Line2D([], [], linestyle="none", marker=f"${n}$", color="black", markersize=5 + 3 * (n > 9), markeredgewidth=0)
                for n in numbers.values()]
    labels += [verbatim(name) for name in numbers]
    across = max(1, min(len(labels), round(figure.get_figwidth() * 11 / (max(map(len, labels)) + 4))))
    rows = -(-len(labels) // across)
    figure.set_figheight(figure.get_figheight() + 0.2 * rows)
    figure.legend(handles, labels, loc="outside lower center", ncols=across, frameon=False, fontsize=8)
