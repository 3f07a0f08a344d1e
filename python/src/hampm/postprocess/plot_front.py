"""Energy release rate and stress intensity factors along the front of a crack in a solid.

A model with &crack has them in its result, at every row of the history: the script shows those of the last, or with --csv of all. --quantity names
what is drawn over the way along the front or --over a coordinate, --number the front where there are several. With error bars as they were estimated.
Of a front that grows --fronts draws where it is at several rows.

Without &crack, in snapshots: the crack is what a constraint leaves free of a plane of symmetry: a box without thickness, named by --ligament, that holds
the direction normal to it. One of its edges is the front, the others are on surfaces. G comes from a domain integral whose test functions are hats along the front,
and for comparison from the forces on the nodes of the front and the opening one cell behind them. Cells at the front have to be of one size, as
many cells around as the domain is wide; it is as wide as they allow unless --cells says less.

Prints the table of the last row or snapshot, or with --csv of all of them, and draws along the front where --output is given.
"""

from __future__ import annotations

import itertools
from argparse import Namespace
from collections import namedtuple
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from ..arrays import Array
from ..errors import ResultError
from ..signals import read_curve
from ..snapshots import DEEPEST, Block
from ..stored import Stored, opened
from ..stored_model import StoredModel
from .pictures import COLOURS, MM, name_curves, picture_parser, plt, positive, write

FINITE = ("neo_hookean", "mooney_rivlin")
ROUNDING = 1e-6   # cells
MOST = 64         # cells around the front that are looked at

Front = namedtuple("Front", "axes signs origin length held")
Front.__doc__ = """Axes of the crack: direction of growth, normal into the body, and along the front; their signs, the place of the front's end [m]
and its length [m]; boxes of constraints, with what they hold."""
Curve = namedtuple("Curve", "time place domain closure mean closure_mean cells")
Curve.__doc__ = "A time [s], places along the front from its end [m], G by domain and by closure there, their means [J/m2], and the width of the domain in cells."


def main(arguments: Sequence[str] | None = None) -> Any:
    options = parse(arguments)
    if options.ligament is None:
        show_measured(options)
        return
    tell_all(curves_of(options), options.csv)
    if options.output:
        write(figure, options, "_front", quiet=True)


def figure(options: Namespace) -> Figure:
    """The picture that these options ask for."""
    if options.ligament is not None:
        return draw(curves_of(options)[-1], options)
    times, columns = measured(options)
    return draw_fronts(times, columns, options) if options.fronts else draw_measured(columns, options)


def show_measured(options: Namespace) -> None:
    """What the program has measured along a front: as a table, as values with every digit, as a picture."""
    times, columns = measured(options)
    shown = ["arc", *(name for name in columns if name[0] in "GK")]
    if options.csv:
        print(",".join(["time", *columns]))
        for row, time in enumerate(times):
            for values in zip(*(column[row] for column in columns.values())):
                print(",".join(f"{value:.17g}" for value in (time, *values)))
    else:
        print(f"time {times[-1]:.6g} s\n" + " ".join(f"{name + ' [mm]' if name == 'arc' else name:>12}" for name in shown))
        for values in zip(*(columns[name][-1] * (MM if name == "arc" else 1) for name in shown)):
            print(" ".join(f"{value:12.6g}" for value in values))
    if options.output:
        write(figure, options, "_front", quiet=True)


def measured(options: Namespace) -> tuple[Array, dict[str, Array]]:
    """Times of the rows, and columns of the front by their names, each (rows, places)."""
    ending = "" if options.number == 1 else f"_front{options.number}"
    with opened(options.files[0]) as stored:
        if not stored.has(f"front/arc{ending}"):
            raise ResultError(f"{stored.path}: has no values along a front {options.number}; a crack of a solid has them, others need --ligament")
        times = stored.numbers("history/time", finite=True)
        names = [name for name in stored.names("front") if name.endswith(ending) and "_front" not in name.removesuffix(ending)]
        columns = {name.removesuffix(ending): stored.numbers(f"front/{name}", dims=2) for name in names}
    if options.quantity not in columns:
        raise ResultError(f"{options.files[0]}: the front has no '{options.quantity}'; it has {', '.join(name for name in columns if name[0] in 'GK')}")
    return times, columns


def draw_measured(columns: Mapping[str, Array], options: Namespace) -> Figure:
    """One quantity along the front, over what it is divided by."""
    figure, axes = plt.subplots(figsize=(6.5, 3.6), layout="constrained")
    values = columns[options.quantity][-1] / options.scale
    error = columns.get(f"{options.quantity}_error")
    axes.errorbar(MM * columns[options.over][-1], values, yerr=None if error is None else error[-1] / options.scale, fmt="o-", color=COLOURS[0], markersize=3,
                  linewidth=1, capsize=2, label=options.quantity.replace("_", " "))
    if options.reference:
        axes.plot(*(factor * values for factor, values in zip((MM, 1), read_curve(options.reference))), color=COLOURS[6], linewidth=1, label="reference")
    unit = "" if options.scale != 1 else " [J/m²]" if options.quantity[0] == "G" else " [Pa m$^{0.5}$]"
    axes.set(xlabel="way along the front [mm]" if options.over == "arc" else f"{options.over} [mm]", ylabel=options.quantity.replace("_", " ") + unit, title=options.title or "")
    name_curves(figure, [axes])
    return figure


def draw_fronts(times: Array, columns: Mapping[str, Array], options: Namespace) -> Figure:
    """Where the front is at rows between the first and the last, in its plane."""
    places = np.array([columns[name] for name in "xyz"])
    first, second = sorted(np.argsort(np.nanmax(places, axis=(1, 2)) - np.nanmin(places, axis=(1, 2)))[1:])
    figure, axes = plt.subplots(figsize=(4.6, 4.2), layout="constrained")
    for part in np.linspace(0, 1, options.fronts):
        row = round(part * (len(times) - 1))
        line = places[[first, second], row]
        gap = np.linalg.norm(line[:, 0] - line[:, -1])
        if gap < 1.5 * np.max(np.linalg.norm(np.diff(line), axis=0)):                      # all around
            line = np.append(line, line[:, :1], axis=1)
        axes.plot(*(MM * line), "o-", color=plt.get_cmap("viridis")(0.9 * part), markersize=2, linewidth=1, label=f"{times[row]:.6g}")
    axes.set(xlabel=f"{'xyz'[first]} [mm]", ylabel=f"{'xyz'[second]} [mm]", title=options.title or "", aspect="equal")
    axes.legend(title="time [s]", fontsize="small", loc="upper right")
    return figure


def curves_of(options: Namespace) -> list[Curve]:
    """G along the front in the last snapshot, or in all."""
    with opened(options.files[0]) as stored:
        model = StoredModel(stored.text("input/namelist"), options.files[0])
        front = front_of(model, options.ligament)
        times = stored.numbers("VTKHDF/particles/Steps/Values", finite=True)
        if not len(times):
            raise ResultError(f"{options.files[0]}: holds no snapshots yet")
        numbers = range(len(times)) if options.csv else [len(times) - 1]
        return [curve(stored, model, front, number, times[number], options) for number in numbers]


def parse(arguments: Sequence[str] | None) -> Namespace:
    parser = picture_parser(__doc__, "_front", "result file with snapshots", nargs=1)
    parser.add_argument("--quantity", default="G", metavar="NAME", help="G, K_I, K_II or K_III (default: G)")
    parser.add_argument("--over", default="arc", choices=("arc", "x", "y", "z"), help="way along the front, or coordinate, over which it is drawn")
    parser.add_argument("--number", type=int, default=1, metavar="N", help="of the front, where there are several (default: 1)")
    parser.add_argument("--fronts", type=int, default=0, metavar="N", help="draw where the front is at N rows, from the first to the last")
    parser.add_argument("--ligament", metavar="NAME", help="without &crack: the &constraint whose edge is the front")
    parser.add_argument("--segments", type=int, metavar="N", help="parts of the front between hats (default: one a cell)")
    parser.add_argument("--cells", type=int, default=MOST, metavar="N", help="cells by which the domain reaches around the front, at most")
    parser.add_argument("--scale", type=positive, default=1.0, metavar="G", help="what the values are divided by")
    parser.add_argument("--reference", metavar="FILE.csv", help="reference curve: rows of place [m], value")
    parser.add_argument("--csv", action="store_true", help="write comma-separated values of all snapshots with every digit")
    return parser.parse_args(arguments)


def front_of(model: StoredModel, name: str) -> Front:
    """The front, by the stored namelist."""
    if len(model.numbers("grid", "lower")) != 3:
        raise ResultError(f"{model.path}: is no result of the program for solids")
    boxes = [(np.array([model.numbers("constraint", key, n, 3) for key in ("lower", "upper")]), model.text("constraint", "fix", n),
              model.text("constraint", "name", n)) for n in range(1, model.count("constraint") + 1)]
    bodies = np.array([[model.numbers("body", key, n, 3) for key in ("lower", "upper")] for n in model.body_groups()])
    lower, upper = bodies[:, 0].min(axis=0), bodies[:, 1].max(axis=0)
    found = [(box, fix) for box, fix, of in boxes if of == name]
    if len(found) != 1:
        raise ResultError(f"{model.path}: the model has {len(found)} constraints named '{name}'; one is asked for")
    box, fix = found[0]
    near = ROUNDING * model.cell()
    flat = [d for d in range(3) if box[1, d] - box[0, d] < near and "xyz"[d] in fix
            and min(abs(box[0, d] - lower[d]), abs(box[0, d] - upper[d])) < near]
    if len(flat) != 1:
        raise ResultError(f"{model.path}: '{name}' is no rectangle on a side of the bodies that holds the direction normal to it")
    normal = flat[0]
    edges = [(d, side) for d in range(3) for side in (0, 1) if d != normal and lower[d] + near < box[side, d] < upper[d] - near]
    if len(edges) != 1:
        raise ResultError(f"{model.path}: {len(edges)} edges of '{name}' are inside of the bodies' sides; a straight crack front is one")
    growth, side = edges[0]
    along = 3 - normal - growth
    origin = np.array([box[side, growth], box[0, normal], lower[along]])
    return Front([growth, normal, along], np.array([1 - 2 * side, 1 if box[0, normal] < lower[normal] + near else -1, 1]), origin,
                 upper[along] - lower[along], [(b, [d for d in range(3) if "xyz"[d] in f]) for b, f, _ in boxes])


def curve(stored: Stored, model: StoredModel, front: Front, number: int, time: float, options: Namespace) -> Curve:
    """G along the front in a snapshot."""
    fields, h = fields_of(stored, model, front, number)
    lattice = Lattice(fields, h, front, options.cells, model)
    segments = lattice.size[2] - 1 if options.segments is None else options.segments
    if not 0 < segments < lattice.size[2] or (lattice.size[2] - 1) % segments:
        raise ResultError(f"--segments {segments}: the front has {lattice.size[2] - 1} cells, which so many parts do not divide")
    step = (lattice.size[2] - 1) // segments
    hats = np.maximum(0, 1 - np.abs(np.arange(lattice.size[2])[None] / step - np.arange(segments + 1)[:, None]))
    lengths = hats @ lattice.lengths
    domain, closure = hats @ lattice.domain_integral(), hats @ lattice.closure()
    return Curve(time, step * h * np.arange(segments + 1), domain / lengths / options.scale, closure / lengths / options.scale,
                 domain.sum() / front.length / options.scale, closure.sum() / front.length / options.scale, lattice.reach)


def fields_of(stored: Stored, model: StoredModel, front: Front, number: int) -> tuple[dict[str, Array], float]:
    """Fields of the particles of a snapshot in the axes of the crack, and the size of the finest cells [m]."""
    def part(block: str, name: str, count: str, dims: int, **limits: Any) -> Array:
        counts = stored.numbers(f"VTKHDF/{block}/{count}", whole=True, least=0)
        if len(counts) <= number or counts[number] == 0:
            raise stored.wrong(f"VTKHDF/{block}/{count}", f"says that snapshot {number} holds nothing")
        return stored.numbers(f"VTKHDF/{block}/{name}", dims=dims, first=int(counts[:number].sum()), count=int(counts[number]), finite=True, **limits)

    h = model.cell() * 0.5 ** part("mesh", "CellData/level", "NumberOfCells", 1, least=0, most=DEEPEST).max()
    of = {name: part("particles", name, "NumberOfPoints", 1 if name.split("/")[-1] in ("body", "energy_density") or "stress" in name else 2,
                     **({"least": 1, "most": len(model.body_groups())} if name.endswith("body") else {}))
          for name in ("Points", "PointData/displacement", "PointData/deformation_gradient", "PointData/energy_density", "PointData/body",
                       *(f"PointData/stress_{a}{b}" for a, b in itertools.combinations_with_replacement("xyz", 2)))}
    if [of[name].shape[1] for name in ("Points", "PointData/displacement", "PointData/deformation_gradient")] != [3, 3, 9]:
        raise ResultError(f"{stored.path}: is no result of the program for solids")
    turn = np.zeros((3, 3))
    turn[np.arange(3), front.axes] = front.signs
    x = of["Points"] - of["PointData/displacement"]
    deformation = of["PointData/deformation_gradient"].reshape(-1, 3, 3)
    stress = np.empty((len(x), 3, 3))
    for a, b in itertools.combinations_with_replacement(range(3), 2):
        stress[:, a, b] = stress[:, b, a] = of["PointData/stress_" + "xyz"[a] + "xyz"[b]]
    number_of = {model.text("material", "name", n): n for n in range(1, model.count("material") + 1)}
    groups = [number_of[model.text("body", "material", n)] for n in model.body_groups()]
    laws = [model.text("material", "law", n) for n in groups]
    if not set(laws) <= {"linear_elastic", *FINITE}:
        raise ResultError(f"{model.path}: the domain integral is that of elastic laws: linear_elastic, {', '.join(FINITE)}")
    body = of["PointData/body"].astype(int) - 1
    finite = np.isin(laws, FINITE)[body]
    stress[finite] = stress[finite] @ np.linalg.inv(deformation[finite]).transpose(0, 2, 1)   # P of Kirchhoff's stress

    def rotated(tensor: Array) -> Array:
        return turn @ tensor @ turn.T
    return {"x": (x @ turn.T) - front.origin * front.signs, "u": of["PointData/displacement"] @ turn.T, "slope": rotated(deformation - np.eye(3))[:, :, 0],
            "stress": rotated(stress), "energy": of["PointData/energy_density"], "material": np.array(groups)[body]}, h


class Lattice:
    """The cells around a front, all of one size, their nodes, and what particles give to these.

    size      number of nodes along each axis; the front is at the number `reach` of the first, 0 of the second
    reach     cells by which the domain reaches around the front
    lengths   part of the front that belongs to each node [m]
    """

    def __init__(self, fields: Mapping[str, Array], h: float, front: Front, most: int, model: StoredModel) -> None:
        at = fields["x"] / h
        across = int(round(front.length / h))
        near = (np.abs(at[:, 0]) < MOST) & (at[:, 1] < MOST)
        at, fields = at[near], {name: values[near] for name, values in fields.items()}
        cell = np.floor(at).astype(int)
        off = np.abs(np.abs(at - cell - 0.5) - 0.25).max(axis=1) > 1e-3
        ring = np.maximum(np.where(cell[:, 0] < 0, -1 - cell[:, 0], cell[:, 0]), cell[:, 1])
        expected = 8 * across * (2 * (np.arange(MOST) + 1) ** 2 - 2 * np.arange(MOST) ** 2)
        complete = (np.bincount(ring, minlength=MOST)[:MOST] == expected) & (np.bincount(ring, off, minlength=MOST)[:MOST] == 0)
        self.reach = min(int(np.argmin(complete)) if not complete.all() else MOST, most + 1) - 1
        cells = np.ravel_multi_index((cell[ring <= self.reach] + [self.reach + 1, 0, 0]).T, (2 * self.reach + 2, self.reach + 1, across), mode="wrap") \
            if self.reach >= 2 else np.zeros(1, dtype=int)
        if np.any(np.bincount(cells) != 8):
            raise ResultError(f"{model.path}: the front has to be on an edge of cells, with three cells and more of one size around it"
                              " and eight particles in their places in each (--cells not below 2)")
        self._fields = {name: values[ring <= self.reach] for name, values in fields.items()}
        self._at, self._cell = at[ring <= self.reach], cell[ring <= self.reach] + [self.reach + 1, 0, 0]
        self.size, self.h, self._front, self.middle = (2 * self.reach + 3, self.reach + 2, across + 1), h, front, self.reach + 1
        self.lengths = h * np.where(np.isin(np.arange(across + 1), (0, across)), 0.5, 1.0)
        self._check_loads(model)
        row = self._cell[:, 1] * self.size[2] + self._cell[:, 2]
        first = np.zeros(row.max() + 1, dtype=int)
        first[row] = self._fields["material"]
        if np.any(first[row] != self._fields["material"]):
            raise ResultError(f"{model.path}: material changes along the crack within {self.reach} cells of the front; give --cells a smaller number")
        inside = self._at - np.floor(self._at)
        self._corners = [(np.ravel_multi_index((self._cell + c).T, self.size), np.where(c, inside, 1 - inside), np.where(c, 1, -1))
                         for c in map(np.array, itertools.product((0, 1), repeat=3))]
        self.volume = h**3 / 8
        self.force = -self.nodal(lambda n, dn: np.einsum("nij,nj->ni", self._fields["stress"], dn))
        self.divergence = self.force / self.nodal(lambda n, dn: n[:, None])
        for d in range(3):
            self.divergence[self.holds(d), d] = 0

    def _check_loads(self, model: StoredModel) -> None:
        front = self._front
        low = np.array([-self.reach, 0, 0]) * self.h
        high = np.array([self.reach, self.reach, self.size[2]]) * self.h
        for n in range(1, model.count("load") + 1):
            corners = [np.array(model.numbers("load", key, n))[front.axes] * front.signs - front.origin * front.signs for key in ("lower", "upper")
                       if len(model.numbers("load", key, n)) == 3]
            if model.text("load", "kind", n) == "traction" and len(corners) == 2 and \
                    np.all(np.maximum(*corners) >= low) and np.all(np.minimum(*corners) <= high):
                raise ResultError(f"{model.path}: the domain of {self.reach} cells reaches a traction; give --cells a smaller number")

    def nodal(self, values: Callable[[Array, Array], Any]) -> Array:
        """Sums over the particles at the nodes, of their volumes times values(functions, gradients)."""
        total: Any = 0
        for node, n, sign in self._corners:
            gradient = np.stack([sign[d] * np.prod(np.delete(n, d, axis=1), axis=1) for d in range(3)], axis=1) / self.h
            given = self.volume * values(np.prod(n, axis=1), gradient)
            total = total + np.stack([np.bincount(node, column, minlength=np.prod(self.size)) for column in given.T], axis=1)
        return total

    def holds(self, d: int) -> Array:
        """Nodes that some constraint holds in an axis of the crack."""
        front = self._front
        places = (np.indices(self.size).reshape(3, -1).T - [self.middle, 0, 0]) * self.h + front.origin * front.signs
        held = np.zeros(len(places), dtype=bool)
        for box, fixed in front.held:
            if front.axes[d] in fixed:
                ends = np.sort(box[:, front.axes] * front.signs, axis=0)
                held |= np.all((places > ends[0] - ROUNDING * self.h) & (places < ends[1] + ROUNDING * self.h), axis=1)
        return held

    def domain_integral(self) -> Array:
        """G times the length of front at each of its nodes: sum V ((u_i,1 P_iJ - W d_1J) q,J + u_i,1 (div P)_i q), twice that of the half model.
        In the plane q is 1 in the cells at the front, and falls to 0."""
        slope = self._fields["slope"]
        flux = np.einsum("ni,nij->nj", slope, self._fields["stress"])
        flux[:, 0] -= self._fields["energy"]
        inertia = np.einsum("ni,ni->n", slope, sum(np.prod(n, axis=1)[:, None] * self.divergence[node] for node, n, _ in self._corners))
        given = self.nodal(lambda n, dn: (np.sum(flux * dn, axis=1) + inertia * n)[:, None]).reshape(self.size)
        first, second = (np.clip((self.reach - np.abs(np.arange(n) - at)) / (self.reach - 1), 0, 1) for n, at in zip(self.size, (self.middle, 0)))
        return 2 * np.einsum("i,j,ijk->k", first, second, given)

    def closure(self) -> Array:
        """The same by the force on each node of the front and the opening one cell behind it."""
        opening, cells = np.zeros((2, np.prod(self.size)))
        for node, n, _ in self._corners:
            opening += np.bincount(node, np.prod(4 * n - 1.5, axis=1) * self._fields["u"][:, 1], minlength=opening.size)
            cells += np.bincount(node, minlength=opening.size)
        opening, cells = opening.reshape(self.size), cells.reshape(self.size) / 8
        force = self.force.reshape(*self.size, 3)[self.middle, 0, :, 1]
        behind = self.middle - 1
        return np.abs(force) * opening[behind, 0] / cells[behind, 0] / self.h


def tell_all(curves: Sequence[Curve], as_csv: bool) -> None:
    """The table of the curves."""
    if as_csv:
        print("time,place,domain,closure")
        for of in curves:
            for row in zip(of.place, of.domain, of.closure):
                print(",".join(f"{value:.17g}" for value in (of.time, *row)))
        return
    for of in curves:
        print(f"time {of.time:.6g} s, domain of {of.cells} cells around the front\n{'place [mm]':>12} {'domain':>12} {'closure':>12}")
        for place, domain, closure in zip(of.place, of.domain, of.closure):
            print(f"{MM * place:12.5g} {domain:12.6g} {closure:12.6g}")
        print(f"{'mean':>12} {of.mean:12.6g} {of.closure_mean:12.6g}")


def draw(of: Curve, options: Namespace) -> Figure:
    """G along the front."""
    figure, axes = plt.subplots(figsize=(6.5, 3.6), layout="constrained")
    for name, values, colour, style in (("domain", of.domain, COLOURS[0], "o-"), ("closure", of.closure, COLOURS[1], "s--")):
        axes.plot(MM * of.place, values, style, color=colour, markersize=3, label=name)
    if options.reference:
        axes.plot(*(factor * values for factor, values in zip((MM, 1), read_curve(options.reference))), color=COLOURS[6], linewidth=1, label="reference")
    axes.set(xlabel="place along the front [mm]", ylabel="$G$ [J/m²]" if options.scale == 1 else "$G / G_\\mathrm{ref}$", title=options.title or "")
    name_curves(figure, [axes])
    return figure
