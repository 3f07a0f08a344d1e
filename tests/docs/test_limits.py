"""docs/reference/limits.md: its matrix of features is that of the table of rules, which the program keeps to."""

import sys

import pytest

from paths import DCB, PROGRAM, ROOT

sys.path.insert(0, str(ROOT / "tools"))

from feature_matrix import BEGIN, COLUMNS, END, NO, NOT_YET, TABLES, YES, Rules, matrix, of_program  # noqa: E402

PAGE = (ROOT / "docs/reference/limits.md").read_text()
KEYS = [{"group": "method", "required": False, "assumed": True, "keys": [{"key": "time", "choices": ["explicit", "implicit", "static"]},
                                                                        {"key": "frame", "choices": ["total", "updated"]},
                                                                        {"key": "mass", "choices": ["lumped", "fmpm"]}]},
        {"group": "growth", "required": False, "assumed": False, "keys": [{"key": "law", "choices": ["given", "slow"]}]},
        {"group": "energy_release", "required": False, "assumed": True, "keys": [{"key": "estimators", "choices": ["a", "b"]}]}]


def rule(subject, verdict, other, basis="mechanics"):
    return {"subject": subject, "verdict": verdict, "other": other, "basis": basis}


def test_the_page_has_the_matrix_of_the_rules():
    shown = PAGE.partition(BEGIN)[2].partition(END)[0].strip()
    assert shown == "\n".join(matrix(of_program(PROGRAM))).strip(), ".venv/bin/python tools/feature_matrix.py --write docs/reference/limits.md"


@pytest.mark.parametrize(("rules", "features", "verdict"), [
    ([], ("&method time = 'static'", "&method time = 'explicit'"), NO),
    ([], ("&method time = 'static'", "&growth"), YES),
    ([rule("&growth", "not allowed with", "&method time = 'static'", "not built")], ("&method time = 'static'", "&growth"), NOT_YET),
    # by what one requires
    ([rule("&growth", "requires", "&method frame = 'total'"), rule("&method frame = 'total'", "not allowed with", "&method time = 'static'", "not built")],
     ("&growth", "&method time = 'static'"), NOT_YET),
    # each value that is left is excluded
    ([rule("&growth", "not allowed with", "&method time = 'static' | 'implicit'"), rule("&method frame = 'total'", "not allowed with", "&method time = 'explicit'")],
     ("&growth", "&method frame = 'total'"), NO),
    # of a group that is not there no key has a value
    ([rule("&method time = 'static'", "not allowed with", "&growth law = 'given'"), rule("&method time = 'static'", "not allowed with", "&growth law = 'slow'")],
     ("&method time = 'static'", "&method frame = 'total'"), YES),
    ([rule("&method time = 'static'", "not allowed with", "&growth law = 'given'"), rule("&method time = 'static'", "not allowed with", "&growth law = 'slow'")],
     ("&method time = 'static'", "&growth"), NO),
    # one value of a list leaves the others open
    ([rule("&energy_release estimators = 'a' | 'b'", "not allowed with", "&growth")], ("&energy_release estimators = 'a'", "&growth"), NO),
    ([rule("&growth", "requires", "&energy_release estimators = 'b'")], ("&energy_release estimators = 'a'", "&growth"), YES),
    # a rule that has nothing to do with it says nothing of its reason
    ([rule("&method mass = 'fmpm'", "not allowed with", "&method time = 'static'", "not built"), rule("&growth", "not allowed with", "&method time = 'static'")],
     ("&growth", "&method time = 'static'"), NO)])
def test_what_rules_say_of_two_features(rules, features, verdict):
    assert Rules(rules, KEYS).verdict(*features) == Rules(rules, KEYS).verdict(*features[::-1]) == verdict


@pytest.mark.parametrize(("words", "table", "row", "column"), [
    (("method.time=implicit", "method.mass=fmpm"), "Time, cells and bodies", "mass: fmpm", "implicit"),
    (("method.time=explicit", "method.mass=fmpm"), "Time, cells and bodies", "mass: fmpm", "explicit")])
def test_the_program_says_the_same(hampm, words, table, row, column):
    said = hampm(DCB, "--check", "--set", "energy_release.energy_balance=.false.", "--set", "method.frame=total", "--set", "method.courant=0", *(f"--set={word}" for word in words))
    assert (said.returncode == 0) == (of_program(PROGRAM).verdict(TABLES[table][row], COLUMNS[column]) == YES), said.stderr
