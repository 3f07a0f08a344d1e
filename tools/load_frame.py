"""Draw the load over the displacement of a load frame, of the specimens of docs/explanation/growth_loads.md, beside closed forms.

    python tools/load_frame.py dcb_snap_back.h5 els.h5 compact_tension_growth.h5 load_frame.png
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


def main(beam, split, specimen, picture):
    plt.rcParams["svg.hashsalt"] = "load_frame"
    figure, (left, middle, right) = plt.subplots(1, 3, figsize=(11, 3.2), layout="constrained")
    a = np.linspace(0.03, 0.055, 200)
    load = WIDTH * math.sqrt(YOUNG * DEPTH**3 / 12) / (a + LONGER)
    compliance = 8 * (a + LONGER) ** 3 / (YOUNG * WIDTH * DEPTH**3)
    left.plot(1e6 * load * (compliance + 1 / STIFFNESS), load, color="0.6", label="beams longer by 0.673 depths")
    found, way = column(beam, "load", "frame_displacement")
    left.plot(np.append(0, 1e6 * way), np.append(0, found), "o-", markersize=3, label="hampm")
    left.set(xlabel="displacement of the frame [µm]", ylabel="load [N]", title="Double cantilever beam, soft frame")
    a, depth, length = np.linspace(0.03, 0.07, 200) + 0.28 * 3e-3, 3e-3, 0.1
    load = math.sqrt(4 * 100 * YOUNG * WIDTH**2 * depth**3 / 9) / a
    middle.plot(1e3 * load * ((3 * a**3 + length**3) / (2 * YOUNG * WIDTH * depth**3) + 1.2 * length / (2 * YOUNG / 2.6 * WIDTH * depth)), load, color="0.6",
                label="beams longer by 0.28 h")
    found, way = column(split, "load", "load_displacement")
    middle.plot(np.append(0, 1e3 * way), np.append(0, found), "o-", markersize=3, label="hampm")
    middle.set(xlabel="displacement of the end [mm]", ylabel="load [N]", title="End-loaded split")
    found, way, tip = column(specimen, "load", "load_displacement", "tip_x")
    alpha = tip[14] / 0.05
    astm = ((1 + alpha) / (1 - alpha)) ** 2 * np.polyval([-9.9314, 20.609, -0.9925, -20.065, 12.219, 2.163], alpha)
    right.plot(1e3 * np.array([0, found[14]]) * (astm + 2.2) / (210e9 / 0.91 * 25e-3), np.array([0, found[14]]) / 1e3, color="0.6", label="ASTM E1820 and holes")
    right.plot(1e3 * way, found / 1e3, "o-", markersize=3, label="hampm")
    right.set(xlabel="displacement of the load [mm]", ylabel="load [kN]", title="Compact tension, unloaded once")
    for axes in (left, middle, right):
        axes.legend(frameon=False)
        axes.set(xlim=(0, None), ylim=(0, None))
    figure.savefig(picture, dpi=85)


if __name__ == "__main__":
    main(*sys.argv[1:])
