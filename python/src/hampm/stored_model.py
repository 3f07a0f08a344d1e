"""The model of a run, as its result file holds it."""

import re
from pathlib import Path
from typing import Any

import numpy as np

from .errors import UNREADABLE, ResultError

FAR = 1e9       # cells from the grid at which nothing can be


class StoredModel:
    """The namelist of a run, as the result file holds it: complete, one key a line. It is read without f90nml, and looked at where it is used.

    Where a group repeats, `instance` says which is meant, counted from 1.
    """

    def __init__(self, text: str, path: str | Path):
        self.path = path
        self._groups: dict[str, list[dict[str, str]]] = {}
        for line in text.splitlines():
            if line.startswith("&"):
                self._groups.setdefault(line[1:].strip(), []).append({})
                values = self._groups[line[1:].strip()][-1]
            elif match := re.match(r"\s+(\w+) =(.*)", line):
                values[match[1]] = match[2].strip()

    def count(self, group: str) -> int:
        """How many groups of this name there are."""
        return len(self._groups.get(group, []))

    def text(self, group: str, key: str, instance: int = 1) -> str:
        """A value as text without quotes; '' where it is not given."""
        groups = self._groups.get(group, [])
        return groups[instance - 1].get(key, "").strip("'") if len(groups) >= instance else ""

    def numbers(self, group: str, key: str, instance: int = 1, count: int | None = None) -> list[float]:
        """Values as numbers, so many of them where that is said; none where they are not given."""
        try:
            values = [float(word) for word in self.text(group, key, instance).replace(",", " ").split()]
        except ValueError as error:
            raise ResultError(f"{self.path}: '{key}' in &{group} of the stored namelist is not a number ({error})",
                              UNREADABLE) from error
        if count is not None and not (len(values) == count and np.all(np.abs(values) < FAR**2)):
            raise ResultError(f"{self.path}: '{key}' in &{group} of the stored namelist has to be {count} number{'s' * (count > 1)}")
        return values

    def dimensions(self) -> int:
        """3 for a solid, else 2."""
        return 3 if len(self.numbers("grid", "cells")) == 3 else 2

    def cell(self) -> float:
        """Size of a root cell [m]."""
        size, = self.numbers("grid", "cell", count=1)
        if not size > 0:
            raise ResultError(f"{self.path}: 'cell' in &grid of the stored namelist is {size:g}")
        return size

    def body_groups(self) -> list[int]:
        """Numbers of the groups &body that are no holes."""
        return [n for n in range(1, self.count("body") + 1) if self.text("body", "hole", n) != ".true."]

    def box_of(self, number: int) -> Any:
        """Lower and upper corner of the box around a body, shape (2, 2), of a solid (2, 3)."""
        match self.text("body", "shape", number):
            case "polygon":
                numbers = self.numbers("body", "points", number)
                if len(numbers) < 6 or len(numbers) % 2:
                    raise ResultError(f"{self.path}: 'points' in &body of the stored namelist are no polygon")
                points = np.reshape(numbers, (-1, 2))
                return [points.min(axis=0), points.max(axis=0)]
            case "circle" | "sphere":
                center, radius = np.array(self.numbers("body", "center", number, self.dimensions())), self.numbers("body", "radius", number, 1)[0]
                return [center - radius, center + radius]
            case "cylinder":
                ends, radius = np.array([self.numbers("body", key, number, 3) for key in ("lower", "upper")]), self.numbers("body", "radius", number, 1)[0]
                aside = radius * (np.abs(ends[1] - ends[0]) < 1e-9 * np.abs(ends[1] - ends[0]).max())
                return [ends[0] - aside, ends[1] + aside]
        return [self.numbers("body", key, number, self.dimensions()) for key in ("lower", "upper")]

    def outline(self, number: int) -> Any:
        """The closed line around a body or a hole of a plane [m], shape (n, 2); of a circle a polygon on the side where there is no material."""
        match self.text("body", "shape", number):
            case "polygon":
                self.box_of(number)     # which says what is wrong with its points
                corners = np.reshape(self.numbers("body", "points", number), (-1, 2))
            case "circle":
                turns = 2 * np.pi * np.arange(120) / 120
                radius = self.numbers("body", "radius", number, 1)[0] / (1 if self.text("body", "hole", number) == ".true." else np.cos(np.pi / 120))
                corners = self.numbers("body", "center", number, 2) + radius * np.column_stack([np.cos(turns), np.sin(turns)])
            case _:
                lower, upper = np.array(self.box_of(number))
                corners = lower + (upper - lower) * [[0, 0], [1, 0], [1, 1], [0, 1]]
        return np.concatenate([corners, corners[:1]])

    def bodies(self) -> tuple[Any, Any]:
        """Lower and upper corners of the boxes around the bodies [m], shape (n, 2), of a solid (n, 3)."""
        return tuple(np.array([self.box_of(n) for n in self.body_groups()]).reshape(-1, 2, self.dimensions()).swapaxes(0, 1))

    def is_static(self) -> bool:
        """Whether the run goes from equilibrium to equilibrium, in a time that only tells how large the loads are."""
        return self.text("method", "time") == "static"

    def has_paths(self) -> bool:
        """Whether its cracks are paths."""
        return self.text("crack", "kind") == "path"

    def way_to_edge(self, start: Any, direction: Any) -> float:
        """How far one gets from a place in the direction of an axis through bodies that touch [m]."""
        along, way = int(np.argmax(np.abs(direction))), 0.0
        reach = 1e-6 * self.cell()
        lower, upper = self.bodies()
        ahead = np.all((lower <= start + reach) & (upper >= start - reach) | (np.arange(2) == along), axis=1)
        ends = (np.array([lower, upper])[:, ahead, along] - start[along]) * direction[along]
        for entry, leave in sorted(np.sort(ends, axis=0).T.tolist()):
            if entry <= way + reach:
                way = max(way, leave)
        return way
