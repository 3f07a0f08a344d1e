"""The exercises of docs/lessons/exercises: their tests are red with the program as it comes, and green with the solution, after an edit, a compilation and a run of
seconds."""

import os
import re
import shutil
import subprocess
import sys

import pytest

from paths import CHECKED_PROGRAM, ROOT

EXERCISES = ROOT / "docs/lessons/exercises"
NAMES = ["scheme", "mass", "functions", "law", "estimator"]
LONGEST = 20  # seconds of processor time from an edit to a result


def patch_of(name):
    return EXERCISES / f"solutions/{name}.patch"


def outcome(program, *names):
    """What the tests of exercises say of a program, by outcome, and all that they print as at a terminal: pytest prints assertions otherwise where `CI` is set."""
    without = {name: value for name, value in os.environ.items() if name not in ("CI", "BUILD_NUMBER")}
    done = subprocess.run([sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", *(f"tests/lab/exercises.py::test_{name}" for name in names)], cwd=ROOT,
                          env=without | {"HAMPM": str(program)}, capture_output=True, text=True)
    return {word: int(number) for number, word in re.findall(r"(\d+) (passed|failed|error)", done.stdout.splitlines()[-1])}, done.stdout


@pytest.fixture(scope="module")
def tree(tmp_path_factory):
    """A copy of the sources with their objects, as `make lab` leaves them."""
    tree = tmp_path_factory.mktemp("lab")
    for name in "Makefile", "VERSION":
        shutil.copy2(ROOT / name, tree)
    for folder in "src", "tools":
        shutil.copytree(ROOT / folder, tree / folder)
    built = tree / "build/checked"
    built.mkdir(parents=True)
    of_sources = {path.stem for path in (ROOT / "src").rglob("*.f90")}
    for path in CHECKED_PROGRAM.parent.iterdir():
        if path.suffix == ".mod" or path.suffix == ".o" and path.stem in of_sources or path.name in ("flags", "depends.mk", "version.inc"):
            shutil.copy2(path, built)
    return tree


def seconds_of_children():
    times = os.times()
    return times.children_user + times.children_system


def test_the_page_has_the_exercises():
    page = (EXERCISES / "README.md").read_text()
    assert re.findall(r"make lab exercise=(\w+)", page.partition("\n## ")[2]) == NAMES
    assert sorted(path.stem for path in (EXERCISES / "solutions").glob("*.patch")) == sorted(NAMES)
    assert all(f"solutions/{name}.patch" in page for name in NAMES)
    answers = (EXERCISES / "solutions/answers.md").read_text()
    titles = [title.partition(":")[0] for title in re.findall(r"^## (.*)$", page, flags=re.MULTILINE)]
    assert titles == re.findall(r"^## (.*)$", answers, flags=re.MULTILINE)


def test_commands_of_the_page_run(tmp_path):
    """But for those of make, in a folder that looks like the repository."""
    (tmp_path / "build").mkdir()
    for item in "docs", "postprocess", ".venv", "build/checked":
        (tmp_path / item).symlink_to(ROOT / item)
    for block in re.findall(r"^```sh\n(.*?)^```$", (EXERCISES / "README.md").read_text(), flags=re.DOTALL | re.MULTILINE):
        done = subprocess.run(["bash", "-e", "-c", block], cwd=tmp_path, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
    assert (tmp_path / "results/lab/mine.png").read_bytes().startswith(b"\x89PNG")


def test_the_program_as_it_comes_passes_none():
    counted, printed = outcome(CHECKED_PROGRAM, *NAMES)
    assert set(counted) == {"failed"} and counted["failed"] >= len(NAMES), printed
    assert len(re.findall(r"^E +AssertionError", printed, flags=re.MULTILINE)) == counted["failed"], printed


@pytest.mark.parametrize("name", NAMES)
def test_a_solution_fits_the_sources(name):
    done = subprocess.run(["git", "apply", "--check", patch_of(name)], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


@pytest.mark.xdist_group("lab")
@pytest.mark.parametrize("name", NAMES)
def test_a_solution_turns_its_test_green(tree, name):
    program = tree / "build/checked/hampm"
    subprocess.run(["git", "apply", patch_of(name)], cwd=tree, check=True)
    before = seconds_of_children()
    try:
        built = subprocess.run(["make", "--no-print-directory", "build/checked/hampm", "build=checked"], cwd=tree, capture_output=True, text=True)
        assert built.returncode == 0 and not built.stderr, built.stderr
        counted, printed = outcome(program, name)
    finally:
        subprocess.run(["git", "apply", "--reverse", patch_of(name)], cwd=tree, check=True)
    assert set(counted) == {"passed"}, printed
    taken = seconds_of_children() - before
    print(f"\n{name}: {taken:.1f} s from the edit to the result", end=" ")
    assert taken < LONGEST
