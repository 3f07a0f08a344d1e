"""Extrapolate results on cells of different sizes to cells of size zero.

The files are of one scene on two cell sizes c or more. A crack tip and a load make errors that are proportional to c, beside
smaller ones in c^2 and so on: at each time the polynomial in c through the values is taken at c = 0. Two sizes remove the term c,
three also c^2. Printed are means over the last tenth of the runs (--part): the value on each size, the extrapolated one, and by
how many percent of it the finest run, and the extrapolation without the coarsest run, differ from it: estimates of the errors of
both. Of three sizes the order that the errors show is printed too; about 1 is what the extrapolation
takes for granted.

Where all files hold the estimated error of a column, `their error [%]` is what those leave of the extrapolated value at most: the
errors of the runs, each times its weight, added up. The file of --output has it as a column. Runs that are not at rest are named.

Refined meshes have to be similar: double `rings` where the cells are halved, so that the refined zone keeps its size.
"""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Sequence
from pathlib import Path

import h5py

from ..errors import UNREADABLE, ResultError
from ..extrapolation import Extrapolation, extrapolate
from ..history import History
from ..scripts import Parser, add_strict, refuse_to_replace, tell_of_motion
from .tabulate import fraction


def main(arguments: Sequence[str] | None = None) -> int:
    options = parse(arguments)
    found = extrapolate(map(History, options.files), options.column, options.part)
    if options.output:
        write(options.output, found)
    for row in (found.header, *found):
        print(*row)
    return tell_of_motion(found.histories, options.strict)


def parse(arguments: Sequence[str] | None) -> Namespace:
    parser = Parser(__doc__)
    parser.add_argument("files", nargs="+", metavar="FILE.h5", help="result file of hampm; two or more")
    parser.add_argument("--column", action="append", metavar="NAME", help="column of the history, * and ? allowed; may be "
                        "repeated (default: G_*)")
    parser.add_argument("--part", type=fraction, default=0.1, metavar="X", help="last part of the run to average (default: 0.1)")
    parser.add_argument("-o", "--output", type=Path, metavar="FILE.h5", help="write the extrapolated columns over time as a result "
                        "file, which the scripts read that need a history only (not report.py, which shows the namelist")
    add_strict(parser)
    options = parser.parse_args(arguments)
    options.column = options.column or ["G_*"]
    return options


def write(path: str | Path, found: Extrapolation) -> None:
    """Write /history as a result file has it."""
    source = found.histories[-1]
    refuse_to_replace(path, [history.path for history in found.histories])
    try:
        with h5py.File(path, "w") as file:
            group = file.create_group("history")
            group.attrs.update(source.attributes)
            if known := [distance for h in found.histories if (distance := h.distance_to_equilibrium()) is not None]:
                group.attrs["distance_to_equilibrium"] = max(known)
            for name, values in {"time": found.times, **found.curves}.items():
                item = group.create_dataset(name, data=values)
                item.attrs["units"] = source.units[name]
                item.attrs["long_name"] = source.long_names[name] + (", extrapolated" if name != "time" else "")
            file.create_group("input").attrs["extrapolated_from"] = ", ".join(str(h.path) for h in found.histories)
    except OSError as error:
        raise ResultError(f"{path}: cannot be written ({error.strerror or error})", UNREADABLE) from error
