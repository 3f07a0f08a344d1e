"""Particles with domains, shape_functions = 'cpdi', beside bilinear functions: the tables of docs/explanation/domains.md.

    turns        ten turns of a free square: angular momentum, energy, the audit
    cantilever   bent by 0.6 of its length, over the cell, against equilibrium in the total frame
    bar          under its own weight, over the cell, against the exact displacement
    cost         processor time of a particle and step, and of the same motion, over that of bilinear functions

Run by `make -C bench domains`, about ten minutes, or for some parts: .venv/bin/python bench/domains.py cost. The manufactured solutions are a unit test:
build/release/test_manufactured fine.
"""

import math
import resource
import statistics
import tempfile
from pathlib import Path

from domain_scenes import change, deflection, elongation_error, energy, square
from program_runs import run_scene
from tables import command_line, write

DOMAINS = "frame = 'updated'  shape_functions = 'cpdi'  scheme = 'usl'  mass = 'consistent'"
LINEAR = "frame = 'updated'  shape_functions = 'linear'  scheme = 'usl'  mass = 'lumped'"
DAMPED = {"end": 24.0, "rise": 6.0, "more": "&damping rate = 0.9 /\n"}


def turns(program, folder):
    """The changes are the largest of ten turns."""
    yield "functions", "scheme", "mass", "turns", "angular momentum", "energy", "audit"
    for functions, scheme, mass, count in (("cpdi", "usl", "consistent", 10), ("cpdi", "usf", "consistent", 10), ("cpdi", "usavg", "consistent", 10),
                                           ("cpdi", "musl", "consistent", 10), ("cpdi", "usl", "weighted", 10), ("cpdi", "usl", "fmpm", 10),
                                           ("cpdi", "usl", "lumped", 10), ("linear", "musl", "lumped", 2), ("linear", "usf", "consistent", 2)):
        try:
            row, _ = run_scene(program, folder, square(count, spin=math.pi, functions=functions, scheme=scheme, mass=mass))
        except RuntimeError:
            yield functions, scheme, mass, count, "stops", "", ""
            continue
        left = energy(row) + row["numerical_loss"] - energy(row)[0]
        yield (functions, scheme, mass, count, f"{change(row['angular_momentum']):.1e}", f"{change(energy(row)):.1e}",
               f"{max(abs(left)) / energy(row)[0]:.1e}")


def cantilever(program, folder):
    """Errors of the deflection."""
    still = [deflection(program, folder, cell, "time = 'static'  load_steps = 10") for cell in (0.25, 0.125, 0.0625)]
    exact = still[2] + (still[2] - still[1]) / 3
    yield "cells along", "functions", "deflection over length", "error"
    for cell in (1.0, 0.5, 0.25):
        for name, method in (("cpdi", DOMAINS), ("linear", LINEAR)):
            try:
                found = deflection(program, folder, cell, method, **DAMPED)
            except RuntimeError as reason:
                yield round(8 / cell), name, "stops", str(reason)[:60]
                continue
            yield round(8 / cell), name, f"{-found / 8:.4f}", f"{found / exact - 1:+.2%}"


def bar(program, folder):
    """Root mean squares over the largest displacement."""
    yield "cells along", "particles at the end", "error", "order"
    last = None
    for cell in (1.0, 0.5, 0.25):
        error, particles = elongation_error(program, folder, cell, 250.0)
        yield round(4 / cell), particles, f"{error:.2e}", "" if last is None else f"{math.log2(last / error):.2f}"
        last = error


def cost(program, folder, turns_of_each=3):
    """Medians of the ratios of runs in turn, without the start: differences of two lengths."""
    yield "scheme", "mass", "CPU a particle and step, ns: linear", "cpdi", "ratio", "ratio of the same motion"
    for scheme, mass in (("musl", "lumped"), ("usf", "lumped"), ("usavg", "lumped"), ("musl", "consistent")):
        found = []
        for _ in range(turns_of_each):
            pair = []
            for functions in ("linear", "cpdi"):
                used, steps = zip(*(spent(program, folder, square(part, functions=functions, scheme=scheme, mass=mass, cell=0.02,
                                                                  cells="120, 120")) for part in (0.004, 0.024)))
                pair.append(((used[1] - used[0]) / (steps[1] - steps[0]) / 10000, used[1] - used[0]))
            found.append((*(1e9 * a for a, _ in pair), pair[1][0] / pair[0][0], pair[1][1] / pair[0][1]))
        yield scheme, mass, *(f"{statistics.median(values):.1f}" for values in zip(*found))


def spent(program, folder, text):
    """Processor time and steps of a run."""
    text = text.replace("&energy_release energy_balance = .true. /\n", "")
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    history, _ = run_scene(program, folder, text, ["output.history_interval=4e-3"])
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime - before.ru_utime, history["step"][-1]


if __name__ == "__main__":
    arguments = command_line(__doc__, ["turns", "cantilever", "bar", "cost"], "results/domains")
    for part in arguments.part:
        with tempfile.TemporaryDirectory() as folder:
            write(list(globals()[part](arguments.program.resolve(), Path(folder))), part, arguments.output)
