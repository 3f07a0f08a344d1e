"""Two threads beside one: wall and processor time of whole runs, in turns, and how threads that wait should do so.

    scenes   runs of many kinds on one and on two threads: the ratio of wall times tells where two help, that of processor times what they cost.
             `pays` is where both are worth it: a shorter wall time by a tenth at least, for at most 3 % more processor time. Where other
             processes run, `processors` (processor over wall time of two threads) is below 2, and only the processor times count: with
             GOMP_SPINCOUNT=0 in the environment, which leaves out the time of threads that wait for one without a processor
    waiting  threads that spin for so many turns before they sleep, on an idle machine and beside neighbours, each a process that keeps one
             processor busy. Threads that only spin make a neighbour's time theirs: all wait for the one that has no processor. Threads that sleep at
             once pay the system for each of some ten meetings a step. `library` is what gfortran has where nothing is said

Medians of turns. Run by `make -C bench threads`, or for one part: .venv/bin/python bench/threads.py scenes
"""

import os
import resource
import statistics
import subprocess
import sys
import tempfile
import time

from tables import ROOT, command_line, write

MOST = 1.03   # processor time of two threads over that of one
INPUT = ROOT / "input"
QUIET = ("energy_release.energy_balance=.false.", "output.snapshot_interval=0")


def beam(n, *settings):
    """The beam of the paper, so many cells an arm: 40 n**2 particles."""
    return "dcb.nml", (f"grid.cell={0.01 / n!r}", f"grid.cells={10 * n},{n + 1}", "energy_release.estimators=vcct", "output.history_interval=1e-3",
                       "run.end_time=1e-3", *QUIET, *settings)


TOTAL, UPDATED = "method.frame=total", "method.frame=updated"
SCENES = {  # model and settings, steps (0: all)
    "10k, total": (*beam(16, TOTAL), 4000), "50k, total": (*beam(36, TOTAL), 1500), "100k, total": (*beam(50, TOTAL), 1000), "400k, total": (*beam(100, TOTAL), 300),
    "10k, updated": (*beam(16, UPDATED), 1000), "50k, updated": (*beam(36, UPDATED), 400), "100k, updated": (*beam(50, UPDATED), 300),
    "400k, updated": (*beam(100, UPDATED), 80),
    "100k, consistent mass": (*beam(50, TOTAL, "method.mass=consistent"), 60), "100k, weighted mass": (*beam(50, TOTAL, "method.mass=weighted"), 60),
    "100k, refined": (*beam(44, TOTAL, "refine.indicator=tip", "refine.max_level=2", "refine.rings=40"), 400),
    "100k, implicit": (*beam(50, TOTAL, "method.time=implicit", "method.time_step=2e-6", "method.courant=0"), 30),
    "100k, at rest": (*beam(50, TOTAL, "method.time=static"), 0), "100k, modes": (*beam(50, TOTAL, "method.time=modal", "damping.rate=0"), 0),
    "chen, a row each 20 ns": ("chen.nml", ("grid.cell=0.1e-3", "grid.cells=101,201", *QUIET), 200),
    "160k, a solid in motion": ("solid/beam.nml", ("grid.cell=2.5e-3", "grid.cells=81,17,17", *QUIET), 40),
    "solid at rest": ("solid/dcb.nml", ("grid.cell=1.25e-3", "grid.cells=80,9,4", *QUIET), 0),
}
WAYS = {"one thread": None, "sleep": "0", "spin 1000": "1000", "spin 10000": "10000", "spin 100000": "100000", "library": "300000"}


def run(programs, scene, threads, spin=None):
    """Wall and processor time of a run [s]."""
    source, settings, steps = SCENES[scene]
    environment = {key: value for key, value in os.environ.items() if key not in ("OMP_WAIT_POLICY", "OMP_NUM_THREADS")}
    with tempfile.TemporaryDirectory() as folder:
        words = [programs[source.startswith("solid/")], INPUT / source, "--quiet", "--force", "--output", folder, "--threads", threads,
                 *(("--steps", steps) if steps else ()), *(word for setting in settings for word in ("--set", setting))]
        before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
        end = subprocess.run([str(word) for word in words], capture_output=True, text=True, env=environment | ({"GOMP_SPINCOUNT": spin} if spin else {}))
        wall, after = time.perf_counter() - start, resource.getrusage(resource.RUSAGE_CHILDREN)
    if end.returncode not in (0, 5):
        sys.exit(f"{words} has ended with {end.returncode}: {end.stderr}")
    return wall, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def median(turns, side, clock):
    return statistics.median(turn[side][clock] for turn in turns)


def scenes(programs, arguments):
    yield "scene", "one thread: wall [s]", "processors [s]", "two: wall [s]", "processors [s]", "wall, two over one", "processors, two over one", "processors", "pays"
    for scene in SCENES:
        turns = [(run(programs, scene, 1), run(programs, scene, 2)) for _ in range(arguments.turns)]
        wall, cpu = (statistics.median(two[clock] / one[clock] for one, two in turns) for clock in (0, 1))
        yield (scene, *(f"{median(turns, side, clock):.2f}" for side in (0, 1) for clock in (0, 1)), f"{wall:.2f}", f"{cpu:.2f}",
               f"{median(turns, 1, 1) / median(turns, 1, 0):.2f}", "yes" if wall <= 0.9 and cpu <= MOST else "no")


def waiting(programs, arguments):
    yield "scene", "neighbours", "threads wait", "wall [s]", "processors [s]", "wall over one thread"
    for scene in ("100k, total", "100k, updated"):
        for neighbours in (0, arguments.neighbours):
            busy = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(neighbours)]
            try:
                turns = [{way: run(programs, scene, 2 if spin else 1, spin) for way, spin in WAYS.items()} for _ in range(arguments.turns)]
            finally:
                for process in busy:
                    process.kill()
                    process.wait()
            for way in WAYS:
                yield (scene, neighbours, way, *(f"{median(turns, way, clock):.2f}" for clock in (0, 1)),
                       f"{statistics.median(turn[way][0] / turn['one thread'][0] for turn in turns):.2f}")


PARTS = {"scenes": scenes, "waiting": waiting}


def main():
    arguments = command_line(__doc__, list(PARTS), "results/threads", turns=(5, "runs of each"), neighbours=(2, "busy processes beside `waiting`"),
                             solids=(ROOT / "build/release3d/hampm3d", "the program for solids"))
    programs = arguments.program.resolve(), arguments.solids.resolve()
    for part in arguments.part:
        rows = []
        for row in PARTS[part](programs, arguments):
            rows.append(row)
            print(*row, sep="  ", flush=True)
        write(rows, part, arguments.output)


if __name__ == "__main__":
    main()
