"""Draw the temperature at which a film peels over how far it has come off, and the length of a crack over the opening of the wedge that drives it, beside closed forms.

    python tools/peel_and_wedge.py results/figures/peeling_film.h5 results/figures/wedge_dcb.h5 peel_and_wedge.png
"""

import sys

import h5py
import matplotlib.pyplot as plt
import numpy as np

FILM, BASE = 200e9 / (1 - 0.25**2) * 1e-6, 100e9 / (1 - 0.3**2) * 10e-6  # stiffness of each layer [N/m]
MISFIT, PEELS = (1.25 * 0.5e-3 - 1.3 * 1.5e-3) / 100, 2.0  # of free strains [1/K], toughness [J/m2]
ARM, DEPTH, WIDTH, TOUGHNESS = 3.3e9 / (1 - 0.35**2), 0.01, 0.01, 300.0  # of the beam


def column(path, *names):
    with h5py.File(path) as file:
        return [file["history"][name][:] for name in names]


def main(film, wedge, picture):
    figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.4), layout="constrained")
    factor, tip = column(film, "load_factor", "tip_x")
    for stiffness, label, style in ((FILM * BASE / (FILM + BASE), "steady state", "-"), (FILM, "the same on a thick substrate", ":")):
        left.axhline(np.sqrt(2 * PEELS / stiffness) / abs(MISFIT), color="0.6", linestyle=style, label=label)
    left.plot(1e6 * tip, 100 * factor, "o-", markersize=3, label="hampm")
    left.set(xlabel="film that has come off [µm]", ylabel="temperature [K]", title="A film that is heated", ylim=(0, None), xlim=(0, None))
    upper, lower, tip, energy = column(wedge, "displacement_upper_y", "displacement_lower_y", "tip_x", "fracture_energy")
    opening = upper - lower
    d = np.linspace(1e-6, opening.max(), 200)
    length = (3 * ARM * DEPTH**3 * d**2 / (16 * TOUGHNESS)) ** 0.25 - 0.673 * DEPTH
    right.plot(1e3 * d, 1e3 * np.maximum(length, tip[0]), color="0.6", label="beams longer by 0.673 depths")
    right.plot(1e3 * opening, 1e3 * tip, "o", markersize=2, label="tip")
    right.plot(1e3 * opening, 1e3 * (tip[0] + energy / (TOUGHNESS * WIDTH)), "o", markersize=2, label="length by the energy taken")
    right.set(xlabel="opening of the lips [mm]", ylabel="length of the crack [mm]", title="A wedge in a double cantilever beam", ylim=(0, None), xlim=(0, None))
    for axes in (left, right):
        axes.legend(frameon=False)
    figure.savefig(picture, dpi=85)


if __name__ == "__main__":
    main(*sys.argv[1:])
