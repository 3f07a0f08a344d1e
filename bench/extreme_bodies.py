"""The parts `shapes`, `meeting` and `growing` of the atlas of extremes: bodies whose edges cut cells, bodies that fly into each other, and
cracks that grow, where each is hardest for the cells.

Cells have size 1, density 1 and dilatational wave speed 1.
"""

import math

import numpy as np
from extreme_paths import audit, modulus, square, young
from extreme_scenes import REST, SHIFTS, growth, method_of, static_error
from mass_matrices import group, scene

STRESS = 1e-6
POISSON = 0.3


def polygon(points):
    """A body of this outline."""
    return group("body", material="'m'", shape="'polygon'", points=", ".join(repr(float(x)) for point in points for x in point))


def box(a, b):
    """The keys of a load on the edge between two points."""
    return {"lower": f"{min(a[0], b[0])!r}, {min(a[1], b[1])!r}", "upper": f"{max(a[0], b[0])!r}, {max(a[1], b[1])!r}"}


def pulled(points, first, second, force, cells=(24, 24)):
    """A free polygon at rest, pulled at two opposite edges by a stress in their normals."""
    text = scene(cells, POISSON, 1.0, 1.0, method_of() | REST) + polygon(points)
    for (a, b), sign in ((first, 1), (second, -1)):
        text += group("load", kind="'traction'", **box(a, b), force=f"{sign * force[0]!r}, {sign * force[1]!r}")
    return text


def strip(width, angle, shift):
    """Corners of a strip of length 8 around the middle of the lattice."""
    c, s = math.cos(math.radians(angle)), math.sin(math.radians(angle))
    return [(12 + shift + x * c - y * s, 12 + shift + x * s + y * c)
            for x, y in ((-4, -width / 2), (4, -width / 2), (4, width / 2), (-4, width / 2))]


def shapes(runner):
    """Strips at any angle and place, down to a tenth of a cell wide, and wedges as sharp as a thousandth of a turn, under uniform stress:
    the energy at rest is known exactly, and its strain is a field that the cells hold."""
    cells, quantity = [], "strain energy of a strip under uniform stress, at rest"
    for angle in (0, 1e-9, 1e-3, 1, 15, 30, 44.999, 45, 60, 89.999999):
        for shift in SHIFTS:
            for width in (0.1, 0.5, 1.0, 3.0):
                corners = strip(width, angle, shift)
                c, s = math.cos(math.radians(angle)), math.sin(math.radians(angle))
                total = STRESS * width
                exact = STRESS**2 / (2 * modulus(POISSON)) * 8 * width
                text = pulled(corners, corners[1:3], (corners[3], corners[0]), (total * c, total * s))
                cells.append(runner.judge(f"angle {angle:g}, offset {shift!r}, width {width:g}", text, quantity, 1e-4,
                                          lambda h, e=exact: static_error(e, h)))
    for degrees in (90, 30, 5, 0.36):
        t = math.tan(math.radians(degrees))
        corners = [(4.2, 4.3), (20.2, 4.3), (20.2, 4.3 + 16 * min(t, 1.0))]
        text = scene((24, 24), POISSON, 1.0, 1.0, method_of() | REST) + polygon(corners)
        text += group("load", kind="'pressure'", **box(corners[0], corners[2]), pressure=STRESS)
        exact = STRESS**2 * (1 + POISSON) * (1 - 2 * POISSON) / young(POISSON) * 8 * 16 * min(t, 1.0)
        cells.append(runner.judge(f"wedge of {degrees:g} degrees under pressure", text, "strain energy of a wedge under pressure, at rest",
                                  1e-4, lambda h, e=exact: static_error(e, h)))
    return cells


MOMENTUM = "momentum of bodies that meet"


def momentum_change(h):
    """How much of the momentum has changed, over what one body brings."""
    size = math.sqrt(2 * max(h["kinetic_energy"][0], 1e-300))
    return max(np.abs(h[f"momentum_{axis}"] - h[f"momentum_{axis}"][0]).max() for axis in "xy") / size


def meeting(runner):
    """Two blocks that fly into each other in the middle of a cell: stiffness and density apart by up to a million, any speed below a
    tenth of that of waves, gaps down to none, each contact."""
    cells = []

    def judge(name, ratio, density, speed, gap, contact, functions):
        text = scene((24, 8), 0.0, min(40.0, 10.0 / speed + 20.0), 1.0,
                     method_of(frame="updated", courant=0.2) | {"shape_functions": f"'{functions}'"}, "neo_hookean")
        text += group("material", name="'other'", law="'neo_hookean'", young=ratio, poisson=0.0, density=density)
        text += group("body", material="'m'", lower="5.3, 2.2", upper="9.3, 5.2", velocity=f"{speed!r}, 0")
        text += group("body", material="'other'", lower=f"{9.3 + gap!r}, 2.2", upper=f"{13.3 + gap!r}, 5.2", velocity="0, 0")
        text += group("contact", bodies=f"'{contact}'", **({"friction": 0.5} if contact == "friction" else {}))
        for what, bound, number in ((MOMENTUM, 1e-9, momentum_change), ("energy gained by bodies that meet", 0.01, growth)):
            cells.append(runner.judge(name, text, what, bound, number))

    for functions in ("linear", "cpdi"):
        for contact in ("stick", "frictionless", "friction"):
            for power in (-6, -3, 0, 3, 6):
                judge(f"stiffness 1e{power}, {contact}, {functions}", 10.0**power, 1.0, 0.01, 0.5, contact, functions)
                judge(f"density 1e{power}, {contact}, {functions}", 1.0, 10.0**power, 0.01, 0.5, contact, functions)
            for speed in (1e-12, 1e-6, 1e-3, 0.1, 0.5):
                judge(f"speed {speed:g}, {contact}, {functions}", 1.0, 1.0, speed, min(0.5, 5 * speed), contact, functions)
            for gap in (0.0, 1e-12, 0.2, 0.9):
                judge(f"gap {gap:g}, {contact}, {functions}", 1.0, 1.0, 0.02, gap, contact, functions)
    return cells


LENGTH = 5.8  # of the crack at the start
AUDIT = "closure of the energy balance, growth "


def audit_at_rest(h):
    """Work less stored and fracture energy, which is of second order in the increments, over the fracture energy."""
    return np.abs(h["external_work"] - h["strain_energy"] - h["fracture_energy"]).max() / h["fracture_energy"].max()


def growing(runner):
    """A crack in from the edge of a square, pulled: toughness from nothing to more than any, speeds up to those that no crack has,
    increments from a hair to the whole square, at rest and in motion."""
    cells, crack = [], [[(-9.0, 0.3), (LENGTH - 9.0, 0.3)]]
    for direction in ("'straight'", "'hoop_stress'", "'local_symmetry'"):
        for law, values in (("toughness", (1e-30, 1e-15, 1e-12, 1e-9, 1e30)), ("speed", (1e-9, 1e-3, 0.1, 0.3, 0.52, 1.0, 1e6))):
            for value in values:
                keys = {"law": f"'{law}'", law: value, "direction": direction}
                keys |= {"law": "'prescribed'"} if law == "speed" else {}
                text = square(crack, method_of(courant=0.2), end=30.0) + group("growth", **keys)
                cells.append(runner.judge(f"{law} {value:g}, {direction[1:-1]}, in motion", text, AUDIT + "in motion", 1e-9,
                                          lambda h: audit(math.inf, h)))
        for increment in (1e-9, 1.0, 2.0, 2.5, 3.0, 4.0, 40.0):
            text = square(crack, REST | {"load_steps": 4}, end=4.0)
            text += group("growth", direction=direction, toughness=1e-12, increment=increment)
            cells.append(runner.judge(f"increment {increment:g}, {direction[1:-1]}, at rest", text, AUDIT + "at rest, over the fracture energy",
                                      (increment / LENGTH)**2, audit_at_rest))
    return cells


PARTS = {part.__name__: part for part in (shapes, meeting, growing)}
