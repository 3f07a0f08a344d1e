"""Cracks that grow in motion, against exact solutions (docs/explanation/growth_accuracy.md).

    run       a crack that starts to run under a plane wave, given speeds: K_I against k(v) K(t, 0), means over a cell and scatter
    benchmark  the same of the benchmark of Rethore & Menouillard: 1500 m/s in a plate 4 m high, one edge of which is loaded
    slanted   the same of a crack at 30 degrees to the grid in both modes, under a wave that meets it aslant
    toughness  the equation of motion of that crack: how far it comes, at what speed, G over the toughness
    strip     a crack through a strip with fixed edges: G against the energy stored ahead, after three heights
    long_strip  the same over twenty heights, with cells that follow the tip: drift of G, particles and CPU time of a step at both ends
    law       the same by toughness/(1 - v/limit): G over the toughness at the speed of the tip, from 1e-4 to 0.9 of that of Rayleigh waves, in the plane
              and in a slab of one cell, in explicit and implicit steps, with two cells
    dcb       a double cantilever beam whose ends are moved apart, at two rates: load and length against the closed form at rest
    kalthoff  the plate of Kalthoff & Winkler: K before growth against finite elements, the start, the first kink and the mean angle
    cost      CPU time of a step with a crack that grows, over that of one whose crack rests; particles at the end over those at the start

The solutions are in tests/reference/growth; each file says where it is from. Run by `make -C bench growth`, or for one part:
.venv/bin/python bench/growth.py run
"""

import itertools
import math
import re
import sys

import numpy as np
import program_runs
from tables import ROOT, command_line, reference, write

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
&energy_release estimators = 'domain_integral'  energy_balance = {audit}  radii = {radii} /
&output history_interval = {interval!r} /
"""

WAVE = """&run plane = 'strain'  thickness = 1e-3  end_time = {end!r} /
&grid lower = -16e-3, -14e-3  cell = {cell!r}  cells = {nx}, {ny} /
&material name = 'a'  young = 199.992e9  poisson = 0.3  density = 5000.0 /
&body material = 'a'  lower = -16e-3, -14e-3  upper = 16e-3, 12e-3 /
&constraint lower = -16e-3, -14e-3  upper = -16e-3, 12e-3  fix = 'x' /
&constraint lower = 16e-3, -14e-3  upper = 16e-3, 12e-3  fix = 'x' /
&load kind = 'traction'  lower = -16e-3, 12e-3  upper = 16e-3, 12e-3  force = 0.0, 32.0 /
&energy_release estimators = 'domain_integral' /
&method mass = 'weighted' /
&crack kind = 'path'  points = {points} /
&growth law = 'prescribed'  speed = {speed!r}  start = {start!r}  direction = 'straight'  tips = 'last' /
&output history_interval = 2e-8 /
"""


BENCHMARK = """&run plane = 'strain'  end_time = {end!r} /
&grid lower = -3.2, {lower!r}  cell = {cell!r}  cells = {n}, {n_y} /
&material name = 'a'  young = 210e9  poisson = 0.3  density = 8000 /
&body material = 'a'  lower = -3.2, -2.0  upper = 3.2, 2.0 /
&constraint lower = -3.2, -2.0  upper = -3.2, 2.0  fix = 'x' /
&constraint lower = 3.2, -2.0  upper = 3.2, 2.0  fix = 'x' /
&load kind = 'traction'  lower = -3.2, 2.0  upper = 3.2, 2.0  force = 0.0, 3.2e9 /
&method mass = '{mass}' /
&crack kind = 'path'  points = -3.2, 0.0, 0.0, 0.0 /
&growth law = 'prescribed'  speed = 1500.0  start = {start!r}  direction = 'straight' /
&energy_release estimators = 'domain_integral'  radii = {radii} /
&output history_interval = 2e-6 /
"""
BENCHMARK_ARRIVAL = 0.000336448033  # of the wave at the crack [s]; the plate is 10 m long there, of which waves meet the tip from 6.4 m only

LONG_STRIP = """&run plane = 'strain'  end_time = {end!r} /
&grid lower = -40e-3, -11e-3  cell = 1e-3  cells = 280, 22 /
&material name = 'steel'  young = 199.992e9  poisson = 0.3  density = 5000 /
&body material = 'steel'  lower = -40e-3, -10e-3  upper = 240e-3, 10e-3 /
&constraint lower = -40e-3, 10e-3  upper = 240e-3, 10e-3  fix = 'xy'  displacement = 0.0, 1e-6  {history} /
&constraint lower = -40e-3, -10e-3  upper = 240e-3, -10e-3  fix = 'xy'  displacement = 0.0, -1e-6  {history} /
&constraint lower = 240e-3, -10e-3  upper = 240e-3, 10e-3  fix = 'x' /
&refine indicator = 'tip'  max_level = {levels}  rings = 8 /
&crack kind = 'path'  points = -40e-3, 0.0, 0.0, 0.0 /
&growth law = 'prescribed'  speed = {speed!r}  start = 70e-6  direction = 'straight' /
&energy_release estimators = 'domain_integral'  radii = {radii} /
&output history_interval = 0.25e-6 /
"""


def rows(name, folder=REFERENCE):
    return reference(folder / name)


def factor_of_speed(speed, name="k_I"):
    """k or A of the universal functions [1], by linear interpolation in the table."""
    table = rows("c1_universal_nu0.30_strain.csv")
    return float(np.interp(speed / RAYLEIGH, [0.0] + [float(row["v/cR"]) for row in table], [1.0] + [float(row[name]) for row in table]))


def intensity_at_rest(time):
    """K_I of the semi-infinite crack at rest under a step wave of 1 MPa [Pa sqrt(m)]."""
    return 2e6 / (1 - POISSON) * np.sqrt(PRESSURE * np.maximum(time - ARRIVAL, 0) * (1 - 2 * POISSON) / math.pi)


def plate(cell, growth, mass="weighted", levels=0, y=0.0, end=2.9, interval=2e-8, audit=False):
    """A wave meets a crack; `cell` is the finest one, `end` in the time that the wave needs to it."""
    root = cell * 2**levels
    n = round(20e-3 / root)
    return PLATE.format(end=end * ARRIVAL, lower=-10e-3 - root, cell=root, n=n, n_y=n + 2, mass=mass, levels=levels, y=y, growth=growth,
                        indicator="tip" if levels else "none", radii=f"{4 * cell!r}, {6 * cell!r}, {8 * cell!r}", interval=interval,
                        audit=".true." if audit else ".false.")


def given(speed, start=1.5):
    return f"law = 'prescribed'  speed = {speed!r}  start = {start * ARRIVAL!r}"


def running(history, speed, cell, skip=5):
    """Errors of K_I, over its exact values, of the rows behind the first `skip` cells; and their means over each whole cell after these."""
    error = history["K_I"] / np.maximum(factor_of_speed(speed) * intensity_at_rest(history["time"]), 1.0) - 1
    return behind(error, (history["tip_x"] - history["tip_x"][0]) / cell, skip)


def behind(error, grown, skip):
    """Errors behind the first `skip` cells, and their means over each whole cell after these."""
    means = [np.mean(error[(grown >= i) & (grown < i + 1)]) for i in range(skip, int(grown[-1])) if np.any((grown >= i) & (grown < i + 1))]
    return error[grown > skip], np.array(means)


def over_cells(way, value, cells=4):
    """Means of a value over the last cells of the way of a tip, or over as many as it has come [1]: the exact value of G_moving_average; at rest the value."""
    moving = max(int(np.argmax(way > 0)) - 1, 0)
    area = np.concatenate([np.zeros(moving + 1), np.cumsum(np.diff(way[moving:]) * (value[moving + 1:] + value[moving:-1]) / 2)])
    first = np.maximum(way - cells, 0)
    return np.where(way > 0, (area - np.interp(first, way[moving:], area[moving:])) / np.maximum(way - first, 1e-30), value)


def benchmark_scene(cell, mass):
    n = round(6.4 / cell)
    return BENCHMARK.format(end=2.9 * BENCHMARK_ARRIVAL, lower=-2.0 - cell, cell=cell, n=n, n_y=round(4.0 / cell) + 2, mass=mass,
                            start=1.5 * BENCHMARK_ARRIVAL, radii=f"{4 * cell!r}, {6 * cell!r}, {8 * cell!r}")


def benchmark_errors(history, cell, skip=5):
    """Errors of K_I behind the first `skip` cells, and their means over each whole cell after these."""
    table = [row for row in rows("c2_freund_xfem_benchmark_1500.csv") if float(row["v[m/s]"]) > 0]
    error = history["K_I"] / np.interp(history["time"], *([float(row[name]) for row in table] for name in ("t[s]", "K_I[Pa*sqrt(m)]"))) - 1
    return behind(error, history["tip_x"] / cell, skip)


def long_strip_scene(levels, speed):
    times = [3e-6 * i for i in range(21)]
    history = ("history = 'table'  times = " + ", ".join(f"{t:.6g}" for t in times) +
               "\n   factors = " + ", ".join(f"{(1 - math.cos(math.pi * t / 60e-6)) / 2:.6g}" for t in times))
    cell = 1e-3 / 2**levels
    return LONG_STRIP.format(end=70e-6 + 0.2 / speed, speed=speed, levels=levels, history=history,
                             radii=f"{4 * cell!r}, {6 * cell!r}, {8 * cell!r}")


DCB = {"E": 70e9, "B": 0.01, "D": 0.01, "a": 0.05, "chi": 0.6731}


def dcb_errors(history, compliance, rate, rise=0.5e-3):
    """Of ends that move apart at a rate after a gentle start, from where the crack grows at rest on: mean of the load over that at rest at the
    same openings, its scatter, means and last of the length over that at rest, and kinetic over stored energy. The opening at rest is by
    f1_dcb_growth_stress.csv, with the compliance at the start by a run at rest."""
    table = [[float(x) for x in row.values()][:3] for row in rows("f1_dcb_growth_stress.csv")]
    length, load, more = np.array(table).T
    opening = load * (compliance + more)
    time = history["time"]
    open_now = rate * np.where(time < rise, time**2 / (2 * rise), time - rise / 2)
    grows = (open_now > opening[0]) & (open_now < opening[-1])
    force = (history["reaction_upper_y"] - history["reaction_lower_y"])[grows] / 2
    at_rest = np.interp(open_now[grows], opening, load)
    off = history["tip_x"][grows] - np.interp(open_now[grows], opening, length)
    return (np.mean(force) / np.mean(at_rest) - 1, np.std(force / at_rest), np.mean(off), off[-1],
            np.mean(history["kinetic_energy"][grows] / history["strain_energy"][grows]))


def dcb_compliance(program):
    """Opening over load of the double cantilever beam at rest [m/N]."""
    text = example("dcb_growth_dynamic", end_time=1.0, velocity="0.0, 0.5e-5", history_interval=1.0)
    text = re.sub(r"&method\n.*?\n/\n", "", text, flags=re.DOTALL) + "&method time = 'static' /\n"
    text = text[:text.index("&growth")] + text[text.index("&energy_release"):]
    text = text[:text.index("&damping")] + text[text.index("&crack"):]
    text = text.replace("velocity = 0.0, 0.5e-5", "displacement = 0.0, 0.5e-5").replace("velocity = 0.0, -7.5e-3", "displacement = 0.0, -0.5e-5")
    text = text.replace("   history = 'ramp'\n   rise_time = 0.5e-3\n", "")
    text += "&refine indicator = 'tip'  max_level = 2  rings = 8 /\n"
    history = program(text)
    return 2e-5 / (history["reaction_upper_y"][-1] - history["reaction_lower_y"][-1])


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


class Program(program_runs.Program):
    """Runs scenes in a folder."""

    def __call__(self, text):
        done = super().__call__(text, threads=0)
        self.seconds = done.seconds
        return done.columns

    def in_parts(self, text, steps):
        """CPU times of the parts of a run that is stopped after so many steps each, and resumed, and of the rest [s]."""
        first = super().__call__(text, words=("--steps", steps[0]), codes=(5,))
        parts = [self.resume(("--steps", number) if number else (), (5 if number else 0,)) for number in [*steps[1:], None]]
        return [part.seconds for part in (first, *parts)]


def percent(x):
    return f"{100 * float(x):.2f}"


def run(program, arguments):
    out = [("mass", "cell", "levels", "v/c_R", "mean %", "scatter %", "cell means %", "fracture energy/integral of G")]
    for mass, cell, levels in (("weighted", 0.2e-3, 0), ("weighted", 0.1e-3, 0), ("weighted", 0.1e-3, 2), ("lumped", 0.2e-3, 0), ("lumped", 0.1e-3, 0)):
        for part in (0.16, 0.33, 0.6):
            history = program(plate(cell, given(part * RAYLEIGH), mass, levels))
            error, means = running(history, part * RAYLEIGH, cell)
            out.append((mass, f"{cell:g}", levels, part, percent(np.mean(error)), percent(np.std(error)),
                        f"{percent(means.min())} to {percent(means.max())}" if len(means) else "",
                        f"{history['fracture_energy'][-1] / history['integral_of_G'][-1]:.3f}"))
    write(out, "run", arguments.output)


def benchmark(program, arguments):
    out = [("mass", "cell [m]", "mean %", "scatter %", "cell means %")]
    for mass, cell in (("weighted", 0.05), ("weighted", 0.04), ("lumped", 0.04)):
        error, means = benchmark_errors(program(benchmark_scene(cell, mass)), cell)
        out.append((mass, f"{cell:g}", percent(np.mean(error)), percent(np.std(error)), f"{percent(means.min())} to {percent(means.max())}"))
    write(out, "benchmark", arguments.output)


def long_strip(program, arguments):
    out = [("levels", "v/c_R", "G/G of the strip", "scatter %", "slope a height %", "particles, end/start",
            "CPU time of a step, last quarter of the way/first")]
    for levels, part in ((1, 0.2), (1, 0.4), (2, 0.4)):
        speed = part * RAYLEIGH
        text = long_strip_scene(levels, speed)
        history = program(text)
        first, last = history["step"][history["tip_x"] > 0][[0, -1]]
        quarter = (last - first) // 4
        times = program.in_parts(text, [int(first), *3 * [int(quarter)]])
        dearer = times[4] / (last - first - 3 * quarter) / (times[1] / quarter)
        steady = history["tip_x"] > 30e-3
        ratio = history["J"][steady] / 26.922
        slope = np.polyfit(history["tip_x"][steady] / HEIGHT, ratio, 1)[0]
        out.append((levels, part, f"{np.mean(ratio):.4f}", percent(np.std(ratio)), f"{100 * slope:.4f}",
                    f"{history['particles'][-1] / history['particles'][0]:.3f}", f"{dearer:.2f}"))
    write(out, "long_strip", arguments.output)


def dcb(program, arguments):
    out = [("opening rate [mm/s]", "steps", "mean load %", "scatter %", "mean length [mm]", "last length [mm]", "kinetic/stored energy %", "CPU [s]")]
    compliance = dcb_compliance(program)
    for rate, dt in ((0.12, 2.5e-5), (0.06, 5e-5), (0.015, 2e-4), (0.015, 4e-4), (0.004, 1e-3)):
        text = example("dcb_growth_dynamic", velocity=f"0.0, {rate / 2}", end_time=60e-6 / rate + 0.25e-3).replace("-7.5e-3", f"-{rate / 2}")
        for method in ("", f"&method time = 'implicit'  time_step = {dt}  hht_alpha = -0.1 /\n"):
            history = program((text.replace("history_interval = 1.0e-5", f"history_interval = {dt}") if method else text) + method)
            load, scatter, mean, last, kinetic = dcb_errors(history, compliance, rate)
            out.append((f"{1e3 * rate:g}", history["step"][-1], percent(load), percent(scatter), f"{1e3 * mean:.2f}", f"{1e3 * last:.2f}", percent(kinetic),
                        f"{program.seconds:.2f}"))
    write(out, "dcb", arguments.output)


def slanted(program, arguments):
    out = [("cell", "v/c_R", "K_I %", "scatter %", "K_II %", "scatter %")]
    for cell, part in ((0.25e-3, 0.33), (0.125e-3, 0.16), (0.125e-3, 0.33), (0.125e-3, 0.6)):
        text, met = slanted_scene(cell, part * RAYLEIGH)
        errors = slanted_errors(program(text), met, part * RAYLEIGH, cell)
        out.append((f"{cell:g}", part, *(percent(x) for error in errors for x in (np.mean(error), np.std(error)))))
    write(out, "slanted", arguments.output)


def toughness(program, arguments):
    out = [("mass", "cell", "growth %", "rms of v/c_R %", "G/toughness", "scatter %")]
    for mass, cell in (("weighted", 0.4e-3), ("weighted", 0.2e-3), ("weighted", 0.1e-3), ("lumped", 0.2e-3), ("lumped", 0.1e-3)):
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


HALF, GRIP = 10e-3, 2e-6                                # of the strip with fixed edges [m]
AHEAD = YOUNG * (1 - POISSON) / ((1 + POISSON) * (1 - 2 * POISSON)) * GRIP**2 / HALF  # what it stores, G at any speed (Nilsson 1974) [J/m2]


def law_scene(cell, speed, solid, step):
    """A strip with fixed edges whose crack is to run at a speed: its toughness at rest is half of G, the limit speed twice the speed. `step`: of implicit steps; 0: explicit."""
    way = 14 * cell if speed < 0.1 * RAYLEIGH else 25e-3
    left, right, high = -30e-3, 20e-3 + way, HALF + cell
    z = lambda value: f", {value!r}" if solid else ""
    box = lambda y_0, y_1, x_0=left, x_1=right: f"lower = {x_0!r}, {y_0!r}{z(0.0)}  upper = {x_1!r}, {y_1!r}{z(cell)}"
    sides = "".join(f"&constraint lower = {left!r}, {-HALF!r}, {at!r}  upper = {right!r}, {HALF!r}, {at!r}  fix = 'z' /\n" for at in (0.0, cell)) if solid else ""
    return f"""&run {'' if solid else "plane = 'strain' "} end_time = {way / speed!r} /
&grid lower = {left!r}, {-high!r}{z(0.0)}  cell = {cell!r}  cells = {round((right - left) / cell)}, {round(2 * high / cell)}{', 1' if solid else ''} /
&material name = 'a'  young = {YOUNG!r}  poisson = {POISSON}  density = {DENSITY} /
&body material = 'a'  {box(-HALF, HALF)} /
&constraint {box(HALF, HALF)}  fix = 'xy'  displacement = 0.0, {GRIP!r}{z(0.0)} /
&constraint {box(-HALF, -HALF)}  fix = 'xy'  displacement = 0.0, {-GRIP!r}{z(0.0)} /
&constraint {box(-HALF, HALF, right)}  fix = 'x' /
{sides}&method start = 'static'  mass = 'weighted'  {f"time = 'implicit'  time_step = {step!r}" if step else ''} /
&crack kind = 'plane'  normal = 'y'  tip = 0.0, 0.0{z(cell / 2)}  direction = 1.0, 0.0{z(0.0)} /
&growth law = 'toughness'  direction = 'straight'  toughness = {AHEAD / 2!r}  limit_speed = {2 * speed!r} /
&energy_release estimators = 'domain_integral' /
&output file = 'growth.h5'  history_interval = {way / speed / 100!r} /
"""


def law_held(history, cell, speed, solid):
    """Means over the second half of the way: speed over the right one, G over the toughness and its scatter, and what faces take over the toughness times their area."""
    way, v, g = (history["crack_area"] / cell, history["front_speed"], history["G_mean"]) if solid else (history["crack_length"], history["tip_speed"], history["G"])
    late = history["time"] > history["time"][-1] / 2
    first, last = np.flatnonzero(late)[[0, -1]]
    far, taken = way[last] - way[first], history["fracture_energy"][last] - history["fracture_energy"][first]
    mean = far / (history["time"][last] - history["time"][first])
    ratio = g[late] / (AHEAD / 2) * np.maximum(0.0, 1 - v[late] / (2 * speed))
    return mean / speed, np.mean(ratio), np.std(ratio), taken / (cell if solid else 1.0) / far / (AHEAD / 2) * max(0.0, 1 - mean / (2 * speed))


def law(program, arguments):
    out = [("v/c_R", "", "steps", "cell [mm]", "speed, over the right one", "G over the toughness", "scatter %", "taken over toughness times area")]
    solids = Program(arguments.solids, arguments.output)
    for part, solid, implicit, cell in itertools.product((1e-4, 1e-3, 0.02, 0.2, 0.6, 0.9), (False, True), (False, True), (1e-3, 0.5e-3)):
        if not implicit and part < 0.02:                # up to a million explicit steps
            continue
        speed = part * RAYLEIGH
        history = (solids if solid else program)(law_scene(cell, speed, solid, cell / speed / 8 if implicit else 0.0))
        right, ratio, scatter, taken = law_held(history, cell, speed, solid)
        out.append((f"{part:g}", "slab" if solid else "plane", "implicit" if implicit else "explicit", 1e3 * cell,
                    f"{right:.3f}", f"{ratio:.3f}", percent(scatter), f"{taken:.3f}"))
    write(out, "law", arguments.output)
    draw_law(out[1:], arguments.output / "law.png")


def draw_law(rows, path):
    """Draw G over the toughness with its scatter, and what faces take, over the speed."""
    sys.path.insert(0, str(ROOT / "postprocess"))
    from pictures import plt  # noqa: PLC0415: only here

    figure, panels = plt.subplots(1, 2, figsize=(9, 3.4), sharey=True)
    for (where, how), marker in zip(itertools.product(("plane", "slab"), ("explicit", "implicit")), "os^v"):
        mine = [row for row in rows if (row[1], row[2]) == (where, how)]
        speed, ratio, scatter, taken = (np.array([float(row[k]) for row in mine]) for k in (0, 5, 6, 7))
        panels[0].errorbar(speed, ratio, scatter / 100, fmt=marker, markersize=4, capsize=2, linewidth=0.8, label=f"{where}, {how}")
        panels[1].plot(speed, taken, marker, markersize=4)
    for panel, title in zip(panels, ("G over the toughness, mean and scatter", "energy that faces take, over toughness times area")):
        panel.axhline(1, color="black", linewidth=0.6)
        panel.axhspan(0.98, 1.02, color="black", alpha=0.07)
        panel.set(xscale="log", xlabel="$v/c_R$", title=title)
        panel.title.set_fontsize(9)
    panels[0].legend(fontsize=8)
    figure.tight_layout()
    figure.savefig(path, dpi=110)


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
    out = [("finest cell", "levels", "direction", "v/c_R", "CPU time of a step, growing/resting", "particles, end/start")]
    for cell, levels in ((0.1e-3, 0), (0.1e-3, 2)):
        for direction, part in (("straight", 0.05), ("straight", 0.16), ("straight", 0.33), ("hoop_stress", 0.33)):
            times = []
            for start in (1e3, 1.5):             # long after the end it rests
                history = program(plate(cell, given(part * RAYLEIGH, start), "lumped", levels, interval=2e-7).replace("straight", direction))
                times.append(program.seconds / history["step"][-1])
            particles = history["particles"][-1] / history["particles"][0]
            out.append((f"{cell:g}", levels, direction, part, f"{times[1] / times[0]:.2f}", f"{particles:.3f}"))
    write(out, "cost", arguments.output)


PARTS = {"run": run, "benchmark": benchmark, "slanted": slanted, "toughness": toughness, "strip": strip, "law": law, "long_strip": long_strip, "dcb": dcb,
         "kalthoff": kalthoff, "cost": cost}


def main():
    arguments = command_line(__doc__, list(PARTS), "results/growth", solids=(ROOT / "build/release3d/hampm3d", "program of solids, for `law`"))
    program = Program(arguments.program, arguments.output)
    for part in arguments.part:
        PARTS[part](program, arguments)


if __name__ == "__main__":
    main()
