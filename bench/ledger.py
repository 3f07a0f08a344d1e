"""The ledger of whole runs, bench/ledger.csv: what each question of whole_runs.py costs, the error that it then has, and why either has changed.

    .venv/bin/python bench/ledger.py [QUESTION ...]               # hold the release to the ledger
    .venv/bin/python bench/ledger.py [QUESTION ...] --why REASON  # write in the questions that cost more or less now

Instructions are without what is flushed before the end of a run. The error is the estimated error of G over G, means over the rows of the history, of
tips and of fronts. Memory is the most that a run takes. Counts are held to rows of the same compiler only.
"""

import argparse
import csv
import datetime
import re
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import h5py
import numpy as np
from instructions import can_count
from tables import ROOT
from whole_runs import QUESTIONS, arguments, count, history

LEDGER = ROOT / "bench" / "ledger.csv"
MOST, LEAST = 1.01, 0.97  # of the instructions of the ledger: beyond, a change has cost something; below, its gain is to be written in


def rows():
    """The last row of each question, by its name."""
    with open(LEDGER, newline="") as file:
        return {row["question"]: row for row in csv.DictReader(file)}


def error_of(columns):
    """The estimated error of G over G, means over the rows [%]; None where none is known."""
    for name in ("G", "G_mean"):
        if f"{name}_error" in columns and np.any(columns[name] != 0):
            return 100 * np.nanmean(columns[f"{name}_error"]) / np.nanmean(np.abs(columns[name]))
    return None


def run(program, question):
    """Error of a question, memory of its run [MB], and the compiler of the program."""
    with tempfile.TemporaryDirectory() as folder:
        process = subprocess.Popen([str(word) for word in (program, *arguments(question, folder))], stderr=subprocess.DEVNULL)
        most = 0
        while process.poll() is None:  # that of a child begins with what its parent has
            most = max([most, *map(int, re.findall(r"VmHWM:\s+(\d+)", Path(f"/proc/{process.pid}/status").read_text()))])
            time.sleep(0.002)
        if process.returncode:
            raise subprocess.CalledProcessError(process.returncode, process.args)
        with h5py.File(Path(folder) / "run.h5") as file:
            compiler = file["input"].attrs["compiler"]
        return error_of(history(folder)), most / 1024, compiler.decode() if isinstance(compiler, bytes) else compiler


def held(name, instructions, compiler):
    """The instructions of a question over those of the ledger; None where that has none by this compiler."""
    row = rows().get(name)
    return instructions / 1e6 / float(row["instructions [1e6]"]) if row and row["compiler"] == compiler else None


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("question", nargs="*", help=f"parts of {', '.join(QUESTIONS)}; default: all")
    parser.add_argument("--why", metavar="REASON", help="write in what has changed, and why")
    parser.add_argument("--date", default=datetime.date.today().isoformat(), help="of the program, default: today")
    parser.add_argument("--programs", metavar="PROGRAM", type=Path, nargs=2, default=(ROOT / "build/release/hampm", ROOT / "build/release3d/hampm3d"),
                        help="of the plane and of solids; default: those of the release")
    options = parser.parse_args()
    if not can_count():
        sys.exit("valgrind is missing: no instructions are counted")
    names = [name for name in QUESTIONS if not options.question or any(word in name for word in options.question)]
    program = {name: options.programs[QUESTIONS[name].is_solid] for name in names}
    with ThreadPoolExecutor(2) as several:
        counts = dict(zip(names, several.map(lambda name: count(program[name], QUESTIONS[name])[0], names)))
    is_held = True
    for name in names:
        error, memory, compiler = run(program[name], QUESTIONS[name])
        ratio = held(name, counts[name], compiler)
        print(f"{name:28} {counts[name] / 1e6:9.1f}  {ratio or 0:.4f}  error {'' if error is None else f'{error:.3g} %'}", flush=True)
        is_new = ratio is None or not LEAST <= ratio <= MOST
        is_held = is_held and not is_new
        if options.why and is_new:
            with open(LEDGER, "a", newline="") as file:
                csv.writer(file, lineterminator="\n").writerow([name, "" if error is None else f"{error:.3g}", f"{counts[name] / 1e6:.1f}", f"{memory:.0f}", options.date,
                                           compiler, options.why])
    if not (is_held or options.why):
        sys.exit(f"instructions beyond {MOST} or below {LEAST} of the ledger: write them in with --why, beside the error that they buy")


if __name__ == "__main__":
    main()
