"""The law 'orthotropic' as a user has it: cracks and waves against closed forms, isotropic constants, turned bodies, and what is refused."""

import math
import re

import h5py
import numpy as np
import pytest

from harness import run
from paths import INPUT, REFERENCE

E1, E2, G12, NU12, DENSITY = 140e9, 10e9, 5e9, 0.3, 1600.0
LAMINATE = f"law = 'orthotropic'  young_1 = {E1}  young_2 = {E2}  shear_12 = {G12}  poisson_12 = {NU12}  density = {DENSITY}"


def chi():
    """Williams' correction of the length of a crack between beams [-]."""
    gamma = 1.18 * math.sqrt(E1 * E2) / G12
    return math.sqrt(E1 / (11 * G12) * (3 - 2 * (gamma / (1 + gamma)) ** 2))


def rate(angle):
    """Y of G = K Y K for a crack at minus this angle [degrees] from axis 1, plane stress, by the roots of Lekhnitskii's equation."""
    c, s = math.cos(math.radians(angle)), math.sin(math.radians(angle))
    turn = np.array([[c * c, s * s, -c * s], [s * s, c * c, c * s], [2 * c * s, -2 * c * s, c * c - s * s]])
    a = turn @ np.array([[1 / E1, -NU12 / E1, 0], [-NU12 / E1, 1 / E2, 0], [0, 0, 1 / G12]]) @ turn.T
    roots = np.roots([a[0, 0], -2 * a[0, 2], 2 * a[0, 1] + a[2, 2], -2 * a[1, 2], a[1, 1]])
    total, product = sum(roots[roots.imag > 0]), np.prod(roots[roots.imag > 0])
    mixed = a[0, 0] * product.imag / 2
    return np.array([[-a[1, 1] * (total / product).imag / 2, mixed], [mixed, a[0, 0] * total.imag / 2]])


def test_a_laminate_beam_has_the_rate_of_the_closed_form(hampm):
    """Beams on a foundation with shear; 12 P^2 (a + chi h)^2/(B^2 E1 h^3) is known to be good to about 1 %."""
    found = run(hampm, INPUT / "laminate_dcb.nml")
    expected = 12 * 5.0**2 * (30e-3 + chi() * 2e-3) ** 2 / (1e-6 * E1 * 2e-3**3)
    for name in ("G_vcct_I", "J", "G"):
        assert found[name][-1] == pytest.approx(expected, rel=0.01)
        assert found[name][-1] == pytest.approx(306.2, rel=0.005)  # tests/reference/orthotropic/laminates.csv
    assert found["K_I"][-1] == pytest.approx(math.sqrt(306.2 / rate(0)[0, 0]), rel=0.005)
    assert abs(found["J"][-1] - 306.2) < found["J_error"][-1]


def test_an_end_notched_laminate_has_the_rate_of_finer_cells(hampm):
    """tests/reference/orthotropic/laminates.csv; the closed form 9 P^2 (a + 0.42 chi h)^2/(16 B^2 E1 h^3) is 1.5 % higher."""
    found = run(hampm, INPUT / "laminate_enf.nml")
    assert found["J"][-1] == pytest.approx(139.75, rel=0.01)
    assert -found["G_vcct_II"][-1] == pytest.approx(139.75, rel=0.01)
    assert found["J"][-1] == pytest.approx(9 * 20.0**2 * (25e-3 + 0.42 * chi() * 2e-3) ** 2 / (16e-6 * E1 * 2e-3**3), rel=0.02)
    assert abs(found["K_II"][-1]) == pytest.approx(math.sqrt(139.75 / rate(0)[1, 1]), rel=0.005)
    assert abs(found["J"][-1] - 139.75) < found["J_error"][-1]


CENTRE = """&run plane = 'stress'  thickness = 1e-3  end_time = 1.0 /
&grid lower = -0.164, -0.164  cell = 0.002  cells = 164, 164 /
&material name = 'a'  {material}  angle = {angle} /
&body material = 'a'  lower = -0.16, -0.16  upper = 0.16, 0.16 /
&load kind = 'traction'  lower = -0.16, 0.16  upper = 0.16, 0.16  force = 0.0, 320.0 /
&load kind = 'traction'  lower = -0.16, -0.16  upper = 0.16, -0.16  force = 0.0, -320.0 /
&crack {crack} /
&energy_release estimators = 'domain_integral' /
&method time = 'static' /
&refine indicator = 'tip'  max_level = 2  rings = 8  max_particles = 20000000 /
"""


def path(degrees, half=8e-3):
    x, y = half * math.cos(math.radians(degrees)), half * math.sin(math.radians(degrees))
    return f"kind = 'path'  points = {-x!r}, {-y!r}, {x!r}, {y!r}"


@pytest.mark.parametrize("crack, angle", [(30, 0), (20, -30), (0, 30)])
def test_cracks_in_a_large_plate_have_the_isotropic_k_and_the_anisotropic_g(hampm, crack, angle):
    """Sih, Paris & Irwin (1965): K_I = s sqrt(pi a) cos^2, K_II = s sqrt(pi a) sin cos, whatever the anisotropy; 16 finest cells to the
    half-length, plate of 20 half-lengths. Along a grid line the crack of the cells is a part of a cell short: 1.3 % of G."""
    (hampm.folder / "case.nml").write_text(CENTRE.format(material=LAMINATE, angle=angle, crack=path(crack)))
    found = run(hampm, "case.nml")
    c, s = math.cos(math.radians(crack)), math.sin(math.radians(crack))
    k = 1e6 * math.sqrt(math.pi * 8e-3) * np.array([c * c, s * c])
    g = k @ rate(angle - crack) @ k
    for tip in ("", "_tip2"):
        measured = np.array([found["K_I" + tip][-1], found["K_II" + tip][-1]])
        assert np.max(np.abs(measured - k)) < 0.01 * np.linalg.norm(k)
        assert found["G" + tip][-1] == pytest.approx(g, rel=0.015 if crack == 0 else 0.01)
        assert found["J" + tip][-1] == pytest.approx(g, rel=0.015 if crack == 0 else 0.01)


# What is off by the degenerate roots is 1e-10; moves of particles differ by rounding
ISOTROPIC = "law = 'orthotropic'  young_1 = 70e9  young_2 = 70e9  young_3 = 70e9  shear_12 = 26923076923.076923  poisson_12 = 0.3 " \
            "poisson_13 = 0.3  poisson_23 = 0.3  density = 2700  angle = 33.0"


@pytest.mark.parametrize("order", [1, 2])
def test_the_error_of_a_sliding_crack_along_the_fibres_knows_how_far_its_faces_slide(hampm, order):
    """The crack of the cells is 2.4 times as much too short as in isotropic material (docs/explanation/estimated_errors.md)."""
    model = CENTRE.format(material=LAMINATE, angle=0, crack=path(0))
    model = model.replace("164, 164 /", f"164, 164  order = {order} /").replace("upper = 0.16, 0.16 /", f"upper = 0.16, 0.16  points_per_cell = {order + 1} /", 1)
    model = "\n".join(line for line in model.splitlines() if "traction" not in line)
    for lower, upper, force in (((-0.16, 0.16), (0.16, 0.16), (320.0, 0.0)), ((-0.16, -0.16), (0.16, -0.16), (-320.0, 0.0)),
                                ((0.16, -0.16), (0.16, 0.16), (0.0, 320.0)), ((-0.16, -0.16), (-0.16, 0.16), (0.0, -320.0))):
        words = [", ".join(map(str, pair)) for pair in (lower, upper, force)]
        model += f"\n&load kind = 'traction'  lower = {words[0]}  upper = {words[1]}  force = {words[2]} /"
    (hampm.folder / "case.nml").write_text(model + "\n")
    found = run(hampm, "case.nml")
    exact = rate(0)[1, 1] * 1e6**2 * math.pi * 8e-3
    wrong = abs(found["J"][-1] - exact)
    print(order, found["J"][-1] / exact - 1, found["J_error"][-1] / exact)
    assert wrong < found["J_error"][-1] < 2.5 * wrong


@pytest.mark.parametrize("plane", ["stress", "strain"])
@pytest.mark.parametrize("settings", [("method.time=static",), ("method.time=explicit", "method.frame=total"),
                                      ("method.time=explicit", "method.frame=updated"),
                                      pytest.param(("method.time=explicit", "refine.indicator=tip", "refine.max_level=2"), marks=pytest.mark.verify),
                                      ("method.time=implicit", "method.time_step=2e-6"),
                                      ("method.time=static", "refine.indicator=zz", "refine.max_level=2")],
                         ids=lambda settings: " ".join(settings))
def test_isotropic_constants_give_what_the_isotropic_law_gives(hampm, plane, settings):
    text = CENTRE.replace("-0.164, -0.164", "-0.026, -0.026").replace("164, 164", "26, 26").replace("0.16", "0.024") \
        .replace("end_time = 1.0", "end_time = 2e-5").replace("'stress'", f"'{plane}'") \
        .replace("max_level = 2", "max_level = 0").replace("angle = {angle}", "")
    text = re.sub(r"&refine indicator = 'tip'  ", "&refine indicator = 'none'  ", text)
    line = "kind = 'line'  tip = 0.008, 0.0  direction = 1.0, 0.0  length = 0.016"
    results = []
    for material in (ISOTROPIC, "young = 70e9  poisson = 0.3  density = 2700"):
        (hampm.folder / "case.nml").write_text(text.format(material=material, crack=line))
        results.append(run(hampm, "case.nml", *settings))
    compared = 0
    for name in results[0]:
        if np.ndim(results[0][name]) == 0 or not re.match(r"(K_|G|J|strain_energy|kinetic_energy|mouth_opening)", name) or "spread" in name:
            continue
        unit = max(np.max(np.abs(column)) for key, column in results[1].items() if np.ndim(column) and key[:1] == name[:1])
        # K of a tip in orthotropic material has its size by J: it is as near as J and K are, and so are the errors of shares of J that K gives
        tolerance = 0.05 if name.startswith("K_") or re.match("G_domain_.*_error", name) else 1e-4 if name.startswith("G_domain") else 1e-7
        if "refine.indicator=zz" in settings:  # of cells with the same error rounding tells which is refined first
            tolerance = max(tolerance, 1e-3)
        assert np.max(np.abs(results[0][name] - results[1][name])) <= tolerance * unit, name
        compared += 1
    assert compared > 5


def test_a_turned_body_of_turned_material_has_the_same_cracks(hampm):
    """A beam along x with fibres along it, and the same along y, crack upwards: explicit steps, with fibres at 30 degrees to it."""
    beam = """&run plane = 'stress'  thickness = 1e-3  end_time = 4e-5 /
&grid lower = 0.0, 0.0  cell = 1e-3  cells = {cells} /
&material name = 'a'  {material}  angle = {angle} /
&body material = 'a'  lower = 0.0, 0.0  upper = {upper} /
&load kind = 'traction'  lower = {a}  upper = {b}  force = {up} /
&load kind = 'traction'  lower = {c}  upper = {d}  force = {down} /
&crack kind = 'line'  tip = {tip}  direction = {direction} /
&energy_release estimators = 'vcct', 'domain_integral' /
&method frame = 'total' courant = 0.3 /
&output history_interval = 1e-5 /
"""
    along = dict(cells="30, 12", angle=30.0, upper="0.03, 0.012", a="0.0, 0.006", b="0.0, 0.012", up="0.0, 1.0", c="0.0, 0.0",
                 d="0.0, 0.006", down="0.0, -1.0", tip="0.012, 0.006", direction="1.0, 0.0")
    up = dict(cells="12, 30", angle=120.0, upper="0.012, 0.03", a="0.0, 0.0", b="0.006, 0.0", up="-1.0, 0.0", c="0.006, 0.0",
              d="0.012, 0.0", down="1.0, 0.0", tip="0.006, 0.012", direction="0.0, 1.0")
    results = []
    for words in (along, up):
        (hampm.folder / "case.nml").write_text(beam.format(material=LAMINATE, **words))
        results.append(run(hampm, "case.nml"))
    for name in ("K_I", "K_II", "J", "G_vcct_I", "G_vcct_II", "strain_energy", "crack_opening"):
        unit = np.max(np.abs(results[0][name]))
        assert unit > 0
        assert np.max(np.abs(results[0][name] - results[1][name])) < 1e-8 * unit, name


@pytest.mark.parametrize("angle, modulus", [(0.0, E1), (90.0, E2)])
def test_waves_in_a_bar_go_by_the_modulus_along_it(hampm, angle, modulus):
    """A slender bar that is held at one end and stretched vibrates with the period 4 L sqrt(rho/E)."""
    length = 0.1
    period = 4 * length * math.sqrt(DENSITY / modulus)
    (hampm.folder / "case.nml").write_text(f"""&run plane = 'stress'  thickness = 1e-3  end_time = {period} /
&grid lower = 0.0, 0.0  cell = 1e-3  cells = 101, 2 /
&material name = 'a'  {LAMINATE}  angle = {angle} /
&body material = 'a'  lower = 0.0, 0.0  upper = {length}, 1e-3 /
&constraint lower = 0.0, 0.0  upper = 0.0, 1e-3  fix = 'x' /
&constraint lower = 0.0, 0.0  upper = 0.1, 0.0  fix = 'y' /
&load kind = 'traction'  lower = {length}, 0.0  upper = {length}, 1e-3  force = 10.0, 0.0 /
&method frame = 'total' /
&output history_interval = {period / 200} /
""")
    found = run(hampm, "case.nml")
    largest = found["time"][np.argmax(found["strain_energy"])]  # at half of the period
    assert largest == pytest.approx(period / 2, rel=0.02)
    assert found["strain_energy"].max() == pytest.approx((2 * 10.0) ** 2 / 2 * length / (modulus * 1e-6), rel=0.03)


def test_a_resumed_run_and_threads_have_the_same_bytes(hampm):
    """A laminate of two angles, in motion, with cells that refine."""
    (hampm.folder / "case.nml").write_text(f"""&run plane = 'strain'  thickness = 1e-3  end_time = 1e-5 /
&grid lower = 0.0, 0.0  cell = 1e-3  cells = 20, 9 /
&material name = 'a'  {LAMINATE}  young_3 = 9e9 poisson_13 = 0.25 poisson_23 = 0.4 angle = 30 /
&material name = 'b'  {LAMINATE}  young_3 = 9e9 poisson_13 = 0.25 poisson_23 = 0.4 angle = -30 /
&body material = 'a'  lower = 0.0, 0.0  upper = 0.02, 4e-3 /
&body material = 'b'  lower = 0.0, 4e-3  upper = 0.02, 8e-3 /
&load kind = 'traction'  lower = 0.0, 0.0  upper = 0.0, 4e-3  force = -10.0, 5.0 /
&refine indicator = 'zz'  tolerance = 0.1  max_level = 1 /
&output history_interval = 1e-6 /
""")
    whole = run(hampm, "case.nml", words=("--threads", "1"))
    two = run(hampm, "case.nml", words=("--threads", "2"))
    stopped = hampm("case.nml", "--force", "--quiet", "--set", "output.file=part.h5", "--steps", "7")
    assert stopped.returncode == 5, stopped.stderr
    resumed = hampm("--resume", "part.h5.checkpoint", "--quiet")
    assert resumed.returncode == 0, resumed.stderr
    with h5py.File(hampm.folder / "part.h5") as file:
        for name, column in file["history"].items():
            assert np.array_equal(column[:], whole[name]), name
            assert np.array_equal(two[name], whole[name]), name


MISTAKES = [
    ("young_1 = 140000000000.0", "young_1 = 1e-99", "must be within a factor of 1e10 of each other"),
    ("young_1 = 140000000000.0", "", "law = 'orthotropic' requires young_1 and young_2"),
    ("poisson_12 = 0.3", "poisson_12 = 3.8", "poisson_12 = 3.8: poisson_12**2 must be below young_1/young_2"),
    ("poisson_12 = 0.3", "poisson_12 = 0.3 young = 1e9", "young = 1e9 is not allowed with law = 'orthotropic'"),
    ("poisson_12 = 0.3", "poisson_12 = 0.3 poisson = 0.3", "poisson = 0.3 is not allowed with law = 'orthotropic'"),
    ("'stress'", "'strain'", "law = 'orthotropic' with &run plane = 'strain' requires young_3"),
    ("angle = 0", "angle = 30", "&material angle = 30: must be a multiple of 90 degrees with &crack kind = 'symmetry'"),
    ("law = 'orthotropic'", "young = 1e9", "young_1 = 140000000000.0 requires law = 'orthotropic'"),
    ("reference = 'none'", "reference = 'dcb'", "reference = 'dcb' is not allowed with &material 'a' law = 'orthotropic'"),
]


@pytest.mark.parametrize("old, new, message", MISTAKES)
def test_mistakes_are_refused(hampm, old, new, message):
    text = f"""&run plane = 'stress'  thickness = 1e-3  end_time = 1.0 /
&grid lower = 0.0, 0.0  cell = 1e-3  cells = 20, 5 /
&material name = 'a'  {LAMINATE}  angle = 0 /
&body material = 'a'  lower = 0.0, 0.0  upper = 0.02, 4e-3 /
&constraint lower = 0.01, 0.0  upper = 0.02, 0.0  fix = 'y' /
&load kind = 'traction'  lower = 0.0, 0.0  upper = 0.0, 4e-3  force = 0.0, 1.0 /
&crack kind = 'symmetry'  tip = 0.01, 0.0  direction = 1.0, 0.0 /
&method time = 'static' /
&energy_release estimators = 'domain_integral'  reference = 'none' /
"""
    assert old in text
    (hampm.folder / "case.nml").write_text(text)
    assert hampm("--check", "case.nml").returncode == 0
    (hampm.folder / "case.nml").write_text(text.replace(old, new))
    result = hampm("--check", "case.nml")
    assert result.returncode == 2
    assert message in result.stderr


def test_growth_is_refused(hampm):
    text = (INPUT / "bend_path.nml").read_text().replace("young = 200.0e9", LAMINATE.replace(f"density = {DENSITY}", "")) \
        .replace("poisson = 0.3\n", "\n").replace("plane = 'strain'", "plane = 'stress'")
    (hampm.folder / "case.nml").write_text(text)
    result = hampm("--check", "case.nml")
    assert result.returncode == 2
    assert "law = 'orthotropic' is not allowed with &growth" in result.stderr


def test_mixed_mode_bending_has_the_rates_of_finite_elements_and_nearly_those_of_the_standard(hampm):
    """tests/reference/orthotropic/mmb.csv, extrapolated to cell size zero: each halving takes half of what is missing. Formulas: ASTM D6671."""
    with open(REFERENCE / "orthotropic/mmb.csv") as file:
        rows = [[float(value) for value in line.split(",")] for line in file.readlines()[2:]]
    modes = [2 * fine - coarse for coarse, fine in zip(rows[-2][1:], rows[-1][1:])]
    found = run(hampm, INPUT / "laminate_mmb.nml")
    print(modes, found["J"][-1], found["G_vcct_I"][-1], found["G_vcct_II"][-1])
    assert found["J"][-1] == pytest.approx(sum(modes), rel=0.01)
    for name in ("G_vcct", "G_domain"):
        assert found[f"{name}_I"][-1] == pytest.approx(modes[0], rel=0.01)
        assert -found[f"{name}_II"][-1] == pytest.approx(modes[1], rel=0.01)
    p, c, span, h, a = 8.0, 45e-3, 50e-3, 2e-3, 25e-3
    closed = (3 * p**2 * (3 * c - span) ** 2 * (a + chi() * h) ** 2 / (4 * span**2 * 1e-6 * h**3 * E1),
              9 * p**2 * (c + span) ** 2 * (a + 0.42 * chi() * h) ** 2 / (16 * span**2 * 1e-6 * h**3 * E1))
    assert found["G_vcct_I"][-1] == pytest.approx(closed[0], rel=0.01)
    assert -found["G_vcct_II"][-1] == pytest.approx(closed[1], rel=0.025)
    assert abs(found["J"][-1] - sum(modes)) < found["J_error"][-1]


def test_errors_of_a_crack_across_the_axes(hampm):
    """Estimated errors of K hold the true ones, and are below 2 %. The cells at a tip share G otherwise than its field: errors of K were 19 %, however fine the cells. Finite elements of order 4."""
    row = run(hampm, """&run plane = 'strain' end_time = 1.0 /
&grid lower = -1e-3, -1e-3 cell = 1e-3 cells = 16, 16 order = 2 /
&material name = 'm' law = 'orthotropic' young_1 = 3e9 young_2 = 1.2e9 young_3 = 0.9e9 shear_12 = 0.6e9 poisson_12 = 0.3 poisson_13 = 0.2 poisson_23 = 0.25 angle = -50.0 density = 1200.0 /
&body material = 'm' points_per_cell = 3 lower = 0.0, 0.0 upper = 14e-3, 14e-3 /
&crack kind = 'line' name = 'c' tip = 6e-3, 7e-3 direction = -1.0, 0.0 length = 3e-3 /
&constraint lower = 0.0, 0.0 upper = 14e-3, 0.0 fix = 'xy' /
&load kind = 'traction' force = 2e3, 5e3 lower = 0.0, 14e-3 upper = 14e-3, 14e-3 /
&refine indicator = 'tip' max_level = 3 rings = 3 /
&energy_release estimators = 'domain_integral' /
&method time = 'static' /
""")
    for tip, (k_1, k_2, j) in {"": (24505.3, 15812.5, 0.576529), "_tip2": (18501.9, 15445.4, 0.401866)}.items():
        for name, true in (("K_I", k_1), ("K_II", k_2), ("J", j)):
            off, told = abs(row[name + tip][-1] - true), row[f"{name}_error{tip}"][-1]
            assert off <= told < 0.02 * true, name + tip
        for name in ("G_domain_I", "G_domain_II"):
            assert row[f"{name}_error{tip}"][-1] < 0.04 * row[name + tip][-1]
