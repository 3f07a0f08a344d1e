"""Pictures of the energy over time: what is booked and what is not, how the balance closes, mistakes named."""

import numpy as np
import pytest

import plot_energy
from history import History
from synthetic import write_result

T = np.linspace(0, 1e-3, 101)
KINETIC, STRAIN, DAMPED = 1 + np.cos(2e4 * T), 0.5 * (1 - np.cos(2e4 * T)), 1e3 * T
LOSS = 0.04 * T / T[-1]


def energies(booked=True, error=0.0):
    """A body that moves from the start, is loaded and damped; the method loses 0.04 J."""
    columns = {"time": T, "kinetic_energy": KINETIC, "strain_energy": STRAIN, "damping_loss": DAMPED,
               "external_work": KINETIC + STRAIN + DAMPED + LOSS - 2 + error}
    return columns | ({"numerical_loss": LOSS} if booked else {})


@pytest.fixture
def balance(tmp_path):
    def call(**options):
        return plot_energy.Balance(History(write_result(tmp_path / "a.h5", energies(**options))))
    return call


def test_what_is_supplied_is_work_and_the_energy_at_the_start(balance):
    np.testing.assert_allclose(balance().supplied, KINETIC + STRAIN + DAMPED + LOSS)
    assert balance().largest == pytest.approx(np.max(KINETIC + STRAIN + DAMPED + LOSS))


def test_a_loss_that_is_not_booked_is_what_the_others_miss(balance):
    found = balance(booked=False)
    assert found.missing is None and "not booked" in plot_energy.closure(found)
    np.testing.assert_allclose(found.parts["numerical_loss"], LOSS, atol=1e-12)


def test_a_balance_that_does_not_close_is_named(balance):
    assert balance().missing < 1e-15
    found = balance(error=0.02 * T / T[-1])
    assert found.missing == pytest.approx(0.02 / found.largest) and "closes to 7e-03" in plot_energy.closure(found)


def test_curves_and_areas_in_the_units_asked_for(tmp_path):
    file = str(write_result(tmp_path / "a.h5", energies()))
    for arguments, factor in [([], 1.0), (["--relative"], None)]:
        found = plot_energy.Balance(History(file))
        figure = plot_energy.draw([found], plot_energy.parse([file, "--time-unit", "us", *arguments]))
        times, kinetic = figure.axes[0].lines[0].get_data()
        np.testing.assert_allclose(times, T * 1e6)
        np.testing.assert_allclose(kinetic, KINETIC * (factor or 1 / found.largest))
        np.testing.assert_allclose(figure.axes[1].lines[0].get_ydata(), 100 * LOSS / found.largest)
    stacked = plot_energy.draw([found], plot_energy.parse([file, "--stacked"])).axes[0]
    assert len(stacked.collections) == 4 and len(stacked.lines) == 1
    plot_energy.plt.close("all")
