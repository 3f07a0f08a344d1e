"""What docs/evidence/figure_10.md takes from the paper."""

import csv
import re

import pytest

from paths import ROOT


def test_values_of_the_paper_are_those_of_its_text():
    """Errors of the page's table, above and below the beam on an elastic foundation, (1 + 2/3 D/a)**2."""
    page = (ROOT / "docs/evidence/figure_10.md").read_text()
    with open(ROOT / "docs/evidence/figure_10_paper.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [(row["curve"], row["case"], row["error_percent"]) for row in rows] == re.findall(r"^\| (.*?) \| `fig10_(\w+)\.nml` \| (\d+) % \|", page, re.MULTILINE)
    for row in rows:
        for column, sign in (("g_if_below", -1), ("g_if_above", 1)):
            assert float(row[column]) == pytest.approx((1 + 2 / 3 * 10 / 50)**2 * (1 + sign * float(row["error_percent"]) / 100), abs=1e-3)
