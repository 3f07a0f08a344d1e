"""Cracks that grow at rest in a load frame: its displacement, its stiffness, snap-back, unloading."""

import math

import numpy as np
import pytest
from paths import ROOT

from harness import differing, run

DCB, CT = (ROOT / "input" / name for name in ("dcb_snap_back.nml", "compact_tension_growth.nml"))
E, B, H, TOUGHNESS, STIFFNESS = 70e9, 0.01, 0.01, 1.0, 0.5e6  # of the beam
LONGER = 0.673 * H  # by which beams with a root that turns are longer, from converged finite elements (tests/reference/growth/f1_dcb_growth_stress.csv)


def beam(a):
    """Load at which a double cantilever beam grows [N], and its compliance by beams that are longer [m/N]: 1 %."""
    return B * np.sqrt(TOUGHNESS * E * H**3 / 12) / (a + LONGER), 8 * (a + LONGER) ** 3 / (E * B * H**3)


def text(path):
    return path.read_text()


ARCS = {}  # of the bare scene, by increment: several tests ask for the same


def arc(hampm, increment):
    if increment not in ARCS:
        ARCS[increment] = grown(hampm, increment)
    return ARCS[increment]


def grown(hampm, increment, name="arc", control="&control\n   stiffness = 0.5e6", **more):
    s = text(DCB).replace("&control\n   stiffness = 0.5e6", control)
    steps = round(25e-3 / increment)
    return run(hampm, s.replace("increment = 2.5e-3", f"increment = {increment!r}"), f"method.load_steps={steps}", f"grid.cell={min(1e-3, increment)!r}", name=name, **more)


def controlled(displacement, history, stiffness="0.5e6", quantity="displacement"):
    given = f"displacement = {displacement!r}" if quantity == "displacement" else ""
    return f"&control\n   quantity = '{quantity}'  {given}  history = 'table'  {history}\n   stiffness = {stiffness}"


def test_a_beam_in_a_soft_frame_snaps_back(hampm):
    """The displacement of the frame falls and rises again, as that of beams on springs: q(a) = P(a) (C(a) + 1/k)."""
    row = arc(hampm, 2.5e-3)
    load, compliance = beam(row["crack_length"])
    print(row["load"] / load, row["load_displacement"] / row["load"] / compliance, row["frame_displacement"] / (load * (compliance + 1 / STIFFNESS)))
    assert row["load"] == pytest.approx(load, rel=0.011)
    assert row["load_displacement"] / row["load"] == pytest.approx(compliance, rel=0.01)
    assert row["frame_displacement"] == pytest.approx(load * (compliance + 1 / STIFFNESS), rel=0.011)
    assert row["frame_displacement"] == pytest.approx(row["load_displacement"] + row["load"] / STIFFNESS, rel=1e-12)
    least = np.argmin(row["frame_displacement"])
    a = np.linspace(0.03, 0.055, 1000)
    turns = a[np.argmin(beam(a)[0] * (beam(a)[1] + 1 / STIFFNESS))]
    assert 0 < least < len(row["load"]) - 1 and abs(row["crack_length"][least] - turns) < 2.5e-3
    assert np.all(np.diff(row["load"]) < 0) and not row.said


def test_energy_of_a_snap_back_closes(hampm):
    """The area under load over displacement of the frame is what beam and frame store and what the crack takes; what is missing beside what cells leave of G falls with the
    square of the increments."""
    missing = []
    for increment in (5e-3, 2.5e-3, 1.25e-3):
        row = arc(hampm, increment)
        work = np.sum((row["load"][1:] + row["load"][:-1]) / 2 * np.diff(row["frame_displacement"]))
        inside = row["strain_energy"] + row["frame_energy"]
        assert np.sum((row["load"][1:] + row["load"][:-1]) / 2 * np.diff(row["load_displacement"])) == pytest.approx(np.ptp(row["external_work"]), rel=1e-6)
        missing.append((work - inside[-1] + inside[0]) / (TOUGHNESS * B * np.ptp(row["crack_length"])) - 1)
        assert row["fracture_energy"][-1] == pytest.approx(TOUGHNESS * B * np.ptp(row["crack_length"]), rel=1e-5)
    order = math.log2((missing[0] - missing[1]) / (missing[1] - missing[2]))
    print(missing, order)
    assert order == pytest.approx(2, abs=0.25) and abs(missing[1]) < 0.005


def test_a_frame_that_moves_on_lets_the_crack_jump(hampm):
    """It begins to grow where the arc begins, and ends on the arc; what is lost on the way is the area between the arc and the fall of the load."""
    path = arc(hampm, 1.25e-3)
    end = float(path["frame_displacement"][0])
    row = grown(hampm, 1.25e-3, name="moved", control=controlled(end * 1.0001, "times = 0.0, 5.0, 10.0  factors = 0.0, 0.9995, 1.0"))
    just_before = np.searchsorted(row["crack_length"], row["crack_length"][0] + 1e-6) - 1
    assert row["frame_displacement"] == pytest.approx(end * 1.0001 * np.interp(row["time"], [0, 5, 10], [0, 0.9995, 1.0]), rel=1e-8, abs=1e-14)
    assert row["G"][just_before] == pytest.approx(TOUGHNESS, rel=2e-3) and row["crack_length"][-1] > 0.045
    # on the stable part of the arc, as an increment of which G is that of the cell that the tip is in allows
    later = slice(np.argmin(path["frame_displacement"]), None)
    assert row["load"][-1] == pytest.approx(np.interp(end * 1.0001, path["frame_displacement"][later], path["load"][later]), rel=0.01)
    assert row["G"][-1] == pytest.approx(TOUGHNESS, rel=0.02)
    lost = row["fracture_energy"][-1] - TOUGHNESS * B * np.ptp(row["crack_length"])
    part = path["frame_displacement"] <= end
    loop = -np.trapezoid(path["load"][part], path["frame_displacement"][part])
    print(lost / loop, row["crack_length"][-1], row["G"][-1])
    assert lost == pytest.approx(loop, rel=0.2)
    assert "runs by itself" in row.said


def test_unloading_a_compact_tension_specimen(hampm):
    """Load over displacement goes back along a line to 0, and again to where it was; its compliance is that of ASTM E1820 (load line, Saxena & Hudak 1978, 0.5 % at most)
    with what the holes give way, 2.1/(E' B), which is the same for all cracks. K_I is that of ASTM E399."""
    row = run(hampm, CT)
    modulus, thickness, width = 210e9 / (1 - 0.3**2), 25e-3, 50e-3
    rows = {time: k for k, time in enumerate(np.round(row["time"]).astype(int))}
    compliance = row["load_displacement"][1:] / row["load"][1:]
    assert row["load"][rows[14]] == pytest.approx(row["load"][rows[10]], rel=1e-9)
    assert compliance[rows[10] - 1:rows[14]] == pytest.approx(compliance[rows[10] - 1], rel=1e-9)
    assert np.ptp(row["crack_length"][rows[10]:rows[14] + 1]) == 0 and np.ptp((row["external_work"] - row["strain_energy"])[rows[10]:rows[14] + 1]) < 1e-9
    alpha = row["tip_x"][1:] / width
    astm = ((1 + alpha) / (1 - alpha)) ** 2 * np.polyval([-9.9314, 20.609, -0.9925, -20.065, 12.219, 2.163], alpha)
    holes = compliance * modulus * thickness - astm
    print(holes, np.diff(compliance * modulus * thickness) / np.diff(astm))
    assert holes[0] == pytest.approx(2.1, abs=0.15)
    assert compliance * modulus * thickness == pytest.approx(astm + holes[0], rel=0.01)
    factor = (2 + alpha) / (1 - alpha) ** 1.5 * np.polyval([-5.6, 14.72, -13.32, 4.64, 0.886], alpha)
    assert row["K_I"][1:] == pytest.approx(row["load"][1:] / (thickness * math.sqrt(width)) * factor, rel=0.015)
    grows = row["time"] > 14.5
    assert row["G"][grows] == pytest.approx(2e4, rel=0.01)


@pytest.mark.verify
def test_more_load_steps_go_the_same_way(hampm):
    """Where growth is stable, the end does not depend on how many rows there are, beside what K of a tip depends on its place in a cell."""
    coarse, fine = (run(hampm, text(CT), f"method.load_steps={n}", name=f"n{n}") for n in (9, 18))
    assert coarse["load"][-1] == pytest.approx(fine["load"][-1], rel=0.01)
    assert coarse["crack_length"][-1] == pytest.approx(fine["crack_length"][-1], abs=0.2e-3)


def test_grips_that_move_are_the_same_frame(hampm):
    """The ends of the arms are moved in place of pulled: load is their reaction, displacement what they are moved apart. Only how the end faces share the force is another."""
    s = text(DCB)
    i, j = s.index("&load"), s.index("&constraint")
    grips = "".join(f"&constraint\n   lower = 0.0, {low}\n   upper = 0.0, {high}\n   fix = 'y'\n   displacement = 0.0, {way}\n/\n"
                    for low, high, way in (("0.1e-3", "10.0e-3", "1.0e-5"), ("-10.0e-3", "-0.1e-3", "-1.0e-5")))
    pulled = run(hampm, s, "method.load_steps=4", name="pulled")
    moved = run(hampm, s[:i] + grips + s[j:], "method.load_steps=4", name="moved")
    for name, off in (("load", 0.01), ("load_displacement", 0.01), ("frame_displacement", 0.01), ("strain_energy", 0.01), ("external_work", 0.01)):
        print(name, moved[name] / pulled[name])
        assert moved[name] == pytest.approx(pulled[name], rel=off), name
    assert moved["load"] * moved["load_displacement"] / 2 == pytest.approx(moved["strain_energy"], rel=1e-9)


def test_control_of_the_load(hampm):
    """Rows have the load that is given as long as the crack stays; then it runs to its max_length."""
    row = grown(hampm, 2.5e-3, control=controlled(0, "times = 0.0, 10.0  factors = 0.0, 25.0", quantity="load"), words=("--set", "growth.max_length=0.05"))
    given = 2.5 * row["time"]
    assert row["load"] == pytest.approx(given, rel=1e-9, abs=1e-12)
    assert np.all(row["crack_length"][given < 20.8] == pytest.approx(0.03)) and np.all(row["crack_length"][given > 20.9] > 0.0474)
    assert "runs by itself" in row.said


def test_held_loads_in_a_frame(hampm):
    """Weight-like forces on the arms stay: the frame's displacement begins with theirs, and load and displacement are those of the frame alone."""
    held = "&load\n   kind = 'traction'\n   lower = 0.0, 0.0\n   upper = 0.0, 10.0e-3\n   force = 0.0, {0}\n   held = .true.\n/\n" \
           "&load\n   kind = 'traction'\n   lower = 0.0, -10.0e-3\n   upper = 0.0, 0.0\n   force = 0.0, -{0}\n   held = .true.\n/\n"
    bare = run(hampm, text(DCB), "method.load_steps=4", name="bare")
    with_it = run(hampm, text(DCB).replace("\n&control\n", "\n" + held.format(5.0) + "&control\n"), "method.load_steps=4", name="with")
    assert with_it["load"] == pytest.approx(bare["load"] - 5, rel=2e-5)
    assert with_it["load_displacement"] == pytest.approx(bare["load_displacement"], rel=1e-5)
    assert with_it["strain_energy"] == pytest.approx(bare["strain_energy"], rel=1e-5)


BENT = """&run plane = 'stress'  thickness = 0.01  end_time = 6.0 /
&grid lower = -2e-3, -2e-3  cell = 1e-3  cells = 84, 24 /
&material name = 'a'  young = 3e9  poisson = 0.3  density = 1200 /
&body material = 'a'  lower = 0.0, 0.0  upper = 80e-3, 20e-3 /
&constraint lower = 4e-3, 0.0  upper = 4e-3, 0.0  fix = 'xy' /
&constraint lower = 76e-3, 0.0  upper = 76e-3, 0.0  fix = 'y' /
&load kind = 'traction'  lower = 38e-3, 20e-3  upper = 42e-3, 20e-3  force = 0.0, -100.0 /
&crack kind = 'path'  points = 34e-3, -1e-3, 34e-3, 9e-3 /
&growth direction = '{direction}'  toughness = 100.0  increment = 1.5e-3 /
&control quantity = 'displacement'  displacement = 0.25e-3  stiffness = 1e7  history = 'ramp'  rise_time = 6.0 /
&refine indicator = 'tip'  max_level = 2  rings = 8 /
&method time = 'static'  load_steps = 6 /
&energy_release estimators = 'domain_integral'  energy_balance = .true. /
&output file = 'out.h5' /
"""


@pytest.mark.parametrize("direction", ["hoop_stress", "local_symmetry", "max_energy"])
def test_a_crack_that_turns_under_a_load_that_moves(hampm, direction):
    """A bent beam with a notch aside: the crack turns to the load; no row is above the toughness but by the place of the tip in its cell."""
    s = BENT.format(direction=direction)
    row = run(hampm, s)
    print(row["load"], row["frame_displacement"], row["crack_length"], row["G"], row["tip_angle"])
    assert row["crack_length"][-1] > row["crack_length"][0] + 4e-3 and abs(row["tip_angle"][-1] - 90) > 3
    assert row["frame_displacement"] == pytest.approx(0.25e-3 * row["time"] / 6, rel=1e-8, abs=1e-14)
    grown = row["crack_length"] > row["crack_length"][0] + 1e-6
    assert np.all(row["G"] < 102.0) and np.all(row["G"][grown] > 84.5)  # an increment that turns has two of the finest cells at least
    if direction == "local_symmetry":
        assert np.all(np.abs(row["K_II"][np.diff(row["crack_length"], prepend=0) > 0][1:]) < 1.1e-3 * row["K_I"][-1])


def test_threads_and_scenes_that_are_refused(hampm):
    s = BENT.format(direction="hoop_stress")
    one, two = (run(hampm, s, "method.load_steps=3", words=("--threads", n), name=f"t{n}").path for n in ("1", "2"))
    assert not differing(one, two)
    for change, word in ((("force = 0.0, -100.0", "force = 0.0, -100.0  history = 'ramp'  rise_time = 1.0"), "history"),
                         (("displacement = 0.25e-3", ""), "displacement"), (("quantity = 'displacement'", "quantity = 'load'"), "displacement"),
                         (("fix = 'y' /", "fix = 'y'  displacement = 0.0, 1e-6 /"), "beside motions"),
                         (("&growth direction", "!"), "&growth")):
        assert word in run(hampm, s.replace(*change), code=2), change


@pytest.mark.verify
def test_an_end_loaded_split_specimen_snaps_back(hampm):
    """Load and displacement of beams with sliding arms, P = sqrt(4 G E B**2 h**3/9)/a and u = P (3 a**3 + L**3)/(2 E B h**3) + 1.2 P L/(2 mu B h), with a longer by 0.28 h (Wang &
    Williams 1992); the displacement is least at a = L/6**(1/3). What the load works less what is stored is toughness times area."""
    row = run(hampm, (ROOT / "input/els.nml").read_text(), "growth.increment=12e-3", "method.load_steps=3", "run.end_time=3.0", "output.snapshot_interval=0")
    young, width, depth, length, toughness = 70e9, 0.01, 3e-3, 0.1, 100.0
    a, work, stored = row["tip_x"], row["external_work"], row["strain_energy"]
    longer = a + 0.28 * depth
    load = math.sqrt(4 * toughness * young * width**2 * depth**3 / 9) / longer
    way = load * ((3 * longer**3 + length**3) / (2 * young * width * depth**3) + 1.2 * length / (2 * young / 2.6 * width * depth))
    released = (np.diff(work) - np.diff(stored)) / (toughness * width * np.diff(a))
    print("load", row["load"] / load, "displacement", row["load_displacement"] / way, "released", released)
    assert row["load"] == pytest.approx(load, rel=0.013)
    assert row["load_displacement"] == pytest.approx(way, rel=0.008)
    assert np.argmin(row["load_displacement"]) == 2 and a[2] == pytest.approx(length / 6**(1 / 3), rel=0.02)
    assert released == pytest.approx(np.ones(3), rel=0.08)                 # by steps of 12 mm, whose error falls with their square
    missing = work - stored - row["fracture_energy"] - row["numerical_loss"]
    assert np.abs(missing - missing[0]).max() < 1e-9 * work.max()


PARTS = """\
&run plane = '{plane}'  end_time = 4.0 /
&grid lower = 0.0, {low}  cell = 0.002  cells = 22, {cells} /
&material name = 'm'  young = 70e9  poisson = 0.3  density = 2700.0 /
&body material = 'm'  lower = 0.0, {low}  upper = 0.04, 0.04 /
&load kind = 'traction'  lower = 0.0, 0.04  upper = 0.04, 0.04  force = 0.0, 1e4 /
{rest}
&method time = 'static'  load_steps = 4 /
&energy_release estimators = 'domain_integral'  energy_balance = .true. /
&growth direction = 'straight'  toughness = 100.0  increment = 0.001 /
&control quantity = 'displacement'  displacement = 1e-4  history = 'ramp'  rise_time = 4.0  {stiffness} /
"""
HALF = """&constraint lower = 0.01, 0.0  upper = 0.04, 0.0  fix = 'y' /
&crack kind = 'symmetry'  tip = 0.01, 0.0 /
&refine indicator = 'tip'  max_level = 2  rings = 6 /"""
WHOLE = """&constraint lower = 0.0, -0.04  upper = 0.04, -0.04  fix = 'xy' /
&crack kind = 'path'  points = 0.0, 0.001, 0.01, 0.001 /
&refine indicator = 'tip'  max_level = 2  rings = 6 /"""


@pytest.mark.parametrize("plane, rest, stiffness", [("axisymmetric", HALF, ""), ("stress", HALF, ""), ("strain", WHOLE, ""), ("stress", WHOLE, "stiffness = 1e11")],
                         ids=["ring", "half", "path", "frame that gives way"])
def test_a_body_that_parts_under_a_displacement_bears_no_load(hampm, plane, rest, stiffness):
    """The piece goes with the load frame, which does no work on it, and the run goes on to its end."""
    rows = run(hampm, PARTS.format(plane=plane, rest=rest, stiffness=stiffness, low=0.0 if rest == HALF else -0.04, cells=22 if rest == HALF else 42))
    parted = rows["time"] >= rows["separated"]
    assert rows["time"][-1] == pytest.approx(4.0) and parted[-1]
    assert abs(rows["load"][parted]).max() == 0
    assert rows["frame_displacement"] == pytest.approx(2.5e-5 * rows["time"], abs=1e-12)
    assert abs(rows["strain_energy"][parted]).max() < 1e-12 * rows["external_work"].max()
    assert np.ptp(rows["external_work"][parted]) == 0 < rows["external_work"][-1]
