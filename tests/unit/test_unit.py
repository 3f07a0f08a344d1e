"""Runs the unit test programs of tests/unit, each in the release build and in the checked build with its run-time checks."""

import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PROGRAMS = sorted(source.stem for source in Path(__file__).parent.glob("test_*.f90"))

LONG = {("test_manufactured", "checked"), ("test_mass_positions", "release"), ("test_refine_cycles", "release"),
        ("test_element_operators", "checked"), ("test_reference_step", "release"), ("test_cut_mass", "release"),
        ("test_crossing_levels", "checked"), ("test_patch", "checked"), ("test_cut_cells", "release"), ("test_newmark", "release"),
        ("test_changing_cells", "release"), ("test_quadratic_children", "release"), ("test_quadratic_cells", "release"), ("test_threads", "release"),
        ("test_local_leapfrog", "release"), ("test_transition", "release"), ("test_domain_integral", "release"), ("test_interface_points", "release")}


@pytest.mark.parametrize(("program", "build"), [
    pytest.param(program, build, id=f"{program}-{build}", marks=pytest.mark.verify if (program, build) in LONG else [])
    for program in PROGRAMS for build in ("release", "checked")])
def test_program(program, build):
    path = ROOT / "build" / build / program
    assert path.exists(), f"{path} is not built: run `make unit build={build}`"
    run = subprocess.run([path], capture_output=True, text=True, errors="replace", timeout=120)
    assert run.returncode == 0, f"{program} ({build}) failed with exit code {run.returncode}\n{run.stdout}{run.stderr}"
