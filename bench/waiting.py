"""How threads that wait should wait: wall and processor time of whole runs on two threads, which spin for so many turns before they sleep.

The machine is idle or has neighbours, each a process that keeps one processor busy. Threads that only spin make a neighbour's time
theirs: all wait for the one that has no processor. Threads that sleep at once pay the system for each of some ten meetings a step.
`one thread` is beside them, and `library` is what gfortran has where nothing is said. Ways of waiting take turns; the table has medians, and the ratio to one thread of the same turn.

With --before both programs are run as a user does who says nothing of threads: the table has medians, the range, and the ratios of turns.

Run by `make -C bench waiting`, or `make -C bench waiting before=PROGRAM`.
"""

import os
import resource
import subprocess
import sys
import tempfile
import time
from functools import partial
from pathlib import Path

import numpy as np

from tables import ROOT, command_line, write

INPUT = ROOT / "input"
FINE = ("grid.cell=0.2e-3", "grid.cells=500,52", "energy_release.energy_balance=.false.", "energy_release.estimators=vcct",
        "output.history_interval=1e-3", "output.snapshot_interval=0", "run.end_time=1e-3")
SCENES = {
    "100k, updated": ("dcb.nml", 300, (*FINE, "method.frame=updated")),
    "100k, total": ("dcb.nml", 1000, (*FINE, "method.frame=total", "method.courant=0.5")),
    "dcb": ("dcb.nml", 2000, ()),
    "chen": ("chen.nml", 300, ()),
}
WAYS = {"one thread": None, "sleep": "0", "spin 1000": "1000", "spin 10000": "10000", "spin 100000": "100000", "library": "300000"}
BUSY = "while True: pass"


def run(program, scene, folder, threads=0, spin=None):
    """Wall and processor time of a run [s]."""
    source, steps, settings = SCENES[scene]
    environment = {key: value for key, value in os.environ.items() if key not in ("OMP_WAIT_POLICY", "GOMP_SPINCOUNT", "OMP_NUM_THREADS")}
    if spin:
        environment["GOMP_SPINCOUNT"] = spin
    words = [program, INPUT / source, "--steps", steps, "--quiet", "--force", "--output", folder, *(["--threads", threads] if threads else []),
             *(word for setting in settings for word in ("--set", setting))]
    before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    end = subprocess.run([str(word) for word in words], capture_output=True, text=True, env=environment)
    wall, after = time.perf_counter() - start, resource.getrusage(resource.RUSAGE_CHILDREN)
    if end.returncode not in (0, 5):
        sys.exit(f"{words} has ended with {end.returncode}: {end.stderr}")
    return wall, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def measure(ways, neighbours, turns):
    """Name -> wall and processor times of all turns, shape (turns, 2), of ways to run, which take a folder."""
    busy = [subprocess.Popen([sys.executable, "-c", BUSY]) for _ in range(neighbours)]
    try:
        with tempfile.TemporaryDirectory() as folder:
            times = [{name: way(Path(folder)) for name, way in ways.items()} for _ in range(turns)]
    finally:
        for process in busy:
            process.kill()
            process.wait()
    return {name: np.array([turn[name] for turn in times]) for name in ways}


def of_waiting(program, scene, neighbours, turns):
    """A row for each way of waiting."""
    times = measure({way: partial(run, program, scene, threads=1 if spin is None else 2, spin=spin) for way, spin in WAYS.items()}, neighbours, turns)
    for way, found in times.items():
        wall, cpu = np.median(found, axis=0)
        yield [scene, neighbours, way, f"{wall:.2f}", f"{cpu:.2f}", f"{np.median(found[:, 0] / times['one thread'][:, 0]):.2f}"]


def of_programs(programs, scene, neighbours, turns):
    """A row for each program."""
    times = measure({name: partial(run, program, scene) for name, program in programs.items()}, neighbours, turns)
    for name, found in times.items():
        ratios = np.median(found / times["before"], axis=0)
        (wall, cpu), low, high = np.median(found, axis=0), found.min(axis=0), found.max(axis=0)
        yield [scene, neighbours, name, f"{wall:.2f}", f"{low[0]:.2f} to {high[0]:.2f}", f"{cpu:.2f}", f"{low[1]:.2f} to {high[1]:.2f}", *(f"{ratio:.2f}" for ratio in ratios)]


def main():
    arguments = command_line(__doc__, list(SCENES), "results/waiting", turns=(5, "runs of each way"), neighbours=(2, "on the busy machine"),
                             before=(Path(), "an earlier program, to be held to"))
    program, before = arguments.program.resolve(), arguments.before.resolve()
    table = [["scene", "neighbours", "threads wait", "wall [s]", "processors [s]", "wall over one thread"]]
    rows = partial(of_waiting, program)
    if arguments.before.is_file():
        table = [["scene", "neighbours", "program", "wall [s]", "from to", "processors [s]", "from to", "wall over before", "processors over before"]]
        rows = partial(of_programs, {"before": before, "after": program})
    for scene in arguments.part:
        for neighbours in (0, arguments.neighbours):
            table += rows(scene, neighbours, arguments.turns)
    write(table, "waiting", arguments.output)


if __name__ == "__main__":
    main()
