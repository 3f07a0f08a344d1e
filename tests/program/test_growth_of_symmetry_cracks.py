"""Cracks on a symmetry plane that grow: half a body gives what the whole one gives with a path on the plane, and so what the exact
solutions give (test_growth_in_motion.py)."""

import sys

import h5py
import numpy as np
import pytest

from harness import run_told
from paths import BENCH

sys.path.insert(0, str(BENCH))

import growth as bench  # noqa: E402

CELL = 0.5e-3
GIVEN = bench.given(1200.0)
BY_TOUGHNESS = f"law = 'toughness'  toughness = {bench.exact_growth()[3]}"


def residual(history):
    """What is missing in the energy balance, over the work."""
    inside = sum(history[name] for name in ("kinetic_energy", "strain_energy", "damping_loss", "numerical_loss", "fracture_energy"))
    return np.max(np.abs(history["external_work"] - inside)) / np.max(history["external_work"])


def off(half, whole, name, times=1):
    return np.max(np.abs(times * half[name] - whole[name])) / np.max(np.abs(whole[name]))


def whole_plate(growth=GIVEN, cell=CELL, method="", **more):
    return bench.plate(cell, growth, audit=True, **more).replace("&method ", f"&method {method} ")


HALF = """&run plane = 'strain'  end_time = {end!r} /
&grid lower = {grid}  cell = {cell!r}  cells = {cells} /
&material name = 'a'  young = 199.992e9  poisson = {poisson}  density = 5000 /
&body material = 'a'  lower = {body[0]}  upper = {body[1]} /
&constraint lower = {behind[0]}  upper = {behind[1]}  fix = '{along}' /
&constraint lower = {ahead[0]}  upper = {ahead[1]}  fix = '{along}' /
&constraint lower = {plane[0]}  upper = {plane[1]}  fix = '{across}' /
&load kind = 'traction'  lower = {top[0]}  upper = {top[1]}  force = {force} /
&method {method} /
&refine indicator = '{indicator}'  max_level = {levels}  rings = 8 /
&crack kind = 'symmetry'  tip = 0.0, 0.0  direction = {direction} /
&growth direction = 'straight'  {growth} /
&energy_release estimators = 'domain_integral'  energy_balance = .true.  radii = {radii} /
&output file = 'growth.h5'  history_interval = 2e-8 /
"""


def half_plate(growth=GIVEN, cell=CELL, method="", mass="weighted", levels=0, end=2.9, poisson=0.3, turned=False, side=1, sense=1, held=10e-3,
               beyond=1):
    """Half of `whole_plate`: on the left or the right (`side`) of a plane along x or y (`turned`), whose crack goes up or down (`sense`).
    `held` is where the symmetry plane ends, `beyond` by how many root cells the grid reaches beyond it."""
    root = cell * 2**levels

    def point(along, across):
        return (side * across, sense * along) if turned else (sense * along, side * across)

    def box(one, other):
        ends = np.sort([point(*one), point(*other)], axis=0)
        return [f"{float(x)!r}, {float(y)!r}" for x, y in ends]

    size = 10e-3
    n = [round(2 * size / root), round(size / root) + 1 + beyond]
    return HALF.format(
        end=end * bench.ARRIVAL, cell=root, poisson=poisson, growth=growth, levels=levels, indicator="tip" if levels else "none",
        method=f"mass = '{mass}' {method}", radii=f"{4 * cell!r}, {6 * cell!r}, {8 * cell!r}",
        grid=box((-size, -beyond * root), (size, size + root))[0], cells=str(n[::-1] if turned else n)[1:-1],
        body=box((-size, 0), (size, size)), behind=box((-size, 0), (-size, size)), ahead=box((size, 0), (size, size)),
        plane=box((0, 0), (held, 0)), top=box((-size, size), (size, size)), along="y" if turned else "x", across="x" if turned else "y",
        force="{!r}, {!r}".format(*(float(x) for x in point(0, 10e3))), direction="{!r}, {!r}".format(*(float(x) for x in point(1, 0))))


SAME = [(GIVEN, {}, 1e-12), (BY_TOUGHNESS, {}, 1e-12), (GIVEN, {"mass": "lumped", "method": "scheme = 'usl'"}, 1e-12),
        (GIVEN, {"mass": "consistent", "method": "scheme = 'usf'"}, 1e-12), (GIVEN, {"method": "scheme = 'usavg'"}, 1e-12),
        (GIVEN, {"cell": 0.25e-3, "levels": 2, "end": 2.3}, 1e-5), (BY_TOUGHNESS, {"levels": 1, "end": 2.6}, 1e-4)]


@pytest.mark.parametrize(("growth", "more", "tolerance"), SAME)
def test_half_a_body_is_half_of_the_whole_one(hampm, growth, more, tolerance):
    """To rounding; with refinement that follows to what particles make of it that split beside the plane."""
    whole, _ = run_told(hampm, whole_plate(growth, **more), name="whole")
    half, _ = run_told(hampm, half_plate(growth, **more), name="half")
    assert half["crack_length"][-1] > 10e-3 + 2 * more.get("cell", CELL)
    assert list(half["step"]) == list(whole["step"])
    for name in ("K_I", "J", "crack_length", "tip_x", "tip_speed", "crack_opening"):
        assert off(half, whole, name) < tolerance, name
    for name in ("fracture_energy", "integral_of_G", "kinetic_energy", "external_work"):
        assert off(half, whole, name, 2) < tolerance, name
    assert residual(half) < 1e-12


PLACES = [{"beyond": 0}, {"side": -1, "beyond": 0}, {"sense": -1}, {"turned": True}, {"turned": True, "side": -1, "sense": -1, "levels": 1}]


@pytest.mark.parametrize("place", PLACES)
def test_planes_on_any_side(hampm, place):
    """Along x or y, with the body on either side of them, at the edge of the grid or within it."""
    base, _ = run_told(hampm, half_plate(poisson=0.2, levels=place.get("levels", 0)), name="base")
    row, _ = run_told(hampm, half_plate(poisson=0.2, **place), name="other")
    for name in ("K_I", "J", "fracture_energy", "crack_length"):
        assert off(row, base, name) < 1e-12, name
    assert residual(row) < 1e-12


def test_a_run_goes_on_from_a_checkpoint(hampm, tmp_path):
    """In the midst of a release, on either number of threads: the same bytes."""
    text = half_plate(BY_TOUGHNESS, levels=1)
    row, _ = run_told(hampm, text, words=("--threads", "2"))
    run_told(hampm, text, code=5, words=("--steps", str(int(0.8 * row["step"][-1])), "--threads", "1"), name="part")
    assert hampm("--resume", "part.h5.checkpoint", "--quiet", "--threads", "1").returncode == 0
    with h5py.File(tmp_path / "part.h5") as file:
        for name, values in row.items():
            assert np.array_equal(values, file["history"][name][:]), name


def test_the_plane_is_held_to_somewhere(hampm):
    """Where the constraint ends the tip stops, and says so; else it runs to the surface."""
    row, said = run_told(hampm, half_plate(bench.given(2000.0), held=4e-3, end=4.0))
    assert "tip 1 no longer grows: a cell further there is no &constraint that holds its symmetry plane ahead of it" in said
    assert 1e-3 < row["tip_x"][-1] < 3e-3 and row["tip_speed"][-1] == 0
    assert residual(row) < 1e-12
    row, said = run_told(hampm, half_plate(bench.given(2500.0), end=5.0))
    assert "tip 1 has run through to a surface" in said and "nothing joins the half body to its mirror image" in said
    assert residual(row) < 1e-12


REST = """&run plane = 'strain'  end_time = 3.0 /
&grid lower = -22e-3, {lower}  cell = 1e-3  cells = 44, {rows} /
&material name = 'a'  young = 200e9  poisson = 0.3  density = 8000 /
&body material = 'a'  lower = -20e-3, {lower_edge}  upper = 20e-3, 20e-3 /
&load kind = 'traction'  lower = -20e-3, 20e-3  upper = 20e-3, 20e-3  force = 0.0, 40e3 /
{more}
&method time = 'static'  load_steps = 3 /
&refine indicator = 'tip'  max_level = 1  rings = 8 /
&growth direction = 'straight'  toughness = 100.0  increment = {increment} /
&energy_release estimators = 'domain_integral'  energy_balance = .true.  radii = 1.5e-3, 2e-3 /
&output history_interval = 1.0 /
"""
UPPER = """&crack kind = 'symmetry'  tip = -12e-3, 0.0 /
&constraint lower = -12e-3, 0.0  upper = 20e-3, 0.0  fix = 'y' /
&constraint lower = 20e-3, 0.0  upper = 20e-3, 0.0  fix = 'x' /"""
BOTH = """&crack kind = 'path'  points = -20e-3, 0.0, -12e-3, 0.0 /
&load kind = 'traction'  lower = -20e-3, -20e-3  upper = 20e-3, -20e-3  force = 0.0, -40e3 /
&constraint lower = 20e-3, 0.0  upper = 20e-3, 0.0  fix = 'xy' /"""


@pytest.mark.parametrize("increment", [1e-3, 1.3e-3])
def test_an_edge_crack_at_rest(hampm, increment):
    """Tips at nodes, and within cells."""
    whole, _ = run_told(hampm, REST.format(lower=-22e-3, rows=44, lower_edge=-20e-3, more=BOTH, increment=increment), name="whole")
    half, _ = run_told(hampm, REST.format(lower=0.0, rows=22, lower_edge=0.0, more=UPPER, increment=increment), name="half")
    for name in ("load_factor", "K_I", "J", "G", "crack_length"):
        assert off(half, whole, name) < 1e-10, name
    for name in ("fracture_energy", "strain_energy", "external_work"):
        assert off(half, whole, name, 2) < 1e-10, name
    assert half["crack_length"][-1] == pytest.approx(8e-3 + 3 * increment)
    assert half["fracture_energy"][-1] == pytest.approx(0.5 * 100 * 3 * increment, rel=0.01)
    assert residual(half) < 1e-12


REFUSED = [([("'straight'", "'hoop_stress'")], "direction = 'hoop_stress' is not allowed with &crack kind = 'symmetry'"),
           ([("'straight'", "'straight'  tips = 'first'")], "tips = 'first' is not allowed with &crack kind = 'symmetry'"),
           ([("'straight'", "'straight'  crack = 'a'")], "crack = 'a' is not allowed with &crack kind = 'symmetry'"),
           ([("'domain_integral'", "'domain_integral', 'vcct'")], "estimators = 'vcct' is not allowed with &growth"),
           ([("'domain_integral'", "'domain_integral', 'stress_closure'")], "estimators = 'stress_closure' is not allowed with &growth"),
           ([("radii = ", "reference = 'dcb'  radii = ")], "reference = 'dcb' is not allowed with &growth"),
           ([("fix = 'y'", "fix = 'y'  unilateral = .true.")], "unilateral = .true. is not allowed with &method time = 'explicit'"),
           ([("fix = 'y'", "fix = 'y'  displacement = 0.0, 1e-6")], "must not move the symmetry plane where a &crack of kind = 'symmetry' goes on"),
           ([("fix = 'y'", "fix = 'y'  velocity = 0.0, 1e-3")], "must not move the symmetry plane where a &crack of kind = 'symmetry' goes on"),
           ([("&method", "&method frame = 'updated'")], "frame = 'updated' is not allowed with &crack kind = 'symmetry' and &growth")]


@pytest.mark.parametrize(("changes", "message"), REFUSED)
def test_what_growth_on_a_symmetry_plane_does_not_go_with(hampm, changes, message):
    text = half_plate()
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    assert message in run_told(hampm, text, code=2)
