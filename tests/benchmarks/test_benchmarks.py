"""The benchmarks: each number has a source, an accuracy and a unit, the page is what the driver makes of the CSV file, and runs give the numbers that stand there."""

import re

import h5py
import numpy as np
import pytest

import exam

NEEDED = {"model", "source", "kind", "accuracy", "quantity", "unit", "published", "measured"}
OPTIONAL = {"let", "cases", "set", "at", "since", "error", "along", "point", "others", "case", "cause", "fault"}


@pytest.mark.parametrize("suite", exam.suites())
def test_every_number_has_a_source_an_accuracy_and_a_unit(suite):
    content = exam.read(suite)
    assert content["title"] and (content["part"] or content["impossible"])
    for part in content["part"]:
        assert NEEDED <= part.keys() <= NEEDED | OPTIONAL, part.keys() ^ NEEDED
        assert part["kind"] in exam.KINDS and (exam.HERE / suite / part["model"]).exists()
        assert len(part["source"]) > 20 and re.search(r"\d", part["source"]), "author, title, year, page or section"
        assert ("cause" in part) == ("fault" in part) and part.get("fault", "source") in exam.FAULTS
        assert part["accuracy"] in ("not stated",) if isinstance(part["accuracy"], str) else 0 <= part["accuracy"] < 0.2
        assert len({len(values) for values in part.get("cases", {}).values()}) <= 1
        for k, names in exam.cases(part):
            assert np.isfinite(exam.published(part, k, names))
            for text in [*part.get("set", []), part.get("case", "")]:
                assert "{" not in exam.filled(text, names)
            assert all(len(values) == len(next(iter(part["cases"].values()))) for values in part.get("others", {}).values())
    assert all(row.keys() == {"quantity", "source", "missing"} for row in content["impossible"])


def test_the_table_has_the_rows_of_the_suites():
    rows = [(suite, part["quantity"], exam.filled(part.get("case", ""), names), f"{float(exam.published(part, k, names)):.6g}")
            for suite in exam.suites() for part in exam.read(suite)["part"] for k, names in exam.cases(part)]
    assert rows == [tuple(row[name] for name in ("suite", "quantity", "case", "published")) for row in exam.read_table()]
    assert len(set(rows)) == len(rows)


def test_the_page_is_what_the_driver_makes_of_the_table():
    page = exam.PAGE.read_text(encoding="utf-8")
    assert exam.renewed(page, exam.read_table()) == page


def test_the_error_of_an_expression_is_that_of_its_columns():
    known = {"K_I": 3.0, "K_I_error": 0.3, "K_II": 4.0, "K_II_error": 0.4, "J": 2.0}
    value, error = exam.measure("2*K_I + K_II", known, {})
    assert (value, error) == (10.0, pytest.approx(np.hypot(0.6, 0.4)))
    assert np.isnan(exam.measure("J", known, {})[1])
    assert exam.error_name("K_I_tip2") == "K_I_error_tip2" and exam.error_name("G_mean") == "G_mean_error"


def test_columns_are_changes_since_an_earlier_time(tmp_path):
    with h5py.File(tmp_path/"run.h5", "w") as file:
        file["history/time"], file["history/tip_x"] = [0.0, 1.0, 2.0], [5.0, 6.0, 9.0]
    assert exam.columns(tmp_path/"run.h5", {"at": "2.0", "since": "0.5"}, {}) == {"time": 1.5, "tip_x": 3.5}


def test_coarser_lattices_keep_the_origin_and_hold_the_body():
    choice = {("grid", "lower"): "-40.0,-20.5", ("grid", "cell"): "0.5", ("grid", "cells"): "120,82", ("grid", "order"): "1"}
    assert exam.coarser(choice, 2) == {("grid", "lower"): "-40,-21", ("grid", "cell"): "1", ("grid", "cells"): "60,42", ("grid", "order"): "1"}
    moved = list(exam.neighbours_in_motion(choice | {("method", "mass"): "'lumped'", ("method", "courant"): "0.8"}))
    assert all(("method", "courant") not in other for other in moved if other["method", "mass"] != "'lumped'") and any(other["method", "courant"] == "0.4" for other in moved
                                                                                                               if ("method", "courant") in other)


@pytest.mark.verify
@pytest.mark.parametrize("suite", exam.suites())
def test_runs_give_the_numbers_of_the_table(suite, tmp_path):
    """Within the larger of both error bars, with the same verdict."""
    asked = [row for row in exam.read_table() if row["suite"] == suite]
    found = list(exam.rows_of(suite, exam.Runs(tmp_path)))
    assert len(found) == len(asked)
    for old, new in zip(asked, found):
        bar = np.nanmax([exam.number(old, "error"), exam.number(new, "error"), 1e-6*abs(exam.number(old, "hampm"))])
        print(suite, old["case"], old["hampm"], new["hampm"], bar)
        assert new["verdict"] == old["verdict"], (old, new)
        assert abs(exam.number(new, "hampm") - exam.number(old, "hampm")) <= bar or new["hampm"] == old["hampm"] == "nan", (old, new)
