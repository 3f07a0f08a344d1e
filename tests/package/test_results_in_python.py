"""Runs, histories, snapshots and sweeps from Python, and results in xarray, pandas and PyVista."""

import inspect
import os
import re
import shutil
import signal
import subprocess
import sys
import threading
import warnings
import zipfile

import h5py
import numpy as np
import pytest

import hampm as package
from paths import DCB, PROGRAM, ROOT

COARSE = {"grid.cell": 5e-3, "grid.cells": (20, 3), "run.end_time": 3e-4}


def test_a_run_gives_its_history(plate, tmp_path):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        history = package.run(plate, output=tmp_path / "results", threads=2, progress=False)
    assert history.path == tmp_path / "results/plate.h5" and history.attributes["ended"] == "done"
    value, error = history.value("K_I")
    assert 0 < error < 0.2 * value
    with pytest.raises(package.FileError, match="there is a result"):
        package.run(plate, output=tmp_path / "results", progress=False, force=False)


def test_progress_is_told(tmp_path):
    parts = []
    package.run(DCB, output=tmp_path, progress=parts.append, settings=COARSE | {"grid.cell": 1.25e-3, "grid.cells": (80, 9), "run.end_time": 1e-4})
    assert parts == sorted(parts) and parts[-1] == 1.0


def test_what_a_run_warns_of_is_a_warning(tmp_path):
    with pytest.warns(package.HampmWarning, match="off with points_per_cell = 1"):
        package.run(DCB, output=tmp_path, progress=False, settings=COARSE | {"body.points_per_cell": 1})


def test_a_computation_that_fails_is_an_exception(tmp_path):
    with pytest.raises(package.ComputationError, match="step") as error:
        package.run(DCB, output=tmp_path, progress=False, settings=COARSE | {"load.force": (0, 1e9)})
    assert error.value.exit_code == 3


def test_a_run_that_is_stopped_goes_on(tmp_path):
    """And has the history of one that was not, to the byte."""
    longer = {"grid.cell": 2.5e-3, "grid.cells": (40, 5), "run.end_time": 3e-4}
    with pytest.raises(package.Stopped, match="--time-limit"):
        package.run(DCB, output=tmp_path, progress=False, settings=longer, time_limit=0.02)
    gone_on = package.run(DCB, output=tmp_path, progress=False, settings=longer, resume=True)
    assert package.compare(gone_on, package.run(DCB, output=tmp_path / "other", progress=False, settings=longer), exact=True)


def test_an_interrupt_stops_the_program_with_a_checkpoint(tmp_path):
    threading.Timer(0.7, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
    with pytest.raises(package.Stopped):
        package.run(DCB, output=tmp_path, progress=False)
    assert (tmp_path / "dcb.h5.checkpoint").exists()


def test_a_history_is_a_table_of_pandas(plate_result):
    history = package.History(plate_result)
    frame = history.to_pandas()
    assert frame.index.name == "time" and frame.attrs["units"]["K_I"] == "Pa m^0.5" and {"K_I", "K_I_error", "G", "G_error"} <= set(frame)
    np.testing.assert_array_equal(frame["K_I"], history["K_I"])


def test_a_history_is_a_dataset_of_xarray(plate_result):
    """Made by the package, and opened by xarray itself, whose coordinate is the time."""
    xarray = pytest.importorskip("xarray")
    own = package.History(plate_result).to_xarray()
    with xarray.open_dataset(plate_result, group="history", engine="h5netcdf") as opened:
        assert list(opened.coords) == ["time"] and set(opened.dims) == {"time"}
        assert opened.K_I.attrs["units"] == own.K_I.attrs["units"] == "Pa m^0.5" and opened.time.attrs["units"] == "s"
        np.testing.assert_array_equal(opened.K_I, own.K_I)
        assert set(opened.data_vars) == set(own.data_vars)


def test_time_is_the_dimension_of_all_columns(plate_result):
    with h5py.File(plate_result) as file:
        history = file["history"]
        assert history["time"].is_scale
        assert all(list(column.dims[0]) == ["time"] and column.dims[0][0] == history["time"] for name, column in history.items() if name != "time")


def test_a_result_says_where_it_comes_from(plate, tmp_path):
    result = package.run(plate, output=tmp_path, progress=False).path
    with h5py.File(result) as file:
        about = dict(file.attrs)
    assert about["program"] == "hampm" and re.fullmatch(r"\d+\.\d+\.\d+", about["version"]) and re.fullmatch(r"|[0-9a-f]{7,}(, modified)?", about["commit"])
    assert re.fullmatch(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d[+-]\d\d:\d\d", about["date"]) and "plate.nml" in about["command"]
    assert about["machine"] and 0 < about["wall_time"] < 60


def test_fields_of_snapshots_have_units(plate_result):
    units = {"displacement": "m", "velocity": "m/s", "stress_xx": "Pa", "stress_yy": "Pa", "stress_zz": "Pa", "stress_xy": "Pa", "energy_density": "J/m3", "mass": "kg"}
    with h5py.File(plate_result) as file:
        for block in ("particles", "mesh", "cracks"):
            for kind in ("PointData", "CellData"):
                for name, data in file.get(f"VTKHDF/{block}/{kind}", {}).items():
                    assert data.attrs["units"] == units.get(name, "1"), name


def test_snapshots_are_datasets_of_xarray(plate_result):
    pytest.importorskip("xarray")
    snapshots = package.Snapshots(plate_result)
    particles, mesh, cracks = (snapshots.to_xarray(block) for block in snapshots.blocks)
    assert len(snapshots) == 2 and float(particles.time) == 1.0 and particles.stress_yy.attrs["units"] == "Pa"
    assert particles.sizes["point"] == package.History(plate_result)["particles"][-1] == mesh.particles.sum()
    # a row of particles carries the load [N], the thickness being 1 m
    row = abs(particles.y.values - 10.5e-3) < 1e-6
    assert row.sum() == 24 and particles.stress_yy.values[row].mean() * 24e-3 == pytest.approx(24e3, rel=0.02)
    corners = mesh.x.values[mesh.corners.values]
    assert np.allclose(np.ptp(corners, axis=1), 2e-3)
    assert sorted(cracks.tip.values) == [1, 2]
    assert float(snapshots.to_xarray("particles", time=0.0).time) == 0.0
    with pytest.raises(package.ResultError, match="no snapshot 7"):
        snapshots.to_xarray(snapshot=7)


@pytest.mark.verify
def test_snapshots_are_blocks_of_pyvista(plate_result):
    pytest.importorskip("pyvista", reason="PyVista is not installed: tools/setup.sh verify")
    snapshots = package.Snapshots(plate_result)
    blocks, particles = snapshots.to_pyvista(), snapshots.to_xarray("particles")
    assert set(blocks.keys()) == {"particles", "mesh", "cracks"}
    np.testing.assert_array_equal(blocks["particles"]["stress_yy"], particles.stress_yy)
    np.testing.assert_array_equal(blocks["particles"].points[:, 0], particles.x.astype(blocks["particles"].points.dtype))


@pytest.mark.verify
def test_a_series_for_paraview_has_every_snapshot(plate_result, tmp_path):
    """The file .pvd names each time with its blocks, whose numbers are those of the result."""
    pyvista = pytest.importorskip("pyvista", reason="PyVista is not installed: tools/setup.sh verify")
    snapshots = package.Snapshots(plate_result)
    snapshots.to_paraview(tmp_path / "a & b.pvd")
    series = pyvista.PVDReader(str(tmp_path / "a & b.pvd"))
    np.testing.assert_array_equal(series.time_values, snapshots.times)
    for number in range(len(snapshots)):
        series.set_active_time_point(number)
        blocks = series.read()[0]
        assert set(blocks.keys()) == {"particles", "mesh", "cracks"}
        np.testing.assert_array_equal(blocks["particles"]["stress_yy"], snapshots.to_xarray("particles", snapshot=number).stress_yy)


def test_notebooks_show_tables_and_a_picture(plate_result, dcb_result):
    history = package.History(dcb_result)
    html = history._repr_html_()
    assert html.count("<table>") == 1 and "<svg" in html and "G_vcct_I" in html and "not at rest" in html
    assert "<svg" not in package.History(plate_result)._repr_html_() and "K_I" in repr(package.History(plate_result))


def test_a_sweep_runs_what_has_not_ended(plate, tmp_path):
    values = {"crack.points": [(-4.1e-3, -1.3e-3, 3.7e-3, 2.2e-3), (-4.1e-3, -1.3e-3, 3.7e-3, -1.2e-3)],
              ("grid.cell", "grid.cells"): [(2e-3, (12, 14)), (1e-3, (24, 28))]}
    sweep = package.Sweep(plate, values, output=tmp_path).run(jobs=1, progress=False)
    table = sweep.to_pandas(["K_*"])
    assert len(table) == len(sweep) == 4 and not sweep.failures and table.attrs["units"]["K_I"] == "Pa m^0.5"
    assert (table.K_I_error > 0).all() and set(table["grid.cell"]) == {1e-3, 2e-3}
    times = {name: sweep.result(name).stat().st_mtime_ns for name in sweep.cases}
    again = package.Sweep(plate, values, output=tmp_path).run(progress=False)
    assert times == {name: again.result(name).stat().st_mtime_ns for name in again.cases} and "done" in repr(again)
    wrong = package.Sweep(plate, {"grid.cell": [-1.0, 2e-3]}, output=tmp_path / "wrong").run(progress=False)
    assert [type(error) for error in wrong.failures.values()] == [package.ModelError] and len(wrong.histories()) == 1
    refused, = wrong.failures
    assert "must be in (0, inf)" in str(wrong.failures[refused]) and wrong.forget() == [refused] and not wrong.failures


def test_a_sweep_goes_on_with_what_was_stopped(tmp_path):
    """After an interrupt the twelve cases that ended are not run again, and those that were stopped go on from their checkpoints."""
    values = {"damping.rate": [0, 1e3, 1e4], "material.poisson": [0.1, 0.2, 0.3, 0.4]}
    scene = package.Scene(DCB).with_settings({"grid.cell": 2.5e-3, "grid.cells": (40, 5), "run.end_time": 1e-3})
    sweep = package.Sweep(scene, values, output=tmp_path / "out of it")
    script = ("import sys, hampm; from pathlib import Path\n"
              f"scene = hampm.Scene(sys.argv[1]).with_settings({{'grid.cell': 2.5e-3, 'grid.cells': (40, 5), 'run.end_time': 1e-3}})\n"
              f"hampm.Sweep(scene, {values}, output=sys.argv[2]).run(jobs=2)\n")
    process = subprocess.Popen([sys.executable, "-c", script, DCB, tmp_path / "out of it"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                               env=os.environ | {"PYTHONPATH": str(ROOT / "python/src")}, start_new_session=True)
    for _ in range(4):
        assert "done: " in process.stdout.readline()
    process.send_signal(signal.SIGINT)
    assert "KeyboardInterrupt" in process.communicate(timeout=60)[1]
    ended = {name: sweep.result(name).stat().st_mtime_ns for name in sweep.cases if "outcome" in sweep.declared.record(name)}
    stopped = [name for name, error in sweep.failures.items() if isinstance(error, package.Stopped)]
    assert 4 <= len(ended) < 12 and len(stopped) <= 2 and all(sweep.result(name).with_suffix(".h5.checkpoint").exists() for name in stopped)
    sweep.run(progress=False)
    assert not sweep.failures and len(sweep.histories()) == 12 and ended.items() <= {name: sweep.result(name).stat().st_mtime_ns for name in sweep.cases}.items()
    assert [sweep.declared.record(name)["spent"]["starts"] for name in stopped] == [2] * len(stopped)


def test_a_sweep_of_a_file_has_its_cases_and_results(plate, tmp_path):
    """They are those of `batch/`, whoever has run them: scripts have them in their table, and what a script has run is done."""
    pytest.importorskip("yaml")
    (tmp_path / "sweep.yaml").write_text("namelist: plate.nml\noutput: results\nproduct:\n  material.poisson: [0.2, 0.3]\n"
                                         "  grid.cell, grid.cells:\n    - [2e-3, [12, 14]]\n  energy_release.estimators: [domain_integral]\n")
    sweep = package.Sweep.read(tmp_path / "sweep.yaml").run(progress=False)
    assert len(sweep.histories()) == 2 and not sweep.failures
    assert [settings["grid.cells"] for settings in sweep.cases.values()] == [[12, 14]] * 2
    assert [sweep.result(name) for name in sweep.cases] == [tmp_path / "results/cases" / name / f"{name}.h5" for name in sweep.cases]
    collected = subprocess.run([sys.executable, ROOT / "batch/collect.py", tmp_path / "sweep.yaml", "--strict"], capture_output=True, text=True)
    assert collected.returncode == 0 and "2 cases: 2 done; " in collected.stdout, collected.stderr
    first, other = sweep.forget(sweep.cases)
    assert repr(sweep).count("to do") == 2
    words = [word for key, text in sweep.declared.cases[first].items() for word in ("--set", f"{key}={text}")][1::2]
    subprocess.run([sys.executable, ROOT / "batch/run_case.py", sweep.declared.folder(first), plate.path, "--program", PROGRAM, "--set", *words], check=True)
    again = package.Sweep.read(tmp_path / "sweep.yaml")
    assert repr(again).count("done") == repr(again).count("to do") == 1
    assert package.compare(again.result(first), again.run(progress=False).result(first), exact=True) and len(again.histories()) == 2
    plate.with_settings({"material.density": 7000.0}).write(tmp_path / "plate.nml")
    assert repr(package.Sweep.read(tmp_path / "sweep.yaml")).count("to do") == 2


WRONG = {   # what is asked of a plate's result, in a folder -> the error
    "a part": (lambda plate, result, folder: package.History(result).value("K_I", part=5), package.ResultError, "above 0 and at most 1"),
    "a column": (lambda plate, result, folder: package.History(result).value("K_III"), package.ResultError, "no column 'K_III'"),
    "a tolerance": (lambda plate, result, folder: package.compare(result, result, rtol=-1), package.ResultError, "tolerances are numbers >= 0"),
    "one value": (lambda plate, result, folder: package.Sweep(plate, {"grid.cell": 1e-3}, output=folder), ValueError, "grid.cell: 0.001: a list of values is needed"),
    "a text": (lambda plate, result, folder: package.Sweep(plate, {"method.mass": "lumped"}, output=folder), ValueError, "a list of values is needed"),
    "a name": (lambda plate, result, folder: package.Sweep(plate, {"output.file": ["a.h5"]}, output=folder), ValueError, "named by their folders"),
    "a case": (lambda plate, result, folder: package.Sweep(plate, {"grid.cell": [1e-3]}, output=folder).forget(["x"]), package.ResultError, "no case 'x'"),
    "a model": (lambda plate, result, folder: package.Scene(result), package.FileError, "not a text"),
    "a program": (lambda plate, result, folder: package.key_table("/bin/true"), package.FileError, "is no hampm"),
}


@pytest.mark.parametrize("name", WRONG)
def test_what_makes_no_sense_is_told(plate, plate_result, tmp_path, name):
    action, kind, said = WRONG[name]
    with pytest.raises(kind, match=re.escape(said)):
        action(plate, plate_result, tmp_path)


def test_a_history_without_samples(plate_result, tmp_path):
    """It can be looked at, and has no values."""
    shutil.copy(plate_result, tmp_path / "empty.h5")
    with h5py.File(tmp_path / "empty.h5", "a") as file:
        for name in list(file["history"]):
            del file["history"][name]
            file["history"][name] = np.empty(0)
    with pytest.raises(package.ResultError, match="no samples yet"):
        package.History(tmp_path / "empty.h5")
    empty = package.History(tmp_path / "empty.h5", may_be_empty=True)
    assert "no samples" in repr(empty) and "no samples" in empty._repr_html_() and empty.to_pandas().empty and empty.to_xarray().sizes["time"] == 0
    for action in (empty.table, lambda: empty.value("K_I"), lambda: package.extrapolate([empty, empty])):
        with pytest.raises(package.ResultError, match="no samples yet"):
            action()


def test_the_unfinished_file_of_a_run_names_the_whole_one(plate_result, tmp_path):
    """A run that is killed leaves a file that HDF5 cannot open beside the one that was whole last."""
    shutil.copy(plate_result, tmp_path / "a.h5")
    (tmp_path / "a.h5.part").write_bytes(plate_result.read_bytes()[:4096])
    with pytest.raises(package.ResultError, match="a.h5.part: .* a.h5 is what was whole last"):
        package.History(tmp_path / "a.h5.part")


def test_computed_values_have_short_names(plate, tmp_path):
    """Numbers of numpy as plain ones; names and tables in few digits, what is run in all."""
    points = np.array([-4.1e-3, -1.3e-3, 3.7e-3, 2.2e-3]) * np.sqrt(0.9)
    sweep = package.Sweep(plate, {"crack.points": [points], "material.poisson": np.array([0.2, 0.3])}, output=tmp_path)
    name = next(iter(sweep.cases))
    assert name.startswith("poisson-0.2_") and "np." not in repr(sweep) and "0.00351" in repr(sweep)
    assert sweep.declared.cases[name]["crack.points"].split(",") == [repr(float(value)) for value in points]
    other = package.Sweep(plate, {"crack.points": [points, 1.1 * points]}, output=tmp_path)
    assert next(iter(other.cases)).startswith("points--0.00389x-0.001233x0.00351x0.002087_")


def test_all_that_is_public_is_typed_and_explained():
    """Signatures and docstrings, which editors show."""
    missing = []
    for name in package.__all__:
        item = getattr(package, name)
        missing += [] if inspect.getdoc(item) else [name]
        if isinstance(item, type) and issubclass(item, Exception):
            continue
        members = {name: item} if not isinstance(item, type) else {f"{name}.{key}": value for key, value in vars(item).items() if not key.startswith("_")}
        for place, member in members.items():
            function = member.fget if isinstance(member, property) else getattr(member, "__func__", member)
            if inspect.isfunction(function):
                missing += [] if inspect.getdoc(function) else [place]
                missing += [f"{place}({one.name})" for one in inspect.signature(function).parameters.values() if one.name not in ("self", "cls") and
                            one.annotation is inspect.Parameter.empty and one.kind is not inspect.Parameter.VAR_KEYWORD]
    assert missing == []


@pytest.mark.verify
def test_the_page_of_python_runs(tmp_path, monkeypatch):
    """Its twelve cases; K of cells of size zero is that of theory, but for the width of the plate."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLCONFIGDIR", str(tmp_path))
    for module in ("pandas", "xarray", "pyvista"):
        pytest.importorskip(module)
    names = {}
    (tmp_path / "input").mkdir()
    for file in ("dcb.nml", "edge_crack.nml"):
        shutil.copy(DCB.with_name(file), tmp_path / "input")
    (tmp_path / "plate.model.yaml").write_text("{run: {end_time: 1.0}, load: [{kind: body}, {kind: body}]}")
    for block in re.findall(r"^```python\n(.*?)^```", (ROOT / "docs/how-to/python.md").read_text(), re.MULTILINE | re.DOTALL):
        exec(block, names)
    assert len(names["table"]) == 12 and not names["sweep"].failures and (tmp_path / "angles.png").stat().st_size > 5000
    for k, angle in enumerate(names["angles"]):
        for name in ("K_I", "K_II"):
            assert abs(names["limits"][k].values[name]) / names["scale"] == pytest.approx(names["theory"][name][k] / names["scale"], abs=0.03), (name, angle)
    assert names["found"].value == pytest.approx(np.degrees(np.arccos(np.sqrt(0.7 / 1.0175))), abs=3) and names["half"].time == 1
    assert names["fit"].values == {"material.young": pytest.approx(73e9, rel=2e-3), "material.density": pytest.approx(2700, rel=2e-3)}
    across = names["limits"][0]
    assert across.values["K_I"] / names["scale"] == pytest.approx(1.0175, abs=0.01)
    assert names["particles"].sizes["point"] > 1000 and names["mesh"].n_cells > 300


def test_all_of_the_package_is_installed(tmp_path):
    """All modules, and the mark that it is typed."""
    built = subprocess.run([sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", tmp_path], cwd=ROOT / "python", capture_output=True, text=True,
                           env=os.environ | {"HAMPM_PURE": "1"})
    assert built.returncode == 0, built.stderr
    wheel, = tmp_path.glob("*.whl")
    own = {f"hampm/{path.relative_to(ROOT / 'python/src/hampm')}" for path in (ROOT / "python/src/hampm").rglob("*")
           if path.is_file() and "__pycache__" not in path.parts}
    assert {name for name in zipfile.ZipFile(wheel).namelist() if ".dist-info/" not in name} == own


def test_the_package_needs_little(tmp_path):
    """numpy, h5py and f90nml; what else is there is not imported before it is asked for."""
    said = subprocess.run([sys.executable, "-c", "import sys, hampm; print(sorted({'pandas', 'xarray', 'pyvista', 'vtk', 'matplotlib', 'f90nml'} & set(sys.modules)))"],
                          capture_output=True, text=True, check=True, env=os.environ | {"PYTHONPATH": str(ROOT / "python/src"), "HAMPM": str(PROGRAM)})
    assert said.stdout.strip() == "[]"
