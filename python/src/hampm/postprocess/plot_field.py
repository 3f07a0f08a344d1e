"""Picture of the particles of snapshots coloured by a field, with the mesh and the crack: a panel for each file and time.

Fields are those of the file (stress_xx, stress_yy, stress_xy, energy_density, ...) and speed, displacement, level (of the
particle's cell), mean_stress (a third of the trace) and von_mises. All panels share one scale of colours. Each face of a crack moves
with the particles beside it: with --scale cracks open. Where a crack lies on a plane of symmetry, both halves are shown.

Of a solid the surface is shown, in a parallel projection, or what a plane across an axis cuts (--slice), without --window, --axes, --tip and --squares.
"""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from ..arrays import Array
from ..errors import ResultError
from . import particle_pictures
from . import solid_pictures
from .frames import Frames, frames_of
from .particle_fields import ParticleField
from .particle_pictures import FLAT, add_colour_bar, add_field_options, colours, extent, is_in_scene, joined
from .pictures import picture_names, picture_parser, plt, positive, write

TALLEST = 6.5  # height of a panel [inch]
TALL = 0.75    # the same of a picture whose width is given, over that
LOWEST = 1.3   # of a panel with its label


def main(arguments: Sequence[str] | None = None) -> Any:
    options = parse(arguments)
    if options.pyvista:
        results = [frames_of(path) for path in options.files]
        if solid_pictures.check_options(results, options):
            by_pyvista(results, options)
            return
    write(figure, options, f"_{options.field}")


def figure(options: Namespace) -> Figure:
    """The picture that these options ask for."""
    return draw([frames_of(path) for path in options.files], options)


def by_pyvista(results: Sequence[Any], options: Namespace) -> None:
    """The picture of one solid at one time by PyVista."""
    views = [(result, number) for result in results for number in numbers(result, options)]
    output = Path(options.output or results[0].path.with_name(f"{results[0].path.stem}_{options.field}.png"))
    if len(views) > 1 or output.suffix != ".png":
        raise ResultError("--pyvista draws one file and snapshot, as a .png")
    (result, number), = views
    solid_pictures.write_with_pyvista(result, ParticleField(result, options.field), number, options, output)


def parse(arguments: Sequence[str] | None) -> Namespace:
    parser = picture_parser(__doc__, "_<field>", "result file with snapshots")
    add_field_options(parser)
    solid_pictures.add_solid_options(parser)
    parser.add_argument("--pyvista", action="store_true", help="of a solid: let PyVista draw, one file and snapshot as a .png")
    which = parser.add_mutually_exclusive_group()
    which.add_argument("--time", type=float, action="append", metavar="S",
                       help="show the snapshot nearest to this time [s]; may be repeated")
    which.add_argument("--snapshot", type=int, action="append", metavar="N",
                       help="show this snapshot, counted from 0, or with a minus sign from the end; may be repeated "
                            "(default: the last)")
    parser.add_argument("--scale", type=positive, default=1.0, metavar="FACTOR",
                        help="by which displacements are enlarged (default: %(default)g)")
    parser.add_argument("--width", type=positive, metavar="INCH", help="width of the picture (default: what suits it)")
    return parser.parse_args(arguments)


def draw(results: Sequence[Frames], options: Namespace) -> Figure:
    """The figure: a panel for each file and time."""
    views = [(result, number) for result in results for number in numbers(result, options)]
    fields = {result: ParticleField(result, options.field) for result in results}
    of = solid_pictures if solid_pictures.check_options(results, options) else particle_pictures
    surveys = [of.survey(result, fields[result], [number], options, options.scale) for result, number in views]
    seen = joined(surveys)
    shades = colours(fields[results[0]], seen, options)
    of_scene = {is_in_scene(result, options) for result in results}
    apart = True in of_scene or any(result.has_crack_lines for result in results)  # tips may be at different places
    is_shared = len(of_scene) == 1 and not (options.window and apart)
    lower, upper = extent(seen, options.window)
    figure, axes = panels(len(views), upper - lower, is_shared, options.width or options.size and options.size[0])
    stems = dict(zip(results, picture_names(results)))
    for panel, (result, number), own in zip(axes, views, surveys):
        canvas = of.Canvas(panel, result, fields[result], options.scale, shades, options)
        words = canvas.show(number)
        if not options.window:
            lower, upper = extent(seen if is_shared else own, options.window)
            panel.set(xlim=(lower[0], upper[0]), ylim=(lower[1], upper[1]))
        words = getattr(result, "words", words)     # of a mode
        panel.set_title("\n".join([stems[result], *words.split(", ")]) if len({one.path for one in results}) > 1 else words)  # panels may be narrow
        if is_shared:
            panel.label_outer()
    add_colour_bar(figure, axes, canvas)
    if options.title:
        figure.suptitle(options.title)
    return figure


def numbers(result: Frames, options: Namespace) -> list[int]:
    """Numbers of the snapshots to show."""
    if options.time:
        return [result.number(time=time) for time in options.time]
    return [result.number(snapshot) for snapshot in options.snapshot or [-1]]


def panels(count: int, size: Array, is_shared: bool, whole: float | None = None) -> tuple[Figure, Any]:
    """A figure with so many panels of this shape, which may share their axes: below each other where they are flat, else up to
    three in a row. As wide as the whole is to be [inch]."""
    across = 1 if size[1] < 0.5 * size[0] else min(count, 3)
    rows = -(-count // across)
    below, beside = (0.9, 0.0) if size[1] < FLAT * size[0] else (0.0, 1.4)   # room for the scale of colours
    widest, tallest = ((whole - beside) / across, TALL * whole) if whole else ({1: 7.0, 2: 4.4, 3: 3.6}[across], TALLEST)
    width = min(widest, tallest * size[0] / size[1])
    height = max(width * size[1] / size[0], LOWEST) + 0.4
    figure, axes = plt.subplots(rows, across, figsize=(width * across + beside, height * rows + 0.4 + below), squeeze=False,
                                sharex=is_shared, sharey=is_shared, layout="compressed")
    for axis in axes.flat:
        axis.yaxis.set_major_locator(MaxNLocator(max(1, min(9, round(3 * width * size[1] / size[0])))))
    for axis in axes.flat[count:]:
        axis.set_visible(False)
    return figure, axes.flat[:count]
