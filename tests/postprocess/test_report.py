"""The report of runs: one file that needs no other, with the numbers of the result and what to know before trusting them."""

import base64
import re
from html import unescape

import h5py
import numpy as np
import pytest

from synthetic import G_REF, complete, write_result

def set_scene(path, text):
    with h5py.File(path, "a") as file:
        del file["input/namelist"]
        file["input/namelist"] = text
        file["input"].attrs["version"] = "1.2.3"
    return path


@pytest.fixture
def report(script, tmp_path):
    """Text of the report of some files, and its pictures."""
    def call(*arguments, warning=""):
        output = tmp_path / "report.html"
        result = script("report.py", *arguments, "-o", output, "--dpi", 30)
        assert (result.returncode, result.stdout.strip()) == (0, str(output))
        assert warning in result.stderr if warning else result.stderr == ""
        text = output.read_text()
        pictures = [base64.b64decode(code) for code in re.findall(r'src="data:image/png;base64,([^"]*)"', text)]
        assert len(pictures) == text.count("<img") and all(picture.startswith(b"\x89PNG") for picture in pictures)
        assert not re.search(r"https?:|<link|<script|src=\"[^d]", text)
        return unescape(re.sub(r"<[^>]*>", " ", text.split("</style>")[1])), pictures
    return call


def test_a_run_with_snapshots_has_all_pictures_and_its_scene(report, refined_result):
    text, pictures = report(refined_result, warning="not at rest")
    assert len(pictures) == 5 and "force = 0.0, 1.0" in text and "GCC" in text
    with h5py.File(refined_result) as file:
        g, g_ref = file["history/G_vcct_I"][:], file["history"].attrs["G_ref"]
        late = file["history/time"][:] >= 0.9 * file["history/time"][-1]
    assert re.search(rf"virtual crack closure, mode I \[J/m2\]\s+{g[-1]:.5g} ± \S+\s.*?\s{np.mean(g[late]) / g_ref:.5g} ± ", text)
    assert "not accounted for" in text and "before its end_time" not in text


def test_a_run_without_snapshots_says_so(report, tmp_path):
    text, pictures = report(write_result(tmp_path / "a.h5", complete()))
    assert len(pictures) == 2 and "holds no snapshots" in text


def test_what_a_reader_should_know_is_noticed(report, tmp_path):
    columns = complete(numerical_loss=np.linspace(0, 0.25, 101), external_work=np.linspace(0, 0.25, 101), J=1.0, J_domain_dependence=0.08)
    columns["crack_opening"][3] = np.nan
    path = set_scene(write_result(tmp_path / "a.h5", columns), "&run\n   title = 'a < b'\n   end_time = 2.4e-3\n/\n")
    with h5py.File(path, "a") as file:
        file["history"].attrs["ended"] = "step 7: the run is unstable"
        file["history"].attrs["warnings"] = "a displacement gradient is large\nthe energy has grown"
    text, _ = report(path)
    for words in ["failed: step 7: the run is unstable", "gradient is large", "energy has grown", "a: a < b", "before its end_time of 0.0024 s", "Not finite somewhere: crack_opening", "lost 20% of the largest",
                  "J differs by 8%", "1.2.3"]:
        assert words in text


def test_runs_are_compared_by_their_means(report, tmp_path):
    files = [write_result(tmp_path / "a.h5", complete() | {"G_vcct_I": np.full(101, 1.25 * G_REF)}),
             write_result(tmp_path / "b.h5", {name: values for name, values in complete().items() if name != "G_vcct_I"})]
    text, pictures = report(*files, "--title", "Two beams")
    assert len(pictures) == 5 and text.strip().startswith("Two beams")
    assert re.search(r"\sa\s+\S+\s+1.25\s", text) and re.search(r"\sb\s+\S+\s+–\s", text)


def test_peaks_have_values_and_times_and_estimated_errors(report, tmp_path):
    g = np.linspace(0, 1, 101)
    g[30] = -4.0
    errors = {"G_vcct_I_error": np.full(101, 0.25), "K_I_tip2": np.full(101, 3.0)}
    path = write_result(tmp_path / "a.h5", complete() | errors | {"G_vcct_I": g}, g_ref=None, beam=None)
    text, pictures = report(path)
    assert re.search(r"G vcct I \[J/m2\]\s+1 ± 0.25\s+0.95\d* ± 0.25\s+–\s+-4 ± 0.25\s+0.00036\s", text)
    assert "error" not in text and re.search(r"K I tip2, tip 2 \[J/m2\]\s+3\s+3\s", text) and len(pictures) == 2


@pytest.mark.parametrize("rate, arguments, code, told", [
    ("1e4", [], 0, True), ("1e4", ["--strict"], 1, True), ("0.0", [], 0, False), ("0.0", ["--strict"], 1, True)])
def test_a_run_that_is_to_come_to_rest_and_does_not_is_named(script, tmp_path, rate, arguments, code, told):
    path = set_scene(write_result(tmp_path / "a.h5", complete(), distance=0.07), f"&damping\n   rate = {rate}\n/\n")
    result = script("report.py", path, "--dpi", 20, *arguments)
    assert result.returncode == code and (f"{path}: not at rest" in result.stderr) == told
    text = unescape((tmp_path / "a_report.html").read_text())
    assert ("Not at rest: the last displacements differ" in text) == (rate != "0.0") and "distance to equilibrium, relative" in text
