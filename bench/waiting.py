"""How threads that wait should wait: wall and processor time of whole runs on two threads, which spin for so many turns before they sleep.

The machine is idle or has neighbours, each a process that keeps one processor busy. Threads that only spin make a neighbour's time
theirs: all wait for the one that has no processor. Threads that sleep at once pay the system for each of some ten meetings a step.
`one thread` is beside them, and `library` is what gfortran has where nothing is said. Ways of waiting take turns; the table has medians, and the ratio to one thread of the same turn.

Run by `make -C bench waiting`.
"""

import os
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

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


def run(program, scene, spin, folder):
    """Wall and processor time of a run [s]."""
    source, steps, settings = SCENES[scene]
    environment = {key: value for key, value in os.environ.items() if key not in ("OMP_WAIT_POLICY", "GOMP_SPINCOUNT", "OMP_NUM_THREADS")}
    if spin:
        environment["GOMP_SPINCOUNT"] = spin
    words = [program, INPUT / source, "--steps", steps, "--threads", 1 if spin is None else 2, "--quiet", "--force", "--output", folder,
             *(word for setting in settings for word in ("--set", setting))]
    before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    end = subprocess.run([str(word) for word in words], capture_output=True, text=True, env=environment)
    wall, after = time.perf_counter() - start, resource.getrusage(resource.RUSAGE_CHILDREN)
    if end.returncode not in (0, 5):
        sys.exit(f"{words} has ended with {end.returncode}: {end.stderr}")
    return wall, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def measure(program, scene, neighbours, turns):
    """A row for each way of waiting."""
    busy = [subprocess.Popen([sys.executable, "-c", BUSY]) for _ in range(neighbours)]
    try:
        with tempfile.TemporaryDirectory() as folder:
            times = [{way: run(program, scene, spin, Path(folder)) for way, spin in WAYS.items()} for _ in range(turns)]
    finally:
        for process in busy:
            process.kill()
            process.wait()
    rows = []
    for way in WAYS:
        wall, cpu = (statistics.median(turn[way][k] for turn in times) for k in (0, 1))
        ratio = statistics.median(turn[way][0] / turn["one thread"][0] for turn in times)
        rows.append([scene, neighbours, way, f"{wall:.2f}", f"{cpu:.2f}", f"{ratio:.2f}"])
    return rows


def main():
    arguments = command_line(__doc__, list(SCENES), "results/waiting", turns=(5, "runs of each way"), neighbours=(2, "on the busy machine"))
    table = [["scene", "neighbours", "threads wait", "wall [s]", "processors [s]", "wall over one thread"]]
    for scene in arguments.part:
        for neighbours in (0, arguments.neighbours):
            table += measure(arguments.program.resolve(), scene, neighbours, arguments.turns)
    write(table, "waiting", arguments.output)


if __name__ == "__main__":
    main()
