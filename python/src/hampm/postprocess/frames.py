"""The snapshots of a run, as its result file holds them: particles and mesh at every time, and the scene of the run.

`Frames` are those of the package `hampm`, with the cracks; `Leaves` puts the cells of a mesh together again, of which those beside finer
ones are stored as four quarters; `CrackPlane` turns positions into distances ahead of the crack tip and from its plane.
"""

from __future__ import annotations

from collections import namedtuple
from pathlib import Path

import numpy as np

from ..arrays import Array
from ..errors import ResultError
from ..snapshots import Block, Snapshots
from ..stored import opened
from ..stored_model import StoredModel

Crack = namedtuple("Crack", "points tips")
Crack.__doc__ = "The points of a crack in the reference configuration [m] (n, 2), and the number of the tip at each; 0 where none is."


class Frames(Snapshots):
    """The snapshots of one result file of a plane, with what pictures show of them: cells and cracks."""

    is_for_solids = False

    def __init__(self, path: str | Path) -> None:
        super().__init__(path)
        if (self.dimensions == 3) != self.is_for_solids:
            raise ResultError(f"{path}: is a result of the program for solids; plot_field.py, plot_mesh.py, animate.py and plot_front.py show it")

    @property
    def scene(self) -> StoredModel:
        """The namelist."""
        return self.model

    def leaves(self, number: int) -> Leaves:
        """The cells of a snapshot's mesh."""
        return Leaves(self.block("mesh", number), np.array(self.scene.numbers("grid", "lower", count=self.dimensions)), self.scene.cell(), self.path)

    def cells_of(self, particles: Block, leaves: Leaves) -> Array:
        """The cell of each particle; -1 outside the mesh. In the total frame it is that in which the particle was at first, wherever it has moved to."""
        return leaves.at(particles.points - particles.point_fields["displacement"][:, :self.dimensions] if self.is_total() else particles.points)

    def is_total(self) -> bool:
        """Whether particles stay in the cells in which they are at first, wherever they move to."""
        return self.scene.text("method", "frame") == "total"

    def cracks(self, number: int = 0) -> list[Crack]:
        """The cracks of a snapshot; one on a symmetry plane that stays, and lines of older files, as the scene has them."""
        scene = self.scene
        if not scene.count("crack"):
            return []
        if not (self.has_crack_lines or scene.has_paths()):
            tip, along = (np.array(scene.numbers("crack", key, count=2)) for key in ("tip", "direction"))
            if not np.hypot(*along) > 0:
                raise ResultError(f"{self.path}: the crack of the stored namelist has no direction")
            along = along / np.hypot(*along)
            length = (scene.numbers("crack", "length") or [0.0])[0]
            return [Crack(np.array([tip - (length or scene.way_to_edge(tip, -along)) * along, tip]), [2 if length else 0, 1])]
        block = self.block("cracks", number)
        parts = [np.unique(block.cells[block.cell_fields["crack"] == of]) for of in np.unique(block.cell_fields["crack"])]
        if any(len(np.unique(block.points[part], axis=0)) < len(part) or len(part) < 2 for part in parts):
            raise ResultError(f"{self.path}: /VTKHDF/cracks/Points has points of one crack at one place")
        return [Crack(block.points[part], block.point_fields["tip"][part].astype(int)) for part in parts]

    def crack_plane(self, tip: int = 1, number: int = 0) -> CrackPlane | None:
        """The plane of the crack at a tip, by its number, in a snapshot; None where the scene has no tip."""
        for crack in self.cracks(number):
            for place, before in ((0, 1), (-1, -2)):
                if crack.tips[place] == tip:
                    return CrackPlane(crack.points[place], crack.points[place] - crack.points[before],
                                      self.scene.text("crack", "kind") == "symmetry")
        if number == 0 and len(self) > 1:    # a crack that appears in the run
            return self.crack_plane(tip, len(self) - 1)
        if tip == 1:
            return None
        raise ResultError(f"{self.path}: the scene has no crack tip {tip}")

    def tip_place(self, plane: CrackPlane, tip: int, number: int) -> Array:
        """Where a tip is in a snapshot, in the coordinates of the plane of a crack [m]; where none is, the plane's own."""
        there = self.crack_plane(tip, number) if self.has_crack_lines else None
        return plane.tip if there is None else plane.local(there.in_scene().tip)


def frames_of(path: str | Path, mode: int | None = None) -> Frames:
    """The snapshots of a result file, of a plane or of a solid; or a period of one of its modes, counted from 1."""
    from .solid_frames import SolidFrames
    kind = SolidFrames if Snapshots(path).dimensions == 3 else Frames
    return kind(path) if mode is None else type("ModeFrames", (OfMode, kind), {})(path, mode)


class OfMode(Frames):
    """What makes snapshots of the first one and of a mode in /modes: a period, in which the largest component of the displacement is a thousandth of the grid."""

    FRAMES, PART = 24, 1e-3

    def __init__(self, path: str | Path, mode: int) -> None:
        super().__init__(path)
        with opened(path) as stored:
            if not stored.has("modes/frequency"):
                raise ResultError(f"{path}: has no modes; a run with &method time = 'modal' has")
            frequency, number = (stored.numbers(f"modes/{name}", finite=True) for name in ("frequency", "id"))
            if not 1 <= mode <= frequency.size:
                raise ResultError(f"{path}: has no mode {mode}; it has {frequency.size}")
            shape = stored.numbers("modes/shape", dims=2, finite=True)[(mode - 1) * number.size:mode * number.size]
        self.words = f"mode {mode}, {frequency[mode - 1]:.5g} Hz"
        self.times = np.arange(self.FRAMES) / (self.FRAMES * max(frequency[mode - 1], np.finfo(float).tiny))
        self._way = dict(zip(number.astype(int), self.PART * self.scene.cell() * max(self.scene.numbers("grid", "cells")) * shape))

    def enlarge(self, factor: float) -> None:
        """Have displacements that are larger by a factor."""
        self._way = {number: factor * way for number, way in self._way.items()}

    def block(self, name: str, number: int) -> Block:
        """That of the first snapshot, its particles where the mode moves them."""
        block = super().block(name, 0)
        if name != "particles":
            return block
        moved, fields = np.zeros_like(block.point_fields["displacement"]), block.point_fields
        moved[:, :self.dimensions] = np.sin(2 * np.pi * number / self.FRAMES) * np.array([self._way[k] for k in fields["id"].astype(int)])
        points = block.points - fields["displacement"][:, :self.dimensions] + moved[:, :self.dimensions]
        fields["displacement"] = moved
        if "deformation_gradient" in fields:     # particles keep their shape
            one = fields["deformation_gradient"][0]
            fields["deformation_gradient"] = np.tile(np.eye(round(one.size**0.5)).reshape(one.shape), (len(points), *[1] * one.ndim))
        return block._replace(points=points)


class Leaves:
    """The cells of a mesh, each once: four quarters of a cell, or the eight parts of one of a solid, become the cell.

    lower, width   lower corner (n, 2), of a solid (n, 3), and size (n) [m]
    level          how often a root cell has been divided, (n)
    particles      number of particles, (n)
    point_fields   fields of the mesh by name, at its points
    """

    def __init__(self, mesh: Block, origin: Array, root: float, path: str | Path = "") -> None:
        level = mesh.cell_fields["level"]
        width = root * 0.5**level
        corners = mesh.points[mesh.cells]
        size = np.ptp(corners, axis=1)
        fits = np.abs(size / width[:, None] - 1) < 1e-3     # or a quarter of a cell beside finer ones
        if not np.all((fits | (np.abs(2 * size / width[:, None] - 1) < 1e-3)).all(axis=1)):
            raise ResultError(f"{path}: /VTKHDF/mesh/CellData/level does not fit the size of the cells")
        middle = corners.mean(axis=1) - origin
        keys = np.column_stack([level, np.floor(middle / width[:, None]).astype(int)])
        unique, self._leaf_of_element = np.unique(keys, axis=0, return_inverse=True)
        self._leaf_of_element = self._leaf_of_element.reshape(-1)
        self.level = unique[:, 0]
        self.width = root * 0.5**self.level
        self.lower = origin + unique[:, 1:] * self.width[:, None]
        self.particles = np.bincount(self._leaf_of_element, mesh.cell_fields["particles"]).astype(int)
        self.point_fields = mesh.point_fields
        self._mesh, self._origin, self._root, self._keys = mesh, origin, root, unique

    def mean_of_nodes(self, name: str) -> Array:
        """Mean of a point field over the nodes of each cell: its corners and those corners of others on its sides."""
        mesh, level = self._mesh, int(self.level.max())
        places = np.rint((mesh.points - self._origin) / (self._root * 0.5**level)).astype(int)
        row = places[:, 1].max() + 1
        numbers = places[:, 0] * row + places[:, 1]
        corners = [self._keys[:, 1:] + shift for shift in ((0, 0), (1, 0), (0, 1), (1, 1))]
        corners = np.concatenate(corners) * 2 ** (level - np.tile(self.level, 4))[:, None]
        is_node = np.isin(numbers, corners[:, 0] * row + corners[:, 1])
        pairs = np.column_stack([np.repeat(self._leaf_of_element, mesh.cells.shape[1]), mesh.cells.reshape(-1)])
        leaf, point = np.unique(pairs[is_node[pairs[:, 1]]], axis=0).T
        return np.bincount(leaf, mesh.point_fields[name][point]) / np.bincount(leaf)

    def at(self, points: Array) -> Array:
        """The cell that each point is in; -1 outside the mesh."""
        found = np.full(len(points), -1)
        for level in np.unique(self.level):
            of_level = np.flatnonzero(self.level == level)
            keys = self._keys[of_level, 1:].astype(int)
            shape = keys.max(axis=0) + 1
            places = np.floor((points - self._origin) / (self._root * 0.5**level)).astype(int)
            inside = np.all((places >= 0) & (places < shape), axis=1)
            numbers = np.where(inside, np.ravel_multi_index(np.where(inside[:, None], places, 0).T, shape), -1)
            known = np.ravel_multi_index(keys.T, shape)  # ascending, as the keys are sorted
            where = np.minimum(np.searchsorted(known, numbers), known.size - 1)
            found = np.where(known[where] == numbers, of_level[where], found)
        return found


class CrackPlane:
    """The plane of a crack at its tip, and coordinates: along it from the tip and normal to it, or with `of_scene` those of the scene.
    `direction` is that of growth; `is_symmetry` tells that the model is one half."""

    def __init__(self, tip: Array, direction: Array, is_symmetry: bool = False, of_scene: bool = False) -> None:
        self.is_symmetry, self.of_scene = is_symmetry, of_scene
        along = np.asarray(direction) / np.hypot(*direction)
        self._origin: Array
        self._axes: Array
        self._origin, self._axes = (np.zeros(2), np.eye(2)) if of_scene else (tip, np.array([along, [-along[1], along[0]]]))
        self.tip, self.along = self.local(tip), self.turned(along)  # in these coordinates

    def in_scene(self) -> CrackPlane:
        """The same plane in the coordinates of the scene."""
        tip, along = self._origin + self.tip @ self._axes, self.along @ self._axes
        return CrackPlane(tip, along, self.is_symmetry, of_scene=True)

    def local(self, points: Array) -> Array:
        """Coordinates of points (..., 2)."""
        return self.turned(points - self._origin)

    def turned(self, vectors: Array) -> Array:
        """Components of vectors."""
        return vectors @ self._axes.T

    def whole(self, points: Array, unit: float = 1.0) -> Array:
        """Points (..., 2) in these coordinates, of which a metre has `unit`, and, where the model is one half, behind them their
        images."""
        if not self.is_symmetry:
            return points
        normal = np.array([-self.along[1], self.along[0]])
        height = (points - unit * self.tip) @ normal
        return np.concatenate([points, points - 2 * height[..., None] * normal])


def squares(lower: Array, width: Array) -> Array:
    """Corners of squares, shape (n, 4, 2)."""
    return lower[:, None, :] + width[:, None, None] * np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
