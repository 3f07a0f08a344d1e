"""The trade-off study (bench/tradeoff.py) on a few coarse runs: what it measures, sustains, extrapolates and advises."""

import sys

import numpy as np
import pytest

from paths import BENCH, PROGRAM

sys.path.insert(0, str(BENCH))

import tradeoff  # noqa: E402
from tradeoff_matrix import YARDSTICK, Family  # noqa: E402
from tradeoff_tables import advice, cheapest, curves, front  # noqa: E402

pytestmark = pytest.mark.xdist_group("test_tradeoff")  # which share the runs of a fixture
FAMILIES = [Family(YARDSTICK, "uniform", {}, (2, 4, 8)), Family(YARDSTICK, "overloaded", {"material.law": "neo_hookean", "load.force": "0, 1e9"}, (2, 4)),
            Family("refined at the tip", "tip", {"refine.indicator": "tip", "refine.max_level": 1}, (2, 4), 2)]


@pytest.fixture(scope="module")
def rows(tmp_path_factory):
    folder = tmp_path_factory.mktemp("tradeoff")
    measured = tradeoff.measure(tradeoff.Program(PROGRAM, folder), "static", FAMILIES, 1)
    tradeoff.save(tradeoff.rows_of("static", FAMILIES, measured), "static", folder)
    return tradeoff.load("static", folder)


def find(rows, name, estimator="vcct"):
    [row] = [row for row in rows if row["name"] == name and row["estimator"] == estimator]
    return row


def test_errors_are_those_of_the_runs(rows):
    """The crack of the cells is 0.22 of a cell short, and G goes as its length squared, nearly: 2 * 0.22 c/a and less, c/a = 1/5n."""
    for n in (2, 4, 8):
        row = find(rows, f"uniform, n = {n}")
        assert float(row["error_percent"]) == pytest.approx(-100 * 2 * 0.22 / (5 * n), rel=0.5)
        assert int(row["particles"]) == 40 * n * n
        assert float(row["cpu_seconds"]) > 0


def test_a_batch_is_extrapolated_and_costs_the_sum(rows):
    coarse, fine, both = (find(rows, f"uniform, {label}") for label in ("n = 4", "n = 8", "batch of 2, n = 4, 8"))
    assert float(both["cpu_seconds"]) == pytest.approx(float(coarse["cpu_seconds"]) + float(fine["cpu_seconds"]), rel=1e-2)
    assert abs(float(both["error_percent"])) < 0.5 * abs(float(fine["error_percent"]))


def test_runs_that_fail_are_told_and_confirm_nothing(rows):
    row = find(rows, "overloaded, n = 4")
    assert row["error_percent"] == "" and row["sustained_percent"] == ""
    assert "step" in row["message"]


def test_the_finest_of_a_family_does_not_count(rows):
    assert find(rows, "uniform, n = 8")["sustained_percent"] == ""
    assert float(find(rows, "uniform, n = 4")["sustained_percent"]) == -float(find(rows, "uniform, n = 4")["error_percent"])


def point(n, value):
    """A point of a curve whose G is this multiple of the converged one."""
    curves = {name: np.array([value * tradeoff.CONVERGED]) for name in tradeoff.STUDIES["static"].estimators}
    return tradeoff.Point(f"n = {n}", n, "", 1, 1.0, (1.0,), curves, "")


@pytest.mark.parametrize(("count", "second"), [(2, 0.0), (3, 0.3)])
def test_a_batch_has_no_error_of_the_orders_that_it_removes(count, second):
    curve = [point(n, 1 - 0.1 / n + second / n**2) for n in (2, 3, 4, 6, 8, 12)]
    found = list(tradeoff.batches(curve, count))
    assert [p.cells for p in found] == ([4, 6, 8, 12] if count == 2 else [8, 12])
    for p in found:
        assert tradeoff.error_of(p.curves["vcct"], "static") == pytest.approx(0, abs=1e-10)


def test_an_error_that_changes_its_sign_is_sustained_by_finer_cells():
    curve = [point(n, value) for n, value in ((2, 1.05), (4, 1.0), (8, 1.02), (16, 1.0))]
    rows = list(tradeoff.curve_rows("static", "", "", curve))[:4]
    assert [row["sustained_percent"] for row in rows] == ["5.0000", "2.0000", "2.0000", ""]


def test_the_advice_names_the_cheapest(rows):
    table = advice(rows, (5,))
    assert sum("**" in line for line in table) == 1
    assert any(line.startswith(f"| 5 % | {YARDSTICK} | ") and line.endswith(" 1 |") for line in table)
    best = cheapest(rows, 5)
    assert f"**{best['name']}**" in "".join(table)
    assert best["name"] in "".join(front(rows))
    assert "| overloaded | failed | failed |  |" in curves(rows)
