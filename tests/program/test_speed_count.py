"""The instructions of a step of a plain scene, and of whole runs, which do not depend on how busy the machine is."""

import sys

import pytest

from paths import BENCH, RELEASE_BENCH, ROOT

sys.path.insert(0, str(BENCH))

from instructions import can_count, instructions  # noqa: E402
from whole_runs import LEAST, MOST, QUESTIONS, count, held, run  # noqa: E402

LIMIT = 1.0  # over the least that a step needs where particles stand
TOTAL_LIMIT = 0.25  # of the total frame over the least of the updated one, for a linear law: nodes only, by shared rows of the matrices of the cells
CELLS = 50  # along an edge: 10 000 particles


@pytest.mark.skipif(not can_count(), reason="valgrind is not installed")
@pytest.mark.skipif(not RELEASE_BENCH.exists(), reason="bench_step is not built")
def test_a_step_takes_hardly_more_instructions_than_the_least():
    program, least = (instructions(RELEASE_BENCH, f"{code}:updated:musl:{CELLS}:1") for code in ("program", "minimal"))
    print(f"{program:.1f} instructions a particle and step, {program / least:.2f} of the least")
    assert program / least <= LIMIT


@pytest.mark.skipif(not can_count(), reason="valgrind is not installed")
@pytest.mark.skipif(not RELEASE_BENCH.exists(), reason="bench_step is not built")
def test_in_the_total_frame_a_step_of_linear_cells_takes_less_than_a_quarter():
    total = instructions(RELEASE_BENCH, f"program:total:musl:{CELLS}:1")
    least = instructions(RELEASE_BENCH, f"minimal:updated:musl:{CELLS}:1")
    print(f"{total:.1f} instructions a particle and step, {total / least:.2f} of the least in the updated frame")
    assert total / least <= TOTAL_LIMIT


@pytest.mark.verify
@pytest.mark.skipif(not can_count(), reason="valgrind is not installed")
@pytest.mark.parametrize("name", QUESTIONS)
def test_a_whole_run_takes_the_instructions_of_the_ledger(name):
    question = QUESTIONS[name]
    program = ROOT / ("build/release3d/hampm3d" if question.is_solid else "build/release/hampm")
    if not program.exists():
        pytest.skip(f"{program.name} is not built")
    error, _, compiler = run(program, question)
    ratio = held(name, count(program, question)[0], compiler)
    if ratio is None:
        pytest.skip(f"the ledger has no count by {compiler}")
    print(f"{name}: {ratio:.4f} of the ledger, error {error} %")
    assert ratio <= MOST, "it costs more: find out what for, and write in what it buys by bench/whole_runs.py --why REASON"
    assert ratio >= LEAST, "it costs less: write that in by bench/whole_runs.py --why REASON"
