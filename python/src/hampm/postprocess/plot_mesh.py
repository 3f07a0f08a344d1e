"""Picture of the mesh around the crack tip, as in the paper's Figs. 7-9, of one or more hampm results.

Above, where a file has it: the refinement parameter R, mean over the nodes of each cell along the crack plane, and the critical
value. Below: the cells that hold material, mirrored about that plane where it is one of symmetry, and the box in which they may
refine. Of a solid, which has no tip, all cells that hold material are shown, from outside or where a plane across an axis cuts them (--slice).
"""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from ..arrays import Array
from ..errors import ResultError
from ..stored_model import StoredModel
from . import solid_pictures
from .frames import CrackPlane, Frames, frames_of, squares
from .particle_pictures import add_axes_option, axis_labels, is_in_scene, plane_of, time_words
from .pictures import COLOURS, MM, picture_parser, plt, positive, verbatim, write
from .plot_field import panels

WINDOW = 6.0    # half width of what is shown [mm]


def main(arguments: Sequence[str] | None = None) -> None:
    write(figure, parse(arguments), "_mesh")


def figure(options: Namespace) -> Figure:
    """The picture that these options ask for."""
    return draw([frames_of(path) for path in options.files], options)


def parse(arguments: Sequence[str] | None) -> Namespace:
    parser = picture_parser(__doc__, "_mesh", "result file with snapshots; one column each")
    parser.add_argument("--window", type=positive, metavar="MM",
                        help=f"half width of what is shown around the crack tip [mm] (default: {WINDOW:g})")
    add_axes_option(parser)
    solid_pictures.add_solid_options(parser)
    which = parser.add_mutually_exclusive_group()
    which.add_argument("--time", type=float, metavar="S", help="show the snapshot nearest to this time [s]")
    which.add_argument("--snapshot", type=int, metavar="N",
                       help="show this snapshot, counted from 0, or with a minus sign from the end (default: the last)")
    return parser.parse_args(arguments)


def draw(results: Sequence[Frames], options: Namespace) -> Figure:
    """The figure: a column for each result, R above the mesh where any has it."""
    if solid_pictures.check_options(results, options):
        return solid_pictures.draw_mesh(results, options, panels)
    views = [View(result, options) for result in results]
    has_parameter = any(view.has_parameter for view in views)
    is_shared = not any(is_in_scene(result, options) or result.has_crack_lines for result in results)  # else tips are at different places
    figure, axes = plt.subplots(1 + has_parameter, len(views), figsize=(0.8 + 3.6 * len(views), 4.2 + 2 * has_parameter),
                                squeeze=False, sharex=is_shared, sharey="row" if is_shared else False,
                                height_ratios=(0.6, 1)[-1 - has_parameter:], layout="compressed")
    upper, lower = axes[0], axes[-1]
    if has_parameter:
        top = max(draw_parameter(panel, view, options.window or WINDOW) for panel, view in zip(upper, views))
        for panel in upper:
            panel.set_ylim(0, 1.1 * top or 1)
        upper[0].set_ylabel("mean $R$ of a cell [–]")
    for panel, title, view in zip(lower, upper, views):
        draw_mesh(panel, view, options.window or WINDOW)
        title.set_title(view.heading(options.window or WINDOW), fontsize="medium")
        panel.xaxis.set_major_locator(MaxNLocator(5, prune="both"))
        if view is views[0] or view.plane.of_scene != views[0].plane.of_scene:
            panel.set_ylabel(axis_labels(view.plane, view.result.scene.count("growth") > 0)[1])
    if options.title:
        figure.suptitle(options.title)
    return figure


class View:
    """What is shown of a result: cells of a snapshot, their corners along the crack and in the coordinates of the picture, and the
    tip in these [mm]."""

    def __init__(self, result: Frames, options: Namespace) -> None:
        number = result.number(options.snapshot, options.time)
        crack = result.crack_plane(options.tip, number)
        if crack is None:
            raise ResultError(f"{result.path}: the scene has no crack tip to look at")
        self.result, self.plane = result, plane_of(result, options)
        self.tip = result.tip_place(self.plane, options.tip, number) * MM
        self.number, self.leaves, self.cracks = number, result.leaves(number), result.cracks(number)
        self.holds_material = self.leaves.particles > 0
        corners = squares(self.leaves.lower, self.leaves.width)
        self.along, self.corners = crack.local(corners) * MM, self.plane.local(corners) * MM
        self.has_parameter = "R" in self.leaves.point_fields

    def critical(self) -> float:
        """The value of R above which cells refine."""
        return self.result.scene.numbers("refine", "r_crit")[0]

    def parameter(self) -> tuple[Array, Array]:
        """Where the plane enters and leaves each cell along it [mm], and the mean R of each."""
        height, size = self.along[..., 1], self.leaves.width * MM
        is_one_side = self.plane.is_symmetry | (height.mean(axis=1) > -1e-3 * size)
        chosen = self.holds_material & is_one_side & (height.min(axis=1) < 1e-3 * size) & (height.max(axis=1) > 1e-3 * size)
        return chords(self.along[chosen]), self.leaves.mean_of_nodes("R")[chosen]

    def heading(self, window: float) -> str:
        """Name or critical value, time, and how many cells of each level are shown."""
        name = rf"$R_\mathrm{{crit}}$ = {self.critical():g}" if self.has_parameter else verbatim(self.result.stem)
        shown = within(self.corners - self.tip, window) & self.holds_material
        return f"{name}, {time_words(self.result, self.number)}\n{levels(self.leaves.level[shown])}"


def draw_mesh(axes: Axes, view: View, window: float) -> None:
    """Cells, the cracks as thick lines up to their tips, and the box."""
    plane, tip = view.plane, view.tip
    cells: Any = plane.whole(view.corners[view.holds_material], MM)
    axes.add_collection(PolyCollection(cells, facecolors="white", edgecolors="0.25", linewidths=0.5))
    for crack in view.cracks:
        points = plane.local(crack.points) * MM
        axes.plot(*points.T, color=COLOURS[1], linewidth=1.8, solid_capstyle="butt")
        axes.plot(*points[np.asarray(crack.tips) > 0].T, "o", color=COLOURS[1], markersize=3.5)
    axes.set(xlim=(tip[0] - window, tip[0] + window), ylim=(tip[1] - window, tip[1] + window), box_aspect=1)
    axes.set_xlabel(axis_labels(plane, view.result.scene.count("growth") > 0)[0])
    axes.grid(False)
    draw_box(axes, view.result.scene, plane)


def draw_box(axes: Axes, scene: StoredModel, plane: CrackPlane) -> None:
    """Where cells may refine, dashed, with its image as one box."""
    lower, upper = (np.array(scene.numbers("refine", key)) for key in ("region_lower", "region_upper"))
    if not lower.size:
        return
    corners = plane.local(box(lower, upper))
    if plane.is_symmetry:
        corners = plane.whole(corners)
        corners = box(corners.min(axis=0), corners.max(axis=0))
    axes.plot(*corners[[0, 1, 2, 3, 0]].T * MM, color=COLOURS[0], linestyle=(0, (4, 3)), linewidth=1.1)


def box(lower: Array, upper: Array) -> Array:
    """The corners of a rectangle."""
    return lower + (upper - lower) * [[0, 0], [1, 0], [1, 1], [0, 1]]


def chords(corners: Array) -> Array:
    """From where to where the line of height 0 runs through squares that it meets, given by their corners (n, 4, 2); shape (n, 2)."""
    start, end = corners, np.roll(corners, -1, axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        part = start[..., 1] / (start[..., 1] - end[..., 1])
        place = start[..., 0] + part * (end[..., 0] - start[..., 0])
    place = np.where(np.isfinite(part) & (part > -1e-2) & (part < 1 + 1e-2), place, np.nan)
    return np.column_stack([np.nanmin(place, axis=1), np.nanmax(place, axis=1)])


def draw_parameter(axes: Axes, view: View, window: float) -> float:
    """Mean R of the cells along the plane, each over its width, and the critical value. Returns the largest shown."""
    axes.set_box_aspect(0.6)
    axes.set_xlim(-window, window)
    if view.plane.of_scene:
        axes.set_xlabel("distance ahead of the crack tip [mm]")
    if not view.has_parameter:
        axes.text(0.5, 0.5, "no $R$ in this file\n(&refine indicator = 'gradient')", ha="center", va="center",
                  transform=axes.transAxes)
        return 0.0
    (x, mean), critical = view.parameter(), view.critical()
    order = np.argsort(x.min(axis=1))
    left, right = x.min(axis=1)[order], x.max(axis=1)[order]
    ends, values = np.column_stack([left, right]).ravel(), np.repeat(mean[order], 2)
    axes.fill_between(ends, values, color=COLOURS[0], alpha=0.15, linewidth=0)
    axes.plot(ends, values, color=COLOURS[0], linewidth=1.1)
    axes.axhline(critical, color=COLOURS[1], linestyle=(0, (5, 3)), linewidth=1.1)
    axes.annotate(r"$R_\mathrm{crit}$", (1, critical), xycoords=("axes fraction", "data"), xytext=(-3, 2),
                  textcoords="offset points", ha="right", va="bottom", color=COLOURS[1])
    in_window = (x.min(axis=1) < window) & (x.max(axis=1) > -window)
    return max(1.1 * critical, mean[in_window].max(initial=0.0))


def within(corners: Array, window: float) -> Array:
    """Whether the middle of a square is in the window."""
    return np.all(np.abs(corners.mean(axis=1)) < window, axis=1)


def levels(level: Array) -> str:
    """How many cells there are of each level, in words, at most three levels a line."""
    counts = [f"{np.count_nonzero(level == n)} of level {n}" for n in np.unique(level)]
    return "\n".join(", ".join(counts[k:k + 3]) for k in range(0, len(counts), 3)) or "no cells"
