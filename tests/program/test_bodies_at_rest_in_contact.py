"""Bodies that touch from the start and stay where they are, at rest and in implicit steps: a crack with contact along the face that they have in common."""

import numpy as np
import pytest

from harness import run
from paths import REFERENCE

BLOCKS = """&run plane = 'strain'  end_time = 1.0 /
&grid lower = -10e-3, -1e-3  cell = 0.5e-3  cells = 40, 36 /
&material name = 'hard'  young = 200e9  poisson = 0.3  density = 7800 /
&material name = 'soft'  young = 70e9  poisson = 0.0  density = 2700 /
&body material = 'hard'  lower = {low}, 0.0  upper = {high}, 10e-3 /
&body material = 'soft'  lower = -4e-3, 10e-3  upper = 4e-3, 16e-3 /
&constraint lower = {low}, 0.0  upper = {high}, 0.0  fix = '{fix}'  name = 'foot' /
&constraint lower = -4e-3, 16e-3  upper = 4e-3, 16e-3  fix = '{fix}'  displacement = {way}  name = 'punch'  {history} /
&constraint lower = 0.0, 0.0  upper = 0.0, 16e-3  fix = '{axis}' /
&crack kind = 'path'  points = {crack}  contact = {contact} /
&method {method} /
&energy_release energy_balance = .true. /
&output file = 'out.h5'  snapshot_interval = 1.0 /
"""
USUAL = {"low": -10e-3, "high": 10e-3, "fix": "xy", "axis": "y", "way": "0.0, -1e-6", "history": "", "crack": "-4e-3, 10e-3, 4e-3, 10e-3", "contact": "'frictionless'", "method": "time = 'static'"}


def blocks(hampm, **changes):
    text = BLOCKS.format(**(USUAL | changes))
    if (USUAL | changes)["axis"] == "y":
        text = "".join(line for line in text.splitlines(keepends=True) if "0.0, 16e-3  fix" not in line)
    return run(hampm, text)


def test_blocks_that_widen_differently(hampm):
    """Without friction each is under the uniform stress of its own: w/sum(height/E') of the way of the press."""
    row = blocks(hampm, low=-4e-3, high=4e-3, fix="y", axis="x", crack="-5e-3, 10e-3, 5e-3, 10e-3")
    stress = -1e-6 / (10e-3 * (1 - 0.3**2) / 200e9 + 6e-3 / 70e9)
    assert row["reaction_punch_y"][-1] == pytest.approx(stress * 8e-3, rel=1e-5)  # faces give way by 1e-6 of a cell
    assert row["stress"][1] == pytest.approx(stress, rel=1e-5)
    assert np.max(np.abs(row["stress"][[0, 2]])) < 1e-5 * abs(stress)


def test_a_block_that_is_lifted(hampm):
    assert np.max(np.abs(blocks(hampm, way="0.0, 1e-6")["reaction_punch_y"])) < 1e-9


@pytest.mark.parametrize("method", [
    {}, pytest.param({"method": "time = 'implicit'  time_step = 0.02e-3", "history": "history = 'smooth_ramp'  rise_time = 0.9"}, marks=pytest.mark.verify)],
    ids=["rest", "implicit"])
def test_a_block_that_slides(hampm, method):
    """Pressed by N and moved along by 8 um it slides everywhere: the force along the face is friction times N."""
    method = dict(method)
    if method:
        method["method"] = "time = 'implicit'  time_step = 0.02"  # so slow that it is at rest
    row = blocks(hampm, contact="'friction'  friction = 0.2", way="8e-6, -1e-6", **method)
    assert row["reaction_punch_x"][-1] == pytest.approx(-0.2 * row["reaction_punch_y"][-1], rel=1e-3)
    assert row["reaction_foot_x"][-1] == pytest.approx(-row["reaction_punch_x"][-1], rel=1e-6)
    assert row["friction_loss"][-1] > 0


LAYER = """&run plane = 'strain'  end_time = 1.0 /
&grid lower = -1e-3, -13e-3  cell = 0.125e-3  cells = 112, 116 /
&material name = 'a'  young = 200e9  poisson = 0.3  density = 7800 /
&body material = 'a'  lower = 0.0, -12e-3  upper = 12e-3, 0.0 /
&body material = 'a'  lower = 0.0, 0.0  upper = 5e-3, 1e-3 /
&constraint lower = 0.0, -12e-3  upper = 0.0, 1e-3  fix = 'x' /
&constraint lower = 0.0, -12e-3  upper = 12e-3, -12e-3  fix = 'y' /
&load kind = 'point'  lower = 0.0, 1e-3  upper = 0.0, 1e-3  force = 0.0, -1e3 /
&crack kind = 'path'  points = -0.5e-3, 0.0, 5e-3, 0.0  contact = 'frictionless' /
&method time = 'static' /
&output file = 'out.h5'  snapshot_interval = 1.0 /
"""


def test_a_layer_that_lifts_off_a_half_plane(hampm):
    """Receding contact: the layer touches over 1.30 of its thickness to each side of the force, whatever that is, and presses as an integral equation has it."""
    x_ref, p_ref = np.loadtxt(REFERENCE / "contact/receding.csv", delimiter=",", skiprows=2, unpack=True)
    row = run(hampm, LAYER)
    place = row["x"] - row["displacement"]
    near = np.abs(place[:, 1]) < 0.0625e-3
    x = np.unique(np.round(place[near, 0], 9))
    of = [near & (np.abs(place[:, 0] - one) < 1e-9) for one in x]
    pressure = np.array([-np.mean(row["stress"][1][some]) for some in of]) * 1e-3 / 2e3
    gap = np.array([np.diff(row["displacement"][some, 1][np.argsort(place[some, 1])])[0] if np.sum(some) == 2 else 1.0 for some in of])
    inside = x < 1.1e-3
    off = pressure[inside] - np.interp(x[inside] * 1e3, x_ref, p_ref)
    lifts = x[np.argmax(gap > 0)]
    print("largest error of the pressure over the largest one", np.max(np.abs(off)) / p_ref[0], "lifts at", lifts)
    assert np.max(np.abs(off)) < 0.02 * p_ref[0]
    assert 1.25e-3 < lifts < 1.4e-3
    assert np.max(pressure[x > 1.45e-3]) < 0.01 * p_ref[0]
