"""Refinement at its extremes, in runs of the program: the energy audit closes, and where refinement ends the user is told."""

import numpy as np
import pytest

from history import History

TIP = "indicator=tip", "rings=4"
GRADIENT = "indicator=gradient", "r_crit=1e-9", "energy_floor=0", "interval=1"
ERROR = "indicator=zz", "tolerance=1e-3", "interval=1"
REACHED = "hampm: warning: refinement reached &refine max_level = 3: cells that would have been refined further were not\n"
ENDED = "hampm: warning: refinement ended at &refine max_particles = 500: cells that would have been refined further were not. " \
        "Give {} or a smaller max_level, or allow more\n"


@pytest.fixture
def refined(dcb, tmp_path):
    """`refined(refine, end_time, *overrides)` runs the beam and returns process and history."""
    def run(refine, end_time, *overrides):
        settings = *(f"refine.{item}" for item in refine), "method.courant=0.5", f"run.end_time={end_time}", \
            f"output.history_interval={end_time / 20}", "output.snapshot_interval=0", *overrides
        process = dcb("--quiet", *(word for item in settings for word in ("--set", item)))
        return process, History(tmp_path / "dcb.h5").columns
    return run


def assert_energy_balances(columns):
    c = columns
    stored = c["kinetic_energy"] + c["strain_energy"]
    residual = stored + c["damping_loss"] + c["numerical_loss"] - c["external_work"] - stored[0]
    assert np.max(np.abs(residual)) <= 1e-13 * np.max(np.abs(c["external_work"]))


@pytest.mark.parametrize(("levels", "end_time"), [(12, 1e-7), (20, 3e-10)])
def test_cells_at_the_tip_may_be_very_small(refined, levels, end_time):
    process, columns = refined((*TIP, f"max_level={levels}"), end_time)
    assert (process.returncode, process.stderr) == (0, "")
    assert columns["step"][-1] >= 300
    assert columns["finest_cell"][-1] == 5e-3 / 2**levels
    assert np.all(columns["particles"] == columns["particles"][0])
    assert columns["cells"][0] < 2000  # a number in proportion to that of the levels
    assert_energy_balances(columns)


def test_every_cell_may_refine_to_the_limit(refined):
    process, columns = refined((*GRADIENT, "max_level=3"), 2e-4, "grid.cell=1e-2", "grid.cells=10,2")
    assert (process.returncode, process.stderr) == (0, REACHED)
    assert (columns["particles"][0], columns["particles"][-1]) == (40, 40 * 4**3)
    assert columns["finest_cell"][-1] == 1e-2 / 2**3
    assert_energy_balances(columns)


@pytest.mark.parametrize(("refine", "advice"), [
    (TIP, "fewer rings"), (GRADIENT, "a larger r_crit"), (ERROR, "a larger tolerance")], ids=["tip", "gradient", "zz"])
def test_refinement_ends_at_the_largest_number_of_particles(refined, refine, advice):
    process, columns = refined((*refine, "max_level=6", "max_particles=500"), 2e-5)
    assert (process.returncode, process.stderr) == (0, ENDED.format(advice))
    assert 160 < max(columns["particles"]) <= 500
    assert_energy_balances(columns)
