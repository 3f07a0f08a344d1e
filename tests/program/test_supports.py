"""Supports that only push: material lifts off them, at rest and in implicit steps. The forces of those that are left follow from the
balance of forces and moments alone; a half of a body on one is what a whole body with a crack in contact is; a bar that meets one leaves it
as waves have it."""

import h5py
import numpy as np
import pytest

import harness

BEAM = """
&run plane = 'stress'  thickness = 0.01  end_time = 1.0 /
&grid lower = 0.0, 0.0  cell = {cell}  cells = {nx}, {ny}  order = {order} /
&material name = 'a'  young = 70e9  poisson = 0.3  density = 2700  law = '{law}' {more} /
&body material = 'a'  lower = 0.0, 0.0  upper = 0.2, 0.01  points_per_cell = {points} /
&constraint lower = 0.0, 0.0  upper = 0.0, 0.0  fix = 'x' /
&constraint lower = 0.0, 0.0  upper = 0.0, 0.0  fix = 'y'  unilateral = .true.  name = 'a' /
&constraint lower = 0.1, 0.0  upper = 0.1, 0.0  fix = 'y'  unilateral = .true.  name = 'b' /
&constraint lower = 0.2, 0.0  upper = 0.2, 0.0  fix = 'y'  unilateral = {push}  name = 'c' {motion} /
&load kind = 'point'  lower = {at}, 0.01  upper = {at}, 0.01  force = 0.0, {force}  history = 'ramp'  rise_time = 1.0 /
&refine indicator = '{refine}'  max_level = 1 /
&method time = 'static'  load_steps = {steps}  solver = '{solver}' /
"""
VALUES = {"cell": 2.5e-3, "law": "linear_elastic", "push": ".true.", "at": 0.05, "force": -10.0, "refine": "none", "steps": 1,
          "solver": "auto", "motion": "", "order": 1, "more": ""}
YIELDS = "yield_stress = 1e4  hardening = 1e9"
CREEPS = "moduli = 5e9, 1e10  relaxation_times = 0.1, 1.0"


def run(hampm, code=0, **values):
    values = VALUES | values
    text = BEAM.format(nx=round(0.2 / values["cell"]), ny=round(0.01 / values["cell"]) + 1, points=1 + values["order"], **values)
    return harness.run(hampm, text, code=code)


WAYS = [{}, {"steps": 4}, {"law": "neo_hookean"}, {"refine": "zz"}, {"solver": "cg"}, {"order": 2},
        {"order": 2, "law": "neo_hookean", "steps": 4}, {"order": 2, "refine": "zz"},
        {"law": "j2_plastic", "more": YIELDS, "steps": 4}, {"law": "viscoelastic", "more": CREEPS, "steps": 4},
        {"law": "viscoelastic", "more": CREEPS, "steps": 4, "order": 2}]


@pytest.mark.parametrize("values", WAYS, ids=str)
def test_a_beam_lifts_off_the_support_that_would_pull(hampm, values):
    """A load between the first two of three supports: the third would pull the beam down."""
    row = run(hampm, **values)
    assert row["reaction_a_y"][-1] == pytest.approx(5.0, rel=1e-5)        # what is deformed at equilibrium shifts it: neo-Hookean
    assert row["reaction_b_y"][-1] == pytest.approx(5.0, rel=1e-5)
    assert row["reaction_c_y"][-1] == 0
    if values.get("more"):
        return
    gone = {"neo_hookean": 1e-5}.get(values.get("law"), 0.02 if "refine" in values else 1e-9)    # finer cells give way after the work
    assert row["external_work"][-1] == pytest.approx(row["strain_energy"][-1], rel=gone)


def test_a_support_that_holds_pulls(hampm):
    """The same beam held at its end: the beam on three supports, moments 3/32 P L; shear, and the cells, change that a little."""
    row = run(hampm, push=".false.", cell=1.25e-3)
    assert row["reaction_c_y"][-1] == pytest.approx(-10 * 3 / 32, rel=0.03)
    assert row["reaction_a_y"][-1] == pytest.approx(10 * 13 / 32, rel=0.03)


def test_a_support_that_comes_nearer_pushes_again(hampm):
    """The third support is raised by a history: it touches once it is where the free end is, and takes what the beam gives way."""
    held = run(hampm, push=".false.", motion="displacement = 0.0, 1e-4 history = 'ramp' rise_time = 1.0", steps=8)
    row = run(hampm, motion="displacement = 0.0, 1e-4 history = 'ramp' rise_time = 1.0", steps=8)
    pushes = held["reaction_c_y"] > 1e-6
    assert pushes.any()
    assert row["reaction_c_y"][pushes] == pytest.approx(held["reaction_c_y"][pushes], rel=1e-9)
    assert np.all(row["reaction_c_y"][~pushes] == 0)
    assert np.all(row["reaction_c_y"] >= 0)


def test_material_that_is_pulled_off_all_supports_is_named(hampm):
    error = run(hampm, code=3, force=10.0)
    assert "has no equilibrium" in error


def test_it_takes_no_explicit_steps_and_an_edge(hampm, tmp_path):
    text = BEAM.format(nx=80, ny=5, points=2, **VALUES)
    (tmp_path / "a.nml").write_text(text.replace("time = 'static'  load_steps = 1", "time = 'explicit' frame = 'total'"))
    result = hampm("a.nml")
    assert result.returncode == 2
    assert "unilateral" in result.stderr
    (tmp_path / "b.nml").write_text(text.replace("lower = 0.1, 0.0  upper = 0.1, 0.0", "lower = 0.1, 0.005  upper = 0.1, 0.005"))
    result = hampm("b.nml", "--check")
    assert result.returncode == 2
    assert "both sides in y" in result.stderr
    (tmp_path / "c.nml").write_text(text.replace("unilateral = .true.", "unilateral = 'yes'"))
    result = hampm("c.nml")
    assert result.returncode == 2
    assert "must be .true. or .false." in result.stderr


BLOCK = """
&run plane = 'strain'  thickness = 0.01  end_time = 1.0 /
&grid lower = 0.0, {bottom}  cell = 2.5e-3  cells = 16, {ny} /
&material name = 'a'  young = 70e9  poisson = 0.2  density = 2700 /
&body material = 'a'  lower = 0.0, {bottom}  upper = 0.04, 0.02 /
&constraint lower = 0.0, 0.0  upper = 0.0, 0.0  fix = 'x' /
&constraint lower = 0.03, 0.0  upper = 0.04, 0.0  fix = 'y'  name = 'rest' /
&load kind = 'traction'  lower = 0.005, 0.02  upper = 0.01, 0.02  force = 0.0, -1e3 /
&load kind = 'traction'  lower = 0.025, 0.02  upper = 0.03, 0.02  force = 0.0, 1e3 /
{rest}
&method time = 'static' /
"""
HALF = "&constraint lower = 0.0, 0.0  upper = 0.0275, 0.0  fix = 'y'  unilateral = .true.  name = 'base' /"
WHOLE = """&load kind = 'traction'  lower = 0.005, -0.02  upper = 0.01, -0.02  force = 0.0, 1e3 /
&load kind = 'traction'  lower = 0.025, -0.02  upper = 0.03, -0.02  force = 0.0, -1e3 /
&crack kind = 'line'  tip = 0.03, 0.0  direction = 1.0, 0.0  contact = 'frictionless' /"""


@pytest.mark.parametrize(("at", "across"), [((5.0, 3.0), "y"), ((1.0, 3.0), "y"), ((3.0, 5.0), "x"), ((3.0, 1.0), "x")], ids=["right", "left", "top", "bottom"])
def test_a_support_along_an_edge_has_material_on_both_sides(hampm, at, across):
    """In the middle of any edge of a square, for the direction along it."""
    hold = f"{6 - at[0]}, {6 - at[1]}"               # opposite
    said = harness.run(hampm, f"""&run plane = 'strain'  end_time = 1.0 /
&grid lower = 0.0, 0.0  cell = 1.0  cells = 6, 6 /
&material name = 'a'  young = 1e9  poisson = 0.3  density = 1000 /
&body material = 'a'  lower = 1.0, 1.0  upper = 5.0, 5.0 /
&constraint lower = {hold}  upper = {hold}  fix = 'xy' /
&constraint lower = {at[0]}, {at[1]}  upper = {at[0]}, {at[1]}  fix = '{across}'  unilateral = .true. /
&method time = 'static' /
""", code=2)
    assert f"the node at ({at[0]}, {at[1]}) m has material on both sides in {across}" in said


@pytest.mark.parametrize("order", [(), ("--set", "grid.order=2", "--set", "body.points_per_cell=3")], ids=["bilinear", "quadratic"])
def test_half_a_body_on_a_support_is_half_of_a_body_with_a_crack_in_contact(hampm, tmp_path, order):
    """A part of the faces opens. Pressed faces are held by a layer that hardly gives way on one way, nodes are fixed on the other."""
    energy = {}
    for name, bottom, ny, rest in ("half", 0.0, 8, HALF), ("whole", -0.02, 16, WHOLE):
        (tmp_path / f"{name}.nml").write_text(BLOCK.format(bottom=bottom, ny=ny, rest=rest))
        result = hampm(f"{name}.nml", "--force", "--quiet", *order)
        assert result.returncode == 0, result.stderr
        with h5py.File(tmp_path / f"{name}.h5") as file:
            energy[name] = file["history/strain_energy"][-1]
            if name == "half":
                force = file["history/reaction_base_y"][-1] + file["history/reaction_rest_y"][-1]
                assert file["history/reaction_base_y"][-1] > 100
                assert abs(force) < 1e-6
    assert energy["whole"] == pytest.approx(2 * energy["half"], rel=2e-6)


def both_halves(hampm, tmp_path, half, whole, *settings):
    """The histories of half a block on a support and of a whole one with a crack, by name."""
    rows = {}
    for name, scene in (("half", half), ("whole", whole)):
        (tmp_path / f"{name}.nml").write_text(scene)
        result = hampm(f"{name}.nml", "--force", "--quiet", *(word for one in settings for word in ("--set", one)))
        assert result.returncode == 0, result.stderr
        with h5py.File(tmp_path / f"{name}.h5") as file:
            rows[name] = {column: values[:] for column, values in file["history"].items()}
    return rows["half"], rows["whole"]


SWINGING = BLOCK.replace("end_time = 1.0", "end_time = {end}").replace("&method time = 'static' /", """
&method time = '{time}' /
&energy_release energy_balance = .true. /
&output history_interval = 1e-6 /""").replace("density = 2700 /", "density = 2700 {law} /")
SINE = "history = 'sine' frequency = 5e4 /"
QUADRATIC = ("grid.order=2", "body.points_per_cell=3")


@pytest.mark.parametrize("settings, law", [
    ((), ""), (("method.mass=consistent",), ""), (("method.mass=consistent", *QUADRATIC), ""), (QUADRATIC, ""),
    ((), "law = 'neo_hookean'"), ((), "law = 'j2_plastic' yield_stress = 1e7 hardening = 1e9"),
    (QUADRATIC, "law = 'viscoelastic' moduli = 1e9, 2e10 relaxation_times = 1e-5, 1e-6")])
def test_faces_and_supports_part_and_meet_in_implicit_steps(hampm, tmp_path, settings, law):
    """The block shaken: its half on the support is half of the whole with a crack whose faces part and meet, but for what their layer gives way by
    (docs/explanation/contact.md): a few parts in a hundred. The audit closes, and nodes that meet a support lose energy, of the order of theirs. With laws
    that dissipate there is the error of the rule of trapezoids for the work of the internal forces, -(w dt)^2/12 of what is dissipated in a
    motion of frequency w (docs/explanation/implicit.md), here w of the load and overtones of it: it is of order 2, and steps half as long tell what is left."""
    scenes = [SWINGING.format(bottom=bottom, ny=ny, rest=rest, end=4e-5, time="implicit", law=law)
              for bottom, ny, rest in ((0.0, 8, HALF.replace("0.0275", "0.029")), (-0.02, 16, WHOLE))]
    for k, scene in enumerate(scenes):
        scene = scene.replace("direction = 1.0, 0.0", "direction = 1.0, 0.0 length = 0.03")
        for force in ("-1e3", "1e3"):
            scene = scene.replace(f"force = 0.0, {force} /", f"force = 0.0, {force} {SINE}")
        scenes[k] = scene
    half, whole = both_halves(hampm, tmp_path, *scenes, "method.time_step=1e-6", *settings)
    for column in ("kinetic_energy", "strain_energy", "external_work"):
        print(column, np.max(np.abs(whole[column] - 2 * half[column])) / np.max(np.abs(whole[column])))
        assert whole[column] == pytest.approx(2 * half[column], rel=0, abs=0.04 * np.max(np.abs(whole[column])))
    loss = whole["numerical_loss"][-1]
    if any(column.endswith("_dissipation") for column in whole):
        finer = both_halves(hampm, tmp_path, *scenes, "method.time_step=5e-7", *settings)[1]["numerical_loss"][-1]
        print("order of the loss in dt", np.log2(loss / finer))
        assert 1.5 < np.log2(loss / finer) < 2.5
        loss = (4 * finer - loss) / 3
    assert np.abs(loss) < 0.02 * np.max(whole["strain_energy"])
    took = sum(half.get(column, 0) for column in ("kinetic_energy", "strain_energy", "numerical_loss", "plastic_dissipation", "viscous_dissipation"))
    assert took == pytest.approx(half["external_work"], rel=0, abs=1e-12 * np.max(half["external_work"]))
    pressed = half["reaction_base_y"] > 1
    assert pressed.any() and not pressed.all() and np.all(half["reaction_base_y"] >= 0)
    if not law:
        assert 0 < half["numerical_loss"][-1] < 0.02 * np.max(half["strain_energy"])


def test_a_bar_leaves_a_support_when_its_wave_is_back(hampm, tmp_path):
    """Under the force of a front, speed x impedance, for the time of a wave there and back; then it flies as fast as it came. What its
    lowest nodes had is lost, as they are on the support from the start."""
    (tmp_path / "bar.nml").write_text("""
&run plane = 'stress'  thickness = 0.01  end_time = 8e-5 /
&grid lower = 0, 0  cell = 2.5e-3  cells = 4, 40 /
&material name = 'a'  young = 70e9  poisson = 0.0  density = 2800 /
&body material = 'a'  lower = 0, 0  upper = 5e-3, 0.1  velocity = 0, -1 /
&constraint lower = 0, 0  upper = 5e-3, 0  fix = 'y'  unilateral = .true.  name = 'floor' /
&energy_release energy_balance = .true. /
&method time = 'implicit'  time_step = 2.5e-7 /
&output history_interval = 1e-6 /
""")
    result = hampm("bar.nml", "--force", "--quiet")
    assert result.returncode == 0, result.stderr
    with h5py.File(tmp_path / "bar.h5") as file:
        row = {name: column[:] for name, column in file["history"].items()}
    force, back = 5e-5 * np.sqrt(70e9 * 2800), 0.2 / np.sqrt(70e9 / 2800)
    push = row["reaction_floor_y"]
    assert push[(row["time"] > 0.2 * back) & (row["time"] < 0.8 * back)] == pytest.approx(force, rel=0.02)
    assert np.all(push[row["time"] > 1.1 * back] == 0)
    assert np.sum(push) * 1e-6 == pytest.approx((1 - 0.0125) * force * back, rel=0.02)    # 2 m v
    assert row["kinetic_energy"][-1] + row["strain_energy"][-1] == pytest.approx(row["kinetic_energy"][0], rel=1e-4)
    assert row["external_work"] == pytest.approx(0, abs=1e-12)


def test_a_node_that_bears_all_of_a_load_is_told(hampm):
    """A plate at a frictionless wall is drawn along it, and one node holds it back: what the wall holds across is not of that support."""
    (hampm.folder / "case.nml").write_text("""&run plane = 'stress' end_time = 1.0 /
&grid lower = 0.0, -0.01 cell = 0.01 cells = 21, 6 /
&material name = 'a' young = 70e9 poisson = 0.3 density = 2700 /
&body material = 'a' lower = 0.0, 0.0 upper = 0.2, 0.04 /
&constraint lower = 0.0, 0.0 upper = 0.0, 0.04 fix = 'x' /
&constraint lower = 0.0, 0.0 upper = 0.0, 0.0 fix = 'y' /
&load name = 'drawn' kind = 'traction' lower = 0.0, 0.0 upper = 0.0, 0.04 force = 0.0, 1000.0 /
&probe name = 'way' quantity = 'load_line' of = 'drawn' /
&method time = 'static' /
""")
    assert "the single held node at (0.0, 0.0) m carries 100.0 % of the load" in hampm("case.nml", "--quiet").stderr
