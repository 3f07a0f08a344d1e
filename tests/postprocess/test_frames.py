"""Snapshots as the pictures need them: quarters put together, means over nodes, coordinates of the crack."""

import numpy as np
import pytest

from frames import CrackPlane, Frames, Leaves
from history import ResultError

from hampm.snapshots import Block
from hampm.stored_model import StoredModel

# A root cell divided into four beside one that is not, and is stored as its quarters: points are numbered along rows.
POINTS = np.array([(x, y) for y in (0, 0.5, 1) for x in (0, 0.5, 1, 1.5, 2)], dtype=float)
CELLS = np.array([[p, p + 1, p + 6, p + 5] for p in (0, 1, 5, 6, 2, 3, 7, 8)])
ORIGIN = np.array([10.0, -3.0])


def two_roots(**point_fields):
    fields = {"level": np.repeat([1.0, 0.0], 4), "particles": np.repeat([4.0, 1.0], 4)}
    return Leaves(Block(POINTS * 2 + ORIGIN, CELLS, point_fields, fields), ORIGIN, 2.0)


def test_quarters_become_one_cell():
    leaves = two_roots()
    assert sorted(zip(leaves.level, leaves.width, leaves.particles)) == [(0, 2.0, 4)] + [(1, 1.0, 4)] * 4
    np.testing.assert_array_equal(leaves.lower[leaves.level == 0], [ORIGIN + [2, 0]])


@pytest.mark.parametrize("point, share", [
    ((1, 0), 1 / 5), ((1, 0.5), 1 / 5), ((2, 1), 1 / 5),  # corners, and the node on its side that the finer cells have
    ((1.5, 0.5), 0), ((1.5, 0), 0), ((2, 0.5), 0)])        # no nodes: its middle, and sides without finer neighbours
def test_mean_is_over_the_nodes_of_a_cell_alone(point, share):
    leaves = two_roots(R=np.all(POINTS == point, axis=1).astype(float))
    assert leaves.mean_of_nodes("R")[leaves.level == 0] == pytest.approx(share)


def test_cell_that_a_point_is_in():
    leaves = two_roots()
    points = ORIGIN + [[0.1, 0.1], [1.9, 1.1], [2.1, 1.9], [3.9, 0.1], [4.1, 1], [-0.1, 1], [1, 2.1], [1, -0.1]]
    cell = leaves.at(points)
    assert list(leaves.level[cell[:4]]) == [1, 1, 0, 0] and cell[2] == cell[3] and cell[0] != cell[1]
    np.testing.assert_array_equal(leaves.lower[cell[1]], ORIGIN + [1, 1])
    assert list(cell[4:]) == [-1] * 4


@pytest.mark.parametrize("direction, ahead, above", [
    ((1, 0), (5, 2), (4, 3)), ((-2, 0), (3, 2), (4, 1)), ((0, 1), (4, 3), (3, 2))])
def test_coordinates_of_a_crack_in_any_direction(direction, ahead, above):
    plane = CrackPlane(np.array([4.0, 2.0]), np.array(direction, dtype=float))
    np.testing.assert_array_equal(plane.local(np.array([ahead, above, (4.0, 2.0)])), [[1, 0], [0, 1], [0, 0]])


def test_values_of_the_namelist():
    scene = StoredModel("&load\n   force = 0.0, 1.0e-3\n/\n&load\n   force = 2.0, 2.0\n   times =\n/\n"
                  "&method\n   frame = 'total'\n/\n", "a.h5")
    assert scene.numbers("load", "force") == [0, 1e-3] and scene.text("method", "frame") == "total"
    assert scene.numbers("load", "times") == scene.numbers("crack", "tip") == []
    assert scene.count("load") == 2 and scene.numbers("load", "force", 2) == [2, 2] and scene.numbers("load", "force", 3) == []


def test_cells_of_a_run_cover_its_grid_once(refined_result):
    frames = Frames(refined_result)
    for number in range(frames.times.size):
        leaves, particles = frames.leaves(number), frames.block("particles", number)
        assert np.sum(leaves.width**2) == pytest.approx(0.1 * 0.015)
        cell = leaves.at(particles.points)
        np.testing.assert_array_equal(np.bincount(cell, minlength=leaves.width.size), leaves.particles)
    assert leaves.level.max() == 2 and leaves.width.size < frames.block("mesh", number).cells.shape[0]


def test_snapshots_are_found_by_number_and_time(refined_result):
    frames = Frames(refined_result)
    assert [frames.number(), frames.number(snapshot=0), frames.number(snapshot=-2)] == [3, 0, 2]
    assert [frames.number(time=time) for time in (0.0, 1.2e-4, 3.9e-4)] == [0, 1, 3]
    for time in (-1.1e-4, 1.0):        # the run goes on to its next snapshot at most
        with pytest.raises(ResultError, match="no snapshot near"):
            frames.number(time=time)


def test_only_half_a_model_has_images_beyond_its_crack_plane():
    tip, along, points = np.zeros(2), np.array([1.0, 0.0]), np.array([[1.0, 2.0]])
    np.testing.assert_array_equal(CrackPlane(tip, along, is_symmetry=True).whole(points), [[1, 2], [1, -2]])
    np.testing.assert_array_equal(CrackPlane(tip, along).whole(points), points)


def test_a_crack_plane_in_the_coordinates_of_the_scene():
    """A vertical plane of symmetry at x = 4: places stay, images are beyond it, also in another unit."""
    plane = CrackPlane(np.array([4.0, 2.0]), np.array([0.0, 3.0]), is_symmetry=True).in_scene()
    points = np.array([[5.0, 1.0], [3.5, 7.0]])
    np.testing.assert_allclose(plane.local(points), points)
    np.testing.assert_allclose(plane.whole(points), [*points, [3.0, 1.0], [4.5, 7.0]])
    np.testing.assert_allclose(plane.whole(1e3 * points, 1e3), 1e3 * plane.whole(points))
    np.testing.assert_allclose([plane.tip, plane.along], [[4.0, 2.0], [0.0, 1.0]])


def test_cracks_on_symmetry_planes_that_stay_are_those_of_the_scene(vertical_crack, refined_result):
    crack, = Frames(vertical_crack).cracks()  # in the material: of the file
    np.testing.assert_allclose(crack.points, [[10e-3, 0], [10e-3, 5e-3]], atol=1e-15)
    assert list(crack.tips) == [0, 1]
    crack, = Frames(refined_result).cracks()
    np.testing.assert_allclose(crack.points, [[0, 0], [0.05, 0]], atol=1e-15)


BODY = "&body\n   lower = {}, 0.0\n   upper = {}, 1.0\n/\n"


def test_a_crack_reaches_through_bodies_that_touch_alone():
    scene = StoredModel("&grid\n   cell = 0.5\n/\n" + "".join(BODY.format(*ends) for ends in [(4, 6), (0, 2), (2, 3)]), "a.h5")
    tip, left = np.array([2.5, 0.5]), np.array([-1.0, 0.0])
    assert scene.way_to_edge(tip, left) == pytest.approx(2.5)
    assert scene.way_to_edge(tip, -left) == pytest.approx(0.5)


def test_cracks_in_any_direction_are_those_of_the_file(slanted_crack):
    frames = Frames(slanted_crack)
    first, second = frames.cracks(0)
    np.testing.assert_allclose(first.points, [[-4.1e-3, -1.3e-3], [3.7e-3, 2.2e-3]])
    np.testing.assert_allclose(second.points, [[-12e-3, 6.3e-3], [-8.2e-3, 7.1e-3], [-6.3e-3, 8.7e-3]])
    assert (list(first.tips), list(second.tips)) == ([2, 1], [0, 0, 3])
    for tip, place, before in ((1, first.points[1], first.points[0]), (2, first.points[0], first.points[1]),
                               (3, second.points[2], second.points[1])):
        plane = frames.crack_plane(tip)
        np.testing.assert_allclose(plane.local(np.array([place, before])), [[0, 0], [-np.linalg.norm(place - before), 0]], atol=1e-15)
    with pytest.raises(ResultError, match="has no crack tip 4"):
        frames.crack_plane(4)
