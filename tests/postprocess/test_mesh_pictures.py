"""Pictures of the mesh and animations: what they show, that they are written, that mistakes are named."""

import re
import shutil
import sys

import h5py
import numpy as np
import pytest
from PIL import Image

import animate
import particle_pictures
import plot_mesh
from frames import Frames
from paths import ROOT

from hampm.snapshots import Block
from hampm.stored_model import StoredModel


def figure_of(file, *arguments):
    return plot_mesh.draw([Frames(file)], plot_mesh.parse([str(file), *arguments]))


def test_mesh_is_mirrored_and_around_the_tip(refined_result):
    lower = figure_of(refined_result, "--window", "8").axes[1]
    drawn = [path.vertices[:4] for path in lower.collections[0].get_paths()]
    leaves = Frames(refined_result).leaves(3)
    assert len(drawn) == 2 * np.count_nonzero(leaves.particles)
    area = sum(np.prod(np.ptp(corners, axis=0)) for corners in drawn)
    assert area == pytest.approx(2 * 100 * 10) and np.mean(drawn, axis=(0, 1))[1] == pytest.approx(0, abs=1e-9)
    assert lower.get_xlim() == lower.get_ylim() == (-8, 8)


def test_parameter_is_the_mean_of_each_cell_along_the_plane(refined_result):
    upper = figure_of(refined_result).axes[0]
    curve, critical = upper.lines[:2]
    x, mean = curve.get_data()
    assert (x[0], x[-1]) == (pytest.approx(-50), pytest.approx(50)) and np.all(np.diff(x) >= -1e-9)
    assert set(critical.get_ydata()) == {0.02}
    with h5py.File(refined_result) as file:  # the cell that ends at the tip, of the finest, from its four corners
        mesh = file["VTKHDF/mesh"]
        first = mesh["Steps/PointOffsets"][3]
        points, values = mesh["Points"][first:], mesh["PointData/R"][first:]
    near = [np.argmin(np.linalg.norm(points[:, :2] - corner, axis=1))
            for corner in [(0.05, 0), (0.05, 1.25e-3), (0.04875, 0), (0.04875, 1.25e-3)]]
    behind = np.flatnonzero((x[:-1] < -1e-9) & (np.abs(x[1:]) < 1e-9))[-1]
    assert x[behind] == pytest.approx(-1.25) and mean[behind] == pytest.approx(np.mean(values[near]))
    assert mean[behind] > 0


def test_the_mesh_in_the_coordinates_of_the_scene(refined_result):
    upper, lower = figure_of(refined_result, "--window", "8", "--axes", "scene").axes
    assert (lower.get_xlim(), lower.get_ylim(), upper.get_xlim()) == ((42, 58), (-8, 8), (-8, 8))
    assert (lower.get_xlabel(), upper.get_xlabel()) == ("$x$ [mm]", "distance ahead of the crack tip [mm]")
    np.testing.assert_allclose(lower.lines[1].get_xydata(), [[50, 0]])
    np.testing.assert_allclose(lower.lines[0].get_xydata(), [[0, 0], [50, 0]])  # the crack, from the edge
    there, here = (np.array([path.vertices[:4] for path in axes.collections[0].get_paths()])
                   for axes in (lower, figure_of(refined_result).axes[1]))
    np.testing.assert_allclose(there, here + [50, 0], atol=1e-9)


def test_cracks_in_any_direction_are_lines_with_their_tips(slanted_crack):
    axes, = figure_of(slanted_crack, "--tip", "2", "--window", "5").axes
    assert axes.get_xlabel() == "$x$ [mm]"
    np.testing.assert_allclose([axes.get_xlim(), axes.get_ylim()], [(-9.1, 0.9), (-6.3, 3.7)])
    first, its_tips, second, its_tip = [curve.get_xydata() for curve in axes.lines]
    np.testing.assert_allclose(first, [[-4.1, -1.3], [3.7, 2.2]])
    np.testing.assert_allclose(its_tips, first)
    np.testing.assert_allclose(second, [[-12, 6.3], [-8.2, 7.1], [-6.3, 8.7]])
    np.testing.assert_allclose(its_tip, second[2:])
    cells = [path.vertices[:4] for path in axes.collections[0].get_paths()]
    assert sum(np.prod(np.ptp(cell, axis=0)) for cell in cells) == pytest.approx(24**2)  # those that are cut once
    axes, = figure_of(slanted_crack, "--axes", "crack", "--tip", "3").axes
    np.testing.assert_allclose(axes.lines[3].get_xydata(), [[0, 0]], atol=1e-12)
    np.testing.assert_allclose(axes.lines[2].get_xydata()[1], [-np.hypot(1.9, 1.6), 0], atol=1e-12)


def test_each_tip_is_in_the_middle_in_the_coordinates_of_the_scene(refined_result, vertical_crack):
    files = [str(refined_result), str(vertical_crack)]
    figure = plot_mesh.draw([Frames(file) for file in files], plot_mesh.parse([*files, "--window", "3", "--axes", "scene"]))
    limits = [(panel.get_xlim(), panel.get_ylim()) for panel in figure.axes[2:]]
    np.testing.assert_allclose(limits, [[(47, 53), (-3, 3)], [(7, 13), (2, 8)]])
    assert figure.axes[0].get_ylim() == figure.axes[1].get_ylim()


def test_runs_without_indicator_show_the_mesh_alone(refined_result, snapshot_result):
    axes, = figure_of(snapshot_result).axes
    assert axes.get_xlabel() == "ahead of the tip [mm]" and axes.get_title().startswith("dcb, ")
    both = plot_mesh.draw([Frames(file) for file in (refined_result, snapshot_result)], plot_mesh.parse(["a"]))
    assert [text.get_text().startswith("no $R$ in this file") for text in both.axes[1].texts] == [True]


def test_animation_has_every_snapshot_and_the_same_bytes_again(script, refined_result, tmp_path):
    files = [tmp_path / "one.gif", tmp_path / "two.gif"]
    for file in files:
        result = script("animate.py", refined_result, "--dpi", 50, "-o", file)
        assert (result.returncode, result.stdout.strip(), result.stderr) == (0, str(file), "")
    assert files[0].read_bytes() == files[1].read_bytes()
    with Image.open(files[0]) as film:
        assert film.n_frames == 4
        frames = []
        for number in range(4):
            film.seek(number)
            frames.append(np.array(film.convert("RGB")))
    assert np.any(frames[0] != frames[3]) and len(np.unique(frames[3].reshape(-1, 3), axis=0)) > 50


FFMPEG = """#!{python}
import sys
open(sys.argv[-1], "wb").write(sys.stdin.buffer.read() + " ".join(sys.argv).encode())
"""


def test_a_film_is_an_mp4_where_there_is_ffmpeg(script, refined_result, tmp_path, monkeypatch):
    """A program of that name gets four pictures of one size, and its words; without it the message says what is missing."""
    monkeypatch.setenv("PATH", str(tmp_path))
    result = script("animate.py", refined_result, "--dpi", 20, "-o", tmp_path / "a.mp4")
    assert result.returncode == 2 and "written by ffmpeg, which is not there" in result.stderr and not (tmp_path / "a.mp4").exists()
    (tmp_path / "ffmpeg").write_text(FFMPEG.format(python=sys.executable))
    (tmp_path / "ffmpeg").chmod(0o755)
    result = script("animate.py", refined_result, "--dpi", 20, "--no-mesh", "-o", tmp_path / "a.mp4")
    assert (result.returncode, result.stdout.strip()) == (0, str(tmp_path / "a.mp4")), result.stderr
    written = (tmp_path / "a.mp4").read_bytes()
    width, height = map(int, re.search(rb"-s (\d+)x(\d+)", written).groups())
    assert written.index(b"-f rawvideo") > 4 * 4 * width * height and b"libx264" in written
    file = shutil.copy(refined_result, tmp_path / "b.h5")
    assert script("animate.py", file, "--dpi", 20, "--every", 3, "--style", "dark", "--size", "100mm").stdout == f"{tmp_path}/b.mp4\n"   # where it can be
    assert re.search(rb"-s (\d+)x", (tmp_path / "b.mp4").read_bytes())[1] == b"78"
    monkeypatch.setenv("PATH", "")
    assert script("animate.py", file, "--dpi", 20, "--every", 3).stdout == f"{tmp_path}/b.gif\n"


def test_the_mesh_is_drawn_where_it_holds_material_or_left_out(refined_result):
    leaves = Frames(refined_result).leaves(3)
    film = film_of(refined_result, "--mesh")
    assert len(film.canvas.mesh.get_paths()) == 2 * np.count_nonzero(leaves.particles) < 2 * len(leaves.particles)
    assert film.canvas.mesh.get_visible() and not film_of(refined_result).canvas.mesh.get_visible()


@pytest.mark.parametrize("field", ["stress_xy", "speed", "displacement"])
def test_fields_that_colour_the_particles(script, refined_result, tmp_path, field):
    result = script("animate.py", refined_result, "--field", field, "--dpi", 40, "--window", 20, "--scale", 1000, "-o",
                    tmp_path / "a.gif")
    assert result.returncode == 0, result.stderr


def film_of(file, *arguments):
    film = animate.Film(Frames(file), animate.parse([str(file), "--squares", "1.06", *arguments]))
    film.show(3)
    return film


def test_particles_cover_the_body_and_move_by_their_scaled_displacement(refined_result):
    film, further = (film_of(refined_result, "--scale", scale) for scale in ("1", "1001"))
    vertices, moved = (np.array([path.vertices[:4] for path in each.canvas.squares.get_paths()]) for each in (film, further))
    particles = Frames(refined_result).block("particles", 3)
    n = len(particles.points)
    assert len(vertices) == 2 * n
    area = np.sum(np.prod(np.ptp(vertices, axis=1), axis=1))
    assert area == pytest.approx(2 * 100 * 10 * particle_pictures.OVERLAP**2, rel=1e-4)  # they are strained a little
    shift = (moved - vertices)[:n].mean(axis=1)
    np.testing.assert_allclose(shift, particles.point_fields["displacement"][:, :2] * 1e6, rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose((moved - vertices)[n:].mean(axis=1), shift * [1, -1], rtol=1e-6, atol=1e-9)


def test_shear_of_the_mirror_image_has_the_other_sign(refined_result):
    values = film_of(refined_result, "--field", "stress_xy").canvas.squares.get_array()
    half = len(values) // 2
    assert np.any(values) and np.array_equal(values[half:], -values[:half])


class Still:
    """A result of one snapshot: bodies of 1 mm as pairs of corners of theirs, each with a velocity."""

    def __init__(self, *bodies):
        places = [np.array(start) + corner for start, _ in bodies for corner in (np.zeros(2), np.full(2, 1e-3))]
        velocity = [speed for _, speed in bodies for _ in range(2)]
        self._particles = Block(np.array(places), None, {"displacement": np.zeros((len(places), 3)), "velocity": np.array(velocity),
                                                         "body": np.repeat(np.arange(1.0, len(bodies) + 1), 2)}, {})
        self.scene = StoredModel("&grid\n   cell = 0.5e-3\n/\n", "a.h5")

    def block(self, name, number):
        return self._particles


@pytest.mark.parametrize("bodies, meet", [
    ([((0, 0), (0, 0))], False),
    ([((0, 0), (0, 0)), ((1.2e-3, 0), (0, 0))], False),                            # bonded, particles are within the cell
    ([((0, 0), (0, 0)), ((4e-3, 0), (0, 0)), ((2e-3, 0), (0, 0))], True),          # apart
    ([((0, 0), (0, 0)), ((2.4e-3, 0), (0, 0)), ((1.2e-3, 0), (0, 0))], False),     # a chain
    ([((0, 0), (5, 0)), ((1.2e-3, 0), (0, 0))], True)])                            # one strikes the other
def test_bodies_that_may_come_to_touch(bodies, meet):
    assert particle_pictures.bodies_meet(Still(*bodies)) is meet


def test_displacements_are_enlarged_never_made_smaller():
    seen = particle_pictures.Survey(moved=50.0, values=None, areas=None, lower=np.zeros(2), upper=np.full(2, 100.0), tip=np.zeros(2))
    assert particle_pictures.default_scale(seen, None) == 1
    assert particle_pictures.default_scale(seen._replace(moved=1e-3), None) == 10_000


def test_an_animation_of_a_crack_that_opens(script, slanted_crack, tmp_path):
    assert script("animate.py", slanted_crack, "--dpi", 40, "--field", "stress_yy", "-o", tmp_path / "a.gif").returncode == 0
    closed, opened = (face_gap(slanted_crack, scale) for scale in ("1", "5000"))
    assert closed < 2e-4 and opened == pytest.approx(5000 * closed)


def face_gap(file, scale):
    """Largest distance of the faces of the first crack in the last snapshot [mm]."""
    film = animate.Film(Frames(file), animate.parse([str(file), "--scale", scale]))
    film.show(1)
    left, right = film.canvas.faces.get_segments()[:2]
    return np.linalg.norm(left - right, axis=1).max()


def test_snapshots_are_counted_on_a_terminal(script, refined_result, tmp_path, monkeypatch):
    arguments = ["animate.py", refined_result, "--dpi", 30, "-o", tmp_path / "a.gif"]
    assert script(*arguments).stderr == ""
    monkeypatch.setattr("sys.stderr.isatty", lambda: True, raising=False)
    lines = script(*arguments).stderr.split("\r")
    assert lines[-1].split("  ")[0] == "snapshot 4 of 4" and lines[-1].endswith(" \n") and re.match(r"snapshot 3 of 4, \d+ s left ", lines[-2])
    assert script(*arguments, "--every", 3).stderr.split("\r")[-1].startswith("snapshot 2 of 2 ")


def test_scene_without_a_crack(script, hampm, tmp_path):
    run = hampm(ROOT / "tests/regression/static_bar/case.nml", "--set", "output.file=bar.h5", "--set",
                "run.end_time=1e-5", "--set", "output.snapshot_interval=1e-5")
    assert run.returncode == 0, run.stderr
    result = script("plot_mesh.py", tmp_path / "bar.h5")
    assert result.returncode == 2 and "has no crack" in result.stderr
    assert script("animate.py", tmp_path / "bar.h5", "--dpi", 40).returncode == 0
    result = script("animate.py", tmp_path / "bar.h5", "--window", 5)
    assert result.returncode == 2 and "has no crack" in result.stderr
