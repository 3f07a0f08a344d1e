"""Fixtures that all tests share."""

import os
import subprocess
import sys

import pytest

from paths import DCB, PROGRAM, SCRIPTS

sys.path.insert(0, str(SCRIPTS))

# For the program and for numpy, before it is loaded. Threads that wait must not spin: where there are more of them than
# free processors they would hardly get on.
os.environ |= {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "OMP_WAIT_POLICY": "passive"}

ACCIDENTS = "backtrace", "Fortran runtime", "Sanitizer", "SIGSEGV"
COARSE_DCB = DCB, "--set", "grid.cell=5e-3", "--set", "grid.cells=20,3", "--set", "run.end_time=3e-4"


@pytest.fixture(scope="session")
def run_hampm():
    """`run_hampm(*arguments, cwd=..., program=..., **options of subprocess.run)` runs the program; output as text."""
    def run(*arguments, cwd, program=PROGRAM, **options):
        options = {"timeout": 120, "errors": "replace"} | options
        result = subprocess.run([program, *map(str, arguments)], cwd=cwd, capture_output=True, text=True, **options)
        for accident in ACCIDENTS:
            assert accident not in result.stdout + result.stderr
        return result
    return run


@pytest.fixture
def hampm(run_hampm, tmp_path):
    """The program as a function, `hampm(*arguments, **options)`; it runs in the test's own folder."""
    def run(*arguments, cwd=tmp_path, **options):
        return run_hampm(*arguments, cwd=cwd, **options)
    return run


@pytest.fixture
def dcb(hampm):
    """`dcb(*arguments)` runs the double cantilever beam of input/ with coarse cells for a short time."""
    def run(*arguments, **options):
        return hampm(*COARSE_DCB, *arguments, **options)
    return run


@pytest.fixture(scope="session")
def dcb_result(run_hampm, tmp_path_factory):
    """Its result file."""
    folder = tmp_path_factory.mktemp("coarse_dcb")
    result = run_hampm(*COARSE_DCB, cwd=folder)
    assert result.returncode == 0, result.stderr
    return folder / "dcb.h5"
