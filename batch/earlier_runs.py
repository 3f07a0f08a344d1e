"""The beginning and the end of a run of a sweep: what it finds of earlier ones, and what hampm says of its cases before the first is run."""

from collections import Counter

from collect import begun, count_of
from needs import refusals
from progress import begin_to_count


def begin(sweep, program):
    """Begin a run of a sweep: say how cases ended before, why those that are not done are not run again, and which are refused."""
    rows = [begun(sweep, name) for name in sweep.cases]
    ends = Counter(row["outcome"] for row in rows)
    ended = len(rows) - ends["not finished"]
    begin_to_count(sweep.output, len(rows), ended)
    for row in rows:
        if row["outcome"] in ("refused", "failed"):
            print(f"{row['outcome']} before: {row['case']}: {row['message']}")
    if ends["refused"] + ends["failed"]:
        print(f"These are not run again, unless they are forgotten: batch/forget.py {sweep.path}")
    if ended:
        print(f"{len(rows)} cases: {count_of(ends)}".replace("not finished", "to run"), flush=True)
    refused = refusals(sweep, [row["case"] for row in rows if row["outcome"] == "not finished"], program)
    for name, why in refused.items():
        print(f"will be refused: {name}: {why}", flush=True)
    if refused:
        print(f"{len(refused)} of {len(rows)} cases will be refused; the others are run, and the exit code is 1", flush=True)


def refused_cases(sweep):
    """How many cases hampm has refused."""
    return sum(begun(sweep, name)["outcome"] == "refused" for name in sweep.cases)
