"""Namelists and command lines that are changed at random are understood as what they say, or refused with a message."""

import random
import subprocess
import sys
from collections import defaultdict

import advice
import checkpoint_files
import combinations
import every_key
import growth_scenes
import h5py
import meeting_scenes
import mutations
import numpy as np
import plain_scenes
import pytest
import rest_scenes
import shape_scenes
import solid_keys
import solid_scenes
from fuzz import SCENES, answers, fuzz, table
from runs import try_runs
from scene_fuzzer import try_scenes

from paths import CHECKED_PROGRAM, PROGRAM, SOLID_PROGRAM

DRIVER = CHECKED_PROGRAM.with_name("fuzz_driver")
CASES = 400
PROCESSES = 100
RUNS = 30


@pytest.mark.parametrize(("seed", "cases"), [(1, CASES), pytest.param(2, 10_000, marks=pytest.mark.verify)])
def test_random_changes(seed, cases):
    """By the checked build, in which an index, a pointer or a number that goes wrong ends the process."""
    counts, longest = fuzz(cases, seed, DRIVER, PROGRAM)
    print(table(counts), longest)


def test_the_program_ends_as_its_exit_codes_say(tmp_path):
    """Whole runs of `--check`: files, options and sizes together."""
    source = random.Random(3)
    for number in range(PROCESSES):
        text = mutations.byte(source.choice(SCENES), source)
        text = mutations.KINDS["value"](text.decode("latin-1"), source)
        (tmp_path / "case.nml").write_text(text, encoding="latin-1")
        program = CHECKED_PROGRAM if number % 2 else PROGRAM
        options = [word for word in mutations.arguments(source) if word != b"/dev/zero"]
        if number % 3:
            options = [b"case.nml"]
        run = subprocess.run([program, *options, b"--check"], cwd=tmp_path, capture_output=True, timeout=60)
        assert run.returncode in (0, 2, 4), (options, text, run.stderr)
        assert run.returncode == 0 or not run.stdout, (options, text)
        for line in run.stderr.splitlines():
            assert line.startswith(b"hampm: "), (options, text, run.stderr)


@pytest.mark.parametrize(("keys", "extra"), [(12, 6), pytest.param(None, 30, marks=pytest.mark.verify)])
def test_every_key_acts(keys, extra):
    """Each of some keys, taken at random, in one scene at least; and where some do not, this is said. `make fuzz` sets all keys in all scenes."""
    assert not every_key.try_each_once(PROGRAM, random.Random(1), extra, keys)


@pytest.mark.skipif(not SOLID_PROGRAM.exists(), reason="make program dim=3 makes it")
@pytest.mark.parametrize(("keys", "extra"), [(10, 4), pytest.param(None, 30, marks=pytest.mark.verify)])
def test_every_key_of_solids_acts(keys, extra):
    """In one scene at least, or it is refused there; and where it does not, this is said."""
    assert not every_key.try_each_once(SOLID_PROGRAM, random.Random(2), extra, keys, solid_keys.SOLIDS)


@pytest.mark.parametrize("program", [pytest.param(PROGRAM, marks=pytest.mark.verify), CHECKED_PROGRAM], ids=["release", "checked"])
def test_runs_that_go_wrong_end_with_a_message(program):
    ends, findings = try_runs(program, RUNS, seed=2)
    assert not findings
    assert ends[3] >= RUNS // 10 and ends[0] >= RUNS // 10


@pytest.mark.parametrize(("program", "cases"), [(PROGRAM, 6), pytest.param(CHECKED_PROGRAM, 12, marks=pytest.mark.verify)],
                         ids=["release", "checked"])
def test_cracks_that_grow_at_random(program, cases):
    """They end as they say, with an energy balance that closes."""
    grown = []

    def look(folder, text):
        with h5py.File(folder / "case.h5") as file:
            grown.append(file["history/crack_length"][-1] > file["history/crack_length"][0])
        return growth_scenes.look(folder, text)

    ends, findings = try_scenes(program, cases, 1, growth_scenes.scene, look)
    assert not findings
    assert sum(grown) >= cases // 4 and ends[0] >= cases // 2


@pytest.mark.parametrize(("program", "cases"), [(PROGRAM, 8), pytest.param(CHECKED_PROGRAM, 20, marks=pytest.mark.verify)],
                         ids=["release", "checked"])
@pytest.mark.parametrize("scenes", [shape_scenes, meeting_scenes, rest_scenes, plain_scenes], ids=["shapes", "meeting", "rest", "plain"])
def test_bodies_at_random(program, cases, scenes):
    """Shapes have their areas, bodies that meet keep their momentum, energy balances close, cracks at rest grow at their toughness, and particles of
    plain scenes move by steps in tiles as by steps in stages."""
    ends, findings = try_scenes(program, cases, 1, scenes.scene, scenes.look)
    assert not findings
    assert ends[0] >= cases // 4


def test_tips_in_another_order_are_told_by_what_they_say():
    """Of six tips the last two changed places, of which one has a domain of J more."""
    row = {f"J{tip}": np.array([1.0, float(k)]) for k, tip in enumerate(["", *(f"_tip{n}" for n in range(2, 7))])} | {"J_2": np.array([0.5, 5.0]), "cells": np.array([4.0, 4.0])}
    other = row | {"J_tip5": row["J_tip6"], "J_tip6": row["J_tip5"]} | {"J": row["J_tip2"], "J_tip2": row["J"], "J_2_tip2": row["J_2"]}
    del other["J_2"]
    scale = defaultdict(lambda: 1.0)
    assert combinations.differences_in_any_order(row, other, scale)[0] == 0.0
    assert combinations.differences_in_any_order(row, other | {"J_tip6": row["J_tip6"]}, scale)[0] == 1.0


@pytest.mark.parametrize("numbers", [(1, 2, 7, 10, 12, 14, 22, 29, 31), pytest.param((3, 4, 5, 6, 8, 9), marks=pytest.mark.verify)])
def test_combinations_at_random(numbers):
    """Scenes over all features together, in the build with all checks: what they give does not hang on how they are written, turned, measured, split and run."""
    _, ends, faults = combinations.try_cases(combinations.Bench(CHECKED_PROGRAM), 1, numbers, [], asked=2)
    assert not faults
    assert ends["done"] >= len(numbers) // 2


@pytest.mark.skipif(not SOLID_PROGRAM.exists(), reason="make program dim=3 makes it")
@pytest.mark.parametrize("numbers", [(0, 3, 7), pytest.param(range(40, 70), marks=pytest.mark.verify)])
def test_solids_at_random(numbers):
    """The same of solids, with mirrors in three axes, axes exchanged, and slabs that are plane strain."""
    _, ends, faults = combinations.try_cases(solid_scenes.SolidBench(SOLID_PROGRAM), 1, numbers, [], asked=2)
    assert not faults
    assert ends["done"] >= len(numbers) // 2


def test_checkpoints_that_are_changed_are_refused():
    refused, _, findings = checkpoint_files.try_checkpoints(PROGRAM, 30, 1)
    assert not findings and refused >= 15


HUGE = {
    "a text of quotes": b"&run title = '" + 1_000_000 * b"''",
    "groups": 300_000 * b"&load /\n",
    "unknown groups": 500_000 * b"&ab/",
    "unknown keys": b"&refine " + 200_000 * b"max_levle = 1 " + b"/",
    "values": b"&run title = " + 500_000 * b"1000*x ",
    "texts of an unknown group": b"&ab " + 500_000 * b"'a' ",
    "a word": b"&run title = " + 2_000_000 * b"x",
}


@pytest.mark.parametrize("text", HUGE.values(), ids=HUGE)
def test_large_files_do_not_take_long(hampm, tmp_path, text):
    (tmp_path / "case.nml").write_bytes(text)
    assert hampm("case.nml", timeout=10).returncode == 2


def test_a_crash_is_found(tmp_path):
    """The driver itself: where it ends early, the case is named."""
    with pytest.raises(Exception, match="the driver stopped at case 0"):
        answers(sys.executable, [("value", 0, [b"&run /"])], tmp_path)


@pytest.mark.parametrize(("seed", "cases"), [(2, 60), pytest.param(7, 2000, marks=pytest.mark.verify)])
def test_advice_can_be_taken(seed, cases):
    """What refusals of scenes at random advise is accepted, or leads there in two steps."""
    ends = advice.try_advice(PROGRAM, cases, seed)
    assert ends and not {row: found for row, found in ends.items() if any(found)}
