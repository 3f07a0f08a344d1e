"""Faults that are drawn to try the tests: of code alone, the same each time, one a line."""

import pytest
from mutants import CHANGES, code_of, draw, faults_of
from paths import ROOT


def test_faults_are_of_code():
    assert not faults_of("      real(dp) :: a = 1.0_dp + b", False)
    assert not faults_of("      ! a + b", False)
    assert code_of("x = 'a + b' ! c + d") == "x = ~~~~~~~ "
    assert faults_of("      a = b + c(i)", False) == [("sign", "      a = b - c(i)"), ("missing line", "      continue")]
    assert faults_of("      if (a < b) return", False) == [("condition", "      if (a >= b) return")]
    assert ("missing line", "      continue") not in faults_of("         + c*d", True)


@pytest.mark.verify
def test_the_draw_is_the_same_and_changes_a_line():
    drawn = draw(30, 7)
    assert drawn == draw(30, 7)
    kinds = {kind for kind, _, _ in CHANGES} | {"missing line"}
    for path, number, kind, new in drawn:
        assert kind in kinds and (ROOT / path).read_text().splitlines()[number] != new
