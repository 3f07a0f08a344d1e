"""What two programs, as one before and one after a change, are off by on the references of cracks (docs/explanation/cracks.md).

    rest    a1 to a7, cracks at rest, 16 finest cells to the half-length or the shortest straight part: K_I and K_II over the larger of both, and G
    slip    a8, cracks that are pressed and slide, 32 finest cells: K_II over K_II without friction; K_I is 0
    wave    c4, a step of tension meets a slanted crack, 20 cells to the half-length: K_I and K_II over the peak
    motion  c2 and d2, cracks that run at given speeds: K_I of the infinite plate, J of the strip
    paths   p1 and p4, growth at rest by local symmetry: place of the tip, its direction, K_I; f1, a double cantilever beam: the load

    .venv/bin/python bench/crack_references.py --before old/hampm

The references are in tests/reference/cracks and tests/reference/growth; each file says where it is from.
"""

import csv
import math
import os
from pathlib import Path

import numpy as np
from cracks import Program, case_scene, cases, errors, errors_of_k, pressed_cases, scene, wave_errors, wave_scene
from growth import REFERENCE, benchmark_errors, benchmark_scene, example, RAYLEIGH
from growth import Program as Histories
from tables import ROOT, command_line, write

SIZE = 8e-3 / math.sqrt(2)  # of the crack at 45 degrees

BEAM = """\
&run plane = 'strain'  thickness = 1e-3  end_time = 9 /
&grid lower = -0.062, -0.017  cell = 1e-3  cells = 124, 34 /
&material name = 'a'  young = 200e9  poisson = 0.3  density = 7800 /
&body material = 'a'  lower = -0.06, -0.015  upper = 0.06, 0.015 /
&load kind = 'traction'  lower = -0.001, 0.015  upper = 0.001, 0.015  force = 0, -2.0 /
&load kind = 'traction'  lower = -0.051, -0.015  upper = -0.049, -0.015  force = 0, 1.0 /
&load kind = 'traction'  lower = 0.049, -0.015  upper = 0.051, -0.015  force = 0, 1.0 /
&energy_release estimators = 'domain_integral' /
&method time = 'static'  load_steps = 9 /
&refine indicator = 'tip'  max_level = 2  rings = 8 /
&crack kind = 'path'  points = -0.02, -0.016, -0.02, -0.006 /
&growth direction = 'local_symmetry'  toughness = 100.0  increment = 1.5e-3 /
"""

DCB = """\
&run plane = 'stress'  thickness = 0.01  end_time = 11 /
&grid lower = -0.0025, -0.0125  cell = 1.25e-3  cells = 100, 20 /
&material name = 'a'  young = 70e9  poisson = 0.3  density = 2700 /
&body material = 'a'  lower = 0, -0.01  upper = 0.12, 0.01 /
&constraint lower = 0.12, -0.01  upper = 0.12, 0.01  fix = 'xy' /
&load kind = 'traction'  lower = 0, 0.00125  upper = 0, 0.01  force = 0, 1.0 /
&load kind = 'traction'  lower = 0, -0.01  upper = 0, -0.00125  force = 0, -1.0 /
&energy_release estimators = 'domain_integral' /
&method time = 'static'  load_steps = 11 /
&refine indicator = 'tip'  max_level = 2  rings = 6 /
&crack kind = 'path'  points = -0.001, 0.0003, 0.05, 0.0003 /
&growth direction = 'straight'  toughness = 1.0  increment = 2.272727e-3 /
"""


def slanted_growth(steps, direction="local_symmetry", increment=1.6e-3, levels=1, cell=1e-3, more="", **values):
    """A crack of 16 mm at 45 degrees in a plate of 40 by 80 mm under tension."""
    text = scene([[(-SIZE, -SIZE), (SIZE, SIZE)]], cell, (0.02, 0.04), levels=levels, sigma=1e6, **values)
    text = text.replace("time = 'static'", f"time = 'static'  load_steps = {steps}")
    return text + f"&growth direction = '{direction}'  toughness = 100.0  increment = {increment} {more} /\n"


def deviations(row, name, tip, increment):
    """Distance of a tip from where it should be [mm], of its direction [degrees] and of K_I, relative, in each row."""
    with (REFERENCE / name).open() as file:
        table = csv.reader(line for line in file if not line.startswith("#"))
        path = {round(float(line[2]), 3): [float(x) for x in line[3:]] for line in table if line[0] == f"{1e3 * increment:g} mm" and line[1] == tip}
    off = []
    for i in range(len(row["tip_x"])):
        x, y, angle, k, _ = path[round(1e3 * increment * i, 3)]
        off.append((math.hypot(1e3 * row["tip_x"][i] - x, 1e3 * row["tip_y"][i] - y), abs(row["tip_angle"][i] - angle),
                    abs(row["K_I"][i] / row["load_factor"][i] / k - 1)))
    return np.array(off)


def load_errors(row):
    """Of the double cantilever beam: the load over that by G = 12 P**2 (a + 0.6731 D)**2/(E B**2 D**3), less 1, in each row."""
    return row["load_factor"] * (row["tip_x"] + 0.6731 * 0.01) / math.sqrt(70e9 * 0.01**2 * 0.01**3 / 12) - 1


def rms(errors):
    return f"{100 * np.sqrt(np.mean(np.square(errors))):.2f}"


def largest(errors):
    return f"{100 * np.max(np.abs(errors)):.2f}"


def rest(arguments):
    program = Program(arguments)
    of_kind = {}
    for case in cases():
        found = program(case_scene(case, 16))
        of_kind.setdefault(case[0][:2], []).append((errors_of_k(found, case[4]).ravel(), errors(found, case[4])[2]))
    for kind, found in of_kind.items():
        k = np.concatenate([each for each, _ in found])
        yield f"{kind}: K of {len(k) // 2} tips, rms, largest; G, largest [%]", (rms(k), largest(k), largest([g for _, g in found]))


def slip(arguments):
    program = Program(arguments)
    of_kind = {}
    for name, text, asked, free in pressed_cases():
        found = program(text) / free
        of_kind.setdefault(name.split()[0], []).append((found[:, 1] - asked / free, found[:, 0]))
    for kind, found in of_kind.items():
        k = np.array(found)
        yield f"a8, {kind}: K_II of {k[:, 0].size} tips, rms, largest; K_I, largest [%]", (rms(k[:, 0]), largest(k[:, 0]), largest(k[:, 1]))


def wave(arguments):
    for mass in ("lumped", "weighted"):
        for tip, found in wave_errors(Histories(arguments)(wave_scene(0.25e-3, mass))).items():
            yield f"c4, {mass}, {tip} tip: K_I, K_II [%]", [rms(each) for each in found]


def motion(arguments):
    error, _ = benchmark_errors(Histories(arguments)(benchmark_scene(0.05, "weighted")), 0.05)
    yield "c2, 1500 m/s: K_I, mean, scatter [%]", (f"{100 * np.mean(error):.2f}", f"{100 * np.std(error):.2f}")
    for part in (0.2, 0.4):
        speed = part * RAYLEIGH
        row = Histories(arguments)(example("strip_growth", end_time=70e-6 + 40e-3 / speed, speed=speed))
        error = row["J"][row["tip_x"] > 30e-3] / 26.922 - 1
        yield f"d2, {part} of the Rayleigh speed: J, mean, scatter [%]", (f"{100 * np.mean(error):.2f}", f"{100 * np.std(error):.2f}")


def paths(arguments):
    for name, text, tip, increment in (("p1_path_slanted_45", slanted_growth(5), "2", 1.6e-3), ("p4_path_three_point_bend", BEAM, "1", 1.5e-3)):
        off = deviations(Histories(arguments)(text), name + ".csv", tip, increment)
        yield (f"{name[:2]}: tip, largest [mm]; direction, largest [degrees]; K_I, median, largest [%]",
               (f"{np.max(off[:, 0]):.3f}", f"{np.max(off[:, 1]):.2f}", f"{100 * np.median(off[:, 2]):.2f}", largest(off[:, 2])))
    error = load_errors(Histories(arguments)(DCB))
    yield "f1: load, mean, scatter, largest [%]", (f"{100 * np.mean(error):.2f}", f"{100 * np.std(error):.2f}", largest(error))


PARTS = {"rest": rest, "slip": slip, "wave": wave, "motion": motion, "paths": paths}


def main():
    arguments = command_line(__doc__, list(PARTS), "results/crack_references", before=(ROOT / "build/before/hampm", "the other program"))
    programs = [Path(os.path.abspath(path)) for path in (arguments.before, arguments.program)]
    for part in arguments.part:
        both = []
        for arguments.program in programs:
            both.append(dict(PARTS[part](arguments)))
        write([("reference", "before", "after"), *((what, *(", ".join(found[what]) for found in both)) for what in both[0])], part, arguments.output)


if __name__ == "__main__":
    main()
