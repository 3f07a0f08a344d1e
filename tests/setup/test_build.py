"""The build says little and does no more than it has to, and its programs say so where the processor is not one they are for."""

import os
import re
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest

from paths import CHECKED_PROGRAM, PROGRAM, ROOT, SOLID_PROGRAM

PROCESSOR = ROOT / "src/processor.c"
SOURCES = {
    "src/processor.c": "int processor;\n",
    "src/base/deep.f90": "module hampm_deep\nimplicit none\ncontains\n"
                         "integer function number()\nnumber = 1\nend function number\nend module hampm_deep\n",
    "src/base/middle.f90": "module hampm_middle\nuse hampm_deep, only: number\nimplicit none\nend module hampm_middle\n",
    "src/main.f90": "program main\nuse hampm_middle, only: number\nimplicit none\nprint *, number()\nend program main\n"}


@pytest.fixture
def tree(tmp_path):
    """A project of three sources with the Makefile, and `make` in it: the lines that it prints."""
    for name, text in SOURCES.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    (tmp_path / "tools").mkdir()
    shutil.copy(ROOT / "Makefile", tmp_path)
    for name in ("depends.awk", "version.sh"):
        shutil.copy(ROOT / "tools" / name, tmp_path / "tools")
    (tmp_path / "VERSION").write_text("1.2.3\n$Format:%h$\n")

    def make(*words):
        run = subprocess.run(["make", "HDF5_LINK=", "ALGEBRA_LINK=", "build=quick", *words], cwd=tmp_path, capture_output=True, text=True,
                             env={key: value for key, value in os.environ.items() if not key.startswith("MAKE")}, check=True)
        assert run.stderr == ""
        return run.stdout.splitlines()
    make.folder = tmp_path
    return make


def edit(tree, name, before, after):
    """Change a source, later than what was made of it."""
    time.sleep(0.05)
    path = tree.folder / name
    path.write_text(path.read_text().replace(before, after))


def names(lines):
    """Lines without the number of the file among those of src/."""
    return [re.sub(r"^\[\d+/\d+\] ", "", line) for line in lines]


def test_compilers_have_said_nothing_of_what_is_tested():
    """Each command that compiles or links keeps what it says in a file beside what it makes."""
    logs = [log for program in (PROGRAM, CHECKED_PROGRAM, SOLID_PROGRAM) for log in program.parent.glob("*.log")]
    assert {log.name for log in logs} >= {"step.o.log", "main.o.log", "kernels.o.log", "hampm.log", "hampm3d.log", "processor.o.log"}
    assert {str(log): log.read_text() for log in logs if log.stat().st_size} == {}


def test_what_a_compiler_says_is_shown_and_kept(tree):
    edit(tree, "src/base/deep.f90", "integer function number()\n", "integer function number()\ninteger :: unused\n")
    command = ["make", "HDF5_LINK=", "ALGEBRA_LINK=", "build=quick", "program"]
    run = subprocess.run(command, cwd=tree.folder, capture_output=True, text=True)
    assert run.returncode == 0 and "Unused variable" in run.stderr
    assert "Unused variable" in (tree.folder / "build/quick/deep.o.log").read_text()
    edit(tree, "src/base/deep.f90", "number = 1", "number = one")
    run = subprocess.run(command, cwd=tree.folder, capture_output=True, text=True)
    assert run.returncode == 2 and "no IMPLICIT type" in run.stderr


def test_a_line_a_file_and_nothing_where_nothing_has_changed(tree):
    built = ["[1/4] gfortran src/base/deep.f90", "[2/4] gfortran src/base/middle.f90", "[3/4] gfortran src/processor.c", "[4/4] gfortran src/main.f90",
             "build/quick/hampm"]
    assert tree("program") == built
    assert [line for line in tree("program") if "Nothing to be done" not in line] == []
    edit(tree, "src/main.f90", "print *", "print '(i0)'")
    commands = [line for line in tree("program", "V=1") if "gfortran -std=f2008" in line]
    assert [re.search(r" -o (\S+)", line)[1] for line in commands] == ["build/quick/main.o", "build/quick/hampm"]


def test_what_uses_a_module_is_compiled_where_its_interface_has_changed(tree):
    tree("program")
    module = tree.folder / "build/quick/hampm_deep.mod"
    before = module.stat().st_mtime_ns
    edit(tree, "src/base/deep.f90", "number = 1", "number = 2")
    compiled = names(tree("program"))
    if module.stat().st_mtime_ns != before:
        pytest.skip("this compiler writes the same module anew")
    assert compiled == ["gfortran src/base/deep.f90", "build/quick/hampm"]
    assert subprocess.run([tree.folder / "build/quick/hampm"], capture_output=True, text=True, check=True).stdout.split() == ["2"]
    edit(tree, "src/base/deep.f90", "end module", "integer function other()\nother = 3\nend function other\nend module")
    assert names(tree("program")) == ["gfortran src/base/deep.f90", "gfortran src/base/middle.f90", "build/quick/hampm"]


def test_a_version_is_its_number_and_the_commit_where_it_is_known(tree):
    """Of a checkout, also one that is changed, or of an archive; and where it changes, only the main program is compiled."""
    edit(tree, "src/main.f90", "print *, number()", "include 'version.inc'\nprint '(a)', built_version")
    edit(tree, "src/main.f90", "implicit none\ninclude", "include")

    def version():
        tree("program")
        return subprocess.run([tree.folder / "build/quick/hampm"], capture_output=True, text=True, check=True).stdout.rstrip("\n")

    def git(*words):
        subprocess.run(["git", "-c", "user.name=a", "-c", "user.email=a@b", "-c", "commit.gpgsign=false", *words], cwd=tree.folder, check=True,
                       capture_output=True)
    assert version() == "1.2.3"
    (tree.folder / "VERSION").write_text("1.2.4\nabc1234\n")
    assert version() == "1.2.4 (abc1234)"
    git("init")
    git("add", "src", "VERSION")
    git("commit", "-m", "sources")
    commit = subprocess.run(["git", "rev-parse", "HEAD"], cwd=tree.folder, check=True, capture_output=True, text=True).stdout[:12]
    assert names(tree("program")) == ["gfortran src/main.f90", "build/quick/hampm"]
    assert version() == f"1.2.4 ({commit})" and [line for line in tree("program") if "Nothing" not in line] == []
    edit(tree, "src/base/deep.f90", "number = 1", "number = 2")
    assert version() == f"1.2.4 ({commit}, modified)"


def test_only_what_is_asked_for_is_linked():
    commands = subprocess.run(["make", "-n", "-C", ROOT, "program", "build=none"], capture_output=True, text=True, check=True).stdout
    assert [line for line in commands.splitlines() if line.startswith('echo "build/none/')] == ['echo "build/none/hampm"']


@pytest.fixture
def built_for(tmp_path):
    """An empty program for a kind of processor, where these are of the kind x86-64."""
    def build(*options):
        (tmp_path / "empty.f90").write_text("print '(a)', 'runs'\nend\n")
        subprocess.run(["gfortran", "-O1", "-Wall", "-Wextra", "-Werror", *options, "-o", "empty", "empty.f90", PROCESSOR], cwd=tmp_path,
                       check=True)
        return tmp_path / "empty"
    if os.uname().machine != "x86_64":
        pytest.skip("the check is for x86-64")
    return build


@pytest.mark.parametrize("options", [["-march=x86-64"], ["-march=native"]])
def test_a_program_for_this_processor_runs(built_for, options):
    assert subprocess.run([built_for(*options)], capture_output=True, text=True, check=True).stdout == "runs\n"


def is_refused(run, feature):
    """Whether a program has ended before it began, with the reason."""
    return run.returncode == 6 and run.stdout == "" and f"this processor has no {feature} instructions" in run.stderr and \
        "ARCH=" in run.stderr


def test_a_processor_that_lacks_instructions_is_told_of(built_for):
    program = built_for("-march=x86-64-v3", "-D__builtin_cpu_supports(feature)=0")
    assert is_refused(subprocess.run([program], capture_output=True, text=True), "popcnt")


@pytest.mark.skipif(not shutil.which("qemu-x86_64"), reason="qemu-user is not installed")
@pytest.mark.parametrize(("arch", "processor", "feature"), [("x86-64-v3", "Nehalem", "avx"), ("x86-64-v4", "Haswell", "avx512f"),
                                                            ("x86-64-v3", "Haswell", None), ("x86-64", "Nehalem", None)])
def test_an_older_processor(built_for, arch, processor, feature):
    run = subprocess.run(["qemu-x86_64", "-cpu", processor, built_for(f"-march={arch}")], capture_output=True, text=True)
    assert is_refused(run, feature) if feature else run.stdout == "runs\n"


@pytest.mark.skipif(sys.platform != "linux", reason="ldd is of Linux")
def test_the_release_brings_its_libraries_where_their_archives_are_there(tmp_path):
    """And where they want no others: HDF5 of Debian 13 wants an archive of curl."""
    archives = ["hdf5", "sz", "aec", "umfpack", "cholmod", "arpack", "openblas"]
    folder = subprocess.run(["gcc", "-dumpmachine"], capture_output=True, text=True, check=True).stdout.strip()
    found = [any((Path("/usr/lib") / folder / sub / f"lib{name}.a").exists() for sub in ("", "hdf5/serial")) for name in archives]
    program = ROOT / "build/release/hampm"
    if not (all(found) and program.exists()):
        pytest.skip("not all archives are there, or no release")
    words = subprocess.run(["make", "-s", "build=release", "--eval=archives: ; @echo $(ARCHIVES)", "archives"], cwd=ROOT, capture_output=True, text=True, check=True).stdout.split()
    (tmp_path / "open.c").write_text("int H5open(void);\nint main(void) { return H5open(); }\n")
    if subprocess.run(["gcc", "open.c", "-o", "open", *words], cwd=tmp_path, capture_output=True).returncode:
        pytest.skip("an archive wants libraries beside those of the program")
    loaded = subprocess.run(["ldd", program], capture_output=True, text=True, check=True).stdout
    assert not any(f"lib{name}" in loaded for name in [*archives, "curl"]), loaded


def test_without_an_archive_the_release_loads_the_library(tree):
    shutil.copytree(ROOT / "src", tree.folder / "src", ignore=shutil.ignore_patterns("*.f90"), dirs_exist_ok=True)
    lines = tree("program", "build=release", "release_kernels=", "ARCHIVES=-lnowhere")
    assert lines[-1] == "build/release/hampm"
    assert subprocess.run([tree.folder / "build/release/hampm"], capture_output=True, text=True, check=True).stdout.split() == ["1"]


@pytest.mark.skipif(not (ROOT / ".git").exists(), reason="no checkout")
def test_an_archive_of_the_sources_knows_its_commit(tmp_path):
    subprocess.run(["git", "clone", "-q", "--shared", ROOT, tmp_path / "source"], check=True)
    subprocess.run(["make", "-s", "dist"], cwd=tmp_path / "source", check=True)
    number = (ROOT / "VERSION").read_text().splitlines()[0]
    subprocess.run(["tar", "-xf", f"source/build/hampm-{number}.tar.gz"], cwd=tmp_path, check=True)
    there = tmp_path / f"hampm-{number}"
    commit = subprocess.run(["git", "rev-parse", "HEAD"], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    assert (there / "src/main.f90").exists() and commit.startswith((there / "VERSION").read_text().splitlines()[1][:7])
