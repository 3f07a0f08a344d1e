"""Runs that are stopped, killed or cut off, and resumed."""

import os
import random
import resource
import shutil
import signal
import subprocess
import time

import h5py
import numpy as np
import pytest

from history import History
from kill_at_random import kill_runs, read_whole
from harness import differing
from paths import COARSE_DCB, CHECKED_PROGRAM, PROGRAM

VERSION = subprocess.run([PROGRAM, "--version"], check=True, capture_output=True, text=True).stdout.split(maxsplit=1)[1].strip()
SHORT = ("--set", "run.end_time=4e-5", "--set", "output.history_interval=1e-6", "--set", "output.snapshot_interval=1e-5")
CHECKPOINT = "dcb.h5.checkpoint"

# A soft and a hard body fly towards each other through the cells, one of them pushed; nothing of the first steps lasts
FLIGHT = """\
&run end_time = 0.04 /
&grid cell = 1.0 cells = 8, 4 /
&material name = 'soft' law = 'neo_hookean' young = 1e5 density = 1000 poisson = 0.3 /
&material name = 'hard' young = 1e6 density = 2000 /
&body material = 'soft' lower = 1.3, 1.2 upper = 2.3, 2.8 velocity = 30, 3 points_per_cell = 4 /
&body material = 'hard' lower = 4.6, 1.0 upper = 5.6, 3.0 velocity = -10, 0 /
&method courant = 0.02 frame = 'updated' /
&damping rate = 1.0 /
&load kind = 'traction' lower = 1.3, 1.2 upper = 1.3, 2.8 force = 1e3, 0 history = 'sine' frequency = 30 /
&load kind = 'body' lower = 4.6, 1.0 upper = 5.6, 3.0 force = 1e3, 0 /
&energy_release energy_balance = .true. /
&output history_interval = 4e-3 snapshot_interval = 13e-3 /
"""
# In the total frame bodies do not meet: they touch, and one pulls the other
TOTAL = "method.frame=total", "body(2).lower=2.3,1.0", "body(1).velocity=1,0", "body(2).velocity=0,0"
REFINED = ("refine.indicator=gradient", "refine.field=speed", "refine.r_crit=0.05", "refine.r_coarsen=0.01", "refine.max_level=2",
           "refine.interval=7")
# A crack whose faces are pressed together, in an arm and a bulk that bend
CLOSED = """\
&run end_time = 2e-5 thickness = 0.01 /
&grid lower = 0.0, -0.0125 cell = 2.5e-3 cells = 20, 10 /
&material name = 'aluminium' young = 70e9 density = 2700 poisson = 0.3 /
&body material = 'aluminium' lower = 0.0, -0.01 upper = 0.05, 0.01 /
&constraint lower = 0.05, -0.01 upper = 0.05, 0.01 fix = 'xy' /
&load kind = 'traction' lower = 0.0, 0.0 upper = 0.0, 0.01 force = 0.0, -2000.0 /
&crack kind = 'line' tip = 0.025, 0.0 contact = 'frictionless' /
&energy_release estimators = 'vcct', 'domain_integral'  energy_balance = .true. /
&output history_interval = 1e-6 snapshot_interval = 1e-5 /
"""
# A crack with two tips, in a plate one end of which is pulled: the wave takes a while to come to the crack
TWO_TIPS = """\
&run end_time = 2e-5 thickness = 0.01 /
&grid lower = 0.0, -0.0125 cell = 2.5e-3 cells = 20, 10 /
&material name = 'aluminium' young = 70e9 density = 2700 poisson = 0.3 /
&body material = 'aluminium' lower = 0.0, -0.01 upper = 0.05, 0.01 /
&constraint lower = 0.05, -0.01 upper = 0.05, 0.01 fix = 'xy' /
&load kind = 'traction' lower = 0.0, 0.0 upper = 0.0, 0.01 force = 500.0, 2000.0 /
&crack kind = 'line' tip = 0.035, 0.0 length = 0.01 /
&energy_release estimators = 'vcct', 'stress_closure', 'domain_integral'  energy_balance = .true. radii = 5e-3, 7e-3 /
&output history_interval = 1e-6 snapshot_interval = 1e-5 /
"""
# A block that turns, with a crack from its edge that it carries through the cells
CARRIED = """\
&run end_time = 3e-5 thickness = 1e-3 /
&grid lower = -5e-3, -5e-3 cell = 5e-4 cells = 20, 20 /
&material name = 'a' law = 'neo_hookean' young = 3e9 poisson = 0.3 density = 1200 /
&body material = 'a' lower = -3e-3, -3e-3 upper = 3e-3, 3e-3 velocity = 10, 5 spin = 1e4 /
&crack kind = 'path' points = -4e-3, 1e-4, -1e-4, 1e-4, 1e-3, 1.1e-3 /
&energy_release estimators = 'domain_integral'  energy_balance = .true. radii = 1.1e-3 /
&method frame = 'updated' /
&output history_interval = 2e-6 snapshot_interval = 1e-5 /
"""
# A crack that grows and turns, in so many load steps that a run can be stopped between them
GROWTH = """\
&run end_time = 24 thickness = 1e-3 /
&grid lower = -21e-3, -21e-3 cell = 1e-3 cells = 42, 42 /
&material name = 'a' young = 3e9 poisson = 0.3 density = 1200 /
&body material = 'a' lower = -20e-3, -20e-3 upper = 20e-3, 20e-3 /
&load kind = 'traction' lower = -20e-3, 20e-3 upper = 20e-3, 20e-3 force = 0, 40 /
&load kind = 'traction' lower = -20e-3, -20e-3 upper = 20e-3, -20e-3 force = 0, -40 /
&load kind = 'body' lower = -21e-3, -21e-3 upper = 21e-3, 21e-3 force = 1e-3, 0 held = .true. /
&load kind = 'traction' lower = 20e-3, -20e-3 upper = 20e-3, 20e-3 force = -1e-3, 0 held = .true. /
&crack kind = 'path' points = -22e-3, -3e-3, -12e-3, -1e-3 /
&growth direction = 'local_symmetry' toughness = 100 increment = 1.1e-3 /
&refine indicator = 'tip' max_level = 1 rings = 4 /
&energy_release estimators = 'domain_integral' /
&method time = 'static' load_steps = 24 /
&output snapshot_interval = 8.0 /
"""
# A hole that is pressed open, around which cells refine and recombine: particles at its edge are more than what they were split from
SOFTENING = """\
&run plane = 'axisymmetric'  end_time = 0.25 /
&grid lower = 0.6, 0.0384  cell = 0.03  cells = 9, 9 /
&material name = 'm0'  law = 'j2_plastic'  young = 1e4  density = 1e3  yield_stress = 0.188 /
&body material = 'm0'  lower = 0.6, 0.0384  upper = 0.87, 0.3084 /
&crack kind = 'path'  points = 0.703, 0.1613, 0.797, 0.2155 /
&cohesive law = 'table'  openings = 0.0, 3.4e-6, 4.27e-5  tractions = 1.283, 0.898, 0.0  from = 0.0325 /
&constraint lower = 0.6, 0.3084  upper = 0.87, 0.3084  fix = 'y'  displacement = 0.0, 2.24e-5  history = 'table'
   times = 0.0, 0.0515, 0.129  factors = 0.0, 1.0, 1.0 /
&output file = 'case.h5'  history_interval = 0.0322 /
"""
HOLE = """\
&run end_time = 4.8e-3 /
&grid lower = 0.0, 3.0 cell = 1.0 cells = 6, 6 /
&material name = 'm0' young = 70e9 density = 2700 /
&body material = 'm0' lower = 0.0, 3.0 upper = 6.0, 9.0 /
&body hole = .true. shape = 'circle' center = 2.33, 6.55 radius = 1.78 /
&load kind = 'pressure' pressure = 4e6 lower = -1.0, 6.0 upper = 7.0, 10.0 history = 'table' times = 0.0, 1.9e-3, 4.8e-3 factors = 0.0, 1.0, -0.5 /
&method mass = 'consistent' /
&refine indicator = 'gradient' max_level = 1 interval = 20 r_coarsen = 0.02 region_lower = 1.0, 4.0 region_upper = 5.0, 8.0 /
&output history_interval = 7e-4 /
"""
MANY_CELLS = """\
&run end_time = 2e-6 /
&grid cell = 1.0e-3 cells = 60, 50 /
&material name = 'a' young = 70e9 density = 2700 /
&body material = 'a' lower = 2e-3, 2e-3 upper = 52e-3, 47e-3 velocity = 1500, 700 /
&method courant = 0.1 frame = 'updated' /
&damping rate = 1e5 /
&load kind = 'traction' lower = 2e-3, 2e-3 upper = 2e-3, 47e-3 force = 1e5, 0 /
&output history_interval = 1e-7 snapshot_interval = 1e-6 /
"""
# The same without a load, which turns too, so that its particles change their cells
TURNING = "\n".join(line for line in MANY_CELLS.splitlines() if "&load" not in line).replace("velocity =", "spin = 1e4 velocity =")
SCENES = {
    "recombined": (HOLE,),
    "lumped musl": (FLIGHT, "method.scheme=musl"),
    "total frame": (FLIGHT, "method.scheme=usavg", *TOTAL),
    "consistent cg": (FLIGHT, "method.scheme=usf", "method.mass=consistent"),
    "consistent direct": (FLIGHT, "method.mass=consistent", "method.solver=direct"),
    "weighted direct": (FLIGHT, "method.scheme=usavg", "method.mass=weighted", "method.solver=direct"),
    "fmpm": (FLIGHT, "method.scheme=usl", "method.mass=fmpm"),
    "partial total": (FLIGHT, "method.mass=partial", "method.consistent_lower=0,0", "method.consistent_upper=4,4", *TOTAL),
    "refined lumped": (FLIGHT, *REFINED),
    "refined consistent": (FLIGHT, "method.mass=consistent", "method.solver=direct", *REFINED),
    "refined zz": (FLIGHT, "refine.indicator=zz", "refine.tolerance=0.1", "refine.max_level=2", "refine.interval=11",
                   "method.mass=weighted"),
    "two tips": (TWO_TIPS, "refine.indicator=tip", "refine.max_level=1", "energy_release.estimators='vcct'", "damping.rate=1e4",
                 "output.history_interval=1e-6"),
    "contact": (CLOSED,),
    "contact consistent": (CLOSED, "method.mass=consistent", "method.frame=total"),
    "contact refined": (CLOSED, "refine.indicator=tip", "refine.max_level=2"),
    "two tips": (TWO_TIPS,),
    "two tips refined": (TWO_TIPS, "refine.indicator=tip", "refine.max_level=2"),
    "implicit": (TWO_TIPS, "method.time=implicit", "method.time_step=1.6e-7", "energy_release.estimators='vcct'"),
    "implicit consistent refined": (TWO_TIPS, "method.time=implicit", "method.mass=consistent", "refine.indicator=tip", "refine.max_level=2",
                              "energy_release.estimators='domain_integral'", "damping.rate=1e4", "method.hht_alpha=-0.1",
                              "constraint.velocity=1,0", "constraint.history=ramp", "constraint.rise_time=1e-5"),
    "tiles": (MANY_CELLS,),
    "tiles without particles": (MANY_CELLS, "method.frame=total", "body(1).velocity=0,0", "output.history_interval=5e-7"),
    "turning": (TURNING, "method.scheme=musl", "output.history_interval=5e-7"),
    "turning usl": (TURNING, "method.scheme=usl", "output.history_interval=1e-6"),
    "turning usavg": (TURNING, "method.scheme=usavg", "output.history_interval=5e-7", "body(1).velocity=3,2"),
    "refined without particles": (CLOSED, "method.frame=total", "refine.indicator=tip", "refine.max_level=2",
                                  "energy_release.estimators='vcct'"),
    "static": (CLOSED, "method.time=static", "method.load_steps=40", "load.history=sine", "load.frequency=1.1e5"),
    "static refined": (CLOSED, "method.time=static", "method.load_steps=30", "load.history=ramp", "load.rise_time=1e-5",
                       "material.law=neo_hookean", "refine.indicator=zz", "refine.max_level=2", "refine.tolerance=0.1"),
    "moved": (CLOSED, "constraint.velocity=2,1", "energy_release.estimators=vcct"),
    "carried crack": (CARRIED,),
    "carried crack refined": (CARRIED, "refine.indicator=tip", "refine.max_level=1", "refine.rings=3", "method.mass=weighted"),
    "growth": (GROWTH,),
    "cohesion that softens": (SOFTENING,),
    "domains": (FLIGHT, "method.shape_functions=cpdi", "method.mass=consistent", "method.scheme=usl"),
    "domains refined": (FLIGHT, "method.shape_functions=cpdi", "method.mass=fmpm", "method.scheme=usavg", *REFINED),
    "domains carried crack": (CARRIED.replace("-1e-4, 1e-4, 1e-3, 1.1e-3", "1e-3, 0").replace("-4e-3, 1e-4", "-4e-3, 0"), "method.shape_functions=cpdi", "refine.indicator=tip", "refine.max_level=1", "refine.rings=3"),
    "checked build": (FLIGHT, "method.mass=consistent", "method.solver=direct", *REFINED),
}


# Tips that have moved since cells were cut last, while the mesh was looked at and stayed: the grid is built with the lines and the tips of then
GROWS_CARRIED = """\

&run plane = 'stress'  end_time = 2.6e-3 /
&grid lower = 0.0, 0.0  cell = 0.1  cells = 12, 12 /
&material name = 'm'  density = 3000.0  young = 2e8  poisson = 0.1 /
&body material = 'm'  lower = 0.2, 0.2  upper = 1.0, 1.0 /
&constraint lower = 0.2, 0.2  upper = 1.0, 0.2  fix = 'y' /
&load kind = 'traction'  lower = 0.2, 1.0  upper = 1.0, 1.0  force = 0.0, 2e3 /
&method frame = 'updated'  scheme = 'usl'  courant = 0.05 /
&refine indicator = 'zz'  max_level = 1  tolerance = 0.05  interval = 5 /
&crack kind = 'line'  tip = 0.6, 0.6 /
&energy_release estimators = 'domain_integral' /
&growth direction = 'hoop_stress'  law = 'toughness'  toughness = 2e-3  limit_speed = 150.0 /
&output history_interval = 1.3e-4 /
"""
GROWS_AT_SPEED = """\
&run plane = 'stress'  end_time = 7.7e-6 /
&grid lower = 0.0, -5e-3  cell = 1e-3  cells = 13, 11 /
&material name = 'm'  density = 3100.0  young = 5.3e9  poisson = 0.1 /
&body material = 'm'  lower = 1e-3, -4e-3  upper = 12e-3, 5e-3 /
&constraint lower = 0.0, -5e-3  upper = 13e-3, -4e-3  fix = 'xy' /
&load kind = 'point'  lower = 12e-3, 5e-3  upper = 12e-3, 5e-3  force = 29.0, 58.0 /
&method start = 'static' /
&refine indicator = 'gradient'  max_level = 1  r_crit = 0.1  interval = 5  field = 'stress_norm' /
&crack kind = 'path'  points = 0.3e-3, 0.0, 3.4e-3, 0.6e-3, 6.3e-3, 0.9e-3 /
&energy_release estimators = 'domain_integral'  radii = 2e-3, 2.6e-3 /
&growth direction = 'straight'  law = 'prescribed'  speed = 260.0  start = 2.3e-6 /
&output history_interval = 4e-7 /
"""


@pytest.mark.parametrize("scene", [GROWS_CARRIED, GROWS_AT_SPEED], ids=["carried", "in place"])
def test_growing_tips_go_on_from_any_step_between_changes_of_the_mesh(hampm, tmp_path, scene):
    (tmp_path / "case.nml").write_text(scene)
    assert hampm("case.nml", "--quiet", "--output", "unbroken").returncode == 0
    whole = History(tmp_path / "unbroken/case.h5")
    steps = int(whole.columns["step"][-1])
    assert whole.columns["tip_x"][-1] != whole.columns["tip_x"][0] and np.ptp(whole.columns["cells"]) > 0
    for stop in (steps // 2, 3 * steps // 4, 4 * steps // 5, 9 * steps // 10, steps - 1):
        assert hampm("case.nml", "--quiet", "--force", "--steps", stop).returncode == 5
        result = hampm("--resume", "case.h5.checkpoint", "--quiet")
        assert result.returncode == 0, (stop, result.stderr)
        assert differing(tmp_path / "unbroken/case.h5", tmp_path / "case.h5") == [], stop
        assert History(tmp_path / "case.h5").attributes["warnings"] == whole.attributes["warnings"]


REFINES = """\
&run end_time = 1.2e-5 thickness = 0.01 /
&grid lower = 0.0, -0.0125 cell = 2.5e-3 cells = 20, 10 /
&material name = 'aluminium' young = 70e9 density = 2700 poisson = 0.3 /
&body material = 'aluminium' lower = 0.0, -0.01 upper = 0.05, 0.01 /
&load kind = 'traction' lower = 0.05, -0.01 upper = 0.05, 0.01 force = 2e3, 0.0 history = 'sine' frequency = 2e4 /
&load kind = 'traction' lower = 0.0, 0.0 upper = 0.0, 0.01 force = 0.0, 2000.0 /
&constraint lower = 0.0, -0.01 upper = 0.0, 0.0 fix = 'xy' /
&crack kind = 'line' tip = 0.025, 0.0 /
&method time = 'implicit'  time_step = 5e-7  hht_alpha = -0.1 /
&refine indicator = 'zz'  max_level = 2  tolerance = 0.1  interval = 5 /
&energy_release estimators = 'domain_integral'  energy_balance = .true. /
&output file = 'case.h5'  history_interval = 1e-6 /
"""


def test_implicit_steps_go_on_from_those_in_which_cells_are_refined(hampm, tmp_path):
    """A step after a change of the mesh begins with what was carried to it, also where the run stops in between."""
    (tmp_path / "case.nml").write_text(REFINES)
    assert hampm("case.nml", "--quiet", "--output", "unbroken").returncode == 0
    row = History(tmp_path / "unbroken/case.h5").columns
    assert len(np.unique(row["cells"])) > 3
    for stop in range(5, int(row["step"][-1]), 5):
        assert hampm("case.nml", "--quiet", "--force", "--steps", stop).returncode == 5
        assert hampm("--resume", "case.h5.checkpoint", "--quiet").returncode == 0
        assert differing(tmp_path / "unbroken/case.h5", tmp_path / "case.h5") == [], stop


@pytest.fixture
def unbroken(dcb, tmp_path):
    """The result of a short run of the coarse beam that is never stopped."""
    assert dcb(*SHORT, "--output", "unbroken").returncode == 0
    return tmp_path / "unbroken/dcb.h5"


@pytest.fixture
def stopped(dcb, tmp_path):
    """A folder with what the same run leaves that stops after 100 steps."""
    assert dcb(*SHORT, "--steps", 100, "--quiet").returncode == 5
    return tmp_path


def files(folder):
    return sorted(path.name for path in folder.iterdir() if path.is_file())


LONG = "carried crack refined", "domains carried crack"


@pytest.mark.parametrize("name", [pytest.param(name, marks=pytest.mark.verify) if name in LONG else name for name in SCENES])
def test_a_resumed_run_has_the_bytes_of_an_unbroken_one(hampm, tmp_path, name):
    program = CHECKED_PROGRAM if name == "checked build" else PROGRAM
    if not program.exists():
        pytest.skip("there is no checked build")
    scene, *settings = SCENES[name]
    (tmp_path / "case.nml").write_text(scene)
    words = [word for item in settings for word in ("--set", item)]
    assert hampm("case.nml", "--quiet", "--output", "unbroken", *words, program=program).returncode == 0
    steps = History(tmp_path / "unbroken/case.h5").columns["step"][-1]
    assert steps > 20
    result = hampm("case.nml", "--quiet", "--threads", 2, *words, "--steps", steps // 7, program=program)
    for part in (1, steps // 3):
        assert result.returncode == 5, result.stderr
        result = hampm("--resume", "case.h5.checkpoint", "--quiet", "--steps", part, "--threads", 1 + part % 3, program=program)
    assert hampm("--resume", "case.h5.checkpoint", "--quiet", program=program).returncode == 0
    assert differing(tmp_path / "unbroken/case.h5", tmp_path / "case.h5") == []
    assert files(tmp_path) == ["case.h5", "case.nml"]


def test_a_run_that_is_stopped_says_how_to_go_on(stopped, hampm, dcb):
    assert files(stopped) == ["dcb.h5", CHECKPOINT]
    result = dcb(*SHORT)
    assert result.returncode == 4
    assert f"./{CHECKPOINT}: there is a checkpoint of a run. To go on with it: hampm --resume ./{CHECKPOINT}." in result.stderr
    result = hampm("--resume", CHECKPOINT, "--steps", 1)
    assert result.returncode == 5
    assert result.stderr.startswith("hampm: step 101, t = ")
    assert result.stderr.endswith(f"stopped by --steps 1. To go on: hampm --resume ./{CHECKPOINT}\n")


def test_the_result_of_a_stopped_run_holds_what_came_before(stopped, unbroken):
    with h5py.File(stopped / CHECKPOINT) as file:
        samples = int(file["run/samples"][0])
    found, whole = History(stopped / "dcb.h5").columns, History(unbroken).columns
    for name, values in found.items():
        assert values.tobytes() == whole[name][:samples].tobytes()


def test_a_run_goes_on_with_the_cracks_where_the_checkpoint_has_them(hampm, tmp_path):
    """Moved before any wave has come to it, the crack is as if it had always been there, but for errors estimated at the start."""
    (tmp_path / "case.nml").write_text(TWO_TIPS)
    assert hampm("case.nml", "--quiet", "--steps", 1).returncode == 5
    cell = [2.5e-3, 0.0]
    for name in ("crack_1/points", "lines/points_1"):  # where cells are cut, too
        change(tmp_path / "case.h5.checkpoint", name, lambda points: points - np.tile(cell, 2))
    change(tmp_path / "case.h5.checkpoint", "crack_1/mouth", lambda mouth: mouth - cell)
    assert hampm("--resume", "case.h5.checkpoint", "--quiet").returncode == 0
    assert hampm("case.nml", "--quiet", "--output", "there", "--set", "crack.tip=0.0325,0.0").returncode == 0
    there, found = (History(tmp_path / folder / "case.h5").columns for folder in ("there", ""))
    names = [name for name in there if "_error" not in name]
    assert found.keys() == there.keys()
    for name in names:  # where its first point is differs in the last digit
        assert found[name] == pytest.approx(there[name], rel=1e-10, abs=1e-10 * np.max(np.abs(there[name]))), name
    assert np.max(found["K_I"]) > 0


def test_checkpoints_do_not_change_the_run(dcb, unbroken, tmp_path):
    assert dcb(*SHORT, "--set", "output.checkpoint_steps=20").returncode == 0
    assert differing(unbroken, tmp_path / "dcb.h5") == []
    assert files(tmp_path) == ["dcb.h5"]


def test_checkpoints_are_so_many_steps_apart(hampm, tmp_path):
    """A body leaves the grid in step 21: what is left of its run is the third checkpoint of six steps each."""
    (tmp_path / "flight.nml").write_text("&run end_time = 1.0 /\n&grid cell = 1.0 cells = 8, 4 /\n&material name = 'a' young = 1e5 density = 1000 poisson = 0.3 /\n"
                                         "&body material = 'a' lower = 1.0, 1.0 upper = 2.0, 3.0 velocity = 30, 0 /\n&method frame = 'updated' /\n"
                                         "&output checkpoint_steps = 6 history_interval = 0.01 /\n")
    assert "hampm: step 21," in hampm("flight.nml", "--quiet").stderr
    with h5py.File(tmp_path / "flight.h5.checkpoint") as file:
        assert file["motion/steps"][0] == 18


def test_a_result_that_went_on_beyond_the_checkpoint_is_cut(stopped, hampm, unbroken):
    """As a kill between the two leaves them, or one after the result was put in its place without a checkpoint."""
    shutil.copy(unbroken, stopped / "dcb.h5")
    assert hampm("--resume", CHECKPOINT, "--steps", 1).returncode == 5
    assert len(History(stopped / "dcb.h5").times) < len(History(unbroken).times)
    assert hampm("--resume", CHECKPOINT).returncode == 0
    assert differing(unbroken, stopped / "dcb.h5") == []


def test_a_time_limit_stops_the_run(dcb, tmp_path):
    result = dcb("--set", "run.end_time=1.0", "--time-limit", 0.3, "--quiet")
    assert (result.returncode, files(tmp_path)) == (5, ["dcb.h5", CHECKPOINT])
    assert "stopped by --time-limit 0.3. To go on: " in result.stderr


def start(folder, *settings, **options):
    """A long run of the coarse beam, once it has put its result in place for the first time."""
    words = [word for setting in settings for word in ("--set", setting)]
    process = subprocess.Popen([PROGRAM, *COARSE_DCB, "--set", "run.end_time=1.0", "--set", "output.checkpoint_interval=0.5", *words],
                               cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, **options)
    deadline = time.time() + 60
    while not (folder / CHECKPOINT).exists() and process.poll() is None and time.time() < deadline:
        time.sleep(0.01)
    return process


@pytest.mark.parametrize("name", ["SIGTERM", "SIGINT", "SIGHUP", "SIGUSR1", "SIGUSR2", "SIGXCPU"])
def test_signals_stop_the_run(tmp_path, name):
    number = getattr(signal, name)
    process = start(tmp_path, preexec_fn=lambda: signal.signal(number, signal.SIG_DFL))  # tests may run where it is ignored
    process.send_signal(number)
    message = process.communicate(timeout=60)[1]
    assert process.returncode == 5
    assert f"stopped by {name}. To go on: hampm --resume ./{CHECKPOINT}" in message
    assert files(tmp_path) == ["dcb.h5", CHECKPOINT]
    assert read_whole(tmp_path / "dcb.h5") and read_whole(tmp_path / CHECKPOINT)


@pytest.mark.parametrize("name", ["SIGTERM", "SIGUSR1"])
def test_a_signal_that_comes_again_takes_no_checkpoint_away(tmp_path, name):
    """As of batch systems, of which each part sends one."""
    process = start(tmp_path)
    while process.poll() is None:
        process.send_signal(getattr(signal, name))
    assert process.wait() == 5 and read_whole(tmp_path / CHECKPOINT)


def test_a_result_is_locked_until_its_last_checkpoint_is_written(tmp_path):
    """By cells so many that writing it takes a while."""
    process = start(tmp_path, "grid.cell=0.3125e-3", "grid.cells=320,33")
    process.send_signal(signal.SIGTERM)
    lock, part = tmp_path / "dcb.h5.lock", tmp_path / (CHECKPOINT + ".part")
    was_written = False
    while process.poll() is None:
        is_free = not lock.exists()
        if part.exists():
            was_written = True
            assert not is_free
    assert process.wait() == 5 and was_written


def test_a_run_that_goes_on_is_not_resumed_beside_it(tmp_path, hampm):
    process = start(tmp_path)
    for _ in range(20):                          # whatever it is doing: it replaces its files again and again
        result = hampm("--resume", CHECKPOINT)
        assert result.returncode == 4
        assert result.stderr == "hampm: ./dcb.h5: cannot be written: another run is writing it\n"
    assert process.poll() is None
    process.send_signal(signal.SIGTERM)
    process.communicate(timeout=60)
    assert process.returncode == 5


def test_a_signal_that_is_to_be_ignored_is_ignored(tmp_path):
    process = start(tmp_path, preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_IGN))
    process.send_signal(signal.SIGHUP)
    time.sleep(0.2)
    assert process.poll() is None
    process.kill()
    process.communicate()


def test_killed_at_random_moments(tmp_path):
    found = kill_runs(PROGRAM, tmp_path, kills=10, interval=0.1, slack=2.0, seed=int(time.time()))
    assert found.faults == []


def limit_files(size):
    """What a process has to do first for no file of its to become larger than `size` bytes; as Python does, let writes fail."""
    return lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))


@pytest.mark.parametrize("size", [100, 20000, 60000, 90000, 120000, 150000])
def test_a_full_disk_leaves_the_last_files(hampm, dcb, unbroken, tmp_path, size):
    """Of result (up to 190 kB) and checkpoint (80 kB), one or the other is too large at some time."""
    words = *SHORT, "--set", "output.checkpoint_steps=20", "--quiet"
    result = dcb(*words, preexec_fn=limit_files(size))
    assert result.returncode == 4
    assert result.stderr.startswith("hampm: ./dcb.h5") and "cannot be written" in result.stderr and "disk" in result.stderr
    assert set(files(tmp_path)) <= {"dcb.h5", CHECKPOINT}
    if (tmp_path / "dcb.h5").exists():
        assert np.all(np.isfinite(read_whole(tmp_path / "dcb.h5")["history/strain_energy"]))
    if (tmp_path / CHECKPOINT).exists():
        assert hampm("--resume", CHECKPOINT, preexec_fn=limit_files(size)).returncode == 4
        assert hampm("--resume", CHECKPOINT).returncode == 0
        assert differing(unbroken, tmp_path / "dcb.h5") == []


def change(path, name, value):
    """Change a value."""
    with h5py.File(path, "r+") as file:
        file[name][...] = value(file[name][:]) if callable(value) else value


def damage(path):
    """Change a byte in the middle of the largest array."""
    data = bytearray(path.read_bytes())
    with h5py.File(path) as file:
        place = file["particles/gradient"].id.get_chunk_info(0).byte_offset
    data[place + 100] ^= 1
    path.write_bytes(data)


NOT_WHOLE = "cannot be read: it is no HDF5 file, or not a whole one"
WRONG = {
    "no file": (lambda path: path.unlink(), "cannot be read: there is no such file"),
    "empty": (lambda path: path.write_bytes(b""), NOT_WHOLE),
    "text": (lambda path: path.write_text("&run /\n" * 1000), NOT_WHOLE),
    "cut off": (lambda path: os.truncate(path, path.stat().st_size - 10), NOT_WHOLE),
    "half": (lambda path: os.truncate(path, path.stat().st_size // 2), NOT_WHOLE),
    "damaged": (damage, "reading /particles/gradient failed (has it changed since it was written?)"),
    "a result": (lambda path: shutil.copy(path.with_name("dcb.h5"), path), "cannot be resumed: it is no checkpoint of hampm"),
    "other version": (lambda path: change(path, "version", lambda letters: [*b"9", *letters[1:]]),
                      f"it was written by hampm 9{VERSION[1:]} (format 42), this is hampm {VERSION} (format 42); resume the run with the program that"),
    "other format": (lambda path: change(path, "format", 99), f"(format 99), this is hampm {VERSION} (format 42)"),
    "other number": (lambda path: change(path, "particles/number", 159), "/particles/mass has 160 values, not 159"),
    "wrong order": (lambda path: change(path, "particles/cell", lambda cells: cells[::-1]),
                    "its particles do not stand in the order of their cells"),
}


@pytest.mark.parametrize("name", WRONG)
def test_a_checkpoint_that_is_none_or_not_whole(stopped, hampm, name):
    spoil, phrase = WRONG[name]
    spoil(stopped / CHECKPOINT)
    before = {file: (stopped / file).read_bytes() for file in files(stopped)}
    result = hampm("--resume", CHECKPOINT)
    assert (result.returncode, result.stdout) == (4, "")
    assert result.stderr.startswith(f"hampm: {CHECKPOINT}: ") and phrase in result.stderr and result.stderr.count("\n") == 1
    assert before == {file: (stopped / file).read_bytes() for file in files(stopped)}


@pytest.mark.skipif("(" not in VERSION, reason="the commit of this program is not known")
def test_a_checkpoint_of_another_commit_is_told_of(stopped, hampm, unbroken):
    """And gone on from, as its number and its format are the same; results and checkpoints name the version with its commit."""
    with h5py.File(stopped / CHECKPOINT) as checkpoint, h5py.File(stopped / "dcb.h5") as result:
        assert bytes(checkpoint["version"][:].tolist()).decode() == VERSION == result["input"].attrs["version"]
    change(stopped / CHECKPOINT, "version", lambda letters: [*letters[:-2], *b"?)"])
    run = hampm("--resume", CHECKPOINT, "--quiet")
    assert (run.returncode, run.stderr) == (0, f"hampm: warning: {CHECKPOINT}: it was written by hampm {VERSION[:-2]}?), this is hampm {VERSION}: "
                                               "the result will be of both\n")
    assert differing(unbroken, stopped / "dcb.h5") == []


def test_no_bit_of_a_checkpoint_can_change_unseen(stopped, hampm, unbroken):
    """One that is in use is told; what HDF5 leaves unused between its pieces may be anything."""
    path, result = stopped / CHECKPOINT, stopped / "dcb.h5"
    data, before = path.read_bytes(), result.read_bytes()
    chance, told = random.Random(1), 0
    for place in [0, 1, len(data) - 1, *(chance.randrange(len(data)) for _ in range(60))]:
        other = bytearray(data)
        other[place] ^= 1 << chance.randrange(8)
        path.write_bytes(other)
        run = hampm("--resume", CHECKPOINT, "--quiet")
        if run.returncode == 0:
            assert differing(unbroken, result) == []
            result.write_bytes(before)
        else:
            told += 1
            assert (run.returncode, run.stdout, run.stderr.count("\n")) == (4, "", 1)
            assert result.read_bytes() == before
    assert told > 50


def another_scene(path, dcb):
    assert dcb(*SHORT, "--force", "--set", "load.force=0,2").returncode == 0


@pytest.mark.parametrize(("spoil", "phrase"), [
    (lambda path, dcb: path.unlink(), "dcb.h5: cannot be read: "),
    (lambda path, dcb: path.write_text("text"), "dcb.h5: there is another file than hampm writes, which is not replaced"),
    (lambda path, dcb: path.write_bytes(b"\x89HDF\r\n\x1a\ntext"), "dcb.h5: cannot be read: it is no HDF5 file"),
    (another_scene, "dcb.h5: is the result of another model than the checkpoint"),
    (lambda path, dcb: dcb(*SHORT, "--force", "--steps", 20, "--output", "shorter") and shutil.copy("shorter/dcb.h5", path),
     "fewer entries of /history/time than there were"),
], ids=["none", "text", "no HDF5", "another model", "shorter"])
def test_a_checkpoint_without_its_result(stopped, hampm, dcb, monkeypatch, spoil, phrase):
    monkeypatch.chdir(stopped)
    checkpoint = (stopped / CHECKPOINT).read_bytes()
    spoil(stopped / "dcb.h5", dcb)
    (stopped / CHECKPOINT).write_bytes(checkpoint)
    before = {file: (stopped / file).read_bytes() for file in files(stopped)}
    result = hampm("--resume", CHECKPOINT)
    assert result.returncode == 4
    assert phrase in result.stderr and result.stderr.count("\n") == 1
    assert before == {file: (stopped / file).read_bytes() for file in files(stopped)}


@pytest.mark.parametrize(("words", "phrase"), [
    (("case.nml",), "--resume and the namelist file 'case.nml': the checkpoint has its model; give one of the two"),
    (("--check",), "--resume and --check: give one of the two"),
    (("--set", "grid.cell=1"), "--set grid.cell=1: with --resume only run.end_time, method.load_steps, run.stop_..., output.checkpoint_interval and"),
    (("--set", "output.checkpoint_steps=-1"), "&output checkpoint_steps = -1: must be an integer in [0, inf)"),
    (("--steps", "0"), "--steps 0: must be an integer in [1, 1e18)"),
    (("--steps", "many"), "--steps many: must be an integer in [1, 1e18)"),
    (("--time-limit", "0"), "--time-limit 0: must be a number in (0, inf) [s]"),
    (("--time-limit", "1:00"), "--time-limit 1:00: must be a number in (0, inf) [s]"),
])
def test_mistakes_on_the_command_line_of_a_resumed_run(stopped, hampm, words, phrase):
    result = hampm("--resume", CHECKPOINT, *words)
    assert result.returncode == 2
    assert phrase in result.stderr


def test_intervals_of_checkpoints_can_be_changed_on_the_way(stopped, hampm, unbroken):
    assert hampm("--resume", CHECKPOINT, "--set", "output.checkpoint_steps=5", "--steps", 50).returncode == 5
    assert hampm("--resume", CHECKPOINT, "--set", "output.checkpoint_interval=0.01").returncode == 0
    assert differing(unbroken, stopped / "dcb.h5") == []
