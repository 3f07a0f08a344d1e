"""Supports that only push: material lifts off them. The forces of those that are left follow from the balance of forces and moments
alone; a half of a body on one is what a whole body with a crack in contact is."""

import h5py
import numpy as np
import pytest

BEAM = """
&run plane = 'stress'  thickness = 0.01  end_time = 1.0 /
&grid lower = 0.0, 0.0  cell = {cell}  cells = {nx}, {ny}  order = {order} /
&material name = 'a'  young = 70e9  poisson = 0.3  density = 2700  law = '{law}' /
&body material = 'a'  lower = 0.0, 0.0  upper = 0.2, 0.01  points_per_cell = {points} /
&constraint lower = 0.0, 0.0  upper = 0.0, 0.0  fix = 'x' /
&constraint lower = 0.0, 0.0  upper = 0.0, 0.0  fix = 'y'  push_only = .true.  name = 'a' /
&constraint lower = 0.1, 0.0  upper = 0.1, 0.0  fix = 'y'  push_only = .true.  name = 'b' /
&constraint lower = 0.2, 0.0  upper = 0.2, 0.0  fix = 'y'  push_only = {push}  name = 'c' {motion} /
&load kind = 'point'  lower = {at}, 0.01  upper = {at}, 0.01  force = 0.0, {force}  history = 'ramp'  rise_time = 1.0 /
&refine indicator = '{refine}'  max_level = 1 /
&method time = 'static'  load_steps = {steps}  solver = '{solver}' /
"""
VALUES = {"cell": 2.5e-3, "law": "linear_elastic", "push": ".true.", "at": 0.05, "force": -10.0, "refine": "none", "steps": 1,
          "solver": "auto", "motion": "", "order": 1}


def run(hampm, tmp_path, code=0, **values):
    values = VALUES | values
    (tmp_path / "beam.nml").write_text(BEAM.format(nx=round(0.2 / values["cell"]), ny=round(0.01 / values["cell"]) + 1, points=1 + values["order"], **values))
    result = hampm("beam.nml", "--force", "--quiet")
    assert result.returncode == code, result.stderr
    if code:
        return result.stderr
    with h5py.File(tmp_path / "beam.h5") as file:
        return {name: column[:] for name, column in file["history"].items()}


WAYS = [{}, {"steps": 4}, {"law": "neo_hookean"}, {"refine": "zz"}, {"solver": "cg"}, {"order": 2},
        {"order": 2, "law": "neo_hookean", "steps": 4}, {"order": 2, "refine": "zz"}]


@pytest.mark.parametrize("values", WAYS, ids=str)
def test_a_beam_lifts_off_the_support_that_would_pull(hampm, tmp_path, values):
    """A load between the first two of three supports: the third would pull the beam down."""
    row = run(hampm, tmp_path, **values)
    assert row["reaction_a_y"][-1] == pytest.approx(5.0, rel=1e-5)        # what is deformed at equilibrium shifts it: neo-Hookean
    assert row["reaction_b_y"][-1] == pytest.approx(5.0, rel=1e-5)
    assert row["reaction_c_y"][-1] == 0
    gone = {"neo_hookean": 1e-5}.get(values.get("law"), 0.02 if "refine" in values else 1e-9)    # finer cells give way after the work
    assert row["external_work"][-1] == pytest.approx(row["strain_energy"][-1], rel=gone)


def test_a_support_that_holds_pulls(hampm, tmp_path):
    """The same beam held at its end: the beam on three supports, moments 3/32 P L; shear, and the cells, change that a little."""
    row = run(hampm, tmp_path, push=".false.", cell=1.25e-3)
    assert row["reaction_c_y"][-1] == pytest.approx(-10 * 3 / 32, rel=0.03)
    assert row["reaction_a_y"][-1] == pytest.approx(10 * 13 / 32, rel=0.03)


def test_a_support_that_comes_nearer_pushes_again(hampm, tmp_path):
    """The third support is raised by a history: it touches once it is where the free end is, and takes what the beam gives way."""
    held = run(hampm, tmp_path, push=".false.", motion="displacement = 0.0, 1e-4 history = 'ramp' rise_time = 1.0", steps=8)
    row = run(hampm, tmp_path, motion="displacement = 0.0, 1e-4 history = 'ramp' rise_time = 1.0", steps=8)
    pushes = held["reaction_c_y"] > 1e-6
    assert pushes.any()
    assert row["reaction_c_y"][pushes] == pytest.approx(held["reaction_c_y"][pushes], rel=1e-9)
    assert np.all(row["reaction_c_y"][~pushes] == 0)
    assert np.all(row["reaction_c_y"] >= 0)


def test_material_that_is_pulled_off_all_supports_is_named(hampm, tmp_path):
    error = run(hampm, tmp_path, code=3, force=10.0)
    assert "does not come to rest" in error


def test_it_takes_time_static_and_an_edge(hampm, tmp_path):
    text = BEAM.format(nx=80, ny=5, points=2, **VALUES)
    (tmp_path / "a.nml").write_text(text.replace("time = 'static'  load_steps = 1", "time = 'explicit' frame = 'total'"))
    result = hampm("a.nml")
    assert result.returncode == 2
    assert "push_only" in result.stderr
    (tmp_path / "b.nml").write_text(text.replace("lower = 0.1, 0.0  upper = 0.1, 0.0", "lower = 0.1, 0.005  upper = 0.1, 0.005"))
    result = hampm("b.nml", "--check")
    assert result.returncode == 2
    assert "both sides in y" in result.stderr
    (tmp_path / "c.nml").write_text(text.replace("push_only = .true.", "push_only = 'yes'"))
    result = hampm("c.nml")
    assert result.returncode == 2
    assert "must be .true. or .false." in result.stderr


BLOCK = """
&run plane = 'strain'  thickness = 0.01  end_time = 1.0 /
&grid lower = 0.0, {bottom}  cell = 2.5e-3  cells = 16, {ny} /
&material name = 'a'  young = 70e9  poisson = 0.2  density = 2700 /
&body material = 'a'  lower = 0.0, {bottom}  upper = 0.04, 0.02 /
&constraint lower = 0.0, 0.0  upper = 0.0, 0.0  fix = 'x' /
&constraint lower = 0.03, 0.0  upper = 0.04, 0.0  fix = 'y'  name = 'rest' /
&load kind = 'traction'  lower = 0.005, 0.02  upper = 0.01, 0.02  force = 0.0, -1e3 /
&load kind = 'traction'  lower = 0.025, 0.02  upper = 0.03, 0.02  force = 0.0, 1e3 /
{rest}
&method time = 'static' /
"""
HALF = "&constraint lower = 0.0, 0.0  upper = 0.0275, 0.0  fix = 'y'  push_only = .true.  name = 'base' /"
WHOLE = """&load kind = 'traction'  lower = 0.005, -0.02  upper = 0.01, -0.02  force = 0.0, 1e3 /
&load kind = 'traction'  lower = 0.025, -0.02  upper = 0.03, -0.02  force = 0.0, -1e3 /
&crack kind = 'line'  tip = 0.03, 0.0  direction = 1.0, 0.0  contact = 'frictionless' /"""


@pytest.mark.parametrize("order", [(), ("--set", "grid.order=2", "--set", "body.points_per_cell=3")], ids=["bilinear", "quadratic"])
def test_half_a_body_on_a_support_is_half_of_a_body_with_a_crack_in_contact(hampm, tmp_path, order):
    """A part of the faces opens. Pressed nodes are tied on one way, fixed on the other."""
    energy = {}
    for name, bottom, ny, rest in ("half", 0.0, 8, HALF), ("whole", -0.02, 16, WHOLE):
        (tmp_path / f"{name}.nml").write_text(BLOCK.format(bottom=bottom, ny=ny, rest=rest))
        result = hampm(f"{name}.nml", "--force", "--quiet", *order)
        assert result.returncode == 0, result.stderr
        with h5py.File(tmp_path / f"{name}.h5") as file:
            energy[name] = file["history/strain_energy"][-1]
            if name == "half":
                force = file["history/reaction_base_y"][-1] + file["history/reaction_rest_y"][-1]
                assert file["history/reaction_base_y"][-1] > 100
                assert abs(force) < 1e-6
    assert energy["whole"] == pytest.approx(2 * energy["half"], rel=1e-9)
