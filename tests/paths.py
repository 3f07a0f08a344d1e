"""Where the tests find what they test. The environment variables HAMPM and HAMPM3D name other builds than the release builds."""

import os
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PROGRAM = (ROOT / os.environ.get("HAMPM", "build/release/hampm")).resolve()
CHECKED_PROGRAM = ROOT / "build/checked/hampm"
SOLID_PROGRAM = (ROOT / os.environ.get("HAMPM3D", "build/release3d/hampm3d")).resolve()
RELEASE_BENCH = ROOT / "build/release/bench_step"
CHECKED_BENCH = ROOT / "build/checked/bench_step"
RESULTS_DRIVER = PROGRAM.with_name("results_driver")
SCRIPTS = ROOT / "postprocess"
PACKAGE = ROOT / "python/src"
BENCH = ROOT / "bench"
BATCH = ROOT / "batch"
INPUT = ROOT / "input"
REFERENCE = ROOT / "tests/reference"
REGRESSION = ROOT / "tests/regression"
DCB = INPUT / "dcb.nml"

# The double cantilever beam with coarse cells for a short time
COARSE_DCB = (DCB, "--set", "grid.cell=5e-3", "--set", "grid.cells=20,3", "--set", "run.end_time=3e-4",
              "--set", "energy_release.estimators=vcct,stress_closure", "--set", "energy_release.energy_balance=.true.")
