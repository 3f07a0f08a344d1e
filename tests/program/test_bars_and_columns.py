"""Errors that cover what cells cannot tell, and columns that were missing: cells that lock, stiff fibres, T without K, signs of G, stress_zz, work of viscous material."""

import h5py
import numpy as np
import pytest

from harness import run_told

BEAM = """
&run title = 'SENB, nearly incompressible'  plane = 'strain'  thickness = 8e-3  end_time = 1.0 /
&grid lower = 0, 0  cell = 2e-3  cells = 42, 12 /
&material name = 'gel'  young = 3.2e9  poisson = {nu}  density = 1190 /
&body material = 'gel'  lower = 0, 0  upper = 80e-3, 20e-3 /
&constraint lower = 0, 8e-3  upper = 0, 20e-3  fix = 'x' /
&constraint lower = 70e-3, 0  upper = 70e-3, 0  fix = 'y' /
&load kind = 'point'  lower = 0, 20e-3  upper = 0, 20e-3  force = 0, -100 /
&crack kind = 'symmetry'  tip = 0, 8e-3  direction = 0, 1 /
&method time = 'static' /
&refine indicator = 'tip'  max_level = 1  rings = 4 /
&energy_release estimators = 'vcct', 'domain_integral' /
"""


@pytest.mark.parametrize("nu", [0.49, 0.499, 0.4999, 0.4999999])
def test_bars_of_cells_that_lock(hampm, nu):
    """Loads are statically determinate: K_I is 2.517e6 Pa m^0.5 for any ratio. The run says that cells lock."""
    row, said = run_told(hampm, BEAM.format(nu=nu))
    exact = {"K_I": 2.517e6, "J": 2.517e6**2 * (1 - nu**2) / 3.2e9, "G_vcct_I": 2.517e6**2 * (1 - nu**2) / 3.2e9}
    for name, value in exact.items():
        print(name, row[name][-1] / value, row[f"{name}_error"][-1] / value)
        assert abs(row[name][-1] - value) <= row[f"{name}_error"][-1]
    assert "nearly incompressible cells lock" in said and "volumetric = 'b_bar'" in said
    assert row["J_error"][-1] < 0.6 * row["J"][-1] or nu > 0.49


@pytest.mark.parametrize("arguments", [("material.volumetric=b_bar", "material.poisson=0.499"), ("run.plane=stress", "material.poisson=0.499"), ("material.poisson=0.48",)])
def test_others_do_not_lock(hampm, arguments):
    _, said = run_told(hampm, BEAM.format(nu=0.3), *arguments)
    assert "lock" not in said


def test_bars_along_stiff_fibres(hampm):
    """An edge crack along them, E_1/E_2 = 22: K_I = 2.006e5 Pa m^0.5, J = 42.29 J/m2 (quadratic cells of four levels)."""
    row, _ = run_told(hampm, """
&run title = 'edge crack along fibres'  plane = 'stress'  thickness = 20e-3  end_time = 1 /
&grid lower = 0, -41e-3  cell = 2e-3  cells = 42, 42 /
&material name = 'spruce'  law = 'orthotropic'  young_1 = 11e9  young_2 = 0.5e9  shear_12 = 0.7e9  poisson_12 = 0.4  angle = 0  density = 430 /
&body material = 'spruce'  lower = 0, -40e-3  upper = 80e-3, 40e-3 /
&load kind = 'traction'  lower = 0, 40e-3  upper = 80e-3, 40e-3  force = 0, 500 /
&load kind = 'traction'  lower = 0, -40e-3  upper = 80e-3, -40e-3  force = 0, -500 /
&crack kind = 'path'  points = -1e-3, 0.4e-3, 31.3e-3, 0.4e-3 /
&method time = 'static' /
&refine indicator = 'tip'  max_level = 1  rings = 6 /
&energy_release estimators = 'domain_integral' /
""")
    for name, value in {"K_I": 2.006e5, "J": 42.29, "G": 42.29}.items():
        print(name, row[name][-1], row[f"{name}_error"][-1])
        assert abs(row[name][-1] - value) <= row[f"{name}_error"][-1] < 0.09 * value


def test_t_without_k(hampm):
    """A tension along a crack is its T, to rounding, and its error too."""
    row, _ = run_told(hampm, """
&run title = 't'  plane = 'stress'  end_time = 1.0 /
&grid lower = -0.02, -0.02  cell = 0.001  cells = 40, 40 /
&material name = 'a'  young = 70e9  poisson = 0.3  density = 2700 /
&body material = 'a'  lower = -0.018, -0.018  upper = 0.018, 0.018 /
&load kind = 'traction'  lower = 0.018, -0.018  upper = 0.018, 0.018  force = 1e4, 0 /
&load kind = 'traction'  lower = -0.018, -0.018  upper = -0.018, 0.018  force = -1e4, 0 /
&crack kind = 'path'  points = -0.0062, 0.0003, 0.0057, 0.0003 /
&method time = 'static' /
&energy_release estimators = 'domain_integral'  t_stress = .true. /
""")
    assert row["T_stress"][-1] == pytest.approx(1e4 / 0.036, rel=1e-6)
    assert row["T_stress_error"][-1] < 1e-6 * row["T_stress"][-1]


@pytest.mark.parametrize("estimators", ["'domain_integral'", "'vcct'", "'material_force'"])
def test_g_of_both_modes_has_one_sign(hampm, estimators):
    """Faces that interpenetrate, as nothing keeps them from it: G is that of the reversed load by each estimator, its part of mode I has the sign of K_I."""
    text = """
&run title = 't'  plane = 'strain'  end_time = 1.0 /
&grid lower = 0, 0  cell = 0.001  cells = 20, 20 /
&material name = 'a'  young = 70e9  poisson = 0.3  density = 2700 /
&body material = 'a'  lower = 0, 0  upper = 0.018, 0.018 /
&load kind = 'traction'  lower = 0, 0.018  upper = 0.018, 0.018  force = 0, {force} /
&constraint lower = 0.006, 0  upper = 0.018, 0  fix = 'y' /
&constraint lower = 0.018, 0  upper = 0.018, 0.018  fix = 'x' /
&crack kind = 'symmetry'  tip = 0.006, 0  direction = 1, 0 /
&method time = 'static' /
&energy_release estimators = %s /
""" % estimators
    pressed, pulled = (run_told(hampm, text.format(force=force))[0] for force in (-1e4, 1e4))
    part = {"'domain_integral'": "G_domain_I", "'vcct'": "G_vcct_I", "'material_force'": "G_material_force_I"}[estimators]
    assert pressed["G"][-1] == pytest.approx(pulled["G"][-1], rel=1e-9) and pulled["G"][-1] > 0
    assert pressed[part][-1] < 0 < pulled[part][-1]


CREEP = """
&run title = 'creep'  plane = 'strain'  end_time = 4e-5 /
&grid lower = 0, -0.01  cell = 0.002  cells = 25, 15 /
&material name = 'a'  law = 'viscoelastic'  young = 1e9  poisson = 0.3  density = 1000  moduli = 1e8, 1e8  relaxation_times = 1e-5, 1e-4 /
&body material = 'a'  lower = 0, 0  upper = 0.03, 0.01  points_per_cell = 3 /
&constraint lower = 0, 0  upper = 0, 0.01  fix = 'x' /
&load kind = 'traction'  lower = 0.03, 0  upper = 0.03, 0.01  force = 1e4, 0  history = 'ramp'  rise_time = 1e-5 /
&energy_release energy_balance = .true. /
"""


@pytest.mark.parametrize("arguments", [(), ("method.frame=updated",), ("grid.order=2",), ("run.plane=axisymmetric",), ("method.scheme=usavg",),
                                       ("method.shape_functions=cpdi", "method.frame=updated")])
def test_work_of_viscous_material(hampm, arguments):
    """What it stores and takes more is the work of its stress: the balance closes to rounding."""
    row, _ = run_told(hampm, CREEP, *arguments)
    left = row["external_work"] - sum(row[name] for name in ("kinetic_energy", "strain_energy", "viscous_dissipation", "numerical_loss"))
    print(np.max(np.abs(left)) / np.max(row["external_work"]), row["viscous_dissipation"][-1] / np.max(row["external_work"]))
    assert np.max(np.abs(left)) < 1e-13 * np.max(row["external_work"])
    assert row["viscous_dissipation"][-1] > 1e-3 * np.max(row["external_work"])


@pytest.mark.parametrize("law, exact", [("law = 'linear_elastic'", 0.3), ("law = 'orthotropic' young_1 = 1e9 young_2 = 1e9 young_3 = 2e9 shear_12 = 4e8 poisson_12 = 0.3 poisson_13 = 0.2 poisson_23 = 0.2", 0.4)])
def test_stress_across_the_plane(hampm, law, exact):
    """In plane strain nu (stress_xx + stress_yy), of orthotropic material nu_13 E_3/E_1 times the sum; none in plane stress."""
    text = """
&run title = 'zz'  plane = 'strain'  end_time = 1.0 /
&grid lower = 0, 0  cell = 0.002  cells = 25, 15 /
&material name = 'a'  %s  density = 1000 %s /
&body material = 'a'  lower = 0, 0  upper = 0.03, 0.01 /
&constraint lower = 0, 0  upper = 0, 0.01  fix = 'x' /
&constraint lower = 0, 0  upper = 0.03, 0  fix = 'y' /
&load kind = 'traction'  lower = 0.03, 0  upper = 0.03, 0.01  force = 1e4, 0 /
&method time = 'static' /
&probe name = 'p'  at = 0.015, 0.005  quantity = 'stress' /
&output snapshot_interval = 1.0 /
""" % (law, "" if "ortho" in law else "young = 1e9 poisson = 0.3")
    row, _ = run_told(hampm, text)
    assert row["stress_p_zz"][-1] == pytest.approx(exact * 1e6, rel=1e-6)
    with h5py.File(row.path) as file:
        assert file["VTKHDF/particles/PointData/stress_zz"][-1] == pytest.approx(exact * 1e6, rel=1e-6)
    if "ortho" in law:
        return
    flat, _ = run_told(hampm, text, "run.plane=stress")
    assert "stress_p_zz" not in flat
