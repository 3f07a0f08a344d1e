"""tools/setup.sh on machines it does not run on: every command it finds is a stub that notes how it was called."""

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from packaging.utils import canonicalize_name, canonicalize_version

SETUP = Path(__file__).resolve().parents[2] / "tools" / "setup.sh"
ORDINARY = ["cat", "chmod", "cksum", "cp", "dirname", "env", "mkdir", "mktemp", "rm", "sed", "sh", "tr"]
LIBRARIES = ["liblapack-dev", "libopenblas-dev", "libsuitesparse-dev", "libarpack2-dev", "libhdf5-dev"]
PARTS = ["run", "batch", "docs", "test", "verify"]
PYTHON = """case $1 in
    -c) exit 0 ;;
    -m) [ "$2" != venv ] || { for folder; do :; done; mkdir -p "$folder/bin"; cp "$0" "$folder/bin/python"; } ;;
esac"""


class Machine:
    """A project folder and a PATH that holds stubs and the ordinary commands only."""

    def __init__(self, folder):
        self.folder, self.bin = folder, folder / "bin"
        self.log = folder / "calls"
        (folder / "project" / "tools").mkdir(parents=True)
        self.bin.mkdir()
        shutil.copy(SETUP, folder / "project" / "tools")
        (folder / "project" / "requirements").mkdir()
        for part in PARTS:
            self.require(part, "")
        self.pin("")
        for name in ORDINARY:
            (self.bin / name).symlink_to(shutil.which(name))
        for name in ["gfortran", "make", "gnuplot"]:
            self.stub(name)
        self.stub("python3", PYTHON)
        self.stub("id", "echo 1000")

    def require(self, part, text):
        (self.folder / "project" / "requirements" / f"{part}.txt").write_text(text)

    def pin(self, text):
        (self.folder / "project" / "requirements.lock").write_text(text)

    def stub(self, name, body="", code=0):
        path = self.bin / name
        path.write_text(f'#!/bin/sh\necho "${{0##*/}} $*" >>"{self.log}"\n{body}\nexit {code}\n')
        path.chmod(0o755)

    def debian(self, *installed):
        self.stub("dpkg-query", f"printf '%s' '{''.join(f'{name}:installed ' for name in installed)}'")
        self.stub("apt-get", 'echo "frontend $DEBIAN_FRONTEND" >>"$0.env"')

    def remove(self, name):
        (self.bin / name).unlink()

    def run(self, *arguments):
        return subprocess.run([self.folder / "project/tools/setup.sh", *arguments], env={"PATH": str(self.bin)},
                              stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=20)

    def installs(self):
        """Arguments of every installation of Python packages so far."""
        return [call for call in self.calls("python") if call.startswith("-m pip install")]

    def calls(self, name):
        """Arguments of every call of a command so far."""
        lines = self.log.read_text().splitlines() if self.log.exists() else []
        return [line.partition(" ")[2] for line in lines if line.split()[0] == name]


@pytest.fixture
def machine(tmp_path):
    return Machine(tmp_path)


def test_what_is_present_is_not_installed_again(machine):
    machine.debian(*LIBRARIES)
    first = machine.run()
    assert first.returncode == 0, first.stderr
    assert len(machine.installs()) == 1 and "-r" in machine.installs()[0]
    second = machine.run()
    assert (second.returncode, second.stdout, second.stderr) == (0, "", "")
    assert len(machine.installs()) == 1 and machine.calls("apt-get") == []


def test_new_requirements_are_installed(machine):
    """Into the environment that is there, in which pip changes what differs."""
    machine.debian(*LIBRARIES)
    machine.run()
    machine.require("test", "pytest==8.4.2\n")
    assert machine.run().returncode == 0 and len(machine.installs()) == 2 and machine.installs()[-1].count(" -r ") == 1
    machine.pin("tqdm==4.70.1\n")
    assert machine.run().returncode == 0 and len(machine.installs()) == 3 and machine.installs()[-1].count(" -r ") == len(PARTS)
    assert machine.installs()[-1].endswith("requirements.lock")
    assert sum(call.startswith("-m venv") for call in machine.calls("python3")) == 1


@pytest.mark.parametrize("lost", ["removed", "another"])
def test_an_environment_whose_python_is_gone_is_made_anew(machine, lost):
    """Removed, or become another one, which does not know the packages."""
    machine.debian(*LIBRARIES)
    machine.run("run")
    python = machine.folder / "project/.venv/bin/python"
    if lost == "removed":
        python.unlink()
    else:
        python.write_text("#!/bin/sh\nexit 1\n")
    assert machine.run("run").returncode == 0 and sum(call.startswith("-m venv --clear") for call in machine.calls("python3")) == 2
    assert len(machine.installs()) == 2 and machine.run("run").stdout == ""


def test_each_part_is_installed_when_it_is_needed_into_one_environment(machine):
    machine.debian(*LIBRARIES)
    for words, installed in (("run", ["run"]), ("run batch", ["batch"]), ("run", []), ("test", ["test"]), ("valgrind", []), ("docs", ["docs"]),
                             ("verify", ["verify"]), ("", [])):
        before = len(machine.installs())
        machine.stub("valgrind")
        assert machine.run(*words.split()).returncode == 0
        files = [Path(word).stem for call in machine.installs()[before:] for word in call.split() if word.endswith(".txt")]
        assert files == installed
    assert sum(call.startswith("-m venv") for call in machine.calls("python3")) == 1


def test_what_is_installed_is_said_before_it_is(machine):
    """With its size and time, which are the sums of those of its rows in the table of the script."""
    machine.debian(*LIBRARIES[2:])
    machine.stub("id", "echo 0")
    rows = {name: (int(size), int(time)) for name, size, time in re.findall(r"^([\w-]+) (\d+) (\d+)$", SETUP.read_text(), re.MULTILINE)}
    assert {*LIBRARIES, *PARTS, "gfortran", "make", "gnuplot-nox", "python3", "python3-venv", "valgrind"} <= rows.keys() and all(size > 0 for size, _ in rows.values())
    machine.stub("apt-get", 'echo "apt-get $*"')
    said = machine.run("run", "docs").stdout.splitlines()
    by_apt = [sum(rows[name][k] for name in LIBRARIES[:2]) for k in (0, 1)]
    by_pip = [rows["run"][k] + rows["docs"][k] for k in (0, 1)]
    assert said[0] == f"installing liblapack-dev, libopenblas-dev by apt-get: about {by_apt[0]} MB, {by_apt[1]} s"
    assert said[1].startswith("apt-get ") and said[-1] == f"installing the Python packages to run, docs into .venv: about {by_pip[0]} MB, {by_pip[1]} s"
    minutes = round(sum(rows[part][1] for part in PARTS[1:2] + PARTS[3:]) / 60)
    assert f"MB, {minutes} minutes" in machine.run().stdout


def test_a_failed_installation_shows_all_that_pip_says(machine):
    """As it is no part of a good one."""
    machine.debian(*LIBRARIES)
    says = 'case $* in "-m pip"*) echo "Collecting soupsieve"; echo "DEPRECATION: old" >&2; exit %d ;; esac'
    machine.stub("python3", says % 1 + "\n" + PYTHON)
    failed = machine.run("docs")
    assert failed.returncode == 1 and "Collecting soupsieve\nDEPRECATION: old\n" in failed.stderr
    assert failed.stderr.endswith("setup.sh: the Python packages to docs have not been installed\n")
    machine.stub("python3", says % 0 + "\n" + PYTHON)
    (machine.folder / "project/.venv/bin/python").unlink()
    good = machine.run("docs")
    assert (good.returncode, good.stderr) == (0, "") and len(good.stdout.splitlines()) == 1


def test_the_program_alone_needs_a_python_without_packages_and_no_gnuplot(machine):
    machine.debian(*LIBRARIES)
    machine.stub("id", "echo 0")
    machine.remove("gnuplot")
    assert machine.run("program").returncode == 0 and machine.calls("apt-get") == []
    assert machine.calls("python") == [] and machine.run("run").returncode == 0 and "gnuplot-nox" in machine.calls("apt-get")[-1]


def test_parts_are_what_their_targets_ask_for():
    """What is run needs numpy, h5py and matplotlib, and no more; the tests do without VTK; all is the sum of the parts."""
    requirements = SETUP.parents[1] / "requirements"
    names = {part: [line.partition("==")[0] for line in (requirements / f"{part}.txt").read_text().splitlines() if line[0] != "#"] for part in PARTS}
    assert set(names["run"]) - {"f90nml"} == {"numpy", "h5py", "matplotlib"} and names["batch"][0] == "snakemake" and names["docs"] == ["mkdocs-material", "latex2mathml", "ford", "jupytext"]
    assert names["verify"] == ["vtk", "pyvista", "ngsolve"]
    assert (SETUP.parents[1] / "requirements.txt").read_text().split() == [word for part in PARTS for word in ("-r", f"requirements/{part}.txt")]


def test_every_package_is_pinned():
    """By its version in the environment that runs this, where that is of the Python for which the lock file is; the package itself
    is listed where `pip install ./python` has left its notes."""
    if sys.version_info < (3, 11):
        pytest.skip("the lock file is for Python 3.11 or later")
    freeze = subprocess.run([sys.executable, "-m", "pip", "freeze"], check=True, capture_output=True, text=True).stdout.splitlines()
    pinned = {same(line.partition(" ;")[0]) for line in (SETUP.parents[1] / "requirements.lock").read_text().splitlines() if line[0] != "#"}
    assert [line for line in freeze if same(line) not in pinned and not line.startswith("hampm")] == []


def same(line):
    """name==version, however it is spelled."""
    name, _, version = line.partition("==")
    return canonicalize_name(name), canonicalize_version(version)


def test_root_installs_only_what_is_missing(machine):
    machine.debian("liblapack-dev", "libhdf5-dev")
    machine.stub("id", "echo 0")
    machine.remove("gnuplot")
    assert machine.run().returncode == 0
    assert machine.calls("apt-get") == [
        "-qq update", "-qq install -y --no-install-recommends libopenblas-dev libsuitesparse-dev libarpack2-dev gnuplot-nox"]
    assert (machine.bin / "apt-get.env").read_text() == "frontend noninteractive\n" * 2


def test_valgrind_is_installed_only_where_it_is_asked_for(machine):
    machine.debian(*LIBRARIES)
    machine.stub("id", "echo 0")
    assert machine.run().returncode == 0 and machine.calls("apt-get") == []
    assert machine.run("valgrind").returncode == 0
    assert machine.calls("apt-get")[-1] == "-qq install -y --no-install-recommends valgrind"
    machine.stub("valgrind")
    assert machine.run("valgrind").returncode == 0 and len(machine.calls("apt-get")) == 2


def test_another_build_of_openblas_is_accepted(machine):
    machine.debian("liblapack-dev", "libhdf5-dev", "libsuitesparse-dev", "libarpack2-dev", "libopenblas-openmp-dev")
    assert machine.run().returncode == 0 and machine.calls("apt-get") == []


def test_a_package_removed_but_configured_is_missing(machine):
    machine.debian(*LIBRARIES[:-1])
    machine.stub("dpkg-query", f"printf '%s' '{':installed '.join(LIBRARIES)}:config-files '")
    assert machine.run("--check").stdout.splitlines()[0] == "libhdf5-dev"


def test_sudo_without_a_password_is_used(machine):
    machine.debian(*LIBRARIES[1:])
    machine.stub("sudo", 'shift; "$@"')
    assert machine.run().returncode == 0
    assert machine.calls("apt-get")[-1] == "-qq install -y --no-install-recommends liblapack-dev"
    assert all(call.startswith("-n ") for call in machine.calls("sudo"))


@pytest.mark.parametrize("sudo", ["absent", "asks for a password"])
def test_without_rights_the_missing_packages_are_named(machine, sudo):
    machine.debian(*LIBRARIES[1:])
    if sudo != "absent":
        machine.stub("sudo", code=1)
    result = machine.run()
    assert result.returncode == 1
    assert "missing: liblapack-dev" in result.stderr and "apt-get install" in result.stderr
    assert machine.calls("apt-get") == [] and machine.calls("python") == []


def test_a_failed_installation_ends_the_script(machine):
    machine.debian()
    machine.stub("id", "echo 0")
    machine.stub("apt-get", code=100)
    assert machine.run().returncode != 0
    assert len(machine.calls("apt-get")) == 1 and machine.calls("python") == []


def test_failed_python_packages_are_tried_again(machine):
    machine.debian(*LIBRARIES)
    machine.stub("python3", PYTHON + '\ncase $0 in *.venv*) exit 1 ;; esac')
    assert machine.run().returncode != 0
    machine.stub("python3", PYTHON)
    shutil.copy(machine.bin / "python3", machine.folder / "project/.venv/bin/python")
    assert machine.run().returncode == 0 and len(machine.installs()) == 2


def test_other_systems_are_told_what_is_missing(machine):
    machine.stub("gfortran", 'case $* in *-lumfpack*) exit 1 ;; esac')
    machine.remove("make")
    result = machine.run()
    assert result.returncode == 1
    assert "missing: make libsuitesparse-dev \n" in result.stderr and "package manager of this system" in result.stderr


def test_other_systems_that_have_everything_get_the_python_packages(machine):
    result = machine.run()
    assert result.returncode == 0, result.stderr
    assert len(machine.installs()) == 1


def test_check_lists_and_changes_nothing(machine):
    machine.debian(*LIBRARIES[1:])
    result = machine.run("--check")
    assert result.returncode == 1
    assert result.stdout.splitlines() == ["liblapack-dev", ".venv with the packages of requirements.txt"]
    assert machine.calls("apt-get") == [] and not (machine.folder / "project" / ".venv").exists()


def test_check_is_silent_when_all_is_there(machine):
    machine.debian(*LIBRARIES)
    machine.run()
    result = machine.run("--check")
    assert (result.returncode, result.stdout) == (0, "")


def test_usage(machine):
    assert "--check" in machine.run("--help").stdout
    result = machine.run("--chekc")
    assert result.returncode == 2 and "--check" in result.stderr
