"""How far from rest a run ends, how to come there, and faces of a crack that interpenetrate."""

import math
import re

import h5py
import pytest

# A cantilever under a force at its end, all of it in one file: L = 0.1 m, depth 0.01 m
BEAM = """
&run plane = 'stress'  thickness = 0.01  end_time = {end_time} /
&grid lower = 0.0, -0.01  cell = 2.5e-3  cells = 42, 8 /
&material name = 'a'  young = 70e9  poisson = 0.0  density = 2700  law = '{law}' /
&body material = 'a'  lower = 0.0, 0.0  upper = 0.1, 0.01 /
&constraint lower = 0.0, 0.0  upper = 0.0, 0.01  fix = 'xy' /
&load kind = 'traction'  lower = 0.1, 0.0  upper = 0.1, 0.01  force = 0.0, 0.1 /
&damping rate = {rate} /
&method frame = '{frame}'  courant = {courant}  mass = '{mass}' /
&refine indicator = '{refine}'  max_level = 1  tolerance = 0.1 /
&output history_interval = {end_time} /
"""
PERIOD = 1 / (3.516 / (2 * math.pi * 0.1**2) * math.sqrt(70e9 * 0.01**2 / 12 / 2700))   # of Euler and Bernoulli's beam [s]


def beam(hampm, tmp_path, *options, **values):
    """Run the cantilever; the result of the program, and the attributes and last row of its history."""
    values = {"end_time": PERIOD / 2, "rate": 0, "frame": "total", "courant": 0.4, "mass": "lumped", "refine": "none",
              "law": "linear_elastic"} | values
    (tmp_path / "beam.nml").write_text(BEAM.format(**values))
    result = hampm("beam.nml", "--force", *options)
    assert result.returncode == 0, result.stderr
    if "--check" in options:
        return result, {}, {}
    with h5py.File(tmp_path / "beam.h5") as file:
        history = file["history"]
        return result, dict(history.attrs), {name: column[-1] for name, column in history.items()}


# A load that comes at once keeps the beam swinging around rest: what it has to give away is the strain energy of rest, always.
SWINGING = [({}, 0.01), ({"end_time": 0.31 * PERIOD}, 0.01), ({"mass": "consistent", "courant": 0.2}, 0.01),
            ({"frame": "updated", "courant": 0.2}, 0.02), ({"law": "neo_hookean"}, 0.01),
            ({"refine": "zz"}, 0.06)]            # finer cells, which come while it swings, are softer: they swing further


@pytest.mark.parametrize("values, tolerance", SWINGING, ids=str)
def test_distance_of_a_beam_that_swings_is_one(hampm, tmp_path, values, tolerance):
    _, attributes, _ = beam(hampm, tmp_path, **values)
    assert attributes["distance_to_equilibrium"] == pytest.approx(1, rel=tolerance)


def test_distance_of_a_beam_that_creeps(hampm, tmp_path):
    """Damped fifty times more than critically it hardly moves, far from where it will be: of a mode, of the angular frequency w,
    exp(-w**2 t/rate) is left. 12/1.8751**4 of the energy of rest is in the first mode; the others are there by then."""
    omega = 2 * math.pi / PERIOD
    result, attributes, row = beam(hampm, tmp_path, rate=100 * omega, end_time=12 / omega)
    assert row["kinetic_energy"] < 1e-2 * row["strain_energy"]
    assert attributes["distance_to_equilibrium"] == pytest.approx(math.sqrt(12 / 1.8751**4) * math.exp(-0.12), rel=0.01)
    assert "distance to equilibrium: 0.87" in result.stdout
    assert "about twice as far from their static values" in result.stdout


def test_check_proposes_how_to_come_to_rest(hampm, tmp_path):
    result, _, _ = beam(hampm, tmp_path, "--check", "--set", "grid.cell=1.25e-3", "--set", "grid.cells=84,16")
    found = re.search(r"to equilibrium +&damping rate = (\S+) \(lowest frequency (\S+) Hz\), &run end_time = (\S+)", result.stdout)
    rate, frequency, end_time = map(float, found.groups())
    assert frequency == pytest.approx(1 / PERIOD, rel=0.03)    # cells bend 2 % too stiffly, shear makes the beam 1 % softer
    assert rate == pytest.approx(4 * math.pi * frequency, rel=0.01)
    _, attributes, _ = beam(hampm, tmp_path, rate=rate, end_time=end_time)
    assert attributes["distance_to_equilibrium"] < 1e-3


def test_no_proposal_where_nothing_holds_the_material(hampm, tmp_path):
    text = BEAM.format(end_time=1e-4, rate=0, frame="total", courant=0.4, mass="lumped", refine="none", law="linear_elastic")
    (tmp_path / "free.nml").write_text(re.sub(r"&constraint.*", "", text))
    result = hampm("--check", "free.nml")
    assert result.returncode == 0, result.stderr
    assert "to equilibrium  &damping" not in result.stdout


# --- faces ------------------------------------------------------------------------------------------------------------

FLEXURE = """
&run plane = 'strain'  thickness = 0.01  end_time = 3e-4 /
&grid lower = 0.0, -0.005  cell = 2.5e-3  cells = 40, 12 /
&material name = 'a'  young = 70e9  poisson = 0.3  density = 2700 /
&body material = 'a'  lower = 0.0, 0.0  upper = 0.1, 0.02 /
&constraint lower = 0.0, 0.0  upper = 0.0, 0.0  fix = 'xy' /
&constraint lower = 0.1, 0.0  upper = 0.1, 0.0  fix = 'y' /
&load kind = 'point'  lower = 0.05, 0.02  upper = 0.05, 0.02  force = 0.0, {force}  history = 'ramp'  rise_time = 1e-4 /
&damping rate = 3e4 /
&method frame = 'total'  courant = 0.4 /
&crack kind = 'line'  tip = 0.03, 0.01  direction = 1.0, 0.0  contact = '{contact}' /
&energy_release estimators = 'domain_integral' /
"""


@pytest.mark.parametrize("contact, told", [("none", True), ("frictionless", False)])
def test_faces_that_go_through_each_other_are_told(hampm, tmp_path, contact, told):
    """End-notched flexure: the arms press on each other."""
    (tmp_path / "enf.nml").write_text(FLEXURE.format(contact=contact, force=-100.0))
    result = hampm("enf.nml")
    assert result.returncode == 0, result.stderr
    phrase = "the faces of the crack interpenetrate"
    with h5py.File(tmp_path / "enf.h5") as file:
        warnings = file["history"].attrs["warnings"]
        opening = file["history/mouth_opening"][:].min()
    assert (phrase in result.stderr) == (phrase in warnings) == told
    if told:
        assert opening < 0
        assert "contact = 'frictionless'" in warnings
        overlap = float(re.search(r"by up to (\S+) m", warnings)[1])
        assert overlap >= -0.999 * opening


def test_faces_that_open_are_not_told(hampm, tmp_path):
    """The flexure upside down is no other: but arms pulled apart open."""
    text = FLEXURE.format(contact="none", force=100.0)
    text = text.replace("lower = 0.05, 0.02  upper = 0.05, 0.02", "lower = 0.0, 0.02  upper = 0.0, 0.02")
    (tmp_path / "open.nml").write_text(text)
    result = hampm("open.nml")
    assert result.returncode == 0, result.stderr
    assert "interpenetrate" not in result.stderr


def test_the_overlap_is_remembered_by_a_checkpoint(hampm, tmp_path):
    (tmp_path / "enf.nml").write_text(FLEXURE.format(contact="none", force=-100.0))
    whole = hampm("enf.nml")
    stopped = hampm("enf.nml", "--force", "--steps", "600")
    assert stopped.returncode == 5 or "To go on" in stopped.stderr
    resumed = hampm("--resume", "enf.h5.checkpoint")
    told = [re.findall(r"interpenetrate.*", result.stderr) for result in (whole, resumed)]
    assert told[0] == told[1] != []


FREE = """&run plane = 'strain'  end_time = 1.2e-4 /
&grid lower = 0.0, 0.0  cell = 1e-3  cells = 30, 14 /
&material name = 'a'  young = {young}  poisson = 0.37  density = 1200.0 /
&body material = 'a'  lower = 5e-3, 2e-3  upper = 13e-3, 10e-3  {motion} /
&body material = 'a'  lower = 17e-3, 2e-3  upper = 25e-3, 10e-3 /
&method frame = 'updated' /
{loads}
"""
PULL = "&load kind = 'traction'  lower = {0}, 2e-3  upper = {0}, 10e-3  force = {1}, 0.0 /\n"


@pytest.mark.parametrize("young", [2.4e9, 70e9])
@pytest.mark.parametrize("motion, loads, told", [("velocity = 8.0, 0.0", "", False), ("", PULL.format(5e-3, -1.0), False), ("", PULL.format(5e-3, -1.0) + PULL.format(13e-3, 1.0), True)],
                         ids=["flies", "is pushed", "is pulled from both ends"])
def test_free_bodies_have_a_lowest_frequency_where_their_loads_balance(hampm, tmp_path, young, motion, loads, told):
    """Nothing holds them: what flies, or is pushed, comes to no rest, and what rounding leaves of its motion is no vibration. The first elastic one is above 20 kHz."""
    (tmp_path / "free.nml").write_text(FREE.format(young=young, motion=motion, loads=loads))
    found = re.search(r"lowest frequency (\S+) Hz", hampm("--check", "free.nml").stdout)
    assert (found is not None) == told
    assert not told or float(found[1]) > 2e4


def test_a_motion_that_takes_days_is_told_before_it_starts(hampm, tmp_path):
    (tmp_path / "free.nml").write_text(FREE.format(young=2.4e9, motion="velocity = 8.0, 0.0", loads="").replace("1.2e-4", "1e4"))
    calls = [hampm("free.nml", "--quiet", "--force", "--steps", "3", *more) for more in ((), ("--time-limit", "10"))]
    assert [bool(re.search(r"warning: the run takes about \S+ days: \S+ steps of \S+ s", call.stderr)) for call in calls] == [True, False]
