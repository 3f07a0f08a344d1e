"""Cracks that grow, at random: number, places, angles, laws, directions, speeds, toughnesses, loads, meshes and methods.

Every run has to end with exit code 0, 2 or 3 as those of `runs.py` do; one that ends with 0 has an energy balance that closes, and has lost
no particle.

    .venv/bin/python tests/fuzz/growth_scenes.py --cases 1000 --seed 2 --program build/checked/hampm
"""

import h5py
import numpy as np
from scene_fuzzer import main

CLOSED = 1e-9  # part of the largest energy that may be missing


def crack(chance, number, middle, room):
    """A crack of one or two straight parts around a place [mm]."""
    half, angle = chance.uniform(1.2, room), chance.choice([0, 45, 90, chance.uniform(0, 180)])
    end = half * np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle))])
    points = [middle - end, middle + end]
    if chance.random() < 0.2:
        points.insert(1, middle + chance.uniform(-0.3, 0.3) * half * np.array([-end[1], end[0]]) / half)
    text = ", ".join(f"{x:.6g}e-3" for point in points for x in point)
    return f"&crack kind = 'path'  name = 'c{number}'  points = {text}  contact = '{chance.choice(['none', 'none', 'frictionless'])}' /\n"


def resistance(chance, moves):
    """On what its toughness depends."""
    text = ""
    if chance.random() < 0.2:
        text += f"  extensions = 0.0, {chance.choice([1, 3])}e-3  extension_factors = 1.0, {chance.choice([0.6, 2.5])}"
    if chance.random() < 0.2:
        text += f"  angles = {chance.choice([-50, -20, 0])}, {chance.choice([10, 35, 60])}, 90  angle_factors = {chance.uniform(0.7, 2):.3g}, {chance.uniform(0.7, 2):.3g}, 1.5"
    if moves and chance.random() < 0.2:
        text += f"  speeds = 0.0, {chance.choice([300, 1000])}  speed_factors = 1.0, {chance.choice([0.7, 2.5])}"
    if chance.random() < 0.2:
        text += "  mixed_mode = " + chance.choice(["'hutchinson_suo'  lambda = 0.3", "'benzeggagh_kenane'  toughness_shear = 5.0  mixed_mode_exponent = 1.6"])
    return text


def growth(chance, number, end):
    """How it grows."""
    direction = chance.choice(["straight", "hoop_stress", "local_symmetry", "max_energy", "path"])
    text = f"&growth crack = 'c{number}'  direction = '{direction}'  tips = '{chance.choice(['all', 'all', 'last', 'first'])}'"
    if direction == "path":
        text += "  points = " + ", ".join(f"{chance.uniform(-6, 6):.3g}e-3" for _ in range(2 * chance.randint(1, 3)))
    if chance.random() < 0.5:
        text += f"  law = 'prescribed'  speed = {chance.choice([10, 300, 1000, 1900, 2500])}"
    else:
        text += f"  law = 'toughness'  toughness = {10 ** chance.uniform(-4, 1):.3g}"
        if chance.random() < 0.3:
            text += f"  limit_speed = {chance.choice([500, 1500])}  exponent = {chance.choice([1, 2])}"
        text += resistance(chance, moves=True)
    if chance.random() < 0.3:
        text += f"  start = {chance.uniform(0, 0.5) * end:.4g}  end = {chance.uniform(0.4, 1) * end:.4g}"
    if chance.random() < 0.2:
        text += f"  max_length = {chance.uniform(4, 9):.3g}e-3"
    return text + " /\n"


def scene(chance):
    """A plate of 20 by 20 mm, pulled, sheared or hit."""
    indicator, level = chance.choice(["none", "none", "tip", "gradient"]), chance.choice([1, 2])
    refines = indicator != "none"
    cell = chance.choice([0.7, 1.0, 1.0] if refines else [0.5, 0.7, 1.0])   # the time of a scene goes with the third power of its cells
    n = round(20 / cell)
    side, end = n * cell / 2, 4e-6 if refines and level == 2 else chance.choice([4e-6, 8e-6])
    number = chance.choice([1, 1, 1, 2, 3])
    places = {1: [(0, 0)], 2: [(-4.5, -1), (4.5, 1)], 3: [(-5, -3), (5, -3), (0, 5)]}[number]
    mass = chance.choice(["auto", "lumped", "weighted", "consistent", "tip_weighted"])
    frame = chance.choice(["total", "total", "updated"])
    room, velocity = (3, f"  velocity = {chance.choice(['0.0, 0.0', '50.0, 0.0', '-30.0, 80.0'])}") if frame == "updated" else (0, "")
    text = f"""&run plane = '{chance.choice(["strain", "stress"])}'  end_time = {end} /
&grid lower = {-side - room * cell}e-3, {-side - (room + 1) * cell}e-3  cell = {cell}e-3  cells = {n + 2 * room}, {n + 2 * room + 2} /
&material name = 'a'  young = 200e9  poisson = {chance.choice([0.0, 0.3, 0.4])}  density = 8000 /
&body material = 'a'  lower = {-side}e-3, {-side}e-3  upper = {side}e-3, {side}e-3{velocity} /
&method frame = '{frame}'  scheme = '{chance.choice(["musl", "musl", "usf", "usl", "usavg"])}'  mass = '{mass}' /
&damping rate = {chance.choice([0, 0, 1e5])} /
&refine indicator = '{indicator}'  max_level = {level}  rings = 4
   max_particles = 20000 /
&energy_release estimators = 'domain_integral'  energy_balance = .true. /
&output file = 'case.h5'  history_interval = {end / 20} /
"""
    for _ in range(chance.choice([1, 2])):
        force = f"{chance.choice([0, 10, 100])}e3, {chance.choice([-20, 20, 100])}e3"
        text += f"&load kind = 'traction'  lower = {-side}e-3, {side}e-3  upper = {side}e-3, {side}e-3  force = {force} /\n"
    if chance.random() < 0.5:
        text += f"&constraint lower = {-side}e-3, {-side}e-3  upper = {side}e-3, {-side}e-3  fix = '{chance.choice(['y', 'xy'])}' /\n"
    for k, place in enumerate(places):
        text += crack(chance, k, np.array(place) + [chance.uniform(-0.5, 0.5), chance.uniform(-0.5, 0.5)], 3 if number == 1 else 2)
        if k == 0 or chance.random() < 0.7:
            text += growth(chance, k, end)
    return text


def look(folder, text):
    """What is wrong with a result; '' where nothing is."""
    with h5py.File(folder / "case.h5") as file:
        row = {name: values[:] for name, values in file["history"].items()}
    inside = sum(row[name] for name in ("kinetic_energy", "strain_energy", "damping_loss", "numerical_loss", "fracture_energy"))
    missing = row["external_work"] - inside
    missing = np.max(np.abs(missing - missing[0])) / max(np.max(row["kinetic_energy"] + row["strain_energy"]), 1e-300)
    if not missing < CLOSED:
        return f"{missing:.1e} of the energy is missing"
    if "indicator = 'none'" in text and np.any(row["particles"] != row["particles"][0]):
        return "a particle is lost"
    return ""


if __name__ == "__main__":
    main(__doc__, scene, look)
