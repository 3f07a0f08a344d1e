"""`&run plane = 'axisymmetric'`: rings around the axis x = 0 against closed forms, converged finite elements and other ways to compute the same."""

import csv
import re

import numpy as np
import pytest

from harness import run
from paths import INPUT, PROGRAM, REFERENCE
from snapshots import field, points, read_steps

YOUNG, DENSITY, PRESSURE = 1e9, 1000.0, 1e6
ORDERS = [(1, 2), (2, 3)]                                                  # order of the cells, particles in a cell and direction


def particles(hampm, *names):
    """Reference positions, displacements and fields of the particles at the end."""
    block = read_steps(hampm.folder / "out.h5")[1][-1][0]
    u = field(block.point_data, "displacement")[:, :2]
    return points(block)[:, :2] - u, u, *(field(block.point_data, name) for name in names)


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
    assert errors[-1] < (5e-3 if order == 1 else 1e-3)
    assert errors[-1] < errors[0] / 3.5


@pytest.mark.parametrize(("order", "across"), ORDERS)
def test_shares_of_loads_are_those_of_rings(hampm, order, across):
    """A disc under its weight on a rigid floor: stress_yy = rho g (y - h), and the reaction is that of the whole disc."""
    h = run(hampm, scene(order, 0.25, (5, 5), f"&body material = 'm'  lower = 0, 0  upper = 1, 1  points_per_cell = {across} /",
                         """&constraint lower = 0, 0  upper = 2, 0  fix = 'y'  name = 'floor' /
&load kind = 'gravity'  acceleration = 0, -10 /""", poisson=0.0))
    x, u, axial = particles(hampm, "stress_yy")
    assert h["reaction_floor_y"][-1] == pytest.approx(DENSITY * 10 * np.pi, rel=1e-10)
    assert axial == pytest.approx(DENSITY * 10 * (x[:, 1] - 1), rel=1e-9 if order == 2 else 0.2, abs=1e-6 if order == 2 else 0.15 * DENSITY * 10)


# --- laws ------------------------------------------------------------------------------------------------------------

SHEAR, LAME = YOUNG / 2.6, YOUNG * 0.3 / (1.3 * 0.4)


def by_energy(energy, strain):
    """Kirchhoff stress along principal axes: stretch times the derivative of the energy by it, by a complex step."""
    stretch = 1 + np.array(strain, dtype=complex)
    return np.array([(1 + strain[k]) * energy(stretch + 1e-20j * (np.arange(3) == k)).imag / 1e-20 for k in range(3)])


def neo_hookean(s):
    return SHEAR / 2 * (np.sum(s**2) - 3 - 2 * np.log(np.prod(s))) + LAME / 2 * np.log(np.prod(s))**2


def mooney_rivlin(s, c01=4e7):
    c10, first = SHEAR / 2 - c01, np.sum(s**2)
    second, j = (first**2 - np.sum(s**4)) / 2, np.log(np.prod(s))
    return c10 * (first - 3) + c01 * (second - 3) - (2 * c10 + 4 * c01) * j + (LAME - 4 * c01) / 2 * j**2


def linear(strain, shear=SHEAR):
    """With the bulk modulus of the material, and another shear modulus where that has relaxed."""
    e = np.array(strain)
    return (LAME + 2 * SHEAR / 3) * np.sum(e) + 2 * shear * (e - np.mean(e))


def plastic(strain, yield_stress=2e6, hardening=1e8):
    """Radial return: a straight path of strain keeps its direction."""
    e = np.array(strain) - np.mean(strain)
    equivalent = np.sqrt(2 / 3 * np.sum(e**2))
    flow = (3 * SHEAR * equivalent - yield_stress) / (3 * SHEAR + hardening)
    assert flow > 0
    return linear(strain, 0) + 2 / 3 * (yield_stress + hardening * flow) * e / equivalent


def orthotropic(strain):
    e1, e2, e3, n12, n13, n23 = YOUNG, 0.4 * YOUNG, YOUNG, 0.3, 0.2, 0.12   # alike around the axis: else stretches that are the same are not in balance
    return np.linalg.solve([[1 / e1, -n12 / e1, -n13 / e1], [-n12 / e1, 1 / e2, -n23 / e2], [-n13 / e1, -n23 / e2, 1 / e3]], strain)


SMALL, LARGE = (2e-3, -3e-3), (0.05, -0.08)                               # along and around the radius, along the axis
ISOTROPIC = f"young = {YOUNG}  poisson = 0.3"
LAWS = {"linear_elastic": (ISOTROPIC, SMALL, linear), "neo_hookean": (ISOTROPIC, LARGE, lambda e: by_energy(neo_hookean, e)),
        "mooney_rivlin": (ISOTROPIC + "  c01 = 4e7", LARGE, lambda e: by_energy(mooney_rivlin, e)),
        "j2_plastic": (ISOTROPIC + "  yield_stress = 2e6  hardening = 1e8", SMALL, plastic),
        "viscoelastic": (ISOTROPIC + "  moduli = 1e8, 5e7  relaxation_times = 1e-3, 2e-3", SMALL, lambda e: linear(e, SHEAR - 1.5e8)),
        "orthotropic": (f"young_1 = {YOUNG}  young_2 = {0.4 * YOUNG}  young_3 = {YOUNG}  shear_12 = 2e8  poisson_12 = 0.3  poisson_13 = 0.2  poisson_23 = 0.12", SMALL,
                        orthotropic)}
METHODS = {"static": "time = 'static'", "implicit": "time = 'implicit'  time_step = 2e-3  hht_alpha = -0.3", "explicit": "time = 'explicit'  frame = 'total'",
           "updated": "time = 'explicit'  frame = 'updated'  courant = 0.3"}


@pytest.mark.parametrize(("order", "across"), [(1, 2), (2, 3)])
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("law", LAWS)
def test_every_law_in_uniform_strain(hampm, law, method, order, across):
    """A ring whose section is strained by H = diag(e, e', e), slowly and with damping in motion: exact to rounding at rest, and with what motion leaves of it, where what
    yields has a memory of waves. The stress is by another formula than that of the program."""
    keys, (radial, axial), stress = LAWS[law]
    if method == "updated" and (order == 2 or radial > SMALL[0]):
        pytest.skip("quadratic cells stay in the total frame, and nodes that are moved far are no longer at the edge of the material in another one")
    end = 0.3
    shift = "&constraint lower = {0}, 0  upper = {0}, 1  fix = 'x'  displacement = {1}, 0  history = 'ramp'  rise_time = 0.2 /\n"
    text = f"""&run plane = 'axisymmetric'  end_time = {end} /
&grid lower = 0.5, -0.5  cell = 0.25  cells = 8, 8  order = {order} /
&material name = 'm'  law = '{law}'  density = {DENSITY}  {keys} /
&body material = 'm'  lower = 1, 0  upper = 2, 1  points_per_cell = {across} /
&constraint lower = 0, 0  upper = 3, 0  fix = 'y' /
&constraint lower = 0, 1  upper = 3, 1  fix = 'y'  displacement = 0, {axial}  history = 'ramp'  rise_time = 0.2 /
{shift.format(1, radial)}{shift.format(2, 2 * radial)}&damping rate = 2e3 /
&method {METHODS[method]} /
&output file = 'out.h5'  snapshot_interval = {end}  history_interval = {end / 4} /
"""
    if method == "static":
        text = text.replace("&damping rate = 2e3 /", "").replace(f"history_interval = {end / 4}", "").replace("'static'", "'static'  load_steps = 3" if law == "viscoelastic" else "'static'")
    run(hampm, text)
    x, u, *found = particles(hampm, "stress_xx", "stress_yy", "stress_zz", "stress_xy")
    exact = stress((radial, axial, radial))
    near = 1e-8 if method == "static" else 0.01 if law == "j2_plastic" or method == "updated" else 1e-6
    size = np.max(np.abs(exact))
    print(law, method, order, [float(np.max(np.abs(one - value)) / size) for one, value in zip(found, (*exact, 0.0))])
    for one, value in zip(found, (*exact, 0.0)):
        assert one == pytest.approx(value, abs=near * size)
    assert u[:, 0] == pytest.approx(radial * x[:, 0], abs=near * radial * (1 if law != "j2_plastic" else 2))


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
    print("J", j / factor - 1, "K", k / factor - 1, "spread", h["J_domain_dependence"][-1] / h["J"][-1])
    assert j == pytest.approx(factor, rel=2e-3)
    assert k == pytest.approx(factor, rel=2e-3)
    assert h["J_domain_dependence"][-1] < 1e-4 * h["J"][-1]


@pytest.mark.parametrize(("kind", "order", "across"), [("path", 2, 3), ("path", 1, 2), ("line", 1, 2)])
def test_a_whole_penny_crack_is_that_of_the_half(hampm, kind, order, across):
    """In both orders the same."""
    keys = {"order": order, "across": across, "level": 2}
    half, whole = penny(hampm, 0.3, 2.5, **keys), penny(hampm, 0.3, 2.5, kind=kind, **keys)
    assert whole[0] == pytest.approx(half[0], rel=1e-6)
    assert whole[1] == pytest.approx(half[1], rel=1e-3)
    assert abs(whole[2]["K_II"][-1]) < 1e-6 * whole[2]["K_I"][-1]


@pytest.mark.parametrize("load", ["tension", "pressure"])
def test_a_penny_crack_in_bilinear_cells(hampm, load):
    """Within 0.5 %, pulled from afar or with pressed faces, within the error that is estimated; so of a path that is pressed as it runs through cells."""
    j, k, h = penny(hampm, 0.3, 4.0, order=1, across=2, load=load, level=5)
    print("J", j / 1.016346 - 1, "K", k / 1.016346 - 1, "estimate", h["K_I_error"][-1] / h["K_I"][-1])
    assert j == pytest.approx(1.016346, rel=5e-3)
    assert k == pytest.approx(1.016346, rel=5e-3)
    assert abs(k - 1.016346) < 2 * h["K_I_error"][-1] / (2 * PRESSURE * np.sqrt(1 / np.pi))


def test_a_penny_crack_inside_cells(hampm):
    """A path along no grid line, pressed, with its tip inside a cell: within what a tip there is off."""
    text = scene(1, 0.25, (17, 34), "&body material = 'm'  lower = 0, -4  upper = 4, 4  points_per_cell = 2 /", f"""&load kind = 'pressure'  on = 'crack'  pressure = {PRESSURE} /
&crack kind = 'path'  points = 0, 0.0137, 1, 0.0137 /
&refine indicator = 'tip'  max_level = 4  rings = 6 /
&energy_release estimators = 'domain_integral' /""", lower="0, -4.25")
    h = run(hampm, text)
    k = h["K_I"][-1] / (2 * PRESSURE * np.sqrt(1 / np.pi))
    print("K", k / 1.016346 - 1, h["K_II"][-1] / h["K_I"][-1])
    assert k == pytest.approx(1.016346, rel=0.01)
    assert abs(h["K_II"][-1]) < 0.01 * h["K_I"][-1]


def test_the_penny_crack_of_the_gallery(hampm):
    """input/penny.nml."""
    h = run(hampm, (INPUT / "penny.nml").read_text())
    assert h["K_I"][-1] / (2e6 * np.sqrt(1 / np.pi)) == pytest.approx(1.01635, rel=1e-3)
    assert h["J"][-1] == pytest.approx(h["K_I"][-1]**2 * (1 - 0.3**2) / 70e9, rel=2e-3)


def test_a_penny_crack_grows_under_pressure(hampm):
    """At rest the load is what the toughness asks for: G = 4 (1 - nu**2) p**2 a/(pi E) in an endless body, 1 % by cells and size; what new faces take is G times their area."""
    h = run(hampm, scene(1, 0.5, (21, 42), "&body material = 'm'  lower = 0, -10  upper = 10, 10  points_per_cell = 2 /", f"""&load kind = 'pressure'  on = 'crack'  pressure = {PRESSURE} /
&crack kind = 'path'  points = 0, 0, 1, 0 /
&growth law = 'quasi_static'  increment = 0.125  toughness = 1000  direction = 'straight' /
&refine indicator = 'tip'  max_level = 4  rings = 6 /
&energy_release estimators = 'domain_integral'  energy_balance = .true. /""", lower="0, -10.5", method="time = 'static'  load_steps = 4"))
    a = h["crack_length"]
    assert a == pytest.approx(np.linspace(1, 1.5, 5))
    assert h["load_factor"] * PRESSURE == pytest.approx(np.sqrt(np.pi * YOUNG * 1000 / (4 * a * (1 - 0.3**2))), rel=0.01)
    assert h["fracture_energy"] == pytest.approx(1000 * np.pi * (a**2 - 1), rel=1e-9, abs=1e-9)
    left = h["external_work"] - h["strain_energy"] - h["fracture_energy"]
    assert np.max(np.abs(left)) < 0.01 * h["external_work"][-1]


def test_a_penny_crack_grows_at_a_given_speed(hampm):
    """Slowly, in motion, and then rests: all energy is booked, and it has the K of one of that length but for where its tip acts, most of a cell ahead, which counts twice: K of
    a longer crack, and a longer front. With cells of half the size it is 2.5 % instead of 4 %."""
    end = 0.075
    text = scene(1, 0.25, (17, 17), "&body material = 'm'  lower = 0, 0  upper = 4, 4  points_per_cell = 2 /", f"""&constraint lower = {{}}, 0  upper = 4, 0  fix = 'y' /
&load kind = 'pressure'  lower = 0, 4  upper = 4, 4  pressure = -{PRESSURE}  history = 'ramp'  rise_time = 0.015 /
&crack kind = 'symmetry'  tip = {{}}, 0  direction = 1, 0 /
&damping rate = 500 /
&refine indicator = 'tip'  max_level = 3  rings = 6 /
&energy_release estimators = 'domain_integral'  energy_balance = .true. /""", end=end, method="time = 'explicit'")
    grown = "\n&growth law = 'prescribed'  direction = 'straight'  speed = 20  start = 0.02  max_length = 1.5 /\n"
    h = run(hampm, text.format(1, 1) + grown)
    rest = run(hampm, text.format(1.5, 1.5).replace("&damping rate = 500 /", "").replace("'explicit'", "'static'"))
    assert h["crack_length"][-1] == pytest.approx(1.5)
    assert h["K_I"][-1] == pytest.approx(rest["K_I"][-1], rel=0.03)
    missing = h["external_work"] - sum(h[name] for name in ("kinetic_energy", "strain_energy", "damping_loss", "numerical_loss", "fracture_energy"))
    assert np.max(np.abs(missing)) < 1e-9 * h["external_work"][-1]


@pytest.mark.parametrize(("method", "cell", "levels", "near", "mean"), [
    ("time = 'explicit'  mass = 'weighted'", 0.1, 2, 0.035, 0.015), ("time = 'explicit'  mass = 'weighted'", 0.05, 1, 0.03, 0.012),
    ("time = 'implicit'  time_step = {}  hht_alpha = -0.1", 0.05, 1, 0.03, 0.012)])
def test_a_penny_crack_under_a_step_of_pressure(hampm, method, cell, levels, near, mean):
    """K(t) until waves come back from the edges, in parts of the peak, against the inversion of a Fredholm equation; where the Rayleigh wave of the other side arrives, at
    c_s t/a = 2.15, K falls so steeply that the reference itself is as good as a shift by 0.03 only. With lumped masses explicit steps, which damp nothing, ring behind each front: 4 %
    with the finer cells, where the matrix of least dispersion has 2.7 %. Implicit steps are five a row: by steps a quarter longer, 2e-5 s, K is 3.3 % off behind that wave; with cells of half the size 0.3 %."""
    shear = np.sqrt(YOUNG / 2.6 / DENSITY)
    end, size = 3.6 / shear, 3.7
    n = round(size / cell)
    h = run(hampm, scene(1, cell, (n + 1, n + 1), f"&body material = 'm'  lower = 0, 0  upper = {n * cell}, {n * cell}  points_per_cell = 2 /",
                         f"""&constraint lower = 1, 0  upper = {n * cell}, 0  fix = 'y' /
&load kind = 'pressure'  on = 'crack'  pressure = {PRESSURE} /
&crack kind = 'symmetry'  tip = 1, 0  direction = 1, 0 /
&refine indicator = 'tip'  max_level = {levels}  rings = 6 /
&energy_release estimators = 'domain_integral' /""", end=end, method=method.format(end / 360)), f"output.history_interval={end / 72}")
    with open(REFERENCE / "penny_dynamic.csv") as file:
        time, factor = np.array([[float(value) for value in row[:2]] for row in csv.reader(line for line in file if line[0] != "#" and line[0].isdigit())]).T
    t, k = h["time"] * shear, h["K_I"] / (2 * PRESSURE * np.sqrt(1 / np.pi))
    steep = np.abs(t - 2.15) < 0.12
    off_by = np.min([np.abs(k - np.interp(t + shift, time, factor)) for shift in (-0.03, 0, 0.03)], axis=0) / np.max(factor)
    off_by[~steep] = np.abs(k - np.interp(t, time, factor))[~steep] / np.max(factor)
    print("largest", off_by[t > 0.3].max(), t[t > 0.3][off_by[t > 0.3].argmax()], "mean square", np.sqrt(np.mean(off_by[t > 0.3]**2)))
    assert off_by[t > 0.3].max() < near
    assert np.sqrt(np.mean(off_by[t > 0.3]**2)) < mean


@pytest.mark.parametrize(("scheme", "order", "across"), [("musl", 1, 2), ("usf", 1, 3), ("usavg", 1, 2), ("usl", 1, 2), ("musl", 2, 3), ("usl", 2, 4)])
def test_steps_at_their_limit_are_stable_at_the_axis(hampm, scheme, order, across):
    """The limit is that of the rings of the body: a third of the cells touch the axis, and thousands of steps add no energy."""
    text = scene(order, 0.25, (6, 12), f"&body material = 'm'  lower = 0, 0  upper = 1, 1  points_per_cell = {across}  velocity = 0, 1e-3 /",
                 "&load kind = 'point'  lower = 1, 1  upper = 1, 1  force = 1, 3  history = 'sine'  frequency = 90 /\n&energy_release energy_balance = .true. /", end=0.5 / order**2,
                 method=f"time = 'explicit'  scheme = '{scheme}'  wave_speed = 'dilatational'  courant = {{}}" + ("  mass = 'consistent'" if order == 2 else ""), lower="0, -1", poisson=0.45)
    limit = float(re.search(r"must be at most ([0-9.]+), not", run(hampm, text.format(5), code=2))[1])
    h = run(hampm, text.format(limit), "output.history_interval=0.025")
    energy = h["kinetic_energy"] + h["strain_energy"]
    assert np.max(energy) < 1.01 * energy[0]
    missing = h["external_work"] + energy[0] - energy - h["numerical_loss"]
    assert np.max(np.abs(missing)) < 1e-9 * energy[0]


@pytest.mark.parametrize("across", [3, 4, 5, 6])
def test_the_limit_of_quadratic_cells_at_the_axis_is_that_of_their_matrices(hampm, run_hampm, across):
    """The longest step of M and K of a whole body, in that of a sample of it, which is the shorter as its masses let the axis move along the radius."""
    for width, height, poisson in ((1, 4, 0.0), (3, 3, 0.0), (2, 4, 0.45)):
        text = scene(2, 0.25, (7, 8), f"&body material = 'm'  lower = 0, 0  upper = {width / 4}, {height / 4}  points_per_cell = {across}  velocity = 0, 1e-3 /", "",
                     method="time = 'explicit'  mass = 'consistent'  courant = {}", poisson=poisson)
        limit = re.search(r"must be at most ([0-9.]+), not", run(hampm, text.format(5), code=2))[1]
        (hampm.folder / "scene.nml").write_text(text.format(limit))
        longest = float(run_hampm(limit, "scene.nml", program=PROGRAM.with_name("eigenvalue_limit"), cwd=hampm.folder).stdout)
        print(width, height, poisson, longest)
        assert 1 <= longest < 1.1


# --- what is refused --------------------------------------------------------------------------------------------------

@pytest.mark.parametrize(("setting", "message"), [("grid.lower=-0.25,0", "x is the radius"), ("run.thickness=2", "circumference"), ("body.spin=1", "cannot rotate in the plane of its section")])
def test_what_no_ring_has_is_refused(hampm, setting, message):
    text = scene(2, 0.25, (6, 5), "&body material = 'm'  lower = 0, 0  upper = 1, 1  points_per_cell = 3 /", "&load kind = 'gravity'  acceleration = 0, 1 /",
                 method="time = 'explicit'  mass = 'consistent'")
    assert message in run(hampm, text, setting, code=2)


@pytest.mark.parametrize("load", ["kind = 'traction'  lower = 0, 0.4  upper = 0, 1  force = 0, 1", "kind = 'pressure'  lower = 0, 0  upper = 0, 1  pressure = 1",
                                  "kind = 'traction'  side = 4  force = 0, 1"])
def test_an_edge_on_the_axis_has_no_area_to_be_loaded(hampm, load):
    """A traction there was none, with external_work that is no number."""
    text = scene(1, 0.25, (4, 4), "&body material = 'm'  lower = 0, 0  upper = 1, 1 /", f"&constraint lower = 0, 0  upper = 1, 0  fix = 'xy' /\n&load {load} /")
    assert "the edge is on the axis" in run(hampm, text, code=2)
    assert np.isfinite(run(hampm, text.replace("side = 4", "side = 3").replace("lower = 0, 0.4  upper = 0, 1", "lower = 0, 1  upper = 1, 1").replace(
        "lower = 0, 0  upper = 0, 1  press", "lower = 1, 0  upper = 1, 1  press"))["external_work"][-1])


def test_a_layer_that_is_held_at_its_rim_adds_nothing_to_closure(hampm):
    """It would widen, and the pressure on its rim keeps it from that: its radial and hoop stress are uniform and end at the crack's plane, without K. So G is that of the pull alone, in
    both modes; the hoop stress of one side alone is part of the force that closes the crack."""
    pressure = 1e6
    rest = """&body material = 'm'  lower = 0, 9e-3  upper = 12e-3, 14e-3  {} /
&constraint lower = 0, 0  upper = 12e-3, 0  fix = 'y' /
&load kind = 'traction'  lower = 0, 14e-3  upper = 12e-3, 14e-3  force = 0, 100.0 /
{}
&crack kind = 'line'  tip = 4e-3, 9e-3  length = 4e-3 /
&energy_release estimators = 'vcct', 'domain_integral' /"""
    strain = pressure * 0.7 / YOUNG
    held = f"eigenstrain = {strain}, 0, 0, {strain}", f"&load kind = 'pressure'  lower = 12e-3, 9e-3  upper = 12e-3, 14e-3  pressure = {pressure} /"
    alone, both = (run(hampm, scene(1, 1e-3, (14, 15), "&body material = 'm'  lower = 0, 0  upper = 12e-3, 9e-3 /", rest.format(*more))) for more in (("", ""), held))
    for name in ("G_vcct_I", "G_vcct_II", "J"):
        assert abs(both[name][-1]) == pytest.approx(abs(alone[name][-1]), rel=1e-6), name
