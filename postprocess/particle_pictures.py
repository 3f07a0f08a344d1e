"""Particles coloured by a field, on the mesh: what still and moving pictures of snapshots share.

Particles stand where they are with their displacement enlarged, each as a square of its share of its cell, coloured by
a field. The mesh stands still: material moves through it. Where a crack lies on a plane of symmetry, both are mirrored about it;
lengths are in mm, from the tip of the crack where there is one, or with --axes scene as in the scene. Components of stress are
those along the axes of the scene.
"""

from collections import namedtuple

import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.colors import BoundaryNorm, LogNorm, Normalize

from frames import CrackPlane, squares
from history import ResultError
from pictures import MM, positive, prefixed, round_off

OVERLAP = 1.12  # of the squares of neighbours: strain and rotation, enlarged too, would open gaps between them
SHARE = 0.12    # of the picture's width that the largest displacement takes where no scale is given
DECADES = 4     # that a logarithmic scale of colours reaches down at most

Survey = namedtuple("Survey", "moved values lower upper tip")
Survey.__doc__ = "Largest displacement [mm] and values of the field that are shown, corners of the material and crack tip [mm]."
Colours = namedtuple("Colours", "norm map factor unit extend")
Colours.__doc__ = "Scale of colours for a field times a factor, which has the unit, and on which side values lie beyond it."


def add_field_options(parser):
    """Options of every picture of particles."""
    parser.add_argument("--field", default="energy_density", metavar="NAME",
                        help="field that colours the particles: one of the file's, speed, displacement, level, mean_stress or "
                             "von_mises (default: %(default)s)")
    parser.add_argument("--log", action="store_true", help="logarithmic scale of colours, for fields without a sign")
    parser.add_argument("--size", type=positive, default=OVERLAP, metavar="PART",
                        help="side of the square of a particle, over that of its share of the cell (default: %(default)g, without gaps)")
    parser.add_argument("--window", type=positive, metavar="MM",
                        help="half width of what is shown around the crack tip [mm] (default: everything)")
    add_axes_option(parser)


def add_axes_option(parser):
    """The coordinates of a picture."""
    parser.add_argument("--axes", choices=["crack", "scene"], default="crack",
                        help="coordinates of the picture: along the crack from its tip and normal to it, as if it came from "
                             "the left, or those of the scene (default: %(default)s)")


def survey(result, field, numbers, options):
    """What some snapshots of a result show."""
    plane, moved, values, corners = plane_of(result, options), 0.0, [], []
    tip = plane.tip * MM
    for number in numbers:
        particles = result.block("particles", number)
        places = plane.local(particles.points) * MM
        shown = np.abs(places - tip).max(axis=1) < (options.window or np.inf)
        moved = max(moved, np.linalg.norm(particles.point_fields["displacement"][shown, :2], axis=1).max(initial=0.0) * MM)
        values.append(field.values(particles, result.leaves(number))[shown])
        corners += [places.min(axis=0), places.max(axis=0)]
    corners = plane.whole(np.array(corners), MM)
    return Survey(moved, np.concatenate(values), corners.min(axis=0), corners.max(axis=0), tip)


def joined(surveys):
    """What all of some surveys show together."""
    moved, values, lower, upper, tips = zip(*surveys)
    return Survey(max(moved), np.concatenate(values), np.min(lower, axis=0), np.max(upper, axis=0), tips[0])


def plane_of(result, options):
    """The plane of the crack in the coordinates asked for; the scene's where it has none, and then no window around a tip."""
    plane = result.crack_plane()
    if plane is None and options.window:
        raise ResultError(f"{result.path}: --window stands around a crack tip, and the scene has no crack")
    plane = plane or CrackPlane(np.zeros(2), np.array([1.0, 0.0]), of_scene=True)
    return plane.in_scene() if options.axes == "scene" else plane


def crack_ends(plane, lower, upper):
    """The tip of the crack, and its other tip or where it meets the edge of the material, whose corners are given [mm]."""
    tip, edges = plane.tip * MM, np.where(plane.along > 0, lower, upper)
    to_edge = min((tip[k] - edges[k]) / plane.along[k] for k in range(2) if plane.along[k])
    return np.array([tip, tip - (plane.length * MM or to_edge) * plane.along])


def axis_labels(plane):
    """What the coordinates of a picture are."""
    along_crack = "distance ahead of the crack tip [mm]", "height above the crack [mm]"
    return ("$x$ [mm]", "$y$ [mm]") if plane.of_scene else along_crack


def default_scale(seen, window):
    """Enlargement of displacements by which the largest is a part of the picture; they are not made smaller."""
    width = 2 * window if window else seen.upper[0] - seen.lower[0]
    return max(1.0, round_off(SHARE * width / seen.moved)) if seen.moved > 0 else 1.0


def bodies_meet(result):
    """Whether bodies may come to touch: in the first snapshot they are apart by a cell or more, or move with different velocities.
    With displacements enlarged they would overlap, or be seen apart where they touch."""
    first, cell = result.block("particles", 0), result.scene.numbers("grid", "cell")[0]
    places, body = first.points - first.point_fields["displacement"][:, :2], first.point_fields["body"]
    parts = [body == number for number in np.unique(body)]
    lower, upper = (np.array([extreme(places[part], axis=0) for part in parts]) for extreme in (np.min, np.max))
    velocity = np.array([first.point_fields["velocity"][part].mean(axis=0) for part in parts])
    joined_to, others = [0], set(range(1, len(parts)))
    for k in joined_to:
        near = {i for i in others if np.all(lower[i] < upper[k] + cell) and np.all(lower[k] < upper[i] + cell)
                and np.allclose(velocity[i], velocity[k], rtol=1e-6, atol=1e-12)}
        joined_to += near
        others -= near
    return bool(others)


def extent(seen, window, scale):
    """Corners of what is shown [mm]."""
    if window:
        return seen.tip - window, seen.tip + window
    width = seen.upper[0] - seen.lower[0]
    margin = np.array([0.02 * width, 0.02 * width + (scale if scale != 1 else 0) * seen.moved])
    return seen.lower - margin, seen.upper + margin


def colours(field, values, log=False):
    """The scale of colours for a field: levels one by one, else linear or logarithmic, up to all but the largest values."""
    if field.name == "level":
        edges = np.arange(values.max(initial=0) + 2) - 0.5
        return Colours(BoundaryNorm(edges, 256), "YlGnBu", 1.0, "1", "neither")
    top = np.percentile(np.abs(values), 99.5) if values.size else 0.0
    top = top if top > 0 else 1.0
    factor, unit = prefixed(top, field.unit)
    is_signed = values.size > 0 and values.min() < 0
    if log:
        if is_signed:
            raise ResultError(f"{field.result.path}: --log is for fields without a sign; {field.name} has values below zero")
        bottom = max(values[values > 0].min(initial=top), top / 10**DECADES)
        return Colours(LogNorm(factor * min(bottom, top / 10), factor * top), "YlOrRd", factor, unit, "both")
    if is_signed:
        return Colours(Normalize(-factor * top, factor * top), "RdYlBu_r", factor, unit, "both")
    return Colours(Normalize(0.0, factor * top), "YlOrRd", factor, unit, "max")


class Canvas:
    """Axes with the particles and the mesh of one result, which `show` draws."""

    def __init__(self, axes, result, field, scale, shades, options):
        self.result, self.field, self.scale, self.shades, self.size = result, field, scale, shades, options.size
        self.plane = plane_of(result, options)
        self.squares = axes.add_collection(PolyCollection([], cmap=shades.map, norm=shades.norm, edgecolors="none",
                                                          antialiased=False))
        self.mesh = axes.add_collection(PolyCollection([], facecolors="none", edgecolors=(0, 0, 0, 0.3), linewidths=0.5))
        across, up = axis_labels(self.plane)
        axes.set(xlabel=across, ylabel=up)
        axes.set_aspect("equal")
        axes.grid(False)

    def show(self, number):
        """Draw a snapshot. Returns what it shows, in words."""
        leaves, particles = self.result.leaves(number), self.result.block("particles", number)
        positions, width = self._positions(particles), self.size * self._width(leaves, particles)
        values = self.shades.factor * self.field.values(particles, leaves)
        self.mesh.set_verts(self.plane.whole(self.plane.local(squares(leaves.lower, leaves.width)) * MM, MM))
        self.squares.set_verts(self.plane.whole(squares(positions - width[:, None] / 2, width), MM))
        images = [-values if self.field.is_odd else values] if self.plane.is_symmetry else []
        self.squares.set_array(np.concatenate([values, *images]))
        words = f"$t$ = {self.result.times[number] * 1e3:.3f} ms, {len(values)} particles"
        factor = f"{self.scale:,g}".replace(",", " ")
        return words if self.scale == 1 else f"{words}, displacements × {factor}"

    def _positions(self, particles):
        """Positions with enlarged displacement, in the coordinates of the picture [mm]."""
        enlarged = particles.points + (self.scale - 1) * particles.point_fields["displacement"][:, :2]
        return self.plane.local(enlarged) * MM

    def _width(self, leaves, particles):
        """Size of the square of each particle: the particles of a cell share its area [mm]."""
        cell = leaves.at(particles.points)
        number = np.bincount(cell[cell >= 0], minlength=leaves.width.size)
        width = leaves.width / np.sqrt(np.maximum(number, 4)) * MM  # a cell at the edge is not full
        return np.where(cell >= 0, width[cell], 0.0)


def add_colour_bar(figure, axes, canvas):
    """The scale of colours, with name and unit of the field, beside some axes."""
    shades = canvas.shades
    bar = figure.colorbar(canvas.squares, ax=axes, extend=shades.extend, extendfrac=0.03, pad=0.02,
                          label=f"{canvas.field.words} [{'–' if shades.unit == '1' else shades.unit}]")
    if canvas.field.name == "level":
        bar.set_ticks(range(round(shades.norm.vmax + 0.5)))
        bar.minorticks_off()
    return bar
