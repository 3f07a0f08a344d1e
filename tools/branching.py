"""Draw speed and criteria of branching of a crack over its length, of docs/explanation/resistance.md.

    python tools/branching.py results/figures/pmma_strip.h5 branching.png
"""

import sys

import h5py
import matplotlib.pyplot as plt


def main(result, picture):
    with h5py.File(result) as file:
        tip, speed, energy, angle = (file["history"][name][:] for name in ("tip_x", "speed_ratio", "branching_energy", "hoop_angle"))
    figure, axes = plt.subplots(figsize=(6.5, 3.2), layout="constrained")
    axes.axhspan(0.4, 0.7, color="0.9", label="speeds at which cracks branch")
    axes.plot(1e3 * tip, speed, label="speed over that of Rayleigh waves")
    axes.plot(1e3 * tip, energy, label="energy over that of two tips")
    axes.plot(1e3 * tip, angle / 90, label="angle of the largest hoop stress over 90 degrees")
    axes.axhline(1, color="0.5", linewidth=0.7)
    for column, least in ((energy, 1), (angle, 1e-9)):
        first = next(k for k, value in enumerate(column) if value >= least)
        axes.plot(1e3 * tip[first], speed[first], "o", color="C3", markersize=5, label="warnings" if least == 1 else None)
    axes.set(xlabel="growth [mm]", xlim=(0, 15), ylim=(0, 3.2), title="A crack in a strip of PMMA")
    axes.legend(frameon=False, fontsize=8, loc="upper left")
    figure.savefig(picture, dpi=85)


if __name__ == "__main__":
    main(*sys.argv[1:])
