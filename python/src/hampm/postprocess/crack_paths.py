"""How far the paths of cracks are from each other."""

from __future__ import annotations

import numpy as np

from ..arrays import Array

LEAST = 4000  # places along a path at which its distance is taken, beside its points


def length(points: Array) -> float:
    """Of a polyline (n, 2) [m]."""
    return float(np.sum(np.hypot(*np.diff(points, axis=0).T)))


def apart(one: Array, other: Array) -> float:
    """The largest distance of any place of one of two polylines from the other [m]: exact at their points, and else to an eight-thousandth
    of their length."""
    return max(np.max(distances(along(one), other)), np.max(distances(along(other), one)))


def along(points: Array) -> Array:
    """Places along a polyline, its points among them."""
    way = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    places = np.union1d(way, np.linspace(0, way[-1], LEAST))
    return np.column_stack([np.interp(places, way, points[:, k]) for k in (0, 1)])


def distances(places: Array, line: Array) -> Array:
    """Of places from a polyline [m]."""
    nearest = np.full(len(places), np.inf)
    for start, end in zip(line[:-1], line[1:]):
        part = np.clip((places - start) @ (end - start) / max(np.sum((end - start) ** 2), np.finfo(float).tiny), 0, 1)
        nearest = np.minimum(nearest, np.hypot(*(places - start - part[:, None] * (end - start)).T))
    return nearest
