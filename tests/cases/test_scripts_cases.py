"""Pictures show all material, and sweeps take every key."""

import re

import numpy as np
import pytest

import animate
import plot_field
from frames import Frames
from paths import CHECKED_PROGRAM, PROGRAM, ROOT

COARSE = ("grid.cell=1e-3", "run.end_time=4e-5", "output.history_interval=1e-5", "output.snapshot_interval=2e-5")


@pytest.fixture(params=[("0.0,-10.0", "100,6"), ("0.0,15.0", "100,4")], ids=["downwards", "upwards"])
def bent(request, case):
    """The beam, some of which has left the grid at its lower edge, or as a sister at its upper one."""
    velocity, cells = request.param
    settings = (*COARSE, f"constraint(2).velocity={velocity}", f"grid.cells={cells}")
    run = case("picture_loses_particles", *(word for setting in settings for word in ("--set", setting)), program=PROGRAM) # the pictures are looked at
    assert run.code == 0, run.stderr
    points = Frames(run.path).block("particles", -1).points
    assert np.any((points[:, 1] < 0) | (points[:, 1] > 1e-3 * int(cells.partition(",")[2]))), "nothing has left the grid"
    return run.path


def assert_all_are_drawn(axes, path, scale):
    """Each particle is in a square, and all squares are within the axes. The crack is along x, its tip at 60 mm, half way up."""
    particles = Frames(path).block("particles", -1)
    places = 1e3 * (particles.points + (scale - 1) * particles.point_fields["displacement"][:, :2] - [60e-3, 2e-3])
    outlines = [outline.vertices for outline in axes.collections[0].get_paths()]
    lower, upper = (np.array([extreme(outline, axis=0) for outline in outlines]) for extreme in (np.min, np.max))
    assert np.all(upper > lower), "a square of no size"
    for place in places:
        assert np.any(np.all((lower <= place) & (place <= upper), axis=1)), place
    (left, right), (bottom, top) = axes.get_xlim(), axes.get_ylim()
    assert left <= lower[:, 0].min() and upper[:, 0].max() <= right and bottom <= lower[:, 1].min() and upper[:, 1].max() <= top


def test_pictures_show_what_has_left_the_grid(bent):
    """In the total frame a particle belongs to the cell in which it began, wherever it is."""
    figure = plot_field.draw([Frames(bent)], plot_field.parse([str(bent), "--scale", "3", "--squares", "1.06"]))
    assert_all_are_drawn(figure.axes[0], bent, 3)
    film = animate.Film(Frames(bent), animate.parse([str(bent), "--squares", "1.06"]))
    film.show(Frames(bent).times.size - 1)
    assert_all_are_drawn(film.figure.axes[0], bent, film.canvas.scale)
    plot_field.plt.close("all")


def test_a_sweep_takes_every_key(run_hampm, tmp_path):
    """Those of &growth too, which the template has as a comment: "sweep_of_growth" has 6 toughnesses times 5 rise times. The keys of a sweep are those
    of `--set`, which names an unknown one."""
    from hampm.batch.declaration import namelist_keys, read_sweep
    sweep = read_sweep(ROOT / "tests/cases/sweep_of_growth.yaml", CHECKED_PROGRAM)
    assert len(sweep.cases) == 30 and sweep.keys == ["growth.toughness", "load(1).rise_time", "load(2).rise_time"]
    words = [word for key, value in list(sweep.cases.values())[-1].items() for word in ("--set", f"{key}={value}")]
    assert run_hampm("--check", sweep.namelist, *words, cwd=tmp_path, program=CHECKED_PROGRAM).returncode == 0
    keys = [f"{group}.{key}" for group, known in namelist_keys(CHECKED_PROGRAM).items() for key in known]
    reference = run_hampm("--keys", cwd=tmp_path, program=CHECKED_PROGRAM).stdout
    assert len(keys) == len(re.findall(r"^\| `", reference, re.MULTILINE)) > 120
    (tmp_path / "empty.nml").write_text("! nothing\n")
    settings = [word for key in [*keys, "growth.toughnes"] for word in ("--set", f"{key}=1")]
    said = run_hampm("--check", "empty.nml", *settings, cwd=tmp_path, program=CHECKED_PROGRAM).stderr
    assert [line for line in said.splitlines() if "has no key" in line or "no group" in line] == [line for line in said.splitlines() if "toughnes=1" in line]
