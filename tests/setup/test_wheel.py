"""A wheel of the Python package has both programs, which start from any folder; where they cannot be built one line says why."""

import os
import re
import shutil
import subprocess
import sys
import tarfile
import zipfile
from pathlib import Path

import pytest

import hampm
import hampm.program as finding
from paths import ROOT

VERSION = (ROOT / "VERSION").read_text().splitlines()[0]
ORDINARY = "awk", "cat", "chmod", "cp", "cut", "dirname", "env", "git", "grep", "ls", "mkdir", "mktemp", "rm", "sed", "sh", "tail", "tr"
STUB_MAKE = """#!/bin/sh
echo "$*|$MAKEFLAGS" >>"{log}"
while [ "$1" != -C ]; do shift; done
cd "$2"
case "$*" in *dim=3*) program=build/release3d/hampm3d ;; *) program=build/release/hampm ;; esac
mkdir -p "${{program%/*}}"
printf '#!/bin/sh\\necho "$0 with $*"\\n' >"$program"
chmod 755 "$program"
"""


class Checkout:
    """What the wheel is built of, and a PATH that holds ordinary commands and stubs only."""

    def __init__(self, folder):
        self.root, self.bin, self.log, self.built = folder / "check out", folder / "bin", folder / "made", folder / "built"
        shutil.copytree(ROOT / "python", self.root / "python", ignore=shutil.ignore_patterns("__pycache__", "dist"))
        for name in ("Makefile", "VERSION", "src/main.f90", "src/processor.c", "src/base/kinds.f90", "tools/depends.awk", "tools/setup.sh", "tools/version.sh"):
            (self.root / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(ROOT / name, self.root / name)
        self.bin.mkdir()
        for name in filter(shutil.which, ORDINARY):
            (self.bin / name).symlink_to(shutil.which(name))
        self.stub("make", STUB_MAKE.format(log=self.log))
        self.stub("gfortran")
        self.debian("liblapack-dev", "libopenblas-dev", "libsuitesparse-dev", "libarpack2-dev", "libhdf5-dev")

    def stub(self, name, text="#!/bin/sh\n"):
        (self.bin / name).write_text(text)
        (self.bin / name).chmod(0o755)

    def debian(self, *installed):
        self.stub("dpkg-query", f"#!/bin/sh\nprintf '%s' '{''.join(f'{name}:installed ' for name in installed)}'\n")

    def build(self, target="wheel", folder=None, code=0, **environment):
        """By the back end of python/pyproject.toml: the archive, or what is said where another exit code is due."""
        run = subprocess.run([sys.executable, "-m", "hatchling", "build", "-t", target, "-d", self.built], cwd=folder or self.root / "python",
                             capture_output=True, text=True, env={"PATH": str(self.bin), "HOME": str(self.root)} | environment)
        assert run.returncode == code, run.stdout + run.stderr
        return run.stdout + run.stderr if code else Path(run.stderr.strip().splitlines()[-1])

    def made(self):
        """How make was called."""
        return self.log.read_text().splitlines() if self.log.exists() else []


@pytest.fixture
def checkout(tmp_path):
    return Checkout(tmp_path)


def metadata(wheel, name):
    return zipfile.ZipFile(wheel).read(f"hampm-{VERSION}.dist-info/{name}").decode()


def test_a_wheel_has_both_programs_and_is_for_this_machine(checkout):
    wheel = checkout.build(MAKEFLAGS="-j --jobserver-auth=3,4")
    machine = os.uname().machine
    assert wheel.name == f"hampm-{VERSION}-py3-none-linux_{machine}.whl"
    assert "Root-Is-Purelib: false" in metadata(wheel, "WHEEL") and f"\nVersion: {VERSION}\n" in metadata(wheel, "METADATA")
    modes = {item.filename: item.external_attr >> 16 & 0o777 for item in zipfile.ZipFile(wheel).infolist()}
    for name in ("hampm", "hampm3d"):
        assert modes[f"hampm/bin/{name}"] == modes[f"hampm-{VERSION}.data/scripts/{name}"] == 0o755
    assert f"hampm-{VERSION}.dist-info/licenses/LICENSE" in modes and "hampm/py.typed" in modes
    calls = [call.split("|") for call in checkout.made()]
    assert [words.rpartition(" ")[2] for words, _ in calls] == ["dim=2", "dim=3"]
    for words, flags in calls:
        assert re.match(r"-j\d+ --no-print-directory -C \S.*check out program build=release dim=", words) and "jobserver" not in flags


def test_scripts_start_the_programs_of_the_package(checkout, tmp_path):
    """By any name, with all words; and they say what is wrong where the package is gone."""
    packages = tmp_path / "site packages"
    zipfile.ZipFile(checkout.build()).extractall(packages)
    (tmp_path / "other name").symlink_to(packages / f"hampm-{VERSION}.data/scripts/hampm3d")
    (packages / "hampm/bin/hampm3d").chmod(0o755)

    def start(*words):
        return subprocess.run([sys.executable, tmp_path / "other name", *(words or ("a b", "--check"))], capture_output=True, text=True, cwd=tmp_path,
                              env=os.environ | {"PYTHONPATH": str(packages)})
    assert start().stdout == f"{packages}/hampm/bin/hampm3d with a b --check\n"
    assert "\nhampm plot g " in start("plot", "--help").stdout and start("compare", "--help").stdout.startswith("usage: hampm compare")
    shutil.rmtree(packages / "hampm/bin")
    gone = start()
    assert gone.returncode == 1 and gone.stderr.startswith("hampm3d: the package hampm of this Python is without its programs")


def test_without_programs_a_wheel_is_for_any_machine(checkout):
    wheel = checkout.build(HAMPM_PURE="1")
    assert wheel.name == f"hampm-{VERSION}-py3-none-any.whl" and checkout.made() == []
    assert not any("/bin/" in name or ".data" in name for name in zipfile.ZipFile(wheel).namelist())
    assert checkout.build(HAMPM_PURE="0").name.endswith(f"linux_{os.uname().machine}.whl")


def test_what_is_missing_is_said_in_one_line(checkout):
    """Before anything is compiled; but where programs are built already, or libraries are named by hand, they need not be there."""
    (checkout.bin / "gfortran").unlink()
    checkout.debian("liblapack-dev", "libopenblas-dev", "libarpack2-dev", "libhdf5-dev")
    said = checkout.build(code=1)
    assert said.strip().splitlines()[-1] == ("hampm: missing to build the programs: gfortran libsuitesparse-dev (names of packages in Debian); "
                                             "HAMPM_PURE=1 leaves the programs out")
    assert "Traceback" not in said and checkout.made() == []
    assert "missing to build the programs: gfortran (" in checkout.build(code=1, HDF5_LINK="-lhdf5", ALGEBRA_LINK="-lcholmod")
    for path in ("build/release/hampm", "build/release3d/hampm3d"):
        (checkout.root / path).parent.mkdir(parents=True)
        (checkout.root / path).write_text("")
    checkout.build()
    assert len(checkout.made()) == 2


def test_a_build_that_fails_and_sources_that_are_not_there(checkout):
    checkout.stub("make", "#!/bin/sh\necho Error: a line of the compiler\nexit 2\n")
    said = checkout.build(code=1)
    assert "Traceback" not in said and re.search(r"^hampm: make -j.* build=release dim=2 has failed; HAMPM_PURE=1 leaves", said, re.MULTILINE)
    shutil.rmtree(checkout.root / "src")
    said = checkout.build(code=1)
    assert "Traceback" not in said and re.search(r"^hampm: the sources of the programs are neither in program nor in the folder above .*/python; HAMPM_PURE=1", said, re.MULTILINE)


def unpacked(archive, folder):
    with tarfile.open(archive) as file:
        file.extractall(folder, filter="data") if hasattr(tarfile, "data_filter") else file.extractall(folder)
    return folder / f"hampm-{VERSION}"


def test_an_archive_of_sources_has_all_that_builds_a_wheel(checkout, tmp_path):
    """Another archive too, and it knows the number and the commit that it is of."""
    def git(*words):
        subprocess.run(["git", "-c", "user.name=a", "-c", "user.email=b", *words], cwd=checkout.root, check=True, capture_output=True)
    git("init")
    git("add", "--all")
    git("commit", "-m", "c")
    commit = subprocess.run(["git", "rev-parse", "--short=12", "HEAD"], cwd=checkout.root, check=True, capture_output=True, text=True).stdout.strip()
    first = unpacked(checkout.build("sdist"), tmp_path)
    assert (first / "program/VERSION").read_text() == f"{VERSION}\n{commit}\n"
    shutil.rmtree(checkout.root)
    second = unpacked(checkout.build("sdist", first), tmp_path / "again")
    files = [{str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file() and path.suffix != ".pyc"} for folder in (first, second)]
    assert files[0] == files[1]
    assert subprocess.run([second / "program/tools/version.sh"], capture_output=True, text=True).stdout == f"{VERSION} ({commit})\n"
    names = set(zipfile.ZipFile(checkout.build("wheel", second)).namelist())
    assert {"hampm/bin/hampm", "hampm/bin/hampm3d", "hampm/scene.py"} <= names and str(second / "program") in checkout.made()[-1]


def test_the_archive_of_sources_has_every_file_that_make_reads(tmp_path):
    """Of these sources: their modules depend on one another as here."""
    subprocess.run([sys.executable, "-m", "hatchling", "build", "-t", "sdist", "-d", tmp_path], cwd=ROOT / "python", check=True, capture_output=True)
    archive, = tmp_path.glob("*.tar.gz")
    folder = unpacked(archive, tmp_path)
    assert archive.stat().st_size < 3e6 and not any(path.is_symlink() for path in folder.rglob("*"))
    sources = {str(path.relative_to(ROOT)) for path in (ROOT / "src").rglob("*") if path.suffix in (".f90", ".c")}
    assert sources == {str(path.relative_to(folder / "program")) for path in (folder / "program/src").rglob("*") if path.is_file()}
    environment = {name: value for name, value in os.environ.items() if not name.startswith("MAKE")}
    for words in (["build/release/depends.mk"], ["build/release3d/depends.mk", "dim=3"]):
        subprocess.run(["make", "-s", *words], cwd=folder / "program", env=environment, check=True)
        assert "main.o" in (folder / "program" / words[0]).read_text()


def test_the_licence_is_that_of_the_repository():
    assert (ROOT / "python/LICENSE").read_text() == (ROOT / "LICENSE").read_text()


@pytest.mark.parametrize("dimensions, name, variable", [(2, "hampm", "HAMPM"), (3, "hampm3d", "HAMPM3D")])
def test_where_a_program_is_found(tmp_path, monkeypatch, dimensions, name, variable):
    """By its name, the environment variable, in the package, in the checkout, below the prefix, in the environment of Python, in PATH: in this order."""
    root = tmp_path / "share/hampm"
    folders = {"variable": "x", "package": "packed", "checkout": f"share/hampm/build/release{'3d' * (dimensions == 3)}", "prefix": "bin", "environment": "venv/bin", "path": "path"}
    programs = {place: tmp_path / folder / name for place, folder in folders.items()}
    for path in programs.values():
        path.parent.mkdir(parents=True)
        path.write_text("#!/bin/sh\n")
        path.chmod(0o755)
    monkeypatch.setattr(finding, "ROOT", root)
    monkeypatch.setattr(finding, "BUILT", root / "build/release/hampm")
    monkeypatch.setattr(finding, "PACKED", tmp_path / "packed")
    monkeypatch.setattr(sys, "prefix", str(tmp_path / "venv"))
    monkeypatch.setenv("PATH", str(tmp_path / "path"))
    monkeypatch.setenv(variable, str(programs["variable"]))
    named = tmp_path / "named"
    named.write_text("")
    assert finding.find_program(named, dimensions) == named
    for place, path in programs.items():
        assert finding.find_program(dimensions=dimensions) == path, place
        monkeypatch.delenv(variable, raising=False)
        if place != "variable":
            path.unlink()
    with pytest.raises(hampm.FileError, match=f"the program {name} is not found"):
        finding.find_program(dimensions=dimensions)


def test_the_tool_says_what_it_cannot_do(tmp_path):
    """And it asks for the packages that the lock file or requirements/wheel.txt pin."""
    tool = ROOT / "tools/wheel.sh"
    (tmp_path / "tools").mkdir()
    for name in "wheel.sh", "bare_debian.sh":
        shutil.copy(ROOT / "tools" / name, tmp_path / "tools")
    wrong = subprocess.run([tmp_path / "tools/wheel.sh", "--inside"], capture_output=True, text=True)
    assert wrong.returncode == 2 and "tools/wheel.sh --try [FOLDER]" in wrong.stdout + wrong.stderr
    nowhere = subprocess.run([tmp_path / "tools/wheel.sh", "--in", tmp_path], capture_output=True, text=True)
    assert (nowhere.returncode, nowhere.stderr) == (1, f"wheel.sh: {tmp_path}: there is no /usr/bin/python3 in it\n")
    pins = (ROOT / "requirements/wheel.txt").read_text().splitlines()[1:]
    assert all(re.fullmatch(r"[\w-]+==[\d.]+", line) for line in pins)
    assert [line for line in pins if line.startswith("hatchling")] == [line for line in (ROOT / "requirements/test.txt").read_text().splitlines() if line.startswith("hatchling")]
    if shutil.which("shellcheck"):
        subprocess.run(["shellcheck", "-x", tool], check=True)


@pytest.mark.verify
@pytest.mark.xdist_group("wheel")
def test_a_wheel_with_its_libraries_runs_in_a_new_environment(tmp_path):
    """As tools/wheel.sh makes it of the programs built here: installed with its dependencies from the index, it runs models by both programs and from Python."""
    made = subprocess.run([ROOT / "tools/wheel.sh"], capture_output=True, text=True)
    assert made.returncode == 0, made.stdout + made.stderr
    wheel, = (ROOT / "build/wheel").glob("hampm-*.whl")
    assert re.fullmatch(rf"hampm-{re.escape(VERSION)}-py3-none-manylinux_2_\d+_{os.uname().machine}\.whl", wheel.name) and wheel.stat().st_size < 60e6
    assert re.search(rf"^\| with its libraries \| \d+ \| {re.escape(wheel.name)} [\d.]+ MB: libgfortran.*libmetis", made.stdout, re.MULTILINE)
    shown = subprocess.run([ROOT / "build/wheel/venv/bin/auditwheel", "show", wheel], check=True, capture_output=True, text=True).stdout
    assert "manylinux" in re.sub(r"\s+", " ", shown).partition("is consistent with the following platform tag: ")[2][:20]
    environment = {name: value for name, value in os.environ.items() if not name.startswith(("HAMPM", "PYTHON"))}

    def run(*words):
        return subprocess.run(list(map(str, words)), cwd=tmp_path, env=environment, check=True, capture_output=True, text=True).stdout
    run(sys.executable, "-m", "venv", "venv")
    run("venv/bin/python", "-m", "pip", "install", "--quiet", "--disable-pip-version-check", wheel)
    for program, model in (("hampm", "edge_crack"), ("hampm3d", "solid/beam")):
        assert run(f"venv/bin/{program}", "--version").split()[:2] == ["hampm", VERSION]
        run(f"venv/bin/{program}", ROOT / f"input/{model}.nml", "--quiet")
        assert (tmp_path / f"{Path(model).name}.h5").exists()
        loaded = run("ldd", f"{tmp_path}/venv/lib/python{sys.version_info[0]}.{sys.version_info[1]}/site-packages/hampm/bin/{program}")
        others = re.findall(r"=> (?!.*/hampm\.libs/)\S*/(lib[\w-]+)\.so", loaded)
        assert set(others) <= {"libc", "libm", "libgcc_s", "libdl", "libpthread"}, loaded
    said = run("venv/bin/python", "-c", "import hampm; print(hampm.find_program(), hampm.__version__, *hampm.run("
               f"{str(ROOT / 'input/edge_crack.nml')!r}, output='python', progress=False).value('J'))").split()
    assert said[0].endswith("site-packages/hampm/bin/hampm") and said[1] == VERSION and float(said[2]) > 0
