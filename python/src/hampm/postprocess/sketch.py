"""Sketch of a model before any run: its bodies, cracks, supports and loads, as hampm understands the namelist.

Grey are the bodies, white their holes; orange the cracks, with a dot at each tip, dashed where their faces hold each other by cohesion, and
dotted the path along which they are to grow. Green are supports, a triangle where both components are held, a roller where one is, and
arrows of prescribed motions; blue are loads, with thick lines where they act along an edge or a crack; pink is the velocity with which a
body starts. Arrows tell directions, not sizes: these stand beside them, with the history where it is not a step. Dash-dotted is a plane of
symmetry that a crack lies in, and the axis of a model around one. With --grid, faint: the lattice, and the boxes in which cells may refine
and in which the mass matrix is consistent. Black are the points and lines of probes. &contact, &damping and the other groups have no
place, and are not drawn.
"""

from __future__ import annotations

import json
from argparse import Namespace
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.markers import MarkerStyle
from matplotlib.patches import Polygon, Rectangle
from matplotlib.path import Path
from matplotlib.ticker import MaxNLocator
from matplotlib.transforms import Affine2D, Bbox

from ..arrays import Array
from ..errors import HampmError, Message, ResultError
from ..program import call
from ..scene import Scene
from ..stored_model import StoredModel
from .pictures import COLOURS, DRAWING, picture_parser, plt, prefixed, typeset, verbatim, write

LOAD, CRACK, SUPPORT, MOTION = COLOURS[:4]
LOOK = {"font.size": 17, "axes.titlesize": 17, "axes.grid": False, "lines.linewidth": 2.5, "axes.linewidth": 1.2, "figure.dpi": 72}
PAD = 0.1    # around all that is drawn [inch]
LARGEST, MARGIN = np.array([580.0, 430.0]), 92.0  # of the bodies, and around them [points]
ARROW, GAP, SYMBOL, SPACING = 38.0, 6.0, 15.0, 44.0  # lengths of arrows, beside edges, of supports, and between either [points]
AXES = {"x": np.array([1.0, 0.0]), "y": np.array([0.0, 1.0])}
OF_HISTORY = {"step": "", "ramp": " (ramp)", "smooth_ramp": " (smooth ramp)", "sine": " (sine)", "table": " (table)"}

# A roller and a triangle that touch what they hold at the origin, from below, one unit deep
GROUND = Path([(-0.7, -0.85), (0.7, -0.85)])
ROLLER = Path.make_compound_path(Path.circle((0, -0.42), 0.4), GROUND)
TRIANGLE = Path.make_compound_path(Path([(0, 0), (-0.5, -0.85), (0.5, -0.85), (0, 0)]), GROUND,
                                   *(Path([(x, -0.85), (x - 0.15, -1)]) for x in (-0.5, -0.1, 0.3, 0.7)))


def main(arguments: Sequence[str] | None = None) -> None:
    write(figure, parse(arguments), "_sketch")


def figure(options: Namespace) -> Figure:
    """The picture that these options ask for."""
    return draw(*understood(options.files[0], options.settings), options)


def parse(arguments: Sequence[str] | None) -> Namespace:
    parser = picture_parser(__doc__, "_sketch", "namelist of a model that hampm --check accepts", "MODEL.nml", nargs=1)
    parser.add_argument("--set", action="append", default=[], metavar="GROUP.KEY=VALUE", dest="settings",
                        help="use this value instead of the file's; may be repeated")
    parser.add_argument("--grid", action="store_true", help="show the lattice and its boxes, too")
    return parser.parse_args(arguments)


def understood(case: str, settings: Sequence[str]) -> tuple[Scene, StoredModel, list[Array]]:
    """The model as the program understands it, with every key: as a scene and as results store it; and its crack tips."""
    try:
        code, text, _ = call(["--check", "--json", "--quiet", case, *(word for setting in settings for word in ("--set", setting))])
        told = json.loads(text)
        if not told["valid"]:
            raise ResultError("\n".join(str(Message(**error)) for error in told["errors"]), code)
        return Scene(text=told["namelist"]), StoredModel(told["namelist"], case), [np.array([tip["x"], tip["y"]]) for tip in told["tips"]]
    except HampmError as error:
        raise ResultError(error, error.exit_code) from error


def draw(scene: Any, stored: StoredModel, tips: Sequence[Array], options: Namespace) -> Figure:
    """The figure: a group of the namelist after the other, then the labels, which look for free places."""
    plt.rcParams.update(LOOK)
    sheet = Sheet(scene, with_lattice=options.grid)
    for body in scene.body:
        draw_body(sheet, body, has_materials=len(scene.material) > 1)
    cracks = [path_of(crack, stored) for crack in scene.crack]
    draw_planes(sheet, scene)
    for crack, path in zip(scene.crack, cracks):
        draw_crack(sheet, scene, crack, path)
    for number, tip in enumerate(tips, 1):
        sheet.axes.plot(*tip, "o", color=CRACK, markersize=9, zorder=5)
        if len(tips) > 1:
            sheet.label(tip, f"tip {number}", AXES["x"])
    for constraint in scene.constraint:
        draw_constraint(sheet, constraint)
    for load in scene.load:
        draw_load(sheet, load, [path for crack, path in zip(scene.crack, cracks) if load.crack in ("", None, crack.name)])
    for probe in scene.probe:
        draw_probe(sheet, probe)
    if options.grid:
        draw_lattice(sheet, scene)
    sheet.write_labels()
    if options.title:
        sheet.axes.set_title(options.title)
    sheet.fit()
    return sheet.axes.figure


class Sheet:
    """What is drawn on: axes in a unit that suits, the length of a point on paper, and where the material is.

    outlines  of bodies and of holes, closed lines (n, 2) [m]
    polygons  those of them that have sides
    point     1/72 inch on paper [m]
    """

    def __init__(self, scene: Any, with_lattice: bool) -> None:
        self.outlines = [outline(body) for body in scene.body]
        self.polygons = [line for line, body in zip(self.outlines, scene.body) if body.shape != "circle"]
        self._material = [(Path(line), body.hole) for line, body in zip(self.outlines, scene.body)]
        self.middles = [middle_of(line) for line, body in zip(self.outlines, scene.body) if not body.hole]
        corners = np.concatenate(self.outlines + ([np.array(lattice(scene))] if with_lattice else []))
        self.lower, self.upper = corners.min(axis=0), corners.max(axis=0)
        self.point = max((self.upper - self.lower) / LARGEST)
        self.factor, name = prefixed(max(self.upper - self.lower), "m")
        size = (self.upper - self.lower) / self.point + 2 * MARGIN
        figure = plt.figure(figsize=size / 72, label=DRAWING)
        self.axes = figure.add_axes((0, 0, 1, 1))
        start, end = self.lower - MARGIN * self.point, self.upper + MARGIN * self.point
        of_x = "radius $x$" if scene.run.plane == "axisymmetric" else "$x$"
        self.axes.set(xlim=(start[0], end[0]), ylim=(start[1], end[1]), xlabel=f"{of_x} [{name}]", ylabel=f"$y$ [{name}]")
        for axis, points in zip((self.axes.xaxis, self.axes.yaxis), size):
            axis.set_major_locator(Scaled(self.factor, max(2, min(6, int(points / 70)))))
            axis.set_major_formatter(lambda value, _: f"{value * self.factor:.6g}".replace("-", "−"))
        self._labels: list[tuple[Any, str, Any]] = []
        self._points = list(np.concatenate([along(line, 5 * self.point)[0] for line in self.outlines]))

    def is_material(self, place: Any) -> bool:
        """Whether there is material at a place."""
        return any(path.contains_point(place) for path, hole in self._material if not hole) and \
            not any(path.contains_point(place) for path, hole in self._material if hole)

    def outward(self, place: Any, directions: Sequence[Array]) -> Array:
        """The first of these directions in which there is no material beside a place; else the first."""
        return next((way for way in directions if not self.is_material(place + self.point * way)), directions[0])

    def line(self, points: Any, **look: Any) -> None:
        self.axes.plot(*np.transpose(points), **look)
        self._points += list(along(points, 5 * self.point)[0] if len(points) > 1 else points)

    def box(self, lower: Any, upper: Any, **look: Any) -> None:
        self.axes.add_patch(Rectangle(lower, *np.subtract(upper, lower), fill=False, linestyle="--", **look))

    def arrow(self, place: Any, direction: Any, colour: Any) -> Array:
        """An arrow that ends at a place, where it presses on an edge from outside, or else begins there. Returns its free end."""
        way = unit(direction)
        presses = self.is_material(place + self.point * way) and not self.is_material(place - self.point * way)
        tail = place - presses * ARROW * self.point * way
        self.axes.annotate("", tail + ARROW * self.point * way, tail, zorder=6, annotation_clip=False,
                           arrowprops={"arrowstyle": "-|>", "color": colour, "linewidth": 2.5, "mutation_scale": 20, "shrinkA": 0, "shrinkB": 0})
        self._points += [tail + part * ARROW * self.point * way for part in np.linspace(0, 1, 8)]
        return tail if presses else tail + ARROW * self.point * way

    def support(self, place: Any, outward: Array, symbol: Any) -> Array:
        """A symbol that touches a place from outside. Returns its other end."""
        turn = Affine2D().rotate(np.arctan2(*outward[::-1]) + np.pi / 2)
        self.axes.plot(*place, marker=MarkerStyle(symbol, transform=turn), markersize=2 * SYMBOL, markeredgewidth=1.8, markeredgecolor=SUPPORT,
                       markerfacecolor="white", zorder=4)
        self._points += [place + SYMBOL * self.point * (part * outward + side * outward[::-1]) for part in (0.3, 0.9) for side in (-0.6, 0, 0.6)]
        return place + SYMBOL * self.point * outward

    def label(self, place: Any, text: str, direction: Any) -> None:
        """To be written beside a place, in a direction if there is room; once only where loads follow each other there."""
        if not any(text == other and np.allclose(place, there) for there, other, _ in self._labels):
            self._labels.append((place, text, direction))

    def write_labels(self) -> None:
        """Each label where it covers the least of what there is, nearer to its own place than to those of others if that can be."""
        whole: Any = self.axes.figure
        renderer = whole.canvas.get_renderer()
        boxes: list[Any] = []
        points = self.axes.transData.transform(self._points)
        places = self.axes.transData.transform([place for place, *_ in self._labels]) if self._labels else []
        for center, (place, text, direction) in zip(places, self._labels):
            word = self.axes.annotate(text, place, (0, 0), textcoords="offset points", ha="center", va="center", zorder=7, annotation_clip=False)
            size = np.array(word.get_window_extent(renderer).size) + 4
            turns = np.radians([0, 45, -45, 90, -90, 135, -135, 180])
            ways = [np.array([np.cos(turn), np.sin(turn)]) for turn in np.arctan2(*direction[::-1]) + turns]
            tried = [(distance + size / 2) * np.round(way, 3) for distance in (6, 20, 36, 54) for way in ways]
            found = [Bbox([center + shift - size / 2, center + shift + size / 2]) for shift in tried]
            hits = [10 * sum(box.overlaps(other) for other in boxes) + sum(box.contains(*point) for point in points) + 20 * (min(box.min) < 0)
                    + 2 * sum(np.hypot(*(places - center - shift).T) < np.hypot(*shift) - 1) + 0.01 * rank
                    for rank, (box, shift) in enumerate(zip(found, tried))]
            best = int(np.argmin(hits))
            word.set_position(tried[best])
            boxes.append(found[best])


    def fit(self) -> None:
        """Have the figure end around all that is drawn, labels of axes too."""
        figure = self.axes.figure
        own, box = figure.get_size_inches(), figure.get_tightbbox()
        size = np.array(box.size) + 2 * PAD
        figure.set_size_inches(size)
        self.axes.set_position([*((PAD - np.array(box.min)) / size), *(own / size)])


class Scaled(MaxNLocator):
    """Ticks that are round in a unit."""

    def __init__(self, factor: float, count: int) -> None:
        self._factor = factor
        super().__init__(count, steps=[1, 2, 5, 10])

    def tick_values(self, least: float, most: float) -> Any:
        return np.array(super().tick_values(least * self._factor, most * self._factor)) / self._factor


def outline(body: Any) -> Array:
    """The closed line around a body or a hole."""
    match body.shape:
        case "polygon":
            corners = np.reshape(body.points, (-1, 2))
        case "circle":
            turns = np.linspace(0, 2 * np.pi, 120, endpoint=False)
            corners = body.center + body.radius * np.column_stack([np.cos(turns), np.sin(turns)])
        case _:
            corners = np.array(body.lower) + np.subtract(body.upper, body.lower) * [[0, 0], [1, 0], [1, 1], [0, 1]]
    return np.concatenate([corners, corners[:1]])


def middle_of(line: Array) -> Array:
    return (line.min(axis=0) + line.max(axis=0)) / 2


def lattice(scene: Any) -> tuple[Array, Array]:
    """Its lower and upper corner."""
    lower = np.array(scene.grid.lower)
    return lower, lower + scene.grid.cell * np.array(scene.grid.cells)


def along(line: Array, spacing: float) -> tuple[Array, Array]:
    """Places in the middle of equal parts of a line (n, 2), each about so long; and the directions of the line there."""
    steps = np.diff(line, axis=0)
    ways = np.concatenate([[0], np.cumsum(np.hypot(*steps.T))])
    count = max(1, round(ways[-1] / spacing))
    at = ways[-1] * (np.arange(count) + 0.5) / count
    of = np.searchsorted(ways, at) - 1
    return np.column_stack([np.interp(at, ways, column) for column in np.transpose(line)]), steps[of] / np.hypot(*steps[of].T)[:, None]


def within(line: Array, lower: Any, upper: Any, slack: float) -> list[Array]:
    """The parts of a line that lie in a box with so much slack, one after the other."""
    parts: list[Array] = []
    for start, end in zip(line[:-1], line[1:]):
        step = end - start
        with np.errstate(divide="ignore", invalid="ignore"):
            enter, leave = np.sort([(lower - slack - start) / step, (upper + slack - start) / step], axis=0)
        is_inside = (start >= lower - slack) & (start <= upper + slack)
        first = max(0, *np.where(step == 0, np.where(is_inside, 0, 2), enter))
        last = min(1, *np.where(step == 0, 1, leave))
        if (last - first) * np.hypot(*step) > 10 * slack:
            piece = start + np.outer([first, last], step)
            if parts and np.allclose(parts[-1][-1], piece[0], rtol=0, atol=slack):
                parts[-1] = np.concatenate([parts[-1], piece[1:]])
            else:
                parts.append(piece)
    return parts


def unit(vector: Any) -> Array:
    """The direction of a vector; zero where it has none."""
    return np.array(vector) / (np.hypot(*vector) or 1.0)


def quantity(value: float, of: str) -> str:
    """A value in a unit with a prefix that suits."""
    factor, of = prefixed(abs(value), of)
    return f"{value * factor:.4g} {typeset(of)}".replace("-", "−")


def draw_body(sheet: Sheet, body: Any, has_materials: bool) -> None:
    """Its outline; its material where there are several, its first velocity and its strain without stress."""
    line = outline(body)
    sheet.axes.add_patch(Polygon(line, facecolor="white" if body.hole else "0.9", edgecolor="0.2", linewidth=1.8))
    if body.hole:
        return
    words = [verbatim(body.material)] * has_materials
    if any(body.eigenstrain):
        words.append(r"$\varepsilon_0$ = " + ", ".join(f"{value:g}" for value in body.eigenstrain))
    if body.spin:
        words.append(rf"$\omega$ = {quantity(body.spin, 'rad/s')}")
    if words:
        sheet.label(middle_of(line), ", ".join(words), AXES["y"])
    if any(body.velocity):
        end = sheet.arrow(middle_of(line), np.array(body.velocity), MOTION)
        sheet.label(end, f"$v$ = {quantity(np.hypot(*body.velocity), 'm/s')}", np.array(body.velocity))


def draw_planes(sheet: Sheet, scene: Any) -> None:
    """The planes of symmetry that cracks lie in, and the axis."""
    lines = [(crack.tip, crack.direction, "symmetry") for crack in scene.crack if crack.kind == "symmetry"]
    for place, way, name in lines + [((0, 0), AXES["y"], "axis")] * (scene.run.plane == "axisymmetric"):
        place, way = np.array(place), unit(np.abs(way))
        ends = [place + way * ((end - place) @ way + sign * MARGIN / 2 * sheet.point) for end, sign in ((sheet.lower, -1), (sheet.upper, 1))]
        sheet.line(ends, color="0.2", linestyle="-.", linewidth=1.2)
        sheet.label(ends[1], name, way)


def path_of(crack: Any, stored: StoredModel) -> Array:
    """The points of a crack; one without a length goes from its tip back to the edge."""
    if crack.kind == "path":
        return np.reshape(crack.points, (-1, 2))
    if crack.front == "disc":
        return np.add(crack.center, np.outer((-1, 1), np.ravel(crack.radii)[0] * np.flip(unit([crack.normal == axis for axis in "xy"]))))
    tip, way = np.array(crack.tip), unit(crack.direction)
    return np.array([tip - (crack.length or stored.way_to_edge(tip, -way)) * way, tip])


def draw_crack(sheet: Sheet, scene: Any, crack: Any, path: Array) -> None:
    """A crack, its part with cohesion dashed, the path that it is to grow along, and what it does."""
    def of_it(groups: Iterable[Any]) -> list[Any]:
        return [group for group in groups if group.crack in ("", None, crack.name)]
    sheet.line(path, color=CRACK, linewidth=4, solid_capstyle="butt")
    for group in of_it(scene.cohesive):
        ways = np.concatenate([[0], np.cumsum(np.hypot(*np.diff(path, axis=0).T))])
        start = [np.interp(group["from"], ways, column) for column in path.T]
        sheet.line([start, *path[ways > group["from"]]], color="0.9", linewidth=4, linestyle=(0, (1, 1)))
    for group in of_it(scene.growth):
        if group.points:
            sheet.line(np.reshape(group.points, (-1, 2)), color=CRACK, linewidth=2.5, linestyle=":")
    words = [verbatim(crack.name or "crack"), *[crack.contact] * (crack.contact != "none"), *["cohesive"] * bool(of_it(scene.cohesive)),
             *["grows"] * bool(of_it(scene.growth))]
    places, ways = along(path, np.inf)
    sheet.label(places[0], ", ".join(words), np.array([-ways[0][1], ways[0][0]]) * (1 if ways[0][0] >= 0 else -1))


def draw_constraint(sheet: Sheet, constraint: Any) -> None:
    """Supports where components are held, arrows where they are moved, along the box of the nodes."""
    lower, upper = (np.clip(corner, sheet.lower, sheet.upper) for corner in (constraint.lower, constraint.upper))
    if np.all(upper - lower > 2 * SYMBOL * sheet.point):
        sheet.box(lower, upper, color=SUPPORT, linewidth=1.5)
    longer = np.arange(2) == np.argmax(upper - lower)
    middle = (lower + upper) / 2
    places = along(np.where(longer, [lower, upper], middle), SPACING * sheet.point)[0] if np.any(upper > lower) else [middle]
    values, of, symbol = (constraint.velocity, "m/s", "v") if any(constraint.velocity) else (constraint.displacement, "m", "u")
    moved = np.array([value if component in constraint.fix else 0.0 for component, value in zip("xy", values)])
    held = [component for component, value in zip("xy", moved) if component in constraint.fix and not value]
    ways = [sign * AXES[component] for component in sorted(held, key=lambda component: longer["xy".index(component)]) for sign in (-1, 1)]
    ends, outward = [], None
    for place in places:
        if held:
            outward = sheet.outward(place, ways)
            end = sheet.support(place, outward, TRIANGLE if len(held) == 2 else ROLLER)
        if any(moved):
            outward = sheet.outward(place, [unit(moved), -unit(moved)])
            end = sheet.arrow(place, moved, SUPPORT)
        ends.append(end)
    words = [f"${symbol}_{component}$ = {quantity(value, of)}{OF_HISTORY[constraint.history]}" for component, value in zip("xy", moved) if value]
    words += [" = ".join([*(f"$u_{component}$" for component in held), "0"])] * bool(held)
    sheet.label(ends[len(ends) // 2], (f"{verbatim(constraint.name)}: " if constraint.name else "") + ", ".join(words)
                + ", from one side" * constraint.unilateral, outward)


def draw_load(sheet: Sheet, load: Any, cracks: Sequence[Array]) -> Any:
    """Arrows along an edge or a crack, or in the middle of what it acts on, and its size."""
    force = np.array(load.acceleration if load.kind == "gravity" else load.force or (0.0, -load.pressure))
    on_crack, is_pressure = load.on == "crack" or load.face != "none", load.kind == "pressure"
    lower, upper = (np.array(corner, dtype=float) for corner in ((load.lower, load.upper) if load.lower else (sheet.lower, sheet.upper)))
    lines = [*(cracks if on_crack else sheet.outlines)] if load.kind in ("traction", "pressure", "absorbing") else []
    if load.side:
        lines = [line[load.side - 1:load.side + 1] for line in sheet.polygons if len(line) > load.side]
    parts = [part for line in lines for part in within(line, lower, upper, 1e-3 * sheet.point)]
    if load.side:
        lower, upper = parts[0].min(axis=0), parts[0].max(axis=0)
    if load.kind == "absorbing":
        for part in parts:
            sheet.line(part, color=LOAD, linewidth=5, linestyle=(0, (0.5, 0.5)), zorder=1.5)
        sheet.label((lower + upper) / 2, "absorbing", upper - lower)
        return
    ends = []
    for part in parts:
        sheet.line(part, color=LOAD, linewidth=5, zorder=1.5, solid_capstyle="butt")
        for place, way in zip(*along(part, SPACING * sheet.point)):
            normal = np.array([way[1], -way[0]])
            for outward in [normal, -normal] if is_pressure and on_crack else [sheet.outward(place, [normal, -normal])]:
                ends.append((force_arrow(sheet, place, way, outward, -load.pressure * outward if is_pressure else force), outward))
    if not ends:
        places = sheet.middles if load.kind == "gravity" else [(lower + upper) / 2]
        ends = [(sheet.arrow(place, force, LOAD), force) for place in places]
    if load.kind == "body":
        sheet.box(lower, upper, color=LOAD, linewidth=1.5)
    size = np.hypot(*force)
    name, value, of = {"gravity": ("g", size, "m/s2"), "pressure": ("p", load.pressure, "Pa")}.get(load.kind, ("F", size, "N"))
    place, outward = ends[len(ends) // 2]
    sheet.label(place, f"${name}$ = {quantity(value, of)}{OF_HISTORY[load.history]}", outward)


def draw_probe(sheet: Sheet, probe: Any) -> None:
    """A point or a line that is measured, with its name."""
    if probe.at:
        points = np.reshape(probe.at, (-1, 2))
        sheet.line(points, color="black", linewidth=2, marker="s", markersize=5, zorder=5)
        sheet.label(points.mean(axis=0), verbatim(probe.name), AXES["x"])


def force_arrow(sheet: Sheet, place: Any, way: Array, outward: Array, force: Array) -> Array:
    """The arrow of a force on an edge, beside it where the force is along it. Returns its free end."""
    if abs(force @ way) > 0.99 * np.hypot(*force):
        place = place + GAP * sheet.point * outward - ARROW / 2 * sheet.point * unit(force)
    return sheet.arrow(place, force, LOAD)


def draw_lattice(sheet: Sheet, scene: Any) -> None:
    """The lattice, and the boxes that are of its cells."""
    boxes = [(*lattice(scene), "grid")]
    boxes += [(scene.refine.region_lower, scene.refine.region_upper, "refines")] * bool(scene.refine.region_lower)
    is_box = scene.method.mass == "partial" and scene.method.consistent_region == "box"
    boxes += [(scene.method.consistent_lower, scene.method.consistent_upper, "consistent mass")] * is_box
    for lower, upper, name in boxes:
        sheet.box(lower, upper, color="0.6", linewidth=1.2)
        sheet.label(np.array(upper, dtype=float), name, AXES["x"])
