"""Snapshots of particles, mesh and cracks, as xarray and PyVista have them."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from .stored import UNREADABLE, ResultError, opened, printable

if TYPE_CHECKING:
    import pyvista
    import xarray

BLOCKS = "particles", "mesh", "cracks"
COUNTED = "id", "body", "level", "particles", "piece", "side", "crack", "tip"   # fields of whole numbers


class Snapshots:
    """The snapshots of one result file.

    path    of the file
    times   of all snapshots [s]
    blocks  names of what they show: particles, mesh and perhaps cracks
    """

    def __init__(self, path: str | Path):
        self.path = Path(path)
        with opened(self.path) as stored:
            self.blocks = tuple(block for block in BLOCKS if stored.has(f"VTKHDF/{block}/Steps/Values"))
            if not self.blocks:
                raise ResultError(f"{self.path}: holds no snapshots (set `snapshot_interval` in &output)", UNREADABLE)
            self.times = stored.numbers(f"VTKHDF/{self.blocks[0]}/Steps/Values", finite=True)

    def __len__(self):
        return self.times.size

    def number(self, snapshot: int | None = None, time: float | None = None) -> int:
        """Number of a snapshot, counted from 0, from the end where negative, or of the one nearest to a time [s]; else of the last."""
        if time is not None:
            return int(np.argmin(np.abs(self.times - time)))
        number = -1 if snapshot is None else snapshot
        if not -len(self) <= number < len(self):
            raise ResultError(f"{self.path}: has no snapshot {number}; there are {len(self)}, counted from 0")
        return number % len(self)

    def to_xarray(self, block: str = "particles", snapshot: int | None = None, time: float | None = None) -> xarray.Dataset:
        """A block of a snapshot as an `xarray.Dataset`: positions `x`, `y` [m] and fields of its points over `point`, fields of its cells over
        `cell`, vectors over `axis` too, and of cells that have all as many points these, by number, as `corners`. Each has `units`."""
        import xarray
        number = self.number(snapshot, time)
        if block not in self.blocks:
            raise ResultError(f"{self.path}: has no {printable(block)} in its snapshots; they have {', '.join(self.blocks)}")
        data = {}
        with opened(self.path) as stored:
            at, count = self._places(stored, block, number)
            points = stored.numbers(f"VTKHDF/{block}/Points", dims=2, first=at["Point"], count=count["Points"])
            for which, dimension, size in (("Point", "point", count["Points"]), ("Cell", "cell", count["Cells"])):
                for name in stored.names(f"VTKHDF/{block}/{which}Data"):
                    path = f"VTKHDF/{block}/{which}Data/{name}"
                    values = stored.numbers(path, dims=stored.dims(path), first=at[which], count=size)
                    dimensions = (dimension, "axis") if values.ndim == 2 else (dimension,)
                    values = values[:, :2] if values.ndim == 2 else values.astype(int) if name in COUNTED else values
                    unit = stored.attributes(path, texts=("units",)).get("units", "1")
                    data[name if name not in data else f"{dimension}_{name}"] = (dimensions, values, {"units": unit})
            if block != "particles" and count["Cells"] and count["ConnectivityIds"] % count["Cells"] == 0:
                corners = stored.numbers(f"VTKHDF/{block}/Connectivity", whole=True, first=at["ConnectivityId"], count=count["ConnectivityIds"])
                data["corners"] = (("cell", "corner"), corners.reshape(count["Cells"], -1), {"units": "1"})
        return xarray.Dataset(data, coords={"x": ("point", points[:, 0], {"units": "m"}), "y": ("point", points[:, 1], {"units": "m"}),
                                            "axis": ["x", "y"], "time": ((), self.times[number], {"units": "s"})},
                              attrs={"block": block, "snapshot": number})

    def to_pyvista(self, snapshot: int | None = None, time: float | None = None) -> pyvista.MultiBlock:
        """A snapshot as a `pyvista.MultiBlock` of `particles`, `mesh` and perhaps `cracks`, as ParaView shows it."""
        import pyvista
        reader = pyvista.HDFReader(str(self.path))
        reader.reader.UpdateInformation()
        reader.reader.UpdateTimeStep(float(self.times[self.number(snapshot, time)]))
        return reader.read()

    def __repr__(self):
        span = f", {self.times[0]:.4g} to {self.times[-1]:.4g} s" if len(self) else ""
        return f"{printable(self.path)}: {len(self)} snapshots of {', '.join(self.blocks)}{span}"

    @staticmethod
    def _places(stored, block, number):
        """Where the data of a snapshot begin, and how many they are."""
        steps = f"VTKHDF/{block}/Steps"
        at = {which: int(stored.numbers(f"{steps}/{which}Offsets", dims=stored.dims(f"{steps}/{which}Offsets"), whole=True, least=0)[number].flat[0])
              for which in ("Point", "Cell", "ConnectivityId")}
        part = int(stored.numbers(f"{steps}/PartOffsets", whole=True, least=0)[number])
        return at, {which: int(stored.numbers(f"VTKHDF/{block}/NumberOf{which}", whole=True, least=0)[part])
                    for which in ("Points", "Cells", "ConnectivityIds")}
