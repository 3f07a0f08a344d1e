"""The worked changes of docs/how-to/extending.md: each touches few files, and together they build and give the numbers of the theory."""

import math
import os
import re
import shutil
import subprocess
import sys

import h5py
import numpy as np
import pytest
from paths import ROOT

PAGE = (ROOT / "docs/how-to/extending.md").read_text()
BLOCK = re.compile(r"^```(fortran|toml|diff) ?(\S*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
FILE = re.compile(r"\[`(src/\S+)`\]\((extending/\S+)\)")
FILES = {"A material law": (1, 1), "A key": (0, 2), "A group": (1, 1), "An estimator": (1, 1),
         "A law of crack growth": (1, 2), "An indicator of refinement": (1, 2)}  # new, changed


def sections():
    """Of each section: its blocks, and the files beside the page that it links, as (kind, file, text)."""
    parts = re.split(r"^## (.*)$", PAGE, flags=re.MULTILINE)
    return {title: BLOCK.findall(text) + [("fortran", name, (ROOT / "docs/how-to" / place).read_text()) for name, place in FILE.findall(text)]
            for title, text in zip(parts[1::2], parts[2::2])}


def hunks(text):
    """(file, old lines, new lines) of a block of changes; ` @` at the end of a line stands for the rest of it."""
    for part in re.split(r"^--- ", text, flags=re.MULTILINE)[1:]:
        name, _, rest = part.partition("\n")
        for hunk in re.split(r"^@@\n", rest, flags=re.MULTILINE):
            lines = hunk.splitlines()
            yield name, [line[1:] for line in lines if line[:1] in " -"], [line[1:] for line in lines if line[:1] in " +"]


def replaced(text, old, new):
    """A text with the lines `old`, which stand in it once, replaced by the lines `new`."""
    lines = text.splitlines()

    def same(a, b):
        return a.startswith(b[:-1]) if b.endswith("@") else a == b
    at = [k for k in range(len(lines)) if len(lines) - k >= len(old) and all(map(same, lines[k:], old))]
    assert len(at) == 1, f"{len(at)} times: {old}"
    whole = dict(zip(old, lines[at[0]:]))
    return "\n".join([*lines[:at[0]], *(whole.get(line, line) for line in new), *lines[at[0] + len(old):]]) + "\n"


def change(tree, blocks):
    """Apply the changes of a section to a tree: the files that are new, and those that are changed."""
    new, changed = set(), set()
    for kind, name, text in blocks:
        if name.endswith((".f90", ".toml")):
            new.add(name)
            assert not (tree / name).exists()
            (tree / name).write_text(text)
        elif kind == "diff":
            for file, old, lines in hunks(text):
                changed.add(file)
                (tree / file).write_text(replaced((tree / file).read_text(), old, lines))
    return new, changed


@pytest.fixture(scope="module")
def tree(tmp_path_factory):
    """A copy of what a build needs."""
    tree = tmp_path_factory.mktemp("extended")
    shutil.copy(ROOT / "Makefile", tree)
    for folder in "src", "tools":
        shutil.copytree(ROOT / folder, tree / folder)
    return tree


@pytest.fixture(scope="module")
def program(tree):
    """The program with all changes."""
    for blocks in sections().values():
        change(tree, blocks)
    subprocess.run([sys.executable, tree / "tools/schema.py"], check=True)
    build = os.environ.get("HAMPM_EXTENDED_BUILD", "quick")
    done = subprocess.run(["make", "-j2", f"build/{build}/hampm", f"build={build}"], cwd=tree, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-3000:]
    return tree / "build" / build / "hampm"


@pytest.mark.parametrize("title", FILES)
def test_a_change_touches_its_own_file_and_a_row(title, tmp_path):
    names = {file for _, _, text in sections()[title] for file, _, _ in hunks(text)}
    for name in names | {name for _, name, _ in sections()[title] if name.endswith((".f90", ".toml"))}:
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        if name in names:
            shutil.copy(ROOT / name, tmp_path / name)
    new, changed = change(tmp_path, sections()[title])
    assert (len(new), len(changed)) == FILES[title]


def results(program, name, folder):
    """The results of the model of a block, and what the run has written."""
    text = next(text for blocks in sections().values() for _, block, text in blocks if block == name)
    (folder / name).write_text(text)
    done = subprocess.run([program, name], cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return h5py.File((folder / name).with_suffix(".h5"))


@pytest.mark.verify
@pytest.mark.xdist_group("extending")
class TestTheExtendedProgram:
    def test_blatz_ko_foam_is_as_stiff_as_its_closed_form(self, program, tmp_path):
        history = results(program, "law.nml", tmp_path)["history"]
        young, poisson, s, area = 1e6, 0.25, 1.5, 10e-3 * 2e-3
        asked = young / (2 * (1 + poisson)) * (s - s ** (-1 - 2 * poisson)) * area
        assert history["reaction_grip_x"][-1] == pytest.approx(asked, rel=1e-6)

    def test_reference_value_has_the_longer_crack(self, program, tmp_path):
        asked = 12 * (0.05 + 0.64 * 0.01) ** 2 / (70e9 * 0.01**2 * 0.01**3)
        assert results(program, "key.nml", tmp_path)["history"].attrs["G_ref"] == pytest.approx(asked, rel=1e-12)

    def test_loads_are_scaled(self, program, tmp_path):
        assert results(program, "group.nml", tmp_path)["history"]["reaction_grip_x"][-1] == pytest.approx(-200, rel=1e-9)

    def test_displacements_tell_K_of_a_crack_in_a_plate(self, program, tmp_path):
        history = results(program, "estimator.nml", tmp_path)["history"]
        a, width, stress, e = 8e-3, 40e-3, 40e3 / 40e-3, 200e9 / (1 - 0.3**2)
        k = stress * math.sqrt(math.pi * a / math.cos(math.pi * a / width)) * (1 - 0.025 * (2 * a / width) ** 2 + 0.06 * (2 * a / width) ** 4)
        # K within 1.5 %: a fit of three terms over 6 cells, in which the particles beside the crack are up to a cell from its faces
        assert history["G_displacements_I"][-1] == pytest.approx(k**2 / e, rel=0.03)
        assert abs(history["G_displacements_II"][-1]) < 1e-6 * history["G_displacements_I"][-1]
        assert history["G"][-1] == history["G_displacements_I"][-1] + abs(history["G_displacements_II"][-1])

    def test_a_crack_grows_at_its_resistance(self, program, tmp_path):
        history = results(program, "growth.nml", tmp_path)["history"]
        length = history["crack_length"][:]
        assert length == pytest.approx(0.03 + 5e-3 * np.arange(5), rel=1e-12)
        assert history["toughness"][:] == pytest.approx(300 - 200 * np.exp(-(length - 0.03) / 0.01), rel=1e-12)
        assert history["G"][:] == pytest.approx(history["toughness"][:], rel=1e-5)

    def test_cells_with_more_energy_than_the_mean_refine(self, program, tmp_path):
        file = results(program, "indicator.nml", tmp_path)
        limit = (1 - 1 / math.sqrt(3)) * 40  # cells
        columns = np.arange(40)
        fine = columns[columns + 0.5 < limit]
        assert file["history"]["particles"][-1] == 4 * (16 * len(fine) + 4 * (40 - len(fine)))
        # of a cell from x to x + 1 the mean of 3 (1 - x/L)**2, with particles at a quarter and three quarters of halved cells
        assert file["history"]["peak_energy"][-1] == pytest.approx(3 * (1 - 0.25 / 40) ** 2, rel=1e-3)

    def test_choices_of_the_keys_are_those_of_the_tables(self, program):
        keys = subprocess.run([program, "--keys"], capture_output=True, text=True).stdout
        for name in "blatz_ko", "displacements", "chi", "loads", "r_curve", "plateau", "energy", "times_mean":
            assert f"`{name}`" in keys
