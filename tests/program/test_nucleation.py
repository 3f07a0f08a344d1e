"""Cracks that appear where none was: what a new crack releases in laminates, against the principle of minimum complementary energy, and the load at which one begins at a
notch, against the asymptotic solution (tests/reference/nucleation)."""

import math
import sys

import h5py
import numpy as np
import pytest

from harness import differing, run
from paths import INPUT, REFERENCE

sys.path.insert(0, str(REFERENCE / "nucleation"))
import notch  # noqa: E402
from laminate import CARBON, GLASS, Laminate  # noqa: E402
from appearing_scenes import K_IC, POISSON, STRENGTH, T0, T90, TOUGHNESS, YOUNG, beam, laminate  # noqa: E402


@pytest.mark.parametrize("of", [CARBON, GLASS], ids=["carbon", "glass"])
@pytest.mark.parametrize("length", [2e-3, 4e-3, 8e-3], ids=lambda length: f"{length * 1e3:g}mm")
def test_released_energy_of_the_next_crack(hampm, of, length):
    """Half way between two cracks, by given grips and converted to a given load, against many layers; one layer is the solution of Nairn."""
    found = run(hampm, laminate(of, length, heat=0.0))
    theory, nairn = Laminate(of, T90, T0, heat=0.0), Laminate(of, T90, T0, 1, heat=0.0)
    u = found["load_factor"][0] * length * 5e-3
    compliances = u / found["reaction_grip_x"]
    share = theory.share**2 * T90
    energy = (compliances[1] - compliances[0]) / 2 / share
    asked = [(2 * of_layers.energy(length / 2) - of_layers.energy(length)) / T90 for of_layers in (theory, nairn)]
    print(f"asked {asked[0]:.4g} J/m2 for 1 Pa (one layer: {asked[1]:.4g}), measured {energy:.4g}: {energy / asked[0]:.4f}; grips {u / theory.onset([length], [length / 2] * 2, TOUGHNESS)[0]:.4f}")
    assert energy == pytest.approx(asked[0], rel=0.02)
    assert asked[1] == pytest.approx(nairn.nairn(1 / length), rel=1e-9)
    assert u == pytest.approx(theory.onset([length], [length / 2] * 2, TOUGHNESS)[0], rel=0.01)
    assert found["fracture_energy"][1] == pytest.approx(TOUGHNESS * T90, rel=1e-6)
    assert np.abs(found["numerical_loss"]).max() < 1e-10 * found["strain_energy"].max()


@pytest.mark.parametrize("of", [CARBON, GLASS], ids=["carbon", "glass"])
def test_cracks_one_after_the_other_with_residual_stress(hampm, of):
    found = run(hampm, laminate(of, 8e-3, places=(0.0, -2e-3, 2e-3)))
    theory = Laminate(of, T90, T0)
    stages = [8e-3], [4e-3] * 2, [4e-3, 2e-3, 2e-3], [2e-3] * 4
    asked = np.array([theory.onset(before, after, TOUGHNESS) for before, after in zip(stages, stages[1:])])
    u, load = found["load_factor"][:3] * 8e-3 * 5e-3, found["reaction_grip_x"][:3]
    print("grips", u / asked[:, 0], "load", load / asked[:, 1])
    assert list(found["onset_crack"]) == [1, 2, 3, 0]
    assert u == pytest.approx(asked[:, 0], rel=0.02)
    assert load == pytest.approx(asked[:, 1], rel=0.022)
    assert found["fracture_energy"] == pytest.approx(TOUGHNESS * T90 * np.arange(4), rel=1e-6)


@pytest.mark.parametrize("angle", [60, 90, pytest.param(120, marks=pytest.mark.verify), pytest.param(150, marks=pytest.mark.verify)])
def test_strength_of_v_notches(hampm, angle):
    """k of the notch by the stress beyond the crack that waits; load and length of the asymptotic solution."""
    places = np.array([5e-5, 7e-5, 1e-4, 1.4e-4, 2e-4])
    probes = "".join(f"&probe name = 'p{k}'  at = 0.0, {5e-3 + float(r)}  quantity = 'stress' /\n" for k, r in enumerate(places))
    found = run(hampm, beam(angle, extra=probes))
    k = notch.intensity(places, [found[f"stress_p{n}_xx"][0] for n in range(len(places))], math.radians(angle))
    length, asked = notch.onset(math.radians(angle), K_IC, STRENGTH)
    print(f"asked {asked:.5g}, {length * 1e6:.2f} um; measured {k / asked:.4f}, {found['onset_length'][0] / length:.4f}")
    assert k == pytest.approx(asked, rel=0.015)
    assert found["onset_length"][0] == pytest.approx(length, rel=0.04)
    assert found["onset_energy"][0] == pytest.approx(K_IC**2 * (1 - POISSON**2) / YOUNG)


def test_psi_of_the_asymptotic_solution():
    """A crack ahead of a crack has its K, and at a straight edge that of Koiter."""
    assert notch.psi(0.0) == pytest.approx(math.sqrt(2 * math.pi), rel=1e-9)
    assert notch.psi(math.pi) / math.sqrt(math.pi) == pytest.approx(1.1215222552, rel=1e-9)


def strip(*, growth="", cell=1e-3, extra="", strength=10e6, load=1e6, toughness=100.0, increment=1e-3, points=(-1e-3, 0.0, 8e-3, 0.0)):
    """A strip under tension, in whose edge a crack may appear."""
    return f"""&run plane = 'stress'  thickness = 1e-2  end_time = 1.0 /
&grid lower = -2e-3, -40e-3  cell = {cell}  cells = {round(44e-3 / cell)}, {round(80e-3 / cell)} /
&material name = 'm'  young = 70e9  poisson = 0.2  density = 2500 /
&body material = 'm'  lower = 0.0, -40e-3  upper = 40e-3, 40e-3 /
&load kind = 'traction'  lower = 0.0, 40e-3  upper = 40e-3, 40e-3  force = 0.0, {load * 4e-4} /
&load kind = 'traction'  lower = 0.0, -40e-3  upper = 40e-3, -40e-3  force = 0.0, {-load * 4e-4} /
&crack kind = 'path'  points = {', '.join(map(str, points))} /
&nucleation toughness = {toughness}  strength = {strength}  increment = {increment} /
{growth}&method time = 'static'  load_steps = 3 /
&energy_release {"estimators = 'domain_integral'" if growth else ''}  energy_balance = .true. /
&output file = 'out.h5' /
{extra}"""


GROWTH = "&growth direction = 'straight'  toughness = 100.0  increment = 2e-3 /\n"


def test_smooth_edge(hampm):
    """Where the stress is uniform the strength is the load, if the longest crack that is tried releases enough, by Tada's K of an edge crack; else the energy of that one is."""
    width = 40e-3

    def released(length):
        a = np.linspace(0, length, 2001)
        x = a / width
        k2 = np.pi * a * (1.122 - 0.231 * x + 10.55 * x**2 - 21.72 * x**3 + 30.39 * x**4)**2
        return np.trapezoid(k2, a) / 70e9 / length
    strong = run(hampm, strip(strength=1e9, cell=0.5e-3))
    assert strong["load_factor"][0] == pytest.approx(1e3, rel=1e-3)        # the strength
    weak = run(hampm, strip(strength=1e5, cell=0.5e-3))
    asked = math.sqrt(100.0 / released(8e-3)) / 1e6
    print(f"asked {asked:.4f}, measured {weak['load_factor'][0]:.4f}")
    assert weak["onset_length"][0] == pytest.approx(8e-3, rel=1e-6)
    assert weak["load_factor"][0] == pytest.approx(asked, rel=0.03)


@pytest.mark.parametrize("degrees", [30.0, 45.0, -45.0])
def test_strength_across_any_direction(hampm, degrees):
    """In pure shear the stress across a crack is the shear times sin(2 angle): where that is tension, its strength is reached; where it is pressure, never."""
    side, shear, strength = 20e-3, 1e6, 10e6
    c, s = 5e-3 * math.cos(math.radians(degrees)), 5e-3 * math.sin(math.radians(degrees))
    edges = "".join(f"&load kind = 'traction'  lower = {x0}, {y0}  upper = {x1}, {y1}  force = {fx * 2 * side * shear}, {fy * 2 * side * shear} /\n" for x0, y0, x1, y1, fx, fy in (
        (-side, side, side, side, -1, 0), (-side, -side, side, -side, 1, 0), (side, -side, side, side, 0, -1), (-side, -side, -side, side, 0, 1)))
    found = run(hampm, f"""&run plane = 'stress'  end_time = 1.0 /
&grid lower = -22e-3, -22e-3  cell = 2e-3  cells = 22, 22 /
&material name = 'm'  young = 70e9  poisson = 0.2  density = 2500 /
&body material = 'm'  lower = {-side}, {-side}  upper = {side}, {side} /
{edges}&crack kind = 'path'  points = {-c}, {-s}, {c}, {s} /
&nucleation toughness = 1e-6  strength = {strength}  increment = 2e-3 /
&method time = 'static'  load_steps = 1 /
&output file = 'out.h5' /
""")
    across = shear * math.sin(math.radians(2 * degrees))
    assert found["onset_crack"][0] == (across > 0)
    assert across < 0 or found["load_factor"][0] == pytest.approx(strength / across, rel=1e-6)


def test_a_penny_around_an_axis(hampm):
    """Where the strength is no bar a penny of the longest length appears, whose G is the toughness in the mean over its area: that of Sneddon, 8 (1 - nu**2) s**2 a/(3 pi E)."""
    radius, toughness = 4e-3, 100.0
    force = 1e6 * math.pi * 20e-3**2
    found = run(hampm, f"""&run plane = 'axisymmetric'  end_time = 1.0 /
&grid lower = 0.0, -22e-3  cell = 0.5e-3  cells = 44, 88 /
&material name = 'm'  young = 70e9  poisson = 0.2  density = 2500 /
&body material = 'm'  lower = 0.0, -20e-3  upper = 20e-3, 20e-3 /
&load kind = 'traction'  lower = 0.0, 20e-3  upper = 20e-3, 20e-3  force = 0.0, {force} /
&load kind = 'traction'  lower = 0.0, -20e-3  upper = 20e-3, -20e-3  force = 0.0, {-force} /
&crack kind = 'path'  points = 0.0, 0.0, {radius}, 0.0 /
&nucleation toughness = {toughness}  strength = 1e3  increment = 1e-3 /
&method time = 'static'  load_steps = 1 /
&energy_release energy_balance = .true. /
&output file = 'out.h5' /
""")
    asked = math.sqrt(toughness * 3 * math.pi * 70e9 / (8 * (1 - 0.2**2) * radius)) / 1e6
    print(f"asked {asked:.4f}, measured {found['load_factor'][0] / asked:.4f}")
    assert found["load_factor"][0] == pytest.approx(asked, rel=0.045)      # 3.5 %, with cells of 0.4 mm 2.7 %
    assert found["fracture_energy"][1] == pytest.approx(toughness * math.pi * radius**2, rel=1e-9)


def test_growth_goes_on(hampm):
    """The crack of the strip appears whole, has more than its toughness, and then grows as one that is there from the start."""
    found = run(hampm, strip(growth=GROWTH, strength=1e5))
    with h5py.File(found.path) as file:            # the radii are not those of the first row in all
        assert file["history/J_1"].attrs["long_name"].endswith("radius 1 of those that there is room for")
    there = run(hampm, strip(growth=GROWTH).replace("&nucleation toughness = 100.0  strength = 10000000.0  increment = 0.001 /\n", ""))
    assert found["load_factor"][1:] == pytest.approx(there["load_factor"][:3], rel=1e-6)
    assert found["crack_length"] == pytest.approx([0, 8e-3, 10e-3, 12e-3])
    assert math.isnan(found["K_I"][0])
    assert found["load_factor"][1] < found["load_factor"][0]
    assert np.abs(found["numerical_loss"]).max() < 0.02 * found["fracture_energy"].max()


def test_a_crack_that_grows_before_another_appears(hampm):
    """What comes first counts: with a strength that is not reached the second crack waits."""
    two = strip(growth=GROWTH.replace("&growth", "&growth crack = 'a'"), points=(41e-3, 5e-3, 30e-3, 5e-3)).replace("&crack", "&crack name = 'b'").replace(
        "&nucleation", "&crack name = 'a'  kind = 'path'  points = -1e-3, 0.0, 12e-3, 0.0 /\n&nucleation crack = 'b'")
    waits = run(hampm, two.replace("strength = 10000000.0", "strength = 1e9"))
    assert not waits["onset_crack"].any() and (waits["crack_length_tip2"] > 12e-3).all() and not waits["crack_length"].any()
    comes = run(hampm, two.replace("strength = 10000000.0", "strength = 1e3").replace("toughness = 100.0  strength", "toughness = 1.0  strength"))
    assert comes["onset_crack"][0] == 1 and comes["load_factor"][0] < waits["load_factor"][0]


def test_held_loads_that_suffice_are_an_error(hampm):
    live = "".join(f"&load kind = 'traction'  lower = 0.0, {y}  upper = 40e-3, {y}  force = 0.0, {1e5 * y} /\n" for y in (40e-3, -40e-3))
    said = run(hampm, strip(strength=1e5, load=1e8).replace("&load kind = 'traction'", "&load held = .true.  kind = 'traction'") + live, code=3)
    assert "appears by held loads or eigenstrains alone" in said


def test_pressed_material_does_not_crack(hampm):
    found = run(hampm, strip(load=-1e6, strength=0.0))
    assert not found["onset_crack"].any() and (found["load_factor"] == 1).all()


def test_scenes_of_input(hampm):
    """The words at their heads."""
    found = run(hampm, INPUT / "laminate_cracks.nml")
    assert found["reaction_grip_x"][:3] / 1.5e-6 == pytest.approx([71e6, 99e6, 98e6], rel=0.01)


def test_resumed(hampm):
    """While the crack waits, as it is about to appear, and after that, on another number of threads: the same bytes."""
    text = strip(growth=GROWTH, strength=1e5)
    run(hampm, text, name="whole")
    for steps in ("1", "2"):
        run(hampm, text, code=5, words=("--steps", steps, "--threads", "2"), name="part")
        assert hampm("--resume", "part.h5.checkpoint", "--quiet", "--threads", "1").returncode == 0
        assert not differing(hampm.folder / "whole.h5", hampm.folder / "part.h5")


@pytest.mark.parametrize(("old", "new", "phrase"), [
    ("&nucleation", "&nucleation crack = 'z' ", "&nucleation crack = 'z': there is no &crack of this name"),
    ("&method", "&nucleation toughness = 1.0 /\n&method", "is the crack of another &nucleation"),
    ("increment = 0.001", "increment = 0.1e-3", "must be at least the finest cell, 0.001 m"),
    ("increment = 0.001", "increment = 0.02", "must be at most the length of the crack in the material, "),
    ("0.008, 0.0", "0.042, 0.0", "is for a crack whose last point is a tip inside the material"),
    ("toughness = 100.0  strength", "strength", "&nucleation requires toughness > 0"),
    ("kind = 'path'", "kind = 'path'  contact = 'frictionless'", "is not allowed with &crack contact = 'frictionless'"),
    ("time = 'static'  load_steps = 3", "time = 'explicit'", "requires &method time = 'static'"),
    ("&load kind", "&load held = .true.  kind", "requires something that growth scales"),
], ids=["name", "twice", "short", "long", "outside", "toughness", "contact", "motion", "held"])
def test_mistakes(hampm, old, new, phrase):
    text = strip()
    assert old in text
    assert phrase in run(hampm, text.replace(old, new), code=2)
