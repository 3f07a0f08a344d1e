"""Fields of particles as smooth ones, for pictures of planes.

Around each particle a linear function is fitted to the field by least squares, over the neighbours in the reference configuration that
are of its body and on its side of all cracks and edges. Between particles these functions are blended by distance. So linear fields are
exact up to the edges, and a field is torn at cracks and between bodies alone.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.tri import Triangulation

from ..arrays import Array
from .crack_faces import is_between

FAR = 2.5       # shares of a cell, of the larger of two particles, beyond which they are no neighbours
SHARP = 0.5     # square of the distance, in shares of a cell, at which the weight of a neighbour has fallen to 1/e
LEAST = 1e-9    # of the moments of neighbours: no gradient is found across those that stand in a line
AT_ONCE = 20000


class Smooth:
    """Fields of some particles between them: places (n, 2), sizes of their shares of cells (n), values (n, c), and their `pairs`."""

    def __init__(self, places: Array, width: Array, values: Array, pairs: Array) -> None:
        one, other = pairs
        self._places, self._width = places, width
        offset = (places[other] - places[one]) / width[one, None]
        basis = np.column_stack([np.ones(len(one)), offset])
        weight = 1 / (1 + np.sum(offset**2, axis=1))

        def summed(terms: Array) -> Array:
            return np.bincount(one, weight * terms, minlength=len(places))
        values = values.astype(float)
        moments = np.array([[summed(a * b) for b in basis.T] for a in basis.T]).transpose(2, 0, 1)
        moments += LEAST * np.diag([0, 1, 1])
        right = np.array([[summed(a * field[other]) for field in values.T] for a in basis.T]).transpose(2, 0, 1)
        self._fit = np.linalg.solve(moments, right)
        self._low, self._high = values.copy(), values.copy()
        np.minimum.at(self._low, one, values[other])
        np.maximum.at(self._high, one, values[other])
        order = np.argsort(one, kind="stable")
        count = np.bincount(one, minlength=len(places))
        self._around = np.full((len(places), count.max(initial=1)), -1)
        self._around[one[order], np.arange(len(one)) - np.repeat(np.cumsum(count) - count, count)] = other[order]

    def at(self, points: Array, owners: Array) -> tuple[Array, Array]:
        """Values at points around particles, (m, k, 2) around m of them, as these see them, and the same within those of the neighbours;
        each of shape (m, k, c)."""
        parts = [self._at(points[k:k + AT_ONCE], owners[k:k + AT_ONCE]) for k in range(0, len(owners), AT_ONCE)]
        found = np.concatenate(parts) if parts else np.zeros((*points.shape[:2], self._low.shape[1]))
        return found, np.clip(found, self._low[owners, None], self._high[owners, None])

    def _at(self, points: Array, owners: Array) -> Array:
        around = self._around[owners]
        offset = (points[:, :, None] - self._places[around][:, None]) / self._width[around][:, None, :, None]
        weight = np.exp(-np.sum(offset**2, axis=3) / SHARP) * (around >= 0)[:, None]
        weight /= np.sum(weight, axis=2, keepdims=True)
        terms = np.concatenate([weight[..., None], weight[..., None] * offset], axis=3)
        return np.einsum("mkdb,mdbc->mkc", terms, self._fit[around])


def pairs_of(places: Array, width: Array, body: Array, segments: Array, divided: Array) -> Array:
    """Particles and their neighbours, themselves among them, each pair in both orders: of one body, near, and not on two sides of a
    segment, which is looked for where one is `divided`. Shape (2, p)."""
    own = np.arange(len(places))
    one, other = beside_each_other(places)
    near = np.linalg.norm(places[one] - places[other], axis=1) < FAR * np.maximum(width[one], width[other])
    near &= body[one] == body[other]
    one, other = one[near], other[near]
    asked = divided[one] | divided[other]       # the smaller of two may be too far
    kept = ~asked
    kept[asked] = ~is_between(places[one[asked]], places[other[asked]], segments)
    one, other = one[kept], other[kept]
    return np.array([[*own, *one, *other], [*own, *other, *one]])


def beside_each_other(places: Array) -> Any:
    """Those that share a side of a triangle, or are at the ends of two that share one: all eight around one of a square lattice."""
    try:
        mesh = Triangulation(*(places - places.mean(axis=0)).T)
    except (RuntimeError, ValueError):      # fewer than three, or in a line
        order = np.lexsort(places.T)
        return order[:-1], order[1:]
    triangle, side = np.nonzero(mesh.neighbors > np.arange(len(mesh.triangles))[:, None])
    beyond = mesh.triangles[mesh.neighbors[triangle, side]]
    ends = mesh.triangles[triangle][np.arange(len(side))[:, None], np.column_stack([side, (side + 1) % 3])]
    opposite = np.where(np.any(beyond[:, :, None] == ends[:, None], axis=2), 0, beyond).sum(axis=1)
    across = np.sort([mesh.triangles[triangle, (side + 2) % 3], opposite], axis=0)
    return np.unique(np.concatenate([np.sort(mesh.edges.T, axis=0), across], axis=1), axis=1)
