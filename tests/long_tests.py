"""Which tests run where. Tests that take long are in long_tests.csv, by file and function, with how many of their cases `make test` runs, or which, by parts of
their names; the others belong to `make verify`, as do those that are marked so. `make costs` measures them anew (costs.py)."""

import csv
from pathlib import Path

LIST = Path(__file__).with_name("long_tests.csv")


def cases():
    """By file and function what `make test` runs: the number of its first cases, a tuple of parts of names of cases, or a set of those of all that it does not run."""
    found = {}
    with LIST.open(newline="") as file:
        for name, function, runs in csv.reader(file):
            parts = runs[1:].split(" | ")
            found.setdefault(name, {})[function] = int(runs) if runs.isdigit() else set(parts) if runs[0] == "!" else tuple(parts)
    return found


def write_cases(found):
    with LIST.open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        for name, of_file in sorted(found.items()):
            for function, runs in sorted(of_file.items()):
                writer.writerow([name, function, runs if isinstance(runs, int) else "!="[isinstance(runs, tuple)] + " | ".join(sorted(runs))])


def is_run(runs, place, case):
    """Whether `make test` runs a case, the `place`-th one of a function."""
    if isinstance(runs, int):
        return place <= runs
    return any(part in case for part in runs) != isinstance(runs, set)


# Of these files all that has to do with a part, by the beginning of the name of the case
PARTS = {"test_lessons": ("2_", "11_", "18_", "20_", "6_", "7_", "8_", "9_", "10_", "13_", "14_", "16_", "19_", *(f"solutions/{k}-" for k in (6, 7, 8, 9, 10, 13, 14, 15, 16))),
         "test_regression": ("dcb_dynamic-alpha10000", "dcb_dynamic-undamped", "chen-0.2mm", "figure_10-unlumped")}

# Files of tests/program whose runs are short enough for the build with all checks and traps; tests/cases and tests/lab have it, too
CHECKED = {"exercises", "test_accuracy", "test_interfaces", "test_line_mass_identity", "test_moved_nodes", "test_permissions", "test_result_file",
           "test_supports", "test_weight_and_eigenstrain"}
