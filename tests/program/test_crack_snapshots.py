"""Snapshots of cracks: the cracks themselves, the side of each particle, and both pieces of a cell."""

import sys

import h5py
import numpy as np
import pytest

from paths import BENCH
from snapshots import field, field_names, points, read_steps
from test_result_file import PARTICLE_FIELDS

sys.path.insert(0, str(BENCH))

from cracks import scene  # noqa: E402

pytestmark = pytest.mark.xdist_group("test_crack_snapshots")  # which share the runs of a fixture
INNER = [(-4.1e-3, -1.3e-3), (3.7e-3, 2.2e-3)]
EDGE = [(-0.012, 5.3e-3), (-7.2e-3, 6.1e-3), (-4.6e-3, 8.2e-3)]
OUTPUT = "&output history_interval = 2e-7  snapshot_interval = 2e-6 /\n"


def plate(cracks, method=""):
    """Two snapshots of a plate under tension, with a level of refinement at the tips."""
    text = scene(cracks, 1e-3, (0.012, 0.012), levels=1, rings=2).replace("end_time = 1.0", "end_time = 4e-6")
    return text.replace("time = 'static'", method) + OUTPUT


@pytest.fixture(scope="module")
def file(run_hampm, tmp_path_factory):
    folder = tmp_path_factory.mktemp("crack_snapshots")
    (folder / "crack.nml").write_text(plate([INNER, EDGE]))
    result = run_hampm("crack.nml", "--quiet", cwd=folder)
    assert result.returncode == 0, result.stderr
    return folder / "crack.h5"


@pytest.fixture(scope="module")
def steps(file):
    return read_steps(file)


def test_cracks_are_lines_with_their_tips(steps):
    """Tips are numbered as the columns of the history are: of each crack the last point first."""
    times, blocks = steps
    assert times == pytest.approx([0, 2e-6, 4e-6])
    for _, _, cracks in blocks:
        np.testing.assert_allclose(points(cracks)[:, :2], [*INNER, *EDGE], rtol=1e-15)
        assert list(field(cracks.point_data, "tip")) == [2, 1, 0, 0, 3]
        assert list(field(cracks.cell_data, "crack")) == [1, 2, 2]
        lines = [list(cell) for cell in cracks.cells]
        assert lines == [[0, 1], [2, 3], [3, 4]]


def height(start, end, places):
    """Above the line through two points, to the left [m]."""
    along = np.subtract(end, start) / np.hypot(*np.subtract(end, start))
    return (places - start) @ [-along[1], along[0]]


def test_particles_have_the_side_on_which_they_began(steps):
    for particles, _, _ in steps[1]:
        data = particles.point_data
        began = (points(particles) - field(data, "displacement"))[:, :2]
        side, piece = field(data, "side"), field(data, "piece")
        assert set(side) == {-1, 0, 1} and np.array_equal(side != 0, piece != 0)
        at_inner = (side != 0) & (np.abs(began) < 5e-3).all(axis=1)
        at_edge = (side != 0) & ~at_inner
        np.testing.assert_array_equal(side[at_inner], np.sign(height(*INNER, began[at_inner])))
        to_left = np.minimum(height(*EDGE[:2], began[at_edge]), height(*EDGE[1:], began[at_edge]))  # it turns to the left
        np.testing.assert_array_equal(side[at_edge], np.sign(to_left))
        distance = np.minimum(np.abs(height(*INNER, began)), 1)
        assert distance[at_inner].max() < np.sqrt(2) * 1e-3


def test_pieces_of_a_cell_are_on_either_side_of_its_crack(steps):
    """A cell that is cut is there once for each piece, with the particles of that."""
    particles, mesh, _ = steps[1][-1]
    data = particles.point_data
    began = (points(particles) - field(data, "displacement"))[:, :2]
    piece, count = field(mesh.cell_data, "piece"), field(mesh.cell_data, "particles")
    assert set(piece) == {0, 1, 2}
    corners = np.array([mesh.bounds(k)[:4] for k in range(len(mesh.cells))])
    squares = {}
    for k in np.flatnonzero(piece):
        squares.setdefault(tuple(np.round(corners[k], 9)), {})[piece[k]] = k
    assert len(squares) > 20
    both = 0
    for (left, right, bottom, top), element in squares.items():
        assert set(element) == {1, 2}
        inside = (began > [left, bottom]).all(axis=1) & (began < [right, top]).all(axis=1)
        sides = []
        for number, k in element.items():
            mine = inside & (field(data, "piece") == number)
            assert np.count_nonzero(mine) == count[k]
            sides += [set(field(data, "side")[mine])]
            assert len(sides[-1]) <= 1
        both += len(sides[0] | sides[1]) == 2
        assert not sides[0] & sides[1]
    assert both > 10


def names(path):
    with h5py.File(path) as file:
        found = []
        file["VTKHDF"].visit(found.append)
        return sorted(found)


def test_lines_are_in_the_files_too(hampm, tmp_path, file):
    """Their cells are not cut where they run along grid lines."""
    (tmp_path / "line.nml").write_text(plate([]) + "&crack kind = 'line'  tip = 5e-3, 0.0  length = 9e-3 /\n")
    assert hampm("line.nml", "--quiet").returncode == 0
    for particles, mesh, cracks in read_steps(tmp_path / "line.h5")[1]:
        np.testing.assert_allclose(points(cracks)[:, :2], [[-4e-3, 0], [5e-3, 0]], rtol=0, atol=1e-15)
        assert list(field(cracks.point_data, "tip")) == [2, 1]
        assert not any(np.any(field(data, "piece")) for data in (particles.point_data, mesh.cell_data))
    assert names(tmp_path / "line.h5") == names(file)


def test_a_symmetry_plane_that_stays_is_not_in_the_file(file, dcb_result):
    """Such files, and those of scenes without cracks, have two blocks, with the fields that they always have."""
    particles, mesh = read_steps(dcb_result)[1][0]
    assert sorted(field_names(particles.point_data)) == PARTICLE_FIELDS
    assert sorted(field_names(mesh.cell_data)) == ["level", "particles"]
    added = set(names(file)) - set(names(dcb_result))
    assert {name for name in added if not name.startswith("cracks/")} == {
        "cracks", "particles/PointData/piece", "particles/PointData/side", "particles/PointData/stress_zz", "mesh/CellData/piece"}


def test_snapshots_go_on_from_a_checkpoint(hampm, tmp_path, file):
    (tmp_path / "crack.nml").write_text(plate([INNER, EDGE]))
    assert "stopped by --steps" in hampm("crack.nml", "--quiet", "--steps", 20).stderr
    assert hampm("--resume", "crack.h5.checkpoint", "--quiet").returncode == 0
    with h5py.File(file) as whole, h5py.File(tmp_path / "crack.h5") as continued:
        for name in names(file):
            if isinstance(whole["VTKHDF"][name], h5py.Dataset):
                assert np.array_equal(whole["VTKHDF"][name], continued["VTKHDF"][name]), name
