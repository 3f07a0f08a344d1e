#!/usr/bin/env python3
"""Animation of a hampm result: particles and mesh in all snapshots, as a GIF.

Particles stand where they are with their displacement enlarged, each as a square of its share of its cell, coloured by
a field. The mesh stands still: material moves through it. Where there is a crack, both are mirrored about its plane.
"""

import argparse
from pathlib import Path

from frames import CrackPlane, Frames, mirrored, squares
from history import UNREADABLE, ResultError, run
from plot_g import STYLE, positive, plt
from plot_mesh import MM

import numpy as np
from matplotlib.animation import PillowWriter
from matplotlib.collections import PolyCollection

DERIVED = {"speed": ("velocity", "m/s"), "displacement": ("displacement", "m")}  # magnitudes of vectors
UNITS = {"energy_density": "J/m³", "stress_xx": "Pa", "stress_yy": "Pa", "stress_xy": "Pa"}
OVERLAP = 1.12  # of the squares of neighbours: strain and rotation, enlarged too, would open gaps between them
SHARE = 0.12  # of the picture's width that the largest displacement takes by default


def main(arguments=None):
    options = parse(arguments)
    result = Frames(options.file)
    output = Path(options.output or result.path.with_name(f"{result.stem}.gif"))
    with plt.rc_context(STYLE | {"savefig.dpi": options.dpi, "figure.dpi": options.dpi}):
        film = Film(result, options)
        try:
            writer = PillowWriter(fps=options.fps)
            with writer.saving(film.figure, output, options.dpi):
                for number in range(result.times.size):
                    film.show(number)
                    writer.grab_frame()
        except OSError as error:
            raise ResultError(f"{output}: cannot be written ({error.strerror})", UNREADABLE) from error
        finally:
            plt.close(film.figure)
    print(output)


def parse(arguments):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file", metavar="FILE.h5", help="result file with snapshots")
    parser.add_argument("--field", default="energy_density", metavar="NAME",
                        help="field that colours the particles: one of the file's, speed or displacement "
                             "(default: %(default)s)")
    parser.add_argument("--scale", type=positive, metavar="FACTOR",
                        help="by which displacements are enlarged (default: the largest is an eighth of the picture)")
    parser.add_argument("--window", type=positive, metavar="MM",
                        help="half width of what is shown around the crack tip [mm] (default: everything)")
    parser.add_argument("--fps", type=positive, default=10, metavar="N",
                        help="snapshots shown in a second (default: %(default)g)")
    parser.add_argument("--dpi", type=positive, default=100, metavar="N", help="resolution (default: %(default)g)")
    parser.add_argument("-o", "--output", type=gif, metavar="FILE.gif",
                        help="animation to write (default: the file's name with .gif, beside it)")
    return parser.parse_args(arguments)


def gif(text):
    if Path(text).suffix != ".gif":
        raise argparse.ArgumentTypeError(f"{text} does not end in .gif")
    return text


class Film:
    """The figure and what changes in it from snapshot to snapshot."""

    def __init__(self, result, options):
        self.result, self.field = result, options.field
        self.plane = result.crack_plane()
        self.has_crack = self.plane is not None
        if options.window and not self.has_crack:
            raise ResultError(f"{result.path}: --window stands around a crack tip, and the scene has no crack")
        if not self.has_crack:
            self.plane = CrackPlane(np.zeros(2), np.array([1.0, 0.0]))
        self.scale, (lower, upper), limits = self._survey(options)
        size = upper - lower
        self.figure, axes = plt.subplots(figsize=(8.4, 1.5 + 6.6 * min(max(size[1] / size[0], 0.15), 1.0)),
                                         layout="compressed")
        self.squares = axes.add_collection(PolyCollection([], cmap="RdYlBu_r" if limits[0] < 0 else "YlOrRd",
                                                          edgecolors="none", antialiased=False))
        self.mesh = axes.add_collection(PolyCollection([], facecolors="none", edgecolors=(0, 0, 0, 0.3),
                                                       linewidths=0.5))
        self.squares.set_clim(*limits)
        axes.set(xlim=(lower[0], upper[0]), ylim=(lower[1], upper[1]), aspect="equal")
        axes.set_xlabel("distance ahead of the crack tip [mm]" if self.has_crack else "$x$ [mm]")
        axes.set_ylabel("height [mm]" if self.has_crack else "$y$ [mm]")
        axes.grid(False)
        self.figure.colorbar(self.squares, extend="max" if limits[0] == 0 else "both", extendfrac=0.03, pad=0.02,
                             label=f"{self.field.replace('_', ' ')} [{unit_of(self.field)}]")
        self.title = axes.set_title(" ")

    def show(self, number):
        """Draw a snapshot."""
        leaves, particles = self.result.leaves(number), self.result.block("particles", number)
        positions, width = self._positions(particles), OVERLAP * self._width(leaves, particles)
        values = self._values(particles)
        shapes = squares(positions - width[:, None] / 2, width)
        self.mesh.set_verts(self._both(self.plane.local(squares(leaves.lower, leaves.width)) * MM))
        self.squares.set_verts(self._both(shapes))
        image = -values if self.field == "stress_xy" else values
        self.squares.set_array(np.concatenate([values, image]) if self.has_crack else values)
        factor = f"{self.scale:,g}".replace(",", " ")
        self.title.set_text(f"$t$ = {self.result.times[number] * 1e3:.3f} ms, {len(values)} particles, "
                            f"displacements × {factor}")

    def _survey(self, options):
        """Enlargement, what is shown [mm] and the range of colours, the same in all snapshots."""
        largest, values, corners = 0.0, [], []
        for number in range(self.result.times.size):
            particles = self.result.block("particles", number)
            places = self.plane.local(particles.points) * MM
            shown = np.abs(places).max(axis=1) < (options.window or np.inf)
            moved = np.linalg.norm(particles.point_fields["displacement"][shown, :2], axis=1)
            largest = max(largest, moved.max(initial=0.0) * MM)
            values.append(self._values(particles)[shown])
            corners += [places.min(axis=0), places.max(axis=0)]
        lower, upper = np.min(corners, axis=0), np.max(corners, axis=0)
        if self.has_crack:
            upper[1] = np.abs([lower[1], upper[1]]).max()
            lower[1] = -upper[1]
        width = 2 * options.window if options.window else upper[0] - lower[0]
        self.scale = options.scale or (round_off(SHARE * width / largest) if largest > 0 else 1.0)
        margin = 0.02 * width + self.scale * largest
        if options.window:
            lower, upper = np.full(2, -options.window), np.full(2, options.window)
        else:
            lower, upper = lower - [0.02 * width, margin], upper + [0.02 * width, margin]
        values = np.concatenate(values)
        top = np.percentile(np.abs(values), 99.5) if values.size else 0.0
        top = top if top > 0 else 1.0
        return self.scale, (lower, upper), (-top if values.size and values.min() < 0 else 0.0, top)

    def _positions(self, particles):
        """Positions with enlarged displacement, in the coordinates of the crack plane [mm]."""
        enlarged = particles.points + (self.scale - 1) * particles.point_fields["displacement"][:, :2]
        return self.plane.local(enlarged) * MM

    def _width(self, leaves, particles):
        """Size of the square of each particle: the particles of a cell share its area [mm]."""
        cell = leaves.at(particles.points)
        number = np.bincount(cell[cell >= 0], minlength=leaves.width.size)
        width = leaves.width / np.sqrt(np.maximum(number, 4)) * MM  # a cell at the edge is not full
        return np.where(cell >= 0, width[cell], 0.0)

    def _values(self, particles):
        """The field at the particles."""
        fields = particles.point_fields
        if self.field in DERIVED:
            return np.linalg.norm(fields[DERIVED[self.field][0]], axis=1)
        scalars = [name for name, values in fields.items() if values.ndim == 1]
        if self.field not in scalars:
            raise ResultError(f"{self.result.path}: the particles have no field '{self.field}'; "
                              f"they have {', '.join([*scalars, *DERIVED])}")
        return fields[self.field]

    def _both(self, shapes):
        """Shapes and, where there is a crack, their mirror images."""
        return mirrored(shapes) if self.has_crack else shapes


def unit_of(field):
    """Unit of a field, 1 where none is known."""
    return DERIVED[field][1] if field in DERIVED else UNITS.get(field, "1")


def round_off(value):
    """The largest of 1, 2, 5 times a power of ten that is not above a value."""
    power = 10.0 ** np.floor(np.log10(value))
    return power * max(factor for factor in (1, 2, 5) if factor * power <= value * (1 + 1e-12))


if __name__ == "__main__":
    run(main)
