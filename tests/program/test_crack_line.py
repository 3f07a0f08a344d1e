"""A crack inside a body has no handedness: turned, mirrored, or halved by its plane of symmetry, a scene gives the same numbers."""

import re

import numpy as np
import pytest

from history import History
from snapshots import field, points, read_steps

TIP = {"uniform": "indicator = 'none'", "refined": "indicator = 'tip' rings = 3 max_level = 2"}
EVERY_ESTIMATOR = "'vcct', 'stress_closure', 'domain_integral'"

BEAM = """\
&run thickness = 0.01 end_time = 3e-5 /
&material name = 'aluminium' young = 70e9 poisson = 0.3 density = 2700 /
&damping rate = 1e4 /
&method {method} /
&refine {refine} /
&energy_release estimators = {estimators} energy_balance = .true. radii = 5e-3, 7e-3 /
&output file = 'beam.h5' history_interval = 1e-6 /
"""


def quarter_turns(point, times, mirrored):
    """A point turned about the origin, after mirroring the second axis if asked for."""
    x, y = point
    y = -y if mirrored else y
    for _ in range(times):
        x, y = -y, x
    return x + 0.0, y + 0.0  # no -0.0


def split_beam(refine, times=0, mirrored=False, method=""):
    """A split beam held at its end, its upper arm pulled up and along, in any orientation: every mode, and waves."""
    def point(*xy):
        return "{!r}, {!r}".format(*quarter_turns(xy, times, mirrored))

    def box(lower, upper):
        corners = np.array([quarter_turns(lower, times, mirrored), quarter_turns(upper, times, mirrored)])
        low, high = corners.min(axis=0).tolist(), corners.max(axis=0).tolist()
        return "lower = {!r}, {!r} upper = {!r}, {!r}".format(*low, *high)

    cells = (24, 12) if times % 2 == 0 else (12, 24)
    corner = np.min([quarter_turns((-5e-3, -15e-3), times, mirrored), quarter_turns((55e-3, 15e-3), times, mirrored)], axis=0).tolist()
    return BEAM.format(method=method, refine=refine, estimators=EVERY_ESTIMATOR) + f"""\
&grid lower = {corner[0]!r}, {corner[1]!r} cell = 2.5e-3 cells = {cells[0]}, {cells[1]} /
&body material = 'aluminium' {box((0.0, -10e-3), (50e-3, 10e-3))} /
&constraint {box((50e-3, -10e-3), (50e-3, 10e-3))} fix = 'xy' /
&load kind = 'traction' {box((0.0, 0.0), (0.0, 10e-3))} force = {point(0.3, 1.0)} /
&crack kind = 'line' tip = {point(25e-3, 0.0)} direction = {point(1.0, 0.0)} /
"""


def cantilever(refine, whole, method=""):
    """A double cantilever beam, whole with its crack inside, or its upper half."""
    scene = BEAM.format(method=method, refine=refine, estimators=EVERY_ESTIMATOR) + """\
&load kind = 'traction' lower = 0.0, 0.0 upper = 0.0, 0.01 force = 0.0, 1.0 /
"""
    if not whole:
        return scene + """\
&grid cell = 2.5e-3 cells = 20, 5 /
&body material = 'aluminium' lower = 0.0, 0.0 upper = 0.05, 0.01 /
&constraint lower = 0.025, 0.0 upper = 0.05, 0.0 fix = 'y' /
&crack kind = 'symmetry' tip = 0.025, 0.0 /
"""
    return scene + """\
&grid lower = 0.0, -0.0125 cell = 2.5e-3 cells = 20, 10 /
&body material = 'aluminium' lower = 0.0, -0.01 upper = 0.05, 0.01 /
&load kind = 'traction' lower = 0.0, -0.01 upper = 0.0, 0.0 force = 0.0, -1.0 /
&crack kind = 'line' tip = 0.025, 0.0 /
"""


@pytest.fixture
def columns_of(hampm, tmp_path):
    """`columns_of(scene)`: the history of a run of it."""
    def run(scene, may_overlap=False):
        (tmp_path / "beam.nml").write_text(scene)
        result = hampm("beam.nml", "--quiet", "--force")
        assert (result.returncode, result.stdout) == (0, "")
        assert result.stderr == "" or may_overlap and "the faces of the crack interpenetrate" in result.stderr
        return History(tmp_path / "beam.h5").columns
    return run


def assert_equal(one, other, names, factors=None, rtol=1e-10):
    """Columns agree to `rtol` of their largest value, those in `factors` after multiplication."""
    assert names
    for name in names:
        expected = one[name] * (factors or {}).get(name, 1)
        np.testing.assert_allclose(other[name], expected, rtol=0, atol=rtol * np.max(np.abs(expected)), err_msg=name)


def odd(name):
    """Whether a column changes its sign with the handedness of the scene."""
    return name.endswith("_II") or name in ("mode_mixity", "crack_sliding", "mouth_sliding")


@pytest.mark.parametrize("refine", TIP.values(), ids=TIP)
@pytest.mark.parametrize("times", [1, 2, 3])
def test_a_turned_scene_gives_the_same(columns_of, refine, times):
    one, other = columns_of(split_beam(refine)), columns_of(split_beam(refine, times))
    assert np.max(np.abs(one["K_II"])) > 0.1 * np.max(np.abs(one["K_I"])) > 0
    assert_equal(one, other, [name for name in one if name not in ("reaction_x", "reaction_y", "numerical_loss")])


@pytest.mark.parametrize("refine", TIP.values(), ids=TIP)
@pytest.mark.parametrize("times", [0, 1])
def test_a_mirrored_scene_gives_mode_ii_of_the_other_sign(columns_of, refine, times):
    one, other = columns_of(split_beam(refine)), columns_of(split_beam(refine, times, mirrored=True))
    assert_equal(one, other, [name for name in one if name not in ("reaction_x", "reaction_y", "numerical_loss")],
                 {name: -1 for name in one if odd(name)})


@pytest.mark.parametrize("refine", TIP.values(), ids=TIP)
@pytest.mark.parametrize("method", ["", "frame = 'total'", "scheme = 'usl'", "mass = 'consistent'", "mass = 'fmpm'"])
def test_a_whole_body_gives_what_its_half_on_the_symmetry_plane_gives(columns_of, refine, method):
    """The stress closure is left out where the matrix is not lumped: extrapolation then knows of the other half or does not. The
    recovery of the stress, from which errors are estimated, never does the same at the plane as in the middle of a body."""
    half, whole = (columns_of(cantilever(refine, whole, method)) for whole in (False, True))
    doubled = {"particles", "cells", "kinetic_energy", "strain_energy", "external_work", "damping_loss"}
    left_out = {"reaction_x", "reaction_y", "numerical_loss"} | ({"G_stress_closure_I"} if "mass" in method else set())
    doubled &= half.keys() & whole.keys()
    errors = {name for name in half if name.endswith("_error")}
    assert_equal(half, whole, [name for name in half if name not in left_out | errors], {name: 2 for name in doubled})
    assert_equal(half, whole, sorted(errors - {"G_stress_closure_I_error"}), rtol=0.1)
    for mode_ii, mode_i in [("K_II", "K_I"), ("G_vcct_II", "G_vcct_I"), ("G_domain_II", "J")]:
        assert np.max(np.abs(whole[mode_ii])) < 1e-10 * np.max(np.abs(whole[mode_i]))


def test_the_progress_line_tells_g_of_both_modes_whatever_way_the_faces_slide(hampm, tmp_path):
    """By the best of the chosen estimators: J before VCCT."""
    (tmp_path / "beam.nml").write_text(split_beam(TIP["uniform"]))
    reference = "--set", "energy_release.reference='value'", "--set", "energy_release.reference_value=1e-6"
    for estimators, column in [(EVERY_ESTIMATOR, "J"), ("'vcct'", "G_vcct")]:
        result = hampm("beam.nml", *reference, "--set", f"energy_release.estimators={estimators}", "--force")
        columns = History(tmp_path / "beam.h5").columns
        rate = columns[column][-1] if column == "J" else columns[column + "_I"][-1] + abs(columns[column + "_II"][-1])
        assert column == "J" or abs(columns[column + "_II"][-1]) > 1e-8
        shown = float(re.findall(r"G/Gref +(-?\d+\.\d+)", result.stdout)[-1])
        assert shown == pytest.approx(rate / 1e-6, abs=1e-4)


OPENED = """\
&run thickness = 0.01 end_time = 2e-4 /
&grid lower = -5e-3, -15e-3 cell = 2.5e-3 cells = 22, 20 /
&material name = 'aluminium' law = 'neo_hookean' young = 70e9 poisson = 0.3 density = 2700 /
&body material = 'aluminium' lower = 0.0, 0.0 upper = 0.05, 0.02 /
&constraint lower = 0.05, 0.0 upper = 0.05, 0.02 fix = 'xy' /
&load kind = 'traction' lower = 0.0, 0.01 upper = 0.0, 0.02 force = 0.0, {force} history = 'ramp' rise_time = 1e-4 /
&load kind = 'traction' lower = 0.0, 0.0 upper = 0.0, 0.01 force = 0.0, -{force} history = 'ramp' rise_time = 1e-4 /
&damping rate = 6e4 /
&method courant = 0.5 frame = 'updated' /
&crack kind = 'line' tip = 0.025, 0.01 /
&energy_release estimators = 'domain_integral' /
&output file = 'beam.h5' history_interval = 1e-5 snapshot_interval = 2e-4 /
"""


def test_faces_that_part_by_more_than_a_cell_keep_their_opening(hampm, tmp_path):
    """In the updated frame nothing is left at the nodes of the mouth; the particles that began there tell how far it is open."""
    (tmp_path / "beam.nml").write_text(OPENED.format(force=1.5e4))
    result = hampm("beam.nml", "--quiet")
    assert result.returncode == 0, result.stderr
    mouth = History(tmp_path / "beam.h5").columns["mouth_opening"][-1]
    data = read_steps(tmp_path / "beam.h5")[1][-1][0]
    displacement = field(data.point_data, "displacement")
    start = points(data) - displacement
    pair = [displacement[np.argmin(np.abs(start - (0.0, y, 0.0)).sum(axis=1)), 1] for y in (0.0106, 0.0094)]
    assert mouth > 2.5e-3
    assert mouth == pytest.approx(pair[0] - pair[1], rel=0.05)


def test_faces_pressed_on_each_other_end_the_run(hampm, tmp_path):
    (tmp_path / "beam.nml").write_text(OPENED.format(force=-1.5e4).replace("--", ""))
    result = hampm("beam.nml", "--quiet")
    assert result.returncode == 3
    assert re.search(r"the faces of a crack interpenetrate by \S+ m, more than half of a cell", result.stderr)


BEHIND = """\
&run thickness = 0.01 end_time = 5e-5 /
&grid lower = -0.04, -0.0125 cell = 2.5e-3 cells = 36, 10 /
&material name = 'aluminium' young = 70e9 poisson = 0.3 density = 2700 /
&body material = 'aluminium' lower = 0.0, -0.01 upper = 0.05, 0.01 /
&body material = 'aluminium' lower = -0.03, -0.005 upper = {edge}, 0.005 /
&load kind = 'traction' lower = -0.03, 0.0 upper = -0.03, 0.005 force = 0.0, 1.0 /
&load kind = 'traction' lower = -0.03, -0.005 upper = -0.03, 0.0 force = 0.0, -1.0 /
&output file = 'beam.h5' history_interval = 1e-6 /
&method courant = 0.1 frame = 'updated' /
"""


@pytest.mark.parametrize("edge", [-0.01, -0.0116, -0.0025])
def test_a_crack_ends_with_the_material_that_it_is_in(columns_of, edge):
    """A body on the line of the crack, behind its mouth, is pulled apart at its end, and is as stiff as without the crack."""
    scene = BEHIND.format(edge=edge)
    whole, cracked = columns_of(scene), columns_of(scene + "&crack kind = 'line' tip = 0.025, 0.0 /\n", may_overlap=True)
    assert np.max(whole["external_work"]) > 0
    assert_equal(whole, cracked, ["external_work", "kinetic_energy", "strain_energy"], rtol=1e-12)


MOVING = """\
&run thickness = 0.01 end_time = 1.4e-4 /
&grid lower = -5e-3, -15e-3 cell = 2.5e-3 cells = 26, 20 /
&material name = 'aluminium' young = 70e9 poisson = 0.3 density = 2700 /
&body material = 'aluminium' lower = 0.0, 0.0 upper = 0.05, 0.02 velocity = {velocity} /
&method frame = 'updated' /
&crack kind = 'line' tip = 0.025, 0.01 /
&output file = 'beam.h5' history_interval = 1e-5 /
"""


@pytest.mark.parametrize("contact", ["none", "frictionless", "friction' friction = 0.3 name = 'a"])
@pytest.mark.parametrize("velocity", ["0.0, 20.0", "20.0, 0.0", "-14.0, 14.0"])
def test_a_crack_goes_with_the_body_that_carries_it(hampm, tmp_path, velocity, contact):
    """Over more than a cell: nothing happens to a body that flies, whose faces touch or not."""
    scene = MOVING.format(velocity=velocity).replace("tip = 0.025, 0.01", f"tip = 0.025, 0.01 contact = '{contact}'")
    (tmp_path / "beam.nml").write_text(scene + "&energy_release estimators = 'domain_integral'  energy_balance = .true. /\n")
    result = hampm("beam.nml", "--quiet")
    assert (result.returncode, result.stderr) == (0, "")
    row = History(tmp_path / "beam.h5").columns
    assert row["kinetic_energy"] == pytest.approx(row["kinetic_energy"][0], rel=1e-12)
    assert np.max(row["strain_energy"]) < 1e-20 * row["kinetic_energy"][0]
    assert np.max(row["J"]) < 1e-20


@pytest.mark.parametrize("contact, cells", [("frictionless", 1), ("friction' friction = 0.2 name = 'a", 2)])
def test_closed_faces_are_the_same_in_both_frames(hampm, tmp_path, contact, cells):
    """A slanted path, so that both have cells that are cut, whose faces a load presses together and shears. Only the total frame keeps all that moves at
    nodes, as faces do that stick and swing: of K_II 6e-3 in cells of 2.5 mm and 2e-3 in those of half the size, and more with more friction."""
    rows = {}
    for frame in ("total", "updated"):
        (tmp_path / "beam.nml").write_text(PRESSED.format(frame=frame, contact=contact, cell=2.5e-3 / cells, nx=26 * cells, ny=20 * cells))
        result = hampm("beam.nml", "--quiet", "--force")
        assert result.returncode == 0, result.stderr
        rows[frame] = History(tmp_path / "beam.h5").columns
    for column in ("K_II", "mouth_sliding"):
        largest = np.max(np.abs(rows["total"][column]))
        print(column, *(rows[frame][column][-1] for frame in rows))
        assert largest > 0
        assert rows["updated"][column] == pytest.approx(rows["total"][column], abs=5e-3 * largest), column


PRESSED = """\
&run thickness = 0.01 end_time = 1e-4 /
&grid lower = -5e-3, -15e-3 cell = {cell} cells = {nx}, {ny} /
&material name = 'aluminium' young = 70e9 poisson = 0.3 density = 2700 /
&body material = 'aluminium' lower = 0.0, 0.0 upper = 0.05, 0.02 /
&method frame = '{frame}' courant = 0.3 /
&damping rate = 2e4 /
&crack kind = 'path' points = -1e-3, 0.0103, 0.025, 0.0109 contact = '{contact}' /
&load kind = 'traction' lower = 0.0, 0.0103 upper = 0.0, 0.02 force = 200.0, -100.0 history = 'ramp' rise_time = 5e-5 /
&load kind = 'traction' lower = 0.0, 0.0 upper = 0.0, 0.0103 force = 0.0, 100.0 history = 'ramp' rise_time = 5e-5 /
&constraint lower = 0.05, 0.0 upper = 0.05, 0.02 fix = 'xy' /
&energy_release estimators = 'domain_integral' /
&output file = 'beam.h5' history_interval = 5e-6 /
"""


SHORT_ARM = """\
&run thickness = 0.01 end_time = 3e-5 /
&grid lower = -5e-3, -15e-3 cell = 2.5e-3 cells = 24, 12 /
&material name = 'aluminium' young = 70e9 poisson = 0.3 density = 2700 /
&body material = 'aluminium' lower = {lower_end}, -10e-3 upper = 50e-3, 0.0 /
&body material = 'aluminium' lower = {upper_end}, 0.0 upper = 50e-3, 10e-3 /
&constraint lower = 50e-3, -10e-3 upper = 50e-3, 10e-3 fix = 'xy' /
&load kind = 'traction' lower = {upper_end}, 0.0 upper = {upper_end}, 10e-3 force = 0.0, 1.0 /
&load kind = 'traction' lower = {lower_end}, -10e-3 upper = {lower_end}, 0.0 force = 0.0, -1.0 /
&crack kind = 'line' tip = 25e-3, 0.0 length = {length} /
&energy_release estimators = 'vcct' /
&output file = 'beam.h5' history_interval = 1e-6 /
"""


@pytest.mark.parametrize("length", [0.0, 20e-3])
def test_the_mouth_is_where_the_shorter_arm_ends(hampm, columns_of, length):
    """With a length beyond that, the crack reaches the edge of the material all the same."""
    one = columns_of(SHORT_ARM.format(lower_end=10e-3, upper_end=0.0, length=length))
    other = columns_of(SHORT_ARM.format(lower_end=0.0, upper_end=10e-3, length=length))
    assert "mouth (0.01, 0.0) m" in hampm("beam.nml", "--check").stdout
    assert_equal(one, other, ["mouth_opening", "G_vcct_I"], rtol=1e-9)
    assert_equal(one, other, ["mouth_sliding", "G_vcct_II"], {"mouth_sliding": -1, "G_vcct_II": -1}, rtol=1e-9)
