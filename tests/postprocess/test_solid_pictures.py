"""Pictures of solids: their surface and slices, what moves them, mistakes named."""

import subprocess

import h5py
import numpy as np
import pytest

import animate
import plot_field
import plot_mesh
import report
import solid_pictures
from frames import Frames, frames_of
from history import ResultError
from paths import SOLID_PROGRAM
from pictures import MM

from hampm.stored_model import StoredModel

pytestmark = pytest.mark.skipif(not SOLID_PROGRAM.exists(), reason="make program dim=3 makes it")

SIZE = np.array([0.3, 0.1, 0.15])
FORCE, YOUNG, POISSON = 3e4, 200e9, 0.3
BAR = """
&run title = 'bar'  end_time = 1.0 /
&grid lower = -0.05, -0.05, -0.05  cell = 0.05  cells = 8, 4, 5 /
&material name = 'a'  young = 200e9  poisson = 0.3  density = 7800.0 /
&body material = 'a'  lower = 0.0, 0.0, 0.0  upper = 0.3, 0.1, 0.15 /
&constraint lower = 0.0, 0.0, 0.0  upper = 0.0, 0.1, 0.15  fix = 'x' /
&constraint lower = 0.0, 0.0, 0.0  upper = 0.3, 0.0, 0.15  fix = 'y' /
&constraint lower = 0.0, 0.0, 0.0  upper = 0.3, 0.1, 0.0  fix = 'z' /
&load kind = 'traction'  lower = 0.3, 0.0, 0.0  upper = 0.3, 0.1, 0.15  force = 3e4, 0.0, 0.0 /
&refine indicator = 'gradient'  field = 'energy_density'  r_crit = 1e-17  max_level = 2  region_lower = 0.1, 0.0, 0.0  region_upper = 0.15, 0.06, 0.06 /
&method time = 'static'  frame = 'total' /
&output snapshot_interval = 1.0 /
"""


@pytest.fixture(scope="module")
def bar(tmp_path_factory):
    """A bar in tension along x, with cells of three sizes; it strains the same everywhere."""
    folder = tmp_path_factory.mktemp("solid")
    (folder / "bar.nml").write_text(BAR)
    subprocess.run([SOLID_PROGRAM, "bar.nml", "--quiet"], cwd=folder, check=True, capture_output=True)
    return folder / "bar.h5"


def drawn(module, result, *arguments):
    return module.draw([frames_of(result)], module.parse([str(result), *arguments]))


def polygons(axes):
    return np.array([path.vertices[:4] for path in axes.collections[0].get_paths()])


def areas(polygons):
    a, b = polygons[:, 2] - polygons[:, 0], polygons[:, 3] - polygons[:, 1]
    return np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]) / 2


def test_the_surface_is_that_of_the_body(bar):
    """No side within it, none missing, with cells of three sizes; particles and cells."""
    result = frames_of(bar)
    for cubes in (result.cubes(1), result.cells(1)[0]):
        assert len(np.unique(cubes.size)) == 3
        number, axis, side = cubes.exposed()
        width = cubes.size[number] * cubes.unit
        for d in range(3):
            for of in (0, 1):
                chosen = (axis == d) & (side == of)
                assert np.sum(width[chosen] ** 2) == pytest.approx(np.prod(np.delete(SIZE, d)), rel=1e-12)
                places = cubes.places(cubes.sides(number[chosen], axis[chosen], side[chosen]))
                np.testing.assert_allclose(places[..., d], of * SIZE[d], atol=1e-12)
                normal = np.cross(places[:, 1] - places[:, 0], places[:, 2] - places[:, 1])
                assert np.all(normal[:, d] * (2 * of - 1) > 0)


def test_corners_move_with_the_material(bar):
    """u = strain times place, to rounding, on all sides."""
    result = frames_of(bar)
    cubes, particles = result.cubes(1), result.block("particles", 1)
    number, axis, side = cubes.exposed()
    corners = cubes.sides(number, axis, side)
    gradient = particles.point_fields["deformation_gradient"].reshape(-1, 3, 3) - np.eye(3)
    moved = cubes.moved(corners, number, particles.point_fields["displacement"], gradient)
    strain = FORCE / (YOUNG * SIZE[1] * SIZE[2]) * np.array([1, -POISSON, -POISSON])
    np.testing.assert_allclose(moved, strain * cubes.places(corners), atol=1e-9 * strain[0] * SIZE[0])


def test_values_along_a_front_are_in_tables_and_reports(bar, tmp_path, script):
    """Of a file that says so."""
    with h5py.File(bar) as old, h5py.File(tmp_path / "front.h5", "w") as new:
        for name in old:
            old.copy(name, new)
        count = new["history/time"].size
        for name, unit, values in (("history/G_mean", "J/m2", np.full(count, 2.5)), ("history/G_largest", "J/m2", np.full(count, 3.0)),
                                   ("front/G", "J/m2", np.tile([2.0, 3.0, 2.5], (count, 1))), ("front/arc", "m", np.tile([0.0, 0.1, 0.2], (count, 1)))):
            new[name] = values
            new[name].attrs["units"] = unit
    assert script("tabulate.py", tmp_path / "front.h5", "--csv").stdout.splitlines() == ["file,G_mean,G_largest", "front,2.5,3"]
    report.main([str(tmp_path / "front.h5"), "--dpi", "20", "-o", str(tmp_path / "front.html")])
    page = (tmp_path / "front.html").read_text()
    assert 'alt="G along the front"' in page and "2.5" in page and 'alt="G over time"' in page


def test_a_slice_is_as_large_as_the_body_is_there(bar):
    """Where a plane goes through particles, between them, and along a side."""
    for words, size in (("x=0.11", SIZE[[1, 2]]), ("y=0.05", SIZE[[0, 2]]), ("z=0", SIZE[[0, 1]]), ("z=0.15", SIZE[[0, 1]])):
        axes = drawn(plot_field, bar, "--slice", words, "--no-mesh").axes[0]
        found = polygons(axes)
        assert areas(found).sum() == pytest.approx(np.prod(size) * MM**2, rel=1e-4)
        np.testing.assert_allclose(np.ptp(found.reshape(-1, 2), axis=0), size * MM, rtol=1e-4)
        assert [axes.get_xlabel(), axes.get_ylabel()] == [f"${name}$ [mm]" for name in "xyz" if name != words[0]]


def test_what_is_seen_from_along_an_axis(bar):
    """The side of the body, doubled by its image; of a shear stress the image has the other sign; cells have their number in the title."""
    axes = drawn(plot_field, bar, "--view", "0,0", "--field", "speed", "--mirror", "y=0").axes[0]
    assert areas(polygons(axes)).sum() == pytest.approx(2 * SIZE[1] * SIZE[2] * MM**2, rel=1e-4)
    assert {text.get_text() for text in axes.texts} >= {"$x$", "$y$", "$z$"}
    view = solid_pictures.View(plot_field.parse([str(bar), "--mirror", "y=0"]))
    result = frames_of(bar)
    for name, is_odd in (("stress_xy", True), ("stress_yz", True), ("stress_xz", False), ("stress_yy", False)):
        _, values = solid_pictures.particle_polygons(result, plot_field.ParticleField(result, name), 1, view, 1.0)
        half, image = np.split(values, 2)
        np.testing.assert_array_equal(image, -half if is_odd else half)
    figure = drawn(plot_mesh, bar, "--view", "0,0")
    assert areas(polygons(figure.axes[0])).sum() == pytest.approx(SIZE[1] * SIZE[2] * MM**2, rel=1e-4)
    leaves = result.leaves(1)
    assert f"{np.count_nonzero((leaves.level == 2) & (leaves.particles > 0))} of level 2" in figure.axes[0].get_title()


@pytest.mark.verify
def test_pyvista_draws_the_same_surface(bar, tmp_path, capfd):
    pyvista = pytest.importorskip("pyvista", reason="PyVista is not installed: tools/setup.sh verify")
    words = [str(bar), "--pyvista", "--field", "von_mises", "--dpi", "30"]
    plot_field.main([*words, "-o", str(tmp_path / "bar.png")])
    picture = pyvista.read(tmp_path / "bar.png")
    assert picture.dimensions[:2] == (210, 136) and len(np.unique(np.asarray(picture.active_scalars), axis=0)) > 20
    for more, says in ((["-o", str(tmp_path / "bar.svg")], "as a .png"), (["--snapshot", "0", "--snapshot", "1"], "one file and snapshot")):
        with pytest.raises(ResultError, match=says):
            plot_field.main([*words, *more])


def test_fields_are_those_of_space(bar):
    result = frames_of(bar)
    particles, leaves = result.block("particles", 1), result.leaves(1)
    stress = FORCE / (SIZE[1] * SIZE[2])
    for name, value in (("von_mises", stress), ("mean_stress", stress / 3)):
        np.testing.assert_allclose(plot_field.ParticleField(result, name).values(particles, leaves), value, rtol=1e-9)


CRACKED = """
&run end_time = 1.0 /
&grid lower = -0.02, -0.02, -0.02  cell = 5e-3  cells = 8, 8, 8 /
&material name = 'steel'  young = 200e9  poisson = 0.3  density = 7800 /
&body material = 'steel'  lower = -0.015, -0.015, -0.015  upper = 0.015, 0.015, 0.015 /
&load kind = 'traction'  lower = -0.015, -0.015, 0.015  upper = 0.015, 0.015, 0.015  force = 0.0, 0.0, 1e5 /
&load kind = 'traction'  lower = -0.015, -0.015, -0.015  upper = 0.015, 0.015, -0.015  force = 0.0, 0.0, -1e5 /
&crack kind = 'plane'  normal = 'z'  front = 'disc'  center = 0.0, 0.015, 0.0  radii = 0.0101 /
&method time = 'static'  frame = 'total' /
&output snapshot_interval = 1.0 /
"""


def test_a_crack_inside_a_body_opens(tmp_path):
    """Its faces are surfaces, which move apart; its front is half a circle, as the centre of the disc is on a side."""
    (tmp_path / "cracked.nml").write_text(CRACKED)
    subprocess.run([SOLID_PROGRAM, "cracked.nml", "--quiet"], cwd=tmp_path, check=True, capture_output=True)
    result = frames_of(tmp_path / "cracked.h5")
    cubes, particles = result.cubes(1), result.block("particles", 1)
    number, axis, side = cubes.exposed()
    corners = cubes.sides(number, axis, side)
    within = (axis == 2) & (np.abs(cubes.places(corners)[..., 2]).max(axis=1) < 1e-9)
    area = {of: np.sum((cubes.size[number[within & (side == of)]] * cubes.unit) ** 2) for of in (0, 1)}
    assert area[0] == area[1] and area[0] == pytest.approx(np.pi * 0.0101**2 / 2, rel=0.35)     # by whole cubes
    gradient = particles.point_fields["deformation_gradient"].reshape(-1, 3, 3) - np.eye(3)
    moved = cubes.moved(corners, number, particles.point_fields["displacement"], gradient)[..., 2]
    at = np.all(np.isclose(cubes.places(corners), [0, 0.015, 0], atol=1e-9), axis=2) & within[:, None]
    upper, lower = (np.unique(moved[at & (side == of)[:, None]]) for of in (0, 1))
    assert np.ptp(upper) < 1e-15 and np.ptp(lower) < 1e-15 and upper[0] - lower[0] > 1e-7
    dot, = drawn(plot_field, tmp_path / "cracked.h5", "--slice", "x=0.0001").axes[0].lines
    np.testing.assert_allclose(dot.get_xydata(), [[15 - 10.1, 0]], atol=0.02)
    assert len(drawn(plot_field, tmp_path / "cracked.h5", "--mirror", "x=0.015").axes[0].lines) == 2
    front, = result.fronts(1)
    np.testing.assert_allclose(np.linalg.norm(front - [0, 0.015, 0], axis=1), 0.0101, rtol=1e-9)
    assert front[:, 1].max() < 0.0151 and np.ptp(front[:, 0]) == pytest.approx(0.0202, rel=1e-2)


def test_fronts_are_where_they_were_measured(tmp_path):
    """In snapshots of a crack with G along its front; one that is closed ends where it begins."""
    (tmp_path / "cracked.nml").write_text(CRACKED.replace("0.0, 0.015, 0.0", "0.0, 0.0, 0.0").replace("0.0101", "0.007").replace("5e-3  cells = 8, 8, 8", "2.5e-3  cells = 16, 16, 16") +
                                          "&energy_release estimators = 'domain_integral' /\n&refine indicator = 'tip'  max_level = 1 /\n")
    subprocess.run([SOLID_PROGRAM, "cracked.nml", "--quiet"], cwd=tmp_path, check=True, capture_output=True)
    result = frames_of(tmp_path / "cracked.h5")
    front, = result.fronts(1)
    np.testing.assert_array_equal(front[0], front[-1])
    np.testing.assert_allclose(np.linalg.norm(front, axis=1), 0.007, rtol=0.02)
    assert result.blocks == ("particles", "mesh", "fronts") and "G" in result.to_xarray("fronts")


def test_boxes_around_bodies_of_any_shape():
    text = "&grid\n   cells = 9, 9, 9\n/\n&body\n   shape = '{}'\n   lower = 0, 0, 0\n   upper = 0, 0, 4\n   center = 1, 2, 3\n   radius = 1\n/\n"
    for shape, box in (("cylinder", [[-1, -1, 0], [1, 1, 4]]), ("sphere", [[0, 1, 2], [2, 3, 4]]), ("rectangle", [[0, 0, 0], [0, 0, 4]])):
        np.testing.assert_allclose(np.array(StoredModel(text.format(shape), "").bodies())[:, 0], box)


def test_films_and_reports_have_solids(bar, tmp_path):
    animate.main([str(bar), "--dpi", "30", "-o", str(tmp_path / "bar.gif")])
    report.main([str(bar), "--dpi", "30", "-o", str(tmp_path / "bar.html")])
    page = (tmp_path / "bar.html").read_text()
    assert (tmp_path / "bar.gif").stat().st_size > 0 and "Last snapshot" in page and "holds no snapshots" not in page


@pytest.mark.parametrize(("arguments", "says"), [
    (["--window", "3"], "--window is for pictures of planes"), (["--squares", "2"], "--squares is for pictures of planes"),
    (["--slice", "x=0.31"], "the plane x = 0.31 m cuts no material; it is between 0 and 0.3 m")])
def test_mistakes_are_named(bar, arguments, says):
    with pytest.raises(ResultError, match=says):
        drawn(plot_field, bar, *arguments)
    with pytest.raises(SystemExit):
        plot_field.parse([str(bar), "--slice", "w=1"])


def test_each_kind_of_result_has_its_own_options(bar, refined_result):
    with pytest.raises(ResultError, match="--slice is for pictures of solids"):
        drawn(plot_field, refined_result, "--slice", "x=0.1")
    with pytest.raises(ResultError, match="not drawn in one picture"):
        plot_field.draw([frames_of(bar), frames_of(refined_result)], plot_field.parse([str(bar), str(refined_result)]))
    with pytest.raises(ResultError, match="is a result of the program for solids"):
        Frames(bar)
