"""Compare the histories of two hampm results, column by column.

A column agrees when  max |a - b| <= ATOL + RTOL * max |a|,  maxima over all samples: the tolerance belongs to the size
of the column, not to that of a sample, so that a zero crossing is no difference. A value that is not finite agrees
only with the same value. Columns that only one file has and different numbers of samples are differences. `relative` is max |a - b|
over max |a|.

With --paths TOLERANCE the paths of cracks of kind 'path' are compared too, as the last snapshots have them: a path agrees when no place of
it is farther than that from the path of the same crack in the other file. `relative` is then the largest distance over the length in A.

A and B may be folders: then the results (*.h5) at the same places below them are compared, with the tolerances that --tolerances names
(postprocess/compare_folders.py has the form of the file), and a result that only one of them has is a difference.
Exit code: 0 they agree, 1 they differ, 2 the request makes no sense, 4 a file cannot be read.
"""

from __future__ import annotations

import argparse
from argparse import Namespace
from collections.abc import Sequence
from pathlib import Path

from ..comparison import Comparison, Row, Tolerance, compare
from ..errors import ResultError
from ..history import History
from ..scripts import Parser
from . import crack_paths
from .compare_folders import case_of, compare_folders, last_sample, not_finite, report
from .frames import Frames


def main(arguments: Sequence[str] | None = None) -> int:
    options = parse(arguments)
    if options.tolerances or Path(options.a).is_dir() or Path(options.b).is_dir():
        return compare_folders(options, rows_of)
    histories = [History(path, may_be_empty=True) for path in (options.a, options.b)]
    found = Comparison(rows_of(histories[0], histories[1], options))
    print(Comparison(found.differing) if options.only_differences else found)
    what = "columns" if options.paths is None else "columns and paths"
    print(f"{len(found.differing)} of {len(found.rows)} {what} differ" if found.differing else f"all {len(found.rows)} {what} agree")
    report([case_of(options.b, found.compared, histories)], options)
    return 1 if found.differing else 0


def rows_of(a: History, b: History, options: Namespace) -> list[Row]:
    """The rows of two histories, compared as the options say."""
    if options.last:
        a, b = last_sample(a), last_sample(b)
    rows = compare(a, b, rtol=options.rtol, atol=options.atol, tolerances=options.tolerance, columns=options.columns,
                   ignore=options.ignore, interpolate=options.interpolate, exact=options.exact, warnings=options.warnings).compared
    if options.paths is not None:
        rows += path_rows(Frames(options.a), Frames(options.b), options.paths)
    return not_finite(a, b, rows) if options.finite else rows


def parse(arguments: Sequence[str] | None) -> Namespace:
    parser = Parser(__doc__)
    parser.add_argument("a", metavar="A.h5", help="the reference, or a folder of them")
    parser.add_argument("b", metavar="B.h5", help="the result to judge, or a folder of them")
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
    parser.add_argument("--last", action="store_true", help="compare only the last values")
    parser.add_argument("--finite", action="store_true", help="a column with a value that is not finite differs, also where both have it")
    parser.add_argument("--warnings", action="store_true", help="a warning of B that A has not had is a difference")
    parser.add_argument("--only-differences", action="store_true", help="show only what differs")
    parser.add_argument("--tolerances", metavar="FILE.yaml", help="tolerances of cases and columns, for two folders")
    parser.add_argument("--json", metavar="FILE", help="write what was found as JSON")
    parser.add_argument("--junit", metavar="FILE", help="write what was found as JUnit's XML, a test a result")
    options = parser.parse_args(arguments)
    if options.exact and options.interpolate:
        parser.error("--exact and --interpolate exclude each other")
    if options.last and options.interpolate:
        parser.error("--last and --interpolate exclude each other")
    return options


def not_negative(text: str) -> float:
    value = float(text)
    if not value >= 0:
        raise argparse.ArgumentTypeError(f"{text} is not a number >= 0")
    return value


def tolerance(text: str) -> Tolerance:
    """NAME=RTOL[,ATOL] as a Tolerance."""
    pattern, _, numbers = text.partition("=")
    try:
        values = [not_negative(number) for number in numbers.split(",")]
    except ValueError:
        values = []
    if not pattern or len(values) not in (1, 2):
        raise argparse.ArgumentTypeError(f"{text} is not NAME=RTOL[,ATOL]")
    return Tolerance(pattern, *values, *[0.0] * (2 - len(values)))


def path_rows(a: Frames, b: Frames, allowed: float) -> list[Row]:
    """A row for each crack, of the largest distance between its paths in the last snapshots."""
    cracks = []
    for frames in (a, b):
        cracks.append(frames.cracks(frames.number()))
        if not cracks[-1]:
            raise ResultError(f"{frames.path}: has no crack, and --paths compares these")
    stated = f"{allowed:.3g} m"
    rows = []
    for number in range(max(map(len, cracks))):
        name = f"path of crack {number + 1}"
        missing = [which for which, of in zip("AB", cracks) if number >= len(of)]
        if missing:
            rows.append(Row(name, f"missing in {missing[0]}", tolerance=stated))
            continue
        one, other = (of[number].points for of in cracks)
        distance = crack_paths.apart(one, other)
        rows.append(Row(name, "equal" if distance <= allowed else "DIFFERS", distance, distance / crack_paths.length(one), a.times[-1], stated, allowed))
    return rows
