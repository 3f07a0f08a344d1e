#!/usr/bin/env python3
"""Write what tests have measured into a page, or as a report of one HTML file.

    verification_table.py RESULTS.xml PAGE.md                   tables of the page, and CSV files beside it with all rows
    verification_table.py --html REPORT.html RESULTS.xml [...]  every reference, error and order of convergence, and what was not run

RESULTS.xml is pytest's JUnit file; of several the last one that has a value or test counts. A test that records `run`, `what`, `asked`,
`tolerance`, `measured` and `source` is a value; the others are counted by file. The tables stand in the page between two lines that begin
with `<!-- make verify`; the rest of the page is left as it is.
"""

import csv
import html
import math
import os
import platform
import re
import subprocess
import sys
import time
import xml.etree.ElementTree as ElementTree
from collections import defaultdict
from fnmatch import fnmatchcase
from pathlib import Path

try:
    import tomllib
except ImportError:  # Python 3.10
    import tomli as tomllib

ROOT = Path(__file__).resolve().parent.parent
BEGIN, END = "<!-- make verify: begin -->", "<!-- make verify: end -->"
VALUES = ["run", "quantity", "asked", "tolerance", "measured", "part_of_tolerance", "passed"]
TESTS = ["file", "tests", "failed", "seconds"]
SIZE = re.compile(r"(\d+(?:\.\d+)?)\s?mm")
EXACT = 1e-7  # what is asked to within this is an identity, such as an energy balance: it has rounding, and no order
SMALL = 0.05  # part of a tolerance below which an error says nothing


def read(paths):
    """Values, a dictionary each, sorted; and file -> list of (seconds, failed) of the other tests."""
    values, others = {}, {}
    for path in paths:
        for test in ElementTree.parse(path).getroot().iter("testcase"):
            if test.find("skipped") is not None:
                continue
            failed = test.find("failure") is not None or test.find("error") is not None
            recorded = {item.get("name"): item.get("value") for item in test.iter("property")}
            if "measured" in recorded:
                row = {"run": recorded["run"], "quantity": recorded["what"], "asked": recorded["asked"], "tolerance": recorded["tolerance"],
                       "measured": recorded["measured"], "part_of_tolerance": part(recorded), "passed": "no" if failed else "yes",
                       "source": recorded.get("source", "")}
                values[row["run"], row["quantity"]] = row
            else:
                file = re.sub(r"/[A-Z].*", "", test.get("classname").replace(".", "/")) + ".py"  # without a class in it
                others[file, test.get("classname"), test.get("name")] = (float(test.get("time")), failed)
    by_file = defaultdict(list)
    for (file, *_), test in sorted(others.items()):
        by_file[file].append(test)
    return [values[key] for key in sorted(values)], dict(by_file)


def part(row):
    """How much of its tolerance the error of a value takes."""
    error, tolerance = abs(float(row["measured"]) - float(row["asked"])), float(row["tolerance"])
    return f"{error / tolerance:.2g}" if tolerance else "0" if not error else "inf"


def case_of(row):
    return row["run"].split()[0]


# --- the page ---------------------------------------------------------------------------------------------------------

def table(rows):
    """Rows, the first being the head, as Markdown."""
    lines = ["| " + " | ".join(str(cell).replace("|", "\\|").replace("\n", " ") for cell in row) + " |" for row in rows]
    return [lines[0], "|---" * len(rows[0]) + "|", *lines[1:]]


def worst_of(values):
    """Each case, its values and that of them which is nearest to its tolerance."""
    cases = defaultdict(list)
    for row in values:
        cases[case_of(row)].append(row)
    return [(case, found, max(found, key=lambda row: float(row["part_of_tolerance"]))) for case, found in cases.items()]


def summary(values, others):
    """What a page has of both tables: a row for each case, with the value that is nearest to its tolerance, and one for each folder of tests."""
    folders = defaultdict(list)
    for file, tests in others.items():
        folders[file.rpartition("/")[0]].append(tests)
    rows = [("case", "values", "value nearest to its tolerance", "asked", "measured")]
    for case, found, worst in worst_of(values):
        runs, failed = len({row["run"] for row in found}), sum(row["passed"] == "no" for row in found)
        rows.append((f"`{case}`", f"{len(found)} of {runs} run{'s' * (runs > 1)}" + f", **{failed} outside**" * bool(failed),
                     f"{worst['run'].partition(' ')[2]}: {worst['quantity']}".removeprefix(": "), f"{worst['asked']} ± {worst['tolerance']}", worst["measured"]))
    tests = [("other tests that take long", "files", "tests", "failed", "seconds")]
    for folder, files in folders.items():
        every = [test for found in files for test in found]
        tests.append((f"`{folder}`", len(files), len(every), sum(failed for _, failed in every), f"{sum(seconds for seconds, _ in every):.0f}"))
    return [*table(rows), "", *table(tests)]


def with_tables(page, lines):
    """The page with new tables; an error where it has no place for them."""
    new, count = re.subn(f"{re.escape(BEGIN)}.*{re.escape(END)}", lambda _: "\n".join([BEGIN, *lines, END]), page, flags=re.DOTALL)
    if count != 1:
        raise SystemExit(f"verification_table.py: the page must have one place from '{BEGIN}' to '{END}'")
    return new


def write_page(values, others, page):
    """The tables of a page, and beside it NAME_values.csv and NAME_tests.csv."""
    text = with_tables(page.read_text(), summary(values, others))
    tests = [(file, len(found), sum(failed for _, failed in found), f"{sum(seconds for seconds, _ in found):.0f}") for file, found in others.items()]
    for name, rows in (("values", [VALUES, *([row[key] for key in VALUES] for row in values)]), ("tests", [TESTS, *tests])):
        with open(page.with_name(f"{page.stem}_{name}.csv"), "w", newline="") as file:
            csv.writer(file, lineterminator="\n").writerows(rows)
    page.write_text(text)


# --- the report -------------------------------------------------------------------------------------------------------

def orders(values):
    """(case, quantity) -> (sizes of cells, errors, observed orders), where runs of a case differ in the size of their cells only, and are asked the
    same. The name of a run has the size, as in `0.1mm`."""
    groups, parts = defaultdict(dict), defaultdict(list)
    for row in values:
        sizes = SIZE.findall(row["run"])
        if len(sizes) == 1 and float(row["tolerance"]) > EXACT * max(1, abs(float(row["asked"]))):
            run = SIZE.sub("", row["run"]).strip(" -")
            groups[run, row["quantity"], row["asked"]][float(sizes[0])] = float(row["measured"]) - float(row["asked"])
            parts[run, row["quantity"]].append(float(row["part_of_tolerance"]))
    found = {}
    for (run, quantity, _), errors in groups.items():
        sizes = sorted(errors, reverse=True)
        if len(sizes) > 1 and all(errors.values()) and max(parts[run, quantity]) > SMALL:
            found[run, quantity] = (sizes, [errors[size] for size in sizes],
                                    [f"{math.log(errors[a] / errors[b]) / math.log(a / b):.1f}" if errors[a] * errors[b] > 0 else "–" for a, b in zip(sizes, sizes[1:])])
    return found


def not_run(values):
    """Run and quantity of all values that tests/regression asks, and that are not among these."""
    have, missing = {(row["run"], row["quantity"]) for row in values}, []
    for path in sorted((ROOT / "tests/regression").glob("*/expected.toml")):
        expected = tomllib.loads(path.read_text())
        missing += [(f"{path.parent.name} {name}", item["what"]) for name in expected.get("runs", {"": []}) for item in expected["expect"]
                    if fnmatchcase(name, item.get("runs", "*")) and (f"{path.parent.name} {name}", item["what"]) not in have]
    return missing


def said_by(*command):
    """The first line that a command prints; nothing where it is not there."""
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    except OSError:
        return ""
    return done.stdout.partition("\n")[0] if done.returncode == 0 else ""


def machine():
    """Program, compiler and machine, as pairs of words."""
    cpuinfo = Path("/proc/cpuinfo")
    model = re.search(r"model name\s*: (.*)", cpuinfo.read_text()) if cpuinfo.exists() else None
    return [("program", said_by(ROOT / os.environ.get("HAMPM", "build/release/hampm"), "--version")), ("compiler", said_by("gfortran", "--version")),
            ("processor", f"{model[1] if model else platform.processor() or platform.machine()}, {os.cpu_count()} cores"),
            ("system", f"{platform.system()} {platform.release()}, Python {platform.python_version()}"), ("report written", stamp(time.time()))]


def stamp(seconds):
    return time.strftime("%Y-%m-%d %H:%M", time.localtime(seconds))


STYLE = """body{font:15px/1.45 system-ui,sans-serif;max-width:75em;margin:2em auto;padding:0 1em;color:#222}h2{margin-top:2em;border-bottom:1px solid #bbb}
table{border-collapse:collapse;width:100%;font-size:13px;margin:1em 0}th{text-align:left;border-bottom:2px solid #555}td,th{padding:.2em .6em;vertical-align:top}
tr{border-bottom:1px solid #ddd;break-inside:avoid}td.n{text-align:right;font-variant-numeric:tabular-nums;white-space:nowrap}.fails{background:#fbd5d0}
.part{white-space:nowrap}.bar{display:inline-block;width:5em;height:.7em;background:#e4e4e4;vertical-align:middle;margin-right:.4em;print-color-adjust:exact;-webkit-print-color-adjust:exact}
.bar i{display:block;height:100%;background:#2b6cb0;print-color-adjust:exact;-webkit-print-color-adjust:exact}.fails .bar i{background:#b3261e}
@media print{body{margin:0;max-width:none;font-size:11px}table{font-size:9px}h2{break-after:avoid}@page{margin:12mm}}"""


def rows_of(head, rows, numbers=()):
    """A table as HTML. A cell that begins with `<` is HTML as it is; `numbers`: the columns that are set right."""
    def cell(k, text):
        text = str(text)
        return f"<td{' class=n' if k in numbers else ''}>{text if text.startswith('<') else html.escape(text)}</td>"
    body = "".join(f"<tr{' class=fails' if fails else ''}>{''.join(cell(k, text) for k, text in enumerate(row))}</tr>\n" for fails, row in rows)
    return f"<table><thead><tr>{''.join(f'<th>{html.escape(text)}</th>' for text in head)}</tr></thead><tbody>\n{body}</tbody></table>\n"


def report(values, others, missing, paths):
    """The whole report."""
    failed, tests = sum(row["passed"] == "no" for row in values), [test for found in others.values() for test in found]
    bad = sum(test[1] for test in tests)
    parts = [f"<!DOCTYPE html><html lang='en'><head><meta charset='utf-8'><meta name='viewport' content='width=device-width'><title>Verification of hampm</title>"
             f"<style>{STYLE}</style></head><body><h1>Verification of hampm</h1>",
             f"<p>{len(values)} values of {len({case_of(row) for row in values})} cases were measured and compared with references: {failed} are outside of their "
             f"tolerance. {len(tests)} other tests ran: {bad} failed. {len(missing)} values were not measured in these runs; they are listed at the end.</p>",
             rows_of(("what", "which"), [(False, row) for row in machine() + [("results", f"{path}, {stamp(path.stat().st_mtime)}") for path in paths]]),
             rows_of(("case", "values", "outside", "nearest to its tolerance", "part"), [
                 (any(row["passed"] == "no" for row in found), (f"<a href='#{case}'>{case}</a>", len(found), sum(row["passed"] == "no" for row in found),
                                                                f"{worst['run'].partition(' ')[2]}: {worst['quantity']}".removeprefix(": "), bar(worst)))
                 for case, found, worst in worst_of(values)], (1, 2)),
             "<h2>Errors against claims</h2><p>Claimed is that the measured value lies within the tolerance of the asked one. The bar is the part of the "
             "tolerance that the error takes. The source says where the asked value and its tolerance come from.</p>"]
    for case in dict.fromkeys(map(case_of, values)):
        rows = [(row["passed"] == "no", (row["run"].partition(" ")[2], row["quantity"], row["asked"], f"± {row['tolerance']}", row["measured"], bar(row), row["source"]))
                for row in values if case_of(row) == case]
        parts.append(f"<h3 id='{case}'>{case}</h3>" + rows_of(("run", "quantity", "asked", "claimed", "measured", "part", "source"), rows, (2, 3, 4)))
    found = orders(values)
    parts.append("<h2>Observed orders of convergence</h2><p>Of runs that differ in the size of their cells only. Errors are those from the asked values above; "
                 "an error that changes its sign between two sizes has no order.</p>")
    parts.append(rows_of(("runs", "quantity", "cells [mm]", "errors", "orders"), [
        (False, (run, quantity, ", ".join(f"{size:g}" for size in sizes), ", ".join(f"{error:+.2g}" for error in errors), ", ".join(order)))
        for (run, quantity), (sizes, errors, order) in found.items()]) if found else "<p>None: no case ran on more than one size.</p>")
    if others:
        parts.append("<h2>Other tests</h2>" + rows_of(TESTS, [
            (any(bad for _, bad in ran), (file, len(ran), sum(bad for _, bad in ran), f"{sum(seconds for seconds, _ in ran):.0f}")) for file, ran in others.items()], (1, 2, 3)))
    parts.append("<h2>Not run</h2>" + (rows_of(("run", "quantity"), [(False, row) for row in missing]) if missing else "<p>Nothing: all values that "
                 "<code>tests/regression</code> asks were measured.</p>"))
    return "\n".join([*parts, "</body></html>\n"])


def bar(row):
    """The part of its tolerance that a value takes, as a bar and a number."""
    return (f"<span class='part'><span class='bar'><i style='width:{min(100, 100 * float(row['part_of_tolerance'])):.0f}%'></i></span>"
            f"{row['part_of_tolerance']}</span>")


def main():
    words = sys.argv[1:]
    if len(words) >= 3 and words[0] == "--html":
        paths = list(map(Path, words[2:]))
        values, others = read(paths)
        Path(words[1]).parent.mkdir(parents=True, exist_ok=True)
        missing = not_run(values)
        Path(words[1]).write_text(report(values, others, missing, paths))
        print(f"{words[1]}: {len(values)} values, {sum(row['passed'] == 'no' for row in values)} outside of their tolerance, {len(missing)} not run")
    elif len(words) == 2 and words[0] != "--html":
        write_page(*read(words[:1]), Path(words[1]))
    else:
        raise SystemExit(__doc__)


if __name__ == "__main__":
    main()
