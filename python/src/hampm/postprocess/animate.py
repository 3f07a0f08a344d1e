"""Animation of a hampm result, all snapshots as an MP4 where there is ffmpeg, else as a GIF; or of one of its modes.

It shows what plot_field.py does, coloured by a field on one scale of colours for all snapshots, with cracks that open and grow.
The title says by how much displacements are enlarged. On a terminal the snapshots that are done are counted.
"""

from __future__ import annotations

import sys
import time
from argparse import Namespace
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from matplotlib.animation import FFMpegWriter, PillowWriter

from ..errors import UNREADABLE, ResultError
from ..scripts import Parser, tell, whole
from . import particle_pictures
from . import solid_pictures
from .frames import Frames, frames_of
from .particle_fields import ParticleField
from .particle_pictures import add_colour_bar, add_field_options, bodies_meet, colours, default_scale, extent
from .pictures import STYLE, STYLES, add_look, ending, in_style, plt, positive

MANY = 50    # snapshots from which it is told how many there are


def main(arguments: Sequence[str] | None = None) -> None:
    options = parse(arguments)
    result = frames_of(options.file, options.mode)
    if options.mode is not None:
        options.field = "displacement"
    output = Path(options.output or result.path.with_name(f"{result.stem}{'.mp4' if FFMpegWriter.isAvailable() else '.gif'}"))
    frames = -(-result.times.size // options.every)
    if frames > MANY:
        tell(f"{frames} snapshots of {result.path} ({result.path.stat().st_size / 1e6:.0f} MB) are drawn; --every {2 * options.every} draws half of them")
    plt.switch_backend("Agg")
    with plt.rc_context(STYLE | STYLES.get(options.style, {}) | {"savefig.dpi": options.dpi, "figure.dpi": options.dpi}):
        film = Film(result, options)
        in_style(lambda _: film.figure, options)
        try:
            writer = writer_of(output, options.fps)
            with writer.saving(film.figure, output, options.dpi):
                for number in counted(film.numbers):
                    film.show(number)
                    writer.grab_frame()
        except OSError as error:
            raise ResultError(f"{output}: cannot be written ({error.strerror})", UNREADABLE) from error
        finally:
            plt.close(film.figure)
    print(output)


def parse(arguments: Sequence[str] | None) -> Namespace:
    parser = Parser(__doc__)
    parser.add_argument("file", metavar="FILE.h5", help="result file with snapshots")
    add_field_options(parser)
    solid_pictures.add_solid_options(parser)
    parser.add_argument("--scale", type=positive, metavar="FACTOR",
                        help="by which displacements are enlarged (default: the largest is an eighth of the picture, but not "
                             "below 1, and 1 where bodies are apart or move against each other, so that they are "
                             "seen to touch)")
    parser.add_argument("--mode", type=int, metavar="N", help="show a period of the mode N of /modes, counted from 1, coloured by displacement")
    parser.add_argument("--every", type=whole, default=1, metavar="N", help="show each Nth snapshot (default: all)")
    parser.add_argument("--fps", type=positive, default=10, metavar="N",
                        help="snapshots shown in a second (default: %(default)g)")
    parser.add_argument("--dpi", type=positive, default=100, metavar="N", help="resolution (default: %(default)g)")
    add_look(parser)
    parser.add_argument("-o", "--output", type=ending(".gif", ".mp4"), metavar="FILE",
                        help="animation to write, .gif or .mp4 (default: the file's name with .mp4, without ffmpeg with .gif, beside it)")
    return parser.parse_args(arguments)


def writer_of(output: Path, fps: Any) -> Any:
    """What writes a film of the kind that the name of a file ends in."""
    if output.suffix == ".gif":
        return PillowWriter(fps=fps)
    if not FFMpegWriter.isAvailable():
        raise ResultError(f"{output}: an .mp4 is written by ffmpeg, which is not there (apt-get install ffmpeg); a .gif needs nothing more")
    return FFMpegWriter(fps=fps, codec="libx264", extra_args=["-pix_fmt", "yuv420p", "-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2:color=white"])


def counted(numbers: range) -> Iterator[int]:
    """These numbers, with a line on the terminal that says how many are done, and about how long the others take."""
    begin = time.monotonic()
    for done, number in enumerate(numbers, 1):
        if sys.stderr.isatty():
            left = (time.monotonic() - begin) / max(done - 1, 1) * (len(numbers) - done + 1)
            words = f", {left:.0f} s left" if 1 < done < len(numbers) else ""
            print(f"\r{f'snapshot {done} of {len(numbers)}{words}':40}", end="\n" if done == len(numbers) else "", file=sys.stderr, flush=True)
        yield number


class Film:
    """The figure and what changes in it from snapshot to snapshot; enlargement, extent and colours are the same in all."""

    def __init__(self, result: Frames, options: Namespace) -> None:
        self.result = result
        of = solid_pictures if solid_pictures.check_options([result], options) else particle_pictures
        field = ParticleField(result, options.field)
        self.numbers = every = range(0, result.times.size, options.every)
        seen = of.survey(result, field, every, options, options.scale or 1.0)
        scale = options.scale or (1.0 if bodies_meet(result) else default_scale(seen, options.window))
        if scale != (options.scale or 1.0):
            seen = of.survey(result, field, every, options, scale)
        lower, upper = extent(seen, options.window)
        size = upper - lower
        self.figure, axes = plt.subplots(figsize=(8.4, 1.5 + 6.6 * min(max(size[1] / size[0], 0.15), 1.0)),
                                         layout="compressed")
        self.canvas = of.Canvas(axes, result, field, scale, colours(field, seen, options), options)
        axes.set(xlim=(lower[0], upper[0]), ylim=(lower[1], upper[1]))
        add_colour_bar(self.figure, axes, self.canvas)
        self.title = axes.set_title(" ")

    def show(self, number: int) -> None:
        """Draw a snapshot."""
        words = self.canvas.show(number)
        self.title.set_text(getattr(self.result, "words", words))
