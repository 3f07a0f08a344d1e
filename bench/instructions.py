"""Counts of instructions by valgrind's callgrind, which do not depend on how busy the machine is.

They are of the release: valgrind knows the instructions of AVX2, and that OpenBLAS asks which there are.
"""

import os
import re
import shutil
import subprocess
from collections import Counter


def can_count():
    """Whether valgrind is installed."""
    return shutil.which("valgrind") is not None


def run_counted(program, *arguments, profile=os.devnull, codes=(0,)):
    """Run a program, which may end with one of some exit codes; return what it prints and the instructions that it takes."""
    command = ["valgrind", "--tool=callgrind", f"--callgrind-out-file={profile}", program, *arguments]
    result = subprocess.run([str(word) for word in command], capture_output=True, text=True,
                            env={**os.environ, "OMP_NUM_THREADS": "1"})
    if result.returncode not in codes:
        raise subprocess.CalledProcessError(result.returncode, command, result.stdout, result.stderr)
    return result.stdout, int(re.search(r"Collected : (\d+)", result.stderr)[1])


def instructions(program, case, few=5, many=15):
    """Instructions per particle and step of a case of bench_step, as the difference of two numbers of steps: without the start."""
    counts = [run_counted(program, "steps", steps, case) for steps in (few, many)]
    particles = int(counts[0][0].split()[0])
    return (counts[1][1] - counts[0][1]) / (many - few) / particles


def costs_of_calls(profile):
    """Instructions of all calls of each procedure, with what it calls, by the name that the compiler gives it; and of those from another one, by both names."""
    names, costs, caller, callee, is_call = {}, Counter(), None, None, False
    with open(profile) as file:
        for line in file:
            if is_call:
                costs[callee] += int(line.split()[1])
                costs[caller, callee] += int(line.split()[1])
            is_call = line.startswith("calls=")
            found = re.match(r"(c?)fn=\((\d+)\)(?: (.*))?", line)
            if found:
                name = names.setdefault(found[2], found[3])
                caller, callee = (caller, name) if found[1] else (name, callee)
    return costs
