"""The matrix of the trade-off study: families of settings, each on cells that become finer.

A family is what stays the same while cells become finer; its error and its cost are curves. They compute the double cantilever
beam of input/dcb.nml, whose arm is `cells` cells deep, the plate of input/chen.nml, half of which is `cells` cells wide, or that of
tests/regression/centre_crack, a quarter of half of whose crack is `cells` cells long. Unless a family says otherwise it takes the defaults:
bilinear cells, the total frame, and nine tenths of the largest stable time step (courant = 0).
"""

from typing import NamedTuple

YARDSTICK = "uniform"  # the group that others are compared with: uniform cells, lumped mass matrix, one run
REFINED = "refined at the tip"
COARSE = (2, 3, 4, 6, 8, 12, 16)
SLOW = COARSE[:-1]  # of settings that take several times as long
FINE = (*COARSE, 20, 24, 28, 32, 40)
BASE = {"method.frame": "total", "method.scheme": "musl", "method.mass": "lumped", "method.courant": 0}
UPDATED = {"method.frame": "updated", "method.courant": 0.9}  # whose courant = 0 is that of the paper
CONSISTENT = {"method.solver": "direct"}
BEST_FRACTION = 0.2778  # 5/18, of the least dispersion in small steps (docs/explanation/mass.md)


class Family(NamedTuple):
    """Runs that differ in the size of their cells, or in the tolerance of their refinement."""

    group: str
    name: str
    settings: dict        # keys of the namelist and their values, over BASE
    cells: tuple          # root cells over the depth of an arm, from coarse to fine
    rings: float = 0      # refine.rings for each of these cells: the refined zone has the same size on all
    finer: tuple = ()     # settings of each member besides, where not the root cells but these make the mesh finer


def number(count, what):
    """A number of things: `1 level`, `2 levels`."""
    return f"{count} {what}{'s' * (count != 1)}"


def uniform():
    """Uniform cells with the lumped mass matrix: other time steps, schemes, frames and numbers of particles."""
    yield Family(YARDSTICK, "uniform", {}, FINE)
    yield Family(YARDSTICK, "courant 0.4", {"method.courant": 0.4}, COARSE)
    yield Family(YARDSTICK, "courant 0.1", {"method.courant": 0.1}, SLOW)
    yield Family(YARDSTICK, "updated frame", UPDATED, COARSE)
    yield Family(YARDSTICK, "settings of the paper", {"method.frame": "updated", "method.courant": 0.1}, SLOW)
    yield Family(YARDSTICK, "usf", {"method.scheme": "usf"}, FINE)
    yield Family(YARDSTICK, "usavg", {"method.scheme": "usavg"}, COARSE)
    yield Family(YARDSTICK, "usl", {"method.scheme": "usl"}, COARSE)
    yield Family(YARDSTICK, "1 point per cell", {"body.points_per_cell": 1}, COARSE)
    yield Family(YARDSTICK, "9 points per cell", {"body.points_per_cell": 3}, COARSE)


def masses():
    """Uniform cells with the other mass matrices and solvers."""
    for name, settings in (("fmpm 2", {"method.order": 2}), ("fmpm 4", {"method.order": 4}),
                           ("weighted 0.5, direct", {"method.lumped_fraction": 0.5, "method.solver": "direct"}),
                           ("weighted 5/18, direct", {"method.lumped_fraction": BEST_FRACTION, "method.solver": "direct"}),
                           ("consistent, cg", CONSISTENT | {"method.solver": "cg"}), ("consistent, direct", CONSISTENT)):
        yield Family("other mass", name, {"method.mass": name.replace(",", "").split()[0], **settings}, SLOW)


def refined():
    """Cells refined around the tip, over zones of 1, 2 and 3 depths of an arm, and choices beside that."""
    sizes = {1: (2, 3, 4, 6, 8, 12, 16), 2: (2, 3, 4, 6, 8, 12), 3: (2, 3, 4, 6), 4: (2, 3, 4), 5: (2, 3)}
    for levels, cells in sizes.items():
        for depths in (1, 2, 3):
            yield tip(f"tip, {number(levels, 'level')}, {depths} n rings", levels, depths, cells)
    other = "tip, 2 levels, 2 n rings, "
    for name, cells, settings in (("updated frame", SLOW, UPDATED), ("usavg", SLOW, {"method.scheme": "usavg"}),
                                  ("fmpm 2", SLOW[:-1], {"method.mass": "fmpm"}),
                                  ("weighted 5/18, direct", SLOW[:-2], {"method.mass": "weighted", "method.lumped_fraction": BEST_FRACTION,
                                                                      "method.solver": "direct"}),
                                  ("consistent, direct", SLOW[:-2], CONSISTENT | {"method.mass": "consistent"}),
                                  ("partial, direct", SLOW[:-2], CONSISTENT | {"method.mass": "partial", "method.consistent_region": "refined"})):
        yield tip(other + name, 2, 2, cells, settings)


def tip(name, levels, depths, cells, settings=None):
    """A family that is refined around the tip from the start."""
    return Family(REFINED, name, {"refine.indicator": "tip", "refine.max_level": levels, **(settings or {})}, cells, depths)


# Refinement that finds its place by itself needs a load that rises slowly, and begins at rest (docs/explanation/adaptivity.md)
RISE = {"method.scheme": "usl", "method.courant": 0.3, "load.history": "ramp", "load.rise_time": 4e-4, "run.end_time": 1.5e-3,
        "refine.start": 9e-4}


def adaptive():
    """Cells refined where the estimated error, or the gradient of a field, is large; for the static value only."""
    yield Family("adaptive", "zz", {**RISE, "refine.indicator": "zz", "refine.interval": 400, "refine.max_level": 6}, (2,) * 4,
                 finer=tuple({"refine.tolerance": tolerance} for tolerance in (0.2, 0.1, 0.05, 0.035)))
    yield Family("adaptive", "gradient of the stress", {
        **RISE, "refine.indicator": "gradient", "refine.field": "stress_norm", "refine.max_level": 6, "refine.interval": 100,
        "refine.region_lower": "0.04, 0", "refine.region_upper": "0.06, 0.01", "refine.energy_floor": 0.2}, (2,) * 4,
                 finer=tuple({"refine.r_crit": r} for r in (0.08, 0.04, 0.02, 0.01)))


QUADRATIC = "quadratic cells"  # the group of what the paper calls its third alternative
NINE_NODES = {"grid.order": 2, "body.points_per_cell": 3}


def graded(group, name, settings, levels, rings, cells):
    """A family that is refined around the tip by zones of as many rings on all cells, which so become smaller with these."""
    return Family(group, f"{name}, tip, {number(levels, 'level')}, {number(rings, 'ring')}",
                  {**settings, "refine.indicator": "tip", "refine.max_level": levels, "refine.rings": rings}, cells)


def graded_motion():
    """Explicit steps in bilinear cells that are graded as quadratic ones are."""
    for levels, cells in {1: COARSE, 2: COARSE, 3: SLOW}.items():
        yield graded(REFINED, "explicit", {}, levels, 4, cells)


AT_REST = "at rest"      # the group of equilibrium, without a motion
REST = {"method.time": "static", "damping.rate": 0, "output.history_interval": 1e-3}


def at_rest():
    """Equilibrium in place of a motion that comes to rest."""
    yield Family(AT_REST, "static", REST, (*FINE, 56, 80))
    for levels, cells in {1: FINE, 2: FINE[:-2], 3: COARSE, 4: SLOW, 5: SLOW[:-1]}.items():
        yield Family(AT_REST, f"static, tip, {number(levels, 'level')}, 2 n rings", {**REST, "refine.indicator": "tip", "refine.max_level": levels},
                     cells, 2)
    for n in (2, 4):
        yield Family(AT_REST, f"static, zz, n = {n}", {**REST, "refine.indicator": "zz", "refine.max_level": 8}, (n,) * 5,
                     finer=tuple({"refine.tolerance": tolerance} for tolerance in (0.12, 0.06, 0.03, 0.02, 0.015)))
    for levels, rings in ((2, 4), (4, 4), (4, 8), (6, 4), (6, 8)):
        yield graded(AT_REST, "static", REST, levels, rings, FINE[:-1])


def quadratic_at_rest():
    """Quadratic cells: uniform, graded towards the tip, and where the error is."""
    yield Family(QUADRATIC, "quadratic", {**REST, **NINE_NODES}, (2, 3, 4, 6, 8, 12, 16, 24, 32))
    for levels, rings in ((2, 2), (4, 1), (4, 2), (6, 1), (6, 2), (8, 2), (8, 4)):
        yield graded(QUADRATIC, "quadratic", {**REST, **NINE_NODES}, levels, rings, (2, 3, 4, 6, 8, 12))
    for n in (2, 4):
        yield Family(QUADRATIC, f"quadratic, zz, n = {n}", {**REST, **NINE_NODES, "refine.indicator": "zz", "refine.max_level": 12}, (n,) * 5,
                     finer=tuple({"refine.tolerance": tolerance} for tolerance in (0.04, 0.02, 0.01, 0.005, 0.0025)))


def tension():
    """A crack in the middle of a plate in tension, at rest: uniform cells, and cells that are graded towards the tips."""
    settings = {"method.time": "static", "damping.rate": 0, "output.history_interval": 0}
    yield Family(YARDSTICK, "uniform", settings, (1, 2, 3, 4, 6, 8, 12, 16))
    for levels, rings in ((2, 4), (2, 8), (4, 4), (4, 8), (6, 4), (6, 8)):
        yield graded(REFINED, "bilinear", settings, levels, rings, (1, 2, 3, 4, 6, 8))
    yield Family("adaptive", "zz, n = 1", {**settings, "refine.indicator": "zz", "refine.max_level": 10}, (1,) * 5,
                 finer=tuple({"refine.tolerance": tolerance} for tolerance in (0.12, 0.06, 0.03, 0.02, 0.015)))
    settings = {**settings, **NINE_NODES}
    yield Family(QUADRATIC, "quadratic", settings, (1, 2, 3, 4, 6, 8))
    for levels, rings in ((2, 2), (4, 1), (4, 2), (6, 1), (6, 2), (8, 2), (8, 4)):
        yield graded(QUADRATIC, "quadratic", settings, levels, rings, (1, 2, 3, 4))
    yield Family(QUADRATIC, "quadratic, zz, n = 1", {**settings, "refine.indicator": "zz", "refine.max_level": 12}, (1,) * 5,
                 finer=tuple({"refine.tolerance": tolerance} for tolerance in (0.04, 0.02, 0.01, 0.005, 0.0025)))


IMPLICIT = "implicit steps"


def implicit_beam():
    """Steps that follow the vibration of the beam and not its waves."""
    for step in (4e-6, 2e-6, 1e-6):
        settings = {"method.time": "implicit", "method.mass": "consistent", "method.time_step": step, "output.history_interval": step}
        yield Family(IMPLICIT, f"implicit {1e6 * step:g} us, consistent", settings, COARSE)
        for levels, cells in {2: COARSE, 3: SLOW, 4: SLOW}.items():
            yield Family(IMPLICIT, f"implicit {1e6 * step:g} us, consistent, tip, {number(levels, 'level')}, 2 n rings",
                         {**settings, "refine.indicator": "tip", "refine.max_level": levels}, cells, 2)
    for step in (1e-6, 5e-7):  # and what quadratic cells are given
        for mass, more in (("lumped", {}), ("weighted 5/18", {"method.lumped_fraction": BEST_FRACTION})):
            settings = {**of_step(step), "method.mass": mass.split()[0], **more}
            name = f"implicit {1e6 * step:g} us, {mass}"
            yield Family(IMPLICIT, name, settings, COARSE)
            for levels, rings in ((1, 8), (2, 4), (3, 4), (4, 4), (3, 8)):
                yield graded(IMPLICIT, name, settings, levels, rings, COARSE)


def of_step(step):
    """Implicit steps of so many seconds."""
    return {"method.time": "implicit", "method.time_step": step, "output.history_interval": max(step, 1e-6)}


def quadratic_motion():
    """Quadratic cells in implicit steps and in explicit ones: uniform, and graded towards the tip."""
    cells = (2, 3, 4, 6, 8)
    for step in (2e-6, 1e-6, 5e-7):
        for mass in ("lumped",) if step > 5e-7 else ("lumped", "consistent"):
            settings = {**of_step(step), **NINE_NODES, "method.mass": mass}
            name = f"quadratic, implicit {1e6 * step:g} us, {mass}"
            yield Family(QUADRATIC, name, settings, cells)
            for levels, rings in ((2, 1), (2, 2), (3, 1), (4, 1), (4, 2)):
                yield graded(QUADRATIC, name, settings, levels, rings, cells[:-1])
    for scheme in ("musl", "usf"):
        settings = {**NINE_NODES, "method.scheme": scheme}
        yield Family(QUADRATIC, f"quadratic, explicit {scheme}", settings, (*cells, 12))
        for levels, rings in ((1, 1), (1, 2), (2, 1), (2, 2), (3, 1), (4, 1)):
            yield graded(QUADRATIC, f"quadratic, explicit {scheme}", settings, levels, rings, cells[:-1])


PLATE = (25, 50, 100, 150, 200)  # the tip of its crack is on a line of the grid
QUADRATIC_PLATE = (25, 50, 75)


def impact():
    """The plate that a wave hits: mass matrices, schemes and time steps, uniform and refined around the tip."""
    yield Family(YARDSTICK, "uniform", {}, PLATE)
    yield Family(YARDSTICK, "courant 0.3", {"method.courant": 0.3}, PLATE[:3])
    yield Family(YARDSTICK, "musl", {"method.scheme": "musl"}, PLATE[:3])
    for name, settings in (("fmpm 2", {"method.order": 2}), ("weighted 0.5", {"method.lumped_fraction": 0.5}), ("weighted 0.4", {"method.lumped_fraction": 0.4}),
                           ("weighted 5/18", {"method.lumped_fraction": BEST_FRACTION}),
                           ("weighted 5/18, courant 0.3", {"method.lumped_fraction": BEST_FRACTION, "method.courant": 0.3}), ("consistent", {})):
        yield Family("other mass", name, {"method.mass": name.replace(",", "").split()[0], **settings}, PLATE[:3])
    for name, settings in (("lumped", {}), ("weighted 5/18", {"method.mass": "weighted", "method.lumped_fraction": BEST_FRACTION})):
        yield tip(f"tip, 1 level, {name}", 1, 0.12, PLATE[:3], settings)
    for courant in (1, 2):
        yield Family(IMPLICIT, f"implicit, courant {courant}, consistent", {"method.time": "implicit", "method.mass": "consistent",
                                                                      "method.courant": courant}, PLATE[:3])
    for levels in (1, 2):
        yield graded(REFINED, "lumped", {}, levels, 4, PLATE[:3])
    yield Family(QUADRATIC, "quadratic, lumped", NINE_NODES, QUADRATIC_PLATE)
    yield graded(QUADRATIC, "quadratic, lumped", NINE_NODES, 1, 2, QUADRATIC_PLATE)
    yield graded(QUADRATIC, "quadratic, lumped", NINE_NODES, 2, 1, QUADRATIC_PLATE[:-1])
    yield Family(QUADRATIC, "quadratic, fmpm 2", {**NINE_NODES, "method.mass": "fmpm", "method.order": 2}, QUADRATIC_PLATE)
    yield Family(QUADRATIC, "quadratic, weighted 5/18", {**NINE_NODES, "method.mass": "weighted", "method.lumped_fraction": BEST_FRACTION}, QUADRATIC_PLATE[:-1])
    for step in (2e-8, 1e-8):
        settings = {**NINE_NODES, "method.time": "implicit", "method.time_step": step}
        yield Family(QUADRATIC, f"quadratic, implicit {1e6 * step:g} us, lumped", settings, QUADRATIC_PLATE[:-1])


FAMILIES = {"static": [*uniform(), *masses(), *refined(), *adaptive(), *at_rest(), *quadratic_at_rest()],
            "tension": [*tension()],
            "dynamic": [*uniform(), *masses(), *refined(), *graded_motion(), *implicit_beam(), *quadratic_motion()],
            "impact": [*impact()]}
