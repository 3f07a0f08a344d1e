"""Modes of linear models (docs/explanation/modal.md): frequencies and responses against closed forms, a system of equations of its own, and implicit steps."""

import functools

import h5py
import numpy as np
import pytest
from scipy.linalg import eigh, expm

import harness
from harness import differing
from history import lowpass, read_curve
from paths import DCB, REFERENCE

E, RHO, CELLS, H, DEPTH, THICK, FORCE = 70e9, 2700.0, 24, 5e-3, 5e-3, 0.01, 1e3
LENGTH, SECTION = CELLS * H, DEPTH * THICK
# A bar that is moved along alone: nodes of one motion each, a chain of masses and springs
BAR = f"""\
&run end_time = 2e-4 plane = 'stress' thickness = {THICK} /
&grid lower = 0, 0 cell = {H} cells = {CELLS}, 1 /
&material name = 'a' young = {E} poisson = 0.0 density = {RHO} /
&body material = 'a' lower = 0, 0 upper = {LENGTH}, {DEPTH} /
&constraint lower = 0, 0 upper = 0, {DEPTH} fix = 'xy' name = 'wall' /
&constraint lower = 0, 0 upper = {LENGTH}, 0 fix = 'y' /
&constraint lower = 0, {DEPTH} upper = {LENGTH}, {DEPTH} fix = 'y' /
&load kind = 'traction' lower = {LENGTH}, 0 upper = {LENGTH}, {DEPTH} force = {FORCE}, 0 name = 'pull' /
&method time = 'modal' modes = 47 mass = 'consistent' /
&energy_release energy_balance = .true. /
&probe name = 'end' quantity = 'load_line' of = 'pull' /
&output history_interval = 2e-6 /
"""
# A body that nothing holds
PLATE = """\
&run end_time = 1e-4 plane = 'strain' /
&grid lower = 0, 0 cell = 5e-3 cells = 8, 4 /
&material name = 'a' young = 70e9 poisson = 0.3 density = 2700 /
&body material = 'a' lower = 0, 0 upper = 0.04, 0.02 {} /
{}
&method time = 'modal' modes = 40 /
&energy_release energy_balance = .true. /
&output history_interval = 1e-6 snapshot_interval = 1e-4 /
"""


@pytest.fixture
def columns(hampm):
    """`columns(model, *settings)` runs it: its row."""
    return functools.partial(harness.run, hampm, name="case")


def modes(row, name):
    with h5py.File(row.path) as file:
        return file[f"modes/{name}"][:]


def chain(mass):
    """Mass and stiffness of the bar's nodes beside the wall, whose points stand at the quarters of cells."""
    m, k = RHO * SECTION * H, E * SECTION / H
    cell = {"lumped": np.diag([0.5, 0.5]), "consistent": np.array([[5, 3], [3, 5]]) / 16}
    cell["weighted"] = 5 / 18 * cell["lumped"] + 13 / 18 * cell["consistent"]
    M, K = np.zeros((2, CELLS + 1, CELLS + 1))
    for i in range(CELLS):
        M[i:i + 2, i:i + 2] += m * cell[mass]
        K[i:i + 2, i:i + 2] += k * np.array([[1, -1], [-1, 1]])
    return M[1:, 1:], K[1:, 1:]


def chain_under(force, times, mass="consistent", rate=0.0, start=None, is_whole=True):
    """Displacements of the end of the chain under a force on it that is linear between these times, from `start` or no displacement: by the
    exponential of the matrix of its first-order system. If it is not whole its highest mode follows the force statically."""
    M, K = chain(mass)
    n = len(M)
    pull = np.linalg.solve(M, np.eye(n)[-1])
    system = np.zeros((2 * n + 2, 2 * n + 2))
    system[:n, n:2 * n] = np.eye(n)
    system[n:2 * n, :n] = -np.linalg.solve(M, K)
    system[n:2 * n, n:2 * n] = -rate * np.eye(n)
    system[n:2 * n, -2] = pull
    system[-2, -1] = 1
    state = np.zeros(2 * n + 2)
    if start is not None:
        state[:n] = start
    squares, shapes = eigh(K, M)
    highest = shapes[:, -1] * (not is_whole)
    found = [state[n - 1]]
    for a, b in zip(times, times[1:]):
        state[-2] = force(a, +1)
        state[-1] = (force(b, -1) - force(a, +1)) / (b - a)
        state = expm(system * (b - a)) @ state
        found.append(state[n - 1] - highest[-1] * (highest @ M @ state[:n] - highest[-1] * force(b, +1) / squares[-1]))
    return np.array(found)


def has_all(row):
    """Whether no mode along the bar is left out, of which one of all is."""
    return np.sum(modes(row, "participation")[:, 0] > 1e-10) == CELLS


def imbalance(row):
    """What is missing in the balance of energy at any time, over the largest energy."""
    energy = row["kinetic_energy"] + row["strain_energy"] + row["damping_loss"] - row["external_work"]
    return np.max(np.abs(energy - energy[0])) / np.max(row["kinetic_energy"] + row["strain_energy"])


@pytest.mark.parametrize("mass", ["lumped", "consistent", "weighted"])
def test_frequencies_of_a_bar_are_those_of_its_chain(columns, mass):
    """Of those in which all of a section moves alike: w**2 = 2 (E/rho) (1 - cos kh)/h**2 over the mass, with kL = (n - 1/2) pi."""
    row = columns(BAR, f"method.mass={mass}", "method.modes=47", "method.lumped_fraction=0.27777777777777778")
    kh = (np.arange(CELLS - 1) + 0.5) * np.pi / CELLS
    share = {"lumped": 1.0, "consistent": (5 + 3 * np.cos(kh)) / 8}
    share["weighted"] = 5 / 18 + 13 / 18 * share["consistent"]
    found = modes(row, "frequency")[modes(row, "participation")[:, 0] > 1e-10]
    assert found[:CELLS - 1] == pytest.approx(np.sqrt(2 * E / RHO * (1 - np.cos(kh)) / share[mass]) / H / (2 * np.pi), rel=1e-9)
    assert np.all(modes(row, "error") < 1e-8)


def test_parts_of_the_mass_of_a_bar_are_those_of_its_modes(columns):
    """8/pi**2/(2 n - 1)**2 of a continuous bar, in long waves; along it alone."""
    part = modes(columns(BAR), "participation")
    assert part[:3, 0] == pytest.approx(8 / np.pi**2 / np.array([1, 3, 5])**2, rel=0.02)
    assert np.all(np.abs(part[:, 1]) < 1e-20)


@pytest.mark.parametrize("mass", ["lumped", "consistent", "weighted"])
@pytest.mark.parametrize("rate", [0.0, 3e4, 1e6])
def test_a_bar_under_a_sudden_force_moves_as_its_chain(columns, mass, rate):
    """Rates of damping below and beyond the critical one."""
    row = columns(BAR, f"method.mass={mass}", f"damping.rate={rate}", "method.lumped_fraction=0.27777777777777778")
    exact = chain_under(lambda t, side: FORCE, row["time"], mass, rate, is_whole=has_all(row))
    assert row["load_displacement_end_x"] == pytest.approx(exact, abs=1e-8 * np.max(np.abs(exact)))
    assert imbalance(row) < 1e-11


HISTORIES = {
    "ramp": ("history = 'ramp' start = 1.1e-5 rise_time = 3.7e-5", lambda t: np.clip((t - 1.1e-5) / 3.7e-5, 0, 1), [1.1e-5, 4.8e-5]),
    "table": ("history = 'table' start = 1.3e-5 times = 1e-5, 1.5e-5, 4e-5 factors = 1.0, -0.5, 0.2",
              lambda t: np.interp(t - 1.3e-5, [1e-5, 1.5e-5, 4e-5], [1.0, -0.5, 0.2]) * (t >= 1.3e-5 - 1e-15), [1.3e-5, 2.3e-5, 2.8e-5, 5.3e-5]),
    "late": ("history = 'step' start = 3.3e-5", lambda t: 1.0 * (t >= 3.3e-5), [3.3e-5]),
    "smooth_ramp": ("history = 'smooth_ramp' rise_time = 5.1e-5", lambda t: np.polyval([6, -15, 10, 0, 0, 0], np.clip(t / 5.1e-5, 0, 1)), []),
    "sine": ("history = 'sine' frequency = 2.3e4", lambda t: np.sin(2 * np.pi * 2.3e4 * t), []),
}


@pytest.mark.parametrize("name", HISTORIES)
def test_loads_of_any_history_move_a_bar_as_its_chain(columns, name):
    """Corners and jumps of loads are between rows. Damped a little."""
    words, factor, corners = HISTORIES[name]
    row = columns(BAR.replace(f"force = {FORCE}, 0", f"force = {FORCE}, 0 {words}"), "damping.rate=1e4")
    fine = [] if corners else np.linspace(0, row["time"][-1], 4001)
    times = np.unique(np.round(np.concatenate([row["time"], corners, fine]), 12))
    found = chain_under(lambda t, side: FORCE * factor(t + side * 1e-12), times, rate=1e4, is_whole=has_all(row))
    exact = np.interp(row["time"], times, found)
    assert row["load_displacement_end_x"] == pytest.approx(exact, abs=(1e-6 if corners else 2e-5) * np.max(np.abs(exact)))
    assert imbalance(row) < 1e-10


def test_a_bar_rings_from_static_equilibrium_when_its_load_is_gone(columns):
    """It stays at rest until then."""
    text = BAR.replace(f"force = {FORCE}, 0", f"force = {FORCE}, 0 history = 'table' times = 1e-5, 1.1e-5 factors = 1.0, 0.0")
    row = columns(text.replace("modes = ", "start = 'static' modes = "))
    stretch = FORCE * LENGTH / (E * SECTION)
    assert row["load_displacement_end_x"][:6] == pytest.approx(np.full(6, stretch), rel=1e-9)
    _, K = chain("consistent")
    times = np.unique(np.round(np.concatenate([row["time"], [1e-5, 1.1e-5]]), 12))
    exact = chain_under(lambda t, side: FORCE * np.interp(t, [1e-5, 1.1e-5], [1, 0]), times, start=np.linalg.solve(K, FORCE * np.eye(CELLS)[-1]), is_whole=has_all(row))
    assert row["load_displacement_end_x"] == pytest.approx(np.interp(row["time"], times, exact), abs=1e-6 * stretch)
    assert imbalance(row) < 1e-10


def test_few_modes_with_the_static_rest_end_in_equilibrium(columns):
    """Damped to rest, one mode and what loads do to the others statically are the whole displacement."""
    row = columns(BAR, "method.modes=1", "damping.rate=4e4", "run.end_time=2e-3", "output.history_interval=1e-4")
    assert row["load_displacement_end_x"][-1] == pytest.approx(FORCE * LENGTH / (E * SECTION), rel=1e-9)


ON_A_WALL = BAR.replace("fix = 'xy' name = 'wall'", "fix = 'xy' name = 'wall' {}").replace(f"force = {FORCE}, 0", "force = 1e-9, 0")


def chain_on_a_wall(mass, motion, rate, times, is_whole):
    """Displacements of the end of the chain whose wall moves by motion(t) = (displacement, velocity, acceleration without impulses) between these times, and
    begins to move with a jump of its velocity where that jumps: absolute displacements, by the exponential of the first-order system."""
    m, k = RHO * SECTION * H, E * SECTION / H
    M, K = chain(mass)
    n = len(M)
    couple = {"lumped": 0.0, "consistent": 3 / 16}[mass] * m * np.eye(n)[0]
    spring = -k * np.eye(n)[0]
    inverse = np.linalg.inv(M)
    squares, shapes = eigh(K, M)
    highest = shapes[:, -1] * (not is_whole)
    static = np.ones(n)  # the chain follows the wall as a whole
    size = 2 * n + 4     # u, v, displacement, velocity, acceleration, rate of acceleration of the wall
    system = np.zeros((size, size))
    system[:n, n:2 * n] = np.eye(n)
    system[n:2 * n, :n] = -inverse @ K
    system[n:2 * n, n:2 * n] = -rate * np.eye(n)
    system[n:2 * n, 2 * n] = -inverse @ spring
    system[n:2 * n, 2 * n + 1] = -rate * inverse @ couple
    system[n:2 * n, 2 * n + 2] = -inverse @ couple
    system[2 * n:2 * n + 3, 2 * n + 1:2 * n + 4] = np.eye(3)
    state, found = np.zeros(size), [0.0]
    for a, b in zip(times, times[1:]):
        d, v, c = motion(a, +1)
        state[n:2 * n] -= inverse @ couple * (v - state[2 * n + 1])   # an impulse
        state[2 * n:] = d, v, c, 0.0
        state = expm(system * (b - a)) @ state
        relative = state[:n] - static * state[2 * n]
        found.append(state[n - 1] - highest[-1] * (highest @ M @ relative))
    return np.array(found)


SPEED, RISE = 2.0, 3.7e-5
MOTIONS = {
    "at once": (f"velocity = {SPEED}, 0", lambda t: (SPEED * t, SPEED, 0.0), []),
    "later": (f"velocity = {SPEED}, 0 start = 1.1e-5", lambda t: (SPEED * max(t - 1.1e-5, 0), SPEED * (t >= 1.1e-5), 0.0), [1.1e-5]),
    "faster and faster": (f"velocity = {SPEED}, 0 history = 'ramp' rise_time = {RISE}",
                          lambda t: (SPEED * (min(t, RISE)**2 / 2 / RISE + max(t - RISE, 0)), SPEED * min(t / RISE, 1), SPEED / RISE * (t < RISE)), [RISE]),
    "by a distance": (f"displacement = 1e-5, 0 history = 'ramp' rise_time = {RISE}", lambda t: (1e-5 * min(t / RISE, 1), 1e-5 / RISE * (t < RISE), 0.0), [RISE]),
}


@pytest.mark.parametrize("mass", ["lumped", "consistent"])
@pytest.mark.parametrize("rate", [0.0, 3e4])
@pytest.mark.parametrize("name", MOTIONS)
def test_a_bar_follows_its_wall_as_its_chain(columns, name, rate, mass):
    """Displacement of the free end, and the balance of energy with the work of the wall; corners between rows."""
    words, motion, corners = MOTIONS[name]
    row = columns(ON_A_WALL.format(words), f"method.mass={mass}", f"damping.rate={rate}")
    times = np.unique(np.round(np.concatenate([row["time"], corners]), 12))
    found = chain_on_a_wall(mass, lambda t, side: motion(t + side * 1e-13), rate, times, has_all(row))
    exact = np.interp(row["time"], times, found)
    assert row["load_displacement_end_x"] == pytest.approx(exact, abs=1e-7 * np.max(np.abs(exact)))
    energy = row["kinetic_energy"] + row["strain_energy"] + row["damping_loss"] - row["external_work"]
    assert np.max(np.abs(energy - energy[0])) < 1e-10 * np.max(row["kinetic_energy"] + row["strain_energy"])


def test_a_wall_that_moves_sends_a_wave_through_a_bar(columns):
    """The free end stays until the wave arrives, moves at twice the speed of the wall until its reflection is back from there, and stays again: d'Alembert."""
    text = ON_A_WALL.format(f"velocity = {SPEED}, 0").replace(str(H), str(H / 4)).replace(f"cells = {CELLS}", f"cells = {4 * CELLS}")
    row = columns(text, "method.modes=180", "run.end_time=1.1e-4")
    arrival = LENGTH / np.sqrt(E / RHO)
    t = row["time"]
    exact = 2 * SPEED * (np.clip(t, arrival, 3 * arrival) - arrival)
    assert row["load_displacement_end_x"] == pytest.approx(exact, abs=0.01 * np.max(exact))


def test_a_slender_beam_has_the_frequency_of_timoshenko(columns):
    """(1.8751/L)**2 sqrt(E I/(rho A)), lowered by shear and rotatory inertia by 0.3 % at a slenderness of 20: quadratic cells."""
    length, depth = 0.2, 0.01
    row = columns(f"""&run end_time = 1e-3 plane = 'stress' thickness = 0.01 /
&grid lower = 0, 0 cell = 5e-3 cells = 40, 2 order = 2 /
&material name = 'a' young = 70e9 poisson = 0.3 density = 2700 /
&body material = 'a' lower = 0, 0 upper = {length}, {depth} points_per_cell = 3 /
&constraint lower = 0, 0 upper = 0, {depth} fix = 'xy' /
&load kind = 'traction' lower = {length}, 0 upper = {length}, {depth} force = 0, 10 /
&method time = 'modal' mass = 'consistent' /
&output history_interval = 1e-4 /
""")
    euler = np.array([1.87510407, 4.69409113])**2 * np.sqrt(70e9 / 12 / 2700) * depth / length**2 / (2 * np.pi)
    found = modes(row, "frequency")[:2]
    assert np.all(found < euler) and found[0] == pytest.approx(euler[0], rel=5e-3) and found[1] == pytest.approx(euler[1], rel=2e-2)


def test_a_free_plate_has_three_rigid_modes_and_flies_as_one(columns):
    """It moves and spins; no mode strains it. The work of a force on it is the kinetic energy of its middle and what it stores."""
    row = columns(PLATE.format("velocity = 3.0, -2.0", ""))
    found = modes(row, "frequency")
    assert np.all(found[:3] == 0) and found[3] > 1e4
    energy = 0.5 * 2700 * 0.04 * 0.02 * 13
    assert row["kinetic_energy"] == pytest.approx(energy, rel=1e-9) and np.all(np.abs(row["strain_energy"]) < 1e-12 * energy)
    assert row["displacement"] == pytest.approx(np.tile([3e-4, -2e-4], (len(row["displacement"]), 1)), rel=1e-9)


@pytest.mark.parametrize("rate", [0.0, 1e3, 1e6])
def test_a_force_moves_a_free_plate_as_a_mass(columns, rate):
    """m v' + m rate v = F in the mean, as momentum is conserved."""
    row = columns(PLATE.format("", "&load kind = 'body' lower = 0, 0 upper = 0.04, 0.02 force = 1e6, 0 history = 'ramp' rise_time = 3e-5 /"
                                   f"\n&damping rate = {rate} /"))
    mass, t, rise = 2700 * 0.04 * 0.02, 1e-4, 3e-5
    steps = np.linspace(0, t, 200001)
    force = 1e6 / mass * np.clip(steps / rise, 0, 1)
    v = np.cumsum(force * np.exp(rate * (steps - t))) * steps[1] - 0.5 * steps[1] * force[-1]
    assert np.mean(row["velocity"][:, 0]) == pytest.approx(v[-1], rel=1e-3)
    assert imbalance(row) < 1e-10


def test_too_few_modes_for_a_free_body_are_told(columns):
    assert "modes leave out motion as a whole" in columns(PLATE.format("velocity = 3.0, -2.0", ""), "method.modes=2", code=3)


REFINED = (DCB, "method.frame=total", "method.courant=0", "method.mass=consistent", "damping.rate=0", "grid.cell=2.5e-3", "grid.cells=40,5", "refine.indicator=tip",
           "refine.max_level=3", "refine.rings=2", "energy_release.estimators=domain_integral,vcct", "output.snapshot_interval=0", "output.history_interval=2e-6",
           "run.end_time=6e-4")


def test_release_rate_of_a_beam_is_that_of_short_implicit_steps(columns):
    """Of the paper's beam, refined around its tip; of as many modes as it takes by itself. Below 20 kHz, where steps of 0.25 us are exact."""
    implicit = columns(*REFINED, "method.time=implicit", "method.time_step=0.25e-6")
    row = columns(*REFINED, "method.time=modal")
    at = row["time"]
    for name in ("G", "J"):
        one, other = (lowpass(at, np.interp(at, run["time"], run[name]), 20e3) for run in (row, implicit))
        assert np.sqrt(np.mean((one - other)**2)) < 1e-3 * np.max(np.abs(other))
    assert imbalance(row) < 1e-10


def test_release_rate_of_a_beam_is_that_of_converged_finite_elements(columns):
    """Below 50 kHz, from `tests/reference/dcb_dynamic_undamped.csv`; quadratic cells."""
    row = columns(*REFINED, "method.time=modal", "method.mass=lumped", "grid.order=2", "body.points_per_cell=3", "refine.max_level=6", "refine.rings=1",
                  "energy_release.estimators=vcct", "run.end_time=7.2e-4", "output.history_interval=1e-6")
    times, exact = read_curve(REFERENCE / "dcb_dynamic_undamped.csv", 1)
    at, reference = row["time"], 12 * 0.05**2 / (70e9 * 0.01**2 * 0.01**3)
    within = at <= 6e-4
    exact, found = (lowpass(at, curve, 50e3)[within] for curve in (np.interp(at, times, exact), row["G_vcct_I"] / reference))
    assert np.sqrt(np.mean((found - exact)**2)) < 1e-3 * np.max(np.abs(exact))


CRACKED = """\
&run end_time = 6e-5 plane = 'strain' /
&grid lower = -12e-3, -12e-3 cell = 2e-3 cells = 12, 12 {order} /
&material name = 'a' young = 70e9 poisson = 0.3 density = 2700 /
&body material = 'a' lower = -10e-3, -10e-3 upper = 10e-3, 10e-3 {points} /
&crack kind = 'path' points = -3.3e-3, -1.7e-3, 3.1e-3, 2.3e-3 name = 'a' /
{more}
&method time = 'modal' mass = 'consistent' modes = 60 /
&energy_release estimators = 'domain_integral' energy_balance = .true. /
&output history_interval = 1e-6 /
"""
PULLED = """&constraint lower = -10e-3, -10e-3 upper = 10e-3, -10e-3 fix = 'xy' /
&load kind = 'traction' lower = -10e-3, 10e-3 upper = 10e-3, 10e-3 force = 2e4, 4e4 history = 'smooth_ramp' rise_time = 1e-5 /"""
PRESSED = "&load kind = 'pressure' on = 'crack' pressure = 1e6 history = 'ramp' rise_time = 2e-5 /\n&damping rate = 2e4 /"


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("more", [PULLED, PRESSED], ids=["pulled", "pressed"])
def test_factors_of_a_slanted_crack_are_those_of_short_implicit_steps(columns, order, more):
    """It cuts cells, with a ghost penalty; the body that is pressed apart from inside is free. Modes of 60 are dense up to what the load wakes."""
    text = CRACKED.format(order="order = 2" if order == 2 else "", points="points_per_cell = 3" if order == 2 else "", more=more)
    row = columns(text)
    implicit = columns(text.replace("time = 'modal'", "time = 'implicit' time_step = 1e-7").replace("modes = 60", ""))
    for name in ("K_I", "K_II", "J_tip2"):
        other = np.interp(row["time"], implicit["time"], implicit[name])
        assert np.max(np.abs(row[name] - other)) < 4e-3 * np.max(np.abs(implicit["K_I" if name == "K_II" else name]))
    assert imbalance(row) < 1e-7  # pieces of cells are held by 1e-10 of their stiffness


# What its bodies are made of, how cells are, and what acts: each with short implicit steps of the same as its reference
PARTS = {
    "refined": ("cells = 12, 12", "", "&refine indicator = 'tip' max_level = 2 rings = 2 /"),
    "axisymmetric": ("cells = 12, 12", "", ""),
    "orthotropic": ("cells = 12, 12", "law = 'orthotropic' density = 1600 young_1 = 140e9 young_2 = 10e9 shear_12 = 5e9 poisson_12 = 0.3 young_3 = 10e9 poisson_13 = 0.3 poisson_23 = 0.4 angle = 30", ""),
    "b_bar": ("cells = 12, 12", "young = 70e9 poisson = 0.49 volumetric = 'b_bar' density = 2700", ""),
    "bonded": ("cells = 12, 12", "", "&body material = 'b' lower = 10e-3, -10e-3 upper = 12e-3, 10e-3 /\n&material name = 'b' young = 200e9 poisson = 0.3 density = 7800 /"),
    "gravity": ("cells = 12, 12", "", "&load kind = 'gravity' acceleration = 1e6, -2e6 history = 'sine' frequency = 2e4 /"),
    "a pin": ("cells = 12, 12", "", "&constraint lower = 10e-3, -2e-3 upper = 10e-3, 2e-3 fix = 'xy' turns = .true. /"),
    "a moved side": ("cells = 12, 12", "", "&constraint lower = 10e-3, -10e-3 upper = 10e-3, 0.0 fix = 'x' displacement = 2e-7, 0 history = 'smooth_ramp' rise_time = 2e-5 /\n"
                     "&damping rate = 2e4 /"),
    "a moved pin": ("cells = 12, 12", "", "&constraint lower = 10e-3, -2e-3 upper = 10e-3, 2e-3 fix = 'xy' turns = .true. velocity = 3e-3, 8e-3 history = 'smooth_ramp' rise_time = 3e-5 /"),
    "a hole": ("cells = 12, 12", "", "&body hole = .true. shape = 'circle' center = 5e-3, -5e-3 radius = 2.3e-3 /"),
    "moving": ("cells = 12, 12", "", "spin = 30.0"),
}


@pytest.mark.parametrize("name", PARTS)
def test_bodies_move_as_in_short_implicit_steps(columns, name):
    """Energies, reactions and K of as many modes as it takes, after a load that rises in 20 us."""
    cells, material, more = PARTS[name]
    text = CRACKED.format(order="", points="spin = 30.0" if name == "moving" else "", more=PULLED.replace("1e-5", "2e-5") + "\n" + (more if name != "moving" else ""))
    number = 10000 if name == "moving" else 120  # what turns at once wakes all modes, of which there are fewer
    text = text.replace("modes = 60", f"modes = {number}")
    if material:
        text = text.replace("young = 70e9 poisson = 0.3 density = 2700", material)
    if name == "axisymmetric":
        text = text.replace("'strain'", "'axisymmetric'").replace("lower = -12e-3", "lower = 0.0").replace("lower = -10e-3", "lower = 0.0").replace("upper = 10e-3", "upper = 20e-3")
        text = text.replace("points = -3.3e-3, -1.7e-3, 3.1e-3, 2.3e-3", "points = 6.7e-3, -1.7e-3, 13.1e-3, 2.3e-3").replace("force = 2e4, 4e4", "force = 0.0, 4e4").replace("fix = 'xy'", "fix = 'y'")
    if name in ("a pin", "a moved pin"):
        text = text.replace("lower = -10e-3, -10e-3 upper = 10e-3, -10e-3 fix = 'xy'", "lower = -10e-3, -10e-3 upper = -10e-3, -10e-3 fix = 'x'")
    dt = 1e-7
    if name == "moving":
        dt, text = 1e-8, text.replace("end_time = 6e-5", "end_time = 2e-5")
    row = columns(text)
    implicit = columns(text.replace("time = 'modal'", f"time = 'implicit' time_step = {dt}").replace(f"modes = {number}", ""))
    for one in ("kinetic_energy", "strain_energy", "external_work", "K_I", "J", "reaction_x", "reaction_y"):
        other = np.interp(row["time"], implicit["time"], implicit[one])
        scale = np.max(np.abs(implicit["reaction_y" if "reaction" in one else one]))
        assert np.max(np.abs(row[one] - other)) < 8e-3 * scale, one
    assert imbalance(row) < 1e-7


@pytest.mark.parametrize("foot", ["", "velocity = 0.0, 0.0, 2e-3 history = 'smooth_ramp' rise_time = 1e-5"])
def test_a_solid_moves_as_in_short_implicit_steps(hampm3d, foot):
    """With a crack in a plane of the grid, on a foot that may move; a free block has six rigid modes."""
    text = """&run end_time = 4e-5 /
&grid lower = 0, 0, 0 cell = 2e-3 cells = 8, 4, 16 /
&material name = 'a' young = 70e9 poisson = 0.3 density = 2700 /
&body material = 'a' lower = 0, 0, 0 upper = 16e-3, 8e-3, 32e-3 /
&crack kind = 'plane' normal = 'z' tip = 8e-3, 4e-3, 16e-3 direction = 1, 0, 0 name = 'a' /
&constraint lower = 0, 0, 0 upper = 16e-3, 8e-3, 0 fix = 'xyz' FOOT /
&load kind = 'traction' lower = 0, 0, 32e-3 upper = 16e-3, 8e-3, 32e-3 force = 1e2, 0, 3e2 history = 'smooth_ramp' rise_time = 1e-5 /
&method time = 'modal' modes = 150 /
&energy_release estimators = 'vcct' energy_balance = .true. /
&output history_interval = 1e-6 /
"""
    text = text.replace("FOOT", foot)
    row = harness.run(hampm3d, text, name="solid")
    implicit = harness.run(hampm3d, text.replace("'modal' modes = 150", "'implicit' time_step = 2e-7"), name="steps")
    for one in ("kinetic_energy", "strain_energy", "external_work", "G_vcct_I"):
        other = np.interp(row["time"], implicit["time"], implicit[one])
        assert np.max(np.abs(row[one] - other)) < 8e-3 * np.max(np.abs(other)), one
    assert imbalance(row) < 1e-10
    free = harness.run(hampm3d, "\n".join(line for line in text.splitlines() if "&constraint" not in line) + "\n", name="free")
    assert np.all(modes(free, "frequency")[:6] == 0) and modes(free, "frequency")[6] > 1e3


def test_sudden_heat_shakes_a_bar_as_implicit_steps_have_it(columns):
    """An eigenstrain that is there at once, with a load that comes later."""
    text = BAR.replace(f"upper = {LENGTH}, {DEPTH} /\n&constraint lower = 0, 0 upper = 0", f"upper = {LENGTH}, {DEPTH} eigenstrain = 1e-4, 0, 0 /\n&constraint lower = 0, 0 upper = 0", 1)
    text = text.replace(f"force = {FORCE}, 0", f"force = {FORCE}, 0 history = 'ramp' start = 3e-5 rise_time = 1e-5")
    row, implicit = columns(text), columns(text.replace("'modal' modes = 47", "'implicit' time_step = 1e-7"))
    other = np.interp(row["time"], implicit["time"], implicit["load_displacement_end_x"])
    assert row["load_displacement_end_x"] == pytest.approx(other, abs=5e-3 * np.max(np.abs(other)))
    resting = columns(text.replace("modes = ", "start = 'static' modes = "))
    assert resting["load_displacement_end_x"][:15] == pytest.approx(np.full(15, 1e-4 * LENGTH), rel=1e-9)


@pytest.mark.parametrize("held", ["", "&constraint lower = 0, 0 upper = 0, 0.02 fix = 'xy' velocity = 1.0, 2.0 displacement = 1e-5, 0 history = 'sine' frequency = 3e4 /\n"])
def test_a_run_that_is_resumed_has_the_same_bytes(columns, hampm, held):
    text = PLATE.format("velocity = 3.0, -2.0", held + "&load kind = 'traction' lower = 0.04, 0 upper = 0.04, 0.02 force = 1e5, 2e5 history = 'sine' frequency = 2e4 /\n&damping rate = 1e3 /")
    row = columns(text)
    assert imbalance(row) < 1e-10
    (hampm.folder / "other.nml").write_text(text)
    assert hampm("other.nml", "--steps", "37", "--set", "output.file=other.h5").returncode == 5
    assert hampm("--resume", "other.h5.checkpoint").returncode == 0
    assert not differing(hampm.folder / "case.h5", hampm.folder / "other.h5")


def test_shapes_of_modes_are_those_of_a_bar(columns):
    """sin((n - 1/2) pi x/L) at the particles, the largest 1."""
    row = columns(BAR)
    place, shape = modes(row, "position"), modes(row, "shape").reshape(47, -1, 2)
    for n in range(4):
        wave = np.sin((n + 0.5) * np.pi * place[:, 0] / LENGTH)
        along = shape[n, :, 0] * np.sign(shape[n, :, 0] @ wave)
        assert along == pytest.approx(wave / np.max(np.abs(wave)), abs=0.01) and np.max(np.abs(shape[n])) == 1


def test_check_tells_the_rows_and_the_wall_time(hampm, columns):
    (hampm.folder / "bar.nml").write_text(BAR)
    said = hampm("--check", "bar.nml", timed=True)
    assert said.returncode == 0 and "steps           100" in said.stdout and "wall time" in said.stdout, said.stdout
