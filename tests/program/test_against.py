"""The comparison with an earlier version (bench/against.py): it sees a difference, and its scenes are accepted."""

import math
import sys
from concurrent.futures import ThreadPoolExecutor
from types import SimpleNamespace

import numpy as np
import pytest

from paths import BENCH, PROGRAM

sys.path.insert(0, str(BENCH))

import against  # noqa: E402
from against_scenes import COUNTED, FLIGHT, SCENES, Scene  # noqa: E402

QUICK = Scene("quick", FLIGHT, ("run.end_time=3e-4", "output.history_interval=1e-4"))


def history(**columns):
    return SimpleNamespace(columns={name: np.array(values) for name, values in columns.items()}, units={
        "G_I": "J/m2", "G_II": "J/m2", "tip_cell": "m", "opening": "m", "cells": "1"})


BEFORE = {"G_I": [0.0, 2.0, -4.0], "G_II": [0.0, 1e-20, -1e-20], "tip_cell": [1.0, 1.0, 1.0], "opening": [0.0, 0.0, 1e-9],
          "cells": [4, 5, 6]}


@pytest.mark.parametrize(("changed", "own", "of_unit"), [
    ({}, {}, {}),
    ({"G_I": [0.0, 2.0 + 1e-6, -4.0]}, {"G_I": 2.5e-7}, {"G_I": 2.5e-7}),
    ({"G_II": [0.0, 0.0, -1e-20]}, {"G_II": 1.0}, {"G_II": 2.5e-21}),
    ({"opening": [0.0, 0.0, 2e-9]}, {"opening": 1.0}, {"opening": 1.0}),
    ({"cells": [4, 5, 7]}, {"cells": 1 / 6}, {"cells": 1 / 6}),
    ({"cells": [4, 5]}, {"cells": math.inf}, {"cells": math.inf}),
    ({"G_I": [0.0, math.nan, -4.0]}, {"G_I": math.inf}, {"G_I": math.inf})])
def test_a_difference_is_seen(changed, own, of_unit):
    found = against.differences(history(**BEFORE), history(**BEFORE | changed))
    assert {name: value for name, value, _ in found if value} == pytest.approx(own)
    assert {name: value for name, _, value in found if value} == pytest.approx(of_unit)


def test_a_column_that_is_gone_is_seen_and_a_new_one_is_not():
    few = {name: values for name, values in BEFORE.items() if name != "G_I"}
    assert ("G_I", math.inf, math.inf) in against.differences(history(**BEFORE), history(**few))
    assert all(value == 0 for _, _, value in against.differences(history(**few), history(**BEFORE)))


def test_numbers_that_are_missing_in_both_are_no_difference():
    assert against.difference(np.array([math.nan, math.inf]), np.array([math.nan, math.inf])) == 0


def test_two_runs_are_compared(tmp_path):
    """A program beside itself; and beside one that takes other steps."""
    other = tmp_path / "release/hampm"
    other.parent.mkdir()
    other.write_text(f'#!/bin/sh\nexec {PROGRAM} "$@" --set method.courant=0.1\n')
    other.chmod(0o755)
    (tmp_path / "same/release").mkdir(parents=True)
    (tmp_path / "same/release/hampm").symlink_to(PROGRAM)
    same, _ = against.compare((tmp_path / "same", tmp_path / "same"), QUICK)
    assert same[against.COLUMNS.index("quantity")] == "the same numbers"
    changed, columns = against.compare((tmp_path / "same", tmp_path), QUICK)
    assert changed[against.COLUMNS.index("met")] == "NO"
    assert max(value for _, name, _, value in columns if name == "dt") > 1e-3


def test_a_run_that_ends_otherwise_is_told(tmp_path):
    for name, code in (("before", 0), ("after", 3)):
        (tmp_path / name / "release").mkdir(parents=True)
        (tmp_path / name / "release/hampm").write_text(f"#!/bin/sh\nexit {code}\n")
        (tmp_path / name / "release/hampm").chmod(0o755)
    line, columns = against.compare((tmp_path / "before", tmp_path / "after"), QUICK)
    assert line[against.COLUMNS.index("met")] == "NO"
    assert columns == []


def test_the_program_accepts_every_scene(run_hampm, tmp_path):
    assert len({scene.name for scene in SCENES}) == len(SCENES) > 25
    assert set(COUNTED) <= {scene.name for scene in SCENES}

    def check(numbered):
        folder = tmp_path / str(numbered[0])
        folder.mkdir()
        return run_hampm("--check", *against.arguments_of(numbered[1], folder), cwd=folder)

    with ThreadPoolExecutor(2) as several:
        found = list(several.map(check, enumerate(SCENES)))
    assert [result.stderr for result in found if result.returncode] == []
