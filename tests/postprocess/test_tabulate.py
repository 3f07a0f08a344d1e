"""The table of last values."""

import csv

import numpy as np

from synthetic import G_REF, dcb, write_result


def settled(value, samples=101):
    """Columns that end at a value of G after a tenth of the run."""
    g = np.full(samples, value * G_REF)
    g[:80] = 0
    return {"time": np.linspace(0, 1, samples), "G_vcct_I": g, "K_I": np.full(samples, 7.0)}


def test_values_are_means_over_the_end_of_the_run_over_g_ref(script, tmp_path):
    files = [write_result(tmp_path / f"{name}.h5", settled(value)) for name, value in [("a", 1.25), ("b", 1.30)]]
    result = script("tabulate.py", *files, "--converged", 1.25, "--csv")
    assert list(csv.reader(result.stdout.splitlines())) == [
        ["file", "G_vcct_I", "[%]"], ["a", "1.25", "+0.00"], ["b", "1.3", "+4.00"]]


def test_other_columns_are_given_as_they_are(script, tmp_path):
    result = script("tabulate.py", write_result(tmp_path / "a.h5", settled(1.0)), "--column", "K_*", "--csv")
    assert result.stdout.splitlines() == ["file,K_I", "a,7"]


def test_a_column_that_a_file_lacks_is_a_dash(script, tmp_path, dcb_file):
    result = script("tabulate.py", write_result(tmp_path / "a.h5", settled(1.0)), dcb_file, "--column", "K_I", "--csv")
    assert result.stdout.splitlines() == ["file,K_I", "a,7", "dcb,-"]


def test_the_part_to_average(script, tmp_path):
    file = write_result(tmp_path / "a.h5", dcb())
    whole, end = (script("tabulate.py", file, "--part", part, "--csv").stdout for part in (1, 0.01))
    assert whole != end


def test_estimated_errors_are_columns_beside_their_values(script, tmp_path):
    errors = {"G_vcct_I_error": np.full(101, 0.01 * G_REF), "K_I_error": np.full(101, 0.5)}
    files = [write_result(tmp_path / "a.h5", settled(1.25) | errors), write_result(tmp_path / "b.h5", settled(1.30))]
    result = script("tabulate.py", *files, "--column", "G_*", "--column", "K_*", "--converged", 1.25, "--csv", "--errors")
    assert list(csv.reader(result.stdout.splitlines())) == [
        ["file", "G_vcct_I", "[%]", "G_vcct_I_error", "K_I", "K_I_error"],
        ["a", "1.25", "+0.00", "0.01", "7", "0.5"], ["b", "1.3", "+4.00", "-", "7", "-"]]
    named = script("tabulate.py", files[0], "--column", "K_I_error", "--column", "K_I", "--csv")
    assert named.stdout.splitlines() == ["file,K_I,K_I_error", "a,7,0.5"]


def test_a_run_that_is_not_at_rest_is_named(script, tmp_path):
    files = [write_result(tmp_path / f"{name}.h5", settled(1.0), distance=distance)
             for name, distance in [("still", 0.009), ("moving", 0.034), ("unknown", None)]]
    result = script("tabulate.py", *files)
    line, = result.stderr.splitlines()
    assert result.returncode == 0 and all(word in line for word in (str(files[1]), "0.034", "0.01", "warning"))
    assert script("tabulate.py", *files, "--strict").returncode == 1
    assert script("tabulate.py", files[0], files[2], "--strict").returncode == 0
    result = script("tabulate.py", *files, "--strict", "--column", "time")  # which is no value at rest
    assert (result.returncode, result.stderr) == (0, "")
