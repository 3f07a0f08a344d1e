"""Particles coloured by a field, on the mesh: what still and moving pictures of snapshots share.

Bodies are shown within their outlines, with displacements enlarged, coloured by a field that is smooth but at cracks and between bodies
(`smooth_fields`). With --squares each particle is a square of its share of its cell that deforms as its material does; so are levels and
numbers shown. Faces of cracks and outlines move with the particles beside them. With --mesh the mesh is drawn where it holds material; it
stands still. Where a crack lies on a plane of symmetry, all is mirrored about it; lengths are in mm, from the tip of a crack along a grid
line, else or with --axes scene as in the scene. Components of stress are those along the axes of the scene.
"""

from __future__ import annotations

import argparse
from argparse import ArgumentParser, Namespace
from collections import namedtuple
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection, PolyCollection, TriMesh
from matplotlib.colors import BoundaryNorm, LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.tri import Triangulation

from ..arrays import Array
from ..errors import ResultError
from ..snapshots import COUNTED, Block
from ..stored_model import StoredModel
from .crack_faces import BESIDE, beside, ends_of, faces, is_between, near, seen_from, segments_of
from .frames import Crack, CrackPlane, Frames, Leaves, squares
from .particle_fields import ParticleField
from .pictures import MM, ON_COLOURS, positive, prefixed, round_off, time_unit, typeset
from .smooth_fields import Smooth, pairs_of

OVERLAP = 1.06  # of the squares of neighbours, whose strains differ
MOST_TURNED = 2.0  # enlarged displacement gradient of a particle that its square shows at most
WIDE = 3.0      # the same of what is drawn below particles at a crack
EDGE = 2.0      # and at an outline
MOST_PARTS = 400 # of a side of an outline
OUTLINE: dict[str, Any] = {"colors": "0.35", "linewidths": 0.6}
SHARE = 0.12    # of the picture's width that the largest displacement takes where no scale is given
NEAREST = 4     # particles whose mean displacement is that of a tip
AROUND = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])  # corners of a square
FLAT = 0.35     # height over width of axes below which the scale of colours stands below them
MOST_CUT = 3e-3 # of the area that may be beyond a scale of colours, as at a tip, where a field has no end
PEAK = 3.0      # up to so many times the value there a scale reaches to the largest
DECADES = 4     # that a logarithmic scale of colours reaches down at most

Survey = namedtuple("Survey", "moved values areas lower upper tip")
Survey.__doc__ = ("Largest displacement [mm] and values of the field that are shown, on which parts of the whole, corners of the squares that are drawn "
                  "and the crack tip, where it is in the last snapshot [mm].")
Colours = namedtuple("Colours", "norm map factor unit extend")
Colours.__doc__ = "Scale of colours for a field times a factor, which has the unit, and on which side values lie beyond it."


def add_field_options(parser: ArgumentParser, field: str = "energy_density") -> None:
    """Options of every picture of particles, with the field that is drawn unless another is asked for."""
    parser.add_argument("--field", default=field, metavar="NAME",
                        help="field that colours the particles: one of the file's, speed, displacement, level, mean_stress or "
                             "von_mises (default: %(default)s)")
    parser.add_argument("--log", action="store_true", help="logarithmic scale of colours, for fields without a sign")
    parser.add_argument("--limits", type=limits, metavar="LOW,HIGH", help="of the scale of colours, in the unit of the field without prefix, such as Pa")
    parser.add_argument("--squares", type=positive, metavar="PART",
                        help=f"show particles as squares, with sides over those of their shares of the cell (default: smooth; {OVERLAP:g}, without gaps)")
    parser.add_argument("--window", type=positive, metavar="MM",
                        help="half width of what is shown around the crack tip [mm] (default: everything)")
    parser.add_argument("--mesh", action="store_true", help="show the mesh")
    parser.add_argument("--no-mesh", dest="mesh", action="store_false", help="do not (the default)")
    add_axes_option(parser)


def limits(text: str) -> tuple[float, float]:
    """Two numbers, the first below the second."""
    low, high = map(float, text.split(","))
    if not low < high:
        raise argparse.ArgumentTypeError(f"{text}: the first is not below the second")
    return low, high


def add_axes_option(parser: ArgumentParser) -> None:
    """The coordinates of a picture."""
    parser.add_argument("--axes", choices=["crack", "scene"],
                        help="coordinates of the picture: along the crack from its tip and normal to it, as if it came from "
                             "the left, or those of the scene (default: crack, or scene with cracks of kind 'path')")
    parser.add_argument("--tip", type=int, default=1, metavar="N",
                        help="number of the crack tip that is meant, of several (default: %(default)s)")


def survey(result: Frames, field: ParticleField, numbers: Iterable[int], options: Namespace, scale: float = 1.0) -> Survey:
    """What some snapshots of a result show, with displacements enlarged."""
    plane, moved, values, areas, corners = plane_of(result, options), 0.0, [], [], []
    tip = plane.tip * MM
    for number in numbers:
        tip = result.tip_place(plane, options.tip, number) * MM
        particles = result.block("particles", number)
        leaves, displacement = result.leaves(number), particles.point_fields["displacement"][:, :2]
        shown = np.abs(plane.local(particles.points) * MM - tip).max(axis=1) < (options.window or np.inf)
        moved = max(moved, np.linalg.norm(displacement[shown], axis=1).max(initial=0.0) * MM)
        values.append(field.values(particles, leaves)[shown])
        width = share_of_cell(result, leaves, particles)
        areas.append(width[shown]**2)
        half = (options.squares or OVERLAP) * width / 2
        places = particles.points + (scale - 1) * (displacement - anchor(result, particles, options.tip, number, options.window))
        drawn = plane.local(deformed(places, half[:, None, None] * AROUND, gradients(particles, scale))).reshape(-1, 2) * MM
        corners += [drawn.min(axis=0), drawn.max(axis=0)]
    box = plane.whole(np.array(corners), MM)
    return Survey(moved, np.concatenate(values), np.concatenate(areas), box.min(axis=0), box.max(axis=0), tip)


def joined(surveys: Sequence[Survey]) -> Survey:
    """What all of some surveys show together."""
    moved, values, areas, lower, upper, tips = zip(*surveys)
    return Survey(max(moved), np.concatenate(values), np.concatenate([part / part.sum() for part in areas]), np.min(lower, axis=0), np.max(upper, axis=0), tips[0])


def share_of_cell(result: Frames, leaves: Leaves, particles: Block) -> Array:
    """Size of the square of each particle in the reference configuration: the particles of a cell share its area [m]. In the updated
    frame that of the first snapshot, as long as none has been divided since: strained material is elsewhere in the cells."""
    if not result.is_total() and result.number():
        first = result.block("particles", 0)
        now, then = (block.point_fields["id"] for block in (particles, first))
        if np.array_equal(np.sort(now), np.sort(then)):
            return shares(result, result.leaves(0), first)[np.argsort(then)][np.argsort(np.argsort(now))]
    return shares(result, leaves, particles)


def shares(result: Frames, leaves: Leaves, particles: Block) -> Array:
    """The same, by the cells in which particles are."""
    cell = result.cells_of(particles, leaves)
    number = np.bincount(cell[cell >= 0], minlength=leaves.width.size)
    full = min((result.scene.numbers("body", "points_per_cell", n) or [2])[0] for n in result.scene.body_groups() or [1])
    width = leaves.width / np.sqrt(np.maximum(number, full**2))  # a cell at the edge is not full
    return np.where(cell >= 0, width[cell], result.scene.cell() / 2)


def anchor(result: Frames, particles: Block, tip: int, number: int, window: float | None) -> Array:
    """The displacement that stays as it is where others are enlarged: that of the particles nearest to the tip around which a window
    stands; none where the whole is shown."""
    plane = result.crack_plane(tip, number) if window else None
    if plane is None:
        return np.zeros(2)
    displacement = particles.point_fields["displacement"][:, :2]
    near_tip = np.linalg.norm(particles.points - displacement - plane.in_scene().tip, axis=1)
    return displacement[np.argsort(near_tip, kind="stable")[:NEAREST]].mean(axis=0)


def deformation(particles: Block) -> Array:
    """The deformation gradients of particles, shape (n, 2, 2); those of no deformation where a file does not have them."""
    stored = particles.point_fields.get("deformation_gradient")
    return np.broadcast_to(np.eye(2), (len(particles.points), 2, 2)) if stored is None else stored.reshape(-1, 2, 2)


def gradients(particles: Block, scale: float) -> Array:
    """The gradients by which the squares of particles deform whose displacements are enlarged, shape (n, 2, 2). Enlarged ones above
    MOST_TURNED, as at the tip of a crack, are brought down to that: squares would be drawn over others."""
    h = scale * (deformation(particles) - np.eye(2))
    size = np.linalg.norm(h, axis=(1, 2))
    most = np.maximum(MOST_TURNED, size / scale)
    return np.eye(2) + h * np.minimum(1, most / np.maximum(size, 1e-300))[:, None, None]


def deformed(places: Array, offsets: Array, gradient: Array) -> Array:
    """Points around places (n, 2), at offsets from them in the reference configuration (n, k, 2), as gradients (n, 2, 2) deform them."""
    return places[:, None] + np.einsum("nij,nkj->nki", gradient, np.broadcast_to(offsets, (len(places), *offsets.shape[1:])))


def time_words(result: Frames, number: int) -> str:
    """When a snapshot is, in words: the load step at rest, where there are several, else the time in the unit that suits the run."""
    scene, time, longest = result.scene, result.times[number], result.times.max()
    if scene.is_static():
        steps, end = (scene.numbers(*key) or [1] for key in (("method", "load_steps"), ("run", "end_time")))
        return f"load step {time * steps[0] / end[0]:.4g} of {steps[0]:g}" if steps[0] > 1 and end[0] > 0 else "equilibrium"
    factor, unit = time_unit(longest)
    digits = max(0, 3 - int(np.floor(np.log10(longest * factor)))) if longest > 0 else 0
    return f"$t$ = {time * factor:.{digits}f} {unit}"


def plane_of(result: Frames, options: Namespace) -> CrackPlane:
    """The plane of the crack in the coordinates asked for; the scene's where it has no tip, and then no window around one."""
    plane = result.crack_plane(options.tip)
    if plane is None and options.window:
        raise ResultError(f"{result.path}: --window stands around a crack tip, and the scene has no crack tip")
    plane = plane or CrackPlane(np.zeros(2), np.array([1.0, 0.0]), of_scene=True)
    return plane.in_scene() if is_in_scene(result, options) else plane


def is_in_scene(result: Frames, options: Namespace) -> bool:
    """Whether a picture has the coordinates of the scene."""
    return options.axes == "scene" or options.axes is None and result.scene.has_paths()


def axis_labels(plane: CrackPlane, grows: bool = False) -> tuple[str, str]:
    """What the coordinates of a picture are; those along a crack that grows are from where its tip began."""
    along_crack = f"ahead of {'where the tip began' if grows else 'the tip'} [mm]", "above crack [mm]"
    return ("$x$ [mm]", "$y$ [mm]") if plane.of_scene else along_crack


def default_scale(seen: Survey, window: float | None) -> float:
    """Enlargement of displacements by which the largest is a part of the picture; they are not made smaller."""
    width = 2 * window if window else seen.upper[0] - seen.lower[0]
    return max(1.0, round_off(SHARE * width / seen.moved)) if seen.moved > 0 else 1.0


def bodies_meet(result: Frames) -> bool:
    """Whether bodies may come to touch: in the first snapshot they are apart by a cell or more, or move with different velocities.
    With displacements enlarged they would overlap, or be seen apart where they touch."""
    first, cell = result.block("particles", 0), result.scene.cell()
    places, body = first.points - first.point_fields["displacement"][:, :first.points.shape[1]], first.point_fields["body"]
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


def extent(seen: Survey, window: float | None) -> tuple[Array, Array]:
    """Corners of what is shown [mm]."""
    if window:
        return seen.tip - window, seen.tip + window
    margin = 0.02 * (seen.upper - seen.lower).max()
    return seen.lower - margin, seen.upper + margin


def colours(field: ParticleField, seen: Survey, options: Namespace) -> Colours:
    """The scale of colours for a field in a survey: levels one by one, else linear or logarithmic. It is for all values, unless they are far above
    those outside of a small part of the area."""
    values, log = seen.values, options.log
    if field.name == "level":
        edges = np.arange(values.max(initial=0) + 2) - 0.5
        return Colours(BoundaryNorm(edges, 256), "YlGnBu", 1.0, "1", "neither")
    largest = np.abs(values).max(initial=0.0)
    top = value_above(np.abs(values), seen.areas)
    top = top if 0 < PEAK * top < largest else largest or 1.0
    if options.limits:
        top = max(map(abs, options.limits))
    is_over = largest > top * (1 + 1e-9)
    factor, unit = prefixed(top, field.unit)
    is_signed = values.size > 0 and values.min() < 0
    if log:
        if is_signed:
            raise ResultError(f"{field.result.path}: --log is for fields without a sign; {field.name} has values below zero")
        bottom = options.limits[0] if options.limits and options.limits[0] > 0 else max(values[values > 0].min(initial=top), top / 10**DECADES)
        return Colours(LogNorm(factor * min(bottom, top / 10), factor * top), "YlOrRd", factor, unit, "both")
    if options.limits:
        low, high = options.limits
        beyond = (values.min(initial=high) < low) + 2 * (values.max(initial=low) > high)
        map_name = "RdYlBu_r" if low < 0 < high else "YlOrRd" if low >= 0 else "YlGnBu_r"
        return Colours(Normalize(factor * low, factor * high), map_name, factor, unit, ("neither", "min", "max", "both")[beyond])
    if is_signed:
        return Colours(Normalize(-factor * top, factor * top), "RdYlBu_r", factor, unit, "both" if is_over else "neither")
    return Colours(Normalize(0.0, factor * top), "YlOrRd", factor, unit, "max" if is_over else "neither")


def value_above(values: Array, areas: Array) -> float:
    """The value above which those of a small part of the area are; 0 where there are none."""
    order = np.argsort(values)
    total = np.cumsum(areas[order])
    return values[order][np.searchsorted(total, (1 - MOST_CUT) * total[-1])] if values.size else 0.0


class Canvas:
    """Axes with the bodies, the mesh and the cracks of one result, which `show` draws."""

    def __init__(self, axes: Axes, result: Frames, field: ParticleField, scale: float, shades: Colours, options: Namespace) -> None:
        self.result, self.field, self.scale, self.shades, self.size = result, field, scale, shades, options.squares or OVERLAP
        self.axes, self.window, self.tip = axes, options.window, options.tip
        self.plane = plane_of(result, options)
        self.is_smooth = not options.squares and field.name not in COUNTED
        self.colours = ScalarMappable(shades.norm, shades.map)
        self.squares: Any = axes.add_collection(PolyCollection([], cmap=shades.map, norm=shades.norm, edgecolors="none",
                                                          antialiased=False))
        self.mesh: Any = axes.add_collection(PolyCollection([], facecolors="none", edgecolors=(0, 0, 0, 0.3), linewidths=0.5,
                                                       visible=options.mesh))
        self.faces: Any = axes.add_collection(LineCollection([], colors="black", linewidths=1.0, capstyle="butt", gid=ON_COLOURS))
        self.outlines: Any = axes.add_collection(LineCollection([], **OUTLINE))
        self._triangles: Any = None
        self._before: Squares | None = None
        self.tips, = axes.plot([], [], "o", color="black", markersize=3, gid=ON_COLOURS)
        across, up = axis_labels(self.plane, result.scene.count("growth") > 0)
        axes.set(xlabel=across, ylabel=up)
        axes.set_aspect("equal")
        axes.grid(False)

    def show(self, number: int) -> str:
        """Draw a snapshot. Returns what it shows, in words."""
        leaves, particles, cracks = self.result.leaves(number), self.result.block("particles", number), self.result.cracks(number)
        values = self.shades.factor * self.field.values(particles, leaves)
        fixed = anchor(self.result, particles, self.tip, number, self.window)
        squares_of = Squares(particles, share_of_cell(self.result, leaves, particles), cracks, self.scale, self.result.scene, fixed,
                             self.plane.is_symmetry)
        holds = leaves.particles > 0
        self.mesh.set_verts(self._seen(squares(leaves.lower[holds], leaves.width[holds])))
        if self.is_smooth:
            self._draw_smooth(squares_of, values)
        else:
            self._draw_particles(squares_of, values)
        self._draw_cracks(squares_of, cracks)
        self._follow(number)
        words, factor = time_words(self.result, number), f"{self.scale:,g}".replace(",", "\u2009")
        return words if self.scale == 1 else f"{words}, displacements × {factor}"

    def _follow(self, number: int) -> None:
        """Keep the window around the tip, which may have grown."""
        if self.window:
            x, y = self.result.tip_place(self.plane, self.tip, number) * MM
            self.axes.set(xlim=(x - self.window, x + self.window), ylim=(y - self.window, y + self.window))

    def _seen(self, points: Array) -> Array:
        """Points of the scene in the coordinates of the picture, with their images [mm]."""
        return self.plane.whole(self.plane.local(points) * MM, MM)

    def _draw_particles(self, squares_of: Squares, values: Array) -> None:
        """The squares. At a crack with two faces that part of each is drawn that is on its side and, below them all, what of larger
        squares is: the edges of squares may be short of the crack."""
        divided = squares_of.divided & (not self.plane.is_symmetry)
        groups = [(squares_of.whole(self.size, ~divided), ~divided)]
        if divided.any():
            groups.append((squares_of.parts(self.size, divided), divided))
            if self.size >= 1:
                groups.insert(0, (squares_of.parts(WIDE, divided), divided))
        self.squares.set_verts([outline for outlines, chosen in groups for outline in self._seen(squares_of.moved(outlines, chosen))])
        shown = np.concatenate([values[chosen] for _, chosen in groups])
        images = [-shown if self.field.is_odd else shown] if self.plane.is_symmetry else []
        self.squares.set_array(np.concatenate([shown, *images]))

    def _draw_smooth(self, squares_of: Squares, values: Array) -> None:
        """The same outlines as fans of triangles around the places of particles, whose corners have the values of the smooth field there."""
        smooth, self._before = squares_of.smooth(values, self._before), squares_of
        parts: list[tuple[Array, Array, Array]] = []
        count = 0
        for outlines, chosen in squares_of.filled():
            owners, (number, corners) = np.flatnonzero(chosen), outlines.shape[:2]
            around = np.concatenate([squares_of.places[chosen][:, None], outlines], axis=1)
            exact, within = smooth.at(around, owners)       # extrapolated displacements, and values that are not
            one = np.arange(corners)
            fan = np.column_stack([np.zeros_like(one), 1 + one, 1 + (one + 1) % corners])
            parts.append(((around + exact[..., :2]).reshape(-1, 2), within[..., 2].reshape(-1),
                          (count + (corners + 1) * np.arange(number)[:, None, None] + fan).reshape(-1, 3)))
            count += number * (corners + 1)
        places, shown, triangles = (np.concatenate(of) for of in zip(*parts))
        points = self._seen(places)
        if len(points) > count:
            shown, triangles = np.concatenate([shown, -shown if self.field.is_odd else shown]), np.concatenate([triangles, triangles + count])
        if self._triangles:
            self._triangles.remove()
        self._triangles = TriMesh(Triangulation(*points.T, triangles), cmap=self.shades.map, norm=self.shades.norm, rasterized=True)
        self._triangles.set_array(shown)
        self.axes.add_collection(self._triangles, autolim=False)
        self.outlines.set_segments([line for outline in squares_of.outlines(self.plane.in_scene(), smooth) for line in self._seen(outline[None])])

    def _draw_cracks(self, squares_of: Squares, cracks: Sequence[Crack]) -> None:
        """Faces, which begin as one line, and tips. On a plane of symmetry a tip stays on it."""
        moved = [squares_of.faces(crack) for crack in cracks]
        self.faces.set_segments([line for lines in moved for line in self._seen(lines)])
        tips = [self._seen(lines[:1, place]).mean(axis=0) for lines, crack in zip(moved, cracks)
                for place in (0, -1) if crack.tips[place]]
        self.tips.set_data(*np.array(tips).reshape(-1, 2).T)


class Squares:
    """The squares of particles of a snapshot in the coordinates of the scene, in the reference configuration [m].

    places    of the particles
    divided   of which a crack may be in the square or beside it
    """

    def __init__(self, particles: Block, width: Array, cracks: Sequence[Crack], scale: float, scene: StoredModel, fixed: Array, is_symmetry: bool = False) -> None:
        displacement, segments = particles.point_fields["displacement"][:, :2], segments_of(cracks)
        self._width, self._segments, self._ends = width, segments, ends_of([] if is_symmetry else cracks)
        self._shift, self._gradient = scale * (displacement - fixed) + fixed, gradients(particles, scale)
        places = particles.points - displacement
        self.divided = near(places, WIDE * width, segments)
        self.places = beside(places, particles.point_fields.get("side", np.zeros(len(places))), width, segments)
        self._body, (self._lower, self._upper) = particles.point_fields["body"].astype(int) - 1, scene.bodies()
        self._smooth: Smooth | None = None
        self._bodies, self._outlines = scene.body_groups(), [scene.outline(n) for n in range(1, scene.count("body") + 1)]
        self._torn = segments[:0] if is_symmetry else segments     # a crack on a plane of symmetry lies along an edge
        sides = [np.stack([line[:-1], line[1:]], axis=1) for line in self._outlines]
        boxes = [n for n in self._bodies if scene.text("body", "shape", n) not in ("polygon", "circle")]
        self._walls = np.concatenate([self._torn, *(of for n, of in enumerate(sides, 1) if n not in boxes)])
        self._cut = near(places, EDGE * width, self._walls) | (self.divided & (not is_symmetry))
        self._aside = near(places, EDGE * width, np.concatenate([segments[:0], *(sides[n - 1] for n in boxes)])) & ~self._cut

    def whole(self, size: Any, chosen: Array) -> Array:
        """Corners, as if there were no cracks, with sides of so many shares."""
        return self.places[chosen, None] + size * self._width[chosen, None, None] / 2 * AROUND

    def moved(self, points: Array, chosen: Array) -> Array:
        """Points (m, k, 2) around particles, as these move and deform."""
        return deformed((self.places + self._shift)[chosen], points - self.places[chosen, None], self._gradient[chosen])

    def parts(self, size: Any, chosen: Array) -> Array:
        """Outlines of what particles see of their squares past cracks and edges; squares larger than their shares end with the body."""
        return seen_from(self.places[chosen], *self._boxes(size, chosen), self._walls, self._ends, self._width[chosen])

    def _boxes(self, size: Any, chosen: Array) -> tuple[Array, Array]:
        """Corners of squares that end with the box around their body."""
        places, body, half = self.places[chosen], self._body[chosen], (size * self._width)[chosen, None] / 2
        return np.maximum(places - half, self._lower[body]), np.minimum(places + half, self._upper[body])

    def filled(self) -> list[tuple[Array, Array]]:
        """Outlines that fill bodies up to their edges and cracks, each (m, k, 2) with those of the particles whose they are; those that come
        later are above the others."""
        cut, aside = self._cut, self._aside
        found = []
        for size in (np.where(self.divided, WIDE, EDGE), np.full(len(cut), OVERLAP)):
            if aside.any():
                (left, low), (right, high) = (corner.T for corner in self._boxes(size, aside))
                found.append((np.stack([[left, right, right, left], [low, low, high, high]]).transpose(2, 1, 0), aside))
            if cut.any():
                found.append((self.parts(size, cut), cut))
        whole = ~cut & ~aside
        return [*found, (self.whole(OVERLAP, whole), whole)]

    def smooth(self, values: Array, before: Squares | None = None) -> Smooth:
        """Displacements, enlarged, and the field of these values between the particles, whose neighbours may be those of another snapshot."""
        is_same = before is not None and np.array_equal(self._walls, before._walls) and self.places.shape == before.places.shape \
            and np.all(np.abs(self.places - before.places) < BESIDE * self._width[:, None])
        self._pairs: Array = before._pairs if before is not None and is_same else pairs_of(self.places, self._width, self._body, self._walls, self._cut)
        found = self._smooth = Smooth(self.places, self._width, np.column_stack([self._shift, values]), self._pairs)
        return found

    def outlines(self, plane: CrackPlane, smooth: Smooth) -> list[Array]:
        """The edges of bodies as they move, but for those on a plane of symmetry; NaN where there is no material. Lines (n, 2)."""
        found, at_edge = [], self._cut | self._aside
        step = np.median(self._width[at_edge]) / 2 if at_edge.any() else np.inf
        for number, line in enumerate(self._outlines, 1):
            own = np.flatnonzero(at_edge & ((self._body == self._bodies.index(number)) if number in self._bodies else True))
            if not own.size:
                continue
            length = np.linalg.norm(np.diff(line, axis=0), axis=1)
            counts = np.minimum(np.ceil(length / step), MOST_PARTS).astype(int)
            points = np.concatenate([*(a + np.arange(n)[:, None] / n * (b - a) for a, b, n in zip(line, line[1:], counts) if n), line[-1:]])
            distance = np.linalg.norm(points[:, None] - self.places[own], axis=2)
            owner = own[np.argmin(distance, axis=1)]
            moved = points + smooth.at(points[:, None], owner)[0][:, 0, :2]
            moved[distance.min(axis=1) > self._width[owner]] = np.nan
            if plane.is_symmetry:
                on = np.abs((points - plane.tip) @ [-plane.along[1], plane.along[0]]) < BESIDE * self._width[owner]
                moved[on & np.append(on[1:], on[1]) & np.insert(on[:-1], 0, on[-2])] = np.nan
            torn = np.flatnonzero(is_between(self.places[owner[:-1]], self.places[owner[1:]], self._torn))
            middle = (points[torn] + points[torn + 1])[:, None] / 2
            left, right = (middle[:, 0] + smooth.at(middle, owner[torn + k])[0][:, 0, :2] for k in (0, 1))
            ends = np.stack([left, np.full((len(torn), 2), np.nan), right], axis=1)
            found.append(np.insert(moved, np.repeat(torn + 1, 3), ends.reshape(-1, 2), axis=0))
        return found

    def faces(self, crack: Crack) -> Array:
        """The faces of a crack, which follow the displacements between particles where these are smooth."""
        beside, smooth = np.flatnonzero(self.divided), self._smooth

        def shift(points: Array, numbers: Array) -> Array:
            return self._shift[beside[numbers]] if smooth is None else smooth.at(points[:, None], beside[numbers])[0][:, 0, :2]
        return faces(crack, self.places[beside], self._width[beside], shift, self._segments, (self._lower, self._upper))


def add_colour_bar(figure: Figure, axes: Axes, canvas: Any) -> Any:
    """The scale of colours, with name and unit of the field, beside some axes."""
    shades = canvas.shades
    (left, right), (bottom, top) = canvas.axes.get_xlim(), canvas.axes.get_ylim()
    place: dict[str, Any] = {"location": "bottom", "aspect": 40, "shrink": 0.7} if top - bottom < FLAT * (right - left) else {"pad": 0.02}
    bar = figure.colorbar(canvas.colours, ax=axes, extend=shades.extend, extendfrac=0.03, **place,
                          label=f"{canvas.field.words} [{'–' if shades.unit == '1' else typeset(shades.unit)}]")
    if canvas.field.name == "level":
        bar.set_ticks(range(round(shades.norm.vmax + 0.5)))
        bar.minorticks_off()
    return bar
