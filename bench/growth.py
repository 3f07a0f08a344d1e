"""Cracks that grow in motion, against exact solutions (docs/growth.md).

    run       a crack that starts to run under a plane wave, given speeds: K_I against k(v) K(t, 0), means over a cell and scatter
    slanted   the same of a crack at 30 degrees to the grid in both modes, under a wave that meets it aslant
    toughness  the equation of motion of that crack: how far it comes, at what speed, G over the toughness
    strip     a crack through a strip with fixed edges: G against the energy stored ahead, after three heights
    kalthoff  the plate of Kalthoff & Winkler: K before growth against finite elements, the start, the first kink and the mean angle
    cost      CPU time of a step with a crack that grows, over that of one whose crack rests; particles at the end over those at the start

The solutions are in tests/reference/growth; each file says where it is from. Run by `make growth`, or for one part:
.venv/bin/python bench/growth.py run
"""

import csv
import math
import os
import resource
import subprocess
import sys

import h5py
import numpy as np
from tables import ROOT, command_line, write

REFERENCE = ROOT / "tests/reference/growth"
YOUNG, POISSON, DENSITY = 199.992e9, 0.3, 5000.0
PRESSURE, SHEAR, RAYLEIGH = 7337.8471, 3922.24426, 3637.53917  # speeds of waves [m/s]
HEIGHT = 10e-3
ARRIVAL = HEIGHT / PRESSURE

PLATE = """&run plane = 'strain'  end_time = {end!r} /
&grid lower = -10e-3, {lower!r}  cell = {cell!r}  cells = {n}, {n_y} /
&material name = 'a'  young = 199.992e9  poisson = 0.3  density = 5000 /
&body material = 'a'  lower = -10e-3, -10e-3  upper = 10e-3, 10e-3 /
&constraint lower = -10e-3, -10e-3  upper = -10e-3, 10e-3  fix = 'x' /
&constraint lower = 10e-3, -10e-3  upper = 10e-3, 10e-3  fix = 'x' /
&load kind = 'traction'  lower = -10e-3, 10e-3  upper = 10e-3, 10e-3  force = 0.0, 10.0e3 /
&load kind = 'traction'  lower = -10e-3, -10e-3  upper = 10e-3, -10e-3  force = 0.0, -10.0e3 /
&method mass = '{mass}' /
&refine indicator = '{indicator}'  max_level = {levels}  rings = 8 /
&crack kind = 'path'  points = -10e-3, {y!r}, 0.0, {y!r} /
&growth direction = 'straight'  {growth} /
&energy_release estimators = 'domain_integral'{audit}  radii = {radii} /
&output file = 'growth.h5'  history_interval = {interval!r} /
"""

WAVE = """&run plane = 'strain'  thickness = 1e-3  end_time = {end!r} /
&grid lower = -16e-3, -14e-3  cell = {cell!r}  cells = {nx}, {ny} /
&material name = 'a'  young = 199.992e9  poisson = 0.3  density = 5000.0 /
&body material = 'a'  lower = -16e-3, -14e-3  upper = 16e-3, 12e-3 /
&constraint lower = -16e-3, -14e-3  upper = -16e-3, 12e-3  fix = 'x' /
&constraint lower = 16e-3, -14e-3  upper = 16e-3, 12e-3  fix = 'x' /
&load kind = 'traction'  lower = -16e-3, 12e-3  upper = 16e-3, 12e-3  force = 0.0, 32.0 /
&energy_release estimators = 'domain_integral' /
&method mass = 'blend' /
&crack kind = 'path'  points = {points} /
&growth law = 'prescribed'  speed = {speed!r}  start = {start!r}  direction = 'straight'  tips = 'last' /
&output file = 'growth.h5'  history_interval = 2e-8 /
"""


def rows(name, folder=REFERENCE):
    with (folder / name).open() as file:
        return list(csv.DictReader(line for line in file if line[0] != "#"))


def factor_of_speed(speed, name="k_I"):
    """k or A of the universal functions [1], by linear interpolation in the table."""
    table = rows("c1_universal_nu0.30_strain.csv")
    return float(np.interp(speed / RAYLEIGH, [0.0] + [float(row["v/cR"]) for row in table], [1.0] + [float(row[name]) for row in table]))


def intensity_at_rest(time):
    """K_I of the semi-infinite crack at rest under a step wave of 1 MPa [Pa sqrt(m)]."""
    return 2e6 / (1 - POISSON) * np.sqrt(PRESSURE * np.maximum(time - ARRIVAL, 0) * (1 - 2 * POISSON) / math.pi)


def plate(cell, growth, mass="blend", levels=0, y=0.0, end=2.9, interval=2e-8, audit=False):
    """A wave meets a crack; `cell` is the finest one, `end` in the time that the wave needs to it."""
    root = cell * 2**levels
    n = round(20e-3 / root)
    return PLATE.format(end=end * ARRIVAL, lower=-10e-3 - root, cell=root, n=n, n_y=n + 2, mass=mass, levels=levels, y=y, growth=growth,
                        indicator="tip" if levels else "none", radii=f"{4 * cell!r}, {6 * cell!r}, {8 * cell!r}", interval=interval,
                        audit=", 'energy_balance'" if audit else "")


def given(speed, start=1.5):
    return f"law = 'prescribed'  speed = {speed!r}  start = {start * ARRIVAL!r}"


def running(history, speed, cell, skip=5):
    """Errors of K_I, over its exact values, of the rows behind the first `skip` cells; and their means over each whole cell after these."""
    error = history["K_I"] / np.maximum(factor_of_speed(speed) * intensity_at_rest(history["time"]), 1.0) - 1
    grown = (history["tip_x"] - history["tip_x"][0]) / cell
    means = [np.mean(error[(grown >= i) & (grown < i + 1)]) for i in range(skip, int(grown[-1])) if np.any((grown >= i) & (grown < i + 1))]
    return error[grown > skip], np.array(means)


def exact_growth():
    """Time, growth and speed by the equation of motion [s, m, m/s], and the toughness [J/m2]."""
    table = rows("c3_equation_of_motion_const.csv")
    return *(np.array([float(row[name]) for row in table]) for name in ("t[s]", "growth[m]", "v[m/s]")), 0.028376188


def by_toughness(history):
    """Growth between 2.265 and 2.75 arrival times over the exact one, rms error of the speed over that of Rayleigh waves, and mean and
    scatter of G over the toughness, from 2 arrival times on."""
    time, growth, speed, toughness = exact_growth()
    last = history["time"] > 2 * ARRIVAL
    way = [np.interp(2.75 * ARRIVAL, t, x) - np.interp(2.265 * ARRIVAL, t, x)
           for t, x in ((history["time"], history["tip_x"]), (time, growth))]
    off = history["tip_speed"][last] - np.interp(history["time"][last], time, speed)
    ratio = history["G"][last] / toughness
    return way[0] / way[1] - 1, math.sqrt(np.mean(off**2)) / RAYLEIGH, np.mean(ratio), np.std(ratio)


def slanted_scene(cell, speed):
    """The crack at 30 degrees whose upper tip starts to run 1 us after the wave has met it; the time at which that is [s]."""
    half, shift = 5e-3 * np.array([math.cos(math.pi / 6), 0.5]), np.array([7e-5, 3e-5])
    met = float((12e-3 - half[1] - shift[1]) / PRESSURE)
    points = ", ".join(repr(float(x)) for x in np.concatenate([shift - half, shift + half]))
    return WAVE.format(end=met + 2.4e-6, cell=cell, nx=round(32e-3 / cell), ny=round(26e-3 / cell), points=points, speed=speed,
                       start=met + 1e-6), met


def slanted_errors(history, met, speed, cell):
    """Errors of K_I and K_II over their exact values, behind the first four cells: the tip runs into material that the wave has met
    before, by half the way over the speed of the wave."""
    first = [row for row in rows("c4_slanted_crack_step_wave_30deg.csv", ROOT / "tests/reference/cracks") if row["tip"] == "upper"][0]
    way = np.hypot(history["tip_x"] - history["tip_x"][0], history["tip_y"] - history["tip_y"][0])
    moving = way > 4 * cell
    root = np.sqrt(np.maximum(history["time"] - met + way / (2 * PRESSURE), 0.0) / float(first["t[s]"]))[moving]
    return [history[k][moving] / (factor_of_speed(speed, "k" + k[1:]) * float(first[k + "[Pa*sqrt(m)]"]) * root) - 1
            for k in ("K_I", "K_II")]


def example(name, **changes):
    """An example of input/, with values of keys changed: by key, and by its place among those of this name."""
    text = (ROOT / f"input/{name}.nml").read_text()
    for key, value in changes.items():
        at = text.index(f"   {key} = ")
        text = text[:at] + f"   {key} = {value}" + text[text.index("\n", at):]
    return text


def kalthoff_errors(history):
    """Largest errors of K_I and K_II before growth over the peak of K_II in the reference, means over 0.5 us."""
    table = np.array([[float(x) for x in list(row.values())[:3]] for row in rows("e1_kalthoff_K_before_growth.csv")])
    table = table[table[:, 0] < 15.5]
    time = 1e6 * history["time"]
    means = np.array([[np.mean(history[k][np.abs(time - t) < 0.251]) / 1e6 for k in ("K_I", "K_II")] for t in table[:, 0]])
    return np.max(np.abs(means - table[:, 1:]), axis=0) / np.max(np.abs(table[:, 2]))


class Program:
    """Runs scenes in a folder."""

    def __init__(self, arguments):
        self.path, self.folder = arguments.program.resolve(), arguments.output.resolve()

    def __call__(self, text):
        (self.folder / "growth.nml").write_text(text)
        result = subprocess.run([self.path, "growth.nml", "--force", "--quiet", "--set", "output.file=growth.h5"], cwd=self.folder,
                                capture_output=True, text=True, env=os.environ | {"OPENBLAS_NUM_THREADS": "1"})
        if result.returncode:
            sys.exit(f"{self.folder / 'growth.nml'} has ended with {result.returncode}: {result.stderr}")
        with h5py.File(self.folder / "growth.h5") as file:
            return {name: column[:] for name, column in file["history"].items()}


def percent(x):
    return f"{100 * float(x):.2f}"


def run(program, arguments):
    out = [("mass", "cell", "levels", "v/c_R", "mean %", "scatter %", "cell means %", "fracture energy/integral of G")]
    for mass, cell, levels in (("blend", 0.2e-3, 0), ("blend", 0.1e-3, 0), ("blend", 0.1e-3, 2), ("lumped", 0.2e-3, 0), ("lumped", 0.1e-3, 0)):
        for part in (0.16, 0.33, 0.6):
            history = program(plate(cell, given(part * RAYLEIGH), mass, levels))
            error, means = running(history, part * RAYLEIGH, cell)
            out.append((mass, f"{cell:g}", levels, part, percent(np.mean(error)), percent(np.std(error)),
                        f"{percent(means.min())} to {percent(means.max())}" if len(means) else "",
                        f"{history['fracture_energy'][-1] / history['integral_of_G'][-1]:.3f}"))
    write(out, "run", arguments.output)


def slanted(program, arguments):
    out = [("cell", "v/c_R", "K_I %", "scatter %", "K_II %", "scatter %")]
    for cell, part in ((0.25e-3, 0.33), (0.125e-3, 0.16), (0.125e-3, 0.33), (0.125e-3, 0.6)):
        text, met = slanted_scene(cell, part * RAYLEIGH)
        errors = slanted_errors(program(text), met, part * RAYLEIGH, cell)
        out.append((f"{cell:g}", part, *(percent(x) for error in errors for x in (np.mean(error), np.std(error)))))
    write(out, "slanted", arguments.output)


def toughness(program, arguments):
    out = [("mass", "cell", "growth %", "rms of v/c_R %", "G/toughness", "scatter %")]
    for mass, cell in (("blend", 0.4e-3), ("blend", 0.2e-3), ("blend", 0.1e-3), ("lumped", 0.2e-3), ("lumped", 0.1e-3)):
        history = program(plate(cell, f"law = 'toughness'  toughness = {exact_growth()[3]}", mass))
        way, speed, ratio, scatter = by_toughness(history)
        out.append((mass, f"{cell:g}", percent(way), percent(speed), f"{ratio:.3f}", percent(scatter)))
    write(out, "toughness", arguments.output)


def strip(program, arguments):
    out = [("v/c_R", "from [mm]", "to [mm]", "G/G of the strip", "scatter %", "fracture energy over G times area")]
    for part in (0.2, 0.4, 0.6):
        speed = part * RAYLEIGH
        history = program(example("strip_growth", end_time=70e-6 + 50e-3 / speed, speed=speed))
        grown = 1e3 * history["tip_x"]
        for start in (30, 40):
            there = (grown >= start) & (grown < start + 10)
            first, last = np.flatnonzero(there)[[0, -1]]
            taken = (history["fracture_energy"][last] - history["fracture_energy"][first]) / (grown[last] - grown[first]) * 1e3
            out.append((part, start, start + 10, f"{np.mean(history['J'][there]) / 26.922:.4f}",
                        percent(np.std(history["J"][there]) / 26.922), f"{taken / 26.922:.3f}"))
    write(out, "strip", arguments.output)


def kalthoff(program, arguments):
    out = [("cell", "K_I %", "K_II %", "starts [us]", "first kink", "mean angle", "mean speed [m/s]")]
    for cell in (1e-3, 0.5e-3):
        n = round(0.1 / cell) + 2
        history = program(example("kalthoff", cell=cell, cells=f"{n}, {n}"))
        moves = np.flatnonzero(history["crack_length"] > history["crack_length"][0])
        x, y = history["tip_x"], history["tip_y"]
        out.append((f"{cell:g}", *(percent(e) for e in kalthoff_errors(history)), f"{1e6 * history['time'][moves[0]]:.1f}",
                    f"{history['tip_angle'][moves[0]]:.1f}", f"{math.degrees(math.atan2(y[-1] - y[0], x[-1] - x[0])):.1f}",
                    f"{np.mean(history['tip_speed'][moves]):.0f}"))
    write(out, "kalthoff", arguments.output)


def cost(program, arguments):
    out = [("finest cell", "levels", "v/c_R", "CPU time of a step, growing/resting", "particles, end/start")]
    for cell, levels in ((0.1e-3, 0), (0.1e-3, 2)):
        for part in (0.05, 0.16, 0.33):
            times = []
            for speed in (part * RAYLEIGH, 0.0):
                before = sum(resource.getrusage(resource.RUSAGE_CHILDREN)[:2])
                history = program(plate(cell, given(speed), "lumped", levels, interval=2e-7))
                times.append((sum(resource.getrusage(resource.RUSAGE_CHILDREN)[:2]) - before) / history["step"][-1])
                particles = history["particles"][-1] / history["particles"][0] if speed > 0 else particles
            out.append((f"{cell:g}", levels, part, f"{times[0] / times[1]:.2f}", f"{particles:.3f}"))
    write(out, "cost", arguments.output)


PARTS = {"run": run, "slanted": slanted, "toughness": toughness, "strip": strip, "kalthoff": kalthoff, "cost": cost}


def main():
    arguments = command_line(__doc__, list(PARTS), "results/growth")
    program = Program(arguments)
    for part in arguments.part:
        PARTS[part](program, arguments)


if __name__ == "__main__":
    main()
