"""The limit of the time step that the program names is that of the run: below it nothing grows, above it everything does."""

import itertools
import re
import sys

import numpy as np
import pytest

from harness import run
from paths import BENCH, PROGRAM

sys.path.insert(0, str(BENCH))

from mass_theory import Block  # noqa: E402

MASSES = {"lumped": "", "consistent": "mass = 'consistent'", "fmpm 2": "mass = 'fmpm'", "fmpm 5": "mass = 'fmpm' order = 5",
          "weighted 0.25": "mass = 'weighted' lumped_fraction = 0.25", "weighted 0.7": "mass = 'weighted' lumped_fraction = 0.7"}

# Loads at places without symmetry set in at once, and move all modes of the block by about the same.
SCENE = """\
&run plane = '{plane}' end_time = {end} /
&grid cell = 1.0 cells = 12, 12 order = {order} /
&material name = 'm' young = 1.0 poisson = {poisson} density = 1.0 /
&body material = 'm' lower = {lower} upper = {upper} points_per_cell = {points} /
&load kind = 'point' lower = {near} upper = {near} force = 1e-6, 3e-7 /
&load kind = 'point' lower = {far} upper = {far} force = -4e-7, 8e-7 /
&method scheme = '{scheme}' frame = '{frame}' {mass} courant = {courant} {more} /
&output file = 'case.h5' history_interval = {interval} /
"""


REFINED = """\
&crack kind = 'line' tip = 6.0, 6.0 direction = 1.0, 0.0 length = 4.0 /
&refine indicator = 'tip' max_level = {} rings = {} /
&energy_release estimators = 'vcct' /
"""


def scene(steps=400, step=1.0, lower=(2.0, 2.0), size=(8.0, 8.0), refined=None, **keys):
    """A block; lengths and times are in cells of size 1 and with Young's modulus and density 1. `refined`: levels and rings around the tip of a
    crack, where steps are in finest cells."""
    step *= 0.5 ** (refined[0] if refined else 0)
    upper = [a + b for a, b in zip(lower, size)]

    def text(x):
        return ", ".join(map(repr, x))
    keys = {"order": 1, "plane": "strain", "poisson": 0.3, "points": 2, "scheme": "musl", "frame": "total", "mass": "", "courant": 0.0,
            "more": ""} | keys
    return SCENE.format(end=steps * step, interval=steps * step / 8, lower=text(lower), upper=text(upper),
                        near=text([a + 0.03 for a in lower]), far=text([a + 0.71 * b for a, b in zip(lower, size)]), **keys) + (REFINED.format(*refined) if refined else "")


def named_limit(hampm, folder, **keys):
    """The largest courant number, as a scene is told that asks for more."""
    (folder / "case.nml").write_text(scene(**keys, courant=10.0))
    result = hampm("--check", "case.nml", cwd=folder)
    assert result.returncode == 2, result.stdout
    return float(re.search(r"&method courant = 10\.0: must be at most (\S+), not 10\.0, with wave_speed", result.stderr)[1])


def survives(hampm, folder, courant, **keys):
    """Whether a run with a courant number, allowed or not, comes to its end."""
    poisson = keys.get("poisson", 0.3)
    step = courant * (2 * (1 + poisson)) ** 0.5
    (folder / "case.nml").write_text(scene(**keys, step=step))
    result = hampm(repr(courant), "case.nml", "--force", "--quiet", program=PROGRAM.parent / "forced_step", cwd=folder)
    assert result.returncode in (0, 3), result.stderr
    return result.returncode == 0


def check_limit(hampm, folder, above, **keys):
    limit = named_limit(hampm, folder, **keys)
    assert survives(hampm, folder, 0.98 * limit, **keys), limit
    assert not survives(hampm, folder, above * limit, **keys), limit


@pytest.mark.parametrize(("plane", "poisson"), [("strain", 0.0), ("strain", 0.33), ("strain", 0.45), ("stress", 0.4)])
@pytest.mark.parametrize("mass", MASSES)
def test_limit_of_each_mass_matrix(hampm, tmp_path, mass, plane, poisson):
    for scheme, points in itertools.product(("musl", "usl"), (2, 3)):
        check_limit(hampm, tmp_path, 1.03, plane=plane, poisson=poisson, mass=MASSES[mass], scheme=scheme, points=points)


@pytest.mark.parametrize("scheme", ["usf", "usavg"])
@pytest.mark.parametrize("frame", ["updated", "total"])
def test_limit_of_other_schemes_and_frames(hampm, tmp_path, scheme, frame):
    check_limit(hampm, tmp_path, 1.03, scheme=scheme, frame=frame)


@pytest.mark.parametrize(("lower", "size"), [((2.0, 2.0), (8.0, 1.0)), ((2.0, 2.0), (2.0, 2.0)), ((2.3, 2.1), (7.0, 7.2)),
                                             ((2.3, 2.4), (0.5, 4.0)), ((2.25, 2.0), (6.0, 6.0))])
@pytest.mark.parametrize("mass", ["lumped", "consistent", "weighted 0.25"])
def test_limit_of_thin_bodies_and_of_bodies_anywhere_in_their_cells(hampm, tmp_path, mass, lower, size):
    check_limit(hampm, tmp_path, 1.03, lower=lower, size=size, mass=MASSES[mass])


@pytest.mark.parametrize(("points", "keys"), [(3, {"poisson": 0.0}), (3, {"poisson": 0.45}), (4, {"plane": "stress"}), (3, {"size": (1.0, 1.0)}),
                                             (3, {"size": (5.0, 1.0)})])
@pytest.mark.parametrize("scheme", ["musl", "usf", "usavg", "usl"])
def test_limit_of_quadratic_cells(hampm, tmp_path, scheme, points, keys):
    check_limit(hampm, tmp_path, 1.03, order=2, scheme=scheme, points=points, **keys)


@pytest.mark.parametrize(("points", "keys"), [(3, {"poisson": 0.0}), (4, {"poisson": 0.45}), (3, {"size": (5.0, 1.0), "plane": "stress"})])
@pytest.mark.parametrize("mass", [mass for mass in MASSES if mass != "lumped"])
def test_limit_of_quadratic_cells_with_other_mass_matrices(hampm, tmp_path, mass, points, keys):
    for scheme in ("musl", "usl"):
        check_limit(hampm, tmp_path, 1.03, order=2, mass=MASSES[mass], scheme=scheme, points=points, **keys)


@pytest.mark.parametrize(("levels", "rings", "points"), [(2, 1, 3), (2, 2, 4)])
@pytest.mark.parametrize("mass", MASSES)
def test_limit_of_quadratic_cells_of_several_sizes(hampm, tmp_path, mass, levels, rings, points):
    """Around the tip of a crack, against the limit of uniform cells of the finest size: `usl` has 0.8 of it where cells refine, as bilinear cells of
    several sizes want it with other mass matrices than the lumped one."""
    for scheme in ("musl", "usl"):
        keys = {"order": 2, "mass": MASSES[mass], "scheme": scheme, "points": points, "poisson": 0.3}
        part = 0.8 if scheme == "usl" and mass != "lumped" else 1
        uniform, limit = named_limit(hampm, tmp_path, **keys), named_limit(hampm, tmp_path, refined=(levels, rings), **keys)
        assert limit == pytest.approx(part * uniform, rel=0.01)
        assert survives(hampm, tmp_path, 0.98 * uniform, refined=(levels, rings), **keys), uniform
        assert not survives(hampm, tmp_path, 2 * uniform, refined=(levels, rings), **keys), uniform


@pytest.mark.parametrize(("lower", "size", "points"), [((2.1, 2.0), (7.25, 7.4), 2), ((2.0, 2.0), (8.25, 7.9), 2), ((2.5, 2.5), (7.5, 7.4), 2),
                                                       ((2.1, 2.0), (7.75, 7.9), 4)])
@pytest.mark.parametrize("mass", MASSES)
@pytest.mark.parametrize("scheme", ["musl", "usl"])
def test_limit_of_finer_cells_that_the_lattice_does_not_fit(hampm, tmp_path, scheme, mass, lower, size, points):
    """Finer cells have particles at other places: what leapfrog schemes lose by these, most with the lumped matrix and two points."""
    keys = {"scheme": scheme, "mass": MASSES[mass], "poisson": 0.0, "lower": lower, "size": size, "points": points}
    lattice, levels = named_limit(hampm, tmp_path, **keys), [(1, 2), (3, 3)]
    for refined in levels:
        limit = named_limit(hampm, tmp_path, refined=refined, **keys)
        assert limit <= lattice
        assert survives(hampm, tmp_path, 0.98 * limit, refined=refined, **keys), limit
    if (scheme, mass, points) == ("musl", "lumped", 2):  # that of the lattice in large cells is too much
        assert not all(survives(hampm, tmp_path, 0.98 * lattice, refined=refined, **keys) for refined in levels), lattice


@pytest.mark.parametrize(("scheme", "mass", "points", "x"), [("usavg", "consistent", 4, 0.8), ("musl", "consistent", 3, 0.72), ("usl", "lumped", 4, 0.85), ("usl", "consistent", 2, 0.6),
                                                             ("usl", "fmpm 5", 3, 0.72), ("usl", "weighted 0.25", 5, 0.85), ("usl", "consistent", 8, 0.9)])
def test_limit_of_slivers_beside_a_crack(hampm, tmp_path, scheme, mass, points, x):
    """Pieces of cells with one column of particles, whose nodes beyond the crack have next to no mass, allow less than any other pieces."""
    keys = {"scheme": scheme, "points": points, "mass": MASSES[mass], "more": f"/ &crack kind = 'path'  points = {5 + x}, 3.3, {5 + x}, 7.6"}
    limit, whole = named_limit(hampm, tmp_path, **keys), named_limit(hampm, tmp_path, **keys | {"more": ""})
    assert limit < 0.75 * whole
    assert survives(hampm, tmp_path, 0.98 * limit, **keys), limit
    assert not survives(hampm, tmp_path, 1.15 * limit, **keys), limit


@pytest.mark.parametrize(("poisson", "courant"), [(0.33, 0.85), (0.35, 0.80), (0.40, 0.75)])
def test_nearly_incompressible_material_is_not_taken_beyond_its_limit(hampm, tmp_path, poisson, courant):
    (tmp_path / "case.nml").write_text(scene(poisson=poisson, courant=courant))
    result = hampm("case.nml")
    assert result.returncode == 2
    assert f"case.nml:7: &method courant = {courant}: must be at most 0." in result.stderr
    assert not survives(hampm, tmp_path, courant, poisson=poisson)


@pytest.mark.parametrize("scheme", ["musl", "usl"])
@pytest.mark.parametrize("mass", MASSES)
@pytest.mark.parametrize(("order", "points"), [(1, 2), (2, 3), (2, 4)])
def test_limit_is_that_of_the_matrices(hampm, tmp_path, mass, scheme, order, points):
    """Against the eigenvalues of a step as a whole, from matrices that are built by themselves (bench/mass_theory.py): rounded down to
    three digits, but for the 2e-4 to which the limit of usl is searched there."""
    block, (kind, _, number) = Block(3, 2, 0.3, held_left=False, order=order, points=points), mass.partition(" ")
    number = float(number or 1)
    theory = block.limit(scheme, block.inverse(kind, order=int(number), lumped_fraction=number))
    named = named_limit(hampm, tmp_path, size=(3.0, 2.0), scheme=scheme, mass=MASSES[mass], order=order, points=points)
    theory /= (2 * 0.7 / 0.4) ** 0.5
    digit = 10 ** (np.floor(np.log10(named)) - 2)
    assert named - 3e-4 * theory < theory < named + digit + 3e-4 * theory


def test_default_is_a_safe_part_of_the_limit(hampm, tmp_path):
    limit = named_limit(hampm, tmp_path)
    (tmp_path / "case.nml").write_text(scene())
    chosen = re.search(r"courant = (\S+)", hampm("--check", "case.nml").stdout)[1]
    assert 0.89 * limit < float(chosen) <= 0.9 * limit


GRADED = """\
&run end_time = 6e-5 /
&grid lower = 0.0, -0.004{flat}  cell = {cell} /
&material name = 'm'  young = 70e9  poisson = 0.3  density = 2700.0 /
&body material = 'm'  lower = 0.0, -0.004{flat}  upper = 0.1, 0.004{thick}  profile_direction = 1.0, 0.0{zero}  profile_at = 0.0, 0.05, {end}, 0.1  {profile} /
&constraint lower = 0.1, -0.004{flat}  upper = 0.1, 0.004{thick}  fix = 'x' /
&load kind = 'traction'  lower = 0.0, -0.004{flat}  upper = 0.0, 0.004{thick}  force = -1e4, 0.0{zero}  history = 'smooth_ramp'  rise_time = 1e-5 /
&method scheme = '{scheme}' /
&energy_release energy_balance = .true. /
&output file = 'case.h5'  history_interval = 2e-6 /
"""
PROFILES = [(0.06, "profile_stiffness = 1.0, 1.0, 3.0, 3.0"), (0.06, "profile_density = 1.0, 1.0, 0.2, 0.2"),
            (0.051, "profile_stiffness = 1.0, 1.0, 100.0, 100.0  profile_density = 30.0, 30.0, 1.0, 1.0"),
            (0.051, "profile_stiffness = 1.0, 1.0, 1e3, 1e3  profile_density = 1.0, 1.0, 1e3, 1e3")]


@pytest.mark.parametrize("end, profile", PROFILES, ids=["stiff", "light", "both", "same speed"])
@pytest.mark.parametrize("scheme", ["musl", "usl"])
@pytest.mark.parametrize("dim", [2, 3])
def test_the_default_step_counts_the_fastest_place_of_a_graded_body(hampm, hampm3d, dim, scheme, end, profile):
    """The limit of a courant number is that of the material where waves are fastest, to which it refers."""
    flat, thick, zero, cell = (", -0.004", ", 0.004", ", 0.0", "0.004  cells = 25, 2, 2") if dim == 3 else ("", "", "", "0.002  cells = 50, 4")
    text = GRADED.format(flat=flat, thick=thick, cell=cell, zero=zero, end=end, profile=profile, scheme=scheme)
    rows = run(hampm3d if dim == 3 else hampm, text.replace("&run", "&run plane = 'stress' ") if dim == 2 else text)
    assert abs(rows["numerical_loss"]).max() < 0.03 * rows["external_work"].max()


SQUEEZED = """\
&run end_time = 0.022 /
&grid lower = -0.004, -0.012{flat}  cell = {cell} /
&material name = 'm'  law = '{law}'  young = 1e6  poisson = 0.3  density = 1000.0 /
&body material = 'm'  lower = 0.0, -0.004{flat}  upper = 0.02, 0.004{thick} /
&constraint lower = 0.0, -0.004{flat}  upper = 0.0, 0.004{thick}  fix = 'x' /
&constraint lower = 0.02, -0.004{flat}  upper = 0.02, 0.004{thick}  fix = 'x'  velocity = -0.5, 0.0{zero}  history = 'ramp'  rise_time = 0.0018333333333333333  name = 'plate' /
&constraint lower = 0.0, -0.004{flat}  upper = 0.02, -0.004{thick}  fix = 'y' /
&damping rate = 200.0 /
&method scheme = '{scheme}'  courant = {courant} /
&energy_release energy_balance = .true. /
&output file = 'case.h5'  history_interval = 0.00044 /
"""


@pytest.mark.parametrize("dim, scheme, law", [("strain", "musl", "neo_hookean"), ("strain", "usl", "neo_hookean"), ("strain", "musl", "mooney_rivlin"), (3, "musl", "neo_hookean"),
                                              (3, "usl", "mooney_rivlin"), ("axisymmetric", "musl", "neo_hookean"), ("axisymmetric", "usl", "mooney_rivlin")])
def test_the_default_step_counts_how_stiff_material_gets(hampm, hampm3d, dim, scheme, law):
    """A block that is squeezed to half of its length, or a cylinder to half of its radius: waves are 2.4 times as fast in the end. Short steps end with the same force."""
    flat, thick, zero, cell = (", -0.004", ", 0.004", ", 0.0", "0.004  cells = 7, 6, 4") if dim == 3 else ("", "", "", "0.002  cells = 13, 12")
    text = SQUEEZED.format(flat=flat, thick=thick, cell=cell, zero=zero, scheme=scheme, law=law + ("'  c01 = 0.4e5 !" if law == "mooney_rivlin" else ""), courant="{}")
    text = text.replace("'  c01 = 0.4e5 !'", "'  c01 = 0.4e5 ")
    if dim != 3:
        text = text.replace("&run", f"&run plane = '{dim}' ")
    if dim == "axisymmetric":
        text = text.replace("lower = -0.004, -0.012", "lower = 0.0, -0.012").replace("cells = 13", "cells = 12")
    by_default, short = (run(hampm3d if dim == 3 else hampm, text.format(courant)) for courant in (0.0, 0.1))
    assert by_default["step"][-1] < 0.6 * short["step"][-1]
    assert by_default["reaction_plate_x"][-1] == pytest.approx(short["reaction_plate_x"][-1], rel=2e-3)
    assert abs(by_default["numerical_loss"][-1]) < 1e-3 * by_default["external_work"][-1]
