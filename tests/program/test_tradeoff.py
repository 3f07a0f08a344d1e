"""The trade-off study (bench/tradeoff.py) on a few coarse runs: what it measures, sustains, extrapolates and advises."""

import csv
import re
import sys

import numpy as np
import pytest

from paths import BENCH, PROGRAM

sys.path.insert(0, str(BENCH))

import tradeoff  # noqa: E402
from tables import rewrite  # noqa: E402
from tradeoff_matrix import YARDSTICK, Family  # noqa: E402
from tradeoff_tables import ADVICE, advice, answer, cheapest, curves, front, groups, written  # noqa: E402

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


def test_a_pair_is_extrapolated_and_costs_the_sum(rows):
    coarse, fine, both = (find(rows, f"uniform, {label}") for label in ("n = 4", "n = 8", "pair, n = 4, 8"))
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
def test_a_pair_or_triple_has_no_error_of_the_orders_that_it_removes(count, second):
    curve = [point(n, 1 - 0.1 / n + second / n**2) for n in (2, 3, 4, 6, 8, 12)]
    found = list(tradeoff.extrapolated(curve, count))
    assert [p.cells for p in found] == ([4, 6, 8, 12] if count == 2 else [8, 12])
    for p in found:
        assert tradeoff.error_of(p.curves["vcct"], "static") == pytest.approx(0, abs=1e-10)


def test_an_error_that_changes_its_sign_is_sustained_by_finer_cells():
    curve = [point(n, value) for n, value in ((2, 1.05), (4, 1.0), (8, 1.02), (16, 1.0))]
    rows = list(tradeoff.curve_rows("static", "", "", curve))[:4]
    assert [row["sustained_percent"] for row in rows] == ["5.0000", "2.0000", "2.0000", ""]


def test_the_advice_names_the_cheapest(rows):
    table = [dict(zip(ADVICE, row)) for row in advice(rows, (5,))[1:]]
    [best] = [row for row in table if row["cheapest"]]
    assert best["setting"] == cheapest(rows, 5)["name"]
    assert [row["times_cheaper"] for row in table if row["group"] == YARDSTICK] == ["1"]
    assert best["setting"] in [row[0] for row in front(rows)]
    assert ["overloaded", "failed", "failed", ""] in curves(rows)


def test_whole_tables_are_files_beside_the_page(rows, tmp_path):
    tables = {"static": (advice(rows, (5, 0.5)), front(rows), curves(rows))}
    page = written(tables, "<!-- answer -->\n<!-- end of answer -->\n", tmp_path, lambda name, lines, text: rewrite(name, lines, text, "page"))
    best = cheapest(rows, 5)
    assert f"| static | 5 % | {best['name']} | " in page and groups(tables["static"][0])[0].startswith("| group | cheapest setting |")
    for name, table in zip(("advice", "front", "families"), tables["static"]):
        with open(tmp_path / f"tradeoff_{name}.csv", newline="") as file:
            found = list(csv.reader(file))
        assert found == [["study", *table[0]], *(["static", *row] for row in table[1:])]


def test_the_page_has_the_rows_of_the_files_beside_it():
    """What stands in the docs is what the writer makes of the CSV files, and each setting that a text names by its particles is in them."""
    page, folder = tradeoff.DOCUMENT.read_text(), tradeoff.DOCUMENT.parent
    with open(folder / "tradeoff_advice.csv", newline="") as file:
        every = list(csv.DictReader(file))
    studies = {study: [ADVICE] + [[row[key] for key in ADVICE] for row in every if row["study"] == study] for study in tradeoff.STUDIES}
    again = rewrite("answer", answer(studies), page, "page")
    for study, table in studies.items():
        assert {row[0] for row in table[1:]} == {f"{limit:g}" for limit in tradeoff.STUDIES[study].accuracies}
    assert again == page
    with open(folder / "tradeoff_front.csv", newline="") as file:
        every += list(csv.DictReader(file))
    told = re.findall(r"([\d.]+) % with (\d+) particles in ([\d.]+) s", " ".join(page.split()))
    assert len(told) >= 3
    for error, particles, seconds in told:
        assert any(row["particles"] == particles and abs(abs(float(row["error_percent"])) - float(error)) <= 0.0051
                   and abs(float(row["cpu_seconds"]) - float(seconds)) <= 0.0051 for row in every), (error, particles, seconds)
