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


GROWS = """&run plane = 'stress'  end_time = 4.0 /
&grid lower = 0.0, -12e-3  cell = 1e-3  cells = 61, 24 /
&material name = 'a'  young = 70e9  poisson = 0.3  density = 2700 /
&body material = 'a'  lower = 0.0, -10e-3  upper = 60e-3, 10e-3 /
&load kind = 'traction'  lower = 0.0, 0.0  upper = 0.0, 10e-3  force = 0.0, 1e5 /
&load kind = 'traction'  lower = 0.0, -10e-3  upper = 0.0, 0.0  force = 0.0, -1e5 /
&constraint lower = 60e-3, -10e-3  upper = 60e-3, 10e-3  fix = 'xy' /
&crack kind = 'path'  points = 0.0, 0.0, 20e-3, 0.0 /
&method time = 'static'  load_steps = 4 /
&energy_release estimators = 'domain_integral' /
"""
LAWS = {"rate": "&growth law = 'fatigue'  direction = 'straight'  rate_constant = 1e-30  rate_exponent = 3.0  increment = 2e-3 /\n&cycles ratio = 0.1 /\n",
        "resistance": "&growth law = 'quasi_static'  direction = 'straight'  toughness = 100.0  increment = 2e-3 /\n"}


@pytest.fixture(scope="module")
def grown(tmp_path_factory):
    """Histories of a beam whose crack grows, by the law that a picture shows."""
    folder = tmp_path_factory.mktemp("grown")
    return {kind: package.run(package.Scene(text=GROWS + law), output=folder / kind, progress=False) for kind, law in LAWS.items()}


def test_growth_per_cycle_is_a_line_in_logarithmic_axes(grown):
    """By the law of Paris: its slope is the exponent."""
    axes = package.plot("rate", grown["rate"]).axes[0]
    x, y = (np.log(values) for values in axes.lines[0].get_data())
    assert axes.get_xscale() == axes.get_yscale() == "log" and np.ptp(x) > 0.1
    np.testing.assert_allclose(np.diff(y) / np.diff(x), 3, rtol=1e-6)
    assert (axes.get_ylabel(), axes.get_xlabel()) == ("growth per load cycle $da/dN$ [m]", "$\\Delta K$ [MPa√m]")


def test_resistance_is_over_the_extension(grown):
    axes = package.plot("resistance", grown["resistance"]).axes[0]
    energy, toughness = (line for line in axes.lines if not line.get_label().startswith("_"))
    np.testing.assert_allclose(energy.get_xdata(), [0, 2, 4, 6, 8], atol=1e-9)
    np.testing.assert_allclose(toughness.get_ydata(), 100)
    np.testing.assert_allclose(energy.get_ydata(), 100, rtol=1e-6)


def test_the_load_at_the_toughness_is_that_of_growth(grown, monkeypatch, capsys):
    """Of a run with other loads it is the same curve: here of half the loads, by columns; where bodies may touch it is left out."""
    from hampm.postprocess import plot_load
    run, at_toughness = package.plot("load", grown["resistance"]).axes[0].lines
    np.testing.assert_allclose(at_toughness.get_xydata(), run.get_xydata(), rtol=1e-6)
    history = grown["resistance"]
    halved = {"G": 0.25, "load_factor": 0.5, "mouth_opening": 0.5}
    for name, factor in halved.items():
        monkeypatch.setitem(history.columns, name, history.columns[name] * factor)
    np.testing.assert_allclose(plot_load.factor_to_toughness(history), 2, rtol=1e-6)
    assert capsys.readouterr().err == ""
    text = plot_load.StoredModel.text
    monkeypatch.setattr(plot_load.StoredModel, "text", lambda self, group, key, n=1: "frictional" if key == "bodies" else text(self, group, key, n))
    assert plot_load.factor_to_toughness(history) is None and "bodies may touch" in capsys.readouterr().err
