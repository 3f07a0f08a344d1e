"""Drawn solids with one crack front, without lattice and refinement, and G along it on meshes that are much finer than those that targets need."""

import math

CELLS_OF_TRUTH = ((1, 2), (2, 1), (2, 2))    # number of the lattice over that of the coarsest, levels at the front
KINDS = ("corner", "surface", "edge", "inside", "strip")


def drawn_solid(chance):
    """The text of a model: a box, a symmetry crack in a corner, in a side or along an edge of it, or a plane crack inside or through it, under tension
    or under pressure on its faces. Edges are multiples of 4 mm, radii and tips of 0.1 mm."""
    kind = chance.choice(KINDS)
    length = [4 * chance.randint(3, 7), 4 * chance.randint(3, 7), 8 * chance.randint(2, 5)]
    radii = [round(chance.uniform(0.25, 0.5) * min(length[:2]), 1)]
    if chance.random() < 0.5:
        radii.append(round(radii[0] * chance.uniform(0.6, 1), 1))
    shape = f"front = '{'ellipse' if len(radii) > 1 else 'disc'}'  radii = {', '.join(f'{r}e-3' for r in radii)}"
    lower, tension, x, y, z = "0.0, 0.0, 0.0", 0.0, *(f"{n}e-3" for n in length)
    held = [("0.0, 0.0, 0.0", f"{x}, {y}, 0.0", "z")]
    if kind in ("corner", "surface"):
        held += [("0.0, 0.0, 0.0", f"{x}, 0.0, {z}", "y"), *([("0.0, 0.0, 0.0", f"0.0, {y}, {z}", "x")] if kind == "corner" else [])]
        crack = f"kind = 'symmetry'  normal = 'z'  {shape}  center = 0.0, 0.0, 0.0"
    elif kind == "edge":
        crack = f"kind = 'symmetry'  normal = 'z'  front = 'straight'  tip = {round(chance.uniform(0.3, 0.6) * length[0], 1)}e-3, 0.0, 0.0  direction = 1.0, 0.0, 0.0"
    else:
        held = []
        half, width = f"{length[2] / 2}e-3", f"{length[0]}e-3"
        middle = f"{length[0] / 2}e-3, {length[1] / 2}e-3, {half}"
        if kind == "inside":
            scaled = ", ".join(f"{round(0.7 * r, 1)}e-3" for r in radii)
            crack = f"kind = 'plane'  normal = 'z'  front = '{'ellipse' if len(radii) > 1 else 'disc'}'  radii = {scaled}  center = {middle}"
        else:
            crack = f"kind = 'plane'  normal = 'z'  front = 'straight'  tip = {round(chance.uniform(0.3, 0.6) * length[0], 1)}e-3, 0.0, {half}  direction = 1.0, 0.0, 0.0"
    force = 1e6 * length[0] * length[1] * 1e-6
    loads = [f"kind = 'traction'  lower = 0.0, 0.0, {z}  upper = {x}, {y}, {z}  force = 0.0, 0.0, {force!r}"]
    if not held:
        loads.append(f"kind = 'traction'  lower = 0.0, 0.0, 0.0  upper = {x}, {y}, 0.0  force = 0.0, 0.0, {-force!r}")
    if chance.random() < 0.25:
        loads = ["kind = 'pressure'  on = 'crack'  pressure = 1e6"]
    return kind, "\n".join([
        "&run end_time = 1.0 /", f"&material name = 'a'  young = 200e9  poisson = {round(chance.uniform(0, 0.4), 2)}  density = 7800.0 /",
        f"&body material = 'a'  lower = {lower}  upper = {x}, {y}, {z} /",
        *(f"&constraint lower = {a}  upper = {b}  fix = '{fix}' /" for a, b, fix in held), *(f"&load {load} /" for load in loads),
        f"&crack {crack} /", "&method time = 'static' /", "&output file = 'run.h5' /", ""])


def truth_of_solid(program, text, quantity, first):
    """Value and uncertainty of a quantity: the limit of three meshes of lattices finer than a first one, the error of the front being taken to be proportional to its cells, that of the others
    to their square. The uncertainty is half of what the finest mesh is off that."""
    found = []
    for times, levels in CELLS_OF_TRUTH:
        settings = {"grid.lower": ",".join(map(repr, first["lower"])), "grid.cell": first["cell"] / times, "grid.cells": ",".join(str(n * times) for n in first["cells"]),
                    "refine.indicator": "tip", "refine.max_level": levels, "refine.rings": 4, "refine.max_particles": 8000000, "energy_release.estimators": "domain_integral"}
        run = program(text, settings=settings, codes=(0, 2, 3))
        if run.code:
            return math.nan, math.nan, run.message
        found.append((run.last[quantity], run.seconds))
    (coarse, _), (shallow, _), (fine, seconds) = found     # e = a H + b h**2, where H at the front is 1, 1, 1/2, and h is 2, 1, 1
    of_front, of_cells = fine - shallow, (shallow - coarse) / 3
    return fine + of_front + of_cells, (abs(of_front) + abs(of_cells)) / 2, f"{seconds:.3g} s"
