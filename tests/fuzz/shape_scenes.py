"""Bodies of any shape, at random: polygons, circles, holes and slivers of every law, with tractions, pressure, gravity and eigenstrain, at rest and in
motion.

Every run has to end with exit code 0, 2 or 3 as those of `runs.py` do; one that ends with 0 has the area that its shapes have, finite numbers, and
in motion an energy balance that closes.

    .venv/bin/python tests/fuzz/shape_scenes.py --cases 1000 --seed 2 --program build/checked/hampm
"""

import math

import h5py
import numpy as np
from scene_fuzzer import main

THICKNESS, CLOSED, AREA = 1e-3, 1e-9, 1e-10
# Laws that remember: the work on them in a step is that of the stresses before and after it, which is of the second order in the step
CLOSED_OF_MEMORY = 2e-2
LAWS = {
    "linear_elastic": "young = 200e9  poisson = {nu}",
    "neo_hookean": "young = 200e9  poisson = {nu}",
    "orthotropic": "young_1 = 140e9  young_2 = 10e9  young_3 = 10e9  shear_12 = 5e9  poisson_12 = 0.3  poisson_13 = 0.3  poisson_23 = 0.4  angle = {angle}",
    "j2_plastic": "young = 200e9  poisson = {nu}  yield_stress = 1e7  hardening = {hardening}",
    "viscoelastic": "young = 200e9  poisson = {nu}  moduli = 2e10, 1e10  relaxation_times = 1e-6, 1e-5",
}


def area_of(points):
    x, y = np.array(points).T
    return abs(np.dot(x, np.roll(y, -1)) - np.dot(np.roll(x, -1), y)) / 2


def star(chance, middle, radius):
    """A polygon around a place [mm], seldom convex; some are slivers, some have sides on grid lines."""
    if chance.random() < 0.15:
        width, height = radius * chance.uniform(0.02, 1), radius * chance.uniform(0.3, 1)
        points = [(-width, -height), (width, -height), (width, height), (-width, height)]
        turn = math.radians(chance.choice([0, 30, 45, 90, chance.uniform(0, 180)]))
    else:
        angles = sorted(chance.uniform(0, 2 * math.pi) for _ in range(chance.randint(3, 8)))
        points = [(r * math.cos(a), r * math.sin(a)) for a in angles for r in [radius * chance.uniform(0.3, 1)]]
        turn = 0
    points = np.array(points) @ np.array([[math.cos(turn), math.sin(turn)], [-math.sin(turn), math.cos(turn)]]) + middle
    return np.round(points, chance.choice([1, 1, 6]))


def body(chance, middle, radius, more):
    """The text of a body around a place [mm]."""
    if chance.random() < 0.3:
        return f"&body shape = 'circle'  center = {middle[0]}e-3, {middle[1]}e-3  radius = {chance.uniform(0.2, 1) * radius:.6g}e-3 {more} /\n"
    points = ", ".join(f"{x:.9g}e-3" for point in star(chance, middle, radius) for x in point)
    return f"&body shape = 'polygon'  points = {points} {more} /\n"


def scene(chance):
    """One or two bodies in a box of 40 by 40 mm."""
    time = chance.choice(["static", "static", "explicit", "explicit", "explicit", "implicit"])
    end = 1.0 if time == "static" else chance.choice([2e-6, 1e-5])
    law = chance.choice(list(LAWS))
    cell = chance.choice([1.0, 2.0, 2.7])
    n = math.ceil(44 / cell)
    half = n * cell / 2
    keys = LAWS[law].format(nu=chance.choice([0.0, 0.3, 0.45]), angle=chance.choice([0, 30]), hardening=chance.choice([0, 1e9]))
    frame = chance.choice(["total", "total", "updated"]) if time == "explicit" else "total"
    points = chance.choice([2, 2, 4])
    more = f"material = 'a'  points_per_cell = {points}"
    if chance.random() < 0.2 and law == "linear_elastic":
        more += f"  eigenstrain = {chance.uniform(-1e-3, 1e-3):.3g}, {chance.uniform(-1e-3, 1e-3):.3g}, 0"
    if time != "static" and chance.random() < 0.3:
        more += f"  spin = {chance.choice([10, 1000])}"
    text = f"""&run plane = '{chance.choice(["strain", "stress"])}'  thickness = {THICKNESS}  end_time = {end} /
&grid lower = {-half}e-3, {-half}e-3  cell = {cell}e-3  cells = {n}, {n} /
&material name = 'a'  law = '{law}'  density = 8000  {keys} /
&method time = '{time}'  frame = '{frame}'  scheme = '{chance.choice(["musl", "usf", "usl", "usavg"])}'  mass = '{chance.choice(["lumped", "lumped", "weighted", "consistent", *(["fmpm"] if time != "implicit" else [])])}'
        shape_functions = '{chance.choice(["linear", "cpdi"]) if frame == "updated" else "linear"}' /
&energy_release energy_balance = .true. /
&output file = 'case.h5'  history_interval = {end / (2 if time == "static" else 10)}  snapshot_interval = {end} /
"""
    if chance.random() < 0.3:
        text += f"&refine indicator = 'zz'  max_level = {chance.choice([1, 2])}  tolerance = 0.1  max_particles = 20000 /\n"
    if chance.random() < (0.3 if frame == "updated" else 0.05):
        text += body(chance, (-10, chance.uniform(-8, 8)), 9, more) + body(chance, (10, chance.uniform(-8, 8)), 9, more)
    else:
        text += body(chance, (chance.uniform(-3, 3), chance.uniform(-3, 3)), 18, more)
    if chance.random() < 0.4:
        text += body(chance, (chance.uniform(-2, 2), chance.uniform(-2, 2)), chance.choice([1, 2, 4]), "hole = .true.")
    if chance.random() < 0.5:
        text += f"&load kind = 'gravity'  acceleration = {chance.choice([0, 1e5])}, {chance.choice([-10, -1e6])} /\n"
    box = f"lower = {chance.choice([-half, -5, 0])}e-3, {chance.choice([-half, -5, 0])}e-3  upper = {half}e-3, {half}e-3"
    if chance.random() < 0.5:
        text += f"&load kind = 'traction'  {box}  force = {chance.choice([0, 10])}, {chance.choice([-100, 50])} /\n"
    if chance.random() < 0.5:
        text += f"&load kind = 'pressure'  {box}  pressure = {chance.choice([1e5, -1e6, 1e8])} /\n"
    if chance.random() < (0.9 if time == "static" else 0.3):
        low = chance.choice([-6, 0])
        text += f"&constraint lower = {-half}e-3, {-half}e-3  upper = {half}e-3, {low}e-3  fix = '{chance.choice(['y', 'xy', 'xy'])}' /\n"
    return text


def shapes(text):
    """The area of the bodies less that of the holes [m2]."""
    area = 0.0
    for group in text.split("&body ")[1:]:
        words = group.split("/\n")[0].replace("=", " ").replace(",", " ").split()
        if "'circle'" in words:
            size = math.pi * float(words[words.index("radius") + 1])**2
        else:
            numbers = []
            for word in words[words.index("points") + 1:]:
                try:
                    numbers.append(float(word))
                except ValueError:
                    break
            size = area_of(np.reshape(numbers, (-1, 2)))
        area += -size if "hole" in words else size
    return area


def look(folder, text):
    """What is wrong with a result; '' where nothing is."""
    with h5py.File(folder / "case.h5") as file:
        row = {name: values[:] for name, values in file["history"].items()}
        told = file["history"].attrs.get("warnings", b"")
        particles = file["VTKHDF/particles"]
        first, last = particles["NumberOfPoints"][0], particles["NumberOfPoints"][-1]
        volume = {name: np.sum(particles["PointData/volume"][slice_]) for name, slice_ in
                  (("first", slice(0, first)), ("last", slice(-int(last), None)))} if "volume" in particles["PointData"] else {}
        fields = [name for name, values in particles["PointData"].items() if not np.all(np.isfinite(values[:]))]
    if fields:
        return f"{fields[0]} is not finite"
    bad = [name for name, values in row.items() if not np.all(np.isfinite(values))]
    if bad:
        return f"{bad[0]} is not finite"
    area = shapes(text)
    for when, value in volume.items():
        if not abs(value / THICKNESS / area - 1) < AREA:
            return f"the area is {value / THICKNESS} m2 in the {when} snapshot, and of the shapes {area} m2"
    told = told.decode() if isinstance(told, bytes) else str(told)
    if "'explicit'" in text and "energy has grown" not in told and not ("'j2_plastic'" in text and "displacement gradient" in told):
        inside = sum(row[name] for name in ("kinetic_energy", "strain_energy", "damping_loss", "numerical_loss", "plastic_dissipation",
                                            "viscous_dissipation") if name in row)
        missing = np.max(np.abs(row["external_work"] - (inside - inside[0]))) / max(np.max(np.abs(inside)), 1e-300)
        if not missing < (CLOSED_OF_MEMORY if "'j2_plastic'" in text or "'viscoelastic'" in text else CLOSED):
            return f"{missing:.1e} of the energy is missing"
    return ""


if __name__ == "__main__":
    main(__doc__, scene, look)
