"""What all scripts share: help, a line in the page of scripts, pictures beside the first file that need no display, and one line about each mistake."""

import re
import shutil

import h5py
import matplotlib.image
import numpy as np
import pytest

from paths import PACKAGE, ROOT, SCRIPTS
from synthetic import complete, dcb, write_result

PROGRAMS = sorted(path.name for path in SCRIPTS.glob("*.py") if path.read_text().startswith("#!"))
STARTS = {".png": b"\x89PNG", ".pdf": b"%PDF", ".svg": b"<?xml", ".gif": b"GIF8", ".html": b"<!DOCTYPE html>"}


@pytest.mark.parametrize("name", PROGRAMS)
def test_each_has_help_and_a_line_in_the_page_of_scripts(script, name):
    result = script(name, "--help")
    assert result.returncode == 0 and result.stdout.startswith("usage: ")
    assert f"`postprocess/{name} " in (ROOT / "docs/reference/scripts.md").read_text()


def test_only_one_module_sets_matplotlib_up():
    """So that all pictures look alike and are drawn without a display."""
    modules = [path for folder in (PACKAGE / "hampm/postprocess", ROOT / "bench") for path in folder.glob("*.py")]
    direct = [path.name for path in modules if re.search(r"^import matplotlib|import pyplot", path.read_text(), re.MULTILINE)]
    assert direct == ["pictures.py"]


def spoilt(path, change):
    """A result file that is changed."""
    with h5py.File(path, "a") as file:
        change(file)
    return path


@pytest.fixture
def given(request, tmp_path):
    """`given(kind)`: a file of a kind, alone in a folder of its own."""
    def result_of(fixture):
        return shutil.copy(request.getfixturevalue(fixture), tmp_path / "a.h5")

    def text(words, name="a.h5"):
        (tmp_path / name).write_text(words)
        return tmp_path / name
    makers = {
        "missing": lambda path: path,
        "text": lambda path: text("not HDF5"),
        "table": lambda path: text("name,family,cpu_seconds,particles,error_percent\na,x,1,100,-8\nb,x,4,400,3\n", "a.csv"),
        "no_history": lambda path: spoilt(path, lambda file: None),
        "empty": lambda path: write_result(path, {name: values[:0] for name, values in dcb().items()}),
        "history": lambda path: write_result(path, dcb()),
        "energies": lambda path: write_result(path, complete()),
        "snapshots": lambda path: result_of("refined_result"),
        "paths": lambda path: result_of("slanted_crack"),
        "grown": lambda path: result_of("grown_crack"),
        "no_points": lambda path: spoilt(result_of("refined_result"), lambda file: [file["VTKHDF"][block].pop("Points") for block in ("mesh", "particles")])}
    return lambda kind: makers[kind](tmp_path / "a.h5")


@pytest.mark.parametrize("name, kind, arguments, picture", [
    ("plot_g.py", "history", ["--dpi", 50], "a_G.png"), ("plot_energy.py", "energies", [], "a_energy.png"),
    ("plot_mesh.py", "snapshots", [], "a_mesh.png"), ("plot_field.py", "snapshots", ["--field", "stress_yy"], "a_stress_yy.png"),
    ("plot_path.py", "grown", [], "a_path.png"), ("plot_work_precision.py", "table", [], "a_work_precision.png"),
    ("report.py", "energies", [], "a_report.html"),
    *[("plot_g.py", "history", ["--output", f"g.{suffix}"], f"g.{suffix}") for suffix in ("pdf", "svg")],
    ("plot_mesh.py", "snapshots", ["--window", 20, "--time", 1e-4, "-o", "m.pdf"], "m.pdf"),
    ("plot_profile.py", "snapshots", ["--field", "stress_yy", "--at", 0, "-o", "p.png"], "p.png")])
def test_pictures_stand_beside_the_first_file_or_where_asked(script, given, tmp_path, monkeypatch, name, kind, arguments, picture):
    file = given(kind)
    monkeypatch.chdir(tmp_path)
    result = script(name, file, *arguments, *["--dpi", 40] * ("--dpi" not in arguments))
    assert result.returncode == 0 and result.stdout.split()[-1].endswith(picture), result.stderr
    assert (tmp_path / picture).read_bytes().startswith(STARTS[(tmp_path / picture).suffix])
    if picture.endswith("png"):
        pixels = matplotlib.image.imread(tmp_path / picture)
        assert pixels.shape[1] < 600 and len(np.unique(pixels.reshape(-1, pixels.shape[2]), axis=0)) > 50


OF_HISTORY = ["plot_g.py", "plot_energy.py", "export.py", "tabulate.py", "report.py"]
OF_SNAPSHOTS = ["plot_mesh.py", "plot_field.py", "animate.py"]
MISTAKES = [
    *[(name, "missing", [], 4, "no such file") for name in [*OF_HISTORY, *OF_SNAPSHOTS]],
    *[(name, "text", [], 4, "cannot be read as HDF5") for name in ("plot_g.py", *OF_SNAPSHOTS)],
    *[(name, "no_history", [], 4, "no group /history") for name in ("plot_g.py", "plot_energy.py")],
    *[(name, "no_history", [], 4, "not a result file") for name in OF_SNAPSHOTS],
    *[(name, "empty", [], 2, "no samples") for name in ("plot_g.py", "plot_energy.py")],
    *[(name, "history", [], 2, "snapshot_interval") for name in OF_SNAPSHOTS],
    *[(name, "no_points", [], 2, "is missing") for name in ("plot_mesh.py", "animate.py")],
    *[(name, kind, ["--output", "/nowhere/at/all" + suffix], 4, "cannot be written") for name, kind, suffix in [
        ("plot_g.py", "history", ".png"), ("plot_mesh.py", "snapshots", ".png"), ("plot_field.py", "snapshots", ".png"), ("animate.py", "snapshots", ".gif"),
        ("plot_path.py", "grown", ".png"), ("report.py", "energies", ".html"), ("export.py", "history", ".txt")]],
    *[(name, kind, ["-o", "a.doc"], 2, f"end in {suffix}") for name, kind, suffix in [
        ("plot_g.py", "history", ".png"), ("plot_mesh.py", "snapshots", ".png"), ("animate.py", "snapshots", ".gif"), ("report.py", "energies", ".html")]],
    *[(name, kind, ["--dpi", "0"], 2, "not a positive number") for name, kind in [
        ("plot_g.py", "history"), ("report.py", "energies"), ("plot_work_precision.py", "table")]],
    *[("plot_g.py", "history", *line) for line in [
        (["--estimator", "nodal"], 2, "it has G_stress_closure_I, G_vcct_I"), (["--lowpass", "-1"], 2, "not a positive number"), (["--column", "K_I"], 2, "no column 'K_I'"),
        (["--scale", "2"], 2, "need --column"), (["--column", "G_*", "--converged", "1.3"], 2, "--column draws other columns"),
        (["--reference", "/nowhere.csv"], 4, "/nowhere.csv"), (["--reference", __file__], 4, "not rows of time")]],
    *[(name, "snapshots", *line) for name, line in [
        ("plot_mesh.py", (["--snapshot", "4"], 2, "there are 4, counted from 0")), ("plot_mesh.py", (["--window", "0"], 2, "not a positive number")),
        ("plot_mesh.py", (["--snapshot", "1", "--time", "0"], 2, "not allowed with")), ("animate.py", (["--field", "colour"], 2, "they have id, body")),
        ("plot_field.py", (["--field", "stress_xx", "--log"], 2, "has values below zero")), ("plot_field.py", (["--field", "colour"], 2, "they have id, body")),
        ("plot_profile.py", (["--field", "heat"], 2, "have no field 'heat'; they have id, body")),
        ("plot_profile.py", (["--field", "heat", "--nodes"], 2, "the nodes have no field 'heat'; they have R, mass, velocity_x, velocity_y")),
        ("plot_profile.py", (["--field", "speed", "--at", "1"], 2, "nothing to show on this line")),
        ("plot_profile.py", (["--field", "speed", "--reference", "/nowhere.csv", "-o", "a.png"], 4, "/nowhere.csv"))]],
    ("plot_energy.py", "history", [], 2, "no column 'strain_energy'"), ("plot_field.py", "paths", ["--tip", "4"], 2, "has no crack tip 4"),
    ("plot_path.py", "paths", [], 2, "no crack grows in this run"), ("plot_g.py", "paths", ["--growth"], 2, "no crack grows in this run"),
    *[("plot_path.py", "grown", *line) for line in [
        (["--measured", "none.csv"], 4, "cannot be read"), (["--columns", "1"], 2, "is not two numbers of columns"), (["--columns", "a,b"], 2, "invalid"),
        (["--snapshot", "9"], 2, "counted from 0")]],
    *[("compare.py", "history", ["a.h5", *line], 2, words) for line, words in [
        (["--columns", "none"], "no column 'none'"), (["--tolerance", "none=1"], "no column 'none'"), (["--tolerance", "step"], "not NAME=RTOL"),
        (["--rtol", "-1"], "not a number >= 0"), (["--ignore", "*"], "nothing is left"), (["--exact", "--interpolate"], "exclude each other"),
        (["--paths", "1e-6"], "holds no snapshots")]],
    ("compare.py", "history", ["none.h5"], 4, "none.h5: no such file"),
    *[("export.py", "history", *line) for line in [
        (["--columns", "none"], 2, "no column 'none'"), (["--attribute", "none"], 2, "it has G_beam_on_foundation, G_ref")]],
    ("tabulate.py", "history", ["--column", "missing"], 2, "missing"), ("tabulate.py", "history", ["--part", "0"], 2, "(0, 1]")]


@pytest.mark.parametrize("name, kind, arguments, code, words", MISTAKES)
def test_mistakes_are_named(script, given, tmp_path, monkeypatch, name, kind, arguments, code, words):
    file = given(kind)
    monkeypatch.chdir(tmp_path)
    result = script(name, file, *arguments)
    assert result.returncode == code and words in result.stderr
    assert result.stderr.startswith("usage: ") or result.stderr.startswith(f"{name}: ") and len(result.stderr.splitlines()) == 1
    assert not [path for path in tmp_path.iterdir() if path.suffix in STARTS]
