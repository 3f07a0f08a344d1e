"""Two histories compared column by column."""

import re
from collections.abc import Iterable, Sequence
from fnmatch import fnmatchcase
from pathlib import Path
from typing import NamedTuple

import numpy as np

from .history import History
from .arrays import Array
from .errors import ResultError
from .tables import Table

NUMBER = r"[-+]?\d[\d.]*([eE][-+]?\d+)?"


class Tolerance(NamedTuple):
    """What columns whose names match a pattern may differ by: `atol`, in their unit, and `rtol` times their largest value."""

    pattern: str
    rtol: float
    atol: float = 0.0


class Row(NamedTuple):
    """A column that was compared; the verdict is "equal" or says why not.

    difference, relative  the largest difference, and that over the largest value of A; None where there is none
    time                  at which it is [s]
    tolerance             in words; `allowed` is the difference that it allows, None of what has to be the same
    """

    column: str
    verdict: str
    difference: float | None = None
    relative: float | None = None
    time: float | None = None
    tolerance: str = "-"
    allowed: float | None = None

    def words(self) -> list[str]:
        """The row as text."""
        none = self.difference == 0
        return [self.column, *("0" if none else "-" if value is None else format(value, form)
                               for value, form in ((self.difference, ".3e"), (self.relative, ".1e"))),
                "-" if self.time is None else f"{self.time:.6g}", self.tolerance, self.verdict]


HEADER = ("column", "max |a-b|", "relative", "at time [s]", "tolerance", "verdict")


class Comparison(Table[list[str]]):
    """A row for each column; true where all agree. `differing` are the rows of those that do not."""

    def __init__(self, rows: Iterable[Row]):
        self.compared = list(rows)
        super().__init__(HEADER, [row.words() for row in self.compared])

    @property
    def differing(self) -> list[Row]:
        """The rows of columns that do not agree."""
        return [row for row in self.compared if row.verdict != "equal"]

    def __bool__(self) -> bool:
        return not self.differing


def compare(a: str | Path | History, b: str | Path | History, *, rtol: float = 1e-9, atol: float = 0.0, tolerances: Sequence[Tolerance] = (),
            columns: Sequence[str] = ("*",), ignore: Sequence[str] = (), interpolate: bool = False, exact: bool = False, warnings: bool = False) -> Comparison:
    """Compare two results, given as paths or `History`.

    A column agrees when  max |a - b| <= atol + rtol * max |a|,  maxima over all samples, or with `exact` when type and bytes are the
    same. `columns` and those to `ignore` are names in which * and ? are allowed; of `tolerances`, each a `Tolerance` of its own for such
    names, the last that matches counts. With `interpolate`, b is taken linearly at the times of a; it must cover them up to one sample. With
    `warnings`, those of b that a has not had are a difference, whatever the numbers in them.
    """
    a, b = (item if isinstance(item, History) else History(item, may_be_empty=True) for item in (a, b))
    general = Tolerance("*", rtol, atol)
    for item in (general, *tolerances):
        if not (item.rtol >= 0 and item.atol >= 0):
            raise ResultError(f"{item}: tolerances are numbers >= 0")
    names = compared(a, b, columns, ignore, tolerances)
    rows = [Row("(warnings)", f"new in B: {text}") for text in new_warnings(a, b)] if warnings else []
    if interpolate and not exact:
        a, b, uncovered = interpolated(a, b)
        rows += [Row("(time span)", uncovered)] * bool(uncovered)
    elif a.times.size != b.times.size:
        rows.append(Row("(rows)", f"A has {a.times.size} samples, B has {b.times.size}"))
        names = [name for name in names if (name in a) != (name in b)]
    return Comparison(rows + [identical(a, b, name) if exact else close(a, b, name, tolerance_of(name, tolerances, general)) for name in names])


def new_warnings(a: History, b: History) -> list[str]:
    """Warnings of a run that another has not had, whatever the numbers in them."""
    had = {re.sub(NUMBER, "#", text) for text in a.warnings()}
    return [text for text in b.warnings() if re.sub(NUMBER, "#", text) not in had]


def compared(a: History, b: History, columns: Sequence[str], ignore: Sequence[str], tolerances: Sequence[Tolerance]) -> list[str]:
    """Names of the columns to compare, of either file; a pattern that matches none is a mistake."""
    known = list(dict.fromkeys([*a.columns, *b.columns]))
    for pattern in [*columns, *ignore, *(item.pattern for item in tolerances)]:
        if not any(fnmatchcase(name, pattern) for name in known):
            raise ResultError(f"no column '{pattern}' in {a.path} or {b.path}; they have {', '.join(known)}")
    names = [name for name in known if matches_any(name, columns) and not matches_any(name, ignore)]
    if not names:
        raise ResultError("nothing is left to compare")
    return names


def matches_any(name: str, patterns: Iterable[str]) -> bool:
    """Whether any of the patterns means a name."""
    return any(fnmatchcase(name, pattern) for pattern in patterns)


def tolerance_of(name: str, tolerances: Sequence[Tolerance], general: Tolerance) -> Tolerance:
    """The last of the tolerances that matches, or the general one."""
    own = [item for item in tolerances if fnmatchcase(name, item.pattern)]
    return own[-1] if own else general


def interpolated(a: History, b: History) -> tuple[History, History, str]:
    """A at those of its times that B covers, B at these; what B does not cover, in words."""
    if a.times.size == 0 or b.times.size == 0:
        raise ResultError("nothing to interpolate: a history holds no samples")
    step = np.max(np.diff(a.times), initial=0.0)
    inside = (a.times >= b.times[0]) & (a.times <= b.times[-1])
    uncovered = ""
    if b.times[0] > a.times[0] + step or b.times[-1] < a.times[-1] - step:
        uncovered = f"B covers {b.times[0]:.6g} to {b.times[-1]:.6g} s, A {a.times[0]:.6g} to {a.times[-1]:.6g} s"
    times = a.times[inside]
    return (a.with_columns({name: values[inside] for name, values in a.columns.items()}),
            b.with_columns({name: np.interp(times, b.times, values) for name, values in b.columns.items()}), uncovered)


def close(a: History, b: History, name: str, allowed: Tolerance) -> Row:
    """The row of a column compared with a tolerance."""
    stated = f"{allowed.rtol:.3g} rel" + (f" + {allowed.atol:.3g}" if allowed.atol else "")
    unlike = unlikeness(a, b, name)
    if unlike:
        return Row(name, unlike, tolerance=stated)
    x, y = a.columns[name].astype(float), b.columns[name].astype(float)
    same = (x == y) | (np.isnan(x) & np.isnan(y))
    with np.errstate(invalid="ignore"):
        difference = np.where(same, 0.0, np.where(np.isfinite(x) & np.isfinite(y), np.abs(x - y), np.inf))
    most = allowed.atol + allowed.rtol * size_of(x)
    bad = [which for which, values in (("A", x), ("B", y)) if not np.all(np.isfinite(values[~same]))]
    verdict = f"not finite in {' and '.join(bad)}" if bad else "equal" if np.max(difference, initial=0.0) <= most else "DIFFERS"
    return Row(name, verdict, *largest(a, difference, size_of(x)), stated, most)


def size_of(values: Array) -> float:
    """The largest of a column that is finite."""
    return float(np.max(np.abs(values[np.isfinite(values)]), initial=0.0))


def identical(a: History, b: History, name: str) -> Row:
    """The row of a column compared byte by byte."""
    unlike = unlikeness(a, b, name)
    if unlike:
        return Row(name, unlike, tolerance="exact")
    x, y = a.columns[name], b.columns[name]
    if x.dtype != y.dtype:
        return Row(name, f"A is {x.dtype}, B is {y.dtype}", tolerance="exact")
    if x.tobytes() == y.tobytes():
        return Row(name, "equal", 0.0, 0.0, None, "exact")
    difference = np.abs(x.astype(float) - y.astype(float))
    return Row(name, "DIFFERS", *largest(a, difference, size_of(x.astype(float))), "exact")


def unlikeness(a: History, b: History, name: str) -> str:
    """Why a column cannot be compared sample by sample, or nothing."""
    return next((f"missing in {which}" for history, which in ((a, "A"), (b, "B")) if name not in history), "")


def largest(a: History, difference: Array, size: float) -> tuple[float, float | None, float | None]:
    """The largest difference, also over the size of the column, and its time."""
    if not np.any(difference > 0):
        return 0.0, 0.0, None
    where = int(np.argmax(difference))
    return float(difference[where]), float(difference[where]) / size if size > 0 else None, float(a.times[where])
