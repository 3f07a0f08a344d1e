#!/usr/bin/env python3
"""Cracked specimens whose energy release rate is known: scenes that come to rest, and G from handbooks, exact forms or converged
solutions. Lengths in mm where a name does not say otherwise.

Sources: Tada, Paris & Irwin, The Stress Analysis of Cracks Handbook; Kaya & Erdogan (1987) for the edge crack in tension, whose K
is good to all digits given; Suo & Hutchinson (1990) for the split beam; tests/reference/dcb_static.csv. The edge
crack in the short plate, K = 265602.34 Pa sqrt(m) by 1 MPa, is by a dislocation-density integral equation, good to 1e-5.

As a program: runs them all and writes a table of true and estimated errors, with bilinear cells and with quadratic ones of the same size.
"""

import re
from dataclasses import dataclass, field, replace
from math import cos, pi, sqrt, tan

from program_runs import Program
from tables import command_line, write

YOUNG, THICKNESS = 70e9, 0.01
PULL = 1e3                 # traction on the ends of plates [Pa]


@dataclass
class Specimen:
    """A scene, its G at rest [J/m2] by mode, how exact that is, and what a variant of it changes."""
    name: str
    scene: str
    g: tuple
    exact: float = 0.0     # relative uncertainty of g
    overrides: list = field(default_factory=list)
    modulus: float = YOUNG  # E'

    def uncertainty_of(self, column):
        """How far the known value of a column may be off, in its unit."""
        return self.exact * columns_of(self)[column] * (0.5 if column.startswith("K") else 1)


def columns_of(specimen):
    """The known values of the columns of a specimen: J, and of each mode that there is its G and K."""
    known = {"J": sum(specimen.g)}
    for mode, g in zip(("I", "II"), specimen.g):
        if g > 0:
            known |= {f"G_vcct_{mode}": g, f"G_domain_{mode}": g, f"K_{mode}": sqrt(specimen.modulus * g)}
    return known


def modulus(plane, poisson):
    return YOUNG if plane == "stress" else YOUNG / (1 - poisson**2)


def centre(ratio):
    """K/(sigma sqrt(pi a)) of a centre crack in tension, by a over half the width, to 0.1 %."""
    return (1 - 0.025 * ratio**2 + 0.06 * ratio**4) / sqrt(cos(pi * ratio / 2))


def double_edge(ratio):
    """The same of two edge cracks, by Benthem & Koiter, to 0.6 %."""
    return (1 + 0.122 * cos(pi * ratio / 2)**4) * sqrt(2 / (pi * ratio) * tan(pi * ratio / 2))


EDGE = {0.2: 1.3673, 0.3: 1.6599, 0.4: 2.1114, 0.5: 2.8246, 0.6: 4.0332}  # one edge crack in a long strip that may turn


def bending(ratio):
    """K B sqrt(W)/P of three-point bending over a span of 4 W, to 0.5 %."""
    return 6 * sqrt(pi * ratio) * (1.090 - 1.735 * ratio + 8.20 * ratio**2 - 14.18 * ratio**3 + 14.57 * ratio**4)


def compact(ratio):
    """K B sqrt(W)/P of the compact tension specimen, to 0.5 %."""
    return (2 + ratio) * (0.886 + 4.64 * ratio - 13.32 * ratio**2 + 14.72 * ratio**3 - 5.6 * ratio**4) / (1 - ratio)**1.5


def scene(width, height, tip, cell, loads, constraints, *, damping, end, plane="stress", poisson=0.3, lower=(0, 0), points=2,
          crack="kind = 'symmetry'", room=0.0, more="", young=YOUNG, courant=0.5):
    """A namelist: a rectangle from `lower`, of which the crack lies on y = 0 or a line."""
    low = [lower[0] - room, lower[1] - room]
    cells = [round((size + 2 * room) / cell + (1 if room == 0 else 0)) for size in (width, height)]
    text = f"""&run plane='{plane}' thickness={THICKNESS} end_time={end} /
&grid lower={low[0]}e-3,{low[1]}e-3 cell={cell}e-3 cells={cells[0]},{cells[1]} /
&material name='m' young={young} poisson={poisson} density=2700 /
&body material='m' lower={lower[0]}e-3,{lower[1]}e-3 upper={lower[0] + width}e-3,{lower[1] + height}e-3 points_per_cell={points} /
"""
    for x0, y0, x1, y1, fix in constraints:
        text += f"&constraint lower={x0}e-3,{y0}e-3 upper={x1}e-3,{y1}e-3 fix='{fix}' /\n"
    for kind, x0, y0, x1, y1, fx, fy in loads:
        text += (f"&load kind='{kind}' lower={x0}e-3,{y0}e-3 upper={x1}e-3,{y1}e-3 force={fx},{fy} history='ramp' "
                 f"rise_time={end / 8} /\n")
    return text + f"""&damping rate={damping} /
&method frame='total' courant={courant} scheme='musl' /
&refine rings=4 max_level=2 /
&crack {crack} tip={tip[0]}e-3,{tip[1]}e-3 /
&energy_release estimators='vcct','domain_integral','stress_closure' /
&output history_interval={end / 40} /
{more}"""


def edge_tension(a, width, cell, height=60, **more):
    """One edge crack, half by symmetry."""
    force = PULL * width * 1e-3 * THICKNESS
    return scene(width, height, (a, 0), cell, [("traction", 0, height, width, height, 0.0, force)],
                 [(a, 0, width, 0, "y"), (width, 0, width, 0, "x")], damping=4e4, end=2.4e-3, **more)


def centre_tension(a, width, cell, height=40, free_side=False, damping=1e5, end=0.4e-3, **more):
    """A crack in the middle or, with `free_side`, two edge cracks: a quarter by symmetry."""
    force = PULL * width * 1e-3 * THICKNESS
    side = width if free_side else 0
    return scene(width, height, (a, 0), cell, [("traction", 0, height, width, height, 0.0, force)],
                 [(a, 0, width, 0, "y"), (side, 0, side, height, "x")], damping=damping, end=end, **more)


def whole_plate(a, width, cell, height=40, **more):
    """A crack in the middle of a plate of half width `width`, without symmetry: two tips."""
    force = 2 * PULL * width * 1e-3 * THICKNESS
    ends = [("traction", -width, y, width, y, 0.0, f) for y, f in ((height, force), (-height, -force))]
    return scene(2 * width, 2 * height, (a, 0), cell, ends, [(-width, 0, -width, 0, "xy"), (width, 0, width, 0, "y")], damping=1e5,
                 end=0.4e-3, lower=(-width, -height), room=2.0, crack=f"kind='line' length={2 * a}e-3", **more)


def three_point_bending(a, width, cell, **more):
    """Half a beam of span 4 W, lying along y: pushed at y = 0 from the right, held at y = 2 W from the left."""
    half_force = 0.5
    return scene(width, 2.25 * width, (a, 0), cell, [("point", width, 0, width, 0, -half_force, 0.0)],
                 [(a, 0, width, 0, "y"), (0, 2 * width, 0, 2 * width, "x")], damping=3.5e4, end=1.2e-3, **more)


def compact_tension(a, width, cell, **more):
    """The upper half of a compact tension specimen without its hole: a point pulls in the middle of where that is."""
    return scene(1.25 * width, 0.6 * width, (a, 0), cell, [("point", 0, 0.275 * width, 0, 0.275 * width, 0.0, 1.0)],
                 [(a, 0, width, 0, "y"), (width, 0, width, 0, "x")], damping=5e4, end=1.2e-3, lower=(-0.25 * width, 0), **more)


def cantilever(cell, a=50, **more):
    """The upper half of the double cantilever beam, arms of 10 mm."""
    return scene(100, 10, (a, 0), cell, [("traction", 0, 0, 0, 10, 0.0, 1.0)], [(a, 0, 100, 0, "y")], damping=3.2e4, end=1.2e-3,
                 **more)


def split_beam(cell, upper, lower, **more):
    """A beam of 50 x 20 mm, split on half its length, with the moments `upper` and `lower` (of 5 N mm) on its arms."""
    loads = []
    for moment, y in ((upper, 10), (lower, 0)):
        if moment:
            loads += [("traction", 0, y + 5, 0, y + 10, moment, 0.0), ("traction", 0, y, 0, y + 5, -moment, 0.0)]
    return scene(50, 20, (25, 10), cell, loads, [(50, 0, 50, 20, "x"), (50, 10, 50, 10, "y")], damping=6e4, end=0.8e-3, room=5.0,
                 crack="kind = 'line' direction = 1.0,0.0", **more)


def end_notched(cell, **more):
    """The part between the inner loads of an end-notched beam in four-point bending: the moment is on the upper arm, the faces are
    pressed together by 50 kPa, without friction, and share it."""
    loads = [("traction", 0, 15, 0, 20, 1.0, 0.0), ("traction", 0, 10, 0, 15, -1.0, 0.0),
             ("traction", 0, 20, 50, 20, 0.0, -25.0), ("traction", 0, 0, 50, 0, 0.0, 25.0)]
    return scene(50, 20, (25, 10), cell, loads, [(50, 0, 50, 20, "x"), (50, 10, 50, 10, "y")], damping=6e4, end=0.8e-3, room=5.0,
                 crack="kind = 'line' direction = 1.0,0.0 contact = 'frictionless'", **more)


def from_factor(factor, a, e):
    """G of a plate under PULL."""
    return ((PULL * factor)**2 * pi * a * 1e-3 / e, 0.0)


def specimens():
    """All of them, by name."""
    u = (5e-3)**2 / (YOUNG * THICKNESS**2 * 0.01**3)
    dcb = 12 * 0.05**2 / (YOUNG * THICKNESS**2 * 0.01**3)
    tip = ["refine.indicator=tip"]

    def bend(a, w, e, p=1.0):
        return ((p / (THICKNESS * sqrt(w * 1e-3)) * bending(a / w))**2 / e, 0.0)

    def ct(a, w, e):
        return ((1.0 / (THICKNESS * sqrt(w * 1e-3)) * compact(a / w))**2 / e, 0.0)

    strain = {"plane": "strain"}
    es = modulus("strain", 0.3)
    found = [
        Specimen("edge 0.5", edge_tension(10, 20, 1.0), from_factor(EDGE[0.5], 10, YOUNG), 1e-4),
        Specimen("edge 0.5, tip", edge_tension(10, 20, 1.0), from_factor(EDGE[0.5], 10, YOUNG), 1e-4, tip),
        Specimen("edge 0.3", edge_tension(6, 20, 1.0), from_factor(EDGE[0.3], 6, YOUNG), 1e-4),
        Specimen("edge 0.25, short plate", edge_tension(10, 40, 1.25, height=40), (7.0544601e10 / YOUNG * 1e-6, 0.0), 1e-5),
        Specimen("edge 0.6, strain, 3 points", edge_tension(12, 20, 1.0, points=3, **strain), from_factor(EDGE[0.6], 12, es), 1e-4),
        Specimen("centre 0.4", centre_tension(8, 20, 2.0), from_factor(centre(0.4), 8, YOUNG), 2e-3),
        Specimen("centre 0.4, whole", whole_plate(8, 20, 1.0), from_factor(centre(0.4), 8, YOUNG), 2e-3),
        Specimen("centre 0.4, whole, tip", whole_plate(8, 20, 2.0), from_factor(centre(0.4), 8, YOUNG), 2e-3, tip),
        Specimen("centre 0.5", centre_tension(10, 20, 1.0), from_factor(centre(0.5), 10, YOUNG), 2e-3),
        Specimen("centre 0.3, strain, nu 0.45", centre_tension(6, 20, 1.0, plane="strain", poisson=0.45, courant=0.3),
                 from_factor(centre(0.3), 6, modulus("strain", 0.45)), 2e-3),
        Specimen("Griffith 0.1, tip", centre_tension(5, 50, 2.5, height=100, end=1.2e-3, damping=4e4), from_factor(centre(0.1), 5, YOUNG), 2e-3, tip),
        Specimen("double edge 0.5", centre_tension(10, 20, 1.0, free_side=True, height=60), from_factor(double_edge(0.5), 10, YOUNG),
                 1.2e-2),
        Specimen("three-point bending 0.5", three_point_bending(10, 20, 1.0), bend(10, 20, YOUNG), 1e-2),
        Specimen("three-point bending 0.3, tip", three_point_bending(6, 20, 1.0), bend(6, 20, YOUNG), 1e-2, tip),
        Specimen("compact 0.5", compact_tension(20, 40, 2.0), ct(20, 40, YOUNG), 1e-2),
        Specimen("compact 0.5, fine", compact_tension(20, 40, 1.0), ct(20, 40, YOUNG), 1e-2),
        Specimen("beam, 4 cells", cantilever(2.5), (1.28737 * dcb, 0.0), 1e-5),
        Specimen("beam, 8 cells", cantilever(1.25), (1.28737 * dcb, 0.0), 1e-5),
        Specimen("beam, 8 cells, tip", cantilever(1.25), (1.28737 * dcb, 0.0), 1e-5, tip),
        Specimen("beam, 4 cells, tip", cantilever(2.5), (1.28737 * dcb, 0.0), 1e-5, tip),
        Specimen("beam, 4 cells, 3 points", cantilever(2.5, points=3), (1.28737 * dcb, 0.0), 1e-5),
        Specimen("beam, 8 cells, strain", cantilever(1.25, **strain), (1.17150 * dcb, 0.0), 1e-5),
        Specimen("beam, 4 cells, strain", cantilever(2.5, **strain), (1.17150 * dcb, 0.0), 1e-5),
        Specimen("beam, 8 cells, 1 point", cantilever(1.25, points=1), (1.28737 * dcb, 0.0), 1e-5),
        Specimen("split beam, one moment", split_beam(1.25, 1, 0), (3 * u, 2.25 * u)),
        Specimen("split beam, opposite", split_beam(2.5, 1, -1), (12 * u, 0.0)),
        Specimen("split beam, equal", split_beam(1.25, 1, 1), (0.0, 9 * u)),
        Specimen("split beam, equal, 4 cells", split_beam(2.5, 1, 1), (0.0, 9 * u)),
        Specimen("end notched", end_notched(1.25), (0.0, 2.25 * u)),
        Specimen("end notched, 4 cells", end_notched(2.5), (0.0, 2.25 * u)),
    ]
    for specimen in found:
        if "plane='strain'" in specimen.scene:
            specimen.modulus = modulus("strain", 0.45 if "0.45" in specimen.name else 0.3)
    return {specimen.name: specimen for specimen in found}


def with_quadratic_cells(specimen, points=3):
    """The same at rest, with quadratic cells of the same size."""
    scene = re.sub(r"points_per_cell=\d", f"points_per_cell={points}", specimen.scene).replace("&grid ", "&grid order=2 ")
    scene = re.sub(r"&method .* /", "&method frame='total' time='static' /", scene).replace(",'stress_closure'", "")
    return replace(specimen, scene=re.sub(r"&damping.*\n", "", scene))


def main():
    arguments = command_line(__doc__, list(specimens()), "results/error_specimens")
    found = specimens()
    table("errors", {name: found[name] for name in arguments.part}, arguments)
    kept = [name for name in arguments.part if "point," not in name and not re.search("points?$|notched", name)]
    table("quadratic", {name: with_quadratic_cells(found[name]) for name in kept}, arguments)


def table(title, chosen, arguments):
    columns = ["J", "VCCT", "K"]
    rows = [["specimen"] + [f"{c}, {what}" for c in columns for what in ("error [%]", "estimate [%]", "ratio")]]
    for name, specimen in chosen.items():
        values = Program(arguments.program, arguments.output)(specimen.scene, specimen.overrides).columns
        mode = "I" if specimen.g[0] >= specimen.g[1] else "II"
        row = [name]
        for column in ("J", f"G_vcct_{mode}", f"K_{mode}"):
            known = columns_of(specimen)[column]
            error, estimate = abs(values[column][-1]) / known - 1, values[column + "_error"][-1] / known
            row += [f"{100 * error:+.2f}", f"{100 * estimate:.2f}", f"{estimate / abs(error):.1f}"]
        rows.append(row)
    write(rows, title, arguments.output)


if __name__ == "__main__":
    main()
