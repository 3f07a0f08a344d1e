"""Nodes of prescribed motion: a bar whose end is pulled away with a constant velocity v. A wave runs into it with the speed
c = sqrt(E/rho); behind it the material has the velocity v and the stress rho c v, so that the end takes the force rho c v A, and its work
rho c v**2 A t is half kinetic and half strain energy."""

import math

import h5py
import pytest

import harness

BAR = """
&run plane = 'stress'  thickness = 0.01  end_time = {end_time} /
&grid lower = 0.0, 0.0  cell = {cell}  cells = {nx}, {ny}  order = {order} /
&material name = 'a'  young = 1e9  poisson = 0.0  density = 1000  law = '{law}' /
&body material = 'a'  lower = 0.0, 0.0  upper = 0.1, 0.004  points_per_cell = {points} /
&constraint lower = 0.1, 0.0  upper = 0.1, 0.004  fix = 'x' {motion} name = 'end' /
&method frame = '{frame}'  scheme = '{scheme}' courant = {courant}  mass = '{mass}' /
&energy_release energy_balance = {audit} /
&refine indicator = '{refine}'  field = 'speed'  r_crit = 0.05  max_level = {levels}  interval = 5 /
&output history_interval = {end_time} /
"""
SPEED, AREA, V = 1e3, 4e-5, 0.01
TIME = 8e-5                                      # the wave has then run through four fifths of the bar


def run(hampm, motion, **values):
    values = {"end_time": TIME, "cell": 1e-3, "law": "linear_elastic", "frame": "total", "scheme": "musl", "courant": 0.3,
              "refine": "none", "levels": 0, "mass": "lumped", "audit": ".true.", "order": 1, "points": 2} | values
    cell = values["cell"]
    return harness.run(hampm, BAR.format(motion=motion, nx=round(0.1 / cell) + 2, ny=round(0.004 / cell) + 1, **values)).last()


PULLED = "velocity = 0.01, 0.0"
WAYS = [({}, PULLED), ({"scheme": "usf"}, PULLED), ({"scheme": "usavg"}, PULLED), ({"scheme": "usl"}, PULLED),
        ({"frame": "updated", "courant": 0.1}, PULLED), ({"law": "neo_hookean"}, PULLED),
        ({"refine": "gradient", "levels": 1, "cell": 2e-3}, PULLED),
        ({"mass": "consistent", "courant": 0.09}, PULLED), ({"mass": "consistent", "frame": "updated", "courant": 0.1, "scheme": "usf"}, PULLED), ({"mass": "fmpm"}, PULLED),
        ({"mass": "weighted"}, PULLED), ({"mass": "consistent", "order": 2, "points": 3, "cell": 2e-3, "courant": 0.09}, PULLED),
        ({}, f"displacement = {V * TIME}, 0.0 history = 'ramp' rise_time = {TIME}"),
        ({}, f"displacement = {V * TIME}, 0.0 history = 'table' times = 0.0, {TIME} factors = 0.0, 1.0")]


@pytest.mark.parametrize("values, motion", WAYS, ids=str)
def test_a_bar_whose_end_is_pulled_away(hampm, values, motion):
    row = run(hampm, motion, **values)
    work = 1000 * SPEED * V**2 * AREA * TIME
    assert row["external_work"] == pytest.approx(work, rel=0.01)
    assert row["kinetic_energy"] == pytest.approx(work / 2, rel=0.02)
    assert row["strain_energy"] == pytest.approx(work / 2, rel=0.02)
    loss = 0.02 if values.get("scheme") == "usl" or values.get("refine") else 6e-3    # what a sudden start loses between cells
    assert row["external_work"] == pytest.approx(row["kinetic_energy"] + row["strain_energy"], rel=loss)
    missing = row["external_work"] - row["kinetic_energy"] - row["strain_energy"] - row["numerical_loss"]
    assert abs(missing) < 1e-12 * work                       # the audit knows the work of what is moved
    assert row["reaction_end_x"] == pytest.approx(1000 * SPEED * V * AREA, rel=0.1)       # it trembles by the cells
    assert abs(row["reaction_end_y"]) < 1e-9


def test_the_work_of_a_moved_end_converges(hampm):
    """With the velocity v sin(pi t/T)**2, by a table of many points, nothing is sudden. What the work is more than the energies falls with
    the cells: particles beside the end are not as fast as that. What the time step adds to that falls with its square."""
    times = [TIME * k / 200 for k in range(201)]
    table = (f"velocity = {V}, 0.0 history = 'table' times = {', '.join(f'{t:.9g}' for t in times)} "
             f"factors = {', '.join(f'{math.sin(math.pi * t / TIME)**2:.12g}' for t in times)}")

    def lost(courant, cell):
        row = run(hampm, table, courant=courant, cell=cell, scheme="usavg")
        return row["external_work"] / (row["kinetic_energy"] + row["strain_energy"]) - 1
    by_step = [lost(courant, 2e-3) for courant in (0.4, 0.2, 0.1)]
    order = math.log2((by_step[0] - by_step[1]) / (by_step[1] - by_step[2]))
    by_cell = [lost(0.1, 2e-3), lost(0.1, 1e-3)]
    print("lost by time step", by_step, "order", order, "by cell", by_cell)
    assert order == pytest.approx(2, abs=0.1)
    assert 0 < by_cell[1] < by_cell[0] / 1.9 < 1e-3


def test_moving_there_slowly_is_being_there(hampm, tmp_path):
    """The same motion without inertia: the bar follows as a whole, as nothing else holds it."""
    text = BAR.format(motion="displacement = 1e-4, 0.0", nx=52, ny=3, cell=2e-3, end_time=1.0, law="linear_elastic", frame="total",
                      scheme="musl", courant=0.0, refine="none", levels=0, mass="lumped", audit=".true.", order=1, points=2)
    (tmp_path / "bar.nml").write_text(text.replace("courant = 0.0", "time = 'static'"))
    result = hampm("bar.nml", "--force", "--quiet")
    assert result.returncode == 0, result.stderr
    with h5py.File(tmp_path / "bar.h5") as file:
        assert file["history/strain_energy"][-1] < 1e-20
        assert abs(file["history/reaction_end_x"][-1]) < 1e-6


@pytest.mark.parametrize("values", [{}, {"frame": "updated", "courant": 0.1, "scheme": "usf"}, {"mass": "consistent", "courant": 0.09}, {"mass": "weighted", "scheme": "usl"}], ids=str)
def test_a_bar_that_moves_already_as_its_end_is_moved(hampm, values):
    """Nothing acts on it: it flies on without any stress."""
    values = {"end_time": TIME, "cell": 1e-3, "law": "linear_elastic", "frame": "total", "scheme": "musl", "courant": 0.3, "refine": "none", "levels": 0, "mass": "lumped",
              "audit": ".true.", "order": 1, "points": 2} | values
    text = BAR.format(motion=PULLED, nx=102, ny=5, **values).replace("points_per_cell = 2", f"velocity = {V}, 0.0")
    row = harness.run(hampm, text).last()
    assert row["kinetic_energy"] == pytest.approx(1000 * AREA * 0.1 * V**2 / 2, rel=1e-9)
    assert row["strain_energy"] < 1e-12 * row["kinetic_energy"]
    assert abs(row["external_work"]) < 1e-9 * row["kinetic_energy"]
