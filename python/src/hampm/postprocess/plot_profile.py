"""Picture of a field along a line through snapshots of one or more hampm results, such as a wave along a bar.

The field is that of the particles whose share of their cell the line touches, or with --nodes that of the nodes on it which
carry mass. There is one value at each place, the mean of the particles there; at a crack along the line each face has its own, and a
curve. Fields of particles are those of the file (stress_xx, energy_density, ...), velocity_x, displacement_y and the like, and
those of plot_field.py; nodes have mass, velocity_x, velocity_y and, where the mesh follows a gradient, R.
"""

from __future__ import annotations

import csv
import sys
from argparse import Namespace
from collections import namedtuple
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from ..arrays import Array
from ..errors import ResultError
from ..signals import read_curve
from ..snapshots import Block
from .crack_faces import is_between, segments_of
from .frames import CrackPlane, Frames, Leaves
from .particle_fields import ParticleField, words_of
from .pictures import COLOURS, DASHES, name_curves, names, picture_parser, plt, positive, prefixed, typeset, verbatim, write

VECTORS = {"velocity": "m/s", "displacement": "m"}
NODE_UNITS = {"mass": "kg", "R": "1"}
FEW = 40       # places up to which each has a marker
CLOSE = 0.01   # of a cell: how far material may have moved off the line

Profile = namedtuple("Profile", "name time place value side")
Profile.__doc__ = ("A field along the line: name of the file, time [s], places [m] in ascending order, values, and the side of the "
                   "line on which each is: 1 where the coordinate across it is larger, -1 where it is smaller, 0 on both.")


def main(arguments: Sequence[str] | None = None) -> None:
    options = parse(arguments)
    if options.csv:
        write_csv(profiles_of(options)[1])
    else:
        write(figure, options, f"_{options.field}")


def figure(options: Namespace) -> Figure:
    """The picture that these options ask for."""
    first, profiles = profiles_of(options)
    return draw(profiles, unit_of(first, options), options)


def profiles_of(options: Namespace) -> tuple[Frames, list[Profile]]:
    """The first result, and the profiles of all."""
    results = [Frames(path) for path in options.files]
    return results[0], [profile(result, name, number, options) for result, name in zip(results, names(results)) for number in numbers(result, options)]


def parse(arguments: Sequence[str] | None) -> Namespace:
    parser = picture_parser(__doc__, "_<field>", "result file with snapshots")
    parser.add_argument("--field", required=True, metavar="NAME", help="what is drawn")
    parser.add_argument("--nodes", action="store_true", help="the field of the nodes, as it was in the last step")
    parser.add_argument("--time", type=float, action="append", metavar="S",
                        help="show the snapshot nearest to this time [s]; may be repeated (default: the last)")
    parser.add_argument("--along", choices=["x", "y"], default="x", help="direction of the line (default: %(default)s)")
    parser.add_argument("--at", type=float, metavar="M", help="where the line is, across it [m] (default: all particles or nodes, the mean at each place)")
    parser.add_argument("--from-tip", action="store_true",
                        help="measure both from the crack tip, along the crack (x) and normal to it")
    parser.add_argument("--from", type=float, default=-np.inf, metavar="M", dest="first",
                        help="where the part that is shown begins [m]")
    parser.add_argument("--to", type=float, default=np.inf, metavar="M", dest="last", help="where it ends [m]")
    parser.add_argument("--log", action="store_true", help="logarithmic axes; leaves out what is not above zero")
    parser.add_argument("--reference", metavar="FILE.csv", help="reference curve: rows of place [m], value")
    parser.add_argument("--reference-name", metavar="TEXT", default="reference", help="of that curve (default: %(default)s)")
    parser.add_argument("--scale", type=positive, metavar="VALUE", help="what the values and the reference curve are divided by")
    parser.add_argument("--label", metavar="TEXT", help="of the vertical axis (default: the field and its unit)")
    parser.add_argument("--csv", action="store_true", help="print comma-separated values in SI units in place of a picture")
    return parser.parse_args(arguments)


def numbers(result: Frames, options: Namespace) -> list[int]:
    """Numbers of the snapshots to show."""
    return [result.number(time=time) for time in options.time or [result.times[-1]]]


def profile(result: Frames, name: str, number: int, options: Namespace) -> Profile:
    """The field of a snapshot along the line."""
    leaves = result.leaves(number)
    block = result.block("mesh" if options.nodes else "particles", number)
    place, across = on_axes(result, number, block.points, options).T
    values = node_values(result, block, options) if options.nodes else particle_values(result, block, leaves, options)
    near = (place >= options.first) & (place <= options.last)
    if options.nodes:
        near &= block.point_fields["mass"] > 0
    if options.at is not None:
        near &= np.abs(across - options.at) <= reach(result, block, leaves, options)
    if options.log:
        near &= (place > 0) & (values > 0)
    if not near.any():
        raise ResultError(f"{result.path}: there is nothing to show on this line")
    order = np.flatnonzero(near)[np.lexsort((across[near], place[near]))]
    side = sides_of(block, across, options)
    place, values, side = (item[order] for item in (place, values, side))
    if not options.nodes:
        began = (block.points - block.point_fields["displacement"][:, :2])[order]
        place, values, side = means(place, values, side, began, CLOSE * leaves.width.min(), segments_of(result.cracks(number)))
    return Profile(name, result.times[number], place, values, side)


def means(place: Array, values: Array, side: Array, began: Array, close: float, segments: Array) -> tuple[Array, Array, Array]:
    """One value a place, in ascending order: the mean of those that are closer, and of either side where a crack runs between them, whose
    places in the reference configuration are `began`."""
    group = np.concatenate([[0], np.cumsum(np.diff(place) > close)])
    on = {sign: side == sign for sign in (1, -1)}
    middle = {sign: mean(began[of].T, group[of], group[-1] + 1).T for sign, of in on.items()}
    both = np.isfinite(middle[1] + middle[-1]).all(axis=1)
    torn = np.zeros(len(both), dtype=bool)
    torn[both] = is_between(middle[1][both], middle[-1][both], segments)
    side = np.where(torn[group] | (np.sum(torn) > 0) & ~both[group], side, 0)
    groups = 3 * group + side.astype(int) + 1
    kept = np.unique(groups)
    found = mean(np.array([place, values]), groups, 3 * group[-1] + 3)[:, kept]
    return *found, kept % 3 - 1


def mean(rows: Any, group: Array, count: int) -> Array:
    """Means of rows over groups, shape (rows, groups); NaN of empty ones."""
    number = np.bincount(group, minlength=count)
    with np.errstate(invalid="ignore"):
        return np.array([np.bincount(group, row, count) / number for row in rows])


def on_axes(result: Frames, number: int, points: Array, options: Namespace) -> Array:
    """Places along the line and across it [m]."""
    plane: CrackPlane | None = CrackPlane(np.zeros(2), np.array([1.0, 0.0]))
    if options.from_tip:
        plane = result.crack_plane(number=number)
    if plane is None:
        raise ResultError(f"{result.path}: --from-tip needs a crack, and the scene has none")
    return plane.local(points)[:, ::1 if options.along == "x" else -1]


def reach(result: Frames, block: Block, leaves: Leaves, options: Namespace) -> Any:
    """How far from the line particles are on it: half of their share of the cell; nodes lie on it [m]."""
    if options.nodes:
        return CLOSE * leaves.width.min()
    cell = result.cells_of(block, leaves)
    share = leaves.width / np.sqrt(np.maximum(leaves.particles, 1))
    return np.where(cell >= 0, (0.5 + CLOSE) * share[cell], 0.0)


def sides_of(block: Block, across: Array, options: Namespace) -> Array:
    """The side of the line on which each particle is, or each node by the cells that it belongs to."""
    if options.at is None:
        return np.zeros(across.shape)
    if not options.nodes:
        return np.sign(across - options.at)
    beyond, before = np.zeros((2, across.size), dtype=bool)
    middle = across[block.cells].mean(axis=1)
    beyond[block.cells[middle > options.at]] = True
    before[block.cells[middle < options.at]] = True
    return beyond.astype(int) - before


def component(name: str) -> tuple[str, int] | None:
    """The vector and the number of its component that a name such as velocity_x means, or none."""
    vector, _, axis = name.rpartition("_")
    return (vector, "xy".index(axis)) if vector in VECTORS and axis in ("x", "y") else None


def particle_values(result: Frames, block: Block, leaves: Leaves, options: Namespace) -> Array:
    """The field at the particles."""
    if part := component(options.field):
        return block.point_fields[part[0]][:, part[1]]
    return ParticleField(result, options.field).values(block, leaves)


def node_values(result: Frames, block: Block, options: Namespace) -> Array:
    """The field at the nodes."""
    part, fields = component(options.field), block.point_fields
    if part and part[0] in fields:
        return fields[part[0]][:, part[1]]
    if options.field not in fields or fields[options.field].ndim > 1:
        raise ResultError(f"{result.path}: the nodes have no field '{options.field}'; they have "
                          f"{', '.join(name for name in fields if name != 'velocity')}, velocity_x, velocity_y")
    return fields[options.field]


def unit_of(result: Frames, options: Namespace) -> str:
    """Unit of the field."""
    if part := component(options.field):
        return VECTORS[part[0]]
    return NODE_UNITS.get(options.field, "1") if options.nodes else ParticleField(result, options.field).unit


def draw(profiles: Sequence[Profile], unit: str, options: Namespace) -> Figure:
    """The figure: a curve for each file and time, and the reference curve."""
    figure, axes = plt.subplots(figsize=(6.3, 4), layout="constrained")
    size, length = prefixed(max(np.abs(shown.place).max() for shown in profiles), "m")
    factor, unit = scaled(profiles, unit, options)
    if options.reference:
        place, value = read_curve(options.reference)
        axes.plot(place * size, value * factor, color="0.15", linewidth=0.9, label=options.reference_name)
    for number, shown in enumerate(profiles):
        few = np.unique(shown.place).size <= FEW
        for side, (chosen, words) in enumerate(sides(shown, options)):
            axes.plot(shown.place[chosen] * size, shown.value[chosen] * factor, color=COLOURS[number % len(COLOURS)],
                      marker="o" if few else None, markersize=3.5, markerfacecolor="white" if side else None,
                      linewidth=0.8 if side else None, linestyle=DASHES[number % len(DASHES)],
                      label=label_of(shown, profiles) + words)
    if options.log:
        axes.set(xscale="log", yscale="log")
    axes.set_xlim(*(end * size if np.isfinite(end) else None for end in (options.first, options.last)))
    axes.set_xlabel(f"distance ahead of the crack tip [{length}]" if options.from_tip and options.along == "x"
                    else f"${options.along}$ [{length}]")
    axes.set_ylabel(options.label or f"{words_of(options.field)} [{'–' if unit == '1' else typeset(unit)}]")
    if options.title:
        figure.suptitle(options.title)
    figure.set_figheight(3.7 + 0.2 * name_curves(figure, [axes]))
    return figure


def sides(shown: Profile, options: Namespace) -> list[tuple[Array, str]]:
    """Which places are on one side of the line, and in words on which; all where there is nothing on the other."""
    if not {-1, 1} <= set(shown.side):
        return [(np.full(shown.place.shape, True), "")]
    across = "$y$" if options.along == "x" else "$x$"
    if options.from_tip:
        across = "height above the crack" if options.along == "x" else "distance ahead"
    return [(shown.side >= 0, f", {across} > {options.at:.4g} m"), (shown.side <= 0, f", {across} < {options.at:.4g} m")]


def scaled(profiles: Sequence[Profile], unit: str, options: Namespace) -> tuple[float, str]:
    """Factor for the values, and the unit that they have then."""
    if options.scale:
        return 1 / options.scale, "1" if options.label else f"{options.scale:g} {unit}"
    return prefixed(max(np.abs(shown.value).max() for shown in profiles), unit)


def label_of(shown: Profile, profiles: Sequence[Profile]) -> str:
    """What tells a curve from the others: its file, its time, or both."""
    time = f"$t$ = {shown.time:.4g} s"
    one_time = len({other.time for other in profiles}) == 1
    one_file = len({other.name for other in profiles}) == 1
    return verbatim(shown.name) if one_time else time if one_file else f"{verbatim(shown.name)}, {time}"


def write_csv(profiles: Sequence[Profile]) -> None:
    """One row a place."""
    writer = csv.writer(sys.stdout)
    writer.writerow(["file", "time", "place", "value"])
    for shown in profiles:
        writer.writerows((shown.name, shown.time, *row) for row in zip(shown.place.tolist(), shown.value.tolist()))
