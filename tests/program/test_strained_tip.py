"""Stress intensities and modes of material that is strained much around a tip: said, as J and they mean different things there."""

import h5py
import pytest

SHEET = """
&run plane = 'strain'  thickness = 0.01  end_time = 8e-2 /
&grid lower = 0.0, -0.05  cell = 5e-3  cells = 20, 60 /
&material name = 'rubber'  law = '{law}'  young = 1e6  poisson = 0.3  density = 1000 /
&body material = 'rubber'  lower = 0.0, 0.0  upper = 0.1, 0.2 /
&constraint lower = 0.0, 0.0  upper = 0.1, 0.0  fix = 'y' /
&constraint lower = 0.05, 0.0  upper = 0.05, 0.0  fix = 'x' /
&load kind = 'traction'  lower = 0.0, 0.2  upper = 0.1, 0.2  force = 0.0, {force}  history = 'ramp'  rise_time = 2e-2 /
&damping rate = 300 /
&method frame = 'total'  courant = 0.3 /
&crack kind = 'line'  tip = 0.03, 0.1 /
&energy_release estimators = 'domain_integral' /
&output history_interval = 2e-3 /
"""


@pytest.mark.parametrize("law, force, told", [("neo_hookean", 150, True), ("neo_hookean", 15, False), ("linear_elastic", 15, False)])
def test_modes_of_a_strained_tip(hampm, tmp_path, law, force, told):
    (tmp_path / "sheet.nml").write_text(SHEET.format(law=law, force=force))
    result = hampm("sheet.nml")
    assert result.returncode == 0, result.stderr
    assert ("valid for small strain only" in result.stderr) == told
    with h5py.File(tmp_path / "sheet.h5") as file:
        history = file["history"]
        ratio = history["K_I"][-1]**2 * (1 - 0.3**2) / 1e6 / history["J"][-1]
    assert (abs(ratio - 1) > 0.04) == told
