"""The program for solids beside theory: limits of its step, and waves and vibrations with closed forms."""

import itertools
import re
import subprocess

import h5py
import numpy as np
import pytest
from paths import REFERENCE, SOLID_PROGRAM

pytestmark = pytest.mark.skipif(not SOLID_PROGRAM.exists(), reason="make program dim=3 makes it")
FORCED = SOLID_PROGRAM.with_name("forced_step")

# Loads at places without symmetry set in at once, and move all modes of the cube. Lengths are in cells, with Young's modulus and density 1
CUBE = """
&run end_time = {end} /
&grid cell = 1.0  cells = {grid}, {grid}, {grid} /
&material name = 'a'  young = 1.0  poisson = {poisson}  density = 1.0 /
&body material = 'a'  lower = 1.0, 1.0, 1.0  upper = {upper}, {upper}, {upper} /
&load kind = 'point'  lower = 1.03, 1.03, 1.03  upper = 1.03, 1.03, 1.03  force = 1e-6, 3e-7, -5e-7 /
&load kind = 'point'  lower = {far}  upper = {far}  force = -4e-7, 8e-7, 6e-7 /
&method mass = '{mass}'  courant = {courant}  wave_speed = 'dilatational' /
&output file = 'case.h5'  history_interval = {interval} /
"""


def cube(folder, cells, poisson, mass, courant=0.0, step=1.0, steps=400):
    """The namelist of a free cube, of which steps are in dilatational waves through a cell."""
    speed = ((1 - poisson) / ((1 + poisson) * (1 - 2 * poisson))) ** 0.5
    far = ", ".join(repr(1 + part * cells) for part in (0.71, 0.63, 0.8))
    (folder / "case.nml").write_text(CUBE.format(end=steps * step / speed, interval=steps * step / speed / 8, grid=cells + 2, upper=cells + 1.0, far=far,
                                                 poisson=poisson, mass=mass, courant=courant))


def named_limit(folder, *what):
    """The largest courant number, as a model is told that asks for more."""
    cube(folder, *what, courant=10.0)
    said = subprocess.run([SOLID_PROGRAM, "case.nml", "--check", "--quiet"], cwd=folder, capture_output=True, text=True).stderr
    return float(re.search(r"&method courant = 10\.0: must be at most (\S+), not 10\.0.* is unstable in a solid", said)[1])


def survives(folder, courant, *what):
    """Whether a run with a courant number, allowed or not, comes to its end."""
    cube(folder, *what, step=courant)
    result = subprocess.run([FORCED, repr(courant), "case.nml", "--force", "--quiet"], cwd=folder, capture_output=True, text=True)
    assert result.returncode in (0, 3), result.stderr
    return result.returncode == 0


@pytest.mark.parametrize(("poisson", "consistent", "lumped"), np.loadtxt(REFERENCE / "solid/timestep_limits.csv", delimiter=","))
def test_limit_of_a_free_cell(tmp_path, poisson, consistent, lumped):
    """Three digits, rounded down, of the reference; with the lumped matrix twice of it."""
    for mass, limit in (("consistent", consistent), ("lumped", 2 * lumped)):
        named = named_limit(tmp_path, 1, poisson, mass)
        print(mass, poisson, f"asked {limit:.4f}, named {named}")
        assert 0.99 * limit < named <= limit


@pytest.mark.verify
@pytest.mark.parametrize("poisson", [0.0, 0.3, 0.45])
@pytest.mark.parametrize("mass", ["lumped", "consistent"])
@pytest.mark.parametrize("cells", [1, 3, 6])
def test_limit_is_that_of_the_run(tmp_path, cells, mass, poisson):
    """Below it nothing grows, above it everything does."""
    if not FORCED.exists():
        pytest.skip("make build/release3d/forced_step dim=3 makes it")
    named = named_limit(tmp_path, cells, poisson, mass)
    assert survives(tmp_path, 0.99 * named, cells, poisson, mass)
    assert not survives(tmp_path, (1.01 if cells < 6 else 1.04) * named, cells, poisson, mass)


def run(folder, text):
    (folder / "case.nml").write_text(text)
    result = subprocess.run([SOLID_PROGRAM, "case.nml", "--quiet", "--force"], cwd=folder, capture_output=True, text=True)
    assert result.returncode == 0, result.stderr
    return h5py.File(folder / "case.h5")


AMPLITUDE, POISSON, PART = 1e-6, 0.3, 0.75   # of a period, after which displacements are compared
SHEAR_SPEED = (1 / (2 * (1 + POISSON))) ** 0.5
DILATATIONAL_SPEED = ((1 - POISSON) / ((1 + POISSON) * (1 - 2 * POISSON))) ** 0.5


def shape(kind, axes, x):
    """A mode of a unit cube at places: standing waves between rollers, u_n = 0 without shear traction, or the Lame mode of free sides."""
    a, b = axes
    u, (sine, cosine) = np.zeros_like(x), (np.sin(np.pi * x), np.cos(np.pi * x))
    if kind == "lame":
        u[:, a], u[:, b] = cosine[:, a] * sine[:, b], -sine[:, a] * cosine[:, b]
    else:
        u[:, a], u[:, b] = sine[:, a] * cosine[:, b], (1 if kind == "dilatation" else -1) * cosine[:, a] * sine[:, b]
    return u


def error_of_mode(folder, cells, kind, axes, method):
    """Of the displacement, in the mean square, over the amplitude of the mode. Each column of particles is a body, with the velocity of the mode."""
    cell, depth, across = 1 / cells, 2 / cells, 3 - sum(axes)
    frequency = np.pi * 2**0.5 * (DILATATIONAL_SPEED if kind == "dilatation" else SHEAR_SPEED)
    end = float(PART * 2 * np.pi / frequency)
    size = np.ones(3)
    size[across] = depth
    counts = [round(length / cell) for length in size]
    text = [f"&run end_time = {end} /", f"&grid cell = {cell}  cells = {counts[0]}, {counts[1]}, {counts[2]} /",
            f"&material name = 'a'  young = 1.0  poisson = {POISSON}  density = 1.0 /"]

    def box(lower, upper):
        return "lower = {}, {}, {}  upper = {}, {}, {}".format(*map(float, lower), *map(float, upper))

    for place in itertools.product(range(2 * cells), repeat=2):
        lower, upper = np.zeros(3), size.copy()
        lower[list(axes)], upper[list(axes)] = np.array(place) / (2 * cells), (np.array(place) + 1) / (2 * cells)
        velocity = AMPLITUDE * frequency * shape(kind, axes, (lower + upper)[None] / 2)[0]
        text.append(f"&body material = 'a'  {box(lower, upper)}  velocity = " + ", ".join(repr(float(v)) for v in velocity) + " /")
    for axis, side in itertools.product(range(3), range(2)):
        lower, upper = np.zeros(3), size.copy()
        lower[axis] = upper[axis] = side * size[axis]
        if kind != "lame":
            text.append(f"&constraint {box(lower, upper)}  fix = '{'xyz'[axis]}' /")
    text.append(f"&method {method} /\n&output file = 'case.h5'  history_interval = {end}  snapshot_interval = {end} /\n")
    particles = run(folder, "\n".join(text))["VTKHDF/particles"]
    last = int(particles["NumberOfPoints"][-1])
    u = particles["PointData/displacement"][-last:]
    mode = AMPLITUDE * shape(kind, axes, particles["Points"][-last:] - u)
    return float(np.sqrt(np.sum((u - np.sin(2 * np.pi * PART) * mode) ** 2) / np.sum(mode**2)))


ALL_METHODS = "mass = 'consistent'  courant = 0.1", "time = 'implicit'  time_step = 0.02", "courant = 0.1"


def check_orders(folder, counts, kind, axes, method):
    errors = [error_of_mode(folder, cells, kind, axes, method) for cells in counts]
    orders = [np.log(a / b) / np.log(n / m) for a, b, m, n in zip(errors, errors[1:], counts, counts[1:])]
    print(kind, axes, method, "errors", *(f"{error:.4f}" for error in errors), "orders", *(f"{order:.2f}" for order in orders))
    assert orders[-1] > 1.9


@pytest.mark.parametrize(("kind", "axes"), [("shear", (1, 2)), ("dilatation", (2, 0)), ("lame", (0, 1))])
def test_standing_waves_converge(tmp_path, kind, axes):
    """Exact modes of a cube between rollers and of a free one, from 4 cells to 6, with the second order and more."""
    check_orders(tmp_path, (4, 6), kind, axes, ALL_METHODS[0])


@pytest.mark.verify
@pytest.mark.parametrize("method", ALL_METHODS)
@pytest.mark.parametrize("axes", [(0, 1), (1, 2), (2, 0)])
@pytest.mark.parametrize("kind", ["shear", "dilatation", "lame"])
def test_standing_waves_of_all_methods_converge(tmp_path, kind, axes, method):
    check_orders(tmp_path, (4, 6, 8), kind, axes, method)


def error_in_space(folder, cells, kind, method):
    """The same of the mode u_n = A_n sin(pi x_n) cos(..) cos(..) of all three directions, of which an eighth is enough: at its inner sides two components are 0."""
    amplitude = np.array((1.0, 1.0, 1.0) if kind == "dilatation" else (1.0, -2.0, 1.0))    # along the wave vector, or across it
    frequency = np.pi * 3**0.5 * (DILATATIONAL_SPEED if kind == "dilatation" else SHEAR_SPEED)
    end = float(PART * 2 * np.pi / frequency)

    def mode(x):
        sine, cosine = np.sin(np.pi * x), np.cos(np.pi * x)
        return AMPLITUDE * np.stack([amplitude[n] * sine[:, n] * cosine[:, n - 1] * cosine[:, n - 2] for n in range(3)], axis=1)

    def box(lower, upper):
        return "lower = {}, {}, {}  upper = {}, {}, {}".format(*map(float, lower), *map(float, upper))

    text = [f"&run end_time = {end} /", f"&grid cell = {1 / cells}  cells = {cells // 2}, {cells // 2}, {cells // 2} /",
            f"&material name = 'a'  young = 1.0  poisson = {POISSON}  density = 1.0 /"]
    for place in itertools.product(range(cells), repeat=3):
        lower = np.array(place) / (2 * cells)
        velocity = frequency * mode(lower[None] + 1 / (4 * cells))[0]
        text.append(f"&body material = 'a'  {box(lower, lower + 1 / (2 * cells))}  velocity = " + ", ".join(repr(float(v)) for v in velocity) + " /")
    for axis, side in itertools.product(range(3), range(2)):
        lower, upper = np.zeros(3), np.full(3, 0.5)
        lower[axis] = upper[axis] = side / 2
        text.append(f"&constraint {box(lower, upper)}  fix = '{'xyz'.replace('xyz'[axis], '') if side else 'xyz'[axis]}' /")
    text.append(f"&method {method} /\n&output file = 'case.h5'  history_interval = {end}  snapshot_interval = {end} /\n")
    particles = run(folder, "\n".join(text))["VTKHDF/particles"]
    last = int(particles["NumberOfPoints"][-1])
    u = particles["PointData/displacement"][-last:]
    exact = mode(particles["Points"][-last:] - u)
    return float(np.sqrt(np.sum((u - np.sin(2 * np.pi * PART) * exact) ** 2) / np.sum(exact**2)))


@pytest.mark.verify
@pytest.mark.parametrize("method", ALL_METHODS)
@pytest.mark.parametrize("kind", ["shear", "dilatation"])
def test_waves_in_all_directions_converge(tmp_path, kind, method):
    errors = [error_in_space(tmp_path, cells, kind, method) for cells in (4, 6)]
    order = np.log(errors[0] / errors[1]) / np.log(6 / 4)
    print(kind, method, "errors", errors, "order", order)
    assert order > 1.9


ONE_POINT = """
&run end_time = 1.0 /
&grid cell = 0.01  cells = 20, 4, 4 /
&material name = 'a'  young = 200.0e9  poisson = 0.3  density = 7800.0 /
&body material = 'a'  lower = 0.0, 0.0, 0.0  upper = 0.2, 0.04, 0.04  points_per_cell = {points} /
&constraint lower = 0.0, 0.0, 0.0  upper = 0.0, 0.04, 0.04  fix = 'xyz' /
&load kind = 'traction'  lower = 0.2, 0.0, 0.0  upper = 0.2, 0.04, 0.04  force = 0.0, {force} /
&method {method} /
&output file = 'case.h5'  history_interval = 0.25 /
"""


def test_cells_with_one_point_bend(tmp_path):
    """A cantilever: as stiff as theory of beams with shear, alike in y and z; and in motion it stays at the equilibrium from which it begins."""
    theory = 1000.0**2 * 0.2**3 / (6 * 200e9 * 0.04**4 / 12) * (1 + (2 + 1.1 * 0.3) / 4 * (0.04 / 0.2) ** 2)   # shear: with k = 5/6 and G = E/2.6 nearly
    energy = [run(tmp_path, ONE_POINT.format(points=points, force=force, method="time = 'static'"))["history/strain_energy"][-1]
              for points, force in ((1, "-1000.0, 0.0"), (1, "0.0, -1000.0"), (2, "0.0, -1000.0"))]
    print(theory, energy)
    assert energy[0] == pytest.approx(energy[1], rel=1e-9) and energy[0] == pytest.approx(theory, rel=0.03) and energy[2] == pytest.approx(theory, rel=0.03)
    row = run(tmp_path, ONE_POINT.format(points=1, force="0.0, -1000.0", method="time = 'implicit'  time_step = 0.05  start = 'static'"))["history"]
    assert np.max(row["kinetic_energy"]) < 1e-15 * energy[0] and row["strain_energy"][:] == pytest.approx(energy[0], rel=1e-9)
    (tmp_path / "case.nml").write_text(ONE_POINT.format(points=1, force="0.0, -1000.0", method="start = 'static'"))
    refused = subprocess.run([SOLID_PROGRAM, "case.nml", "--check", "--quiet"], cwd=tmp_path, capture_output=True, text=True)
    assert refused.returncode == 2 and "explicit steps do not hold how cells with one point are bent" in refused.stderr


BEAM = """
&run end_time = 8e-4 /
&grid cell = {cell}  cells = {cells} /
&material name = 'a'  young = 70.0e9  poisson = 0.3  density = 2700.0 /
&body material = 'a'  lower = 0.0, 0.0, 0.0  upper = 0.1, 0.01, 0.005 /
&constraint lower = 0.05, 0.0, 0.0  upper = 0.1, 0.0, 0.005  fix = 'y'  name = 'ligament' /
&constraint lower = 0.0, 0.0, 0.005  upper = 0.1, 0.01, 0.005  fix = '{middle}'  name = 'middle' /
&load kind = 'traction'  lower = 0.0, 0.0, 0.0  upper = 0.0, 0.01, 0.005  force = {force}  history = 'smooth_ramp'  rise_time = 6e-5 /
&method time = 'implicit'  time_step = 2e-6 /
&output file = 'case.h5'  history_interval = 2e-6 /
"""


def frequencies(step, signals, modes=16):
    """Of sums of undamped oscillations, by a matrix pencil; without what steps of average acceleration make longer [Hz]."""
    windows = [np.lib.stride_tricks.sliding_window_view(signal / np.max(np.abs(signal)), len(signal) // 2 + 1) for signal in signals]
    basis = np.linalg.svd(np.vstack(windows), full_matrices=False)[2][:modes].T
    root = np.linalg.eigvals(np.linalg.lstsq(basis[:-1], basis[1:], rcond=None)[0])
    turn = np.sort(np.angle(root[(np.abs(np.abs(root) - 1) < 1e-2) & (root.imag > 1e-6)]))
    return np.tan(turn / 2) / (np.pi * step)


@pytest.mark.verify
@pytest.mark.parametrize(("family", "middle", "force"), [("sym", "z", "0.1, 1.0, 0.0"), ("antisym", "xy", "0.0, 0.3, 1.0")])
def test_vibrations_of_a_cracked_beam(tmp_path, family, middle, force):
    """After its end was loaded: frequencies of the forces of its constraints on cells of a quarter and an eighth of the depth. The edge of the crack makes the error one of
    the first order in the cells; extrapolated so, they are those of finite elements of degree 3 within 0.5 %."""
    rows = [line.split(", ") for line in (REFERENCE / "solid/dcb_vibration.csv").read_text().splitlines() if line.startswith(f"{family},")][:3]
    asked, found = np.array([float(row[2]) for row in rows]), []
    for cell, cells in ((2.5e-3, "40, 4, 2"), (1.25e-3, "80, 8, 4")):
        row = run(tmp_path, BEAM.format(cell=cell, cells=cells, middle=middle, force=force))["history"]
        late = row["time"][:] > 6.4e-5
        forces = [row[name][late] - np.mean(row[name][late]) for name in row if name.startswith("reaction") and np.any(np.abs(row[name][:]) > 1e-6)]
        all_of = frequencies(2e-6, forces)
        found.append([all_of[np.argmin(np.abs(all_of - frequency))] for frequency in asked])
    extrapolated = 2 * np.array(found[1]) - found[0]
    for values in zip(asked, *found, extrapolated):
        print(family, *(f"{value:.1f}" for value in values), f"off by {100 * (values[-1] / values[0] - 1):.2f} %")
    assert np.max(np.abs(extrapolated / asked - 1)) < 5e-3


HELD = """
&run end_time = 6.0 /
&grid lower = {low}  cell = 1.0  cells = {cells} /
&material name = 'a'  young = 1.0  poisson = 0.3  density = 1.0 /
&body material = 'a'  lower = 0.0, 0.0, 0.0  upper = {upper} /
&constraint lower = {low}  upper = {high}  fix = '{all}' /
&constraint lower = 0.0, 0.0, 0.0  upper = {foot}  fix = '{foot_axis}' /
&constraint lower = {edge}  upper = {edge_end}  fix = '{edge_axis}' /
&load kind = 'traction'  lower = {top}  upper = {upper}  force = {force} /
&method mass = '{mass}' {solver} /
&output file = 'case.h5'  history_interval = 1.5 /
"""


@pytest.mark.parametrize("mass", ["consistent", "weighted"])
@pytest.mark.parametrize("axes", list(itertools.permutations(range(3))))
def test_a_component_that_is_held_everywhere(tmp_path, axes, mass):
    """A block between rollers, whose foot and one edge are held along the two other axes, is pulled: factors give the work of conjugate gradients, whichever axis is
    which, and something moves."""
    def turned(*values):
        return ", ".join(repr(values[axis]) for axis in axes)

    def named(axis):
        return "xyz"[axes.index(axis)]
    text = HELD.format(low=turned(-1.0, -1.0, 0.0), cells=turned(6, 5, 1), upper=turned(4.0, 3.0, 1.0), high=turned(5.0, 4.0, 1.0), all=named(2), foot=turned(4.0, 0.0, 1.0),
                       foot_axis=named(1), edge=turned(4.0, 0.0, 0.0), edge_end=turned(4.0, 0.0, 1.0), edge_axis=named(0), top=turned(0.0, 3.0, 0.0),
                       force=turned(0.0, 0.008, 0.0), mass=mass, solver="{solver}")
    by_factors, by_iteration = (run(tmp_path, text.format(solver=solver))["history/external_work"][-1] for solver in ("", "solver = 'cg'"))
    assert by_factors == pytest.approx(by_iteration, rel=1e-9)
    if mass == "consistent":
        assert by_factors == pytest.approx(7.32265e-5, rel=1e-5)
