"""Studies of convergence: groups, errors, orders, extrapolated values and the figure, from tables of values that are known."""

import csv
import math

import numpy as np
import pytest

import study
from paths import ROOT

LIMIT = 2.0


@pytest.fixture
def table(tmp_path):
    """A table of a sweep from rows."""
    def write(rows):
        path = tmp_path / "table.csv"
        with open(path, "w", newline="") as file:
            out = csv.DictWriter(file, list(dict.fromkeys(key for row in rows for key in row)), restval="")
            out.writeheader()
            out.writerows(rows)
        return path
    return write


def rows(order=2.0, cells=(0.4, 0.2, 0.1), masses=("lumped", "consistent"), coefficient=0.5):
    """Values LIMIT + c h^p on cells of these sizes, with another coefficient for each mass matrix."""
    return [{"case": f"{mass}-{cell}", "grid.cell": cell, "grid.cells": f"{round(4 / cell)},{round(2 / cell)}", "method.mass": mass, "method.solver": f"of {mass}",
             "method.frame": "total", "particles": round(8 / cell**2), "cpu_seconds": 0.01 / cell**3, "K": LIMIT + (k + 1) * coefficient * cell**order, "exact": LIMIT}
            for k, mass in enumerate(masses) for cell in cells]


def written(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


@pytest.mark.parametrize("cells", [(0.4, 0.2, 0.1), (0.3, 0.2, 0.15), (0.5, 0.4, 0.1)])
@pytest.mark.parametrize("order", [0.5, 1.0, 2.0, 4.0])
def test_the_order_and_the_limit_of_three_values(cells, order):
    """Also where sizes are not in one ratio."""
    found, limit = study.richardson(cells, [LIMIT - 3 * cell**order for cell in cells])
    assert found == pytest.approx(order, rel=1e-6) and limit == pytest.approx(LIMIT, rel=1e-9)


@pytest.mark.parametrize("values", [[1, 2], [1, 2, 1.5], [1, 1, 1], [1, 2, 4], [1.0, math.nan, 2]])
def test_what_does_not_tend_to_a_limit_has_none(values):
    found = study.richardson([0.4, 0.2, 0.1][:len(values)], values)
    assert all(map(math.isnan, found))


def test_groups_errors_and_orders(script, table, tmp_path):
    """Keys that follow from others are no reason for another group; the reference is a number, a column or each group's own limit."""
    path = table(rows())
    for reference in ("2.0", "exact", "extrapolated"):
        result = script("study.py", path, "--error", "K", "--reference", reference, "--by", "grid.cell")
        assert result.returncode == 0, result.stderr
        found = written(tmp_path / "study_K.csv")
        assert [row["family"] for row in found] == 3 * ["mass=lumped"] + 3 * ["mass=consistent"] and found[0]["name"] == "mass=lumped cell=0.4"
        np.testing.assert_allclose([float(row["error_percent"]) for row in found], [100 * c * cell**2 / LIMIT for c in (0.5, 1.0) for cell in (0.4, 0.2, 0.1)], rtol=1e-6)
        assert [row["order"] for row in found[::3]] == ["", ""] and all(float(row["order"]) == pytest.approx(2) for row in found if row["order"])
        assert all(float(row["extrapolated"]) == pytest.approx(LIMIT) for row in found)
        assert (tmp_path / "study_K.png").read_bytes().startswith(b"\x89PNG")
    assert "the last three tend to 2 with the order 2.00\n" in result.stdout and "Pareto front:" in result.stdout


def test_coarse_comes_first_whichever_way_the_key_goes(script, table, tmp_path):
    """By particles; or as is said, where all have as many."""
    numbered = [row | {"$n": round(1 / row["grid.cell"], 6)} for row in rows(masses=("lumped",))]
    for row in numbered:
        del row["grid.cell"], row["grid.cells"]
    result = script("study.py", table(numbered[::-1]), "--error", "K", "--reference", "2", "--by", "$n")
    assert [row["$n"] for row in written(tmp_path / "study_K.csv")] == ["2.5", "5.0", "10.0"] and "order 2.00" in result.stdout
    assert "all cases:" in result.stdout
    steps = [{"method.courant": c, "particles": 10, "cpu_seconds": 1 / c, "K": LIMIT + c} for c in (0.1, 0.2, 0.4)]
    for option, order in (((), 1.0), (("--direct",), 1.0), (("--inverse",), -1.0)):
        script("study.py", table(steps), "--error", "K", "--reference", "2", "--by", "method.courant", *option)
        assert float(written(tmp_path / "study_K.csv")[1]["order"]) == pytest.approx(order)


def test_cases_without_a_number_are_counted(script, table):
    failed = rows() + [{"case": "failed", "grid.cell": 0.05, "method.mass": "lumped", "K": ""}]
    assert "1 of 7 cases without a number in K left out" in script("study.py", table(failed), "--error", "K", "--by", "grid.cell").stderr


@pytest.mark.parametrize("words, message", [
    (["--error", "J", "--by", "grid.cell"], "no column 'J'"), (["--error", "K", "--by", "grid.cel"], "no column 'grid.cel'"),
    (["--error", "K", "--by", "grid.cell", "--reference", "exactly"], "no column 'exactly'"), (["--error", "K", "--by", "method.mass"], "'lumped' is no size"),
    (["--error", "K", "--by", "particles"], "particles")])
def test_mistakes(script, table, words, message):
    twice = rows() + rows() if words[-1] == "particles" else rows()
    result = script("study.py", table(twice), *words)
    assert result.returncode == 2 and message in result.stderr and result.stderr.count("\n") == 1


def test_the_page_of_scripts_names_it():
    assert "`postprocess/study.py SWEEP.yaml" in (ROOT / "docs/reference/scripts.md").read_text()
