"""What solids cost: a step beside a copy of its state, solutions at rest by both solvers, and the beam of square arms, by size.

    step    ns of the processor per particle and step of a cube, both frames, over four sizes, beside a copy of its state in the same turn
    count   instructions per particle and step of a cube by valgrind, all schemes in both frames
    rest    seconds of the processor and the peak of the memory of a cube at rest by factors and by conjugate gradients with a multigrid,
            beside what --check foretells
    beam    seconds of the processor for the mean of G along the front of input/solid/dcb.nml, on uniform and refined cells and by
            Richardson's extrapolation

Run by `make -C bench solids`, or for some parts: .venv/bin/python bench/solid_speed.py rest --output DIR.
"""

import os
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from instructions import run_counted
from tables import ROOT, command_line, write


COLUMNS = 3 + 3 + 3 + 9 + 1 + 1  # of the state of a particle: place, displacement, velocity, gradient, mass, volume
CUBE = """
&run end_time = {end!r} /
&grid lower = 0.0, 0.0, 0.0  cell = {cell!r}  cells = {n}, {n}, {n} /
&material name = 'a'  young = 200.0e9  poisson = 0.3  density = 7800.0 /
&body material = 'a'  lower = 0.0, 0.0, 0.0  upper = 1.0, 1.0, 1.0  {body} /
&constraint lower = 0.0, 0.0, 0.0  upper = 1.0, 1.0, 0.0  fix = 'xyz' /
{load}
&method {method} /
&output file = 'case.h5'  history_interval = {end!r} /
"""
LOAD = "&load kind = 'traction'  lower = 0.0, 0.0, 1.0  upper = 1.0, 1.0, 1.0  force = 1.0e6, 0.0, 1.0e6 /"
# A process begins with the peak of the one that started it: that must be a small one
MEASURE = """
import os, sys
_, status, used = os.wait4(os.spawnv(os.P_NOWAIT, sys.argv[1], sys.argv[1:]), 0)
print(used.ru_utime + used.ru_stime, used.ru_maxrss)
sys.exit(status != 0)
"""


def run(program, folder, text):
    """Processor seconds and the peak of the memory [MB] of a run on one thread, and the memory that was foretold."""
    (folder / "case.nml").write_text(text)
    check = subprocess.run([program, "case.nml", "--check"], cwd=folder, capture_output=True, text=True, check=True).stdout
    number, unit = re.search(r"! memory +about (\S+) (\w+)", check).groups()
    done = subprocess.run([sys.executable, "-c", MEASURE, program, "case.nml", "--quiet", "--force", "--threads", "1"], cwd=folder,
                          env=os.environ | {"OMP_NUM_THREADS": "1"}, stdout=subprocess.PIPE, text=True, check=True).stdout.split()
    return float(done[0]), 1024e-6 * float(done[1]), float(number) * {"kB": 1e-3, "MB": 1, "GB": 1e3}[unit]


def copy_seconds(particles):
    """Processor seconds to copy the state of particles once, the least of five."""
    state = [np.ones(particles) for _ in range(COLUMNS)]
    other = [np.zeros(particles) for _ in range(COLUMNS)]
    taken = []
    for _ in range(5):
        start = time.process_time()
        for a, b in zip(state, other):
            np.copyto(b, a)
        taken.append(time.process_time() - start)
    return min(taken)


def step(program, folder):
    """Each turn measures few and many steps, whose difference is that of the steps alone, and the copy."""
    rows = [["frame", "particles", "ns", "copy ns", "ratio", "MB", "foretold MB", "bytes a particle"]]
    speed = (200e9 * 0.7 / (1.3 * 0.4) / 7800.0) ** 0.5
    for frame in ("updated", "total"):
        for n in (10, 23, 32, 50):
            particles, dt = 8 * n**3, 0.2 / n / speed
            few, many = 5, 5 + max(30, 10_000_000 // particles)
            turns = []
            for _ in range(3):
                taken = []
                for steps in (few, many):
                    seconds, peak, foretold = run(program, folder, CUBE.format(
                        n=n, cell=1 / n, end=steps * dt, load="", body="velocity = 1.0, 0.0, 0.0", method=f"frame = '{frame}'  courant = 0.2"))
                    taken.append(seconds)
                turns.append(((taken[1] - taken[0]) / (many - few) / particles * 1e9, copy_seconds(particles) / particles * 1e9))
            ns, copy = (sorted(values)[1] for values in zip(*turns))
            rows.append([frame, particles, f"{ns:.0f}", f"{copy:.0f}", f"{ns / copy:.1f}", f"{peak:.0f}", f"{foretold:.0f}",
                         f"{peak * 1e6 / particles:.0f}"])
            print(rows[-1], flush=True)
    return rows


def count(program, folder):
    """The difference of two numbers of steps: without the start."""
    rows = [["frame", "scheme", "particles", "instructions"]]
    n, few, many = 16, 4, 12
    speed = (200e9 * 0.7 / (1.3 * 0.4) / 7800.0) ** 0.5
    for frame in ("updated", "total"):
        for scheme in ("musl", "usl", "usf", "usavg"):
            counts = []
            for steps in (few, many):
                (folder / "case.nml").write_text(CUBE.format(
                    n=n, cell=1 / n, end=steps * 0.2 / n / speed, load="", body="velocity = 1.0, 0.0, 0.0",
                    method=f"frame = '{frame}'  scheme = '{scheme}'  courant = 0.2"))
                counts.append(run_counted(program, folder / "case.nml", "--output", folder, "--quiet", "--force", "--threads", "1")[1])
            rows.append([frame, scheme, 8 * n**3, f"{(counts[1] - counts[0]) / (many - few) / (8 * n**3):.1f}"])
            print(rows[-1], flush=True)
    return rows


def rest(program, folder):
    """Up to where factors take too long to wait for."""
    rows = [["solver", "unknowns", "s", "MB", "foretold MB", "bytes an unknown"]]
    for solver, sizes in (("direct", (14, 20, 28, 36)), ("cg", (14, 20, 28, 36, 46))):
        for n in sizes:
            unknowns = 3 * (n + 1) ** 2 * n
            seconds, peak, foretold = run(program, folder, CUBE.format(
                n=n, cell=1 / n, end=1.0, load=LOAD, body="", method=f"time = 'static'  frame = 'total'  solver = '{solver}'"))
            rows.append([solver, unknowns, f"{seconds:.1f}", f"{peak:.0f}", f"{foretold:.0f}", f"{peak * 1e6 / unknowns:.0f}"])
            print(rows[-1], flush=True)
    return rows


def beam(program, folder):
    """Uniform and refined cells; Richardson's extrapolation of the means takes the order of the three before, or 1 of two."""
    rows = [["cells [mm]", "around the front [mm]", "mean over G_ref", "error %", "s"]]
    text = (ROOT / "input/solid/dcb.nml").read_text()
    reference = 1.28321

    def change(cell, level):
        k = round(0.01 / cell)
        changed = text.replace("cell = 0.625e-3", f"cell = {cell!r}").replace("cells = 160, 17, 8", f"cells = {10 * k}, {k + 1}, {k // 2}")
        return changed.replace("max_level = 1", f"max_level = {level}") if level else re.sub(r"&refine.*?\n/\n", "", changed, flags=re.S)

    means = {}
    for cell, level in ((2.5e-3, 0), (1.25e-3, 0), (0.625e-3, 0), (0.3125e-3, 0), (2.5e-3, 1), (1.25e-3, 1), (0.625e-3, 1), (0.625e-3, 2)):
        seconds, _, _ = run(program, folder, change(cell, level).replace("file = 'dcb.h5'", "file = 'case.h5'"))
        out = subprocess.run([sys.executable, ROOT / "postprocess/plot_front.py", "case.h5", "--ligament", "ligament", "--scale", "4.2857e-3"],
                             cwd=folder, capture_output=True, text=True, check=True).stdout
        mean = float(re.search(r"mean[^0-9]*([0-9.]+)", out)[1])
        means[cell, level] = mean, seconds
        rows.append([f"{1e3 * cell:g}", f"{1e3 * cell / 2**level:g}", f"{mean:.5f}", f"{100 * (mean / reference - 1):.2f}", f"{seconds:.1f}"])
        print(rows[-1], out.splitlines()[-1], flush=True)
    uniform = [means[cell, 0] for cell in (2.5e-3, 1.25e-3, 0.625e-3, 0.3125e-3)]
    for k in (2, 3):
        (a, s), (b, t), (c, u) = uniform[k - 2:k + 1]
        best = c + (c - b) ** 2 / ((b - a) - (c - b))
        rows.append(["three above", f"from {2.5 / 2**k:g}", f"{best:.5f}", f"{100 * (best / reference - 1):.2f}", f"{s + t + u:.1f}"])
    for (coarse, fine) in (((1.25e-3, 0), (0.625e-3, 0)), ((0.625e-3, 0), (0.3125e-3, 0)), ((2.5e-3, 1), (1.25e-3, 1)), ((1.25e-3, 1), (0.625e-3, 1))):
        best = 2 * means[fine][0] - means[coarse][0]
        rows.append(["pair, order 1", f"{1e3 * fine[0] / 2**fine[1]:g}", f"{best:.5f}", f"{100 * (best / reference - 1):.2f}",
                     f"{means[fine][1] + means[coarse][1]:.1f}"])
    return rows


def main():
    parts = {"step": step, "count": count, "rest": rest, "beam": beam}
    arguments = command_line(__doc__, list(parts), ROOT / "results/solids", ROOT / "build/release3d/hampm3d")
    for part in arguments.part:
        with tempfile.TemporaryDirectory() as folder:
            write(parts[part](arguments.program.resolve(), Path(folder)), f"solid_{part}", arguments.output)


if __name__ == "__main__":
    main()
