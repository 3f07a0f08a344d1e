"""Pictures of G(t)/G_ref and of other columns: written, non-trivial, in every format; mistakes named."""

import h5py
import matplotlib.colors
import matplotlib.image
import matplotlib.text
import numpy as np
import pytest

import pictures
import plot_g
from history import History, ResultError
from synthetic import G_REF, dcb, write_result


def test_default_picture_stands_beside_the_first_file(program, dcb_file):
    result = program("plot_g.py", dcb_file)
    picture = dcb_file.with_name("dcb_G.png")
    assert result.returncode == 0 and result.stdout.strip() == str(picture)
    pixels = matplotlib.image.imread(picture)[..., :3]
    assert pixels.shape[0] > 700 and pixels.shape[1] > 1000
    for colour in pictures.COLOURS[:2]:
        assert share(pixels, colour) > 1e-3
    assert share(pixels, pictures.COLOURS[2]) < 1e-4


def share(pixels, colour):
    """Part of the picture that has this colour."""
    return np.mean(np.all(np.abs(pixels - matplotlib.colors.to_rgb(colour)) < 0.02, axis=2))


def test_labels_name_files_estimators_lines_and_units(script, dcb_file, tmp_path):
    (tmp_path / "other").mkdir()
    other = write_result(tmp_path / "other" / "dcb.h5")
    curve = tmp_path / "curve.csv"
    curve.write_text("# t_s, G\n0,0\n1e-3,1\n1.2e-3,0.5\n")
    picture = tmp_path / "g.svg"
    result = script("plot_g.py", dcb_file, other, "--estimator", "vcct_I", "--converged", 1.28737, "--reference",
                    curve, "--time-unit", "us", "--lowpass", 5e4, "--title", "Two beams", "--output", picture)
    assert result.returncode == 0, result.stderr
    text = picture.read_text()
    for label in ["other/dcb", tmp_path.name[:20], "reference: curve", "1.284", "1.287", "Two beams, low-pass filter at 50 kHz", "µs"]:
        assert label in text
    assert "stress closure" not in text


def test_curves_are_g_over_g_ref_in_the_unit_of_time(dcb_file):
    options = plot_g.parse([str(dcb_file), "--time-unit", "ms"])
    axes = plot_g.draw([History(dcb_file)], options).axes[0]
    t, g = axes.lines[0].get_data()
    np.testing.assert_allclose(t, dcb()["time"] * 1e3)
    np.testing.assert_allclose(g, dcb()["G_stress_closure_I"] / G_REF)


def test_another_column_and_its_reference_are_over_the_scale(dcb_file, tmp_path):
    curve = tmp_path / "curve.csv"
    curve.write_text("# made by hand\nt_s,opening\n0,0\n1e-3,4e-8\n")
    options = plot_g.parse([str(dcb_file), "--column", "crack_*", "--scale", "2e-8", "--reference", str(curve),
                            "--reference-name", "by hand", "--time-unit", "us"])
    axes = plot_g.draw([History(dcb_file)], options).axes[0]
    reference, opening = axes.lines
    np.testing.assert_allclose(reference.get_data(), [[0, 1000], [0, 2]])
    np.testing.assert_allclose(opening.get_ydata(), dcb()["crack_opening"] / 2e-8)
    assert [line.get_label() for line in axes.lines] == ["by hand", "crack opening"]
    assert axes.get_ylabel() == "crack opening [2e-08 m]"


def drawn(files, *arguments):
    """The figure of some files."""
    return plot_g.draw([History(file) for file in files], plot_g.parse([*map(str, files), *map(str, arguments)]))


def test_g_without_a_reference_value_has_its_own_unit(tmp_path):
    axes, = drawn([write_result(tmp_path / "a.h5", g_ref=None, beam=None)]).axes
    np.testing.assert_allclose(axes.lines[1].get_ydata(), 1e3 * dcb()["G_vcct_I"])
    assert axes.get_ylabel() == "energy release rate $G$ [mJ/m²]"


def test_what_is_over_the_reference_value_needs_it_in_all_files(script, tmp_path, dcb_file):
    path = write_result(tmp_path / "a.h5", g_ref=None)
    for arguments in ([path, "--converged", 1], [dcb_file, path]):
        result = script("plot_g.py", *arguments)
        assert result.returncode == 2 and f"{path}: /history has no attribute G_ref" in result.stderr


LONG = "stress intensity factor, interaction integral, mode I"


def with_units(path, columns, units, long_names):
    """A result file whose columns have these units and long names."""
    write_result(path, columns)
    with h5py.File(path, "a") as file:
        for name in columns:
            file["history"][name].attrs["units"] = units.get(name, "J/m2")
            file["history"][name].attrs["long_name"] = long_names.get(name, name)
    return path


def test_columns_of_different_units_have_axes_of_their_own(tmp_path):
    columns = dcb() | {"K_I": 1e6 * dcb()["time"], "K_II": dcb()["time"]}
    file = with_units(tmp_path / "a.h5", columns, {"K_I": "Pa m^0.5", "K_II": "Pa m^0.5", "crack_opening": "m"},
                      {"K_I": LONG, "K_II": LONG + "I"})
    upper, lower = drawn([file], "--column", "K_*", "--column", "crack_opening").axes
    assert [len(axes.lines) for axes in (upper, lower)] == [2, 1]
    assert upper.get_ylabel().replace("\n", " ") == "stress intensity factor [kPa√m]"
    np.testing.assert_allclose(upper.lines[0].get_ydata(), 1e3 * dcb()["time"])
    assert lower.get_ylabel() == "crack_opening [nm]"
    assert [line.get_label() for line in upper.lines] == [r"$K_{\mathrm{I}}$", r"$K_{\mathrm{II}}$"]
    with pytest.raises(ResultError, match="--label is of one axis"):
        drawn([file], "--column", "K_I", "--column", "crack_opening", "--label", "both")


def test_long_labels_stay_within_the_picture(tmp_path):
    file = with_units(tmp_path / "a.h5", dcb() | {"K_I": dcb()["time"]}, {"K_I": "Pa m^0.5"}, {"K_I": LONG})
    for arguments in (["--column", "K_I"], ["--column", "K_I", "--column", "step", "--column", "crack_opening"]):
        figure = drawn([file], *arguments)
        figure.draw_without_rendering()
        for axes in figure.axes:
            box = axes.yaxis.label.get_window_extent()
            assert box.y0 >= 0 and box.y1 <= figure.bbox.height and box.x0 >= 0


def test_errors_are_bands_and_no_curves(tmp_path):
    columns = dcb() | {"G_vcct_I_error": np.full(1201, 0.2 * G_REF)}
    file = write_result(tmp_path / "a.h5", columns)
    axes, = drawn([file], "--errors").axes
    assert [line.get_label() for line in axes.lines[:2]] == [r"$G_{\mathrm{I}}$ stress closure", r"$G_{\mathrm{I}}$ VCCT"]
    assert len(axes.lines) == 3
    band, = axes.collections
    middle = np.interp(0.6, 1e3 * columns["time"], columns["G_vcct_I"] / G_REF)
    heights = [y for x, y in band.get_paths()[0].vertices if abs(x - 0.6) < 1e-9]
    np.testing.assert_allclose(sorted(heights), [middle - 0.2, middle + 0.2])
    assert not drawn([file]).axes[0].collections


def test_a_column_over_another_one(tmp_path):
    """The load over the opening, with its unit; of each tip over the column of that tip where there is one."""
    columns = dcb() | {"load_factor": 2 * dcb()["time"], "K_I": dcb()["time"], "K_I_tip2": 3 * dcb()["time"],
                       "crack_length": np.linspace(0.01, 0.02, 1201), "crack_length_tip2": np.linspace(0.03, 0.05, 1201)}
    units = dict.fromkeys(["K_I", "K_I_tip2"], "Pa m^0.5") | dict.fromkeys(["crack_opening", "crack_length", "crack_length_tip2"], "m")
    file = with_units(tmp_path / "a.h5", columns, units | {"load_factor": "1"}, {"crack_opening": "opening one cell behind the tip"})
    axes, = drawn([file], "--column", "load_factor", "--x", "crack_opening").axes
    np.testing.assert_allclose(axes.lines[0].get_data(), [1e9 * columns["crack_opening"], columns["load_factor"] / 1])
    assert axes.get_xlabel() == "opening one cell behind the tip [nm]"
    axes, = drawn([file], "--column", "K_*", "--x", "crack_length").axes
    np.testing.assert_allclose([line.get_xdata()[[0, -1]] for line in axes.lines], [[10, 20], [30, 50]])
    with pytest.raises(ResultError, match="no column 'way'"):
        drawn([file], "--x", "way")


@pytest.mark.parametrize(("column", "shown"), [
    ("K_I", r"$K_{\mathrm{I}}$"), ("K_II_tip2", r"$K_{\mathrm{II}}$, tip 2"), ("J_3", r"$J_{\mathrm{3}}$"), ("G", "$G$"),
    ("J_near_tip", "$J$ near tip"),
    ("G_stress_closure_II", r"$G_{\mathrm{II}}$ stress closure"), ("crack_opening", "crack opening"), ("kinetic_energy", "kinetic energy")])
def test_names_of_columns_in_pictures(column, shown):
    assert plot_g.words(column) == shown


@pytest.mark.parametrize(("unit", "shown"), [
    ("J/m2", "J/m²"), ("Pa m^0.5", "Pa√m"), ("kg m2/s", "kg m²/s"), ("m/s", "m/s"), ("N", "N")])
def test_units_in_pictures(unit, shown):
    assert pictures.typeset(unit) == shown


def test_up_to_eight_curves_have_their_names_beside_them(tmp_path):
    """In their colours, in the picture, none over another; more stand in a legend. No two of eight look alike."""
    columns = dcb() | {f"J_{k}": (1 + 0.001 * k) * dcb()["time"] for k in range(1, 10)}
    file = write_result(tmp_path / "a.h5", columns)
    figure = drawn([file], "--column", "J_[1-8]")
    axes, = figure.axes
    assert not figure.legends and [text.get_color() for text in axes.texts] == [line.get_color() for line in axes.lines]
    assert len({line.get_color() for line in axes.lines}) == 8
    figure.draw_without_rendering()
    boxes = [matplotlib.text.Text.get_window_extent(text) for text in axes.texts]  # without the lines that lead there
    assert all(0 <= box.y0 and box.y1 <= figure.bbox.height and box.x1 <= figure.bbox.width for box in boxes)
    boxes.sort(key=lambda box: box.y0)
    assert all(lower.y1 <= upper.y0 + 1 for lower, upper in zip(boxes, boxes[1:]))
    figure = drawn([file], "--column", "J_?")
    assert len(figure.legends[0].get_texts()) == 9 and not figure.axes[0].texts


def test_the_unit_of_time_suits_the_run(dcb_file):
    assert drawn([dcb_file]).axes[0].get_xlabel() == "time $t$ [ms]"
    assert [pictures.time_unit(longest)[1] for longest in (2.0, 0.5, 2e-4, 3e-8, 0.0)] == ["s", "ms", "µs", "ns", "s"]


@pytest.mark.parametrize(("name", "is_one"), [("G_domain_I", True), ("G_vcct_II_tip2", True), ("G_domain_I_error", False), ("G_tip2", False), ("G_moving_average", False),
                                              ("G_moving_average_tip3", False)])
def test_estimators_are_compared_at_a_time(name, is_one):
    """A mean over an advance lags behind a G that rises: a picture or a report would show that as a difference between estimators."""
    assert plot_g.is_estimator(name) == is_one
