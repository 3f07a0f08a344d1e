"""Faces that cohesion holds: double cantilever beams against beam theory in both modes, end-notched flexure and a bar against closed forms, at rest, in implicit and explicit steps; refined, resumed,
in mirrors. Plane stress, E = 70 GPa, arms of 3 mm, 1 mm thick: a couple M on each arm is G = 12 M**2/(E b**2 h**3) in mode I, 3/4 of that where both turn alike (mode II)."""

import h5py
import numpy as np
import pytest
from scipy.optimize import brentq

from harness import differing, run
from paths import CHECKED_PROGRAM, INPUT, PROGRAM

E, H, B = 70e9, 3e-3, 1e-3
INERTIA = B * H**3 / 12
BAR = """&run plane = 'stress'  thickness = 1e-3  end_time = 1.0 /
&grid lower = -1e-3, -1e-3  cell = 1e-3  cells = 12, 6 /
&material name = 'a'  young = 1e9  poisson = 0.0  density = 1000 /
&body material = 'a'  lower = 0.0, 0.0  upper = 10e-3, 4e-3 /
&constraint lower = 0.0, 0.0  upper = 0.0, 4e-3  fix = 'xy' /
&constraint name = 'end'  lower = 10e-3, 0.0  upper = 10e-3, 4e-3  fix = 'x'  displacement = {way}, 0.0  history = 'ramp'  rise_time = 1.0 /
&method time = 'static'  load_steps = 50 /
&crack kind = 'path'  name = 'a'  points = 5.5e-3, -1e-3, 5.5e-3, 5e-3 /
&cohesive crack = 'a'  {law} /
&energy_release energy_balance = .true. /
&output file = 'out.h5' /
"""
LAWS = {"linear": "law = 'linear'  strength = 1e6  toughness = 20.0", "bilinear": "law = 'bilinear'  strength = 1e6  toughness = 20.0  opening = 4e-6",
        "table": "law = 'table'  openings = 0.0, 1e-5, 6e-5  tractions = 1e6, 0.5e6, 0.0",
        "hardening": "law = 'table'  openings = 4e-6, 1e-5, 6e-5  tractions = 1e6, 1.5e6, 0.0"}


@pytest.mark.parametrize("law", LAWS)
def test_a_bar_parts(hampm, law):
    """All of its force follows from its end: u = T L/E + the opening, and what is taken is the toughness by the section."""
    row = run(hampm, BAR.format(way=7e-5, law=LAWS[law]))
    openings, tractions = {"linear": ([0, 4e-5], [1e6, 0]), "bilinear": ([4e-6, 4e-5], [1e6, 0]), "table": ([0, 1e-5, 6e-5], [1e6, 0.5e6, 0]),
                           "hardening": ([4e-6, 1e-5, 6e-5], [1e6, 1.5e6, 0])}[law]
    layer = 1e-3 / 3 / 1e9                                             # the compliance of the layer of the cells
    u = np.array([o + t * (10e-3 / 1e9 + layer) for o, t in zip(openings, tractions)])
    expected = np.interp(7e-5 * row["time"], [0, *u], [0, *tractions]) * 4e-6
    assert np.max(np.abs(row["reaction_end_x"] - expected)) < 2e-3 * 4
    assert row["cohesive_energy"][-1] == pytest.approx(4e-6 * np.trapezoid([0, *tractions], [0, *openings]), rel=2e-6)
    assert np.max(np.abs(row["numerical_loss"])) < 2e-3 * row["external_work"][-1]


def test_tractions_that_rise_as_their_openings_are_refused(hampm):
    """The secant stiffness falls from point to point: damage does not heal."""
    said = run(hampm, BAR.format(way=1e-6, law="law = 'table'  openings = 4e-6, 6e-6, 6e-5  tractions = 1e6, 1.501e6, 0.0"), code=2)
    assert "tractions = 1e6, 1.501e6, 0.0: must rise less than the openings do" in said


def test_a_bar_that_snaps_back_says_so(hampm, tmp_path):
    """Longer than 2 G E/strength**2 = 8 mm it stores more than its section takes."""
    said = run(hampm, BAR.format(way=2e-5, law="law = 'linear'  strength = 1e6  toughness = 4.0"), code=3)
    assert "snap" in said
    with h5py.File(tmp_path / "out.h5") as file:
        assert 3.6 < file["history/reaction_end_x"][-1] < 4.0          # the last load step before its strength, 4 N


@pytest.mark.parametrize(("opening", "code"), [(1.6e-7, 2), (1.75e-7, 0)])
def test_cells_that_let_faces_snap_apart_are_refused(hampm, opening, code):
    """Where a part of the law falls more steeply than the layer of the cells, a third of their size, gives: half the strength over 3e9 Pa/mm is 1.67e-7 m."""
    law = f"law = 'table'  openings = 0.0, {opening}, 6e-5  tractions = 1e6, 0.5e6, 0.0"
    said = run(hampm, BAR.format(way=1e-6, law=law), code=code)
    assert code == 0 or "too large for the cohesive zone" in said


def beam(loads, law, cell=0.75e-3, length=99e-3, a=22e-3, method="time = 'static'  load_steps = 20", radii=2.25e-3, end=1.0, more="", contact="", output=""):
    """A beam of two arms, its crack a long from 1 mm before its end on, held from there on."""
    n = round(length / cell)
    return f"""&run plane = 'stress'  thickness = {B}  end_time = {end} /
&grid lower = {-2 * cell}, {-H - 2 * cell}  cell = {cell}  cells = {n + 4}, {round(2 * H / cell) + 4} /
&material name = 'a'  young = {E}  poisson = 0.3  density = 2700 /
&body material = 'a'  lower = 0.0, {-H}  upper = {length}, {H} /
&constraint lower = {length}, {-H}  upper = {length}, {H}  fix = 'xy' /
{loads}&method {method} /
&crack kind = 'path'  name = 'a'  points = -1e-3, 0.0, {length - 6e-3}, 0.0  {contact} /
&cohesive crack = 'a'  from = {a}  {law} /
&energy_release estimators = 'domain_integral'  energy_balance = .true.  radii = {radii} /
{more}
&output file = 'out.h5'  {output} /
"""


def couples(upper, lower, history="history = 'ramp'  rise_time = 1.0"):
    """Couples on the arms, of opening sense [N m]."""
    text = ""
    for moment, sense in ((upper, 1), (lower, -1)):
        for outer, force in ((True, moment / (H / 2)), (False, -moment / (H / 2))):
            y = sorted((sense * H / 2, sense * H if outer else 0.0))
            text += f"&load kind = 'traction'  lower = 0.0, {y[0]}  upper = 0.0, {y[1]}  force = {force}, 0.0  {history} /\n"
    return text


def ends(way, end=1.0):
    """The ends of the arms are moved apart, each by a way."""
    return "".join(f"&constraint name = '{name}'  lower = 0.0, {sense * H}  upper = 0.0, {sense * H}  fix = 'y'  displacement = 0.0, {sense * way}"
                   f"  history = 'ramp'  rise_time = {end} /\n" for name, sense in (("up", 1), ("down", -1)))


def of_zone(c, strength, toughness):
    """J at which the zone of a linear law is c long: w'''' EI = -b T(2 w) on a half opening w, ahead an elastic foundation 2 E b/h (Kanninen 1973)."""
    k, final = 2 * E * B / H, 2 * toughness / strength
    lam, beta, first = (2 * B * strength / (E * INERTIA * final))**0.25, (k / (4 * E * INERTIA))**0.25, B * strength / k

    def derivatives(x):
        up, down, cos, sin = np.exp(lam * (x - c)), np.exp(-lam * x), np.cos(lam * x), np.sin(lam * x)
        return np.array([[up, down, cos, sin], [lam * up, -lam * down, -lam * sin, lam * cos], [lam**2 * up, lam**2 * down, -lam**2 * cos, -lam**2 * sin],
                         [lam**3 * up, -lam**3 * down, lam**3 * sin, -lam**3 * cos]])
    free, front = derivatives(0.0), derivatives(c)
    matrix, right = np.zeros((5, 5)), np.array([-final / 2, -beta * first, 0.0, 2 * beta**3 * first, 0.0])
    matrix[:4, :4], matrix[4, :4], matrix[1:4, 4] = front, free[3], [-beta, 2 * beta**2, -2 * beta**3]
    return (E * INERTIA * (free[2] @ np.linalg.solve(matrix, right)[:4]))**2 / (E * INERTIA * B)


def test_a_long_zone_of_bridges(hampm, tmp_path):
    """Large scale bridging: 2 MPa, 300 J/m2. The zone that couples open is as long as a beam on a foundation that softens has it, up to 15 mm, to 2 % and a cell; J is what the law
    takes up to the opening of the root (Rice 1968), but for the 0.6 % by which arms of four cells are too stiff."""
    most = (297.0 * E * INERTIA * B)**0.5
    row = run(hampm, beam(couples(most, most), "strength = 2e6  toughness = 300.0"))
    for time, zone in zip(row["time"][6:-1], row["zone_length"][6:-1]):
        assert zone == pytest.approx(brentq(lambda c, t=time: of_zone(c, 2e6, 300.0) - 297.0 * t**2, 1e-4, 18.2e-3), rel=0.02, abs=0.25e-3)
    assert np.allclose(2e6 * row["root_opening"] * (1 - row["root_opening"] / 600e-6), 297.0 * row["time"]**2, rtol=0.01)
    assert row["crack_length"][-1] == row["crack_length"][0]          # below the steady state nothing parts
    with h5py.File(tmp_path / "out.h5") as file:
        assert "cohesive zone" in file["history"].attrs["warnings"]     # longer than the disc of J
    assert np.max(np.abs(row["numerical_loss"])) < 2e-3 * row["external_work"][-1]


def test_the_resistance_rises_to_its_steady_state(hampm):
    """J of a disc that holds the zone is that of the couples and, from where the tip moves on, the toughness. Ends moved apart: the short zone is linear fracture, for which
    P**2 u = 8/(E b h**3) (G E b**2 h**3/12)**1.5 whatever the length of the crack."""
    law = "strength = 60e6  toughness = 300.0"
    most = (250.0 * E * INERTIA * B)**0.5
    row = run(hampm, beam(couples(most, most), law, cell=0.5e-3, length=60e-3, method="time = 'static'  load_steps = 5", radii=2.5e-3))
    assert np.allclose(row["J"][1:], 250.0 * row["time"][1:]**2, rtol=0.012)
    row = run(hampm, beam(ends(0.35e-3), law, cell=0.25e-3, length=60e-3, a=21e-3, method="time = 'static'  load_steps = 20", radii=2.5e-3))
    grown = row["crack_length"] > row["crack_length"][0] + 0.5e-3
    assert np.count_nonzero(grown) >= 5
    assert np.allclose(row["J"][grown], 300.0, rtol=0.005)
    steady = 8 / (E * B * H**3) * (300.0 * E * B**2 * H**3 / 12)**1.5
    assert np.allclose((row["reaction_up_y"]**2 * 0.7e-3 * row["time"])[grown], steady, rtol=0.005)
    new = B * (row["crack_length"][-1] - row["crack_length"][grown][0])
    taken = row["cohesive_energy"][-1] - row["cohesive_energy"][grown][0]
    assert taken == pytest.approx(300.0 * new, rel=0.03)              # a step of the tip is a point of the cohesion, that of a zone that it leaves behind
    assert np.max(np.abs(row["numerical_loss"])) < 2e-3 * row["external_work"][-1]


@pytest.mark.parametrize(("mode_II", "law", "toughness"), [
    (1.0, "strength = 10e6  toughness = 300.0  strength_shear = 30e6  toughness_shear = 900.0", 900.0), (0.5, "strength = 20e6  toughness = 400.0", 400.0)], ids=["II", "mixed"])
def test_couples_of_any_mode_part_the_arms_at_the_toughness(hampm, tmp_path, mode_II, law, toughness):
    """Where both modes take the same the law has a potential: J is the toughness for all mixtures. The load at which the tip moves lies between two load steps."""
    opening = ((1 - mode_II) * toughness * E * INERTIA * B)**0.5
    sliding = (mode_II * toughness * 4 / 3 * E * INERTIA * B)**0.5
    history = "history = 'table'  times = 0.0, 0.5, 1.0  factors = 0.0, 0.95, 0.995"
    stays = run(hampm, beam(couples(opening + sliding, opening - sliding, history), law))
    assert stays["crack_length"][-1] == stays["crack_length"][0]
    history = "history = 'table'  times = 0.0, 0.5, 1.0  factors = 0.0, 0.99, 1.02"
    (tmp_path / "out.nml").write_text(beam(couples(opening + sliding, opening - sliding, history), law, method="time = 'static'  load_steps = 8"))
    goes = hampm("out.nml", "--force", "--quiet", timeout=300)
    with h5py.File(tmp_path / "out.h5") as file:
        assert goes.returncode == 3 or file["history/crack_length"][-1] > stays["crack_length"][0] + 5e-3


@pytest.mark.parametrize(("mode_II", "strength"), [(0.15, 17.3e6), (0.5, 12e6), (0.5, 30e6), (0.8, 17.3e6)])
def test_mixed_modes_by_benzeggagh_and_kenane(hampm, mode_II, strength):
    """Ends of both arms are turned. Moments and axial forces by reactions, G of both modes of these by beam theory: while the tip moves on their sum is the toughness of
    their mix, whatever the strengths, though in a zone of two to four arms the faces first open and then slide. Where the tip begins to move it is up to 4 % less: the zone that
    grows there has another history."""
    toughness = 300 + 600 * mode_II**1.5
    turns = np.array([[1, 1], [1, -1]]) @ [((1 - mode_II) * toughness / E / INERTIA * B)**0.5 * 35e-3, (mode_II * toughness * 4 / 3 / E / INERTIA * B)**0.5 * 45e-3]
    history = "history = 'table'  times = 0.0, 0.2, 1.0  factors = 0.0, 0.65, 1.0"
    loads = "".join(f"&constraint name = '{name}{part}'  lower = 0.0, {sense * part * H / 4}  upper = 0.0, {sense * part * H / 4}  fix = 'x'"
                    f"  displacement = {(part - 2) * turn * H / 4}, 0.0  {history} /\n" for name, sense, turn in zip(("up", "down"), (1, -1), turns) for part in (1, 3))
    row = run(hampm, beam(loads, f"strength = 10e6  toughness = 300.0  strength_shear = {strength}  toughness_shear = 900.0  exponent = 1.5", length=75e-3))
    moment, axial = ([(row[f"reaction_{name}3_x"] + sign * row[f"reaction_{name}1_x"]) for name in ("up", "down")] for sign in (-1, 1))
    opening, sliding, pull = (moment[0] + moment[1]) * H / 8, (moment[0] - moment[1]) * H / 8, (axial[0] - axial[1]) / 2
    mode = [opening**2 / (E * INERTIA * B), (sliding**2 / (E * INERTIA) + pull**2 / (E * B * H) - (2 * sliding + pull * H)**2 / (16 * E * INERTIA)) / B]
    steady = row["crack_length"] > row["crack_length"][0] + 4e-3
    assert np.count_nonzero(steady) > 2
    ratio = (sum(mode) / (300 + 600 * (mode[1] / np.maximum(sum(mode), 1e-9))**1.5))[steady]
    assert np.allclose(ratio, 1.0, atol=0.01), ratio


def test_an_end_notched_flexure_specimen(hampm):
    """Three points bend a beam whose arms press on each other. What the load and its way tell by compliance (corrected by that at first, Moura et al. 2006: u/P = (3 a**3 + 2 L**3)/(8 E b h**3)
    + 3 L/(10 mu b h), G = 9 P**2 a**2/(16 E b**2 h**3)) is the toughness of sliding while the tip moves on."""
    half, a, most = 60e-3, 42e-3, 1.85e-3
    loads = "".join(f"&constraint name = '{name}'  lower = {x}, {y}  upper = {x}, {y}  fix = '{fix}'  displacement = 0.0, {way}  history = 'table'"
                    f"  times = 0.0, 0.1, 0.2, 1.0  factors = 0.0, 0.02, 0.93, 1.0 /\n"
                    for name, x, y, fix, way in (("left", 3e-3, -H, "y", 0.0), ("right", 3e-3 + 2 * half, -H, "xy", 0.0), ("pin", 3e-3 + half, H, "y", -most)))
    text = beam(loads, "strength = 30e6  toughness = 300.0  strength_shear = 50e6  toughness_shear = 900.0", length=2 * half + 6e-3, a=a + 4e-3, contact="contact = 'frictionless'")
    row = run(hampm, "".join(line for line in text.splitlines(True) if not line.startswith("&constraint lower")))
    force, way = -row["reaction_pin_y"], most * np.interp(row["time"], [0.0, 0.1, 0.2, 1.0], [0.0, 0.02, 0.93, 1.0])
    compliance = way[1:] / force[1:] - 3 * half / (10 * E / 2.6 * B * H)
    modulus = (3 * a**3 + 2 * half**3) / (8 * B * H**3 * compliance[0])
    assert modulus == pytest.approx(E, rel=0.02)
    length = np.cbrt((8 * modulus * B * H**3 * compliance - 2 * half**3) / 3)
    grown = row["crack_length"][1:] > row["crack_length"][0] + 0.3e-3
    assert np.count_nonzero(grown) >= 2
    assert np.allclose((9 * (force[1:] * length)**2 / (16 * modulus * B**2 * H**3))[grown], 900.0, rtol=0.01)


RUBS = {"static": ("static'  load_steps = 50", ""), "zz": ("static'  load_steps = 50", "&refine indicator = 'zz'  tolerance = 1e-3  max_level = 1 /"), "implicit": ("implicit'  time_step = 0.02", "")}


@pytest.mark.parametrize("how", RUBS)
def test_faces_that_have_parted_rub(hampm, how):
    """A block is pressed onto another one and moved along it until cohesion has let go: the rest is Coulomb's friction, and loss is force by way."""
    text = f"""&run plane = 'stress'  thickness = 1e-3  end_time = 1.0 /
&grid lower = -2e-3, -1e-3  cell = 1e-3  cells = 14, 6 /
&material name = 'a'  young = 1e9  poisson = 0.0  density = 1000 /
&body material = 'a'  lower = 0.0, 0.0  upper = 10e-3, 4e-3 /
&constraint lower = 0.0, 0.0  upper = 10e-3, 0.0  fix = 'xy' /
&constraint name = 'top'  lower = 0.0, 4e-3  upper = 10e-3, 4e-3  fix = 'x'  displacement = 1e-4, 0.0  history = 'table'  times = 0.0, 0.1, 1.0  factors = 0.0, 0.0, 1.0 /
&constraint name = 'press'  lower = 0.0, 4e-3  upper = 10e-3, 4e-3  fix = 'y'  displacement = 0.0, -4e-6  history = 'ramp'  rise_time = 0.1 /
&method time = '{RUBS[how][0]} /
{RUBS[how][1]}
&crack kind = 'path'  name = 'a'  points = -1e-3, 2.3e-3, 11e-3, 2.3e-3  contact = 'friction'  friction = 0.3 /
&cohesive crack = 'a'  strength = 1e6  toughness = 20.0 /
&energy_release energy_balance = .true. /
&output file = 'out.h5' /
"""
    row = run(hampm, text)
    assert row["cohesive_energy"][-1] == pytest.approx(20.0 * 10e-6, rel=1e-3)
    rubs = np.flatnonzero(row["time"] > 0.7)                           # all of it slides
    assert np.count_nonzero(rubs) > 10
    assert np.allclose(row["reaction_top_x"][rubs], -0.3 * row["reaction_press_y"][rubs], rtol=2e-3 if how == "implicit" else 1e-6)
    way = 1e-4 / 0.9 * np.diff(row["time"][rubs])
    assert np.allclose(np.diff(row["friction_loss"][rubs]), way * row["reaction_top_x"][rubs][1:], rtol=0.01)


@pytest.mark.parametrize("method", ["time = 'implicit'  time_step = 4e-5", "time = 'explicit'"], ids=["implicit", "explicit"])
def test_a_beam_that_splits_in_motion(hampm, method):
    """Slowly enough J at the tip that moves is the toughness, at 3 cells to the zone to 2 %; the energy is closed."""
    end = 1e-3 if "explicit" in method else 4e-3
    row = run(hampm, beam(ends(0.4e-3, end), "strength = 60e6  toughness = 300.0", cell=0.5e-3, length=60e-3, a=21e-3, method=method, radii=2.5e-3, end=end,
                                    output=f"history_interval = {end / 50}"))
    grown = row["crack_length"] > row["crack_length"][0] + 0.5e-3
    assert np.count_nonzero(grown) > 10
    assert np.mean(row["J"][grown]) == pytest.approx(300.0, rel=0.02)
    taken = row["cohesive_energy"][-1] - row["cohesive_energy"][grown][0]
    assert taken == pytest.approx(300.0 * B * (row["crack_length"][-1] - row["crack_length"][grown][0]), rel=0.05)
    balance = row["external_work"] - row["strain_energy"] - row["kinetic_energy"] - row["cohesive_energy"] - row["numerical_loss"]
    assert np.max(np.abs(balance - balance[0])) < 1e-9 * row["external_work"][-1]
    assert np.max(np.abs(row["numerical_loss"])) < 2e-3 * row["external_work"][-1]


@pytest.mark.parametrize("refine", ["indicator = 'tip'  rings = 6", "indicator = 'zz'  tolerance = 0.05", "indicator = 'gradient'"], ids=["tip", "zz", "gradient"])
@pytest.mark.parametrize("method", ["time = 'static'  load_steps = 20", "time = 'implicit'  time_step = 2e-4", "time = 'explicit'"], ids=["static", "implicit", "explicit"])
def test_damage_stays_on_finer_cells(hampm, method, refine):
    """What has been taken and the length of the crack are those of cells that are fine from the start."""
    end = {"s": 1.0, "e": 1e-3, "i": 4e-3}[method[8]]
    text = beam(ends(0.4e-3, end), "strength = 60e6  toughness = 300.0", cell=0.5e-3, length=60e-3, a=21e-3, method=method, radii=2.5e-3, end=end,
                output="" if end == 1.0 else f"history_interval = {end / 20}")
    fine = run(hampm, text)
    text = text.replace("cell = 0.0005  cells = 124, 16", "cell = 0.001  cells = 64, 8").replace("lower = -0.001, -0.004", "lower = -0.002, -0.004")
    refined = run(hampm, text.replace("&output", f"&refine {refine}  max_level = 1 /\n&output"))
    assert refined["cells"][-1] < fine["cells"][-1]
    assert np.all(np.diff(refined["cohesive_energy"]) >= -1e-15)
    assert refined["crack_length"][-1] == pytest.approx(fine["crack_length"][-1], abs=0.6e-3)
    assert refined["cohesive_energy"][-1] == pytest.approx(fine["cohesive_energy"][-1], rel=0.04)


def test_a_resumed_run_has_the_bytes_of_an_unbroken_one(hampm, tmp_path):
    text = beam(ends(0.3e-3), "strength = 60e6  toughness = 300.0", cell=0.5e-3, length=40e-3, a=16e-3, radii=2.5e-3, output="checkpoint_steps = 3", method="time = 'static'  load_steps = 8",
                more="&refine indicator = 'zz'  max_level = 1 /")
    (tmp_path / "whole.nml").write_text(text.replace("out.h5", "whole.h5"))
    (tmp_path / "out.nml").write_text(text)
    assert hampm("whole.nml").returncode == 0
    assert hampm("out.nml", "--steps", "5").returncode == 5
    assert hampm("--resume", "out.h5.checkpoint").returncode == 0
    assert not differing(tmp_path / "whole.h5", tmp_path / "out.h5")


def test_mirror_images_part_alike(hampm):
    """In both modes, to 1e-9 of the largest value."""
    opening, sliding = (150.0 * E * INERTIA * B)**0.5, (150.0 * E * INERTIA * B)**0.5
    law = "strength = 10e6  toughness = 300.0  strength_shear = 20e6  toughness_shear = 500.0  exponent = 1.5"
    one = run(hampm, beam(couples(opening + sliding, opening - sliding), law))
    other = run(hampm, beam(couples(opening - sliding, opening + sliding), law))
    assert one["zone_length"][-1] > 1e-3
    for name in ("J", "zone_length", "cohesive_energy", "strain_energy", "external_work", "K_I"):
        assert np.allclose(one[name], other[name], rtol=1e-9, atol=1e-9 * np.max(np.abs(one[name]))), name
    assert np.allclose(one["K_II"], -other["K_II"], rtol=1e-9, atol=1e-9 * np.max(np.abs(one["K_II"])))


@pytest.mark.parametrize("refine", ["", "&refine indicator = 'tip'  rings = 6  max_level = 1 /", "&refine indicator = 'zz'  max_level = 1 /"], ids=["uniform", "tip", "zz"])
@pytest.mark.parametrize("time", ["static'  load_steps = 16", "implicit'  time_step = 2e-4", "explicit'"], ids=["static", "implicit", "explicit"])
def test_half_of_a_beam_parts_from_its_mirror_image(hampm, time, refine):
    """J, the tip, zone and forces are those of the whole, its energies half of them: of either half, a crack on their symmetry plane. Faces that jump from point to point do so a little
    sooner or later; explicit steps are of other lengths."""
    if refine and time[0] != "s":
        pytest.skip("once is enough")
    end = {"s": 1.0, "e": 5e-4, "i": 4e-3}[time[0]]
    whole = beam(ends(0.4e-3, end), "strength = 60e6  toughness = 300.0", cell=0.5e-3, length=40e-3, a=11e-3, method=f"time = '{time}", radii=2.5e-3, end=end, more=refine,
                 output="" if end == 1.0 else f"history_interval = {end / 20}")
    rows = {"whole": run(hampm, whole)}
    for half, lower, upper, name, other in (("upper", 0.0, 3e-3, "up", "down"), ("lower", -3e-3, 0.0, "down", "up")):
        lines = [line for line in whole.splitlines(True) if f"name = '{other}'" not in line]
        text = "".join(lines).replace("lower = 0.04, -0.003  upper = 0.04, 0.003", f"lower = 0.04, {lower}  upper = 0.04, {upper}")
        text = text.replace("lower = 0.0, -0.003  upper = 0.04, 0.003", f"lower = 0.0, {lower}  upper = 0.04, {upper}").replace("crack = 'a'  from = 0.011  ", "")
        text = text.replace("kind = 'path'  name = 'a'  points = -1e-3, 0.0, 0.034, 0.0", "kind = 'symmetry'  tip = 0.01, 0.0")
        rows[half] = run(hampm, text.replace("&method", "&constraint name = 'plane'  lower = 0.01, 0.0  upper = 0.034, 0.0  fix = 'y' /\n&method"))
    assert rows["whole"]["tip_x"][-1] > 12e-3
    for half in ("upper", "lower"):
        for name, part in (("J", 1.0), ("tip_x", 1.0), ("zone_length", 1.0), ("root_opening", 1.0), ("K_I", 1.0), ("cohesive_energy", 0.5), ("strain_energy", 0.5), ("external_work", 0.5)):
            assert np.allclose(rows[half][name], part * rows["whole"][name], rtol=0, atol=(0.03 if time[0] == "e" else 1e-3) * np.max(np.abs(rows["whole"][name]))), (half, name)


@pytest.mark.parametrize("method", ["", "&method time = 'implicit'  time_step = 2e-7 /"], ids=["explicit", "implicit"])
def test_beside_a_crack_that_grows(hampm, method):
    """One crack runs by a toughness, another one parts by cohesion: each has its columns, and the energy is closed."""
    text = f"""&run plane = 'strain'  end_time = 1e-5  thickness = 0.01 /
&grid lower = -10e-3, -12e-3  cell = 1e-3  cells = 20, 24 /
&material name = 'a'  young = 200e9  poisson = 0.3  density = 8000 /
&body material = 'a'  lower = -10e-3, -10e-3  upper = 10e-3, 10e-3 /
&load kind = 'traction'  lower = -10e-3, 10e-3  upper = 10e-3, 10e-3  force = 0.0, 16e3 /
&load kind = 'traction'  lower = -10e-3, -10e-3  upper = 10e-3, -10e-3  force = 0.0, -16e3 /
{method}
&crack kind = 'path'  name = 'g'  points = -6.3e-3, 2.1e-3, -1.1e-3, 3.3e-3 /
&crack kind = 'path'  name = 'h'  points = 0.7e-3, -4.1e-3, 8.2e-3, -3.4e-3 /
&growth crack = 'g'  law = 'toughness'  toughness = 30  limit_speed = 2000 /
&cohesive crack = 'h'  from = 3e-3  strength = 300e6  toughness = 100 /
&energy_release estimators = 'domain_integral'  energy_balance = .true.  radii = 2e-3 /
&output file = 'out.h5'  history_interval = 2e-7 /
"""
    row = run(hampm, text)
    assert row["crack_length"][-1] > row["crack_length"][0] + 5e-3
    assert row["crack_length_tip3"][-1] > row["crack_length_tip3"][0] + 1e-4
    assert row["cohesive_energy"][-1] > 1e-3 and "zone_length_tip3" in row and "toughness_tip3" not in row
    assert "is the crack of a &growth" in run(hampm, text.replace("crack = 'h'  from", "crack = 'g'  from"), code=2)
    taken = row["cohesive_energy"] + row["fracture_energy"] + row["numerical_loss"]
    assert np.max(np.abs(row["external_work"] - row["strain_energy"] - row["kinetic_energy"] - taken)) < 1e-9 * np.max(row["external_work"])


OTHERS = {"large strains": ("law = 'neo_hookean'", 0.02), "yields": ("law = 'j2_plastic'  yield_stress = 1e13", 1e-6), "creeps": ("law = 'viscoelastic'  moduli = 1.0  relaxation_times = 1.0", 1e-6)}


@pytest.mark.parametrize("law", OTHERS)
def test_faces_of_any_material_part(hampm, law):
    """What hardly yields or creeps as what is elastic, and at large strains nearly so: arms turn by 0.04."""
    text = beam(ends(0.3e-3), "strength = 60e6  toughness = 300.0", cell=0.5e-3, length=40e-3, a=16e-3, method="time = 'static'  load_steps = 12", radii=2.5e-3)
    words, off = OTHERS[law]
    row, elastic = run(hampm, text.replace("name = 'a'  young", f"name = 'a'  {words}  young")), run(hampm, text)
    assert elastic["crack_length"][-1] > 19e-3
    for name in ("cohesive_energy", "reaction_up_y", "external_work"):
        assert np.max(np.abs(row[name] - elastic[name])) < off * np.max(np.abs(elastic[name])), name


def test_quadratic_cells(hampm):
    """J at the tip that moves on, at 1.5 cells to the zone to 2 %."""
    text = beam(ends(0.4e-3), "strength = 60e6  toughness = 300.0", cell=1e-3, length=60e-3, a=21e-3, method="time = 'static'  load_steps = 16", radii=2.5e-3)
    row = run(hampm, text.replace("cells = 64, 10", "cells = 64, 10  order = 2").replace("&body", "&body points_per_cell = 3 "))
    grown = row["crack_length"] > row["crack_length"][0] + 0.5e-3
    assert np.count_nonzero(grown) > 3
    assert np.allclose(row["J"][grown], 300.0, rtol=0.02)


def test_j_of_a_zone_has_the_same_digits_in_every_build(run_hampm, tmp_path):
    """Points outside of the domain count with 0 however a sum over nodes is rounded: in a release J of this beam was 0.02 to 14 % off. Detects change alone."""
    columns = []
    for name, program in (("release", PROGRAM), ("checked", CHECKED_PROGRAM)):
        run_hampm(INPUT / "dcb_cohesive.nml", "--steps", 3, "--quiet", "--threads", 1, "--output", name, cwd=tmp_path, program=program)
        with h5py.File(tmp_path / name / "dcb_cohesive.h5") as file:
            columns.append(file["history/J"][()])
    assert columns[0] == pytest.approx(columns[1], rel=1e-9) and columns[0][1] > 0.5
