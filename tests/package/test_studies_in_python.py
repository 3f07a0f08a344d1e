"""Sweeps by names of one's own, as tables of numbers, and functions over their cases; values of keys that are looked for."""

import re

import numpy as np
import pytest

import hampm as package
from paths import DCB

HALF = 4e-3         # length of the crack [m]


def ends(angle):
    """Of a crack aside of the lines of the grid."""
    along = HALF * np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle))])
    return np.array([0.11e-3, 0.23e-3]) + [-along, along]


def largest_k(history):
    """Of a case, in a process of a pool."""
    return float(max(history.K_I))


@pytest.fixture(scope="module")
def sweep(plate_result, tmp_path_factory):
    """Angles by cells; K of cells of two sizes."""
    scene = package.Scene(plate_result.with_suffix(".nml"))
    values = {"$angle": np.array([0.0, 30.0]), "crack.points": ends, ("grid.cell", "grid.cells"): [(2e-3, (12, 14)), (1e-3, (24, 28))]}
    return package.Sweep(scene, values, output=tmp_path_factory.mktemp("sweep")).run(progress=False)


def test_cases_are_called_by_what_they_are_declared_by(sweep):
    assert not sweep.failures and list(sweep.labels.values()) == [f"angle={angle} cell={cell} cells={cells}" for angle in (0, 30)
                                                                  for cell, cells in (("0.002", "12, 14"), ("0.001", "24, 28"))]
    assert all(re.fullmatch(r"angle-(0|30)\.0_cell-0\.00[12]_cells-\d+x\d+_\w{8}", name) for name in sweep.cases)
    assert sweep.history(angle=30, cell=1e-3).path == sweep.result(list(sweep.cases)[3])
    assert "angle" in repr(sweep) and repr(sweep).count("done") == 4
    for wrong, said in (({"angle": 30}, "2 cases have angle=30"), ({"angle": 1}, "0 cases have"), ({"phi": 1}, "have no 'phi'; they have angle, cell, cells")):
        with pytest.raises(KeyError, match=said):
            sweep.history(**wrong)


def test_a_table_has_numbers_back_as_they_were(sweep):
    table = sweep.to_pandas(["K_I", "K_II"])
    assert list(table.angle) == [0.0, 0.0, 30.0, 30.0] and list(table["grid.cells"].unique()) == [(12, 14), (24, 28)] and table["grid.cell"].dtype == float
    assert table.index.name == "case" and list(table.index) == list(sweep.cases) and "crack.points" not in table
    by = sweep.to_pandas(["K_I", "K_II"], index="settings")
    assert by.index.names == ["angle", "grid.cell", "grid.cells"] and by.K_I.xs(30.0, level="angle").size == 2
    across, turned = (by.K_I.groupby("angle").mean()[angle] for angle in (0.0, 30.0))
    assert turned / across == pytest.approx(np.cos(np.radians(30)) ** 2, rel=0.05)           # of an infinite plate
    assert by.droplevel("grid.cells").to_xarray().K_II.sel(angle=30.0).shape == (2,)
    with pytest.raises(package.ResultError, match="there are 'case' and 'settings'"):
        sweep.to_pandas(index="angle")


def test_a_function_goes_over_all_cases(sweep):
    found = sweep.map(largest_k)
    assert list(found) == list(sweep.cases) and found == sweep.map(lambda history: float(max(history.K_I)), jobs=2)
    assert list(found.values()) == [max(sweep.history(angle=angle, cell=cell).K_I) for angle in (0, 30) for cell in (2e-3, 1e-3)]


@pytest.mark.parametrize(("values", "said"), [
    ({"$angle": [0], "crack.points": lambda turn: ends(turn)}, "there is no $turn"), ({"crack.points": lambda angle: ends(angle)}, "there is no $angle"),
    ({"$angle": [0, 1]}, "is there already")])
def test_names_that_make_no_case_are_told(plate, tmp_path, values, said):
    with pytest.raises(ValueError, match=re.escape(said)):
        package.Sweep(plate, values, output=tmp_path)


def test_the_value_at_which_a_column_comes_to_a_target(plate, tmp_path):
    """K is proportional to the load, so that the load is known; its error is that of K."""
    study = package.Study(plate, output=tmp_path, computed={("load(1).force", "load(2).force"): lambda f: ((0, f), (0, -f))})
    k, error = plate.run(output=tmp_path / "one", progress=False).value("K_I")
    for quantity in ("K_I", "max K_I"):
        found = study.solve("$f", quantity, 1.5 * k, between=(24e3, 72e3))
        assert found.value == pytest.approx(36e3, rel=2e-3) and found.error == pytest.approx(36e3 * error / k, rel=0.05)
        assert found.history["K_I"][-1] == pytest.approx(1.5 * k, rel=2e-3) and str(found).startswith("$f = 36")
    by_function = study.solve("$f", lambda history: history.K_I[-1] / 1e3, 1.5e-3 * k, between=(24e3, 72e3))
    assert by_function.value == found.value and by_function.error is None
    with pytest.raises(package.ResultError, match="is not between them"):
        study.solve("$f", "K_I", 10 * k, between=(24e3, 72e3))
    with pytest.raises(package.ModelError, match="poisson"):
        package.Study(plate, output=tmp_path).solve("material.poisson", "K_I", k, between=(0.2, 0.7))


def test_keys_that_follow_a_measured_curve(tmp_path):
    """What a model of other keys has computed gives these back, with noise within the errors; none of its runs is done twice."""
    beam = package.Scene(DCB).with_settings({"grid.cell": 5e-3, "grid.cells": (20, 3), "run.end_time": 3e-4})
    truth = beam.run(output=tmp_path / "truth", progress=False)
    keys = {"material.young": 70e9, "material.density": 2700.0}
    t, opening = truth.times[10::10], truth["crack_opening"][10::10]
    study = package.Study(beam, output=tmp_path / "runs")
    start = {"material.young": 60e9, "material.density": 3000.0}
    fit = study.fit(start, t, opening, "crack_opening")
    assert {key: pytest.approx(value, rel=1e-3) for key, value in keys.items()} == fit.values and "material.young" in str(fit)
    runs = {path: path.stat().st_mtime_ns for path in (tmp_path / "runs").rglob("*.h5")}
    assert len(runs) == fit.runs and study.fit(start, t, opening, "crack_opening").values == fit.values
    assert runs == {path: path.stat().st_mtime_ns for path in (tmp_path / "runs").rglob("*.h5")}
    sigma = 0.02 * opening.max()
    noisy = opening + np.random.default_rng(3).normal(0, sigma, opening.size)
    fit = study.fit(start, t, noisy, "crack_opening", sigma=sigma)
    assert all(abs(fit.values[key] - value) < 3 * fit.errors[key] and fit.errors[key] < 0.1 * value for key, value in keys.items()), fit
    for wrong, said in (((start, t + 1, opening, "crack_opening"), "time is from 0 to 0.0003"), ((start, t[:2], opening[:2], "crack_opening"), "more points than keys")):
        with pytest.raises(package.ResultError, match=said):
            study.fit(*wrong)
