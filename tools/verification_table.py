#!/usr/bin/env python3
"""Write what `make verify` has measured into a page: verification_table.py RESULTS.xml PAGE.md

RESULTS.xml is pytest's JUnit file. A test that records `run`, `what`, `asked`, `tolerance` and `measured` becomes a row of the
table of values; the others are listed by file, with their number and seconds. The table stands in the page between the two
lines that begin with `<!-- make verify`; the rest of the page is left as it is.
"""

import re
import sys
import xml.etree.ElementTree as ElementTree
from collections import defaultdict
from pathlib import Path

BEGIN, END = "<!-- make verify: begin -->", "<!-- make verify: end -->"


def cell(text):
    """Text that may stand in a table."""
    return text.replace("|", "\\|").replace("\n", " ")


def tables(root):
    """Both tables, from the root of a JUnit file."""
    values, others = [], defaultdict(list)
    for test in root.iter("testcase"):
        if test.find("skipped") is not None:
            continue
        failed = test.find("failure") is not None or test.find("error") is not None
        recorded = {item.get("name"): item.get("value") for item in test.iter("property")}
        if "measured" in recorded:
            values.append((recorded["run"], recorded["what"], f"{recorded['asked']} ± {recorded['tolerance']}",
                           recorded["measured"] + (" **fails**" if failed else "")))
        else:
            file = re.sub(r"/[A-Z].*", "", test.get("classname").replace(".", "/")) + ".py"  # without a class in it
            others[file].append((float(test.get("time")), failed))
    lines = ["| run | quantity | asked | measured |", "|---|---|---|---|"]
    lines += ["| " + " | ".join(map(cell, row)) + " |" for row in sorted(values)]
    lines += ["", "| other tests that take long | number | failed | seconds |", "|---|---|---|---|"]
    lines += [f"| `{name}` | {len(tests)} | {sum(failed for _, failed in tests)} | {sum(time for time, _ in tests):.0f} |"
              for name, tests in sorted(others.items())]
    return "\n".join(lines)


def with_tables(page, text):
    """The page with new tables; an error where it has no place for them."""
    new, count = re.subn(f"{re.escape(BEGIN)}.*{re.escape(END)}", lambda _: f"{BEGIN}\n{text}\n{END}", page, flags=re.DOTALL)
    if count != 1:
        raise SystemExit(f"verification_table.py: the page must have one place from '{BEGIN}' to '{END}'")
    return new


def main():
    if len(sys.argv) != 3:
        raise SystemExit(__doc__)
    results, page = map(Path, sys.argv[1:])
    page.write_text(with_tables(page.read_text(), tables(ElementTree.parse(results).getroot())))


if __name__ == "__main__":
    main()
