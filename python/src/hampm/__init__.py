"""Models, runs and results of hampm, which computes the dynamic energy release rate of cracks by a material point method."""

from .comparison import Comparison, Tolerance, compare
from .extrapolation import Extrapolation, extrapolate
from .history import History
from .stored import ResultError

__all__ = ["Comparison", "Extrapolation", "History", "ResultError", "Tolerance", "compare", "extrapolate"]
