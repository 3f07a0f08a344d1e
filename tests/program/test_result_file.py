"""The result file of a real run: history, input, snapshots, and the scripts that read it."""

import os
import subprocess
import sys

import h5py
import numpy as np
import pytest

import compare
import export
import plot_g
from history import History
from paths import SCRIPTS
from snapshots import field, field_names, points, read_steps

COLUMNS = {
    "time": "s", "step": "1", "dt": "s", "particles": "1", "cells": "1", "finest_cell": "m", "kinetic_energy": "J",
    "strain_energy": "J", "external_work": "J", "damping_loss": "J", "momentum_x": "kg m/s", "momentum_y": "kg m/s",
    "angular_momentum": "kg m2/s", "numerical_loss": "J", "G_vcct_I": "J/m2",
    "G_vcct_I_error": "J/m2", "G_stress_closure_I": "J/m2", "G_stress_closure_I_error": "J/m2", "G": "J/m2",
    "G_error": "J/m2", "crack_opening": "m", "mouth_opening": "m", "tip_cell": "m", "reaction_x": "N", "reaction_y": "N"}
PARTICLE_FIELDS = ["body", "deformation_gradient", "displacement", "energy_density", "id", "stress_xx", "stress_xy", "stress_yy", "velocity"]
MASS = 2700 * 0.1 * 0.01 * 0.01


@pytest.fixture(scope="module")
def steps(dcb_result):
    return read_steps(dcb_result)


def test_every_column_has_a_unit_and_a_long_name(dcb_result):
    history = History(dcb_result)
    assert history.units == COLUMNS
    with h5py.File(dcb_result) as file:
        assert all(len(column.attrs["long_name"]) > 3 for name, column in file["history"].items() if name != "dt")


def test_history_of_a_coarse_beam(dcb_result):
    history = History(dcb_result)
    c = history.columns
    assert np.all(c["particles"] == 160) and np.all(c["cells"] == 60) and np.all(c["finest_cell"] == 5e-3)
    assert c["step"].dtype == np.int64 and np.all(np.diff(c["step"]) > 0)
    longest = 0.1 * 5e-3 / np.sqrt(70e9 / 2.6 / 2700)
    assert np.all(c["dt"][1:] <= longest * (1 + 1e-9))
    np.testing.assert_allclose(np.diff(c["time"]), c["dt"][1:] * np.diff(c["step"]), rtol=1e-9)
    assert history.attributes["title"] == "DCB, suddenly loaded, damped"
    assert history.g_ref() == pytest.approx(12 * 0.05**2 / (70e9 * 0.01**2 * 0.01**3), rel=1e-12)
    assert history.beam_ratio() == pytest.approx((0.05 + 0.01 * 2 / 3)**2 / 0.05**2, rel=1e-12)


def test_the_result_says_how_the_run_has_ended(dcb, tmp_path, dcb_result):
    attributes = History(dcb_result).attributes
    assert (attributes["ended"], attributes["warnings"]) == ("done", "")
    settings = "refine.indicator=gradient", "refine.max_level=1", "load.force=0,1e4", "run.end_time=4e-5", "output.snapshot_interval=0"
    printed = dcb(*(word for setting in settings for word in ("--set", setting))).stderr.splitlines()
    assert len(printed) == 2  # strains, and the limit of the levels
    assert printed == [f"hampm: warning: {line}" for line in History(tmp_path / "dcb.h5").attributes["warnings"].splitlines()]
    assert dcb("--force", "--steps", 50).returncode == 5
    assert not {"ended", "warnings"} & set(History(tmp_path / "dcb.h5").attributes)


def test_input_says_what_produced_the_result(dcb_result):
    with h5py.File(dcb_result) as file:
        text = file["input/namelist"].asstr()[()]
        attributes = {name: str(value) for name, value in file["input"].attrs.items()}
    assert "cell = 0.005" in text and "end_time = 3.0e-4" in text
    assert attributes["compiler"].startswith("GCC version")
    assert "-O" in attributes["compiler_options"]
    assert attributes["version"][0].isdigit() and attributes["threads"] == "1" and attributes["host"]


def test_snapshots_fall_on_their_times(steps):
    np.testing.assert_allclose(steps[0], [0, 1e-4, 2e-4, 3e-4], rtol=1e-12)


@pytest.mark.parametrize("k", range(4))
def test_snapshots_have_particles_and_mesh(steps, k):
    particles, mesh = steps[1][k]
    assert (len(points(particles)), len(points(mesh)), len(mesh.cells)) == (160, 84, 60)
    assert sorted(field_names(particles.point_data)) == PARTICLE_FIELDS
    for data in (particles.point_data, mesh.point_data, mesh.cell_data):
        for name in field_names(data):
            assert np.all(np.isfinite(field(data, name))), name
    assert np.sum(field(mesh.cell_data, "particles")) == 160
    assert np.all(points(particles)[:, :2] > [-0.001, -0.001]) and np.all(points(particles)[:, :2] < [0.101, 0.011])


@pytest.mark.parametrize("k", range(1, 4))
def test_snapshots_agree_with_the_history(dcb_result, steps, k):
    particles, mesh = (data.point_data for data in steps[1][k])
    columns = History(dcb_result).columns
    sample = np.argmin(np.abs(columns["time"] - 1e-4 * k))
    assert np.sum(field(mesh, "mass")) == pytest.approx(MASS, rel=1e-12)
    kinetic = np.sum(field(particles, "velocity")**2) * MASS / 160 / 2
    strain = np.sum(field(particles, "energy_density")) * MASS / 2700 / 160
    assert kinetic == pytest.approx(columns["kinetic_energy"][sample], rel=1e-12)
    assert strain == pytest.approx(columns["strain_energy"][sample], rel=1e-12)


def test_the_deformation_gradient_is_that_of_the_stored_energy(steps):
    """Half of the stress times the strain, which is the symmetric part of F - I: components xx, xy, yx, yy."""
    particles = steps[1][3][0].point_data
    f = field(particles, "deformation_gradient")
    xx, xy, yy = (field(particles, f"stress_{name}") for name in ("xx", "xy", "yy"))
    energy = (xx * (f[:, 0] - 1) + xy * (f[:, 1] + f[:, 2]) + yy * (f[:, 3] - 1)) / 2
    np.testing.assert_allclose(energy, field(particles, "energy_density"), rtol=1e-6)


def test_plot_g_draws_a_picture(dcb_result, tmp_path):
    assert plot_g.main([str(dcb_result), "--converged", "1.28737", "--output", str(tmp_path / "g.png")]) is None
    assert (tmp_path / "g.png").read_bytes().startswith(b"\x89PNG")


def test_gnuplot_draws_a_picture(dcb_result, tmp_path):
    subprocess.run(["gnuplot", "-c", SCRIPTS / "g_of_t.gp", tmp_path / "g.png", dcb_result], check=True,
                   env=os.environ | {"HAMPM_PYTHON": sys.executable, "HAMPM_CONVERGED": "1.28737"})
    assert (tmp_path / "g.png").read_bytes().startswith(b"\x89PNG")


def test_compare_tells_equal_from_different(dcb, dcb_result, tmp_path, capsys):
    assert dcb("--set", "damping.rate=1.01e4").returncode == 0
    assert compare.main([str(dcb_result), str(dcb_result), "--exact"]) == 0
    assert compare.main([str(dcb_result), str(tmp_path / "dcb.h5")]) == 1
    assert "DIFFERS" in capsys.readouterr().out


def test_export_writes_every_sample(dcb_result, tmp_path):
    export.main([str(dcb_result), "--columns", "G_vcct_I", "--normalised", "--output", str(tmp_path / "g.txt")])
    history = History(dcb_result)
    table = np.loadtxt(tmp_path / "g.txt")
    np.testing.assert_array_equal(table, np.column_stack([history.times, history.g_ratio("G_vcct_I")]))
