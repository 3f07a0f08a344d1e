"""The tests of docs/lessons/exercises, one for each: red as long as the program is as it comes, green once the exercise is done.

    make lab exercise=scheme         # or make lab, then .venv/bin/python -m pytest -q tests/lab/exercises.py -k scheme

`make test` collects no file of this name; `test_solutions.py` holds the tests to the solutions.
"""

import math

import h5py
import numpy as np
import pytest

from paths import ROOT

LESSONS = ROOT / "docs/lessons"


@pytest.fixture
def run(hampm, tmp_path):
    """`run(model, *settings)` runs a model, a text or a file of the lessons, by the readable step; its history and its last particles, in the order of their numbers."""
    def of(model, *settings, path="reference"):
        name = tmp_path / "model.nml"
        name.write_text((LESSONS / model).read_text() if model.endswith(".nml") else model)
        words = [word for setting in (*settings, *([f"method.path={path}"] if path else [])) for word in ("--set", setting)]
        done = hampm(name, "--output", tmp_path, "--force", "--quiet", *words)
        assert done.returncode == 0, done.stderr
        with h5py.File(tmp_path / "model.h5") as file:
            history = {column: values[:] for column, values in file["history"].items()}
            if "VTKHDF" in file:
                last = file["VTKHDF/particles/NumberOfPoints"][-1]
                data = file["VTKHDF/particles/PointData"]
                order = np.argsort(data["id"][-last:])
                history |= {field: data[field][-last:][order] for field in ("displacement", "velocity")}
        return history
    return of


def of_one_cell(run, scheme):
    """Kinetic and strain energy of the cell of lesson 3 over the initial energy, at the end of each of its steps of 0.1."""
    history = run("3_energy.nml", f"method.scheme={scheme}", "energy_release.energy_balance=.false.")
    return np.array([history["kinetic_energy"], history["strain_energy"]]).T / 5e-13


def test_scheme(run):
    """Lesson 3's cell by hand: the velocities q of its two columns of points, where N is 1/4 and 3/4, and the displacement u of the node."""
    keep, dt, n = 0.9, 0.1, np.array([0.25, 0.75])
    q, u, asked = np.ones(2), 0.0, []
    for _ in range(281):
        asked.append([np.sum(q**2) / 2, u**2])
        v = n @ q                                   # p = (q_1 N_1 + q_2 N_2)/2 over D = 1/2
        a = -2 * u
        q = keep * (q + dt * a * n) + (1 - keep) * (v + dt * a) * n
        u += dt * n @ q
    assert of_one_cell(run, "musl") == pytest.approx(np.array(asked), rel=0, abs=1e-5)
    flight = run("1_material_point.nml")
    assert flight["kinetic_energy"][-1] == pytest.approx(0.8 * (1 + (9.81 * 0.2)**2), rel=1e-9)


@pytest.mark.parametrize("model, settings", [
    ("2_mapping.nml", []),
    ("4_waves.nml", ["run.end_time=20", "output.snapshot_interval=20"]),
    ("5_time_step.nml", ["method.courant=0.3", "output.snapshot_interval=100", "energy_release.energy_balance=.false.", "method.scheme=usl"])])
def test_mass(run, model, settings):
    """The readable step with the series against the fast one that has it built in."""
    asked = run(model, *settings, "method.mass=fmpm", path="fastest")
    found = run(model, *settings)
    for name in "kinetic_energy", "strain_energy", "external_work", "displacement", "velocity":
        size = np.max(np.abs(asked[name])) if name in ("displacement", "velocity") else np.max(asked["kinetic_energy"])
        assert found[name] == pytest.approx(asked[name], rel=0, abs=1e-10 * size), name


BAR = """
&run title = 'A bar that is pulled while it flies through the cells'  end_time = 80.0 /
&grid cell = 1.0  cells = 48, 3 /
&material name = 'unit'  young = 1.0  density = 1.0 /
&body material = 'unit'  lower = 2.0, 1.0  upper = 22.0, 2.0  velocity = {speed}, 0.0 /
&load kind = 'traction'  lower = 2.0, 1.0  upper = 2.0, 2.0  force = -1e-3, 0.0  history = 'ramp'  rise_time = 40.0 /
&load kind = 'traction'  lower = 22.0, 1.0  upper = 22.0, 2.0  force = 1e-3, 0.0  history = 'ramp'  rise_time = 40.0 /
&method frame = '{frame}'  wave_speed = 'dilatational'  courant = 0.1 /
&output history_interval = 1.0 /
"""


def test_functions(run):
    """A bar that flies while it is pulled stores what a bar at rest does, but for 5 %; with bilinear functions the four lines that it crosses make that 47 %."""
    asked = run(BAR.format(speed=0.0, frame="total"), path="fastest")["strain_energy"]
    found = run(BAR.format(speed=0.05, frame="updated"))["strain_energy"]
    assert np.max(np.abs(found - asked)) < 0.05 * np.max(asked)


@pytest.mark.parametrize("scheme", ["usf", "musl"])
def test_law(run, scheme):
    """Lesson 3's cell by hand: a stress E H_11 + 2 eta L_11 with E = 1 and eta = 0.05; w is the velocity of its node at the start of a step."""
    viscosity, dt, n = 2 * 0.05, 0.1, np.array([0.25, 0.75])
    q, u, asked = np.ones(2), 0.0, []
    for _ in range(281):
        asked.append([np.sum(q**2) / 2, u**2])
        w = n @ q
        if scheme == "usf":
            u += dt * w
        q = q + dt * n * -2 * (u + viscosity * w)
        if scheme == "musl":
            u += dt * n @ q
    assert of_one_cell(run, scheme) == pytest.approx(np.array(asked), rel=0, abs=1e-5)


PLATE = """
&run             plane = 'strain'  end_time = 1.0 /
&grid            lower = -20e-3, -41e-3  cell = 1e-3  cells = 40, 82 /
&material        name = 'steel'  young = 200e9  poisson = 0.3  density = 7800.0 /
&body            material = 'steel'  lower = -20e-3, -40e-3  upper = 20e-3, 40e-3 /
&load            kind = 'traction'  lower = -20e-3, 40e-3   upper = 20e-3, 40e-3   force = 0.0, 40e3 /
&load            kind = 'traction'  lower = -20e-3, -40e-3  upper = 20e-3, -40e-3  force = 0.0, -40e3 /
&crack           kind = 'path'  points = -8e-3, 0.0, 8e-3, 0.0 /
&method          time = 'static' /
&refine          indicator = 'tip'  max_level = 2  rings = 8 /
&energy_release  estimators = 'stress_ahead' /
"""


def test_estimator(run):
    """A crack in the middle of a plate that is pulled, by Tada's formula."""
    history = run(PLATE, path=None)
    a, width, stress, modulus = 8e-3, 40e-3, 40e3 / 40e-3, 200e9 / (1 - 0.3**2)
    k = stress * math.sqrt(math.pi * a / math.cos(math.pi * a / width)) * (1 - 0.025 * (2 * a / width)**2 + 0.06 * (2 * a / width)**4)
    assert history["G_stress_ahead_I"][-1] == pytest.approx(k**2 / modulus, rel=0.04)
    assert abs(history["G_stress_ahead_II"][-1]) < 1e-6 * history["G_stress_ahead_I"][-1]
