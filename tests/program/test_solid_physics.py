"""The program for solids beside theory: limits of its step, and waves and vibrations with closed forms."""

import re
import subprocess

import numpy as np
import pytest
from paths import REFERENCE, SOLID_PROGRAM

pytestmark = pytest.mark.skipif(not SOLID_PROGRAM.exists(), reason="make program build=quick dim=3 makes it")
FORCED = SOLID_PROGRAM.with_name("forced_step")

# Loads at places without symmetry set in at once, and move all modes of the cube. Lengths are in cells, with Young's modulus and density 1
CUBE = """
&run end_time = {end} /
&grid cell = 1.0  cells = {grid}, {grid}, {grid} /
&material name = 'a'  young = 1.0  poisson = {poisson}  density = 1.0 /
&body material = 'a'  lower = 1.0, 1.0, 1.0  upper = {upper}, {upper}, {upper} /
&load kind = 'point'  lower = 1.03, 1.03, 1.03  upper = 1.03, 1.03, 1.03  force = 1e-6, 3e-7, -5e-7 /
&load kind = 'point'  lower = {far}  upper = {far}  force = -4e-7, 8e-7, 6e-7 /
&method mass = '{mass}'  courant = {courant}  wave_speed = 'dilatational' /
&output file = 'case.h5'  history_interval = {interval} /
"""


def cube(folder, cells, poisson, mass, courant=0.0, step=1.0, steps=400):
    """The namelist of a free cube, of which steps are in dilatational waves through a cell."""
    speed = ((1 - poisson) / ((1 + poisson) * (1 - 2 * poisson))) ** 0.5
    far = ", ".join(repr(1 + part * cells) for part in (0.71, 0.63, 0.8))
    (folder / "case.nml").write_text(CUBE.format(end=steps * step / speed, interval=steps * step / speed / 8, grid=cells + 2, upper=cells + 1.0, far=far,
                                                 poisson=poisson, mass=mass, courant=courant))


def named_limit(folder, *what):
    """The largest courant number, as a model is told that asks for more."""
    cube(folder, *what, courant=10.0)
    said = subprocess.run([SOLID_PROGRAM, "case.nml", "--check"], cwd=folder, capture_output=True, text=True).stderr
    return float(re.search(r"&method courant = 10\.0: must be at most (\S+), not 10\.0.* is unstable in a solid", said)[1])


def survives(folder, courant, *what):
    """Whether a run with a courant number, allowed or not, comes to its end."""
    cube(folder, *what, step=courant)
    result = subprocess.run([FORCED, repr(courant), "case.nml", "--force", "--quiet"], cwd=folder, capture_output=True, text=True)
    assert result.returncode in (0, 3), result.stderr
    return result.returncode == 0


@pytest.mark.parametrize(("poisson", "consistent", "lumped"), np.loadtxt(REFERENCE / "solid/timestep_limits.csv", delimiter=","))
def test_limit_of_a_free_cell(tmp_path, poisson, consistent, lumped):
    """Three digits, rounded down, of the reference; with the lumped matrix twice of it."""
    for mass, limit in (("consistent", consistent), ("lumped", 2 * lumped)):
        named = named_limit(tmp_path, 1, poisson, mass)
        print(mass, poisson, f"asked {limit:.4f}, named {named}")
        assert 0.99 * limit < named <= limit


@pytest.mark.verify
@pytest.mark.parametrize("poisson", [0.0, 0.3, 0.45])
@pytest.mark.parametrize("mass", ["lumped", "consistent"])
@pytest.mark.parametrize("cells", [1, 3, 6])
def test_limit_is_that_of_the_run(tmp_path, cells, mass, poisson):
    """Below it nothing grows, above it everything does."""
    if not FORCED.exists():
        pytest.skip("make build/quick3d/forced_step build=quick dim=3 makes it")
    named = named_limit(tmp_path, cells, poisson, mass)
    assert survives(tmp_path, 0.99 * named, cells, poisson, mass)
    assert not survives(tmp_path, (1.01 if cells < 6 else 1.04) * named, cells, poisson, mass)
