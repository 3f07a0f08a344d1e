#!/usr/bin/env python3
"""Table of the last values of columns of one or more hampm results, such as energy release rates at rest.

A value is the mean over the last tenth of the run (--part), so that what still rings counts little. Energy release rates are
given over G_ref where there is one. With --converged each is followed by its difference from that, in percent.
"""

import argparse
import csv
import sys
from fnmatch import fnmatchcase

from history import USAGE, History, ResultError, run


def main(arguments=None):
    options = parse(arguments)
    histories = [History(path) for path in options.files]
    names = [name for name in dict.fromkeys(name for history in histories for name in history.columns)
             if any(fnmatchcase(name, pattern) for pattern in options.column)]
    if not names:
        raise ResultError(f"no column of {', '.join(map(str, options.files))} matches {', '.join(options.column)}", USAGE)
    rows = [["file", *(heading for name in names for heading in headings(name, options))]]
    rows += [[history.stem, *(word for name in names for word in words(history, name, options))] for history in histories]
    if options.csv:
        csv.writer(sys.stdout).writerows(rows)
    else:
        widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
        for row in rows:
            print("  ".join([row[0].ljust(widths[0]), *(word.rjust(width) for word, width in zip(row[1:], widths[1:]))]))


def parse(arguments):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="+", metavar="FILE.h5", help="result file of hampm")
    parser.add_argument("--column", action="append", metavar="NAME", help="column of the history, * and ? allowed; may be "
                        "repeated (default: G_*)")
    parser.add_argument("--converged", type=float, metavar="VALUE", help="converged G/G_ref")
    parser.add_argument("--part", type=fraction, default=0.1, metavar="X", help="last part of the run to average (default: 0.1)")
    parser.add_argument("--csv", action="store_true", help="print comma-separated values")
    options = parser.parse_args(arguments)
    options.column = options.column or ["G_*"]
    return options


def fraction(text):
    value = float(text)
    if not 0 < value <= 1:
        raise argparse.ArgumentTypeError("must be in (0, 1]")
    return value


def is_rate(name):
    """Whether a column is an energy release rate, which G_ref scales."""
    return name.startswith("G_") or name == "J" or name.startswith("J_")


def headings(name, options):
    return [name, "[%]"] if options.converged and is_rate(name) else [name]


def words(history, name, options):
    """The value of a column as text, and its difference from the converged one where that is asked for."""
    count = len(headings(name, options))
    if name not in history.columns:
        return ["-"] * count
    value = history.late_mean(name, options.part)
    if is_rate(name) and "G_ref" in history.attributes:
        value /= history.attributes["G_ref"]
    return [f"{value:.5g}", f"{100 * (value / options.converged - 1):+.2f}"][:count] if count > 1 else [f"{value:.5g}"]


if __name__ == "__main__":
    run(main)
