"""The matrix of the trade-off study: families of settings, each on cells that become finer.

A family is what stays the same while cells become finer; its error and its cost are curves. They compute the double cantilever
beam of input/dcb.nml, whose arm is `cells` cells deep, or the plate of input/chen.nml, half of which is `cells` cells wide. Unless
a family says otherwise it takes the defaults: the total frame, and nine tenths of the largest stable time step (courant = 0).
"""

from typing import NamedTuple

YARDSTICK = "uniform"  # the group that others are compared with: uniform cells, lumped mass matrix, one run
COARSE = (2, 3, 4, 6, 8, 12, 16)
SLOW = COARSE[:-1]  # of settings that take several times as long
FINE = (*COARSE, 20, 24, 28, 32, 40)
BASE = {"method.frame": "total", "method.scheme": "musl", "method.mass": "lumped", "method.courant": 0}
UPDATED = {"method.frame": "updated", "method.courant": 0.9}  # whose courant = 0 is that of the paper
FULL = {"method.solver": "umfpack"}
BEST_BLEND = 0.2778  # 5/18, of the least dispersion in small steps (docs/mass.md)


class Family(NamedTuple):
    """Runs that differ in the size of their cells, or in the tolerance of their refinement."""

    group: str
    name: str
    settings: dict        # keys of the namelist and their values, over BASE
    cells: tuple          # root cells over the depth of an arm, from coarse to fine
    rings: float = 0      # refine.rings for each of these cells: the refined zone has the same size on all
    finer: tuple = ()     # settings of each member besides, where not the root cells but these make the mesh finer


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
                           ("blend 0.5, banded", {"method.blend": 0.5, "method.solver": "banded"}),
                           ("blend 5/18, banded", {"method.blend": BEST_BLEND, "method.solver": "banded"}),
                           ("full, cg", FULL | {"method.solver": "cg"}), ("full, umfpack", FULL),
                           ("full, banded", FULL | {"method.solver": "banded"})):
        yield Family("other mass", name, {"method.mass": name.replace(",", "").split()[0], **settings}, SLOW)


def refined():
    """Cells refined around the tip, over zones of 1, 2 and 3 depths of an arm, and choices beside that."""
    sizes = {1: (2, 3, 4, 6, 8, 12, 16), 2: (2, 3, 4, 6, 8, 12), 3: (2, 3, 4, 6), 4: (2, 3, 4), 5: (2, 3)}
    for levels, cells in sizes.items():
        for depths in (1, 2, 3):
            yield tip(f"tip, {levels} levels, {depths} n rings", levels, depths, cells)
    other = "tip, 2 levels, 2 n rings, "
    for name, cells, settings in (("updated frame", SLOW, UPDATED), ("usavg", SLOW, {"method.scheme": "usavg"}),
                                  ("local time steps", SLOW, {"method.time_steps": "local"}),
                                  ("fmpm 2", SLOW[:-1], {"method.mass": "fmpm"}),
                                  ("blend 5/18, umfpack", SLOW[:-2], {"method.mass": "blend", "method.blend": BEST_BLEND,
                                                                      "method.solver": "umfpack"}),
                                  ("full, umfpack", SLOW[:-2], FULL | {"method.mass": "full"}),
                                  ("partial, umfpack", SLOW[:-2], FULL | {"method.mass": "partial", "method.full_region": "refined"})):
        yield tip(other + name, 2, 2, cells, settings)


def tip(name, levels, depths, cells, settings=None):
    """A family that is refined around the tip from the start."""
    return Family("refined at the tip", name, {"refine.indicator": "tip", "refine.max_level": levels, **(settings or {})}, cells, depths)


# Refinement that finds its place by itself needs a load that rises slowly, and begins at rest (docs/adaptivity.md)
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


AT_REST = "at rest"      # the group of equilibrium, without a motion
REST = {"method.time": "static", "damping.rate": 0, "output.history_interval": 1e-3}


def at_rest():
    """Equilibrium in place of a motion that comes to rest."""
    yield Family(AT_REST, "static", REST, (*FINE, 56, 80))
    for levels, cells in {1: FINE, 2: FINE[:-2], 3: COARSE, 4: SLOW, 5: SLOW[:-1]}.items():
        yield Family(AT_REST, f"static, tip, {levels} levels, 2 n rings", {**REST, "refine.indicator": "tip", "refine.max_level": levels},
                     cells, 2)
    for n in (2, 4):
        yield Family(AT_REST, f"static, zz, n = {n}", {**REST, "refine.indicator": "zz", "refine.max_level": 8}, (n,) * 5,
                     finer=tuple({"refine.tolerance": tolerance} for tolerance in (0.12, 0.06, 0.03, 0.02, 0.015)))


IMPLICIT = "implicit steps"


def implicit_beam():
    """Steps that follow the vibration of the beam and not its waves."""
    for step in (4e-6, 2e-6, 1e-6):
        settings = {"method.time": "implicit", "method.mass": "full", "method.time_step": step, "output.history_interval": step}
        yield Family(IMPLICIT, f"implicit {1e6 * step:g} us, full", settings, COARSE)
        for levels, cells in {2: COARSE, 3: SLOW, 4: SLOW}.items():
            yield Family(IMPLICIT, f"implicit {1e6 * step:g} us, full, tip, {levels} levels, 2 n rings",
                         {**settings, "refine.indicator": "tip", "refine.max_level": levels}, cells, 2)


PLATE = (25, 50, 100, 150, 200)  # the tip of its crack is on a line of the grid


def impact():
    """The plate that a wave hits: mass matrices, schemes and time steps, uniform and refined around the tip."""
    yield Family(YARDSTICK, "uniform", {}, PLATE)
    yield Family(YARDSTICK, "courant 0.3", {"method.courant": 0.3}, PLATE[:3])
    yield Family(YARDSTICK, "musl", {"method.scheme": "musl"}, PLATE[:3])
    for name, settings in (("fmpm 2", {"method.order": 2}), ("blend 0.5", {"method.blend": 0.5}), ("blend 0.4", {"method.blend": 0.4}),
                           ("blend 5/18", {"method.blend": BEST_BLEND}),
                           ("blend 5/18, courant 0.3", {"method.blend": BEST_BLEND, "method.courant": 0.3}), ("full", {})):
        yield Family("other mass", name, {"method.mass": name.replace(",", "").split()[0], **settings}, PLATE[:3])
    for name, settings in (("lumped", {}), ("blend 5/18", {"method.mass": "blend", "method.blend": BEST_BLEND})):
        yield tip(f"tip, 1 levels, {name}", 1, 0.12, PLATE[:3], settings)
    for courant in (1, 2):
        yield Family(IMPLICIT, f"implicit, courant {courant}, full", {"method.time": "implicit", "method.mass": "full",
                                                                      "method.courant": courant}, PLATE[:3])


FAMILIES = {"static": [*uniform(), *masses(), *refined(), *adaptive(), *at_rest()],
            "dynamic": [*uniform(), *masses(), *refined(), *implicit_beam()],
            "impact": [*impact()]}
