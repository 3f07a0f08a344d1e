"""The history as text, and the gnuplot script that reads it through a pipe."""

import os
import shutil
import subprocess
import sys

import matplotlib.image
import numpy as np
import pytest

from paths import SCRIPTS
from synthetic import BEAM, G_REF, dcb, write_result


def test_text_has_a_header_and_every_digit(script, dcb_file):
    result = script("export.py", dcb_file, "--columns", "G_vcct_I", "step")
    lines = result.stdout.splitlines()
    assert lines[0] == "# time [s] G_vcct_I [J/m2] step [1]"
    values = np.loadtxt(lines)
    for column, name in zip(values.T, ["time", "G_vcct_I", "step"]):
        np.testing.assert_array_equal(column, dcb()[name])


def test_output_goes_to_a_file_with_all_columns(script, dcb_file, tmp_path):
    text = tmp_path / "history.txt"
    assert script("export.py", dcb_file, "--output", text).stdout == ""
    assert np.loadtxt(text).shape == (1201, len(dcb()))


def test_normalised_divides_g_alone(script, dcb_file):
    result = script("export.py", dcb_file, "--columns", "G_vcct_I", "crack_opening", "--normalised")
    assert result.stdout.startswith("# time [s] G_vcct_I [1] crack_opening [m]\n")
    last = [float(word) for word in result.stdout.splitlines()[-1].split()]
    assert last[1] == dcb()["G_vcct_I"][-1] / G_REF and last[2] == dcb()["crack_opening"][-1]


def test_names_and_attributes(script, dcb_file):
    assert script("export.py", dcb_file, "--columns", "G_*", "--list").stdout.split() == \
        ["G_stress_closure_I", "G_vcct_I"]
    beam = script("export.py", dcb_file, "--attribute", "G_beam_on_foundation", "--normalised").stdout
    assert float(beam) == BEAM / G_REF


def test_a_reader_that_stops_early_is_no_failure(dcb_file):
    command = f"'{sys.executable}' '{SCRIPTS}/export.py' '{dcb_file}' | head -1"
    result = subprocess.run(["sh", "-c", command], capture_output=True, text=True)
    assert result.stdout.startswith("# time [s]") and result.stderr == ""


def gnuplot(*arguments, **environment):
    return subprocess.run(["gnuplot", "-c", SCRIPTS / "g_of_t.gp", *arguments], capture_output=True, text=True,
                          env={**os.environ, "HAMPM_PYTHON": sys.executable, **environment})


needs_gnuplot = pytest.mark.skipif(not shutil.which("gnuplot"), reason="gnuplot is not installed")


@needs_gnuplot
def test_gnuplot_draws_a_png(tmp_path):
    folder = tmp_path / "with blanks"
    folder.mkdir()
    files = [write_result(folder / f"{name}.h5") for name in ("fine", "coarse")]
    picture = tmp_path / "g.png"
    result = gnuplot(picture, *files, HAMPM_CONVERGED="1.28737")
    assert (result.returncode, result.stderr) == (0, "")
    pixels = matplotlib.image.imread(picture)
    assert pixels.shape[:2] == (840, 1260) and len(np.unique(pixels.reshape(-1, pixels.shape[2]), axis=0)) > 50


@needs_gnuplot
def test_gnuplot_draws_an_svg_with_labels(tmp_path, dcb_file):
    picture = tmp_path / "g.svg"
    assert gnuplot(picture, dcb_file, HAMPM_ESTIMATOR="G_vcct*").returncode == 0
    text = picture.read_text()
    assert "dcb: VCCT I" in text and "beam on elastic foundation: 1.284" in text
    assert "stress closure" not in text and "converged" not in text


@needs_gnuplot
@pytest.mark.parametrize("picture, file, code, words", [
    ("g.png", "none.h5", 4, "no such file"), ("g.doc", "none.h5", 2, "does not end in .png or .svg"),
    ("g.png", "no_g_ref.h5", 2, "no attribute G_ref")])
def test_gnuplot_names_mistakes(tmp_path, picture, file, code, words):
    write_result(tmp_path / "no_g_ref.h5", g_ref=None)
    result = gnuplot(tmp_path / picture, tmp_path / file)
    assert result.returncode == code and words in result.stderr
