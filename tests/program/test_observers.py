"""What is recorded, and when, changes nothing of a run: columns are the same to the last digit with and without snapshots, with probes, and in implicit steps with
rows at other times; in explicit steps, which end at rows, where these leave the steps as they are. Each scene had other numbers, or none, while outputs cut steps."""

import functools

import numpy as np
import pytest

import harness
from paths import PROGRAM, SOLID_PROGRAM

PLATE = """\
&run plane = 'strain'  end_time = 1.0 /
&grid lower = -22e-3, -22e-3  cell = 1e-3  cells = 44, 44 /
&material name = 'm'  young = 2e11  poisson = 0.3  density = 7800 {law} /
&body material = 'm'  lower = -20e-3, -20e-3  upper = 20e-3, 20e-3 /
&load kind = 'traction'  lower = -20e-3, 20e-3  upper = 20e-3, 20e-3  force = 0, {force} /
&load kind = 'traction'  lower = -20e-3, -20e-3  upper = 20e-3, -20e-3  force = 0, -{force} /
&crack kind = 'path'  points = -4e-3, 0.2e-3, 4e-3, 0.2e-3 /
&energy_release estimators = 'domain_integral'  radii = 2e-3, 3e-3 /
&method time = 'static'  load_steps = 2 /
"""
AT_REST = {
    "toughness": PLATE.format(force=1e6, law="") + "&growth toughness = 100.0  increment = 2e-3  direction = 'straight' /\n",
    "r_curve": PLATE.format(force=1e6, law="") + "&growth toughness = 100.0  extensions = 0.0, 2e-3  extension_factors = 1.0, 1.5  increment = 2e-3  direction = 'straight' /\n",
    "cycles": PLATE.format(force=5e5, law="") + "&growth law = 'fatigue'  rate_constant = 1e-29  rate_exponent = 3.0  increment = 2e-3  direction = 'straight' /\n",
    "control": PLATE.format(force=1e6, law="") + "&growth toughness = 100.0  increment = 2e-3  direction = 'straight' /\n&control quantity = 'load' /\n",
    "yielding": PLATE.format(force=4e6, law="law = 'j2_plastic'  yield_stress = 3e8  hardening = 2e9")
}
# A free block that turns: rows each 90 us end steps of 72 or 80 us; with snapshots each ms one in eleven was of 10 us, and the energy grew until the run ended
BLOCK = """\
&run plane = 'strain'  end_time = 0.03 /
&grid lower = -40e-3, -40e-3  cell = 2e-3  cells = 40, 40 /
&material name = 'rubber'  young = 1e6  poisson = 0.3  density = 1000 /
&body material = 'rubber'  lower = -10e-3, -4e-3  upper = 10e-3, 4e-3  velocity = {velocity} /
&load kind = 'pressure'  lower = -10e-3, 4e-3  upper = 10e-3, 4e-3  pressure = 2e4 /
&load kind = 'pressure'  lower = -10e-3, -4e-3  upper = 10e-3, -4e-3  pressure = 2e4 /
&method frame = '{frame}' /
&energy_release energy_balance = {audit} /
&output history_interval = 9e-5 /
"""
IN_STEPS = {"total": BLOCK.format(frame="total", velocity="0, 0", audit=".true."), "without balance": BLOCK.format(frame="total", velocity="0, 0", audit=".false."),
            "updated": BLOCK.format(frame="updated", velocity="0.5, 0.3", audit=".true.").replace("2e4", "2e2")}
BEAM = """\
&run end_time = 1e-3  plane = 'stress'  thickness = 0.01 /
&grid lower = 0, 0  cell = 0.01  cells = 20, 2 /
&material name = 'a'  young = 70e9  poisson = 0.3  density = 2700 /
&body material = 'a'  lower = 0, 0  upper = 0.2, 0.02 /
&constraint lower = 0, 0  upper = 0, 0.02  fix = 'xy'  name = 'wall' /
&load kind = 'traction'  lower = 0.2, 0  upper = 0.2, 0.02  force = 0, 10  history = 'sine'  frequency = 2e3 /
&method time = 'implicit'  time_step = 1e-5 /
{more}&output history_interval = 1e-5 /
"""
CRACK = "&crack kind = 'line'  tip = 0.1, 0.01 /\n&refine indicator = 'tip'  max_level = 2 /\n&energy_release estimators = 'vcct', 'domain_integral' /\n"
SOLID = """\
&run end_time = 12 /
&grid lower = 0.0, 0.0, 0.0  cell = 1.0  cells = 9, 9, 8 /
&material name = 'a'  young = 1.0  poisson = 0.25  density = 1.0 /
&body material = 'a'  lower = 0.0, 0.0, 0.0  upper = 9.0, 9.0, 7.0 /
&constraint lower = 0.0, 0.0, 0.0  upper = 9.0, 9.0, 0.0  fix = 'z' /
&constraint lower = 0.0, 0.0, 0.0  upper = 0.0, 9.0, 7.0  fix = 'x' /
&constraint lower = 0.0, 0.0, 0.0  upper = 9.0, 0.0, 7.0  fix = 'y' /
&load kind = 'traction'  lower = 0.0, 0.0, 7.0  upper = 9.0, 9.0, 7.0  force = 0.0, 0.0, 0.01 /
&crack kind = 'symmetry'  normal = 'z'  front = 'disc'  center = 0.0, 0.0, 0.0  radii = 4.0 /
&growth {growth}  direction = 'straight' /
&energy_release estimators = 'domain_integral' /
&method {method} /
&output history_interval = 3.0 /
"""
SOLIDS = {"explicit": SOLID.format(growth="law = 'prescribed'  speed = 0.25  start = 5.0", method="time = 'explicit'"),
          "implicit": SOLID.format(growth="law = 'prescribed'  speed = 0.25  start = 2.0", method="time = 'implicit'  time_step = 0.5"),
          "rest": SOLID.format(growth="toughness = 1e-4  increment = 0.5", method="time = 'static'  load_steps = 4")
          .replace("&output history_interval = 3.0 /\n", "")}

# Rows whose intervals are whole numbers of equal steps. Waves that cells cannot carry are sampled between rows: rows 5, 10, 20 us apart had errors of other sizes
SLIT = """\
&run end_time = 2.2e-4  plane = 'stress'  thickness = 0.01 /
&grid lower = 0, 0  cell = 2.5e-3  cells = 80, 10 /
&material name = 'a'  young = 70e9  poisson = 0.3  density = 2700 /
&body material = 'a'  lower = 0, 0  upper = 0.2, 0.02 /
&constraint lower = 0.1, 0  upper = 0.2, 0  fix = 'y' /
&load kind = 'traction'  lower = 0, 0  upper = 0, 0.02  force = 0, 10 /
&method {method} /
&crack kind = 'symmetry'  tip = 0.1, 0 /
&energy_release estimators = 'vcct', 'domain_integral', 'stress_closure' /
"""
IMPACT = """\
&run end_time = 4e-5  plane = 'strain' /
&grid lower = 0, 0  cell = 2e-3  cells = 25, 12 /
&material name = 'a'  young = 70e9  poisson = 0.3  density = 2700 /
&body material = 'a'  lower = 2e-3, 2.3e-3  upper = 22e-3, 20.4e-3  velocity = 10, 0 /
&body material = 'a'  lower = 22.2e-3, 4e-3  upper = 42e-3, 18e-3 /
&contact bodies = 'friction'  friction = 0.1 /
&method frame = 'updated' /
"""
STILL = SOLIDS["explicit"].replace("end_time = 12", "end_time = 48").replace("&growth law = 'prescribed'  speed = 0.25  start = 5.0  direction = 'straight' /\n", "")
DENSER = {"explicit": (SLIT.format(method="time = 'explicit'"), 5.5e-6, 1.375e-6), "implicit": (SLIT.format(method="time = 'implicit'  time_step = 1.1e-6"), 2.2e-5, 1.1e-6),
          "contact": (IMPACT, 4e-6, 1e-6), "solid": (STILL, 3.0, 1.0), "solid, implicit": (STILL.replace("explicit'", "implicit'  time_step = 0.5").replace("48", "24"), 8.0, 0.5)}


GROWING = SLIT.format(method="time = 'explicit'  courant = 0.5").replace("'vcct', 'domain_integral', 'stress_closure'", "'domain_integral'").replace("force = 0, 10", "force = 0, 1e3")


@pytest.fixture
def columns(hampm, tmp_path):
    """`columns(model, *settings)` runs it: its columns."""
    return functools.partial(harness.run, hampm, name="case")


def differing(one, other):
    """The columns in which rows of the same step differ."""
    _, here, there = np.intersect1d(one["step"], other["step"], return_indices=True)
    assert len(here) >= min(len(one["step"]), len(other["step"])) // 2
    return [name for name in one if not np.array_equal(one[name][here], other[name][there], equal_nan=True)]


def snapshots(row):
    """Times of the snapshots."""
    return harness.datasets(row.path)["VTKHDF/particles/Steps/Values"]


@pytest.mark.parametrize("kind", AT_REST)
def test_at_rest_snapshots_cut_no_load_step(columns, kind):
    plain = columns(AT_REST[kind])
    seen = columns(AT_REST[kind], "output.snapshot_interval=0.2")
    assert list(plain["time"]) == [0, 0.5, 1] and differing(plain, seen) == []
    assert list(snapshots(seen)) == [0, 0.5, 1]


@pytest.mark.parametrize("kind", IN_STEPS)
def test_in_explicit_steps_snapshots_cut_none(columns, kind):
    plain = columns(IN_STEPS[kind])
    assert np.ptp(plain["dt"][1:-1]) < 1e-9 * plain["dt"][1]
    seen = columns(IN_STEPS[kind], "output.snapshot_interval=1e-3")
    assert differing(plain, seen) == []
    late = snapshots(seen)[:31] - 1e-3 * np.arange(31)
    assert np.all(late > -1e-12) and np.all(late < plain["dt"][1])
    if "numerical_loss" not in plain:
        return
    balance = plain["external_work"] + plain["kinetic_energy"][0] - plain["kinetic_energy"] - plain["strain_energy"] - plain["numerical_loss"]
    assert np.max(np.abs(balance)) < 1e-9 * np.max(plain["kinetic_energy"] + plain["strain_energy"])


@pytest.mark.parametrize("more", ["", CRACK], ids=["body", "crack"])
def test_in_implicit_steps_rows_change_no_other(columns, more):
    text = BEAM.format(more=more)
    every = columns(text)
    assert len(every["step"]) == 101
    for settings in ("output.history_interval=3e-5",), ("output.history_interval=7.7e-5", "output.snapshot_interval=1.3e-5"), ("output.history_interval=1e-6",):
        assert differing(columns(text, *settings), every) == [], settings


@pytest.mark.parametrize("kind", DENSER)
def test_denser_rows_change_no_error(hampm, kind):
    text, *intervals = DENSER[kind]
    solid = functools.partial(hampm, program=SOLID_PROGRAM if "solid" in kind else PROGRAM)
    solid.folder = hampm.folder
    few, many = (harness.run(solid, text, f"output.history_interval={interval}") for interval in intervals)
    assert len(many["time"]) > 2 * len(few["time"]) and np.ptp(many["dt"][1:]) < 1e-9 * many["dt"][1]
    _, here, there = np.intersect1d(few["step"], many["step"], return_indices=True)
    assert len(here) == len(few["step"])
    errors = {name for name in few if name.endswith("_error")}
    assert errors and all(np.nanmax(few[name]) > 0 for name in errors)
    rounding = 0 if "implicit" in kind else 1e-6  # steps that end at rows let particles follow nodes in other sums
    for name in few if "implicit" in kind else errors | {name[:-len("_error")] for name in errors}:
        assert np.nanmax(np.abs(few[name][here] - many[name][there])) <= rounding * np.nanmax(np.abs(few[name])), name


@pytest.mark.parametrize("law", ["law = 'prescribed'  speed = 300  start = 1e-4  max_length = 0.12", "law = 'toughness'  toughness = 20.0"])
def test_denser_rows_change_no_integral_of_G(columns, law):
    """It goes on cell by cell, also as the tip comes to rest. By rows it was 0.7 % off with a row each 28 steps and one each 14, 9 % where the tip runs through in three rows."""
    few, many = (columns(GROWING + f"&growth {law}  direction = 'straight' /\n", f"output.history_interval={interval}") for interval in (1.1e-5, 2.75e-6))
    _, here, there = np.intersect1d(few["step"], many["step"], return_indices=True)
    assert len(here) == len(few["step"]) and few["crack_length"][-1] > 0.1199
    whole = many["integral_of_G"][-1]
    print(whole, few["integral_of_G"][-1] / whole - 1)
    assert np.max(np.abs(few["integral_of_G"][here] - many["integral_of_G"][there])) < 1e-9 * whole
    rate, way = many["J"], np.diff(many["crack_length"])
    if "prescribed" in law:  # half of the body, 10 mm thick
        assert whole == pytest.approx(0.01 / 2 * np.sum((rate[1:] + rate[:-1]) / 2 * way), rel=0.01)


@pytest.mark.parametrize("kind", SOLIDS)
def test_snapshots_of_fronts_change_none(hampm, kind):
    solid = functools.partial(hampm, program=SOLID_PROGRAM)
    solid.folder = hampm.folder
    plain, seen = (harness.run(solid, SOLIDS[kind], *settings) for settings in ((), ("output.snapshot_interval=1.3",)))
    assert len(plain["step"]) == 5 and plain["crack_area"][-1] > plain["crack_area"][0]
    assert differing(plain, seen) == []


def test_probes_change_no_other(columns):
    more = "&probe name = 'p'  quantity = 'displacement', 'stress'  at = 0.15, 0.005 /\n"
    assert differing(columns(BEAM.format(more=CRACK)), columns(BEAM.format(more=CRACK + more))) == []


def test_check_says_of_which_steps_snapshots_are(hampm, tmp_path):
    (tmp_path / "case.nml").write_text(AT_REST["toughness"] + "&output snapshot_interval = 0.2 /\n")
    assert "! samples         3 of the history, 3 snapshots, of the load steps at or after their times\n" in hampm("case.nml", "--check", "--quiet").stdout
    (tmp_path / "case.nml").write_text(IN_STEPS["total"].replace("9e-5 /", "9e-5  snapshot_interval = 1e-3 /"))
    assert " 31 snapshots, of the steps in which their times come\n" in hampm("case.nml", "--check", "--quiet").stdout
