"""The pages that one follows command by command: every command runs as it stands, and prints what the page shows.

Blocks ```sh of docs/tutorials/*.md and README.md are run in order, in a folder that looks like the repository but for its results; a block
after "Save it as `NAME`" is that file. A block ```text behind the commands is what the last of them prints: its lines stand in the
output in this order, with any lines in between, the same words and, but for rounding, the same numbers. Free are the numbers of lines that
tell times, and a word that begins with `...` stands for one that ends so. Commands that install or build are not run: `make` has their target.
"""

import functools
import re
import subprocess
import sys
from types import SimpleNamespace

import h5py
import pytest

from paths import PROGRAM, ROOT, SOLID_PROGRAM

sys.path.insert(0, str(ROOT / "tests/lessons"))

from test_lessons import NUMBER, commands_of, unit_of  # noqa: E402

PAGES = [page for page in (*sorted((ROOT / "docs/tutorials").glob("*.md")), ROOT / "README.md") if page.stem != "solids" or SOLID_PROGRAM.exists()]
PIECE = re.compile(r"[Ss]ave it as `([^`]+)`[^`]*?\n+```\w*\n(.*?)^```$|^```sh\n(.*?)^```$(?:\n\n```text\n(.*?)^```$)?", re.MULTILINE | re.DOTALL)
ROW = re.compile(r"^\|[^|]*\| \[(?P<model>\w+)\.nml\]\([^|]*\) \| `(?P<column>\w+)` \| (?P<handbook>[^| ]+) \| (?P<hampm>[^| ]+) \| (?P<ratio>[\d.]+) \|", re.MULTILINE)
FREE = re.compile(r"wall time|Mp/s|left\b")  # lines with times
BY_TIME = "processor time [s]"              # the last column of a table


def pieces(text):
    """In their order: (file, its text) and (commands, text shown or None)."""
    for match in PIECE.finditer(text):
        yield SimpleNamespace(file=match[1], text=match[2]) if match[1] else SimpleNamespace(file=None, commands=list(commands_of(match[3])), shown=match[4])


def is_left_out(command):
    """Whether a command fetches, installs or builds."""
    return re.match(r"(git clone|cd|make)\b", command)


@pytest.fixture(scope="session")
def done(tmp_path_factory):
    """`done(page)`: the folder of a page whose commands have run, and each with its result, the last of a block with what is shown."""
    @functools.cache
    def run(page):
        folder = tmp_path_factory.mktemp(page.stem)
        for item in ("docs", "postprocess", "batch", "input", "python", "tests", ".venv"):
            (folder / item).symlink_to(ROOT / item)
        (folder / "build/release").mkdir(parents=True)
        (folder / "build/release/hampm").symlink_to(PROGRAM)
        (folder / "build/release3d").mkdir()
        (folder / "build/release3d/hampm3d").symlink_to(SOLID_PROGRAM)
        results = []
        for piece in pieces(page.read_text()):
            if piece.file:
                (folder / piece.file).write_text(piece.text)
                continue
            for k, command in enumerate(piece.commands):
                if not is_left_out(command):
                    result = subprocess.run(["bash", "-c", command], cwd=folder, capture_output=True, text=True, timeout=300)
                    results.append((command, result, piece.shown if k == len(piece.commands) - 1 else None))
        return SimpleNamespace(folder=folder, results=results)
    return run


each_page = pytest.mark.parametrize("page", [pytest.param(page, id=page.stem, marks=pytest.mark.xdist_group(f"page {page.stem}")) for page in PAGES])


@each_page
def test_commands_end_as_the_page_says(done, page):
    for command, result, _ in done(page).results:
        promised = re.search(r"# exit code (\d)$", command)
        assert result.returncode == int(promised[1] if promised else 0), f"{command}\n{result.stdout}{result.stderr}"


@each_page
def test_commands_print_what_the_page_shows(done, page):
    for command, result, shown in done(page).results:
        if shown is not None:
            assert not missing(result.stdout + result.stderr, shown), command


@each_page
def test_targets_of_make_exist(page):
    targets = re.findall(r"^(\w+):.*## ", (ROOT / "Makefile").read_text(), re.MULTILINE) + ["program"]
    for name in re.findall(r"^make (\w+)", page.read_text(), re.MULTILINE):
        assert name in targets


def test_the_first_hour_and_the_specimens_have_commands():
    assert all(sum(not piece.file for piece in pieces(page.read_text())) >= 5 for page in PAGES if page.stem in ("first_hour", "specimens"))


def missing(printed, shown):
    """The first line shown that does not follow in what is printed, with what comes next; else nothing."""
    lines, free_last = iter([line for line in printed.splitlines() if line.strip()]), False
    for wanted in shown.splitlines():
        if not wanted.strip() or wanted.strip() == "...":
            free_last = free_last and bool(wanted.strip())
            continue
        seen = []
        for line in lines:
            seen.append(line)
            if is_same(line, wanted, free_last):
                break
        else:
            return f"{wanted!r} is not in {seen}"
        free_last = free_last or wanted.endswith(BY_TIME)
    return ""


def is_same(line, wanted, free_last):
    """Whether a line printed is the one shown."""
    words, asked = line.split(), wanted.split()
    if len(words) != len(asked):
        return False
    free = [bool(FREE.search(wanted))] * (len(asked) - 1) + [bool(FREE.search(wanted)) or free_last]
    return all(map(is_word, words, asked, free))


def is_word(word, wanted, free):
    if wanted.startswith("...") and len(wanted) > 3:
        return word.endswith(wanted.removeprefix("..."))
    wanted, word = wanted.rstrip(",;"), word.rstrip(",;")
    if not re.fullmatch(NUMBER, wanted):
        return word == wanted
    return bool(re.fullmatch(NUMBER, word)) and (free or float(word) == pytest.approx(float(wanted), rel=2e-3, abs=1.1 * unit_of(wanted)))


@pytest.mark.parametrize(("printed", "shown", "found"), [
    ("a 1.0\nb 2.0", "b 2.0", True), ("a 1.0\nb 2.0", "b 2.3", False), ("b 2.0\na 1.0", "a 1.0\nb 2.0", False), ("a 1.001", "a 1.000", True),
    ("wall time 3.0 s", "wall time 5 s", True), ("3 done; /x/table.csv", "3 done; .../table.csv", True), ("3 done; /x/table.csv", "3 done; .../other", False),
    (f"h K {BY_TIME}\n1 2 3", f"h K {BY_TIME}\n1 2 9", True), (f"h K {BY_TIME}\n1 2 3", f"h K {BY_TIME}\n1 9 3", False), ("a", "a\n...", True)])
def test_what_a_page_shows_is_compared(printed, shown, found):
    assert (missing(printed, shown) == "") == found


# --- the specimens ----------------------------------------------------------------------------------------------------

SPECIMENS = ROOT / "docs/tutorials/specimens.md"
ROWS = [match.groupdict() for match in ROW.finditer(SPECIMENS.read_text())]


def test_the_table_of_specimens_has_rows():
    assert len(ROWS) >= 12


@pytest.mark.xdist_group("page specimens")
@pytest.mark.parametrize("row", ROWS, ids=lambda row: f"{row['model']}-{row['column']}")
def test_a_specimen_gives_the_value_of_its_row(done, row):
    with h5py.File(done(SPECIMENS).folder / f"results/specimens/{row['model']}.h5") as file:
        value = file["history"][row["column"]][-1]
    asked, ratio = float(row["handbook"]), float(row["ratio"])
    assert value == pytest.approx(float(row["hampm"]), rel=2e-3)
    assert value / asked == pytest.approx(ratio, abs=1.5e-3)
