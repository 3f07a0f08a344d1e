"""Plain scenes of the updated frame at random: bodies side by side that rest, fly and turn, each run twice.

The steps of the first run are done in tiles, those of the second in stages, as `energy_balance` asks for. Both have to end with the same code, and where
that is 0 with the same velocities, displacements and energies.

    .venv/bin/python tests/fuzz/plain_scenes.py --cases 1000 --seed 2 --program build/checked/hampm
"""

import sys
from pathlib import Path

import h5py
import numpy as np
from runs import PROGRAM, try_run
from scene_fuzzer import main

SAME = 1e-7  # over the largest value; rounding grows where bodies meet


def body(chance, names, lower, upper, speed, cell):
    way = [chance.uniform(-1, 1) * speed for _ in "xy"]
    spin = chance.choice([0, chance.uniform(-1, 1) * speed / (10 * cell)])
    return (f"&body material = '{chance.choice(names)}'  lower = {lower[0]}, {lower[1]}  upper = {upper[0]}, {upper[1]}  "
            f"velocity = {way[0]}, {way[1]}  spin = {spin}  points_per_cell = {chance.choice([2, 2, 3, 1])} /\n")


def scene(chance):
    """One or two bodies, in a grid that they may fill."""
    cell, cells = chance.choice([1e-3, 0.25, 7.0]), (chance.randint(9, 60), chance.randint(9, 60))
    origin = [chance.uniform(-5, 5) * cell * chance.choice([0, 1, 20]) for _ in "xy"]
    young = [10**chance.uniform(6, 11) for _ in range(chance.randint(1, 3))]
    names = [f"m{k}" for k in range(len(young))]
    text = "".join(f"&material name = '{name}'  young = {value}  poisson = {chance.choice([0, 0.2, 0.3, 0.45])}  "
                   f"density = {10**chance.uniform(2, 4)} /\n" for name, value in zip(names, young))
    edge = chance.choice([0, 3, 3])
    middle = chance.uniform(edge + 1.5, cells[0] - edge - 1.5)
    slow, fast = (min(young) / 1e3)**0.5, (max(young) / 100)**0.5
    for left, right in ((edge, middle), (middle, cells[0] - edge))[:chance.randint(1, 2)]:
        low = chance.uniform(edge, cells[1] - edge - 2)
        high = chance.uniform(low + 1.5, cells[1] - edge)
        text += body(chance, names, [origin[0] + left * cell, origin[1] + low * cell], [origin[0] + right * cell, origin[1] + high * cell],
                     chance.choice([0, 1e-3, 0.05, 0.5]) * slow, cell)
    end = chance.randint(30, 200) * 0.05 * cell / fast
    if chance.random() < 0.5:
        text += f"&damping rate = {chance.random() * slow / (30 * cell)} /\n"
    if chance.random() < 0.4:
        text += (f"&constraint lower = {origin[0]}, {origin[1]}  upper = {origin[0] + chance.uniform(1, cells[0]) * cell}, "
                 f"{origin[1] + cells[1] * cell}  fix = '{chance.choice(['x', 'y', 'xy'])}' /\n")
    return text + f"""&run plane = '{chance.choice(["stress", "strain"])}'  thickness = {cell}  end_time = {end} /
&grid lower = {origin[0]}, {origin[1]}  cell = {cell}  cells = {cells[0]}, {cells[1]} /
&method frame = 'updated'  scheme = '{chance.choice(["musl", "usf", "usl", "usavg"])}'  courant = {chance.choice([0.05, 0.1])} /
&output file = 'case.h5'  history_interval = {end}  snapshot_interval = {end} /
"""


def result(path):
    """Velocities and displacements of the particles by their numbers, and energies, at the end."""
    with h5py.File(path) as file:
        data, n = file["VTKHDF/particles"], file["VTKHDF/particles/NumberOfPoints"][-1]
        order = np.argsort(data["PointData/id"][-n:].ravel())
        fields = [data["PointData"][name][-n:][order] for name in ("velocity", "displacement")]
        return fields + [np.array([file["history"][name][-1] for name in ("kinetic_energy", "strain_energy", "damping_loss")])]


def look(folder, text):
    """What is wrong with a result; '' where nothing is."""
    program = Path(sys.argv[sys.argv.index("--program") + 1]).resolve() if "--program" in sys.argv else PROGRAM
    in_tiles = result(folder / "case.h5")
    (folder / "case.h5").unlink()
    code, fault = try_run(program, folder, text + "&energy_release energy_balance = .true. /\n", [])
    if fault or code:
        return fault or f"ends with {code} in stages"
    for name, one, other in zip(("velocity", "displacement", "energy"), in_tiles, result(folder / "case.h5")):
        if not np.max(np.abs(one - other)) <= SAME * np.max(np.abs(other)):
            return f"{name} differs by {np.max(np.abs(one - other)):.1e} of {np.max(np.abs(other)):.1e}"
    return ""


if __name__ == "__main__":
    main(__doc__, scene, look)
