"""A front of a solid that comes to another crack, across its plane, ends there and says so, at rest, in a load frame, in load cycles, in time and in motion: fronts went through its faces and on behind
them."""

import pytest
from test_growth_once import GRIP, H

from harness import differing, run

WALL = 3e-3                                                 # place of the other crack
DRIVES = {"rest": ("law = 'quasi_static'  increment = 2e-3", "", 1.0),
          "frame": ("law = 'quasi_static'  increment = 2e-3", "&control quantity = 'displacement'  displacement = 3e-6  history = 'table'  times = 0.0, 1.0  factors = 0.0, 1.0 /", 1.0),
          "cycles": ("law = 'fatigue'  rate_constant = 1e-27  rate_exponent = 3.0  increment = 2e-3", "&cycles ratio = 0.1 /", 1.0),
          "time": ("law = 'subcritical'  rate = 'charles'  speed = 1e-3  rate_exponent = 8.0  increment = 2e-3", "", 2e3),
          "motion": ("law = 'prescribed'  speed = 1000.0", "", 8e-6)}


def block(drive, width=1, mirror=1):
    """A strip as in test_growth_once, that many cells thick, with another crack at x = WALL, in y from -3 to 3 mm, or of a thick one through half of its thickness."""
    growth, more, end = DRIVES[drive]
    method = "mass = 'weighted'  courant = 0.35  start = 'static'" if drive == "motion" else "time = 'static'  load_steps = 8"
    toughness = {"cycles": "toughness = 1e6", "time": "toughness = 100.0", "motion": ""}.get(drive, "toughness = 10.0")
    corners = ", ".join(f"{mirror * WALL}, {y}, {z}" for y, z in (("-3e-3", -H), ("3e-3", -H), ("3e-3", 2 * H), ("-3e-3", 2 * H)))
    other = f"front = 'polygon'  points = {corners}" if width == 1 else f"front = 'straight'  tip = {mirror * WALL}, 0.0, {width / 2 * H}  direction = 0.0, 0.0, 1.0"
    return f"""&run end_time = {end} /
&grid lower = -10e-3, -9e-3, 0.0  cell = {H}  cells = 20, 18, {width} /
&material name = 'a'  young = 200e9  poisson = 0.3  density = 5000 /
&body material = 'a'  lower = -10e-3, -8e-3, 0.0  upper = 10e-3, 8e-3, {width * H} /
&constraint lower = -10e-3, 8e-3, 0.0  upper = 10e-3, 8e-3, {width * H}  fix = 'xy'  displacement = 0.0, {GRIP}, 0.0 /
&constraint lower = -10e-3, -8e-3, 0.0  upper = 10e-3, -8e-3, {width * H}  fix = 'xy'  displacement = 0.0, {-GRIP}, 0.0 /
&constraint lower = -10e-3, -8e-3, 0.0  upper = 10e-3, 8e-3, 0.0  fix = 'z' /
&constraint lower = -10e-3, -8e-3, {width * H}  upper = 10e-3, 8e-3, {width * H}  fix = 'z' /
&crack name = 'one'  kind = 'plane'  normal = 'y'  tip = {-2e-3 * mirror}, 0.0, 0.0  direction = {mirror}, 0.0, 0.0 /
&crack name = 'other'  kind = 'plane'  normal = 'x'  {other} /
&growth crack = 'one'  {growth}  {toughness}  direction = 'straight' /
&energy_release estimators = 'domain_integral' /
{more}
&method {method} /
&output {f'history_interval = {end / 16}' if drive == "motion" else ''} /
"""


@pytest.mark.parametrize("drive", DRIVES)
def test_a_front_ends_at_another_crack(hampm3d, drive):
    """To the last digit, from either side."""
    for mirror in (1, -1) if drive in ("frame", "motion") else (1,):
        row = run(hampm3d, block(drive, mirror=mirror))
        print(row["crack_area"], row.said)
        assert ("come to another crack" if drive != "motion" else "or to other cracks") in row.said and "separated" not in row.said
        assert row["crack_area"][-1] == pytest.approx((10e-3 + WALL) * H, rel=1e-9)
        assert row["crack_area"].max() <= (10e-3 + WALL) * H * (1 + 1e-9)


@pytest.mark.parametrize("drive", ("rest", pytest.param("motion", marks=pytest.mark.verify)))
def test_a_front_goes_on_beside_another_crack(hampm3d, drive):
    """Where it reaches through half of the thickness the rest of the front runs on."""
    row = run(hampm3d, block(drive, width=8))
    area = row["crack_area"]
    print(area, row.said)
    assert "come to another crack" in row.said or "or to another crack" in row.said
    assert (10e-3 + WALL) * 8 * H + 1e-3 * 4 * H < area.max() <= (10e-3 + WALL + 20e-3) * 4 * H * (1 + 1e-6)


@pytest.mark.parametrize(("drive", "steps"), [("rest", (1,)), ("cycles", (1,)), ("motion", (60, 80))])
def test_it_goes_on_from_a_checkpoint(hampm3d, drive, steps):
    """After the front has ended there, and while what it has left is released: the same bytes. Nodes ahead of it are open, which a new grid has to know."""
    run(hampm3d, block(drive), name="whole")
    for some in steps:
        run(hampm3d, block(drive), code=5, words=("--steps", str(some)), name="part")
        assert hampm3d("--resume", "part.h5.checkpoint", "--quiet").returncode == 0
        assert not differing(hampm3d.folder / "whole.h5", hampm3d.folder / "part.h5"), some
