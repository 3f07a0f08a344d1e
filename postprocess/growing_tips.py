"""How cracks grow, as the history of a run has it: where each tip is, how fast, under which G and with which toughness."""

import re

import numpy as np

from history import ResultError

PLACE = re.compile(r"tip_x(_tip\d+)?$")
OVER_TIME = ("G", "toughness", "tip_speed", "load_factor", "crack_length")  # what plots of growth show, as far as a file has it


class GrowingTip:
    """A tip whose place the history has.

    number   of the tip, 1, 2, ...
    ending   what the names of its columns end in: nothing for the first, _tip2, ...
    places   where it is in the samples [m], shape (n, 2)
    """

    def __init__(self, history, ending):
        self.history, self.ending = history, ending
        self.number = int(ending.removeprefix("_tip") or 1)
        self.places = np.column_stack([self.column("tip_x"), self.column("tip_y")])
        if not np.all(np.isfinite(self.places)):
            raise ResultError(f"{history.path}: /history/tip_x{ending} and tip_y{ending} hold values that are not finite")

    def has(self, name):
        return name + self.ending in self.history.columns

    def column(self, name):
        """A column of this tip."""
        if not self.has(name):
            raise ResultError(f"{self.history.path}: /history/{name}{self.ending} is missing")
        return self.history.columns[name + self.ending]

    def path(self, until=None):
        """The places that it has been at, each once, in their order, up to a time where that is given [m]."""
        known = self.history.times <= (np.inf if until is None else until * (1 + 1e-9))
        known[0] = True
        places = self.places[known]
        moves = np.any(np.diff(places, axis=0) != 0, axis=1)
        return places[np.concatenate([[True], moves])]

    def way(self):
        """Length of its path [m]."""
        return float(np.hypot(*np.diff(self.places, axis=0).T).sum())

    def starts(self):
        """Time of the last sample before it moves; None where it stays [s]."""
        moved = np.flatnonzero(np.any(np.diff(self.places, axis=0) != 0, axis=1))
        return self.history.times[moved[0]] if moved.size else None


def growing_tips(history):
    """The tips whose places a history has; none without `&growth`."""
    return [GrowingTip(history, match[1] or "") for match in map(PLACE.match, history.columns) if match]


def columns_over_time(history):
    """Names of the columns of all tips that plots of growth show; the load factor is one of all."""
    endings = [tip.ending for tip in growing_tips(history)]
    names = [name + ending for name in OVER_TIME for ending in endings]
    found = [name for name in names if name in history.columns]
    if not found:
        raise ResultError(f"{history.path}: no crack grows in this run (set `&growth`)")
    return found
