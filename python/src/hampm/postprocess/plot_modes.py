"""Picture of the modes of a run with &method time = 'modal': a panel for each, at its largest displacement, with its frequency."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from . import particle_pictures, plot_field, solid_pictures
from .frames import OfMode, frames_of
from .particle_fields import ParticleField
from .pictures import picture_parser, positive, write


def main(arguments: Sequence[str] | None = None) -> None:
    write(figure, parse(arguments), "_modes")


def figure(options: Namespace) -> Figure:
    """The picture that these options ask for."""
    results: list[Any] = [frames_of(options.files[0], number) for number in options.modes]
    of = solid_pictures if solid_pictures.check_options(results, options) else particle_pictures
    seen = [of.survey(result, ParticleField(result, options.field), options.snapshot, options) for result in results]
    for result, own in zip(results, seen):      # one size of the largest displacement: that of a mode is any
        result.enlarge(np.max([one.moved for one in seen]) / own.moved if own.moved > 0 else 1.0)
    options.scale = options.scale or particle_pictures.default_scale(particle_pictures.joined(seen), options.window)
    return plot_field.draw(results, options)


def parse(arguments: Sequence[str] | None) -> Namespace:
    parser = picture_parser(__doc__, "_modes", "result file with modes and snapshots", nargs=1)
    parser.add_argument("--modes", type=lambda text: [int(word) for word in text.split(",")], default=[1, 2, 3, 4], metavar="N,...",
                        help="their numbers, counted from 1 (default: 1,2,3,4)")
    parser.add_argument("--scale", type=positive, metavar="FACTOR", help="by which displacements are enlarged (default: what suits the picture)")
    parser.add_argument("--width", type=positive, metavar="INCH", help="width of the picture (default: what suits it)")
    particle_pictures.add_field_options(parser, "displacement")
    solid_pictures.add_solid_options(parser)
    parser.set_defaults(time=None, snapshot=[OfMode.FRAMES // 4], pyvista=False)
    return parser.parse_args(arguments)
