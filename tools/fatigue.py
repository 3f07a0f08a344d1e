"""Draw lengths of cracks over load cycles and the rate after an overload, of scenes of docs/explanation/fatigue.md, beside the reference.

    python tools/fatigue.py results/figures/fatigue_eccentric_crack.h5 results/figures/fatigue_overload.h5 fatigue.png
"""

import sys
from pathlib import Path

import h5py
import matplotlib.pyplot as plt
import numpy as np

REFERENCE = Path(__file__).resolve().parents[1] / "tests/reference/growth/g2_fatigue_eccentric_crack.csv"
CONSTANT, EXPONENT = 1e-29, 3.0  # of the rate


def column(path, *names):
    with h5py.File(path) as file:
        return [file["history"][name][:] for name in names]


def main(eccentric, overload, picture):
    plt.rcParams["svg.hashsalt"] = "fatigue"
    figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.4), layout="constrained")
    count, fast, slow, *_ = np.genfromtxt(REFERENCE, delimiter=",", skip_header=2, unpack=True)
    cycles, x, other = column(eccentric, "cycles", "tip_x", "tip_x_tip2")
    for reference, found, name, colour in ((-fast, -1e3 * other, "tip at the left", "C0"), (slow, 1e3 * x, "tip at the right", "C1")):
        left.plot(count / 1e3, reference - 10, color="0.6", label="reference" if colour == "C0" else None)
        left.plot(cycles / 1e3, found - 10, "o", markersize=3, color=colour, label=name)
    left.set(xlabel="thousands of cycles", ylabel="growth [mm]", title="A crack beside the middle")
    a, rate, ranges = column(overload, "crack_length", "growth_rate", "delta_K")
    right.plot(1e3 * a, 1e9 * CONSTANT * ranges**EXPONENT, color="0.6", label="Paris, without retardation")
    right.plot(1e3 * a, 1e9 * rate, "o-", markersize=3, label="hampm, after the overload")
    right.set(xlabel="half length of the crack [mm]", ylabel="rate [nm/cycle]", title="An overload of 1.6 times the load", xlim=(10, 20), ylim=(0, 170))
    left.set(xlim=(0, None), ylim=(0, None))
    for axes in (left, right):
        axes.legend(frameon=False)
    figure.savefig(picture, dpi=85)


if __name__ == "__main__":
    main(*sys.argv[1:])
