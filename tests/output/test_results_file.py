"""What other programs find in the result file that the driver results_driver.f90 writes."""

import errno
import fcntl
import os
import pty
import re
import shutil
import subprocess

import h5py
import numpy as np
import pytest

from paths import RESULTS_DRIVER
from snapshots import field, points, read_steps

SAMPLES = 1300


def drive(folder, *mode):
    return subprocess.run([RESULTS_DRIVER, folder, *mode], check=True, capture_output=True, text=True).stdout


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("results")
    assert drive(path) == "results_driver passed\n"
    return path


@pytest.fixture(scope="module")
def results(folder):
    with h5py.File(folder / "results.h5") as file:
        yield file


def check_samples(history, samples):
    """The columns hold the first samples as the driver computes them."""
    number = np.arange(1, samples + 1)
    np.testing.assert_allclose(history["time"][:], 1e-6 * number, rtol=1e-15)
    np.testing.assert_array_equal(history["step"][:], 2**40 + number)
    np.testing.assert_allclose(history["G_domain_I"][:], 1.0 / number, rtol=1e-15)


def test_columns_hold_every_sample(results):
    check_samples(results["history"], SAMPLES)


def test_columns_have_the_right_types(results):
    history = results["history"]
    assert history["time"].dtype == np.float64
    assert history["step"].dtype == np.int64
    assert history["time"].maxshape == (None,)


def test_columns_carry_units_and_long_names(results):
    attributes = results["history/G_domain_I"].attrs
    assert attributes["units"] == "J/m2"
    assert attributes["long_name"] == "energy release rate, mode I"


def test_attributes_can_be_replaced_and_keep_their_types(results):
    assert results["history"].attrs["G_ref"] == 0.25
    assert results["history"].attrs["threads"] == 2
    assert results["input"].attrs["title"] == "Schälversuch"


def test_texts_are_read_as_written(results):
    assert results["input/namelist"].asstr()[()] == "&run title = 'Schälversuch'\n/"
    assert results["input/empty"].asstr()[()] == ""


def test_no_snapshots_unless_asked_for(folder):
    with h5py.File(folder / "plain.h5") as file:
        assert sorted(file) == ["history", "input"]
        check_samples(file["history"], SAMPLES)


def test_history_of_a_failed_run_is_complete(folder):
    with h5py.File(folder / "failed_run.h5") as file:
        check_samples(file["history"], 1)


def test_same_results_give_the_same_bytes(folder, tmp_path):
    drive(tmp_path)
    assert (tmp_path / "results.h5").read_bytes() == (folder / "results.h5").read_bytes()


def test_a_result_that_another_run_writes_is_not_touched(tmp_path):
    with (tmp_path / "results.h5.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        outcome = subprocess.run([RESULTS_DRIVER, tmp_path], capture_output=True, text=True)
    assert outcome.returncode != 0
    assert "results.h5: cannot be written: another run is writing it" in outcome.stdout


def test_a_reader_of_the_result_neither_hinders_nor_notices(folder, tmp_path):
    """The driver flushes 13 times while one of its results is open."""
    shutil.copy(folder / "plain.h5", tmp_path / "results.h5")
    with h5py.File(tmp_path / "results.h5") as file:
        assert drive(tmp_path) == "results_driver passed\n"
        check_samples(file["history"], SAMPLES)
    with h5py.File(tmp_path / "results.h5") as file:
        check_samples(file["history"], SAMPLES)
    assert read_steps(tmp_path / "results.h5")[0] == read_steps(folder / "results.h5")[0]


def test_files_by_turns_hold_the_same_as_one_that_is_written_at_once(folder):
    """With snapshots every 500 samples and flushes every 100, some snapshots are only in the file that is replaced."""
    with h5py.File(folder / "results.h5") as file:
        for name in ("Points", "PointData/mass"):
            data = file[f"VTKHDF/particles/{name}"][:]
            assert len(data) == 5 + 8 + 11 and np.all(np.isfinite(data))
        assert [file[f"VTKHDF/{block}/Steps"].attrs["NSteps"] for block in ("particles", "mesh")] == [3, 3]


@pytest.fixture
def killed(tmp_path):
    """The file of a run that was killed after a flush."""
    with subprocess.Popen([RESULTS_DRIVER, tmp_path, "killed"], stdin=subprocess.PIPE, stdout=subprocess.PIPE) as process:
        assert process.stdout.readline() == b"flushed\n"
        process.kill()
    return tmp_path / "killed.h5"


def test_flushed_samples_outlive_the_program(killed):
    with h5py.File(killed) as file:
        check_samples(file["history"], 100)
        assert file["input"].attrs["title"] == "Schälversuch"
    assert read_steps(killed)[0] == [0.0, 1e-3]


@pytest.mark.skipif(shutil.which("h5dump") is None, reason="h5dump is not installed")
def test_h5dump_reads_the_file_of_a_killed_program(killed):
    dump = subprocess.run(["h5dump", "-d", "/history/step", killed], check=True, capture_output=True, text=True).stdout
    assert str(2**40 + 100) in dump
    assert str(2**40 + 101) not in dump


def test_snapshots_have_their_times_and_blocks(folder):
    times, steps = read_steps(folder / "results.h5")
    np.testing.assert_allclose(times, [0.0, 1e-3, 2e-3], rtol=1e-15)
    with h5py.File(folder / "results.h5") as file:
        order = h5py.h5p.CRT_ORDER_TRACKED
        assert file["VTKHDF/Assembly"].id.get_create_plist().get_link_creation_order() & order and list(file["VTKHDF/Assembly"]) == ["particles", "mesh"]
        assert len(file["VTKHDF/Steps/Values"]) == 3 and {len(blocks) for blocks in steps} == {2}


@pytest.mark.parametrize("k", [0, 1, 2])
def test_the_number_of_particles_changes(folder, k):
    particles = read_steps(folder / "results.h5")[1][k][0]
    row = np.arange(1.0, 6 + 3 * k)
    zero = np.zeros_like(row)
    assert list(particles.kinds) == [1] * row.size and [list(cell) for cell in particles.cells] == [[i] for i in range(row.size)]
    np.testing.assert_array_equal(points(particles), np.column_stack([row, row + 10 * k, zero]))
    np.testing.assert_array_equal(field(particles.point_data, "velocity"), np.column_stack([row, -row, zero]))
    np.testing.assert_array_equal(field(particles.point_data, "mass"), 100 * k + row)
    assert points(particles).dtype == np.float64


@pytest.mark.parametrize("k", [0, 1, 2])
def test_the_mesh_changes(folder, k):
    mesh = read_steps(folder / "results.h5")[1][k][1]
    cells = 2 + k
    assert len(points(mesh)) == 2 * cells + 2 and list(mesh.kinds) == [9] * cells
    for i in range(cells):
        assert list(mesh.bounds(i)) == [i, i + 1, 0.0, 1.0, 0.0, 0.0]
    np.testing.assert_array_equal(field(mesh.cell_data, "level"), 10 * k + np.arange(1.0, cells + 1))


def test_progress_in_a_pipe_is_whole_lines(tmp_path):
    lines = drive(tmp_path, "progress").splitlines()
    assert len(lines) == 1
    assert lines[0].startswith("100.0% 1.0000 ms 0:00:00 left step ")
    assert "cells 720 particles 2880 level 4" in lines[0]
    assert "G/Gref" not in lines[0] and "energy" not in lines[0]


def read_to_end(terminal):
    """All that was written to a terminal whose other end is closed; one read may come before all of it has arrived."""
    parts = []
    while True:
        try:
            part = os.read(terminal, 65536)
        except OSError as error:
            if error.errno != errno.EIO:  # how Linux says that the other end is closed
                raise
            part = b""
        if not part:
            return b"".join(parts)
        parts.append(part)


def test_progress_on_a_terminal_is_one_refreshed_line(tmp_path):
    terminal, descriptor = pty.openpty()
    subprocess.run([RESULTS_DRIVER, tmp_path, "progress"], check=True, stdout=descriptor)
    os.close(descriptor)
    text = read_to_end(terminal).decode()
    os.close(terminal)
    shown = [re.sub(r"\x1b\[\?7[hl]|\x1b\[K", "", line) for line in re.split(r"\r(?!\n)", text) if line]
    assert 2 <= len(shown) <= 4
    assert "G/Gref 1.2870" in shown[0] and "energy missing -1.2E-04 %" in shown[0]
    assert all(len(line) <= 132 for line in shown[:-1])
    assert text.count("\n") == 1


def test_quiet_progress_prints_nothing(tmp_path):
    assert drive(tmp_path, "quiet") == ""
