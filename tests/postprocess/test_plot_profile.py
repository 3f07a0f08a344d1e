"""Profiles of fields along a line: which particles and nodes are on it, and what is drawn of them."""

import csv

import numpy as np
import pytest

import plot_profile
from frames import Frames


def options_of(file, *arguments):
    return plot_profile.parse([str(file), *map(str, arguments)])


def profile_of(file, *arguments):
    """The last snapshot along a line."""
    result = Frames(file)
    return plot_profile.profile(result, "name", result.number(), options_of(file, *arguments))


def drawn(file, *arguments):
    """Axes of the figure."""
    shown = profile_of(file, *arguments)
    options = options_of(file, *arguments)
    return plot_profile.draw([shown], plot_profile.unit_of(Frames(file), options), options).axes[0]


def test_line_along_an_edge_shows_the_row_of_particles_beside_it(snapshot_result):
    block = Frames(snapshot_result).block("particles", -1)
    lowest = block.points[:, 1] < 2e-3  # 5 mm cells, rows at 1.25 mm, 3.75 mm, ...
    order = np.argsort(block.points[lowest, 0])
    shown = profile_of(snapshot_result, "--field", "stress_yy", "--at", 0)
    np.testing.assert_array_equal(shown.place, block.points[lowest, 0][order])
    np.testing.assert_array_equal(shown.value, block.point_fields["stress_yy"][lowest][order])
    assert shown.place.size == 40


def test_line_between_two_rows_shows_their_mean(snapshot_result):
    """One value a place."""
    rows = [profile_of(snapshot_result, "--field", "speed", "--at", 1e-3 * height).value for height in (1.25, 2.5, 3.75)]
    assert [row.size for row in rows] == [40, 40, 40]
    np.testing.assert_allclose(rows[1], (rows[0] + rows[2]) / 2)


@pytest.mark.parametrize("nodes", [False, True])
def test_each_side_of_a_crack_has_a_curve(vertical_crack, nodes):
    """The right face moves away from the left one, which the support holds back; ahead of the tip they are one."""
    arguments = ["--field", "velocity_x", "--along", "y", "--at", 10e-3] + ["--nodes"] * nodes
    right, left = drawn(vertical_crack, *arguments).lines
    for line in (right, left):
        assert np.all(np.diff(line.get_xdata()) > 0) and line.get_xdata().size == (11 if nodes else 20)
    behind = right.get_xdata() < 4.9
    assert np.all((right.get_ydata() > left.get_ydata())[behind])
    if nodes:
        np.testing.assert_array_equal(right.get_ydata()[~behind], left.get_ydata()[~behind])
    assert [line.get_label() for line in (right, left)] == ["name, $x$ > 0.01 m", "name, $x$ < 0.01 m"]
    assert len(drawn(vertical_crack, "--field", "velocity_x", "--along", "y", "--at", 0, *arguments[6:]).lines) == 1


def test_line_through_cells_of_several_sizes_shows_a_row_of_each(refined_result):
    frames = Frames(refined_result)
    leaves = frames.leaves(frames.number())
    along = (leaves.lower[:, 1] == 0) & (leaves.particles > 0)
    shown = profile_of(refined_result, "--field", "level", "--at", 0)
    assert sorted(np.unique(shown.value)) == [0, 1, 2]
    assert shown.place.size == 2 * np.count_nonzero(along)


def test_places_are_measured_from_the_tip_and_cut_off(snapshot_result):
    all_of_it = profile_of(snapshot_result, "--field", "stress_yy", "--at", 0)
    shown = profile_of(snapshot_result, "--field", "stress_yy", "--at", 0, "--from-tip", "--from", 0, "--to", 11e-3)
    np.testing.assert_allclose(shown.place, all_of_it.place[20:24] - 0.05)
    assert np.all(np.diff(shown.place) > 0)


def test_a_component_is_that_of_the_vector(snapshot_result):
    block = Frames(snapshot_result).block("particles", -1)
    shown = profile_of(snapshot_result, "--field", "displacement_y", "--along", "y")
    of = np.argsort(block.points[:, 1]).reshape(-1, 40)      # rows along x
    np.testing.assert_allclose(shown.value, block.point_fields["displacement"][of, 1].mean(axis=1))
    np.testing.assert_allclose(shown.place, block.points[of, 1].mean(axis=1))


def test_nodes_with_mass_carry_all_of_it(snapshot_result):
    assert profile_of(snapshot_result, "--field", "mass", "--nodes").value.sum() == pytest.approx(2700 * 0.1 * 0.01 * 0.01)
    held = profile_of(snapshot_result, "--field", "velocity_y", "--nodes", "--at", 0)
    np.testing.assert_allclose(held.place, 5e-3 * np.arange(21), atol=1e-12)
    assert np.all(held.value[held.place >= 0.0499] == 0) and np.all(held.value[:10] != 0)


def test_axes_have_units_with_prefixes(snapshot_result, tmp_path):
    curve = tmp_path / "curve.csv"
    curve.write_text("0.0,0.0\n0.1,1e-6\n")
    arguments = ["--field", "displacement_y", "--at", 0, "--reference", curve, "--reference-name", "by hand"]
    axes, shown = drawn(snapshot_result, *arguments), profile_of(snapshot_result, *arguments)
    reference, line = axes.lines
    assert axes.get_xlabel() == "$x$ [mm]" and axes.get_ylabel() == "displacement $u_{y}$ [nm]"
    np.testing.assert_allclose(reference.get_data(), [[0, 100], [0, 1000]])
    np.testing.assert_allclose(line.get_data(), [shown.place * 1e3, shown.value * 1e9])
    axes = drawn(snapshot_result, "--field", "stress_yy", "--from-tip", "--log", "--scale", 1e3, "--label", "stress over 1 kPa")
    assert axes.get_xlabel() == "distance ahead of the crack tip [mm]" and axes.get_ylabel() == "stress over 1 kPa"
    assert axes.get_xscale() == axes.get_yscale() == "log" and np.all(axes.lines[0].get_data()[1] > 0)


def test_a_curve_for_each_time_and_rows_of_values(script, snapshot_result):
    result = script("plot_profile.py", snapshot_result, "--field", "speed", "--at", 0, "--time", 0, "--time", 2e-4, "--csv")
    rows = list(csv.DictReader(result.stdout.splitlines()))
    assert len(rows) == 80 and {row["file"] for row in rows} == {"dcb"}
    assert all(float(row["value"]) == 0 for row in rows[:40]) and float(rows[40]["time"]) == pytest.approx(2e-4)
