"""What a run of a sweep finds of earlier ones."""

from collections import Counter

from collect import begun, count_of
from progress import begin_to_count


def begin(sweep):
    """Begin a run of a sweep: say how cases ended before, and why those that are not done are not run again."""
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
