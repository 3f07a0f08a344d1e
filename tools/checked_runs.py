"""Run the unit tests and short cases in a build or under a tool that finds wrong uses of memory.

    python tools/checked_runs.py sanitize     the build of that name: AddressSanitizer and UndefinedBehaviorSanitizer, leaks too
    python tools/checked_runs.py memcheck     the build of that name under valgrind: uses of what was never set, wrong addresses, leaks

Exit code 1 and what was reported where anything was. What is left out of the reports of unit tests stands in tools/*.supp.
"""

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
SUPPRESSED = {"sanitize": ROOT / "tools/leaks.supp", "memcheck": ROOT / "tools/valgrind.supp"}
SHORT = ["--quiet", "--set", "grid.cell=5e-3", "--set", "grid.cells=20,3", "--set", "run.end_time=2e-5",
         "--set", "output.history_interval=1e-6", "--set", "output.snapshot_interval=5e-6"]
DCB = ["input/dcb.nml", *SHORT]
ALL_ESTIMATORS = "energy_release.estimators=nodal_force,stress_closure,energy_balance"
CASES = {
    "template": ["--template"],
    "mistakes": ["input/dcb.nml", "--check", "--set", "material.yuong=1", "--set", "grid.cell=-1", "--set", "run=", "--nothing"],
    "check": ["input/dcb.nml", "--check"],
    "plain": [*DCB, "--set", ALL_ESTIMATORS],
    "two threads": [*DCB, "--threads", "2"],
    "total frame": [*DCB, "--set", "method.frame=total", "--set", "method.scheme=usavg"],
    "full mass, cg": [*DCB, "--set", "method.mass=full", "--set", "method.solver=cg"],
    "full mass, banded": [*DCB, "--set", "method.mass=full", "--set", "method.solver=banded", "--set", "method.frame=total"],
    "full mass, umfpack": [*DCB, "--set", "method.mass=full", "--set", "method.solver=umfpack"],
    "fmpm": [*DCB, "--set", "method.mass=fmpm"],
    "gradient": [*DCB, "--set", "refine.indicator=gradient", "--set", "refine.max_level=2", "--set", "refine.interval=5"],
    "error": [*DCB, "--set", "refine.indicator=zz", "--set", "refine.max_level=2", "--set", "refine.interval=5"],
    "tip, local time steps": [*DCB, "--set", "refine.indicator=tip", "--set", "refine.max_level=3",
                              "--set", "method.time_steps=local", "--set", "energy_release.estimators=nodal_force"],
    "no file": ["nothing.nml"],
    "no folder": [*DCB, "--output", "/dev/null/x"],
}
CODES = {"mistakes": 2, "no file": 4, "no folder": 4}


def environment(tool, is_unit=False):
    """What tells the tools to report all they find, and the threads to do nothing while they wait."""
    settings = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "OMP_WAIT_POLICY": "passive"}
    if tool == "sanitize":
        settings |= {"ASAN_OPTIONS": "detect_leaks=1:exitcode=99", "UBSAN_OPTIONS": "halt_on_error=1:exitcode=99",
                     "LSAN_OPTIONS": "exitcode=99:print_suppressions=0" + f":suppressions={SUPPRESSED[tool]}" * is_unit}
    return os.environ | settings


def wrapper(tool, is_unit):
    """The command before that of the program."""
    if tool == "sanitize":
        return []
    return ["valgrind", "--quiet", "--error-exitcode=99", "--leak-check=full", "--show-leak-kinds=definite",
            "--errors-for-leak-kinds=definite", *[f"--suppressions={SUPPRESSED[tool]}"] * is_unit]


def main():
    if len(sys.argv) != 2 or sys.argv[1] not in SUPPRESSED:
        sys.exit(__doc__)
    tool = sys.argv[1]
    build = ROOT / "build" / tool
    runs = {source.stem: ([build / source.stem], 0) for source in sorted(ROOT.glob("tests/unit/test_*.f90"))}
    runs |= {name: ([build / "hampm", *words], CODES.get(name, 0)) for name, words in CASES.items()}
    bad = 0
    with tempfile.TemporaryDirectory() as folder:
        for name, (command, code) in runs.items():
            results = ["--output", f"{folder}/{name}"] if name in CASES and "--output" not in command else []
            start = time.time()
            is_unit = name not in CASES
            run = subprocess.run([*wrapper(tool, is_unit), *command, *results], cwd=ROOT, env=environment(tool, is_unit),
                                 capture_output=True, text=True, errors="replace")
            fine = run.returncode == code and not any(sign in run.stderr for sign in ("runtime error", "Sanitizer", "== "))
            print(f"{name}: {'fine' if fine else 'WRONG'}, {time.time() - start:.1f} s", flush=True)
            if not fine:
                bad += 1
                print(f"exit code {run.returncode}\n{run.stdout[-2000:]}{run.stderr[:6000]}")
    print(f"{len(runs) - bad} of {len(runs)} runs without any report")
    sys.exit(bad > 0)


if __name__ == "__main__":
    main()
