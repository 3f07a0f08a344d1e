"""Fixtures that all tests share."""

import os
import subprocess
import sys
from collections import Counter

import pytest

from long_tests import CHECKED, PARTS, cases, is_run
from paths import CHECKED_PROGRAM, COARSE_DCB, PACKAGE, PROGRAM, ROOT, SCRIPTS, SOLID_PROGRAM

sys.path[:0] = [str(SCRIPTS), str(PACKAGE)]

# For the program and for numpy, before it is loaded. Threads that wait must not spin: where there are more of them than
# free processors they would hardly get on.
os.environ |= {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "OMP_WAIT_POLICY": "passive"}

# Tests are compiled once, and not in each process again where the environment forbids it: that takes longer than to collect them
sys.dont_write_bytecode, sys.pycache_prefix = False, str(ROOT / "build/pycache")

ACCIDENTS = "backtrace", "Fortran runtime", "Sanitizer", "SIGSEGV"


def pytest_configure(config):
    config.addinivalue_line("markers", "verify: takes long; `make test` leaves it out, `make verify` runs it")


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items):
    """Mark the cases of tests that take long, but for the first ones or those that are named."""
    seen, runs = Counter(), cases()
    for item in items:
        file, test = item.path.stem, getattr(item, "originalname", item.name)
        case = item.name.partition("[")[2]
        kept = runs.get(file, {}).get(test)
        if kept is not None and not item.get_closest_marker("verify"):
            seen[file, test] += 1
            if not is_run(kept, seen[file, test], case):
                item.add_marker("verify")
        if case.startswith(PARTS.get(file, ())):
            item.add_marker("verify")


@pytest.fixture(scope="session")
def run_hampm():
    """`run_hampm(*arguments, cwd=..., program=..., **options of subprocess.run)` runs the program; output as text. With --check it tries no steps to
    tell the wall time, unless they are `timed`: of large models in the checked build these take most of the time."""
    def run(*arguments, cwd, program=PROGRAM, timed=False, **options):
        options = {"timeout": 120, "errors": "replace"} | options
        quiet = ["--quiet"] if "--check" in arguments and "--quiet" not in arguments and not timed else []
        result = subprocess.run([program, *map(str, arguments), *quiet], cwd=cwd, capture_output=True, text=True, **options)
        for accident in ACCIDENTS:
            assert accident not in result.stdout + result.stderr
        return result
    return run


@pytest.fixture
def hampm(request, run_hampm, tmp_path):
    """The program as a function, `hampm(*arguments, **options)`; it runs in the test's own folder, `hampm.folder`. Without HAMPM it is of the checked build in some files."""
    of_file = CHECKED_PROGRAM if request.path.stem in CHECKED and "HAMPM" not in os.environ else PROGRAM

    def run(*arguments, cwd=tmp_path, program=of_file, **options):
        return run_hampm(*arguments, cwd=cwd, program=program, **options)
    run.folder = tmp_path
    return run


@pytest.fixture
def hampm3d(hampm):
    """The same of the program for solids."""
    if not SOLID_PROGRAM.exists():
        pytest.skip("make program dim=3 makes it")

    def run(*arguments, **options):
        return hampm(*arguments, program=SOLID_PROGRAM, **options)
    run.folder = hampm.folder
    return run


@pytest.fixture(params=("plane", "solid"))
def either(request):
    """Each of both programs, and whether it is that for solids."""
    solid = request.param == "solid"
    return request.getfixturevalue("hampm3d" if solid else "hampm"), solid


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


def coarse_snapshots(run_hampm, folder, *settings):
    """Run the coarse beam with four snapshots; its result file."""
    words = [word for setting in settings for word in ("--set", setting)]
    result = run_hampm(*COARSE_DCB, "--set", "output.snapshot_interval=1e-4", *words, cwd=folder)
    assert result.returncode == 0, result.stderr
    return folder / "dcb.h5"


@pytest.fixture(scope="session")
def snapshot_result(run_hampm, tmp_path_factory):
    """The result file of the coarse beam with four snapshots, on uniform cells."""
    return coarse_snapshots(run_hampm, tmp_path_factory.mktemp("snapshots"))


@pytest.fixture(scope="session")
def refined_result(run_hampm, tmp_path_factory):
    """The same, refined around the tip to level 2."""
    return coarse_snapshots(run_hampm, tmp_path_factory.mktemp("refined"), "refine.indicator='gradient'",
                            "refine.r_crit=0.02", "refine.max_level=2", "refine.region_lower=0.04,0.0",
                            "refine.region_upper=0.06,0.005")
