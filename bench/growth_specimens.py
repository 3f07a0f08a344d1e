"""Specimens whose cracks move or turn, for `prediction_coverage.py`, with truth from closed forms.

  speed   strips between rigid grips, plane and as a slab, by toughness(v), in explicit and implicit steps: G as at rest at any speed (Nilsson 1974); and, where
          they are slow, the way
  stops   the same strips, whose toughness rises along the way to more than G: the crack comes to rest where both are equal
  slow    the same strips, whose grips move so slowly that waves do not matter, across and along: the time at which G is the toughness
  wave    a plane wave meets a crack of a half plane: K_I(t) or, by the hoop stress, K_II(t) tell the time at which it starts (Freund 1990, 2.5 and 3.2)
  path    a centre crack across the tension, beside the grid lines: its path is straight
  turn    a slanted crack in a plate, a notch beside the load of a bent beam: their paths by integral equations (tests/reference/growth), in increments of half the
          size, a third of whose difference counts for the estimate
"""

import math
import random
import tempfile
from pathlib import Path

from program_runs import Program

ROOT = Path(__file__).resolve().parent.parent

YOUNG, POISSON, DENSITY = 200e9, 0.3, 5000.0
MODULUS, SHEAR = YOUNG / (1 - POISSON**2), YOUNG / (2 * (1 + POISSON))
ACROSS = YOUNG * (1 - POISSON) / ((1 + POISSON) * (1 - 2 * POISSON))
WAVES = math.sqrt(ACROSS / DENSITY), math.sqrt(SHEAR / DENSITY)
RAYLEIGH = 0.9274 * WAVES[1]
HOOP = 2 / math.sqrt(3)                                      # largest hoop stress of mode II, over K_II


def head(low, high, cell, solid, end):
    """Namelist of a body in plane strain; a slab is one cell thick."""
    z = lambda x: f", {x!r}" if solid else ""
    counts = [round((b - a) / cell) + 2 for a, b in zip(low, high)]
    return (f"&run {'' if solid else 'plane = ' + repr('strain')}  end_time = {float(end)!r} /\n"
            f"&grid lower = {low[0] - cell!r}, {low[1] - cell!r}{z(0.0)}  cell = {cell!r}  cells = {counts[0]}, {counts[1]}{', 1' if solid else ''} /\n"
            f"&material name = 'a'  young = {YOUNG}  poisson = {POISSON}  density = {DENSITY} /\n"
            f"&body material = 'a'  lower = {low[0]!r}, {low[1]!r}{z(0.0)}  upper = {high[0]!r}, {high[1]!r}{z(cell)} /\n"
            "&energy_release estimators = 'domain_integral' /\n")


def strip(r, solid, grip, law, end, method, history=""):
    """A strip with its tip anywhere in a cell of the middle; grips move by a vector [m]."""
    half = 8e-3
    cell = half / r.choice((6, 8))
    left, right, tip = -6 * half, 7 * half, r.uniform(-0.5, 0.5) * cell
    z = lambda x: f", {x!r}" if solid else ""
    text = head((left, -half), (right, half), cell, solid, end)
    for y in (half, -half):
        text += (f"&constraint lower = {left!r}, {y!r}{z(0.0)}  upper = {right!r}, {y!r}{z(cell)}  fix = 'xy'  "
                 f"displacement = {math.copysign(grip[0], y)!r}, {math.copysign(grip[1], y)!r}{z(0.0)} {history} /\n")
    if not grip[0]:                                        # as the strip goes on
        text += f"&constraint lower = {right!r}, {-half!r}{z(0.0)}  upper = {right!r}, {half!r}{z(cell)}  fix = 'x' /\n"
    if solid:
        text += "".join(f"&constraint lower = {left!r}, {-half!r}, {x!r}  upper = {right!r}, {half!r}, {x!r}  fix = 'z' /\n" for x in (0.0, cell))
    text += f"&crack kind = 'plane'  normal = 'y'  tip = {tip!r}, 0.0{z(cell / 2)}  direction = 1.0, 0.0{z(0.0)} /\n&growth law = 'toughness'  {law(cell)} /\n{method(cell)}"
    return text, cell


def speed(r, solid):
    """Text, and a function of the row and the cell that gives values."""
    v = RAYLEIGH * (r.choice((0.1, 0.2, 0.4, 0.6)) if r.random() < 0.4 else 10 ** r.uniform(-3.5, -1.5))
    part, is_slow = r.uniform(0.3, 0.7), v < 0.05 * RAYLEIGH
    rate = ACROSS * 1e-12 / 8e-3
    implicit = is_slow or r.random() < 0.5
    way = 5e-3 if is_slow else 20e-3
    text, cell = strip(r, solid, (0.0, 1e-6), lambda cell: f"direction = 'straight'  toughness = {rate * part!r}  limit_speed = {v / (1 - part)!r}", way / v,
                       lambda cell: f"&method start = 'static'  {f'time = {chr(39)}implicit{chr(39)}  time_step = {cell / v / 8!r}' if implicit else ''} /\n"
                                    f"&output file = 'run.h5'  history_interval = {way / v / 20!r} /\n")

    def found(row, told):
        name, tail = ("front_speed", "crack_area") if solid else ("tip_speed", "crack_length")
        yield "speed in motion", row[name][-1], v, row[name + "_error"][-1], 0.0
        if is_slow:
            width = cell if solid else 1.0
            yield "way in motion", (row[tail][-1] - row[tail][0]) / width, v * row["time"][-1], row[tail + "_error"][-1] / width, 0.0
    return text, found


def stops(r, solid):
    """A strip whose toughness rises with the way x to G at x_a: v = v_0 (1 - x/x_a)."""
    v, part = RAYLEIGH * r.uniform(0.03, 0.15), r.uniform(0.4, 0.8)
    rise = r.uniform(1.3, 2.0) / part                      # of the toughness, to more than G
    rate, far = ACROSS * 1e-12 / 8e-3, 8e-3 * r.uniform(0.5, 1.2)
    end = far * (rise - 1) / (1 / part - 1)                # of the curve
    text, cell = strip(r, solid, (0.0, 1e-6), lambda cell: f"direction = 'straight'  toughness = {rate * part!r}  limit_speed = {v / (1 - part)!r}  "
                       f"extensions = 0.0, {end!r}  extension_factors = 1.0, {rise!r}", 6 * far / v,
                    lambda cell: f"&method start = 'static' /\n&output file = 'run.h5'  history_interval = {far / v / 4!r} /\n")

    def found(row, told):
        name, width = ("crack_area", cell) if solid else ("crack_length", 1.0)
        yield "arrest in motion", (row[name][-1] - row[name][0]) / width, far * (1 - math.exp(-v * row["time"][-1] / far)), row[name + "_error"][-1] / width, 0.0
    return text, found


def slow(r, solid):
    """Onset in a strip whose grips move in 10 ms, some thousand times the time of a wave across it."""
    along = r.choice((0.0, 1.0)) * r.uniform(1.0, 3.0)
    grip = (along * 1e-6, 1e-6)
    full = (ACROSS * grip[1] ** 2 + SHEAR * grip[0] ** 2) / 8e-3
    part, rise = r.uniform(0.4, 0.9), 1e-2                 # of the rise, at the start; its time [s]
    text, _ = strip(r, solid, grip, lambda cell: f"direction = 'straight'  toughness = {full * part**2!r}  limit_speed = {10 * cell / rise!r}", 1.1 * part * rise,
                    lambda cell: f"&method start = 'static'  time = 'implicit'  time_step = {part * rise / 300!r} /\n&output file = 'run.h5'  history_interval = {rise / 10!r} /\n",
                    f"history = 'ramp'  rise_time = {rise!r}")

    def found(row, told):
        yield f"onset time, {'shear' if along else 'opening'}", told["onset_time"], part * rise, told["onset_time_error"], 0.0
    return text, found


def wave(r, solid):
    """Onset under a wave."""
    half, shears = 10e-3, r.random() < 0.5
    cell = half / r.choice((25, 40))
    fast = WAVES[shears]
    start = r.uniform(0.25, 0.8) * half / fast             # after the wave has come
    turns = shears and not solid                           # a front stays in its plane, and starts by G
    if shears:
        k = 2e6 * math.sqrt(2 * fast * start / (math.pi * (1 - POISSON))) * (HOOP if turns else 1.0)
    else:
        k = 2e6 / (1 - POISSON) * math.sqrt(fast * start * (1 - 2 * POISSON) / math.pi)
    right = half / fast + start
    text = head((-half, -half), (half, half), cell, solid, right + 0.3 * half / fast)
    z = lambda x: f", {x!r}" if solid else ""
    for side in (-half, half):
        text += f"&constraint lower = {side!r}, {-half!r}{z(0.0)}  upper = {side!r}, {half!r}{z(cell)}  fix = '{'y' if shears else 'x'}' /\n"
        push = math.copysign(1e6 * half * (cell if solid else 1.0), side)
        text += (f"&load kind = 'traction'  lower = {-half!r}, {side!r}{z(0.0)}  upper = {half!r}, {side!r}{z(cell)}  "
                 f"force = {f'{push!r}, 0.0' if shears else f'0.0, {push!r}'}{z(0.0)} /\n")
    if solid:
        text += "".join(f"&constraint lower = {-half!r}, {-half!r}, {x!r}  upper = {half!r}, {half!r}, {x!r}  fix = 'z' /\n" for x in (0.0, cell))
    y, tip = r.uniform(-0.4, 0.4) * cell, r.uniform(-0.5, 0.5) * cell
    crack = f"kind = 'plane'  normal = 'y'  tip = {tip!r}, 0.0, {cell / 2!r}  direction = 1.0, 0.0, 0.0" if solid else f"kind = 'path'  points = {-half!r}, {y!r}, {tip!r}, 0.0"
    text += (f"&crack {crack} /\n&growth law = 'toughness'  toughness = {k**2 / MODULUS!r}  direction = '{'hoop_stress' if turns else 'straight'}' /\n"
             f"&output file = 'run.h5'  history_interval = {right / 50!r} /\n")

    def found(row, told):
        yield f"onset time, wave{' of shear' if shears else ''}{', slab' if solid else ''}", told["onset_time"], right, told["onset_time_error"], 0.0
    return text, found


def path(r, solid):
    """A centre crack that grows straight on."""
    half = 8e-3
    cell = half / r.choice((10, 16))
    a, y = half * r.uniform(0.25, 0.4), r.uniform(0.1, 0.9) * cell
    low, high = (0.0, -3 * half), (half, 3 * half)
    text = head(low, high, cell, False, 1.0)
    text += f"&constraint lower = 0.0, {low[1]!r}  upper = 0.0, {high[1]!r}  fix = 'x' /\n&constraint lower = {half!r}, 0.0  upper = {half!r}, 0.0  fix = 'y' /\n"
    text += "".join(f"&load kind = 'traction'  lower = 0.0, {side!r}  upper = {half!r}, {side!r}  force = 0.0, {math.copysign(1e7 * half, side)!r} /\n" for side in (low[1], high[1]))
    text += f"&crack kind = 'path'  points = 0.0, {y!r}, {a!r}, {y!r} /\n"
    text += (f"&growth direction = '{r.choice(('hoop_stress', 'local_symmetry', 'max_energy'))}'  toughness = 10.0  increment = {r.choice((2.0, 3.0)) * cell!r} /\n"
             f"&method time = 'static'  load_steps = {max(2, int(0.25 * half / cell / 2))} /\n&output file = 'run.h5' /\n")

    def found(row, told):
        yield "path", row["tip_x"][-1] - row["tip_x"][0], row["tip_x"][-1] - row["tip_x"][0] + row["tip_y"][-1] - y, row["path_error"][-1], 0.0
    return text, found


def turn(r, solid):
    """A crack that turns: at 45 degrees in a plate of 40 by 80 mm, or beside the load of a beam of 120 by 30 mm."""
    mm, slanted = 1e-3, r.random() < 0.5
    cell, levels, part = (r.choice((0.8, 1.0)) if slanted else r.choice((0.75, 1.0))) * mm, r.choice((1, 2)), r.uniform(0.5, 1.0)
    half = (20.0, 40.0) if slanted else (60.0, 15.0)
    text = head([-x * mm for x in half], [x * mm for x in half], cell, False, 1.0)
    if slanted:
        points, pulls = [-8 * math.sqrt(0.5), -8 * math.sqrt(0.5), 8 * math.sqrt(0.5), 8 * math.sqrt(0.5)], [(-20, 20, y, y / 40 * 4e4) for y in (-40, 40)]
        name, number, step, way = "p1_path_slanted_45.csv", "2", 1.6 * part, 8.0
    else:
        points, pulls = [-20, -16, -20, -6], [(-1, 1, 15, -2e3), (-51, -49, -15, 1e3), (49, 51, -15, 1e3)]
        name, number, step, way = "p4_path_three_point_bend.csv", "1", 1.5 * part, 9.0
    text += "".join(f"&load kind = 'traction'  lower = {a * mm!r}, {y * mm!r}  upper = {b * mm!r}, {y * mm!r}  force = 0.0, {force!r} /\n" for a, b, y, force in pulls)
    text += f"&crack kind = 'path'  points = {', '.join(repr(x * mm) for x in points)} /\n"
    text += (f"&growth direction = 'local_symmetry'  toughness = 100.0  increment = {step * mm!r} /\n&refine indicator = 'tip'  max_level = {levels}  rings = 8 /\n"
             f"&method time = 'static'  load_steps = {round(way / step)} /\n&output file = 'run.h5' /\n")
    lines = [line.split(",") for line in (ROOT / "tests/reference/growth" / name).read_text().splitlines()]
    coarse, fine = ([[float(x) * mm for x in line[3:5]] for line in lines if line[:2] == [f"{size:g} mm", number]] for size in ((1.6, 0.8) if slanted else (1.5, 0.75)))

    def beside(path, x, y):
        """How far a place is to the left of the two points of a path that are the nearest [m]."""
        (ax, ay), (bx, by) = sorted(sorted(path, key=lambda p: math.hypot(p[0] - x, p[1] - y))[:2], key=path.index)
        return ((bx - ax) * (y - ay) - (by - ay) * (x - ax)) / math.hypot(bx - ax, by - ay)

    def found(row, told):
        x, y = row["tip_x"][-1], row["tip_y"][-1]
        off, of_coarse = beside(fine, x, y), beside(coarse, x, y)
        yield "path, curved", way * mm + off, way * mm, row["path_error"][-1], abs(off - of_coarse) / 3 / (way * mm)
    return text, found


def drawn(make, seed, k):
    """Whether a specimen is a solid, its namelist, and the function of its row and attributes that gives its values."""
    r = random.Random(f"{make.__name__} {seed} {k}")
    solid = make not in (path, turn) and r.random() < 0.25
    return solid, *make(r, solid)


def moving(seed, number, program, program3d):
    """Values of so many specimens of each kind as they come, as those of `measure`."""
    import h5py  # noqa: PLC0415: only here

    for make in (speed, stops, slow, wave, path, turn):
        for k in range(number):
            solid, text, found = drawn(make, seed, k)
            with tempfile.TemporaryDirectory() as folder:
                run = Program(program3d if solid else program, folder)(text, codes=(0, 2, 3))
                if run.code != 0:
                    print(make.__name__, k, "refused:", run.message.strip()[-200:])
                    continue
                row = run.columns
                with h5py.File(run.path) as file:
                    told = dict(file["history/front_speed" if solid else "history/tip_speed"].attrs) if make in (slow, wave) else {}
                try:
                    yield from ((make.__name__ + " slab" * solid, "motion", "strain", 1, 0, 0.0, 0.0, name, abs(value / exact - 1), error / abs(exact), more)
                                for name, value, exact, error, more in found(row, told))
                except KeyError as missing:
                    print(make.__name__, k, "has no", missing)
