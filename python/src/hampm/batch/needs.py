"""What hampm says of a case before it runs: whether it refuses it, and what it needs."""

import json
import os
import re
import subprocess
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from pathlib import Path
from typing import Any

from .case import OUTCOMES, messages
from .declaration import Declaration

MEGABYTES = {"kB": 1e-3, "MB": 1, "GB": 1e3, "TB": 1e6}
LEAST = 100


@cache
def checked(program: str | Path, namelist: Path, settings: tuple[tuple[str, str], ...]) -> tuple[int, dict[str, Any], str]:
    """Exit code, what is told and words of `hampm --check --json --quiet` for a case."""
    words = [word for key, value in settings for word in ("--set", f"{key}={value}")]
    run = subprocess.run([program, "--check", "--json", "--quiet", namelist, *words], capture_output=True, text=True, errors="replace",
                         env=os.environ | dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1"))
    try:
        return run.returncode, json.loads(run.stdout), run.stderr
    except ValueError:
        return run.returncode, {}, run.stderr


def check(sweep: Declaration, name: str, program: str | Path) -> tuple[int, dict[str, Any], str]:
    """`checked` of a case by its name."""
    return checked(program, sweep.namelist, tuple(sweep.cases[name].items()))


def refusals(sweep: Declaration, names: Iterable[str], program: str | Path) -> dict[str, str]:
    """Name -> why, of those of some cases that hampm refuses."""
    names = list(names)
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        found = dict(zip(names, pool.map(lambda name: check(sweep, name, program), names)))
    return {name: messages(said) for name, (code, _, said) in found.items() if OUTCOMES.get(code) == "refused"}


def memory(sweep: Declaration, name: str, program: str | Path) -> int:
    """Memory to ask for [MB]: as declared, or twice the most that `hampm --check` says, and 100; 100 where it refuses the case."""
    if sweep.memory:
        return sweep.memory
    _, told, said = check(sweep, name, program)
    return LEAST + round(2 * (told["most_memory"] / 1e6 if "most_memory" in told else memory_refused(said)))


def memory_refused(said: str) -> float:
    """The memory [MB] that a model needs which is refused because this machine has not as much; 0 where that is not why."""
    found = re.search(r"needs about (\S+) ([kMGT]B) of memory", said)
    return float(found[1]) * MEGABYTES[found[2]] if found else 0.0
