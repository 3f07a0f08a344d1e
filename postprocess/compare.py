#!/usr/bin/env python3
"""Compare the histories of two hampm results, column by column.

A column agrees when  max |a - b| <= ATOL + RTOL * max |a|,  maxima over all samples: the tolerance belongs to the size
of the column, not to that of a sample, so that a zero crossing is no difference. A value that is not finite agrees
only with the same value. Columns that only one file has and different numbers of samples are differences. `relative` is max |a - b|
over max |a|.

With --paths TOLERANCE the paths of cracks of kind 'path' are compared too, as the last snapshots have them: a path agrees when no place of
it is farther than that from the path of the same crack in the other file. `relative` is then the largest distance over the length in A.
Exit code: 0 they agree, 1 they differ, 2 the request makes no sense, 4 a file cannot be read.
"""

import argparse
from collections import namedtuple
from fnmatch import fnmatchcase

import numpy as np

import crack_paths
from frames import Frames
from history import History, ResultError, run

Tolerance = namedtuple("Tolerance", "pattern rtol atol")
Row = namedtuple("Row", "column difference relative time tolerance verdict")  # all text; the verdict is "equal" or says why not


def main(arguments=None):
    options = parse(arguments)
    a, b = (History(path, may_be_empty=True) for path in (options.a, options.b))
    names = compared(a, b, options)
    if options.exact:
        rows = [exact(a, b, name) for name in names]
    else:
        if options.interpolate:
            b, uncovered = interpolated(a, b)
        rows = [close(a, b, name, tolerance_of(name, options)) for name in names]
        if options.interpolate and uncovered:
            rows.insert(0, Row("(time span)", "-", "-", "-", "-", uncovered))
    if options.paths is not None:
        rows += path_rows(Frames(options.a), Frames(options.b), options.paths)
    differing = [row for row in rows if row.verdict != "equal"]
    print_table(rows)
    what = "columns" if options.paths is None else "columns and paths"
    print(f"{len(differing)} of {len(rows)} {what} differ" if differing else f"all {len(rows)} {what} agree")
    return 1 if differing else 0


def parse(arguments):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("a", metavar="A.h5", help="the reference")
    parser.add_argument("b", metavar="B.h5", help="the result to judge")
    parser.add_argument("--rtol", type=not_negative, default=1e-9, help="relative tolerance (default: %(default)g)")
    parser.add_argument("--atol", type=not_negative, default=0.0, help="absolute tolerance (default: %(default)g)")
    parser.add_argument("--tolerance", type=tolerance, action="append", default=[], metavar="NAME=RTOL[,ATOL]",
                        help="tolerance of one column (* and ? allowed; the last that matches counts); may be repeated")
    parser.add_argument("--columns", nargs="+", default=["*"], metavar="NAME",
                        help="compare only these (* and ? allowed)")
    parser.add_argument("--ignore", nargs="+", default=[], metavar="NAME", help="leave these out (* and ? allowed)")
    parser.add_argument("--interpolate", action="store_true",
                        help="interpolate B linearly onto A's times; B must cover them up to one sample")
    parser.add_argument("--paths", type=not_negative, metavar="TOLERANCE",
                        help="compare also the paths of cracks in the last snapshots, whose largest distance may be that [m]")
    parser.add_argument("--exact", action="store_true", help="demand the same type and bytes, tolerances do not count")
    options = parser.parse_args(arguments)
    if options.exact and options.interpolate:
        parser.error("--exact and --interpolate exclude each other")
    return options


def not_negative(text):
    value = float(text)
    if not value >= 0:
        raise argparse.ArgumentTypeError(f"{text} is not a number >= 0")
    return value


def tolerance(text):
    """NAME=RTOL[,ATOL] as a Tolerance."""
    pattern, _, numbers = text.partition("=")
    try:
        values = [not_negative(number) for number in numbers.split(",")]
    except ValueError:
        values = []
    if not pattern or len(values) not in (1, 2):
        raise argparse.ArgumentTypeError(f"{text} is not NAME=RTOL[,ATOL]")
    return Tolerance(pattern, *values, *[0.0] * (2 - len(values)))


def compared(a, b, options):
    """Names of the columns to compare, of either file; a pattern that matches none is a mistake."""
    known = list(dict.fromkeys([*a.columns, *b.columns]))
    for pattern in [*options.columns, *(item.pattern for item in options.tolerance)]:
        if not any(fnmatchcase(name, pattern) for name in known):
            raise ResultError(f"no column '{pattern}' in {a.path} or {b.path}; they have {', '.join(known)}")
    names = [name for name in known if matches(name, options.columns) and not matches(name, options.ignore)]
    if not names:
        raise ResultError("nothing is left to compare")
    return names


def matches(name, patterns):
    return any(fnmatchcase(name, pattern) for pattern in patterns)


def tolerance_of(name, options):
    """The last --tolerance that matches, or the general one."""
    own = [item for item in options.tolerance if fnmatchcase(name, item.pattern)]
    return own[-1] if own else Tolerance("*", options.rtol, options.atol)


def interpolated(a, b):
    """B at those of A's times that it covers and A's columns there cut to match; what B does not cover, in words."""
    if a.times.size == 0 or b.times.size == 0:
        raise ResultError("nothing to interpolate: a history holds no samples")
    step = np.max(np.diff(a.times), initial=0.0)
    inside = (a.times >= b.times[0]) & (a.times <= b.times[-1])
    uncovered = ""
    if b.times[0] > a.times[0] + step or b.times[-1] < a.times[-1] - step:
        uncovered = f"B covers {b.times[0]:.6g} to {b.times[-1]:.6g} s, A {a.times[0]:.6g} to {a.times[-1]:.6g} s"
    times = a.times[inside]
    b.columns = {name: np.interp(times, b.times, values) for name, values in b.columns.items()}
    a.columns = {name: values[inside] for name, values in a.columns.items()}
    return b, uncovered


def close(a, b, name, allowed):
    """The row of a column compared with a tolerance."""
    stated = f"{allowed.rtol:.3g} rel" + (f" + {allowed.atol:.3g}" if allowed.atol else "")
    unlike = unlikeness(a, b, name)
    if unlike:
        return Row(name, "-", "-", "-", stated, unlike)
    x, y = a.columns[name].astype(float), b.columns[name].astype(float)
    same = (x == y) | (np.isnan(x) & np.isnan(y))
    with np.errstate(invalid="ignore"):
        difference = np.where(same, 0.0, np.where(np.isfinite(x) & np.isfinite(y), np.abs(x - y), np.inf))
    agrees = np.max(difference, initial=0.0) <= allowed.atol + allowed.rtol * size_of(x)
    return Row(name, *largest(a, difference, size_of(x)), stated, "equal" if agrees else "DIFFERS")


def size_of(values):
    """The largest of a column that is finite."""
    return np.max(np.abs(values[np.isfinite(values)]), initial=0.0)


def exact(a, b, name):
    """The row of a column compared byte by byte."""
    unlike = unlikeness(a, b, name)
    if unlike:
        return Row(name, "-", "-", "-", "exact", unlike)
    x, y = a.columns[name], b.columns[name]
    if x.dtype != y.dtype:
        return Row(name, "-", "-", "-", "exact", f"A is {x.dtype}, B is {y.dtype}")
    if x.tobytes() == y.tobytes():
        return Row(name, "0", "0", "-", "exact", "equal")
    difference = np.abs(x.astype(float) - y.astype(float))
    return Row(name, *largest(a, difference, size_of(x.astype(float))), "exact", "DIFFERS")


def path_rows(a, b, allowed):
    """A row for each crack, of the largest distance between its paths in the last snapshots."""
    cracks = []
    for frames in (a, b):
        cracks.append(frames.cracks(frames.number()))
        if not cracks[-1]:
            raise ResultError(f"{frames.path}: has no crack, and --paths compares these")
    stated, time = f"{allowed:.3g} m", f"{a.times[-1]:.6g}"
    rows = []
    for number in range(max(map(len, cracks))):
        name = f"path of crack {number + 1}"
        missing = [which for which, of in zip("AB", cracks) if number >= len(of)]
        if missing:
            rows.append(Row(name, "-", "-", "-", stated, f"missing in {missing[0]}"))
            continue
        one, other = (of[number].points for of in cracks)
        distance = crack_paths.apart(one, other)
        rows.append(Row(name, f"{distance:.3e}", f"{distance / crack_paths.length(one):.1e}", time, stated,
                        "equal" if distance <= allowed else "DIFFERS"))
    return rows


def unlikeness(a, b, name):
    """Why a column cannot be compared sample by sample, or nothing."""
    for history, which in ((a, "A"), (b, "B")):
        if name not in history.columns:
            return f"missing in {which}"
    lengths = a.columns[name].size, b.columns[name].size
    return "" if lengths[0] == lengths[1] else f"A has {lengths[0]} samples, B has {lengths[1]}"


def largest(a, difference, size):
    """The largest difference, also over the size of the column, and its time, as text."""
    if not np.any(difference > 0):
        return "0", "0", "-"
    where = int(np.argmax(difference))
    return f"{difference[where]:.3e}", f"{difference[where] / size:.1e}" if size > 0 else "-", f"{a.times[where]:.6g}"


def print_table(rows):
    """Aligned columns under a header."""
    header = Row("column", "max |a-b|", "relative", "at time [s]", "tolerance", "verdict")
    widths = [max(map(len, cells)) for cells in zip(header, *rows)]
    for row in (header, *rows):
        print("  ".join(cell.ljust(width) for cell, width in zip(row, widths)).rstrip())


if __name__ == "__main__":
    run(main)
