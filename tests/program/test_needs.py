"""What a scene needs is known before anything is built, and a scene that needs too much is refused."""

import os
import re
import resource
import subprocess
import sys

import pytest

from paths import CHECKED_PROGRAM, PROGRAM

SCENE = """\
&run thickness = 0.01 end_time = 1e-7 /
&grid cell = 1e-3 cells = {0}, {1} /
&material name = 'a' young = 70e9 poisson = 0.3 density = 2700 /
&body material = 'a' lower = 0.0, 0.0 upper = {2}e-3, {2}e-3 points_per_cell = {3} /
&load kind = 'traction' lower = 0.0, 0.0 upper = 0.0, {2}e-3 force = 1.0, 1.0 /
&method courant = 0.1 /
"""
PLAIN = SCENE.format(151, 151, 150, 2)
CRACK = "&constraint lower = 0.05, 0.0 upper = 0.1, 0.0 fix = 'y' /\n&crack tip = 0.05, 0.0 /\n"
PLAIN_METHOD = "&method courant = 0.1 /\n"
MASS = "&method courant = 0.1 mass = 'consistent' solver = '{}' frame = 'total' /\n"
SCENES = {
    "particles": SCENE.format(151, 151, 150, 4),
    "cells": SCENE.format(500, 500, 20, 2),
    "plain": PLAIN,
    "cg": PLAIN.replace(PLAIN_METHOD, MASS.format("cg")),
    "direct": PLAIN.replace(PLAIN_METHOD, MASS.format("direct")),
    "refined": SCENE.format(101, 101, 100, 2) + CRACK + "&refine indicator = 'tip' rings = 40 max_level = 4 /\n",
    "quadratic": SCENE.format(151, 151, 150, 3).replace("151 /", "151 order = 2 /"),
    "quadratic_static": SCENE.format(101, 101, 100, 3).replace("101 /", "101 order = 2 /").replace(PLAIN_METHOD, "&method time = 'static' /\n")
    + "&constraint lower = 0.1, 0.0 upper = 0.1, 0.1 fix = 'xy' /\n",
    **{f"quadratic_{solver}": SCENE.format(101, 101, 100, 3).replace("101 /", "101 order = 2 /").replace(PLAIN_METHOD, MASS.format(solver).replace("0.1", "0.05"))
       for solver in ("cg", "direct")},
    "quadratic_fmpm": SCENE.format(101, 101, 100, 3).replace("101 /", "101 order = 2 /").replace(PLAIN_METHOD,
                                                                                               "&method courant = 0.1 mass = 'fmpm' /\n"),
    "quadratic_implicit": SCENE.format(101, 101, 100, 3).replace("101 /", "101 order = 2 /").replace(
        PLAIN_METHOD, "&method time = 'implicit' time_step = 5e-8 mass = 'consistent' /\n"),
    "quadratic_points": SCENE.format(101, 101, 100, 6).replace("101 /", "101 order = 2 /"),
    "quadratic_refined": SCENE.format(61, 61, 60, 3).replace("61 /", "61 order = 2 /") + CRACK.replace("0.05", "0.03").replace("0.1,", "0.06,")
    + "&refine indicator = 'tip' rings = 20 max_level = 4 /\n",
    "quadratic_snapshots": SCENE.format(101, 101, 100, 3).replace("101 /", "101 order = 2 /") + "&output snapshot_interval = 1e-8 /\n",
    "domains": PLAIN.replace(PLAIN_METHOD, "&method courant = 0.1 shape_functions = 'cpdi' frame = 'updated' /\n"),
    "snapshots": PLAIN + "&output snapshot_interval = 1e-8 /\n",
}
# A process begins with the peak of the one that started it: that must be a small one.
MEASURE = """
import os, sys
_, status, used = os.wait4(os.spawnv(os.P_NOWAIT, sys.argv[1], sys.argv[1:]), 0)
print(used.ru_maxrss)
sys.exit(status != 0)
"""
UNIT = {"kB": 1e3, "MB": 1e6, "GB": 1e9, "TB": 1e12}


def said(report, what):
    """A size that --check prints [bytes]."""
    number, unit = re.search(rf"! {what} +about (\S+) (\w+)", report).groups()
    return float(number) * UNIT[unit]


@pytest.mark.parametrize("text", SCENES.values(), ids=SCENES)
def test_memory_and_size_of_results_are_as_foretold(hampm, tmp_path, text):
    (tmp_path / "case.nml").write_text(text)
    options = "--set", "output.history_interval=1e-8"
    check = hampm("case.nml", "--check", *options)
    assert check.returncode == 0, check.stderr
    peak = subprocess.run([sys.executable, "-c", MEASURE, PROGRAM, "case.nml", "--quiet", "--threads", "1", *options],
                          cwd=tmp_path, capture_output=True, text=True, check=True).stdout
    peak, size = 1024 * int(peak.split()[-1]), (tmp_path / "case.h5").stat().st_size
    print(f"memory: {peak / 1e6:.1f} MB, foretold {said(check.stdout, 'memory') / 1e6:.1f}; "
          f"results: {size / 1e6:.2f} MB, foretold {said(check.stdout, 'results') / 1e6:.2f}")
    assert said(check.stdout, "memory") == pytest.approx(peak, rel=0.3)
    assert said(check.stdout, "results") == pytest.approx(size, rel=0.3, abs=1e5)


@pytest.mark.parametrize("velocity", ["0.0, 0.0", "500.0, 300.0"], ids=["resting", "moving"])
def test_memory_of_plain_particles_is_as_foretold(hampm, tmp_path, velocity):
    text = SCENE.format(171, 171, 150, 2).replace("end_time = 1e-7", "end_time = 1e-5")
    text = re.sub("&load.*\n", "", text).replace("points_per_cell", f"velocity = {velocity} points_per_cell")
    (tmp_path / "case.nml").write_text(text.replace(PLAIN_METHOD, "&method courant = 0.1 frame = 'updated' /\n"))
    check = hampm("case.nml", "--check", "--set", "output.history_interval=1e-5")
    assert check.returncode == 0, check.stderr
    peak = 1024 * int(subprocess.run([sys.executable, "-c", MEASURE, PROGRAM, "case.nml", "--quiet", "--threads", "1", "--set",
                                      "output.history_interval=1e-5"], cwd=tmp_path, capture_output=True, text=True,
                                     check=True).stdout.split()[-1])
    print(f"memory: {peak / 1e6:.1f} MB, foretold {said(check.stdout, 'memory') / 1e6:.1f}")
    assert said(check.stdout, "memory") == pytest.approx(peak, rel=0.3)


def test_check_tells_rows_snapshots_and_what_refinement_may_come_to(hampm, tmp_path):
    refine = "&refine indicator = 'gradient' max_level = 3 /\n&output snapshot_interval = 1e-8 /\n"
    (tmp_path / "case.nml").write_text(SCENE.format(41, 41, 40, 2) + refine)
    report = hampm("case.nml", "--check").stdout
    assert "! samples         1001 of the history, 11 snapshots\n" in report
    assert re.search(r"! memory +about \d+ MB, \d+ MB where cells refine to 409600 particles\n", report)
    start, most = re.search(r"! results +about (\S+) MB, at most (\d+) MB\n", report).groups()
    assert float(start) < 20 and float(most) == pytest.approx((10 * 409600 * (169 + 113 / 4)) / 1e6, rel=0.1)


def test_results_of_a_refinement_that_runs_away_are_at_most_what_was_foretold(hampm, tmp_path):
    """Cells are refined as a wave comes to them; those with nothing but rounding are not."""
    refine = ("&refine indicator = 'gradient' max_level = 2 r_crit = 1e-9 energy_floor = 0.0 interval = 1 max_particles = 100000 /\n"
              "&output snapshot_interval = 2e-7 history_interval = 2e-7 /\n")
    (tmp_path / "case.nml").write_text(SCENE.format(41, 41, 40, 2).replace("end_time = 1e-7", "end_time = 2e-6") + refine)
    most = re.search(r"at most (\d+) MB", hampm("case.nml", "--check").stdout)[1]
    assert hampm("case.nml", "--quiet").returncode == 0
    assert 0.3 * float(most) < (tmp_path / "case.h5").stat().st_size / 1e6 < 1.1 * float(most)


TOO_MUCH = [
    (("cell = 1e-3 cells = 151, 151", "cell = 1e-5 cells = 20000, 20000"),
     r"the model needs about \d+ GB of memory for 900000000 particles and 400000000 cells, and there are \S+ GB"),
    (("cell = 1e-3 cells = 151, 151", "cell = 1e-5 cells = 30000, 30000"), "cells = 30000, 30000: they must have at most 5e8 nodes"),
    (("cell = 1e-3 cells = 151, 151", "cell = 1e-3 cells = 499999999, 1"), "cells = 499999999, 1: they must have at most 5e8 nodes"),
    (("end_time = 1e-7", "end_time = 1e9"), r"the run would take 3.2e16 time steps, more than 1.0e12: use a shorter &run end_time"),
    (("end_time = 1e-7", "end_time = 1e99"), r"the run would take 3.2e106 time steps"),
    (("young = 70e9", "young = 1e99"), r"the run would take 3.8e44 time steps"),
]


@pytest.mark.parametrize("program", [path for path in (PROGRAM, CHECKED_PROGRAM) if path.exists()], ids=lambda path: path.parent.name)
@pytest.mark.parametrize(("change", "message"), TOO_MUCH, ids=range(len(TOO_MUCH)))
def test_too_much_is_refused_at_once(hampm, tmp_path, change, message, program):
    """Limits on the memory of the process are those of the shell; the first scene needs more than any machine these tests meet."""
    (tmp_path / "case.nml").write_text(PLAIN.replace(*change))
    result = hampm("case.nml", program=program, timeout=10)
    assert result.returncode == 2, result.stderr
    assert re.search(message, result.stderr), result.stderr
    assert os.listdir(tmp_path) == ["case.nml"]


def test_a_limit_of_the_shell_counts_as_memory(hampm, tmp_path):
    (tmp_path / "case.nml").write_text(SCENE.format(2001, 2001, 2000, 2))
    limit = 4 * 10**9

    def restrict():
        resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
    result = hampm("case.nml", "--check", preexec_fn=restrict, timeout=10)
    assert result.returncode == 2
    assert re.search(r"needs about \d\.\d GB of memory for 16000000 particles and 4004001 cells, and there are 3.[3-6] GB: use fewer "
                     "&grid cells, a larger &grid cell or fewer &body points_per_cell", result.stderr)
