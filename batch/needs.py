"""What a case needs, as hampm says before it runs."""

import re
import subprocess

MEGABYTES = {"kB": 1e-3, "MB": 1, "GB": 1e3, "TB": 1e6}
LEAST = 100


def memory(sweep, name, program):
    """Memory to ask for [MB]: as declared, or twice the most that `hampm --check` says, and 100; 100 where it refuses the case."""
    if sweep.memory:
        return sweep.memory
    words = [word for key, value in sweep.cases[name].items() for word in ("--set", f"{key}={value}")]
    check = subprocess.run([program, "--check", sweep.namelist, *words], capture_output=True, text=True)
    return LEAST + round(2 * most_memory(check.stdout + check.stderr))


def most_memory(text):
    """The greatest memory [MB] that a scene is said to need, also where it is refused because this machine has not as much."""
    said = re.search(r"^! memory .*|needs about \S+ \w+ of memory", text, re.MULTILINE)
    amounts = re.findall(r"(\S+) ([kMGT]B)\b", said[0]) if said else []
    return max((float(number) * MEGABYTES[unit] for number, unit in amounts), default=0)
