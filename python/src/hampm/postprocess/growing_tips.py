"""How cracks grow, as the history of a run has it: where each tip is, how fast, under which G and with which toughness."""

from __future__ import annotations

import re

import numpy as np

from ..arrays import Array
from ..errors import ResultError
from ..former_names import column
from ..history import History
from ..stored import opened

PLACE = re.compile(r"tip_x(_tip\d+)?$")
MEAN_SPEED = "mean_tip_speed"
OVER_TIME = ("G", "toughness", MEAN_SPEED, "load_factor", "crack_length")  # what plots of growth show, as far as a file has it


class GrowingTip:
    """A tip whose place the history has.

    number   of the tip, 1, 2, ...
    ending   what the names of its columns end in: nothing for the first, _tip2, ...
    places   where it is in the samples [m], shape (n, 2)
    """

    def __init__(self, history: History, ending: str) -> None:
        self.history, self.ending = history, ending
        self.number = int(ending.removeprefix("_tip") or 1)
        self.places = np.column_stack([self.column("tip_x"), self.column("tip_y")])
        if not np.all(np.isfinite(self.places)):
            raise ResultError(f"{history.path}: /history/tip_x{ending} and tip_y{ending} hold values that are not finite")

    def has(self, name: str) -> bool:
        return name + self.ending in self.history.columns

    def column(self, name: str) -> Array:
        """A column of this tip."""
        if not self.has(name):
            raise ResultError(f"{self.history.path}: /history/{name}{self.ending} is missing")
        return self.history.columns[name + self.ending]

    def path(self, until: float | None = None) -> Array:
        """The places that it has been at, each once, in their order, up to a time where that is given [m]."""
        known = self.history.times <= (np.inf if until is None else until * (1 + 1e-9))
        known[0] = True
        places = self.places[known]
        moves = np.any(np.diff(places, axis=0) != 0, axis=1)
        return places[np.concatenate([[True], moves])]

    def way(self) -> float:
        """Length of its path [m]."""
        return float(np.hypot(*np.diff(self.places, axis=0).T).sum())

    def starts(self) -> float | None:
        """When it begins to move, to a step; in results that do not tell it the time of the last sample before. None where it stays [s]."""
        moved = np.flatnonzero(np.any(np.diff(self.places, axis=0) != 0, axis=1))
        return self._told("onset_time") or (self.history.times[moved[0]] if moved.size else None)

    def rests(self) -> float | None:
        """When it has come to rest; None where it has not, or where that is not told [s]."""
        return self._told("arrest_time")

    def _told(self, name: str) -> float | None:
        """An attribute of its speed; None where there is none."""
        if not self.has("tip_speed"):
            return None
        with opened(self.history.path) as stored:
            names = {column(old): old for old in stored.names("history")}
            return stored.attributes(f"history/{names['tip_speed' + self.ending]}", numbers=("onset_time", "arrest_time")).get(name)

    def mean_speed(self) -> Array:
        """Its speed in the samples as the mean over the way of a cell, 0 before it begins to move and after it has moved last [m/s]."""
        way = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(self.places, axis=0).T))])
        return mean_speed(self.history.times, way, self.column("tip_cell")[0])


def growing_tips(history: History) -> list[GrowingTip]:
    """The tips whose places a history has; none without `&growth`."""
    return [GrowingTip(history, match[1] or "") for match in map(PLACE.match, history.columns) if match]


def mean_speed(times: Array, way: Array, length: float) -> Array:
    """The speed along a way as mean over so much of it around each place, less at its ends; 0 where nothing moves before or after [m/s]."""
    speed, moved = np.zeros(len(way)), np.flatnonzero(np.diff(way) > 0)
    if not moved.size:
        return speed
    first, last = moved[0], moved[-1] + 2
    arrived = np.unique(np.concatenate([[first], moved + 1]))
    ends = np.clip([way[first:last] - length / 2, way[first:last] + length / 2], way[first], way[last - 1])
    start, end = np.interp(ends, way[arrived], times[arrived])
    speed[first:last] = (ends[1] - ends[0]) / np.maximum(end - start, np.finfo(float).tiny)
    return speed


def add_derived(history: History) -> None:
    """Give a history of tips that grow columns for each: the way since the first row, and the mean over a cell of the speed."""
    for name in [name for name in history.columns if name.startswith("crack_length") and not name.startswith("crack_length_error")]:
        added = name.replace("crack_length", "extension")
        history.columns[added], history.units[added] = history.columns[name] - history.columns[name][0], history.units[name]
        history.long_names[added] = "extension of the crack"
    for tip in growing_tips(history):
        name = MEAN_SPEED + tip.ending
        if tip.has("tip_speed") and tip.has("tip_cell") and name not in history.columns:
            history.columns[name], history.units[name] = tip.mean_speed(), history.units["tip_speed" + tip.ending]
            history.long_names[name] = "speed at which the tip grows, mean over a cell"


def columns_over_time(history: History) -> list[str]:
    """Names of the columns of all tips that plots of growth show; the load factor is one of all."""
    endings = [tip.ending for tip in growing_tips(history)]
    names = [name + ending for name in OVER_TIME for ending in endings]
    found = [name for name in names if name in history.columns]
    if not found:
        raise ResultError(f"{history.path}: no crack grows in this run (set `&growth`)")
    return found
