"""Odd numbers of particles along a cell beside finer cells: such a cell is stored as its quarters, and its particles are split where some would stand on the lines that
quarter it."""

import h5py
import numpy as np
import pytest

PLATE = """
&material name = 'a'  young = 70e9  poisson = 0.3  density = 2700 /
&run plane = 'strain'  thickness = 0.01  end_time = {end} /
&grid lower = 0, 0  cell = 0.005  cells = 24, 12 /
&body material = 'a'  lower = 0, 0  upper = 0.1, 0.05  points_per_cell = {points} /
&crack kind = 'symmetry'  tip = 0.05, 0  direction = 1, 0 /
&constraint lower = 0.05, 0  upper = 0.1, 0  fix = 'y' /
&constraint lower = 0.1, 0  upper = 0.1, 0  fix = 'xy' /
&load kind = 'traction'  lower = 0, 0.05  upper = 0.1, 0.05  force = 0, 1e5  history = 'ramp'  rise_time = 1e-4 /
&refine indicator = '{indicator}'  max_level = 2 /
&method time = '{time}'  frame = '{frame}' /
&energy_release estimators = 'domain_integral'  energy_balance = .true. /
"""


@pytest.mark.parametrize(("time", "frame", "indicator", "numbers"), [
    ("static", "total", "tip", (2, 3, 4, 5)), ("static", "total", "zz", (2, 3, 4, 5)), ("explicit", "total", "tip", (1, 2, 3)),
    ("explicit", "updated", "tip", (1, 2, 3)), ("implicit", "total", "tip", (2, 3))])
def test_odd_numbers_are_between_even_ones(hampm, tmp_path, time, frame, indicator, numbers):
    """At rest better quadrature strains the cells more stiffly: the energy falls, less and less, with the number of particles. In motion results are near to
    each other. The energy balance closes."""
    k, energy = [], []
    for points in numbers:
        (tmp_path / "case.nml").write_text(PLATE.format(end=1e-4 if time == "static" else 5e-5, points=points, time=time, frame=frame, indicator=indicator))
        result = hampm("case.nml", "--force", "--quiet")
        assert result.returncode == 0, result.stderr
        with h5py.File(tmp_path / "case.h5") as file:
            history = file["history"]
            k.append(history["K_I"][-1])
            energy.append(history["strain_energy"][-1])
            balance = [history[column][-1] for column in ("strain_energy", "kinetic_energy", "numerical_loss", "external_work")]
        assert sum(balance[:3]) == pytest.approx(balance[3], rel=1e-10)
    print("\nK, energy over those of most particles:", np.array(k)/k[-1], np.array(energy)/energy[-1])
    if time == "static":
        changes = -np.diff(energy)/energy[-1]
        assert np.all(changes > 0) and np.all(changes[1:] < changes[:-1])
    assert np.array(k)/k[-1] == pytest.approx(1, abs={1: 0.04, 2: 0.004}[numbers[0]])


@pytest.mark.parametrize("frame", ["updated", "total"])
def test_cells_refined_in_motion_have_mirror_images(hampm, tmp_path, frame):
    """Particles on the lines that quarter a cell are split while it is whole, before finer ones beside it: the velocities of their children hang on no rounding
    (1e-7 of the forces did, and 3e-5 of the indicator)."""
    histories = []
    for sign in (1, -1):
        lower, upper = sorted((-0.00732421875*sign, 0.00537109375*sign))
        (tmp_path / "case.nml").write_text(f"""
            &material name = 'a'  young = 70e9  poisson = 0.3  density = 2700 /
            &run plane = 'stress'  thickness = 3  end_time = 1e-6 /
            &grid lower = {lower - 0.0009765625}, -0.0009765625  cell = 0.0009765625  cells = 15, 13 /
            &body material = 'a'  points_per_cell = 3  lower = {lower}, 0  upper = {upper}, 0.0107421875 /
            &constraint lower = {lower}, 0  upper = {upper}, 0  fix = 'xy'  name = 'a' /
            &load kind = 'body'  force = {1.4e5*sign}, 8e4  lower = {lower}, 0.005  upper = {upper}, 0.0107421875 /
            &load kind = 'pressure'  pressure = -6e6  lower = {-0.00732421875*sign}, 0  upper = {-0.00732421875*sign}, 0.0107421875 /
            &method frame = '{frame}' /
            &refine indicator = 'gradient'  max_level = 1  rings = 4 /
            &output history_interval = 2.5e-9 /""")
        result = hampm("case.nml", "--force", "--quiet")
        assert result.returncode == 0, result.stderr
        with h5py.File(tmp_path / "case.h5") as file:
            histories.append({name: file["history"][name][:] for name in ("largest_R", "kinetic_energy", "reaction_a_y", "cells")})
    assert histories[0]["cells"][-1] > histories[0]["cells"][0]
    for name, values in histories[0].items():
        assert values == pytest.approx(histories[1][name], abs=1e-9*abs(values).max()), name
