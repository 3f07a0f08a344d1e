"""Pictures of particles coloured by a field: what they show, fields that follow from others, mistakes named."""

import shutil
from io import BytesIO
from types import SimpleNamespace

import h5py
import matplotlib.image
import numpy as np
import pytest

import plot_field
from frames import Frames
from history import ResultError
from particle_fields import ParticleField
from particle_pictures import DECADES, MOST_CUT, colours

from hampm.postprocess.smooth_fields import Smooth, pairs_of
from hampm.snapshots import Block
from hampm.stored_model import StoredModel

MATERIAL = "&material\n   name = 'a'\n   law = 'linear_elastic'\n   poisson = 0.25\n/\n"
RUBBER = "&material\n   name = 'b'\n   law = 'neo_hookean'\n   poisson = 0.4\n/\n"


def figure_of(files, *arguments):
    """Of particles as squares without gaps."""
    return smooth_figure(files, "--squares", "1.06", *arguments)


def smooth_figure(files, *arguments):
    options = plot_field.parse([*map(str, files), *arguments])
    return plot_field.draw([Frames(file) for file in files], options)


def test_a_panel_for_each_file_and_time_and_one_scale_of_colours(refined_result, snapshot_result):
    figure = figure_of([refined_result, snapshot_result], "--time", "1e-4", "--time", "3e-4", "--field", "speed", "--window", "9")
    *panels, bar = [axes for axes in figure.axes if axes.get_visible()]
    assert len(panels) == 4 and bar.get_ylabel().startswith("speed [") and bar.get_ylabel().endswith("m/s]")
    titles = [axes.get_title() for axes in panels]
    assert len(set(titles)) == 4 and all(f"$t$ = {t} µs" in title for t, title in zip(["100.0", "300.0"] * 2, titles))
    assert len({panel.collections[0].get_clim() for panel in panels}) == 1
    assert all(panel.get_xlim() == panel.get_ylim() == (-9, 9) for panel in panels)


def middles(axes):
    return np.array([path.vertices[:4].mean(axis=0) for path in axes.collections[0].get_paths()])


def test_squares_stand_at_the_particles_and_have_their_values(refined_result):
    axes = figure_of([refined_result], "--snapshot", "2", "--field", "stress_xx").axes[0]
    particles = Frames(refined_result).block("particles", 2)
    n = len(particles.points)
    np.testing.assert_allclose(middles(axes)[:n], (particles.points - [0.05, 0]) * 1e3, atol=1e-9)
    values, stress = axes.collections[0].get_array(), particles.point_fields["stress_xx"]
    np.testing.assert_allclose(values[:n] / values[0], stress / stress[0])
    np.testing.assert_array_equal(values[n:], values[:n])


def test_a_model_of_both_halves_is_not_mirrored(refined_result, tmp_path):
    file = shutil.copy(refined_result, tmp_path / "line.h5")
    with h5py.File(file, "a") as result:
        text = result["input/namelist"].asstr()[()].replace("kind = 'symmetry'", "kind = 'line'")
        del result["input/namelist"]
        result["input/namelist"] = text
    half, whole = (middles(figure_of([name]).axes[0]) for name in (file, refined_result))
    n = len(whole) // 2
    assert n == len(Frames(file).block("particles", -1).points) and np.all(whole[:n, 1] > 0) and np.all(half[:, 1] > 0)


def distance_to(start, end, points):
    """Of points from a line with two ends."""
    along = np.subtract(end, start)
    part = np.clip((points - start) @ along / (along @ along), 0, 1)
    return np.linalg.norm(points - start - part[:, None] * along, axis=1)


def whole_squares(axes):
    """Middles of the squares with four corners."""
    return np.array([path.vertices[:4].mean(axis=0) for path in axes.collections[0].get_paths() if len(path.vertices) == 5])


def test_a_picture_in_the_coordinates_of_the_scene(vertical_crack):
    axes = figure_of([vertical_crack], "--axes", "scene", "--window", "4").axes[0]
    points = Frames(vertical_crack).block("particles", -1).points * 1e3
    far = points[distance_to([10, 0], [10, 5], points) > 1.2]  # the squares of others are cut at the crack
    found = whole_squares(axes)
    np.testing.assert_allclose(found[distance_to([10, 0], [10, 5], found) > 1.2], far, atol=1e-9)
    assert (axes.get_xlim(), axes.get_ylim()) == ((6, 14), (1, 9))
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("$x$ [mm]", "$y$ [mm]")
    np.testing.assert_allclose(axes.lines[0].get_xydata(), [[10, 5]], atol=1e-3)
    for face in axes.collections[2].get_segments():
        np.testing.assert_allclose([face[0], face[-1]], [[10, 0], [10, 5]], atol=1e-3)
    found = whole_squares(figure_of([vertical_crack]).axes[0])
    turned = np.column_stack([far[:, 1] - 5, 10 - far[:, 0]])
    np.testing.assert_allclose(found[distance_to([-5, 0], [0, 0], found) > 1.2], turned, atol=1e-9)


def colour_at(axes, place):
    """The value of the uppermost outline over a place; NaN where there is none."""
    values = axes.collections[0].get_array()
    over = [k for k, path in enumerate(axes.collections[0].get_paths()) if path.contains_point(place)]
    return values[over[-1]] if over else np.nan


def test_colours_end_at_the_faces_and_the_crack_opens(slanted_crack, tmp_path):
    """Beside the closed crack stands the colour of a particle of that side, and beside the open one; in it nothing is drawn."""
    start, end = np.array([-4.1, -1.3]), np.array([3.7, 2.2])
    along = (end - start) / np.linalg.norm(end - start)
    left = np.array([-along[1], along[0]])
    file = shutil.copy(slanted_crack, tmp_path / "numbered.h5")
    with h5py.File(file, "a") as result:  # what refinement has divided shares a number
        result["VTKHDF/particles/PointData/id"][:] = np.arange(result["VTKHDF/particles/PointData/id"].size)
    particles = Frames(file).block("particles", -1)
    began = (particles.points - particles.point_fields["displacement"][:, :2]) * 1e3
    height = dict(zip(particles.point_fields["id"].astype(int), (began - start) @ left))
    axes = figure_of([file], "--field", "id").axes[0]
    for way in np.linspace(0.05, 0.95, 25):
        for side in (1, -1):
            assert height[int(colour_at(axes, start + way * (end - start) + 0.02 * side * left))] * side > 0
    axes = figure_of([file], "--field", "id", "--scale", "5000").axes[0]
    faces = axes.collections[2].get_segments()
    gap = np.linalg.norm(faces[0] - faces[1], axis=1)
    n = len(gap)
    assert gap[0] == gap[-1] == 0 and gap[n // 2] > 0.2 and gap[n // 2] > 1.5 * max(gap[1], gap[-2])
    for k in range(n // 4, 3 * n // 4):
        assert np.isnan(colour_at(axes, (faces[0][k] + faces[1][k]) / 2))
        for face, sign in ((faces[0], 1), (faces[1], -1)):
            assert height[int(colour_at(axes, face[k] + 0.05 * sign * left))] * sign > 0
    tips = axes.lines[0].get_xydata()
    np.testing.assert_allclose(tips[:2], [faces[0][0], faces[0][-1]])
    assert len(tips) == 3


def test_the_squares_around_a_slanted_crack_are_turned_with_it(slanted_crack):
    """By --axes crack the crack lies along the axis; the picture has the same area."""
    there, here = (figure_of([slanted_crack], *words).axes[0] for words in ([], ["--axes", "crack", "--tip", "2"]))
    np.testing.assert_allclose(here.collections[2].get_segments()[0][:, 1], 0, atol=1e-3)
    assert here.get_xlabel() == "ahead of the tip [mm]" and there.get_xlabel() == "$x$ [mm]"
    for one, other in zip(there.collections[0].get_paths(), here.collections[0].get_paths()):
        assert area(one.vertices) == pytest.approx(area(other.vertices))


def test_no_label_is_cut_off(refined_result, slanted_crack, stretched):
    """Those of flat bodies neither."""
    for file in (refined_result, slanted_crack, stretched):
        figure = figure_of([file], "--field", "stress_xx")
        figure.draw_without_rendering()
        for axes in figure.axes:
            for label in (axes.xaxis.label, axes.yaxis.label, axes.title):
                box = label.get_window_extent()
                assert box.x0 >= 0 and box.y0 >= 0 and box.x1 <= figure.bbox.width and box.y1 <= figure.bbox.height, label


@pytest.mark.parametrize(("name", "stretch"), [("stretched", 2.0), ("stretched_updated", 1.3)])
def test_particles_that_are_stretched_leave_no_stripes(request, name, stretch):
    """Each place between two particles that are neighbours at the start is in the square of one of them."""
    file = request.getfixturevalue(name)
    particles = Frames(file).block("particles", -1)
    moved, first = particles.points, particles.points - particles.point_fields["displacement"][:, :2]
    assert np.ptp(moved[:, 0]) > 0.95 * stretch * np.ptp(first[:, 0])
    paths = figure_of([file], "--field", "stress_xx").axes[0].collections[0].get_paths()
    for shift in ([0.5e-3, 0], [0, 0.5e-3], [0.5e-3, 0.5e-3]):
        for k, place in enumerate(first):
            other = np.flatnonzero(np.linalg.norm(first - place - shift, axis=1) < 1e-6)
            if other.size:
                between = 1e3 * (moved[k] + moved[other[0]]) / 2
                assert any(path.contains_point(between, radius=1e-9) for path in paths), between
    sides = np.array([np.ptp(path.vertices, axis=0) for path in paths])
    assert np.median(sides[:, 0] / sides[:, 1]) > 0.85 * stretch


def test_old_files_have_squares(refined_result, tmp_path):
    """Without a deformation gradient."""
    file = shutil.copy(refined_result, tmp_path / "old.h5")
    with h5py.File(file, "a") as result:
        del result["VTKHDF/particles/PointData/deformation_gradient"]
    corners = figure_of([file]).axes[0].collections[0].get_paths()[0].vertices[:4]
    assert np.ptp(corners[:, 0]) == pytest.approx(np.ptp(corners[:, 1]))


def test_a_crack_is_drawn_within_the_body(notched):
    """It begins 0.9 mm above it."""
    crack, = Frames(notched).cracks()
    assert crack.points[:, 1].max() == pytest.approx(12.9e-3)
    lines = np.concatenate(figure_of([notched]).axes[0].collections[2].get_segments())
    assert 11.5 < np.nanmax(lines[:, 1]) < 12.01


def area(outline):
    x, y = outline.T
    return abs(np.sum(x[:-1] * y[1:] - x[1:] * y[:-1])) / 2


def test_each_window_is_around_its_tip(vertical_crack, refined_result):
    *panels, _ = figure_of([vertical_crack, refined_result], "--axes", "scene", "--window", "4").axes
    assert [(axes.get_xlim(), axes.get_ylim()) for axes in panels] == [((6, 14), (1, 9)), ((46, 54), (-4, 4))]


def field_of(name, plane, law="a"):
    scene = StoredModel(f"&run\n   plane = '{plane}'\n/\n&body\n   material = '{law}'\n/\n{MATERIAL}{RUBBER}", "a.h5")
    return ParticleField(SimpleNamespace(scene=scene, path="a.h5"), name)


def particles_under(xx, yy, xy):
    return Block(np.zeros((1, 2)), None, {"stress_xx": np.array([xx]), "stress_yy": np.array([yy]), "stress_xy": np.array([xy]),
                                          "body": np.array([1.0])}, {})


@pytest.mark.parametrize("plane, stress, mean, mises", [
    ("stress", (3.0, 0.0, 0.0), 1.0, 3.0),                # a bar
    ("stress", (0.0, 0.0, 2.0), 0.0, 2 * np.sqrt(3)),     # shear
    ("stress", (2.0, 2.0, 0.0), 4 / 3, 2.0),              # the same in both directions
    ("strain", (2.0, 2.0, 0.0), 5 / 3, 1.0)])             # the third component is 0.25 * 4
def test_mean_and_equivalent_stress(plane, stress, mean, mises):
    for name, value in [("mean_stress", mean), ("von_mises", mises)]:
        assert field_of(name, plane).values(particles_under(*stress), None) == pytest.approx(value)


def test_stress_normal_to_the_plane_is_not_guessed():
    field_of("von_mises", "stress", "b").values(particles_under(1.0, 0.0, 0.0), None)
    with pytest.raises(ResultError, match="linear elastic bodies without eigenstrain alone"):
        field_of("von_mises", "strain", "b").values(particles_under(1.0, 0.0, 0.0), None)


def test_level_is_that_of_the_cell(refined_result):
    figure = figure_of([refined_result], "--field", "level")
    result = Frames(refined_result)
    values, leaves = figure.axes[0].collections[0].get_array(), result.leaves(3)
    for level in (0, 1, 2):
        assert np.count_nonzero(values == level) == 2 * leaves.particles[leaves.level == level].sum() > 0
    assert [label.get_text() for label in figure.axes[-1].get_xticklabels()] == ["0", "1", "2"]  # of a flat picture, below it


def scale_of(name, values, *words, areas=None):
    """The scale of colours of these values."""
    seen = SimpleNamespace(values=np.array(values, dtype=float), areas=np.ones(len(values)) if areas is None else np.array(areas))
    return colours(field_of(name, "stress"), seen, plot_field.parse(["a.h5", *words]))


def test_colours_are_symmetric_about_zero_for_fields_with_a_sign():
    assert scale_of("stress_xx", [-2e3, 1e3]).norm.vmin == -scale_of("stress_xx", [-2e3, 1e3]).norm.vmax == -2
    assert scale_of("stress_xx", [0, 2e3])[2:] == (1e-3, "kPa", "neither") and scale_of("stress_xx", np.zeros(3)).norm.vmax > 0
    norm = scale_of("energy_density", [0, 1e-9, 1.0, 1.0], "--log").norm
    assert norm.vmax / norm.vmin == pytest.approx(10**DECADES)


def test_a_scale_of_colours_cuts_no_region():
    """Three times the nominal stress at a hole is shown; 20 times at a tip is not, which stands in cells of a small part of the area."""
    assert (scale_of("stress_xx", [1e3] * 500 + [3e3]).norm.vmax, scale_of("stress_xx", [1e3] * 500 + [3e3]).extend) == (3, "neither")
    tip = scale_of("stress_xx", [1e3] * 500 + [20e3] * 100, areas=[1] * 500 + [0.9 * MOST_CUT * 5] * 100)
    assert (tip.norm.vmax, tip.extend) == (1, "max")
    assert scale_of("stress_xx", [1e3] * 500 + [20e3] * 100).norm.vmax == 20
    asked = scale_of("stress_xx", [-5e3, 1e3], "--limits=-2e3,0")
    assert (asked.norm.vmin, asked.norm.vmax, asked.extend) == (-2, 0, "both")


CRACK = np.array([[[-1.0, 0.1], [1.0, 0.3]]])


def test_linear_fields_are_exact_up_to_edges_and_cracks():
    """Particles at odd places, and a field that jumps at a crack: its own function on either side, beyond the last particles too."""
    places = np.random.default_rng(1).uniform(-1, 1, (400, 2))
    above = places[:, 1] > 0.2 + 0.1 * places[:, 0]
    of = (lambda x: 3 + 2 * x[..., 0] - x[..., 1], lambda x: -5 + x[..., 0] + 4 * x[..., 1])
    values, width = np.where(above, of[1](places), of[0](places)), np.full(400, 0.1)
    pairs = pairs_of(places, width, np.ones(400), CRACK, np.full(400, True))
    assert np.all(above[pairs[0]] == above[pairs[1]]) and len(pairs[0]) > 6 * 400
    smooth = Smooth(places, width, values[:, None], pairs)
    at = places[:, None] + [[0, 0], [0.05, 0.05], [-0.03, 0.04]]
    np.testing.assert_allclose(smooth.at(at, np.arange(400))[0][..., 0], np.where(above[:, None], of[1](at), of[0](at)), atol=1e-6)


def test_a_crack_parts_particles_of_two_sizes():
    """Of which one is so small that the crack is not near it."""
    places, width = np.array([[0.0, 0.3], [0.1, -0.2], [0.3, 0.3]]), np.array([0.125, 0.25, 0.125])
    one, other = pairs_of(places, width, np.ones(3), np.array([[[-1.0, 0.0], [1.0, 0.0]]]), np.array([False, True, False]))
    assert [(int(a), int(b)) for a, b in zip(one, other) if a < b] == [(0, 2)]


@pytest.mark.parametrize("places", [np.zeros((1, 2)), np.array([[0, 0], [1, 0], [2, 0.0]])])
def test_few_particles_and_those_in_a_line_have_their_values(places):
    n = len(places)
    smooth = Smooth(places, np.ones(n), np.arange(n)[:, None], pairs_of(places, np.ones(n), np.ones(n), CRACK, np.full(n, False)))
    np.testing.assert_allclose(smooth.at(places[:, None] + [[[0, 0], [0, 0.4]]], np.arange(n))[0][..., 0], np.arange(n)[:, None] * [1, 1], atol=1e-8)


def shown_at(figure, places):
    """Colours of a figure at places of its first axes."""
    stream = BytesIO()
    figure.savefig(stream, dpi=200)
    stream.seek(0)
    image = matplotlib.image.imread(stream, format="png")[::-1, :, :3]
    column, row = (figure.axes[0].transData.transform(places) * 200 / figure.dpi).astype(int).T
    return image[row, column]


def test_a_body_is_filled_to_its_outline_and_not_beyond(run_hampm, tmp_path):
    """A plate with a round hole, of cells that fit neither."""
    (tmp_path / "hole.nml").write_text("""&run plane = 'stress'  end_time = 1.0 /
&grid lower = 0.0, 0.0  cell = 1.3e-3  cells = 16, 16 /
&material name = 'a'  young = 70e9  poisson = 0.3  density = 2700 /
&body material = 'a'  lower = 0.7e-3, 0.8e-3  upper = 18.6e-3, 18.9e-3 /
&body shape = 'circle'  hole = .true.  center = 9.1e-3, 10.2e-3  radius = 4.3e-3 /
&load kind = 'traction'  lower = 18.6e-3, 0.8e-3  upper = 18.6e-3, 18.9e-3  force = 1e6, 0.0 /
&constraint lower = 0.0, 0.0  upper = 1.3e-3, 20.8e-3  fix = 'xy' /
&method time = 'static' /
&output snapshot_interval = 1.0 /
""")
    done = run_hampm("hole.nml", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    figure = smooth_figure([tmp_path / "hole.h5"], "--field", "von_mises")
    turns = np.linspace(0, 2 * np.pi, 60)
    ways = np.column_stack([np.cos(turns), np.sin(turns)])
    edge = [[0.8, 5], [0.8, 15], [18.5, 5], [5, 0.9], [15, 18.8], [0.8, 0.9], [18.5, 18.8]]
    inside = np.concatenate([[9.1, 10.2] + 4.4 * ways, edge])
    outside = np.concatenate([[9.1, 10.2] + 4.2 * ways, edge + np.where(np.array(edge) < 1, -0.2, np.where(np.array(edge) > 18, 0.2, 0))])
    assert not np.any(np.all(shown_at(figure, inside) > 0.99, axis=1)) and np.all(shown_at(figure, outside) > 0.95)


def test_a_smooth_field_is_torn_at_a_crack_alone(slanted_crack):
    """Colours beside the faces are those of their side; the open crack is empty, and outlines stand around the body."""
    axes = smooth_figure([slanted_crack], "--field", "stress_yy", "--scale", "5000").axes[0]
    left, right = axes.collections[2].get_segments()[:2]
    middle = (left + right) / 2
    n = len(left)
    colours = shown_at(axes.figure, middle[n // 3:2 * n // 3])
    assert np.all(colours > 0.99)
    way = (left - right) / np.linalg.norm(left - right, axis=1)[:, None]
    for face, sign in ((left, 1), (right, -1)):
        assert not np.any(np.all(shown_at(axes.figure, (face + 0.3 * sign * way)[n // 3:2 * n // 3]) > 0.99, axis=1))
    outline, = (path.vertices for path in axes.collections[3].get_paths())
    assert np.nanmax(np.abs(outline)) > 12 and np.count_nonzero(np.isnan(outline[:, 0])) == 1      # at the mouth of the kinked crack
