"""What hampm says of a case before it runs: whether it refuses it, and what it needs."""

import os
import re
import subprocess
from concurrent.futures import ThreadPoolExecutor
from functools import cache

from run_case import OUTCOMES, messages

MEGABYTES = {"kB": 1e-3, "MB": 1, "GB": 1e3, "TB": 1e6}
LEAST = 100


@cache
def checked(program, namelist, settings):
    """Exit code and words of `hampm --check` for a case."""
    words = [word for key, value in settings for word in ("--set", f"{key}={value}")]
    run = subprocess.run([program, "--check", namelist, *words], capture_output=True, text=True, errors="replace",
                         env=os.environ | dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1"))
    return run.returncode, run.stdout, run.stderr


def check(sweep, name, program):
    return checked(program, sweep.namelist, tuple(sweep.cases[name].items()))


def refusals(sweep, names, program):
    """Name -> why, of those of some cases that hampm refuses."""
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        found = dict(zip(names, pool.map(lambda name: check(sweep, name, program), names)))
    return {name: messages(said) for name, (code, _, said) in found.items() if OUTCOMES.get(code) == "refused"}


def memory(sweep, name, program):
    """Memory to ask for [MB]: as declared, or twice the most that `hampm --check` says, and 100; 100 where it refuses the case."""
    if sweep.memory:
        return sweep.memory
    _, out, said = check(sweep, name, program)
    return LEAST + round(2 * most_memory(out + said))


def most_memory(text):
    """The greatest memory [MB] that a scene is said to need, also where it is refused because this machine has not as much."""
    said = re.search(r"^! memory .*|needs about \S+ \w+ of memory", text, re.MULTILINE)
    amounts = re.findall(r"(\S+) ([kMGT]B)\b", said[0]) if said else []
    return max((float(number) * MEGABYTES[unit] for number, unit in amounts), default=0)
