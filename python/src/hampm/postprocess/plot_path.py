"""Picture of the paths of growing cracks over mesh and stress.

Particles, mesh and cracks are those of a snapshot of the first file, the last unless another is asked for; over them stand the paths of all
tips that grow, of this file up to that snapshot and of the others as a whole, a colour for each file. A dot marks where a tip began. Paths
are those of the reference configuration. Points of a measured path, or of any other reference, come from CSV files. With --beside a column
such as G stands beside the picture, or below a flat one, over time, with a line at the time of the snapshot.
"""

from __future__ import annotations

import argparse
from argparse import Namespace
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke

from ..arrays import Array
from ..columns import symbol
from ..errors import ResultError
from ..history import History, is_rate
from . import plot_g
from .frames import CrackPlane, Frames
from .growing_tips import growing_tips
from .particle_fields import ParticleField
from .particle_pictures import Canvas, add_colour_bar, add_field_options, colours, extent, survey
from .pictures import COLOURS, DASHES, MM, add_time_unit, picture_names, picture_parser, plt, positive, prefixed, time_axis, typeset, verbatim, write
from .points import read_points

TALLEST = 6.0  # height of the picture [inch]
FLAT = 0.5     # height over width below which what stands beside it stands below it
HALO = [withStroke(linewidth=3.6, foreground="white")]
MARKERS = "osD^v"
LOOK = ("color", "linestyle", "linewidth", "marker", "markersize", "markerfacecolor", "markeredgecolor")


def main(arguments: Sequence[str] | None = None) -> None:
    write(figure, parse(arguments), "_path")


def figure(options: Namespace) -> Figure:
    """The picture that these options ask for."""
    first, histories = Frames(options.files[0]), [History(path) for path in options.files]
    return draw(first, histories, [(path, read_points(path, options.columns)) for path in options.measured], options)


def parse(arguments: Sequence[str] | None) -> Namespace:
    parser = picture_parser(__doc__, "_path", "result file with growing cracks; the first with snapshots")
    add_field_options(parser, "von_mises")
    which = parser.add_mutually_exclusive_group()
    which.add_argument("--time", type=float, metavar="S", help="show the first file's snapshot nearest to this time [s]")
    which.add_argument("--snapshot", type=int, metavar="N",
                       help="show this snapshot of it, counted from 0, or with a minus sign from the end (default: the last)")
    parser.add_argument("--scale", type=positive, default=1.0, metavar="FACTOR",
                        help="by which displacements are enlarged; paths are not moved (default: %(default)g)")
    parser.add_argument("--beside", metavar="NAME", help="column of the history to draw over time; G over G_ref where there is one")
    add_time_unit(parser)
    parser.add_argument("--measured", action="append", default=[], metavar="FILE.csv",
                        help="points of a measured path, or of another reference: rows of x, y [mm]; may be repeated")
    parser.add_argument("--columns", type=pair, default=(1, 2), metavar="X,Y",
                        help="which columns of these files are x and y, counted from 1 (default: 1,2)")
    parser.add_argument("--inset", type=float, nargs=3, metavar=("X", "Y", "HALF"),
                        help="enlarge the paths around a place in a corner of the picture, over so much on either side [mm]")
    return parser.parse_args(arguments)


def pair(text: str) -> tuple[int, ...]:
    """Numbers of two columns, counted from 1."""
    numbers = [int(word) for word in text.split(",")]
    if len(numbers) != 2 or min(numbers) < 1 or numbers[0] == numbers[1]:
        raise argparse.ArgumentTypeError(f"{text} is not two numbers of columns")
    return tuple(numbers)


def draw(first: Frames, histories: Sequence[History], measured: Sequence[tuple[str, Array]], options: Namespace) -> Figure:
    """The figure: a snapshot of the first result, and over it the paths of all results and the measured points."""
    number = first.number(options.snapshot, options.time)
    field = ParticleField(first, options.field)
    seen = survey(first, field, [number], options, options.scale)
    lower, upper = extent(seen, options.window)
    size = upper - lower
    figure, axes, panel = panels(size[1] / size[0], options.beside)
    canvas = Canvas(axes, first, field, options.scale, colours(field, seen, options), options)
    title = canvas.show(number)
    axes.set(xlim=(lower[0], upper[0]), ylim=(lower[1], upper[1]), title=options.title or title)
    add_colour_bar(figure, axes, canvas)
    for k, (history, name) in enumerate(zip(histories, picture_names(histories))):
        label = name if len(histories) > 1 else "path of the tip"
        draw_paths(axes, canvas.plane, history, label, k, first.times[number] if k == 0 else None)
    for k, (path, points) in enumerate(measured):
        axes.plot(*canvas.plane.local(points / MM).T * MM, MARKERS[k % len(MARKERS)], markersize=5, markerfacecolor="none",
                  markeredgecolor="black", markeredgewidth=1.1, label=verbatim(Path(path).stem), zorder=6)
    if options.inset:
        draw_inset(axes, options.inset)
    if panel:
        draw_over_time(panel, histories, first.times[number], options)
    figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=2, frameon=False, handlelength=3.2)
    return figure


def draw_inset(axes: Axes, window: Sequence[float]) -> None:
    """Enlarge the lines and points around a place, in a corner: x, y and half width of what is enlarged [mm]."""
    x, y, half = window
    inset = axes.inset_axes((0.62, 0.03, 0.35, 0.35), xlim=(x - half, x + half), ylim=(y - half, y + half), xticks=[], yticks=[])
    inset.set_aspect("equal")
    inset.grid(False)
    for line in axes.lines[1:]:                    # the first are the tips
        inset.plot(*line.get_data(), **{name: plt.getp(line, name) for name in LOOK})
    inset.spines[:].set_visible(True)
    axes.indicate_inset_zoom(inset, edgecolor="0.3", alpha=1)


def panels(shape: float, has_panel: Any) -> tuple[Figure, Axes, Axes | None]:
    """A figure with axes of this height over width for the picture, and with a panel beside them, or below flat ones, or None."""
    width = min(7.0, TALLEST / shape)
    size = max(width, 4.5) + 1.2, width * shape + 1.2
    if not has_panel:
        figure, axes = plt.subplots(figsize=size, layout="compressed")
        return figure, axes, None
    if shape < FLAT:
        figure, (axes, panel) = plt.subplots(2, figsize=(size[0], size[1] + 2.6), height_ratios=(width * shape + 0.4, 2.4), layout="constrained")
    else:
        figure, (axes, panel) = plt.subplots(1, 2, figsize=(size[0] + 4.2, size[1]), width_ratios=(size[0], 4.0), layout="constrained")
        panel.set_box_aspect(0.75)
    return figure, axes, panel


def draw_over_time(axes: Axes, histories: Sequence[History], now: float, options: Namespace) -> None:
    """A column of all files over time, with a line at the time of the snapshot."""
    factor, label = time_axis(histories, options.time_unit)
    name = options.beside
    for history in histories:
        history.select([name])
    is_ratio = is_rate(name) and all("G_ref" in history.attributes for history in histories)
    largest = max(np.abs(history.columns[name][np.isfinite(history.columns[name])]).max(initial=0.0) for history in histories)
    unit = verbatim(histories[0].units[name])
    scale, unit = (1.0, "–") if is_ratio else prefixed(largest, unit)
    unit = "–" if unit == "1" else typeset(unit)
    for k, history in enumerate(histories):
        axes.plot(history.times * factor, history.columns[name] * (1 / history.g_ref() if is_ratio else scale), color=COLOURS[k % len(COLOURS)],
                  linestyle=DASHES[k % len(DASHES)], marker="o" if history.times.size <= plot_g.FEW else None, markersize=3.5)
    axes.axvline(now * factor, color="0.6", linewidth=1.0)
    axes.set(xlabel=label, ylabel=rf"${name}/G_\mathrm{{ref}}$ [–]" if is_ratio and name == "G" else f"{symbol(name)} [{unit}]")


def draw_paths(axes: Axes, plane: CrackPlane, history: History, name: str, number: int, until: float | None = None) -> None:
    """The paths of all tips of a run that grow, up to a time where that is given, with a dot where each began."""
    tips = growing_tips(history)
    if not tips:
        raise ResultError(f"{history.path}: no crack grows in this run (set `&growth`)")
    style: dict[str, Any] = {"color": COLOURS[number % len(COLOURS)], "linestyle": DASHES[number % len(DASHES)], "linewidth": 1.9, "path_effects": HALO, "zorder": 5}
    for tip in tips:
        points = plane.local(tip.path(until)) * MM
        axes.plot(*points.T, label=name if tip is tips[0] else None, **style)
        axes.plot(*points[0], "o", color=style["color"], markersize=4, markeredgecolor="white", zorder=5)
