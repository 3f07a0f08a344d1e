"""Snapshots of particles, mesh and cracks, as xarray and PyVista have them."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple
from xml.sax.saxutils import quoteattr

import numpy as np
from numpy.typing import NDArray

from .errors import UNREADABLE, ColumnError, ResultError, printable
from .stored import Stored, opened
from .stored_model import FAR, StoredModel

if TYPE_CHECKING:
    import pyvista
    import xarray
    from matplotlib.figure import Figure

POINTS = {"particles": (1,), "mesh": (4, 9), "cracks": (2,)}   # of a cell
OF_SOLIDS = {"particles": (1,), "mesh": (8,), "fronts": (2,)}
COMPONENTS = {"displacement": 1, "velocity": 1, "deformation_gradient": 2}   # powers of the dimensions, at least
COUNTED = ("id", "body", "level", "particles", "crack", "tip", "piece", "front")   # fields of whole numbers from 0 on
DEEPEST = 40    # level of a cell
CLOSE = 1e-9    # part by which times may differ that are the same


class Block(NamedTuple):
    """Positions [m] (n, 2), of a solid (n, 3), the corners of the cells as numbers of points (k, 9, 8, 4, 2 or 1), and fields by name of points and cells."""

    points: NDArray[np.float64]
    cells: NDArray[np.int64]
    point_fields: Fields
    cell_fields: Fields


class Snapshots:
    """The snapshots of one result file.

    path             of the file
    times            of all snapshots [s], shape (n)
    blocks           names of what they show: particles, mesh and perhaps cracks, of a solid fronts
    model            the namelist of the run
    dimensions       3 for a solid, else 2
    has_crack_lines  whether the snapshots hold the cracks as they are then: all but one on a symmetry plane that stays
    """

    def __init__(self, path: str | Path):
        self.path = Path(path)
        with opened(self.path) as stored:
            if not stored.has("input/namelist"):
                raise ResultError(f"{path}: has no dataset /input/namelist: not a result file", UNREADABLE)
            self.model = StoredModel(stored.text("input/namelist"), path)
            self.dimensions = self.model.dimensions()
            if not all(stored.has(f"VTKHDF/{block}/Steps/Values") for block in ("mesh", "particles")):
                raise ResultError(f"{path}: holds no snapshots (set `snapshot_interval` in &output)")
            self.has_crack_lines = stored.has("VTKHDF/cracks/Points")
            self._points = OF_SOLIDS if self.dimensions == 3 else POINTS
            self.blocks = tuple(block for block in self._points if block in ("particles", "mesh") or stored.has(f"VTKHDF/{block}/Points"))
            self.times: NDArray[np.float64] = stored.numbers("VTKHDF/mesh/Steps/Values", finite=True)
        if self.times.size == 0:
            raise ResultError(f"{path}: holds no snapshots yet")
        if np.any(np.diff(self.times) < 0):
            raise ResultError(f"{path}: /VTKHDF/mesh/Steps/Values goes back in time")

    def __len__(self) -> int:
        return self.times.size

    @property
    def stem(self) -> str:
        """File name without folder and suffix, for people."""
        return printable(self.path.stem)

    def number(self, snapshot: int | None = None, time: float | None = None) -> int:
        """Number of a snapshot, counted from 0, from the end where negative, or of the one nearest to a time [s], which is of the run; else of the last."""
        if time is not None:
            beyond = np.diff(self.times).max(initial=0.0)     # the run goes on to its next snapshot at most
            if not self.times[0] - beyond <= time <= self.times[-1] + beyond:
                raise ResultError(f"{self.path}: has no snapshot near {time:g} s; they are from {self.times[0]:g} to {self.times[-1]:g} s")
            return int(np.argmin(np.abs(self.times - time)))
        number = -1 if snapshot is None else snapshot
        if not -len(self) <= number < len(self):
            raise ResultError(f"{self.path}: has no snapshot {number}; there are {len(self)}, counted from 0")
        return number % len(self)

    def block(self, name: str, number: int) -> Block:
        """Particles, mesh or cracks of a snapshot, by its number from 0."""
        if name not in self.blocks:
            raise ResultError(f"{self.path}: has no {printable(name)} in its snapshots; they have {', '.join(self.blocks)}")
        with opened(self.path) as stored:
            return StoredBlock(stored, f"VTKHDF/{name}", number, self.model).read(self._points[name])

    def to_xarray(self, block: str = "particles", snapshot: int | None = None, time: float | None = None) -> xarray.Dataset:
        """A block of a snapshot as an `xarray.Dataset`: positions `x`, `y` and of a solid `z` [m], and fields of its points over `point`, fields of its cells over
        `cell`, vectors over `axis` too, and of cells that have all as many points these, by number, as `corners`. Each has `units`."""
        import xarray
        number = self.number(snapshot, time)
        found = self.block(block, number)
        data: dict[str, Any] = {}
        for dimension, fields in (("point", found.point_fields), ("cell", found.cell_fields)):
            for name, values in fields.items():
                vector = values[:, :self.dimensions] if name in ("displacement", "velocity") else values
                dimensions = (dimension, *([] if values.ndim == 1 else ["axis"] if vector is not values else [f"component_of_{name}"]))
                data[name if name not in data else f"{dimension}_{name}"] = (dimensions, vector, {"units": fields.units[name]})
        if block != "particles":
            data["corners"] = (("cell", "corner"), found.cells, {"units": "1"})
        axes = list("xyz"[:self.dimensions])
        return xarray.Dataset(data, coords={axis: ("point", places, {"units": "m"}) for axis, places in zip(axes, found.points.T)} |
                              {"axis": axes, "time": ((), self.times[number], {"units": "s"})},
                              attrs={"block": block, "snapshot": number})

    def sel(self, time: float, method: str | None = None, block: str = "particles") -> xarray.Dataset:
        """The snapshot of a time [s], as `sel` of xarray: of just this time, or with method = "nearest" the one nearest to it. Before the first and behind the
        last there is none."""
        number = int(np.argmin(np.abs(self.times - time)))
        is_within = self.times[0] <= time <= self.times[-1]
        if method not in (None, "nearest") or not (is_within and method == "nearest" or np.isclose(self.times[number], time, rtol=CLOSE, atol=0)):
            raise ColumnError(f"{self.path}: has no snapshot at {time:g} s; " + (f"method '{method}' is not known: use 'nearest'" if method not in (None, "nearest")
                              else f"method='nearest' takes that of {self.times[number]:g} s" if is_within else f"they are from {self.times[0]:g} to {self.times[-1]:g} s"))
        return self.to_xarray(block, snapshot=number)

    def plot(self, field: str = "energy_density", **options: Any) -> Figure:
        """A figure of the particles coloured by a field. Options are those of `hampm plot field`, such as time=1e-4, scale=100, window=5."""
        from .plots import plot
        return plot("field", self, field=field, **options)

    def to_pyvista(self, snapshot: int | None = None, time: float | None = None) -> pyvista.MultiBlock:
        """A snapshot as a `pyvista.MultiBlock` of `particles`, `mesh` and perhaps `cracks` or `fronts`, as ParaView shows it."""
        import pyvista
        reader = pyvista.HDFReader(str(self.path))
        reader.reader.UpdateInformation()
        reader.reader.UpdateTimeStep(float(self.times[self.number(snapshot, time)]))
        return reader.read()

    def to_paraview(self, output: str | Path) -> None:
        """The snapshots as a series in time that every ParaView shows as one animation: a file .pvd, and beside it a folder of its name with a file of each time.
        ParaView before 5.13 needs it, as in Debian 12; PyVista writes it."""
        output = Path(output)
        names = [f"{output.stem}/{number:05}.vtm" for number in range(len(self))]
        output.with_suffix("").mkdir(exist_ok=True)
        try:
            for number, name in enumerate(names):
                self.to_pyvista(number).save(output.parent / name)
        except ImportError as missing:
            raise ResultError(f"{output}: {missing}; a series for ParaView needs PyVista (pip install pyvista)") from missing
        sets = (f'<DataSet timestep="{float(time)!r}" file={quoteattr(name)}/>\n' for name, time in zip(names, self.times))
        output.write_text(f'<VTKFile type="Collection" version="0.1"><Collection>\n{"".join(sets)}</Collection></VTKFile>\n')

    def __repr__(self) -> str:
        return f"{printable(self.path)}: {len(self)} snapshots of {', '.join(self.blocks)}, {self.times[0]:.4g} to {self.times[-1]:.4g} s"


class Fields(dict[str, NDArray[Any]]):
    """Fields by name, of which one that is asked for has to be there; `units` has the unit of each."""

    def __init__(self, fields: dict[str, NDArray[Any]], units: dict[str, str], where: str):
        super().__init__(fields)
        self.units, self._where = units, where

    def __missing__(self, name: str) -> NDArray[Any]:
        raise ResultError(f"{self._where}/{name} is missing")


class StoredBlock:
    """Particles, mesh or cracks of a snapshot in a file that is open."""

    def __init__(self, stored: Stored, name: str, number: int, model: StoredModel):
        self._stored, self._name, self._number, self._model = stored, name, number, model

    def read(self, points_of_cell: tuple[int, ...]) -> Block:
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
        reach = FAR * max(self._model.numbers("grid", "cell"), default=FAR)
        place = self._stored.numbers(f"{self._name}/Points", dims=2, finite=True, least=-reach, most=reach, first=first_point, count=points)
        if place.shape[1] < self._model.dimensions():
            raise self._stored.wrong(f"{self._name}/Points", f"has {place.shape[1]} coordinates")
        return Block(place[:, :self._model.dimensions()], numbers.reshape(cells, -1), self._fields("PointData", first_point, points),
                     self._fields("CellData", first_cell, cells))

    def _step(self, name: str) -> int:
        """Where something begins, or how many there are, in this snapshot."""
        name = f"{self._name}/{name}"
        values = self._stored.numbers(name, dims=max(self._stored.dims(name), 1), whole=True, least=0).reshape(-1)
        if values.size <= self._number:
            raise self._stored.wrong(name, f"has {values.size} rows, and there is a snapshot {self._number}")
        return int(values[self._number])

    def _fields(self, group: str, first: int, count: int) -> Fields:
        """Fields by name."""
        where = f"{self._name}/{group}"
        found: dict[str, NDArray[Any]] = {}
        units = {}
        for name in self._stored.names(where):
            dims = 2 if name in COMPONENTS else 1 if name in COUNTED else max(1, self._stored.dims(f"{where}/{name}"))
            limits: dict[str, Any] = {"whole": True, "least": 0, "most": DEEPEST if name == "level" else 2**31} if name in COUNTED else {}
            found[name] = self._stored.numbers(f"{where}/{name}", dims, finite=True, first=first, count=count, **limits)
            units[name] = printable(self._stored.attributes(f"{where}/{name}", texts=("units",)).get("units", "1"))
            if name in COMPONENTS and found[name].shape[1] < self._model.dimensions() ** COMPONENTS[name]:
                raise self._stored.wrong(f"{where}/{name}", f"has {found[name].shape[1]} components")
        bodies = len(self._model.body_groups())
        if "body" in found and not (found["body"].min() >= 1 and found["body"].max() <= bodies):
            raise self._stored.wrong(f"{where}/body", f"is between {found['body'].min()} and {found['body'].max()}, and the scene has {bodies}")
        return Fields(found, units, f"{self._stored.path}: /{where}")
