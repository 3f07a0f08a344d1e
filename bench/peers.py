"""The step of the program in the total frame beside a matrix-free step of finite elements in C (bench/peers/element_step.c), on one thread.

Both compute the same motion by the same scheme (usf) of the same particles, which tests/program/test_peers.py checks. The least of such a step
are central differences by the same loops, which know no particles. They take turns in one run, so that a change of the machine's speed meets
all of them, and the median of the ratios of turns that follow each other counts.
"""

import subprocess
import sys
import time
from statistics import median

from tables import ROOT, command_line, write

sys.path.insert(0, str(ROOT / "bench" / "peers"))

from scenes import Body, ByElements, InC, library_in_c  # noqa: E402

UPDATES = 5_000_000   # of particles in a turn, at least
LEAST_STEPS = 50      # in a turn, as in bench_step
SIZES = {"10k": 50, "100k": 158, "1M": 500}


class Program:
    """bench_step, which measures a case when it is asked."""

    def __init__(self, program, cases):
        self.process = subprocess.Popen([program, "turns", *cases], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def turn(self, k):
        """Processor time [ns a particle and step]."""
        print(k + 1, file=self.process.stdin, flush=True)
        fields = self.process.stdout.readline().split()
        return float(fields[3])

    def close(self):
        self.process.stdin.close()
        self.process.wait()


def time_of(peer):
    """Processor time of a turn of somebody else [ns a particle and step]."""
    count = max(UPDATES // peer.body.n + 1, LEAST_STEPS)
    start = time.process_time()
    peer.steps(count)
    return (time.process_time() - start) * 1e9 / count / peer.body.n


def beside_elements(program, turns, folder):
    """Total frame, usf: the program, the same by finite elements in C, and central differences by these."""
    library = library_in_c(folder)
    rows = [["particles", "program [ns]", "elements in C [ns]", "central differences [ns]", "over elements", "over central differences",
             "target"]]
    for (size, cells), target in zip(SIZES.items(), ["1.5", "1.7", "2.5"]):
        own = Program(program, [f"program:total:usf:{cells}:1"])
        body = Body(cells)
        others = [InC(body, library), ByElements(body, library)]
        for other in others:
            other.steps(1)
        times = [(own.turn(0), *map(time_of, others)) for _ in range(turns)]
        own.close()
        ours, elements, differences = (median(column) for column in zip(*times))
        rows.append([size, f"{ours:.1f}", f"{elements:.1f}", f"{differences:.1f}", f"{median(t[0] / t[1] for t in times):.2f}",
                     f"{median(t[0] / t[2] for t in times):.2f}", target])
    write(rows, "peers_total", folder)


def main():
    arguments = command_line(__doc__, ["elements"], "results/peers", ROOT / "build/release/bench_step", turns=(5, "turns of each"))
    beside_elements(arguments.program, arguments.turns, arguments.output)


if __name__ == "__main__":
    main()
