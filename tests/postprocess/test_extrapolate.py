"""Results on cells of several sizes, extrapolated to size zero."""

import h5py
import numpy as np
import pytest

from history import History
from synthetic import dcb, write_result


@pytest.fixture
def on_cells(tmp_path):
    """Write a result whose G errs by `first` c + `second` c^2 of itself, c in mm."""
    def write(size, first=-0.01, second=0.0, distance=None, error=None, **more):
        columns = dcb(**more)
        columns["G_vcct_I"] = columns["G_vcct_I"] * (1 + first * size + second * size**2)
        columns["finest_cell"] = np.full_like(columns["time"], size * 1e-3)
        if error is not None:
            columns["G_vcct_I_error"] = error * exact()
        return write_result(tmp_path / f"c{size:g}.h5", columns, distance=distance)
    return write


def exact():
    return dcb()["G_vcct_I"]


@pytest.mark.parametrize("sizes", [(2.0, 1.0), (3.0, 2.0), (1.0, 2.0), (4.0, 2.0, 1.0), (5.0, 3.0, 2.0)])
def test_polynomials_in_the_cell_size_are_removed(script, on_cells, tmp_path, sizes):
    second = 0.003 if len(sizes) > 2 else 0.0
    files = [on_cells(size, second=second) for size in sizes]
    assert script("extrapolate.py", *files, "--output", tmp_path / "zero.h5", "--column", "G_vcct_*").returncode == 0
    result = History(tmp_path / "zero.h5")
    np.testing.assert_allclose(result.columns["G_vcct_I"], exact(), rtol=1e-12, atol=1e-20)
    assert result.units["G_vcct_I"] == "J/m2"
    assert result.g_ref() == History(files[0]).g_ref()
    with h5py.File(tmp_path / "zero.h5") as file:
        assert str(files[0]) in file["input"].attrs["extrapolated_from"]


def test_samples_at_other_times_are_interpolated(script, on_cells, tmp_path):
    files = [on_cells(2.0, samples=2401), on_cells(1.0)]
    assert script("extrapolate.py", *files, "-o", tmp_path / "zero.h5").returncode == 0
    np.testing.assert_allclose(History(tmp_path / "zero.h5").columns["G_vcct_I"], exact(), rtol=1e-9, atol=1e-20)


def test_the_table_tells_the_order_and_the_errors(script, on_cells):
    shown = script("extrapolate.py", *map(on_cells, (4.0, 2.0, 1.0)), "--column", "G_vcct_I").stdout.splitlines()[1].split()
    assert float(shown[4]) == pytest.approx(np.mean(exact()[-121:]), rel=1e-5)  # the last tenth
    assert float(shown[5]) == pytest.approx(-1.0, abs=1e-3)
    assert float(shown[6]) == pytest.approx(0.0, abs=1e-3)
    assert float(shown[7]) == pytest.approx(1.0, abs=1e-2)


def test_errors_of_second_order_are_told(script, on_cells):
    files = [on_cells(size, first=0.0, second=0.002) for size in (4.0, 2.0, 1.0)]
    assert float(script("extrapolate.py", *files, "--column", "G_vcct_I").stdout.split()[-1]) == pytest.approx(2.0, abs=1e-2)


def test_what_cannot_be_extrapolated_is_refused(script, on_cells, dcb_file, tmp_path):
    fine = on_cells(1.0)
    same = tmp_path / "same.h5"
    same.write_bytes(fine.read_bytes())
    for files, word in (([fine], "two results"), ([fine, same], "same size"), ([fine, dcb_file], "finest_cell"),
                        ([fine, on_cells(2.0, end=1e-3)], "one scene")):
        result = script("extrapolate.py", *files)
        assert result.returncode == 2 and word in result.stderr


def test_an_output_that_cannot_be_written(script, on_cells, tmp_path):
    result = script("extrapolate.py", on_cells(2.0), on_cells(1.0), "-o", tmp_path / "none" / "zero.h5")
    assert result.returncode == 4 and "cannot be written" in result.stderr


def test_what_is_left_of_the_estimated_errors(script, on_cells, tmp_path):
    """2 G(1) - G(2): at most 2 * 0.01 + 0.03 of G."""
    files = [on_cells(2.0, error=0.03), on_cells(1.0, error=0.01)]
    lines = [line.split(" ") for line in script("extrapolate.py", *files, "-o", tmp_path / "zero.h5").stdout.splitlines()]
    assert " ".join(lines[0]).endswith("finest [%] their error [%]") and [line[0] for line in lines[1:]] == [
        "G_stress_closure_I", "G_vcct_I"]
    assert float(lines[2][-1]) == pytest.approx(5.0, abs=1e-3) and lines[1][-1] == "-"
    result = History(tmp_path / "zero.h5")
    np.testing.assert_allclose(result.columns["G_vcct_I_error"], 0.05 * exact(), rtol=1e-12)
    assert result.units["G_vcct_I_error"] == "J/m2"
    assert "error" not in script("extrapolate.py", on_cells(2.0), files[1]).stdout


def test_runs_that_are_not_at_rest_are_named(script, on_cells, tmp_path):
    files = [on_cells(2.0, distance=0.2), on_cells(1.0, distance=1e-3)]
    result = script("extrapolate.py", *files, "-o", tmp_path / "zero.h5")
    line, = result.stderr.splitlines()
    assert result.returncode == 0 and all(word in line for word in (str(files[0]), "0.2", "0.01", "warning"))
    assert script("extrapolate.py", *files, "--strict").returncode == 1
    assert History(tmp_path / "zero.h5").distance_to_equilibrium() == 0.2
