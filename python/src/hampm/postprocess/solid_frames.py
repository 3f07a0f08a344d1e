"""Snapshots of solids: the cubes of their material and of their cells, the sides of these that nothing covers, and what a plane cuts.

Each particle is the cube of which it is the middle where the material is undeformed. Corners of cubes move with the mean of what the
particles around them say, on their side of a crack, each by its displacement and its deformation gradient; so surfaces are closed, and cracks open.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.path import Path as Outline

from ..arrays import Array
from ..errors import ResultError
from ..snapshots import Block
from ..stored_model import StoredModel
from .frames import Frames, Leaves
from .plot_front import front_of

CORNERS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0], [0, 0, 1], [1, 0, 1], [0, 1, 1], [1, 1, 1]])
AROUND = np.array([[0, 0], [1, 0], [1, 1], [0, 1]])     # corners of a side, by the two axes along it
OFF = 0.05      # of half the width of a cube: how far a particle may be from the middle of one
PIECES = 32     # of the edge of a constraint
AROUND_FRONT = 128   # pieces of the edge of a crack
KEPT = 4        # snapshots whose cubes are remembered


class SolidFrames(Frames):
    """The snapshots of one result of the program for solids."""

    is_for_solids = True

    def __init__(self, path: str | Path) -> None:
        super().__init__(path)
        self.cubes = lru_cache(KEPT)(self._cubes)

    def crack_plane(self, tip: int = 1, number: int = 0) -> None:
        """None: what a crack has in a solid is a front."""
        return None

    def fronts(self, number: int, ligament: str | None = None) -> list[Array]:
        """The fronts of cracks at the time of a snapshot, nodes (n, 3) [m] of each: those that are measured, or the edge of a constraint."""
        if ligament:
            front = front_of(self.scene, ligament)
            return [front.origin + np.outer(np.linspace(0, front.length, PIECES + 1), np.eye(3)[front.axes[2]])]
        return self._measured_fronts(number) or [line for crack in cracks_of(self.scene) for line in crack.fronts(*self.scene.bodies())]

    def _measured_fronts(self, number: int) -> list[Array]:
        """Nodes of the fronts at which these were measured in a snapshot."""
        if "fronts" not in self.blocks:
            return []
        block = self.block("fronts", number)
        of = block.point_fields["front"]
        parts = [np.flatnonzero(of == front) for front in np.unique(of)]
        is_closed = [np.count_nonzero(of[block.cells[:, 0]] == of[part[0]]) == len(part) for part in parts]
        return [block.points[[*part, *part[:1]] if closed else part] for part, closed in zip(parts, is_closed)]

    def _cubes(self, number: int) -> Cubes:
        """The cubes of the particles of a snapshot."""
        return cubes_of_particles(self, self.block("particles", number), self.leaves(number))

    def cells(self, number: int) -> tuple[Cubes, Leaves, Array]:
        """The cubes of the cells that hold material, with the numbers of these among `leaves`."""
        leaves = self.leaves(number)
        holds = np.flatnonzero(leaves.particles > 0)
        size = 2 ** (leaves.level.max() - leaves.level[holds])
        unit = self.scene.cell() * 0.5 ** leaves.level.max()
        lower = np.array(self.scene.numbers("grid", "lower", count=3))
        return Cubes(np.rint((leaves.lower[holds] - lower) / unit).astype(int), size, lower, unit), leaves, holds


class Crack:
    """A crack in a plane of the grid, by the stored namelist.

    axis, at    normal of the plane, and where it is on that [m]
    is_inside   whether it is inside a body, with two faces, and not on a plane of symmetry
    outline     corners of what is cracked in the plane, by the other axes in cyclic order [m] (n, 2); a half plane is cracked far from the bodies too
    """

    def __init__(self, scene: StoredModel, number: int) -> None:
        def numbers(key: str, count: int | None = None) -> Array:
            return np.array(scene.numbers("crack", key, number, count))
        self.is_inside = scene.text("crack", "kind", number) == "plane"
        self.axis = max(0, "xyz".find(scene.text("crack", "normal", number) or "z"))
        self.along = [(self.axis + 1) % 3, (self.axis + 2) % 3]
        shape = scene.text("crack", "front", number)
        self.is_curve = shape in ("disc", "ellipse")
        if shape == "polygon":
            points = numbers("points").reshape(-1, 3)
            self.at, self.outline = points[0, self.axis], points[:, self.along]
            return
        middle = numbers("center" if self.is_curve else "tip", 3)
        self.at, middle = middle[self.axis], middle[self.along]
        if self.is_curve:
            angle = 2 * np.pi * np.arange(AROUND_FRONT) / AROUND_FRONT
            self.outline = middle + numbers("radii") * np.column_stack([np.cos(angle), np.sin(angle)])
            return
        ahead = numbers("direction", 3)[self.along]
        ahead = ahead / np.linalg.norm(ahead)
        lower, upper = scene.bodies()
        reach = 4 * np.linalg.norm(upper.max(axis=0) - lower.min(axis=0))
        aside = reach * np.array([-ahead[1], ahead[0]])
        self.outline = np.array([middle - aside, middle + aside, middle + aside - reach * ahead, middle - aside - reach * ahead])

    def holds(self, places: Array) -> Array:
        """Whether the material at places in the plane (n, 3) is cracked; at the edge it is not."""
        return Outline(self.outline).contains_points(places[:, self.along], radius=0)

    def fronts(self, lower: Array, upper: Array) -> list[Array]:
        """The parts of its edge that are inside of bodies with these corners, nodes (n, 3) of each [m]."""
        corners = np.concatenate([self.outline, self.outline[:1]])
        pieces = 1 if self.is_curve else 8 * AROUND_FRONT
        nodes = np.concatenate([np.linspace(start, end, pieces, endpoint=False) for start, end in zip(corners, corners[1:])] + [corners[-1:]])
        near = 1e-9 * (upper.max(axis=0) - lower.min(axis=0))
        nodes = np.insert(nodes, 0, self.at, axis=1)[:, np.argsort([self.axis, *self.along])]
        middle = (nodes[1:] + nodes[:-1]) / 2
        strict = np.eye(3)[self.axis] == 0     # on an edge of a body that is in the plane of the crack there is no front
        inside = np.any([np.all((middle > low + near * np.where(strict, 1, -1)) & (middle < high - near * np.where(strict, 1, -1)), axis=1)
                         for low, high in zip(lower, upper)], axis=0)
        if inside.all():
            return [nodes]
        ends = np.flatnonzero(np.diff(np.concatenate([[False], inside, [False]]).astype(int)))
        return [nodes[first:last + 1] for first, last in ends.reshape(-1, 2)]


def cracks_of(scene: StoredModel) -> list[Crack]:
    """The cracks of a solid."""
    return [Crack(scene, number) for number in range(1, scene.count("crack") + 1)]


class Cubes:
    """Cubes on one lattice, each some powers of two as wide as its cells.

    corner, size    lower corner (n, 3) and width (n) in cells of the lattice
    origin, unit    where the lattice begins, and the size of its cells [m]
    part            number of what each belongs to (n): cubes of other parts cover nothing, and share no corners
    cracks          those inside of the material, across which cubes do not cover each other
    """

    def __init__(self, corner: Array, size: Array, origin: Array, unit: float, part: Any = None, cracks: Sequence[Crack] = ()) -> None:
        self.cracks = cracks
        self.corner, self.size, self.origin, self.unit = corner, size, origin, unit
        self.part = np.zeros(len(size), dtype=int) if part is None else part
        self._shape = (self.part.max(initial=0) + 1, *(corner.max(axis=0) + size.max() + 2))
        self._known = {int(width): np.unique(self._keys(corner[size == width], self.part[size == width])) for width in np.unique(size)}

    def _keys(self, places: Array, part: Any) -> Array:
        """Numbers of places of the lattice, which are told apart by what they belong to; -1 outside of it."""
        inside = np.all((places >= 0) & (places < self._shape[1:]), axis=-1)
        found = np.ravel_multi_index((part, *np.moveaxis(np.where(inside[..., None], places, 0), -1, 0)), self._shape)
        return np.where(inside, found, -1)

    def hold(self, points: Array, part: Any) -> Array:
        """Whether points, in cells of the lattice, are in some cube of a part."""
        found = np.zeros(len(points), dtype=bool)
        for width, known in self._known.items():
            found |= is_among(self._keys(np.floor(points / width).astype(int) * width, part), known)
        return found

    def exposed(self) -> list[Array]:
        """The sides that nothing covers: numbers of their cubes, the axes normal to them, and 0 or 1 for the lower or the upper one."""
        found = []
        for axis in range(3):
            along = [d for d in range(3) if d != axis]
            for side in (0, 1):
                ahead = self.corner.copy()
                ahead[:, axis] += (2 * side - 1) * self.size
                covered = np.zeros(len(self.size), dtype=bool)
                for width, known in self._known.items():
                    covered[self.size == width] = is_among(self._keys(ahead[self.size == width], self.part[self.size == width]), known)
                rest = np.flatnonzero(~covered)
                probes = np.ones(len(rest), dtype=bool)
                for quarter in AROUND:
                    point = self.corner[rest].astype(float)
                    point[:, along] += self.size[rest, None] * (0.26 + 0.47 * quarter)
                    point[:, axis] += np.where(side, self.size[rest] + 0.25, -0.25)
                    probes &= self.hold(point, self.part[rest])
                covered[rest] = probes
                for crack in self.cracks:
                    if axis == crack.axis:
                        for offset in CORNERS[CORNERS[:, axis] == side]:
                            covered[self._are_in(crack, self.corner + offset * self.size[:, None])] = False
                rest = np.flatnonzero(~covered)
                found.append((rest, np.full(len(rest), axis), np.full(len(rest), side)))
        return [np.concatenate(parts) for parts in zip(*found)]

    def _are_in(self, crack: Crack, corners: Array) -> Array:
        """Whether corners, in cells of the lattice, are in the faces of a crack."""
        places = self.places(corners)
        found = np.abs(places[:, crack.axis] - crack.at) < self.unit / 4
        found[found] = crack.holds(places[found])
        return found

    def _side(self, corners: Array, number: Array) -> Array:
        """1 for corners (n, 3) in the faces of a crack of cubes above it, by their numbers, else 0."""
        found = np.zeros(len(corners), dtype=int)
        for crack in self.cracks:
            found[self._are_in(crack, corners) & (self.places(self.corner[number] + self.size[number, None] / 2)[:, crack.axis] > crack.at)] = 1
        return found

    def sides(self, number: Array, axis: Array, side: Array) -> Array:
        """Corners of sides in cells of the lattice, shape (n, 4, 3); seen from outside they are in one order."""
        corners = np.empty((len(number), 4, 3), dtype=int)
        for d in range(3):
            chosen = axis == d
            along = [(d + 1) % 3, (d + 2) % 3]
            of, width = self.corner[number[chosen]], self.size[number[chosen]]
            corners[chosen] = of[:, None]
            corners[chosen, :, d] += (side[chosen] * width)[:, None]
            for k, other in enumerate(along):
                corners[chosen, :, other] += AROUND[:, k] * width[:, None]
        corners[side == 0] = corners[side == 0, ::-1]
        return corners

    def places(self, corners: Array) -> Array:
        """Where corners are [m]."""
        return self.origin + self.unit * corners

    def moved(self, corners: Array, number: Array, displacement: Array, gradient: Array) -> Array:
        """The displacements of corners (n, k, 3) of cubes (n): means of those that the cubes around them say by their own, (m, 3), and by
        their gradients, (m, 3, 3) [m]."""
        number = np.repeat(number, corners.shape[1])
        flat = corners.reshape(-1, 3)
        keys = 2 * self._keys(flat, self.part[number]) + self._side(flat, number)
        known, where = np.unique(keys, return_inverse=True)
        total, number, every = np.zeros((len(known), 3)), np.zeros(len(known)), np.arange(len(self.size))
        for offset in CORNERS:
            own = self.corner + offset * self.size[:, None]
            own = 2 * self._keys(own, self.part) + self._side(own, every)
            place = np.minimum(np.searchsorted(known, own), len(known) - 1)
            chosen = known[place] == own
            arm = (offset - 0.5) * (self.unit * self.size[chosen, None])
            said = displacement[chosen] + np.einsum("nij,nj->ni", gradient[chosen], arm)
            number += np.bincount(place[chosen], minlength=len(known))
            total += np.stack([np.bincount(place[chosen], column, minlength=len(known)) for column in said.T], axis=1)
        return (total / np.maximum(number, 1)[:, None])[where.reshape(-1)].reshape(corners.shape)

    def cut(self, axis: int, at: float) -> Array:
        """Numbers of the cubes that a plane across an axis cuts [m]; of two that meet in it the lower one."""
        place = (at - self.origin[axis]) / self.unit
        near = 1e-6 * self.size
        low, high = self.corner[:, axis], self.corner[:, axis] + self.size
        found = (low < place - near) & (high >= place - near)
        return np.flatnonzero(found if found.any() else np.abs(low - place) <= near)


def is_among(keys: Array, known: Array) -> Array:
    """Which keys are among those that are known, in ascending order."""
    return known[np.minimum(np.searchsorted(known, keys), len(known) - 1)] == keys


def on_lattice(places: Array, origin: Array, half: float, depth: int) -> tuple[Array, ...]:
    """Places in halves of the width of cubes, odd numbers near them, the powers of two in these, and whether they are the middles of cubes."""
    at = (places - origin) / half
    odd = np.rint(at).astype(int)
    power = np.min(odd & -odd, axis=1, initial=2**depth, where=odd != 0)
    return origin, at, odd, power, np.all(np.abs(at - odd) < OFF, axis=1) & np.all((odd // power[:, None]) % 2 == 1, axis=1)


def cubes_of_particles(result: SolidFrames, particles: Block, leaves: Leaves) -> Cubes:
    """The cubes of particles where they are undeformed. A place in the middle of a cube is an odd number of halves of its width from where
    its body begins, or the grid; others have the cube of the lattice of their cells in which they are."""
    scene, body = result.scene, particles.point_fields["body"].astype(int) - 1
    places = particles.points - particles.point_fields["displacement"][:, :3]
    depth = leaves.level.max()
    grid = np.array(scene.numbers("grid", "lower", count=3))
    lower, _ = scene.bodies()
    halves = [scene.cell() / (scene.numbers("body", "points_per_cell", n) or [2])[0] * 0.5 ** (depth + 1) for n in scene.body_groups()]
    half = min(halves)
    if any(abs(other / half - round(other / half)) > 1e-9 for other in halves):
        raise ResultError(f"{result.path}: bodies with other points_per_cell that are no multiples of each other are not drawn")
    number = np.empty(places.shape, dtype=int)
    size = np.ones(len(places), dtype=int)
    cell = result.cells_of(particles, leaves)
    of_cell = np.where(cell >= 0, leaves.width[cell], scene.cell())
    for k, own in enumerate(halves):
        chosen = body == k
        origin, at, odd, power, fits = max((on_lattice(places[chosen], origin, own, depth) for origin in (grid, lower[k])), key=lambda found: found[-1].sum())
        width = np.where(fits, 2 * power, np.maximum(1, np.rint(of_cell[chosen] / scene.cell() * 2**depth).astype(int)) * 2)
        first = np.where(fits[:, None], odd - power[:, None], np.floor(at / width[:, None]).astype(int) * width[:, None])
        shift = np.rint((origin - grid) / half).astype(int)
        number[chosen] = (first * round(own / half) + shift)
        size[chosen] = width * round(own / half)
    apart = scene.text("contact", "bodies") not in ("", "bonded")
    return Cubes(number - number.min(axis=0), size, grid + half * number.min(axis=0), half, body if apart else None,
                 [crack for crack in cracks_of(scene) if crack.is_inside])
