"""The recipes for containers, for Spack and for conda say what tools/setup.sh and the Makefile do."""

import ast
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

from paths import ROOT

RECIPES = ROOT / "recipes"
SETUP = (ROOT / "tools/setup.sh").read_text()
PACKAGES = re.search(r'^packages="(.*)"$', SETUP, re.MULTILINE)[1].split()
BUILT_WITH = {*PACKAGES, "python3", "python3-venv", "ca-certificates", "git"}
# What libraries are in Spack; CHOLMOD and UMFPACK are in suite-sparse
IN_SPACK = {"gfortran": "fortran", "make": "gmake", "liblapack-dev": "lapack", "libopenblas-dev": "blas", "libsuitesparse-dev": "suite-sparse",
            "libarpack2-dev": "arpack-ng", "libhdf5-dev": "hdf5"}

# And for conda, in conda-forge
IN_CONDA = {"gfortran": '${{ compiler("fortran") }}', "make": "make", "liblapack-dev": "liblapack", "libopenblas-dev": "libblas", "libsuitesparse-dev": "suitesparse",
            "libarpack2-dev": "arpack", "libhdf5-dev": "hdf5"}


def commands(text):
    """The commands of a shell script or of a RUN, without continued lines."""
    return [line.strip() for line in re.sub(r"\\\n", " ", text).replace("&&", "\n").splitlines()]


def installed(lines):
    """Packages of each apt-get install."""
    return [set(line.split()[2:]) - {"-y", "--no-install-recommends"} for line in lines if line.startswith("apt-get install")]


def container_stages():
    """[(instruction, what is behind it)] of each stage of the Containerfile."""
    lines = [line for line in re.sub(r"\\\n", " ", (RECIPES / "Containerfile").read_text()).splitlines() if line.strip() and line[0] != "#"]
    stages = []
    for word, _, rest in (line.partition(" ") for line in lines):
        assert word in ("FROM", "RUN", "COPY", "ENV", "WORKDIR", "ENTRYPOINT"), word
        if word == "FROM":
            stages.append([])
        stages[-1].append((word, rest))
    return stages


def test_the_containerfile_builds_with_what_setup_installs_and_keeps_what_is_loaded():
    build, final = container_stages()
    assert build[0][1].endswith(" AS build") and ("COPY", "--from=build /opt/hampm /opt/hampm") in final
    packages, = installed(line for word, rest in build if word == "RUN" for line in commands(rest))
    assert packages == BUILT_WITH
    assert any("make -C /source clean install PREFIX=/opt/hampm" in rest for _, rest in build)
    kept, = installed(line for word, rest in final if word == "RUN" for line in commands(rest))
    assert kept == {"libgfortran5", "libgomp1", "libmetis5", "python3"}


@pytest.mark.skipif(not shutil.which("ldd"), reason="ldd is of Linux")
def test_the_release_loads_only_the_libraries_that_the_image_keeps():
    program = ROOT / "build/release/hampm"
    if not program.exists():
        pytest.skip("no release")
    loaded = set(re.findall(r"^\s*(lib[\w-]+)\.so", subprocess.run(["ldd", program], check=True, capture_output=True, text=True).stdout, re.MULTILINE))
    if "libhdf5" in loaded or "libhdf5_serial" in loaded:
        pytest.skip("without archives the release loads its libraries")
    assert loaded <= {"libgfortran", "libgomp", "libmetis", "libm", "libc", "libgcc_s", "libquadmath", "libdl", "libpthread"}


def test_the_definition_for_apptainer_does_the_same():
    text = (RECIPES / "hampm.def").read_text()
    head, *parts = re.split(r"^%(\w+)\n", text, flags=re.MULTILINE)
    sections = dict(zip(parts[::2], parts[1::2]))
    assert re.search(r"^Bootstrap: docker\nFrom: debian:bookworm-slim$", head, re.MULTILINE)
    assert list(sections) == ["files", "post", "environment", "runscript", "test"]
    lines = commands(sections["post"])
    assert installed(lines) == [BUILT_WITH]
    containers = [line for _, rest in container_stages()[0] for line in commands(rest)]
    assert [line for line in lines if line.startswith("make")] == [line for line in containers if line.startswith("make")]
    for section in ("post", "environment", "runscript", "test"):
        subprocess.run(["sh", "-n"], input=sections[section], text=True, check=True)


def test_the_package_for_spack_depends_on_the_same_libraries():
    tree = ast.parse((RECIPES / "spack/package.py").read_text())
    package = next(node for node in tree.body if isinstance(node, ast.ClassDef))
    assert package.name == "Hampm" and [base.id for base in package.bases] == ["MakefilePackage"]
    needed = {}
    for call in (node.value for node in package.body if isinstance(node, ast.Expr) and isinstance(node.value, ast.Call)):
        if call.func.id == "depends_on":
            name = re.match(r"[\w-]+", call.args[0].value)[0]
            needed.setdefault(name, set()).update(word.value.value for word in call.keywords if word.arg == "type")
    assert {IN_SPACK[name] for name in PACKAGES} <= set(needed)
    run = {line.partition("==")[0] for line in (ROOT / "requirements/run.txt").read_text().splitlines() if line[0] != "#"}
    assert {name.removeprefix("py-") for name, kinds in needed.items() if name.startswith("py-") and "run" in kinds} == run
    assert {node.name for node in package.body if isinstance(node, ast.FunctionDef)} == {"edit", "build", "install"}
    # The line of the Makefile that it leaves out, as it stands
    left_out = re.search(r'filter_file\("(.*?)"', (RECIPES / "spack/package.py").read_text())[1]
    assert (ROOT / "Makefile").read_text().count(f"\t{left_out}\n") == 1


def conda():
    """The recipe, and the shell script of its build."""
    recipe = yaml.safe_load((RECIPES / "conda/recipe.yaml").read_text())
    return recipe, recipe["build"]["script"]


def test_the_recipe_for_conda_depends_on_the_same_libraries_and_packages():
    recipe, script = conda()
    assert recipe["package"] == {"name": "hampm", "version": "${{ version }}"}
    needed = recipe["requirements"]
    assert {IN_CONDA[name] for name in PACKAGES} | {'${{ compiler("c") }}'} <= {*needed["build"], *needed["host"]}
    package = (ROOT / "python/pyproject.toml").read_text()
    asked = ast.literal_eval(re.search(r"^dependencies = (\[.*\])$", package, re.MULTILINE)[1])
    assert needed["run"] == ["python", *(re.sub("(>=)", r" \1", name) for name in asked)]
    back_end, = ast.literal_eval(re.search(r"^requires = (\[.*\])$", package, re.MULTILINE)[1])
    assert {"python", "pip", back_end.replace(">=", " >=")} <= set(needed["host"])
    assert all((RECIPES / "conda" / recipe["source"]["path"] / name).exists() for name in ("Makefile", recipe["about"]["license_file"]))
    subprocess.run(["sh", "-n"], input=script, text=True, check=True)
    named = set(re.findall(r"\b([A-Z][A-Z0-9_]+)=", script)) - {"HAMPM_PURE"}
    assert named == {"HDF5_LINK", "ALGEBRA_LINK", "FC"} and all(re.search(rf"^{name} [?:]?=", (ROOT / "Makefile").read_text(), re.MULTILINE) for name in named)


@pytest.mark.verify
@pytest.mark.xdist_group("wheel")
def test_the_script_for_conda_installs_programs_and_package(tmp_path):
    """In an environment that stands for that of conda, of programs that are built already: the tests of the recipe pass there, with the programs not in PATH. Programs of another commit
    would be linked again, with libraries that this environment does not have."""
    present = subprocess.run([ROOT / "tools/version.sh"], check=True, capture_output=True, text=True).stdout
    built = [ROOT / "build/release/hampm", ROOT / "build/release3d/hampm3d"]
    if not all(path.exists() and subprocess.run([path, "--version"], check=True, capture_output=True, text=True).stdout == f"hampm {present}" for path in built):
        pytest.skip("the release is not of this commit: make program, make program dim=3")
    prefix = tmp_path / "prefix"
    subprocess.run([sys.executable, "-m", "venv", "--system-site-packages", prefix], check=True)
    if sys.prefix != sys.base_prefix:       # hatchling of this environment, but not the package of the checkout
        for packages in prefix.glob("lib/python3*/site-packages"):
            (packages / "outer.pth").write_text("\n".join(path for path in sys.path if path.endswith("site-packages")))
    environment = {name: value for name, value in os.environ.items() if not name.startswith(("HAMPM", "PYTHON", "MAKE"))}
    recipe, script = conda()
    subprocess.run(["sh", "-e"], input=script, text=True, check=True, cwd=ROOT,
                   env=environment | {"PREFIX": str(prefix), "PYTHON": str(prefix / "bin/python"), "CPU_COUNT": "2", "FC": "gfortran"})
    version = recipe["context"]["version"]
    for name in ("hampm", "hampm3d"):
        assert subprocess.run([prefix / "bin" / name, "--version"], check=True, capture_output=True, text=True).stdout.split()[:2] == ["hampm", version]
    found = subprocess.run([prefix / "bin/python", "-c", "import hampm; print(hampm.__file__, hampm.find_program(), hampm.find_program(dimensions=3))"], check=True,
                           capture_output=True, text=True, cwd=tmp_path, env=environment).stdout.split()
    assert Path(found[0]).is_relative_to(prefix) and found[1:] == [str(prefix / "bin/hampm"), str(prefix / "bin/hampm3d")]


def test_what_tries_them_in_a_bare_root_installs_the_same():
    text = (ROOT / "tools/bare_root.sh").read_text()
    assert "$packages python3 python3-venv ca-certificates" in text and "make -C /source install PREFIX=/opt/hampm" in text
    found = re.search(r"^packages=\$\((sed .*)\)$", text, re.MULTILINE)[1].replace("$root", str(ROOT))
    assert subprocess.run(["sh", "-c", found], check=True, capture_output=True, text=True).stdout.split() == PACKAGES
    if shutil.which("shellcheck"):
        for name in ("bare_root.sh", "bare_debian.sh", "install.sh", "lock.sh", "setup.sh", "version.sh", "hampm-tool"):
            subprocess.run(["shellcheck", "-x", ROOT / "tools" / name], check=True)


def test_a_bare_root_is_removed_only_where_nothing_is_mounted_below_it():
    """What is mounted for a step is in a namespace of its own, and the check comes before the removal."""
    text = (ROOT / "tools/bare_debian.sh").read_text()
    users = [(ROOT / "tools" / name).read_text() for name in ("bare_root.sh", "wheel.sh")]
    assert all(". \"$root/tools/bare_debian.sh\"" in user and not re.search(r"rm -rf.*\bbare\b|\bmount -|--r?bind", user) for user in users)
    assert "mount --bind" not in text and "--rbind" not in text
    assert text.count("rm -rf") == 1 and text.index('[ -n "$(mounted)" ]') < text.index("rm -rf --one-file-system")
    mounts = [line.strip() for line in text.splitlines() if re.search(r"\bmount -", line)]
    assert mounts and all("unshare --mount --pid --fork" in text[:text.index(line)] + line for line in mounts)
    assert "mount -t devpts" not in text or "mount -t devpts -o newinstance" in text
    assert all(kind in ("proc", "tmpfs", "devpts") for kind in re.findall(r"mount -t (\w+)", text))
