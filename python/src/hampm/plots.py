"""Figures of results and models: those of the commands `hampm plot ...`, drawn here."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .errors import ResultError
from .scripts import Asked

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from .history import History
    from .snapshots import Snapshots

KINDS = "energy", "field", "front", "g", "load", "mesh", "modes", "path", "profile", "rate", "resistance", "work_precision", "sketch"   # modules plot_... of `postprocess`


def plot(kind: str, *results: str | Path | History | Snapshots, **options: Any) -> Figure:
    """The figure that the command `hampm plot KIND RESULT ...` writes.

    kind     energy, field, front, g, load, mesh, modes, path, profile, rate, resistance, work_precision; sketch of a namelist
    results  paths of results, or what has been read of them
    options  those of the command, `_` for `-`: column=["K_I", "K_II"], errors=True, style="paper", size="84mm"; its --help explains them

    A `ResultError` tells what is wrong with a result or an option. The figure is that of matplotlib: change it, `savefig` it.
    """
    if kind not in KINDS:
        raise ResultError(f"there is no plot '{kind}'; there are {', '.join(KINDS)}")
    module = import_module(f".postprocess.{kind if kind == 'sketch' else 'plot_' + kind}", __package__)
    pictures = import_module(".postprocess.pictures", __package__)
    asked = module.parse(Asked(f"plot {kind}", [str(getattr(result, "path", result)) for result in results], options))
    with pictures.plt.rc_context(pictures.STYLE | pictures.STYLES.get(asked.style, {})):
        figure: Figure = pictures.in_style(module.figure, asked)
        pictures.plt.close(figure)      # a notebook shows what a cell returns, and not the same again
    return figure
