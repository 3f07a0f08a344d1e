"""Draw the load over the displacement of a load frame, of the two specimens of docs/explanation/growth.md, beside closed forms.

    python tools/load_frame.py results/figures/dcb_snap_back.h5 results/figures/compact_tension_growth.h5 load_frame.png
"""

import math
import sys

import h5py
import matplotlib.pyplot as plt
import numpy as np

YOUNG, WIDTH, DEPTH, LONGER, STIFFNESS = 70e9, 0.01, 0.01, 6.73e-3, 0.5e6  # of the beam and its frame


def column(path, *names):
    with h5py.File(path) as file:
        return [file["history"][name][:] for name in names]


def main(beam, specimen, picture):
    plt.rcParams["svg.hashsalt"] = "load_frame"
    figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.4), layout="constrained")
    a = np.linspace(0.03, 0.055, 200)
    load = WIDTH * math.sqrt(YOUNG * DEPTH**3 / 12) / (a + LONGER)
    compliance = 8 * (a + LONGER) ** 3 / (YOUNG * WIDTH * DEPTH**3)
    left.plot(1e6 * load * (compliance + 1 / STIFFNESS), load, color="0.6", label="beams longer by 0.673 depths")
    found, way = column(beam, "load", "frame_displacement")
    left.plot(np.append(0, 1e6 * way), np.append(0, found), "o-", markersize=3, label="hampm")
    left.set(xlabel="displacement of the frame [µm]", ylabel="load [N]", title="Double cantilever beam, soft frame")
    found, way, tip = column(specimen, "load", "load_displacement", "tip_x")
    alpha = tip[14] / 0.05
    astm = ((1 + alpha) / (1 - alpha)) ** 2 * np.polyval([-9.9314, 20.609, -0.9925, -20.065, 12.219, 2.163], alpha)
    right.plot(1e3 * np.array([0, found[14]]) * (astm + 2.2) / (210e9 / 0.91 * 25e-3), np.array([0, found[14]]) / 1e3, color="0.6", label="ASTM E1820 and holes")
    right.plot(1e3 * way, found / 1e3, "o-", markersize=3, label="hampm")
    right.set(xlabel="displacement of the load [mm]", ylabel="load [kN]", title="Compact tension, unloaded once")
    for axes in (left, right):
        axes.legend(frameon=False)
        axes.set(xlim=(0, None), ylim=(0, None))
    figure.savefig(picture, dpi=85)


if __name__ == "__main__":
    main(*sys.argv[1:])
