"""A period of a mode in place of the snapshots (animate.py --mode)."""

import h5py
import numpy as np
import pytest

import animate
import hampm as package
from frames import OfMode, frames_of
from history import ResultError

BAR = """&run end_time = 1e-5 thickness = 0.01 /
&grid lower = 0, 0{z} cell = 2e-3 cells = 12, 2{n} /
&material name = 'a' young = 70e9 poisson = 0.3 density = 2700 /
&body material = 'a' lower = 0, 0{z} upper = 24e-3, 4e-3{top} /
&constraint lower = 0, 0{z} upper = 0, 4e-3{top} fix = 'xy{d}' /
&load kind = 'traction' lower = 24e-3, 0{z} upper = 24e-3, 4e-3{top} force = 1.0, 10.0{z} /
&method time = 'modal' modes = 5 /
&output file = 'bar.h5' history_interval = 1e-6 snapshot_interval = 5e-6 /
"""


@pytest.fixture(params=[2, 3], ids=["plane", "solid"])
def bar(request, hampm, tmp_path):
    """A result with five modes."""
    solid = request.param == 3
    run = request.getfixturevalue("hampm3d") if solid else hampm
    text = BAR.format(z=", 0", n=", 2", top=", 4e-3", d="z").replace(" thickness = 0.01", "") if solid else BAR.format(z="", n="", top="", d="")
    (tmp_path / "bar.nml").write_text(text)
    result = run("bar.nml")
    assert result.returncode == 0, result.stderr
    return tmp_path / "bar.h5"


def test_particles_swing_by_the_shape_of_a_mode(bar):
    """From where they are at first, a period in equal times; a quarter of it shows the shape."""
    result = frames_of(bar, mode=2)
    with h5py.File(bar) as file:
        frequency, number, place, shape = (file[f"modes/{name}"][:] for name in ("frequency", "id", "position", "shape"))
    assert result.times.size == OfMode.FRAMES and result.times[1] * OfMode.FRAMES == pytest.approx(1 / frequency[1])
    rest, most = (result.block("particles", k) for k in (0, OfMode.FRAMES // 4))
    at = [list(number).index(k) for k in rest.point_fields["id"]]
    dims = place.shape[1]
    assert rest.points == pytest.approx(place[at], abs=1e-15)
    assert most.points - rest.points == pytest.approx(OfMode.PART * 24e-3 * shape.reshape(5, -1, dims)[1][at], abs=1e-12)
    assert most.point_fields["displacement"][:, :dims] == pytest.approx(most.points - rest.points, abs=1e-15)
    assert np.max(np.abs(most.points - rest.points)) == pytest.approx(OfMode.PART * 24e-3)


def test_a_film_of_a_mode_names_it(bar):
    options = animate.parse([str(bar), "--mode", "1"])
    film = animate.Film(frames_of(bar, 1), options)
    film.show(3)
    assert film.title.get_text().startswith("mode 1, ") and film.title.get_text().endswith(" Hz")
    animate.plt.close(film.figure)


@pytest.mark.parametrize("bar", [2], indirect=True)
def test_a_film_of_a_mode_is_written(bar, tmp_path):
    animate.main([str(bar), "--mode", "1", "--dpi", "20", "-o", str(tmp_path / "mode.gif")])
    assert (tmp_path / "mode.gif").read_bytes()[:4] == b"GIF8"


def test_a_picture_of_modes_has_a_panel_for_each(bar):
    """At its largest displacement, which is the same in all; a body that bends stays whole."""
    figure = package.plot("modes", bar, modes=[1, 3])
    *panels, _ = figure.axes
    assert [axes.get_title().split(",")[0] for axes in panels] == ["mode 1", "mode 3"] and all(axes.get_title().endswith(" Hz") for axes in panels)
    if frames_of(bar).dimensions == 2:
        for axes in panels:
            drawn = axes.collections[-1]
            assert np.max(drawn.get_array()) == pytest.approx(drawn.norm.vmax, rel=0.1)
            outline, = (path.vertices for path in axes.collections[3].get_paths())
            corners = np.array([outline[np.argmin(outline @ way)] for way in ((1, 1), (1, -1))])
            assert corners == pytest.approx(np.array([[0, 0], [0, 4]]), abs=0.05)      # where it is held


def test_a_mode_that_is_not_there_is_refused(bar, dcb_result):
    with pytest.raises(ResultError, match="has no mode 6; it has 5"):
        frames_of(bar, 6)
    with pytest.raises(ResultError, match="has no modes; a run with &method time = 'modal' has|has no snapshots"):
        frames_of(dcb_result, 1)
