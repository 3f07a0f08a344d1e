"""Cracks that grow: directions without K_II, starts in pure shear, speeds below their limits, and what crack and bonds tell.

The plate that a wave meets (`limit_speed_exceeded`, `bonds_weaker_than_tension`) is held to the equation of motion of a semi-infinite crack (Freund 1990),
G(v, t) = g(v) K(t, 0)**2/E' = toughness(v), with g of tests/reference/growth/c1_universal_nu0.30_strain.csv."""

import h5py
import numpy as np
import pytest

GROWN = 1e-3  # |K_II| over K_I that local symmetry leaves


def mixity(row, tip=""):
    return np.abs(row[f"K_II{tip}"] / row[f"K_I{tip}"])


def test_no_k_ii_is_left_in_strong_shear(case):
    """63.2 degrees by hand. Of the mirror image the angles are the same to the other side."""
    run = case("local_symmetry_strong_shear")
    assert run.code == 0, run.stderr
    assert max(mixity(run.row)[1], mixity(run.row, "_tip2")[1]) < GROWN
    assert run.row["tip_angle"][1] == pytest.approx(-63.2, abs=0.2)
    assert run.row["tip_angle_tip2"][1] == pytest.approx(180 - 63.2, abs=1.5)


COARSE = (("-51e-3  cell = 1e-3  cells = 100, 102", "-52e-3  cell = 2e-3  cells = 50, 52"), ("max_level = 2", "max_level = 3"),
          ("49e-3, 0.0  upper = 49e-3, 0.0", "48e-3, 0.0  upper = 48e-3, 0.0"), ("-49e-3, 0.0  upper = -49e-3", "-48e-3, 0.0  upper = -48e-3"),
          ("-6.210046e-03, -8.876238e-03", "-6.195e-03, -8.89e-03"), ("6.210046e-03, 8.876238e-03", "6.195e-03, 8.89e-03"))


def coarser(text):
    """With cells of 2 mm away from the tips, the same at these."""
    for old, new in COARSE:
        text = text.replace(old, new)
    assert "cells = 50, 52" in text and "max_level = 3" in text
    return text


def test_wing_cracks_go_smoothly(case, text_of):
    """With the same increments: no K_II, and no large turn. Version 1: K_II/K_I from 0.07 to 0.44, then the tip turns back by 110 degrees."""
    run = case("local_symmetry_diverges", "--set", "method.load_steps=2", text=coarser(text_of("local_symmetry_diverges")))
    assert run.code == 0, run.stderr
    assert np.all(mixity(run.row)[1:] < GROWN)
    assert np.all(mixity(run.row, "_tip2")[1:] < GROWN)
    assert np.all(np.abs(np.diff(run.row["tip_angle"])) < 5)
    assert np.all(np.diff(run.row["crack_length"]) > 0.9 * 2 * 0.8e-3)


@pytest.mark.parametrize("direction, angle", [("hoop_stress", 70.53), ("local_symmetry", 72)])
def test_pure_shear_starts(case, text_of, direction, angle):
    """Hoop stress: 70.53 degrees to the left, as K_II < 0. Local symmetry: within 8 degrees of that, without K_II at the end of the increment."""
    text = coarser(text_of("pure_mode_II_waits")).replace("'hoop_stress'", f"'{direction}'")
    run = case("pure_mode_II_waits", "--set", "method.load_steps=1", text=text)
    assert run.code == 0, run.stderr
    assert run.row["K_I"][0] == 0
    assert run.row["crack_length"][1] == pytest.approx(20e-3 + 3.2e-3, rel=0.01)
    assert run.row["tip_angle"][1] == pytest.approx(45 + angle, abs=0.1 if direction == "hoop_stress" else 8)
    assert direction == "hoop_stress" or mixity(run.row)[1] < GROWN
    assert "waited" not in run.stderr


def quotients(row):
    """Way over time from row to row [m/s]."""
    return np.diff(row["tip_x"]) / np.diff(row["time"])


def integral(row, first, last=-1):
    """Of the toughness of the present speed over the way of the tip, from row to row."""
    way, toughness = row["tip_x"][first:last], row["toughness"][first:last]
    return np.sum((toughness[1:] + toughness[:-1]) / 2 * np.diff(way))


def test_no_tip_is_faster_than_its_limit(case, text_of):
    """PMMA, 690 m/s, below the 921 of waves of Rayleigh. Cells of 0.5 mm; with lumped masses they take a fifth of G in waves of their size."""
    text = text_of("faster_than_limit_speed").replace("cell = 0.25e-3  cells = 128, 68", "cell = 0.5e-3  cells = 64, 34")
    run = case("faster_than_limit_speed", "--set", "run.end_time=95e-6", "--set", "method.mass=weighted", text=text)
    assert run.code == 0, run.stderr
    row = run.row
    assert row["tip_x"][-1] > 12e-3
    assert np.max(row["tip_speed"]) < 690
    assert np.max(quotients(row)) <= 690 * (1 + 1e-6)
    first, last = np.searchsorted(row["tip_x"], [7e-3, 17e-3])
    taken = row["fracture_energy"][last - 1] - row["fracture_energy"][first]
    assert taken == pytest.approx(integral(row, first, last), rel=0.06)


def test_a_tip_by_the_equation_of_motion_below_its_limit(case):
    """1455 m/s: growth of 1.390 mm from 1.75 H/c_d on."""
    run = case("limit_speed_exceeded", "--set", "output.history_interval=2.7256e-8")
    assert run.code == 0, run.stderr
    row = run.row
    assert np.max(row["tip_speed"]) < 1455
    assert np.max(quotients(row)) <= 1455 * (1 + 1e-6)
    way = row["tip_x"][-1] - np.interp(2.385e-6, row["time"], row["tip_x"])
    assert way == pytest.approx(1.390e-3, rel=0.03)
    first = np.searchsorted(row["time"], 2.385e-6)
    assert row["fracture_energy"][-2] - row["fracture_energy"][first] == pytest.approx(integral(row, first), rel=0.06)


def test_bonds_that_are_weaker_than_the_tension_ahead_wait_for_the_tip(case):
    """6.35 mm at the end; the energy is that of this way and of the cell that bonds are ahead; slower than waves of Rayleigh. Version 1: 0.43 mm, 21 times
    the toughness."""
    run = case("bonds_weaker_than_tension", "--set", "output.history_interval=2.7256e-8")
    assert run.code == 0, run.stderr
    assert np.max(quotients(run.row)) <= 3637.6
    assert run.row["tip_x"][-1] == pytest.approx(6.35e-3, rel=0.06)
    assert run.row["fracture_energy"][-1] == pytest.approx(0.00472936 * (run.row["tip_x"][-1] + 0.2e-3), rel=0.06)


def test_bonds_that_are_far_too_weak_are_told_of(case):
    """At a sixteenth of the toughness: it is as fast as waves of Rayleigh, and G is many times the toughness in its cells."""
    run = case("bonds_weaker_than_tension", "--set", "growth.toughness=0.0003", "--set", "output.history_interval=1e-7",
               "--set", "run.end_time=2e-6")
    assert run.code == 0, run.stderr
    assert "tip 1 is in cells that are too coarse for its toughness" in run.stderr


@pytest.mark.parametrize("points", ["-6.13e-3, -3.71e-3, 6.13e-3, 3.71e-3", "-6.1e-3, -3.7e-3, 6.1e-3, 3.7e-3"])
def test_symmetric_tips_grow_alike(case, text_of, points):
    """A particle lies on the way of each tip of the second crack: it is split as cells there are cut, and bonded points hold what its halves do. They held it as one side had all of it:
    G of the tips came to differ by up to 3 %."""
    text = text_of("symmetric_tips_unlike").replace("-6.1e-3, -3.7e-3, 6.1e-3, 3.7e-3", points)
    run = case("symmetric_tips_unlike", "--set", "run.end_time=10.5e-6", "--set", "output.history_interval=5e-7", text=text)
    assert run.code == 0, run.stderr
    assert run.row["tip_x"][-1] > 6.5e-3
    assert run.row["tip_x_tip2"] == pytest.approx(-run.row["tip_x"], abs=1e-9)
    assert run.row["G_tip2"] == pytest.approx(run.row["G"], rel=1e-6, abs=1e-6)


def test_a_crack_that_has_parted_its_plate_says_so(case):
    """It runs through to the surface. Bonds have taken the toughness of its way but for the last cells, where G falls and no domain fits."""
    run = case("crack_length_stops", "--set", "run.end_time=20e-6")
    assert run.code == 0, run.stderr
    assert run.row["crack_length"][-1] == pytest.approx(20e-3, rel=1e-8)
    assert run.row["fracture_energy"][-1] == pytest.approx(6.0 * 14e-3, rel=0.15)
    assert "separated at t = " in run.stderr


def test_labels_of_j_name_no_radius_that_changes(case):
    """So a run that is resumed has the labels of one that was not."""
    run = case("crack_length_stops", "--set", "run.end_time=9e-6")
    with h5py.File(run.path) as file:
        assert file["history/J_1"].attrs["long_name"] == "J integral, radius 1 of those that there is room for"


def test_a_pressed_crack_of_two_cells_grows(case):
    run = case("pressed_crack_of_two_cells")
    assert run.code == 0, run.stderr
    row = run.row
    inside = sum(row[name] for name in ("kinetic_energy", "strain_energy", "damping_loss", "numerical_loss", "fracture_energy", "friction_loss"))
    missing = row["external_work"] - inside
    assert np.max(np.abs(missing - missing[0])) < 1e-6 * np.max(np.abs(row["external_work"]))
