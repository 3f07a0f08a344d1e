"""Pressure that follows the edges and faces on which it acts, in the updated frame and on laws for any strain: closed forms, an elastica, what must be conserved."""

import itertools

import h5py
import harness
import numpy as np
import pytest
from paths import SOLID_PROGRAM
from scipy.integrate import solve_bvp
from scipy.optimize import brentq

YOUNG, POISSON = 1e6, 0.3
MU, LAME = YOUNG / 2 / (1 + POISSON), YOUNG * POISSON / (1 + POISSON) / (1 - 2 * POISSON)
SIDES = [((-10, 4), (10, 4)), ((-10, -4), (10, -4)), ((-10, -4), (-10, 4)), ((10, -4), (10, 4))]


def boxes(sides, pressure, history):
    return "".join(f"&load kind = 'pressure' lower = {', '.join(f'{x}e-3' for x in a)} upper = {', '.join(f'{x}e-3' for x in b)} pressure = {pressure} "
                   f"{history} /\n" for a, b in sides)


def spinning(method, spin=50.0):
    return f"""\
&run plane = 'strain' end_time = 3.0e-2 /
&grid lower = -40e-3, -40e-3 cell = 2e-3 cells = 40, 40 /
&material name = 'rubber' law = 'neo_hookean' young = {YOUNG} poisson = {POISSON} density = 1000 /
&body material = 'rubber' lower = -10e-3, -4e-3 upper = 10e-3, 4e-3 spin = {spin} /
&method {method} /
&energy_release energy_balance = .true. /
&output file = 'r.h5' snapshot_interval = 1e-3 /
""" + boxes(SIDES, 2e4, "history = 'smooth_ramp' rise_time = 5e-3")


def turns(path, mass):
    """Angular momentum around the middle at each snapshot."""
    found, at = [], 0
    with h5py.File(path) as file:
        data = file["VTKHDF/particles"]
        for n in data["NumberOfPoints"][()]:
            x, v = data["Points"][at:at + n], data["PointData/velocity"][at:at + n]
            x, v = x - x.mean(axis=0), v - v.mean(axis=0)
            found.append(mass / n * np.sum(x[:, 0] * v[:, 1] - x[:, 1] * v[:, 0]))
            at += n
    return np.array(found)


@pytest.mark.parametrize(("method", "within"), [("frame = 'total'", 0.02), ("frame = 'updated' shape_functions = 'cpdi'", 0.03), ("frame = 'updated'", 0.3)])
def test_pressure_on_all_edges_turns_no_free_block(hampm, method, within):
    """A pressure all around has no moment. (In the updated frame with bilinear functions the block loses 16 % of its momentum without any pressure too.) The work of
    the loads is stored or moves the block."""
    row = harness.run(hampm, spinning(method))
    moment = turns(row.path, 1000 * 20e-3 * 8e-3)
    assert np.abs(moment / moment[0] - 1).max() < within
    assert row["kinetic_energy"].max() < 4 * row["kinetic_energy"][0]
    if "'updated' /" not in spinning(method):
        assert abs(row["numerical_loss"][-1]) < 2e-3 * row["strain_energy"][-1]


def squeezed(time, order=1, pressure=2e5):
    return f"""\
&run plane = 'strain' end_time = 1.0 /
&grid lower = -2e-3, -2e-3 cell = 2e-3 cells = 14, 12 order = {order} /
&material name = 'rubber' law = 'neo_hookean' young = {YOUNG} poisson = {POISSON} density = 1000 /
&body material = 'rubber' lower = 0, 0 upper = 20e-3, 16e-3 points_per_cell = {order + 1} /
&constraint lower = 0, 0 upper = 0, 16e-3 fix = 'x' /
&constraint lower = 0, 0 upper = 20e-3, 0 fix = 'y' /
&method {time} frame = 'total' /
&probe name = 'a' quantity = 'displacement' at = 20e-3, 16e-3 /
&output file = 'r.h5' /
""" + boxes([((0, 16), (20, 16)), ((20, 0), (20, 16))], pressure, "history = 'ramp' rise_time = 1.0")


def stretch_under(pressure, directions):
    """Of material that a pressure squeezes alike in two or three directions."""
    return brentq(lambda s: MU * (s**2 - 1) + LAME * np.log(s**directions) + pressure * s**directions, 0.3, 1.0)


@pytest.mark.parametrize(("time", "order", "within"), [("time = 'static' load_steps = 1", 1, 1e-9), ("time = 'static' load_steps = 2", 2, 1e-9),
                                                        ("time = 'implicit' time_step = 0.05", 1, 3e-3)])
def test_pressure_acts_on_the_area_that_is_left(hampm, time, order, within):
    row = harness.run(hampm, squeezed(time, order))
    u = stretch_under(2e5, 2) - 1
    assert row["displacement_a_x"][-1] == pytest.approx(20e-3 * u, rel=within)
    assert row["displacement_a_y"][-1] == pytest.approx(16e-3 * u, rel=within)


def elastica(pressure, length, depth, follows):
    """Displacement of the end of a cantilever that cannot be stretched, under a force on its length that stays normal to it, or stays as it is."""
    stiffness = YOUNG * depth**3 / 12

    def rates(s, y, p):
        turn, moment, f_x, f_y = y[2:]
        load = p * np.array([-np.sin(turn), np.cos(turn)]) if follows else p * np.array([0 * turn, 0 * turn + 1])
        beside = 0 if follows else p * depth / 2 * np.sin(turn)  # it acts on the upper side, beside the middle of the section
        return np.array([np.cos(turn), np.sin(turn), moment / stiffness, f_x * np.sin(turn) - f_y * np.cos(turn) - beside, *load])
    s, y = np.linspace(0, length, 200), np.zeros((6, 200))
    y[0] = s
    for part in np.linspace(0.1, 1, 10):
        y = solve_bvp(lambda s, y, p=part * pressure: rates(s, y, p), lambda a, b: np.array([a[0], a[1], a[2], b[3], b[4], b[5]]), s, y, tol=1e-8,
                      max_nodes=20000).sol(s)
    return y[0, -1] - length, y[1, -1]


@pytest.mark.parametrize("load", ["pressure", "traction"])
def test_a_cantilever_under_a_load_that_follows_it_or_stays(hampm, load):
    """The tangent has the change of the pressure: each of 8 load steps ends. 20 depths long, it is an elastica but for shear."""
    length, depth, p = 40e-3, 2e-3, 40.0
    size = f"pressure = {p}" if load == "pressure" else f"force = 0, {-p * length}"
    row = harness.run(hampm, f"""\
&run plane = 'strain' end_time = 1.0 /
&grid lower = -2e-3, -2e-3 cell = 1e-3 cells = 44, 6 order = 2 /
&material name = 'rubber' law = 'neo_hookean' young = {YOUNG} poisson = 0.0 density = 1000 /
&body material = 'rubber' lower = 0, 0 upper = {length}, {depth} points_per_cell = 3 /
&constraint lower = 0, 0 upper = 0, {depth} fix = 'xy' /
&load kind = '{load}' lower = 0, {depth} upper = {length}, {depth} {size} history = 'ramp' rise_time = 1.0 /
&method time = 'static' load_steps = 8 frame = 'total' /
&probe name = 'a' quantity = 'displacement' at = {length}, {depth / 2} /
&output file = 'r.h5' /
""")
    x, y = elastica(p, length, depth, load == "pressure")
    assert row["displacement_a_y"][-1] == pytest.approx(y, rel=0.015)
    assert row["displacement_a_x"][-1] == pytest.approx(x, rel=0.03)
    assert row["external_work"][-1] == pytest.approx(row["strain_energy"][-1], rel=5e-3)


def test_j_of_faces_under_a_pressure_that_follows_them_hangs_on_no_disc(hampm):
    row = harness.run(hampm, f"""\
&run plane = 'strain' end_time = 1.0 /
&grid lower = -32e-3, -32e-3 cell = 1e-3 cells = 64, 64 /
&material name = 'rubber' law = 'neo_hookean' young = {YOUNG} poisson = {POISSON} density = 1000 /
&body material = 'rubber' lower = -30e-3, -30e-3 upper = 30e-3, 30e-3 /
&crack kind = 'path' points = -10e-3, 0.0003, 10e-3, 0.0003 /
&constraint lower = -30e-3, -30e-3 upper = 30e-3, -30e-3 fix = 'xy' /
&load kind = 'pressure' on = 'crack' pressure = 2e5 history = 'ramp' rise_time = 1.0 /
&method time = 'static' load_steps = 4 frame = 'total' /
&energy_release estimators = 'domain_integral' radii = 3e-3, 5e-3, 7e-3 /
&output file = 'r.h5' /
""")
    assert row["J_domain_dependence"][-1] < 3e-3 * row["J"][-1]


ALL_AROUND = [((0, 0, 6), (8, 8, 6)), ((0, 8, 0), (8, 8, 6)), ((8, 0, 0), (8, 8, 6))]


@pytest.mark.skipif(not SOLID_PROGRAM.exists(), reason="make program dim=3 makes it")
@pytest.mark.parametrize("solver", ["direct", "cg"])
def test_pressure_on_a_solid_acts_on_the_area_that_is_left(hampm, solver):
    text = f"""\
&run end_time = 1.0 /
&grid lower = -2e-3, -2e-3, -2e-3 cell = 2e-3 cells = 6, 6, 5 /
&material name = 'rubber' law = 'neo_hookean' young = {YOUNG} poisson = {POISSON} density = 1000 /
&body material = 'rubber' lower = 0, 0, 0 upper = 8e-3, 8e-3, 6e-3 /
&constraint lower = 0, 0, 0 upper = 0, 8e-3, 6e-3 fix = 'x' /
&constraint lower = 0, 0, 0 upper = 8e-3, 0, 6e-3 fix = 'y' /
&constraint lower = 0, 0, 0 upper = 8e-3, 8e-3, 0 fix = 'z' /
&method time = 'static' load_steps = 1 solver = '{solver}' frame = 'total' /
&probe name = 'a' quantity = 'displacement' at = 8e-3, 8e-3, 6e-3 /
&output file = 'r.h5' /
""" + boxes(ALL_AROUND, 2e5, "history = 'ramp' rise_time = 1.0")
    row = solid_run(hampm, text)
    u = stretch_under(2e5, 3) - 1
    assert [row[f"displacement_a_{d}"][-1] for d in "xyz"] == pytest.approx([8e-3 * u, 8e-3 * u, 6e-3 * u], rel=1e-8)


def solid_run(hampm, text):
    def solid(*arguments, **options):
        return hampm(*arguments, program=SOLID_PROGRAM, **options)
    solid.folder = hampm.folder
    return harness.run(solid, text)


@pytest.mark.skipif(not SOLID_PROGRAM.exists(), reason="make program dim=3 makes it")
@pytest.mark.parametrize(("frame", "within"), [("total", 0.03), ("updated", 0.3)])
def test_pressure_on_all_sides_turns_no_free_solid(hampm, frame, within):
    a, b, c = 8, 4, 3
    sides = [((s * a, -b, -c), (s * a, b, c)) for s in (-1, 1)] + [((-a, s * b, -c), (a, s * b, c)) for s in (-1, 1)] \
        + [((-a, -b, s * c), (a, b, s * c)) for s in (-1, 1)]
    row = solid_run(hampm, f"""\
&run end_time = 1.2e-2 /
&grid lower = -16e-3, -16e-3, -8e-3 cell = 2e-3 cells = 16, 16, 8 /
&material name = 'rubber' law = 'neo_hookean' young = {YOUNG} poisson = {POISSON} density = 1000 /
&body material = 'rubber' lower = -8e-3, -4e-3, -3e-3 upper = 8e-3, 4e-3, 3e-3 spin = 0, 0, 50 /
&method frame = '{frame}' /
&output file = 'r.h5' snapshot_interval = 2e-3 /
""" + boxes(sides, 2e4, "history = 'smooth_ramp' rise_time = 5e-3"))
    moment = turns(row.path, 1000 * 16e-3 * 8e-3 * 6e-3)
    assert np.abs(moment / moment[0] - 1).max() < within


@pytest.mark.skipif(not SOLID_PROGRAM.exists(), reason="make program dim=3 makes it")
def test_a_solid_that_is_pulled_and_pressed_is_so_in_both_frames(hampm):
    """Pressure all around has no resultant as it turns with faces that a pull deforms: the momentum is that of the pull. What the body stores is the same in both frames, in these coarse
    cells to a tenth."""
    pull, end = (1.0, 0.3, 0.0), 2e-3
    corners = np.array([8, 4, 4])
    sides = []
    for d, s in itertools.product(range(3), (-1, 1)):
        lower, upper = -corners, corners.copy()
        lower[d] = upper[d] = s * corners[d]
        sides.append((lower, upper))
    rows = [solid_run(hampm, f"""\
&run end_time = {end} /
&grid lower = -16e-3, -12e-3, -12e-3 cell = 4e-3 cells = 8, 6, 6 /
&material name = 'rubber' law = 'neo_hookean' young = {YOUNG} poisson = {POISSON} density = 1000 /
&body material = 'rubber' lower = -8e-3, -4e-3, -4e-3 upper = 8e-3, 4e-3, 4e-3 /
&load kind = 'traction' lower = 8e-3, -4e-3, -4e-3 upper = 8e-3, 4e-3, 4e-3 force = {', '.join(map(str, pull))} /
&method frame = '{frame}' /
&output file = 'r.h5' history_interval = {end / 10} /
""" + boxes(sides, YOUNG / 10, "history = 'smooth_ramp' rise_time = 1e-3")) for frame in ("updated", "total")]
    assert [rows[0][f"momentum_{d}"][-1] for d in "xyz"] == pytest.approx([force * end for force in pull], abs=1e-12)
    assert rows[0]["strain_energy"][-1] == pytest.approx(rows[1]["strain_energy"][-1], rel=0.15)
