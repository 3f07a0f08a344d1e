"""Models, runs and results of hampm, which computes the dynamic energy release rate of cracks by a material point method.

    import hampm
    scene = hampm.Scene("plate.nml")          # a model: read, changed, checked, written
    scene.grid.cell = 0.5e-3                  # [m]
    print(scene.check())                      # what a run would need, and how long it takes
    history = hampm.run(scene, threads=2)     # its history: columns over time, with units and estimated errors
    history.to_pandas()

Numbers are in SI units throughout. docs/how-to/python.md has a study of twelve cases.
"""

from .comparison import Comparison, Tolerance, compare
from .errors import ComputationError, FileError, HampmError, HampmWarning, Message, ModelError, Stopped
from .extrapolation import Extrapolation, extrapolate
from .history import History
from .program import find_program, key_table
from .running import run
from .scene import Check, Scene
from .snapshots import Snapshots
from .stored import ResultError
from .sweep import Sweep

__version__ = "1.0.0"
__all__ = ["Check", "Comparison", "ComputationError", "Extrapolation", "FileError", "HampmError", "HampmWarning", "History", "Message", "ModelError",
           "ResultError", "Scene", "Snapshots", "Stopped", "Sweep", "Tolerance", "compare", "extrapolate", "find_program", "key_table", "run"]
