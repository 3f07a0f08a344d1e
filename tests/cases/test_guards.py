"""Scenes whose numbers were taken from another material or divided by nothing, and what guards say of a run."""

import h5py
import numpy as np
import pytest


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
