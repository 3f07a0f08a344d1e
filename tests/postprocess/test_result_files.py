"""Result files that are not as hampm writes them: every script says in one line what is wrong with which file and dataset."""

import sys

import h5py
import numpy as np
import pytest

from paths import ROOT
from synthetic import write_result

sys.path.insert(0, str(ROOT / "tests/fuzz"))

import result_files  # noqa: E402

QUICK = [name for name in result_files.SCRIPTS if name not in result_files.SLOW]
OF_HISTORY = ["tabulate.py", "compare.py", "extrapolate.py", "export.py", "plot_g.py", "plot_energy.py", "report.py"]


def put(file, name, **dataset):
    del file[name]
    file.create_dataset(name, **dataset)


WRONG = {
    "text": (lambda file: put(file, "history/step", data=["a", "b"]), "/history/step holds texts or references, not numbers"),
    "complex": (lambda file: put(file, "history/step", data=np.zeros(1201, complex)), "/history/step holds complex numbers, not numbers"),
    "truth": (lambda file: put(file, "history/step", data=np.zeros(1201, bool)), "/history/step holds truth values, not numbers"),
    "compound": (lambda file: put(file, "history/step", data=np.zeros(1201, result_files.COMPOUND)), "/history/step holds compounds, not numbers"),
    "short": (lambda file: put(file, "history/step", data=np.zeros(3)), "/history/step has 3 samples, and /history/time has 1201"),
    "two": (lambda file: put(file, "history/step", data=np.zeros((1201, 2))), "/history/step has the shape (1201, 2)"),
    "null": (lambda file: put(file, "history/step", dtype="f8", data=h5py.Empty("f8")), "/history/step has the shape None"),
    "back": (lambda file: put(file, "history/time", data=np.linspace(1, 0, 1201)), "/history/time goes back in time"),
    "nan": (lambda file: put(file, "history/time", data=np.full(1201, np.nan)), "/history/time holds values that are not finite"),
    "huge": (lambda file: put(file, "history/crack_opening", data=np.full(1201, 1e300)), "/history/crack_opening holds 1e+300, and values are between"),
    "attribute": (lambda file: file["history"].attrs.update(G_ref="<b>"), "/history has an attribute G_ref that is no number"),
    "unit": (lambda file: file["history/step"].attrs.update(units=1.0), "/history/step has an attribute units that is no text"),
}


@pytest.mark.parametrize("name", OF_HISTORY)
@pytest.mark.parametrize("kind", WRONG)
def test_a_history_that_is_none(script, tmp_path, name, kind):
    spoil, words = WRONG[kind]
    path, good = write_result(tmp_path / "a.h5"), write_result(tmp_path / "b.h5")
    with h5py.File(path, "r+") as file:
        spoil(file)
    result = script(name, path, *[good] * (name in ("compare.py", "extrapolate.py")))
    assert result.returncode == 2 and result.stdout == ""
    assert result.stderr.count("\n") == 1 and f"{path}: {words}" in result.stderr


@pytest.mark.parametrize("name", OF_HISTORY)
def test_a_history_without_samples(script, tmp_path, name):
    path, good = write_result(tmp_path / "a.h5", {"time": np.zeros(0), "G_I": np.zeros(0)}), write_result(tmp_path / "b.h5")
    result = script(name, path, *[good] * (name in ("compare.py", "extrapolate.py")))
    assert result.returncode in ((0, 1) if name in ("compare.py", "export.py") else (2,))
    assert result.returncode < 2 or result.stderr.count("\n") == 1 and "holds no samples yet" in result.stderr


SOME_AND_MANY = [(1, 5), pytest.param(2, 40, marks=pytest.mark.verify)]


@pytest.mark.parametrize(("seed", "files"), SOME_AND_MANY)
def test_files_that_are_changed_at_random(vertical_crack, slanted_crack, grown_crack, seed, files):
    """By the scripts that draw nothing."""
    ends, findings = result_files.try_files([vertical_crack, slanted_crack, grown_crack], 6 * files, seed, QUICK)
    assert not findings
    assert ends[0] > 4 * files and ends[2] > 4 * files


@pytest.mark.parametrize(("seed", "files"), SOME_AND_MANY)
def test_pictures_of_files_that_are_changed_at_random(vertical_crack, slanted_crack, seed, files):
    drawn = [name for name in result_files.SLOW if name != "plot_path"]
    ends, findings = result_files.try_files([vertical_crack, slanted_crack], files, seed, drawn)
    assert not findings
    assert ends[0] > 1 and ends[2] > 1


@pytest.mark.parametrize(("seed", "files"), SOME_AND_MANY)
def test_pictures_of_paths_in_files_that_are_changed_at_random(grown_crack, seed, files):
    ends, findings = result_files.try_files([grown_crack], files, seed, ["plot_path"])
    assert not findings
    assert ends[0] > 0 and ends[2] > 0
