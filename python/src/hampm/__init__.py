"""Models, runs and results of hampm, which computes the dynamic energy release rate of cracks by a material point method.

    import hampm
    scene = hampm.Scene("plate.nml")          # a model: read, changed, checked, written
    scene.grid.cell = 0.5e-3                  # [m]
    print(scene.check())                      # what a run would need, and how long it takes
    history = hampm.run(scene, threads=2)     # its history: columns over time, with units and estimated errors
    history.to_pandas()

Numbers are in SI units throughout. docs/how-to/python.md has a study of twelve cases.
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .columns import Column as Column, describe as describe
    from .comparison import Comparison as Comparison, Tolerance as Tolerance, compare as compare
    from .errors import (ColumnError as ColumnError, ComputationError as ComputationError, FileError as FileError, HampmError as HampmError, HampmWarning as HampmWarning,
                         Message as Message, ModelError as ModelError, ResultError as ResultError, Stopped as Stopped)
    from .extrapolation import Extrapolation as Extrapolation, extrapolate as extrapolate
    from .history import History as History
    from .plots import plot as plot
    from .program import find_program as find_program, key_table as key_table
    from .running import run as run
    from .scene import Check as Check, Scene as Scene
    from .snapshots import Snapshots as Snapshots
    from .study import Fit as Fit, Solution as Solution, Study as Study
    from .sweep import Sweep as Sweep

__version__ = "2.0.0"

# Modules are read when something of them is asked for first: scripts that run thousands of cases have no time for what they do not use
_MODULES = {"columns": ("Column", "describe"), "comparison": ("Comparison", "Tolerance", "compare"),
            "errors": ("ColumnError", "ComputationError", "FileError", "HampmError", "HampmWarning", "Message", "ModelError", "ResultError", "Stopped"),
            "extrapolation": ("Extrapolation", "extrapolate"), "history": ("History",), "plots": ("plot",), "program": ("find_program", "key_table"), "running": ("run",),
            "scene": ("Check", "Scene"), "snapshots": ("Snapshots",), "study": ("Fit", "Solution", "Study"), "sweep": ("Sweep",)}
_HOMES = {name: module for module, names in _MODULES.items() for name in names}
__all__ = sorted(_HOMES)


if not TYPE_CHECKING:
    def __getattr__(name):
        if name not in _HOMES:
            raise AttributeError(f"module 'hampm' has no attribute '{name}'")
        globals()[name] = found = getattr(import_module(f".{_HOMES[name]}", __name__), name)
        return found


def __dir__() -> list[str]:
    return [*__all__, "__version__"]
