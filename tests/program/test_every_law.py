"""Every law in static, implicit and explicit runs, bilinear and quadratic cells, plane strain and stress, and around an axis, in one table: `pytest -s` prints it.

A block is pulled, partly let back, pulled again and held while its sides are free, so that it is strained uniformly, whatever its mesh: its cells are of two sizes, and a crack
that runs along the pull cuts it in part. Patch: by how much the stress of its particles differs at the end. Path: its force against an independent integration of the law, in
closed form along the way across or, of laws with a history, by a solver of stiff differential equations, which knows no return to a yield surface.

A block between two plates is sheared and pulled. Tangent: that of the forces against differences. Newton: the order with which what is out of balance falls."""

from itertools import product

import h5py
import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import root

from paths import PROGRAM
from snapshots import field, read_steps

YOUNG, NU, DENSITY = 1e6, 0.3, 1.0
MU, LAMBDA = YOUNG/(2*(1 + NU)), YOUNG*NU/((1 + NU)*(1 - 2*NU))
KAPPA = LAMBDA + 2*MU/3
DEVIATOR = np.eye(3) - 1/3
STIFFNESS = LAMBDA*np.ones((3, 3)) + 2*MU*np.eye(3)
C01 = 4e4
YIELD, HARDENING, SATURATION, AT, KINEMATIC = 2e3, 3e4, 1e3, 4e-3, 2e4
FLUIDITY = 1e-5                                                            # [s]
PRONY = ((1e5, 0.02), (5e4, 0.1))
ISOTROPIC = f"young = {YOUNG}  poisson = {NU}"
# (r, z, around): equal in the section, so that a rod stays uniform
ORTHOTROPIC = "young_1 = 5e5  young_2 = 1e6  young_3 = 5e5  poisson_12 = 0.15  poisson_13 = 0.3  poisson_23 = 0.3  shear_12 = 3e5"
COMPLIANCE = np.array([[1/5e5, -0.15/5e5, -0.3/5e5], [-0.15/5e5, 1e-6, -0.3/1e6], [-0.3/5e5, -0.3/1e6, 1/5e5]])
END, CORNERS, TURNS, PARTS = 0.2, [0.0, 0.5, 0.75, 1.0, 1.25], [0.0, 1.0, -0.2, 0.6, 0.6], 16
ROUNDING = 1e-13
# a table that slows down before it turns
TIMES = np.unique(np.concatenate([np.linspace(*pair, PARTS + 1) for pair in zip(CORNERS, CORNERS[1:])]))
FACTORS = np.array([TURNS[k] + (TURNS[k + 1] - TURNS[k])*(1 - np.cos(np.pi*(t - CORNERS[k])/(CORNERS[k + 1] - CORNERS[k])))/2
                    for t in TIMES for k in [max(0, np.searchsorted(CORNERS, t) - 1)]])


def elastic(stress):
    """The way of a law without a history: `stress` is that of principal strains."""
    def way(free, pull):
        found, strain = [], np.zeros(3)
        for target in FACTORS[1:]:
            strain[1] = pull*target

            def across(inner):
                strain[free] = inner
                return stress(strain)[free]/YOUNG
            across(root(across, strain[free], tol=1e-12).x)
            found.append(stress(strain)[1])
        return np.array(found)
    return way


def piola(kirchhoff):
    """First Piola stress of a law of principal stretches."""
    return lambda strain: kirchhoff(1 + strain)/(1 + strain)


def neo_hookean(f):
    return MU*(f**2 - 1) + LAMBDA*np.log(np.prod(f))


def mooney_rivlin(f):
    c10, b = MU/2 - C01, f**2
    return 2*c10*b + 2*C01*(np.sum(b)*b - b**2) - (2*c10 + 4*C01) + (LAMBDA - 4*C01)*np.log(np.prod(f))


def in_time(moduli, flow):
    """The way of a law in time: the state, stress first, changes as moduli times the strain rate, and by what flows in a state."""
    def way(free, pull):
        state, found = np.zeros(len(moduli)), []
        across = np.linalg.inv(moduli[free][:, free])
        for now, then, begin, end in zip(TIMES*END, TIMES[1:]*END, FACTORS, FACTORS[1:]):
            def change(_, y, rate=np.array([0.0, pull*(end - begin)/(then - now), 0.0])):
                flowing = flow(y)
                rate[free] = -across @ (flowing[free] + moduli[free, 1]*rate[1])
                return flowing + moduli @ rate
            state = solve_ivp(change, (now, then), state, "BDF", rtol=1e-7, atol=1e-8*YIELD).y[:, -1]
            found.append(state[1])
        return np.array(found)
    return way


def deviator(x):
    return x - np.mean(x)


def plastic(state):
    """Stress, back stress and alpha; what is above the yield surface flows, so fast that next to nothing is: viscoplasticity as its viscosity goes to 0."""
    stress, back, alpha = state[:3], state[3:6], state[6]
    relative = deviator(stress) - back
    radius = np.sqrt(2/3)*(YIELD + HARDENING*alpha + SATURATION*(1 - np.exp(-alpha/AT)))
    size = max(np.linalg.norm(relative), 1e-12)
    gamma = max(size/radius - 1, 0.0)/FLUIDITY
    return np.concatenate([-2*MU*gamma*relative/size, 2/3*KINEMATIC*gamma*relative/size, [np.sqrt(2/3)*gamma]])


def viscoelastic(state):
    """Stress and the parts of it that relax."""
    fading = [-part/tau for (_, tau), part in zip(PRONY, state[3:].reshape(-1, 3))]
    return np.concatenate([sum(fading), *fading])


# keys, largest strain, integration, error at rest: of laws with a history by its 240 steps
LAWS = {
    "linear_elastic": (ISOTROPIC, 0.01, elastic(lambda e: STIFFNESS @ e), 1e-6),
    "orthotropic": (ORTHOTROPIC, 0.01, elastic(lambda e: np.linalg.solve(COMPLIANCE, e)), 1e-6),
    "neo_hookean": (ISOTROPIC, 0.4, elastic(piola(neo_hookean)), 1e-6),
    "mooney_rivlin": (ISOTROPIC + f"  c01 = {C01}", 0.4, elastic(piola(mooney_rivlin)), 1e-6),
    "j2_plastic": (ISOTROPIC + f"  yield_stress = {YIELD}  hardening = {HARDENING}  saturation = {SATURATION}  saturation_strain = {AT}  "
                   f"kinematic_hardening = {KINEMATIC}", 0.01, in_time(np.concatenate([STIFFNESS, np.zeros((4, 3))]), plastic), 1e-3),
    "viscoelastic": (ISOTROPIC + f"  moduli = {', '.join(str(g) for g, _ in PRONY)}  relaxation_times = {', '.join(str(t) for _, t in PRONY)}",
                     0.01, in_time(np.concatenate([STIFFNESS, *(2*g*DEVIATOR for g, _ in PRONY)]), viscoelastic), 1e-5),
}
FREE = {"strain": [0], "stress": [0, 2], "axisymmetric": [0, 2]}
METHODS = {"static": "time = 'static'  load_steps = {steps}", "implicit": "time = 'implicit'  time_step = 1e-3  hht_alpha = -0.1  mass = 'consistent'",
           "explicit": "time = 'explicit'  mass = 'consistent'"}
ORDERS = {1: 2, 2: 4}                                                     # points in a cell and direction
COMBINATIONS = [("static", 1), ("implicit", 1), ("static", 2), ("explicit", 1), ("implicit", 2)]
# Each law in each plane once, then with the next of these, and last with what takes longest
CASES = [(law, plane, *COMBINATIONS[(k + shift) % len(COMBINATIONS)]) for shift in range(len(COMBINATIONS)) for k, (plane, law) in enumerate(product(FREE, LAWS))]
CASES += [(law, plane, "explicit", 2) for law, plane in product(LAWS, FREE)]
EXPECTED, TABLE = {}, {}

BLOCK = """
&run plane = '{plane}'  end_time = {end} {thickness} /
&grid lower = {left}, 0.0  cell = 0.5  cells = 4, 4  order = {order} /
&material name = 'a'  density = {density}  law = '{law}'  {keys} /
&body material = 'a'  lower = {inner}, 0.0  upper = {outer}, 1.0  points_per_cell = {points} /
&method {method}  frame = 'total' /
"""
PULLED = BLOCK + """
&constraint lower = 0.0, 0.0  upper = 0.0, 1.0  fix = 'x' /
&constraint lower = 0.0, 0.0  upper = 1.0, 0.0  fix = 'y' /
&constraint lower = 0.0, 1.0  upper = 1.0, 1.0  fix = 'y'  displacement = 0.0, {pull}  history = 'table'  times = {times}  factors = {factors}  name = 'top' /
&crack kind = 'line'  tip = 0.5, 0.5  direction = 0, 1  length = 0.5 /
&refine indicator = 'tip'  max_level = 1  rings = 1 /
&damping rate = {damping} /
&output file = 'out.h5'  history_interval = {interval}  snapshot_interval = {end} /
"""
SHEARED = BLOCK + """
&constraint lower = 0.0, 0.0  upper = 2.0, 0.0  fix = 'xy' /
&constraint lower = 0.0, 1.0  upper = 2.0, 1.0  fix = 'xy'  displacement = {shear}, {pull}  history = 'ramp'  rise_time = {end} /
&output history_interval = {interval} /
"""


@pytest.fixture(scope="module", autouse=True)
def table():
    """Print what has been found."""
    yield
    print("\n| law | plane | steps | order | patch | path | tangent | Newton |\n|---|---|---|---|---|---|---|---|")
    for case, found in sorted(TABLE.items()):
        print("|", " | ".join(map(str, case)), "|", " | ".join(found.get(name, "") for name in ("patch", "path", "tangent", "Newton")), "|")


def scene(text, law, plane, method, order, **values):
    return text.format(law=law, plane=plane, order=order, points=ORDERS[order], method=method, keys=LAWS[law][0], thickness="" if plane == "axisymmetric" else "thickness = 1.0",
                       **values)


@pytest.mark.parametrize(("law", "plane", "method", "order"), CASES)
def test_a_block_is_pulled_and_let_back(hampm, tmp_path, law, plane, method, order):
    _, pull, way, close = LAWS[law]
    remembers = law in ("j2_plastic", "viscoelastic")
    (tmp_path / "block.nml").write_text(scene(
        PULLED, law, plane, METHODS[method].format(steps=240 if remembers else 20), order, end=CORNERS[-1]*END, left=0.0 if plane == "axisymmetric" else -0.5, inner=0.0, outer=1.0,
        density=1e-2*DENSITY if method != "explicit" else DENSITY/4 if remembers else DENSITY, pull=pull, times=", ".join(f"{t:.9g}" for t in TIMES*END),
        factors=", ".join(f"{value:.12g}" for value in FACTORS), damping=0.0 if method == "static" else 2e3, interval=END/4))
    result = hampm("block.nml", "--force", "--quiet")
    assert result.returncode == 0, result.stderr
    with h5py.File(tmp_path / "out.h5") as file:
        time, force = file["history/time"][:], file["history/reaction_top_y"][:]
    free = FREE[plane]
    if (law, *free) not in EXPECTED:
        EXPECTED[(law, *free)] = way(free, pull)
    expected = EXPECTED[(law, *free)][PARTS - 1::PARTS]*(np.pi if plane == "axisymmetric" else 1.0)
    got = force[[np.argmin(np.abs(time - t*END)) for t in CORNERS[1:]]]
    path = np.max(np.abs(got - expected))/np.max(np.abs(expected))
    particles = read_steps(tmp_path / "out.h5")[1][-1][0].point_data
    stress = np.array([field(particles, name).ravel() for name in ("stress_xx", "stress_yy", "stress_xy")])
    patch = np.max(np.ptp(stress, axis=1))/np.max(np.abs(stress))
    TABLE.setdefault((law, plane, method, order), {}).update(patch=f"{patch:.0e}", path=f"{path:.0e}")
    print(f"\n{law}, {plane}, {method}, order {order}: patch {patch:.1e}, path {path:.1e}")
    # what inertia has of the force, and what waves leave in material that remembers, both as its density
    assert path < {"static": close, "implicit": max(close, 3e-4), "explicit": 5e-3}[method]
    assert patch < {"static": 1e-13, "implicit": 1e-3 if remembers else 1e-6, "explicit": 1e-2 if remembers else 1e-6}[method]


@pytest.mark.parametrize(("law", "plane", "method", "order"), [case for case in CASES if case[2] != "explicit"])
def test_newton_converges_quadratically(hampm, tmp_path, law, plane, method, order):
    """Four large steps. What is out of balance is at most ten times the square of what was, until rounding; where forces are linear it is gone at once, and implicit steps are one
    solution, without an iteration."""
    pull, end = LAWS[law][1], END/2
    method_keys = {"static": "time = 'static'  load_steps = 4", "implicit": f"time = 'implicit'  time_step = {end/4}  mass = 'consistent'"}[method]
    (tmp_path / "block.nml").write_text(scene(SHEARED, law, plane, method_keys, order, end=end, left=0.0, inner=0.5, outer=1.5, density=DENSITY, pull=pull, shear=pull/2, interval=end/4))
    result = hampm("block.nml", program=PROGRAM.with_name("newton_steps"))
    assert result.returncode == 0, result.stderr
    rows = [[float(word) for word in line.split()[1:]] for line in result.stdout.splitlines()]
    assert len(rows) == 4
    tangent, orders = max(row[0] for row in rows), []
    print(f"\n{law}, {plane}, {method}, order {order}: tangent {tangent:.1e}")
    for _, *left in rows:
        print("   out of balance:", " ".join(f"{one:.1e}" for one in left))
        for before, after in zip(left, left[1:]):
            if before < 0.03:
                assert after < max(10*before**2, ROUNDING)
        orders += [np.log(c/b)/np.log(b/a) for a, b, c in zip(left, left[1:], left[2:]) if a < 0.3 and c > 2e-15]
    is_linear = law not in ("neo_hookean", "mooney_rivlin", "j2_plastic")
    if is_linear:
        assert all(left[1:2] < [ROUNDING] and len(left) < 3 for _, *left in rows)
    else:
        assert len(orders) >= 4
    newton = f"{np.median(orders):.2f}" if orders else "1 solution"
    TABLE.setdefault((law, plane, method, order), {}).update(tangent=f"{tangent:.0e}", Newton=newton)
    assert tangent < 1e-6
    assert is_linear or np.median(orders) > 1.6
