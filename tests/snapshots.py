"""Snapshots of a result file, read by the rules of VTKHDF with h5py alone; tests/output/test_vtk.py holds what is read here to what VTK reads."""

from dataclasses import dataclass

import h5py
import numpy as np

BLOCKS = "particles", "mesh", "cracks", "fronts"


@dataclass
class Block:
    """A part of a snapshot: an unstructured grid. A cell is the numbers of its points; kinds are those of VTK: 1 a vertex, 3 a line, 9 a quadrilateral."""
    points: np.ndarray
    point_data: dict
    cell_data: dict
    cells: list
    kinds: np.ndarray

    def bounds(self, cell):
        """Least and largest x, y, ... of a cell."""
        corners = self.points[self.cells[cell]]
        return np.column_stack([corners.min(axis=0), corners.max(axis=0)]).ravel()


def read_steps(path):
    """Times and, for every time, the blocks: particles, mesh and, with cracks in any direction, these."""
    with h5py.File(path) as file:
        root = file["VTKHDF"]
        names = [name for name in BLOCKS if name in root]
        times = list(root[names[0]]["Steps/Values"][:])
        assert all(list(root[name]["Steps/Values"][:]) == times for name in names)
        return times, [[read_block(root[name], step) for name in names] for step in range(len(times))]


def read_block(group, step):
    """What a step has of each dataset: one part, whose numbers of points, cells and corners are a row of `NumberOf...`."""
    steps = group["Steps"]
    part = steps["PartOffsets"][step]
    counted = {name: int(group[f"NumberOf{name}"][part]) for name in ("Points", "Cells", "ConnectivityIds")}
    first_cell, first_corner = (int(np.ravel(steps[name][step])[0]) for name in ("CellOffsets", "ConnectivityIdOffsets"))
    # Of each part there is an offset more than there are cells
    ends = group["Offsets"][first_cell + part:first_cell + part + counted["Cells"] + 1]
    corners = group["Connectivity"][first_corner:first_corner + counted["ConnectivityIds"]]

    def fields(kind, count):
        found = {}
        for name, data in group.get(kind, {}).items():
            first = int(steps[f"{kind}Offsets/{name}"][step])
            found[name] = data[first:first + count]
        return found
    first = int(steps["PointOffsets"][step])
    return Block(group["Points"][first:first + counted["Points"]], fields("PointData", counted["Points"]), fields("CellData", counted["Cells"]),
                 [corners[begin:end] for begin, end in zip(ends, ends[1:])], group["Types"][first_cell:first_cell + counted["Cells"]])


def points(grid):
    return grid.points


def field(data, name):
    return data[name]


def field_names(data):
    return list(data)
