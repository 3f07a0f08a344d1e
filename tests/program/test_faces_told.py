"""Faces that turn while they press on each other, and tips that nothing opens, are told."""

import sys

import h5py
import numpy as np

from harness import run
from paths import BENCH

sys.path.insert(0, str(BENCH))

from cracks import SIGMA, scene  # noqa: E402


TURNING = """\
&run plane = 'strain'  thickness = 1e-3  end_time = 1.0 /
&grid lower = -6, -6  cell = 0.5  cells = 24, 24 /
&material name = 'a'  law = 'neo_hookean'  young = 1.0  poisson = 0.3  density = 1.0 /
&body material = 'a'  lower = -4, -4  upper = 4, 4  /
&crack kind = 'path'  points = -2.2, 0.1, 2.1, 0.2  contact = 'frictionless' /
&method time = 'static'  load_steps = 8 /
&constraint lower = -4, -4  upper = -4, 4  fix = 'xy' /
&constraint lower = 4, -4  upper = 4, 4  fix = 'xy'  displacement = -0.02, {way}  history = 'ramp'  rise_time = 1.0 /
&load kind = 'traction'  lower = -4, 4  upper = 4, 4  force = 0.0, -4e-4 /
&load kind = 'traction'  lower = -4, -4  upper = 4, -4  force = 0.0, 4e-4 /
"""


def test_pressed_faces_that_turn_are_told(hampm):
    """Contact keeps the normals that the faces had: a block that is sheared by a quarter is stopped, one by a
    twentieth is not."""
    assert "have turned by" in run(hampm, TURNING.format(way=2.0), code=3)
    run(hampm, TURNING.format(way=0.4))


def test_a_tip_that_nothing_opens_waits_and_says_so(hampm, tmp_path):
    """Under pressure straight across the crack neither tip grows: a slanted one would by its shear."""
    half = 8e-3
    text = scene([[(-3.1e-3, 0.1e-3), (3.2e-3, 0.1e-3)]], 1e-3, (half, half), 1, sigma=-SIGMA)
    text = text.replace("time = 'static'", "time = 'static'  load_steps = 2")
    (tmp_path / "waits.nml").write_text(text + "&growth direction = 'hoop_stress'  toughness = 100.0  increment = 1.6e-3 /\n")
    result = hampm("waits.nml", "--force", "--quiet")
    assert result.returncode == 0, result.stderr
    with h5py.File(tmp_path / "waits.h5") as file:
        assert np.ptp(file["history/crack_length"][:]) == 0
        assert file["history"].attrs["warnings"].count("nothing opens it in the direction that it would take") == 2
