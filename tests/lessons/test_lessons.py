"""The lessons of docs/lessons: every command runs as it stands, in a cell of the notebook of the lesson, and prints what the lesson shows, and the numbers of the text are
those measured, and are what theory asks.

The lessons themselves have no marks. `<lesson>.toml` says what a number is and among which words it stands:

    [let]       optional: names for numbers and expressions, in order
    [name]      warned    some words of a warning of `--check`, which the lesson tells of; with `source` alone
                measured  an expression; optional where the lesson gives theory alone
                asked     a number or an expression, from theory or an independent method
                rtol      of `asked`, and/or; a number or an expression
                atol      absolute
                source    where `asked` and the tolerance come from
                said      some words of the lesson, once there, with {} in the place of the number that gives `measured`; or a list of such
                said_asked  the same of numbers that give `asked`

`solutions/<number>.toml` says the same of the solutions of the exercises, and `exercises/solutions/answers.toml` of the answers of the laboratory. Their runs are

    [runs]                    name = what `--set` overrides in the namelist of the lesson
    half = ["grid.cell=0.5"]
    [edits]                   optional: name = [pattern, text] or several, by which the namelist of that run differs
    [forced]                  optional: name = time step, for runs by forced_step
    [checked]                 optional: name = what `--set` overrides in `--check`
    [scenes]                  optional: name = number of the lesson whose namelist it is

A run is made where an expression first reads it; a number may be `measured` and `said` without what theory asks.

Expressions know numpy as `np`, the attributes and the
last value of a column of results/lessons/<number>/RESULT.h5 as `last('RESULT', 'column')`, all values as `history(...)`, and the
functions that `Runs` lists.
"""

import functools
import re
import subprocess
import sys
from types import SimpleNamespace

import nbclient
import numpy as np
import pytest

import plot_profile
from frames import Frames
from history import History
from paths import PROGRAM, ROOT

sys.path.append(str(ROOT / "tools"))

from notebooks import commands_of, notebook_of  # noqa: E402

try:
    import tomllib
except ImportError:  # Python 3.10
    import tomli as tomllib

FOLDER = ROOT / "docs/lessons"
NAMES = sorted((path.stem for path in FOLDER.glob("[0-9]*_*.md")), key=lambda name: int(name.partition("_")[0]))
SOLUTIONS = [*(f"solutions/{name.partition('_')[0]}" for name in NAMES), "exercises/solutions/answers"]
TABLES = "runs", "edits", "forced", "checked", "scenes"
NUMBER = r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?"
LARGEST_PICTURE = 80_000  # bytes


class Runs:
    """Results, and the expressions that know them."""

    def __init__(self, name, folder):
        self.name, self.folder, self.number = name, folder, number_of(name)
        self.checks = checks_of(name)
        self.names = {"np": np, "last": self.last, "history": self.history, "profile": self.profile,
                      "wave_number": wave_number, "output": self.output}

    def name_expressions(self):
        """Give names to what stands under [let]."""
        for key, value in self.checks.pop("let", {}).items():
            self.names[key] = self.value(value)

    def value(self, expression):
        """The value of an expression, or a number as it is."""
        return eval(expression, self.names) if isinstance(expression, str) else expression

    @functools.cache
    def columns(self, result):
        history = History(self.path(result))
        return history.attributes | history.columns

    def history(self, result, column):
        """All values of a column of the history."""
        return self.columns(result)[column]

    def last(self, result, column):
        """The last value of a column of the history, or an attribute of it."""
        return np.atleast_1d(self.columns(result)[column])[-1]

    def profile(self, result, *arguments):
        """A field along a line in the last snapshot, by the options of plot_profile.py."""
        frames = Frames(self.path(result))
        return plot_profile.profile(frames, result, frames.number(), plot_profile.parse([str(frames.path), *arguments]))


class Lesson(Runs):
    """A lesson, its notebook run in a folder that looks like the repository but for its results."""

    def __init__(self, name, folder):
        super().__init__(name, folder)
        self.text = (FOLDER / f"{name}.md").read_text()
        for item in ("docs", "postprocess", "tests", ".venv"):
            (folder / item).symlink_to(ROOT / item)
        (folder / "build/release").mkdir(parents=True)
        (folder / "build/release/hampm").symlink_to(PROGRAM)
        (folder / "build/release/forced_step").symlink_to(PROGRAM.with_name("forced_step"))
        self.notebook = notebook_of(self.text, folder)
        nbclient.NotebookClient(self.notebook, kernel_name="python3", allow_errors=True, timeout=120, resources={"metadata": {"path": str(folder)}}).execute()
        self.cells = [cell for cell in self.notebook.cells if cell.cell_type == "code"]
        results = iter([self._result(cell) for cell in self.cells if cell.source.startswith("%%bash\n")])
        self.blocks = [SimpleNamespace(results=[(command, next(results)) for command in commands], shown=shown) for commands, shown in blocks(self.text)]
        self.name_expressions()

    @staticmethod
    def _result(cell):
        """What a cell of a command printed, and why it failed, if it did."""
        printed = {name: "".join(item.text for item in cell.outputs if item.output_type == "stream" and item.name == name) for name in ("stdout", "stderr")}
        return SimpleNamespace(**printed, source=cell.source, error="".join(item.evalue for item in cell.outputs if item.output_type == "error"))

    def path(self, result):
        return self.folder / f"results/lessons/{self.number}/{result}.h5"

    def output(self, pattern):
        """The number that a pattern finds in what the commands print, messages too."""
        printed = "".join(result.stdout + result.stderr for block in self.blocks for _, result in block.results)
        return float(re.search(pattern, printed)[1])


class Solutions(Runs):
    """The solutions of the exercises of a lesson, whose runs are made when they are asked for."""

    def __init__(self, name, folder):
        super().__init__(name, folder)
        self.runs, self.edits, self.forced, self.checked, self.scenes = (self.checks.pop(key, {}) for key in TABLES)
        self.name_expressions()

    def path(self, result):
        path = self.folder / f"{result}.h5"
        if not path.exists():
            program = [PROGRAM.with_name("forced_step"), str(self.forced[result])] if result in self.forced else [PROGRAM]
            self.run(result, [*program, f"{result}.nml", "--quiet", "--set", f"output.file={result}.h5"], self.runs[result])
        return path

    def run(self, result, command, settings):
        """What the program prints for the namelist of a run."""
        text, edits = next(FOLDER.glob(f"{self.scenes.get(result, self.number)}_*.nml")).read_text(), self.edits.get(result, [])
        for pattern, new in [edits] if edits and isinstance(edits[0], str) else edits:
            text, count = re.subn(pattern, new, text, flags=re.DOTALL)
            assert count, pattern
        (self.folder / f"{result}.nml").write_text(text)
        words = [word for setting in settings for word in ("--set", setting)]
        done = subprocess.run([*map(str, command), *words], cwd=self.folder, capture_output=True, text=True, timeout=300)
        return done.stdout + done.stderr

    @functools.cache
    def output(self, name, pattern):
        """The number that a pattern finds in what `--check` prints."""
        printed = self.run(name, [PROGRAM, "--check", f"{name}.nml"], self.checked[name])
        return float(re.search(pattern, printed)[1])


def wave_number(shown, last, least=0.6, most=1.0):
    """Wave number of the sine that fits a profile up to a place best, together with a constant, between two bounds [1/m]."""
    here = shown.place < last

    def misfit(k):
        waves = np.column_stack([np.sin(k * shown.place[here]), np.cos(k * shown.place[here]), np.ones(np.count_nonzero(here))])
        return np.linalg.lstsq(waves, shown.value[here], rcond=None)[1][0]
    return min(np.linspace(least, most, 801), key=misfit)


def blocks(text):
    """The blocks of commands of a lesson, each with the text shown as the output of its last command, or None."""
    for match in re.finditer(r"^```sh\n(.*?)^```\n(?:\n```text\n(.*?)^```\n)?", text, flags=re.S | re.M):
        yield commands_of(match[1]), match[2]


@pytest.fixture(scope="session")
def lesson_of(tmp_path_factory):
    """`lesson_of(name)`: that lesson, run once."""
    return functools.cache(lambda name: (Solutions if name in SOLUTIONS else Lesson)(name, tmp_path_factory.mktemp("lesson")))


def number_of(name):
    return name.removeprefix("solutions/").partition("_")[0]


def checks_of(name):
    """What is known of the numbers of a lesson."""
    return tomllib.loads((ROOT / "tests/lessons" / f"{name}.toml").read_text())


def said(name):
    """The numbers of a lesson: name, whether measured or asked, the words around it."""
    for key, check in checks_of(name).items():
        for kind, words in (("measured", check.get("said", [])), ("asked", check.get("said_asked", []))) if key not in ("let", *TABLES) else ():
            yield from ((key, kind, place) for place in ([words] if isinstance(words, str) else words))


def number_at(name, words):
    """The number in the place of {} among some words, which stand once in the lesson."""
    text = " ".join((FOLDER / f"{name}.md").read_text().split())
    found = re.findall(re.escape(words).replace(r"\{\}", rf"({NUMBER})"), text)
    assert len(found) == 1, f"{name}: '{words}' stands {len(found)} times in the lesson"
    return found[0]


def parameters(items):
    """Test parameters from tuples that begin with a lesson; its tests stay together, as its commands run once."""
    return [pytest.param(*item, id="-".join(map(str, item[:3])), marks=pytest.mark.xdist_group(item[0])) for item in items]


each_lesson = pytest.mark.parametrize("name", parameters([name] for name in NAMES))


def test_the_course_lists_the_lessons_in_order():
    assert re.findall(r"^\| \[\d+\]\((\w+)\.md\)", (FOLDER / "README.md").read_text(), flags=re.M) == NAMES
    assert [number_of(name) for name in NAMES] == [str(k) for k in range(len(NAMES))]


@each_lesson
def test_a_lesson_has_its_parts(name):
    text = (FOLDER / f"{name}.md").read_text()
    parts = re.findall(r"^## (.*)", text, flags=re.M)
    assert parts == ["Commands", "What to see", "Question", "Exercises"]
    assert all(f"**{word}**" in text for word in ("Aims", "Time", "Needs")) and text.count("*(points: ") == 2
    number, solutions = number_of(name), (FOLDER / f"solutions/{number_of(name)}.md").read_text()
    assert f"(solutions/{number}.md)" in text and "**1.**" in solutions and "**2.**" in solutions
    assert text.startswith(f"# Lesson {number_of(name)}: ") and f"({name}.nml)" in text and f"({name}.png)" in text
    question = text[text.index("## Question"):].partition("## Exercises")[0]
    assert "?" in question[:question.index("<details>")] and question.rstrip().endswith("</details>")
    assert f"-o results/lessons/{name}.png" in text.replace("--output", "-o") and any(said(name)) and "<!--" not in text
    assert (FOLDER / f"{name}.png").stat().st_size < LARGEST_PICTURE


@each_lesson
def test_the_namelist_is_valid(hampm, name):
    """Without a warning, but for those that the lesson tells of."""
    result = hampm("--check", "--quiet", FOLDER / f"{name}.nml")
    warned = [check["warned"] for check in checks_of(name).values() if "warned" in check]
    lines = result.stderr.splitlines()
    assert result.returncode == 0 and len(lines) == len(warned)
    assert all(words in line for words, line in zip(warned, lines))


@each_lesson
def test_commands_end_as_the_lesson_says(lesson_of, name):
    for block in lesson_of(name).blocks:
        for command, result in block.results:
            promised = re.search(r" *(# exit code (\d))?$", command)
            assert result.source.removeprefix("%%bash\n").startswith(command[:promised.start()])
            assert (f"|| test $? -eq {promised[2]}" in result.source) == bool(promised[2])
            assert not result.error, f"{command}\n{result.stderr}\n{result.error}"


@each_lesson
def test_the_picture_is_made(lesson_of, name):
    """And shown by a cell of the notebook, whose other cells say nothing but what commands print."""
    lesson = lesson_of(name)
    assert (lesson.folder / f"results/lessons/{name}.png").read_bytes().startswith(b"\x89PNG")
    assert [cell.source.count(f"{name}.png") for cell in lesson.cells if any("image/png" in item.get("data", {}) for item in cell.outputs)] == [1]
    assert not any(item.output_type == "error" for cell in lesson.cells for item in cell.outputs)


@each_lesson
def test_a_notebook_has_all_of_its_lesson(name):
    """Its text and its commands in their order; formulas and folded answers as Jupyter has them."""
    page = (FOLDER / f"{name}.md").read_text()
    notebook = notebook_of(page)
    texts = "\n".join(cell.source for cell in notebook.cells if cell.cell_type == "markdown")
    assert all(cell.cell_type == "code" or cell.source.count("<details>") == cell.source.count("</details>") for cell in notebook.cells)
    assert "```sh" not in texts and "```math" not in texts and "$`" not in texts
    folds = r"^</?details>$|^<summary>[^\n]*$"
    asked = re.sub(r"^```sh\n.*?^```$|^!\[[^\n]*$|^```math$|" + folds, "", page, flags=re.S | re.M)
    assert re.findall(r"\w+", re.sub(r"^!\[[^\n]*$|" + folds, "", texts, flags=re.M)) == re.findall(r"\w+", asked)


@each_lesson
def test_commands_print_what_the_lesson_shows(lesson_of, name):
    for block in lesson_of(name).blocks:
        if block.shown is not None:
            assert_same_text(block.results[-1][1].stdout, block.shown)


def assert_same_text(printed, shown):
    """The same words and, but for rounding, the same numbers; what is below 1e-20 is rounding itself."""
    for line, expected in zip(printed.splitlines(), shown.splitlines(), strict=True):
        assert len(line.split()) == len(expected.split()), line
        for word, wanted in zip(re.split(r"[\s,]+", line), re.split(r"[\s,]+", expected)):
            if re.fullmatch(NUMBER, wanted):
                assert float(word) == pytest.approx(float(wanted), rel=2e-3, abs=1.1 * unit_of(wanted) + 1e-20), line
            else:
                assert word == wanted, line


def unit_of(number):
    """The unit of the last digit of a number in words."""
    digits, _, power = number.partition("e")
    return 10.0 ** (int(power or 0) - len(digits.partition(".")[2]))


@pytest.mark.parametrize(("name", "key"), parameters(
    (name, key) for name in NAMES + SOLUTIONS
    for key, check in checks_of(name).items() if "measured" in check and (name in NAMES or "asked" in check)))
def test_what_is_measured_is_what_theory_asks(lesson_of, name, key):
    lesson = lesson_of(name)
    check = lesson.checks[key]
    measured, asked = lesson.value(check["measured"]), lesson.value(check["asked"])
    tolerance = lesson.value(check.get("atol", 0.0)) + lesson.value(check.get("rtol", 0.0)) * abs(asked)
    report = f"{name}: {key}: asked {asked:.6g} +- {tolerance:.2g}, measured {measured:.6g} ({check['source']})"
    print(f"\n{report}", end=" ")
    assert abs(measured - asked) <= tolerance, report


@pytest.mark.parametrize(("name", "key", "kind", "words"), parameters((name, *place) for name in NAMES + SOLUTIONS for place in said(name)))
def test_the_text_gives_that_number(lesson_of, name, key, kind, words):
    lesson, number = lesson_of(name), number_at(name, words)
    value = lesson.value(lesson.checks[key][kind])
    assert abs(float(number) - value) <= 0.75 * unit_of(number), f"{name}: {key}: {kind} is {value:.6g}"
