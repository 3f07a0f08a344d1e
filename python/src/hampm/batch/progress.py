"""How far a run of a sweep has come, counted in the file `progress` of its folder: a line of JSON, written when the run begins, and
below it a line for each case that has ended since. Cases end on any node of a cluster; each adds its line by itself."""

import json
import time
from pathlib import Path

FILE = "progress"


def begin_to_count(output: Path, cases: int, ended: int) -> None:
    """Begin a run of a sweep of so many cases, of which some have ended before."""
    output.mkdir(parents=True, exist_ok=True)
    (output / FILE).write_text(json.dumps({"cases": cases, "ended": ended, "begun": time.time()}) + "\n")


def count_end(folder: Path) -> str:
    """Count a case that has ended, by its folder: '[3/7, 12 s left] ', or '' where no run of a sweep counts."""
    path = folder.resolve().parent.parent / FILE
    try:
        if not path.exists():
            return ""
        with open(path, "a") as file:
            file.write("ended\n")
        first, *others = path.read_text().splitlines()
        sweep = json.loads(first)
        done, cases = sweep["ended"] + len(others), sweep["cases"]
        left = (time.time() - sweep["begun"]) / len(others) * (cases - done)
    except (OSError, ValueError, KeyError, TypeError):
        return ""
    return f"[{done}/{cases}{f', {duration(left)} left' if done < cases else ''}] "


def duration(seconds: float) -> str:
    """A time [s] as people say it."""
    for unit, length in (("d", 86400), ("h", 3600), ("min", 60)):
        if seconds >= 1.5 * length:
            return f"{seconds / length:.{1 if seconds < 10 * length else 0}f} {unit}"
    return f"{seconds:.0f} s"
