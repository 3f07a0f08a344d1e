"""What `make install` puts in its place works from any folder when the sources are gone, and `make uninstall` leaves nothing of it."""

import os
import re
import shutil
import subprocess
import sys

import pytest

from paths import PROGRAM, ROOT, SOLID_PROGRAM

KEYS = subprocess.run([PROGRAM, "--keys"], check=True, capture_output=True, text=True).stdout
OPTIONS = re.findall(r"^  (--[\w-]+)", subprocess.run([PROGRAM, "--help"], check=True, capture_output=True, text=True).stdout, re.MULTILINE)


def install(root, *words, **environment):
    return subprocess.run([root / "tools/install.sh", *words], capture_output=True, text=True, env=os.environ | environment)


@pytest.fixture
def sources(tmp_path):
    """What is installed, as in a checkout that can be changed and removed."""
    root = tmp_path / "check out"
    for name in ("batch", "postprocess", "input", "requirements", "tools", "python"):
        if (ROOT / name).exists():
            shutil.copytree(ROOT / name, root / name)
    for path in [*ROOT.glob("*.*"), ROOT / "LICENSE", *(ROOT / "docs").rglob("*.md")]:
        if path.is_file():
            (root / path.relative_to(ROOT)).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(path, root / path.relative_to(ROOT))
    return root


@pytest.fixture
def prefix(sources, tmp_path):
    """A folder with hampm, and no sources."""
    place = tmp_path / "in stalled"
    done = install(sources, PROGRAM, *[SOLID_PROGRAM] * SOLID_PROGRAM.exists(), PREFIX=str(place), packages="none")
    assert done.returncode == 0 and done.stderr == "", done.stderr
    shutil.rmtree(sources)
    return place


def files(folder):
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file())


def tool(prefix, *words, cwd):
    return subprocess.run([prefix / "bin/hampm-tool", *words], cwd=cwd, capture_output=True, text=True, env=os.environ | {"HAMPM_PYTHON": sys.executable})


def test_the_program_and_its_scripts_run_from_any_folder(prefix, tmp_path):
    here = tmp_path / "else where"
    here.mkdir()
    subprocess.run([prefix / "bin/hampm", prefix / "share/hampm/input/edge_crack.nml", "--quiet"], cwd=here, check=True)
    table = tool(prefix, "tabulate", "edge_crack.h5", "--column", "J", cwd=here)
    assert table.returncode == 0 and "edge_crack" in table.stdout, table.stderr
    assert tool(prefix, "plot_g", "edge_crack.h5", "--column", "J", "--output", "g.png", cwd=here).returncode == 0 and (here / "g.png").exists()
    listed = tool(prefix, cwd=here).stdout
    assert re.search(r"^tabulate +Table of", listed, re.MULTILINE) and re.search(r"^upgrade +\w", listed, re.MULTILINE)
    wrong = tool(prefix, "tabulat", cwd=here)
    assert (wrong.returncode, wrong.stderr) == (2, "hampm-tool: there is no script tabulat; hampm-tool lists them\n")
    if (ROOT / "python").exists():
        found = tool(prefix, "python", "-c", "import hampm; print(hampm.__file__)", cwd=here)
        assert found.stdout.startswith(str(prefix)), found.stderr
    assert tool(prefix, "python", "-c", "import os, shutil; print(os.path.realpath(shutil.which('hampm')))", cwd=here).stdout.strip() == \
        str(prefix / "bin/hampm")


def test_a_link_to_the_tool_works(prefix, tmp_path):
    (tmp_path / "tool").symlink_to(prefix / "bin/hampm-tool")
    assert "tabulate" in subprocess.run([tmp_path / "tool"], capture_output=True, text=True).stdout


def test_scripts_run_the_installed_program(prefix, tmp_path):
    pytest.importorskip("yaml")
    (tmp_path / "x.yaml").write_text(f"namelist: '{prefix}/share/hampm/input/dcb.nml'\noutput: out\nproduct: {{grid.cell: [1, 2]}}\n")
    assert len(tool(prefix, "sweep", "x.yaml", cwd=tmp_path).stdout.splitlines()) == 2
    found = tool(prefix, "python", "-c", "import hampm; print(hampm.find_program())", cwd=tmp_path).stdout
    assert str(prefix / "bin/hampm") in found
    if SOLID_PROGRAM.exists():
        found = tool(prefix, "python", "-c", "import hampm; print(hampm.find_program(dimensions=3))", cwd=tmp_path).stdout
        assert str(prefix / "bin/hampm3d") in found


def test_uninstall_leaves_what_others_have(prefix, tmp_path):
    (prefix / "bin/other").write_text("")
    tool(prefix, "tabulate", "--help", cwd=tmp_path)
    done = subprocess.run(["sh", prefix / "share/hampm/tools/install.sh", "--uninstall"], capture_output=True, text=True, env=os.environ | {"PREFIX": str(prefix)})
    assert (done.returncode, done.stderr, files(prefix)) == (0, "", ["bin/other"])
    assert not (prefix / "share").exists()
    again = install(ROOT, "--uninstall", PREFIX=str(prefix))
    assert again.returncode == 1 and "hampm is not installed" in again.stderr


def test_packages_are_built_in_a_folder_apart(sources, tmp_path):
    """DESTDIR stands before the prefix and in no file; no Python packages are brought along. What is no longer installed goes."""
    stage = tmp_path / "stage"
    for turn in range(2):
        assert install(sources, PROGRAM, PREFIX="/opt/hampm", DESTDIR=str(stage), packages="run").returncode == 0
        assert [path.name for path in stage.iterdir()] == ["opt"]
        found = files(stage / "opt/hampm")
        assert "bin/hampm" in found and not any("venv" in name for name in found)
        assert ("share/hampm/postprocess/tabulate.py" in found) == (turn == 0)
        assert not any(str(stage).encode() in (stage / "opt/hampm" / name).read_bytes() for name in found)
        (sources / "postprocess/tabulate.py").unlink(missing_ok=True)
    assert install(sources, "--uninstall", PREFIX="/opt/hampm", DESTDIR=str(stage)).returncode == 0 and files(stage) == []


@pytest.mark.verify
def test_python_packages_are_installed_beside_the_program(sources, tmp_path):
    """From the package index: those of `make run`, which take less than 250 MB."""
    place = tmp_path / "with python"
    assert install(sources, PROGRAM, PREFIX=str(place)).returncode == 0
    shutil.rmtree(sources)
    size = sum(path.lstat().st_blocks for path in (place / "lib").rglob("*")) * 512
    assert size < 250e6
    subprocess.run([place / "bin/hampm", place / "share/hampm/input/edge_crack.nml", "--quiet"], cwd=tmp_path, check=True)
    table = subprocess.run([place / "bin/hampm-tool", "tabulate", "edge_crack.h5"], cwd=tmp_path, capture_output=True, text=True)
    assert table.returncode == 0, table.stderr
    assert install(ROOT, "--uninstall", PREFIX=str(place)).returncode == 0 and not files(place)


def test_make_hands_on_where_to_install_and_what_to_run(tmp_path):
    (tmp_path / "tools").mkdir()
    shutil.copy(ROOT / "Makefile", tmp_path)
    shutil.copy(ROOT / "tools/depends.awk", tmp_path / "tools")
    (tmp_path / "src").mkdir()
    (tmp_path / "src/main.f90").write_text("end\n")
    (tmp_path / "src/processor.c").write_text("int processor;\n")
    for name, does in (("setup.sh", "echo setup $@"), ("version.sh", "echo 1"), ("install.sh", 'echo "$PREFIX|$DESTDIR|$packages|$*"')):
        (tmp_path / "tools" / name).write_text(f"#!/bin/sh\n{does}\n")
        (tmp_path / "tools" / name).chmod(0o755)
    common = "make", "-s", "HDF5_LINK=", "ALGEBRA_LINK=", "build=quick"
    environment = {key: value for key, value in os.environ.items() if not key.startswith("MAKE")}
    (tmp_path / "tools/python").write_text('#!/bin/sh\nprintf "%s|" "$@"\n')
    (tmp_path / "tools/python").chmod(0o755)
    for words, said in ((["sweep", "file=my sweeps/x.yaml", "strict=1", "PYTHON=tools/python"], "batch/run_sweep.py|my sweeps/x.yaml|--program|build/quick/hampm|--strict|"),
                        (["docs", "PYTHON=tools/python"], "tools/api_pages.py|"), (["install", "PREFIX=/a b", "packages=run batch"], "/a b||run batch|build/quick/hampm"), (["install"], "/usr/local|||build/quick/hampm"),
                        (["uninstall", "PREFIX=/a", "DESTDIR=/c d"], "/a|/c d||--uninstall")):
        lines = subprocess.run([*common, *words], cwd=tmp_path, env=environment, check=True, capture_output=True, text=True).stdout.splitlines()
        assert lines[-1].endswith(said)
        installed = {"install": ["setup program"], "sweep": ["setup run batch"], "docs": ["setup docs"], "uninstall": []}
        assert [line for line in lines if line.startswith("setup")] == installed[words[0]]


# --- the manual page and completions, which are made from what the program says -----------------------------------------------

@pytest.fixture(scope="module")
def manual(tmp_path_factory):
    """The files of a kind, made once."""
    folder = tmp_path_factory.mktemp("manual")

    def make(kind):
        path = folder / kind
        if not path.exists():
            path.write_text(subprocess.run([sys.executable, ROOT / "tools/manual.py", PROGRAM, kind], check=True, capture_output=True, text=True).stdout)
        return path
    return make


def test_the_manual_page_has_every_option_group_and_key(manual):
    text = manual("man").read_text().replace("\\-", "-")
    assert [name for name in OPTIONS if f"\\fB{name}\\fR" not in text] == [] and len(OPTIONS) > 10
    keys = re.findall(r"^\| `(\w+)`", KEYS, re.MULTILINE)
    assert [key for key in keys if f"\\fB{key}\\fR (" not in text] == [] and text.count(".TP") == len(keys) + len(OPTIONS)
    assert [group for group in re.findall(r"^## &(\w+)", KEYS, re.MULTILINE) if f".SS &{group}" not in text] == []
    assert ".SH EXIT STATUS\n0 done; 2 an error" in text


@pytest.mark.skipif(not shutil.which("man"), reason="man is not installed")
def test_the_manual_page_is_formatted_without_a_warning(manual):
    shown = subprocess.run(["man", "--warnings", "-l", manual("man")], capture_output=True, text=True, env=os.environ | {"MANPAGER": "cat", "MANWIDTH": "100"})
    assert (shown.returncode, shown.stderr) == (0, "") and "--resume CHECKPOINT" in shown.stdout


def completed(manual, folder, words):
    """What bash offers for the last of some words."""
    script = 'source "$1"; shift; COMP_WORDS=("$@") COMP_CWORD=$(($# - 1)); _hampm; printf "%s\\n" "${COMPREPLY[@]}"'
    run = subprocess.run(["bash", "-c", script, "bash", manual("bash"), "hampm", *words], cwd=folder, capture_output=True, text=True)
    assert run.returncode == 0 and run.stderr == ""
    return sorted(run.stdout.split("\n")[:-1])


@pytest.mark.parametrize("words, offered", [
    (["--res"], ["--resume"]),
    (["--set", "method.ma"], ["method.mass="]),
    (["--set", "method.mass", "="], ["auto", "consistent", "fmpm", "lumped", "partial", "tip_weighted", "weighted"]),
    (["--set", "method.mass", "=", "l"], ["lumped"]),
    (["--set", "method.mass=l"], ["method.mass=lumped"]),
    (["--set", "energy_release.energy_balance", "=", ".t"], [".true."]),
    (["--set", "grid.cell", "=", ""], [""]),
    (["--threads", ""], [""]),
    (["--output", ""], ["a folder"]),
    (["--output", "=", "a"], ["a folder"]),
    (["--resume", ""], ["a folder", "x.h5.checkpoint"]),
    ([""], ["a folder", "a model.nml"]),
    (["a model.nml", "--che"], ["--check"])], ids=" ".join)
def test_bash_completes(manual, tmp_path, words, offered):
    (tmp_path / "a folder").mkdir()
    for name in ("a model.nml", "x.h5.checkpoint", "x.h5"):
        (tmp_path / name).touch()
    assert completed(manual, tmp_path, words) == offered


@pytest.mark.skipif(not shutil.which("zsh"), reason="zsh is not installed")
@pytest.mark.parametrize("typed, shown", [("hampm --res", "--resume "), ("hampm --set method.ma", "method.mass="), ("hampm --set method.mass=lu", "method.mass=lumped "),
                                          ("hampm a", "a.nml ")])
def test_zsh_completes(manual, tmp_path, typed, shown):
    """In a terminal, where a tabulator is typed."""
    (tmp_path / "functions").mkdir()
    shutil.copy(manual("zsh"), tmp_path / "functions/_hampm")
    (tmp_path / "a.nml").touch()
    script = f"""
        zmodload zsh/zpty
        zpty shell 'PS1= TERM=dumb zsh -f -i'
        zpty -w shell 'fpath=({tmp_path}/functions $fpath); autoload -U compinit; compinit -u -D; unsetopt zle_bracketed_paste 2>/dev/null; print REA""DY'
        zpty -r shell line '*READY*'
        zpty -w -n shell $'{typed}\\t'
        sleep 0.7
        zpty -w -n shell $'\\x01echo \\'<\\x05>\\'\\n'
        zpty -r shell line '*>*>*'
        print -r -- $line
    """
    run = subprocess.run(["zsh", "-f", "-c", script], cwd=tmp_path, capture_output=True, text=True, timeout=30)
    assert shown in run.stdout, run.stdout + run.stderr
