"""Pictures of cracks that grow: their paths, what drives them over time, windows that follow the tip; mistakes named."""

import h5py
import numpy as np
import pytest

import animate
import plot_energy
import plot_g
import plot_path
from frames import Frames
from growing_tips import growing_tips, mean_speed
from history import History
from points import read_points


def figure_of(files, *arguments):
    options = plot_path.parse([*map(str, files), *arguments])
    measured = [(path, read_points(path, options.columns)) for path in options.measured]
    return plot_path.draw(Frames(files[0]), [History(path) for path in files], measured, options)


def places(path):
    """Where the tip is in each row [mm]."""
    with h5py.File(path) as file:
        return np.column_stack([file["history/tip_x"], file["history/tip_y"]]) * 1e3


def lines(figure, colour):
    """The lines of a colour, without markers."""
    return [line.get_xydata() for line in figure.axes[0].lines if line.get_color() == colour and line.get_linestyle() != "None"]


def test_the_path_is_that_of_the_history_and_begins_at_the_tip_of_the_scene(grown_crack):
    path, = lines(figure_of([grown_crack]), plot_path.COLOURS[0])
    np.testing.assert_allclose(path, places(grown_crack))
    np.testing.assert_allclose(path[0], [-3, 2.4])
    np.testing.assert_allclose(np.linalg.norm(np.diff(path, axis=0), axis=1), 1.5, rtol=1e-6)


def test_an_earlier_snapshot_has_the_path_up_to_it(grown_crack):
    figure = figure_of([grown_crack], "--snapshot", "1")
    path, = lines(figure, plot_path.COLOURS[0])
    np.testing.assert_allclose(path, places(grown_crack)[:2])
    assert figure.axes[0].get_title() == "load step 1 of 3"


def test_g_stands_beside_the_path_with_the_time_of_the_snapshot(running_crack):
    figure = figure_of([running_crack], "--beside", "G", "--snapshot", "1", "--time-unit", "us")
    panel = figure.axes[1]
    t, g = panel.lines[0].get_data()
    np.testing.assert_allclose(t, History(running_crack).times * 1e6)
    np.testing.assert_allclose(g / g.max(), History(running_crack).columns["G"] / History(running_crack).columns["G"].max())
    np.testing.assert_allclose(panel.lines[1].get_xdata(), 4, rtol=1e-2)


def test_several_runs_and_a_measured_path(grown_crack, running_crack, tmp_path):
    curve = tmp_path / "experiment.csv"
    curve.write_text("# measured\nspecimen,x [mm],y [mm]\na,-3,2.4\na,-1,3\n")
    figure = figure_of([grown_crack, running_crack], "--measured", str(curve), "--columns", "2,3")
    assert [len(lines(figure, colour)) for colour in plot_path.COLOURS[:2]] == [1, 1]
    np.testing.assert_allclose(lines(figure, plot_path.COLOURS[1])[0], places(running_crack)[np.unique(places(running_crack)[:, 0],
                                                                                                 return_index=True)[1]])
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    assert labels == ["grown", "running", "experiment"]
    np.testing.assert_allclose(figure.axes[0].lines[-1].get_xydata(), [[-3, 2.4], [-1, 3]])


def test_the_tip_of_a_crack_on_a_plane_of_symmetry_has_moved(running_crack):
    """5 mm at 1000 m/s after the start."""
    tip, = growing_tips(History(running_crack))
    assert tip.way() == pytest.approx(5e-3, abs=1e-6) and tip.starts() == pytest.approx(3e-6, abs=2e-7)
    crack, = Frames(running_crack).cracks(2)
    assert np.max(crack.points[:, 0]) == pytest.approx(5e-3, abs=1e-6)


def test_the_window_of_an_animation_follows_the_tip(running_crack, grown_crack):
    for path, place in [(running_crack, lambda frame: [[0, 0], [1e-3, 0], [5e-3, 0]][frame]), (grown_crack, lambda frame: places(grown_crack)[frame] / 1e3)]:
        film = animate.Film(Frames(path), animate.parse([str(path), "--window", "4"]))
        for frame in (0, 1, 2):
            film.show(frame)
            x, y = np.array(place(frame)) * 1e3
            np.testing.assert_allclose(film.canvas.axes.get_xlim() + film.canvas.axes.get_ylim(), [x - 4, x + 4, y - 4, y + 4], atol=2e-3)
        animate.plt.close(film.figure)


def test_what_drives_growth_over_time(grown_crack, running_crack):
    for path, units, axis in [(grown_crack, 3, "load step"), (running_crack, 3, "time $t$ [µs]")]:
        figure = plot_g.draw([History(path)], plot_g.parse([str(path), "--growth"]))
        assert len(figure.axes) == units and figure.axes[-1].get_xlabel() == axis
        assert figure.axes[0].get_ylabel().startswith("$G$ and toughness") and figure.axes[-1].get_ylabel() == "length of the crack [mm]"
        plot_g.plt.close(figure)


@pytest.mark.parametrize("speed", [100.0, 2000.0])
def test_the_mean_speed_over_a_cell(speed):
    """Of a tip that moves in jumps of a quarter of a cell that of its whole way, from half a cell on; zero before and after."""
    times = np.linspace(0, 1, 1001) * 10e-3 / speed
    way = np.clip(np.floor(speed * times / 0.25e-3) * 0.25e-3 - 2e-3, 0, 5e-3)
    found = mean_speed(times, way, 1e-3)
    np.testing.assert_allclose(found[(way > 0.6e-3) & (way < 4.4e-3)], speed, rtol=0.02)
    assert np.all(found[times * speed < 2e-3] == 0) and np.all(found[times * speed > 7.01e-3] == 0)
    assert np.array_equal(mean_speed(times, 0 * way, 1e-3), 0 * times)


def test_onset_and_the_mean_speed_of_a_crack_that_runs(running_crack):
    """Its growth starts at 3 us, with 1000 m/s; 5 mm further it has not come to rest."""
    history = History(running_crack)
    figure = plot_g.draw([history], plot_g.parse([str(running_crack), "--column", "G", "--x", "mean_tip_speed"]))
    speed, = (line.get_xdata() for line in figure.axes[0].lines)
    np.testing.assert_allclose(speed[history.times > 3.6e-6], 1.0, rtol=1e-6)
    tip, = growing_tips(history)
    assert tip.starts() == pytest.approx(3e-6, abs=1.01 * history.columns["dt"][-1]) and tip.rests() is None


def test_an_inset_enlarges_the_paths(grown_crack):
    figure = figure_of([grown_crack], "--inset", "-2", "2.6", "1.5")
    inset, = figure.axes[0].child_axes
    assert inset.get_xlim() == (-3.5, -0.5) and inset.get_ylim() == pytest.approx((1.1, 4.1))
    np.testing.assert_allclose(inset.lines[0].get_xydata(), places(grown_crack))


def test_few_samples_have_bars_for_their_errors(grown_crack):
    history = History(grown_crack)
    figure = plot_g.draw([history], plot_g.parse([str(grown_crack), "--column", "G", "--errors"]))
    bars, = figure.axes[0].containers
    ends = np.array(bars[2][0].get_segments())[:, :, 1]
    np.testing.assert_allclose(ends.mean(axis=1), history.columns["G"])
    np.testing.assert_allclose(np.diff(ends, axis=1)[:, 0] / 2, history.columns["G_error"])


def test_new_faces_take_energy_and_rest_begins_loaded(grown_crack, running_crack):
    for path in (grown_crack, running_crack):
        balance, history = plot_energy.Balance(History(path)), History(path)
        np.testing.assert_array_equal(balance.parts["fracture_energy"], history.columns["fracture_energy"])
        assert balance.supplied[0] == history.columns["strain_energy"][0]
        assert np.abs(balance.parts["numerical_loss"]).max() < 0.05 * balance.largest


def test_the_report_tells_of_growth_and_of_rest(script, grown_crack, tmp_path):
    result = script("report.py", grown_crack, "-o", tmp_path / "r.html", "--dpi", 30)
    text = (tmp_path / "r.html").read_text()
    assert result.returncode == 0 and "<h3>Growth</h3>" in text and "equilibrium at rest" in text and "load steps" in text
    x, y = places(grown_crack)[-1] / 1e3
    assert f"{x:.5g}, {y:.5g}" in text and "paths of the cracks" in text and "time step, least" not in text


MEASURED = {"words": ("x,y\n1,2\n1,a\n", 2, "not rows of numbers"), "nan": ("1,nan\n", 2, "not finite"), "empty": ("# none\n", 2, "has no points"),
            "short": ("1,2\n1\n", 2, "has rows without a column 2")}


@pytest.mark.parametrize("kind", MEASURED)
def test_measured_points_that_are_none(script, grown_crack, tmp_path, kind):
    text, code, words = MEASURED[kind]
    (tmp_path / "m.csv").write_text(text)
    result = script("plot_path.py", grown_crack, "--measured", tmp_path / "m.csv", "-o", tmp_path / "p.png")
    assert result.returncode == code and words in result.stderr and result.stderr.count("\n") == 1


def test_columns_of_growth_that_are_spoilt(script, grown_crack, tmp_path):
    path = tmp_path / "a.h5"
    path.write_bytes(grown_crack.read_bytes())
    with h5py.File(path, "r+") as file:
        file["history/tip_x"][1] = np.nan
    result = script("plot_path.py", path)
    assert result.returncode == 2 and "values that are not finite" in result.stderr
    with h5py.File(path, "r+") as file:
        del file["history/tip_y"]
    assert "/history/tip_y is missing" in script("plot_path.py", path).stderr
