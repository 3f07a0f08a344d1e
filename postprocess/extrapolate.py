#!/usr/bin/env python3
"""Extrapolate results on cells of different sizes to cells of size zero.

The files are of one scene on two cell sizes c or more. A crack tip and a load make errors that are proportional to c, beside
smaller ones in c^2 and so on: at each time the polynomial in c through the values is taken at c = 0. Two sizes remove the term c,
three also c^2. Printed are means over the last tenth of the runs (--part): the value on each size, the extrapolated one, and by
how many percent of it the finest run, and the extrapolation without the coarsest run, differ from it: estimates of the errors of
both. Where three sizes are halves of each other, the order that the errors show is printed too; about 1 is what the extrapolation
takes for granted.

Where all files hold the estimated error of a column, `their error [%]` is what those leave of the extrapolated value at most: the
errors of the runs, each times its weight, added up. The file of --output has it as a column. Runs that are not at rest are named.

Refined meshes have to be similar: double `rings` where the cells are halved, so that the refined zone keeps its size.
"""

import argparse
import math
from pathlib import Path

import h5py
import numpy as np

from history import UNREADABLE, History, ResultError, add_strict, error_name, refuse_to_replace, run, tell_of_motion
from tabulate import fraction


def main(arguments=None):
    options = parse(arguments)
    histories = sorted(map(History, options.files), key=cell_size, reverse=True)
    check(histories)
    cells = [cell_size(h) for h in histories]
    names = [name for name in histories[-1].select(options.column) if all(name in h.columns for h in histories)]
    uncertain = [name for name in names if all(h.error_of(name) for h in histories)]
    if options.output:
        write(options.output, histories, *curves(histories, names, uncertain))
    print(" ".join(["column", *(f"{cell * 1e3:g} mm" for cell in cells), "extrapolated", "finest [%]"]
                   + ["without coarsest [%]", "order"] * (len(histories) > 2) + ["their error [%]"] * bool(uncertain)))
    for name in names:
        values = [h.late_mean(name, options.part) for h in histories]
        errors = [h.late_mean(error_name(name), options.part) for h in histories] if name in uncertain else []
        print(name, *summary(cells, values), *[left_error(cells, errors, values)] * bool(uncertain))
    return tell_of_motion(histories, options.strict)


def parse(arguments):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="+", metavar="FILE.h5", help="result file of hampm; two or more")
    parser.add_argument("--column", action="append", metavar="NAME", help="column of the history, * and ? allowed; may be "
                        "repeated (default: G_*)")
    parser.add_argument("--part", type=fraction, default=0.1, metavar="X", help="last part of the run to average (default: 0.1)")
    parser.add_argument("-o", "--output", type=Path, metavar="FILE.h5", help="write the extrapolated columns over time as a result "
                        "file, which the other scripts read")
    add_strict(parser)
    options = parser.parse_args(arguments)
    options.column = options.column or ["G_*"]
    return options


def cell_size(history):
    """Size of the smallest cell at the end of a run [m]."""
    if "finest_cell" not in history.columns:
        raise ResultError(f"{history.path}: has no column finest_cell: its size of cells is not known")
    size = float(history.columns["finest_cell"][-1])
    if not 0 < size < math.inf:
        raise ResultError(f"{history.path}: /history/finest_cell ends with {size:g}, which is no size of cells")
    return size


def check(histories):
    """Refuse what can't be extrapolated."""
    if len(histories) < 2:
        raise ResultError("two results or more are needed, on cells of different sizes")
    for coarse, fine in zip(histories, histories[1:]):
        if cell_size(fine) > 0.99 * cell_size(coarse):
            raise ResultError(f"{coarse.path} and {fine.path} have cells of the same size, {cell_size(fine) * 1e3:g} mm")
        for what, a, b in (("end", coarse.times[-1], fine.times[-1]),
                           ("G_ref", *(h.attributes.get("G_ref", 0.0) for h in (coarse, fine)))):
            if not math.isclose(a, b, rel_tol=1e-6):
                raise ResultError(f"{coarse.path} and {fine.path} are not of one scene: {what} is {a:g} and {b:g}")


def weights(cells):
    """What each value counts in the polynomial through (cell size, value) at cell size 0."""
    return [math.prod(other / (other - own) for other in cells if other != own) for own in cells]


def extrapolate(cells, values):
    """Values, numbers or arrays, on these cell sizes, taken to cell size 0."""
    return sum(weight * value for weight, value in zip(weights(cells), values))


def extrapolate_errors(cells, errors):
    """What errors of values on these cell sizes, of whatever sign, leave of the value at cell size 0 at most."""
    return sum(abs(weight) * error for weight, error in zip(weights(cells), errors))


def curves(histories, names, uncertain):
    """Times of the finest run, and the extrapolated columns by name, with the errors of those that have them."""
    times, cells = histories[-1].times, [cell_size(h) for h in histories]

    def samples(name):
        return [np.interp(times, h.times, h.columns[name]) for h in histories]

    return times, ({name: extrapolate(cells, samples(name)) for name in names}
                   | {error_name(name): extrapolate_errors(cells, samples(error_name(name))) for name in uncertain})


def summary(cells, values):
    """The words of a column's line behind its name."""
    limit = extrapolate(cells, values)
    words = [*(f"{value:.6g}" for value in values), f"{limit:.6g}", percent(values[-1], limit)]
    if len(values) > 2:
        words += [percent(extrapolate(cells[1:], values[1:]), limit), order(cells[-3:], values[-3:])]
    return words


def left_error(cells, errors, values):
    """The word for what is left of the errors; '-' where there are none."""
    limit = extrapolate(cells, values)
    return f"{abs(100 * extrapolate_errors(cells, errors) / limit):.3f}" if errors and limit else "-"


def percent(value, limit):
    return f"{100 * (value / limit - 1):+.3f}" if limit else "-"


def order(cells, values):
    """The order that three values show, as text; '-' where cells are not halves, or values do not approach a limit."""
    halves = all(math.isclose(a, 2 * b, rel_tol=1e-6) for a, b in zip(cells, cells[1:]))
    ratio = (values[1] - values[0]) / (values[2] - values[1]) if values[2] != values[1] else 0.0
    return f"{math.log2(ratio):.2f}" if halves and ratio > 0 else "-"


def write(path, histories, times, columns):
    """Write /history as a result file has it."""
    source = histories[-1]
    refuse_to_replace(path, [history.path for history in histories])
    try:
        with h5py.File(path, "w") as file:
            group = file.create_group("history")
            group.attrs.update(source.attributes)
            if known := [distance for h in histories if (distance := h.distance_to_equilibrium()) is not None]:
                group.attrs["distance_to_equilibrium"] = max(known)
            for name, values in {"time": times, **columns}.items():
                item = group.create_dataset(name, data=values)
                item.attrs["units"] = source.units[name]
                item.attrs["long_name"] = source.long_names[name] + (", extrapolated" if name != "time" else "")
            file.create_group("input").attrs["extrapolated_from"] = ", ".join(str(h.path) for h in histories)
    except OSError as error:
        raise ResultError(f"{path}: cannot be written ({error.strerror or error})", UNREADABLE) from error


if __name__ == "__main__":
    run(main)
