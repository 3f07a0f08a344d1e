"""Equilibrium, `time = 'static'`: it is where damped motions end, where theory has it, and nowhere where there is none."""

import math
import re

import h5py
import numpy as np
import pytest

from harness import run
from paths import INPUT, REGRESSION
from snapshots import field, points, read_steps


STATIC = "method.time=static", "method.frame=total"
AT_REST = "method.courant=0", "damping.rate=0", "output.history_interval=0"  # what dcb.nml gives for motion only

# --- where damped motions end -----------------------------------------------------------------------------------------

DAMPED = "method.frame=total", "method.courant=0", "output.snapshot_interval=0"
COARSE = "grid.cell=5e-3", "grid.cells=20,3", "output.history_interval=1e-3"
LONG = "run.end_time=8e-3", "damping.rate=1.2e4"
# scene, settings, those of the damped run, and how near to each other they are: the lumped ones still tremble in K and in what
# single nodes feel
LIMITS = [("dcb", (*COARSE, "method.mass=consistent"), LONG, 1e-9),
          ("dcb", (*COARSE, "refine.indicator=tip", "refine.max_level=2"), LONG, 1e-6),
          ("centre_crack", ("output.history_interval=1e-4",), ("run.end_time=2e-3",), 1e-6),
          ("mixed_mode", ("output.history_interval=1e-4",), ("run.end_time=3e-3",), 1e-6),
          ("closed_crack", ("output.history_interval=1e-4",), ("run.end_time=2e-3",), 1e-6)]


@pytest.mark.parametrize("scene, settings, damped, tolerance", LIMITS, ids=lambda value: value if isinstance(value, str) else "")
def test_static_values_are_those_that_damped_runs_tend_to(hampm, scene, settings, damped, tolerance):
    path = INPUT / "dcb.nml" if scene == "dcb" else REGRESSION / scene / "case.nml"
    rest = run(hampm, path, *settings, *STATIC, "output.snapshot_interval=0")
    motion = run(hampm, path, *settings, *DAMPED, *damped)
    compared = 0
    for name, column in rest.items():
        if not re.match(r"(G_vcct|G_stress|G_domain|K|J)(_I|_II|_\d)?$", name):
            continue
        unit = [values[-1] for key, values in motion.items() if np.ndim(values) and key[:2] == name[:2]]
        assert column[-1] == pytest.approx(motion[name][-1], abs=tolerance * np.max(np.abs(unit))), name
        compared += 1
    assert compared >= 4
    assert rest["strain_energy"][-1] == pytest.approx(motion["strain_energy"][-1], rel=tolerance)
    assert rest["external_work"][-1] == pytest.approx(rest["strain_energy"][-1], rel=1e-9)
    assert rest["distance_to_equilibrium"] < 1e-8


# --- theory -----------------------------------------------------------------------------------------------------------

BAR = """
&run plane = '{plane}'  thickness = 0.01  end_time = 2.0 /
&grid lower = 0.0, 0.0  cell = 2.5e-3  cells = 18, 6 /
&material name = 'a'  young = 1e6  poisson = 0.3  density = 1000  law = '{law}' /
&body material = 'a'  lower = 0.0, 0.0  upper = 0.04, 0.01 /
&constraint lower = 0.0, 0.0  upper = 0.0, 0.01  fix = 'x' /
&constraint lower = 0.0, 0.0  upper = 0.04, 0.0  fix = 'y' /
{end}
&method time = 'static'  load_steps = 4 /
"""
GRIP = """&constraint lower = 0.04, 0.0  upper = 0.04, 0.01  fix = 'x'  displacement = {}, 0.0  history = 'ramp'  rise_time = 2.0
             name = 'grip' /"""
PULL = "&load kind = 'traction'  lower = 0.04, 0.0  upper = 0.04, 0.01  force = {}, 0.0  history = 'ramp'  rise_time = 2.0 /"


def neo_hookean_bar(stretch, plane):
    """Force over the area of a bar under uniaxial stress in the plane, by bisection for the stretch across (and the thickness)."""
    young, poisson = 1e6, 0.3
    mu, lam = young / (2 * (1 + poisson)), young * poisson / ((1 + poisson) * (1 - 2 * poisson))

    def kirchhoff(a, j):
        return mu * (a**2 - 1) + lam * math.log(j)
    low, high = 0.1, 3.0
    for _ in range(200):
        across = (low + high) / 2
        thick = across if plane == "stress" else 1.0
        low, high = (across, high) if kirchhoff(across, stretch * across * thick) < 0 else (low, across)
    return kirchhoff(stretch, stretch * across * thick) / stretch


@pytest.mark.parametrize("plane", ["stress", "strain"])
@pytest.mark.parametrize("stretch", [0.7, 1.5])
def test_a_neo_hookean_bar_that_is_gripped(hampm, tmp_path, plane, stretch):
    (tmp_path / "bar.nml").write_text(BAR.format(plane=plane, law="neo_hookean", end=GRIP.format(0.04 * (stretch - 1))))
    rows = run(hampm, "bar.nml")
    assert len(rows["time"]) == 5
    for time, force in zip(rows["time"], rows["reaction_grip_x"]):
        asked = 1e-4 * neo_hookean_bar(1 + (stretch - 1) * time / 2, plane)
        assert force == pytest.approx(asked, rel=1e-8, abs=1e-9)


@pytest.mark.parametrize("law", ["linear_elastic", "neo_hookean"])
def test_pulling_a_bar_and_moving_its_end_are_the_same(hampm, tmp_path, law):
    (tmp_path / "moved.nml").write_text(BAR.format(plane="stress", law=law, end=GRIP.format(8e-3)))
    moved = run(hampm, "moved.nml")
    (tmp_path / "pulled.nml").write_text(BAR.format(plane="stress", law=law, end=PULL.format(moved["reaction_grip_x"][-1])))
    pulled = run(hampm, "pulled.nml")
    assert pulled["strain_energy"][-1] == pytest.approx(moved["strain_energy"][-1], rel=1e-8)
    for rows in moved, pulled:                   # the mean force of each load step: exact where work is quadratic
        assert rows["external_work"][-1] == pytest.approx(rows["strain_energy"][-1], rel=1e-9 if law == "linear_elastic" else 6e-3)


BEAM = """
&run plane = 'stress'  thickness = 1.0  end_time = 1.0 /
&grid lower = 0.0, 0.0  cell = {cell}  cells = {nx}, {ny} /
&material name = 'a'  young = 12e6  poisson = 0.0  density = 1000  law = 'neo_hookean' /
&body material = 'a'  lower = 0.0, 0.0  upper = 1.0, 0.02 /
&constraint lower = 0.0, 0.0  upper = 0.0, 0.02  fix = 'xy' /
&load kind = 'traction'  lower = 1.0, 0.0  upper = 1.0, 0.02  force = {force}  history = 'ramp'  rise_time = 1.0 /
&method time = 'static'  load_steps = {steps} /
&output snapshot_interval = 1.0 /
"""


def elastica(load):
    """Deflection, over the length, of the end of a cantilever that does not stretch, under P L**2/(E I) = `load`, which keeps its
    direction: with t the angle at the end, L = integral dt'/sqrt(2 load (sin t - sin t')) over 0 to t."""
    def of_angle(end):
        s = (np.arange(40000) + 0.5) / 40000 * math.sqrt(end)       # t' = t - s**2 takes the root's pole away
        angle = end - s**2
        weight = 2 * s / np.sqrt(2 * load * (np.sin(end) - np.sin(angle))) * math.sqrt(end) / 40000
        return weight.sum(), (weight * np.sin(angle)).sum()
    low, high = 1e-6, math.pi / 2
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if of_angle(middle)[0] < 1 else (low, middle)
    return of_angle(middle)[1]


def end_deflection(path):
    _, steps = read_steps(path)
    particles = steps[-1][0]
    u = field(particles.point_data, "displacement")[:, 1]
    x = (points(particles) - field(particles.point_data, "displacement"))[:, 0]
    last, before = sorted(set(np.round(x, 7)))[-2:][::-1]
    a, b = (np.mean(u[np.abs(x - place) < 1e-6]) for place in (before, last))
    return b + (b - a) / (last - before) * (1 - last)


def test_a_cantilever_that_bends_by_most_of_its_length(hampm, tmp_path):
    """Bilinear cells err by the square of their size; shear and stretch make the beam, of a fiftieth of its length, 0.07 % softer."""
    asked = elastica(10.0)
    assert asked == pytest.approx(0.81061, abs=1e-5)         # Bisshopp & Drucker 1945, table of P L**2/(E I)
    found = []
    for cell in 0.02 / 2, 0.02 / 4:
        (tmp_path / "beam.nml").write_text(BEAM.format(cell=cell, nx=round(1 / cell) + 1, ny=round(0.02 / cell) + 1,
                                                       force="0.0, 80.0", steps=5))
        rows = run(hampm, "beam.nml")
        assert rows["distance_to_equilibrium"] < 1e-8 and rows["warnings"] == ""
        found.append(end_deflection(tmp_path / "out.h5"))
    print("deflection over the length, asked", asked, "measured", found)
    assert found[0] == pytest.approx(asked, rel=5e-3)
    assert found[1] == pytest.approx(asked, rel=1e-3)
    assert found[1] + (found[1] - found[0]) / 3 == pytest.approx(asked, rel=1e-3)


@pytest.mark.parametrize("steps, most", [(1, 1.0), (4, 1.3)])
def test_a_column_is_followed_to_where_it_buckles(hampm, tmp_path, steps, most):
    """Euler's load, pi**2 E I/(4 L**2); cells of half its depth are 25 % too stiff in bending, those of a quarter 6 %."""
    euler = math.pi**2 * 12e6 * 0.02**3 / 12 / 4
    cell = 0.005
    (tmp_path / "column.nml").write_text(BEAM.format(cell=cell, nx=202, ny=6, force=f"{-4 * euler * most}, 0.0", steps=steps))
    result = run(hampm, "column.nml", code=3)
    found = re.search(r"step (\d+), .*not stable. It was followed through (\S+) % of this load step.*limit point", result)
    with h5py.File(tmp_path / "out.h5") as file:
        done = file["history/time"][-1]
    reached = (done + float(found[2]) / 100 / steps) * 4 * most
    print("buckles at", reached, "of Euler's load")
    assert reached == pytest.approx(1.0, rel=0.08)


def test_two_columns_that_buckle_at_once(hampm, tmp_path):
    """Two eigenvalues change their sign at the same load: the determinant of the stiffness stays positive. Euler's load, as above."""
    euler = math.pi**2 * 12e6 * 0.02**3 / 12 / 4
    columns = "".join(f"""\
&body material = 'a'  lower = 0.0, {y}  upper = 1.0, {y + 0.02} /
&load kind = 'traction'  lower = 1.0, {y}  upper = 1.0, {y + 0.02}  force = {-4 * euler * 1.3}, 0.0  history = 'ramp'  rise_time = 1.0 /
""" for y in (0.0, 0.05))
    (tmp_path / "columns.nml").write_text(f"""\
&run plane = 'stress'  thickness = 1.0  end_time = 1.0 /
&grid lower = -0.05, -0.05  cell = 0.005  cells = 212, 34 /
&material name = 'a'  young = 12e6  poisson = 0.0  density = 1000  law = 'neo_hookean' /
&body material = 'a'  lower = -0.05, 0.0  upper = 0.0, 0.07 /
&constraint lower = -0.05, 0.0  upper = 0.0, 0.07  fix = 'xy' /
{columns}&method time = 'static' /
""")
    result = run(hampm, "columns.nml", code=3)
    found = re.search(r"not stable. It was followed through (\S+) % of this load step.*limit point", result)
    assert float(found[1]) / 100 * 4 * 1.3 == pytest.approx(1.0, rel=0.08)


def test_a_double_cantilever_beam_that_is_opened(hampm, tmp_path):
    """With the end moved by d, force P: G is P**2/(2 B) dC/da of both arms, by compliances C = 2 d/P of cracks a cell longer and
    shorter, and J in each run. Cells of the same size everywhere, so that the derivative is that of the same mesh."""
    scene = (INPUT / "dcb.nml").read_text()
    scene = re.sub(r"&load.*?\n/\n", """&constraint lower = 0.0, 0.0 upper = 0.0, 0.0 fix = 'y' displacement = 0.0, 1e-5 name = 'pin' /
""", scene, flags=re.S)
    compliance, j = {}, {}
    for tip in 0.04875, 0.05, 0.05125:
        text = scene.replace("lower = 0.05, 0.0", f"lower = {tip}, 0.0").replace("tip = 0.05, 0.0", f"tip = {tip}, 0.0")
        (tmp_path / "opened.nml").write_text(text.replace("reference = 'dcb'", "reference = 'none'"))
        rows = run(hampm, "opened.nml", *STATIC)
        force = rows["reaction_pin_y"][-1]
        compliance[tip], j[tip] = 2 * 1e-5 / force, rows["J"][-1] / force**2
        assert rows["external_work"][-1] == pytest.approx(force * 1e-5 / 2, rel=1e-9)
    by_compliance = (compliance[0.05125] - compliance[0.04875]) / 2.5e-3 / (2 * 0.01)
    print("G/P**2 by compliance", by_compliance, "J/P**2", j[0.05])
    assert j[0.05] == pytest.approx(by_compliance, rel=2e-3)


# --- meshes and solvers -----------------------------------------------------------------------------------------------


def test_cells_refine_until_the_estimated_error_is_small_enough(hampm):
    """G of the beam, 1.28737 G_ref (p-version finite elements, tests/reference), from cells of half an arm, unattended."""
    rows = run(hampm, INPUT / "dcb.nml", *STATIC, "grid.cell=5e-3", "grid.cells=20,3", "refine.indicator=zz", "refine.tolerance=0.03",
               "refine.max_level=12", "output.snapshot_interval=0", *AT_REST)
    assert rows["error_estimate"][-1] <= 0.03 and rows["warnings"] == ""
    assert rows["J"][-1] / rows["G_ref"] == pytest.approx(1.28737, rel=1e-3)
    assert rows["G_vcct_I"][-1] / rows["G_ref"] == pytest.approx(1.28737, rel=3e-3)
    assert rows["external_work"][-1] == pytest.approx(rows["strain_energy"][-1], rel=1e-9)     # a linear scene is found anew on each mesh


def test_the_estimated_error_is_that_of_the_energy(hampm):
    """At rest under given loads the squared error in the energy norm is twice the energy that is missing: of a cantilever, by cells of half the size. 16 particles a cell
    integrate it well; four hold three quarters of the energy of bending within cells."""
    energy, estimate = [], []
    for cells in (4, 8):
        rows = run(hampm, f"""&run plane = 'stress'  thickness = 0.01  end_time = 1.0 /
&grid lower = 0.0, 0.0  cell = {0.04 / cells}  cells = {5 * cells + 1}, {cells + 1} /
&material name = 'm'  young = 70e9  poisson = 0.3  density = 2700 /
&body material = 'm'  points_per_cell = 4  lower = 0.0, 0.0  upper = 0.2, 0.04 /
&constraint lower = 0.0, 0.0  upper = 0.0, 0.04  fix = 'x' /
&constraint lower = 0.0, 0.0  upper = 0.0, 0.0  fix = 'y' /
&load kind = 'traction'  lower = 0.2, 0.0  upper = 0.2, 0.04  force = 0.0, 100.0 /
&load kind = 'traction'  lower = 0.0, 0.0  upper = 0.0, 0.04  force = 0.0, -100.0 /
&refine indicator = 'zz'  tolerance = 0.9  max_level = 1 /
&method time = 'static'  load_steps = 1 /
&output file = 'out.h5' /
""")
        energy.append(rows["strain_energy"][-1])
        estimate.append(rows["error_estimate"][-1])
    missing = (energy[1] - energy[0]) * np.array([4 / 3, 1 / 3])           # of the second order
    true = np.sqrt(missing / (energy[1] + missing[1]))
    print("estimated", estimate, "over the true one", estimate / true)
    assert estimate == pytest.approx(true, rel=0.15)


@pytest.mark.parametrize("scene", ["dcb", "closed_crack"])
def test_all_solvers_find_the_same(hampm, scene):
    path = INPUT / "dcb.nml" if scene == "dcb" else REGRESSION / scene / "case.nml"
    found = [run(hampm, path, *STATIC, "output.snapshot_interval=0", f"method.solver={solver}")
             for solver in ("direct", "cg")]
    for rows in found[1:]:
        assert rows["J"][-1] == pytest.approx(found[0]["J"][-1], rel=1e-8)
        assert rows["strain_energy"][-1] == pytest.approx(found[0]["strain_energy"][-1], rel=1e-9)


def test_faces_that_open_and_close_with_a_law_of_finite_strain(hampm, tmp_path):
    """Faces in touch answer a load, however small, otherwise than their tangent: some of them open."""
    text = re.sub(r"kind = 'line'.*", "kind = 'line'  contact = 'frictionless'", (INPUT / "mixed_mode.nml").read_text())
    (tmp_path / "case.nml").write_text(text)
    linear, finite = (run(hampm, "case.nml", *STATIC, f"material.law={law}", "method.load_steps=2", "output.snapshot_interval=0")
                      for law in ("linear_elastic", "neo_hookean"))
    for name in ("G", "G_domain_I", "G_domain_II", "strain_energy"):
        assert finite[name][-1] == pytest.approx(linear[name][-1], rel=1e-5), name


# --- where there is none ----------------------------------------------------------------------------------------------

PLATE = """
&run thickness = 0.01  end_time = 1.0 /
&grid lower = 0.0, 0.0  cell = 2.5e-3  cells = 18, 6 /
&material name = 'a'  young = 70e9  poisson = 0.3  density = 2700 /
&body material = 'a'  lower = 0.0, 0.0  upper = 0.04, 0.01 /
{constraints}
&load kind = 'traction'  lower = 0.04, 0.0  upper = 0.04, 0.01  force = {force} /
{more}
&method time = 'static' /
"""
HOLD = "&constraint lower = 0.0, 0.0  upper = 0.0, {}  fix = '{}' /"
UNHELD = [("", "1.0, 0.0", r"moves along x, as the loads push with 1.0 N and no &constraint with fix = 'x'"),
          (HOLD.format(0.01, "x"), "0.0, 2.0", "moves along y, as the loads push with 2.0 N"),
          (HOLD.format(0.0, "xy"), "0.0, 1.0", "turns, as the loads have a moment")]


@pytest.mark.parametrize("constraints, force, phrase", UNHELD)
def test_what_nothing_holds_is_named(hampm, tmp_path, constraints, force, phrase):
    (tmp_path / "plate.nml").write_text(PLATE.format(constraints=constraints, force=force, more=""))
    result = run(hampm, "plate.nml", code=3)
    assert phrase in result and "the piece of body 1" in result


def test_loads_that_balance_each_other_need_no_constraint(hampm, tmp_path):
    pull = "&load kind = 'traction'  lower = 0.0, 0.0  upper = 0.0, 0.01  force = -3.0, 0.0 /"
    (tmp_path / "plate.nml").write_text(PLATE.format(constraints="", force="3.0, 0.0", more=pull))
    rows = run(hampm, "plate.nml")
    assert rows["strain_energy"][-1] == pytest.approx(3.0**2 * 0.04 / (2 * 70e9 * 1e-4), rel=1e-9)


CANCEL = """&run end_time = 4.0 /
&grid lower = {low}  cell = 0.005  cells = {cells} order = {order} /
&material name = 's'  young = 200e9  poisson = 0.3  density = 7850.0 {law} /
&body material = 's'  lower = {lower}  upper = {upper} points_per_cell = 3 /
{loads}
&method time = 'static'  load_steps = 4 /
"""
FACTORS = [(1.0, "history = 'step'"), (-1.0, "history = 'step'")], [(1.0, "history = 'table' times = 0, 1, 2, 3, 4  factors = 0, 1, 0, -1, 0")]


@pytest.mark.parametrize("pairs", FACTORS, ids=["that cancel", "through 0"])
@pytest.mark.parametrize("law, order", [("", 1), ("law = 'neo_hookean'", 1), ("", 2)])
@pytest.mark.parametrize("solid", [False, True], ids=["plane", "solid"])
def test_loads_of_a_free_body_that_are_nothing_at_times(hampm, hampm3d, solid, law, order, pairs):
    """Pairs of tractions that cancel, or whose factor passes 0, leave rounding of loads of 1e4 N: no motion, and nothing stored. Each pair by itself stores F^2 l/(2 E A)."""
    if solid and order == 2:
        pytest.skip("cells of solids are linear")
    more = ", 0.01" if solid else ""
    loads = "\n".join(f"&load kind = 'traction'  lower = 0.0, {side * 0.04}{', 0.0' if solid else ''}  upper = 0.02, {side * 0.04}{more}  "
                      f"force = 0.0, {factor * side * 1e4}{', 0.0' if solid else ''}  {history} /" for factor, history in pairs for side in (1, -1))
    text = CANCEL.format(low="-0.005, -0.045" + (", -0.005" if solid else ""), cells="6, 18" + (", 4" if solid else ""), order=order, law=law,
                         lower="0.0, -0.04" + (", 0.0" if solid else ""), upper="0.02, 0.04" + more, loads=loads)
    if not solid:
        text = text.replace("&run", "&run plane = 'stress'  thickness = 0.01")
    else:
        text = text.replace(f"order = {order}", "")
    rows = run(hampm3d if solid else hampm, text)
    stored = 1e4**2 * 0.08 / (2 * 200e9 * 2e-4)
    expected = [0.0] * 5 if len(pairs) > 1 else [0.0, stored, 0.0, stored, 0.0]
    assert rows["strain_energy"] == pytest.approx(expected, rel=1e-3, abs=1e-12 * stored)
    assert ("nothing has moved" in rows.said) == (len(pairs) > 1)


def test_a_load_that_no_material_bears(hampm, tmp_path):
    text = BEAM.format(cell=0.01, nx=101, ny=3, force="0.0, 1e12", steps=1)
    (tmp_path / "beam.nml").write_text(text)
    result = run(hampm, "beam.nml", code=3)
    assert "followed through" in result and "too large for the material" in result


# --- one particle in a cell -------------------------------------------------------------------------------------------

LONE = """&run plane = '{plane}'  end_time = {end} /
&grid lower = 0.0, 0.0  cell = {cell}  cells = {across}, {up} /
&material name = 'm'  young = 1e6  poisson = {nu}  density = 1.0 {law} /
&body material = 'm'  points_per_cell = {points}  lower = 0.0, 0.0  upper = 8.0, 1.0 /
&constraint lower = 0.0, 0.0  upper = 0.0, 1.0  fix = '{fix}' /
&constraint lower = 0.0, 0.0  upper = {bottom}, 0.0  fix = 'y' /
&load kind = 'traction'  lower = 8.0, 0.0  upper = 8.0, 1.0  force = {force} /
&method time = '{time}'  {step} /
&energy_release /
"""


def work_of_beam(hampm, cells, points=1, plane="stress", nu=0.3, fix="xy", force="0.0, 1.0", law="", time="static", step="", end=1.0):
    """Work of the load on a beam that is eight times as long as it is deep [J]."""
    bottom = 8.0 if fix == "x" else 0.0
    (hampm.folder / "beam.nml").write_text(LONE.format(cell=1 / cells, across=8 * cells + 1, up=cells + 1, **{
        key: value for key, value in locals().items() if key not in ("hampm", "cells")}))
    return run(hampm, "beam.nml")["external_work"][-1]


def test_lone_particles_leave_a_linear_field_alone(hampm):
    """Tension of 1 N on 1 m2, held in x on one side and in y below."""
    assert work_of_beam(hampm, 4, fix="x", force="1.0, 0.0") == pytest.approx(8 / 2e6, rel=1e-12)
    assert work_of_beam(hampm, 4, fix="x", force="1.0, 0.0", plane="strain", nu=0.45) == pytest.approx(8 * (1 - 0.45**2) / 2e6, rel=1e-12)


@pytest.mark.parametrize("cells", [2, 4, 8])
def test_a_beam_of_lone_particles_bends(hampm, cells):
    """Against bending and shear of a cantilever (Timoshenko), whose clamped end, of which theory knows nothing, makes it 0.23 % stiffer."""
    theory = (4 * 8**3 + 1.2 * 8 * 2.6) / 2e6
    assert work_of_beam(hampm, cells) / theory == pytest.approx(0.9977, abs=0.04 / cells**2)


def test_a_beam_of_lone_particles_does_not_lock(hampm):
    coarse, fine = (work_of_beam(hampm, cells, plane="strain", nu=0.49) for cells in (2, 8))
    assert coarse == pytest.approx(fine, rel=0.03)


@pytest.mark.parametrize("law, near", [("law = 'neo_hookean'", 0.01), ("law = 'viscoelastic'  moduli = 3.4e5  relaxation_times = 0.01", 1 / 4**2),
                                       ("law = 'j2_plastic'  yield_stress = 40.0  hardening = 1e5", 1 / 4**2)])
def test_a_beam_of_lone_particles_of_other_laws(hampm, law, near):
    """Against four particles in smaller cells. Cells that yield or relax are hardly held: their own bending is (1/4)**2 of that of a beam of four."""
    assert work_of_beam(hampm, 4, law=law) == pytest.approx(work_of_beam(hampm, 16, points=2, law=law), rel=near)


def test_a_beam_of_lone_particles_in_implicit_steps(hampm):
    alone, four = (work_of_beam(hampm, 2, points=points, time="implicit", step="time_step = 2e-3", end=0.06) for points in (1, 2))
    assert alone == pytest.approx(four, rel=0.01)              # 7.8 % more where nothing holds how cells are bent


def test_J_of_lone_particles(hampm):
    """A double cantilever beam with eight cells an arm."""
    words = "method.time=static", "method.frame=total", "method.courant=0", "damping.rate=0", "output.history_interval=0", "grid.cell=1.25e-3", "grid.cells=80,12"
    alone, four = (run(hampm, INPUT / "dcb.nml", *words, f"body.points_per_cell={points}")["J"][-1] for points in (1, 2))
    assert alone == pytest.approx(four, rel=0.005)


@pytest.mark.parametrize("law", ["law = 'neo_hookean'", "law = 'mooney_rivlin'  c01 = 4e4"])
@pytest.mark.parametrize("plane", ["strain", "stress"])
@pytest.mark.parametrize(("stretch", "way"), [(0.0, 0.1), (0.0, 1e-9), (0.0, 1e3), (0.05, 0.1), (0.05, 1e3)])
def test_a_body_that_is_only_carried_along(hampm, law, plane, stretch, way):
    """Stretched or not, it has the stress and energy from before: nothing but rounding has done work."""
    table = "history = 'table'  times = 0.0, 1.0, 2.0  factors"
    row = run(hampm, f"""
        &run plane = '{plane}'  thickness = 0.01  end_time = 2.0 /
        &grid lower = -1.0, -1.0  cell = 0.25  cells = 16, 12 /
        &material name = 'm'  {law}  young = 1e6  poisson = 0.3  density = 1.0 /
        &body material = 'm'  lower = 0.0, 0.0  upper = 1.0, 1.0 /
        &constraint lower = 0.0, 0.0  upper = 1.0, 0.0  fix = 'xy'  displacement = {way}, {way/3}  {table} = 0.0, 0.0, 1.0 /
        &constraint lower = 0.0, 1.0  upper = 1.0, 1.0  fix = 'x'  displacement = {way}, 0.0  {table} = 0.0, 0.0, 1.0 /
        &constraint lower = 0.0, 1.0  upper = 1.0, 1.0  fix = 'y'  displacement = 0.0, 1.0  {table} = 0.0, {stretch}, {stretch + way/3} /
        &method time = 'static'  load_steps = 4 /
        &output file = 'out.h5'  snapshot_interval = 2.0 /""")
    energy = row["strain_energy"]
    assert energy[-1] == pytest.approx(energy[2], rel=1e-9, abs=1e-12 * 1e4 * min(way, 1.0)**2)
    assert (energy[2] > 0.1) == (stretch > 0)
    assert row["displacement"][:, 0].mean() == pytest.approx(way, rel=1e-12)


def test_work_on_a_mesh_that_refines_is_what_is_stored_on_it(hampm):
    """With cohesion that stays whole, which lets no step begin anew, under a load and with an edge that is moved. The full load on what finer cells give way was 17 %
    too much in one step of such a plate, and the moved edge 0.7 % too little. Where cohesion gives way, too, all but what a step tells by its mean force is booked."""
    text = """\
&run plane = 'strain'  thickness = 0.2  end_time = 1.0 /
&grid lower = -0.6, 0.0  cell = 0.1  cells = 13, 12 /
&material name = 'm'  density = 700.0  young = 18e9  poisson = 0.1 /
&body material = 'm'  lower = -0.5, 0.1  upper = 0.6, 1.1 /
&constraint lower = -0.5, 0.1  upper = 0.6, 0.1  fix = 'xy' /
&load kind = 'traction'  lower = -0.5, 1.1  upper = 0.6, 1.1  force = 8e4, 4e5  history = 'ramp'  rise_time = 1.0 /
&method time = 'static' /
&refine indicator = 'gradient'  max_level = 1  r_crit = 0.03  field = 'stress_norm' /
&crack kind = 'path'  points = -0.23, 0.631, 0.3, 0.631 /
&cohesive law = 'table'  openings = 0.0, 4.5e-5, 1.35e-4  tractions = 3.6e6, 1.4e6, 0.0 /
"""
    moved = text.replace("&load", "&constraint fix = 'y'  displacement = 0.0, 1e-6 ").replace("  kind = 'traction'", "").replace("force = 8e4, 4e5  ", "")
    for scene in (text, text.replace("'gradient'", "'zz'").replace("r_crit = 0.03  field = 'stress_norm'", "tolerance = 0.02"), moved):
        for steps in (1, 5):
            found = run(hampm, scene, f"method.load_steps={steps}")
            assert found["cells"][-1] > 156 and np.all(found["cohesive_energy"] == 0)
            assert np.max(np.abs(found["external_work"] - found["strain_energy"])) < 1e-9 * found["strain_energy"][-1]
