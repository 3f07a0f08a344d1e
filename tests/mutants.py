"""Strength of the tests: small faults are drawn at random from all of src/, one at a time, and the tests are asked to find them.

    make mutants                             200 of seed 1; what ran before is kept in build/mutants/ledger.jsonl
    python tests/mutants.py --draw 200 --seed 1 [--only A:B] [--whole] [--minutes M] [--show]

A fault is an operator, a sign, a constant, an index, a condition or a line that is missing, in a statement that computes (no declarations, texts, comments, and no
tables that tools write). The tree is a copy of the last commit in build/mutants with quick builds of both programs; after an edit make compiles what has changed.
First the tests run that changed most often together with the file (its history tells), those that the table "you changed X, run Y" of CONTRIBUTING.md names, and some
that are broad, quick ones before others, as many as BUDGET allows; then the unit test of that name; with --whole all of `make test` where these find nothing. What does
not compile is not counted. A test that fails, and has not passed before, is asked again with the programs without the fault: where it fails there too, or takes as long as
a fault without end, it is left out from then on. Tests are collected once; those of a fault run in a child of this process.
--show prints the table and the survivors of what has run."""

import argparse
import collections
import contextlib
import functools
import json
import math
import os
import random
import re
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
FOLDER = ROOT / "build/mutants"
TREE, LEDGER, CLEAN = FOLDER / "tree", FOLDER / "ledger.jsonl", FOLDER / "clean"
COSTS, LEFT_OUT = FOLDER / "costs.jsonl", FOLDER / "left_out.json"
BUILDS = "quick/hampm", "quick3d/hampm3d"
BUDGET, MOST, UNKNOWN = 8.0, 1.2, 0.5     # seconds of a processor: of the tests of a fault, of one test, of a test that has not run
WRITTEN = "rule_table.f90", "key_table.f90"

# What to change, and for what, in the part of a statement that is no text
CHANGES = [("sign", r"(?<=[\w)] )\+(?= [\w(])", "-"), ("sign", r"(?<=[\w)] )-(?= [\w(])", "+"), ("operator", r"(?<=[\w)])\*(?=[\w(])", "/"),
           ("operator", r"\bmin\(", "max("), ("operator", r"\bmax\(", "min("), ("condition", r"(?<= )<(?= )", ">="), ("condition", r"(?<= )>(?= )", "<="),
           ("condition", r"(?<= )<=(?= )", "<"), ("condition", r"(?<= )>=(?= )", ">"), ("condition", r"(?<= )==(?= )", "/="), ("condition", r"(?<= )/=(?= )", "=="),
           ("condition", r"\.and\.", ".or."), ("condition", r"\.or\.", ".and."), ("condition", r"\.not\. ?", ""), ("constant", r"\b0\.5_dp\b", "0.25_dp"),
           ("constant", r"\b2\.0_dp\b|\b2\*", "3*"), ("constant", r"(?<![\w.])(\d+)\.(\d+)_dp\b", r"1\1.\2_dp"), ("index", r"(?<=\w )[+-] 1\b(?!\.)", ""),
           ("index", r"(?<=[(, ])([a-z]\w*)(?=\)\s*[=*+,-])", r"\1 + 1")]
STATEMENT = re.compile(r"^\s+(call \w[\w%]*\(.*\)|[a-z][\w%]*(\(.*\))? = .*)$")
NO_CODE = re.compile(r"::|^\s*(!|use\b|implicit|end\b|module|contains|private|public|import|subroutine|function|type\b|interface|class|case|block|select|else\s*$|stop|error)|=>")

# Of the files that are asked of a fault: those of its folder, after those that its history names, and those that are asked of each
NEAR = {"fracture growth": "growth quadratic fronts front_growth fatigue estimates crack_path growth_in_motion t_stress estimated_errors",
        "element points law": "every_law remembering_laws weight_and_eigenstrain static quadratic", "time solve problem": "implicit static rest supports pressure",
        "mesh adapt geometry": "cut_cells quadratic_cut solid_shapes shapes carried_cracks static front_growth",
        "interface": "contact cohesive interfaces solid_contact body_contact", "input": "rules bad_input command_line caveats", "setup": "checkpoints run bad_input",
        "output report": "results_file result_file probes", "": "run stopping checkpoints command_line"}
BROAD = "mirror_images images solid_physics solid_loads same_numbers estimate_coverage line_mass_identity".split()
FOLDERS = "program", "cases", "cli", "output", "fuzz"


def code_of(line):
    """The code of a line: without its comment, with texts blanked."""
    found, quote = [], ""
    for letter in line:
        if quote:
            quote = "" if letter == quote else quote
            letter = "~"
        elif letter in "\"'":
            quote, letter = letter, "~"
        elif letter == "!":
            break
        found.append(letter)
    return "".join(found)


def faults_of(line, is_continued):
    """All faults of a line: (kind, the line with it)."""
    code = code_of(line)
    if NO_CODE.search(code) or not code.strip():
        return []
    found = [(kind, line[:at.start()] + at.expand(new) + line[at.end():]) for kind, old, new in CHANGES for at in re.finditer(old, code)]
    if STATEMENT.match(code) and not code.rstrip().endswith("&") and not is_continued:
        found.append(("missing line", re.match(r"\s*", line)[0] + "continue"))
    return found


@functools.cache
def all_faults(root):
    """Faults of all of src/ by kind: (file, number of the line, kind, new line)."""
    by_kind = collections.defaultdict(list)
    for path in sorted((root / "src").rglob("*.f90")):
        if path.name in WRITTEN:
            continue
        is_continued = False
        for number, line in enumerate(path.read_text().splitlines()):
            for kind, new in faults_of(line, is_continued):
                by_kind[kind].append((str(path.relative_to(root)), number, kind, new))
            is_continued = code_of(line).rstrip().endswith("&")
    return by_kind


def draw(count, seed, root=ROOT):
    """Faults that are drawn, each kind as often."""
    drawn, by_kind = random.Random(seed), all_faults(root)
    return [drawn.choice(by_kind[drawn.choice(sorted(by_kind))]) for _ in range(count)]


def inside(*command, **options):
    return subprocess.run(command, cwd=TREE, capture_output=True, text=True, **options)


def build(*others):
    """A quick build: of the program of the plane, or of others."""
    return inside("make", "-s", "build=quick", *(others or ["program"])).returncode == 0


@functools.cache
def history():
    """How often a file of src/ changed together with a file of tests, of commits that changed few: {file: {test: weight}}."""
    found = collections.defaultdict(collections.Counter)
    for commit in subprocess.run(["git", "log", "--no-merges", "--name-only", "--format=@%h"], cwd=ROOT, capture_output=True, text=True, check=True).stdout.split("@"):
        files = commit.split()[1:]
        sources, tests = ([file for file in files if re.match(what, file)] for what in ("src/.*f90$", r"tests/(program|cases|cli|output|fuzz)/test_\w+\.py$"))
        for source in sources:
            found[source].update({test: 1 / len(sources) / len(tests) for test in tests})
    return found


def near(path):
    """Files of tests for a file of src/, the likeliest first."""
    there = {file.stem.removeprefix("test_"): str(file.relative_to(TREE)) for folder in FOLDERS for file in sorted((TREE / "tests" / folder).glob("test_*.py"))}
    often = collections.Counter()
    for source in history().values():
        often.update(source)
    weights = collections.Counter({test: weight / math.sqrt(often[test]) for test, weight in history()[path].items()})
    words = set(Path(path).stem.split("_"))
    for name, test in there.items():
        alike = sum(any(word.startswith(other[:5]) and other.startswith(word[:5]) for other in words) for word in name.split("_") if len(word) > 3)
        weights[test] += alike / len(name.split("_"))
    folder = Path(path).parts[1] if len(Path(path).parts) > 2 else ""
    of_folder = next((of for names, of in NEAR.items() if folder in names.split()), NEAR[""])
    likely = [test for test, weight in weights.most_common(5) if weight > 0.05]
    return [test for test in dict.fromkeys([*likely, *(there.get(name) for name in [*of_folder.split(), *BROAD])]) if test and (TREE / test).exists()]


def spent():
    times = os.times()
    return times.user + times.system + times.children_user + times.children_system


class Tests:
    """As a plugin of pytest: what is collected is asked of one fault after the other."""

    def __init__(self, asked, rows):
        self.asked, self.rows, self.failed = asked, rows, None
        self.costs, self.passed = {}, set()
        for name, cost, has_passed in map(json.loads, COSTS.read_text().splitlines() if COSTS.exists() else ()):
            self.costs[name] = cost
            self.passed.update([name] if has_passed else [])
        self.left_out = set(json.loads(LEFT_OUT.read_text())) if LEFT_OUT.exists() else set()

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtestloop(self, session):
        self.items, self.run = session.items, session.config.hook.pytest_runtest_protocol
        judge_all(self)
        return True

    def pytest_runtest_logreport(self, report):
        if report.failed and not self.failed:
            self.failed = report.nodeid, str(report.longrepr)[-300:]

    def chosen(self, files):
        """Tests of files: quick ones first, as many of a file as a part of the budget allows."""
        found, total = [], 0.0
        for file in files:
            of_file = 0.0
            for item in sorted((item for item in self.items if item.nodeid.startswith(f"{file}::")), key=lambda item: self.costs.get(item.nodeid, UNKNOWN)):
                cost = self.costs.get(item.nodeid, UNKNOWN)
                if cost < MOST and of_file + cost < BUDGET / 5 and total + cost < BUDGET:
                    of_file, total = of_file + cost, total + cost
                    found.append(item)
        return found

    def first_that_fails(self, items):
        """In a child: what is imported and collected is there already."""
        end, begin = os.pipe()
        child = os.fork()
        if child == 0:
            try:
                self.run_in_child(items, begin)
            finally:
                os._exit(0)
        os.close(begin)
        with os.fdopen(end) as pipe:
            failed, notes = json.load(pipe)
        os.waitpid(child, 0)
        shutil.rmtree(FOLDER / "tmp", ignore_errors=True)
        (FOLDER / "tmp").mkdir()
        with COSTS.open("a") as file:
            for note in notes:
                file.write(json.dumps(note) + "\n")
                self.costs[note[0]] = note[1]
                self.passed.update([note[0]] if note[2] else [])
        return failed

    def run_in_child(self, items, begin):
        for stream in (1, 2):
            os.dup2(os.open(os.devnull, os.O_WRONLY), stream)
        notes = []
        for item, following in zip(items, [*items[1:], None]):
            before = spent()
            self.run(item=item, nextitem=following)
            notes.append((item.nodeid, round(spent() - before, 3), not self.failed))
            if self.failed:
                break
        with os.fdopen(begin, "w") as pipe:
            json.dump([self.failed, notes], pipe)

    def found_by(self, items):
        """The first test that fails with the fault and not without it."""
        while failed := self.first_that_fails([item for item in items if item.nodeid not in self.left_out]):
            begin = time.time()
            if failed[0] in self.passed and "Timeout" not in failed[1]:
                return failed
            item = next(item for item in items if item.nodeid == failed[0])
            with no_fault():
                is_fault = not self.first_that_fails([item]) and ("Timeout" not in failed[1] or time.time() - begin < 60)
            if is_fault:
                return failed
            self.left_out.add(failed[0])
            LEFT_OUT.write_text(json.dumps(sorted(self.left_out)))
        return None


@contextlib.contextmanager
def no_fault():
    """The programs as they are without one."""
    for name in BUILDS:
        os.replace(TREE / "build" / name, FOLDER / Path(name).name)
        shutil.copy2(CLEAN / name, TREE / "build" / name)
    yield
    for name in BUILDS:
        os.replace(FOLDER / Path(name).name, TREE / "build" / name)


def prepare():
    """The copy and its builds."""
    if not TREE.exists():
        FOLDER.mkdir(parents=True, exist_ok=True)
        subprocess.run(["git", "clone", "-q", "--no-hardlinks", ROOT, TREE], check=True)
        (TREE / ".venv").symlink_to(ROOT / ".venv")
        (TREE / "build/checked").mkdir(parents=True)                   # for tests that take no other build
        (TREE / "build/checked/hampm").symlink_to(f"../{BUILDS[0]}")
    subprocess.run(["git", "fetch", "-q", ROOT, "HEAD"], cwd=TREE, check=True)
    subprocess.run(["git", "reset", "-q", "--hard", "FETCH_HEAD"], cwd=TREE, check=True)
    if not (build() and build("dim=3", "program") and build("build/quick/results_driver")):
        sys.exit("the copy in build/mutants/tree does not build")
    shutil.rmtree(CLEAN, ignore_errors=True)
    for name in ("quick", "quick3d"):
        shutil.copytree(TREE / "build" / name, CLEAN / name)


def restore(file, before, times, began):
    """Take a fault back, with what was compiled of it."""
    file.write_text(before)
    for name in ("quick", "quick3d"):
        for made in (TREE / "build" / name).iterdir():
            if made.stat().st_mtime >= began - 1 and made.is_file():
                kept = CLEAN / name / made.name
                made.unlink()                    # it may run
                if kept.exists():
                    shutil.copy2(kept, made)
    os.utime(file, times)                        # at last: what has failed before is compiled anew


def judge(fault, tests):
    """Build and test one fault: its row of the ledger."""
    path, number, kind, new = fault
    file = TREE / path
    before, times, began = file.read_text(), (file.stat().st_atime, file.stat().st_mtime), time.time()
    lines = before.splitlines()
    row = {"file": path, "line": number + 1, "kind": kind, "old": lines[number].strip(), "new": new.strip(), "start": began}
    lines[number] = new
    try:
        file.write_text("\n".join(lines) + "\n")
        if not build() and not build("dim=3", "program"):
            return row | {"end": "does not compile"}
        row["build"] = round(time.time() - began)
        files, unit = near(path), f"build/quick/test_{Path(path).stem}"
        found = tests.found_by(tests.chosen(file for file in files if not re.search("solid|front", file)))
        if not found and (TREE / f"tests/unit/test_{Path(path).stem}.f90").exists() and build(unit) and inside(unit, timeout=600).returncode:
            found = f"unit {Path(path).stem}"
        if not found and build("dim=3", "program"):
            found = tests.found_by(tests.chosen(file for file in files if re.search("solid|front", file)))
        end = "killed" if found else "survived"
        if not found and tests.asked.whole:
            found = tests.found_by(tests.items)
            end = "killed by the whole" if found else "survived all"
        return row | {"end": end, "by": found}
    finally:
        restore(file, before, times, began)


def judge_all(tests):
    first, last = (int(part) if part else None for part in tests.asked.only.split(":"))
    began, known = time.time(), {(row["file"], row["line"], row["new"]) for row in tests.rows}
    for fault in draw(tests.asked.draw, tests.asked.seed, TREE)[first:last]:
        if (fault[0], fault[1] + 1, fault[3].strip()) in known or time.time() > began + 60 * tests.asked.minutes:
            continue
        row = judge(fault, tests)
        row["seconds"] = round(time.time() - row.pop("start"))
        tests.rows.append(row)
        with LEDGER.open("a") as file:
            file.write(json.dumps(row) + "\n")
        print({key: row[key] for key in ("file", "line", "kind", "end", "seconds")}, flush=True)


def show(rows):
    ends = collections.Counter(row["end"] for row in rows)
    counted = sum(count for end, count in ends.items() if end != "does not compile")
    killed = sum(count for end, count in ends.items() if end.startswith("killed"))
    print("| kind | drawn | killed | survived |\n|---|---|---|---|")
    for kind in sorted({row["kind"] for row in rows}):
        of = [row["end"] for row in rows if row["kind"] == kind and row["end"] != "does not compile"]
        print(f"| {kind} | {len(of)} | {sum(end.startswith('killed') for end in of)} | {sum(end.startswith('survived') for end in of)} |")
    print(f"{killed} of {counted} killed ({100 * killed / max(counted, 1):.0f} %); {ends['does not compile']} did not compile")
    for row in rows:
        if row["end"].startswith("survived"):
            print(f"{row['file']}:{row['line']}\n    {row['old']}\n    {row['new']}")


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--draw", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", default=":", help="places among the drawn ones, as A:B")
    parser.add_argument("--whole", action="store_true")
    parser.add_argument("--minutes", type=float, default=1e9, help="begin no other fault after this time")
    parser.add_argument("--show", action="store_true")
    asked = parser.parse_args()
    rows = [json.loads(line) for line in LEDGER.read_text().splitlines()] if LEDGER.exists() else []
    if not asked.show:
        prepare()
        os.chdir(TREE)
        os.environ.update({"HAMPM": f"build/{BUILDS[0]}", "HAMPM3D": f"build/{BUILDS[1]}"})
        whole = ["tests", "--ignore=tests/setup", "--ignore=tests/unit"] if asked.whole else [f"tests/{folder}" for folder in FOLDERS]
        pytest.main(["-q", "-s", "-p", "no:cacheprovider", "-p", "no:xdist", f"--basetemp={FOLDER}/tmp", "-m", "not verify", *whole], plugins=[Tests(asked, rows)])
    show(rows)


if __name__ == "__main__":
    main()
