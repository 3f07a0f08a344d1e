"""Every law in static, implicit and explicit runs, bilinear and quadratic cells, plane strain and stress, and around an axis: a block is pulled, partly let back and
pulled again while its sides are free, so that it is strained uniformly; its force against an independent integration of the law, by Newton's
iteration or, of laws with a history, by the differential equations in 4000 steps of Runge and Kutta, which know no return to a yield surface."""

import h5py
import numpy as np
import pytest

YOUNG, NU, DENSITY = 1e6, 0.3, 1.0
MU, LAMBDA = YOUNG/(2*(1 + NU)), YOUNG*NU/((1 + NU)*(1 - 2*NU))
KAPPA = LAMBDA + 2*MU/3
STIFFNESS = LAMBDA*np.ones((3, 3)) + 2*MU*np.eye(3)
C01 = 4e4
YIELD, HARDENING, SATURATION, AT, KINEMATIC = 2e3, 3e4, 1e3, 4e-3, 2e4
PRONY = ((1e5, 0.02), (5e4, 0.1))
ISOTROPIC = f"young = {YOUNG}  poisson = {NU}"
# (r, z, around): equal in the section, so that a rod stays uniform
ORTHOTROPIC = "young_1 = 5e5  young_2 = 1e6  young_3 = 5e5  poisson_12 = 0.15  poisson_13 = 0.3  poisson_23 = 0.3  shear_12 = 3e5"
COMPLIANCE = np.array([[1/5e5, -0.15/5e5, -0.3/5e5], [-0.15/5e5, 1e-6, -0.3/1e6], [-0.3/5e5, -0.3/1e6, 1/5e5]])
END, CORNERS, TURNS, PARTS = 0.2, [0.0, 0.5, 0.75, 1.0], [0.0, 1.0, -0.2, 0.6], 16
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
            for _ in range(12):
                slopes = np.array([(stress(strain + 1e-6*unit) - stress(strain - 1e-6*unit))/2e-6 for unit in np.eye(3)[free]])[:, free].T
                strain[free] -= np.linalg.solve(slopes, stress(strain)[free])
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


def in_time(rates, n, steps=4000):
    """The way of a law in time: `rates(state, strain rate)` of the stress, which is first in the state, and of the rest, is linear in the rate where a switch of it
    stays."""
    def way(free, pull):
        state, found = np.zeros(n), []
        for k in range(len(TIMES) - 1):
            duration = (TIMES[k + 1] - TIMES[k])*END
            number = round(steps*(TIMES[k + 1] - TIMES[k]))

            def change(y, speed=pull*(FACTORS[k + 1] - FACTORS[k])/duration):
                rate = np.array([0.0, speed, 0.0])
                for _ in range(2):                                   # the second time with the switch as it then is
                    zero = rates(y, rate)[free]
                    slopes = np.array([rates(y, rate + abs(speed)*1e-3*unit)[free] - zero for unit in np.eye(3)[free]]).T/(abs(speed)*1e-3)
                    rate[free] -= np.linalg.solve(slopes, zero)
                return rates(y, rate)*duration/number
            for _ in range(number):
                first = change(state)
                second = change(state + first/2)
                third = change(state + second/2)
                state = state + (first + 2*second + 2*third + change(state + third))/6
            found.append(state[1])
        return np.array(found)
    return way


def deviator(x):
    return x - np.mean(x)


def plastic(state, rate):
    """Stress, back stress and alpha; flows where the stress is on the yield surface, blurred by some parts in 10**4, and loads it."""
    stress, back, alpha = state[:3], state[3:6], state[6]
    relative = deviator(stress) - back
    radius = np.sqrt(2/3)*(YIELD + HARDENING*alpha + SATURATION*(1 - np.exp(-alpha/AT)))
    slope = HARDENING + SATURATION/AT*np.exp(-alpha/AT)
    size = max(np.linalg.norm(relative), 1e-12)
    normal = relative/size
    on = 1/(1 + np.exp(-np.clip((size/radius - 1)*3e3, -60, 60)))
    gamma = on*max(2*MU*np.dot(normal, rate), 0.0)/(2*MU + 2/3*(KINEMATIC + slope))
    return np.concatenate([STIFFNESS @ rate - 2*MU*gamma*normal, 2/3*KINEMATIC*gamma*normal, [np.sqrt(2/3)*gamma]])


def viscoelastic(state, rate):
    """Stress and the parts q_i of it that relax."""
    parts = state[3:].reshape(-1, 3)
    fading = [2*g*deviator(rate) - q/tau for (g, tau), q in zip(PRONY, parts)]
    stiff = KAPPA*np.sum(rate) + 2*(MU - sum(g for g, _ in PRONY))*deviator(rate)
    return np.concatenate([stiff + sum(fading), *fading])


# keys, largest strain, integration, errors at rest (of laws with a history by its 192 steps) and in explicit runs, which have inertia
LAWS = {
    "linear_elastic": (ISOTROPIC, 0.01, elastic(lambda e: STIFFNESS @ e), 1e-6, 1e-2),
    "orthotropic": (ORTHOTROPIC, 0.01, elastic(lambda e: np.linalg.solve(COMPLIANCE, e)), 1e-6, 1e-2),
    "neo_hookean": (ISOTROPIC, 0.4, elastic(piola(neo_hookean)), 1e-6, 1e-2),
    "mooney_rivlin": (ISOTROPIC + f"  c01 = {C01}", 0.4, elastic(piola(mooney_rivlin)), 1e-6, 1e-2),
    "j2_plastic": (ISOTROPIC + f"  yield_stress = {YIELD}  hardening = {HARDENING}  saturation = {SATURATION}  saturation_strain = {AT}  "
                   f"kinematic = {KINEMATIC}", 0.01, in_time(plastic, 7), 4e-3, 1e-2),
    "viscoelastic": (ISOTROPIC + f"  moduli = {', '.join(str(g) for g, _ in PRONY)}  relaxation_times = {', '.join(str(t) for _, t in PRONY)}",
                     0.01, in_time(viscoelastic, 3 + 3*len(PRONY)), 4e-3, 1e-2),
}
FREE = {"strain": [0], "stress": [0, 2], "axisymmetric": [0, 2]}
METHODS = {"static": "time = 'static'  load_steps = 192", "implicit": f"time = 'implicit'  time_step = {END/200}  hht_alpha = -0.1  mass = 'full'", "explicit": "time = 'explicit'  mass = 'full'"}
EXPECTED = {}

SCENE = """
&run plane = '{plane}'  end_time = {end} /
&grid lower = {left}, 0.0  cell = 0.5  cells = {cells}, 4  order = {order} /
&material name = 'a'  density = {density}  law = '{law}'  {keys} /
&body material = 'a'  lower = 0.0, 0.0  upper = 1.0, 1.0  points_per_cell = {points} /
&constraint lower = 0.0, 0.0  upper = 0.0, 1.0  fix = 'x' /
&constraint lower = 0.0, 0.0  upper = 1.0, 0.0  fix = 'y' /
&constraint lower = 0.0, 1.0  upper = 1.0, 1.0  fix = 'y'  displacement = 0.0, {pull}  history = 'table'  times = {times}  factors = {factors}  name = 'top' /
&damping rate = {damping} /
&method {method}  frame = 'total' /
&output history_interval = {interval}  snapshot_interval = {end} /
"""


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("plane", FREE)
@pytest.mark.parametrize("law", LAWS)
def test_a_block_is_pulled_and_let_back(hampm, tmp_path, law, plane, method, order):
    keys, pull, way, close, in_motion = LAWS[law]
    density = DENSITY if method == "explicit" else 1e-2*DENSITY
    (tmp_path / "block.nml").write_text(SCENE.format(
        plane=plane, end=END, left=0.0 if plane == "axisymmetric" else -0.5, cells=3 if plane == "axisymmetric" else 4, order=order, points=order + 1,
        density=density, law=law, keys=keys, pull=pull, times=", ".join(f"{t:.9g}" for t in TIMES*END), factors=", ".join((f"{value:.12g}" for value in FACTORS)),
        damping=0.0 if method == "static" else 2e3, method=METHODS[method], interval=END/4))
    result = hampm("block.nml", "--force", "--quiet", *(() if plane == "axisymmetric" else ("--set", "run.thickness=1.0")))
    assert result.returncode == 0, result.stderr
    with h5py.File(tmp_path / "block.h5") as file:
        time, force = file["history/time"][:], file["history/reaction_top_y"][:]
    if (law, plane) not in EXPECTED:
        EXPECTED[law, plane] = way(FREE[plane], pull)*(np.pi if plane == "axisymmetric" else 1.0)
    expected = EXPECTED[law, plane]
    expected = expected[PARTS - 1::PARTS]
    got = force[[np.argmin(np.abs(time - t*END)) for t in CORNERS[1:]]]
    error = np.max(np.abs(got - expected))/np.max(np.abs(expected))
    print(f"\n{law}, {plane}, {method}, order {order}: {error:.1e}")
    assert error < {"static": close, "implicit": max(close, 3e-4), "explicit": in_motion}[method]
