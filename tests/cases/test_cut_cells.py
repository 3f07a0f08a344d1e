"""Pieces of cells that hold next to nothing, as cracks and edges of bodies leave them."""

import random
from math import cos, pi, radians, sin

import pytest


def lame_energy(inner, outer, pressure=1e6, young=200e9, poisson=0.3):
    """Strain energy of a ring under pressure inside, plane strain, for each length [J/m]: half of the pressure times what the hole widens."""
    modulus, ratio = young / (1 - poisson**2), poisson / (1 - poisson)
    widening = pressure * inner / (modulus * (outer**2 - inner**2)) * ((1 - ratio) * inner**2 + (1 + ratio) * outer**2)
    return pi * inner * pressure * widening


def last(result, *columns):
    """The last values of some columns of a run that has ended well."""
    assert result.code == 0, result.stderr
    return [float(result.row[column][-1]) for column in columns]


def test_crack_whose_mouth_is_slanted_at_rest(case):
    """K by superposition and by quadratic cells; cells of half the size come nearer."""
    k_1, k_2, mouth, work, energy = last(case("small_cut_piece_static"), "K_I", "K_II", "mouth_opening", "external_work", "strain_energy")
    assert k_1 == pytest.approx(6.4e5, rel=0.03)
    assert k_2 == pytest.approx(8e4, rel=0.07)
    assert mouth == pytest.approx(1.51e-6, rel=0.05)
    assert work == pytest.approx(energy, rel=1e-9)
    fine = case("small_cut_piece_static", "--set", "grid.cell=0.5e-3", "--set", "grid.cells=24,24")
    k_1, k_2, j, mouth = last(fine, "K_I", "K_II", "J", "mouth_opening")
    assert k_1 == pytest.approx(6.4e5, rel=0.02)
    assert k_2 == pytest.approx(8e4, rel=0.02)
    assert 1.89 < j < 1.97
    assert mouth == pytest.approx(1.51e-6, rel=0.03)


def test_crack_whose_mouth_is_slanted_in_implicit_steps(case):
    """At the end of a damped ramp it has the state at rest; the work is above the energy stored by what damping took, and that is 2.88e-3 J in
    cells of a quarter of the size, at rest (2.69e-3 J by cells of order 1 with the mouth half a cell elsewhere)."""
    mouth, j, work = last(case("small_cut_piece_implicit", "--set", "method.time_step=1e-6", "--set", "output.history_interval=1e-5"), "mouth_opening", "J", "external_work")
    at_rest, j_at_rest = last(case("small_cut_piece_static"), "mouth_opening", "J")
    assert mouth == pytest.approx(at_rest, rel=2e-3)
    assert j == pytest.approx(j_at_rest, rel=2e-3)
    assert mouth == pytest.approx(1.51e-6, rel=0.05)
    assert work == pytest.approx(2.88e-3, rel=0.05)


@pytest.mark.parametrize("points, side", [("7e-3, 4e-3, 12e-3, 9e-3", "12e-3"), ("5e-3, 8e-3, 0.0, 3e-3", "0.0")])
def test_mirror_images_of_it(case, text_of, points, side):
    """Particles on this diagonal are split into squares, for the pressure acts on their edges; an eighth of their volume stays on it and goes to one side: on
    a mesh this coarse that is up to 2 % of what the body stores. Where nothing held its small pieces mirror images came to rest, or did not."""
    text = text_of("small_cut_piece_static").replace("12e-3, 3e-3, 7e-3, 8e-3", points)
    if side == "0.0":
        for y in ("0.0", "12e-3"):
            text = text.replace(f"lower = 0.0, {y}  upper = 0.0, {y}", f"lower = 12e-3, {y}  upper = 12e-3, {y}")
    k_1, *one = last(case("small_cut_piece_static"), "K_I", "mouth_opening", "strain_energy")
    other_k_1, *other = last(case("mirrored", text=text), "K_I", "mouth_opening", "strain_energy")
    assert other == pytest.approx(one, rel=0.03)
    assert other_k_1 == pytest.approx(k_1, rel=0.03)


@pytest.mark.parametrize("name, inner", [("pressed_ring_refined_a", 4.6e-3), ("pressed_ring_refined_b", 4.3e-3)])
def test_ring_under_pressure_whose_edge_refines(case, name, inner):
    """Lame."""
    energy, work = last(case(name), "strain_energy", "external_work")
    assert energy == pytest.approx(lame_energy(inner, 9e-3), rel=0.01)
    assert work == pytest.approx(energy, rel=0.03)


@pytest.mark.parametrize("inner", [4.1e-3, 5.05e-3, 5.7e-3])
def test_rings_of_other_radii(case, text_of, inner):
    text = text_of("pressed_ring_refined_a").replace("4.6e-3", repr(inner)).replace("-5e-3, -5e-3  upper = 5e-3, 5e-3", "-6e-3, -6e-3  upper = 6e-3, 6e-3")
    energy, = last(case("ring", text=text), "strain_energy")
    assert energy == pytest.approx(lame_energy(inner, 9e-3), rel=0.015)


def test_work_of_a_load_is_counted_once_where_cells_refine(case):
    """What finer cells give way is the difference: 0.7 %."""
    work, energy = last(case("external_work_pressed_crack_zz", "--set", "refine.max_level=2"), "external_work", "strain_energy")
    assert work == pytest.approx(energy, rel=0.015)


def edge_crack(at_random):
    """A square under pressure in an edge crack placed at random."""
    while True:
        angle, y, length = radians(at_random.uniform(-75, 75)), at_random.uniform(2.5, 9.5), at_random.uniform(3.5, 6.5)
        tip = length * cos(angle), y + length * sin(angle)
        if tip[0] > 2.6 and 2.6 < tip[1] < 9.4:
            break
    if at_random.random() < 0.5:
        points = 0.0, y, *tip
    else:
        points = 12.0, y, 12 - tip[0], tip[1]
    return f"""&run  end_time = 1.0  plane = '{at_random.choice(["strain", "stress"])}' /
&grid  cell = 1e-3  cells = 12, 12 /
&material  name = 's'  young = 200e9  poisson = {at_random.choice([0.0, 0.3, 0.45])}  density = 7800.0 /
&body  material = 's'  lower = 0.0, 0.0  upper = 12e-3, 12e-3 /
&constraint  lower = 6e-3, 0.0  upper = 6e-3, 0.0  fix = 'xy' /
&constraint  lower = 6e-3, 12e-3  upper = 6e-3, 12e-3  fix = 'x' /
&load  kind = 'pressure'  on = 'crack'  pressure = 1e6 /
&crack  kind = 'path'  points = {", ".join(f"{1e-3 * x!r}" for x in points)} /
&method  time = 'static' /
&energy_release  estimators = 'domain_integral' /
"""


@pytest.mark.parametrize("seed", range(3))
def test_edge_cracks_at_random(case, seed):
    """Of 100 of them 22 found no equilibrium where nothing held small pieces, and of 4 the mouth had the opening 0, as it fell on a sliver. Faces of
    elastic material open by at least K sqrt(length)/E' and at most some times as much."""
    at_random = random.Random(seed)
    for _ in range(6):
        k_1, mouth, work, energy = last(case("random", text=edge_crack(at_random)), "K_I", "mouth_opening", "external_work", "strain_energy")
        assert k_1 * 0.06 / 200e9 < mouth < k_1 * 1.2 / 200e9
        assert work == pytest.approx(energy, rel=1e-9)


def test_mesh_that_changes_around_a_crack_in_motion(case, text_of):
    """Where bonds forgot at each change of the mesh what particles do not tell, the energy of this smaller plate grew without end within 600 steps."""
    text = text_of("path_zz_unstable")
    for old, new in (("=-20e-3,-12e-3", "=-10e-3,-10e-3"), ("40,24", "20,20"), ("-18e-3", "-8e-3"), ("18e-3", "8e-3"), ("10e-3 force", "8e-3 force"),
                     ("=-8e-3,-10e-3", "=-8e-3,-8e-3"), ("=8e-3,-10e-3", "=8e-3,-8e-3"), ("=-8e-3,10e-3", "=-8e-3,8e-3"), ("=8e-3,10e-3", "=8e-3,8e-3"),
                     ("2e4", "4e4"), ("tolerance=0.1", "tolerance=0.2"), ("end_time=4e-4", "end_time=1.1e-4")):
        text = text.replace(old, new)
    result = case("path_zz_unstable", text=text)
    assert result.code == 0, result.stderr
    assert "grown" not in result.stderr


@pytest.mark.parametrize("is_upright", [False, True])
def test_cracks_just_beside_a_grid_line(case, is_upright):
    """By a fiftieth of a cell, where what is cut off from a cell holds no sample: as on the line, with bonds ahead of the tip and with the same openings.
    K was 8 % too large without them, and all openings were 0."""
    def place(along, across):
        return "{!r}, {!r}".format(*((across, along) if is_upright else (along, across)))

    def scene(beside):
        return f"""&run  plane = 'strain'  end_time = 1.0 /
&grid  lower = -11e-3, -11e-3  cell = 1e-3  cells = 22, 22 /
&material  name = 's'  young = 200e9  poisson = 0.3  density = 8000 /
&body  material = 's'  lower = -10e-3, -10e-3  upper = 10e-3, 10e-3 /
&load  kind = 'traction'  lower = {place(-10e-3, 10e-3)}  upper = {place(10e-3, 10e-3)}  force = {place(0.0, 40e3)} /
&load  kind = 'traction'  lower = {place(-10e-3, -10e-3)}  upper = {place(10e-3, -10e-3)}  force = {place(0.0, -40e3)} /
&constraint  lower = {place(10e-3, -10e-3)}  upper = {place(10e-3, 10e-3)}  fix = '{"y" if is_upright else "x"}' /
&constraint  lower = {place(10e-3, 0.0)}  upper = {place(10e-3, 0.0)}  fix = 'xy' /
&crack  kind = 'path'  points = {place(-10e-3, beside)}, {place(-1.5e-3, beside)} /
&method  time = 'static' /
&energy_release  estimators = 'domain_integral' /
"""
    columns = "K_I", "J", "crack_opening", "mouth_opening", "strain_energy"
    on_line = last(case("on_line", text=scene(0.0)), *columns)
    for beside in (2e-5, -2e-5):
        assert last(case("beside", text=scene(beside)), *columns) == pytest.approx(on_line, rel=1e-3)


def test_bonded_halves_are_one_body_beside_a_crack(case, text_of):
    halves = text_of("bonded_halves_refine")
    second = next(line for line in halves.splitlines() if line.startswith("&body") and "lower = 1.75" in line)
    rows = [case("bonded_halves_refine", text=text).row for text in (halves, halves.replace(second + "\n", "").replace("upper = 1.75, 3.5", "upper = 3.5, 3.5"))]
    assert rows[0]["cells"][-1] > 800
    for column in ("strain_energy", "kinetic_energy"):
        assert rows[0][column] == pytest.approx(rows[1][column], rel=0, abs=1e-9 * max(rows[1][column])), column
