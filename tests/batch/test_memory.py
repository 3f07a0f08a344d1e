"""The memory that a case asks of a cluster."""

import pytest

pytest.importorskip("yaml")

from hampm.batch.declaration import read_sweep
from hampm.batch.needs import memory, memory_refused
from paths import PROGRAM
from scene import HEAD, write_sweep


@pytest.mark.parametrize("said, megabytes", [
    ("hampm: the model needs about 170 GB of memory for 900000000 particles and 400000000 cells, and there are 8.2 GB: use", 170e3),
    ("hampm: --set method.mass=consisten: must be 'lumped'", 0)])
def test_the_memory_of_a_model_that_is_refused(said, megabytes):
    assert memory_refused(f"{said}\n") == megabytes


def test_what_a_case_asks_for(tmp_path):
    """Uniform, refined, too large for any machine, refused."""
    path = write_sweep(tmp_path, HEAD + "cases:\n- {run.title: a}\n"
                       "- {refine.indicator: gradient, refine.r_crit: 0.1, refine.max_level: 8, refine.field: speed}\n"
                       "- {grid.cells: [15000, 15000], body.upper: [14000.25, 14000]}\n- {method.mass: consisten}\n")
    sweep = read_sweep(path)
    plain, refined, large, refused = (memory(sweep, name, PROGRAM) for name in sweep.cases)
    assert refused == 100 < plain < refined and large > 100e3
    path.write_text(path.read_text() + "memory: 7")
    sweep = read_sweep(path)
    assert {memory(sweep, name, PROGRAM) for name in sweep.cases} == {7}
