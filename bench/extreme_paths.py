"""The part `paths` of the atlas of extremes: cracks that ignore the grid, in places and by methods that are hard for the cells which
they cut.

A square of 16 x 16 cells of size 1 around the origin, density 1 and dilatational wave speed 1. Straight cracks have the edge loads
by which the square is part of an infinite plate: K_I and K_II are then known whatever the angle and the place (`cracks.py`).
"""

import itertools
import math
import re

import numpy as np
from cracks import THICKNESS, cut_out, direction, tension
from extreme_scenes import Cell, method_of, stored
from mass_matrices import KINDS, SCHEMES, body, group

HALF = 8  # of the side of the square [cells]
STRESS = 1e-6  # far away, over the modulus of dilatational waves
REST = {"time": "'static'"}
MAY_CLOSE = ("stable", "warned")  # faces that nothing keeps apart may interpenetrate, of which the program warns
MAY_SPLIT = MAY_CLOSE  # particles on a crack are split, of which it warns too
MOTION = 60.0  # some four passages of the square [cell/wave speed]


def modulus(poisson):
    """E' of plane strain where dilatational waves have speed 1."""
    return young(poisson) / (1 - poisson**2)


def young(poisson):
    return (1 + poisson) * (1 - 2 * poisson) / (1 - poisson)


def square(cracks, method, loads=None, poisson=0.3, levels=0, end=MOTION, velocity=(0.0, 0.0), estimators="'domain_integral'",
           law="linear_elastic", contact="", points=2, half=HALF, stress=STRESS):
    """The namelist of the square with cracks, each a list of points; under tension in y where no loads are given."""
    text = group("run", plane="'strain'", thickness=THICKNESS, end_time=end)
    text += group("grid", lower=f"{-half - 1}, {-half - 1}", cell=1.0, cells=f"{2 * half + 2}, {2 * half + 2}")
    text += group("material", name="'m'", law=f"'{law}'", young=young(poisson), poisson=poisson, density=1.0)
    text += body((-half, -half), (half, half), velocity).replace("&body\n", f"&body\n   points_per_cell = {points}\n")
    text += group("method", **method) + "\n".join(loads or tension((half, half), stress)) + "\n"
    text += group("output", history_interval=min(end / 2, 1.0))
    if levels:
        text += group("refine", indicator="'tip'", max_level=levels, rings=3)
    text += group("energy_release", estimators=estimators, energy_balance=".true." if method.get("time") is None else ".false.")
    return text + "".join("&crack kind = 'path'  points = " + ", ".join(repr(float(x)) for point in crack for x in point) + contact + " /\n"
                          for crack in cracks)


def tips(h):
    """The ends of the names of the columns of each tip."""
    return [""] + [name[3:] for name in h if name.startswith("K_I_tip")]


def release_error(asked, h):
    """Largest relative error of G over the tips at the end."""
    return max(abs(h["G" + end][-1] / asked - 1) for end in tips(h))


def audit(most, h):
    """How far the audit of energies is from closed, over the largest energy; infinite where G is no number or beyond `most` in size."""
    g = np.array([h["G" + end] for end in tips(h)]) if "G" in h else np.zeros(1)
    if not np.all(np.abs(g) <= most):
        return math.inf
    losses = sum(h.get(name, 0.0) for name in ("damping_loss", "numerical_loss", "friction_loss", "fracture_energy"))
    rest = stored(h) - stored(h)[0] + losses - h["external_work"]
    return np.abs(rest).max() / max(stored(h).max(), 1e-300)


# --- places -----------------------------------------------------------------------------------------------------------

A_HAIR = (1e-6, 1e-9, 1e-12, 1e-15)  # of a cell

# With four cells to the half-length. A particle that comes to the other side of the crack, and a tip that enters a cell, move G
QUANTITY, BOUND = "G of a crack of 8 cells against an infinite plate", 0.15
CLOSURE = "closure of the energy balance"
MOVING = CLOSURE + ", G below 10 times that at rest"


def straight():
    """Name, first and last point of cracks in awkward places; the one that they are a hair away from, if any, and how far they may differ
    from it."""
    yield "through corners", (-2.9, -2.9), (2.9, 2.9), None, None
    yield "through corners, tips on nodes", (-3, -3), (3, 3), None, None
    yield "along edges of cells", (-4.3, 1), (3.6, 1), None, None
    yield "along edges of cells, tips on nodes", (-4, 1), (4, 1), None, None
    yield "upright along edges of cells", (1, -4.3), (1, 3.6), None, None
    yield "through particles", (-4.3, 0.25), (3.6, 0.25), None, None
    yield "through particles, tips on particles", (-4.25, 0.25), (3.75, 0.25), None, None
    yield "diagonal through particles", (-3.25, -3.25), (2.75, 2.75), None, None
    yield "tips on edges of cells", (-4, -1.3), (4, 1.4), None, None
    yield "tips on nodes", (-4, -1), (4, 2), None, None
    yield "no particle on one side in the cells of the tips", (-4.2, -1.05), (4.2, 1.05), None, None
    yield "tips on edges of cells, close to corners", (-4.1, -1), (4.1, 2), None, None
    for h in A_HAIR:
        for sign in (h, -h):
            yield f"{sign:+g} beside edges of cells", (-4.3, 1 + sign), (3.6, 1 + sign), "along edges of cells", 1e-6
            yield f"{sign:+g} inclined", (-4.3, 1 - sign), (3.6, 1 + sign), "along edges of cells", 1e-6
            yield f"{sign:+g} beside particles", (-4.3, 0.25 + sign), (3.6, 0.25 + sign), "through particles", BOUND
            yield f"{sign:+g} beside corners", (-2.9, -2.9 + sign), (2.9, 2.9 + sign), "through corners", BOUND
            yield f"tips {sign:+g} beyond nodes", (-4 - sign, -1), (4 + sign, 2), "tips on nodes", BOUND


def ends_of(first, last):
    """Half-length, middle and angle of a crack between two points."""
    first, last = np.array(first, float), np.array(last, float)
    return np.linalg.norm(last - first) / 2, (first + last) / 2, math.degrees(math.atan2(*(last - first)[::-1]))


def places(runner):
    """Straight cracks at rest, against an infinite plate and each other, and set in motion by a step."""
    cells, found = [], {}
    for name, first, last, near, bound in straight():
        a, middle, beta = ends_of(first, last)
        loads = cut_out(HALF, 2 * HALF, a, middle, beta, *(STRESS * direction(40)))
        asked = STRESS**2 * math.pi * a / modulus(0.3)

        def number(h, name=name, asked=asked):
            found[name] = [h["G" + end][-1] for end in tips(h)]
            return release_error(asked, h)
        cells.append(runner.judge(f"{name}, at rest", square([[first, last]], REST, loads), QUANTITY, BOUND, number, MAY_SPLIT))
        if near and name in found:
            differ = max(abs(one / other - 1) for one, other in zip(found[name], found[near]))
            outcome = "stable" if differ <= bound else "defect"
            cells.append(Cell(f"{name}, {near}", outcome, f"G against a place 1e-6 of a cell away or less, to {bound:g}", differ, bound))
        cells.append(runner.judge(f"{name}, in motion", square([[first, last]], {}, loads), MOVING, 1e-10,
                                  lambda h, most=10 * asked: audit(most, h), MAY_CLOSE))
    return cells


# --- shapes -----------------------------------------------------------------------------------------------------------

LINE = [(-4.3, 0.4), (3.6, 0.4)]
EDGE = [(-HALF, 0.4), (1.3, 0.4)]


def shapes():
    """Name, cracks, those that they are to be like if any, bound of the difference over what the crack has let free, allowed outcomes."""
    stable, refused = ("stable",), ("refused",)
    zigzag = [(-4.3 + 1.075 * k, 0.45 if k % 2 else 0.35) for k in range(9)]
    yield "zigzag, a tenth of a cell high", [zigzag], [[(-4.3, 0.4), (4.3, 0.4)]], 0.05, stable
    yield "zigzag, two cells high", [[(-4 + k, 0.9 if k % 2 else -0.9) for k in range(9)]], None, None, MAY_CLOSE
    yield "zigzag with segments of less than a cell", [[(-2 + k / 4, 0.1 if k % 2 else -0.1) for k in range(17)]], None, None, refused
    yield "in the edge of the body", [[(-4, HALF), (4, HALF)]], [], 1e-9, ("stable", "refused")
    yield "1e-9 inside the edge of the body", [[(-20, HALF - 1e-9), (20, HALF - 1e-9)]], [], 1e-6, ("stable", "refused")
    yield "0.1 inside the edge of the body", [[(-20, HALF - 0.1), (20, HALF - 0.1)]], None, None, None
    yield "1e-9 outside of the body", [[(-4, HALF + 1e-9), (4, HALF + 1e-9)]], [], 1e-9, ("stable", "refused")
    yield "from the edge", [EDGE], [[(-HALF - 3, 0.4), (1.3, 0.4)]], 1e-9, stable
    yield "from 1e-9 beyond the edge", [[(-HALF - 1e-9, 0.4), (1.3, 0.4)]], [EDGE], 1e-9, stable
    yield "from 1e-9 inside the edge", [[(-HALF + 1e-9, 0.4), (1.3, 0.4)]], [EDGE], 1e-6, ("stable", "refused")
    yield "from a node of the edge", [[(-HALF, 1), (1.3, 2.4)]], None, None, stable
    yield "from a corner of the body", [[(-HALF, -HALF), (-1.3, 0.4)]], None, None, stable
    yield "grazes a corner of the body", [[(-HALF - 1, HALF - 1), (-HALF + 1, HALF + 1)]], [], 1e-9, ("stable", "refused")
    yield "cuts a corner off", [[(-HALF - 1, HALF - 1.5), (-HALF + 1.5, HALF + 1)]], None, None, ("stable", "stopped", "refused")
    yield "the same crack twice", [LINE, LINE], [LINE], 1e-9, ("stable", "refused")
    yield "two cracks 1e-9 apart", [LINE, [(x, y + 1e-9) for x, y in LINE]], [LINE], 1e-6, ("stable", "refused")
    yield "one crack inside another", [LINE, [(-2.3, 0.4), (1.6, 0.4)]], [LINE], 1e-9, ("stable", "refused")
    yield "two that overlap in line", [[(-4.3, 0.4), (1.2, 0.4)], [(-1.1, 0.4), (3.6, 0.4)]], [LINE], 1e-9, ("stable", "refused")
    yield "two that touch end to end", [[(-4.3, 0.4), (0.1, 0.4)], [(0.1, 0.4), (3.6, 0.4)]], [LINE], 1e-9, ("stable", "refused")
    yield "two with a gap of 1e-9", [[(-4.3, 0.4), (0.1, 0.4)], [(0.1 + 1e-9, 0.4), (3.6, 0.4)]], [LINE], 1e-6, ("stable", "refused")
    yield "goes back on itself", [[(-4.3, 0.4), (3.6, 0.4), (1.0, 0.4)]], None, None, refused
    yield "goes back beside itself", [[(-4.3, 0.4), (3.6, 0.4), (1.0, 0.4 + 1e-9)]], None, None, refused
    yield "points in line", [[(-4.3, 0.4), (-1.0, 0.4), (2.0, 0.4), (3.6, 0.4)]], [LINE], 1e-9, stable
    yield "backwards", [LINE[::-1]], [LINE], 1e-9, stable
    yield "a closed triangle", [[(-2.2, -1.3), (2.3, -1.1), (0.2, 2.4), (-2.2, -1.3)]], None, None, ("refused", "stopped", "stable")
    triangle = [[(-4.2, -1.3), (4.3, -1.1)], [(3.3, -3.1), (-0.8, 4.4)], [(0.6, 4.4), (-3.5, -3.1)]]
    yield "three that enclose a triangle", triangle, None, None, MAY_CLOSE
    yield "an X at a node", [[(-4, -3), (4, 3)], [(-4, 3), (4, -3)]], None, None, stable
    yield "an X through a particle", [[(-4.25, -3.25), (4.75, 3.75)], [(-4.25, 3.75), (4.75, -3.25)]], None, None, stable
    yield "a T", [LINE, [(0.3, 0.4), (0.7, 4.4)]], None, None, MAY_CLOSE
    yield "a T that ends 1e-9 beyond", [LINE, [(0.3, 0.4 - 1e-9), (0.7, 4.4)]], None, None, (*MAY_CLOSE, "refused")
    yield "a T with a gap of 1e-9", [LINE, [(0.3, 0.4 + 1e-9), (0.7, 4.4)]], None, None, (*MAY_CLOSE, "refused")
    star = [[(0.1, 0.2), np.array([0.1, 0.2]) + 4 * direction(72 * k + 11)] for k in range(5)]
    yield "five that meet at a point", star, None, None, (*MAY_CLOSE, "refused")
    fan = [[(-4.2, 0.1), np.array([-4.2, 0.1]) + 8 * direction(angle)] for angle in (0, 2)]
    yield "a fan of 2 degrees", fan, None, None, ("stable", "refused")
    yield "through the whole body", [[(-20, 0.3), (20, 1.1)]], None, None, ("stable", "stopped")
    yield "along cells through the whole body", [[(-20, 1), (20, 1)]], None, None, ("stable", "stopped")
    yield "ligament of a cell", [[(-20, 0.3), (-0.6, 0.3)], [(0.6, 0.3), (20, 0.3)]], None, None, ("stable", "refused")
    yield "99 points", [[(-4.9 + 0.1 * k * 1.01, 0.1 * math.sin(k)) for k in range(99)]], None, None, refused


def shape_cells(runner):
    """Cracks of many shapes: energies beside those of the same without them, and in motion."""
    cells = []
    whole = runner.outcome(square([], REST, estimators="")).columns["strain_energy"][-1]
    for name, cracks, like, bound, expected in shapes():
        text = square(cracks, REST, estimators="")
        if like is None:
            # With an edge crack through half of the width it is eight times as large
            what, bound = "strain energy over that without cracks", 10.0

            def number(h):
                energy = h["strain_energy"][-1] / whole
                return energy if energy > 1 - 1e-9 else math.inf
        else:
            what = "strain energy against that of a like crack"
            other = runner.outcome(square(like, REST, estimators="")).columns["strain_energy"][-1]

            def number(h, other=other):
                return (h["strain_energy"][-1] - other) / max(other - whole, 1e-3 * whole)
        cells.append(runner.judge(f"{name}, at rest", text, what, bound, number, expected))
        for contact in ("", "  contact = 'frictionless'"):
            text = square(cracks, {}, estimators="", contact=contact)
            cells.append(runner.judge(f"{name}, in motion{', with contact' if contact else ''}", text, CLOSURE, 1e-10, lambda h: audit(math.inf, h),
                                      ("refused",) if expected == ("refused",) else ("stable", "refused", "warned")))
    random, half = np.random.default_rng(3), 15
    many = [[(x, y), np.array([x, y]) + 1.5 * direction(random.uniform(-30, 30))] for x in np.linspace(-13.2, 11.0, 10)
            for y in np.linspace(-13, 13, 10)]
    # As many without each other, of an effective half-length between that of the points and up to half a cell more at each tip
    alone = 1 + 100 * 2 * math.pi * 1.1**2 / (2 * half)**2
    energy = runner.outcome(square([], REST, estimators="", half=half)).columns["strain_energy"][-1]
    cells.append(runner.judge("a hundred, at rest", square(many, REST, estimators="", half=half),
                              "strain energy against that of a hundred by themselves", 0.25,
                              lambda h: h["strain_energy"][-1] / energy / alone - 1, ("stable",)))
    cells.append(runner.judge("a hundred, in motion", square(many, {}, estimators="", half=half), CLOSURE, 1e-10, lambda h: audit(math.inf, h),
                              MAY_CLOSE))
    return cells


# --- methods ----------------------------------------------------------------------------------------------------------

KINKED = [(-3.7, -1.4), (0.3, 0.2), (2.6, 3.1)]


def limit_of(runner, text):
    """The courant number at the limit, as a refusal names it."""
    message = runner.outcome(text, ["method.courant=999"]).message
    return float(re.search(r"must be at most (\S+), not", message)[1])


def methods(runner):
    """All mass matrices and schemes in the default time step and at its limit, with and without refinement and contact."""
    cells = []
    scenes = (("open, poisson 0", {"poisson": 0.0}),
              ("friction, refined, poisson 0.3", {"levels": 1, "contact": "  contact = 'friction'  friction = 0.3"}),
              ("contact, poisson 0.45", {"poisson": 0.45, "contact": "  contact = 'frictionless'"}))
    for kind, scheme, (what, keys) in itertools.product(KINDS, SCHEMES, scenes):
        text = square([KINKED], method_of(kind, scheme, courant=0, box=(-HALF, -HALF, 0, HALF)), **keys)
        limit = limit_of(runner, text)
        most = 200 * STRESS**2 / modulus(keys.get("poisson", 0.3))
        for name, courant in (("default", 0.0), ("limit", limit * (1 - 1e-6))):
            cells.append(runner.judge(f"{kind}, {scheme}, {what}, courant: {name}", text, MOVING, 1e-10, lambda h, most=most: audit(most, h),
                                      MAY_CLOSE if not courant else None, settings=[f"method.courant={courant!r}"]))
    cells.append(runner.judge("updated frame", square([KINKED], method_of(frame="updated", courant=0)), MOVING, 1e-10,
                              lambda h: audit(200 * STRESS**2 / modulus(0.3), h), MAY_CLOSE))
    return cells


SLANTED = [np.array([0.13, 0.29]) + side * 4 * direction(33) for side in (-1, 1)]


def materials(runner):
    """Poisson's ratio to both ends, particles a cell, the law for large strains, and implicit steps. Nearly incompressible cells
    lock, G is then far too small, and the error that is estimated says so."""
    cells = []
    loads = cut_out(HALF, 2 * HALF, *ends_of(*SLANTED), *(STRESS * direction(40)))
    for poisson in (-0.99, -0.5, 0.0, 0.3, 0.45, 0.49, 0.499, 0.4999):
        asked = STRESS**2 * math.pi * 4 / modulus(poisson)
        for points, law in itertools.product((2, 3), ("linear_elastic", "neo_hookean")):
            name = f"poisson {poisson}, {points**2} a cell, {law}"
            cells.append(runner.judge(f"{name}, at rest", square([SLANTED], REST, loads, poisson, points=points, law=law),
                                      "G of a crack of 8 cells against an infinite plate, over the error that is estimated", 1.5,
                                      lambda h, asked=asked: max(abs(h["G" + end][-1] - asked) / h["G_error" + end][-1] for end in tips(h)),
                                      ("stable",)))
            cells.append(runner.judge(f"{name}, in motion", square([SLANTED], {}, loads, poisson, points=points, law=law), MOVING, 1e-10,
                                      lambda h, most=10 * asked: audit(most, h), MAY_CLOSE))
        text = square([SLANTED], {"time": "'implicit'", "time_step": 0.5}, loads, poisson)
        cells.append(runner.judge(f"poisson {poisson}, implicit steps", text, MOVING + ", implicit", 1e-8,
                                  lambda h, most=10 * asked: audit(most, h), MAY_CLOSE))
    return cells


def speeds(runner):
    """A body that flies: what it does by itself is that of one that does not, but for the digits that its way takes."""
    cells = []
    loads = [load for load in cut_out(HALF, 2 * HALF, *ends_of(*SLANTED), *(STRESS * direction(40))) if load.startswith("&load")]
    still = runner.outcome(square([SLANTED], {}, loads)).columns["G"]
    for speed in (1e-6, 1e-3, 1.0, 1e3, 1e6):
        def number(h):
            return np.abs(h["G"] - still).max() / still.max() if h["G"].size == still.size else math.inf
        cells.append(runner.judge(f"flies with {speed:g} times the wave speed", square([SLANTED], {}, loads, velocity=(speed, 0.5 * speed)),
                                  "G against that of a body that does not fly, over 1 + speed", 1e-9,
                                  lambda h, speed=speed: number(h) / (1 + speed)))
    return cells


def sizes(runner):
    """Loads from those whose squares are hardly numbers to those that open the crack by a cell, of the law for large strains."""
    cells = []
    for size in (1e-90, 1e-60, 1e-30, 1e-15, 1e-6, 1e-4, 1e-2, 0.1):
        loads = cut_out(HALF, 2 * HALF, *ends_of(*SLANTED), *(size * direction(40)))
        asked = size**2 * math.pi * 4 / modulus(0.3)
        for law in ("linear_elastic", "neo_hookean"):
            cells.append(runner.judge(f"stress {size:g}, {law}, at rest", square([SLANTED], REST, loads, law=law),
                                      QUANTITY, BOUND, lambda h, asked=asked: release_error(asked, h),
                                      ("stable",) if size < 1e-3 else None))
            if size > 1e-3:
                continue
            cells.append(runner.judge(f"stress {size:g}, {law}, in motion", square([SLANTED], {}, loads, law=law), MOVING, 1e-10,
                                      lambda h, most=10 * asked: audit(most, h), MAY_CLOSE))
    return cells


def frictions(runner):
    """Closed cracks under pressure: K_I = 0, K_II = s sqrt(pi a)(sin b cos b - mu cos^2 b), none where faces stick. 16 finest cells to the
    half-length: the springs between the faces take up a twelfth of K_II with four."""
    cells, a, half = [], 4.0, 2 * HALF
    for beta, mu in itertools.product((20, 45, 60), (0.0, 1e-12, 0.3, 1.0, 1e3, 1e90)):
        crack = [np.array([0.13, 0.29]) + side * a * direction(beta) for side in (-1, 1)]
        contact = f"  contact = 'friction'  friction = {mu!r}" if mu else "  contact = 'frictionless'"
        scale = STRESS * math.sqrt(math.pi * a)
        asked = max(0.0, math.sin(math.radians(beta)) * math.cos(math.radians(beta)) - mu * math.cos(math.radians(beta))**2)

        def number(h, asked=asked, scale=scale):
            return max(max(abs(abs(h["K_II" + end][-1]) / scale - asked), abs(h["K_I" + end][-1]) / scale) for end in tips(h))
        text = square([crack], REST | {"load_steps": 4}, contact=contact, stress=-STRESS, half=half, levels=2)
        cells.append(runner.judge(f"{beta} degrees, friction {mu:g}, at rest", text,
                                  "K of a closed crack of 32 cells against an infinite plate, over s sqrt(pi a)", 0.05, number, ("stable",)))
        cells.append(runner.judge(f"{beta} degrees, friction {mu:g}, in motion", square([crack], {}, contact=contact, stress=-STRESS), MOVING, 1e-10,
                                  lambda h: audit(10 * STRESS**2 * math.pi * a / modulus(0.3), h), ("stable",)))
    return cells


def paths(runner):
    """All of them."""
    return [cell for part in (places, shape_cells, methods, materials, speeds, sizes, frictions) for cell in part(runner)]
