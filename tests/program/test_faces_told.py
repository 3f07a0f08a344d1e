"""Faces that turn while they press on each other, and tips that nothing opens, are told."""

import sys

import h5py
import numpy as np
import pytest

from harness import run
from paths import BENCH, SOLID_PROGRAM

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


SLAB = """&run end_time = 1.0 /
&grid lower = 0, 0, {low}  cell = 2e-3  cells = 10, 2, {n} /
&material name = 's'  young = 70e9  poisson = 0.25  density = 2700 /
&body material = 's'  lower = 0, 0, {foot}  upper = 20e-3, 4e-3, 20e-3 /
&constraint lower = 0, 0, {foot}  upper = 20e-3, 0, 20e-3  fix = 'y' /
{held}
&load kind = 'traction'  lower = 0, 0, 20e-3  upper = 20e-3, 4e-3, 20e-3  force = 0, 0, {force} /
{pull}
&crack kind = '{kind}'  normal = 'z'  front = 'straight'  tip = 8e-3, 0, 0  direction = 1, 0, 0 {contact} /
&energy_release estimators = 'domain_integral', 'vcct' /
&method time = 'static' /
&output file = 'slab.h5' /
"""
HALF = "&constraint lower = 8e-3, 0, 0  upper = 20e-3, 4e-3, 0  fix = 'z' /\n&constraint lower = 20e-3, 0, 0  upper = 20e-3, 4e-3, 20e-3  fix = 'x' /"


@pytest.mark.skipif(not SOLID_PROGRAM.exists(), reason="make program dim=3 makes it")
@pytest.mark.parametrize("kind", ["symmetry", "plane"])
def test_pressed_faces_of_solids_are_told(hampm, kind):
    """Under compression G of vcct has the sign of the opening, as in the plane, and faces that go through each other are told; under tension neither, nor where they have contact."""
    rows = {}
    for force, contact in ((800, ""), (-800, ""), *(((-800, "contact = 'frictionless'"),) if kind == "plane" else ())):
        keys = dict(low=0, n=11, foot=0, held=HALF, pull="") if kind == "symmetry" else dict(
            low=-22e-3, n=22, foot=-20e-3, held="&constraint lower = 20e-3, 0, -20e-3  upper = 20e-3, 4e-3, 20e-3  fix = 'x' /",
            pull=f"&load kind = 'traction'  lower = 0, 0, -20e-3  upper = 20e-3, 4e-3, -20e-3  force = 0, 0, {-force} /")
        (hampm.folder / "slab.nml").write_text(SLAB.format(kind=kind, force=force, contact=contact, **keys))
        result = hampm("slab.nml", "--force", program=SOLID_PROGRAM)
        assert result.returncode == 0, result.stderr
        assert ("the faces of the crack interpenetrate" in result.stderr) == (force < 0 and not contact), result.stderr
        with h5py.File(hampm.folder / "slab.h5") as file:
            rows[force, contact] = {name: file["history"][name][-1] for name in ("K_I", "G_vcct_I", "G_mean")}
    pulled, pressed = rows[800, ""], rows[-800, ""]
    for name, sign in (("K_I", -1), ("G_vcct_I", -1), ("G_mean", 1)):
        assert pressed[name] == pytest.approx(sign * pulled[name], rel=1e-6), name
    assert pulled["K_I"] > 0 and pulled["G_vcct_I"] > 0
