"""Scenes whose numbers were taken from another material or divided by nothing, and what guards say of a run."""

import h5py
import numpy as np
import pytest

from paths import CHECKED_PROGRAM


def attribute(run, name):
    """An attribute of the history."""
    with h5py.File(run.path) as file:
        return file["history"].attrs[name]


def test_reference_is_that_of_the_material_of_the_body(case, text_of):
    """The closed form of a double cantilever beam, 12 P**2 a**2/(E B**2 D**3), is asked of the material at the tip: one that no body uses changes nothing."""
    run = case("reference_of_other_material")
    assert run.code == 0, run.stderr
    assert attribute(run, "G_ref") == pytest.approx(12*1.0**2*0.05**2/(70e9*0.01**2*0.01**3), rel=1e-12)
    text = "".join(line for line in text_of("reference_of_other_material").splitlines(True) if "'unused'" not in line)
    alone = case("reference_of_other_material", text=text)
    assert attribute(alone, "G_beam_on_foundation") == attribute(run, "G_beam_on_foundation")
    for column, values in alone.row.items():
        assert np.array_equal(values, run.row[column]), column


@pytest.mark.parametrize("name", ["eigenstrain_tip_bounds", "eigenstrain_tip_bounds_motion"])
def test_tip_in_material_with_eigenstrain(case, text_of, name):
    """What is recorded at a tip follows from the material there, with its eigenstrain: intensities, modes and errors, as it is linear, whatever other materials
    the scene has."""
    text = text_of(name)
    run = case(name, "--steps", "3")
    assert run.code == 5, run.stderr
    assert {"K_I", "K_II", "G_domain_I", "J_error"} <= set(run.row)
    other = case(name, "--steps", "3", text=text + "\n&material name = 'other'  law = 'neo_hookean'  young = 1e6  poisson = 0.3  density = 1e3 /\n")
    assert set(other.row) == set(run.row)


def test_error_of_a_crack_that_nothing_opens(case):
    """The estimate of the start shares the work of closing a crack among its modes: where there is none, it is that of the lengths alone."""
    run = case("fpe_expected_error")
    assert run.code == 0, run.stderr
    for column, values in run.row.items():
        assert np.all(np.isfinite(values)), column


def snapshots_of(run):
    """Times of the snapshots of a run."""
    with h5py.File(run.path) as file:
        return file["VTKHDF/Steps/Values"][:]


@pytest.mark.parametrize("unit", ["", "e-6", "e6"])
@pytest.mark.parametrize("time", ["explicit", "implicit"])
def test_last_sample_is_taken_once(case, text_of, unit, time):
    """20 intervals give 21 rows and 21 snapshots, the last of them at the end time itself, in whatever unit times are."""
    text = text_of("last_sample_twice").replace("6e-3", f"6e{int(unit[1:] or 0) - 3}").replace("3e-4", f"3e{int(unit[1:] or 0) - 4}")
    run = case("last_sample_twice", text=text.replace("young = 1e6", f"young = {1e6/float('1' + unit)**2:g}") + f"&method time = '{time}' /\n")
    assert run.code == 0, run.stderr
    assert np.allclose(run.row["time"], float("3e-4")*float("1" + unit)*np.arange(21), rtol=1e-9, atol=0)
    assert np.all(np.diff(run.row["step"]) > 0) and run.row["time"][-1] == float(f"6e{int(unit[1:] or 0) - 3}")
    assert np.array_equal(snapshots_of(run), run.row["time"])


def test_last_sample_of_a_resumed_run(case, hampm):
    """A run that is resumed just before its end has the rows of one that never stopped; rows that end between two samples have one more, at the end."""
    whole = case("last_sample_twice")
    part = case("last_sample_twice", "--steps", "119")
    assert part.code == 5
    assert hampm("--resume", f"{part.path}.checkpoint", program=CHECKED_PROGRAM).returncode == 0
    with h5py.File(part.path) as file:
        assert np.array_equal(file["history/time"][:], whole.row["time"])
    assert len(case("last_sample_twice", "--set", "run.end_time=6.15e-3").row["time"]) == 22
