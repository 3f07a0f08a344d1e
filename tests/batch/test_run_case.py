"""One case in its folder: what is an outcome, what is not, and how a case goes on."""

import json
import os
import re
import signal
import subprocess
import sys
from contextlib import suppress

import pytest

from history import History
from paths import BATCH, PROGRAM
from hampm.batch.progress import begin_to_count, count_end, duration
from scene import FLIGHT, SLOW, runs_of, wait_for

CHECKPOINT = "case.h5.checkpoint"


@pytest.fixture
def case(tmp_path):
    """The command that runs a case with settings in the folder `case`."""
    (tmp_path / "flight.nml").write_text(FLIGHT)

    def command(settings={}, *options):
        words = [f"{key}={value}" for key, value in settings.items()]
        return [sys.executable, BATCH / "run_case.py", tmp_path / "case", tmp_path / "flight.nml", "--program", PROGRAM,
                *options, "--set", *words]
    return command


@pytest.fixture
def folder(tmp_path):
    return tmp_path / "case"


def run(command):
    return subprocess.run(command, capture_output=True, text=True, timeout=60)


def outcome(folder):
    return json.loads((folder / "outcome.json").read_text())


@pytest.mark.parametrize("settings, end, message", [
    ({}, "done", ""),
    ({"method.mass": "consisten"}, "refused", "did you mean 'consistent'?"),
    ({"body.velocity": "30000,0"}, "failed", "Likely cause: the run is unstable")])
def test_an_end_that_would_come_again_is_an_outcome(case, folder, settings, end, message):
    result = run(case(settings))
    assert (result.returncode, result.stderr) == (0, "")
    found = outcome(folder)
    assert found["outcome"] == end and message in found["message"] and not found["message"].startswith("hampm")
    assert found["case"]["settings"] == settings
    assert found["spent"]["starts"] == 1 and found["spent"]["cpu_seconds"] > 0 and found["spent"]["peak_megabytes"] > 1
    assert list(folder.glob("ended-*")) and (folder / "case.h5").exists() == (end != "refused")


def test_a_case_with_an_outcome_is_not_run_again_until_it_is_another(case, folder, tmp_path):
    run(case())
    before = (folder / "case.h5").stat().st_mtime_ns
    run(case())
    assert (folder / "case.h5").stat().st_mtime_ns == before
    (tmp_path / "flight.nml").write_text(FLIGHT.replace("velocity = 30", "velocity = 20"))
    run(case())
    assert (folder / "case.h5").stat().st_mtime_ns > before


def test_what_may_end_otherwise_next_time_is_no_outcome(case, folder):
    folder.mkdir()
    (folder / "case.h5").mkdir()   # as a disk that cannot be written
    result = run(case())
    assert result.returncode == 1 and result.stderr.startswith("not finished: case: exit code 4: ")
    assert not (folder / "outcome.json").exists() and not list(folder.glob("ended-*"))
    (folder / "case.h5").rmdir()
    assert run(case()).returncode == 0 and outcome(folder)["spent"]["starts"] == 2


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT, signal.SIGKILL], ids=lambda number: number.name)
def test_a_stopped_case_goes_on_from_its_checkpoint(case, folder, number):
    """SIGTERM is for all processes, and twice, as of Slurm and its srun, SIGINT for the group, as of a keyboard, and SIGKILL for the script alone."""
    process = subprocess.Popen(case(SLOW, "--checkpoint", "0.1"), stderr=subprocess.PIPE, text=True, start_new_session=True)
    wait_for((folder / CHECKPOINT).exists)
    if number == signal.SIGTERM:
        for each in 2 * (process.pid, *runs_of(folder, PROGRAM)):
            with suppress(ProcessLookupError):
                os.kill(each, signal.SIGTERM)
    elif number == signal.SIGINT:
        os.killpg(process.pid, signal.SIGINT)
    else:
        process.kill()
    message = process.communicate(timeout=60)[1]
    wait_for(lambda: not runs_of(folder, PROGRAM))
    assert process.returncode == (-signal.SIGKILL if number == signal.SIGKILL else 1)
    assert number == signal.SIGKILL or "exit code 5: step" in message
    assert (folder / CHECKPOINT).exists() and not (folder / "outcome.json").exists()
    assert run(case(SLOW)).returncode == 0
    assert History(folder / "case.h5").times[-1] == float(SLOW["run.end_time"])
    assert not (folder / CHECKPOINT).exists() and outcome(folder)["outcome"] == "done"


def test_the_checkpoint_of_another_case_is_not_gone_on_from(case, folder, tmp_path):
    process = subprocess.Popen(case(SLOW, "--checkpoint", "0.1"), stderr=subprocess.DEVNULL)
    wait_for((folder / CHECKPOINT).exists)
    process.terminate()
    process.wait(timeout=60)
    assert run(case()).returncode == 0
    words = "--output", tmp_path / "alone", "--set", "output.file=result.h5"
    assert subprocess.run([PROGRAM, tmp_path / "flight.nml", "--quiet", *words]).returncode == 0
    alone = History(tmp_path / "alone/result.h5").columns
    for name, values in History(folder / "case.h5").columns.items():
        assert values.tobytes() == alone[name].tobytes()


def test_two_starts_at_a_time_run_a_case_once(case, folder):
    processes = [subprocess.Popen(case(SLOW), stdout=subprocess.DEVNULL) for _ in range(2)]
    assert [process.wait(timeout=60) for process in processes] == [0, 0]
    assert outcome(folder)["spent"]["starts"] == 1


@pytest.mark.parametrize(("seconds", "text"), [(0, "0 s"), (89, "89 s"), (90, "1.5 min"), (601, "10 min"), (7200, "2.0 h"), (2e6, "23 d")])
def test_times_that_are_left(seconds, text):
    assert duration(seconds) == text


def test_cases_that_end_are_counted(tmp_path):
    begin_to_count(tmp_path, 12, 9)
    assert [re.sub(r"\d+ s", "T", count_end(tmp_path / "cases/any")) for _ in range(3)] == ["[10/12, T left] ", "[11/12, T left] ", "[12/12] "]
    assert count_end(tmp_path / "no/sweep/here") == ""
    assert [path.name for path in tmp_path.iterdir()] == ["progress"]
