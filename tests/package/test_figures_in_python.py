"""Pictures as figures of matplotlib, and the commands that write them."""

import os
import subprocess
import sys

import matplotlib.image
import numpy as np
import pytest

import hampm as package
from hampm.commands import commands
from paths import INPUT, PACKAGE

KINDS = {"g": {"column": ["K_*", "J"], "errors": True}, "energy": {"stacked": True}, "field": {"field": "stress_yy", "time": 1.0},
         "mesh": {"window": 3}, "profile": {"field": "stress_yy", "at": 0.5e-3}}


@pytest.mark.parametrize("kind", KINDS)
def test_each_picture_is_a_figure(plate, tmp_path, kind):
    plate.energy_release.energy_balance = True
    history = package.run(plate, output=tmp_path, progress=False)
    figure = package.plot(kind, history, style="paper", size="84mm", **KINDS[kind])
    assert figure.get_figwidth() == pytest.approx(84 / 25.4) and figure.axes
    figure.savefig(tmp_path / "a.svg")
    assert (tmp_path / "a.svg").stat().st_size > 5000 and sorted(path.name for path in tmp_path.iterdir()) == ["a.svg", "plate.h5", "plate.nml"]


@pytest.mark.parametrize(("kind", "options", "said"), [
    ("g", {"colum": "K_I"}, "there is no option 'colum'; did you mean 'column'?"), ("g", {"scale": 0}, "argument --scale: 0 is not a positive number"),
    ("g", {"column": "K_I", "size": "84"}, "84 is no size, such as 84mm"), ("f", {}, "there is no plot 'f'; there are energy, field"),
    ("g", {"column": "K_III"}, "no column 'K_III'"), ("field", {"format": "doc"}, "'doc' is none of png, pdf, svg")])
def test_mistakes_are_exceptions(plate_result, capsys, kind, options, said):
    with pytest.raises(package.ResultError, match=said.replace("?", r"\?")):
        package.plot(kind, plate_result, **options)
    assert capsys.readouterr().err == ""


def test_a_dark_picture_is_light_on_dark(plate_result, tmp_path):
    """Words and axes are white, and colours of curves stay."""
    light, dark = (package.plot("g", plate_result, column="K_*", style=style) for style in (None, "dark"))
    dark.savefig(tmp_path / "dark.png")
    assert np.median(matplotlib.image.imread(tmp_path / "dark.png")[..., :3]) < 0.15
    assert [line.get_color() for line in light.axes[0].lines] == [line.get_color() for line in dark.axes[0].lines]
    assert min(dark.axes[0].xaxis.label.get_color()[:3]) > 0.9


def command(folder, *words):
    return subprocess.run([sys.executable, "-m", "hampm", *map(str, words)], cwd=folder, capture_output=True, text=True,
                          env=os.environ | {"PYTHONPATH": str(PACKAGE)})


def test_one_command_with_words_has_all(plate_result, tmp_path):
    """Several files at once, of the size that is asked for; mistakes in the words list what there is."""
    done = command(tmp_path, "plot", "g", plate_result, "--column", "K_*", "--format", "png,pdf,svg", "--size", "100x50mm", "--dpi", "254", "-o", "k.png")
    assert (done.returncode, done.stdout) == (0, "k.png\nk.pdf\nk.svg\n"), done.stderr
    assert matplotlib.image.imread(tmp_path / "k.png").shape[:2] == (500, 1000)
    assert command(tmp_path, "sketch", INPUT / "dcb.nml", "-o", "s.svg").returncode == 0
    listed = command(tmp_path)
    assert listed.returncode == 0 and [line.split("  ")[0] for line in listed.stdout.splitlines()] == [f"hampm {words}" for words in commands()]
    assert {"plot g", "plot field", "sketch", "animate", "compare", "report", "tabulate"} <= set(commands())
    wrong = command(tmp_path, "plot", "h", plate_result)
    assert wrong.returncode == 2 and "hampm plot g " in wrong.stderr and "hampm compare" not in wrong.stderr
    assert command(tmp_path, "plot", "g", "none.h5").stderr == "hampm plot g: none.h5: no such file\n"


def test_a_film_of_some_snapshots(plate_result, tmp_path):
    """And of how many where there are many."""
    from hampm.postprocess import animate
    from PIL import Image
    for every, frames in ((1, 2), (2, 1)):
        done = command(tmp_path, "animate", plate_result, "--every", every, "--dpi", "30", "-o", "a.gif")
        assert done.returncode == 0 and Image.open(tmp_path / "a.gif").n_frames == frames, done.stderr
    assert command(tmp_path, "animate", plate_result, "--every", "0").returncode == 2
    assert list(animate.counted(range(0, 7, 3))) == [0, 3, 6]
