"""Loads at rest that bring G to the toughness where the answer is not linear in them: eigenstrain, large strains."""

import numpy as np
import pytest

from harness import differing, run

SCENE = """&run plane = 'stress'  end_time = 1.0 /
&grid lower = -10e-3, -12e-3  cell = 1e-3  cells = 20, 24 /
&material name = 'a'  law = '{law}'  young = 2e11  poisson = 0.3  density = 8000 /
&body material = 'a'  lower = -10e-3, -12e-3  upper = 10e-3, 0.0  points_per_cell = 2  {free} /
&body material = 'a'  lower = -10e-3, 0.0  upper = 10e-3, 12e-3  points_per_cell = 2  {free} /
&crack kind = 'path'  points = -10.5e-3, 0.4e-3, -3.4e-3, 0.4e-3 /
{growth}
&constraint lower = -10e-3, -12e-3  upper = 10e-3, -12e-3  fix = 'xy' /
&load kind = 'traction'  lower = -10e-3, 12e-3  upper = 10e-3, 12e-3  force = {force[0]!r}, {force[1]!r} /
&method time = 'static'  load_steps = 2 /
&energy_release estimators = 'domain_integral'  energy_balance = .true. /
&output file = 'out.h5' /
"""
GROWTH = "&growth law = 'quasi_static'  direction = 'straight'  toughness = 5e3  increment = 2e-3 /"


@pytest.mark.parametrize(("law", "free", "force"), [
    ("linear_elastic", "eigenstrain = 8e-4, 1e-4, 0.0", (0.0, 2e6)),
    ("neo_hookean", "", (0.0, 2e6))], ids=["eigenstrain", "large strains"])
def test_loads_follow_the_toughness(hampm, law, free, force):
    """G of each row is the toughness, and so it is in a scene of its own with the loads as they are in the first."""
    keys = {"law": law, "free": free}
    row = run(hampm, SCENE.format(growth=GROWTH, force=force, **keys))
    print(row["load_factor"], row["crack_length"], row["G"])
    assert row["G"] == pytest.approx(5e3, rel=1e-5)
    assert np.ptp(row["load_factor"]) > 0.01 * row["load_factor"][0] and row["crack_length"][-1] > row["crack_length"][0] + 3.9e-3
    first = run(hampm, SCENE.format(growth="", force=tuple(f * float(row["load_factor"][0]) for f in force), **keys))
    assert first["G"][-1] == pytest.approx(5e3, rel=1e-5)


def test_a_tip_that_has_run_through_has_no_mix_of_modes(hampm):
    """Its toughness was that of modes before it had, which a run that is resumed does not know: other bytes."""
    text = """&run plane = 'strain'  end_time = 2.0 /
&grid lower = 1.5544, 0.5  cell = 0.25  cells = 16, 13 /
&material name = 'a'  young = 70e9  poisson = 0.49  density = 5400.0 /
&body material = 'a'  points_per_cell = 4  lower = 1.9294, 0.75  upper = 5.2419, 3.5 /
&crack kind = 'path'  name = 'c0'  points = 2.6008, 1.64899, 3.12448, 1.95132 /
&growth law = 'quasi_static'  direction = 'hoop_stress'  crack = 'c0'  toughness = 33.7  increment = 0.75  mixed_mode = 'benzeggagh_kenane'  toughness_shear = 16.8 /
&constraint lower = 1.8044, 0.75  upper = 1.8044, 0.75  fix = 'xy' /
&constraint lower = 5.3044, 0.75  upper = 5.3044, 0.75  fix = 'y' /
&load kind = 'pressure'  on = 'crack'  pressure = 2355329.8  crack = 'c0' /
&method time = 'static'  load_steps = 2 /
&energy_release estimators = 'domain_integral' /
&output file = 'out.h5' /
"""
    whole = run(hampm, text, name="whole")
    assert "run through" in whole.said
    run(hampm, text, words=("--steps", "1"), code=5, name="part")
    assert hampm("--resume", hampm.folder / "part.h5.checkpoint", "--quiet").returncode == 0
    assert not differing(whole.path, hampm.folder / "part.h5")
