"""The weight of bodies, and strains without stress: closed forms, path independence and superposition."""

import math
import re

import numpy as np
import pytest

import harness
from snapshots import field, points, read_steps

E, POISSON, B = 70e9, 0.3, 0.01
QUADRATIC = "grid.order=2", "body.points_per_cell=3"
both_orders = pytest.mark.parametrize("order", [(), QUADRATIC], ids=["bilinear", "quadratic"])
MATERIAL = "&material name = 'a' young = {young} poisson = {poisson} density = 2000 /\n"


def run(hampm, text, *options):
    return harness.run(hampm, text, *options).last()


def bodies(text, cells, lower, cell, *, plane="stress", time="time = 'static'", end=1.0, young=E, poisson=POISSON, estimators="",
           rows=1, audited=True):
    return f"""\
&run thickness = {B} plane = '{plane}' end_time = {end} /
&grid lower = {lower} cell = {cell} cells = {cells} /
{MATERIAL.format(young=young, poisson=poisson)}
&method frame = 'total' {time} /
{f"&energy_release energy_balance = .true. {estimators} /" if audited else ""}
&output file = 'case.h5' history_interval = {end / rows} snapshot_interval = {end} /
{text}
"""


def particles(tmp_path):
    """Particles of the last snapshot: places X in the reference configuration, displacements, and the data."""
    grid = read_steps(tmp_path / "out.h5")[1][-1][0]
    data = grid.point_data
    u = field(data, "displacement")[:, :2]
    return points(grid)[:, :2] - u, u, data


# Weight

LENGTH, WIDTH, G, YOUNG = 0.04, 0.008, 9.81, 1e7


def column(cell, **options):
    return bodies(f"""\
&body material = 'a' lower = 0, 0 upper = {WIDTH}, {LENGTH} /
&constraint lower = -1, 0 upper = 1, 0 fix = 'y' name = 'foot' /
&constraint lower = 0, 0 upper = 0, 0 fix = 'x' /
&load kind = 'gravity' acceleration = 0, {-G} history = 'ramp' rise_time = {options.get('rise', 1.0)} /
""", f"{round(WIDTH / cell) + 4}, {round(LENGTH / cell) + 2}", f"{-2 * cell}, 0", cell, young=YOUNG, poisson=0,
                  **{name: value for name, value in options.items() if name != "rise"})


def test_a_column_under_its_weight(hampm, tmp_path):
    """sigma_yy = -rho g (l - y), linear in a cell; particles have that of the middle of their row, and the energy
    (rho g)**2 l**3 A/6E an error of order 2."""
    errors = []
    for cell in (4e-3, 2e-3):
        values = run(hampm, column(cell))
        errors.append(values["strain_energy"] / ((2000 * G)**2 * LENGTH**3 * WIDTH * B / (6 * YOUNG)) - 1)
        assert values["reaction_foot_y"] == pytest.approx(2000 * G * LENGTH * WIDTH * B, rel=1e-9)
        assert values["external_work"] == pytest.approx(values["strain_energy"], rel=1e-9)
        x, _, data = particles(tmp_path)
        middle = (np.floor(x[:, 1] / cell) + 0.5) * cell                      # the strain of a cell is constant, and right in its middle
        assert field(data, "stress_yy") == pytest.approx(-2000 * G * (LENGTH - middle), rel=1e-9)
    assert abs(errors[1]) < 1e-3
    assert errors[0] / errors[1] == pytest.approx(4, rel=0.01)


@pytest.mark.parametrize("time", ["", "mass = 'consistent'", "time = 'implicit' time_step = 2e-5", "scheme = 'usavg'"])
def test_the_audit_closes_with_weight(hampm, time):
    end = 2e-3
    audited = "implicit" not in time
    values = run(hampm, column(2e-3, time=time, end=end, rise=end, audited=audited))
    gone = values["kinetic_energy"] + values["strain_energy"] + values.get("numerical_loss", 0)
    assert gone == pytest.approx(values["external_work"], rel=1e-9 if audited else 0.02)


def test_gravity_of_free_bodies_makes_them_fall(hampm):
    text = re.sub("&constraint.*\n", "", column(2e-3, time="frame = 'updated'", end=1e-3).replace("frame = 'total' ", "")).replace(
        "history = 'ramp' rise_time = 1.0", "").replace("lower = 0, 0 upper = 0.008, 0.04 /", "lower = 0, 0.001 upper = 0.008, 0.038 /")
    values = run(hampm, text)
    assert values["kinetic_energy"] == pytest.approx(2000 * WIDTH * 0.037 * B * (G * 1e-3)**2 / 2, rel=1e-6)
    half_a_step = values["numerical_loss"]     # between the velocities at the ends of a step (docs/explanation/energy_balance.md)
    assert values["external_work"] == pytest.approx(values["kinetic_energy"] + half_a_step, rel=1e-6)


def hanging(a, cell):
    return bodies(f"""\
&body material = 'a' lower = 0, -0.04 upper = 0.04, 0.04 /
&constraint lower = -1, 0.04 upper = 1, 0.04 fix = 'xy' /
&load kind = 'gravity' acceleration = 0, -9810 history = 'ramp' rise_time = 1.0 /
&crack kind = 'line' tip = {a}, 0 direction = 1, 0 /
""", f"{round(0.044 / cell)}, {round(0.084 / cell)}", "-0.002, -0.042", cell, young=1e9, estimators="estimators = 'domain_integral' radii = "
                  "0.005, 0.008, 0.012")


def test_a_crack_in_a_body_that_hangs(hampm):
    """J is the same on all discs, and the change of the energy with the length of the crack, both under weight."""
    energy = [run(hampm, hanging(a, 5e-4))["strain_energy"] for a in (0.0155, 0.0165)]
    values = run(hampm, hanging(0.016, 5e-4))
    assert values["J_domain_dependence"] < 1e-3 * values["J"]
    assert values["J"] == pytest.approx((energy[1] - energy[0]) / (1e-3 * B), rel=5e-3)
    assert math.hypot(values["K_I"], values["K_II"])**2 / 1e9 == pytest.approx(values["J"], rel=0.01)


# Eigenstrain

@both_orders
@pytest.mark.parametrize(("plane", "eigenstrain", "strain"), [
    ("stress", "1e-3, -2e-3, 5e-4", (1e-3, -2e-3, 5e-4)),
    ("strain", "1e-3, 1e-3, 0, 1e-3", (1.3e-3, 1.3e-3, 0))])
@pytest.mark.parametrize("extra", ["", "&refine indicator = 'zz' tolerance = 0.1 max_level = 1 /",
                                   "&crack kind = 'path' points = -0.001, 0.003, 0.02, 0.007 /\n"])
def test_a_free_body_takes_its_eigenstrain(hampm, tmp_path, plane, eigenstrain, strain, extra, order):
    """Without stress; in plane strain nu eps_zz comes to the strain in the plane, and the energy of sigma_zz = -E eps_zz stays."""
    values = run(hampm, bodies(f"&body material = 'a' lower = 0, 0 upper = 0.04, 0.012 eigenstrain = {eigenstrain} /\n{extra}",
                                         "26, 12", "-0.004, -0.004", 2e-3, plane=plane), *order)
    x, u, data = particles(tmp_path)
    found, *_ = np.linalg.lstsq(np.column_stack([x, np.ones(len(x))]), u, rcond=None)
    is_cut = order and "path" in extra         # corners of quadratic cells may have no particle
    assert [found[0, 0], found[1, 1], (found[0, 1] + found[1, 0]) / 2] == pytest.approx(strain, abs=1e-13 if is_cut else 1e-14)
    for name in ("stress_xx", "stress_yy", "stress_xy"):
        assert np.max(np.abs(field(data, name))) < 1e-12 * E
    assert values["strain_energy"] == pytest.approx(E * 1e-6 / 2 * 0.04 * 0.012 * B if plane == "strain" else 0, abs=5e-5 if is_cut else 1e-12)
    assert abs(values["numerical_loss"]) < 1e-12


LAWS = {"neo_hookean": "", "mooney_rivlin": " c01 = 1e9", "j2_plastic": " yield_stress = 1e9", "viscoelastic": " moduli = 5e9 relaxation_times = 0.1",
        "orthotropic": "young_1 = 70e9 young_2 = 30e9 young_3 = 20e9 shear_12 = 9e9 poisson_12 = 0.3 poisson_13 = 0.2 poisson_23 = 0.25 density = 2000"}


@both_orders
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("extra", ["", "&refine indicator = 'tip' max_level = 1 rings = 2 /\n&crack kind = 'path' points = -0.001, 0.003, 0.021, 0.0072 /\n"], ids=["whole", "cracked"])
def test_a_free_body_of_another_law_takes_its_eigenstrain(hampm, tmp_path, law, extra, order):
    """Without stress or energy, also strains that are not small."""
    strain, constants = 0.03 if law in ("neo_hookean", "mooney_rivlin") else 1e-3, LAWS[law]
    if law == "orthotropic":           # the thickness is free
        constants = constants.replace("young_3 = 20e9", "").replace("poisson_13 = 0.2 poisson_23 = 0.25", "")
    text = bodies(f"&body material = 'a' lower = 0, 0 upper = 0.04, 0.012 eigenstrain = {strain}, {-strain / 2}, {strain / 4} /\n{extra}",
                  "26, 12", "-0.004, -0.004", 2e-3)
    elastic = "young = 70000000000.0 poisson = 0.3 density = 2000"
    assert elastic in text
    run(hampm, text.replace(elastic, f"law = '{law}' " + (constants if law == "orthotropic" else elastic + constants)), *order)
    x, u, data = particles(tmp_path)
    found, *_ = np.linalg.lstsq(np.column_stack([x, np.ones(len(x))]), u, rcond=None)
    free, h = np.array([[strain, strain / 4], [strain / 4, -strain / 2]]), found[:2].T
    if strain > 0.01:                  # the body may turn: it is stretched by I + eps0
        assert (np.eye(2) + h).T @ (np.eye(2) + h) == pytest.approx((np.eye(2) + free) @ (np.eye(2) + free), abs=1e-9)
    else:
        assert (h + h.T) / 2 == pytest.approx(free, abs=1e-10)
    for name in ("stress_xx", "stress_yy", "stress_xy"):
        assert np.max(np.abs(field(data, name))) < 1e-9 * E


@both_orders
@pytest.mark.parametrize(("law", "c01"), [("neo_hookean", 0.0), ("mooney_rivlin", 6e9)])
def test_a_body_that_swells_between_its_sides_is_a_larger_one_pressed_into_their_place(hampm, law, c01, order):
    """Closed form in plane strain: stretches s = 1/(1 + e) of a volume that is (1 + e)**2 of the reference volume, which has energy and reactions."""
    strain, half = 0.04, 0.012
    swollen = 1 + strain
    mu, bulk = E / 2.6, E * 0.3 / (1.3 * 0.4)
    text = f"&body material = 'a' lower = {-half}, {-half} upper = {half}, {half} eigenstrain = {strain}, {strain}, 0, 0 /\n"
    for axis, side in ((0, -half), (0, half), (1, -half), (1, half)):
        lower, upper = ([side if k == axis else at for k in (0, 1)] for at in (-half, half))
        text += f"&constraint lower = {lower[0]}, {lower[1]} upper = {upper[0]}, {upper[1]} fix = '{'xy'[axis]}' name = 's{axis}{'b' if side > 0 else 'a'}' /\n"
    text = bodies(text, "8, 8", "-0.016, -0.016", 4e-3, plane="strain")
    row = run(hampm, text.replace("young =", f"law = '{law}' {f'c01 = {c01}' if c01 else ''} young ="), *order)
    s = 1 / swollen
    log = 2 * math.log(s)
    first, second, c10 = 2 * s**2 + 1, s**4 + 2 * s**2, mu / 2 - c01
    energy = c10 * (first - 3) + c01 * (second - 3) - (mu + 2 * c01) * log + (bulk - 4 * c01) / 2 * log**2
    stress = 2 * c10 * s**2 + 2 * c01 * (s**4 + s**2) - (mu + 2 * c01) + (bulk - 4 * c01) * log
    assert row["strain_energy"] == pytest.approx(swollen**2 * energy * (2 * half)**2 * B, rel=1e-9)
    assert row["reaction_s0b_x"] == pytest.approx(swollen**2 * stress * 2 * half * B, rel=1e-9)
    assert row["reaction_s1a_y"] == pytest.approx(-swollen**2 * stress * 2 * half * B, rel=1e-9)


def test_heat_in_fibres_that_are_held_across(hampm, tmp_path):
    """Plane strain: what is kept from the strain across the plane adds nu_i3 E_3/E_i of it along the axes, here turned by 30 degrees."""
    text = bodies("&body material = 'a' lower = 0, 0 upper = 0.04, 0.012 eigenstrain = 0, 0, 0, 1e-3 /\n", "26, 12", "-0.004, -0.004", 2e-3, plane="strain")
    values = run(hampm, text.replace("young = 70000000000.0 poisson = 0.3 density = 2000", "law = 'orthotropic' angle = 30 " + LAWS["orthotropic"]))
    x, u, _ = particles(tmp_path)
    found, *_ = np.linalg.lstsq(np.column_stack([x, np.ones(len(x))]), u, rcond=None)
    along, c, s = (0.2 * 20 / 70 * 1e-3, 0.25 * 20 / 30 * 1e-3), math.cos(math.pi / 6), math.sin(math.pi / 6)
    wanted = [along[0] * c**2 + along[1] * s**2, along[0] * s**2 + along[1] * c**2, (along[0] - along[1]) * c * s]
    assert [found[0, 0], found[1, 1], (found[0, 1] + found[1, 0]) / 2] == pytest.approx(wanted, abs=1e-13)
    assert values["strain_energy"] == pytest.approx(20e9 * 1e-6 / 2 * 0.04 * 0.012 * B, rel=1e-9)


CLAMPED = """&body material = 'a' lower = 0, 0 upper = 0.04, 0.012 eigenstrain = 1e-3, 1e-3, 0 /
&constraint lower = 0, -1 upper = 0, 1 fix = 'x' name = 'left' /
&constraint lower = 0.04, -1 upper = 0.04, 1 fix = 'x' /
&constraint lower = 0, 0 upper = 0, 0 fix = 'y' /
"""


@both_orders
def test_a_bar_between_walls(hampm, tmp_path, order):
    values = run(hampm, bodies(CLAMPED, "26, 12", "-0.004, -0.004", 2e-3), *order)
    assert values["reaction_left_x"] == pytest.approx(E * 1e-3 * 0.012 * B, rel=1e-12)
    assert field(particles(tmp_path)[2], "stress_xx") == pytest.approx(-E * 1e-3, rel=1e-12)


@both_orders
@pytest.mark.parametrize("time", ["", "mass = 'consistent' scheme = 'usf'", "mass = 'weighted'", "time = 'implicit' time_step = 2e-7",
                                  "scheme = 'usavg'"])
def test_the_audit_closes_with_eigenstrain(hampm, time, order):
    """Suddenly there: the energy that it stores at first moves the bar, which swings around -E eps with the energy of no stress."""
    end = 2e-5
    audited = "implicit" not in time
    values = run(hampm, bodies(CLAMPED, "26, 12", "-0.004, -0.004", 2e-3, time=time, end=end, audited=audited), *order)
    first = E / (1 - POISSON) * 1e-6 * 0.04 * 0.012 * B
    gone = values["kinetic_energy"] + values["strain_energy"] + values.get("numerical_loss", 0)
    assert values["kinetic_energy"] > 0.01 * first
    assert gone == pytest.approx(first, rel=1e-9)


def test_a_damped_bar(hampm):
    for time in ("", "frame = 'updated'"):
        text = bodies(CLAMPED + "&damping rate = 3e5 /\n", "26, 12", "-0.004, -0.004", 2e-3, time=time, end=1e-4, audited=False)
        if "updated" in time:
            text = text.replace("frame = 'total' ", "")
        values = run(hampm, text)
        assert values["reaction_left_x"] == pytest.approx(E * 1e-3 * 0.012 * B, rel=5e-3), time


@both_orders
def test_a_strip_of_two_metals_bends(hampm, tmp_path, order):
    """Curvature 1.5 (mismatch)/h of two equal layers of one modulus, height h together (Timoshenko 1925), far from the ends."""
    mismatch, h, length = 1e-3, 8e-3, 0.08
    run(hampm, bodies(f"""\
&body material = 'a' lower = 0, 0 upper = {length}, {h / 2} eigenstrain = {mismatch}, {mismatch}, 0 /
&body material = 'a' lower = 0, {h / 2} upper = {length}, {h} /
""", "84, 12", "-0.002, -0.002", 1e-3), *(option.replace("body.", f"body({k}).") for k in (1, 2) for option in order))
    x, u, _ = particles(tmp_path)
    middle = np.abs(x[:, 0] - length / 2) < length / 4
    row = middle & (np.abs(x[:, 1] - np.min(x[x[:, 1] > h / 2, 1])) < 1e-9)
    curvature = 2 * np.polyfit(x[row, 0], u[row, 1], 2)[0]
    assert abs(curvature) == pytest.approx(1.5 * mismatch / h, rel=0.01)


@pytest.mark.parametrize("crack", ["kind = 'line' tip = 0.01, 0 direction = 1, 0 length = 0.02",
                                   "kind = 'path' points = -0.009, -0.004, 0.009, 0.004"])
def test_a_crack_in_a_cooled_plate_that_is_held(hampm, crack):
    """Held at all edges and cooled, the plate without a crack has sigma = E alpha dT/(1 - nu): K is that of this stress on the faces."""
    half, cell, strain = 0.04, 1e-3, 1e-3
    held = "".join(f"&constraint lower = {a}, {b} upper = {c}, {d} fix = 'xy' /\n" for a, b, c, d in (
        (-half, -half, half, -half), (-half, half, half, half), (-half, -half, -half, half), (half, -half, half, half)))
    body = f"&body material = 'a' lower = {-half}, {-half} upper = {half}, {half} "
    grid = ("84, 84", "-0.042, -0.042", cell)
    cooled = run(hampm, bodies(body + f"eigenstrain = {-strain}, {-strain}, 0 /\n&crack {crack} /\n" + held, *grid,
                                         estimators="estimators = 'domain_integral'"))
    pressed = run(hampm, bodies(body + f"/\n&crack {crack} /\n" + held + "&load kind = 'pressure' on = 'crack' pressure = "
                                          f"{E * strain / (1 - POISSON)} /\n", *grid, estimators="estimators = 'domain_integral'"))
    for name in ("K_I", "G", "J"):
        assert cooled[name] == pytest.approx(pressed[name], rel=2e-4), name


@both_orders
@pytest.mark.parametrize("crack", ["kind = 'line' tip = 0.01, 0 direction = 1, 0 length = 0.02",
                                   "kind = 'path' points = -0.009, -0.004, 0.009, 0.004"])
@pytest.mark.parametrize(("law", "within"), [("linear_elastic", 1e-9), ("neo_hookean", 3e-3), ("orthotropic", 1e-9)])
def test_a_plate_that_shrinks_between_its_sides_is_one_whose_sides_move_apart(hampm, crack, order, law, within):
    """The sides stay in line: displacements differ by the eigenstrain times the place, stress, K, G and J do not; with a law for any strain by some times that of
    1e-3."""
    half, cell, strain = 0.02, 2e-3, 1e-3
    sides = [(axis, side) for axis in (0, 1) for side in (-half, half)]

    def plate(eigenstrain, motion):
        text = f"&body material = 'a' lower = {-half}, {-half} upper = {half}, {half} eigenstrain = {eigenstrain}, {eigenstrain}, 0 /\n&crack {crack} /\n"
        for axis, side in sides:
            lower, upper, moved = [-half, -half], [half, half], [0.0, 0.0]
            lower[axis] = upper[axis] = side
            moved[axis] = motion * side
            text += f"&constraint lower = {lower[0]}, {lower[1]} upper = {upper[0]}, {upper[1]} fix = '{'xy'[axis]}' " \
                    f"displacement = {moved[0]}, {moved[1]} name = 's{axis}{'b' if side > 0 else 'a'}' /\n"
        text = bodies(text, "24, 24", "-0.024, -0.024", cell, estimators="estimators = 'domain_integral'")
        of_law = LAWS[law] if law == "orthotropic" else "young = 70000000000.0 poisson = 0.3 density = 2000"
        of_law = of_law.replace("young_3 = 20e9", "").replace("poisson_13 = 0.2 poisson_23 = 0.25", "")
        return run(hampm, text.replace("young = 70000000000.0 poisson = 0.3 density = 2000", f"law = '{law}' {of_law}"), *order)

    shrinks, moves = plate(-strain, 0.0), plate(0.0, strain)
    assert moves["K_I"] > (0.3 if law == "orthotropic" else 0.7) * E / (1 - POISSON) * strain * math.sqrt(math.pi * 0.0095)
    for name in ("K_I", "K_II", "G", "J", "reaction_s0b_x", "reaction_s1b_y"):
        assert shrinks[name] == pytest.approx(moves[name], rel=within, abs=within * abs(moves["K_I"])), name


TWO = """&body material = 'a' lower = 0, 0 upper = 0.026, 0.024 eigenstrain = 1e-3, 1e-3, 0 /
&body material = 'a' lower = 0.026, 0 upper = 0.04, 0.024 /
&crack kind = 'path' points = -0.001, 0.010, 0.02, 0.010 /
"""
LAYERS = """&body material = 'a' lower = 0, 0 upper = 0.04, 0.014 /
&body material = 'a' lower = 0, 0.014 upper = 0.04, 0.024 eigenstrain = 1e-3, 1e-3, 0 /
&constraint lower = 0.04, 0 upper = 0.04, 0.024 fix = 'xy' /
"""


@pytest.mark.parametrize("crack", ["kind = 'path' points = -0.001, 0.0103, 0.02, 0.0103", "kind = 'line' tip = 0.02, 0.01"])
def test_layers_along_a_crack_leave_j_independent_of_the_path(hampm, crack):
    """What expands beside a crack bends its arm open: discs that end within the layer of the tip have the J of those that reach beyond."""
    text = bodies(LAYERS + f"&crack {crack} /\n", "84, 52", "-0.001, -0.001", 5e-4, estimators="estimators = 'domain_integral' radii = 2e-3, 3e-3, 6e-3, 8e-3")
    row = run(hampm, text)
    assert [row[f"J_{k}"] for k in (2, 3, 4)] == pytest.approx(3 * [row["J_1"]], rel=0.01) and row["J_1"] > 0


@pytest.mark.parametrize(("text", "phrase"), [
    (bodies(CLAMPED.replace("1e-3, 1e-3, 0 ", "1, 0, 0 "), "26, 12", "-0.004, -0.004", 2e-3), r"must be in \[-0.05, 0.05\]"),
    (bodies(CLAMPED.replace("1e-3, 1e-3, 0 ", "1e-3 "), "26, 12", "-0.004, -0.004", 2e-3), "eigenstrain"),
    (bodies(TWO, "24, 16", "-0.004, -0.004", 2e-3, estimators="estimators = 'domain_integral' radii = 0.008"), "has another eigenstrain"),
    (column(2e-3).replace("acceleration = 0, -9.81", "acceleration = 0, -9.81 force = 0, 1"), "is not allowed with kind = 'gravity'"),
    (column(2e-3).replace("kind = 'gravity'", "kind = 'body'"), "kind = 'body' requires lower and upper and force")])
def test_what_has_no_meaning_is_refused(hampm, tmp_path, text, phrase):
    (tmp_path / "case.nml").write_text(text)
    result = hampm("--check", "case.nml")
    assert result.returncode == 2, result.stdout
    assert re.search(phrase, result.stderr), result.stderr
