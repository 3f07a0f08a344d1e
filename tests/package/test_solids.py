"""Solids from Python: the program that runs them is found by their grid."""

import subprocess
import sys

import numpy as np
import pytest

import hampm as package
from hampm.program import dimensions_of, program_of_model
from paths import BATCH, INPUT, PROGRAM, SOLID_PROGRAM

pytestmark = pytest.mark.skipif(not SOLID_PROGRAM.exists(), reason="make program dim=3 makes it")

BAR = """&run end_time = 1.0 /
&grid ! of cubes / not of squares
   lower = -0.1, -0.1, -0.1  cell = 0.1
   cells = 6, 4, 4 /
&material name = 'a'  young = 200e9  poisson = 0.3  density = 7800 /
&body material = 'a'  lower = 0.0, 0.0, 0.0  upper = 0.4, 0.2, 0.2 /
&constraint lower = 0.0, 0.0, 0.0  upper = 0.0, 0.2, 0.2  fix = 'xyz' /
&load kind = 'traction'  lower = 0.4, 0.0, 0.0  upper = 0.4, 0.2, 0.2  force = 1e5, 0.0, 0.0 /
&method time = 'static'  frame = 'total' /
&output snapshot_interval = 1.0 /
"""


@pytest.fixture
def bar(tmp_path, monkeypatch):
    monkeypatch.setenv("HAMPM3D", str(SOLID_PROGRAM))
    (tmp_path / "bar.nml").write_text(BAR)
    return tmp_path / "bar.nml"


def test_the_program_is_that_of_the_grid(bar):
    assert dimensions_of(BAR) == 3 and program_of_model(bar) == SOLID_PROGRAM.resolve() and program_of_model(INPUT / "dcb.nml") == PROGRAM.resolve()
    scene = package.Scene(bar)
    assert scene.found_program() == SOLID_PROGRAM.resolve() and scene.check().particles == 4 * 2 * 2 * 8
    made = package.Scene()
    made.grid.set(cells=(6, 4, 4))
    assert made.dimensions() == 3 and package.Scene(INPUT / "dcb.nml").dimensions() == 2


def test_a_missing_program_is_that_of_the_model(monkeypatch, tmp_path):
    """Keys are those of either program; where neither is there the one of planes is named."""
    from hampm import program
    monkeypatch.setattr(program, "find_program", lambda name=None, dimensions=2: (_ for _ in ()).throw(program.FileError([f"the program {'hampm3d' if dimensions == 3 else 'hampm'} is not found"])))
    with pytest.raises(program.FileError, match="the program hampm is not found"):
        program.key_table()


def test_runs_sweeps_and_snapshots(bar, tmp_path):
    result = package.run(bar, output=tmp_path, progress=False)
    snapshots = package.Snapshots(result.path)
    assert snapshots.dimensions == 3
    block = snapshots.block("mesh", -1 % len(snapshots))
    assert block.points.shape[1] == 3 and block.cells.shape[1] == 8
    found = snapshots.to_xarray()
    assert found.displacement.dims == ("point", "axis") and list(found.axis.values) == ["x", "y", "z"] and found.z.max() < 0.2
    sweep = package.Sweep(bar, {"material.young": [100e9, 200e9]}, output=tmp_path / "sweep")
    sweep.run()
    energies = [history["strain_energy"][-1] for history in map(package.History, sorted((tmp_path / "sweep").rglob("*.h5")))]
    np.testing.assert_allclose(max(energies), 2 * min(energies), rtol=1e-9)


@pytest.mark.verify
def test_cells_have_the_corners_of_vtk(bar, tmp_path):
    """Hexahedra, which have the volume of the bar."""
    pytest.importorskip("pyvista", reason="PyVista is not installed: tools/setup.sh verify")
    mesh = package.Snapshots(package.run(bar, output=tmp_path, progress=False).path).to_pyvista()["mesh"]
    assert mesh.compute_cell_sizes()["Volume"][mesh["particles"] > 0].sum() == pytest.approx(0.4 * 0.2 * 0.2, rel=1e-9)


def test_sweeps_of_files_take_it(bar, tmp_path):
    """What run_sweep.py hands on: the program of the model."""
    (tmp_path / "bar.yaml").write_text("namelist: bar.nml\noutput: out\nproduct:\n  material.young: [1e11, 2e11]\n")
    code = ("import os, run_sweep\nos.execv = lambda program, words: print(*words)\n"
            f"run_sweep.main([{str(tmp_path / 'bar.yaml')!r}])")
    done = subprocess.run([sys.executable, "-c", code], cwd=BATCH, capture_output=True, text=True)
    assert str(SOLID_PROGRAM.resolve()) in done.stdout, done.stderr
