"""Cost over size: how the processor time of a run grows with the number of everything of which a model may have many.

    .venv/bin/python bench/sizes.py [FAMILY ...] [--program FILE] [--solid FILE] [--output DIR]

Each family asks the same question in several sizes, on one thread. The exponent is that of time over size between the two largest, without the time of the smallest; at
most 1.15 is asked. One table, on the screen and as CSV.
"""

import math
import os
import subprocess
import tempfile
from pathlib import Path

from tables import ROOT, command_line, write

MOST = 1.15
STEP = 0.5 / math.sqrt(1e9 / 2.6 / 1000)  # of courant = 0.5 in the material below [s]


def model(cells, *parts, steps=0, rows=1, snapshots=0):
    """A model of cells of 1 m with a corner at -1: at rest, or in steps with rows of the history and snapshots."""
    end = STEP * steps if steps else 1.0
    keys = f"history_interval = {end / rows:.12e}" + (f"  snapshot_interval = {end / snapshots:.12e}" if snapshots else "")
    lines = ["&run end_time = %.12e" % end + ("" if len(cells) == 3 else "  plane = 'strain'  thickness = 1.0") + " /", f"&grid lower = {at(*[-1] * len(cells))}  cell = 1.0  cells = {', '.join(map(str, cells))} /",
             "&material name = 'a'  young = 1e9  poisson = 0.3  density = 1000.0 /", *parts]
    return "\n".join([*lines, "&method courant = 0.5 /" if steps else "&method time = 'static' /", f"&output file = 'run.h5'  {keys} /\n"])


def at(*place):
    return ", ".join(f"{x:.9g}" for x in map(float, place))


def block(*size, force=1e3, also=""):
    """A block that stands on its lower side and is pulled on its upper one."""
    top = [*size[:-1]]
    axes = "xyz"[: len(size)]
    low = [0] * len(size)
    return [f"&body material = 'a'  lower = {at(*low)}  upper = {at(*size)} /", f"&constraint lower = {at(*low)}  upper = {at(*top, 0)}  fix = '{axes}' /",
            f"&load kind = 'traction'  lower = {at(*low[:-1], size[-1])}  upper = {at(*size)}  force = {at(*low[:-1], force * math.prod(top))} {also} /"]


def lattice(count, step):
    """Lower corners of squares in a square."""
    side = math.isqrt(count)
    return [(step * i, step * j) for i in range(side) for j in range(side)]


def crack(*points, name="c"):
    return f"&crack kind = 'path'  name = '{name}'  points = {at(*points)} /"


def cells_at_rest(n):
    side = math.isqrt(n)
    return model((side + 2, side + 2), *block(side, side))


def particles_in_steps(n):
    side = math.isqrt(n // 4)
    return model((side + 2, side + 2), *block(side, side), steps=20)


def solid_at_rest(n):
    side = round(n ** (1 / 3))
    return model((side + 2,) * 3, *block(side, side, side))


def solid_in_steps(n):
    side = round((n / 8) ** (1 / 3))
    return model((side + 2,) * 3, *block(side, side, side), steps=20)


def bodies(n):
    """The squares of a block of 128 by 128 cells, bonded, under their weight."""
    step = 128 // math.isqrt(n)
    squares = [f"&body material = 'a'  lower = {at(x, y)}  upper = {at(x + step, y + step)} /" for x, y in lattice(n, step)]
    return model((130, 130), *squares, "&constraint lower = 0.0, 0.0  upper = 128.0, 0.0  fix = 'xy' /", "&load kind = 'gravity'  acceleration = 0.0, -10.0 /")


def meeting(n):
    """Squares of 4 by 4 cells with gaps of a cell, which fly and may meet, for 20 steps."""
    side = 5 * math.isqrt(n)
    squares = [f"&body material = 'a'  lower = {at(x, y)}  upper = {at(x + 4, y + 4)}  velocity = {at(x % 2, 0)} /" for x, y in lattice(n, 5)]
    return model((side + 2, side + 2), *squares, "&contact bodies = 'frictionless' /", steps=20).replace("&method", "&method frame = 'updated' ").replace("courant = 0.5", "courant = 0.1")


def cracks(n):
    """Cracks of 4 cells in squares of 12, J and K of all tips."""
    side = 12 * math.isqrt(n)
    lines = [crack(x + 4.3, y + 6.5, x + 8.3, y + 6.5, name=f"c{k}") for k, (x, y) in enumerate(lattice(n, 12))]
    return model((side + 2, side + 2), *block(side, side), *lines, "&energy_release estimators = 'domain_integral' /")


def segments(n):
    """A crack that zigzags, of segments of two cells."""
    points = [value for k in range(n + 1) for value in (10.2 + 2.2 * k, 10.3 + 0.2 * (k % 2))]
    return model((11 * n // 5 + 32, 22), *block(11 * n // 5 + 30, 20), crack(*points), "&energy_release estimators = 'domain_integral' /")


def faces(n):
    """A crack of so many cells whose faces press on each other."""
    return model((n + 22, 14), *block(n + 20, 12, force=-1e3), crack(10.2, 6.4, n + 10.2, 6.4).replace(" /", "  contact = 'frictionless' /"))


def remeshing(n):
    """The same crack, open, whose tip runs for three cells in 20 steps: interface points are placed anew."""
    return model((n + 22, 14), *block(n + 20, 12), crack(10.2, 6.4, n + 10.2, 6.4).replace(" /", "  contact = 'frictionless' /"),
                 "&growth crack = 'c'  law = 'prescribed'  speed = 200.0  direction = 'straight'  tips = 'last' /", "&energy_release estimators = 'domain_integral' /", steps=20)


def probes(n):
    """Points whose displacement is recorded in 100 rows."""
    points = [f"&probe name = 'p{k}'  quantity = 'displacement'  at = {at(1 + 98 * (k * 0.618034 % 1), 1 + 98 * (k * 0.754878 % 1))} /" for k in range(n)]
    return model((102, 102), *block(100, 100), *points, steps=100, rows=100)


def boxes(n):
    """Loads along the upper edge, and as many supports along the lower one."""
    ends = [450 * k / n for k in range(n + 1)]
    loads = [f"&load kind = 'traction'  lower = {at(a, 20)}  upper = {at(b, 20)}  force = {at(0, 1e4 / n)} /" for a, b in zip(ends, ends[1:])]
    held = [f"&constraint lower = {at(a, 0)}  upper = {at(b, 0)}  fix = 'xy' /" for a, b in zip(ends, ends[1:])]
    return model((452, 22), "&body material = 'a'  lower = 0.0, 0.0  upper = 450.0, 20.0 /", *loads, *held)


def rows(n):
    """A row of the history in each step of eight cells."""
    return model((6, 4), *block(4, 2), steps=n, rows=n)


def snapshots(n):
    return model((6, 4), *block(4, 2), steps=n, snapshots=n)


def table(n):
    """A load by a table of so many places, for 2000 steps of eight cells."""
    times, factors = (", ".join(f"{value:.9g}" for value in values) for values in ([2000 * STEP * k / n for k in range(n)], [float(k % 3) for k in range(n)]))
    return model((6, 4), *block(4, 2, also=f"history = 'table'  times = {times}  factors = {factors}"), steps=2000)


# The sizes of each
FAMILIES = {cells_at_rest: (1600, 6400, 25600, 102400), particles_in_steps: (10000, 100000, 1000000), solid_at_rest: (1000, 8000, 27000), solid_in_steps: (8000, 64000, 512000),
            bodies: (16, 64, 256, 1024, 4096), meeting: (2, 4, 16), cracks: (4, 16, 64, 256, 900), segments: (10, 100, 1000), faces: (100, 1000, 4000), remeshing: (100, 1000, 10000), probes: (10, 100, 900),
            boxes: (10, 100, 450), rows: (10000, 100000, 1000000), snapshots: (100, 1000, 10000), table: (100, 1000, 10000)}


def cost(program, text):
    """Processor time of a run [s], the least of as many as take a second, and its memory [MB]."""
    best, most, spent = math.inf, 0, 0.0
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "run.nml").write_text(text)
        while spent < 1:
            with open(Path(folder, "log"), "w") as log:
                process = subprocess.Popen([str(program.resolve()), "run.nml", "--quiet", "--force", "--threads", "1"], cwd=folder, stdout=log, stderr=log)
                _, status, usage = os.wait4(process.pid, 0)
            if os.waitstatus_to_exitcode(status):
                raise SystemExit(f"{text[:2000]}\n{Path(folder, 'log').read_text()[:1000]}")
            seconds = usage.ru_utime + usage.ru_stime
            best, most, spent = min(best, seconds), max(most, usage.ru_maxrss / 1024), spent + seconds
    return best, most


def main():
    names = {family.__name__: family for family in FAMILIES}
    arguments = command_line(__doc__, list(names), "results/sizes", solid=(ROOT / "build/release3d/hampm3d", "the program for solids"))
    found = [("family", "sizes", "seconds", "MB", "exponent", f"at most {MOST}")]
    for name in arguments.part:
        sizes = FAMILIES[names[name]]
        times, memory = zip(*(cost(arguments.solid if name.startswith("solid") else arguments.program, names[name](size)) for size in sizes))
        exponent = math.log(max(times[-1] - times[0], 1e-3) / max(times[-2] - times[0], 1e-3)) / math.log(sizes[-1] / sizes[-2])
        found.append((name, *(" ".join(form % value for value in values) for form, values in (("%d", sizes), ("%.2f", times), ("%.0f", memory))), f"{exponent:.2f}", "yes" if exponent <= MOST else "no"))
        print(*found[-1], flush=True)
    write(found, "sizes", arguments.output)


if __name__ == "__main__":
    main()
