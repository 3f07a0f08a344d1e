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


@pytest.mark.parametrize("name", ["static_needs_no_mass_a", "static_needs_no_mass_b"])
def test_statics_needs_no_mass_matrix(case, text_of, name):
    """Equilibrium has no inertia: the state is that of mass = 'lumped' to the last bit, and the mass that was asked for is said to have no effect."""
    run = case(name)
    assert run.code == 0 and "&method mass = " in run.stderr and "has no effect" in run.stderr, run.stderr
    lumped = case(name, "--set", "method.mass='lumped'")
    for column, values in lumped.row.items():
        assert np.array_equal(values, run.row[column]), column


def test_work_on_a_mesh_that_is_refined_at_rest(case, text_of):
    """A linear body at rest has stored what the loads have done, on the mesh on which it rests: finer cells have nodes in the box of the constraint that had moved
    before they were there. (The run ended with 'the energy has grown ... unstable; reduce courant'.) The energy is that of a mesh that is fine from the start."""
    run = case("static_gradient_energy_guard")
    assert run.code == 0, run.stderr
    assert run.row["external_work"][-1] == pytest.approx(run.row["strain_energy"][-1], rel=1e-9)
    text = text_of("static_gradient_energy_guard").replace("cell = 0.001\n", "cell = 0.0005\n").replace("cells = 16, 12", "cells = 32, 24")
    fine = case("static_gradient_energy_guard", "--set", "refine.indicator='none'", text=text)
    assert run.row["strain_energy"][-1] == pytest.approx(fine.row["strain_energy"][-1], rel=0.05)


def test_sine_is_resolved_by_steps(case, text_of):
    """Less than ten steps to a period see another sine: refused with the frequency and the step. Up to twenty are told of, in static load steps too."""
    run = case("sine_not_resolved")
    assert run.code == 2 and "frequency = 3497348.434864105" in run.stderr and "time steps of 1.14e-7 s: 2.5 of them to a period" in run.stderr, run.stderr
    run = case("sine_not_resolved", "--set", "load.frequency=5e5")
    assert run.code == 0 and "warning: &load 1: steps of 1.14e-7 s take 17.5 points of a period of its sine of 500000.0 Hz" in run.stderr, run.stderr
    run = case("sine_not_resolved", "--set", "load.frequency=3e5")
    assert run.code == 0 and "points of a period" not in run.stderr, run.stderr
    pulse = text_of("sine_not_resolved").replace("history = 'sine'\n   frequency = 3497348.434864105", "history = 'table'  times = 0, 2e-7, 2.1e-7, 2.2e-7  factors = 0, 0, 1, 0")
    run = case("sine_not_resolved", text=pulse)
    assert run.code == 0 and "may pass by its factor at 2.1e-7 s" in run.stderr, run.stderr


def coarse_damped_plate(text_of, method, damping="&damping rate = 1.2e5 /"):
    """The damped plate with cells of twice the size."""
    return (text_of("damped_rest_differs_from_static").replace("lower = -21e-3, -21e-3  cell = 1e-3  cells = 42, 42", "lower = -22e-3, -22e-3  cell = 2e-3  cells = 22, 22")
            .replace("end_time = 3e-4", "end_time = 1.5e-4").replace("history_interval = 6e-6", "history_interval = 3e-5")
            .replace("&method mass = 'consistent' /", f"&method {method} /").replace("&damping rate = 1.2e5 /", damping))


def test_a_motion_that_trembles_near_rest(case):
    """With the lumped mass matrix single nodes tremble, 1.2 % from rest. Bonds at nodes of little mass keep their stiffness: K is that of equilibrium, where weaker ones let it
    be 12 % too large."""
    text = """\
&run plane = 'strain'  end_time = 3e-4 /
&grid lower = 0.2e-3, 0.0  cell = 1e-3  cells = 9, 12 /
&material name = 'm'  young = 70e9  poisson = 0.3  density = 5400.0 /
&body material = 'm'  lower = 0.2e-3, 0.0  upper = 9.2e-3, 12e-3 /
&crack kind = 'path'  points = 4.8e-3, 3.7e-3, 4.8e-3, 8.1e-3 /
&constraint lower = 0.2e-3, 0.0  upper = 9.2e-3, 0.0  fix = 'xy' /
&load kind = 'pressure'  on = 'crack'  pressure = 1.57e6 /
&damping rate = 3e5 /
&energy_release estimators = 'domain_integral' /
&output history_interval = 1e-4 /
"""
    run = case("trembles", text=text)
    static = case("trembles", text=text.replace("&damping rate = 3e5 /", "&method time = 'static' /").replace("end_time = 3e-4", "end_time = 1e-4"))
    for tip in ("", "_tip2"):
        assert run.row[f"K_I{tip}"][-1] == pytest.approx(static.row[f"K_I{tip}"][-1], rel=0.01)


def test_damped_rest_is_equilibrium(case, text_of):
    """J, K and the opening of a damped plate at rest are those of time = 'static' on the same cells with the default step (with weaker bonds they were 9.5 %, 2 % and 16 %
    off) but for the ghost penalty on small pieces, which equilibrium alone has (0.7 % of J, 1.0 % of the opening)."""
    static = case("damped_rest_differs_from_static", text=coarse_damped_plate(text_of, "time = 'static'  load_steps = 1", ""))
    for mass in ("consistent", "lumped"):
        run = case("damped_rest_differs_from_static", text=coarse_damped_plate(text_of, f"mass = '{mass}'"))
        assert run.code == 0, run.stderr
        for column in ("J", "K_I", "K_II", "J_tip2", "strain_energy", *["crack_opening"] * (mass == "consistent")):  # single nodes tremble where masses are lumped
            assert run.row[column][-1] == pytest.approx(static.row[column][-1], rel=1.5e-2), column
