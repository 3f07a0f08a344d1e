"""The speed of the program, as one table.

    time          the plain scene of 10k, 100k and 1M particles: schemes, both frames and two threads, beside a copy of the same
                  bytes and the least that a step needs (minimal_kernel.f90)
    size          cost per particle and step from 1k to 4M particles
    memory        growth of the peak resident size between two numbers of particles
    instructions  of a step, over those of the least
    shares        of measuring, of checks, of writing, of adapting the mesh and of the errors to expect, in the instructions of each example of input/

The cases of a comparison take turns within one run; a ratio is the median over these turns. Run by `make -C bench speed`, or for some parts:
.venv/bin/python bench/speed.py time --output DIR. The last two need valgrind and `make program
build/release/bench_step`.
"""

import os
import re
import statistics
import subprocess
import sys
import tempfile
from collections import defaultdict
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import NamedTuple

from instructions import can_count, costs_of_calls, instructions, run_counted
from tables import ROOT, command_line, write

RELEASE = ROOT / "build/release"
COLUMNS = ["part", "scene", "frame", "scheme", "particles", "threads", "processors", "quantity", "value", "bytes", "copy",
           "over copy", "minimal", "over minimal", "compared with", "over that", "target", "met"]
CELLS = (50, 158, 500)  # along an edge: 10k, 100k, 1M particles
SIZES = (16, 32, 50, 100, 158, 316, 500, 1000)
SECONDS = 0.3  # of processor time that a run takes whose instructions are counted, about


class Case(NamedTuple):
    """A case of bench_step."""

    cells: int
    frame: str = "updated"
    scheme: str = "musl"
    threads: int = 1
    code: str = "program"

    def __str__(self):
        return f"{self.code}:{self.frame}:{self.scheme}:{self.cells}:{self.threads}"

    def least(self):
        """The same by the minimal kernel."""
        return self._replace(code="minimal")


class Turn(NamedTuple):
    """What bench_step prints of a case in one turn; times per particle and step [ns]."""

    particles: int
    bytes: int
    processor: float
    wall: float
    copy: float


def row(part, scene, quantity, value, **more):
    """A row of the table; `more`: other columns, with _ for a blank."""
    given = {"part": part, "scene": scene, "quantity": quantity, "value": value} | {
        name.replace("_", " "): item for name, item in more.items()}
    assert not set(given) - set(COLUMNS)
    return [given.get(name, "") for name in COLUMNS]


def about(case, particles):
    """Columns that tell which case it is."""
    return {"frame": case.frame, "scheme": case.scheme, "particles": particles, "threads": case.threads}


def processors():
    """Number of processors that may be used."""
    return len(os.sched_getaffinity(0))


def judged(value, target):
    """Columns of a target that a value must not exceed."""
    return {"target": target, "met": "yes" if value <= target else "NO"}


# --- time and size --------------------------------------------------------------------------------------------------

def take_turns(program, repeats, cases):
    """Measure cases in turn within one run; a list of turns for each."""
    result = subprocess.run([str(program), "time", str(repeats), *map(str, cases)], capture_output=True, text=True, check=True)
    by_name = defaultdict(list)
    for line in result.stdout.splitlines():
        name, particles, moved, *times = line.split()
        by_name[name].append(Turn(int(particles), int(moved), *map(float, times)))
    return {case: by_name[str(case)] for case in cases}


def ratio(turns, others, clock):
    """Median of the ratios of turns that followed each other."""
    return statistics.median(getattr(a, clock) / getattr(b, clock) for a, b in zip(turns, others))


def time_row(part, found, case, reference=None):
    """A row about the time of a case, with its ratios to a copy, to the minimal kernel and to another case where there are such."""
    turns = found[case]
    clock = "processor" if case.threads == 1 else "wall"
    values = [getattr(turn, clock) for turn in turns]
    more = {"processors": f"{statistics.median(turn.processor / turn.wall for turn in turns):.2f}", "bytes": turns[0].bytes,
            "copy": f"{statistics.median(turn.copy for turn in turns):.1f}",
            "over_copy": f"{statistics.median(a / turn.copy for a, turn in zip(values, turns)):.1f}"}
    least = case.least()
    if least in found:
        more |= {"minimal": f"{statistics.median(turn.processor for turn in found[least]):.1f}",
                 "over_minimal": f"{ratio(turns, found[least], 'processor'):.2f}"}
    if reference:
        other, text = reference
        more |= {"compared_with": text, "over_that": f"{ratio(turns, found[other], clock):.2f}"}
    return row(part, "plain", f"ns, {clock}", f"{statistics.median(values):.1f}", **about(case, turns[0].particles), **more)


def time(program, repeats):
    """Schemes, frames and threads."""
    rows = []
    for cells in CELLS:
        plain = Case(cells)
        cases = {plain: None, Case(cells, frame="total"): (plain, "updated")}
        if cells == CELLS[0]:
            cases |= {Case(cells, scheme=scheme): (plain, "musl") for scheme in ("usl", "usf", "usavg")}
        elif processors() > 1:
            cases[Case(cells, threads=2)] = plain, "1 thread"
        found = take_turns(program, repeats, [plain, plain.least(), *list(cases)[1:]])
        rows += [time_row("time", found, case, reference) for case, reference in cases.items()]
    return rows


def size(program, repeats):
    """Numbers of particles, each beside 10k."""
    cases = [Case(cells) for cells in SIZES]
    found = take_turns(program, repeats, cases)
    return [time_row("size", found, case, (Case(CELLS[0]), "10k particles")) for case in cases]


# --- memory ---------------------------------------------------------------------------------------------------------

def memory(program, _):
    """Growth of the peak resident size over the growth of the number of particles."""
    rows = []
    for frame, small, large in (("updated", 158, 500), ("updated", 500, 1000), ("total", 158, 500)):
        (few, least), (many, most) = (peak(program, Case(cells, frame=frame)) for cells in (small, large))
        if least == 0:
            print("memory: left out, as this system does not tell the peak resident size", file=sys.stderr)
            return []
        rows.append(row("memory", "plain", "bytes held a particle", f"{(most - least) / (many - few):.0f}",
                        **about(Case(large, frame=frame), many), compared_with=f"{few} particles"))
    return rows


def peak(program, case):
    """Number of particles of a case and the most memory that a run of it holds [bytes]."""
    result = subprocess.run([str(program), "steps", "2", str(case)], capture_output=True, text=True, check=True)
    return map(int, result.stdout.split())


# --- instructions ---------------------------------------------------------------------------------------------------

def count(_, __):
    """Instructions of a step beside those of the least."""
    program, case = RELEASE / "bench_step", Case(CELLS[0])
    least = instructions(program, case.least())
    rows = []
    for each in (case, *(Case(CELLS[0], scheme=scheme) for scheme in ("usl", "usf", "usavg")), Case(CELLS[0], frame="total")):
        value = instructions(program, each)
        over = {"over_minimal": f"{value / least:.2f}", **judged(value / least, 1.25)} if each == case else {}
        rows.append(row("instructions", "plain", "instructions", f"{value:.1f}", **about(each, 4 * CELLS[0]**2),
                        minimal=f"{least:.1f}" if over else "", **over))
    return rows


def shares(_, __):
    """Which parts of a run's instructions, from reading the model on, measuring, checking, writing, adapting and expected errors take, of each example."""
    with ThreadPoolExecutor(processors()) as several:
        return [line for rows in several.map(shares_of, sorted((ROOT / "input").glob("*.nml"))) for line in rows]


def shares_of(example):
    """The same of the first steps of one of them, or of all where these are few."""
    with tempfile.TemporaryDirectory() as folder:
        words = [example, "--quiet", "--threads", 1, "--force", "--output", folder, "--steps"]
        steps, spent, end = 1, 0.0, 5
        while end == 5 and spent < SECONDS:
            steps = 2 * steps
            process = subprocess.Popen([str(word) for word in (RELEASE / "hampm", *words, steps)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            _, status, usage = os.wait4(process.pid, 0)
            end, spent = os.waitstatus_to_exitcode(status), usage.ru_utime
        profile = Path(folder) / "profile"
        run_counted(RELEASE / "hampm", *words, steps, profile=profile, codes=(0, 5))
        costs = costs_of_calls(profile)
    rows, tips = "__hampm_measurements_MOD_measure", "__hampm_measurements_MOD_measure_tips"
    whole, adapting, recording, expecting = (costs[f"__hampm_{procedure}"] for procedure in (
        "program_MOD_simulate", "mesh_changes_MOD_adapt", "recording_MOD_record", "crack_errors_MOD_estimate_errors"))
    measuring = costs[rows] + costs[tips] - costs[rows, tips] - costs["__hampm_nodal_state_MOD_solve_for_step"]  # that the next step leaves out
    if re.search(r"^\s*time\s*=\s*'static'", example.read_text(), re.MULTILINE):  # a run at rest goes on with this factorisation
        expecting -= costs["__hampm_expected_error_MOD_find_equilibrium", "__hampm_stiffness_MOD_factorise_stiffness"]
    checking = sum(costs[f"__hampm_run_time_checks_MOD_check_{what}"] for what in ("state", "step", "tip"))
    parts = {"measuring": measuring, "checking": checking, "writing": recording - costs[rows] - checking, "adapting": adapting,
             "expecting": expecting}
    limits = {"measuring": 0.15, "checking": 0.01, "adapting": 0.05}
    return [row("shares", example.stem, f"share of {part}", f"{cost / whole:.4f}", threads=1,
                **(judged(cost / whole, limits[part]) if part in limits else {}))
            for part, cost in parts.items() if cost or part not in ("adapting", "expecting")]


PARTS = {"time": time, "size": size, "memory": memory, "instructions": count, "shares": shares}


def main():
    arguments = command_line(__doc__, list(PARTS), "results", program=ROOT / "build/release/bench_step",
                             repeats=(9, "turns of which the median is taken"))
    rows = [COLUMNS]
    for part in arguments.part:
        if part in ("instructions", "shares") and not (can_count() and (RELEASE / "bench_step").exists()):
            print(f"{part}: left out, as valgrind or build/release/bench_step is missing", file=sys.stderr)
            continue
        rows += PARTS[part](arguments.program, arguments.repeats)
    write(rows, "bench", arguments.output)


if __name__ == "__main__":
    main()
