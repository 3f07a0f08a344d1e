"""Columns that are derived from histories and from other columns."""

from types import SimpleNamespace

import numpy as np
import pytest

from hampm.batch.derived import derive, mistake
from hampm.errors import ResultError

T = np.array([0.0, 1.0, 2.0, 4.0])
HISTORY = SimpleNamespace(times=T, columns={"time": T, "K_I": np.array([0.0, 2.0, 6.0, 4.0]), "G": np.array([1.0, 1.0, 1.0, 1.0])},
                          units={"time": "s", "K_I": "Pa m^(1/2)", "G": "J/m2"})
ROW = {"growth.toughness": "4", "$n": "3", "K_I": 4.0, "blank": "", "name": "x"}


@pytest.mark.parametrize("text, value, unit", [
    ("first time K_I > 4", 1.5, "s"), ("first time K_I >= 0", 0.0, "s"), ("first time K_I > 7", "", "s"), ("first time K_I < 5", 0.0, "s"),
    ("max K_I", 6.0, "Pa m^(1/2)"), ("min K_I", 0.0, "Pa m^(1/2)"), ("last K_I", 4.0, "Pa m^(1/2)"), ("first G", 1.0, "J/m2"),
    ("mean K_I", (1.0 + 4.0 + 10.0) / 4, "Pa m^(1/2)"), ("mean K_I between 1 and 2", 4.0, "Pa m^(1/2)"), ("mean K_I between 0.5 and 1.5", 2.25, "Pa m^(1/2)"),
    ("max K_I between 0 and 1.5", 4.0, "Pa m^(1/2)"), ("mean K_I between 5 and 6", "", "Pa m^(1/2)"), ("K_I at 3", 5.0, "Pa m^(1/2)"), ("K_I at 9", "", "Pa m^(1/2)"),
    ("first time K_I > ${growth.toughness}", 1.5, "s"), ("mean K_I between ${n - 2} and 2.0d0", 4.0, "Pa m^(1/2)"), ("${K_I / growth.toughness}", 1.0, "1")])
def test_each_form(text, value, unit):
    assert mistake(text) == ""
    found, of = derive(text, HISTORY, ROW)
    assert (found == "" if value == "" else found == pytest.approx(value)) and of == unit


@pytest.mark.parametrize("text, message", [("max K_II", "no column 'K_II'; it has time, K_I, G"), ("${K_II}", "there is no K_II"), ("${blank}", "there is no blank"),
                                           ("${name}", "no number")])
def test_what_a_case_does_not_have(text, message):
    with pytest.raises(ResultError, match=message):
        derive(text, HISTORY, ROW)


@pytest.mark.parametrize("text", ["", "K_I", "maximum K_I", "first time K_I", "first time K_I = 3", "last K_I between 1 and 2", "mean K_I between 1", "max K_I + 1", "K_I at"])
def test_other_forms_are_mistakes(text):
    assert "is none of: first time COLUMN > NUMBER" in mistake(text)
