"""Cracks that grow in motion, against exact solutions (tests/reference/growth); what they keep, and what is refused."""

import math
import re
import sys

import h5py
import numpy as np
import pytest

from harness import run_told
from paths import BENCH
from snapshots import field, points, read_steps

sys.path.insert(0, str(BENCH))

import growth as bench  # noqa: E402


def residual(history):
    """What is missing in the energy balance since the start, where ends that are driven may move already, over the work."""
    inside = sum(history[name] for name in ("kinetic_energy", "strain_energy", "damping_loss", "numerical_loss", "fracture_energy", "friction_loss") if name in history)
    missing = history["external_work"] - inside
    return np.max(np.abs(missing - missing[0])) / np.max(history["external_work"])


@pytest.mark.parametrize(("part", "levels"), [(0.33, 0), *(pytest.param(*case, marks=pytest.mark.verify)
                                                           for case in [(0.16, 0), (0.33, 1), (0.6, 0)])])
def test_a_crack_that_runs(hampm, part, levels):
    """K_I of a given speed: means over a cell to 2 % (2.5 at 0.6 of Rayleigh waves, at first), momentary values to 1 %. K swings once a cell: a mean wants at least eight rows a cell."""
    speed = part * bench.RAYLEIGH
    text = bench.plate(0.2e-3, bench.given(speed), levels=levels, audit=part == 0.33)
    row, said = run_told(hampm, text.replace("history_interval = 2e-08", "history_interval = 5e-09") if part > 0.5 else text)
    error, means = bench.running(row, speed, 0.2e-3, skip=5 if part > 0.5 else 3)
    print(part, levels, means, np.mean(error), np.std(error))
    assert len(error) > 10
    assert np.all(np.abs(means) < (0.02 if part < 0.5 else 0.025))
    assert abs(np.mean(error)) < 0.011
    assert np.std(error) < 0.015
    # by the fields of a tip that runs: what the tip acts ahead or behind in its cells is of the first order in these, and told as error
    own, _ = bench.running({**row, "K_I": row["K_I_by_fields"]}, speed, 0.2e-3, skip=5 if part > 0.5 else 3)
    told = np.mean((row["K_I_by_fields_error"] / row["K_I_by_fields"])[-len(own):])
    print("by fields", np.mean(own), np.std(own), "told", told)
    assert abs(np.mean(own)) < 0.025 and np.std(own) < 0.015 and told < 0.06
    assert np.max(np.abs(row["K_II_by_fields"])) < 1e-6 * np.max(row["K_I"])
    assert row["tip_x"][-1] == pytest.approx(speed * 1.4 * bench.ARRIVAL, rel=0.02)
    assert "growth" not in said
    if part == 0.33:
        assert residual(row) < 1e-12
    # the bonds take what G says, but for the first cells of the way
    assert row["fracture_energy"][-1] == pytest.approx(row["integral_of_G"][-1], rel=0.08)
    if levels:
        assert row["particles"][-1] < 1.2 * row["particles"][0]


@pytest.mark.parametrize("part", [0.6, 0.74])
@pytest.mark.parametrize("frame", ["total", pytest.param("updated", marks=pytest.mark.verify)])
def test_a_fast_crack_by_default(hampm, part, frame):
    """Where no mass matrix is chosen, G and K of a fast tip are right in the mean, and single samples within their errors: with lumped masses G was 3.6 and 13 %
    low there, and bars held 68 and 54 %. Bonded points take what G says, to 5 %. The chosen matrix is told. Means over the last four cells of advance are within
    their band, which is less wide."""
    cell, speed = 0.2e-3, part * bench.RAYLEIGH
    text = bench.plate(cell, bench.given(speed)).replace("&method mass = 'weighted' /", f"&method frame = '{frame}' /")
    row, _ = run_told(hampm, text)
    late = row["tip_x"] > 5 * cell
    exact = {"K_I": bench.factor_of_speed(speed) * bench.intensity_at_rest(row["time"])}
    exact["G"] = bench.factor_of_speed(speed, "A_I") * exact["K_I"]**2 * (1 - bench.POISSON**2) / bench.YOUNG
    for name, right in exact.items():
        error = (row[name] - right)[late]
        held = np.mean(np.abs(error) <= row[f"{name}_error"][late])
        print(part, frame, name, np.mean(error / right[late]), held)
        assert abs(np.mean(error / right[late])) < 0.02
        assert held >= 0.9
    means = bench.over_cells(row["tip_x"] / cell, exact["G"])
    error, band = (row["G_moving_average"] - means)[late] / means[late], row["G_moving_average_error"][late] / means[late]
    settled = row["tip_x"][late] > 9 * cell
    print("average", np.mean(error), np.std(error[settled]), np.mean(np.abs(error) <= band), np.median(band[settled]))
    assert abs(np.mean(error)) < 0.02 and np.all(np.abs(error) <= band)
    single = ((row["G"] - exact["G"])[late] / exact["G"][late])[settled]
    assert np.std(error[settled]) < np.std(single) and np.median(band[settled]) < np.median((row["G_error"][late] / exact["G"][late])[settled])
    assert row["fracture_energy"][-1] == pytest.approx(row["integral_of_G"][-1], rel=0.05)


@pytest.mark.parametrize(("mass", "contact", "part"), [("lumped", "none", 0.6), ("weighted", "frictionless", 0.6), pytest.param("lumped", "none", 0.74, marks=pytest.mark.verify)])
def test_errors_of_a_fast_crack_know_of_lumped_masses(hampm, mass, contact, part):
    """Where tips run through lumped masses, as they do between faces with contact whatever the matrix, G is 4 and 13 % low. Errors held 0.68 and 0.54 of the samples: they
    have the part of G that waves of half the length of what a tip releases lose, 6 and 17 % at these speeds."""
    cell, speed = 0.2e-3, part * bench.RAYLEIGH
    row, _ = run_told(hampm, bench.plate(cell, bench.given(speed), mass).replace("kind = 'path'", f"kind = 'path'  contact = '{contact}'"))
    late = row["tip_x"] > 5 * cell
    right = bench.factor_of_speed(speed, "A_I") * (bench.factor_of_speed(speed) * bench.intensity_at_rest(row["time"]))**2 * (1 - bench.POISSON**2) / bench.YOUNG
    error = (row["G"] - right)[late]
    assert np.mean(error / right[late]) < -0.03
    assert np.mean(np.abs(error) <= row["G_error"][late]) >= 0.9
    means = bench.over_cells(row["tip_x"] / cell, right)
    assert np.all(np.abs(row["G_moving_average"] - means)[late] <= row["G_moving_average_error"][late])


def test_a_moving_average_does_not_depend_on_rows(hampm):
    """With steps of the same length rows five times as far apart have the same values: samples are taken by the advance of the tip. Before it moves the average is G."""
    text = bench.plate(0.4e-3, bench.given(0.5 * bench.RAYLEIGH), "lumped")
    dense, sparse = (run_told(hampm, text.replace("history_interval = 2e-08", f"history_interval = {interval}"))[0] for interval in ("6.4e-08", "32e-08"))
    for k, time in enumerate(sparse["time"][:-1]):
        same = int(np.argmin(np.abs(dense["time"] - time)))
        assert dense["time"][same] == pytest.approx(time, abs=1e-12) and dense["step"][same] == sparse["step"][k]
        for name in ("G", "G_moving_average", "G_moving_average_error"):
            assert sparse[name][k] == pytest.approx(dense[name][same], rel=1e-9, abs=1e-12 * np.max(dense["G"])), (time, name)
    resting = dense["tip_x"] == 0
    assert np.count_nonzero(resting) > 5 and np.array_equal(dense["G_moving_average"][resting], dense["G"][resting])


@pytest.mark.parametrize(("keys", "mass"), [("", "tip_weighted"), ("time = 'implicit'", "lumped"), ("scheme = 'usl'", "lumped"), ("frame = 'updated'", "tip_weighted")])
def test_which_mass_matrix_a_model_has_by_default(hampm, tmp_path, keys, mass):
    """`--check` prints it; where steps or faces have lumped masses at the tip anyway another one has no use."""
    text = bench.plate(0.5e-3, bench.given(1000.0)).replace("&method mass = 'weighted' /", f"&method {keys} /")
    (tmp_path / "model.nml").write_text(text)
    assert f"mass = '{mass}'" in hampm("--check", "model.nml").stdout
    for before, after in [("0.0, 0.0 /\n&growth", "0.0, 0.0  contact = 'frictionless' /\n&growth"), ("&method", "&method courant = 0.1 "), ("&body", "&body velocity = 1.0, 0.0 ")]:
        if "velocity" in after and "updated" not in keys:
            continue
        (tmp_path / "model.nml").write_text(text.replace(before, after))
        assert "mass = 'lumped'" in hampm("--check", "model.nml").stdout, after


@pytest.mark.verify
def test_a_benchmark_of_a_crack_that_runs(hampm):
    """1500 m/s in a plate that is loaded on one edge only (Rethore & Menouillard): means over a cell to 2 %, scatter to 5 %."""
    row, _ = run_told(hampm, bench.benchmark_scene(0.05, "weighted"))
    error, means = bench.benchmark_errors(row, 0.05)
    print(means, np.mean(error), np.std(error))
    assert len(means) >= 8
    assert np.all(np.abs(means) < 0.02)
    assert np.std(error) < 0.05
    assert row["K_II"] == pytest.approx(0, abs=0.01 * np.max(row["K_I"]))


def test_a_beam_that_splits_slowly_comes_near_to_one_at_rest(hampm):
    """The load at the same opening, in the mean, is the nearer to that at rest the slower the ends move; the crack is a cell or two behind."""
    compliance = bench.dcb_compliance(lambda text: run_told(hampm, text)[0])
    off = []
    for rate in (0.12, 0.06):
        text = bench.example("dcb_growth_dynamic", velocity=f"0.0, {rate / 2}", end_time=60e-6 / rate + 0.25e-3)
        row, _ = run_told(hampm, text.replace("-7.5e-3", f"-{rate / 2}"))
        load, _, length, _, _ = bench.dcb_errors(row, compliance, rate)
        print(rate, load, length)
        off.append(load)
        assert -2.5e-3 < length < 0
    assert 0 < off[1] < 0.6 * off[0] < 0.15


def test_a_crack_keeps_pace_with_its_load_in_implicit_steps(hampm):
    """The beam that splits slowly, in steps in which the crack passes a cell or two: G is the toughness at the end of each, and the load comes to that at
    rest as the ends move more slowly; it is above that by a part that is about proportional to their speed. Bonds take what G says, and the audit closes. The arms are at rest also with
    more damping by the method: what nodes keep goes over to the cells that are cut anew (they swung with a hundred times the strain energy, and later the load by 6 %)."""
    compliance = bench.dcb_compliance(lambda text: run_told(hampm, text)[0])
    off = {}
    for rate, dt, alpha in ((0.06, 5e-5, -0.1), (0.015, 2e-4, -0.1), (0.004, 1e-3, -0.1), (0.004, 1e-3, -0.3)):
        text = bench.example("dcb_growth_dynamic", velocity=f"0.0, {rate / 2}", end_time=np.ceil((60e-6 / rate + 0.25e-3) / dt) * dt).replace("-7.5e-3", f"-{rate / 2}")
        text = text.replace("'domain_integral'", "'domain_integral'  energy_balance = .true.")
        row, _ = run_told(hampm, text, words=("--set", "method.time=implicit", "--set", f"method.time_step={dt}", "--set", f"method.hht_alpha={alpha}",
                                                   "--set", f"output.history_interval={dt}"))
        load, scatter, length, _, kinetic = bench.dcb_errors(row, compliance, rate)
        late = row["tip_x"] > 55e-3
        taken = row["fracture_energy"][-1] / row["integral_of_G"][-1]
        print(rate, alpha, row["step"][-1], load, scatter, length, kinetic, taken, np.max(np.abs(row["G"][late] - 1)))
        assert row["step"][-1] < 32
        assert taken == pytest.approx(1, abs=0.1)
        assert kinetic < 0.002 + (rate / 0.3)**2
        assert residual(row) < 1e-10
        assert row["G"][late] == pytest.approx(1.0, abs=0.05)
        assert np.mean(row["G"][late]) == pytest.approx(1.0, abs=0.01)
        assert scatter < (0.01 if rate < 0.02 else 0.06)
        off.setdefault(rate, []).append(load)
    assert all(0 < value < 0.01 for value in off[0.004])
    assert off[0.004][0] < off[0.015][0] / 2 and off[0.015][0] < off[0.06][0] / 3 < 0.03


def growth_in_shear(sign):
    """A slanted crack in a sheet under shear, or its mirror image in y."""
    low, high = sorted((0.0, 0.0107421875 * sign))
    return f"""
        &run plane = 'strain'  end_time = 8.642e-3  thickness = 3 /
        &grid lower = -0.0009765625, {low - 0.0009765625}  cell = 0.0009765625  cells = 16, 13 /
        &material name = 'a'  young = 1e4  poisson = 0.25  density = 2000 /
        &body material = 'a'  lower = 0, {low}  upper = 0.013671875, {high} /
        &crack kind = 'path'  points = 0.005401532113528166, {sign * 0.004660605243162005}, 0.007293780386471834, {sign * 0.006081582256837995} /
        &growth law = 'prescribed'  direction = 'straight'  tips = 'last'  speed = 1.265  start = 1.73e-3  end = 6.9e-3 /
        &constraint lower = 0, {low}  upper = 0, {high}  fix = 'x' /
        &load kind = 'traction'  force = 0, {sign * 5.3e-3}  lower = 0, {sign * 0.0107421875}  upper = 0.01171875, {sign * 0.0107421875} /
        &method time = 'implicit'  time_step = 2.16e-4  mass = 'consistent' /
        &energy_release estimators = 'domain_integral'  energy_balance = .true. /
        &output history_interval = 2.16e-4 /"""


def growth_that_turns(sign):
    """Two cracks in a plate that is thrown; one turns by 80 degrees as it grows, out of cells that its first cut divides in another way."""
    low, high = sorted((0.0, 0.014 * sign))
    return f"""
        &run plane = 'strain'  end_time = 2.0e-5 /
        &grid lower = -0.0085, {low - 0.001}  cell = 0.001  cells = 14, 16 /
        &material name = 'a'  young = 3e9  poisson = 0.3  density = 1200 /
        &body material = 'a'  lower = -0.0075, {low}  upper = 0.0045, {high}  velocity = 0.3896889470348655, {sign * 0.49561140156330447} /
        &crack kind = 'path'  name = 'c0'  points = -0.005567413105567406, {sign * 0.004597189357906404}, -0.0030945610212841147, {sign * 0.0060248911744334895}
            contact = 'none' /
        &crack kind = 'path'  name = 'c1'  points = -0.0003423436501217676, {sign * 0.007657656349878233}, 0.002342343650121768, {sign * 0.010342343650121768}
            contact = 'none' /
        &growth law = 'prescribed'  direction = 'hoop_stress'  tips = 'all'  crack = 'c0'  speed = 79.05694150420949  start = 1.1376087618529573e-05 /
        &constraint lower = -0.0075, 0  upper = -0.0075, 0  fix = 'xy' /
        &constraint lower = 0.0045, 0  upper = 0.0045, 0  fix = 'y' /
        &load kind = 'pressure'  pressure = -1777066.34911729  lower = 0.0045, {low}  upper = 0.0045, {high}
            history = 'ramp'  start = 5.688043809264786e-06  rise_time = 0.00011376087618529573 /
        &method time = 'implicit'  time_step = 1.4220109523161966e-06 /
        &refine indicator = 'tip'  max_level = 2  max_particles = 4000  rings = 4 /
        &energy_release estimators = 'domain_integral'  energy_balance = .true. /
        &output history_interval = 1.4220109523161966e-06 /"""


@pytest.mark.parametrize("scene", [growth_in_shear, growth_that_turns])
def test_growth_in_implicit_steps_has_its_mirror_image(hampm, scene):
    """What nodes and what holds small pieces of cells keep goes on on new cuts, each piece by itself: springs that were new began at nothing, or with what the piece on the
    other side of the crack had (3e-6 of the energy in the first step that cuts cells anew); a node in the middle of two particles from different cells took its displacement
    from the first of them (K_I 4e-4 off in the step after that)."""
    rows = [run_told(hampm, scene(sign))[0] for sign in (1, -1)]
    assert residual(rows[0]) < 1e-9
    for name in ("strain_energy", "kinetic_energy", "fracture_energy", "J", "crack_opening"):
        assert np.abs(rows[0][name]) == pytest.approx(np.abs(rows[1][name]), abs=1e-9 * np.max(np.abs(rows[0][name]))), name


def pressed_and_sheared(shear, contact, method):
    """A crack across a plate under pressure and shear, which grows at one end once both have come."""
    side = "history = 'ramp'  rise_time = 8e-5 /"
    return f"""
        &run plane = 'strain'  end_time = 1.2e-4 /
        &grid lower = -0.02, -0.02  cell = 1e-3  cells = 40, 40 /
        &material name = 'a'  young = 200e9  poisson = 0.3  density = 7800 /
        &body material = 'a'  lower = -0.02, -0.02  upper = 0.02, 0.02 /
        &constraint lower = -0.02, -0.02  upper = 0.02, -0.02  fix = 'xy' /
        &load kind = 'traction'  lower = -0.02, 0.02  upper = 0.02, 0.02  force = 0, -10e6  history = 'ramp'  rise_time = 4e-5 /
        &load kind = 'traction'  lower = -0.02, 0.02  upper = 0.02, 0.02  force = {shear}, 0  {side}
        &load kind = 'traction'  lower = 0.02, -0.02  upper = 0.02, 0.02  force = 0, {shear}  {side}
        &load kind = 'traction'  lower = -0.02, -0.02  upper = -0.02, 0.02  force = 0, {-shear}  {side}
        &crack kind = 'path'  points = -8.1e-3, 0.4e-3, 6.2e-3, 0.4e-3  contact = {contact} /
        &growth law = 'prescribed'  direction = 'straight'  tips = 'last'  speed = 200  start = 9e-5  end = 1.1e-4 /
        &damping rate = 1.5e5 /
        &method {method} /
        &energy_release estimators = 'domain_integral'  energy_balance = .true. /
        &output history_interval = 2e-6 /"""


@pytest.mark.parametrize("method", ["courant = 0.3", "time = 'implicit'  time_step = 2e-6"], ids=["explicit", "implicit"])
def test_faces_that_open_in_growth_press_and_rub(hampm, method):
    """Bonds that had let go bore no pressure, until cells were cut anew, four cells further: then faces that had gone through each other sprang apart (energy of 33 J in 600 J came from nothing).
    Faces that slide everywhere under a pressure p are those without friction under a shear that is smaller by mu p: 7 of 10 MN, with mu = 0.3. Friction takes mu p times the area that slides has."""
    rubbed, free = (run_told(hampm, pressed_and_sheared(*of, method))[0] for of in ((10e6, "'friction'  friction = 0.3"), (7e6, "'frictionless'")))
    for row in (rubbed, free):
        step = np.diff(row["numerical_loss"])
        print(np.min(step), np.max(step), row["numerical_loss"][-1], row["external_work"][-1])
        assert residual(row) < 1e-9
        assert np.max(np.abs(step)) < 3e-3 * row["external_work"][-1]
    for name in ("K_II", "K_II_tip2", "mouth_sliding"):
        print(name, rubbed[name][-1], free[name][-1])
    assert rubbed["K_II"][-1] == pytest.approx(free["K_II"][-1], rel=0.06)  # of a tip that grows, by J
    assert rubbed["K_II_tip2"][-1] == pytest.approx(free["K_II_tip2"][-1], rel=0.03)
    assert rubbed["mouth_sliding"][-1] == pytest.approx(free["mouth_sliding"][-1], rel=0.02)
    assert np.all(np.diff(rubbed["friction_loss"]) >= 0)
    ellipse = math.pi / 4 * (14.3e-3 + 4e-3) * free["mouth_sliding"][-1] * 0.3 * 10e6 / 0.04
    print("friction takes", rubbed["friction_loss"][-1], "of an ellipse", ellipse)
    assert rubbed["friction_loss"][-1] == pytest.approx(ellipse, rel=0.05)


def test_faces_that_rub_know_no_order_of_points(hampm):
    """Bonds follow the way of a tip, contact the points of its crack: what a bond bore came with the wrong sign to a crack whose first end grows (K_II 3 % off)."""
    text = pressed_and_sheared(10e6, "'friction'  friction = 0.3", "time = 'implicit'  time_step = 2e-6").replace("cell = 1e-3  cells = 40, 40", "cell = 2e-3  cells = 20, 20")
    text = text.replace("speed = 200  start = 9e-5", "speed = 250  start = 7e-5").replace("end_time = 1.2e-4", "end_time = 1.1e-4")
    one, other = (run_told(hampm, text.replace("-8.1e-3, 0.4e-3, 6.2e-3, 0.4e-3", points).replace("'last'", tips))[0]
                  for points, tips in (("-8.1e-3, -1.9e-3, 6.2e-3, 2.7e-3", "'last'"), ("6.2e-3, 2.7e-3, -8.1e-3, -1.9e-3", "'first'")))
    for name in ("strain_energy", "kinetic_energy", "friction_loss", "fracture_energy", "mouth_sliding"):
        assert other[name] == pytest.approx(one[name], rel=0, abs=1e-6 * np.max(np.abs(one[name]))), name  # points slide by rounding at the edge of the cone


@pytest.mark.verify
def test_a_crack_that_runs_in_mixed_mode(hampm):
    """At 30 degrees to the grid, under a wave that meets it aslant."""
    speed = 0.33 * bench.RAYLEIGH
    text, met = bench.slanted_scene(0.25e-3, speed)
    row, _ = run_told(hampm, text)
    opening, sliding = bench.slanted_errors(row, met, speed, 0.25e-3)
    own = bench.slanted_errors({**row, **{k: row[f"{k}_by_fields"] for k in ("K_I", "K_II")}}, met, speed, 0.25e-3)
    print(np.mean(opening), np.std(opening), np.mean(sliding), np.std(sliding), "by fields", [(np.mean(one), np.std(one)) for one in own])
    assert all(abs(np.mean(one)) < 0.045 for one in own)
    assert len(opening) > 10
    assert abs(np.mean(opening)) < 0.02 and np.std(opening) < 0.05
    assert abs(np.mean(sliding)) < 0.045 and np.std(sliding) < 0.05
    assert row["tip_angle"] == pytest.approx(30)


@pytest.mark.verify
@pytest.mark.parametrize("frame", ["total", "updated"])
def test_the_equation_of_motion(hampm, frame):
    """By the toughness: its place to 0.3 cells, its speed to 1.5 % of Rayleigh waves, G to 3 %, from the start on, which is in time. In the updated frame it came 4 % too short, and 9.6 % in cells half as large: masses that
    were lumped at its faces radiated waves of the cells, for which G paid."""
    toughness = bench.exact_growth()[3]
    text = bench.plate(0.2e-3, f"law = 'toughness'  toughness = {toughness}", audit=True)
    row, _ = run_told(hampm, text.replace("&method", f"&method frame = '{frame}' "))
    way, speed, ratio, scatter = bench.by_toughness(row)
    print(way, speed, ratio, scatter)
    time, growth, _, _ = bench.exact_growth()
    seen = row["time"] > 1.7 * bench.ARRIVAL
    off = (row["tip_x"] - np.interp(row["time"], time, growth))[seen] / 0.2e-3
    print(off.min(), off.max())
    assert np.all(np.abs(off) < 0.3)
    assert abs(way) < 0.02
    assert speed < 0.015
    assert ratio == pytest.approx(1, abs=0.03)
    assert scatter < 0.03
    assert residual(row) < 1e-12
    assert np.all(row["toughness"] == toughness)
    assert row["fracture_energy"][-1] == pytest.approx(toughness * row["tip_x"][-1], rel=0.03)


@pytest.mark.parametrize("method", ["", "time = 'implicit'  time_step = 5e-8"])
def test_a_tip_that_may_turn_runs_as_one_that_may_not(hampm, method):
    """Under loads that open it alone. In implicit steps K_I**2/E' of a running tip was held at the toughness, which is above its G by A_I of its speed: 13 % too short a way."""
    text = bench.plate(0.4e-3, f"law = 'toughness'  toughness = {bench.exact_growth()[3]}").replace("&method", f"&method {method} ")
    straight, turning = (run_told(hampm, text.replace("direction = 'straight'", f"direction = '{direction}'"))[0] for direction in ("straight", "hoop_stress"))
    print(straight["tip_x"][-1], turning["tip_x"][-1], straight["time"][-1] / bench.ARRIVAL)
    assert turning["tip_x"][-1] > 3e-3
    assert turning["tip_x"][-1] == pytest.approx(straight["tip_x"][-1], rel=0.02)


@pytest.mark.verify
@pytest.mark.parametrize("angle", [30, 60])
def test_a_sharp_kink_at_a_given_speed(hampm, angle):
    """K of the first two cells of a kink, whose domains hold the crack before it, are within their errors those of the kink once domains fit behind it; G had any sign there."""
    cell, at = 0.2e-3, math.radians(angle)
    text = bench.plate(cell, f"law = 'prescribed'  speed = 800.0  start = 2.4e-6  points = {8e-3 * math.cos(at)}, {8e-3 * math.sin(at)}").replace("'straight'", "'path'")
    row, _ = run_told(hampm, text)
    grown, rest = (row["crack_length"] - row["crack_length"][0]) / cell, np.maximum(bench.intensity_at_rest(row["time"]), 1.0)
    short, long = (grown > 0) & (grown < 2), (grown > 4) & (grown < 6)
    assert np.count_nonzero(short) > 20 < np.count_nonzero(long)
    for name in ("K_I", "K_II"):
        values, errors = row[name] / rest, row[f"{name}_error"] / rest
        print(name, np.mean(values[short]), np.mean(errors[short]), np.mean(values[long]), np.std(values[long]))
        assert np.mean(np.abs(values[short] - np.mean(values[long])) < errors[short] + 0.02) > 0.9, name
        assert np.mean(errors[short]) < 0.3


STRIP = """&run plane = 'stress'  end_time = {end} /
&grid lower = -40e-3, -11e-3  cell = 1e-3  cells = 75, 22 /
&material name = 'a'  young = 70e9  poisson = 0.3  density = 2700 /
&body material = 'a'  lower = -40e-3, -10e-3  upper = 35e-3, 10e-3 /
&constraint lower = -40e-3, 10e-3  upper = 35e-3, 10e-3  fix = 'xy'  displacement = 0.0, 2e-6 /
&constraint lower = -40e-3, -10e-3  upper = 35e-3, -10e-3  fix = 'xy'  displacement = 0.0, -2e-6 /
&constraint lower = 35e-3, -10e-3  upper = 35e-3, 10e-3  fix = 'x' /
&method start = 'static'  mass = 'weighted' /
&crack kind = 'path'  points = -40e-3, 0.0, 0.0, 0.0 /
&growth law = 'toughness'  direction = 'straight'  toughness = 15.3846  limit_speed = {limit} /
&energy_release estimators = 'domain_integral'  energy_balance = .true. /
&output file = 'strip.h5'  history_interval = {interval} /
"""


@pytest.mark.parametrize(("part", "way"), [(0.2, 14e-3), *(pytest.param(*case, marks=pytest.mark.verify) for case in [(0.02, 6e-3), (0.1, 14e-3), (0.6, 25e-3)])])
def test_a_tip_takes_the_speed_of_its_toughness(hampm, part, way):
    """A strip with fixed edges has G = M u_0**2/h at any speed (Nilsson 1974), 30.769 J/m2: by toughness/(1 - v/limit) of half of that at rest the tip runs at half
    of the limit. Tips that followed their bonds stopped in it, with up to 8 times their toughness. Errors know of a swing of G that is slower than the waves that cells
    cannot carry: at a tenth of the speed of Rayleigh waves they held half of the values."""
    speed = part * 2886
    end = way / speed
    row, said = run_told(hampm, STRIP.format(end=end, limit=2 * speed, interval=end / 100))
    late = row["time"] > 0.4 * end
    mean = (row["tip_x"][late][-1] - row["tip_x"][late][0]) / (row["time"][late][-1] - row["time"][late][0])
    ratio = (row["G"] / row["toughness"])[late]
    print(part, mean / speed, np.std(row["tip_speed"][late]) / speed, np.mean(ratio), np.std(ratio), row["fracture_energy"][-1] / row["integral_of_G"][-1])
    assert mean == pytest.approx(speed, rel=0.02)
    assert np.mean(ratio) == pytest.approx(1, abs=0.01) and np.std(ratio) < 0.03
    assert residual(row) < 1e-11
    assert "too coarse" not in said
    off, told = np.abs(row["G"] - 30.769)[late], row["G_error"][late]
    print("G held", np.mean(off <= told), np.median(told) / np.median(off))
    assert np.mean(off <= told) >= 0.9 and np.median(told) < 5 * np.median(off)


@pytest.mark.verify
def test_a_crack_rests_at_what_is_tougher(hampm):
    """A wave drives it into a body with 3.6 times its toughness, where it is at rest from 5.234 to 6.342 us by g(v) K(t, 0)**2/E' = toughness. A tip that followed its
    bonds crept on at 100 to 400 m/s. From there on it goes to 2.164 mm at 8.405 us: forces of failing points that did not follow K at rest let it run 0.57 cells too far."""
    text = ARREST.format(loads="\n".join(f"&load kind = 'traction'  lower = {a}, {y}  upper = {b}, {y}  force = 0.0, {np.sign(y) * 0.5e6 * (b - a)} /"
                                          for a, b in ((-12e-3, 1.2e-3), (1.2e-3, 14.88e-3)) for y in (12e-3, -12e-3)))
    row, _ = run_told(hampm, text, "run.end_time=8.405e-6")
    rests = (row["time"] > 5.35e-6) & (row["time"] < 6.3e-6)
    print(row["tip_x"][rests], row["time"][np.flatnonzero(row["tip_speed"] > 0)])
    assert np.all(row["tip_speed"][rests] == 0) and np.ptp(row["tip_x"][rests]) == 0
    assert row["tip_x"][rests][0] == pytest.approx(1.2e-3, abs=0.06e-3)
    again = row["time"][(row["time"] > 5.3e-6) & (row["tip_speed"] > 0)][0]
    assert again == pytest.approx(6.342e-6, abs=0.24e-3 / 2390)
    assert row["tip_x"][-1] == pytest.approx(2.164e-3, abs=0.3 * 0.24e-3)


ARREST = """&run plane = 'strain'  end_time = 7e-6 /
&grid lower = -12e-3, -12.24e-3  cell = 0.24e-3  cells = 112, 102 /
&material name = 'm'  young = 100e9  poisson = 0.25  density = 7000 /
&body material = 'm'  lower = -12e-3, -12e-3  upper = 1.2e-3, 12e-3 /
&body material = 'm'  lower = 1.2e-3, -12e-3  upper = 14.88e-3, 12e-3  toughness = 0.151261 /
&constraint lower = -12e-3, -12e-3  upper = -12e-3, 12e-3  fix = 'x' /
&constraint lower = 14.88e-3, -12e-3  upper = 14.88e-3, 12e-3  fix = 'x' /
{loads}
&method mass = 'weighted' /
&crack kind = 'path'  points = -12e-3, 0.0, 0.0, 0.0 /
&growth law = 'toughness'  toughness = 0.0420169  direction = 'straight' /
&energy_release estimators = 'domain_integral'  energy_balance = .true. /
&output file = 'arrest.h5'  history_interval = 2.8e-8 /
"""


def test_a_faster_crack_may_be_tougher(hampm):
    """toughness/(1 - speed/limit_speed): the speed stays below the limit."""
    growth = f"law = 'toughness'  toughness = {bench.exact_growth()[3]}  limit_speed = 1000.0"
    row, _ = run_told(hampm, bench.plate(0.2e-3, growth))
    late = row["time"] > 2.3 * bench.ARRIVAL
    assert 300 < np.mean(row["tip_speed"][late]) < 1000
    assert row["toughness"] == pytest.approx(bench.exact_growth()[3] / (1 - row["tip_speed"] / 1000), rel=1e-12)
    assert np.mean(row["G"][late] / row["toughness"][late]) == pytest.approx(1, abs=0.1)


@pytest.mark.verify
@pytest.mark.parametrize("mass", ["lumped", "auto"])
def test_a_strip(hampm, mass):
    """Three heights after the start G is the energy stored ahead. With the default masses it is the nearer to that, and single samples scatter by 2.1 % for 1.7: means over
    four cells by 0.8 %. Bonded points take 0.98 of it, by lumped masses 0.94."""
    speed = 0.4 * bench.RAYLEIGH
    row, _ = run_told(hampm, bench.example("strip_growth", end_time=70e-6 + 40e-3 / speed) + f"&method mass = '{mass}' /\n")
    there = row["tip_x"] > 30e-3
    scattering = row["J" if mass == "lumped" else "G_moving_average"][there] / 26.922
    print(mass, np.mean(row["J"][there]) / 26.922, np.mean(scattering), np.std(scattering))
    assert np.mean(row["J"][there]) == pytest.approx(26.922, rel=0.01)
    assert np.std(scattering) < (0.02 if mass == "lumped" else 0.01)
    assert np.all(np.abs(row["G_moving_average"][there] - 26.922) <= row["G_moving_average_error"][there])


def mirrored(text):
    """The plate of Kalthoff in y < 0."""
    for above, below in (("lower = 0.0, 0.0\n   cell", "lower = 0.0, -0.102\n   cell"), ("0.0, 0.025, 0.05, 0.025", "0.0, -0.025, 0.05, -0.025"),
                         ("lower = 0.0, 0.0\n   upper = 0.1, 0.1", "lower = 0.0, -0.1\n   upper = 0.1, 0.0"),
                         ("lower = 0.0, 0.0\n   upper = 0.0, 0.025", "lower = 0.0, -0.025\n   upper = 0.0, 0.0")):
        assert text.count(above) == 1
        text = text.replace(above, below)
    return text


def test_the_plate_of_kalthoff(hampm):
    """K before growth to 3.5 % of the peak with cells of 1 mm, the start at 15.85 us of the reference, and the first kink, in smaller cells too. G of the short kink, which domains
    hold together with the slit, is the toughness, and faces take that times their area. In the mirror image the same."""
    scene = bench.example("kalthoff", end_time=20e-6)
    row, _ = run_told(hampm, scene)
    errors = bench.kalthoff_errors(row)
    moves = np.flatnonzero(row["crack_length"] > 0.0500001)[0]
    rate, taken = row["G"][moves:] / 22146, row["fracture_energy"][-1] / (22146 * (row["crack_length"][-1] - 0.05))
    print(errors, 1e6 * row["time"][moves], row["tip_angle"][moves], rate.min(), rate.max(), taken)
    assert np.all(errors < 0.035)
    assert 15.5e-6 < row["time"][moves] < 16.5e-6
    assert row["tip_angle"][moves] == pytest.approx(77.6, abs=2)
    assert rate[2:] == pytest.approx(1, abs=0.05) and taken == pytest.approx(1, abs=0.1)
    image, _ = run_told(hampm, mirrored(scene))
    for name, sign in (("K_I", 1), ("K_II", -1), ("crack_length", 1), ("tip_angle", -1), ("fracture_energy", 1)):
        assert sign * image[name] == pytest.approx(row[name], abs=1e-9 * np.max(np.abs(row[name]))), name
    fine = bench.example("kalthoff", end_time=17.5e-6).replace("radii = 4.0e-3, 6.0e-3, 8.0e-3", "radii = 2.0e-3, 3.0e-3, 4.0e-3")
    row, _ = run_told(hampm, fine + "&refine indicator = 'tip'  max_level = 1  rings = 10 /\n")
    moves = np.flatnonzero(row["crack_length"] > 0.0500001)[0]
    print(1e6 * row["time"][moves], row["tip_angle"][moves])
    assert 15.5e-6 < row["time"][moves] < 16.5e-6
    assert row["tip_angle"][moves] == pytest.approx(77.6, abs=2)


PLATE = """\
&run plane = 'strain'  end_time = 8e-6 /
&grid lower = -10e-3, -10.5e-3  cell = 0.5e-3  cells = 40, 42 /
&material name = 'a'  young = 200e9  poisson = 0.3  density = 8000 /
&body material = 'a'  lower = -10e-3, -10e-3  upper = 10e-3, 10e-3 /
&load kind = 'traction'  lower = -10e-3, 10e-3  upper = 10e-3, 10e-3  force = 0.0, 20e3 /
&load kind = 'traction'  lower = -10e-3, -10e-3  upper = 10e-3, -10e-3  force = 0.0, -20e3 /
&method {method} /
&refine max_particles = 1000000 {refine} /
&crack kind = 'path'  points = -2e-3, -1e-3, 2e-3, 1e-3 {crack} /
{growth}
&energy_release estimators = 'domain_integral'  energy_balance = .true. /
&output history_interval = 0.16e-6  snapshot_interval = 4e-6 /
"""
GIVEN = "&growth law = 'prescribed'  speed = 600.0  start = 2e-6  direction = 'straight' {} /"


def plate(growth=GIVEN.format(""), method="", refine="", crack=""):
    return PLATE.format(growth=growth, method=method, refine=refine, crack=crack)


LEVEL = "indicator = 'tip'  max_level = 1  rings = 8"
MANY = [("", "", ""), ("mass = 'consistent'", "", ""), ("mass = 'weighted'", LEVEL, ""), ("scheme = 'usf'", "", "contact = 'frictionless'"),
        ("scheme = 'usl'", LEVEL, ""), ("scheme = 'usavg'", "", ""), ("frame = 'updated'", "", ""),
        ("frame = 'updated'  mass = 'weighted'", LEVEL, "contact = 'frictionless'")]


@pytest.mark.parametrize(("method", "refine", "crack"), MANY)
def test_both_tips_of_a_slanted_crack(hampm, method, refine, crack):
    """They are images of each other, the energy balance closes, and the way is that of the speed."""
    row, _ = run_told(hampm, plate(method=method, refine=refine, crack=crack))
    assert residual(row) < 1e-12
    assert row["crack_length"][-1] == pytest.approx(2 * math.hypot(2e-3, 1e-3) + 2 * 600 * 6e-6, rel=1e-9)
    assert row["tip_x_tip2"] == pytest.approx(-row["tip_x"], abs=1e-12)
    assert row["K_I_tip2"][-1] == pytest.approx(row["K_I"][-1], rel=0.02)
    assert row["K_II_tip2"][-1] == pytest.approx(row["K_II"][-1], rel=0.03)
    assert row["tip_angle"] == pytest.approx(math.degrees(math.atan2(1, 2)))
    assert row["tip_speed"][-1] == pytest.approx(600, rel=1e-6)


@pytest.mark.parametrize("crack", ["", "contact = 'frictionless'"])
def test_samples_and_steps_share_what_they_solve(hampm, crack):
    """A sample takes the acceleration of the next step from a factorised mass matrix, and adds what the points between faces make of it. By conjugate gradients each solves for itself: the
    same numbers, whether every step or every seventh is looked at."""
    rows = []
    for solver, interval in (("direct", 0.4e-6 / 7), ("cg", 0.4e-6), ("direct", 0.4e-6)):
        text = plate(method=f"mass = 'weighted'  solver = '{solver}'", crack=crack).replace("end_time = 8e-6", "end_time = 4e-6")
        rows.append(run_told(hampm, re.sub(r"history_interval = \S+", f"history_interval = {interval}", text))[0])
    assert len(rows[0]["time"]) - 1 == rows[0]["step"][-1] == rows[2]["step"][-1] == 7 * (len(rows[2]["time"]) - 1)
    assert np.count_nonzero(rows[2]["tip_speed"]) > 3
    for name in ("J", "K_I", "K_II", "crack_opening"):
        largest = np.max(np.abs(rows[0][name]))
        print(name, np.max(np.abs(rows[1][name] - rows[2][name])) / largest, abs(rows[0][name][-1] - rows[2][name][-1]) / largest)
        assert rows[1][name] == pytest.approx(rows[2][name], abs=1e-9 * largest), name
        assert rows[0][name][-1] == pytest.approx(rows[2][name][-1], abs=1e-9 * largest), name


@pytest.mark.parametrize("direction", ["hoop_stress", "local_symmetry", "max_energy"])
def test_a_slanted_crack_turns(hampm, direction):
    """Across the tension: the tips go on level. Single samples of K_II ring by up to 0.16 of K_I with lumped masses."""
    row, _ = run_told(hampm, plate(GIVEN.format("").replace("straight", direction), refine=LEVEL))
    ratio = row["K_II"][-24:] / row["K_I"][-24:]
    print(row["tip_angle"][-1], np.sqrt(np.mean(ratio**2)), np.mean(ratio))
    assert residual(row) < 1e-12
    assert abs(row["tip_angle"][-1]) < 8
    assert np.sqrt(np.mean(ratio**2)) < 0.06
    assert abs(np.mean(ratio)) < 0.02


def flying(text, velocity):
    """The plate in the updated frame, with room to fly."""
    for before, after in (("lower = -10e-3, -10.5e-3  cell", "lower = -12e-3, -12e-3  cell"), ("cells = 40, 42", "cells = 48, 48"),
                          ("upper = 10e-3, 10e-3 /\n&load", f"upper = 10e-3, 10e-3  velocity = {velocity} /\n&load"), ("&method", "&method frame = 'updated'")):
        assert text.count(before) == 1, before
        text = text.replace(before, after)
    return text


def test_a_crack_that_the_body_carries_has_turned(hampm):
    """Across the largest hoop stress: of K_II before the turn, a third of K_I, nothing is left right behind it, where domains are wider than the way since then."""
    row, _ = run_told(hampm, flying(plate(GIVEN.format("").replace("straight", "hoop_stress")), "0.0, 0.0").replace("end_time = 8e-6", "end_time = 4e-6"))
    first = np.flatnonzero(row["tip_speed"] > 0)[0]
    before, right_behind = row["K_II"][first - 1] / row["K_I"][first - 1], slice(first, first + 10)
    left = np.mean(row["K_II"][right_behind]) / np.mean(row["K_I"][right_behind])
    print(before, left, row["tip_angle"][first])
    assert before > 0.3 and abs(left) < 0.01


@pytest.mark.parametrize("law", ["law = 'prescribed'  speed = 600.0  start = 2e-6", "law = 'toughness'  toughness = 0.05"])
def test_a_crack_grows_in_a_plate_that_flies(hampm, law):
    """At 60 m/s it goes through a cell in 8 us. Its way is as in the total frame; energy is kept; K rings as its tips go from cell to cell. By the toughness bonded points take that times the
    area in both frames, to 5 %, up to where the plate is in two. Masses are weighted: lumped ones at the faces of such fast tips radiate a fifth of it."""
    text = plate(f"&growth {law}  direction = 'straight' /", "mass = 'lumped'" if "prescribed" in law else "mass = 'weighted'")
    still, _ = run_told(hampm, text)
    row, said = run_told(hampm, flying(text, "60.0, -40.0"))
    late = row["time"] > 4e-6
    missing = residual(row) * np.max(row["external_work"]) / np.max(row["kinetic_energy"])
    print(missing, row["crack_length"][-1], still["crack_length"][-1], np.std(row["K_I"][late] / still["K_I"][late]))
    assert missing < 1e-12
    assert row["crack_length"][-1] == pytest.approx(still["crack_length"][-1], rel=1e-9 if "prescribed" in law else 0.05)
    assert "too coarse for its toughness" not in said and "faces have taken" not in said
    if "prescribed" in law:
        assert np.mean(row["K_I"][late] / still["K_I"][late]) == pytest.approx(1, abs=0.06)
        assert row["fracture_energy"][-1] == pytest.approx(still["fracture_energy"][-1], rel=0.05)
        return
    for of in (still, row):
        taken = of["fracture_energy"][-1] / (0.05 * (of["crack_length"][-1] - of["crack_length"][0]))
        print(taken)
        assert taken == pytest.approx(1, abs=0.05)


def test_a_tip_that_its_cells_cannot_slow_down_says_so(hampm):
    """At the speed of Rayleigh waves G of a tip is 0.10 of what it would be at rest after 15 cells, 0.02 in a continuum: a toughness below that is not met, in either frame."""
    row, said = run_told(hampm, plate("&growth law = 'toughness'  toughness = 0.01  direction = 'straight' /").replace("end_time = 8e-6", "end_time = 4e-6"))
    running = row["time"] > 3e-6
    print(np.mean(row["G"][running]) / 0.01)
    assert "tip 1 is in cells that are too coarse for its toughness" in said
    assert np.mean(row["G"][running]) > 2 * 0.01


@pytest.mark.parametrize("frame", ["total", "updated"])
def test_a_cut_shakes_no_tip_that_waits(hampm, frame):
    """Cells ahead of a tip are cut while it rests, and bonded points begin with forces by which both faces go on as one: K stays that of a crack at rest up to the start, to 6 % (25 % with
    the mean traction of the material; momentary values), and the start is in time. A tip that does not come near its toughness has K of one without growth to the last digit."""
    toughness = bench.exact_growth()[3]

    def of(growth):
        return run_told(hampm, bench.plate(0.4e-3, growth, audit=True).replace("&method", f"&method frame = '{frame}' "))[0]
    row = of(f"law = 'toughness'  toughness = {toughness}")
    time, way, _, _ = bench.exact_growth()
    rests = (row["time"] > 1.2 * bench.ARRIVAL) & (row["tip_x"] <= 0)
    asked = bench.intensity_at_rest(row["time"])
    seen = row["time"] > 1.7 * bench.ARRIVAL
    off = (row["tip_x"] - np.interp(row["time"], time, way))[seen] / 0.4e-3
    taken = row["fracture_energy"][-1] / row["integral_of_G"][-1]
    print(np.max(np.abs(row["K_I"] / np.maximum(asked, 1) - 1)[rests]), np.min(off), np.max(off), taken)
    assert np.max(np.abs(row["K_I"] / np.maximum(asked, 1) - 1)[rests]) < 0.06
    assert np.all(np.abs(off) < 0.3)
    assert taken == pytest.approx(1, abs=0.05)
    assert residual(row) < 1e-12
    most = np.max(asked)**2 * (1 - bench.POISSON**2) / bench.YOUNG
    waits, without = of(f"law = 'toughness'  toughness = {1.3 * most}"), of(f"law = 'toughness'  toughness = {100 * most}")
    assert np.max(waits["G"]) > 0.7 * waits["toughness"][-1]
    assert np.array_equal(waits["K_I"], without["K_I"])


@pytest.mark.verify
@pytest.mark.parametrize(("part", "taken"), [(0.33, 0.02), (0.6, 0.05)])
def test_a_crack_that_runs_in_the_updated_frame(hampm, part, taken):
    """K_I of a given speed in the mean and its scatter as in the total frame, and bonded points take what G says but for the first cells: 0.84 of it at 0.6 of Rayleigh waves with lumped masses
    at the faces. Energy is kept."""
    speed = part * bench.RAYLEIGH
    row, _ = run_told(hampm, bench.plate(0.2e-3, bench.given(speed), audit=True).replace("&method", "&method frame = 'updated' "))
    error, means = bench.running(row, speed, 0.2e-3)
    print(part, means, np.mean(error), np.std(error), row["fracture_energy"][-1] / row["integral_of_G"][-1])
    assert abs(np.mean(error)) < 0.01
    assert np.std(error) < 0.015
    assert row["fracture_energy"][-1] == pytest.approx(row["integral_of_G"][-1], rel=taken)
    assert residual(row) < 1e-12


def test_a_given_path(hampm, tmp_path):
    """Through its points, and straight on behind the last."""
    growth = GIVEN.format("points = 3e-3, 1.2e-3, 4e-3, 3e-3, 5e-3, 3e-3  tips = 'last'").replace("straight", "path")
    row, _ = run_told(hampm, plate(growth.replace("600.0", "900.0")))
    way = math.hypot(1e-3, 0.2e-3) + math.hypot(1e-3, 1.8e-3)
    end = np.array([4e-3 + 900 * 6e-6 - way, 3e-3])
    assert [row["tip_x"][-1], row["tip_y"][-1]] == pytest.approx(end, abs=1e-9)
    assert row["tip_x_tip2"][-1] == -2e-3
    # The crack is stored as a line through these points, up to the tip and not along what is cut ahead of it
    times, blocks = read_steps(tmp_path / "out.h5")
    corners = [(-2e-3, -1e-3), (2e-3, 1e-3), (3e-3, 1.2e-3), (4e-3, 3e-3)]
    assert times == pytest.approx([0, 4e-6, 8e-6])
    for time, (_, _, cracks), passed in zip(times, blocks, (1, 3, 4)):
        tip = [np.interp(time, row["time"], row[name]) for name in ("tip_x", "tip_y")]
        assert points(cracks)[:, :2] == pytest.approx(np.array(corners[:passed] + [tip]), abs=1e-9)
        assert list(field(cracks.point_data, "tip")) == [2] + (passed - 1) * [0] + [1]
        lines = [list(cell) for cell in cracks.cells]
        assert lines == [[k, k + 1] for k in range(passed)]


@pytest.mark.parametrize(("mass", "end", "crack", "more"), [
    ("weighted", 4e-6, "-1.83537e-3, -1.83864e-3, 2.58063e-3, 1.82701e-3", "tips = 'all'  points = 5.02e-3, 0.698e-3  toughness = 0.259"),
    ("consistent", 4e-6, "-1.49376e-3, -2.0496e-3, 2.39232e-3, 1.83648e-3",
     "tips = 'last'  points = 2.41e-3, -5.75e-3, 4.02e-3, 5.59e-3  toughness = 0.134")])
def test_usl_and_pieces_of_cells_that_few_particles_hold(hampm, mass, end, crack, more):
    """Cracks that turn sharply in cells, at the default time step: both were unstable at 0.9 of what is stable for cracks at rest."""
    text = f"""\
&run plane = 'strain'  end_time = {end} /
&grid lower = -10e-3, -10.5e-3  cell = 0.5e-3  cells = 40, 42 /
&material name = 'a'  young = 200e9  poisson = 0.4  density = 8000 /
&body material = 'a'  lower = -10e-3, -10e-3  upper = 10e-3, 10e-3 /
&method scheme = 'usl'  mass = '{mass}' /
&energy_release estimators = 'domain_integral'  energy_balance = .true. /
&output history_interval = {end / 20} /
&load kind = 'traction'  lower = -10e-3, 10e-3  upper = 10e-3, 10e-3  force = 100e3, 100e3 /
&crack kind = 'path'  name = 'c0'  points = {crack}  contact = 'frictionless' /
&growth crack = 'c0'  direction = 'path'  law = 'toughness'  {more}  max_length = 8.37e-3 /
"""
    row, _ = run_told(hampm, text)
    assert row["crack_length"][-1] > row["crack_length"][0] and residual(row) < 1e-9


def assert_moves(speed, onset, arrest, dt):
    """A column of a speed tells when its tip began to move and, where that is at rest at the end, when it came to rest: to a step."""
    assert speed.attrs["onset_time"] == pytest.approx(onset, abs=1.01 * dt)
    assert speed.attrs.get("arrest_time", None) == (arrest and pytest.approx(arrest, abs=1.01 * dt))


def test_intervals_arrest_and_the_largest_length(hampm, tmp_path):
    """Several &growth of one crack; a crack that rests keeps its place, and one that is long enough says so."""
    first = "&growth law = 'prescribed'  speed = 600.0  start = 2e-6  end = 3e-6  direction = 'straight'  tips = 'last' /\n"
    second = "&growth law = 'prescribed'  speed = 1200.0  start = 4e-6  direction = 'hoop_stress'  tips = 'last'  max_length = 6.5e-3 /"
    row, said = run_told(hampm, plate(first + second))
    length = row["crack_length"]
    begin = 2 * math.hypot(2e-3, 1e-3)
    rest = (row["time"] > 3.05e-6) & (row["time"] < 3.99e-6)
    assert length[rest] == pytest.approx(begin + 600e-6, rel=1e-12)
    assert np.all(row["tip_speed"][rest] == 0)
    assert length[-1] == pytest.approx(6.5e-3, rel=1e-9)
    assert row["tip_angle"][-1] < 10
    assert "tip 1 no longer grows: the crack has its max_length" in said
    with h5py.File(tmp_path / "out.h5") as file:
        assert_moves(file["history/tip_speed"], 2e-6, 4e-6 + (6.5e-3 - begin - 600e-6) / 1200, row["dt"][-1])
        assert "tip 1 no longer grows: the crack has its max_length" in file["history"].attrs["warnings"]
    assert residual(row) < 1e-12


@pytest.mark.parametrize(("law", "method"), [("'prescribed'  speed = 600.0", ""), ("'prescribed'  speed = 600.0", "time = 'implicit'"),
                                             ("'toughness'  toughness = 0.01", ""), ("'toughness'  toughness = 0.1", "time = 'implicit'")])
def test_tips_share_what_is_left_of_the_largest_length(hampm, law, method):
    """The first tip does not take it all."""
    growth = f"&growth law = {law}  start = 2e-6  direction = 'straight'  max_length = 5.1e-3 /"
    row, said = run_told(hampm, plate(growth, method))
    print(row["crack_length"], row["tip_x"] + row["tip_x_tip2"])
    assert row["crack_length"][-1] == pytest.approx(5.1e-3, rel=2e-9)
    assert row["tip_x_tip2"][-1] == pytest.approx(-row["tip_x"][-1], rel=1e-6)
    for tip in 1, 2:
        assert f"tip {tip} no longer grows: the crack has its max_length" in said


def test_a_support_moves_from_the_start_as_the_crack_does(hampm):
    """In implicit steps its nodes have its velocity when the first cells are cut, and what is in them is not lost."""
    moved = "\n&constraint lower = -10e-3, 10e-3  upper = 10e-3, 10e-3  fix = 'y'  displacement = 0.0, 1e-7  history = 'ramp'  rise_time = 4e-6 /"
    row, _ = run_told(hampm, plate(GIVEN.format("").replace("2e-6", "0.0") + moved, "time = 'implicit'  time_step = 1e-7").replace("8e-6", "4e-6"))
    assert row["kinetic_energy"][0] > 0.01 * np.max(row["kinetic_energy"])
    assert residual(row) < 1e-12


def test_a_crack_stops_before_a_load(hampm, tmp_path):
    held = "\n&load kind = 'traction'  lower = 10e-3, 4e-3  upper = 10e-3, 6e-3  force = 1.0, 0.0 /"
    row, said = run_told(hampm, plate(GIVEN.format("").replace("600.0", "1800.0") + held))
    assert "tip 1 no longer grows: a cell further there is no room" in said
    assert row["tip_speed"][-1] == 0
    with h5py.File(tmp_path / "out.h5") as file:
        last = np.flatnonzero(row["tip_speed"])[-1]
        assert row["time"][last] <= file["history/tip_speed"].attrs["arrest_time"] <= row["time"][last + 1]
        assert file["history/tip_speed_tip2"].attrs["onset_time"] == pytest.approx(2e-6, abs=row["dt"][1])
    assert residual(row) < 1e-12


def test_a_crack_that_has_no_room_stops_where_it_is(hampm):
    """Beside a pin within the plate, nine cells before the edge; the other tip, with nothing beside it, runs through to that."""
    pin = "\n&constraint lower = 5.9e-3, 3.9e-3  upper = 6.6e-3, 4.6e-3  fix = 'x' /"
    row, said = run_told(hampm, plate(GIVEN.format("").replace("600.0", "1800.0") + pin))
    assert "tip 1 no longer grows: a cell further there is no room" in said
    assert math.hypot(5.9e-3 - row["tip_x"][-1], 3.9e-3 - row["tip_y"][-1]) > 2 * 0.5e-3
    assert 5e-3 < row["tip_x"][-1] < 5.9e-3
    assert row["tip_x_tip2"][-1] == pytest.approx(-10e-3, rel=1e-6)


@pytest.mark.parametrize(("law", "method", "steps"), [
    ("law = 'toughness'  toughness = 0.01", "time = 'implicit'  time_step = 2e-7  hht_alpha = -0.1", 14),
    ("law = 'prescribed'  speed = 600.0  start = 2e-6  direction = 'straight'", "mass = 'weighted'", 47),
    ("law = 'prescribed'  speed = 600.0  start = 2e-6  direction = 'straight'", "mass = 'weighted'", 48),
    ("law = 'prescribed'  speed = 600.0  start = 2e-6  direction = 'hoop_stress'", "", 47), ("law = 'toughness'  toughness = 0.01  direction = 'local_symmetry'", "", 47),
    ("law = 'toughness'  toughness = 0.01  direction = 'local_symmetry'", "frame = 'updated'", 47)])
def test_a_run_goes_on_from_a_checkpoint(hampm, tmp_path, law, method, steps):
    """In the midst of a release: the same bytes. Also after a step (48) whose sample has solved for the acceleration of the next one."""
    text = plate(f"&growth {law} /", method=method, refine=LEVEL).replace("0.5e-3  cells = 40, 42", "1e-3  cells = 20, 21")
    row, _ = run_told(hampm, text)
    assert np.count_nonzero(row["tip_speed"]) > 2
    run_told(hampm, text, code=5, words=("--steps", f"{steps}"), name="part")
    assert hampm("--resume", "part.h5.checkpoint", "--quiet").returncode == 0
    with h5py.File(tmp_path / "part.h5") as file:
        for name, values in row.items():
            assert np.array_equal(values, file["history"][name][:], equal_nan=True), name
        whole = h5py.File(tmp_path / "out.h5")["history/tip_speed"].attrs
        assert "onset_time" in whole and all(file["history/tip_speed"].attrs[name] == whole[name] for name in whole if name != "DIMENSION_LIST")


def test_threads_change_nothing(hampm):
    text = plate("&growth law = 'toughness'  toughness = 0.01 /", refine=LEVEL)
    one, _ = run_told(hampm, text, words=("--threads", "1"))
    two, _ = run_told(hampm, text, words=("--threads", "2"))
    for name, values in one.items():
        assert np.array_equal(values, two[name], equal_nan=True), name


def test_the_progress_line_tells_length_and_speed(hampm, tmp_path):
    """Of a crack that grows, in motion and at rest, and of no other."""
    (tmp_path / "growth.nml").write_text(plate())
    assert " crack 11.672 mm at 600 m/s step " in hampm("growth.nml", "--force").stdout
    (tmp_path / "growth.nml").write_text(plate(growth=""))
    assert " crack " not in hampm("growth.nml", "--force").stdout
    text = plate("&growth toughness = 1.0  increment = 1e-3  direction = 'straight' /", method="time = 'static'  load_steps = 2")
    (tmp_path / "growth.nml").write_text(text.replace("  energy_balance = .true.", "") +
                                         "&constraint lower = -10e-3, -10e-3  upper = -9.5e-3, 10e-3  fix = 'xy' /\n")
    assert re.search(r" left G 1.0 J/m2 crack 8.472 mm step 2 ", hampm("growth.nml", "--force").stdout)


def test_the_check_says_how_a_crack_grows(hampm, tmp_path):
    (tmp_path / "growth.nml").write_text(plate())
    said = hampm("growth.nml", "--check").stdout
    assert "growth          straight, at 600.0 m/s, 0.2" in said and "of that of Rayleigh waves, from 2.0e-6 s" in said


REFUSED = [(GIVEN.format("").replace("600.0", "4000.0"), "", "speed = 4000.0: must be below the speed of Rayleigh waves"),
           (GIVEN.format("").replace("speed = 600.0", ""), "", "law = 'prescribed' requires speed > 0"),
           (GIVEN.format("toughness = 1.0"), "", "toughness = 1.0 is not allowed with law = 'prescribed'"),
           (GIVEN.format("increment = 1e-3"), "", "increment = 1e-3 requires law = 'quasi_static'"),
           (GIVEN.format("tips = 'largest'"), "", "tips = 'largest' requires law = 'quasi_static'"),
           (GIVEN.format("end = 1e-6"), "", "end = 1e-6: must be later than start"),
           (GIVEN.format("") * 2, "", "two &growth of one tip must not apply at the same time"),
           (GIVEN.format("").replace("straight", "path"), "", "direction = 'path' requires points"),
           (GIVEN.format("points = 1e-3, 2e-3"), "", "points = 1e-3, 2e-3 requires direction = 'path'"),
           ("&growth law = 'toughness' /", "", "law = 'toughness' requires toughness > 0"),
           ("&growth law = 'toughness'  toughness = 1.0  speed = 10.0 /", "", "speed = 10.0 requires law = 'prescribed'"),
           (GIVEN.format(""), "time = 'static'", "law = 'prescribed' requires &method time = 'explicit' or 'implicit'"),
           (GIVEN.format("") + " &growth toughness = 1.0  increment = 1e-3 /", "", "law = 'quasi_static' (default) is not allowed with growth by laws of both kinds")]


@pytest.mark.parametrize(("growth", "method", "message"), REFUSED)
def test_what_growth_does_not_go_with(hampm, growth, method, message):
    assert message in run_told(hampm, plate(growth, method=method), code=2)


def test_a_constraint_ends_at_a_crack(hampm):
    """A box that ends at a crack holds the nodes of the face on its side, and not those of the other one."""
    text = bench.example("kalthoff", end_time=3e-6)
    text = text[:text.index("&growth")] + text[text.index("&energy_release"):].replace("   snapshot_interval = 5.0e-6\n", "")
    text = text.replace("   velocity = 16.5, 0.0\n", "   velocity = 16.5, 0.0\n   name = 'end'\n")
    row, _ = run_told(hampm, text)
    below = run_told(hampm, text.replace("upper = 0.0, 0.025", "upper = 0.0, 0.0245"))[0]
    above = run_told(hampm, text.replace("upper = 0.0, 0.025", "upper = 0.0, 0.0265"))[0]
    assert row["external_work"][-1] == pytest.approx(below["external_work"][-1], rel=0.05)
    assert above["external_work"][-1] > 1.05 * below["external_work"][-1]


REVERSED = """&run plane = 'strain'  end_time = 7.4e-6 /
&grid lower = -12e-3, -12.48e-3  cell = 0.48e-3  cells = 56, 52 /
&material name = 'm'  young = 100e9  poisson = 0.25  density = 7000 /
&body material = 'm'  lower = -12e-3, -12e-3  upper = 14.88e-3, 12e-3 /
&constraint lower = -12e-3, -12e-3  upper = -12e-3, 12e-3  fix = 'x' /
&constraint lower = 14.88e-3, -12e-3  upper = 14.88e-3, 12e-3  fix = 'x' /
{loads}
&method mass = 'weighted' /
&crack kind = 'path'  points = -12e-3, 0.0, 0.0, 0.0  {contact} /
&growth law = 'toughness'  toughness = 0.01  direction = '{direction}' /
&energy_release estimators = 'domain_integral' /
&output file = 'reversed.h5'  history_interval = 5e-8 /
"""


@pytest.mark.parametrize(("direction", "contact"), [("straight", ""), ("hoop_stress", ""), ("straight", "contact = 'frictionless'")])
def test_waves_of_compression_stop_a_tip_and_noise_does_not(hampm, direction, contact):
    """A wave of tension of 0.25 MPa drives a crack to 0.7 of the speed of Rayleigh waves, where K by fields has no certain sign; one of compression comes at 5.50 us and
    brings K(t, 0) of both (Freund 1990) to 0 at 5.66 us. It stood still before that with a G of 1.4 times its toughness, and by `hoop_stress` ran on behind it
    by 5 cells, at up to 2100 m/s under K_I < 0."""
    times = "history = 'table'  times = 0.0, 2.6e-6, 2.65e-6, 1.2e-5  factors = 1.0, 1.0, -3.0, -3.0"
    row, _ = run_told(hampm, REVERSED.format(direction=direction, contact=contact, loads="\n".join(
        f"&load kind = 'traction'  lower = -12e-3, {y}  upper = 14.88e-3, {y}  force = 0.0, {np.sign(y) * 6720}  {times} /" for y in (12e-3, -12e-3))))
    runs = (row["time"] > row["time"][np.flatnonzero(row["tip_speed"] > 0)[0]]) & (row["time"] < 5.52e-6)
    print(row["tip_x"][runs][-1], row["tip_x"][-1])
    assert np.all(row["tip_speed"][runs] > 0) and np.all(row["K_I"][runs] > 0)
    assert row["tip_x"][-1] - row["tip_x"][runs][-1] < 0.48e-3        # a cell
    assert np.ptp(row["tip_x"][row["time"] > 6.2e-6]) == 0


FIRST = """&run plane = 'stress'  end_time = {end} /
&grid lower = -2e-3, -42e-3  cell = 2e-3  cells = 23, 42 /
&material name = 'm'  young = 70e9  poisson = 0.3  density = 2700 /
&body material = 'm'  lower = 0.0, -40e-3  upper = 40e-3, 40e-3 /
&load kind = 'traction'  lower = 0.0, 40e-3  upper = 40e-3, 40e-3  force = 0.0, 8e5 /
&load kind = 'traction'  lower = 0.0, -40e-3  upper = 40e-3, -40e-3  force = 0.0, -8e5 /
&constraint lower = 40e-3, -40e-3  upper = 40e-3, -40e-3  fix = 'xy' /
&constraint lower = 40e-3, 40e-3  upper = 40e-3, 40e-3  fix = 'x' /
&crack kind = 'path'  points = -1e-3, 0.1e-3, 12e-3, 0.1e-3 /
&refine indicator = 'tip'  max_level = 2  rings = 6 /
&energy_release estimators = 'domain_integral' /
&growth law = 'toughness'  direction = 'straight'  toughness = 60.0 /
&method start = 'static'  {method} /
&output file = 'first.h5'  history_interval = 1e-7 /
"""


def test_a_tip_far_above_its_toughness_starts_in_implicit_steps_as_in_explicit_ones(hampm):
    """G at the static start is 9.9 times the toughness: by g(v) nearly 1 - v/c the tip takes 0.9 of the speed of Rayleigh waves. In implicit steps it had exactly that speed from the
    first one on."""
    implicit, explicit = (run_told(hampm, FIRST.format(end=end, method=method))[0] for end, method in ((5e-7, "time = 'implicit'  time_step = 1e-7"), (5.05e-7, "")))
    way = np.interp(implicit["time"], explicit["time"], explicit["tip_x"]) - 12e-3
    print(implicit["tip_x"] - 12e-3, way, implicit["speed_ratio"])
    assert implicit["G"][0] / 60 == pytest.approx(9.9, abs=0.1)
    assert 0.85 < implicit["speed_ratio"][1] < 0.97
    assert implicit["tip_x"][1:] - 12e-3 == pytest.approx(way[1:], rel=0.06)


SHEARED = """&run plane = 'strain'  end_time = 14e-6 /
&grid lower = 0.0, 0.0  cell = 1e-3  cells = {cells}, 101 /
&material name = 'm'  young = 200e9  poisson = 0.3  density = 7900 /
&body material = 'm'  lower = 0.0, 0.0  upper = {wide}, 0.1 /
&constraint lower = 0.0, 0.0  upper = {wide}, 0.0  fix = 'y' /
&constraint {edge}  fix = 'x'  velocity = {speed}, 0.0 /
&crack kind = 'path'  points = {points} /
&growth law = 'toughness'  toughness = 9213.75  direction = 'hoop_stress' /
&energy_release estimators = 'domain_integral' /
&output file = 'sheared.h5'  history_interval = 1e-7 /
"""


@pytest.mark.parametrize("side", ["left", pytest.param("right", marks=pytest.mark.verify)])
def test_a_sheared_tip_starts_when_its_hoop_stress_says(hampm, side):
    """Impact on the material below a notch: a tip by `hoop_stress` starts when K of the largest hoop stress, by K_I < 0 and K_II, reaches that of the toughness. It was 4 us late."""
    wide = 0.1
    keys = dict(edge="lower = 0.0, 0.0  upper = 0.0, 0.026", speed=12.0, points="-1e-3, 0.026, 0.047, 0.026") if side == "left" else \
        dict(edge=f"lower = {wide}, 0.0  upper = {wide}, 0.026", speed=-12.0, points="0.101, 0.026, 0.053, 0.026")
    row, _ = run_told(hampm, SHEARED.format(cells=100, wide=wide, **keys))
    angle = np.radians(np.linspace(-179, 179, 717))
    hoop = np.array([np.max(np.cos(angle / 2)**2 * (k_1 * np.cos(angle / 2) - 3 * k_2 * np.sin(angle / 2))) for k_1, k_2 in zip(row["K_I"], row["K_II"])])
    reached = row["time"][np.flatnonzero(hoop**2 * 0.91 / 200e9 >= 9213.75)[0]]
    starts = row["time"][np.flatnonzero(row["crack_length"] > row["crack_length"][0])[0]]
    print(reached, starts, row["K_I"][row["time"] < starts][-1])
    assert 0 <= starts - reached < 0.3e-6
    with h5py.File(row.path) as file:
        moved = dict(file["history/tip_speed"].attrs)
    print(moved["onset_time"], moved["onset_time_error"], row["tip_angle"][-1])
    right = 12.79e-6                                           # a crack at rest, cells of 0.25 mm: 12.78, with weighted masses 12.79
    assert abs(moved["onset_time"] - right) < min(moved["onset_time_error"], 0.03 * right)
    assert moved["onset_time_error"] < 0.03 * right
    assert row["K_I"][row["time"] < starts][-1] < 0


@pytest.mark.verify
def test_a_tip_slows_down_in_a_dip_of_its_load_and_does_not_rest(hampm):
    """A plane wave of 1 MPa dips by 0.6 for a quarter of H/c_d: by g(v) K(t, 0)**2/E' = toughness/(1 - v/549), all known, the tip slows down from 295 to 254 m/s and goes from 0.4540
    to 0.6028 mm between 5.652 and 6.202 us. It rested."""
    times = "history = 'table'  times = 0.0, 2.60845e-6, 2.61135e-6, 3.33302e-6, 3.33592e-6, 1.2e-5  factors = 1.0, 1.0, 0.4, 0.4, 1.0, 1.0"
    text = ARREST.format(loads="\n".join(f"&load kind = 'traction'  lower = -12e-3, {y}  upper = 14.88e-3, {y}  force = 0.0, {np.sign(y) * 13440}  {times} /" for y in (12e-3, -12e-3)))
    text = text.replace("  toughness = 0.151261", "").replace("toughness = 0.0420169", "toughness = 0.0356507  limit_speed = 549.0")
    row, _ = run_told(hampm, text)
    dip = [np.interp(t, row["time"], row["tip_x"]) for t in (5.652e-6, 6.202e-6)]
    print(dip)
    assert dip == pytest.approx([0.4540e-3, 0.6028e-3], abs=0.02e-3)
    assert np.all(row["tip_speed"][(row["time"] > 5.652e-6) & (row["time"] < 6.202e-6)] > 100)


def test_a_crack_whose_load_ends_stops_in_implicit_steps_as_in_explicit_ones(hampm):
    """A pulse of 2 us: tips run as long as they have the energy, and then stay, to a cell in the length of their crack."""
    text = plate("&growth law = 'toughness'  toughness = 0.05  direction = 'straight' /").replace("0.5e-3  cells = 40, 42", "1e-3  cells = 20, 22")
    text = text.replace("-10e-3, -10.5e-3", "-10e-3, -11e-3").replace("end_time = 8e-6", "end_time = 7e-6").replace("0.16e-6", "0.2e-6")
    text = text.replace("20e3 /", "20e3  history = 'table'  times = 0.0, 1e-6, 2.5e-6, 3e-6, 1.0  factors = 0.0, 1.0, 1.0, 0.0, 0.0 /")
    implicit, explicit = (run_told(hampm, text.replace("&method", f"&method {method}"))[0] for method in ("time = 'implicit'  time_step = 2e-7", ""))
    print(implicit["crack_length"][-1], explicit["crack_length"][-1])
    for row in implicit, explicit:
        assert row["crack_length"][-1] - row["crack_length"][0] > 5e-3 and not (row["tip_speed"][-5:] > 0).any()
    assert implicit["crack_length"][-1] == pytest.approx(explicit["crack_length"][-1], abs=1e-3)
