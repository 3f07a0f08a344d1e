"""Draw the models of docs/explanation/resistance.md beside closed forms: resistance curves at rest and in slow motion, mixed-mode bending, and a zigzag.

    python tools/resistance.py results/figures resistance.png
"""

import sys
from pathlib import Path

import h5py
import matplotlib.pyplot as plt
import numpy as np

CURVE = np.array([0, 2.5, 5, 7.5, 10, 25]), np.array([100, 180, 240, 280, 300, 300])  # [mm], [J/m2]


def column(path, *names):
    with h5py.File(path) as file:
        return [file["history"][name][:] for name in names]


def main(folder, picture):
    folder = Path(folder)
    figure, (left, middle, right) = plt.subplots(1, 3, figsize=(11, 3.3), layout="constrained")
    way = np.linspace(0, 25, 300)
    load = 0.01 * np.sqrt(np.interp(way, *CURVE) * 70e9 * 0.01**3 / 12) / (0.03673 + way / 1e3)
    left.plot(way, load, color="0.6", label="beams longer by 0.673 depths")
    factor, tip = column(folder / "dcb_r_curve.h5", "load_factor", "tip_x")
    left.plot(1e3 * tip - 30, 100 * factor, "o", markersize=3.5, label="at rest")
    force, tip = column(folder / "dcb_r_curve_slow.h5", "reaction_upper_y", "tip_x")
    left.plot(1e3 * tip - 30, force, ".", markersize=3, label="in slow motion")
    left.set(xlabel="growth [mm]", ylabel="load [N]", title="Resistance curve", ylim=(0, None), xlim=(-1, 25))
    factor, tip = column(folder / "laminate_mmb_growth.h5", "load_factor", "tip_x")
    a = np.linspace(25, 41, 100) / 1e3
    one, two = 3 * 0.085**2 * (a + 3.756e-3) ** 2 / (4 * 0.05**2 * 1120), 9 * 0.095**2 * (a + 1.5775e-3) ** 2 / (16 * 0.05**2 * 1120)
    for toughness, text, style in ((277 + 511 * (two / (one + two)) ** 1.6, "beams, Benzeggagh & Kenane", "-"), (277 + 0 * a, "beams, mode I alone", ":")):
        middle.plot(1e3 * a, np.sqrt(toughness / (one + two)) / 1e3, style, color="0.6", label=text)
    middle.plot(1e3 * tip, 8 * factor, "o", markersize=3.5, label="hampm")
    middle.set(xlabel="length [mm]", ylabel="load [N/mm]", title="Mixed-mode bending", ylim=(0, None))
    x, y = column(folder / "zigzag.h5", "tip_x", "tip_y")
    right.plot(1e3 * x, 1e3 * y, ".-", linewidth=1, markersize=4, label="hampm, tips of each row")
    for side in (-1, 1):
        right.plot([0, 1.2], [1.6, 1.6 + side * 1.2 * np.tan(np.radians(40))], color="0.6", label="weak planes" if side > 0 else None)
    right.set(xlabel="x [mm]", ylabel="y [mm]", title="Zigzag", aspect="equal", xlim=(-1, 13), ylim=(-1.5, 4.5))
    for axes in (left, middle, right):
        axes.legend(frameon=False, fontsize=8)
    figure.savefig(picture, dpi=85)


if __name__ == "__main__":
    main(*sys.argv[1:])
