"""Toughness that depends on how far, how fast, where and in what modes a tip goes (docs/explanation/resistance.md), against closed forms."""

import math
import re

import numpy as np
import pytest

from harness import differing, run, run_told
from paths import REFERENCE, ROOT

CURVE = np.array([0, 2.5e-3, 5e-3, 7.5e-3, 10e-3]), np.array([100, 180, 240, 280, 300])


def input_of(name):
    return (ROOT / "input" / f"{name}.nml").read_text()


def beam_load(length, toughness):
    """Of a double cantilever beam whose G is the toughness, by beams that are longer by 0.673 arms."""
    return 0.01 * np.sqrt(toughness * 70e9 * 0.01**3 / 12) / (length + 6.73e-3)


def test_a_resistance_curve_at_rest(hampm):
    """G is the curve at each length, and the load that of beams, to 0.3 %; it rises and falls."""
    row, _ = run_told(hampm, input_of("dcb_r_curve"))
    resistance = np.interp(row["tip_x"] - 30e-3, *CURVE)
    off = 100 * row["load_factor"] / beam_load(row["tip_x"], resistance) - 1
    print(off)
    assert row["toughness"] == pytest.approx(resistance, rel=1e-9) and row["G"] == pytest.approx(resistance, rel=1e-6)
    assert np.max(np.abs(off)) < 0.003
    assert np.argmax(row["load_factor"]) == np.argmax(beam_load(row["tip_x"], resistance)) == 6


@pytest.mark.parametrize("stop", [4, 7])
def test_a_resistance_curve_goes_on_from_a_checkpoint(hampm, stop):
    """The length that has grown, by which the toughness rises, and the energy that it took: the same bytes."""
    coarse = ("--set", "refine.max_level=1", "--set", "run.end_time=8", "--set", "method.load_steps=8", "--set", "output.snapshot_interval=0")
    (hampm.folder / "case.nml").write_text(input_of("dcb_r_curve").replace("dcb_r_curve.h5", "case.h5"))
    assert hampm("case.nml", "--quiet", "--output", "unbroken", *coarse).returncode == 0
    assert hampm("case.nml", "--quiet", "--steps", stop, *coarse).returncode == 5
    assert hampm("--resume", "case.h5.checkpoint", "--quiet").returncode == 0
    assert differing(hampm.folder / "unbroken/case.h5", hampm.folder / "case.h5") == []


def test_a_resistance_curve_in_slow_motion(hampm):
    """The same beam, opened slowly: G on the curve to 1 %, the load within 3 % of that of beams in cells of 1 mm, and what faces take from 2.5 mm on is the area under
    the curve to 0.8 %: within the two cells over which forces fall 0.3 of a cell more than the way of the tip is taken, once."""
    row, _ = run_told(hampm, input_of("dcb_r_curve_slow"))
    grows = row["tip_x"] > 30.5e-3
    resistance = np.interp(row["tip_x"] - 30e-3, *CURVE)
    off = row["reaction_upper_y"][grows] / beam_load(row["tip_x"], resistance)[grows] - 1
    first = np.flatnonzero(row["tip_x"] > 32.5e-3)[0]
    way = np.linspace(row["tip_x"][first] - 30e-3, row["tip_x"][-1] - 30e-3, 1000)
    area = 0.01 * np.trapezoid(np.interp(way, *CURVE), way)
    taken = row["fracture_energy"][-1] - row["fracture_energy"][first]
    print(off, taken / area, row["tip_x"][-1])
    assert row["tip_x"][-1] > 50e-3
    assert row["toughness"] == pytest.approx(resistance, rel=1e-9)
    assert np.max(np.abs(row["G"][grows] / resistance[grows] - 1)) < 0.0105
    assert 0 < np.mean(off) < 0.02 and np.max(np.abs(off)) < 0.03
    assert taken == pytest.approx(area, rel=0.008)


@pytest.mark.parametrize("law", ["benzeggagh_kenane", "hutchinson_suo"])
def test_mixed_mode_bending(hampm, law):
    """A delamination grows at the toughness of its mix of modes: load and toughness are those of beams to 1 %."""
    text = input_of("laminate_mmb_growth").replace("end_time = 8.0", "end_time = 4.0").replace("load_steps = 8", "load_steps = 4")
    if law == "hutchinson_suo":
        kept = [line for line in text.splitlines() if "toughness_shear" not in line and "exponent" not in line]
        text = "\n".join(kept).replace("'benzeggagh_kenane'", "'hutchinson_suo'  lambda = 0.3") + "\n"
    row, _ = run_told(hampm, text)
    a, h, e, length, lever, chi = row["tip_x"], 2e-3, 140e9, 50e-3, 45e-3, 1.878
    of_one = 3 * (3 * lever - length) ** 2 * (a + chi * h) ** 2 / (4 * length**2 * e * h**3)
    of_two = 9 * (lever + length) ** 2 * (a + 0.42 * chi * h) ** 2 / (16 * length**2 * e * h**3)
    m = of_two / (of_one + of_two)
    toughness = 277 + 511 * m**1.6 if law == "benzeggagh_kenane" else 277 * (1 + np.tan(0.7 * np.arctan(np.sqrt(m / (1 - m)))) ** 2)
    load = np.sqrt(toughness / (of_one + of_two))
    print(8e3 * row["load_factor"] / load, row["toughness"] / toughness)
    assert a[-1] == pytest.approx(33e-3)
    assert 8e3 * row["load_factor"] == pytest.approx(load, rel=0.005)
    assert row["toughness"] == pytest.approx(toughness, rel=0.01)


def test_each_body_has_its_toughness(hampm):
    """A crack that goes from one body into another of the same material: an increment ends at the seam, its toughness is that of the body ahead, and factors apply to both."""
    text = input_of("dcb_r_curve").replace("indicator = 'tip'", "indicator = 'none'").replace("end_time = 20.0", "end_time = 4.0").replace(
        "load_steps = 20", "load_steps = 4").replace("snapshot_interval = 10.0", "").replace("increment = 1.25e-3", "increment = 2.5e-3")
    body = text[text.index("&body"):text.index("&load")]
    first, second = (body.replace("95.0e-3", "34.0e-3"), body.replace("lower = 0.0,", "lower = 34.0e-3,").replace("upper = 95.0e-3, 10.0e-3", "upper = 95.0e-3, 10.0e-3\n   toughness = 250.0"))
    row, _ = run_told(hampm, text.replace(body, first + second))
    factor = np.interp(row["tip_x"] - 30e-3, CURVE[0], CURVE[1] / 100)
    assert row["tip_x"] == pytest.approx([30e-3, 32.5e-3, 34e-3, 36.5e-3, 39e-3])
    assert row["toughness"] == pytest.approx(np.array([100, 100, 250, 250, 250]) * factor)
    assert row["G"] == pytest.approx(row["toughness"], rel=1e-6)


SEAM = """&run plane = 'stress'  thickness = 0.01  end_time = 1.0 /
&grid lower = -5e-3, -12e-3  cell = 1e-3  cells = 66, 24 /
&material name = 'a'  young = 70e9  poisson = 0.3  density = 2700 /
{bodies}
&load kind = 'traction'  lower = 0.0, 0.0  upper = 0.0, 0.01  force = 0.0, 1.0 /
&load kind = 'traction'  lower = 0.0, -0.01  upper = 0.0, 0.0  force = 0.0, -1.0 /
&constraint lower = 0.06, -0.01  upper = 0.06, 0.01  fix = 'xy' /
&method time = 'static'  load_steps = 1 /
&crack kind = 'path'  points = 0.0, 0.0, 0.03, 0.0 /
&growth law = 'quasi_static'  direction = 'straight'  toughness = 200.0  increment = 2e-3 /
&energy_release estimators = 'domain_integral' /
&output file = 'out.h5' /
"""


@pytest.mark.parametrize(("tough", "least"), [((300.0, 100.0), 100.0), ((300.0, 0.0), 200.0), ((150.0, 0.0), 150.0), ((0.0, 0.0), 200.0)])
def test_a_crack_along_a_seam_takes_the_lesser_toughness(hampm, tough, least):
    """Two beams are glued along the way of the crack: whichever is the tougher one, and whichever comes first, loads are those of the weaker one. One without a toughness has that of &growth."""
    loads = []
    for first, mirrored in ((0, 0), (0, 1), (1, 0), (1, 1)):
        bodies = [f"&body material = 'a'  lower = 0.0, {y}  upper = 0.06, {y + 0.01}  toughness = {tough[(side + mirrored) % 2]} /\n" for side, y in ((0, -0.01), (1, 0.0))]
        row = run(hampm, SEAM.format(bodies="".join(bodies if first == 0 else bodies[::-1])))
        assert row["toughness"] == pytest.approx(least, rel=1e-12)
        loads += [row["load_factor"]]
    assert np.array(loads) == pytest.approx(np.array([loads[0]] * 4), rel=1e-9)


def test_a_crack_zigzags_along_weak_planes(hampm):
    """Weak planes at 40 degrees to either side of a strip: segments go along them; a tip turns where a kink of 80 degrees has more G than straight on, at K_II/K_I =
    0.460, and the load is that of a straight crack with the toughness of Wulff's construction to 2 %."""
    text = input_of("zigzag").replace("end_time = 32.0", "end_time = 14.0").replace("load_steps = 32", "load_steps = 14").replace("interval = 32.0", "interval = 14.0")
    row, said = run_told(hampm, text)
    angle = row["tip_angle"][1:]
    mixity = np.abs(row["K_II"] / row["K_I"])[1:-1]
    turns = np.abs(np.diff(angle)) > 1
    assert np.abs(angle) == pytest.approx(40.0, abs=1e-6) and "to and fro" not in said
    print(np.min(mixity[turns]), np.max(mixity[~turns]))
    assert np.max(mixity[~turns]) < 0.460 < np.min(mixity[turns])
    assert row["toughness"][1:] == pytest.approx(100.0)
    whole = slice(2, 14)                          # three periods of four increments
    wulff = 100 / math.cos(math.radians(40))
    per_way = (1 / row["load_factor"][:-1] ** 2 + row["G"][1:] / 100 / row["load_factor"][1:] ** 2) / 2
    print(np.mean(per_way[whole]) * wulff / 12.0, said)
    assert np.mean(per_way[whole]) * wulff / 12.0 == pytest.approx(1, abs=0.02)


def test_the_same_on_weak_planes_that_turn_with_the_body(hampm):
    """A quarter turn of strip and planes: the same loads and segments."""
    text = input_of("zigzag").replace("end_time = 32.0", "end_time = 4.0").replace("load_steps = 32", "load_steps = 4").replace("interval = 32.0", "interval = 4.0")
    text = text.replace("points = -30.0e-3, 0.0, 0.0, 0.0", "points = -30.0e-3, 0.1e-3, 0.0, 0.1e-3")
    turned = text.replace("lower = -30.0e-3, -10.5e-3", "lower = -10.5e-3, -30.0e-3").replace("cells = 160, 42", "cells = 42, 160")
    turned = turned.replace("lower = -30.0e-3, -10.0e-3", "lower = -10.0e-3, -30.0e-3").replace("upper = 50.0e-3, 10.0e-3", "upper = 10.0e-3, 50.0e-3")
    turned = turned.replace("lower = -30.0e-3, 10.0e-3", "lower = -10.0e-3, -30.0e-3", 1).replace("upper = 50.0e-3, -10.0e-3", "upper = 10.0e-3, 50.0e-3")
    for old, new in (("displacement = 0.0, 1.0e-6", "displacement = -1.0e-6, 0.0"), ("displacement = 0.0, -1.0e-6", "displacement = 1.0e-6, 0.0"),
                     ("points = -30.0e-3, 0.1e-3, 0.0, 0.1e-3", "points = -0.1e-3, -30.0e-3, -0.1e-3, 0.0"), ("-40.0, 0.0, 40.0, 90.0", "0.0, 50.0, 90.0, 130.0"),
                     ("1.0, 1.6, 1.0, 3.0", "3.0, 1.0, 1.6, 1.0")):
        assert old in turned
        turned = turned.replace(old, new)
    boxes = turned.split("&constraint")
    boxes[1] = boxes[1].replace("upper = 10.0e-3, 50.0e-3", "upper = -10.0e-3, 50.0e-3")
    boxes[2] = boxes[2].replace("lower = -10.0e-3, -30.0e-3", "lower = 10.0e-3, -30.0e-3")
    row, _ = run_told(hampm, text)
    other, _ = run_told(hampm, "&constraint".join(boxes))
    assert other["load_factor"] == pytest.approx(row["load_factor"], rel=1e-6)
    assert other["tip_y"] == pytest.approx(row["tip_x"], abs=1e-9) and other["tip_x"] == pytest.approx(-row["tip_y"], abs=1e-9)


def rayleigh_speed(shear, pressure):
    low, high = 0.5 * shear, shear
    for _ in range(60):
        v = (low + high) / 2
        a_d, a_s = math.sqrt(1 - (v / pressure) ** 2), math.sqrt(1 - (v / shear) ** 2)
        low, high = (v, high) if 4 * a_d * a_s > (1 + a_s**2) ** 2 else (low, v)
    return v


def hoop_angle(v, shear, pressure):
    """Of the largest hoop stress around a tip that runs in mode I, by the stresses of Freund (1990), equation 4.3.10 [deg]."""
    a_d, a_s = math.sqrt(1 - (v / pressure) ** 2), math.sqrt(1 - (v / shear) ** 2)
    theta = np.radians(np.linspace(0, 90, 1801))
    s, c = np.sin(theta), np.cos(theta)
    root_d, root_s = (1 - (v * s / pressure) ** 2) ** 0.25, (1 - (v * s / shear) ** 2) ** 0.25
    half_d, half_s = np.arctan2(a_d * s, c) / 2, np.arctan2(a_s * s, c) / 2
    xx = (1 + a_s**2) * (1 + 2 * a_d**2 - a_s**2) * np.cos(half_d) / root_d - 4 * a_s * a_d * np.cos(half_s) / root_s
    yy = -((1 + a_s**2) ** 2 * np.cos(half_d) / root_d - 4 * a_d * a_s * np.cos(half_s) / root_s)
    xy = 2 * a_d * (1 + a_s**2) * (np.sin(half_d) / root_d - np.sin(half_s) / root_s)
    return np.degrees(theta[np.argmax(xx * s**2 + yy * c**2 - 2 * xy * s * c)])


@pytest.mark.parametrize("limit", [None, 1200.0])
def test_where_a_crack_in_pmma_may_branch(hampm, limit):
    """The criteria of a crack that runs faster and faster, against the universal function and stresses of Freund; the run warns of both, at 0.4 to 0.72 of the
    speed of Rayleigh waves, as experiments branch. Branching takes twice the toughness at rest, however much more a running tip needs."""
    text = input_of("pmma_strip").replace("cell = 0.5e-3", "cell = 1.0e-3").replace("cells = 180, 42", "cells = 90, 22").replace("-10.5e-3", "-11.0e-3")
    text = text.replace("'stress'", "'strain'").replace("0.35", "0.3").replace("interval = 115.0e-6", "interval = 0.0").replace("115.0e-6", "105.0e-6")
    row, said = run_told(hampm, text.replace("toughness = 200.0", f"toughness = 200.0  limit_speed = {limit}" if limit else "toughness = 200.0"))
    shear = math.sqrt(3.6e9 / 2.6 / 1190)
    pressure = shear * math.sqrt(3.5)
    v = row["tip_speed"]
    assert np.max(v) > (0.59 if limit else 0.75) * shear
    ratio = v / rayleigh_speed(shear, pressure)
    assert row["speed_ratio"] == pytest.approx(ratio, rel=1e-9)
    runs = np.flatnonzero(v > 0)
    off = [row["hoop_angle"][k] - hoop_angle(v[k], shear, pressure) for k in runs]
    assert np.max(np.abs(off)) < 0.3
    table = np.loadtxt(REFERENCE / "growth/c1_universal_nu0.30_strain.csv", delimiter=",", skiprows=7)
    g = np.interp(ratio, table[:, 0], table[:, 5])
    off = row["branching_energy"] * 2 * 200 * g / np.maximum(row["G"], 1e-9) - 1
    print(np.max(np.abs(off[runs])), np.max(ratio), said)
    assert np.max(np.abs(off[runs][ratio[runs] < 0.8])) < 2e-3
    spoken = [float(found) for found in re.findall(r"tip 1 (?:has the energy|is fast enough).*first at ([\d.]+) of the speed", said)]
    print(spoken)
    first = np.argmax(row["branching_energy"] >= 1)
    assert spoken[0] == pytest.approx(ratio[first], abs=2e-3)
    told = float(re.search(r"a tip at rest in its place would have ([\d.]+) times the toughness", said)[1])
    assert told == pytest.approx(2 * row["branching_energy"][first], rel=5e-3)
    assert spoken[0] < 0.4 and len(spoken) == 1 if limit else 0.4 < spoken[0] < spoken[1] < 0.75


@pytest.mark.parametrize("along", [-1.5, pytest.param(1.5, marks=pytest.mark.verify)])
def test_a_kink_with_its_t_stress(hampm, along):
    """A slanted crack of 20 mm under stress along x too, and kinks of 1 mm at both ends: with the T-stress the G that the kink was to have is the one that it has, to 15 % more as
    the crack is 10 % longer; without it under pressure along x that is 39 % less."""
    half, cell = 0.06, 2e-3
    c, s = 0.01 * math.cos(math.radians(20)), 0.01 * math.sin(math.radians(20))
    sides = "".join(f"&load kind = 'traction'  lower = {x0}, {y0}  upper = {x1}, {y1}  force = {fx}, {fy} /\n" for x0, y0, x1, y1, fx, fy in (
        (-half, half, half, half, 0.0, 2e6 * half), (-half, -half, half, -half, 0.0, -2e6 * half),
        (half, -half, half, half, along * 2e6 * half, 0.0), (-half, -half, -half, half, -along * 2e6 * half, 0.0)))
    found = {}
    for t_stress in ("true", "false"):
        row, _ = run_told(hampm, f"""&run plane = 'strain'  end_time = 1.0 /
&grid lower = {-half - cell / 2}, {-half - cell / 2}  cell = {cell}  cells = 61, 61 /
&material name = 'rock'  young = 70e9  poisson = 0.2  density = 2500 /
&body material = 'rock'  lower = {-half}, {-half}  upper = {half}, {half} /
{sides}&crack kind = 'path'  points = {-c}, {-s}, {c}, {s} /
&growth toughness = 40.0  increment = 1e-3  direction = 'max_energy' /
&refine indicator = 'tip'  max_level = 2  rings = 6 /
&method time = 'static' /
&energy_release estimators = 'domain_integral'  t_stress = .{t_stress}. /
""")
        found[t_stress] = row["G"][1] * (row["load_factor"][0] / row["load_factor"][1]) ** 2 / row["G_kink"][0]
        assert row["G_kink"][0] == pytest.approx(40.0, rel=1e-5)
        assert row["tip_angle"][1] - row["tip_angle"][0] == pytest.approx(row["kink_angle"][0], abs=1e-6)
    print(found)
    assert 1.1 < found["true"] < 1.16
    assert along > 0 or found["false"] < 0.65


def test_the_energy_to_branch_is_bounded_at_the_speed_of_rayleigh_waves(hampm):
    """A crack under a plane wave by a toughness that no speed meets. G of a tip at rest is K(t, 0)**2/E' (Freund); g(v) is 0 at the speed of Rayleigh waves, where cells leave a tenth of G: G/g(v)
    was 1e4 times that."""
    density, way, toughness = 5000.0, 10e-3, 1e-4
    fast = math.sqrt(199.992e9 / 2.6 / density) * 1.87082869339
    row = run(hampm, f"""&run plane = 'strain'  end_time = {2.2 * way / fast} /
&grid lower = {-way}, {-way - 0.4e-3}  cell = 0.4e-3  cells = 50, 52 /
&material name = 's'  young = 199.992e9  poisson = 0.3  density = {density} /
&body material = 's'  lower = {-way}, {-way}  upper = {way}, {way} /
&constraint lower = {-way}, {-way}  upper = {-way}, {way}  fix = 'x' /
&constraint lower = {way}, {-way}  upper = {way}, {way}  fix = 'x' /
&load kind = 'traction'  lower = {-way}, {way}  upper = {way}, {way}  force = 0, 10e3 /
&load kind = 'traction'  lower = {-way}, {-way}  upper = {way}, {-way}  force = 0, -10e3 /
&method mass = 'weighted' /
&crack kind = 'path'  points = {-way}, 0, 0, 0 /
&growth law = 'toughness'  toughness = {toughness}  direction = 'straight' /
&energy_release estimators = 'domain_integral' /
""")
    late = row["time"] > 1.6 * way / fast
    at_rest = (2e6 / 0.7 * np.sqrt(fast * (row["time"][late] - way / fast) * 0.4 / math.pi))**2 * 0.91 / 199.992e9
    ratio = row["branching_energy"][late] * 2 * toughness / at_rest
    print(np.min(row["speed_ratio"][late]), np.min(ratio), np.max(ratio))
    assert np.min(row["speed_ratio"][late]) > 0.93
    assert 0.7 < np.min(ratio) and np.max(ratio) < 1.4
