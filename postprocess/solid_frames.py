"""Snapshots of solids: the cubes of their material and of their cells, the sides of these that nothing covers, and what a plane cuts.

Each particle is the cube of which it is the middle where the material is undeformed. Corners of cubes move with the mean of what the
particles around them say, each by its displacement and its deformation gradient; so surfaces are closed, and cracks in a plane of symmetry open.
"""

from functools import lru_cache

import numpy as np

from frames import Frames
from history import ResultError, opened
from plot_front import front_of

CORNERS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0], [0, 0, 1], [1, 0, 1], [0, 1, 1], [1, 1, 1]])
AROUND = np.array([[0, 0], [1, 0], [1, 1], [0, 1]])     # corners of a side, by the two axes along it
OFF = 0.05      # of half the width of a cube: how far a particle may be from the middle of one
PIECES = 32     # of the edge of a constraint
KEPT = 4        # snapshots whose cubes are remembered


class SolidFrames(Frames):
    """The snapshots of one result of the program for solids."""

    is_for_solids = True

    def __init__(self, path):
        super().__init__(path)
        self.cubes = lru_cache(KEPT)(self._cubes)

    def crack_plane(self, tip=1, number=0):
        """None: what a crack has in a solid is a front."""
        return None

    def fronts(self, number, ligament=None):
        """The fronts of cracks at the time of a snapshot, nodes (n, 3) [m] of each: those that are measured, or the edge of a constraint."""
        if ligament:
            front = front_of(self.scene, ligament)
            return [front.origin + np.outer(np.linspace(0, front.length, PIECES + 1), np.eye(3)[front.axes[2]])]
        with opened(self.path) as stored:
            if not all(stored.has(f"front/{name}") for name in "xyz"):
                return []
            sample = int(np.argmin(np.abs(stored.numbers("history/time", finite=True) - self.times[number])))
            return [np.column_stack([stored.numbers(f"front/{name}", dims=2, finite=True, first=sample, count=1)[0] for name in "xyz"])]

    def _cubes(self, number):
        """The cubes of the particles of a snapshot."""
        return cubes_of_particles(self, self.block("particles", number), self.leaves(number))

    def cells(self, number):
        """The cubes of the cells that hold material, with the numbers of these among `leaves`."""
        leaves = self.leaves(number)
        holds = np.flatnonzero(leaves.particles > 0)
        size = 2 ** (leaves.level.max() - leaves.level[holds])
        unit = self.scene.cell() * 0.5 ** leaves.level.max()
        lower = np.array(self.scene.numbers("grid", "lower", count=3))
        return Cubes(np.rint((leaves.lower[holds] - lower) / unit).astype(int), size, lower, unit), leaves, holds


class Cubes:
    """Cubes on one lattice, each some powers of two as wide as its cells.

    corner, size    lower corner (n, 3) and width (n) in cells of the lattice
    origin, unit    where the lattice begins, and the size of its cells [m]
    part            number of what each belongs to (n): cubes of other parts cover nothing, and share no corners
    """

    def __init__(self, corner, size, origin, unit, part=None):
        self.corner, self.size, self.origin, self.unit = corner, size, origin, unit
        self.part = np.zeros(len(size), dtype=int) if part is None else part
        self._shape = (self.part.max(initial=0) + 1, *(corner.max(axis=0) + size.max() + 2))
        self._known = {int(width): np.unique(self._keys(corner[size == width], self.part[size == width])) for width in np.unique(size)}

    def _keys(self, places, part):
        """Numbers of places of the lattice, which are told apart by what they belong to; -1 outside of it."""
        inside = np.all((places >= 0) & (places < self._shape[1:]), axis=-1)
        found = np.ravel_multi_index((part, *np.moveaxis(np.where(inside[..., None], places, 0), -1, 0)), self._shape)
        return np.where(inside, found, -1)

    def hold(self, points, part):
        """Whether points, in cells of the lattice, are in some cube of a part."""
        found = np.zeros(len(points), dtype=bool)
        for width, known in self._known.items():
            found |= is_among(self._keys(np.floor(points / width).astype(int) * width, part), known)
        return found

    def exposed(self):
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
                rest = rest[~probes]
                found.append((rest, np.full(len(rest), axis), np.full(len(rest), side)))
        return [np.concatenate(parts) for parts in zip(*found)]

    def sides(self, number, axis, side):
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

    def places(self, corners):
        """Where corners are [m]."""
        return self.origin + self.unit * corners

    def moved(self, corners, part, displacement, gradient):
        """The displacements of corners (n, ..., 3) of parts (n): means of those that the cubes around them say by their own, (k, 3), and by
        their gradients, (k, 3, 3) [m]."""
        keys = self._keys(corners, np.broadcast_to(part.reshape(-1, *[1] * (corners.ndim - 2)), corners.shape[:-1]))
        known, where = np.unique(keys, return_inverse=True)
        total, number = np.zeros((len(known), 3)), np.zeros(len(known))
        for offset in CORNERS:
            own = self._keys(self.corner + offset * self.size[:, None], self.part)
            place = np.minimum(np.searchsorted(known, own), len(known) - 1)
            chosen = known[place] == own
            arm = (offset - 0.5) * (self.unit * self.size[chosen, None])
            said = displacement[chosen] + np.einsum("nij,nj->ni", gradient[chosen], arm)
            number += np.bincount(place[chosen], minlength=len(known))
            total += np.stack([np.bincount(place[chosen], column, minlength=len(known)) for column in said.T], axis=1)
        return (total / np.maximum(number, 1)[:, None])[where.reshape(-1)].reshape(corners.shape)

    def cut(self, axis, at):
        """Numbers of the cubes that a plane across an axis cuts [m]; of two that meet in it the lower one."""
        place = (at - self.origin[axis]) / self.unit
        near = 1e-6 * self.size
        low, high = self.corner[:, axis], self.corner[:, axis] + self.size
        found = (low < place - near) & (high >= place - near)
        return np.flatnonzero(found if found.any() else np.abs(low - place) <= near)


def is_among(keys, known):
    """Which keys are among those that are known, in ascending order."""
    return known[np.minimum(np.searchsorted(known, keys), len(known) - 1)] == keys


def cubes_of_particles(result, particles, leaves):
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
        for origin in (grid, lower[k]):
            at = (places[chosen] - origin) / own
            odd = np.rint(at).astype(int)
            power = np.min(odd & -odd, axis=1, initial=2**depth, where=odd != 0)
            fits = np.all(np.abs(at - odd) < OFF, axis=1) & np.all((odd // power[:, None]) % 2 == 1, axis=1)
            if fits.all():
                break
        width = np.where(fits, 2 * power, np.maximum(1, np.rint(of_cell[chosen] / scene.cell() * 2**depth).astype(int)) * 2)
        first = np.where(fits[:, None], odd - power[:, None], np.floor(at / width[:, None]).astype(int) * width[:, None])
        shift = np.rint((origin - grid) / half).astype(int)
        number[chosen] = (first * round(own / half) + shift)
        size[chosen] = width * round(own / half)
    apart = scene.text("contact", "bodies") not in ("", "bonded")
    return Cubes(number - number.min(axis=0), size, grid + half * number.min(axis=0), half, body if apart else None)
