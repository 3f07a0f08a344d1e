"""The list of tests that `make test` leaves out, and what it is written by."""

from costs import kept
from long_tests import cases, is_run
from paths import ROOT


def test_every_row_names_a_test():
    sources = {path.stem: path.read_text() for path in (ROOT / "tests").rglob("test_*.py")}
    assert [f"{file}: {function}" for file, of_file in cases().items() for function in of_file
            if f"def {function}(" not in sources.get(file, "")] == []


def test_what_is_run_of_a_function():
    assert [is_run(2, place, "") for place in (1, 2, 3)] == [True, True, False]
    assert [is_run(("usl", "musl-1"), 1, case) for case in ("usl-2", "musl-1", "musl-2", "other")] == [True, True, True, False]
    assert [is_run({"slow"}, 1, case) for case in ("slow-1", "fast")] == [False, True]


def test_what_fits_is_kept():
    """The first cases that are quick together; of slow ones the quickest, or none."""
    assert kept("test_a", "test_b", [("1", 0.2), ("2", 0.1), ("3", 0.2), ("4", 0.01)]) == ["1", "2"]
    assert kept("test_a", "test_b", [("1", 0.3), ("2", 0.05), ("3", 0.05), ("4", 0.05)]) == ["1", "2", "3", "4"]
    assert kept("test_a", "test_b", [("1", 3.0), ("2", 1.0)]) == ["2"]
    assert kept("test_a", "test_b", [("1", 3.0), ("2", 2.0)]) == []
    assert kept("test_fatigue", "test_paris_life_of_a_crack_in_the_middle", [("", 3.0)]) == [""]
    assert kept("test_unit", "test_program", [("1", 3.0), ("2", 1.9)]) == ["2"]
