"""Cracked plates in the total frame with cells refined around their tips, at random, with time steps that fit the size of the cells
(`time_steps = 'local'`, leapfrog steps), and with common ones.

At the limit of the courant number the energy must not grow, and with a quarter of it the motion is that with short common steps, about as well as with
common steps of half of it: the error is that of the large cells, which falls with the square of the step.

    .venv/bin/python tests/fuzz/local_scenes.py --cases 1000 --seed 2 --program build/checked/hampm
"""

import re
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np
from runs import PROGRAM, try_run
from scene_fuzzer import main

GROWTH = 3.0  # times that with common steps, of what the balance of energy misses, from the first half of a run to the second
WORSE, FLOOR = 2.5, 0.04  # times the error that common steps of that courant number have, and what is always allowed
NEARLY = 0.999  # of the limit of the courant number


def scene(chance):
    """A plate with a crack along a grid line, loaded at its ends."""
    cell = chance.choice([1e-3, 0.25])
    wide, high = chance.randint(4, 14), chance.randint(2, 8)
    young = [10**chance.uniform(9, 11)]
    young.append(young[0] * chance.choice([1, 1, 0.3, 3]))
    speed = (max(young) / 1000)**0.5
    origin = [cell * chance.choice([0, -3, 0.25 * chance.randint(0, 3)]) for _ in "xy"]
    start = [x + 2 * cell for x in origin]
    plane, points = chance.choice(["stress", "strain"]), chance.choice([2, 2, 2, 4])
    edge = chance.choice([0, 0, 0.25, 0.5])  # how far bodies reach beyond a grid line
    low, up = start, [start[0] + (wide + edge) * cell, start[1] + (high + edge) * cell]
    middle = start[0] + chance.randint(1, wide - 1) * cell
    text = "".join(f"&material name = 'm{k}'  young = {value}  poisson = {chance.choice([0, 0.2, 0.3, 0.45])}  "
                   f"density = {chance.choice([1000, 3000])} /\n" for k, value in enumerate(young))
    text += f"&body material = 'm0'  lower = {low[0]}, {low[1]}  upper = {middle}, {up[1]}  points_per_cell = {points} /\n"
    text += f"&body material = 'm{chance.randint(0, 1)}'  lower = {middle}, {low[1]}  upper = {up[0]}, {up[1]}  points_per_cell = {points} /\n"
    kind = chance.choice(["symmetry", "line", "none"])
    levels = chance.randint(1, 5)
    tip = start[0] + chance.randint(1, wide - 1) * cell
    if kind == "symmetry":
        text += f"&crack tip = {tip}, {low[1]} /\n&constraint lower = {tip}, {low[1]}  upper = {up[0]}, {low[1]}  fix = 'y' /\n"
    elif kind == "line":
        row = low[1] + chance.randint(1, high - 1) * cell
        text += f"&crack kind = 'line'  tip = {tip}, {row}  length = {tip - low[0]} /\n"
    if kind == "none":
        text += f"&constraint lower = {low[0]}, {low[1]}  upper = {low[0]}, {up[1]}  fix = 'xy' /\n"
    else:
        text += f"&refine indicator = 'tip'  rings = {chance.randint(1, 4)}  max_level = {levels} /\n"
        text += "&energy_release estimators = 'vcct', 'domain_integral' /\n"
    end = chance.uniform(5, 40) * max(wide, high) * cell / speed
    force = young[0] * cell**2 * 1e-4
    history = chance.choice(["", "", f"history = 'ramp'  rise_time = {end * 0.3}", f"history = 'sine'  frequency = {3 / end}"])
    text += f"&load kind = 'traction'  lower = {middle}, {up[1]}  upper = {up[0]}, {up[1]}  force = {chance.choice([0, force])}, {force}  {history} /\n"
    if chance.random() < 0.3:
        text += f"&load kind = 'gravity'  acceleration = 0, {-force / cell**3 / 1000} /\n"
    if chance.random() < 0.5:
        text += f"&damping rate = {chance.random() * 10 / end} /\n"
    samples = chance.randint(10, 40)
    snapshots = chance.choice([1, 2, 5, 2.5])
    return text + f"""&run plane = '{plane}'  thickness = {cell}  end_time = {end} /
&grid lower = {origin[0]}, {origin[1]}  cell = {cell}  cells = {wide + 5}, {high + 5} /
&method frame = 'total'  scheme = 'musl'  time_steps = 'local'  courant = 0 /
&output file = 'case.h5'  history_interval = {end / samples}  snapshot_interval = {end / samples * snapshots} /
"""


def result(path):
    """Displacements of the particles, by where they started, at the last snapshot, and by how much more the balance of energy misses in the second
    half of the samples than in the first."""
    with h5py.File(path) as file:
        data, n = file["VTKHDF/particles"], file["VTKHDF/particles/NumberOfPoints"][-1]
        displacement = data["PointData/displacement"][-n:]
        start = np.round((data["Points"][-n:] - displacement) / np.ptp(data["Points"][-n:]), 7)  # numbers are given as cells refine, in another order
        kinetic, strain, work, damped = (file["history"][name][()] for name in ("kinetic_energy", "strain_energy", "external_work",
                                                                                 "damping_loss"))
    missed, half = np.abs(kinetic + strain + damped - work) / np.max(kinetic + strain), len(work) // 2
    return displacement[np.lexsort(start.T)], np.max(missed[half:]) / max(np.max(missed[:half]), 1e-4)


def look(folder, text):
    """What is wrong with a result; '' where nothing is. Runs the scene with the longest local steps that there are, with a quarter of their courant number, with
    common ones of half of it, and with common ones of a fifth of it."""
    program = Path(sys.argv[sys.argv.index("--program") + 1]).resolve() if "--program" in sys.argv else PROGRAM
    courant = NEARLY * largest_courant(program, folder, text)
    runs = []
    for steps, part in (("local", 1), ("local", 0.25), ("global", 0.5), ("global", 0.2)):
        (folder / "case.h5").unlink(missing_ok=True)
        scene_text = text.replace("time_steps = 'local'", f"time_steps = '{steps}'").replace("courant = 0 ", f"courant = {part * courant} ")
        code, fault = try_run(program, folder, scene_text, [])
        if fault or code:
            return fault or f"ends with {code} with {steps} steps of {part * courant}"
        runs.append(result(folder / "case.h5"))
    (_, growth), (local, _), (common, ordinary), (exact, least) = runs
    if not growth <= GROWTH * max(least, ordinary, 1):
        return f"what the balance of energy misses grows {growth:.1f} times, {ordinary:.1f} and {least:.1f} times with common steps"
    off, allowed = (np.sqrt(np.mean((one - exact)**2) / np.mean(exact**2)) for one in (local, common))
    return "" if off <= WORSE * allowed + FLOOR else f"displacements are off by {off:.1e}, those of common steps by {allowed:.1e}"


def largest_courant(program, folder, text):
    """The largest courant number that the program takes; the limit that it names is one without damping, then with it."""
    limit = 999
    while True:
        (folder / "limit.nml").write_text(text.replace("courant = 0 ", f"courant = {limit} "))
        checked = subprocess.run([program, "--check", folder / "limit.nml"], capture_output=True, text=True)
        if checked.returncode == 0:     # with warnings or without
            return limit
        limit = float(re.search(r"&method courant = .*: must be at most ([0-9.e+-]+), not", checked.stderr)[1])


if __name__ == "__main__":
    main(__doc__, scene, look)
