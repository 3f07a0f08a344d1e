"""The beginning and the end of a run of a sweep: what it finds of earlier ones, and what hampm says of its cases before the first is run."""

from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from .declaration import Declaration
from .needs import refusals
from .progress import begin_to_count
from .table import begun, by_reason, count_of

WORDS = {"refused": "are refused", "failed": "have failed"}


def begin(sweep: Declaration, program: str | Path, strict: bool = False) -> int:
    """Begin a run of a sweep: say how cases ended before, why those that are not done are not run again, and which will be refused;
    how many these are."""
    sweep.adopt()
    rows = [begun(sweep, name) for name in sweep.cases]
    ends = Counter(row["outcome"] for row in rows)
    ended = len(rows) - ends["not finished"]
    begin_to_count(sweep.output, len(rows), ended)
    for outcome in ("refused", "failed"):
        for line in by_reason(f"{outcome} before", {row["case"]: row["message"] for row in rows if row["outcome"] == outcome}):
            print(line)
    if ends["refused"] + ends["failed"]:
        print(f"These are not run again, unless they are forgotten: batch/forget.py {sweep.path}")
    if ended:
        print(f"{len(rows)} cases: {count_of(ends)}".replace("not finished", "to run"), flush=True)
    refused = refusals(sweep, [row["case"] for row in rows if row["outcome"] == "not finished"], program)
    for line in by_reason("will be refused", refused):
        print(line, flush=True)
    if refused:
        print(f"{len(refused)} of {len(rows)} cases will be refused; {'none is run' if strict else 'the others are run'}, and the exit code is 1", flush=True)
    return len(refused) + ends["refused"]


def unsuccessful(sweep: Declaration, outcomes: Sequence[str]) -> str:
    """How many cases have ended in this way: '3 of 7 cases are refused'; '' where none has."""
    ends = Counter(begun(sweep, name)["outcome"] for name in sweep.cases)
    found = " and ".join(f"{ends[outcome]} of {len(sweep.cases)} cases {words}" for outcome, words in WORDS.items()
                         if outcome in outcomes and ends[outcome])
    return f"{found}: mend or remove them" if found else ""
