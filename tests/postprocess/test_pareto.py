"""The Pareto front of measured rows and the cheapest row of an accuracy, against all pairs of rows."""

import itertools
import random

import pytest

from pareto import cheapest, front, measured


def rows_of(*pairs):
    return [{"name": f"{number}", "s": cost, "e": error} for number, (cost, error) in enumerate(pairs)]


def names(rows):
    return [row["name"] for row in rows]


def dominated(row, rows):
    """Whether another row is no worse in both and better in one."""
    def no_worse(other):
        return other["s"] <= row["s"] and abs(other["e"]) <= abs(row["e"])
    return any(no_worse(other) and (other["s"], abs(other["e"])) != (row["s"], abs(row["e"])) for other in rows)


@pytest.mark.parametrize("seed", range(20))
def test_front_is_what_no_row_dominates(seed):
    """Costs and errors of few values, so that many rows share one of them."""
    pairs = list(itertools.product(range(1, 9), range(-8, 9)))
    rows = rows_of(*random.Random(seed).sample(pairs, 12))
    expected = {(row["s"], abs(row["e"])) for row in rows if not dominated(row, rows)}
    found = front(rows, "s", "e")
    assert [(row["s"], abs(row["e"])) for row in found] == sorted(expected)


def test_sign_of_an_error_does_not_count():
    assert names(front(rows_of((1, -3), (2, 2), (3, -2.5), (4, -1)), "s", "e")) == ["0", "1", "3"]


def test_equal_rows_appear_once():
    assert names(front(rows_of((1, 2), (1, -2), (1, 2)), "s", "e")) == ["0"]


def test_cheapest_is_the_least_cost_within_the_limit():
    rows = rows_of((5, 0.1), (1, -4), (3, -1), (3, 0.5), (2, 1.1))
    assert [cheapest(rows, "s", "e", limit)["name"] for limit in (5, 2, 1, 0.5, 0.1)] == ["1", "4", "3", "3", "0"]
    assert cheapest(rows, "s", "e", 0.05) is None and cheapest([], "s", "e", 1) is None


@pytest.mark.parametrize("nothing", ["", None, "nan", float("nan"), "failed", "inf"])
def test_rows_without_a_number_are_left_out(nothing):
    rows = [{"name": "run", "s": "2.5", "e": "-1e0"}, {"name": "a", "s": "1", "e": nothing}, {"name": "b", "s": nothing, "e": "0"}]
    assert names(measured(rows, "s", "e")) == names(front(rows, "s", "e")) == ["run"]
    assert cheapest(rows, "s", "e", 1)["name"] == "run"
