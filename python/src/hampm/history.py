"""The history of a run, G(t) and the rest, as its result file holds it."""

import math
import re
from copy import copy
from fnmatch import fnmatchcase
from pathlib import Path

import numpy as np

from .former_names import ATTRIBUTES, column
from .stored import UNREADABLE, ResultError, opened, printable

ERROR = "_error"          # what the name of a column ends in, but for its tip, that holds the estimated error of another one
OF_TIP = re.compile(r"(_tip\d+)?$")
STATIC = re.compile(r"^\s*time = 'static'", re.MULTILINE)
REST = 0.01               # distance from rest above which last values are not taken for those at rest


def matches(name, pattern):
    """Whether a pattern (`*` and `?` as in a shell) means a column. Estimated errors are meant by `*` alone, and by patterns that
    end in _error, or in _error and a tip, so that G_* is all estimators."""
    return fnmatchcase(name, pattern) and (pattern == "*" or is_error(pattern) or not is_error(name))


def error_name(name):
    """The name that the column of the estimated error of a column has."""
    tip = OF_TIP.search(name)[0]
    return name.removesuffix(tip) + ERROR + tip


def is_rate(name):
    """Whether a column is an energy release rate, which G_ref scales."""
    return name.split("_")[0] in ("G", "J")


def is_error(name):
    """Whether the name is that of a column that holds the estimated error of another one."""
    return OF_TIP.sub("", name).endswith(ERROR)


class History:
    """Columns, units and attributes of `/history` of one result file.

    columns     name -> samples, as stored
    units       name -> unit, '1' where none is given
    long_names  name -> description
    is_static   whether its times only tell how large the loads are
    attributes  name -> value, of the group itself

    Columns and attributes of version 1 have the names that they have now.
    """

    def __init__(self, path, may_be_empty=False):
        self.path = Path(path)
        with opened(self.path) as stored:
            self._read(stored)
        if self.times.size == 0 and not may_be_empty:
            raise ResultError(f"{path}: /history holds no samples yet")

    def _read(self, stored):
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

    def with_columns(self, columns):
        """The same history with other columns."""
        other = copy(self)
        other.columns = columns
        return other

    @property
    def times(self):
        """Times of the samples [s]."""
        return self.columns["time"]

    @property
    def stem(self):
        """File name without folder and suffix, for people."""
        return printable(self.path.stem)

    def select(self, patterns):
        """Names of the columns that match any of the patterns, in the order asked for."""
        chosen = {}
        for pattern in patterns:
            matching = [name for name in self.columns if matches(name, pattern)]
            if not matching:
                raise ResultError(f"{self.path}: no column '{pattern}' in /history; "
                                  f"it has {', '.join(self.columns)}")
            chosen.update(dict.fromkeys(matching))
        return list(chosen)

    def g_ref(self):
        """Reference energy release rate [J/m2] by which G is divided."""
        value = self.attributes.get("G_ref")
        if value is None:
            raise ResultError(f"{self.path}: /history has no attribute G_ref, so G/G_ref is not known "
                              "(set `reference` in &energy_release)")
        if not (np.isfinite(value) and value > 0):
            raise ResultError(f"{self.path}: attribute G_ref of /history is {value}, not a positive number")
        return value

    def g_scale(self):
        """What energy release rates are divided by: G_ref where there is one."""
        return self.g_ref() if "G_ref" in self.attributes else 1.0

    def g_ratio(self, name):
        """Column `name` divided by G_ref."""
        return self.columns[name] / self.g_ref()

    def late_mean(self, name, part=0.1):
        """Mean of a column over the last part of the run, so that what still rings counts little."""
        return np.mean(self.columns[name][self.times >= (1 - part) * self.times[-1]])

    def error_of(self, name):
        """Name of the column that holds the estimated error of another; None where there is none."""
        return error_name(name) if error_name(name) in self.columns else None

    def distance_to_equilibrium(self):
        """How far the last values are from those at rest, relative; None where it is not known or has no meaning."""
        value = self.attributes.get("distance_to_equilibrium", math.nan)
        return None if math.isnan(value) else value

    def is_moving(self):
        """Whether the last values are known not to be those at rest."""
        return (self.distance_to_equilibrium() or 0.0) > REST

    def motion(self):
        """What there is to say of a run that is moving."""
        return (f"not at rest: the last values differ from those at rest by {self.distance_to_equilibrium():.2g} (relative), "
                f"above the limit of {REST:g}")

    def beam_ratio(self):
        """The beam on an elastic foundation, eq. (33), divided by G_ref; None where it is not known."""
        value = self.attributes.get("G_beam_on_foundation")
        return None if value is None else value / self.g_ref()
