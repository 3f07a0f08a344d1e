"""Runs that end before their end time, as &run stop_when has it, and runs that are resumed with another end."""

import re

import h5py
import numpy as np
import pytest

# A strip under tension by grips that move, with a crack from its left edge; static growth
PLATE = """
&run plane = 'strain'  end_time = {end}  {stop} /
&grid lower = -20e-3, -21e-3  cell = 1e-3  cells = 40, 42 /
&material name = 'steel'  young = 200e9  poisson = 0.3  density = 7800 /
&body material = 'steel'  lower = -20e-3, -20e-3  upper = 20e-3, 20e-3 /
&constraint lower = -20e-3, -20e-3  upper = 20e-3, -20e-3  fix = 'xy' /
&constraint lower = -20e-3, 20e-3  upper = 20e-3, 20e-3  fix = 'y'  displacement = 0.0, 10e-6  history = 'smooth_ramp'  rise_time = {rise}  name = 'grip' /
&crack kind = 'path'  points = -21e-3, 0.0, -6e-3, 0.0 /
{growth}
&method {method} /
&energy_release estimators = 'domain_integral' /
{output}
"""
AT_REST = "&growth toughness = 100.0  increment = 2e-3  direction = 'straight' /"
AT_SPEED = "&growth law = 'prescribed'  speed = 800.0  direction = 'straight'  start = 2e-6  end = 6e-6 /"


def plate(hampm, tmp_path, stop, code=0, options=(), **values):
    """Run the plate: what it says, and its history."""
    values = {"end": 1.0, "rise": 1.0, "growth": AT_REST, "method": "time = 'static'  load_steps = 8", "output": "", "stop": stop} | values
    (tmp_path / "plate.nml").write_text(PLATE.format(**values))
    result = hampm("plate.nml", "--force", *options)
    assert result.returncode == code, result.stderr
    return result


def history(tmp_path):
    """The columns and attributes of the history."""
    with h5py.File(tmp_path / "plate.h5") as file:
        return {name: column[:] for name, column in file["history"].items()}, dict(file["history"].attrs)


MOTION = {"end": 20e-6, "rise": 4e-6, "growth": AT_SPEED, "method": "mass = 'weighted'", "output": "&output history_interval = 0.5e-6 /"}


@pytest.mark.parametrize("motion", [{}, MOTION, MOTION | {"method": "time = 'implicit'  time_step = 1e-7"}], ids=["rest", "explicit", "implicit"])
def test_a_length_ends_a_run(hampm, tmp_path, motion):
    result = plate(hampm, tmp_path, "stop_when = 'crack_length'  stop_length = 17e-3", **motion)
    row, attributes = history(tmp_path)
    assert row["crack_length"][-1] >= 17e-3 * (1 - 1e-9) > row["crack_length"][-2]
    assert row["time"][-1] < motion.get("end", 1.0)
    assert attributes["ended"] == "done"
    assert attributes["stopped_when"].startswith(f"crack_length: a crack is 0.01{7 if motion else 8}")
    (time,) = re.findall(r"ended at t = (\S+) s by &run stop_when, crack_length: a crack is", result.stdout)
    assert float(time) == pytest.approx(row["time"][-1], rel=1e-5) and len(time.split("e")[0]) <= 7
    assert not (tmp_path / "plate.h5.checkpoint").exists()


def test_it_is_the_run_without_it_as_far_as_it_goes(hampm, tmp_path):
    plate(hampm, tmp_path, "", **MOTION)
    whole, _ = history(tmp_path)
    plate(hampm, tmp_path, "stop_when = 'crack_length'  stop_length = 17e-3", **MOTION)
    row, _ = history(tmp_path)
    for name, column in row.items():
        assert column.tobytes() == whole[name][:len(column)].tobytes(), name


def test_an_arrested_crack_ends_a_run(hampm, tmp_path):
    """The crack grows from 2 to 6 us; the run ends when it has been at rest for 3 us."""
    plate(hampm, tmp_path, "stop_when = 'arrested'  stop_rest = 3e-6", **MOTION)
    row, attributes = history(tmp_path)
    assert attributes["stopped_when"].startswith("arrested")
    assert 9e-6 <= row["time"][-1] < 10e-6
    assert row["tip_speed"][-1] == 0


def test_arrest_at_rest_is_a_tip_that_has_stopped(hampm, tmp_path):
    plate(hampm, tmp_path, "stop_when = 'arrested'", growth=AT_REST.replace(" /", "  max_length = 18e-3 /"))
    row, attributes = history(tmp_path)
    assert attributes["stopped_when"].startswith("arrested")
    assert row["crack_length"][-1] >= 18e-3 * (1 - 1e-9)
    assert len(row["time"]) < 9


@pytest.mark.parametrize("motion", [{"end": 20.0, "method": "time = 'static'  load_steps = 20"},
                                    MOTION | {"end": 60e-6, "growth": AT_SPEED.replace("  end = 6e-6", "")}], ids=["rest", "explicit"])
def test_a_parted_body_ends_a_run(hampm, tmp_path, motion):
    """With the first sample from which on nothing joins both pieces; other ends are looked at as well."""
    plate(hampm, tmp_path, "stop_when = 'separated', 'arrested', 'load_dropped', 'crack_length'  stop_length = 1.0  stop_load = 1e-9  stop_rest = 1.0", **motion)
    row, attributes = history(tmp_path)
    assert attributes["stopped_when"] == "separated: a crack has parted a body"
    assert row["time"][-2] < attributes["separated"] <= row["time"][-1] < motion["end"]
    assert row["crack_length"][-1] == pytest.approx(40e-3, abs=1.5e-3)


def test_a_dropped_load_ends_a_run(hampm, tmp_path):
    plate(hampm, tmp_path, "")
    whole, _ = history(tmp_path)
    load = np.hypot(whole["reaction_grip_x"], whole["reaction_grip_y"])
    first = int(np.argmax(load < 0.8 * np.maximum.accumulate(load)))
    assert 0 < first < len(load) - 1
    plate(hampm, tmp_path, "stop_when = 'load_dropped', 'crack_length'  stop_load = 0.8  stop_length = 1.0")
    row, attributes = history(tmp_path)
    assert len(row["time"]) == first + 1
    assert attributes["stopped_when"].startswith("load_dropped: the load is 0.7")


def test_the_largest_load_is_kept_in_checkpoints(hampm, tmp_path):
    stop = "stop_when = 'load_dropped'  stop_load = 0.8"
    plate(hampm, tmp_path, stop)
    whole, _ = history(tmp_path)
    plate(hampm, tmp_path, stop, code=5, options=("--steps", 2))
    assert hampm("--resume", "plate.h5.checkpoint").returncode == 0
    row, attributes = history(tmp_path)
    assert attributes["stopped_when"].startswith("load_dropped")
    for name, column in row.items():
        assert column.tobytes() == whole[name].tobytes(), name


def test_refused(hampm, tmp_path):
    assert "requires &growth" in plate(hampm, tmp_path, "stop_when = 'separated'", code=2, growth="").stderr
    for stop, words in (("stop_when = 'crack_length'", "stop_length"), ("stop_length = 1e-3", "stop_when = 'crack_length'"), ("stop_when = 'late'", "must be"),
                        ("stop_load = 0.7", "load_dropped")):
        assert words in plate(hampm, tmp_path, stop, code=2).stderr
    assert "&growth" in plate(hampm, tmp_path, "stop_when = 'arrested'", code=2, growth="").stderr


# --- another end of a run that is resumed ------------------------------------------------------------------------------

def test_a_motion_goes_on_to_a_later_end(hampm, tmp_path):
    """It is the run that had that end from its beginning: samples have the same interval."""
    plate(hampm, tmp_path, "", **MOTION)
    whole, _ = history(tmp_path)
    plate(hampm, tmp_path, "", code=5, options=("--steps", 20), **MOTION | {"end": 8e-6})
    assert hampm("--resume", "plate.h5.checkpoint", "--set", "run.end_time=14e-6", "--steps", 10).returncode == 5
    assert hampm("--resume", "plate.h5.checkpoint", "--set", "run.end_time=20e-6", "--steps", 10).returncode == 5
    assert hampm("--resume", "plate.h5.checkpoint").returncode == 0
    row, attributes = history(tmp_path)
    assert attributes["end_time"] == 20e-6
    for name, column in row.items():
        assert column.tobytes() == whole[name].tobytes(), name


def test_growth_at_rest_goes_on_by_the_same_load_steps(hampm, tmp_path):
    plate(hampm, tmp_path, "")
    whole, _ = history(tmp_path)
    plate(hampm, tmp_path, "", code=5, options=("--steps", 2), end=0.5, method="time = 'static'  load_steps = 4")
    refused = hampm("--resume", "plate.h5.checkpoint", "--set", "run.end_time=1.0")
    assert refused.returncode == 2 and "end_time/load_steps has to stay 0.125 s" in refused.stderr
    assert hampm("--resume", "plate.h5.checkpoint", "--set", "run.end_time=1.0", "--set", "method.load_steps=8").returncode == 0
    row, _ = history(tmp_path)
    for name, column in row.items():
        assert column.tobytes() == whole[name].tobytes(), name


def test_a_run_may_be_told_to_stop_when_it_is_resumed(hampm, tmp_path):
    plate(hampm, tmp_path, "", code=5, options=("--steps", 5), **MOTION)
    assert hampm("--resume", "plate.h5.checkpoint", "--set", "run.stop_when='crack_length'", "--set", "run.stop_length=16e-3").returncode == 0
    _, attributes = history(tmp_path)
    assert attributes["stopped_when"].startswith("crack_length")


def test_what_may_not_change(hampm, tmp_path):
    plate(hampm, tmp_path, "", code=5, options=("--steps", 20), **MOTION)
    other = hampm("--resume", "plate.h5.checkpoint", "--set", "material.young=1e9")
    assert other.returncode == 1 or "can be changed" in other.stderr
    early = hampm("--resume", "plate.h5.checkpoint", "--set", "run.end_time=1e-6")
    assert early.returncode == 2 and "cannot end before that" in early.stderr
    assert hampm("--resume", "plate.h5.checkpoint").returncode == 0
