#!/usr/bin/env python3
"""Picture of the mesh around the crack tip, as in the paper's Figs. 7-9, of one or more hampm results.

Above: the refinement parameter R, mean over the nodes of each cell along the crack plane, and the critical value.
Below: the cells that hold material, mirrored about that plane where it is one of symmetry, and the box in which they may refine.
"""

import argparse

from frames import Frames, squares
from history import ResultError, run
from pictures import COLOURS, MM, add_picture_options, plt, positive, write

import numpy as np
from matplotlib.collections import PolyCollection


def main(arguments=None):
    options = parse(arguments)
    results = [Frames(path) for path in options.files]
    write(lambda: draw(results, options), options, "_mesh")


def parse(arguments):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="+", metavar="FILE.h5", help="result file with snapshots; one column each")
    parser.add_argument("--window", type=positive, default=6.0, metavar="MM",
                        help="half width of what is shown around the crack tip [mm] (default: %(default)g)")
    which = parser.add_mutually_exclusive_group()
    which.add_argument("--time", type=float, metavar="S", help="show the snapshot nearest to this time [s]")
    which.add_argument("--snapshot", type=int, metavar="N",
                       help="show this snapshot, counted from 0, or with a minus sign from the end (default: the last)")
    add_picture_options(parser, "_mesh")
    return parser.parse_args(arguments)


def draw(results, options):
    """The figure: a column for each result, R above the mesh."""
    figure, axes = plt.subplots(2, len(results), figsize=(0.8 + 3.6 * len(results), 6.2), squeeze=False, sharex=True,
                                sharey="row", height_ratios=(0.6, 1), layout="compressed")
    tops = [draw_result(result, *column, options) for result, column in zip(results, axes.T)]
    axes[0, 0].set_ylim(0, 1.1 * max(tops) or 1)
    axes[0, 0].set_ylabel("mean $R$ of a cell [–]")
    axes[1, 0].set_ylabel("height above the crack plane [mm]")
    if options.title:
        figure.suptitle(options.title)
    return figure


def draw_result(result, upper, lower, options):
    """One column: R along the plane and the mesh. Returns the largest value of R shown."""
    plane = result.crack_plane()
    if plane is None:
        raise ResultError(f"{result.path}: the scene has no crack, so there is no tip to look at")
    number = result.number(options.snapshot, options.time)
    leaves = result.leaves(number)
    holds_material = leaves.particles > 0
    corners = plane.local(squares(leaves.lower, leaves.width)) * MM
    size = leaves.width * MM

    draw_mesh(lower, plane.whole(corners[holds_material]), options.window, plane.length * MM)
    draw_box(lower, result.scene, plane)
    lower.set_xlabel("distance ahead of the crack tip [mm]")

    heading, top = f"{result.stem}, $t$ = {result.times[number] * 1e3:.4g} ms", 0.0
    if "R" in leaves.point_fields:
        is_one_side = plane.is_symmetry | (corners[..., 1].mean(axis=1) > 0)
        along = holds_material & is_one_side & (np.abs(corners[..., 1]).min(axis=1) < 1e-3 * size)
        critical = result.scene.numbers("refine", "r_crit")[0]
        top = draw_parameter(upper, corners[along, :, 0], leaves.mean_of_nodes("R")[along], critical, options.window)
        heading = rf"$R_\mathrm{{crit}}$ = {critical:g}, $t$ = {result.times[number] * 1e3:.4g} ms"
    else:
        upper.text(0.5, 0.5, "no $R$ in this file\n(&refine indicator = 'gradient')", ha="center", va="center",
                   transform=upper.transAxes)
    shown = within(corners, options.window) & holds_material
    upper.set_title(f"{heading}\n{levels(leaves.level[shown])}")
    upper.set_box_aspect(0.6)
    return top


def draw_mesh(axes, corners, window, length):
    """Squares, and the crack as a thick line up to its tip at the origin, of a length unless that is 0."""
    axes.add_collection(PolyCollection(corners, facecolors="white", edgecolors="0.25", linewidths=0.5))
    axes.plot([-length or -window, 0], [0, 0], color=COLOURS[1], linewidth=1.8, solid_capstyle="butt")
    axes.plot(0, 0, "o", color=COLOURS[1], markersize=3.5)
    axes.set(xlim=(-window, window), ylim=(-window, window), box_aspect=1)
    axes.grid(False)


def draw_box(axes, scene, plane):
    """Where cells may refine, dashed."""
    lower, upper = scene.numbers("refine", "region_lower"), scene.numbers("refine", "region_upper")
    if not (lower and upper):
        return
    ends = plane.whole(plane.local(np.array([lower, upper]))) * MM
    (left, bottom), (right, top) = ends.min(axis=0), ends.max(axis=0)
    axes.plot([left, right, right, left, left], [bottom, bottom, top, top, bottom], color=COLOURS[0],
              linestyle=(0, (4, 3)), linewidth=1.1)


def draw_parameter(axes, x, mean, critical, window):
    """Mean R of the cells along the plane, each over its width, and the critical value. Returns the largest shown."""
    order = np.argsort(x.min(axis=1))
    left, right = x.min(axis=1)[order], x.max(axis=1)[order]
    ends, values = np.column_stack([left, right]).ravel(), np.repeat(mean[order], 2)
    axes.fill_between(ends, values, color=COLOURS[0], alpha=0.15, linewidth=0)
    axes.plot(ends, values, color=COLOURS[0], linewidth=1.1)
    axes.axhline(critical, color=COLOURS[1], linestyle=(0, (5, 3)), linewidth=1.1)
    axes.annotate(rf"$R_\mathrm{{crit}}$", (1, critical), xycoords=("axes fraction", "data"), xytext=(-3, 2),
                  textcoords="offset points", ha="right", va="bottom", color=COLOURS[1])
    in_window = (x.min(axis=1) < window) & (x.max(axis=1) > -window)
    return max(1.1 * critical, mean[in_window].max(initial=0.0))


def within(corners, window):
    """Whether the middle of a square is in the window."""
    return np.all(np.abs(corners.mean(axis=1)) < window, axis=1)


def levels(level):
    """How many cells there are of each level, in words."""
    return "cells of level " + ", ".join(f"{n}: {np.count_nonzero(level == n)}" for n in np.unique(level))


if __name__ == "__main__":
    run(main)
