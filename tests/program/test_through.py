"""Tips that run through to a surface, a hole or another crack, at rest and in motion: what the crack is then, what the pieces do, and what is kept."""

import sys

import h5py
import numpy as np
import pytest

from harness import datasets, run, run_told
from paths import BENCH
from snapshots import field, points, read_steps

sys.path.insert(0, str(BENCH))

from cracks import scene  # noqa: E402


def at_rest(cracks, steps, increment=1e-3, direction="straight", tips="all", levels=1, more=""):
    """A plate of 40 by 80 mm under tension with cracks that grow."""
    text = scene(cracks, 1e-3, (0.02, 0.04), levels=levels, sigma=1e6)
    text = text.replace("time = 'static'", f"time = 'static'  load_steps = {steps}") + more
    for k in range(len(cracks)):
        text = text.replace("\n&crack kind", f"\n&crack name = 'c{k}'  kind", 1)
        text += f"&growth crack = 'c{k}'  direction = '{direction}'  toughness = 100.0  increment = {increment}  tips = '{tips}' /\n"
    return text


# At rest

def test_a_crack_that_parts_a_plate(hampm):
    """Both tips run to the surfaces in one load step. The pieces have no equilibrium under their loads: the run ends there, and says so."""
    row, said = run_told(hampm, at_rest([[(-5e-3, 0.0), (5e-3, 0.0)]], 9, increment=2e-3, levels=0))
    assert "tip 1 has run through to a surface: its crack ends there, at (0.02, 0.0) m" in said
    assert "tip 2 has run through to a surface: its crack ends there, at (-0.02, 0.0) m" in said
    assert "separated at t = 0.777778 s: all material is in 2 pieces, in 1 at the start" in said
    assert "the run ends before end_time, as pieces have no equilibrium" in said
    assert len(row["time"]) == 7 and row["crack_length"][-1] == pytest.approx(34e-3)
    assert row["ended"] == "done" and row["separated"] == pytest.approx(7 / 9)


def test_pieces_that_are_held_stay(hampm):
    """Where constraints hold both pieces the run goes on: nothing is stored in them, and G of a tip that is none is no number."""
    text = at_rest([[(-20e-3, 0.0), (9e-3, 0.0)]], 8, increment=2e-3, levels=0).replace("&load kind = 'traction'", "&constraint")
    text = text.replace("force = 0.0, 40.0", "fix = 'xy'  displacement = 0.0, 1e-5").replace("force = 0.0, -40.0", "fix = 'xy'")
    row, said = run_told(hampm, text)
    assert "separated at t = 0.625 s" in said and "no equilibrium" not in said
    assert len(row["time"]) == 9 and row["tip_x"][-4:] == pytest.approx(0.02)
    assert np.isnan(row["G"]).tolist() == [False] * 5 + [True] * 4
    assert row["G"][:5] == pytest.approx(100.0)
    assert np.max(row["strain_energy"][-2:]) < 1e-20 * row["strain_energy"][0]
    assert row["fracture_energy"][-1] == pytest.approx(100.0 * 11e-3 * 1e-3, rel=1e-6)


def test_two_cracks_that_merge_are_one(hampm):
    """The inner tips of two cracks in a line meet. From there on the loads are those of one crack of their length from the start."""
    row, said = run_told(hampm, at_rest([[(-10e-3, 0.0), (-4e-3, 0.0)], [(4e-3, 0.0), (10e-3, 0.0)]], 3, increment=2e-3, levels=0))
    one, _ = run_told(hampm, at_rest([[(-14e-3, 0.0), (14e-3, 0.0)]], 1, increment=2e-3, levels=0), name="one")
    assert "tip 4 has run through to crack 'c0': its crack ends there, at (0.0, 0.0) m" in said and "tip 1 has ended: another crack has come to it" in said
    assert "separated" not in said
    assert row["load_factor"][-2:] == pytest.approx(one["load_factor"], rel=1e-9)
    assert row["strain_energy"][-2:] == pytest.approx(one["strain_energy"], rel=1e-9)
    assert np.isnan(row["G"][-2:]).all() and row["G_tip3"][-2:] == pytest.approx(100.0)


def test_a_tip_at_a_surface_leaves_an_edge_crack(hampm):
    """One tip runs to the surface; from there on the crack is an edge crack, but for the radii of its domains, which are those of the start."""
    row, said = run_told(hampm, at_rest([[(3e-3, 0.0), (13e-3, 0.0)]], 5, increment=2e-3, tips="largest", levels=0))
    at = np.flatnonzero(np.isnan(row["G"]))[0]
    edge, _ = run_told(hampm, at_rest([[(row["tip_x_tip2"][at], 0.0), (20e-3, 0.0)]], 1, increment=2e-3, levels=0), name="edge")
    assert "tip 1 has run through to a surface" in said
    assert row["load_factor"][at:at + 2] == pytest.approx(edge["load_factor"][:2], rel=1e-4)


def test_cracks_that_pass_each_other_cut_out_a_lens(hampm):
    """Two cracks pass each other, turn, and meet each the flank of the other one: the piece between them is cut out of the plate."""
    cracks = [[(-20e-3, -1.6e-3), (-6e-3, -1.6e-3)], [(20e-3, 1.6e-3), (6e-3, 1.6e-3)]]
    text = at_rest(cracks, 20, increment=1.2e-3, direction="hoop_stress", levels=2)
    text = text.replace("lower = -0.021, -0.041", "lower = -0.021, -0.023").replace("cells = 42, 82", "cells = 42, 46").replace("0.04", "0.02")
    row, said = run_told(hampm, text)
    assert "all material is in 3 pieces, in 1 at the start" in said
    assert "tip 1 has run through to crack 'c1'" in said and "tip 2 has run through to crack 'c0'" in said
    assert row["tip_x_tip2"] == pytest.approx(-row["tip_x"], abs=1e-9) and row["tip_y_tip2"] == pytest.approx(-row["tip_y"], abs=1e-9)


def ends_at_its_load(row, toughness=100.0):
    """No row in which a tip still exists has more than the toughness, but for what K varies by with the place of a tip in its cell: a frame that moves lets tips grow."""
    rate = row["G"][np.isfinite(row["G"])]
    print(rate[-4:], row["tip_x"][-4:])
    assert np.max(rate) < 1.02 * toughness


MOVED = "&control quantity = 'displacement'  displacement = {most}  history = 'table'  times = 0.0, 1.0  factors = 0.0, 1.0 /\n"


@pytest.mark.parametrize("drive", ("loads", "frame", "cycles"))
def test_a_tip_does_not_step_over_another_crack(hampm, drive):
    """An increment of four of the finest cells from two of them before another crack to two behind it, where a domain has room again. With a frame a tip rested on a side with
    2.3 to 60 times its toughness, as what had run through was taken back."""
    text = at_rest([[(-20e-3, 0.1e-3), (-8e-3, 0.1e-3)], [(5e-3, -8e-3), (5e-3, 8e-3)]], 16, increment=2e-3)
    text = text[:text.rindex("&growth")] + (MOVED.format(most=1e-4) if drive == "frame" else "")
    if drive == "cycles":
        text = text.replace("increment = 0.002", "increment = 2e-3  law = 'fatigue'  rate_constant = 1e-29  rate_exponent = 3.0").replace("toughness = 100.0", "toughness = 1e6")
        text += "&cycles ratio = 0.1 /\n"
    row, said = run_told(hampm, text)
    assert "tip 1 has run through to crack 'c1': its crack ends there, at (0.005, 1.0e-4) m" in said
    assert row["tip_x"][-1] == pytest.approx(5e-3, abs=1e-9) and "separated" not in said
    if drive == "frame":
        ends_at_its_load(row)


@pytest.mark.parametrize("direction", ("straight", pytest.param("hoop_stress", marks=pytest.mark.verify)))
@pytest.mark.parametrize("contact", ("", "contact = 'frictionless'", "contact = 'friction'  friction = 0.3"))
def test_a_moved_piece_whose_faces_may_touch_parts(hampm, contact, direction):
    """Open faces hold nothing: a piece that a frame moves has no load from there on, and stores nothing. Faces that may touch seemed to balance it, with displacements
    of 1e7 m: the last increment was taken back, and the tip rested 2.7 mm before the surface with 1.2 times its toughness; or the run ended with exit code 3."""
    text = at_rest([[(-20e-3, 0.1e-3), (-8e-3, 0.1e-3)]], 16, increment=2e-3, direction=direction, more=MOVED.format(most=1e-4))
    row, said = run_told(hampm, text.replace("-0.008, 0.0001 /", f"-0.008, 0.0001  {contact} /"))
    parted = row["tip_x"] > 20e-3 * (1 - 1e-6)
    assert row["separated"] == pytest.approx(row["time"][parted][0], rel=1e-9)
    assert np.all(row["load"][parted] == 0) and np.max(row["strain_energy"][parted]) < 1e-12 * np.max(row["strain_energy"])
    ends_at_its_load(row)


@pytest.mark.parametrize("contact", ("contact = 'frictionless'", "contact = 'friction'  friction = 0.3"))
def test_loads_on_a_piece_whose_faces_may_touch_end_the_run(hampm, contact):
    """They have no balance, and that is said; exit code 0."""
    text = at_rest([[(-20e-3, 0.1e-3), (10e-3, 0.1e-3)]], 9, increment=2e-3)
    row, said = run_told(hampm, text.replace("0.01, 0.0001 /", f"0.01, 0.0001  {contact} /"))
    assert "separated at t = " in said and "the run ends before end_time, as pieces have no equilibrium" in said
    assert row["ended"] == "done" and np.max(np.abs(row["mouth_opening"])) < 1e-3


def half_at_rest(whole, hole=""):
    """An edge crack in a plate that is pulled apart, or the half above its plane."""
    low = -20e-3 if whole else 0.0
    text = f"""&run plane = 'strain'  end_time = 9.0 /
&grid lower = -22e-3, {1.1 * low}  cell = 1e-3  cells = 44, {44 if whole else 22} /
&material name = 'a'  young = 200e9  poisson = 0.3  density = 8000 /
&body material = 'a'  lower = -20e-3, {low}  upper = 20e-3, 20e-3 /
{hole}
&load kind = 'traction'  lower = -20e-3, 20e-3  upper = 20e-3, 20e-3  force = 0.0, 40e3 /
&constraint lower = 20e-3, 20e-3  upper = 20e-3, 20e-3  fix = 'x' /
&method time = 'static'  load_steps = 9 /
&refine indicator = 'tip'  max_level = 1  rings = 8 /
&growth direction = 'straight'  toughness = 100.0  increment = 2e-3 /
&energy_release estimators = 'domain_integral'  energy_balance = .true.  radii = 1.5e-3, 2e-3 /
&output history_interval = 1.0 /
"""
    if whole:
        return text + """&crack kind = 'path'  points = -20e-3, 0.0, 7e-3, 0.0 /
&load kind = 'traction'  lower = -20e-3, -20e-3  upper = 20e-3, -20e-3  force = 0.0, -40e3 /
&constraint lower = 20e-3, -20e-3  upper = 20e-3, -20e-3  fix = 'x' /
"""
    return text + "&crack kind = 'symmetry'  tip = 7e-3, 0.0 /\n&constraint lower = 7e-3, 0.0  upper = 20e-3, 0.0  fix = 'y' /\n"


def test_a_symmetry_crack_runs_to_the_end_of_its_plane(hampm):
    """Half a body gives what the whole one gives, and ends as that does."""
    half, said = run_told(hampm, half_at_rest(False))
    whole, _ = run_told(hampm, half_at_rest(True), name="whole")
    assert "separated at t = 7.0 s: nothing joins the half body to its mirror image" in said
    assert half["separated"] == whole["separated"] == 7.0
    assert len(half["time"]) == len(whole["time"]) == 7
    for name, times in (("load_factor", 1), ("G", 1), ("fracture_energy", 2), ("strain_energy", 2), ("external_work", 2)):
        assert times * half[name] == pytest.approx(whole[name], rel=1e-7), name


def edge_crack_load(length):
    """Force at which an edge crack in the plate of hole_growth.nml has 100 J/m2 (Tada, Paris & Irwin, The Stress Analysis of Cracks Handbook, 2.11, to 0.5 %)."""
    part = length / 40e-3
    angle = np.pi / 2 * part
    factor = np.sqrt(np.tan(angle) / angle) * (0.752 + 2.02 * part + 0.37 * (1 - np.sin(angle))**3) / np.cos(angle)
    return np.sqrt(200e9 * 100.0) / (factor * np.sqrt(np.pi * length)) * 40e-3 * 1e-3


def test_a_crack_runs_through_a_hole(hampm):
    """A crack runs into a hole and rests there; a small one at the other side of the hole waits until then, starts and parts the plate. Where the
    hole is not felt any more, from 4 mm behind it on, and until the last 2 mm the loads are those of an edge crack as long as both and the hole, to 1 %."""
    row, said = run_told(hampm, BENCH.parent / "input" / "hole_growth.nml")
    assert "tip 1 has run through to a surface" in said and "tip 2 has run through to a surface" in said
    assert "separated at t = " in said and "2 pieces" in said
    at = np.flatnonzero(np.isnan(row["G"]))[0]
    assert np.all(np.diff(row["crack_length_tip2"][:at + 1]) == 0) and np.all(row["G_tip2"][:at] < 30)
    assert row["G"][:at] == pytest.approx(100.0, rel=1e-6) and row["G_tip2"][at:] == pytest.approx(100.0, rel=1e-6)
    assert np.all(np.diff(row["crack_length_tip2"][at:]) > 0)
    assert np.hypot(row["tip_x"][-1], row["tip_y"][-1]) == pytest.approx(4e-3, rel=1e-4)  # where the edge of the hole is
    far = row["tip_x_tip2"] > 7.5e-3
    off = 40 * row["load_factor"][far] / edge_crack_load(20e-3 + row["tip_x_tip2"][far]) - 1
    print(off)
    assert len(off) > 8 and np.all(np.abs(off[:-2]) < 0.01)


# In motion

def residual(row):
    """What is missing in the energy balance, over the work."""
    inside = sum(row[name] for name in ("kinetic_energy", "strain_energy", "damping_loss", "numerical_loss", "fracture_energy", "friction_loss") if name in row)
    return np.max(np.abs(row["external_work"] - inside)) / np.max(row["external_work"])


GIVEN = "law = 'prescribed'  speed = 1800.0  start = 2e-6  direction = 'straight'"
BY_TOUGHNESS = "law = 'toughness'  toughness = 0.01  direction = 'straight'"
LEVEL = "&refine indicator = 'tip'  max_level = 1  rings = 6 /"


def in_motion(cracks, growth, method="", refine="", contact="none", end=10e-6, more="", snapshots=0.0):
    """A plate of 20 by 20 mm that is suddenly pulled at two edges by 20 kN; cracks are texts of points [mm] with the &growth of each."""
    text = f"""&run plane = 'strain'  end_time = {end} /
&grid lower = -10e-3, -10.5e-3  cell = 0.5e-3  cells = 40, 42 /
&material name = 'a'  young = 200e9  poisson = 0.3  density = 8000 /
&body material = 'a'  lower = -10e-3, -10e-3  upper = 10e-3, 10e-3 /
&load kind = 'traction'  lower = -10e-3, 10e-3  upper = 10e-3, 10e-3  force = 0.0, 20e3 /
&load kind = 'traction'  lower = -10e-3, -10e-3  upper = 10e-3, -10e-3  force = 0.0, -20e3 /
&method {method} /
{refine}
{more}
&energy_release estimators = 'domain_integral'  energy_balance = .true. /
&output history_interval = 2e-7  snapshot_interval = {snapshots} /
"""
    for k, (points_of, law) in enumerate(zip(cracks, growth, strict=True)):
        numbers = ", ".join(f"{x}e-3" for x in points_of)
        text += f"&crack kind = 'path'  name = 'c{k}'  points = {numbers}  contact = '{contact}' /\n"
        text += f"&growth crack = 'c{k}'  {law} /\n" if law else ""
    return text


SLANTED = [(-2.0, -1.0, 2.0, 1.0)]


def test_cells_that_refine_as_halves_part_leave_each_its_motion(hampm):
    """A slanted crack runs right through a plate whose ends are pulled: its halves fly apart as rigid bodies, and their own strains are a fiftieth of that. Particles beside the crack
    divide at the end, some on both sides of it, and each has the motion of its half."""
    row = run(hampm, """\
&run plane = 'strain'  end_time = 2e-5 /
&grid lower = -12e-3, -12e-3  cell = 2e-3  cells = 12, 12 /
&material name = 'a'  young = 200e9  poisson = 0.3  density = 8000 /
&body material = 'a'  lower = -10e-3, -10e-3  upper = 10e-3, 10e-3 /
&load kind = 'traction'  lower = -10e-3, 10e-3  upper = 10e-3, 10e-3  force = 0.0, 20e3 /
&load kind = 'traction'  lower = -10e-3, -10e-3  upper = 10e-3, -10e-3  force = 0.0, -20e3 /
&refine indicator = 'gradient'  r_crit = 1e-6  max_level = 1  start = 1.9e-5  interval = 1 /
&crack kind = 'path'  points = -12e-3, -3.6e-3, 12e-3, 3.6e-3 /
&output snapshot_interval = 2e-5 /
""")
    u = row["displacement"]
    x = row["x"] - u
    assert len(x) == 4 * 20**2
    for side in (1, -1):
        of = side * (x[:, 1] - 0.3 * x[:, 0]) > 0
        rigid = np.column_stack([np.ones(np.count_nonzero(of)), x[of]])
        off = u[of, 1] - rigid @ np.linalg.lstsq(rigid, u[of, 1], rcond=None)[0]
        assert np.max(np.abs(off)) < 0.05 * np.mean(side * u[of, 1])


@pytest.mark.parametrize(("law", "method", "refine", "contact"), [
    (GIVEN, "", "", "none"), (GIVEN, "mass = 'weighted'", LEVEL, "frictionless"), (GIVEN, "time = 'implicit'  time_step = 1e-7", "", "none"),
    (BY_TOUGHNESS, "", "", "none"), (BY_TOUGHNESS, "mass = 'consistent'", LEVEL, "none"), (BY_TOUGHNESS, "time = 'implicit'  time_step = 1e-7", "", "frictionless")])
def test_halves_fly_apart(hampm, law, method, refine, contact):
    """A crack in the middle runs to both sides of a plate. The energy balance closes, and once the halves are apart nothing but its load changes the
    momentum of each: by 20 kN."""
    row, said = run_told(hampm, in_motion(SLANTED, [law], method, refine, contact, snapshots=1e-6))
    print(residual(row), row["separated"], row["fracture_energy"][-1], row["integral_of_G"][-1])
    for tip, x in ((1, 0.01), (2, -0.01)):
        assert f"tip {tip} has run through to a surface: its crack ends there, at ({x}, {x / 2}) m" in said.replace("-5.0e-3", "-0.005").replace("5.0e-3", "0.005")
    assert "2 pieces, in 1 at the start" in said and 3e-6 < row["separated"] < 9e-6
    assert residual(row) < 1e-12
    assert row["crack_length"][-1] == pytest.approx(np.hypot(20e-3, 10e-3), rel=1e-8)
    assert row["tip_speed"][-1] == row["tip_speed_tip2"][-1] == 0
    if refine:                                   # whose particles are of several sizes
        return
    times, steps = read_steps(row.path)
    mass, momenta = 8000 * 0.25e-3**2, []
    for time, blocks in zip(times, steps, strict=True):
        if time < row["separated"]:
            continue
        x, data = points(blocks[0]), blocks[0].point_data
        x, velocity = x - field(data, "displacement"), field(data, "velocity")
        upper = x[:, 1] > x[:, 0] / 2
        momenta.append((time, mass * np.sum(velocity[upper, 1]), mass * np.sum(velocity[~upper, 1])))
    momenta = np.array(momenta)
    rates = np.diff(momenta[:, 1:], axis=0) / np.diff(momenta[:, :1], axis=0)
    print(rates)
    assert len(rates) > 0
    assert rates == pytest.approx(np.tile([20e3, -20e3], (len(rates), 1)), rel=1e-6)


@pytest.mark.parametrize("law", [GIVEN.replace("1800", "2400"), BY_TOUGHNESS])
@pytest.mark.parametrize("method", ["", "time = 'implicit'  time_step = 1e-7"])
def test_a_symmetry_crack_runs_to_the_end_of_its_plane_in_motion(hampm, law, method):
    """Half a body gives what the whole one gives with a path on the plane."""
    whole = in_motion([(-10.0, 0.0, -1.0, 0.0)], [law], method, end=8e-6)
    half = whole.replace("lower = -10e-3, -10.5e-3  cell = 0.5e-3  cells = 40, 42", "lower = -10e-3, 0.0  cell = 0.5e-3  cells = 40, 21")
    half = half.replace("&body material = 'a'  lower = -10e-3, -10e-3", "&body material = 'a'  lower = -10e-3, 0.0").replace(
        "&load kind = 'traction'  lower = -10e-3, -10e-3  upper = 10e-3, -10e-3  force = 0.0, -20e3", "&constraint lower = -1e-3, 0.0  upper = 10e-3, 0.0  fix = 'y'")
    half = half.replace("kind = 'path'  name = 'c0'  points = -10.0e-3, 0.0e-3, -1.0e-3, 0.0e-3", "kind = 'symmetry'  tip = -1e-3, 0.0").replace("crack = 'c0'", "")
    one, _ = run_told(hampm, whole, name="whole")
    row, said = run_told(hampm, half)
    assert "nothing joins the half body to its mirror image" in said and row["separated"] == pytest.approx(one["separated"], rel=1e-9)
    assert residual(row) < 1e-12
    for name, times in (("K_I", 1), ("J", 1), ("crack_length", 1), ("fracture_energy", 2), ("kinetic_energy", 2)):
        assert np.array_equal(np.isnan(row[name]), np.isnan(one[name]))
        assert np.nanmax(np.abs(times * row[name] - one[name])) < 1e-9 * np.nanmax(np.abs(one[name])), name


JOINED = (-10.0, -1.0, -6.0, -0.7), (0.0, -6.0, 0.0, 6.0)
HEAD_ON = (-10.0, -1.0, -6.0, -0.7), (-1.0, -0.325, 3.0, -0.025)


@pytest.mark.parametrize(("cracks", "growth", "method", "contact"), [
    (JOINED, (GIVEN, ""), "", "none"), (JOINED, (GIVEN, BY_TOUGHNESS), "mass = 'weighted'", "frictionless"),
    (HEAD_ON, (GIVEN, BY_TOUGHNESS), "", "none"), (HEAD_ON, (GIVEN, BY_TOUGHNESS), "time = 'implicit'  time_step = 1e-7", "none")])
def test_a_crack_runs_into_another(hampm, cracks, growth, method, contact):
    """From the side and, not quite in a line, to its tip: both are one crack then, the energy balance closes, and the order of cracks does not matter."""
    row, said = run_told(hampm, in_motion(cracks, growth, method, contact=contact))
    assert "has run through to crack 'c" in said
    assert residual(row) < 1e-12
    assert ("separated at" in said) == (cracks is HEAD_ON)
    other, _ = run_told(hampm, in_motion(cracks[::-1], growth[::-1], method, contact=contact).replace("'c0'", "'d'").replace("'c1'", "'c0'").replace("'d'", "'c1'"), name="other")
    assert other["fracture_energy"] == pytest.approx(row["fracture_energy"], rel=1e-6, abs=1e-9 * np.max(row["fracture_energy"]))
    assert other["tip_x_tip3"] == pytest.approx(row["tip_x"], abs=1e-9) and other["tip_x"] == pytest.approx(row["tip_x_tip2"], abs=1e-9)


def test_a_crack_that_runs_into_a_hole_waits_there(hampm):
    hole = "&body shape = 'circle'  center = 2e-3, 0.3e-3  radius = 3e-3  hole = .true. /"
    row, said = run_told(hampm, in_motion([(-10.0, -1.0, -6.0, -0.7), (2.0, 0.0, 6.5, 0.2)], [GIVEN, ""], more=hole))
    assert "tip 1 has run through to a surface" in said and "separated" not in said
    assert np.hypot(row["tip_x"][-1] - 2e-3, row["tip_y"][-1] - 0.3e-3) == pytest.approx(3e-3, rel=1e-4)
    assert residual(row) < 1e-12


@pytest.mark.parametrize(("text", "part"), [
    (in_motion(SLANTED, [GIVEN], "mass = 'weighted'", LEVEL, end=9e-6, snapshots=1e-6), (0.7, 0.78, 0.82, 0.95)),
    (in_motion(HEAD_ON, (GIVEN, BY_TOUGHNESS), end=6e-6), (0.5, 0.6, 0.8)),
    (in_motion(HEAD_ON, (GIVEN, BY_TOUGHNESS), "time = 'implicit'  time_step = 1e-7", end=6e-6), (0.5, 0.6, 0.8)),
    (at_rest([[(-10e-3, 0.0), (-4e-3, 0.0)], [(4e-3, 0.0), (10e-3, 0.0)]], 6), (0.5, 0.7, 0.9))], ids=["parts", "merges", "merges implicitly", "merges at rest"])
def test_a_run_goes_on_from_a_checkpoint(hampm, text, part):
    """Before a tip ends, when it has, and after the pieces have parted, on another number of threads: the same bytes."""
    row, _ = run_told(hampm, text, words=("--threads", "2"), name="whole")
    whole = datasets(hampm.folder / "whole.h5")
    for some in part:
        run_told(hampm, text, code=5, words=("--steps", str(int(some * row["step"][-1])), "--threads", "1"), name="part")
        assert hampm("--resume", "part.h5.checkpoint", "--quiet", "--threads", "1").returncode == 0
        found = datasets(hampm.folder / "part.h5")
        for name, values in whole.items():
            assert np.asarray(values).tobytes() == np.asarray(found[name]).tobytes(), (some, name)
        with h5py.File(hampm.folder / "part.h5") as file:
            assert file["history"].attrs["warnings"] == row["warnings"]
            assert file["history"].attrs.get("separated", -1) == row.others.get("separated", -1)


UNDER_A_BODY = """\
&run plane = 'strain'  end_time = 12.0e-6 /
&grid lower = -12e-3, -2e-3  cell = 1e-3  cells = 24, 20 /
&material name = 'a'  young = 70e9  poisson = 0.3  density = 2700 /
&body material = 'a'  lower = -8e-3, 0.0  upper = 8e-3, 8e-3  {part} /
&body material = 'a'  lower = -8e-3, 8e-3  upper = 8e-3, 16e-3  {part} /
&body material = 'a'  lower = 9e-3, 0.0  upper = 11e-3, 2e-3 /
&contact bodies = 'frictionless' /
&crack kind = 'path'  points = 0.0, -1e-3, 0.0, 4e-3 /
&growth law = 'prescribed'  speed = 600.0  direction = 'straight' /
&energy_release estimators = 'domain_integral'  radii = 2e-3  energy_balance = .true. /
&method frame = 'updated' /
"""


@pytest.mark.parametrize("part", ["", "contact_group = 'one'"])
def test_a_body_that_touches_another_one_is_not_ahead_of_its_crack(hampm, part):
    """The tip ends at the surface of its body after 4 mm, at 6.7 us, and parts it; where both are one part it goes on into the other one."""
    row, said = run_told(hampm, UNDER_A_BODY.format(part=part))
    print(row["tip_y"][-1], row["separated"] if not part else "")
    if part:
        assert "run through" not in said and row["tip_y"][-1] == pytest.approx(4e-3 + 600 * 12e-6, abs=1e-4)
    else:
        assert "run through to a surface: its crack ends there, at (0.0, 0.008) m" in said
        assert 4e-3 / 600 * (1 - 1e-6) < row["separated"] < (4e-3 + 3e-3) / 600  # two cells and more behind the last point its force is 0
