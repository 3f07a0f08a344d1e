"""Curves over time: filters that do not move them, means over windows, natural frequencies of records of a few periods.

`read_curve` reads a reference curve; `lowpass` removes what is above a frequency without moving the rest in time; `moving_mean`
averages over a window; `first_frequency` finds the first natural frequency of an oscillation of which only a few periods are known.
"""

from pathlib import Path
from typing import NamedTuple

import numpy as np

from .arrays import Array, Reals
from .errors import UNREADABLE, ResultError

class Mode(NamedTuple):
    """amplitude * exp(-decay * t) * cos(2 pi frequency t + phase); frequency [Hz], decay [1/s]."""

    frequency: float
    decay: float
    amplitude: float


def read_curve(path: str | Path, column: int = 1) -> Reals:
    """Times [s] and values: the first and another column of a CSV file with # comments, perhaps with names above them."""
    try:
        with open(path) as file:
            rows = [line for line in file if line.strip() and not line[0].isalpha() and not line.lstrip().startswith("#")]
        curve = np.loadtxt(rows, delimiter=",", usecols=(0, column), unpack=True, ndmin=2) if rows else np.empty((2, 0))
    except OSError as error:
        raise ResultError(f"{path}: cannot be read ({error.strerror or error})", UNREADABLE) from error
    except ValueError as error:
        raise ResultError(f"{path}: not rows of time and values ({error})", UNREADABLE) from error
    if not curve.size or not np.all(np.isfinite(curve)):
        raise ResultError(f"{path}: {'has values that are not finite' if curve.size else 'has no rows of time and values'}", UNREADABLE)
    return curve


def moving_mean(t: Array, y: Array, width: float) -> Reals:
    """Mean of y(t), linear between the samples, over a window of this width around each t; near the ends over what there is
    of the window."""
    t, y = np.asarray(t, dtype=float), np.asarray(y, dtype=float)
    ends = np.clip([t - width / 2, t + width / 2], t[0], t[-1])
    knots = np.unique(np.concatenate([t, *ends]))
    values = np.interp(knots, t, y)
    total = np.concatenate([[0.0], np.cumsum((values[1:] + values[:-1]) / 2 * np.diff(knots))])
    first, last = np.interp(ends, knots, total)
    return (last - first) / (ends[1] - ends[0])


def lowpass(t: Array, y: Array, cutoff: float, order: int = 4) -> Reals:
    """Remove from y(t) what is above `cutoff` [Hz], without shifting the rest in time.

    The gain is that of a Butterworth filter of the given order run forwards and backwards,
    1/(1 + (f/cutoff)^(2 order)): 1/2 at the cutoff, 1 - 1e-8 at a tenth of it, 0.004 at twice it. At its ends the
    signal is continued by point reflection (y(-t) = 2 y(0) - y(t)), which keeps its value and slope; it is filtered as
    the straight line through its end points, which passes unchanged, plus a sine series. The first and last sample are
    therefore kept, and within two periods of the cutoff of them high frequencies are only partly removed. Unequal
    steps are interpolated linearly.
    """
    t, y = np.asarray(t, dtype=float), np.asarray(y, dtype=float)
    if cutoff <= 0:
        raise ValueError("cutoff must be positive")
    if t.size < 3:
        return y.copy()
    uniform = np.linspace(t[0], t[-1], t.size)
    line = y[0] + (y[-1] - y[0]) * (uniform - t[0]) / (t[-1] - t[0])
    odd = np.interp(uniform, t, y) - line
    spectrum = np.fft.rfft(np.concatenate([odd, -odd[-2:0:-1]]))
    frequency = np.fft.rfftfreq(2 * t.size - 2, uniform[1] - uniform[0])
    with np.errstate(over="ignore"):
        gain = 1 / (1 + (frequency / cutoff) ** (2 * order))
    filtered = np.fft.irfft(spectrum * gain, 2 * t.size - 2)[: t.size] + line
    return np.interp(t, uniform, filtered)


def first_frequency(t: Array, y: Array) -> float:
    """First natural frequency [Hz] of y(t), undamped or decaying, from about three periods or more.

    The lowest mode of `fit_modes` that completes a period in the record and has at least 5 % of the strongest one's
    amplitude. Of a mode with decay d the undamped natural frequency is returned, sqrt(f^2 + (d/2 pi)^2). An energy or
    a G is quadratic in the motion: take sign(G) sqrt|G|, or the crack opening.
    """
    modes = [mode for mode in fit_modes(t, y) if mode.frequency * (t[-1] - t[0]) >= 1]
    if not modes:
        raise ValueError("no oscillation of at least one period found")
    strongest = max(mode.amplitude for mode in modes)
    mode = min(mode for mode in modes if mode.amplitude >= 0.05 * strongest)
    return float(np.hypot(mode.frequency, mode.decay / (2 * np.pi)))


def fit_modes(t: Array, y: Array, most: int = 8, accuracy: float = 1e-6) -> list[Mode]:
    """Fit y(t) by a constant and up to `most` decaying harmonics, by least squares.

    Modes are added one by one at the highest peak of the residual's spectrum, and after each addition all frequencies
    and decays are refined together by Gauss-Newton, so that neighbours do not bias each other as they do in a
    spectrum of a few periods. Ends when the residual is below `accuracy` of the signal.
    """
    t, y = _averaged(*_without_rest(np.asarray(t, dtype=float), np.asarray(y, dtype=float)))
    start, span = t[0], t[-1] - t[0]
    s = (t - start) / span  # the record on [0, 1]; rates below are per record
    signal = np.std(y)
    rates: Array = np.empty(0, dtype=complex)  # decay + i omega
    residual = y - np.mean(y)
    while rates.size < most and np.std(residual) > accuracy * signal:
        rates = _refined(s, y, np.append(rates, 1j * _peak(s, residual)))
        residual = _solved(s, y, rates)[1]
    pairs = _solved(s, y, rates)[0][1:].reshape(-1, 2)
    return [Mode(abs(rate.imag) / (2 * np.pi * span), rate.real / span, float(np.hypot(*pair)))
            for rate, pair in zip(rates, pairs)]


def _without_rest(t: Reals, y: Reals) -> tuple[Reals, Reals]:
    """The record up to where it stays within 2 % of its last value: a body at rest says nothing about frequencies."""
    moving = np.abs(y - y[-1]) > 0.02 * np.ptp(y)
    last = np.max(np.nonzero(moving)[0], initial=0) + 1
    return (t[: last + 1], y[: last + 1]) if last > 1 else (t, y)


def _averaged(t: Reals, y: Reals, most: int = 4000) -> tuple[Reals, Reals]:
    """Means over blocks of equal length: long records hold far more samples than a low mode needs."""
    block = -(-t.size // most)
    usable = t.size - t.size % block
    return t[:usable].reshape(-1, block).mean(axis=1), y[:usable].reshape(-1, block).mean(axis=1)


def _peak(s: Reals, residual: Reals) -> float:
    """Angular frequency of the highest peak of the spectrum, at least half a period in the record."""
    uniform = np.interp(np.linspace(0, 1, s.size), s, residual)
    padding = 8
    spectrum = np.abs(np.fft.rfft(uniform, padding * s.size))
    lowest = padding // 2
    return 2 * np.pi * (lowest + np.argmax(spectrum[lowest:])) / padding * (s.size - 1) / s.size


def _harmonics(s: Reals, rates: Array) -> Reals:
    """Columns exp(-d s) cos(w s), exp(-d s) sin(w s) of every rate d + i w, side by side."""
    waves = np.exp(np.outer(s, -rates.real + 1j * rates.imag))
    return np.stack([waves.real, waves.imag], axis=2).reshape(s.size, -1)


def _solved(s: Reals, y: Reals, rates: Array) -> tuple[Reals, Reals]:
    """Coefficients of the constant and the harmonics that fit y best, and the residual."""
    basis = np.column_stack([np.ones_like(s), _harmonics(s, rates)])
    coefficients: Reals = np.linalg.lstsq(basis, y, rcond=None)[0].astype(float)
    return coefficients, y - basis @ coefficients


def _refined(s: Reals, y: Reals, rates: Array, iterations: int = 30) -> Array:
    """Gauss-Newton on all rates at once, with the step halved until the residual falls."""
    coefficients, residual = _solved(s, y, rates)
    for _ in range(iterations):
        harmonics = _harmonics(s, rates)
        a, b = coefficients[1::2], coefficients[2::2]
        cosine, sine = harmonics[:, ::2], harmonics[:, 1::2]
        by_decay = -s[:, None] * (a * cosine + b * sine)
        by_omega = s[:, None] * (b * cosine - a * sine)
        tangent = np.column_stack([np.ones_like(s), harmonics, by_decay, by_omega])
        correction = np.linalg.lstsq(tangent, residual, rcond=1e-10)[0][1 + 2 * rates.size:]
        step = correction[: rates.size] + 1j * correction[rates.size:]
        step *= min(1.0, (np.pi / 2) / max(np.abs(step).max(), 1e-300))
        for _ in range(6):
            new_coefficients, new_residual = _solved(s, y, rates + step)
            if new_residual @ new_residual < residual @ residual:
                break
            step /= 2
        else:
            return rates
        rates, coefficients, residual = rates + step, new_coefficients, new_residual
        if np.abs(step).max() < 1e-9:
            break
    return rates
