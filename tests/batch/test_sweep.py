"""The cases that a sweep declares, and what is said of a declaration that makes no sense."""

import re
import subprocess
import sys

import pytest

pytest.importorskip("yaml")

from hampm.batch.case import result_of
from hampm.batch.declaration import case_name, namelist_keys, read_sweep
from hampm.errors import UNREADABLE, USAGE, ResultError
from paths import BATCH, INPUT, PROGRAM
from scene import HEAD, write_sweep


@pytest.fixture
def declared(tmp_path):
    """The sweep that a text declares, behind the scene and the folder."""
    return lambda text: read_sweep(write_sweep(tmp_path, HEAD + text))


def settings(sweep):
    return list(sweep.cases.values())


def test_a_product_is_every_value_with_every_other_one(declared):
    sweep = declared("product: {grid.cell: [1.0, 0.5], method.mass: [lumped, consistent, fmpm]}")
    assert settings(sweep) == [{"grid.cell": cell, "method.mass": mass}
                               for cell in ("1.0", "0.5") for mass in ("lumped", "consistent", "fmpm")]


def test_keys_change_together(declared):
    sweep = declared("product:\n  grid.cell, grid.cells: [[1.0, [8, 4]], [0.5, [16, 8]]]\n  method.mass: [lumped, consistent]")
    assert settings(sweep)[::2] == [{"grid.cell": "1.0", "grid.cells": "8,4", "method.mass": "lumped"},
                                    {"grid.cell": "0.5", "grid.cells": "16,8", "method.mass": "lumped"}]
    assert sweep.keys == ["grid.cell", "grid.cells", "method.mass"]


def test_a_list_stands_beside_the_product(declared):
    sweep = declared("product: {method.mass: [lumped, consistent]}\ncases:\n- {method.scheme: usl}\n- {Body(1).Velocity: [1, -2]}")
    assert settings(sweep) == [{"method.mass": "lumped"}, {"method.mass": "consistent"}, {"method.scheme": "usl"},
                               {"body(1).velocity": "1,-2"}]


def test_an_error_is_asked_of_all_cases(declared):
    """As a group of its own; cases may ask for less."""
    sweep = declared("accuracy: {K_I: 0.01}\nproduct: {crack.tip: [[1, 0], [2, 0]]}\ncases: [{accuracy.error: 0.1}]")
    assert [(case["accuracy.quantity"], case["accuracy.error"]) for case in settings(sweep)] == [("K_I", "0.01"), ("K_I", "0.01"), ("K_I", "0.1")]


def test_values_are_taken_as_they_are_written(declared):
    """YAML would make numbers and truth values of them."""
    sweep = declared("cases:\n- {run.title: no, run.end_time: 1.50e-3, grid.cells: 010}")
    assert settings(sweep) == [{"run.title": "no", "run.end_time": "1.50e-3", "grid.cells": "010"}]


def test_names_say_what_a_case_sets_and_stay_when_cases_are_added(declared):
    before = declared("product: {grid.cell: [1.0], method.mass: [lumped]}")
    after = declared("product: {grid.cell: [0.5, 1.0], method.mass: [consistent, lumped]}\ncases: [{run.end_time: -1}]")
    name, = before.cases
    assert name.startswith("cell-1.0_mass-lumped_") and name in after.cases
    assert len(set(after.cases)) == 5


def test_names_and_labels_have_what_varies_only(declared):
    """What all cases have in common, or what `set` makes of it, is not in them; keys whose last parts are the same are named whole."""
    sweep = declared("product: {grid.cell: [1.0, 0.5], method.frame: [total]}\nset: {method.mass: lumped, grid.cells: ['${8/grid.cell}', 4]}")
    assert [name[:-9] for name in sweep.cases] == ["cell-1.0", "cell-0.5"] and [sweep.label(name) for name in sweep.cases] == ["cell=1.0", "cell=0.5"]
    assert settings(sweep)[1] == {"grid.cell": "0.5", "method.frame": "total", "method.mass": "lumped", "grid.cells": "16,4"}
    sweep = declared("product: {load(1).rise_time: [1, 2], load(2).rise_time: [3, 4]}")
    assert next(iter(sweep.cases)).startswith("load1.rise_time-1_load2.rise_time-3_") and sweep.label(next(iter(sweep.cases))) == "load(1).rise_time=1 load(2).rise_time=3"


def test_names_follow_from_what_all_cases_have_in_common(declared):
    """The number at the end of a name is of all settings: with another value of `set` a case is another one, with a folder of its own."""
    names = [set(declared(f"product: {{grid.cell: [1.0, 0.5]}}\nset: {{run.end_time: {end}}}").cases) for end in (1.0, 2.0, "'${3 * grid.cell}'")]
    assert len(set.union(*names)) == 6


def test_own_names_and_arithmetic(declared):
    """Own names are columns of the table, and hampm is not given them."""
    sweep = declared("product: {$n: [4, 8], method.mass: [lumped]}\nset:\n  grid.cell: ${8.0 / n}\n  grid.cells: ['${n}', '${n/2}']\n"
                     "cases:\n- {grid.cell: 3, $n: '${grid.cell + 1}'}")
    assert settings(sweep) == [{"method.mass": "lumped", "grid.cell": "2", "grid.cells": "4,2"}, {"method.mass": "lumped", "grid.cell": "1", "grid.cells": "8,4"},
                               {"grid.cell": "3", "grid.cells": "4,2"}]
    assert sweep.keys[0] == "$n" and [sweep.values(name)["$n"] for name in sweep.cases] == ["4", "8", "4"]
    assert [name[:-9] for name in sweep.cases] == ["n-4_mass-lumped", "n-8_mass-lumped", "n-4_cell-3"]


def test_folders_follow_names(declared, tmp_path):
    """A case that is named otherwise, since something else varies, keeps what it has computed, unless somebody runs it."""
    sweep = declared("product: {grid.cell: [1.0, 0.5], method.mass: [lumped]}")
    for name in sweep.cases:
        sweep.folder(name).mkdir(parents=True)
        (sweep.folder(name) / f"{name}.h5").write_text(name)
    other = declared("product: {grid.cell: [1.0, 0.5], method.mass: [lumped, consistent]}")
    lumped = [name for name, values in other.cases.items() if values["method.mass"] == "lumped"]
    held = subprocess.Popen([sys.executable, "-c", "import fcntl, sys; f = open(sys.argv[1], 'w'); fcntl.lockf(f, fcntl.LOCK_EX); print(flush=True); input()",
                             next(iter(map(sweep.folder, sweep.cases))) / "lock"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    held.stdout.readline()
    other.adopt()
    assert [other.folder(name).exists() for name in lumped] == [False, True]
    held.communicate("\n")
    other.adopt()
    assert [result_of(other.folder(name)).read_text() for name in lumped] == list(sweep.cases)
    assert len(list((tmp_path / "out/cases").iterdir())) == 2


@pytest.mark.parametrize("value", ["a/b", "..", "it's $HOME", "x" * 300, "a b,c=d:e", "\u00e9"])
def test_names_are_names_of_files_whatever_the_value(value):
    name = case_name({"run.title": value})
    assert set(name) <= set("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789.+-_") and len(name) < 100
    assert name != case_name({"run.title": value + "!"})


def test_defaults(declared, tmp_path):
    sweep = declared("cases: [{method.mass: consistent}]")
    assert (sweep.columns, sweep.mean, sweep.threads, sweep.memory, sweep.runtime, sweep.checkpoint) == \
        (("*",), None, 1, None, 60, 600)
    assert (sweep.namelist, sweep.output) == (tmp_path / "flight.nml", tmp_path / "out")


MISTAKES = {
    "key of the sweep": ("produkt: {a: b}", ":3: a sweep has no key 'produkt'; did you mean 'product'?"),
    "group": ("product: {gird.cell: [1]}", ":3: 'gird.cell': hampm has no group &gird; did you mean 'grid'?"),
    "namelist key": ("product:\n  grid.cel: [1]", ":4: 'grid.cel': &grid has no key 'cel'; did you mean 'cell'?"),
    "old name of a key": ("cases: [{method.functions: cpdi}]", ":3: 'method.functions': &method has no key 'functions'; it is called shape_functions now"),
    "namelist key of a case": ("cases:\n- {method.mass: consistent}\n- {method.mas: consistent}", ":5: 'method.mas': &method has no key 'mas'"),
    "no group": ("product: {cell: [1]}", ":3: 'cell': a key is GROUP.KEY, such as grid.cell"),
    "result file": ("cases: [{output.file: a.h5}]", ":3: 'output.file': the results of a sweep are named by their folders"),
    "unequal lengths": ("product:\n  grid.cell, grid.cells: [[1.0, [8, 4]], [0.5]]",
                        ":4: grid.cell, grid.cells: [0.5]: each value is a list of 2, one for each key"),
    "no list": ("product: {grid.cell: 1}", ":3: grid.cell: a list of values is needed, such as [1e-3, 2e-3]"),
    "list of the list": ("product: {grid.cells: [[[1, 2], 3]]}",
                         ":3: grid.cells: [[1, 2], 3]: a value is a number, a name or a list"),
    "one key twice": ("product: {grid.cell: [1], 'grid.cell, grid.cells': [[1, 2]]}", ":3: product: 'grid.cell' stands in two"),
    "repeated key": ("product: {grid.cell: [1]}\nproduct: {grid.cells: [1]}", ":4: 'product' stands twice"),
    "no cases": ("columns: [J]", ":1: there are no cases: 'product' or 'cases' is needed"),
    "duplicate": ("product: {method.mass: [consistent]}\ncases:\n- {method.mass: consistent}",
                  ":5: the case method.mass=consistent is there already"),
    "number": ("cases: [{method.mass: consistent}]\nthreads: two", ":4: threads: two: one whole number is needed, above 0"),
    "negative": ("cases: [{method.mass: consistent}]\ncheckpoint: -1", ":4: checkpoint: -1: one number is needed, 0 or more"),
    "columns": ("cases: [{method.mass: consistent}]\ncolumns: [[J]]", ":4: columns: a list of names is needed"),
    "set": ("product: {grid.cell: [1]}\nset: [1]", ":4: set: keys with values are needed"),
    "key of set": ("product: {grid.cell: [1]}\nset: {grid.cel: 1}", ":4: 'grid.cel': &grid has no key 'cel'"),
    "errors of two columns": ("accuracy: {K_I: 0.1, J: 0.1}\nproduct: {grid.cell: [1]}", ":3: accuracy: a column with its error is needed, such as"),
    "no error": ("accuracy: K_I\nproduct: {grid.cell: [1]}", ":3: accuracy: a column with its error is needed, such as"),
    "own name": ("product: {$1: [1]}", ":3: '$1': a name of one's own is $ and letters"),
    "no such name": ("product: {grid.cell: ['${n}']}", ":3: grid.cell: ${n}: the case has no $n; it has grid.cell"),
    "depends on itself": ("product: {$n: ['${m}'], $m: ['${n}'], grid.cell: [1]}", ":3: $n: ${m}: ${n}: $n depends on itself"),
    "expression of a case": ("cases:\n- {grid.cell: 1}\n- {grid.cell: '${1/0}'}", ":5: grid.cell: ${1/0}: division by zero"),
    "open expression": ("product: {grid.cell: ['${1']}", ":3: grid.cell: ${1: an expression is not closed"),
    "derived": ("product: {grid.cell: [1]}\nderived: {a: maximum K_I}", ":4: derived: a: 'maximum K_I' is none of: first time"),
    "name of a derived one": ("product: {grid.cell: [1]}\nderived: {a.b: max K_I}", ":4: derived: 'a.b': a name is of letters"),
    "derived ones": ("product: {grid.cell: [1]}\nderived: [max K_I]", ":4: derived: names with texts are needed"),
    "YAML": ("product: [", ": no YAML: "),
}


@pytest.mark.parametrize("name", MISTAKES)
def test_a_mistake_is_named_with_its_line_and_what_would_be_right(declared, tmp_path, name):
    text, message = MISTAKES[name]
    with pytest.raises(ResultError) as error:
        declared(text)
    first = str(error.value).splitlines()[0]
    assert first.startswith(f"{tmp_path / 'sweep.yaml'}:") and message in first


def test_all_mistakes_are_named_at_once(declared):
    with pytest.raises(ResultError) as error:
        declared("product: {gird.cell: [1]}\ncases: [{method.mas: consistent}]\nthreads: 0")
    assert len(str(error.value).splitlines()) == 3


def test_what_is_missing_is_named(tmp_path):
    path = tmp_path / "sweep.yaml"
    path.write_text("namelist: none.nml\ncases: [{method.mass: consistent}]\n")
    with pytest.raises(ResultError) as error:
        read_sweep(path)
    assert "output: a path is needed" in str(error.value)
    assert f":1: namelist: there is no file {tmp_path / 'none.nml'}" in str(error.value)
    with pytest.raises(ResultError) as error:
        read_sweep(tmp_path / "no.yaml")
    assert error.value.exit_code == UNREADABLE


@pytest.mark.parametrize("name", ["table.csv", "table.h5", "progress"])
@pytest.mark.parametrize("link", [False, True])
def test_a_sweep_does_not_replace_the_namelist(tmp_path, name, link):
    """Nor where its own name is that of a link to it."""
    path = write_sweep(tmp_path, f"namelist: {name}\noutput: .\ncases: [{{method.mass: consistent}}]\n")
    (tmp_path / name).symlink_to(tmp_path / "flight.nml") if link else (tmp_path / "flight.nml").rename(tmp_path / name)
    with pytest.raises(ResultError, match="would be replaced by what the sweep writes"):
        read_sweep(path)


LAUGHS = "".join(f"{b}: &{b} [{', '.join(9 * [f'*{a}'])}]\n" for a, b in zip("abcdefgh", "bcdefghi"))


@pytest.mark.parametrize("text", [f"a: &a [1]\n{LAUGHS}product: {{grid.cell: *i}}", f"a: &a {{grid.cell: 1}}\n{LAUGHS}cases: *i",
                                  f"a: &a '{100_000 * 'x'}'\nproduct: {{run.title: [{', '.join(1000 * ['*a'])}]}}"], ids=["values", "cases", "texts"])
def test_aliases_do_not_fill_the_memory(declared, text):
    """A file of some lines may stand for more than there is room for."""
    with pytest.raises(ResultError, match="aliases make too much of this file"):
        declared(text)


def test_aliases_are_what_they_stand_for(declared):
    sweep = declared("product: {grid.cell: &sizes [1.0, 0.5], method.order: [2]}\ncases: [{grid.cell: &one 2.0}, {grid.cell: *one, method.order: 3}]")
    assert [case["grid.cell"] for case in settings(sweep)] == ["1.0", "0.5", "2.0", "2.0"]


def test_keys_have_the_units_of_the_program(declared):
    """For the table; a number of a group does not matter, and what has none is 1."""
    sweep = declared("cases: [{grid.cell: 1, body(1).velocity: '1,0', material.density: 2, method.courant: 0.1, growth.toughness: 3}]")
    assert sweep.units == {"grid.cell": "m", "body(1).velocity": "m/s", "material.density": "kg/m3", "method.courant": "1", "growth.toughness": "J/m2"}


def test_every_key_of_every_group_can_be_swept(declared):
    """Those of groups that a model need not have, such as &growth and &cohesive, as well; but for the name of the result."""
    groups = namelist_keys(PROGRAM)
    keys = [f"{group}.{key}" for group, of in groups.items() for key in of if (group, key) != ("output", "file")]
    printed = subprocess.run([PROGRAM, "--keys"], check=True, capture_output=True, text=True).stdout
    assert len(keys) + 1 == len(re.findall(r"^\| `", printed, re.MULTILINE)) and {"growth", "cohesive", "contact", "damping"} <= set(groups)
    assert declared("cases:\n" + "".join(f"- {{{key}: 1}}\n" for key in keys)).keys == keys


def test_the_command_lists_the_cases(tmp_path):
    path = write_sweep(tmp_path, HEAD + "product: {method.mass: [lumped, consistent]}")
    result = subprocess.run([sys.executable, BATCH / "sweep.py", path], capture_output=True, text=True)
    assert [line.split()[1:] for line in result.stdout.splitlines()] == [["method.mass=lumped"], ["method.mass=consistent"]]
    path.write_text(HEAD)
    assert subprocess.run([sys.executable, BATCH / "sweep.py", path], capture_output=True).returncode == USAGE


@pytest.mark.parametrize("path", sorted(INPUT.glob("*.yaml")), ids=lambda path: path.name)
def test_the_sweeps_of_input_make_sense(path):
    assert read_sweep(path).cases
