"""Pins and rollers: constraints that turn freely (`turns`), whose nodes are a rigid body about the middle of their box."""

import math

import numpy as np
import pytest

import harness
from paths import INPUT

# A beam on a pin at its left end and a roller at its right one, each a patch in its middle plane
YOUNG, DENSITY, LENGTH, DEPTH, WIDTH = 1e9, 1000.0, 0.1, 0.01, 0.01
BEAM = """
&run plane = 'stress'  thickness = 0.01  end_time = {end} /
&grid lower = -6e-3, -9e-3  cell = {cell}  cells = {nx}, {ny}  order = {order} /
&material name = 'a'  young = 1e9  poisson = 0.3  density = 1000  law = '{law}' /
&body material = 'a'  lower = -4e-3, -5e-3  upper = 104e-3, 5e-3  points_per_cell = {points} /
&constraint lower = -1e-3, -1e-3  upper = 1e-3, 1e-3  fix = 'xy' {turns} name = 'pin' /
&constraint lower = 99e-3, -1e-3  upper = 101e-3, 1e-3  fix = 'y' {turns} {motion} name = 'roller' /
{load}
&method time = '{time}'  {method} /
&energy_release energy_balance = .true. /
&probe name = 'middle'  quantity = 'displacement'  at = 50e-3, 0.0 /
&probe name = 'end'  quantity = 'displacement'  at = 103e-3, 4e-3 /
&output history_interval = {every} /
"""


def beam(hampm, **values):
    values = {"end": 1.0, "every": 1.0, "cell": 1e-3, "order": 1, "points": 2, "law": "linear_elastic", "turns": "turns = .true.", "motion": "", "load": "",
              "time": "static", "method": ""} | values
    cell = values["cell"]
    return harness.run(hampm, BEAM.format(nx=round(0.112 / cell), ny=round(0.018 / cell), **values))


@pytest.mark.parametrize("values", [{}, {"order": 2, "points": 3}, {"time": "implicit", "end": 1000.0, "every": 1000.0, "method": "time_step = 100.0"}], ids=str)
def test_a_body_turns_about_its_pin_without_force(hampm, values):
    """The roller lifts its end: the beam turns as a whole, by 1e-5 rad, and nothing resists."""
    motion = "displacement = 0.0, 1e-6" + (" history = 'smooth_ramp' rise_time = 500.0" if "end" in values else "")
    row = beam(hampm, motion=motion, **values).last()
    assert row["displacement_end_y"] == pytest.approx(103e-3 * 1e-5, rel=1e-5)
    assert row["displacement_end_x"] == pytest.approx(-4e-3 * 1e-5, rel=1e-4)
    bent = 3 * YOUNG * WIDTH * DEPTH**3 / 12 * 1e-6 / LENGTH**3          # the force that would bend a clamped beam as far
    forces = [row[f"reaction_{name}_{d}"] for name in ("pin", "roller") for d in "xy"]
    print("forces over those of bending", np.abs(forces).max() / bent, "energy", row["strain_energy"] / (bent * 0.5e-6))
    assert np.abs(forces).max() < 1e-5 * bent
    assert row["strain_energy"] < 1e-8 * bent * 1e-6


@pytest.mark.parametrize("values", [{}, {"order": 2, "points": 3, "cell": 2e-3}, {"law": "neo_hookean", "cell": 2e-3}, {"method": "solver = 'cg'", "cell": 2e-3}], ids=str)
def test_a_beam_bends_on_a_pin_and_a_roller(hampm, values):
    """Under its weight a beam between points that turn sags by 5 q L**4/(384 E I) + 1.2 q L**2/(8 G A), with overhangs of 4 mm; patches that do not turn leave far less. The pin has half
    of the weight and no force along the beam."""
    weight = "&load kind = 'gravity'  acceleration = 0.0, -1.0 /"
    row = beam(hampm, load=weight, **values).last()
    held = beam(hampm, load=weight, turns="", **values).last()
    q, inertia, area = DENSITY * WIDTH * DEPTH, WIDTH * DEPTH**3 / 12, WIDTH * DEPTH
    over = q * 4e-3**2 / 2
    sag = 5 * q * LENGTH**4 / (384 * YOUNG * inertia) + 1.2 * q * LENGTH**2 / (8 * YOUNG / 2.6 * area) - over * LENGTH**2 / (8 * YOUNG * inertia)
    print(f"sag {-row['displacement_middle_y'] / sag:.4f} of the beam's; held {-held['displacement_middle_y'] / sag:.4f}")
    assert -row["displacement_middle_y"] == pytest.approx(sag, rel=0.02)
    assert -held["displacement_middle_y"] < 0.7 * sag
    assert row["reaction_pin_y"] == pytest.approx(q * 108e-3 / 2, rel=1e-7) == row["reaction_roller_y"]
    assert abs(row["reaction_pin_x"]) < 1e-9 * row["reaction_pin_y"]
    assert row["strain_energy"] == pytest.approx(row["external_work"], rel=1e-9)


def frequency_of_beam():
    """The lowest of a Timoshenko beam on supports that turn [1/s], a L/h of 10: Euler's, less the part that shear and turning take."""
    euler = (math.pi / LENGTH)**2 * math.sqrt(YOUNG * DEPTH**2 / 12 / DENSITY) / (2 * math.pi)
    part = (math.pi / LENGTH)**2 * DEPTH**2 / 12 * (1 + 2.6 * 1.2)
    return euler / math.sqrt(1 + part)


MOTIONS = [("explicit", "mass = 'lumped'"), ("explicit", "mass = 'lumped'  scheme = 'usf'"), ("explicit", "mass = 'consistent'"), ("explicit", "mass = 'consistent'  solver = 'cg'"),
           ("explicit", "mass = 'fmpm'"), ("explicit", "mass = 'weighted'"), ("explicit", "mass = 'partial'  consistent_lower = 20e-3, -5e-3  consistent_upper = 60e-3, 5e-3"), ("explicit", "mass = 'lumped'  frame = 'updated'"),
           ("implicit", "time_step = 2e-5"), ("implicit", "time_step = 2e-5  hht_alpha = -0.1")]


@pytest.mark.parametrize("time, method", MOTIONS, ids=str)
def test_a_beam_swings_on_a_pin_and_a_roller(hampm, time, method):
    """The weight comes at once, and the beam swings with the frequency of the theory: half of a period until it is lowest."""
    period = 1 / frequency_of_beam()
    every = period / 100
    rows = beam(hampm, cell=2e-3, time=time, method=method, end=0.8 * period, every=every, load="&load kind = 'gravity'  acceleration = 0.0, -1.0 /")
    y, t = rows["displacement_middle_y"], rows["time"]
    near = slice(np.argmin(y) - 12, np.argmin(y) + 13)
    a, b, _ = np.polyfit(t[near], y[near], 2)
    last, energy = rows.last(), rows["external_work"].max()
    missing = last["external_work"] - last["kinetic_energy"] - last["strain_energy"] - last["numerical_loss"]
    print(f"half period {-b / (2 * a) / period * 2:.4f}, loss {last['numerical_loss'] / energy:.2e}, missing {missing / energy:.1e}")
    assert -b / (2 * a) == pytest.approx(period / 2, rel=0.03)
    assert abs(missing) < 1e-11 * energy
    assert abs(last["numerical_loss"]) < (0.02 if "hht" in method else 5e-3) * energy


def test_a_compact_tension_specimen_between_pins(hampm):
    """The opening in the load line over the load (Saxena & Hudak 1978, 0.5 %) and K (ASTM E399, 0.5 %; uniform cells around the holes). Grips that do not turn take a moment."""
    text = (INPUT / "compact_tension_pins.nml").read_text()
    row, held = harness.run(hampm, text).last(), harness.run(hampm, text.replace("turns = .true.", "turns = .false.")).last()
    alpha, young = 0.5, 210e9 / (1 - 0.3**2)
    compliance = ((1 + alpha) / (1 - alpha))**2 * np.polyval([-9.9314, 20.609, -0.9925, -20.065, 12.219, 2.163], alpha) / young

    def ratios(row):
        load = row["load_pins_y"]
        return (row["displacement_upper_face_y"] - row["displacement_lower_face_y"]) / load / compliance, row["K_I"] / (9.659 * load / math.sqrt(0.05))
    print("opening over load, K over load:", ratios(row), "held", ratios(held))
    assert ratios(row) == pytest.approx((1, 1), rel=6e-3)
    assert max(ratios(held)) < 0.85
    assert row["load_pins_y"] * 1e-5 / 2 == pytest.approx(row["strain_energy"], rel=1e-9) == row["external_work"]


def test_a_crack_grows_between_pins(hampm):
    """With the crack the pins lose load and move on: K of ASTM E399 (0.5 %) is that of the toughness at each length, and what they work less what is stored is toughness times area."""
    toughness, steps = 2000.0, 4
    text = (INPUT / "compact_tension_pins.nml").read_text() + f"&growth toughness = {toughness}  increment = 1e-3  direction = 'straight' /\n&control /\n"
    row = harness.run(hampm, text, f"method.load_steps={steps}", f"run.end_time={steps}", "refine.max_level=2", "refine.rings=8", "energy_release.energy_balance=.true.",
                      "output.snapshot_interval=0")
    x = row["tip_x"] / 0.05
    shape = (2 + x) / (1 - x)**1.5 * np.polyval([-5.6, 14.72, -13.32, 4.64, 0.886], x)
    load = math.sqrt(toughness * 210e9 / (1 - 0.3**2)) * math.sqrt(0.05) / shape
    released = (np.diff(row["external_work"]) - np.diff(row["strain_energy"])) / (toughness * np.diff(row["tip_x"]))
    print("load", row["load"] / load, "released", released)
    assert row["load"] == pytest.approx(load, rel=0.015)
    assert released == pytest.approx(np.ones(steps), rel=0.01)
    assert np.all(np.diff(row["load"]) < 0) and np.all(np.diff(row["load_displacement"]) > 0)


@pytest.mark.parametrize("change, reason", [
    (("name = 'pin'", "unilateral = .true. name = 'pin'"), "no rigid body does"), (("plane = 'stress'  thickness = 0.01", "plane = 'axisymmetric'"), "a ring does not turn"),
    (("&energy_release", "&contact bodies = 'stick' /\n&energy_release"), "an impulse between bodies"),
    (("scheme", "path = 'reference'"), "the reference step has no prescribed motion"), (("turns = .true. name", "turns = 'freely' name"), "turns")], ids=lambda x: x if isinstance(x, str) else "")
def test_what_turns_is_refused_with_a_reason(hampm, change, reason):
    text = BEAM.format(end=1e-4, every=1e-4, cell=2e-3, nx=56, ny=9, order=1, points=2, law="linear_elastic", turns="turns = .true.", motion="", load="", time="explicit", method="scheme")
    changed = text.replace(*change).replace("  scheme", "")
    assert changed != text.replace("  scheme", "")
    assert reason in harness.run(hampm, changed, code=2)


def test_a_pin_at_one_node_turns_without_the_key(hampm):
    """A box that holds one node does not tell how it turns: the same with and without the key."""
    load = "&load kind = 'gravity'  acceleration = 0.0, -1.0 /"
    one = [beam(hampm, cell=2e-3, load=load.replace("/", "/\n&constraint lower = 48e-3, -5e-3  upper = 48e-3, -5e-3  fix = 'xy'  " + turns + " name = 'one' /"))["displacement_end_y"]
           for turns in ("", "turns = .true.")]
    assert np.array_equal(*one)
