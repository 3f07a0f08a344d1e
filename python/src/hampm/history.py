"""The history of a run, G(t) and the rest, as its result file holds it."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Mapping
from copy import copy
from difflib import get_close_matches
from fnmatch import fnmatchcase
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .former_names import ATTRIBUTES, column
from .arrays import Array
from .errors import UNREADABLE, ColumnError, ResultError, printable
from .stored import Stored, opened
from .tables import Table

if TYPE_CHECKING:
    import pandas
    import xarray
    from matplotlib.figure import Figure

ERROR = "_error"          # what the name of a column ends in, but for its tip, that holds the estimated error of another one
OF_TIP = re.compile(r"(_(?:tip|front)\d+)?$")
OF_DOMAIN = re.compile(r"J_\d+(_tip\d+)?$")   # J of one domain
STATIC = re.compile(r"^\s*time = 'static'", re.MULTILINE)
REST = 0.01               # distance from rest above which last values are not taken for those at rest


def matches(name: str, pattern: str) -> bool:
    """Whether a pattern (`*` and `?` as in a shell) means a column. Estimated errors are meant by `*` alone, and by patterns that
    end in _error, or in _error and a tip, so that G_* is all estimators."""
    return fnmatchcase(name, pattern) and (pattern == "*" or is_error(pattern) or not is_error(name))


def error_name(name: str) -> str:
    """The name that the column of the estimated error of a column has."""
    base = OF_TIP.sub("", name)
    return base + ERROR + name.removeprefix(base)


def is_rate(name: str) -> bool:
    """Whether a column is an energy release rate, which G_ref scales."""
    return name.split("_")[0] in ("G", "J")


def is_error(name: str) -> bool:
    """Whether the name is that of a column that holds the estimated error of another one."""
    return OF_TIP.sub("", name).endswith(ERROR)


class History(Mapping[str, Array]):
    """Columns, units and attributes of `/history` of one result file: a mapping of names to samples, `history["K_I"]`, which are attributes,
    too, `history.K_I`. A column that is not there is a `KeyError`, as a `ResultError`.

    columns     name -> samples, as stored
    units       name -> unit, '1' where none is given
    long_names  name -> description
    is_static   whether its times only tell how large the loads are
    attributes  name -> value, of the group itself
    version     of the program that has written it, and its commit; '' where it is not told

    Columns and attributes of version 1 have the names that they have now.
    """

    def __init__(self, path: str | Path, may_be_empty: bool = False):
        self.path = Path(path)
        with opened(self.path) as stored:
            self._read(stored)
            about = stored.attributes("/")
            self.version = printable(" ".join(filter(None, (str(about.get(name, "")) for name in ("program", "version")))) + (f" ({about['commit']})" if about.get("commit") else ""))
        if self.times.size == 0 and not may_be_empty:
            raise ResultError(f"{path}: /history holds no samples yet")

    def _read(self, stored: Stored) -> None:
        if not stored.has_group("history"):
            raise ResultError(f"{self.path}: has no group /history: not a result file", UNREADABLE)
        if not stored.has("history/time"):
            raise ResultError(f"{self.path}: has no dataset /history/time", UNREADABLE)
        names = {column(name): name for name in stored.names("history")}
        self.is_static = stored.has("input/namelist") and bool(STATIC.search(stored.text("input/namelist")))
        self.columns = {name: stored.numbers(f"history/{old}", finite=name == "time") for name, old in names.items()}
        described = {name: stored.attributes(f"history/{old}", texts=("units", "long_name")) for name, old in names.items()}
        self.units = {name: printable(found.get("units", "1")) for name, found in described.items()}
        self.long_names = {name: printable(found.get("long_name", name)) for name, found in described.items()}
        self.attributes = stored.attributes("history", texts=("ended", "warnings"),
                                            numbers=("G_ref", "G_beam_on_foundation", *ATTRIBUTES, *ATTRIBUTES.values()))
        self.attributes = {column(name): value for name, value in self.attributes.items()}
        for name, values in self.columns.items():
            if values.size != self.times.size:
                raise stored.wrong(f"history/{name}", f"has {values.size} samples, and /history/time has {self.times.size}")
        if np.any(np.diff(self.times) < 0):
            raise stored.wrong("history/time", "goes back in time")

    def with_columns(self, columns: dict[str, Array]) -> History:
        """The same history with other columns."""
        other = copy(self)
        other.columns = columns
        return other

    @property
    def times(self) -> Array:
        """Times of the samples [s]."""
        return self.columns["time"]

    @property
    def stem(self) -> str:
        """File name without folder and suffix, for people."""
        return printable(self.path.stem)

    def select(self, patterns: Iterable[str]) -> list[str]:
        """Names of the columns that match any of the patterns, in the order asked for."""
        chosen = {}
        for pattern in patterns:
            matching = [name for name in self.columns if matches(name, pattern)]
            if not matching:
                raise ColumnError(f"{self.path}: no column '{pattern}' in /history; it has {', '.join(self.columns)}")
            chosen.update(dict.fromkeys(matching))
        return list(chosen)

    def g_ref(self) -> float:
        """Reference energy release rate [J/m2] by which G is divided."""
        value = self.attributes.get("G_ref")
        if value is None:
            raise ResultError(f"{self.path}: /history has no attribute G_ref, so G/G_ref is not known "
                              "(set `reference` in &energy_release)")
        if not (np.isfinite(value) and value > 0):
            raise ResultError(f"{self.path}: attribute G_ref of /history is {value}, not a positive number")
        return value

    def g_scale(self) -> float:
        """What energy release rates are divided by: G_ref where there is one."""
        return self.g_ref() if "G_ref" in self.attributes else 1.0

    def g_ratio(self, name: str) -> Array:
        """Column `name` divided by G_ref."""
        return self.columns[name] / self.g_ref()

    def late_mean(self, name: str, part: float = 0.1) -> float:
        """Mean of a column over the last part of the run, above 0 and up to 1, so that what still rings counts little."""
        if not 0 < part <= 1:
            raise ResultError(f"part = {part}: a part of the run is above 0 and at most 1")
        if self.times.size == 0:
            raise ResultError(f"{self.path}: /history holds no samples yet")
        name = name if name in self.columns else self.select([name])[0]
        return np.mean(self.columns[name][self.times >= (1 - part) * self.times[-1]])

    def error_of(self, name: str) -> str | None:
        """Name of the column that holds the estimated error of another; None where there is none."""
        return error_name(name) if error_name(name) in self.columns else None

    def warnings(self) -> list[str]:
        """What the run has warned of."""
        return [text for text in str(self.attributes.get("warnings", "")).splitlines() if text]

    def distance_to_equilibrium(self) -> float | None:
        """How far the last values are from those at rest, relative; None where it is not known or has no meaning."""
        value = self.attributes.get("distance_to_equilibrium", math.nan)
        return None if math.isnan(value) else value

    def is_moving(self) -> bool:
        """Whether the last values are known not to be those at rest."""
        return (self.distance_to_equilibrium() or 0.0) > REST

    def motion(self) -> str:
        """What there is to say of a run that is moving."""
        return (f"not at rest: the last displacements differ from static ones by {self.distance_to_equilibrium():.2g} (relative, in the energy norm; energy release rates by about twice that), "
                f"above the limit of {REST:g}")

    def beam_ratio(self) -> float | None:
        """The beam on an elastic foundation, eq. (33), divided by G_ref; None where it is not known."""
        value = self.attributes.get("G_beam_on_foundation")
        return None if value is None else value / self.g_ref()

    def to_pandas(self) -> "pandas.DataFrame":
        """The columns as a `pandas.DataFrame` over the time [s]; `attrs["units"]` has the unit of each, `attrs["long_names"]` what it is, and the
        other attributes are those of the history. A column that ends in _error holds the estimated error of the one named before it."""
        import pandas
        frame = pandas.DataFrame({name: values for name, values in self.columns.items() if name != "time"},
                                 index=pandas.Index(self.times, name="time"))
        frame.attrs = {**self.attributes, "units": dict(self.units), "long_names": dict(self.long_names)}
        return frame

    def to_xarray(self) -> "xarray.Dataset":
        """The columns as an `xarray.Dataset` with the coordinate `time` [s], each with its `units` and `long_name`; `ancillary_variables` of a column
        names the variable of its estimated error, as the conventions of CF do."""
        import xarray
        about = {name: {"units": self.units[name], "long_name": self.long_names[name]} | ({"ancillary_variables": error} if error else {})
                 for name, error in ((name, self.error_of(name)) for name in self.columns)}
        return xarray.Dataset({name: ("time", values, about[name]) for name, values in self.columns.items() if name != "time"},
                              coords={"time": ("time", self.times, about["time"])}, attrs=dict(self.attributes))

    def front(self, number: int = 1, arc: Array | Iterable[float] | None = None) -> "xarray.Dataset":
        """Values along the front of a crack in a solid at all times: G, K and the rest over `time` and `point`, with the way along the front, `arc` [m], and
        places as coordinates; or over `time` and the ways that are given, linear between points."""
        import xarray
        ending = "" if number == 1 else f"_front{number}"
        with opened(self.path) as stored:
            names = {name.removesuffix(ending): name for name in stored.names("front") if name.endswith(ending) and "_front" not in name.removesuffix(ending)}
            if "arc" not in names:
                raise ResultError(f"{self.path}: has no values along a front {number}")
            values = {name: stored.numbers(f"front/{own}", dims=2) for name, own in names.items()}
            about = {name: stored.attributes(f"front/{own}", texts=("units", "long_name")) for name, own in names.items()}
        places = [name for name in ("arc", "x", "y", "z") if name in values]
        dims = "time", "point"
        if arc is not None:
            at = np.asarray(list(arc), dtype=float)
            values = {name: np.array([_between(at, ways, row) for ways, row in zip(values["arc"], rows)]) for name, rows in values.items()} | {"arc": at}
            dims = "time", "arc"
        for name in values:
            about[name] = {key: about[name][key] for key in ("units", "long_name") if key in about[name]} | \
                ({"ancillary_variables": f"{name}_error"} if f"{name}_error" in values else {})
        data: dict[str, Any] = {name: (dims if array.ndim == 2 else "arc", array, about[name]) for name, array in values.items()}
        return xarray.Dataset({name: item for name, item in data.items() if name not in places},
                              coords={"time": ("time", self.times, {"units": "s"})} | {name: data[name] for name in places}, attrs={"front": number})

    def plot(self, *columns: str, **options: Any) -> "Figure":
        """A figure of columns over the time, * and ? allowed, each unit below the other; of G where none is named. Options are those of
        `hampm plot g`, such as errors=True, x="crack_length", style="paper", size="84mm"."""
        from .plots import plot
        return plot("g", self, **{"column": columns} | options)

    def __getitem__(self, name: str) -> Array:
        """Samples of a column."""
        return self.columns[self.select([name])[0]]

    def __contains__(self, name: object) -> bool:
        return name in self.columns

    def __iter__(self) -> Iterator[str]:
        return iter(self.columns)

    def __len__(self) -> int:
        return len(self.columns)

    __eq__ = object.__eq__       # the same history, not one of equal arrays
    __hash__ = object.__hash__

    def __getattr__(self, name: str) -> Array:
        if name.startswith("_") or name == "columns":
            raise AttributeError(name)
        if name not in self.columns:
            close = get_close_matches(name, self.columns, 1)
            raise AttributeError(f"{self.path}: no column '{name}' in /history" + (f"; did you mean '{close[0]}'?" if close else ""))
        return self.columns[name]

    def __dir__(self) -> list[str]:
        return [*self.columns, *object.__dir__(self)]

    def _ipython_key_completions_(self) -> list[str]:
        return list(self.columns)

    def value(self, name: str, part: float = 0.1) -> tuple[float, float | None]:
        """(mean, estimated error) of a column over the last part of the run, in its unit; the error is None where there is none."""
        error = self.error_of(name)
        return float(self.late_mean(name, part)), float(self.late_mean(error, part)) if error else None

    def table(self, part: float = 0.1) -> Table[list[str]]:
        """K, G and J with their estimated errors, as means over the last part of the run."""
        rows = []
        for name in self.columns:
            if not (is_rate(name) or name.startswith("K_")) or is_error(name) or OF_DOMAIN.match(name):
                continue
            mean, error = self.value(name, part)
            rows.append([name, f"{mean:.5g}", "" if error is None or math.isnan(error) else f"{error:.2g}", self.units[name], self.long_names[name]])
        return Table(("column", "value", "estimated error", "unit", "what it is"), rows)

    def __repr__(self) -> str:
        title = self.attributes.get("title", "")
        span = f"{self.times.size} samples, {self.times[0]:.4g} to {self.times[-1]:.4g} s" if self.times.size else "no samples"
        return f"{printable(self.path)}: {title + ', ' if title else ''}{span}\n{self.table() if self.times.size else ''}".rstrip()

    def _repr_html_(self) -> str:
        head = escape(repr(self).partition("\n")[0])
        motion = f"<p>{escape(self.motion())}</p>" if self.is_moving() else ""
        return f"<p>{head}</p>{self.table()._repr_html_()}{motion}{small_picture(self)}" if self.times.size else f"<p>{head}</p>"


def _between(at: Array, ways: Array, values: Array) -> Array:
    """Values at ways along a front, linear between its points; not a number beyond its ends."""
    known = np.isfinite(ways) & np.isfinite(values)
    return np.interp(at, ways[known], values[known], left=np.nan, right=np.nan) if known.any() else np.full(at.shape, np.nan)


def small_picture(history: History) -> str:
    """G over the time, or its K, as an SVG of a few lines; nothing of a single sample."""
    name = next((name for name in ("G", *history.columns) if name in history.columns and (is_rate(name) or name.startswith("K_"))), None)
    if name is None or history.times.size < 3:
        return ""
    t, y = history.times, history.columns[name].astype(float)
    keep = np.isfinite(y)
    t, y = t[keep][:: max(1, keep.sum() // 400)], y[keep][:: max(1, keep.sum() // 400)]
    if t.size < 2 or t[-1] <= t[0]:
        return ""
    width, height, low, high = 360, 120, min(0.0, float(y.min())), max(float(y.max()), 0.0)
    points = " ".join(f"{width * (a - t[0]) / (t[-1] - t[0]):.1f},{height * (high - b) / ((high - low) or 1):.1f}" for a, b in zip(t, y))
    return (f'<svg width="{width}" height="{height + 20}" viewBox="-2 -2 {width + 4} {height + 22}" style="font: 11px sans-serif">'
            f'<polyline points="{points}" fill="none" stroke="#0072b2"/><line x1="0" x2="{width}" y1="{height * high / ((high - low) or 1):.1f}" '
            f'y2="{height * high / ((high - low) or 1):.1f}" stroke="#999" stroke-width="0.5"/>'
            f'<text x="0" y="{height + 14}">{escape(name)} [{escape(history.units[name])}], 0 to {high:.3g}, over {t[-1]:.3g} s</text></svg>')
