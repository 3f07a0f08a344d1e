"""Folders and files without the permission to write or read: exit code 4, the reason, and nothing is lost.

Root may do everything: where the tests run as root the program runs as the user `nobody`, from a copy that he can read.
"""

import os
import re
import shutil
import subprocess
import tempfile
import time
from pathlib import Path

import pytest

from kill_at_random import read_whole
from harness import differing
from paths import COARSE_DCB, PROGRAM

NOBODY = {"user": 65534, "group": 65534, "extra_groups": []} if os.geteuid() == 0 else {}
SCENE = ("dcb.nml", *COARSE_DCB[1:], "--set", "output.snapshot_interval=1e-5", "--quiet")
SHORT = (*SCENE, "--set", "run.end_time=4e-5", "--set", "output.history_interval=1e-6", "--output", "results")
CHECKPOINT = "results/dcb.h5.checkpoint"
DENIED = "Permission denied"


@pytest.fixture
def place():
    """A folder that everyone may enter, with program, scene and an empty folder `results` that everyone may write in."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        folder.chmod(0o755)
        shutil.copy(PROGRAM, folder / "hampm")
        shutil.copy(COARSE_DCB[0], folder / "dcb.nml")
        (folder / "hampm").chmod(0o755)
        (folder / "dcb.nml").chmod(0o644)
        (folder / "results").mkdir()
        (folder / "results").chmod(0o777)
        try:
            subprocess.run(["./hampm", "--version"], cwd=folder, check=True, capture_output=True, **NOBODY)
        except OSError as error:
            pytest.skip(f"no program can be started as another user here: {error}")
        yield folder
        allow(folder / "results", 0o777)


@pytest.fixture
def run(run_hampm, place):
    """The program as a function of its arguments, run by someone who is not root."""
    return lambda *arguments: run_hampm(*arguments, cwd=place, program=place / "hampm", **NOBODY)


def allow(path, mode):
    """Give `path` the permissions `mode`, and to whom the tests run as."""
    os.chown(path, os.geteuid(), os.getegid())
    path.chmod(mode)


def contents(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def assert_refused(result, *patterns):
    assert result.returncode == 4, result.stderr
    for pattern in patterns:
        assert re.search(pattern, result.stderr), result.stderr


@pytest.fixture
def stopped(run, place):
    """The folder of a run that has stopped after 100 steps, no longer to be written in; and what is in it."""
    assert run(*SHORT, "--steps", 100).returncode == 5
    allow(place / "results", 0o555)
    return contents(place / "results")


def test_a_folder_that_cannot_be_written_in(run, place):
    allow(place / "results", 0o555)
    assert_refused(run(*SHORT), f"hampm: results/dcb.h5.*: cannot be written: .*{DENIED}")
    assert contents(place / "results") == {}


def test_a_folder_that_cannot_be_made(run, place):
    allow(place / "results", 0o555)
    assert_refused(run(*SHORT, "--output", "results/new"), "hampm: results/new: the folder cannot be made: no permission to write")
    assert contents(place / "results") == {}


def test_a_folder_that_cannot_be_entered(run, place):
    allow(place / "results", 0)
    assert_refused(run(*SHORT), "hampm: results: .*a folder that may not be entered")


def test_a_result_that_cannot_be_replaced(run, place, stopped):
    assert_refused(run(*SHORT, "--force"), f"hampm: results/dcb.h5.*: cannot be written: .*{DENIED}")
    assert contents(place / "results") == stopped


def test_a_run_that_cannot_be_resumed_goes_on_when_it_may(run, place, stopped):
    assert_refused(run("--resume", CHECKPOINT), f"hampm: results/dcb.h5.*: cannot be written: .*{DENIED}")
    assert contents(place / "results") == stopped
    allow(place / "results", 0o777)
    assert run("--resume", CHECKPOINT, "--quiet").returncode == 0
    (place / "unbroken").mkdir()
    allow(place / "unbroken", 0o777)
    assert run(*SHORT, "--output", "unbroken").returncode == 0
    assert differing(place / "unbroken/dcb.h5", place / "results/dcb.h5") == []


@pytest.mark.parametrize("name", ["dcb.h5.checkpoint", "dcb.h5"])
def test_a_file_that_cannot_be_read(run, place, stopped, name):
    allow(place / "results" / name, 0)
    assert_refused(run("--resume", CHECKPOINT), f"hampm: results/{name}: cannot be read: .*{DENIED}")
    allow(place / "results" / name, 0o644)
    assert contents(place / "results") == stopped


def test_a_scene_that_cannot_be_read(run, place):
    allow(place / "dcb.nml", 0)
    assert_refused(run("dcb.nml", "--check"), f"hampm: dcb.nml: cannot be read: .*{DENIED}")


def test_permission_that_is_lost_on_the_way(run, place):
    """Result and checkpoint are those of the last time, and the run goes on from there."""
    command = ["./hampm", *map(str, SCENE), "--output", "results", "--set", "run.end_time=1.0", "--set", "output.checkpoint_steps=100"]
    process = subprocess.Popen(command, cwd=place, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, **NOBODY)
    deadline = time.time() + 60
    while not (place / CHECKPOINT).exists() and process.poll() is None and time.time() < deadline:
        time.sleep(0.01)
    allow(place / "results", 0o555)
    message = process.communicate(timeout=60)[1]
    assert process.returncode == 4, message
    assert re.search("hampm: results/dcb.h5.*: cannot be written: ", message)
    assert read_whole(place / "results/dcb.h5") and read_whole(place / CHECKPOINT)
    allow(place / "results", 0o777)
    assert run("--resume", CHECKPOINT, "--steps", 1).returncode == 5
