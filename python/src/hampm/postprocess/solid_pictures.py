"""Pictures of solids: their surface in a parallel projection, or what a plane across an axis cuts, coloured by a field of the particles.

The surface is made of the sides of particles that no other covers, drawn from back to front, in the light of one lamp. Where a constraint
makes a model of one half, `--mirror` adds the image in its plane. Lengths are in mm, in the coordinates of the scene.
"""

from __future__ import annotations

import argparse
import re
from argparse import ArgumentParser, Namespace
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import PolyCollection
from matplotlib.colors import BoundaryNorm
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke
from matplotlib.transforms import ScaledTranslation

from ..arrays import Array
from ..errors import ResultError
from .particle_fields import ParticleField
from .particle_pictures import Colours, Survey, colours, time_words
from .pictures import COLOURS, MM, verbatim
from .solid_frames import CORNERS, Cubes, SolidFrames

NAMES = "xyz"
LAMP = np.array([0.35, 0.8, 0.5])       # where it is: to the right, above and towards the viewer
SHADE = 0.25                            # what of the colour a side that is turned away from it loses
PALE = 150                              # of 256 colours: lines are seen on them
EDGE = {"linewidths": 0.35, "edgecolors": (0, 0, 0, 0.45)}
NEAREST = 8                             # particles whose mean displacement is that of a node of a front
ARROW, MARGIN, CORNER = 24, 8, 0.2      # length of the arrows of the axes, how far they are from the edges [points], and the part of the picture they take
HALO = [withStroke(linewidth=3.2, foreground="white")]
OF_PLANES = {"window": None, "axes": None, "tip": 1, "squares": None}   # options of pictures of planes, and what they are where not given
OF_SOLIDS: dict[str, Any] = {"slice": None, "view": None, "up": None, "mirror": [], "ligament": None, "pyvista": False}


def add_solid_options(parser: ArgumentParser) -> None:
    """Options of pictures of solids."""
    parser.add_argument("--slice", type=plane, metavar="AXIS=M", help="of a solid: what a plane across an axis cuts, such as y=0.005 (default: its surface)")
    parser.add_argument("--view", type=angles, metavar="AZIMUTH,ELEVATION",
                        help="of a solid: from where it is seen, around the axis that is up and above the plane across it [deg] (default: --view=-50,28)")
    parser.add_argument("--up", choices=NAMES, help="of a solid: the axis that is up (default: z)")
    parser.add_argument("--mirror", type=plane, action="append", default=[], metavar="AXIS=M",
                        help="of a solid: add its image in this plane, such as y=0; may be repeated")
    parser.add_argument("--ligament", metavar="NAME", help="of a solid: draw the edge of this &constraint as the front of the crack beside it")


def plane(text: str) -> tuple[int, float]:
    """An axis and a place on it [m]."""
    found: Any = re.fullmatch(r"([xyz])=(.+)", text)
    try:
        return NAMES.index(found[1]), float(found[2])
    except (TypeError, ValueError):
        raise argparse.ArgumentTypeError(f"{text} is no plane across an axis, such as y=0.005") from None


def angles(text: str) -> tuple[float, float]:
    try:
        azimuth, elevation = map(float, text.split(","))
        return azimuth, elevation
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text} is not two angles, such as -50,28") from None


def check_options(results: Sequence[Any], options: Namespace) -> bool:
    """Refuse options that are those of other models. Returns whether the results are of solids."""
    kinds = {result.is_for_solids for result in results}
    if len(kinds) > 1:
        raise ResultError("results of planes and of solids are not drawn in one picture")
    solid = kinds.pop()
    for name, default in (OF_PLANES if solid else OF_SOLIDS).items():
        if getattr(options, name, default) != default:
            raise ResultError(f"{results[0].path}: --{name} is for pictures of {'planes; those of solids have --slice, --view and --mirror' if solid else 'solids'}")
    return solid


class View:
    """How places in space become places in a picture: along its axes and towards the viewer, (3, 3)."""

    def __init__(self, options: Namespace) -> None:
        self.slice, self.mirrors, self.ligament = options.slice, options.mirror, options.ligament
        if self.slice:
            self.axes = [d for d in range(3) if d != self.slice[0]]
            self.turn = np.eye(3)[[*self.axes, self.slice[0]]]
            return
        azimuth, elevation = np.radians(options.view or (-50.0, 28.0))
        up = NAMES.index(options.up or "z")
        x, y, z = np.eye(3)[[(up + 1) % 3, (up + 2) % 3, up]]
        around = np.cos(azimuth) * x + np.sin(azimuth) * y
        towards = np.cos(elevation) * around + np.sin(elevation) * z
        right = np.cos(azimuth) * y - np.sin(azimuth) * x
        self.turn = np.array([right, np.cross(towards, right), towards])

    def of(self, points: Array) -> Array:
        """Places in the picture, and how near they are."""
        return points @ self.turn.T

    def whole(self, polygons: Array, values: Array, is_odd: Callable[[int], bool]) -> tuple[Array, Array]:
        """Polygons (n, k, 3) with values and their images. `is_odd` tells for an axis whether an image has the other sign."""
        for axis, place in self.mirrors:
            images = polygons[:, ::-1].copy()
            images[..., axis] = 2 * place - images[..., axis]
            polygons, values = np.concatenate([polygons, images]), np.concatenate([values, -values if is_odd(axis) else values])
        return polygons, values


def particle_polygons(result: SolidFrames, field: ParticleField, number: int, view: View, scale: float) -> tuple[Array, Array]:
    """The polygons of a snapshot [m], and their values."""
    cubes, particles = result.cubes(number), result.block("particles", number)
    displacement = particles.point_fields["displacement"][:, :3]
    gradient = particles.point_fields["deformation_gradient"].reshape(-1, 3, 3) - np.eye(3)
    values = field.values(particles, result.leaves(number))
    chosen, corners, part = polygons_of(cubes, view)
    moved = cubes.moved(corners, chosen, displacement, gradient)
    return view.whole(part(cubes.places(corners) + scale * moved), values[chosen], field.is_odd_across)


def polygons_of(cubes: Cubes, view: View) -> tuple[Array, Array, Callable[[Array], Array]]:
    """Numbers of the cubes that are drawn, their corners, and what makes polygons of these: sides, or cuts by a plane."""
    if view.slice is None:
        chosen, axis, side = cubes.exposed()
        return chosen, cubes.sides(chosen, axis, side), lambda places: places
    axis, at = view.slice
    chosen = cubes.cut(axis, at)
    if not chosen.size:
        raise ResultError(f"the plane {NAMES[axis]} = {at:g} m cuts no material; it is between "
                          f"{cubes.places(cubes.corner)[:, axis].min():g} and {cubes.places(cubes.corner + cubes.size[:, None])[:, axis].max():g} m")
    corners = cubes.corner[chosen, None] + CORNERS * cubes.size[chosen, None, None]
    weight = np.clip(((at - cubes.origin[axis]) / cubes.unit - cubes.corner[chosen, axis]) / cubes.size[chosen], 0, 1)[:, None, None]

    def part(places: Array) -> Array:
        low, high = (places[:, [k for k in range(8) if CORNERS[k, axis] == side]] for side in (0, 1))
        return ((1 - weight) * low + weight * high)[:, [0, 1, 3, 2]]
    return chosen, corners, part


def draw_mesh(results: Sequence[Any], options: Namespace, panels: Callable[..., Any]) -> Figure:
    """The figure of the cells that hold material, coloured by how often they have been divided: their surface, or a slice."""
    view, shown = View(options), []
    for result in results:
        number = result.number(options.snapshot, options.time)
        shown.append((result, number, *cell_polygons(result, number, view)))
    places = np.concatenate([view.of(polygons.reshape(-1, 3))[:, :2] for *_, polygons, _ in shown]) * MM
    lower, upper = places.min(axis=0), places.max(axis=0)
    margin = 0.02 * (upper - lower).max()
    figure, axes = panels(len(shown), upper - lower, True)
    deepest = max(level.max() for *_, level in shown)
    shades = ScalarMappable(BoundaryNorm(np.arange(deepest + 2) - 0.5, PALE), "YlGnBu")
    for panel, (result, number, polygons, level) in zip(axes, shown):
        prepare(panel, view)
        draw_polygons(panel, view, polygons, shades.to_rgba(level), **EDGE)
        draw_fronts(panel, result, number, view, 0.0)
        counts = result.leaves(number)
        counts = np.unique(counts.level[counts.particles > 0], return_counts=True)
        panel.set_title("\n".join([verbatim(result.stem), slice_words(view, time_words(result, number)),
                                   ", ".join(f"{count} of level {of}" for of, count in zip(*counts))]), fontsize="medium")
        panel.set(xlim=(lower[0] - margin, upper[0] + margin), ylim=(lower[1] - margin, upper[1] + margin))
        panel.label_outer()
    if options.title:
        figure.suptitle(options.title)
    return figure


def slice_words(view: View, words: str) -> str:
    """What is shown when, in words."""
    return words if view.slice is None else f"{words}, ${NAMES[view.slice[0]]}$ = {view.slice[1] * MM:g} mm"


def survey(result: SolidFrames, field: ParticleField, numbers: Iterable[int], options: Namespace, scale: float = 1.0) -> Survey:
    """What some snapshots show, with displacements enlarged."""
    view, moved, values, corners = View(options), 0.0, [], []
    for number in numbers:
        polygons, own = particle_polygons(result, field, number, view, scale)
        displacement = result.block("particles", number).point_fields["displacement"]
        moved = max(moved, np.linalg.norm(displacement, axis=1).max(initial=0.0) * MM)
        values.append(own)
        places = view.of(polygons.reshape(-1, 3))[:, :2] * MM
        corners += [places.min(axis=0), places.max(axis=0)]
    return Survey(moved, np.concatenate(values), np.ones(sum(map(len, values))), np.min(corners, axis=0), np.max(corners, axis=0), np.zeros(2))


class Canvas:
    """Axes with the surface or a slice of one result, which `show` draws."""

    def __init__(self, axes: Axes, result: SolidFrames, field: ParticleField, scale: float, shades: Colours, options: Namespace) -> None:
        self.axes, self.result, self.field, self.scale, self.shades = axes, result, field, scale, shades
        self.view, self.mesh = View(options), options.mesh
        self.colours = ScalarMappable(shades.norm, shades.map)
        prepare(axes, self.view)

    def show(self, number: int) -> str:
        """Draw a snapshot. Returns what it shows, in words."""
        for drawn in [*self.axes.collections, *self.axes.lines]:
            drawn.remove()
        polygons, values = particle_polygons(self.result, self.field, number, self.view, self.scale)
        draw_polygons(self.axes, self.view, polygons, self.colours.to_rgba(self.shades.factor * values))
        if self.mesh and self.view.slice:
            cells = cell_polygons(self.result, number, self.view)[0]
            seen: Any = self.view.of(cells)[..., :2] * MM
            self.axes.add_collection(PolyCollection(seen, facecolors="none", edgecolors=(0, 0, 0, 0.3), linewidths=0.5))
        draw_fronts(self.axes, self.result, number, self.view, self.scale)
        words, factor = slice_words(self.view, time_words(self.result, number)), f"{self.scale:,g}".replace(",", "\u2009")
        return words if self.scale == 1 else f"{words}, displacements × {factor}"


def prepare(axes: Axes, view: View) -> None:
    """The coordinates of a slice, or arrows for those of space."""
    axes.set_aspect("equal")
    axes.grid(False)
    if view.slice:
        axes.set(**{f"{name}label": f"${NAMES[d]}$ [mm]" for name, d in zip("xy", view.axes)})
        return
    axes.set_axis_off()


def draw_axes(axes: Axes, view: View, places: Array) -> None:
    """Arrows along the axes of space, in the corner of a picture that has the least of these places in it."""
    part = (places - places.min(axis=0)) / np.ptp(places, axis=0)
    corner = min(np.array([[0, 0], [1, 0], [0, 1], [1, 1]]), key=lambda corner: np.count_nonzero(np.all(np.abs(part - corner) < CORNER, axis=1)))
    ends = ARROW * view.turn[:2].T
    low, high = np.minimum(0, ends.min(axis=0)), np.maximum(0, ends.max(axis=0))
    start = np.where(corner, -MARGIN - high, MARGIN - low)

    def at(place: Array) -> Any:
        return axes.transAxes + ScaledTranslation(place[0] / 72, place[1] / 72, axes.figure.dpi_scale_trans)
    for name, end in zip(NAMES, ends):
        axes.annotate("", xy=corner, xytext=corner, xycoords=at(start + end), textcoords=at(start),
                      arrowprops={"arrowstyle": "->", "linewidth": 0.9, "shrinkA": 0, "shrinkB": 0})
        axes.text(corner[0], corner[1], f"${name}$", transform=at(start + 1.3 * end), ha="center", va="center", fontsize=9)


def draw_polygons(axes: Axes, view: View, polygons: Array, colours: Array, **edges: Any) -> Any:
    """Polygons that are seen, from back to front; on a surface those turned from the lamp are darker."""
    seen: Any = view.of(polygons)
    if view.slice is None:
        normal = np.cross(seen[:, 2] - seen[:, 0], seen[:, 3] - seen[:, 1])
        normal /= np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]
        order = np.flatnonzero(normal[:, 2] > 1e-3)
        order = order[np.argsort(seen[order, :, 2].mean(axis=1), kind="stable")]
        light = 1 - SHADE * (1 - np.clip(normal[order] @ (LAMP / np.linalg.norm(LAMP)), 0, 1))
        colours = colours[order] * np.column_stack([light, light, light, np.ones(len(order))])
        seen = seen[order]
        if not axes.texts:
            draw_axes(axes, view, seen[..., :2].reshape(-1, 2))
    look: dict[str, Any] = {"edgecolors": colours, "linewidths": 0.3} | edges
    return axes.add_collection(PolyCollection(seen[..., :2] * MM, facecolors=colours, **look))


def cell_polygons(result: SolidFrames, number: int, view: View) -> tuple[Array, Array]:
    """The sides of the cells that hold material, or their cuts [m], and the levels of these."""
    cubes, leaves, holds = result.cells(number)
    chosen, corners, part = polygons_of(cubes, view)
    return view.whole(part(cubes.places(corners)), leaves.level[holds][chosen], lambda axis: False)


def front_lines(result: SolidFrames, number: int, view: View, scale: float) -> Iterator[Array]:
    """The fronts of cracks as lines (n, 3) with their images [m], which move with the particles nearest to each of their nodes."""
    for front in result.fronts(number, view.ligament):
        if scale:
            particles = result.block("particles", number)
            moved = particles.point_fields["displacement"][:, :3]
            places = particles.points - moved
            front = front + scale * np.array([moved[np.argpartition(np.sum((places - node) ** 2, axis=1), NEAREST)[:NEAREST]].mean(axis=0) for node in front])
        nodes, _ = view.whole(front[:, None], np.zeros(len(front)), lambda axis: False)
        yield from np.split(nodes[:, 0], 2 ** len(view.mirrors))


def draw_fronts(axes: Axes, result: SolidFrames, number: int, view: View, scale: float) -> None:
    """The fronts of cracks as lines, or where a slice meets them."""
    for line in front_lines(result, number, view, scale):
        drawn = view.of(line) * MM
        if view.slice is None:
            axes.plot(*drawn[:, :2].T, color=COLOURS[5], linewidth=1.8, path_effects=HALO, solid_capstyle="butt")
            continue
        height = drawn[:, 2] - view.slice[1] * MM
        before = np.flatnonzero((height[:-1] <= 0) != (height[1:] <= 0))
        part = height[before] / (height[before] - height[before + 1])
        axes.plot(*(drawn[before] + part[:, None] * (drawn[before + 1] - drawn[before]))[:, :2].T, "o", color=COLOURS[5], markersize=4,
                  path_effects=HALO)


def write_with_pyvista(result: SolidFrames, field: ParticleField, number: int, options: Namespace, output: Path) -> None:
    """The picture of a snapshot by PyVista, which hides what is behind exactly, in place of one by matplotlib."""
    try:
        import pyvista
    except ImportError as missing:
        raise ResultError(f"--pyvista: {missing}; without it matplotlib draws") from missing
    view = View(options)
    polygons, values = particle_polygons(result, field, number, view, options.scale)
    shades = colours(field, Survey(0.0, values, np.ones(len(values)), None, None, None), options)
    surface = pyvista.PolyData.from_regular_faces(polygons.reshape(-1, 3) * MM, np.arange(4 * len(polygons)).reshape(-1, 4))
    title = re.sub(r"[$\\{}]|_(?={)", "", f"{field.words} [{shades.unit}]").replace("sigma", "")
    surface.cell_data[title] = shades.factor * values
    width = round((options.width or 7.0) * options.dpi)
    plotter = pyvista.Plotter(off_screen=True, window_size=(width, round(0.65 * width)))
    plotter.set_background("white")
    plotter.add_mesh(surface, cmap=shades.map, clim=(shades.norm.vmin, shades.norm.vmax), log_scale=options.log,
                     scalar_bar_args={"title": title, "color": "black", "vertical": False}, ambient=0.35)
    for line in front_lines(result, number, view, options.scale):
        plotter.add_mesh(pyvista.MultipleLines(line * MM), color=COLOURS[5], line_width=4)
    if options.title:
        plotter.add_title(options.title, color="black")
    plotter.add_axes(color="black")
    plotter.enable_parallel_projection()
    plotter.view_vector(view.turn[2], viewup=view.turn[1])
    plotter.camera.zoom(0.85)          # room for the scale of colours
    plotter.screenshot(output)
    plotter.close()
    print(output)
