"""Results on cells of different sizes, extrapolated to cells of size zero."""

import math
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from .history import History, error_name
from .arrays import Array
from .errors import ResultError
from .tables import Table


class Extrapolation(Table[list[str]]):
    """A row for each column: its values on the cells, coarse to fine, the extrapolated one, and how far the finest run is from it.

    cells    sizes of the cells [m], coarse to fine
    values   column -> value extrapolated to cells of size zero, in its unit
    errors   column -> what the estimated errors of the runs leave of it at most, of those that have them
    times    of the finest run [s]
    curves   column -> extrapolated samples at these times, with the errors of those that have them
    """

    def __init__(self, histories: Iterable[History], columns: Sequence[str] = ("G_*",), part: float = 0.1):
        self.histories = ordered(histories)
        self.cells = [cell_size(history) for history in self.histories]
        names = [name for name in self.histories[-1].select(columns) if all(name in h.columns for h in self.histories)]
        uncertain = [name for name in names if all(h.error_of(name) for h in self.histories)]
        self.times, self.curves = curves(self.histories, self.cells, names, uncertain)
        self.values: dict[str, float] = {}
        self.errors: dict[str, float] = {}
        rows: list[list[str]] = []
        for name in names:
            values = [h.late_mean(name, part) for h in self.histories]
            errors = [h.late_mean(error_name(name), part) for h in self.histories] if name in uncertain else []
            self.values[name] = limit(self.cells, values)
            if errors:
                self.errors[name] = left_of_errors(self.cells, errors)
            rows.append([name, *summary(self.cells, values), *[left_error(self.cells, errors, values)] * bool(uncertain)])
        super().__init__(["column", *(f"{cell * 1e3:g} mm" for cell in self.cells), "extrapolated", "finest [%]"]
                         + ["without coarsest [%]", "order"] * (len(self.cells) > 2) + ["their error [%]"] * bool(uncertain), rows)


def extrapolate(results: Iterable[str | Path | History], columns: Sequence[str] = ("G_*",), part: float = 0.1) -> Extrapolation:
    """Extrapolate results of one model on two cell sizes or more, given as paths or `History`, to cells of size zero.

    A crack tip and a load make errors that are proportional to the size c, beside smaller ones in c^2 and so on: at each time the
    polynomial in c through the values is taken at c = 0. `columns` are names in which * and ? are allowed; values are means over the last
    `part` of the runs.
    """
    return Extrapolation([item if isinstance(item, History) else History(item) for item in results], columns, part)


def cell_size(history: History) -> float:
    """Size of the smallest cell at the end of a run [m]."""
    if "finest_cell" not in history.columns:
        raise ResultError(f"{history.path}: has no column finest_cell: its size of cells is not known")
    if history.times.size == 0:
        raise ResultError(f"{history.path}: /history holds no samples yet")
    size = float(history.columns["finest_cell"][-1])
    if not 0 < size < math.inf:
        raise ResultError(f"{history.path}: /history/finest_cell ends with {size:g}, which is no size of cells")
    return size


def ordered(histories: Iterable[History]) -> list[History]:
    """From coarse to fine cells; refuses what can't be extrapolated."""
    histories = sorted(histories, key=cell_size, reverse=True)
    if len(histories) < 2:
        raise ResultError("two results or more are needed, on cells of different sizes")
    for coarse, fine in zip(histories, histories[1:]):
        if cell_size(fine) > 0.99 * cell_size(coarse):
            raise ResultError(f"{coarse.path} and {fine.path} have cells of the same size, {cell_size(fine) * 1e3:g} mm")
        for what, a, b in (("end", coarse.times[-1], fine.times[-1]),
                           ("G_ref", *(h.attributes.get("G_ref", 0.0) for h in (coarse, fine)))):
            if not math.isclose(a, b, rel_tol=1e-6):
                raise ResultError(f"{coarse.path} and {fine.path} are not of one scene: {what} is {a:g} and {b:g}")
    return histories


def weights(cells: Sequence[float]) -> list[float]:
    """What each value counts in the polynomial through (cell size, value) at cell size 0."""
    return [math.prod(other / (other - own) for other in cells if other != own) for own in cells]


def limit(cells: Sequence[float], values: Sequence[Any]) -> Any:
    """Values, numbers or arrays, on these cell sizes, taken to cell size 0."""
    return sum(weight * value for weight, value in zip(weights(cells), values))


def left_of_errors(cells: Sequence[float], errors: Sequence[Any]) -> Any:
    """What errors of values on these cell sizes, of whatever sign, leave of the value at cell size 0 at most."""
    return sum(abs(weight) * error for weight, error in zip(weights(cells), errors))


def curves(histories: Sequence[History], cells: Sequence[float], names: Sequence[str], uncertain: Sequence[str]) -> tuple[Array, dict[str, Array]]:
    """Times of the finest run, and the extrapolated columns by name, with the errors of those that have them."""
    times = histories[-1].times

    def samples(name: str) -> list[Array]:
        return [np.interp(times, h.times, h.columns[name]) for h in histories]

    return times, ({name: limit(cells, samples(name)) for name in names}
                   | {error_name(name): left_of_errors(cells, samples(error_name(name))) for name in uncertain})


def summary(cells: Sequence[float], values: Sequence[float]) -> list[str]:
    """The words of a column's line behind its name."""
    at_zero = limit(cells, values)
    words = [*(f"{value:.6g}" for value in values), f"{at_zero:.6g}", percent(values[-1], at_zero)]
    if len(values) > 2:
        order, _ = richardson(cells[-3:], values[-3:])
        words += [percent(limit(cells[1:], values[1:]), at_zero), "-" if math.isnan(order) else f"{order:.2f}"]
    return words


def left_error(cells: Sequence[float], errors: Sequence[float], values: Sequence[float]) -> str:
    """The word for what is left of the errors; '-' where there are none."""
    at_zero = limit(cells, values)
    return f"{abs(100 * left_of_errors(cells, errors) / at_zero):.3f}" if errors and at_zero else "-"


def percent(value: float, at_zero: float) -> str:
    """The word for how far a value is from the extrapolated one [%]."""
    return f"{100 * (value / at_zero - 1):+.3f}" if at_zero else "-"


def observed(sizes: Sequence[float], errors: Sequence[float]) -> float:
    """The order that two errors show; not a number where they differ in sign or one is zero."""
    if not errors[0] * errors[1] > 0:
        return math.nan
    return math.log(errors[0] / errors[1]) / math.log(sizes[0] / sizes[1])


def richardson(sizes: Sequence[float], values: Sequence[float]) -> tuple[float, float]:
    """The order p, and the limit f, of three values f + c h^p; not numbers where they are fewer or do not tend to one.

    p is that of (f1 - f2)/(f2 - f3) = (h1^p - h2^p)/(h2^p - h3^p), which rises with p, by bisection (Roache 1998, unequal ratios).
    """
    if len(values) < 3 or values[1] == values[2] or not (values[0] - values[1]) / (values[1] - values[2]) > 0:
        return math.nan, math.nan
    coarse, fine = math.log(sizes[0] / sizes[1]), math.log(sizes[1] / sizes[2])
    wanted = (values[0] - values[1]) / (values[1] - values[2])

    def ratio(p: float) -> float:
        return math.exp(p * fine) * math.expm1(p * coarse) / math.expm1(p * fine)
    low, high = 1e-3, 20.0
    if not ratio(low) < wanted < ratio(high):
        return math.nan, math.nan
    for _ in range(100):
        middle = (low + high) / 2
        low, high = (middle, high) if ratio(middle) < wanted else (low, middle)
    return low, values[2] + (values[2] - values[1]) / math.expm1(low * fine)
