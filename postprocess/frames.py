"""The snapshots of a run, as its result file holds them: particles and mesh at every time, and the scene of the run.

`Frames` reads `/VTKHDF` and the namelist, and has the cracks; `Leaves` puts the cells of a mesh together again, of which those beside finer
ones are stored as four quarters; `CrackPlane` turns positions into distances ahead of the crack tip and from its plane.
"""

import re
from collections import namedtuple
from pathlib import Path

from history import UNREADABLE, ResultError
from stored import opened, printable

import numpy as np

Block = namedtuple("Block", "points cells point_fields cell_fields")
Crack = namedtuple("Crack", "points tips")
Crack.__doc__ = "The points of a crack in the reference configuration [m] (n, 2), and the number of the tip at each; 0 where none is."
Block.__doc__ = "Positions [m] (n, 2), the corners of the cells as numbers of points (k, 9, 4, 2 or 1), and fields by name."

POINTS = {"particles": (1,), "mesh": (4, 9), "cracks": (2,)}   # of a cell
COMPONENTS = {"displacement": 2, "velocity": 2, "deformation_gradient": 4}   # at least
COUNTED = ("body", "level", "particles", "crack", "tip", "piece")  # fields of whole numbers from 0 on
DEEPEST = 40    # level of a cell
FAR = 1e9       # cells from the grid at which nothing can be


class Frames:
    """The snapshots of one result file.

    times             of all snapshots [s], shape (n)
    scene             the namelist
    has_crack_lines   whether the snapshots hold the cracks as they are then: all but one on a symmetry plane that stays
    """

    def __init__(self, path):
        self.path = Path(path)
        with opened(self.path) as stored:
            if not stored.has("input/namelist"):
                raise ResultError(f"{path}: has no dataset /input/namelist: not a result file", UNREADABLE)
            self.scene = Scene(stored.text("input/namelist"), path)
            if not all(stored.has(f"VTKHDF/{block}/Steps/Values") for block in ("mesh", "particles")):
                raise ResultError(f"{path}: holds no snapshots (set `snapshot_interval` in &output)")
            self.times = stored.numbers("VTKHDF/mesh/Steps/Values", finite=True)
            self.has_crack_lines = stored.has("VTKHDF/cracks/Points")
        if self.times.size == 0:
            raise ResultError(f"{path}: holds no snapshots yet")
        if np.any(np.diff(self.times) < 0):
            raise ResultError(f"{path}: /VTKHDF/mesh/Steps/Values goes back in time")

    @property
    def stem(self):
        """File name without folder and suffix, for people."""
        return printable(self.path.stem)

    def number(self, snapshot=None, time=None):
        """Number of a snapshot, counted from 0 from the end where negative, or nearest to a time; else the last."""
        if time is not None:
            return int(np.argmin(np.abs(self.times - time)))
        number = -1 if snapshot is None else snapshot
        if not -self.times.size <= number < self.times.size:
            raise ResultError(f"{self.path}: has no snapshot {number}; there are {self.times.size}, counted from 0")
        return number % self.times.size

    def block(self, name, number):
        """Particles, mesh or cracks of a snapshot."""
        with opened(self.path) as stored:
            return StoredBlock(stored, f"VTKHDF/{name}", number, self.scene).read(POINTS[name])

    def leaves(self, number):
        """The cells of a snapshot's mesh."""
        return Leaves(self.block("mesh", number), np.array(self.scene.numbers("grid", "lower", count=2)), self.scene.cell(), self.path)

    def cells_of(self, particles, leaves):
        """The cell of each particle; -1 outside the mesh. In the total frame it is that in which the particle was at first, wherever it has moved to."""
        return leaves.at(particles.points - particles.point_fields["displacement"][:, :2] if self.is_total() else particles.points)

    def is_total(self):
        """Whether particles stay in the cells in which they are at first, wherever they move to."""
        return self.scene.text("method", "frame") == "total"

    def cracks(self, number=0):
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

    def crack_plane(self, tip=1, number=0):
        """The plane of the crack at a tip, by its number, in a snapshot; None where the scene has no tip."""
        for crack in self.cracks(number):
            for place, before in ((0, 1), (-1, -2)):
                if crack.tips[place] == tip:
                    return CrackPlane(crack.points[place], crack.points[place] - crack.points[before],
                                      self.scene.text("crack", "kind") == "symmetry")
        if tip == 1:
            return None
        raise ResultError(f"{self.path}: the scene has no crack tip {tip}")

    def tip_place(self, plane, tip, number):
        """Where a tip is in a snapshot, in the coordinates of the plane of a crack [m]; where none is, the plane's own."""
        there = self.crack_plane(tip, number) if self.has_crack_lines else None
        return plane.tip if there is None else plane.local(there.in_scene().tip)


class Fields(dict):
    """Fields by name, of which one that is asked for has to be there."""

    def __init__(self, fields, where):
        super().__init__(fields)
        self._where = where

    def __missing__(self, name):
        raise ResultError(f"{self._where}/{name} is missing")


class StoredBlock:
    """Particles, mesh or cracks of a snapshot in a file that is open."""

    def __init__(self, stored, name, number, scene):
        self._stored, self._name, self._number, self._scene = stored, name, number, scene

    def read(self, points_of_cell):
        """The block, whose cells have one of these numbers of points."""
        first_point, points = self._step("Steps/PointOffsets"), self._step("NumberOfPoints")
        first_cell, cells = self._step("Steps/CellOffsets"), self._step("NumberOfCells")
        first, count = self._step("Steps/ConnectivityIdOffsets"), self._step("NumberOfConnectivityIds")
        if points == 0 or cells == 0:
            raise self._stored.wrong(f"{self._name}/NumberOfPoints", f"says that snapshot {self._number} holds nothing")
        if count % cells or count // cells not in points_of_cell:
            raise self._stored.wrong(f"{self._name}/NumberOfConnectivityIds", f"is {count} in snapshot {self._number}, and {cells} cells have "
                                     f"{' or '.join(map(str, points_of_cell))} each")
        numbers = self._stored.numbers(f"{self._name}/Connectivity", whole=True, least=0, most=points - 1, first=first, count=count)
        reach = FAR * max(self._scene.numbers("grid", "cell"), default=FAR)
        place = self._stored.numbers(f"{self._name}/Points", dims=2, finite=True, least=-reach, most=reach, first=first_point, count=points)
        if place.shape[1] < 2:
            raise self._stored.wrong(f"{self._name}/Points", f"has {place.shape[1]} coordinates")
        return Block(place[:, :2], numbers.reshape(cells, -1), self._fields("PointData", first_point, points),
                     self._fields("CellData", first_cell, cells))

    def _step(self, name):
        """Where something begins, or how many there are, in this snapshot."""
        name = f"{self._name}/{name}"
        values = self._stored.numbers(name, dims=max(self._stored.dims(name), 1), whole=True, least=0).reshape(-1)
        if values.size <= self._number:
            raise self._stored.wrong(name, f"has {values.size} rows, and there is a snapshot {self._number}")
        return int(values[self._number])

    def _fields(self, group, first, count):
        """Fields by name."""
        where, found = f"{self._name}/{group}", {}
        for name in self._stored.names(where):
            dims = 2 if name in COMPONENTS else 1 if name in COUNTED else max(1, self._stored.dims(f"{where}/{name}"))
            limits = {"whole": True, "least": 0, "most": DEEPEST if name == "level" else 2**31} if name in COUNTED else {}
            found[name] = self._stored.numbers(f"{where}/{name}", dims, finite=True, first=first, count=count, **limits)
            if name in COMPONENTS and found[name].shape[1] < COMPONENTS[name]:
                raise self._stored.wrong(f"{where}/{name}", f"has {found[name].shape[1]} components")
        bodies = len(self._scene.body_groups())
        if "body" in found and not (found["body"].min() >= 1 and found["body"].max() <= bodies):
            raise self._stored.wrong(f"{where}/body", f"is between {found['body'].min()} and {found['body'].max()}, and the scene has {bodies}")
        return Fields(found, f"{self._stored.path}: /{where}")


class Scene:
    """The namelist of a run, as the result file holds it: complete, one key a line.

    Where a group repeats, `instance` says which is meant, counted from 1.
    """

    def __init__(self, text, path):
        self.path, self._groups = path, {}
        for line in text.splitlines():
            if line.startswith("&"):
                self._groups.setdefault(line[1:].strip(), []).append({})
                values = self._groups[line[1:].strip()][-1]
            elif match := re.match(r"\s+(\w+) =(.*)", line):
                values[match[1]] = match[2].strip()

    def count(self, group):
        """How many groups of this name there are."""
        return len(self._groups.get(group, []))

    def text(self, group, key, instance=1):
        """A value as text without quotes; '' where it is not given."""
        groups = self._groups.get(group, [])
        return groups[instance - 1].get(key, "").strip("'") if len(groups) >= instance else ""

    def numbers(self, group, key, instance=1, count=None):
        """Values as numbers, so many of them where that is said; none where they are not given."""
        try:
            values = [float(word) for word in self.text(group, key, instance).replace(",", " ").split()]
        except ValueError as error:
            raise ResultError(f"{self.path}: '{key}' in &{group} of the stored namelist is not a number ({error})",
                              UNREADABLE) from error
        if count is not None and not (len(values) == count and np.all(np.abs(values) < FAR**2)):
            raise ResultError(f"{self.path}: '{key}' in &{group} of the stored namelist has to be {count} number{'s' * (count > 1)}")
        return values

    def cell(self):
        """Size of a root cell [m]."""
        size, = self.numbers("grid", "cell", count=1)
        if not size > 0:
            raise ResultError(f"{self.path}: 'cell' in &grid of the stored namelist is {size:g}")
        return size

    def body_groups(self):
        """Numbers of the groups &body that are no holes."""
        return [n for n in range(1, self.count("body") + 1) if self.text("body", "hole", n) != ".true."]

    def box_of(self, number):
        """Lower and upper corner of the box around a body, shape (2, 2)."""
        match self.text("body", "shape", number):
            case "polygon":
                points = self.numbers("body", "points", number)
                if len(points) < 6 or len(points) % 2:
                    raise ResultError(f"{self.path}: 'points' in &body of the stored namelist are no polygon")
                points = np.reshape(points, (-1, 2))
                return [points.min(axis=0), points.max(axis=0)]
            case "circle":
                center, radius = np.array(self.numbers("body", "center", number, 2)), self.numbers("body", "radius", number, 1)[0]
                return [center - radius, center + radius]
        return [self.numbers("body", key, number, 2) for key in ("lower", "upper")]

    def bodies(self):
        """Lower and upper corners of the boxes around the bodies [m], shape (n, 2)."""
        return tuple(np.array([self.box_of(n) for n in self.body_groups()]).reshape(-1, 2, 2).swapaxes(0, 1))

    def is_static(self):
        """Whether the run goes from equilibrium to equilibrium, in a time that only tells how large the loads are."""
        return self.text("method", "time") == "static"

    def has_paths(self):
        """Whether its cracks are paths."""
        return self.text("crack", "kind") == "path"

    def way_to_edge(self, start, direction):
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


class Leaves:
    """The cells of a mesh, each once: four quarters of a cell become the cell.

    lower, width   lower corner (n, 2) and size (n) [m]
    level          how often a root cell has been divided, (n)
    particles      number of particles, (n)
    point_fields   fields of the mesh by name, at its points
    """

    def __init__(self, mesh, origin, root, path=""):
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

    def mean_of_nodes(self, name):
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

    def at(self, points):
        """The cell that each point is in; -1 outside the mesh."""
        found = np.full(len(points), -1)
        for level in np.unique(self.level):
            of_level = np.flatnonzero(self.level == level)
            row = self._keys[of_level, 2].max() + 2
            places = np.floor((points - self._origin) / (self._root * 0.5**level)).astype(int)
            inside = (places >= 0).all(axis=1) & (places[:, 1] < row)
            numbers = np.where(inside, places[:, 0] * row + places[:, 1], -1)
            known = self._keys[of_level, 1] * row + self._keys[of_level, 2]  # ascending, as the keys are sorted
            where = np.minimum(np.searchsorted(known, numbers), known.size - 1)
            found = np.where(known[where] == numbers, of_level[where], found)
        return found


class CrackPlane:
    """The plane of a crack at its tip, and coordinates: along it from the tip and normal to it, or with `of_scene` those of the scene.
    `direction` is that of growth; `is_symmetry` tells that the model is one half."""

    def __init__(self, tip, direction, is_symmetry=False, of_scene=False):
        self.is_symmetry, self.of_scene = is_symmetry, of_scene
        along = np.asarray(direction) / np.hypot(*direction)
        self._origin, self._axes = (np.zeros(2), np.eye(2)) if of_scene else (tip, np.array([along, [-along[1], along[0]]]))
        self.tip, self.along = self.local(tip), self.turned(along)  # in these coordinates

    def in_scene(self):
        """The same plane in the coordinates of the scene."""
        tip, along = self._origin + self.tip @ self._axes, self.along @ self._axes
        return CrackPlane(tip, along, self.is_symmetry, of_scene=True)

    def local(self, points):
        """Coordinates of points (..., 2)."""
        return self.turned(points - self._origin)

    def turned(self, vectors):
        """Components of vectors."""
        return vectors @ self._axes.T

    def whole(self, points, unit=1.0):
        """Points (..., 2) in these coordinates, of which a metre has `unit`, and, where the model is one half, behind them their
        images."""
        if not self.is_symmetry:
            return points
        normal = np.array([-self.along[1], self.along[0]])
        height = (points - unit * self.tip) @ normal
        return np.concatenate([points, points - 2 * height[..., None] * normal])


def squares(lower, width):
    """Corners of squares, shape (n, 4, 2)."""
    return lower[:, None, :] + width[:, None, None] * np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
