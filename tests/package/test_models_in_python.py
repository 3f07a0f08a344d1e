"""`Scene`: models read, changed, checked and written; keys as the program has them; mistakes told apart."""

import concurrent.futures
import copy
import json
import multiprocessing
import pickle
import re
import subprocess
import sys

import numpy as np
import pandas
import pytest

import hampm as package
from paths import ROOT


def test_groups_and_keys_are_attributes(plate, tmp_path):
    assert plate.grid.cell == 2e-3 and plate.grid.cells == [12, 14] and plate.grid.order is None
    assert [load.force[1] for load in plate.load] == [24e3, -24e3]
    plate.grid.set(cell=1e-3, cells=(24, 28))
    plate.load.add(kind="body", force=(0, 1))
    del plate.load[2]
    plate.method["time"] = "explicit"
    plate.material[0].poisson = None
    plate.write(tmp_path / "new.nml")
    again = package.Scene(tmp_path / "new.nml")
    assert again == plate and again.grid.cells == [24, 28] and again.material[0].poisson is None and len(again.load) == 2


@pytest.mark.parametrize("again", [copy.deepcopy, lambda given: pickle.loads(pickle.dumps(given))])
def test_models_and_errors_go_to_other_processes(plate, again):
    """`copy` and `pickle`, of which `multiprocessing` makes use: a copy is equal, is changed alone, and is refused in the same words."""
    other = again(plate)
    assert other == plate
    other.grid.cell = -1.0
    assert plate.grid.cell == 2e-3 and other.load[0].force is not plate.load[0].force
    with pytest.raises(package.ModelError) as refused:
        other.check()
    told = again(refused.value)
    assert (str(told), told.messages, told.exit_code) == (str(refused.value), refused.value.messages, 2) and "cell = -1" in str(told)


def solved(scene):
    """K_I of a model, in a process of a pool."""
    return scene.run(output=f"poisson {scene.material[0].poisson}", progress=False).value("K_I")[0]


@pytest.mark.parametrize("pool", [multiprocessing.Pool, concurrent.futures.ProcessPoolExecutor])
def test_models_run_in_a_pool(plate, tmp_path, monkeypatch, pool):
    monkeypatch.chdir(tmp_path)
    cases = [plate.with_settings({"material.poisson": poisson}) for poisson in (0.2, 0.3)]
    with pool(2) as workers:
        found = list(workers.map(solved, cases))
    assert found == [pytest.approx(package.History(tmp_path / f"poisson {poisson}/plate.h5").value("K_I")[0]) for poisson in (0.2, 0.3)]


@pytest.mark.parametrize("points", [np.array([[-4.1e-3, -1.3e-3], [3.7e-3, 2.2e-3]]), [(-4.1e-3, -1.3e-3), (3.7e-3, 2.2e-3)], zip((-4.1e-3, 3.7e-3), (-1.3e-3, 2.2e-3)),
                                    pandas.DataFrame({"x": [-4.1e-3, 3.7e-3], "y": [-1.3e-3, 2.2e-3]}), np.array([-4.1e-3, -1.3e-3, 3.7e-3, 2.2e-3])])
def test_points_are_arrays_or_pairs(plate, points):
    """Or flat, as the namelist has them; numbers of numpy are numbers."""
    other = plate.copy()
    other.crack[0].set(points=points)
    other.grid.set(cell=np.float64(2e-3), cells=np.array([12, 14], dtype=np.int32))
    assert other == plate and repr(other) == repr(plate) and all(type(value) is float for value in other.crack[0].points)
    assert package.Scene(text=repr(other)) == plate


def test_messages_name_the_line_that_the_user_has_written(plate, tmp_path):
    """Of the namelist where a key is of it, else of the program in Python; never that of a file that nobody has written."""
    plate.run.title = "another"
    plate.load[1].kind = "pull"; here = sys._getframe().f_lineno   # noqa: E702
    plate.material.add(name="stone", young=-1.0); there = sys._getframe().f_lineno   # noqa: E702
    del plate.body[0].upper
    for action in (plate.check, plate.copy().check, plate.run):
        with pytest.raises(package.ModelError) as error:
            action()
        found = {(m.file, m.line, m.group, m.key) for m in error.value.messages}
        assert {(__file__, here, "load", "kind"), (__file__, there, "material", "young"), (__file__, there, "material", "density")} <= found, error.value
        assert {file for file, *_ in found} <= {__file__, str(plate.path)}
    plate.load[1].kind, plate.crack[0].kind = "traction", "plane"
    del plate.material[1]
    plate.body[0].upper = 12e-3, 12e-3
    plate.grid.cell = None
    with pytest.raises(package.ModelError) as error:
        plate.check()
    assert f"{plate.path}:2: &grid" in str(error.value)


def test_a_result_is_replaced_only_with_force(plate, tmp_path):
    """As by the command."""
    first = plate.run(output=tmp_path, progress=False)
    before = first.path.stat().st_mtime_ns
    for again in (plate.run, lambda **options: package.run(plate, **options)):
        with pytest.raises(package.FileError, match="there is a result"):
            again(output=tmp_path, progress=False)
    assert first.path.stat().st_mtime_ns == before
    assert package.compare(first, plate.run(output=tmp_path, progress=False, force=True, settings={"run.title": "b"}), exact=True)
    assert first.path.stat().st_mtime_ns > before and plate.run.title == "a crack in a plate"


def test_a_model_is_drawn_before_it_runs(plate):
    """What is drawn is the model as it is, changed or not; a wrong one is refused in the words of check()."""
    assert [line.get_xydata().tolist() for line in plate.sketch().axes[0].lines if line.get_xydata().shape == (2, 2)][0] == [[-4.1e-3, -1.3e-3], [3.7e-3, 2.2e-3]]
    plate.crack[0].points = [(-5.1e-3, 1e-3), (4e-3, 1.5e-3)]
    figure = plate.sketch(grid=True, size="84mm")
    own = plate.sketch(grid=True)
    letters, of_own = ({text.get_fontsize() for text in one.findobj(lambda part: hasattr(part, "get_fontsize"))} for one in (figure, own))
    assert figure.get_figwidth() == pytest.approx(84 / 25.4) and max(letters) / max(of_own) == pytest.approx(figure.get_figwidth() / own.get_figwidth())
    box = figure.get_tightbbox()
    assert min(box.min) > 0 and all(box.max < figure.get_size_inches())          # nothing is cut off
    assert [-5.1e-3, 1e-3] in np.concatenate([line.get_xydata() for line in figure.axes[0].lines]).tolist()
    plate.grid.cell = -1.0
    with pytest.raises(package.ModelError, match=re.escape(__file__)):
        plate.sketch()


@pytest.mark.parametrize(("change", "said"), [
    (lambda s: setattr(s.grid, "cel", 1), "&grid has no key 'cel'; did you mean 'cell'?"), (lambda s: s.grib, "there is no group &grib; did you mean 'grid'?"),
    (lambda s: s.load[0].kin, "did you mean 'kind'"), (lambda s: s.add("grid"), "&grid may stand only once"), (lambda s: s.load.add(kinds="point"), "no key 'kinds'"),
    (lambda s: setattr(s, "grid", 1), "&grid is a group"), (lambda s: s.with_settings({"load.force": (0, 1)}), "there are 2 of &load"),
    (lambda s: s.with_settings({"grid.cel": 1}), "no key 'cel'"), (lambda s: package.Scene(text="&run en_time = 1.0 /"), "no key 'en_time'")])
def test_a_wrong_name_is_told_at_once(plate, change, said):
    before = str(plate)
    with pytest.raises((AttributeError, KeyError), match=said.replace("(", r"\(").replace("?", r"\?")):
        change(plate)
    assert str(plate) == before


def test_an_editor_is_told_groups_keys_and_choices(plate):
    """By dir(), and by annotations that are those of the program."""
    assert {"grid", "load", "energy_release", "check"} <= set(dir(plate)) and {"cell", "cells", "lower", "order"} <= set(dir(plate.grid))
    printed = subprocess.run([sys.executable, ROOT / "tools/python_groups.py"], capture_output=True, text=True, check=True).stdout
    assert (ROOT / "python/src/hampm/groups.py").read_text() == printed, "tools/python_groups.py > python/src/hampm/groups.py"
    from hampm import groups
    assert set(groups.Groups.__annotations__) == set(package.key_table())
    assert groups.Grid.__annotations__["cell"] == float | None
    assert (ROOT / "python/src/hampm/py.typed").exists()


def test_keys_for_programs_are_those_of_the_reference(hampm):
    """Types of values, and a default or an example of each type."""
    table, page = json.loads(hampm("--keys", "--json").stdout), hampm("--keys").stdout
    keys = [key for group in table for key in group["keys"]]
    assert page.count("\n| `") == len(keys) and page.count("\n## &") == len(table)
    kinds = {"real": (float, int), "integer": int, "logical": bool, "text": str}
    for key in keys:
        for value in (key["default"], key["example"]):
            values = value if isinstance(value, list) else [value]
            assert all(item is None or isinstance(item, kinds[key["type"]]) for item in values), key
            assert isinstance(value, list) == (key["most"] > 1) or value is None
        if key["fewest"] == 0:
            assert not key["default"], "an empty value is an unset one"


def test_a_model_is_checked(plate, hampm):
    """The numbers are those of the text of --check."""
    check = plate.check()
    text = hampm("--check", plate.path, timed=True).stdout
    assert f"! particles       {check.particles}\n" in text and f"! cells           {check.cells}, of which occupied {check.occupied_cells}\n" in text
    assert check.steps == 1 and check.samples == 2 and check.snapshots == 2 and 1e7 < check.memory < 1e9 and 0 < check.seconds < 60
    assert len(check.tips) == 2 and 0 < check.tips[0]["expected_errors"]["K"] < 1 and check.tips[0]["x"] == pytest.approx(3.7e-3)
    assert f"J {100 * check.tips[0]['expected_errors']['J']:.1f} %" in text and text.startswith(check.namelist)
    assert "expected errors" in str(check) and "<table>" in check._repr_html_()
    last = re.compile(r"! wall time +about \S+ s on this machine: 1 thread, .*\n$")
    quiet = hampm("--check", "--quiet", plate.path).stdout
    assert last.search(text) and last.sub("", text) == quiet and "seconds" not in json.loads(hampm("--check", "--json", "--quiet", plate.path).stdout)


def test_the_time_of_a_run_is_about_what_it_takes(hampm):
    """By a factor that leaves room for a busy machine."""
    from paths import DCB
    coarse = package.Scene(DCB).with_settings({"grid.cell": 2.5e-3, "grid.cells": (40, 5)})
    seconds = coarse.check().seconds
    taken = package.run(coarse, output=hampm.folder, progress=False)
    import h5py
    with h5py.File(taken.path) as file:
        assert 0.1 < seconds / file.attrs["wall_time"] < 10


def test_mistakes_are_told_apart(plate, tmp_path):
    """Each with file, line, group, key, value and reason; the same of a run."""
    text = plate.path.read_text().replace("cell = 2e-3", "cell = -2e-3").replace("fix", "fix").replace("'traction'", "'pull'")
    (tmp_path / "wrong.nml").write_text(text)
    wrong = package.Scene(tmp_path / "wrong.nml")
    for action in (wrong.check, lambda: package.run(wrong, output=tmp_path, progress=False)):
        with pytest.raises(package.ModelError) as error:
            action()
        found = {(m.file, m.line, m.group, m.key, m.value) for m in error.value.messages}
        assert (str(wrong.path), 2, "grid", "cell", "-2e-3") in found and (str(wrong.path), 5, "load", "kind", "'pull'") in found
        assert all(m.reason.startswith("must be") for m in error.value.messages) and error.value.exit_code == 2


SAID = [  # what is wrong -> what is told of it
    ("&grid cel = 1 /", {"line": 1, "group": "grid", "key": "cel", "value": "1"}), ("&nn /", {"line": 1, "group": "nn"}),
    ("&run end_time = 1e-6\n&grid cell = 1 /", {"line": 1, "group": "run"}), ("&run end_time 1.0 /", {"line": 1, "group": "run", "key": "end_time"}),
    ("&run end_time = 'a' /", {"line": 1, "group": "run", "key": "end_time", "value": "'a'"}), ("x\n&run /", {"line": 1}),
    ("&run /", {"group": "run", "key": "end_time", "line": 1}), ("", {"group": "grid"}),
    ("&run end_time = 1.0 /\n&method time = 'static' time_step = 1e-3 /", {"line": 2, "group": "method", "key": "time_step"})]


@pytest.mark.parametrize(("text", "told"), SAID)
def test_errors_for_programs_are_those_for_people(hampm, text, told):
    (hampm.folder / "a.nml").write_text(text)
    run, plain = hampm("--check", "--json", "a.nml"), hampm("--check", "a.nml")
    found = json.loads(run.stdout)
    assert found["program"] == "hampm" and re.fullmatch(r"\d+\.\d+\.\d+", found["version"]) and found["commit"] == found["commit"].strip()
    assert run.returncode == plain.returncode == 2 and found["valid"] is False and run.stderr == plain.stderr
    assert len(found["errors"]) == len(plain.stderr.splitlines()), plain.stderr
    assert any(told.items() <= error.items() and error["file"] == "a.nml" for error in found["errors"]), found
    assert all(line.endswith(error["reason"]) for line, error in zip(plain.stderr.splitlines(), found["errors"]))


def test_warnings_and_notes_for_programs_tell_where(plate, hampm):
    plate.with_settings({"refine.start": 1.0, "refine.indicator": "tip", "energy_release.radii": (3e-3, 4e-3, 5e-3)}).write(hampm.folder / "a.nml")
    text = (hampm.folder / "a.nml").read_text().replace("200000000000.0", "200.0")
    (hampm.folder / "a.nml").write_text(text)
    found, plain = json.loads(hampm("--check", "--json", "a.nml").stdout), hampm("--check", "a.nml")
    assert [f"! note: {note['reason']}" for note in found["notes"]] == [line for line in plain.stdout.splitlines() if line.startswith("! note")]
    assert [f"hampm: warning: {warning['reason']}" for warning in found["warnings"]] == plain.stderr.splitlines()
    lines = text.splitlines()
    units = next(note for note in found["warnings"] if "waves would pass" in note["reason"])
    assert units["group"] == "material" and lines[units["line"] - 1] == "&material" and units["file"] == "a.nml"
    start = next(note for note in found["warnings"] if "start" in note["reason"])
    assert (start["group"], start["key"], start["value"]) == ("refine", "start", "1.0") and lines[start["line"] - 1].strip().startswith("start")


def test_options_are_told(hampm, plate):
    found = json.loads(hampm("--check", "--json", plate.path, "--set", "grid.cell=-1").stdout)
    assert found["errors"][0]["option"] == "--set grid.cell=-1" and found["errors"][0]["key"] == "cell"


def test_json_is_asked_of_what_has_it(hampm, plate):
    run = hampm("--json", plate.path)
    assert run.returncode == 2 and "--json requires --check, --keys or --rules" in run.stderr


def test_texts_stay_what_they_are(hampm, plate):
    title = 'a "quote", an \'other\', a \\ and ä'
    plate.run.title = title
    plate.write(hampm.folder / "a.nml")
    assert package.Scene(text=json.loads(hampm("--check", "--json", "a.nml").stdout)["namelist"]).run.title == title


def test_an_error_is_asked(plate, tmp_path):
    """What the model leaves out is chosen; the model stays as it is. Its lattice may be missing, not without an error that is asked."""
    del plate.grid
    with pytest.raises(package.ModelError, match="grid"):
        package.run(plate, output=tmp_path, progress=False)
    history = package.run(plate, output=tmp_path, progress=False, accuracy={"K_I": 0.002, "K_II": 0.005})
    for quantity, error in (("K_I", 0.002), ("K_II", 0.005)):
        assert all(history[f"{quantity}_error{tip}"][-1] <= error * abs(history[f"{quantity}{tip}"][-1]) for tip in ("", "_tip2"))
    assert len(plate.accuracy) == 0
    with pytest.raises(package.ComputationError, match="not reached"):
        package.run(plate, output=tmp_path, progress=False, force=True, accuracy={"K_I": 1e-12})


def test_an_error_is_asked_of_a_sweep(plate, tmp_path):
    """Each case has cells of its own; the group is part of the model, and cases may set its keys."""
    del plate.grid
    sweep = package.Sweep(plate, {"accuracy.error": [0.05, 0.002]}, output=tmp_path, accuracy={"K_I": 0.01}).run(jobs=1, progress=False)
    assert not sweep.failures
    for settings, history in zip(sweep.cases.values(), sweep.histories().values(), strict=True):
        assert history["K_I_error"][-1] <= settings["accuracy.error"] * abs(history["K_I"][-1])
