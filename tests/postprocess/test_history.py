"""Reading a history and a curve, the low-pass filter, the moving mean and the first natural frequency."""

import h5py
import numpy as np
import pytest

from history import History, ResultError, fit_modes, first_frequency, lowpass, moving_mean, read_curve
from synthetic import BEAM, G_REF, dcb, write_result

TIMES = np.linspace(0, 1.2e-3, 1201)
F1 = 2549.4


def tone(frequency, phase=0.7, decay=0.0):
    return np.exp(-decay * TIMES) * np.cos(2 * np.pi * frequency * TIMES + phase)


def interior(values, cutoff):
    """Without two periods of the cutoff at either end, where the continuation of the signal is felt."""
    margin = int(2 / cutoff / (TIMES[1] - TIMES[0]))
    return np.max(np.abs(values[margin:-margin]))


def test_history_gives_columns_units_and_ratios(dcb_file):
    history = History(dcb_file)
    assert history.stem == "dcb"
    assert history.units["crack_opening"] == "m" and history.units["G_vcct_I"] == "J/m2"
    np.testing.assert_allclose(history.g_ratio("G_vcct_I") * G_REF, dcb()["G_vcct_I"])
    assert history.beam_ratio() == pytest.approx(BEAM / G_REF)
    assert history.select(["G_*"]) == ["G_stress_closure_I", "G_vcct_I"]


def test_attributes_written_as_arrays_of_one_element_are_read(tmp_path):
    path = write_result(tmp_path / "a.h5", g_ref=np.array([G_REF]), beam=None)
    assert History(path).g_ref() == G_REF
    assert History(path).beam_ratio() is None


def test_units_padded_by_fortran_are_read(dcb_file):
    with h5py.File(dcb_file, "a") as file:
        file["history/time"].attrs["units"] = np.bytes_("s   ")
    assert History(dcb_file).units["time"] == "s"


@pytest.mark.parametrize("value", [0.0, -1.0, np.nan])
def test_a_senseless_reference_value_is_refused(tmp_path, value):
    with pytest.raises(ResultError, match="not a positive number"):
        History(write_result(tmp_path / "a.h5", g_ref=value)).g_ref()


def test_columns_of_unequal_length_are_refused(tmp_path):
    path = write_result(tmp_path / "a.h5", {**dcb(), "step": np.arange(3)})
    with pytest.raises(ResultError, match="/history/step has 3 samples") as refused:
        History(path)
    assert refused.value.exit_code == 2


@pytest.mark.parametrize("phase", [0.0, 0.7, np.pi / 2])
def test_lowpass_keeps_a_slow_tone_and_removes_a_fast_one(phase):
    slow, fast = tone(5e3, phase), tone(100e3, phase)
    assert interior(lowpass(TIMES, slow, 50e3) - slow, 50e3) < 1e-3
    assert np.max(np.abs(lowpass(TIMES, slow, 50e3) - slow)) < 3e-3
    assert interior(lowpass(TIMES, fast, 20e3), 20e3) < 4e-3


def test_lowpass_keeps_straight_lines_and_short_signals():
    np.testing.assert_allclose(lowpass(TIMES, 3 + 2e3 * TIMES, 1e3), 3 + 2e3 * TIMES, rtol=1e-13)
    np.testing.assert_array_equal(lowpass([0.0, 1.0], [1.0, 5.0], 0.1), [1.0, 5.0])


def test_lowpass_on_unequal_steps():
    t = TIMES + 2e-7 * np.sin(np.arange(TIMES.size))
    slow, fast = np.sin(2 * np.pi * 5e3 * t), np.sin(2 * np.pi * 100e3 * t)
    assert interior(lowpass(t, slow + fast, 20e3) - slow, 20e3) < 1e-2


def test_lowpass_has_half_the_amplitude_at_the_cutoff():
    filtered = lowpass(TIMES, tone(30e3), 30e3)
    assert interior(filtered, 30e3) == pytest.approx(0.5, rel=0.02)


@pytest.mark.parametrize("shift", [0.0, 0.3])
def test_moving_mean_of_a_line_is_the_line_up_to_half_a_window_from_the_ends(shift):
    t = np.arange(11) + shift * np.sin(np.arange(11))
    inside = (t > t[0] + 1.1) & (t < t[-1] - 1.1)
    np.testing.assert_allclose(moving_mean(t, 3 - 2 * t, 2.2)[inside], (3 - 2 * t)[inside], rtol=1e-13)


def test_moving_mean_integrates_straight_lines_between_samples():
    mean = moving_mean([0.0, 1.0, 2.0], [0.0, 1.0, 0.0], 1.0)
    np.testing.assert_allclose(mean, [0.25, 0.75, 0.25])  # at the ends over half of the window


def test_moving_mean_of_a_wave_of_the_width_of_the_window_is_nothing():
    t = np.linspace(0, 1, 1001)
    assert np.max(np.abs(moving_mean(t, np.cos(20 * np.pi * t), 0.1)[50:-50])) < 1e-12


def test_a_curve_may_have_comments_and_names_above_it(tmp_path):
    path = tmp_path / "curve.csv"
    path.write_text("# made by hand\nt_s,K,K_mean\n0,1,2\n1e-6,3,4\n")
    np.testing.assert_array_equal(read_curve(path), [[0, 1e-6], [1, 3]])
    np.testing.assert_array_equal(read_curve(path, 2), [[0, 1e-6], [2, 4]])


def test_first_frequency_below_higher_modes():
    signal = 1 - tone(F1, 0) + 0.3 * (1 - tone(16e3, 0)) + 0.1 * tone(45e3)
    assert first_frequency(TIMES, signal) == pytest.approx(F1, rel=1e-6)


@pytest.mark.parametrize("phase", [0.0, 1.0, 2.5])
def test_first_frequency_in_noise(phase):
    noise = np.random.default_rng(1).standard_normal(TIMES.size)
    signal = 1 - tone(F1, phase) + 0.3 * tone(16e3) + 0.02 * noise
    assert first_frequency(TIMES, signal) == pytest.approx(F1, rel=1e-3)


@pytest.mark.parametrize("decay", [500.0, 2000.0, 5000.0])
def test_first_natural_frequency_of_a_damped_motion(decay):
    """Damping -alpha m v lowers the frequency of every mode: f_d^2 = f^2 - (alpha / 4 pi)^2, decay alpha/2."""
    damped = np.sqrt(F1**2 - (decay / (2 * np.pi)) ** 2)
    signal = 1 - tone(damped, 0.3, decay) + 0.1 * tone(16e3, 1.0, decay)
    assert first_frequency(TIMES, signal) == pytest.approx(F1, rel=1e-6)


def test_first_frequency_of_a_motion_that_has_come_to_rest():
    t = np.linspace(0, 5e-3, 1501)
    damped = np.sqrt(F1**2 - (5000 / (2 * np.pi)) ** 2)
    noise = 1e-4 * np.random.default_rng(2).standard_normal(t.size)
    signal = 1 - np.exp(-5000 * t) * np.cos(2 * np.pi * damped * t) + noise
    assert first_frequency(t, signal) == pytest.approx(F1, rel=1e-3)


def test_first_frequency_of_a_very_long_record():
    t = np.linspace(0, 1.2e-3, 200_001)
    assert first_frequency(t, 1 - np.cos(2 * np.pi * F1 * t)) == pytest.approx(F1, rel=1e-4)


def test_first_frequency_of_g_itself_whose_square_holds_twice_the_frequency():
    assert first_frequency(TIMES, (1 - tone(F1, 0)) ** 2) == pytest.approx(F1, rel=1e-6)


def test_first_frequency_needs_an_oscillation():
    with pytest.raises(ValueError, match="no oscillation"):
        first_frequency(TIMES, np.ones_like(TIMES))


def test_modes_have_the_amplitudes_and_decays_put_in():
    low, high = sorted(fit_modes(TIMES, 4 + 2 * tone(F1, 0.3, 300.0) + 0.5 * tone(16e3, 1.0, 900.0)))
    assert low == pytest.approx((F1, 300.0, 2.0), rel=1e-6)
    assert high == pytest.approx((16e3, 900.0, 0.5), rel=1e-6)


@pytest.mark.parametrize("distance, known, is_moving", [
    (None, None, False), (np.nan, None, False), (0.0, 0.0, False), (0.01, 0.01, False), (0.02, 0.02, True), (np.inf, np.inf, True)])
def test_distance_from_rest(tmp_path, distance, known, is_moving):
    history = History(write_result(tmp_path / "a.h5", distance=distance))
    assert (history.distance_to_equilibrium(), history.is_moving()) == (known, is_moving)


def test_patterns_mean_estimated_errors_where_they_say_so(tmp_path):
    columns = {name: np.zeros(3) for name in ("time", "G_a_I", "G_a_I_error", "K_I", "K_I_error", "error_estimate")}
    history = History(write_result(tmp_path / "a.h5", columns))
    assert history.select(["G_*"]) == ["G_a_I"] and history.select(["G_*_error"]) == ["G_a_I_error"]
    assert sorted(history.select(["*"])) == sorted(columns) and history.select(["K_I_error"]) == ["K_I_error"]
    assert history.select(["*estimate"]) == ["error_estimate"]
    assert (history.error_of("G_a_I"), history.error_of("error_estimate")) == ("G_a_I_error", None)


@pytest.mark.parametrize(("text", "words"), [("", "no rows"), ("# only words\n", "no rows"), ("time,G\n1,nan\n", "not finite"),
                                             ("1,x\n", "not rows of time"), ("1\n", "not rows of time"), ("\xff\xfe", "not rows of time")])
def test_reference_curves_that_are_none(tmp_path, text, words):
    (tmp_path / "a.csv").write_bytes(text.encode("latin-1"))
    with pytest.raises(ResultError, match=words):
        read_curve(tmp_path / "a.csv")


def test_results_of_version_1_have_the_present_names(tmp_path):
    old = {"time": dcb()["time"], "G_nodal_force_I": dcb()["G_vcct_I"], "G_nodal_force_I_error_tip2": dcb()["G_vcct_I"], "J_spread": dcb()["step"]}
    with h5py.File(write_result(tmp_path / "old.h5", old, distance=None), "a") as file:
        file["history"].attrs["distance_from_rest"] = 0.5
    history = History(tmp_path / "old.h5")
    assert set(history.columns) == {"time", "G_vcct_I", "G_vcct_I_error_tip2", "J_domain_dependence"} and history.is_moving()
    assert history.select(["G_*"]) == ["G_vcct_I"] and history.units["G_vcct_I"] == "J/m2"
