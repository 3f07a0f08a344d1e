"""Fronts of cracks in planes that grow in motion: a strip between grips, |y| < 10 mm, whose upper edge is moved by u_0 and held, between rollers."""

import subprocess
import sys

import h5py
import numpy as np
import pytest
from paths import BENCH, SOLID_PROGRAM

sys.path.insert(0, str(BENCH))

import growth as bench  # noqa: E402

pytestmark = pytest.mark.skipif(not SOLID_PROGRAM.exists(), reason="make program dim=3 makes it")

STEADY = 26.922                                    # rho c_d**2 u_0**2/h, what is stored ahead of a crack that runs (Nilsson 1974)
T = np.linspace(0, 60e-6, 21)
RISE = (f"history = 'table'  times = {', '.join(f'{t:.6g}' for t in T)}  "
        f"factors = {', '.join(f'{f:.8g}' for f in (1 - np.cos(np.pi * T / 60e-6)) / 2)}")


def strip(growth, cells=1, h=2e-3, kind="symmetry", end=58e-6, method="", ahead=20e-3, tough=None):
    """Half of it, or all, some cells wide; the front is at x = 0 and goes along x."""
    half, w = kind == "symmetry", cells * h
    low, n = (0.0, round(10e-3 / h) + 1) if half else (-10e-3, round(20e-3 / h) + 2)
    box = lambda x0, y0, z0, x1, y1, z1: f"lower = {x0}, {y0}, {z0}  upper = {x1}, {y1}, {z1}"
    x0, x1 = -10e-3, ahead
    parts = [(0.0, w, "")] if tough is None else [(0.0, w / 2, f"toughness = {tough[0]}"), (w / 2, w, f"toughness = {tough[1]}")]
    bodies = "\n".join(f"&body material = 'a'  {box(x0, low, a, x1, 10e-3, b)}  {key} /" for a, b, key in parts)
    below = f"{box(x0, 0.0, 0.0, x1, 0.0, w)}  fix = 'y'" if half else \
        f"{box(x0, low, 0.0, x1, low, w)}  fix = 'xyz'  displacement = 0.0, -1e-6, 0.0  {RISE}"
    return f"""&run end_time = {end} /
&grid lower = {x0}, {0.0 if half else -10e-3 - h}, 0.0  cell = {h}  cells = {round((x1 - x0) / h)}, {n}, {cells} /
&material name = 'a'  young = 199.992e9  poisson = 0.3  density = 5000 /
{bodies}
&constraint {box(x0, 10e-3, 0.0, x1, 10e-3, w)}  fix = 'xyz'  displacement = 0.0, 1e-6, 0.0  {RISE} /
&constraint {below} /
&constraint {box(x0, low, 0.0, x1, 10e-3, 0.0)}  fix = 'z' /
&constraint {box(x0, low, w, x1, 10e-3, w)}  fix = 'z' /
&constraint {box(x1, low, 0.0, x1, 10e-3, w)}  fix = 'x' /
&crack kind = '{kind}'  normal = 'y'  front = 'straight'  tip = 0.0, 0.0, 0.0  direction = 1.0, 0.0, 0.0 /
&growth {growth}  direction = 'straight' /
&energy_release estimators = 'domain_integral'  energy_balance = .true. /
&output file = 'case.h5'  history_interval = 0.5e-6 /
{method}
"""


def run(hampm, tmp_path, text, *options, code=0):
    (tmp_path / "case.nml").write_text(text)
    result = hampm("case.nml", "--force", *options, program=SOLID_PROGRAM)
    assert result.returncode == code, result.stderr
    return read(tmp_path)


def read(tmp_path):
    with h5py.File(tmp_path / "case.h5") as file:
        row = {name: data[()] for name, data in file["history"].items()}
        return row, {name: data[()] for name, data in file["front"].items()}


def missing(row):
    """Of the energy at all samples, in parts of the work."""
    kept = sum(row[name] for name in ("kinetic_energy", "strain_energy", "fracture_energy", "numerical_loss"))
    return np.max(np.abs(row["external_work"] - kept)) / np.max(row["external_work"])


GIVEN = "law = 'prescribed'  speed = 1455.0  start = 50e-6"
TOUGH = "law = 'toughness'  toughness = 20.0"


def test_a_front_at_a_given_speed(hampm, tmp_path):
    """Energy at all samples; a wider half as one cell of the whole; straight, and where it is to be."""
    row, front = run(hampm, tmp_path, strip(GIVEN, cells=4))
    assert np.max(front["K_I_error"]) < np.max(front["K_I"]), "also where G is below 0, before waves come"
    whole, _ = run(hampm, tmp_path, strip(GIVEN, kind="plane"))
    assert np.ptp(front["x"], axis=1).max() == 0
    assert front["x"][-1, 0] == pytest.approx(1455 * 8e-6, rel=1e-9)
    assert row["crack_area"][-1] - row["crack_area"][0] == pytest.approx(8e-3 * 1455 * 8e-6, rel=1e-9)
    assert whole["fracture_energy"] == pytest.approx(row["fracture_energy"] / 2, rel=1e-9, abs=1e-15)
    assert missing(row) < 1e-12
    assert missing(whole) < 1e-12
    assert np.abs(row["numerical_loss"][-1]) < 0.02 * row["fracture_energy"][-1]


PENNY = """&run end_time = 21 /
&grid lower = 0.0, 0.0, 0.0  cell = 1.0  cells = 9, 9, 8 /
&material name = 'a'  young = 1.0  poisson = 0.25  density = 1.0 /
&body material = 'a'  lower = 0.0, 0.0, 0.0  upper = 9.0, 9.0, 7.0 /
&constraint lower = 0.0, 0.0, 0.0  upper = 9.0, 9.0, 0.0  fix = 'z' /
&constraint lower = 0.0, 0.0, 0.0  upper = 0.0, 9.0, 7.0  fix = 'x' /
&constraint lower = 0.0, 0.0, 0.0  upper = 9.0, 0.0, 7.0  fix = 'y' /
&load kind = 'traction'  lower = 0.0, 0.0, 7.0  upper = 9.0, 9.0, 7.0  force = 0.0, 0.0, 0.01 /
&crack kind = 'symmetry'  normal = 'z'  front = 'disc'  center = 0.0, 0.0, 0.0  radii = 4.0 /
&growth law = 'prescribed'  speed = 0.25  start = 9.0  direction = 'straight' /
&energy_release estimators = 'domain_integral'  energy_balance = .true. /
&output file = 'case.h5'  history_interval = 3.0 /
"""


def test_a_disc_stays_one(hampm, tmp_path):
    row, front = run(hampm, tmp_path, PENNY)
    assert row["crack_area"][-1] == pytest.approx(np.pi / 4 * 7**2, rel=1e-4)
    assert np.hypot(front["x"][-1], front["y"][-1]) == pytest.approx(7, rel=5e-3)
    assert missing(row) < 1e-12


def test_a_tough_half_lags(hampm, tmp_path):
    row, front = run(hampm, tmp_path, strip(TOUGH, cells=8, tough=(15, 30), end=50e-6))
    x = front["x"][-1]
    print(x)
    assert x[np.argmin(front["z"][-1])] > 2 * x[np.argmax(front["z"][-1])] + 2e-3
    assert missing(row) < 1e-12


def test_a_front_runs_through(hampm, tmp_path):
    """It is said, and there is none any more."""
    (tmp_path / "case.nml").write_text(strip(GIVEN, ahead=10e-3))
    result = hampm("case.nml", program=SOLID_PROGRAM)
    assert "crack 1 has run through at t = " in result.stderr
    row, _ = read(tmp_path)
    assert np.isnan(row["G_mean"][-1]) and row["front_speed"][-1] == 0
    assert row["crack_area"][-1] == pytest.approx(20e-3 * 2e-3)


def test_a_run_resumed_after_the_front_has_ended(hampm, tmp_path):
    """All columns go on, and say that there is no front, as snapshots do. G by closure is that of the whole."""
    text, whole = (strip(GIVEN, ahead=10e-3, kind=kind).replace("'domain_integral'", "'domain_integral', 'vcct'")
                   .replace("history_interval", "snapshot_interval = 5.75e-6  history_interval") for kind in ("symmetry", "plane"))
    of_whole, _ = run(hampm, tmp_path, whole)
    once, along = run(hampm, tmp_path, text)
    run(hampm, tmp_path, text, "--steps", "229", code=5)
    assert subprocess.run([SOLID_PROGRAM, "--resume", "case.h5.checkpoint"], cwd=tmp_path, capture_output=True).returncode == 0
    again, along_again = read(tmp_path)
    assert np.isnan(again["K_I"][-1]) and np.isnan(again["G_vcct_I"][-1])
    assert once["G_vcct_I"] == pytest.approx(of_whole["G_vcct_I"], rel=1e-7, nan_ok=True)
    with h5py.File(tmp_path / "case.h5") as file:
        assert file["VTKHDF/fronts/NumberOfPoints"][-2:].tolist() == [5, 0]
    for one, other in ((once, again), (along, along_again)):
        assert all(np.array_equal(one[name], other[name], equal_nan=True) for name in one)


BAND = """&run end_time = {end} /
&grid lower = 0.0, 0.0, -1.0  cell = 1.0  cells = 20, 1, 21 /
&material name = 'a'  young = 1.0  poisson = 0.25  density = 1.0 /
&body material = 'a'  lower = 0.0, 0.0, 0.0  upper = 20.0, 1.0, 19.0 /
&load kind = 'traction'  lower = 0.0, 0.0, 19.0  upper = 20.0, 1.0, 19.0  force = 0.0, 0.0, 0.2 /
&load kind = 'traction'  lower = 0.0, 0.0, 0.0  upper = 20.0, 1.0, 0.0  force = 0.0, 0.0, -0.2 /
&crack name = 'band'  kind = 'plane'  normal = 'z'  front = 'polygon'  points = 4.5, -1.0, 6.0, 9.5, -1.0, 6.0, 9.5, 2.0, 6.0, 4.5, 2.0, 6.0 /
&crack name = 'other'  kind = 'plane'  normal = 'z'  front = 'straight'  tip = 15.0, 0.0, 13.0  direction = -1.0, 0.0, 0.0 /
&growth crack = 'band'  law = 'prescribed'  speed = 0.5  start = 1.0  direction = 'straight' /
&energy_release estimators = 'domain_integral' /
&output file = 'case.h5'  history_interval = 1.0 /
"""


def test_fronts_keep_their_numbers(hampm, tmp_path):
    """One of the two fronts of a crack ends on a side: the other, and that of another crack, go on as what they were. A resumed run knows it too."""
    _, once = run(hampm, tmp_path, BAND.format(end=14.0))
    assert np.all(once["x"] == pytest.approx(9.5 + np.arange(-1, 14)[:, None].clip(0) / 2 * np.ones(once["x"].shape[1]))), once["x"]
    assert np.all(np.isfinite(once["x_front2"][:10])) and np.all(np.isnan(once["x_front2"][12:]))
    assert np.all(once["x_front3"] == 15) and np.all(np.isfinite(once["G_front3"]))
    run(hampm, tmp_path, BAND.format(end=14.0), "--steps", "11", code=5)
    assert subprocess.run([SOLID_PROGRAM, "--resume", "case.h5.checkpoint"], cwd=tmp_path, capture_output=True).returncode == 0
    _, again = read(tmp_path)
    assert all(np.array_equal(once[name], again[name], equal_nan=True) for name in once)


@pytest.mark.parametrize("method, steps", (("", 200), ("&method time = 'implicit'  time_step = 0.5e-6 /", 90)))
def test_a_run_that_is_resumed(hampm, tmp_path, method, steps):
    text = strip(TOUGH, kind="plane", method=method)
    once, _ = run(hampm, tmp_path, text)
    run(hampm, tmp_path, text, "--steps", str(steps), code=5)
    assert subprocess.run([SOLID_PROGRAM, "--resume", "case.h5.checkpoint"], cwd=tmp_path, capture_output=True).returncode == 0
    again, _ = read(tmp_path)
    assert once["crack_area"][-1] > once["crack_area"][0]
    for name in once:                              # in explicit steps the last digit of a node that opens is not kept
        scale = np.nanmax(np.abs(once[name])) if method == "" else 0
        assert again[name] == pytest.approx(once[name], rel=0, abs=1e-12 * scale, nan_ok=True), name


def test_a_front_starts_when_it_may(hampm, tmp_path):
    """Its G is above its toughness before its &growth applies: it stands until then, and runs from the step on in which that begins."""
    start = 44e-6
    row, _ = run(hampm, tmp_path, strip(f"law = 'toughness'  toughness = 2.0  start = {start}", end=46e-6))
    waits = row["time"] < start
    assert row["G_mean"][waits][-1] > 4 and np.ptp(row["crack_area"][waits]) == 0
    assert np.all(np.diff(row["crack_area"][row["time"] > start + 0.2e-6]) > 0)
    assert row["front_speed"][row["time"] > start + 0.2e-6][0] > 0


WAVE = """&run end_time = {end} /
&grid lower = -10e-3, 0.0, 0.0  cell = {h}  cells = {n}, {n_y}, 1 /
&material name = 'a'  young = 199.992e9  poisson = 0.3  density = 5000 /
&body material = 'a'  lower = -10e-3, 0.0, 0.0  upper = 10e-3, 10e-3, {h} /
&constraint lower = -10e-3, 0.0, 0.0  upper = -10e-3, 10e-3, {h}  fix = 'x' /
&constraint lower = 10e-3, 0.0, 0.0  upper = 10e-3, 10e-3, {h}  fix = 'x' /
&constraint lower = -10e-3, 0.0, 0.0  upper = 10e-3, 10e-3, {h}  fix = 'z' /
&constraint lower = -10e-3, 0.0, 0.0  upper = 10e-3, 0.0, {h}  fix = 'y' /
&load kind = 'traction'  lower = -10e-3, 10e-3, 0.0  upper = 10e-3, 10e-3, {h}  force = 0.0, {force}, 0.0 /
&crack kind = 'symmetry'  normal = 'y'  tip = 0.0, 0.0, 0.0  direction = 1.0, 0.0, 0.0 /
&growth law = 'toughness'  toughness = {toughness}  direction = 'straight' /
&energy_release estimators = 'domain_integral'  energy_balance = .true. /
&method mass = 'weighted' /
&output file = 'case.h5'  history_interval = 2e-8 /
"""


def test_a_front_by_the_equation_of_motion(hampm, tmp_path):
    """Freund's crack under a step wave at a constant toughness, 20 cells high: it starts in time, is within a quarter of a cell of its place, and its speed is right
    to 4 % of that of Rayleigh waves. Relaxed in the time of shear waves through three cells it was 1.6 of these late, and 2 cells behind."""
    time, growth, speed, toughness = bench.exact_growth()
    h = bench.HEIGHT / 20
    row, _ = run(hampm, tmp_path, WAVE.format(end=2.9 * bench.ARRIVAL, h=h, n=40, n_y=21, force=0.5e6 * 20e-3 * h, toughness=toughness))
    way = (row["crack_area"] - row["crack_area"][0]) / h
    seen = row["time"] > 1.8 * bench.ARRIVAL
    off = (way - np.interp(row["time"], time, growth))[seen] / h
    late = row["time"] > 2 * bench.ARRIVAL
    spread = np.sqrt(np.mean((row["front_speed"] - np.interp(row["time"], time, speed))[late]**2)) / bench.RAYLEIGH
    start = row["time"][np.flatnonzero(way > 1e-6)[0]] - np.interp(1e-6, growth, time)
    print(off, spread, start * bench.SHEAR / h, np.mean(row["G_mean"][late]) / toughness)
    assert abs(start) * bench.SHEAR / h < 0.5
    assert np.max(np.abs(off)) < 0.25
    assert spread < 0.04
    assert np.mean(row["G_mean"][late]) / toughness == pytest.approx(1, abs=0.08)
    assert missing(row) < 1e-12


def fast(part, mass):
    """Freund's crack at a given part of the speed of Rayleigh waves, 20 cells high: history, exact G at its rows [J/m2], and advance [cells]."""
    h = bench.HEIGHT / 20
    text = WAVE.format(end=2.9 * bench.ARRIVAL, h=h, n=40, n_y=21, force=0.5e6 * 20e-3 * h, toughness=0.0)
    text = text.replace("law = 'toughness'  toughness = 0.0", bench.given(part * bench.RAYLEIGH)).replace("mass = 'weighted'", f"mass = '{mass}'")
    speed = part * bench.RAYLEIGH
    exact = lambda time: bench.factor_of_speed(speed, "A_I") * (bench.factor_of_speed(speed) * bench.intensity_at_rest(time))**2 * (1 - bench.POISSON**2) / bench.YOUNG
    return text, exact, h


@pytest.mark.parametrize("mass, part, most", [("auto", 0.3, 0.03), ("auto", 0.6, 0.04), ("lumped", 0.6, 0.1)])
def test_g_of_a_fast_front(hampm, tmp_path, mass, part, most):
    """Freund's crack as a slab. With the default masses, which are weighted around the front of a slab, G is right to 3 % in the mean; lumped ones lose 4 to 9 %, which errors
    know (they held 0.76). Means over the last four cells of advance are within their band, from the first cell on."""
    text, exact, h = fast(part, mass)
    row, _ = run(hampm, tmp_path, text)
    right, way = exact(row["time"]), (row["crack_area"] - row["crack_area"][0]) / h**2
    late = way > 4
    error = (row["G_mean"] - right)[late] / right[late]
    means = bench.over_cells(way, right)
    off = (row["G_moving_average"] - means)[way > 1] / means[way > 1]
    print(mass, part, np.mean(error), np.mean(np.abs(error) * right[late] <= row["G_mean_error"][late]), off[-1])
    assert abs(np.mean(error)) < most
    assert np.mean(np.abs(error) * right[late] <= row["G_mean_error"][late]) >= 0.9
    assert np.all(np.abs(off) * means[way > 1] <= row["G_moving_average_error"][way > 1])


@pytest.mark.parametrize("cells, more, mass", [(1, "", "tip_weighted"), (4, "", "tip_weighted"), (5, "", "lumped"), (4, "&refine indicator = 'tip'  max_level = 1 /\n", "lumped"),
                                               (2, "&refine indicator = 'tip'  max_level = 1 /\n", "tip_weighted")])
def test_masses_of_a_front_by_default(hampm, tmp_path, cells, more, mass):
    """Weighted around fronts of up to four of the finest cells; wider ones would cost more than a shorter step."""
    (tmp_path / "case.nml").write_text(strip(GIVEN, cells=cells) + more)
    assert f"mass = '{mass}'" in hampm("--check", "case.nml", program=SOLID_PROGRAM).stdout


@pytest.mark.parametrize("toughness, told", ((1.5, True), (20.0, False)))
def test_a_front_that_its_cells_cannot_slow_down_says_so(hampm, tmp_path, toughness, told):
    """As of a tip: with a fifteenth of G as toughness it runs at the speed of Rayleigh waves with 8 times its toughness, and faces take 2.4 times that."""
    (tmp_path / "case.nml").write_text(strip(f"law = 'toughness'  toughness = {toughness}  start = 50e-6", end=54e-6))
    result = hampm("case.nml", program=SOLID_PROGRAM)
    assert result.returncode == 0
    assert ("a front is in cells that are too coarse for its toughness" in result.stderr) == told


@pytest.mark.parametrize("part, implicit", ((1e-3, True), (0.6, False), (0.8, False), (0.9, False)))
def test_faces_take_the_toughness_times_their_area(hampm, tmp_path, part, implicit):
    """Of a front in a slab between fixed edges, where the energy stored ahead is G at any speed (Nilsson 1974), at parts of the speed of Rayleigh waves: within
    2 %, as of a tip in the plane. Nodes that a front released as its squares of one cell to each side went by emitted waves: 0.95, 0.88 and 0.87; slow implicit
    steps lost what places take last (0.969). G is the toughness at the speed of the front within 3 %: at 0.9 it still becomes faster."""
    cell, speed = 1e-3, part * bench.RAYLEIGH
    row, _ = run(hampm, tmp_path, bench.law_scene(cell, speed, True, cell / speed / 8 if implicit else 0.0).replace("growth.h5", "case.h5"))
    _, ratio, scatter, taken = bench.law_held(row, cell, speed, True)
    print(ratio, scatter, taken)
    assert taken == pytest.approx(1, abs=0.02)
    assert ratio == pytest.approx(1, abs=0.03) and scatter < 0.05


@pytest.mark.verify
@pytest.mark.parametrize("growth", ("law = 'prescribed'  speed = 1455.0  start = 70e-6",
                                    "law = 'toughness'  toughness = 10.0  limit_speed = 1500.0"))
def test_what_is_stored_ahead_is_released(hampm, tmp_path, growth):
    """Whatever the speed (Nilsson 1974). By its toughness it goes where 10/(1 - v/1500) is that."""
    row, _ = run(hampm, tmp_path, strip(growth, h=1e-3, ahead=80e-3, end=90e-6))
    late = row["time"] > 75e-6
    print(np.mean(row["G_mean"][late]) / STEADY, np.mean(row["front_speed"][late]) / (1500 * (1 - 10 / STEADY)))
    assert np.mean(row["G_mean"][late]) == pytest.approx(STEADY, rel=0.03)
    if "toughness" in growth:
        assert np.mean(row["front_speed"][late]) == pytest.approx(1500 * (1 - 10 / STEADY), rel=0.05)


def test_rows_change_nothing(hampm, tmp_path):
    """Steps of 40 ns, with a row at each and at each third: where a row was in a step in which the front had opened nodes, G was measured twice, and the second was
    another one: by 2e-3 of G at the end."""
    *_, toughness = bench.exact_growth()
    h, rows = bench.HEIGHT / 20, []
    for interval in ("4e-8", "1.2e-7"):
        text = WAVE.format(end=3.24e-6, h=h, n=40, n_y=21, force=0.5e6 * 20e-3 * h, toughness=toughness)
        rows.append(run(hampm, tmp_path, text.replace("history_interval = 2e-8", f"history_interval = {interval}"))[0])
    each, third = rows
    assert np.all(each["dt"][1:] == pytest.approx(4e-8)) and np.all(third["dt"][1:] == pytest.approx(4e-8))
    for name in ("G_mean", "crack_area", "fracture_energy"):
        assert each[name][::3] == pytest.approx(third[name], rel=1e-11, abs=1e-11 * np.max(third[name])), name
