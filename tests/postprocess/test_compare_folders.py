"""Comparing the results of two folders: cases, tolerances from a file, what is written for programs, and the recipe for continuous integration."""

import json
import os
import subprocess
import sys
import xml.etree.ElementTree as ET

import h5py
import numpy as np
import pytest

pytest.importorskip("yaml")

import hampm as package
from paths import BATCH, INPUT, PROGRAM
from synthetic import dcb, write_result


def changed(name, factor):
    return {**dcb(), name: dcb()[name] * factor}


@pytest.fixture
def folders(tmp_path):
    """Two folders with the same two cases, the second a part off: G_vcct_I by 1e-4."""
    for which in "ab":
        (tmp_path / which / "deep").mkdir(parents=True)
    for which, factor in (("a", 1.0), ("b", 1 + 1e-4)):
        write_result(tmp_path / which / "one.h5")
        write_result(tmp_path / which / "deep/two.h5", changed("G_vcct_I", factor))
    return tmp_path


@pytest.fixture
def compare(folders, script):
    def call(*options, rules=None):
        if rules is not None:
            (folders / "t.yaml").write_text(rules)
            options = ("--tolerances", folders / "t.yaml", *options)
        return script("compare.py", folders / "a", folders / "b", *options)
    return call


def test_each_case_is_told_with_the_columns_that_differ(compare):
    result = compare()
    assert result.returncode == 1
    lines = result.stdout.splitlines()
    assert lines[0] == "deep/two: 1 of 6 columns differ" and lines[2].split()[0] == "G_vcct_I" and lines[2].endswith("DIFFERS")
    assert lines[3:] == ["one: equal", "2 cases: 1 equal, 1 different"]
    assert "one" not in compare("--only-differences").stdout
    assert compare("--rtol", "1e-3").returncode == 0 and compare("--tolerance", "G_*=1e-3").returncode == 0
    assert compare("--ignore", "G_vcct_I").returncode == 0 and compare("--columns", "time", "G_vcct_I").returncode == 1


@pytest.mark.parametrize("rules, agrees", [
    ("rtol: 1e-3", True), ("rtol: 1e-5", False), ("columns: {'G_*': 1e-3}", True), 
    ("columns: {G_vcct_I: [0, 1e9]}", True), ("ignore: [G_vcct_I]", True), ("rtol: 1e-3\ncases: {deep/*: {rtol: 1e-6}}", False),
    ("cases: {deep/two: {columns: {G_vcct_I: 1e-3}}}", True), ("cases: {one: {columns: {G_vcct_I: 1e-3}}}", False),
    ("cases: {deep/*: {rtol: 1e-3}, '*two': {rtol: 1e-6}}", False), ("cases: {deep/two: {skip: is known}}", True)])
def test_tolerances_of_cases_and_columns(compare, rules, agrees):
    """The last that matches counts, and what is said of a case comes after what is said of all."""
    assert compare(rules=rules).returncode == (0 if agrees else 1)


@pytest.mark.parametrize("rules, message", [
    ("rtol: -1", "rtol: -1 is not a number >= 0"), ("rto: 1", "there is no rule 'rto'"), ("- 1", "rules are needed"), ("columns: [J]", "columns: names with tolerances"),
    ("columns: {J: [1, 2, 3]}", "columns: J: a relative tolerance is needed"), ("cases: {three: {rtol: 1}}", "no case 'three'; there are deep/two, one"),
    ("cases: {one: {skip: true}}", "cases: one: skip: a reason is needed"), ("columns: {K_I: 1e-3}", "no column 'K_I' in any case that it is for; they have G_stress"), ("ignore: [K_I]", "no column 'K_I'"),
    ("cases: {deep/*: {columns: {stp: 1}}}", "no column 'stp'"), ("cases: {one: {cases: {}}}", "there is no rule 'cases'"), ("a: [", "no YAML"),
    ("cases: [one]", "names of cases with rules")])
def test_mistakes_in_the_file_of_tolerances(compare, rules, message):
    result = compare(rules=rules)
    assert result.returncode == 2 and message in result.stderr and result.stderr.count("\n") == 1


def test_a_result_that_one_folder_lacks_is_a_difference(compare, folders):
    write_result(folders / "b/three.h5")
    (folders / "b/one.h5").unlink()
    (folders / "b/deep/two.h5").write_text("no result")
    lines = compare("--rtol", "1").stdout.splitlines()
    assert lines[1:] == ["one: missing in B", "three: missing in A", "3 cases: 3 in error"]
    assert lines[0].startswith("deep/two: ") and "cannot be read as HDF5" in lines[0]


def test_only_last_values(compare, folders):
    """The large difference in the middle does not count."""
    columns = dcb()
    columns["G_vcct_I"] = columns["G_vcct_I"] * (1 + 0.1 * (np.arange(1201) == 600))
    write_result(folders / "b/deep/two.h5", columns)
    assert compare().returncode == 1 and compare("--last").returncode == 0
    write_result(folders / "b/deep/two.h5", {name: values[::2] for name, values in columns.items()})
    assert compare().returncode == 1 and compare("--last").returncode == 0


def test_values_that_are_not_finite(compare, folders):
    columns = changed("crack_opening", np.nan)
    for which in "ab":
        write_result(folders / which / "deep/two.h5", columns)
    assert compare().returncode == 0
    result = compare("--finite")
    assert result.returncode == 1 and "not finite in B" in result.stdout
    write_result(folders / "b/deep/two.h5")
    assert "not finite in A" in compare().stdout


def test_what_is_found_is_written_for_programs(compare, folders):
    compare("--json", folders / "x.json", "--junit", folders / "x.xml", rules="cases: {one: {skip: '<known> & told'}}")
    found = json.loads((folders / "x.json").read_text())
    assert not found["agree"] and [(case["name"], case["verdict"]) for case in found["cases"]] == [("deep/two", "differs"), ("one", "skipped: <known> & told")]
    row, = [row for row in found["cases"][0]["columns"] if row["verdict"] != "equal"]
    assert row["column"] == "G_vcct_I" and row["relative"] == pytest.approx(1e-4, rel=1e-6) and row["allowed"] == pytest.approx(1e-9 * row["difference"] / row["relative"])
    suite = ET.parse(folders / "x.xml").getroot()
    assert {name: suite.get(name) for name in ("tests", "failures", "errors", "skipped")} == {"tests": "2", "failures": "1", "errors": "0", "skipped": "1"}
    two, one = suite
    assert (two.get("classname"), two.get("name")) == ("deep", "two") and "G_vcct_I" in two.find("failure").text
    assert two.find("failure").get("message") == "1 of 6 columns differ, G_vcct_I: DIFFERS by 1.0e-04"
    assert one.find("skipped").get("message") == "<known> & told"


def test_two_files_are_written_and_shortened_in_the_same_way(script, folders):
    files = folders / "a/deep/two.h5", folders / "b/deep/two.h5"
    result = script("compare.py", *files, "--only-differences", "--junit", folders / "x.xml")
    assert result.returncode == 1 and [line.split()[0] for line in result.stdout.splitlines()] == ["column", "G_vcct_I", "1"]
    assert ET.parse(folders / "x.xml").getroot().get("failures") == "1"


@pytest.fixture
def gate(tmp_path):
    def call(*words, program=PROGRAM):
        return subprocess.run([BATCH / "gate.sh", *words], cwd=tmp_path, capture_output=True, text=True,
                              env=os.environ | {"HAMPM": str(program), "HAMPM_PYTHON": sys.executable})
    return call


def test_a_gate_for_continuous_integration(gate, tmp_path):
    """References are stored, met, and not met by a changed model, one that fails and one that has none."""
    model = tmp_path / "a plate.nml"
    model.write_text((INPUT / "edge_crack.nml").read_text())
    words = "stored here", model.name
    stored = gate("--update", *words)
    assert stored.returncode == 0 and (tmp_path / "stored here/a plate.h5").exists(), stored.stderr
    with h5py.File(tmp_path / "stored here/a plate.h5") as file:
        assert sorted(file) == ["history", "input"] and file.attrs["program"] == "hampm"        # and no snapshots
    met = gate(*words)
    assert (met.returncode, met.stdout) == (0, "1 cases: 1 equal\n"), met.stderr
    model.write_text(model.read_text().replace("young = 200.0e9", "young = 201e9"))
    missed = gate(*words)
    assert missed.returncode == 1 and "a plate: " in missed.stdout and "1 cases: 1 different" in missed.stdout
    suite = ET.parse(tmp_path / "gate/gate.xml").getroot()
    assert suite.get("failures") == "1" and float(suite.find("testcase").get("time")) > 0
    (tmp_path / "t.yaml").write_text("rtol: 0.01\ncases: {a plate: {columns: {'reaction_*': [0, 1e-6], 'K_II*': [0, 1]}, ignore: [G_domain_II*, mode_mixity, '*_sliding']}}\n")
    assert gate("--tolerances", "t.yaml", *words).returncode == 0
    (tmp_path / "bad.nml").write_text("&run /\n")
    failed = gate("--tolerances", "t.yaml", *words, "bad.nml")
    assert failed.returncode == 1 and "bad: failed with exit code 2" in failed.stdout and "2 cases: 1 equal, 1 in error" in failed.stdout
    suite = ET.parse(tmp_path / "gate/gate.xml").getroot()
    bad = suite.find("testcase[@name='bad']")
    assert (suite.get("failures"), suite.get("errors")) == ("0", "1") and "end_time: is missing" in bad.find("system-out").text
    assert bad.find("error").get("message").startswith("failed with exit code 2: ")
    assert gate("--tolerances", "t.yaml", "--only", "a*", *words, "bad.nml").stdout == "1 cases: 1 equal\n"


def test_a_gate_takes_no_folder_of_others(gate, tmp_path):
    (tmp_path / "mine").mkdir()
    (tmp_path / "stored").mkdir()
    (tmp_path / "mine/x.h5").write_text("")
    refused = gate("--output", "mine", "stored", INPUT / "edge_crack.nml")
    assert refused.returncode == 2 and "has files of others" in refused.stderr and (tmp_path / "mine/x.h5").exists()


@pytest.mark.parametrize(("words", "said"), [
    ([], "required: REFERENCES, MODEL.nml"), (["--outptu", "x", "stored", "a.nml"], "unrecognized arguments"), (["none", "a.nml"], "there are no references"),
    (["--threads", "0", "stored", "a.nml"], "no whole number above zero"), (["--jobs", "two", "stored", "a.nml"], "no whole number"),
    (["--only", "b", "stored", "a.nml"], "no model has this name; there are a"), (["stored", "a.nml", "other/a.nml"], "two models have this name"),
    (["--update", "--propose", "t.yaml", "stored", "a.nml"], "not allowed with"), (["--update", "--tolerances", "t.yaml", "stored", "a.nml"], "is for a comparison"),
    (["--propose", "t.yaml", "stored", "a.nml"], "a: has no reference in stored")])
def test_a_request_that_makes_no_sense(gate, tmp_path, words, said):
    """Is told before a model is run."""
    for folder in ("stored", "other"):
        (tmp_path / folder).mkdir()
    for path in ("a.nml", "other/a.nml"):
        (tmp_path / path).write_text("")
    refused = gate(*words)
    assert refused.returncode == 2 and said in refused.stderr and not (tmp_path / "gate").exists()


def test_versions_and_new_warnings_are_told(gate, tmp_path):
    """Of another program, and what only it warns of."""
    model = tmp_path / "dcb.nml"
    scene = package.Scene(INPUT / "dcb.nml").with_settings({"grid.cell": 5e-3, "grid.cells": (20, 3), "run.end_time": 1e-4})
    scene.write(model)
    assert gate("--update", "stored", model.name).returncode == 0
    with h5py.File(tmp_path / "stored/dcb.h5", "a") as file:
        file.attrs["version"] = "1.0.0"
    assert gate("stored", model.name).stdout.splitlines()[0].startswith("A: hampm 1.0.0 (")
    scene.with_settings({"body.points_per_cell": 1}).write(model)
    warned = gate("stored", model.name)
    assert "(warnings)" in warned.stdout and "new in B: G_vcct is 14 to 24 % off" in warned.stdout
    assert json.loads((tmp_path / "gate/gate.json").read_text())["versions"]["a"][0].startswith("hampm 1.0.0")


@pytest.mark.parametrize(("name", "settings", "step"), [
    ("edge_crack", {}, "method.load_steps = 2"), ("dcb", {"grid.cell": 5e-3, "grid.cells": (20, 3), "run.end_time": 1e-4, "output.history_interval": 1e-5}, "method.courant = ")])
def test_tolerances_are_proposed(gate, tmp_path, name, settings, step):
    """From half the step and another number of threads; with them both runs agree, and a changed model does not."""
    scene = package.Scene(INPUT / f"{name}.nml").with_settings(settings)
    scene.write(tmp_path / "a.nml")
    assert gate("--update", "stored", "a.nml").returncode == 0
    proposed = gate("--propose", "t.yaml", "stored", "a.nml")
    text = (tmp_path / "t.yaml").read_text()
    assert proposed.returncode == 0 and proposed.stdout == "t.yaml\n" and step in text, proposed.stderr
    met = gate("--tolerances", "t.yaml", "--threads", "2", "stored", "a.nml")
    assert met.returncode == 0, met.stdout + text
    key, _, value = text.partition("halved by ")[2].splitlines()[0].partition(" = ")
    scene.with_settings({key: float(value) if "courant" in key else int(value)}).write(tmp_path / "a.nml")
    assert gate("--tolerances", "t.yaml", "stored", "a.nml").returncode == 0
    scene.with_settings({"material.young": 1.1 * scene.material[0].young}).write(tmp_path / "a.nml")
    assert gate("--tolerances", "t.yaml", "stored", "a.nml").returncode == 1
    assert gate("--propose", "t.yaml", "stored", "a.nml").returncode == 4
