"""Scenes that run, but whose numbers mean something else than one may think: said by name, as a warning or a note, or refused."""

import re

import pytest
import base_case
from base_case import GOOD, LINE
from paths import ROOT

BODY = "  lower = 0.0, 0.0\n  upper = 0.1, 0.01\n"
SECOND = """/
&body
  material = 'aluminium'
  lower = {}
  upper = {}
/
&constraint
"""


def changed(text, old, new):
    """A scene after one replacement."""
    return base_case.changed((old, new), scene=text)


PLAIN = changed(GOOD, "  reference = 'dcb'\n", "  reference = 'none'\n")


def with_second(lower, upper, text=PLAIN):
    """The scene with a second body."""
    return changed(text, "/\n&constraint\n", SECOND.format(lower, upper))


def check(hampm, tmp_path, text):
    """--check of a scene."""
    (tmp_path / "scene.nml").write_text(text)
    return hampm("--check", "--quiet", "scene.nml")


def notes(result):
    return re.findall(r"^! note: (.*)$", result.stdout, re.MULTILINE)


def in_frame(text, frame):
    return changed(text, "  frame = 'updated'\n", f"  frame = '{frame}'\n")


def test_a_usual_scene_has_no_caveat(hampm, tmp_path):
    result = check(hampm, tmp_path, GOOD)
    assert result.returncode == 0, result.stderr
    assert result.stderr == ""
    assert notes(result) == []


# --- bodies -----------------------------------------------------------------------------------------------------------

# where the second body begins, in the direction away from the first, and whether it shares nodes with that
APART = [("0.0, 0.01025", True), ("0.0, 0.0111", True), ("0.0, 0.0114", False)]


@pytest.mark.parametrize("lower, shares", APART)
def test_bodies_that_do_not_touch_are_refused_in_the_total_frame(hampm, tmp_path, lower, shares):
    scene = changed(with_second(lower, "0.1, 0.013"), "cells = 80, 9", "cells = 80, 12")
    result = check(hampm, tmp_path, in_frame(scene, "total"))
    assert result.returncode == 2
    assert "the body must touch the others with &method frame = 'total'" in result.stderr
    assert "Use frame = 'updated'" in result.stderr


@pytest.mark.parametrize("lower, shares", APART)
def test_bodies_that_may_meet_are_told_when(hampm, tmp_path, lower, shares):
    scene = changed(with_second(lower, "0.1, 0.013"), "cells = 80, 9", "cells = 80, 12")
    result = check(hampm, tmp_path, in_frame(scene, "updated"))
    assert result.returncode == 0, result.stderr
    assert any("bodies interact from about a cell apart (0.00125 m) on" in note for note in notes(result))
    assert ("they act on each other from the start" in result.stderr) == shares


@pytest.mark.parametrize("frame", ["total", "updated"])
def test_bodies_that_touch_are_told_to_be_joined(hampm, tmp_path, frame):
    scene = changed(with_second("0.0, 0.01", "0.1, 0.013"), "cells = 80, 9", "cells = 80, 12")
    result = check(hampm, tmp_path, in_frame(scene, frame))
    assert result.returncode == 0, result.stderr
    assert notes(result) == ["bodies 1 and 2 touch: they are bonded, except along a &crack"]


def test_bodies_joined_by_a_third_that_comes_later_are_one(hampm, tmp_path):
    scene = with_second("0.0, 0.011", "0.1, 0.013", with_second("0.0, 0.01", "0.05, 0.011"))
    scene = changed(scene, "cells = 80, 9", "cells = 80, 12")
    result = check(hampm, tmp_path, in_frame(scene, "total"))
    assert result.returncode == 0, result.stderr
    assert notes(result)[0].startswith("bodies ")


def test_a_slot_narrower_than_a_cell_is_told(hampm, tmp_path):
    """A U of three bodies whose arms are a fifth of a cell apart."""
    scene = with_second("0.0, 0.01025", "0.1, 0.013", with_second("0.1, 0.0", "0.105, 0.013"))
    scene = changed(scene, "cells = 80, 9", "cells = 90, 12")
    result = check(hampm, tmp_path, in_frame(scene, "total"))
    assert result.returncode == 0, result.stderr
    assert "are 2.5e-4 m apart, but no whole cell is free between them" in result.stderr


# --- constraints ------------------------------------------------------------------------------------------------------

def test_a_constraint_beside_the_material(hampm, tmp_path):
    scene = changed(GOOD, "&damping", "&constraint\n  lower = 0.0, 0.01125\n  upper = 0.1, 0.01125\n  fix = 'y'\n/\n&damping")
    refused = check(hampm, tmp_path, in_frame(scene, "total"))
    assert refused.returncode == 2
    assert "must hold a node of a cell with material" in refused.stderr
    told = check(hampm, tmp_path, in_frame(scene, "updated"))
    assert told.returncode == 0, told.stderr
    assert "&constraint(2) holds no node of a cell with material" in told.stderr


def test_a_constraint_in_the_cells_of_a_body_is_none(hampm, tmp_path):
    """The body ends within the cells above 0.00875: a node at 0.01 holds it."""
    scene = changed(GOOD, "upper = 0.1, 0.01\n  points", "upper = 0.1, 0.0095\n  points").replace("upper = 0.0, 0.01\n",
                                                                                                  "upper = 0.0, 0.0095\n")
    scene = changed(scene, "&damping", "&constraint\n  lower = 0.0, 0.01\n  upper = 0.1, 0.01\n  fix = 'y'\n/\n&damping")
    for frame in "total", "updated":
        result = check(hampm, tmp_path, in_frame(scene, frame))
        assert result.returncode == 0, result.stderr
        assert "holds no node" not in result.stderr


# --- what is measured -------------------------------------------------------------------------------------------------

def test_one_particle_a_cell(hampm, tmp_path):
    result = check(hampm, tmp_path, changed(GOOD, "points_per_cell = 2", "points_per_cell = 1"))
    assert "G_vcct is 14 to 24 % off with points_per_cell = 1" in result.stderr


STEEL = "&material\n  name = 'steel'\n  young = 210e9\n  poisson = 0.3\n  density = 7850\n/\n&body"


@pytest.mark.parametrize("stiffness, told", [("210e9", True), ("70e9", False)])
def test_a_tip_between_two_materials(hampm, tmp_path, stiffness, told):
    """The upper half of a beam with a crack along its middle, of another material or of one with another name only."""
    scene = changed(LINE, "&body", STEEL.replace("210e9", stiffness))
    scene = re.sub(r"estimators = .*\n  radii.*", "estimators = 'vcct'", scene)
    assert ("the tip of the crack is between two materials" in upper_half(hampm, tmp_path, scene).stderr) == told


def upper_half(hampm, tmp_path, scene):
    """Split the body of a scene along its crack, and make the upper half of steel."""
    tip = re.search(r"tip = ([^,]+), (\S+)", scene)
    body = re.search(r"&body\n(.*?)/\n", scene, re.DOTALL)
    lower, upper = (re.search(rf"{key} = ([^,]+), (\S+)", body[1]) for key in ("lower", "upper"))
    first = body[0].replace(upper[0], f"upper = {upper[1]}, {tip[2]}")
    second = body[0].replace(lower[0], f"lower = {lower[1]}, {tip[2]}")
    second = re.sub(r"material = '\w+'", "material = 'steel'", second)
    return check(hampm, tmp_path, scene.replace(body[0], first + second))


# --- units ------------------------------------------------------------------------------------------------------------

@pytest.mark.parametrize("young, density, told", [
    ("70e9", "2700", False), ("1e5", "1000", False), ("1.2e12", "3500", False), ("1.0", "1.0", False),
    ("70e3", "2.7e-9", True), ("70e9", "2.7e-9", True), ("70", "2700", True), ("70e3", "2700", True), ("70e9", "2.7", True)])
def test_units_of_materials(hampm, tmp_path, young, density, told):
    scene = changed(GOOD, "young = 70e9", f"young = {young}").replace("density = 2700", f"density = {density}")
    result = check(hampm, tmp_path, scene.replace("rate = 1e4", "rate = 0"))
    assert result.returncode == 0, result.stderr
    assert any("young is in Pa, density in kg/m3" in text for text in re.findall("warning: (.*)", result.stdout + result.stderr)) == told


def test_units_of_lengths(hampm, tmp_path):
    text = """&run end_time=1 thickness=1/
&grid lower=0,0 cell=100 cells=80,9/
&material name='rock' young=70e9 density=2700/
&body material='rock' lower=0,0 upper=8000,900/
"""
    assert "&grid: it is 8000.0 m large; lengths are in m" in notes(check(hampm, tmp_path, text))
    assert notes(check(hampm, tmp_path, text.replace("100 ", "1 ").replace("8000,900", "80,9"))) == []


def test_notes_and_warnings_reach_who_runs(hampm, tmp_path):
    scene = changed(with_second("0.0, 0.01025", "0.1, 0.013"), "cells = 80, 9", "cells = 80, 12")
    (tmp_path / "scene.nml").write_text(in_frame(scene, "updated"))
    result = hampm("scene.nml", "--set", "run.end_time=1e-6", "--set", "output.snapshot_interval=0")
    assert result.returncode == 0, result.stderr
    assert "note: bodies interact from" in result.stdout
    assert "hampm: warning: bodies 1 and 2 are 2.5e-4 m apart" in result.stderr
    quiet = hampm("scene.nml", "--set", "run.end_time=1e-6", "--set", "output.snapshot_interval=0", "--quiet", "--force")
    assert "note:" not in quiet.stdout
    assert "hampm: warning: bodies 1 and 2" in quiet.stderr


def test_growth_in_motion(hampm, tmp_path):
    """The mass matrix and the scheme matter at the tip of a fast crack."""
    text = (ROOT / "input/freund_growth.nml").read_text()
    assert "a crack that grows" not in check(hampm, tmp_path, text).stdout
    lumped = check(hampm, tmp_path, changed(text, "mass = 'weighted'", "mass = 'lumped'"))
    assert "&method mass = 'lumped' with &growth law = 'prescribed': in explicit steps K of a tip at 0.6" in str(notes(lumped))
    early = check(hampm, tmp_path, changed(text, "mass = 'weighted'", "mass = 'weighted'  scheme = 'usavg'"))
    assert "stresses lag behind a growing tip" in early.stdout + early.stderr


@pytest.mark.parametrize("crack, estimator, advised", [("kind = 'symmetry'  tip = 0.05, 0.0  contact = 'friction'", "domain_integral", False),
                                                       ("kind = 'path'  points = 0.0, 0.004, 0.05, 0.004  contact = 'friction'", "domain_integral", True),
                                                       ("", "vcct", False), ("kind = 'line'  tip = 0.05, 0.005  direction = 1.0, 0.0  length = 0.05", "vcct", True)])
def test_no_advice_is_given_that_is_refused_itself(hampm, tmp_path, crack, estimator, advised):
    """Frictionless faces at a plane of symmetry, which has one, and an estimator where there is no crack."""
    text = f"""&run plane = 'strain'  end_time = 1.0 /
&grid lower = 0.0, 0.0  cell = 0.001  cells = 100, 10 /
&material name = 'm'  law = 'j2_plastic'  yield_stress = 1e8  young = 70e9  poisson = 0.3  density = 2700.0 /
&body material = 'm'  lower = 0.0, 0.0  upper = 0.1, 0.01 /
&constraint lower = 0.05, 0.0  upper = 0.1, 0.0  fix = 'xy' /
{f"&crack {crack} /" if crack else ""}
&method time = 'static' /
&energy_release estimators = '{estimator}' /
"""
    result = check(hampm, tmp_path, text)
    assert result.returncode == 2
    assert any(advice in result.stderr for advice in ("; use &crack", "; use 'domain_integral'")) == advised
