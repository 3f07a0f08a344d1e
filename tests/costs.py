"""Processor time of each test, and by it which cases `make test` runs (tests/long_tests.csv); the others are those of `make verify`.

    make costs          measures all that `make test` runs, and takes from it what has become too long

Of each function the first cases are run, as many as fit into BUDGET, beside those that take no time, or the quickest one, which may take MOST. What stands
for a promise by itself is in ESSENTIAL, and functions whose cases are tests of their own, each as long as it may be, in APART. What `make verify` runs is not
taken back: delete its row, and measure again."""

import json
import os
import sys
from collections import defaultdict
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))
from long_tests import cases, write_cases  # noqa: E402

BUDGET, MOST, NOTHING = 0.4, 1.2, 0.06     # seconds of a processor
APART = {"test_unit": 2.0, "test_regression": 1.5, "test_bad_input": 1.0, "test_lessons": 1.0, "test_tutorials": 1.0}
ESSENTIAL = {"test_speed_count::test_a_step_takes_hardly_more_instructions_than_the_least", "test_fatigue::test_paris_life_of_a_crack_in_the_middle",
             "test_growth_in_motion::test_a_crack_that_runs", "test_growth_in_motion::test_the_plate_of_kalthoff",
             "test_growth_in_motion::test_a_tip_that_may_turn_runs_as_one_that_may_not", "test_fuzz::test_advice_can_be_taken", "test_fuzz::test_random_changes",
             "test_checkpoints::test_growing_tips_go_on_from_any_step_between_changes_of_the_mesh", "test_resistance::test_a_resistance_curve_at_rest",
             "test_front_growth::test_threads_and_restarts_change_no_byte_of_growth", "test_nucleation::test_smooth_edge",
             "test_nucleation::test_cracks_one_after_the_other_with_residual_stress", "test_front_growth::test_a_front_meets_a_side",
             "test_reference::test_every_column_of_the_history_is_documented", "test_extremes::test_units", "test_fuzz::test_combinations_at_random"}
FOLDER = Path(__file__).resolve().parents[1] / "build/costs"


def spent():
    times = os.times()
    return times.user + times.system + times.children_user + times.children_system


def pytest_collection_modifyitems(items):
    for place, item in enumerate(items):
        item.place = place


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_protocol(item):
    """As a plugin, -p costs: note what a test has taken, with what it has started."""
    before = spent()
    yield
    FOLDER.mkdir(parents=True, exist_ok=True)
    with (FOLDER / str(os.getpid())).open("a") as file:
        file.write(json.dumps([item.place, item.path.stem, item.originalname, item.name.partition("[")[2].rstrip("]"), spent() - before]) + "\n")


def kept(file, function, costs):
    """Of the cases of a function, as (name, seconds) in their order: those that `make test` runs."""
    if file in APART:
        return [case for case, cost in costs if cost <= APART[file]]
    found, total = [], 0.0
    for case, cost in costs:
        if cost > NOTHING and total + cost > BUDGET:
            break
        found.append(case)
        total += cost
    case, least = min(costs, key=lambda one: one[1])
    return found or [case] * (least <= MOST or f"{file}::{function}" in ESSENTIAL)


def main():
    measured, total, runs = defaultdict(list), [0.0, 0.0], cases()
    for path in FOLDER.iterdir():
        for place, file, function, case, cost in map(json.loads, path.read_text().splitlines()):
            measured[file, function].append((place, case, cost))
    for (file, function), costs in measured.items():
        costs = [(case, cost) for _, case, cost in sorted(costs)]
        names = [case for case, _ in costs]
        keep = kept(file, function, costs)
        if keep != names:
            is_first = keep == names[:len(keep)] and (not keep or not isinstance(runs.get(file, {}).get(function), tuple))
            left = tuple(name for name in names if name not in keep)
            runs.setdefault(file, {})[function] = len(keep) if is_first else set(left) if len(left) < len(keep) else tuple(keep)
        total[0] += sum(cost for _, cost in costs)
        total[1] += sum(cost for case, cost in costs if case in keep)
    write_cases(runs)
    print(f"{total[0]:.0f} s of a processor, {total[1]:.0f} s with what is left")


if __name__ == "__main__":
    main()
