"""`make slurm` on machines that it cannot run on: one line says why. What it does elsewhere takes minutes (docs/how-to/batches.md)."""

import os
import shutil
import socket
import subprocess
import sys
from pathlib import Path

import pytest

SLURM = Path(__file__).resolve().parents[2] / "tools/slurm.py"


def run(*words, part="requests", path=os.environ["PATH"], temporary=None):
    return subprocess.run([sys.executable, SLURM, part, "--program", sys.executable, *words], capture_output=True, text=True, timeout=60,
                          env=os.environ | {"PATH": str(path), "TMPDIR": str(temporary)})


def test_without_the_packages_of_debian(tmp_path):
    result = run(path=tmp_path, temporary=tmp_path)
    assert result.returncode == 1
    assert result.stderr == "slurm.py: there is no apt-get: the packages of Slurm are taken from Debian or Ubuntu\n"
    assert list(tmp_path.iterdir()) == []


def test_without_the_lists_of_packages(tmp_path):
    """As for a user who may not fetch them."""
    for name, body in {"apt-get": 'echo "E: Unable to locate package slurmctld" >&2; exit 100', "dpkg-deb": ":"}.items():
        (tmp_path / name).write_text(f"#!/bin/sh\n{body}\n")
        (tmp_path / name).chmod(0o755)
    (tmp_path / "sh").symlink_to(shutil.which("sh"))
    (tmp_path / "temporary").mkdir()
    result = run(path=tmp_path, temporary=tmp_path / "temporary")
    assert (result.returncode, result.stderr) == (
        1, "slurm.py: apt-get install: Unable to locate package slurmctld; `apt-get update` by root may help\n")
    assert list((tmp_path / "temporary").iterdir()) == []


@pytest.mark.skipif(not (SLURM.parents[1] / "build/slurm/packages.txt").exists(), reason="make slurm has not been run")
def test_a_port_that_is_taken(tmp_path):
    with socket.socket() as taken:
        taken.bind(("", 0))
        taken.listen()
        port = taken.getsockname()[1]
        result = run("--port", str(port), str(port + 1), temporary=tmp_path)
    assert (result.returncode, result.stderr) == (1, f"slurm.py: port {port} is taken\n") and list(tmp_path.iterdir()) == []


def test_a_part_that_is_none(tmp_path):
    result = run(part="limits", temporary=tmp_path)
    assert result.returncode == 2 and "there is no part 'limits'; there are requests, ended, limit, preempted, one_job" in result.stderr
