"""The step of the program beside what others write: 60 lines of Python with numba, 150 of C each (bench/peers/), on one thread.

All compute the same motion by the same scheme (usf) of the same particles, which tests/program/test_peers.py checks. In the total frame the
other is a matrix-free step of finite elements (bench/peers/element_step.c), and the least that such a step is: central differences, which know no particles. They take turns
in one run, so that a change of the machine's speed meets all of them, and the median of the ratios of turns that follow each other
counts. numba is not among the packages that hampm needs: `make -C bench peers` installs it.
"""

import subprocess
import sys
import time
from statistics import median

from tables import ROOT, command_line, write

sys.path.insert(0, str(ROOT / "bench" / "peers"))

from scenes import Body, ByElements, InC, InNumba, library_in_c  # noqa: E402

UPDATES = 5_000_000   # of particles in a turn, at least
LEAST_STEPS = 50      # in a turn, as in bench_step
SIZES = {"10k": 50, "100k": 158, "1M": 500}


class Program:
    """bench_step, which measures a case when it is asked."""

    def __init__(self, program, cases):
        self.process = subprocess.Popen([program, "turns", *cases], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def turn(self, k):
        """Processor time (wall time with several threads) and that of a copy of the same bytes [ns a particle and step]."""
        print(k + 1, file=self.process.stdin, flush=True)
        fields = self.process.stdout.readline().split()
        return float(fields[3 if fields[0].split(":")[4] == "1" else 4]), float(fields[5])

    def close(self):
        self.process.stdin.close()
        self.process.wait()


def time_of(peer):
    """Processor time of a turn of somebody else [ns a particle and step]."""
    count = max(UPDATES // peer.body.n + 1, LEAST_STEPS)
    start = time.process_time()
    peer.steps(count)
    return (time.process_time() - start) * 1e9 / count / peer.body.n


def beside_others(program, turns, folder):
    """Updated frame, usf: the program, numba and C."""
    library = library_in_c(folder)
    rows = [["particles", "program [ns]", "numba [ns]", "C [ns]", "copy [ns]", "over numba", "target", "over C", "target"]]
    for size, cells in SIZES.items():
        own = Program(program, [f"program:updated:usf:{cells}:1"])
        body = Body(cells, "smooth")
        others = [InNumba(body), InC(body, library)]
        for other in others:
            other.steps(1)
        times = [(*own.turn(0), *map(time_of, others)) for _ in range(turns)]
        own.close()
        ours, copy, numba, c = (median(column) for column in zip(*times))
        rows.append([size, f"{ours:.1f}", f"{numba:.1f}", f"{c:.1f}", f"{copy:.1f}",
                     f"{median(t[0] / t[2] for t in times):.2f}", "0.65" if size != "10k" else "",
                     f"{median(t[0] / t[3] for t in times):.2f}", "1.10" if size != "10k" else ""])
    write(rows, "peers", folder)


def beside_elements(program, turns, folder):
    """Total frame, usf: the program, the same by finite elements in C, and central differences by these."""
    library = library_in_c(folder, "element_step")
    rows = [["particles", "program [ns]", "elements in C [ns]", "central differences [ns]", "over elements", "over central differences",
             "target"]]
    for (size, cells), target in zip(SIZES.items(), ["1.5", "1.7", "2.5"]):
        own = Program(program, [f"program:total:usf:{cells}:1"])
        body = Body(cells, "smooth")
        others = [InC(body, library), ByElements(body, library)]
        for other in others:
            other.steps(1)
        times = [(own.turn(0)[0], *map(time_of, others)) for _ in range(turns)]
        own.close()
        ours, elements, differences = (median(column) for column in zip(*times))
        rows.append([size, f"{ours:.1f}", f"{elements:.1f}", f"{differences:.1f}", f"{median(t[0] / t[1] for t in times):.2f}",
                     f"{median(t[0] / t[2] for t in times):.2f}", target])
    write(rows, "peers_total", folder)


def among_themselves(program, turns, folder):
    """The total frame over a copy of its bytes, two threads over one, and a turning body over one that rests."""
    pairs = [("total frame over the copy, 1M", "program:total:usf:500:1", None, "at most 1.3"),
             ("total over updated frame, 10k", "program:total:usf:50:1", "program:updated:usf:50:1", ""),
             ("total over updated frame, 1M", "program:total:usf:500:1", "program:updated:usf:500:1", ""),
             ("one thread over two, 100k", "program:updated:usf:158:1", "program:updated:usf:158:2", "at least 1.8"),
             ("one thread over two, 1M", "program:updated:usf:500:1", "program:updated:usf:500:2", "at least 1.8"),
             ("turning over resting, 103k, usf", "program:updated:usf:256:1:turning", "program:updated:usf:256:1:resting", "at most 2.5"),
             ("turning over resting, 103k, musl", "program:updated:musl:256:1:turning", "program:updated:musl:256:1:resting", "at most 2.5")]
    rows = [["what", "first [ns]", "second [ns]", "ratio", "target"]]
    for what, first, second, target in pairs:
        own = Program(program, [first] + [second] * bool(second))
        times = []
        for _ in range(turns):
            a, copy = own.turn(0)
            times.append((a, own.turn(1)[0] if second else copy))
        own.close()
        rows.append([what, *(f"{median(column):.1f}" for column in zip(*times)), f"{median(a / b for a, b in times):.2f}", target])
    write(rows, "peers_own", folder)


def main():
    arguments = command_line(__doc__, ["others", "elements", "own"], "results/peers", ROOT / "build/release/bench_step",
                             turns=(5, "turns of each"))
    if "others" in arguments.part:
        beside_others(arguments.program, arguments.turns, arguments.output)
    if "elements" in arguments.part:
        beside_elements(arguments.program, arguments.turns, arguments.output)
    if "own" in arguments.part:
        among_themselves(arguments.program, arguments.turns, arguments.output)


if __name__ == "__main__":
    main()
