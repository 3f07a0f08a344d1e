"""A run that goes wrong says so: exit code, step, time, place, likely cause; what it recorded stays readable."""

import os
import re
import resource
import shutil
import subprocess
import time
from pathlib import Path

import h5py
import numpy as np
import pytest

from history import History
from paths import COARSE_DCB, DCB, CHECKED_PROGRAM, INPUT, PROGRAM

UNSTABLE = *COARSE_DCB, "--set", "output.history_interval=1e-5", "--set", "damping.rate=0"
FLYING = """\
&run end_time = 1e-3 /
&grid cell = 1.0 cells = 4, 2 /
&material name = 'a' young = 1e6 density = 1000 /
&body material = 'a' lower = 1.3, 0.2 upper = 2.3, 0.8 velocity = 3000, 0 /
&method frame = 'updated' /
"""
CRUSHED = """\
&run end_time = 1.0 /
&grid cell = 1.0 cells = 2, 1 /
&material name = 'a' law = 'neo_hookean' young = 1e3 density = 1000 /
&body material = 'a' lower = 0, 0 upper = 1, 1 /
&constraint lower = 0, 0 upper = 0, 1 fix = 'xy' /
&load kind = 'body' lower = 0, 0 upper = 1, 1 force = -1e9, 0 /
"""
CANCELLED = """\
&run end_time = 2e-4 thickness = 0.01 /
&grid lower = -0.01, -0.04 cell = 2.5e-3 cells = 48, 32 /
&material name = 'a' young = 70e9 poisson = 0.3 density = 2700 /
&body material = 'a' lower = 0.0003, -0.03 upper = 0.1, 0.03 /
&load kind = 'traction' lower = 0.0003, -0.03 upper = 0.0403, -0.03 force = 0, 1e3 /
&load kind = 'traction' lower = 0.0003, -0.03 upper = 0.0403, -0.03 force = 0, -333.3 /
&load kind = 'traction' lower = 0.0003, -0.03 upper = 0.0403, -0.03 force = 0, -666.7 /
&output file = 'none.h5' history_interval = 1e-6 /
"""
WHEN = r"hampm: step \d+, t = \S+ s: "
PLACE = r"\(\S+, \S+\) m"

builds = pytest.mark.parametrize("program", [
    PROGRAM, pytest.param(CHECKED_PROGRAM, marks=pytest.mark.skipif(not CHECKED_PROGRAM.exists(), reason="no checked build"))],
    ids=["release", "checked"])


def assert_failed(result, path, *patterns):
    """Exit code 3, a message of one line, behind warnings, that matches all patterns, and a history of numbers that are
    finite, but for estimated errors that are not known."""
    assert result.returncode == 3, result.stderr
    assert result.stderr.endswith("\n")
    message, = (line for line in result.stderr.splitlines() if not line.startswith("hampm: warning: "))
    for pattern in (WHEN, *patterns):
        assert re.search(pattern, message), result.stderr
    history = History(path)
    assert message == f"hampm: {history.attributes['ended']}"
    assert [line for line in result.stderr.splitlines() if line != message] == [
        f"hampm: warning: {line}" for line in history.attributes["warnings"].splitlines()]
    assert history.times.size >= 1
    for name, values in history.columns.items():
        assert np.all(np.isfinite(values)) or name.endswith("_error") and not np.any(np.isinf(values)), name
    with h5py.File(path) as file:
        assert file["VTKHDF/particles/Steps/Values"][-1] >= history.times[-1]   # a last snapshot
    return history


@builds
@pytest.mark.parametrize("scheme", ["musl", "usavg", "usf", "usl"])
def test_an_unstable_run(hampm, tmp_path, program, scheme):
    result = hampm("1.15", *UNSTABLE, "--set", f"method.scheme={scheme}", program=program.with_name("forced_step"))
    assert_failed(result, tmp_path / "dcb.h5", PLACE, "Likely cause: .*run is unstable.* &method courant")


@builds
@pytest.mark.parametrize("indicator", ["gradient", "zz", "tip"])
def test_an_unstable_run_whose_mesh_adapts_still_has_all_fields_in_its_last_snapshot(hampm, tmp_path, program, indicator):
    """R is not a number there: it can't be found from particles that have gone wrong."""
    result = hampm("1.15", *UNSTABLE, "--set", f"refine.indicator={indicator}", "--set", "refine.max_level=1",
                   "--set", "refine.interval=5", program=program.with_name("forced_step"))
    assert_failed(result, tmp_path / "dcb.h5", "&method courant")
    with h5py.File(tmp_path / "dcb.h5") as file:
        counts = file["VTKHDF/mesh/NumberOfPoints"][()]
        for values in file["VTKHDF/mesh/PointData"].values():
            assert len(values) == sum(counts)
        if indicator == "gradient":
            assert np.all(np.isnan(file["VTKHDF/mesh/PointData/R"][-counts[-1]:]))


@builds
def test_a_body_that_leaves_the_grid(hampm, tmp_path, program):
    (tmp_path / "case.nml").write_text(FLYING)
    result = hampm("case.nml", program=program)
    history = assert_failed(result, tmp_path / "case.h5", rf"particle \d+ left the grid at {PLACE}; it started at {PLACE}",
                            "Likely cause: .* &grid more cells")
    assert history.times[-1] == pytest.approx((4.0 - 2.05) / 3000, abs=2e-6)


@pytest.mark.parametrize("mass", [[], ["--set", "method.mass=consistent"],
                                  ["--set", "method.mass=consistent", "--set", "method.solver=direct"]], ids=["lumped", "cg", "direct"])
def test_a_crushed_body(hampm, tmp_path, mass):
    (tmp_path / "case.nml").write_text(CRUSHED)
    result = hampm("case.nml", *mass)
    assert_failed(result, tmp_path / "case.h5", "Likely cause: .*&method courant")


@pytest.mark.parametrize(("output", "phrase"), [
    ("file/results", "a file has this name"), ("file", "a file has this name"),
    ("/proc/results", "cannot be made"), ("results", "dcb.h5: cannot be written: .*Is a directory")])
def test_an_output_folder_that_cannot_be_written(dcb, tmp_path, output, phrase):
    (tmp_path / "file").touch()
    (tmp_path / "results/dcb.h5").mkdir(parents=True)
    result = dcb("--output", output)
    assert result.returncode == 4
    assert re.search(phrase, result.stderr), result.stderr
    assert (tmp_path / "file").read_bytes() == b""


def test_a_namelist_that_is_not_there(hampm):
    result = hampm("nothing.nml")
    assert result.returncode == 4
    assert "nothing.nml" in result.stderr


def test_a_scene_with_a_mistake_writes_nothing(dcb, tmp_path):
    assert dcb("--set", "material.young=-1").returncode == 2
    assert list(tmp_path.iterdir()) == []


def test_loads_that_cancel_leave_rounding_which_is_not_judged(hampm, tmp_path):
    """The exact answer is that nothing happens, which is said: what is left of 1000 N is some 1e-13 N, and no sign of an unstable run."""
    (tmp_path / "none.nml").write_text(CANCELLED)
    result = hampm("none.nml", "--quiet")
    assert result.returncode == 0
    assert re.fullmatch(r"hampm: warning: the loads have done no work, and nothing has moved\. .*\n", result.stderr)
    stored = History(tmp_path / "none.h5").columns["strain_energy"]
    assert 0 < stored.max() < 1e-30, "rounding, of a square of 1e-13 N"


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no full device")
@pytest.mark.parametrize("arguments", [["--help"], ["--version"], ["--keys"], ["--template"], [DCB, "--check"]], ids=str)
def test_a_full_standard_output(arguments):
    """What was asked for and could not be printed is no success."""
    with open("/dev/full", "w") as full:
        result = subprocess.run([PROGRAM, *arguments], stdout=full, stderr=subprocess.PIPE, text=True)
    assert (result.returncode, result.stderr) == (4, "hampm: the standard output cannot be written (is the disk full?)\n")


SCENES_IN_LITTLE_ROOM = {
    "explicit": COARSE_DCB, "static": [INPUT / "edge_crack.nml"], "refined": [*COARSE_DCB, "--set", "refine.indicator=gradient",
                                                                              "--set", "refine.max_level=2"],
    "consistent mass": [*COARSE_DCB, "--set", "method.mass=consistent", "--set", "method.solver=direct", "--set", "run.end_time=1e-6"]}


@pytest.mark.parametrize("megabytes", [330, 400, 460, 520, 600, 700, 900])
@pytest.mark.parametrize("arguments", SCENES_IN_LITTLE_ROOM.values(), ids=SCENES_IN_LITTLE_ROOM)
def test_little_room_in_memory(hampm, arguments, megabytes):
    """Wherever it ends, the run is refused or stopped with one line, or done; the library of linear algebra would wait for ever."""
    result = hampm(*arguments, "--quiet", "--threads", "1", timeout=60,
                   preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (megabytes * 10**6,) * 2))
    assert result.returncode in (0, 2, 3), result.stderr
    assert result.returncode == 0 or len([line for line in result.stderr.splitlines() if "warning" not in line]) == 1, result.stderr


def test_more_threads_than_processors_are_warned_of(dcb):
    n = len(os.sched_getaffinity(0))
    result = dcb("--quiet", "--threads", str(n + 1), "--steps", "2", "--force")
    assert f"hampm: warning: {n + 1} threads share {n} processors" in result.stderr and f"--threads {n} is faster" in result.stderr
    assert "share" not in dcb("--quiet", "--threads", str(n), "--steps", "2", "--force").stderr


def test_threads_that_cannot_be_started(dcb):
    result = dcb("--threads", "300", preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (10**9,) * 2))
    assert result.returncode == 2
    assert re.match(r"hampm: 300 threads cannot be started, but \d+: use fewer \(--threads", result.stderr), result.stderr


@pytest.mark.parametrize("kilobytes", [64, 128, 512])
@pytest.mark.parametrize("dim", [2, 3])
def test_a_small_stack_is_told(hampm, hampm3d, dim, kilobytes):
    """Before anything takes of it more than there is."""
    scene = INPUT / ("solid/dcb.nml" if dim == 3 else "dcb.nml")
    result = (hampm3d if dim == 3 else hampm)("--check", scene, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_STACK, (kilobytes * 1024,) * 2))
    assert result.returncode == 2
    assert re.fullmatch(r"hampm: the limit of the stack \(ulimit -s\) is \S+ kB: allow .*\n", result.stderr), result.stderr


@pytest.mark.parametrize("descriptors", [4, 5, 6, 8])
def test_few_file_descriptors(dcb, descriptors):
    result = dcb("--quiet", preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_NOFILE, (descriptors, descriptors)))
    if result.returncode != 0:
        assert result.returncode == 4
        assert re.fullmatch(r"hampm: \S+: cannot be written: .*Too many open files\n", result.stderr), result.stderr


def test_a_folder_that_is_removed_under_the_run(tmp_path):
    folder = tmp_path / "gone"
    folder.mkdir()
    process = subprocess.Popen([PROGRAM, DCB, "--quiet", "--set", "output.checkpoint_interval=1e-5"], cwd=folder,
                               stderr=subprocess.PIPE, text=True)
    while not (folder / "dcb.h5.checkpoint").exists() and process.poll() is None:
        time.sleep(0.01)
    while folder.exists():                           # while it is removed files are written into it
        shutil.rmtree(folder, ignore_errors=True)
    message = process.communicate(timeout=60)[1]
    assert process.returncode == 4
    assert all(re.match(r"hampm: \./dcb\.h5\S*: cannot be (written|read)", line) for line in message.splitlines()), message
