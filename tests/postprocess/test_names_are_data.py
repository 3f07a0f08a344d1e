"""What a result holds, and what it is called, is data: no shell runs it, no terminal obeys it, no picture takes it for a formula."""

import os
import shutil
import subprocess
import sys

import h5py
import numpy as np
import pytest

import plot_g
from history import USAGE, History, ResultError
from paths import SCRIPTS
from pictures import verbatim
from synthetic import dcb, write_result

NAMES = ["G_x; touch evil", "G_$(touch evil)", "G_`touch evil`", "G_a b", "G_\x1b[31mred", "G_$\\frac$", "G_'", 'G_"', "G_é", "G_\u202eI", "G_\n"]
ESCAPES = "\x1b]0;evil\x07\x1b[2J\u202e"


@pytest.mark.parametrize("name", NAMES)
def test_columns_are_called_by_letters_digits_and_underscores(script, tmp_path, name):
    path = write_result(tmp_path / "a.h5", dcb() | {name: np.ones(1201)})
    with pytest.raises(ResultError, match="names are of letters, digits and _"):
        History(path)
    for words in ("export.py", path), ("tabulate.py", path), ("plot_g.py", path, "-o", tmp_path / "a.png"), ("report.py", path):
        result = script(*words)
        assert result.returncode == USAGE and "names are of letters, digits and _" in result.stderr and "\x1b" not in result.stderr


@pytest.mark.skipif(not shutil.which("gnuplot"), reason="gnuplot is not installed")
@pytest.mark.parametrize("name", ["a'; touch evil; '.h5", "a$(touch evil).h5", "a`touch evil`.h5", 'a"; touch evil; ".h5', "-a.h5"])
@pytest.mark.parametrize("column", ["G_x", "G_x; touch evil"])
def test_gnuplot_runs_nothing(tmp_path, name, column):
    """Neither in the name of a column nor in that of a file."""
    write_result(tmp_path / name, dcb() | {column: np.ones(1201)})
    file = name if not name.startswith("-") else f"./{name}"
    run = subprocess.run(["gnuplot", "-c", SCRIPTS / "g_of_t.gp", "g.svg", file], capture_output=True, text=True, cwd=tmp_path,
                         env={**os.environ, "HAMPM_PYTHON": sys.executable})
    assert not (tmp_path / "evil").exists()
    assert (run.returncode == 0) == (column == "G_x") and (tmp_path / "g.svg").exists() == (column == "G_x"), run.stderr


def test_texts_are_printed_without_what_terminals_obey(script, tmp_path):
    path = write_result(tmp_path / f"a{ESCAPES}.h5")
    with h5py.File(path, "a") as file:
        for key in ("units", "long_name"):
            file["history/G_vcct_I"].attrs[key] = f"J/m2{ESCAPES}\nevil"
        file["history"].attrs["title"] = file["history"].attrs["warnings"] = f"evil {ESCAPES}"
    for words in [("tabulate.py", path), ("tabulate.py", path, "--csv"), ("export.py", path), ("export.py", path, "--attribute", "title"),
                  ("export.py", path, "--columns", "none")]:
        result = script(*words)
        assert not any(letter in result.stdout + result.stderr for letter in "\x1b\x07\u202e"), words
    assert len(script("export.py", path, "--columns", "G_vcct_I").stdout.splitlines()) == 1202


@pytest.mark.parametrize("text", [r"$\frac$", "a$b$", "$", r"\$x$", "_hidden", r"$\undefined$"])
def test_texts_are_no_formulas(tmp_path, text):
    """A formula that matplotlib cannot read ends it; one that it can would not show what is there. A legend has no label that begins with _."""
    assert verbatim(text).replace(r"\$", "$").strip() == text
    paths = [write_result(tmp_path / name) for name in (f"{text}.h5".replace("\\", "+"), "other.h5")]
    for path in paths:
        with h5py.File(path, "a") as file:
            for item in file["history"].values():
                item.attrs["units"] = item.attrs["long_name"] = text
    options = plot_g.parse([*map(str, paths), "--column", "G_vcct_I", "--column", "G_stress_closure_I"])
    figure = plot_g.draw([History(path) for path in paths], options)
    figure.canvas.draw()
    shown = [words.get_text().replace("\n", " ").replace(r"\$", "$") for words in figure.axes[0].texts]
    assert len(shown) == 4 and sum(words.strip().startswith(f"{paths[0].stem}: ") for words in shown) == 2
    plot_g.plt.close("all")


def test_a_table_has_one_unit_a_column(script, tmp_path):
    """Files with and without G_ref beside each other: all in J/m2, said; a converged ratio asks all for their G_ref."""
    files = [write_result(tmp_path / f"{name}.h5", g_ref=g_ref) for name, g_ref in (("with", 2.0), ("without", None))]
    mixed = script("tabulate.py", *files, "--column", "G_vcct_I", "--csv")
    first, second = (line.split(",")[1] for line in mixed.stdout.splitlines()[1:])
    assert first == second and "without.h5 has no G_ref: energy release rates are in J/m2" in mixed.stderr
    ratio = script("tabulate.py", files[0], "--column", "G_vcct_I", "--csv").stdout.split(",")[-1]
    assert float(ratio) == pytest.approx(float(first) / 2, rel=1e-4)
    assert "[J/m2]" in script("tabulate.py", *files).stdout and "[1]" in script("tabulate.py", files[0]).stdout
    assert "[m]" in script("tabulate.py", files[0], "--column", "crack_opening").stdout
    assert script("tabulate.py", *files, "--converged", 1.2).returncode == USAGE


def test_no_script_writes_over_what_it_reads(script, tmp_path):
    path = write_result(tmp_path / "a.h5")
    (tmp_path / "link.txt").symlink_to(path)
    before = path.read_bytes()
    for output in (path, tmp_path / "link.txt", tmp_path / "." / "a.h5"):
        result = script("export.py", path, "--output", output)
        assert result.returncode == USAGE and "is read, and is not replaced" in result.stderr
    assert path.read_bytes() == before
