"""A cracked beam on two anvils that is struck in its middle, by the theory of beams: what `input/one_point_bend.nml` is compared with.

    .venv/bin/python tools/references/one_point_bend.py results/one_point_bend.h5 [picture.png]

Half of the beam is one of Timoshenko, its crack a spring between the halves (Tada, Paris & Irwin, angle of a beam in bending), and K that of the moment in it at the
moment, as at rest. The striker is a rod, and rod and anvils only push. The rod touches by a spring stiffer than its elements; an anvil is the spring of its column,
E' B 4/6, in series with one of about as much for what beam and anvil give way where they touch. Steps are central differences.
"""

import math
import sys

import h5py
import numpy as np

YOUNG, POISSON, DENSITY = 210e9, 0.3, 7850.0
LENGTH, DEPTH, WIDTH, CRACK = 0.12, 0.02, 0.01, 0.006      # of the beam
ROD, ROD_LENGTH, SPEED = 0.01, 0.08, 5.0
ANVIL = 0.056                                              # from the middle


def angle_of_crack(x):
    """V_2 of the angle 4 s/E V_2 by which a crack of the part x of the depth turns a beam with the bending stress s."""
    return (x / (1 - x))**2 * np.polyval([13.12, -35.84, 37.14, -19.69, 5.93], x)


def k_by_moment(moment):
    """K_I of a beam in bending (Tada, Paris & Irwin)."""
    x = CRACK / DEPTH
    half = math.pi * x / 2
    shape = math.sqrt(math.tan(half) / half) * (0.923 + 0.199 * (1 - math.sin(half))**4) / math.cos(half)
    return 6 * moment / (WIDTH * DEPTH**2) * math.sqrt(math.pi * CRACK) * shape


def struck_beam(end=100e-6, elements=60, has_anvils=True):
    """Times [s] and there: K_I, displacement of the middle, displacement over the anvil, force of the striker, force of an anvil."""
    young = YOUNG / (1 - POISSON**2)
    h, area, inertia = LENGTH / 2 / elements, WIDTH * DEPTH, WIDTH * DEPTH**3 / 12
    shear = 1 / (1 / (5 / 6 * YOUNG / (2 + 2 * POISSON) * area) + h**2 / (12 * young * inertia))
    bend, slide = np.array([0, -1 / h, 0, 1 / h]), np.array([-1 / h, -0.5, 1 / h, -0.5])
    element = young * inertia * h * np.outer(bend, bend) + shear * h * np.outer(slide, slide)
    stiffness, mass = np.zeros((2 * elements + 2,) * 2), np.zeros(2 * elements + 2)
    for k in range(elements):
        stiffness[2 * k:2 * k + 4, 2 * k:2 * k + 4] += element
        mass[2 * k:2 * k + 4] += DENSITY * h / 2 * np.array([area, inertia, area, inertia])
    spring = WIDTH * DEPTH**2 * young / (24 * angle_of_crack(CRACK / DEPTH))
    stiffness[1, 1] += 2 * spring                          # moment of the crack: spring times twice the turn of a half
    parts = round(ROD_LENGTH / h)
    rod_spring = young * ROD * WIDTH / 2 / h
    rod_mass = np.full(parts + 1, DENSITY * ROD * WIDTH / 2 * h)
    rod_mass[[0, -1]] /= 2
    touch, anvil_spring = 2 * rod_spring, 0.3 * young * WIDTH
    dt = 0.2 * h / math.sqrt(young / DENSITY)
    over = 2 * round(ANVIL / h)
    u, v, rod, rod_v = np.zeros(len(mass)), np.zeros(len(mass)), np.zeros(parts + 1), np.full(parts + 1, -SPEED)
    found = []
    for step in range(1, int(end / dt) + 1):
        pull, rod_pull = -stiffness @ u, np.zeros(parts + 1)
        tension = rod_spring * np.diff(rod)
        rod_pull[:-1] += tension
        rod_pull[1:] -= tension
        strike, anvil = touch * max(0.0, u[0] - rod[0]), anvil_spring * max(0.0, -u[over]) * has_anvils
        pull[0] -= strike
        rod_pull[0] += strike
        pull[over] += anvil
        v, rod_v = v + dt * pull / mass, rod_v + dt * rod_pull / rod_mass
        u, rod = u + dt * v, rod + dt * rod_v
        found.append((step * dt, k_by_moment(2 * spring * u[1]), u[0], u[over], 2 * strike, anvil))
    return np.array(found).T


def main(result, picture=None):
    with h5py.File(result) as file:
        run = {name: column[:] for name, column in file["history"].items()}
    beam = struck_beam(run["time"][-1])
    pairs = [("K_I [MPa m^0.5]", 1e-6, "K_I", 1), ("above the anvil [um]", 1e6, "displacement_anvil_y", 3), ("on an anvil [kN]", 1e-3, "reaction_left_y", 5)]
    for t in np.arange(10e-6, run["time"][-1] + 1e-9, 10e-6):
        print(f"{1e6 * t:5.0f} us", *(f"  {what} {scale * np.interp(t, run['time'], run[name]):7.2f} beam {scale * np.interp(t, beam[0], beam[k]):7.2f}" for what, scale, name, k in pairs))
    if picture is None:
        return
    import matplotlib.pyplot as plt
    figure, all_axes = plt.subplots(1, 3, figsize=(9, 2.8), layout="constrained")
    for axes, (what, scale, name, k) in zip(all_axes, pairs):
        axes.plot(1e6 * beam[0], scale * beam[k], color="0.6", label="beam")
        axes.plot(1e6 * run["time"], scale * run[name], label="hampm")
        axes.set(xlabel="time [µs]", ylabel=what.replace("um", "µm").replace("m^0.5", "√m"), xlim=(0, 1e6 * run["time"][-1]))
        axes.axhline(0, color="0.8", linewidth=0.5, zorder=0)
    all_axes[0].legend(frameon=False)
    figure.savefig(picture, dpi=85)


if __name__ == "__main__":
    main(*sys.argv[1:])
