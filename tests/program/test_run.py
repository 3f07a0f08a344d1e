"""A run as a user sees it: what it prints, where it writes, and that the same scene gives the same results."""

import re

import h5py
import numpy as np
import pytest

import compare
from harness import differing
from history import History
from paths import DCB, CHECKED_PROGRAM

OLD_RESULT = b"\x89HDF\r\n\x1a\nsomething else"
PLATE = """&run plane = 'strain'  end_time = 1.0 /
&grid lower = -10e-3, -10e-3  cell = 1e-3  cells = 20, 20 /
&material name = 'a'  young = 200e9  poisson = 0.3  density = 7800 /
&body material = 'a'  lower = -10e-3, -10e-3  upper = 10e-3, 10e-3 /
&load kind = 'traction'  lower = -10e-3, 10e-3  upper = 10e-3, 10e-3  force = 0.0, 20e3 /
&load kind = 'traction'  lower = -10e-3, -10e-3  upper = 10e-3, -10e-3  force = 0.0, -20e3 /
&method time = 'static' /
&crack kind = 'path'  points = -3e-3, 0.0, 3e-3, 0.0 /
&energy_release estimators = 'domain_integral' /
"""
PROGRESS = r" *\d+\.\d% \d+\.\d{4} us (\d+:\d\d:\d\d|-) left G/Gref -?\d\.\d{4} step \d+ energy missing -?\d.\dE[+-]\d\d % cells 60 particles 160 level 0 "


def test_output_makes_folders(dcb, tmp_path):
    assert dcb("--output", "a/b/c").returncode == 0
    assert [path.name for path in (tmp_path / "a/b/c").iterdir()] == ["dcb.h5"]


def test_an_old_result_is_replaced_only_by_force(dcb, tmp_path):
    (tmp_path / "dcb.h5").write_bytes(OLD_RESULT)
    result = dcb()
    assert (result.returncode, result.stdout) == (4, "")
    assert result.stderr == "hampm: ./dcb.h5: there is a result. To replace it: --force. Or use another &output file or --output\n"
    assert [path.name for path in tmp_path.iterdir()] == ["dcb.h5"]
    assert (tmp_path / "dcb.h5").read_bytes() == OLD_RESULT
    assert dcb("--force").returncode == 0
    assert History(tmp_path / "dcb.h5").times.size == 301
    assert [path.name for path in tmp_path.iterdir()] == ["dcb.h5"]


def test_a_forced_run_that_fails_at_its_start_leaves_the_old_result(dcb, tmp_path):
    (tmp_path / "dcb.h5").write_bytes(OLD_RESULT)
    assert dcb("--force", "--set", "load.lower=0.5,0.5").returncode == 2
    (tmp_path / "dcb.h5.part").mkdir()
    assert dcb("--force").returncode == 4
    assert (tmp_path / "dcb.h5").read_bytes() == OLD_RESULT


def test_quiet_prints_nothing(dcb):
    result = dcb("--quiet")
    assert (result.returncode, result.stdout, result.stderr) == (0, "", "")


def test_progress_in_a_pipe_is_whole_lines(dcb):
    result = dcb()
    _, *lines, _, _, _, rest, took = result.stdout.splitlines()
    assert result.stderr == ""
    assert len(lines) >= 1 and re.fullmatch(r"wall time [0-9.]+ s, processor time [0-9.]+ s, threads \d+", took)
    assert re.match(r"distance to equilibrium: 0\.\d+ of the displacements; G, J and energies are about twice", rest)
    for line in lines:
        assert re.match(PROGRESS, line) and len(line) <= 132
    assert lines[-1].startswith("100.0% 300.0000 us")


def test_the_end_of_a_run_tells_what_was_found_at_each_tip(hampm, tmp_path):
    """The last values of the result, the estimated errors in percent of them, and where the tips are; nothing of it with --quiet."""
    (tmp_path / "plate.nml").write_text(PLATE)
    lines = hampm("plate.nml").stdout.splitlines()
    first = next(k for k, line in enumerate(lines) if line.split()[:1] == ["tip"])
    assert re.split(r"  +", lines[first].strip()) == ["tip", "length [m]", "angle [deg]", "G [J/m2]", "error", "J [J/m2]", "error",
                                                      "K_I [Pa m^0.5]", "error", "K_II [Pa m^0.5]", "error"]
    history = History(tmp_path / "plate.h5")
    for row, ending, angle in [(lines[first + 1], "", 0.0), (lines[first + 2], "_tip2", 180.0)]:
        words = re.split(r"  +", row.strip())
        assert len({len(line) for line in lines[first:first + 3]}) == 1
        assert [float(word) for word in words[1:3]] == [pytest.approx(6e-3), angle]
        for name, value, error in zip(["G", "J", "K_I", "K_II"], words[3::2], words[4::2]):
            told, off = (history.columns[name + suffix + ending][-1] for suffix in ("", "_error"))
            assert float(value) == pytest.approx(told, rel=1e-4)
            assert error == "> 100 %" if off > abs(told) else float(error.removesuffix(" %")) == pytest.approx(100 * off / abs(told), abs=0.051)
    assert lines[first + 3] == "errors are estimated from the cells"
    assert hampm("plate.nml", "--quiet", "--force").stdout == ""


def test_the_progress_line_has_the_unit_of_g_where_there_is_no_reference(hampm, tmp_path):
    (tmp_path / "plate.nml").write_text(PLATE)
    shown = float(re.search(r" left G (\S+) J/m2 step 1 ", hampm("plate.nml").stdout)[1])
    assert shown == pytest.approx(History(tmp_path / "plate.h5").columns["G"][-1], rel=1e-3)


def test_any_number_of_threads_gives_the_same_bytes(dcb, tmp_path):
    for threads in (1, 2, 3):
        short = "--set", "run.end_time=1e-4", "--set", "output.snapshot_interval=2e-5"
        assert dcb("--threads", threads, "--output", f"of_{threads}", *short).returncode == 0
    for threads in (2, 3):
        files = [str(tmp_path / f"of_{n}/dcb.h5") for n in (1, threads)]
        assert differing(*files) == []
        assert compare.main([*files, "--exact"]) == 0


def test_the_same_run_twice_gives_the_same_bytes(dcb, dcb_result, tmp_path):
    assert dcb().returncode == 0
    assert differing(dcb_result, tmp_path / "dcb.h5") == []


def test_what_check_prints_can_be_run(dcb, hampm, dcb_result, tmp_path):
    (tmp_path / "checked.nml").write_text(dcb("--check").stdout)
    assert hampm("checked.nml", "--output", "again").returncode == 0
    assert differing(dcb_result, tmp_path / "again/dcb.h5") == []


def test_the_namelist_in_the_result_can_be_run(hampm, dcb_result, tmp_path):
    with h5py.File(dcb_result) as file:
        (tmp_path / "used.nml").write_text(file["input/namelist"].asstr()[()])
    assert hampm("used.nml", "--output", "again").returncode == 0
    assert differing(dcb_result, tmp_path / "again/dcb.h5") == []


def test_set_changes_the_run(dcb, dcb_result, tmp_path):
    assert dcb("--set", "load.force=0.0, 2.0", "--set", "output.file=twice.h5").returncode == 0
    once, twice = History(dcb_result), History(tmp_path / "twice.h5")
    assert twice.g_ref() == pytest.approx(4 * once.g_ref(), rel=1e-12)
    ratio = twice.columns["strain_energy"][1:] / once.columns["strain_energy"][1:]
    np.testing.assert_allclose(ratio, 4, rtol=1e-4)  # linear but for the points' places in their cells


def test_outputs_fall_on_their_times(dcb_result):
    times = History(dcb_result).times
    np.testing.assert_allclose(times, 1e-6 * np.arange(301), rtol=1e-12, atol=0)


def test_intervals_that_do_not_divide_the_end_time(dcb, tmp_path):
    assert dcb("--set", "output.history_interval=7e-5", "--set", "output.snapshot_interval=0").returncode == 0
    np.testing.assert_allclose(History(tmp_path / "dcb.h5").times, [0, 7e-5, 14e-5, 21e-5, 28e-5, 30e-5], rtol=1e-12)


@pytest.mark.skipif(not CHECKED_PROGRAM.exists(), reason="no checked build")
def test_the_checked_build_gives_the_same_numbers(dcb, dcb_result, tmp_path):
    result = dcb("--output", "checked", program=CHECKED_PROGRAM)
    assert (result.returncode, result.stderr) == (0, "")
    assert compare.main([str(dcb_result), str(tmp_path / "checked/dcb.h5"), "--rtol", "1e-9",
                         "--tolerance", "numerical_loss=1e-6", "--ignore", "momentum_x"]) == 0  # nothing moves along x but rounding


def test_the_shipped_example_is_a_valid_scene(hampm):
    assert hampm(DCB, "--check").returncode == 0
