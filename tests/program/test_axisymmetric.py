"""`&run plane = 'axisymmetric'`: rings around the axis x = 0 against closed forms, converged finite elements and other ways to compute the same."""

import csv

import h5py
import numpy as np
import pytest

from paths import INPUT, REFERENCE
from snapshots import field, points, read_steps

YOUNG, DENSITY, PRESSURE = 1e9, 1000.0, 1e6
ORDERS = [(1, 2), (2, 3)]                                                          # order of the cells, particles in a cell and direction


@pytest.fixture
def hampm(hampm, tmp_path):
    hampm.folder = tmp_path
    return hampm


def run(hampm, text, *settings, fails=0):
    """Runs a scene, a text or a namelist; its history, columns and attributes."""
    scene = hampm.folder / "scene.nml"
    scene.write_text(text)
    words = [word for setting in settings for word in ("--set", setting)]
    result = hampm(scene, "--force", "--quiet", "--set", "output.file=out.h5", *words)
    assert result.returncode == fails, result.stderr
    if fails:
        return result
    with h5py.File(hampm.folder / "out.h5") as file:
        return {name: column[:] for name, column in file["history"].items()} | dict(file["history"].attrs)


def particles(hampm, *names):
    """Reference positions, displacements and fields of the particles at the end."""
    block = read_steps(hampm.folder / "out.h5")[1][-1][0]
    u = field(block.GetPointData(), "displacement")[:, :2]
    return points(block)[:, :2] - u, u, *(field(block.GetPointData(), name) for name in names)


def off(found, exact):
    """Error in the mean, relative."""
    return np.sqrt(np.mean((found - exact)**2) / np.mean(exact**2))


def scene(order, cell, cells, bodies, rest, end=1.0, poisson=0.3, method="time = 'static'", law="'linear_elastic'", lower="0, 0", more=""):
    """A scene of one material."""
    return f"""&run plane = 'axisymmetric'  end_time = {end} /
&grid lower = {lower}  cell = {cell}  cells = {cells[0]}, {cells[1]}  order = {order} /
&material name = 'm'  law = {law}  young = {YOUNG}  poisson = {poisson}  density = {DENSITY}  {more} /
{bodies}
{rest}
&method {method} /
&output file = 'out.h5'  snapshot_interval = {end} /
"""


# --- closed forms -----------------------------------------------------------------------------------------------------

def lame_cylinder(r, a, b, pressure, poisson):
    """Radial displacement, radial and hoop stress of a cylinder under inner pressure that keeps its length (Lame 1852)."""
    c = pressure * a**2 / (b**2 - a**2)
    return (1 + poisson) / YOUNG * ((1 - 2 * poisson) * c * r + c * b**2 / r), c * (1 - b**2 / r**2), c * (1 + b**2 / r**2)


@pytest.mark.parametrize(("order", "across"), ORDERS)
def test_a_thick_cylinder_under_pressure(hampm, order, across):
    """Converges with the order of the cells: displacements with one more than stress; the reaction at its ends is that of stress_yy = nu (s_r + s_t)."""
    errors = []
    for n in (4, 8, 16):
        cell = 1.0 / n
        h = run(hampm, scene(order, cell, (2 * n + 1, 3), f"&body material = 'm'  lower = 1, 0  upper = 2, {2 * cell}  points_per_cell = {across} /",
                             f"""&constraint lower = 0, 0  upper = 3, 0  fix = 'y'  name = 'end' /
&constraint lower = 0, {2 * cell}  upper = 3, {2 * cell}  fix = 'y' /
&load kind = 'pressure'  lower = 1, 0  upper = 1, {2 * cell}  pressure = {PRESSURE} /"""))
        x, u, radial, hoop = particles(hampm, "stress_xx", "stress_zz")
        exact = lame_cylinder(x[:, 0], 1.0, 2.0, PRESSURE, 0.3)
        errors.append([off(found, one) for found, one in zip((u[:, 0], radial, hoop), exact)])
    orders = np.log2(np.array(errors)[:-1] / np.array(errors)[1:])
    print("errors", errors[-1], "orders", orders)
    assert orders[-1] == pytest.approx([order + 1, order, order], abs=0.1)
    assert errors[-1][0] < 3e-5 if order == 2 else 3e-3
    assert h["reaction_end_y"][-1] == pytest.approx(-0.3 * 2 * PRESSURE / 3 * np.pi * 3, rel=1e-3)  # it is kept from becoming shorter


@pytest.mark.parametrize(("order", "across"), ORDERS)
@pytest.mark.parametrize("poisson", [0.0, 0.3, 0.45])
def test_a_rod_is_pulled(hampm, order, across, poisson):
    """Uniform tension in a rod, from the axis on: exact to rounding, with H_33 = -nu eps and no stress across."""
    run(hampm, scene(order, 0.25, (5, 9), f"&body material = 'm'  lower = 0, 0  upper = 1, 2  points_per_cell = {across} /",
                     f"""&constraint lower = 0, 0  upper = 2, 0  fix = 'y' /
&load kind = 'traction'  lower = 0, 2  upper = 1, 2  force = 0, {PRESSURE * np.pi} /""", poisson=poisson))
    x, u, radial, axial, hoop, shear = particles(hampm, "stress_xx", "stress_yy", "stress_zz", "stress_xy")
    assert u[:, 0] == pytest.approx(-poisson * PRESSURE / YOUNG * x[:, 0], abs=1e-11 * PRESSURE / YOUNG)
    assert u[:, 1] == pytest.approx(PRESSURE / YOUNG * x[:, 1], rel=1e-10)
    assert axial == pytest.approx(PRESSURE, rel=1e-10)
    assert np.max(np.abs([radial, hoop, shear])) < 1e-9 * PRESSURE


@pytest.mark.parametrize(("order", "across"), ORDERS)
def test_a_hollow_sphere_under_pressure(hampm, order, across):
    """Edges cut the cells anywhere. u = A r + B/r**2 (Lame); of the second order, as edges are polygons."""
    errors, nu = [], 0.3
    for n in (8, 16):
        angle = np.linspace(0, np.pi / 2, 65)
        ring = np.concatenate([2 * np.stack([np.cos(angle), np.sin(angle)], axis=1), np.stack([np.cos(angle), np.sin(angle)], axis=1)[::-1]])
        ring[np.abs(ring) < 1e-12] = 0
        corners = ", ".join(f"{value:.15g}" for value in ring.ravel())
        cell = 2.0 / n
        run(hampm, scene(order, cell, (n + 1, n + 1), f"&body material = 'm'  shape = 'polygon'  points = {corners}  points_per_cell = {across} /",
                         f"""&constraint lower = 0, 0  upper = 3, 0  fix = 'y' /
&load kind = 'pressure'  lower = 0, 0  upper = 1, 1  pressure = {PRESSURE} /"""))
        x, u = particles(hampm)
        r = np.linalg.norm(x, axis=1)
        c = PRESSURE / (8 - 1)
        exact = c / YOUNG * ((1 - 2 * nu) * r + (1 + nu) * 8 / (2 * r**2))
        errors.append(off(np.sum(u * x, axis=1) / r, exact))
    print("errors", errors)
    assert errors[-1] < {1: 5e-3, 2: 2e-3}[order]
    assert errors[-1] < errors[0] / 2.5


@pytest.mark.parametrize(("order", "across"), ORDERS)
def test_shares_of_loads_are_those_of_rings(hampm, order, across):
    """A disc under its weight on a rigid floor: stress_yy = rho g (y - h), and the reaction is that of the whole disc."""
    h = run(hampm, scene(order, 0.25, (5, 5), f"&body material = 'm'  lower = 0, 0  upper = 1, 1  points_per_cell = {across} /",
                         """&constraint lower = 0, 0  upper = 2, 0  fix = 'y'  name = 'floor' /
&load kind = 'gravity'  acceleration = 0, -10 /""", poisson=0.0))
    x, u, axial = particles(hampm, "stress_yy")
    assert h["reaction_floor_y"][-1] == pytest.approx(DENSITY * 10 * np.pi, rel=1e-10)
    assert axial == pytest.approx(DENSITY * 10 * (x[:, 1] - 1), rel=1e-9 if order == 2 else 0.2, abs=1e-6 if order == 2 else 0.15 * DENSITY * 10)


# --- cracks -----------------------------------------------------------------------------------------------------------

def penny(hampm, poisson, size, *settings, kind="symmetry", load="tension", order=2, across=3, cell=0.25, level=4, name="domain_integral"):
    """sqrt(J E') and K_I of a penny crack of radius 1 in a cylinder of radius and half height `size`, over 2 p sqrt(a/pi)."""
    low, rows = (0, round(size / cell) + 1) if kind == "symmetry" else (-size - cell, 2 * round(size / cell) + 2)
    body = f"&body material = 'm'  lower = 0, {0 if kind == 'symmetry' else -size}  upper = {size}, {size}  points_per_cell = {across} /"
    crack = {"symmetry": f"&constraint lower = 1, 0  upper = {size}, 0  fix = 'y' /\n&crack kind = 'symmetry'  tip = 1, 0  direction = 1, 0 /",
             "line": "&crack kind = 'line'  tip = 1, 0  direction = 1, 0  length = 1 /", "path": "&crack kind = 'path'  points = 0, 0, 1, 0 /"}[kind]
    pull = "".join(f"&load kind = 'pressure'  lower = 0, {y}  upper = {size}, {y}  pressure = -{PRESSURE} /\n" for y in ([size] if kind == "symmetry" else [size, -size]))
    if load == "pressure":
        pull = f"&load kind = 'pressure'  on = 'crack'  pressure = {PRESSURE} /\n"
    h = run(hampm, scene(order, cell, (round(size / cell) + 1, rows), body,
                         crack + "\n" + pull + f"&refine indicator = 'tip'  max_level = {level}  rings = 4 /\n&energy_release estimators = '{name}' /", poisson=poisson,
                         lower=f"0, {low}"), *settings)
    unit, modulus = 2 * PRESSURE * np.sqrt(1 / np.pi), YOUNG / (1 - poisson**2)
    return np.sqrt(h["J"][-1] * modulus) / unit, h["K_I"][-1] / unit, h


def converged():
    """Rows of the table of converged finite elements: Poisson's ratio, size, factor."""
    with open(REFERENCE / "penny_cylinder.csv") as file:
        return [(float(row["nu"]), float(row["R_over_a"]), float(row["F"])) for row in csv.DictReader(line for line in file if line[0] != "#")]


@pytest.mark.parametrize(("poisson", "size", "factor"), converged())
def test_a_penny_crack_has_the_converged_value(hampm, poisson, size, factor):
    """Within 0.2 % by J and by K, and J differs by next to nothing between its discs: without its terms of the radius they would differ by their size over a."""
    j, k, h = penny(hampm, poisson, size)
    print("J", j / factor - 1, "K", k / factor - 1, "spread", h["J_spread"][-1] / h["J"][-1])
    assert j == pytest.approx(factor, rel=2e-3)
    assert k == pytest.approx(factor, rel=2e-3)
    assert h["J_spread"][-1] < 1e-4 * h["J"][-1]


def test_a_whole_penny_crack_is_that_of_the_half(hampm):
    """Of kind 'path', in any order the same."""
    half, whole = penny(hampm, 0.3, 4.0, level=2), penny(hampm, 0.3, 4.0, kind="path", level=2)
    assert whole[0] == pytest.approx(half[0], rel=1e-6)
    assert whole[1] == pytest.approx(half[1], rel=1e-3)
    assert abs(whole[2]["K_II"][-1]) < 1e-6 * whole[2]["K_I"][-1]


def test_the_penny_crack_of_the_gallery(hampm):
    """input/penny.nml."""
    h = run(hampm, (INPUT / "penny.nml").read_text())
    assert h["K_I"][-1] / (2e6 * np.sqrt(1 / np.pi)) == pytest.approx(1.01635, rel=1e-3)
    assert h["J"][-1] == pytest.approx(h["K_I"][-1]**2 * (1 - 0.3**2) / 70e9, rel=2e-3)


# --- what is refused --------------------------------------------------------------------------------------------------

@pytest.mark.parametrize(("setting", "message"), [("grid.lower=-0.25,0", "x is the radius"), ("run.thickness=2", "circumference"), ("body.spin=1", "turned inside out")])
def test_what_no_ring_has_is_refused(hampm, setting, message):
    text = scene(2, 0.25, (6, 5), "&body material = 'm'  lower = 0, 0  upper = 1, 1  points_per_cell = 3 /", "&load kind = 'gravity'  acceleration = 0, 1 /",
                 method="time = 'explicit'  mass = 'full'")
    assert message in run(hampm, text, setting, fails=2).stderr
