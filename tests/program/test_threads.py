"""How many threads a run takes, and how they wait."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
RELEASE = ROOT / "build/release/hampm"
MANY = [ROOT / "input/dcb.nml", "--steps", "1", "--set", "grid.cell=0.2e-3", "--set", "grid.cells=500,52", "--force"]
PROCESSORS = len(os.sched_getaffinity(0))


def first_line(result):
    return result.stdout.splitlines()[0]


def test_the_first_line_says_how_many_threads_and_why(hampm, dcb):
    assert first_line(dcb("--steps", "1")) == "1 thread, for 160 particles"
    assert first_line(dcb("--steps", "1", "--threads", "2", "--force")) == "2 threads, as --threads says"
    assert first_line(hampm(*MANY)) == "1 thread, as OMP_NUM_THREADS and the processors allow"


@pytest.mark.skipif(PROCESSORS < 2 or PROCESSORS != os.sysconf("SC_NPROCESSORS_ONLN"), reason="needs several processors, all of the machine")
def test_a_run_leaves_busy_processors_to_others(hampm, monkeypatch):
    """Each step all threads would wait for the one that has none."""
    monkeypatch.setenv("OMP_NUM_THREADS", "2")
    busy = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(PROCESSORS)]
    try:
        assert first_line(hampm(*MANY)) == "1 thread, as other processes are busy"
    finally:
        for process in busy:
            process.kill()
            process.wait()


def waiting(**settings):
    """How long threads of the release spin while they wait, in turns; None where the library of threads is a shared one."""
    if "libgomp" in subprocess.run(["ldd", RELEASE], capture_output=True, text=True).stdout:
        return None
    environment = {key: value for key, value in os.environ.items() if key not in ("OMP_WAIT_POLICY", "GOMP_SPINCOUNT")}
    shown = subprocess.run([RELEASE, "--version"], capture_output=True, text=True, env=environment | {"OMP_DISPLAY_ENV": "verbose", **settings})
    return int(re.search(r"GOMP_SPINCOUNT = '(\d+)'", shown.stderr)[1])


@pytest.mark.skipif(not RELEASE.exists() or waiting() is None, reason="the release has its library of threads elsewhere")
def test_threads_that_wait_sleep_soon():
    assert waiting() == 10000
    assert waiting(GOMP_SPINCOUNT="7") == 7
    assert waiting(OMP_WAIT_POLICY="active") > 10**6
