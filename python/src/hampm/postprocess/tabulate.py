"""Table of the last values of columns of one or more hampm results, such as energy release rates at rest.

A value is the mean over the last tenth of the run (--part), so that what still rings counts little. Energy release rates are
given over G_ref where all files have one, else in their unit. With --converged each is followed by its difference from that, in percent, with --errors by its
estimated error where the files hold that, in the unit of the value. A run that is not at rest is named where G, J or K are asked for.
"""

from __future__ import annotations

import argparse
import csv
import sys
from argparse import Namespace
from collections.abc import Sequence

from ..errors import USAGE, ResultError
from ..history import History, error_name, is_rate, matches
from ..scripts import Parser, add_strict, tell, tell_of_motion


def main(arguments: Sequence[str] | None = None) -> int:
    options = parse(arguments)
    histories = [History(path) for path in options.files]
    names = [name for name in dict.fromkeys(name for history in histories for name in history.columns)
             if any(matches(name, pattern) for pattern in options.column)]
    if not names:
        raise ResultError(f"no column of {', '.join(map(str, options.files))} matches {', '.join(options.column)}", USAGE)
    rates_are_ratios = is_ratio(histories, names, options)
    uncertain = {name for name in names for history in histories
                 if options.errors and history.error_of(name) and error_name(name) not in names}
    rows = [["file", *(heading for name in names for heading in headings(name, name in uncertain, options))]]
    if not options.csv:
        rows.append(["", *(word for name in names for word in unit_words(histories, name, name in uncertain, rates_are_ratios, options))])
    rows += [[history.stem, *(word for name in names for word in words(history, name, name in uncertain, rates_are_ratios, options))]
             for history in histories]
    if options.csv:
        csv.writer(sys.stdout).writerows(rows)
    else:
        widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
        for row in rows:
            print("  ".join([row[0].ljust(widths[0]), *(word.rjust(width) for word, width in zip(row[1:], widths[1:]))]))
    return tell_of_motion(histories if any(is_of_crack(name) for name in names) else [], options.strict)


def parse(arguments: Sequence[str] | None) -> Namespace:
    parser = Parser(__doc__)
    parser.add_argument("files", nargs="+", metavar="FILE.h5", help="result file of hampm")
    parser.add_argument("--column", action="append", metavar="NAME", help="column of the history, * and ? allowed; may be "
                        "repeated (default: G_*)")
    parser.add_argument("--converged", type=float, metavar="VALUE", help="converged G/G_ref")
    parser.add_argument("--part", type=fraction, default=0.1, metavar="X", help="last part of the run to average (default: 0.1)")
    parser.add_argument("--errors", action="store_true", help="print the estimated errors beside their values")
    parser.add_argument("--csv", action="store_true", help="print comma-separated values")
    add_strict(parser)
    options = parser.parse_args(arguments)
    options.column = options.column or ["G_*"]
    return options


def fraction(text: str) -> float:
    value = float(text)
    if not 0 < value <= 1:
        raise argparse.ArgumentTypeError("must be in (0, 1]")
    return value


def is_of_crack(name: str) -> bool:
    """Whether a column has a static value of its own: a G, J or K."""
    return is_rate(name) or name.startswith("K_")


def is_ratio(histories: Sequence[History], names: Sequence[str], options: Namespace) -> bool:
    """Whether energy release rates are given over G_ref: where all files that have one of them have it. A column has one unit."""
    with_rates = [history for history in histories if any(is_rate(name) and name in history.columns for name in names)]
    without = [history for history in with_rates if "G_ref" not in history.attributes]
    if without and options.converged:
        without[0].g_ref()  # which says what is missing
    if without and len(without) < len(with_rates):
        tell(f"warning: {without[0].path} has no G_ref: energy release rates are in J/m2 in all rows")
    return not without


def unit_words(histories: Sequence[History], name: str, is_uncertain: bool, rates_are_ratios: bool, options: Namespace) -> list[str]:
    """The units of the columns of a name."""
    unit = next(history.units[name] for history in histories if name in history.columns)
    found = [f"[{'1' if is_rate(name) and rates_are_ratios else unit}]"]
    return [*found, *[""] * (len(headings(name, False, options)) - 1), *found * is_uncertain]


def headings(name: str, is_uncertain: bool, options: Namespace) -> list[str]:
    return [name, *["[%]"] * bool(options.converged and is_rate(name)), *[error_name(name)] * is_uncertain]


def words(history: History, name: str, is_uncertain: bool, rates_are_ratios: bool, options: Namespace) -> list[str]:
    """The value of a column as text, its difference from the converged one where that is asked for, and its error."""
    if name not in history.columns:
        return ["-"] * len(headings(name, is_uncertain, options))
    g_ref = history.g_ref() if is_rate(name) and rates_are_ratios else 1.0
    value = history.late_mean(name, options.part) / g_ref
    found = [f"{value:.5g}"]
    if options.converged and is_rate(name):
        found.append(f"{100 * (value / options.converged - 1):+.2f}")
    if is_uncertain:
        error = history.error_of(name)
        found.append(f"{history.late_mean(error, options.part) / g_ref:.2g}" if error else "-")
    return found
