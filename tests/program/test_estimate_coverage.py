"""Estimated errors cover the true ones on random specimens: those of the table of the docs, of which a few are run."""

import sys
from statistics import median

from paths import BENCH, PROGRAM

sys.path.insert(0, str(BENCH))

from estimate_coverage import errors, read, run, summary  # noqa: E402
from estimate_specimens import make  # noqa: E402

TABLE = read(BENCH.parent / "docs/evidence/estimates_after.csv")
FEW = [("symmetry", 0), ("path", 0), ("hole", 1), ("pressure", 1)]


def test_estimates_cover_nineteen_of_twenty_and_are_not_much_larger():
    covered, ratios = [], []
    for kind, number in FEW:
        rows = [row for row in TABLE if row["kind"] == kind and row["number"] == number]
        columns = run(str(PROGRAM), make(kind, number).scene)
        assert rows and not isinstance(columns, str), columns
        for row in rows:
            value = abs(columns[row["column"]]) if row["column"].startswith("G_") else columns[row["column"]]
            name, _, tip = row["column"].partition("_tip")
            estimate = columns[f"{name}_error" + (f"_tip{tip}" if tip else "")]
            covered.append(abs(value - row["truth"]) <= estimate + row["doubt"])
            ratios.append(estimate / max(abs(value - row["truth"]), row["doubt"]))
    assert sum(covered) >= 0.95 * len(covered)
    assert median(ratios) < 5


def test_the_table_of_the_docs_holds_what_is_said_of_it():
    _, _, _, covered, sharp, _ = next(summary(TABLE, lambda row: ""))
    assert covered >= 95 and sharp <= 3
    assert max(errors(row) / row["size"] for row in TABLE) < 1
