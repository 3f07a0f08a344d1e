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
ALL_ESTIMATORS = ["--set", "energy_release.estimators=vcct,stress_closure", "--set", "energy_release.energy_balance=.true."]
STATIC = ["--set", "method.time=static", "--set", "method.frame=total"]
CASES = {
    "template": ["--template"],
    "mistakes": ["input/dcb.nml", "--check", "--set", "material.yuong=1", "--set", "grid.cell=-1", "--set", "run=", "--nothing"],
    "mistakes of a law": ["input/creep_bar.nml", "--check", "--set", "material.moduli=5e9,6e9"],
    "check": ["input/dcb.nml", "--check"],
    "plain": [*DCB, *ALL_ESTIMATORS],
    "two threads": [*DCB, "--threads", "2"],
    "total frame": [*DCB, "--set", "method.frame=total", "--set", "method.scheme=usavg"],
    "consistent mass, cg": [*DCB, "--set", "method.mass=consistent", "--set", "method.solver=cg"],
    "consistent mass, direct, total": [*DCB, "--set", "method.mass=consistent", "--set", "method.solver=direct", "--set", "method.frame=total"],
    "consistent mass, direct": [*DCB, "--set", "method.mass=consistent", "--set", "method.solver=direct"],
    "fmpm": [*DCB, "--set", "method.mass=fmpm"],
    "gradient": [*DCB, "--set", "refine.indicator=gradient", "--set", "refine.max_level=2", "--set", "refine.interval=5"],
    "error": [*DCB, "--set", "refine.indicator=zz", "--set", "refine.max_level=2", "--set", "refine.interval=5"],
    "neo-Hookean law": [*DCB, "--set", "material.law=neo_hookean", "--set", "method.frame=updated"],
    "line crack, contact": ["input/mixed_mode.nml", "--quiet", "--set", "grid.cell=2.5e-3", "--set", "grid.cells=21,12",
                            "--set", "run.end_time=2e-5", "--set", "output.history_interval=1e-6", "--set",
                            "crack.contact=frictionless", "--set", "refine.max_level=1", "--set", "energy_release.radii=3e-3"],
    "equilibrium, zz": [*DCB, *STATIC, "--set", "refine.indicator=zz", "--set", "refine.max_level=3"],
    "equilibrium, cg": [*DCB, *STATIC, "--set", "method.solver=cg", "--set", "material.law=neo_hookean"],
    "equilibrium, contact": ["input/mixed_mode.nml", "--quiet", *STATIC, "--set", "method.load_steps=3", "--set", "grid.cell=2.5e-3",
                             "--set", "grid.cells=21,12", "--set", "crack.contact=frictionless", "--set", "refine.max_level=1",
                             "--set", "energy_release.radii=3e-3", "--set", "output.snapshot_interval=0"],
    "no equilibrium": [*DCB, *STATIC, "--set", "load.force=1,1"],
    "moved": [*DCB, "--set", "method.frame=total", "--set", "constraint.velocity=0,1", "--set", "constraint.name=grip", "--set",
              "energy_release.estimators=vcct", "--set", "crack.kind=symmetry"],
    "growth at rest": ["input/two_cracks.nml", "--quiet", "--set", "grid.cell=2e-3", "--set", "grid.cells=20,22", "--set",
                       "method.load_steps=2", "--set", "run.end_time=2", "--set", "growth(1).increment=2.4e-3", "--set",
                       "growth(2).increment=2.4e-3", "--set", "growth(2).direction=local_symmetry"],
    "growth in motion": ["input/dcb_growth_dynamic.nml", "--quiet", "--set", "grid.cell=2e-3", "--set", "grid.cells=64,12", "--set",
                         "grid.lower=-4e-3,-12e-3", "--set", "run.end_time=1e-4", "--set", "growth.toughness=1e-6"],
    "cohesion": ["input/dcb_cohesive.nml", "--quiet", "--set", "grid.cell=1e-3", "--set", "grid.cells=66,8",
                 "--set", "method.load_steps=8"],
    "J2 law, mean dilatation": ["input/plastic_notch.nml", "--quiet", "--set", "grid.cell=2e-3", "--set", "grid.cells=9,17",
                                "--set", "method.load_steps=4"],
    "viscoelastic law": ["input/creep_bar.nml", "--quiet", "--set", "method.load_steps=8"],
    "implicit steps": [*DCB, "--set", "method.time=implicit", "--set", "method.frame=total"],
    "orthotropic law": ["input/laminate_dcb.nml", "--quiet", "--set", "grid.cell=1e-3", "--set", "grid.cells=70,3",
                        "--set", "refine.max_level=1"],
    "quadratic cells, rings": ["input/penny.nml", "--quiet", "--set", "refine.max_level=1"],
    "hole": ["input/plate_with_hole.nml", "--quiet", "--set", "refine.max_level=1"],
    "pressure on a crack": ["input/pressurised_crack.nml", "--quiet", "--set", "grid.cell=8e-3", "--set", "grid.cells=26,26"],
    "bodies in contact": ["tests/cases/contact_unit_of_length.nml", "--quiet", "--set", "contact.bodies=friction",
                          "--set", "contact.friction=0.3"],
    "cpdi": ["tests/cases/cpdi_resume.nml", "--quiet"],
    "stopped": [*DCB, "--steps", "20", "--set", "output.checkpoint_steps=7", "--set", "method.mass=consistent",
                "--set", "refine.indicator=zz", "--set", "refine.max_level=2", "--set", "refine.interval=5"],
    "resumed": ["--resume", "{folder}/stopped/dcb.h5.checkpoint", "--quiet", "--steps", "20"],
    "no file": ["nothing.nml"],
    "no folder": [*DCB, "--output", "/dev/null/x"],
}
LIMIT = 1800  # s of a run, the longest of which takes a sixth of that on a busy machine
CODES = {"mistakes": 2, "mistakes of a law": 2, "stopped": 5, "resumed": 5, "no equilibrium": 3, "no file": 4, "no folder": 4}


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


def run(command, code, tool, is_unit):
    """Run a program; what is wrong with how it went, '' where nothing is."""
    try:
        end = subprocess.run([*wrapper(tool, is_unit), *command], cwd=ROOT, env=environment(tool, is_unit), capture_output=True,
                             text=True, errors="replace", timeout=LIMIT)
    except subprocess.TimeoutExpired:
        return f"it took more than {LIMIT} s"
    if end.returncode == code and not any(sign in end.stderr for sign in ("runtime error", "Sanitizer", "== ")):
        return ""
    return f"exit code {end.returncode}\n{end.stdout[-2000:]}{end.stderr[:6000]}"


def main():
    if len(sys.argv) != 2 or sys.argv[1] not in SUPPRESSED:
        sys.exit(__doc__)
    tool = sys.argv[1]
    build = ROOT / "build" / tool
    runs = {source.stem: ([build / source.stem], 0) for source in sorted(ROOT.glob("tests/unit/test_*.f90"))}
    runs |= {name: ([build / "hampm", *words], CODES.get(name, 0)) for name, words in CASES.items()}
    bad, start = 0, time.time()
    with tempfile.TemporaryDirectory() as folder:
        for name, (command, code) in runs.items():
            begin, is_unit = time.time(), name not in CASES
            command = [str(word).replace("{folder}", folder) for word in command]
            if not is_unit and not {"--output", "--resume"} & set(command):
                command += ["--output", f"{folder}/{name}"]
            wrong = run(command, code, tool, is_unit)
            bad += wrong != ""
            print(f"{name}: {'WRONG' if wrong else 'fine'}, {time.time() - begin:.1f} s\n{wrong}".strip(), flush=True)
    print(f"{len(runs) - bad} of {len(runs)} runs without any report, {(time.time() - start) / 60:.1f} minutes")
    sys.exit(bad > 0)


if __name__ == "__main__":
    main()
