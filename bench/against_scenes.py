"""The short scenes on which `against.py` holds two builds to each other. Their keys are those of every version since 1.0."""

from typing import NamedTuple

from tables import ROOT

CASES = ROOT / "tests/regression"
SCHEMES = ("musl", "usl", "usf", "usavg")

# Two bodies off the grid lines, of two materials, that fly through the cells, are pushed, held at an edge and damped
FLIGHT = """
&run  title = 'two bodies'  thickness = 0.01  end_time = 3e-3 /
&grid  lower = -0.05, -0.05  cell = 0.01  cells = 40, 24 /
&material  name = 'rubber'  law = 'neo_hookean'  young = 2e6  poisson = 0.4  density = 1100 /
&material  name = 'soft'  young = 3e6  poisson = 0.3  density = 1400 /
&body  material = 'rubber'  lower = 0.003, 0.002  upper = 0.087, 0.064  velocity = 9.0, 3.0 /
&body  material = 'soft'  lower = 0.113, 0.017  upper = 0.196, 0.071  points_per_cell = 3  velocity = -7.0, 1.0 /
&constraint  lower = 0.2, -0.05  upper = 0.21, 0.1  fix = 'x' /
&load  kind = 'body'  lower = 0.003, 0.002  upper = 0.087, 0.064  force = 9.0, -40.0  history = 'sine'  frequency = 700 /
&load  kind = 'point'  lower = 0.15, 0.04  upper = 0.15, 0.04  force = 3.0, 5.0  history = 'ramp'  rise_time = 5e-4 /
&damping  rate = 40.0 /
&method  courant = 0.2  frame = 'updated' /
"""


class Scene(NamedTuple):
    """A run."""

    name: str
    source: object               # path of a namelist, or its text
    settings: tuple              # of --set
    threads: int = 1


def beam(name, *settings, estimators="'vcct','domain_integral','stress_closure'", balance=".false.", threads=1):
    """The double cantilever beam on coarse cells for a short time; without the audit, whose path is another."""
    short = ("grid.cell=2.5e-3", "grid.cells=40,6", "run.end_time=1.5e-4", "output.snapshot_interval=0")
    return Scene(name, ROOT / "input/dcb.nml", (*short, f"energy_release.estimators={estimators}", f"energy_release.energy_balance={balance}", *settings), threads)


def audited(name, *settings):
    """The same with the audit of the energy."""
    return beam(name, *settings, estimators="'vcct'", balance=".true.")


def method(**keys):
    """Settings of &method."""
    return tuple(f"method.{key}={value}" for key, value in keys.items())


def case(name, folder, end, *settings):
    """The start of a case of tests/regression."""
    return Scene(name, CASES / folder / "case.nml", (f"run.end_time={end}", "output.snapshot_interval=0", *settings))


REGION = ("refine.region_lower=0.04,0", "refine.region_upper=0.06,0.01")
TIP = ("refine.indicator=tip", "refine.max_level=2", "refine.rings=3")
GRADIENT = ("refine.indicator=gradient", "refine.max_level=2", "refine.r_crit=0.01", *REGION)
BOX = {"consistent_lower": "0.03,0", "consistent_upper": "0.07,0.01"}

SCENES = [
    *(beam(f"{scheme}, {frame}", *method(scheme=scheme, frame=frame)) for scheme in SCHEMES for frame in ("updated", "total")),
    *(audited(f"{scheme}, audit", *method(scheme=scheme)) for scheme in SCHEMES),
    *(audited(f"{scheme}, total, audit", *method(scheme=scheme, frame="total")) for scheme in ("musl", "usavg")),
    beam("two threads", threads=2),
    beam("consistent, cg", *method(mass="consistent")),
    beam("consistent, cg, usavg, total", *method(mass="consistent", scheme="usavg", frame="total")),
    beam("consistent, direct", *method(mass="consistent", solver="direct"), "run.end_time=5e-5"),
    beam("consistent, direct, total", *method(mass="consistent", solver="direct", frame="total")),
    audited("consistent, cg, audit", *method(mass="consistent")),
    beam("weighted, cg", *method(mass="weighted", lumped_fraction=0.3)),
    beam("weighted, direct, total, usl", *method(mass="weighted", lumped_fraction=0.5, solver="direct", frame="total", scheme="usl")),
    beam("fmpm", *method(mass="fmpm", order=3)),
    beam("fmpm, total, usf", *method(mass="fmpm", order=2, frame="total", scheme="usf")),
    beam("partial, cg", *method(mass="partial", **BOX)),
    beam("partial, direct, total", *method(mass="partial", solver="direct", frame="total", **BOX)),
    beam("tip", *TIP),
    beam("tip, total, usavg", *TIP, *method(frame="total", scheme="usavg")),
    beam("tip, consistent, direct, total", *TIP, *method(mass="consistent", solver="direct", frame="total")),
    beam("tip, partial in the refined cells", *TIP, *method(mass="partial", consistent_region="refined"), "run.end_time=2e-5"),
    audited("tip, audit", *TIP),
    beam("gradient", *GRADIENT),
    audited("gradient, usf, audit", *GRADIENT, *method(scheme="usf")),
    beam("gradient that coarsens, fmpm, total", *GRADIENT, "refine.r_coarsen=0.005", *method(mass="fmpm", frame="total")),
    beam("zz", "refine.indicator=zz", "refine.max_level=2", "refine.tolerance=0.2", *REGION),
    Scene("fig10, adaptive, consistent", ROOT / "input/fig10_adaptive_unlumped.nml", ("run.end_time=4e-5",)),
    Scene("line crack, tip", ROOT / "input/mixed_mode.nml", ("run.end_time=4e-5", "output.snapshot_interval=0", "refine.rings=4")),
    case("two tips", "centre_crack", 5e-5),
    case("contact", "closed_crack", 1e-4, "energy_release.estimators='vcct','domain_integral'"),
    case("contact, audit, total", "closed_crack", 1e-4, "method.frame=total"),
    case("contact, tip", "closed_crack", 4e-5, "refine.indicator=tip", "refine.rings=4", "refine.max_level=1"),
    case("plane strain, waves", "freund", 2.5e-6, "grid.cell=0.4e-3"),
    case("stiff rubber", "neo_hookean_bar", 0.01),
    case("two materials", "bar_of_two_materials", 2e-4),
    case("four bodies, loads", "rigid_loads", 2e-4),
    *(Scene(f"flight, {scheme}, updated", FLIGHT, method(scheme=scheme)) for scheme in ("musl", "usf")),
    Scene("flight, audit", FLIGHT, ("energy_release.energy_balance=.true.",)),
    Scene("flight, consistent", FLIGHT, method(mass="consistent", courant=0.05, scheme="usavg")),
]

# Those whose instructions are counted, each path of a step once, and when they end then [s]
COUNTED = {"musl, updated": 1e-4, "usavg, total": 1e-4, "musl, audit": 1e-4, "consistent, cg": 1e-5, "consistent, direct, total": 5e-5,
           "fmpm": 5e-5, "partial, direct, total": 5e-5, "tip": 2e-5, "tip, total, usavg": 2e-5,
           "gradient": 2e-5, "zz": 5e-5, "contact": 5e-5, "line crack, tip": 5e-6, "stiff rubber": 3e-3,
           "flight, musl, updated": 2e-4}
