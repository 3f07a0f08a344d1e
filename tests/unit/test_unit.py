"""Runs the unit test programs of tests/unit: in the checked build with its run-time checks, and by `make verify` in the release build; those that take minutes with checks the
other way round."""

import os
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
BUILDS = [Path(os.environ["HAMPM"]).parent.name] if "HAMPM" in os.environ else ["release", "checked"]
PROGRAMS = sorted(source.stem for source in Path(__file__).parent.glob("test_*.f90"))

IN_RELEASE = {"test_crossing_levels", "test_manufactured", "test_patch"}   # so has the Makefile


@pytest.mark.parametrize(("program", "build"), [
    pytest.param(program, build, id=f"{program}-{build}", marks=pytest.mark.verify if len(BUILDS) > 1 and (build == "release") != (program in IN_RELEASE) else [])
    for program in PROGRAMS for build in BUILDS])
def test_program(program, build):
    path = ROOT / "build" / build / program
    assert path.exists(), f"{path} is not built: run `make unit build={build}`"
    run = subprocess.run([path], capture_output=True, text=True, errors="replace", timeout=120)
    assert run.returncode == 0, f"{program} ({build}) failed with exit code {run.returncode}\n{run.stdout}{run.stderr}"
