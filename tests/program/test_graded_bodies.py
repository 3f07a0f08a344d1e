"""Graded bodies: K and J of cracks where moduli and eigenstrain change from place to place."""

import csv
import math

import harness
import pytest
from paths import REFERENCE
from test_interface_intensities import box, place

STRAIN, E = 1e-3, 1e9


def plate(profile, half=16.0, cell=0.5, levels=4, angle=0.0, plane="stress", poisson=0.3, eigenstrain="", turn=False, order=1, moved=STRAIN, method="time = 'static'", more="",
          law="", indicator="tip"):
    """A plate that is pulled by a uniform strain across its crack from -1 to 1, which may be slanted [degrees]."""
    w, n = half, round(2 * half / cell) + 4
    c, s = math.cos(math.radians(angle)), math.sin(math.radians(angle))

    def grip(y):
        return f"&constraint {box((-w, y), (w, y), turn)} fix = '{'x' if turn else 'y'}' displacement = {place((0.0, math.copysign(moved * w, y)), turn)} /\n"
    return (f"&run plane = '{plane}' end_time = 1.0 /\n&grid lower = {-w - 2 * cell}, {-w - 2 * cell} cell = {cell} cells = {n}, {n} order = {order} /\n"
            f"&material name = 'm' {law or f'young = {E} poisson = {poisson}'} density = 1000 /\n"
            f"&body material = 'm' {box((-w, -w), (w, w), turn)} points_per_cell = {1 + order} {eigenstrain} {profile} profile_direction = {place((1.0, 0.0), turn)} /\n"
            + grip(w) + grip(-w) + f"&constraint {box((w, w), (w, w), turn)} fix = '{'y' if turn else 'x'}' /\n"
            f"&crack kind = 'path' name = 'c' points = {place((-c, -s), turn)}, {place((c, s), turn)} /\n{more}&method {method} /\n"
            f"&refine indicator = '{indicator}' max_level = {levels} rings = 8 /\n&energy_release estimators = 'domain_integral' /\n&output file = 'out.h5' /\n")


def exponential(beta, half=16.0):
    return f"profile_at = {-half}, {half} profile_stiffness = {math.exp(-beta * half)!r}, {math.exp(beta * half)!r}"


def references():
    with open(REFERENCE / "graded.csv") as file:
        return {float(row["beta a"]): (float(row["K_right"]), float(row["K_left"])) for row in csv.DictReader(line for line in file if not line.startswith("#"))}


def close_to(found, exact, modulus, part):
    """K and J of both tips, J as sqrt(E J), and that J is the same in all domains."""
    for tip, k, e in zip(("", "_tip2"), exact, modulus):
        print(tip or "_tip1", f"K {found['K_I' + tip] / k - 1:+.3%}", f"J {math.sqrt(found['J' + tip] * e) / k - 1:+.3%}", f"domains {found['J_domain_dependence' + tip] / found['J' + tip]:.3%}")
        assert found["K_I" + tip] == pytest.approx(k, rel=part)
        assert math.sqrt(found["J" + tip] * e) == pytest.approx(k, rel=part)
        assert found["J_domain_dependence" + tip] < 2e-3 * found["J" + tip]


@pytest.mark.parametrize("beta", [0.25, 0.5])
def test_exponential_modulus(hampm, beta):
    """Konda & Erdogan's plate, within 1 %; its edges, 16 half-lengths away, make 0.5 % of that."""
    exact = [k * E * STRAIN * math.sqrt(math.pi) for k in references()[beta]]
    close_to(harness.run(hampm, plate(exponential(beta))).last(), exact, [E * math.exp(beta), E * math.exp(-beta)], 0.01)


@pytest.mark.parametrize("end", [24.0, 1.25])
def test_heat_that_changes_along_the_crack(hampm, end):
    """A plate that is held at its ends and shrinks by eps (1 + x/2a) across its crack has, without Poisson's ratio, just the stress of that: K = E eps sqrt(pi a) (1 +- 1/4).
    So it has where nothing changes beyond a place near the tips, within the domains of J and K."""
    profile = f"profile_at = {-end}, {end} profile_eigenstrain = {1 - end / 2}, {1 + end / 2}"
    text = plate(profile, half=24.0, levels=5, moved=0.0, poisson=0.0, eigenstrain=f"eigenstrain = 0.0, {-STRAIN}, 0.0")
    exact = [E * STRAIN * math.sqrt(math.pi) * part for part in (1.25, 0.75)]
    close_to(harness.run(hampm, text).last(), exact, [E, E], 0.01)


@pytest.mark.parametrize(("plane", "law"), [("strain", ""), ("stress", ""), ("stress", "law = 'orthotropic' young_1 = 2e9 young_2 = 1e9 poisson_12 = 0.2 shear_12 = 0.5e9")])
def test_both_across_a_slanted_crack(hampm, plane, law):
    """J does not depend on the domain, and is what both K make, in a body whose moduli and eigenstrain change together, and in that turned by a quarter."""
    profile = "profile_at = -16.0, 0.0, 16.0 profile_stiffness = 0.02, 1.0, 9.0 profile_eigenstrain = -3.0, 1.0, 5.0 profile_density = 1.0, 2.0, 3.0"
    settings = dict(angle=36.0, plane=plane, half=16.0, law=law)
    found = harness.run(hampm, plate(profile, eigenstrain="eigenstrain = -2e-4, -5e-4, 1e-4, -3e-4", **settings).replace("-3e-4", "-3e-4" if plane == "strain" else "0.0")).last()
    for tip in "", "_tip2":
        j = found["J" + tip]
        print(tip, f"domains {found['J_domain_dependence' + tip] / j:.3%}", f"K {found['G' + tip] / j - 1:+.3%}", found["K_I" + tip], found["K_II" + tip])
        assert found["J_domain_dependence" + tip] < 5e-3 * j
        assert found["G" + tip] == pytest.approx(j, rel=0.02)
        assert abs(found["K_II" + tip]) > 0.2 * abs(found["K_I" + tip])
    if not law:
        turned = harness.run(hampm, plate(profile, eigenstrain="eigenstrain = -5e-4, -2e-4, -1e-4, -3e-4", turn=True, **settings).replace("-3e-4", "-3e-4" if plane == "strain" else "0.0")).last()
        for column in "K_I", "K_II", "J", "K_I_tip2", "J_tip2":
            assert turned[column] == pytest.approx(found[column], rel=1e-6)


def test_pressed_faces(hampm):
    """What is added to the stress for a pressure on the faces has no part in the terms of the moduli."""
    uniform = "&load kind = 'pressure' on = 'crack' crack = 'c' pressure = 1e6 /\n"
    found = harness.run(hampm, plate(exponential(0.25), moved=0.0, more=uniform)).last()
    for tip, e in ("", E * math.exp(0.25)), ("_tip2", E * math.exp(-0.25)):
        assert found["J_domain_dependence" + tip] < 5e-3 * found["J" + tip]
        assert found["K_I" + tip] == pytest.approx(math.sqrt(e * found["J" + tip]), rel=0.005)


def test_factors_of_one_change_nothing(hampm):
    plain = harness.run(hampm, plate("", half=8.0, levels=2).replace("profile_direction = 1.0, 0.0", "")).last()
    one = harness.run(hampm, plate("profile_at = -1.0, 1.0 profile_stiffness = 1.0, 1.0", half=8.0, levels=2)).last()
    assert all(one[column] == pytest.approx(plain[column], rel=1e-9, abs=1e-9 * abs(plain["K_I"])) for column in plain if column not in ("wall_time", "processor_time") and "dependence" not in column)


@pytest.mark.parametrize(("method", "indicator"), [("time = 'explicit' frame = 'updated'", "zz"), ("time = 'explicit'", "tip"), ("time = 'implicit' time_step = 2e-4", "zz")])
def test_a_run_that_goes_on(hampm, method, indicator):
    """Refined in motion, stopped and resumed, a run has the same bytes."""
    load = "&load kind = 'traction' lower = -8.0, -8.0 upper = -8.0, 8.0 force = 1e7, 2e6 /\n"
    text = plate(exponential(0.5, 8.0), half=8.0, levels=1, indicator=indicator, moved=0.0, more=load, method=method).replace(" displacement = 0.0, 0.0", "").replace(" displacement = 0.0, -0.0", "").replace("end_time = 1.0", "end_time = 4e-3").replace("rings = 8", "rings = 8 tolerance = 0.2")
    expected = harness.datasets(harness.run(hampm, text, "output.history_interval=1e-3", "output.snapshot_interval=4e-3").path)
    harness.run(hampm, text, "output.history_interval=1e-3", "output.snapshot_interval=4e-3", "--steps", "7", code=5)
    assert hampm("--resume", "out.h5.checkpoint", "--quiet").returncode == 0
    found = harness.datasets(hampm.folder / "out.h5")
    assert found.keys() == expected.keys() and all(harness.same_bytes(found[name], expected[name]) for name in expected)


def test_cells_that_recombine_have_the_material_of_their_places(hampm):
    """A crack that has grown has J and K of one that was as long from the start: behind it fine cells have become coarse ones."""
    text = plate(exponential(0.5, 8.0), half=8.0, levels=1).replace("rings = 8", "rings = 3").replace("-1.0, -0.0, 1.0, 0.0", "-9.0, 0.0, {tip}, 0.0")
    text = text.replace("'domain_integral'", "'domain_integral' radii = 1.2, 1.6, 2.0")
    more = "&growth law = 'quasi_static' direction = 'straight' toughness = 1.0 increment = 1.0 /\n"
    grown = harness.run(hampm, text.format(tip=-4.0) + more, "method.load_steps=6").last()
    stays = harness.run(hampm, text.format(tip=grown["tip_x"])).last()
    print(grown["tip_x"], [(grown[name] / grown["load_factor"]**power / stays[name] - 1) for name, power in (("J", 2), ("K_I", 1))])
    assert grown["tip_x"] > 0.9
    for name, power in (("J", 2), ("K_I", 1)):
        assert grown[name] / grown["load_factor"]**power == pytest.approx(stays[name], rel=1e-4), name


@pytest.mark.parametrize(("profile", "told"), [
    ("profile_at = 0.0 profile_stiffness = 1.0", "profile_at = 0.0: must have two places at least"),
    ("profile_at = 1.0, 0.0 profile_stiffness = 1.0, 2.0", "must increase from one to the next"),
    ("profile_at = 0.0, 1.0 profile_stiffness = 1.0", "must have one value for each of the 2 places of profile_at, not 1"),
    ("profile_at = 0.0, 1.0", "requires profile_stiffness or profile_density or profile_eigenstrain"),
    ("profile_stiffness = 0.0, 1.0", "must be in (0, inf)"),
    ("profile_at = 0.0, 1.0 profile_eigenstrain = 1.0, 2.0", "requires eigenstrain"),
])
def test_what_is_refused(hampm, profile, told):
    said = harness.run(hampm, plate(profile, half=8.0), code=2)
    assert told in said, said
