"""Strength of the tests: small faults are drawn at random from all of src/, one at a time, and the tests are asked to find them.

    make mutants                             200 of seed 1; what ran before is kept in build/mutants/ledger.jsonl
    python tests/mutants.py --draw 200 --seed 1 [--only A:B] [--whole] [--minutes M] [--show]

A fault is an operator, a sign, a constant, an index, a condition or a line that is missing, in a statement that computes (no declarations, texts, comments, and no
tables that tools write). The tree is a copy of the last commit in build/mutants with quick builds of both programs; after an edit make compiles what has changed.
Once, both programs are built so that each of the places drawn tells that it is run, and the first case of each test is run: a fault is asked of those only that run its
place, and of others of the same files, where runs may be shared. First come those of files that changed most often together with its file (its history tells), of each file those that name
it, and quick ones, before others, as many as BUDGET allows; then unit tests that use its module; with --whole all of `make test` where these find nothing. What does not
compile is not counted. A test that fails, and has not passed before, is asked again with the programs without the fault: where it fails there too, or takes as long as
a fault without end, it is left out from then on. Tests are collected once; those of a fault run in a child of this process.
--show prints the table and the survivors of what has run."""

import argparse
import collections
import contextlib
import functools
import itertools
import json
import math
import os
import random
import re
import resource
import shutil
import subprocess
import sys
import time
import zlib
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
FOLDER = ROOT / "build/mutants"
TREE, LEDGER, CLEAN = FOLDER / "tree", FOLDER / "ledger.jsonl", FOLDER / "clean"
COSTS, LEFT_OUT = FOLDER / "costs.jsonl", FOLDER / "left_out.json"
TRACED, NOTES, OF = FOLDER / "traced", FOLDER / "notes", FOLDER / "traced_of"
BUILDS = "quick/hampm", "quick3d/hampm3d"
TOOLS = "newton_steps", "forced_step", "eigenvalue_limit", "results_driver"    # programs that some tests run
BUDGET, SHARE, MOST, UNKNOWN = 12.0, 2.0, 2.0, 0.15    # seconds of a processor: of the tests of a fault, of those of one file, of one test, of a test that has not run
UNITS = 6                                 # most unit tests that are asked of a fault
LONGEST, MEMORY, LARGEST = 20, 8 * 2**30, 2**28    # seconds until a run has no end, and bytes that it may ask for and write
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


def inside(*command, cwd=TREE, **options):
    return subprocess.run(command, cwd=cwd, capture_output=True, text=True, **options)


def build(*others):
    """A quick build: of the program of the plane, or of others."""
    return inside("make", "-s", "build=quick", *(others or ["program"])).returncode == 0


def units_of(name):
    """The unit tests that use a module, that of its name first."""
    found = sorted((f"test_{name}" != file.stem, file.stem) for file in (TREE / "tests/unit").glob("test_*.f90") if f"use hampm_{name}," in file.read_text() or file.stem == f"test_{name}")
    return [stem for _, stem in found[:UNITS]]


def fails(unit):
    """Whether a unit test fails, or has no end."""
    try:
        return inside(unit, timeout=120).returncode != 0
    except subprocess.TimeoutExpired:
        return True


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
    """How near files of tests are to a file of src/: they changed together, or have a word of their names in common."""
    often = collections.Counter()
    for source in history().values():
        often.update(source)
    weights = collections.Counter({test: weight / math.sqrt(often[test]) for test, weight in history()[path].items()})
    words = set(Path(path).stem.split("_"))
    for file in (file for folder in FOLDERS for file in (TREE / "tests" / folder).glob("test_*.py")):
        name = file.stem.removeprefix("test_").split("_")
        alike = sum(any(word.startswith(other[:5]) and other.startswith(word[:5]) for other in words) for word in name if len(word) > 3)
        weights[str(file.relative_to(TREE))] += alike / len(name)
    return weights


# A procedure that notes once a run that a place is run; it is no pure one, but none of its callers can tell
TELLS = r"""
#include <fcntl.h>
#include <stdio.h>
void mutants_hit(int place) {
    static char seen[100000];
    const char *path = getenv("MUTANTS_HITS");
    if (seen[place] || !path) return;
    seen[place] = 1;
    const int file = open(path, O_WRONLY | O_APPEND | O_CREAT, 0666);
    if (file >= 0) { dprintf(file, "%d\n", place); close(file); }
}
"""
INTERFACE = """   interface
      pure subroutine mutants_hit(place) bind(c)
         use, intrinsic :: iso_c_binding, only: c_int
         integer(c_int), intent(in), value :: place
      end subroutine mutants_hit
   end interface"""


def start_of(lines, number):
    """The line before which a call may stand that is run with a line: the first one of its statement, or of the construct that it is a condition of."""
    while True:
        indent = len(lines[number]) - len(lines[number].lstrip())
        code, before = code_of(lines[number]), lines[number - 1]
        if code_of(before).rstrip().endswith("&") or before.lstrip().startswith("!$omp"):
            number -= 1
        elif re.match(r"\s*else", code):
            number = next(k for k in range(number - 1, 0, -1) if re.match(rf"\s{{{indent}}}(if|where)\b", lines[k]))
        else:
            opened = next((k for k in range(number - 1, 0, -1) if lines[k].strip() and len(lines[k]) - len(lines[k].lstrip()) < indent), 0)
            if not re.match(r"\s*(else)?where\b", lines[opened]):
                return number
            number = opened


def trace(faults):
    """A copy of the tree whose programs tell which of the places of faults they run."""
    if TRACED.exists():
        return
    shutil.copytree(TREE, TRACED, symlinks=True)
    for path in {fault[0] for fault in faults}:
        file = TRACED / path
        lines = file.read_text().splitlines()
        places = sorted({(start_of(lines, fault[1]), place) for place, fault in enumerate(faults) if fault[0] == path}, reverse=True)
        for line, place in places:
            lines.insert(line, f"call mutants_hit({place})")
        lines.insert(next(k for k, line in enumerate(lines) if line.startswith("contains")), INTERFACE)
        file.write_text("\n".join(lines) + "\n")
    with (TRACED / "src/processor.c").open("a") as file:
        file.write(TELLS)
    if not all(inside("make", "-s", "build=quick", *words, cwd=TRACED).returncode == 0 for words in (["program"], ["dim=3", "program"])):
        sys.exit(f"{TRACED} does not build")


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
        self.hits = self.all_hits()
        judge_all(self)
        return True

    def pytest_runtest_logreport(self, report):
        if report.failed and not self.failed:
            self.failed = report.nodeid, str(report.longrepr)[-300:]

    def all_hits(self):
        """Of each function of the tests the places of faults that its first case runs."""
        first = {function_of(item): item for item in reversed(self.items) if not note_of(item).exists()}
        if first:
            trace(draw(self.asked.draw, self.asked.seed, TREE))
            NOTES.mkdir(exist_ok=True)
            with programs_of_folder(TRACED / "build"):
                for _, items in itertools.groupby(reversed(first.values()), lambda item: item.path):
                    self.first_that_fails(list(items), is_traced=True)
        return {function_of(item): {int(place) for place in note_of(item).read_text().split()} for item in self.items if note_of(item).exists()}

    def chosen(self, path, place):
        """Tests that run a place, of each file as much as SHARE allows, and others of these files, which may share runs with them, later: of near files first. Cases
        that are named after the file count as such; where no first case runs the place, tests of near files do."""
        weights, name = near(path), Path(path).stem
        files = {item.path for item in self.items if place in self.hits.get(function_of(item), ()) or f"[{name}" in item.nodeid} or {TREE / file for file, _ in weights.most_common(8)}
        total, of_file, found = 0.0, collections.Counter(), []
        for item in sorted((item for item in self.items if item.path in files), key=lambda item: (name not in item.nodeid, self.costs.get(item.nodeid, UNKNOWN))):
            cost, file = self.costs.get(item.nodeid, UNKNOWN), str(item.path.relative_to(TREE))
            is_later = place not in self.hits.get(function_of(item), ()) or of_file[file] + cost > SHARE
            of_file[file] += 0 if is_later else cost
            found.append((is_later, -weights[file], item, cost))
        tests = []
        for _, _, item, cost in sorted(found, key=lambda one: one[:2]):
            if cost < MOST and total + cost < BUDGET:
                total += cost
                tests.append(item)
        return tests

    def first_that_fails(self, items, is_traced=False):
        """In a child: what is imported and collected is there already. Where places are traced all are run."""
        end, begin = os.pipe()
        child = os.fork()
        if child == 0:
            try:
                self.run_in_child(items, begin, is_traced)
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

    def run_in_child(self, items, begin, is_traced):
        for stream in (1, 2):
            os.dup2(os.open(os.devnull, os.O_WRONLY), stream)
        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
        resource.setrlimit(resource.RLIMIT_FSIZE, (LARGEST, LARGEST))
        wait, notes = subprocess.Popen.communicate, []
        subprocess.Popen.communicate = lambda self, input=None, timeout=None: wait(self, input, min(timeout or LONGEST, LONGEST))
        for item, following in zip(items, [*items[1:], None]):
            before, self.failed = spent(), None
            if is_traced:
                os.environ["MUTANTS_HITS"] = str(note_of(item))
                note_of(item).touch()
            self.run(item=item, nextitem=following)
            notes.append((item.nodeid, round(spent() - before, 3), not self.failed))
            if self.failed and not is_traced:
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
            with programs_of_folder(CLEAN):
                is_fault = not self.first_that_fails([item]) and ("Timeout" not in failed[1] or time.time() - begin < 60)
            if is_fault:
                return failed
            self.left_out.add(failed[0])
            LEFT_OUT.write_text(json.dumps(sorted(self.left_out)))
        return None


def function_of(item):
    """A test without its case."""
    return item.nodeid.partition("[")[0]


def note_of(item):
    """Where a test notes the places that it runs."""
    return NOTES / f"{zlib.crc32(function_of(item).encode()):08x}"


@contextlib.contextmanager
def programs_of_folder(folder):
    """The tests run other programs than those with a fault, or without one."""
    names = [name for name in (*BUILDS, *(f"{build}/{tool}" for build in ("quick", "quick3d") for tool in TOOLS)) if (folder / name).exists()]
    for name in names:
        os.replace(TREE / "build" / name, FOLDER / name.replace("/", "_"))
        shutil.copy2(folder / name, TREE / "build" / name)
    yield
    for name in names:
        os.replace(FOLDER / name.replace("/", "_"), TREE / "build" / name)


def programs_of(tests, folder):
    """The programs of a build that tests run."""
    texts = [path.read_text().lower() for path in {item.path for item in tests}]
    return ["program", *(f"build/{folder}/{tool}" for tool in TOOLS if any(tool in text for text in texts))]


def of_git(*words):
    return subprocess.run(["git", *words], cwd=TREE, check=True, capture_output=True, text=True).stdout


def prepare(asked):
    """The copy and its builds."""
    if not TREE.exists():
        FOLDER.mkdir(parents=True, exist_ok=True)
        subprocess.run(["git", "clone", "-q", "--no-hardlinks", ROOT, TREE], check=True)
        (TREE / ".venv").symlink_to(ROOT / ".venv")
        (TREE / "build/checked").mkdir(parents=True)                   # for tests that take no other build
        (TREE / "build/checked/hampm").symlink_to(f"../{BUILDS[0]}")
    of_git("fetch", ROOT, "HEAD")
    sources = of_git("ls-files", "src").split()
    of_git("update-index", "--no-assume-unchanged", *sources)
    of_git("reset", "--hard", "FETCH_HEAD")
    of = f"{asked.draw} {asked.seed} {of_git('rev-parse', 'HEAD:src')}"
    if not OF.exists() or OF.read_text() != of:                     # other places
        for folder in (TRACED, NOTES):
            shutil.rmtree(folder, ignore_errors=True)
        OF.write_text(of)
    of_git("update-index", "--assume-unchanged", *of_git("ls-files", "src").split())    # a fault makes no other version of the program
    tools, unit = [f"build/quick/{tool}" for tool in TOOLS], "build/quick/test_text"      # which makes what unit tests share
    if not (build("program", *tools, unit) and build("dim=3", "program", "build/quick3d/forced_step")):
        sys.exit("the copy in build/mutants/tree does not build")
    shutil.rmtree(CLEAN, ignore_errors=True)
    for name in ("quick", "quick3d"):
        shutil.copytree(TREE / "build" / name, CLEAN / name)


def restore(file, before, times, began):
    """Take a fault back, with what was compiled of it."""
    file.write_text(before)
    for name in ("quick", "quick3d"):
        for made in (TREE / "build" / name).iterdir():
            if made.stat().st_mtime >= began - 1 and made.is_file() and not (made.name.startswith("test_") and made.suffix == ".o"):
                kept = CLEAN / name / made.name
                made.unlink()                    # it may run
                if kept.exists():
                    shutil.copy2(kept, made)
    os.utime(file, times)                        # at last: what has failed before is compiled anew


def judge(fault, place, tests):
    """Build and test one fault, drawn at a place: its row of the ledger."""
    path, number, kind, new = fault
    file = TREE / path
    before, times, began = file.read_text(), (file.stat().st_atime, file.stat().st_mtime), time.time()
    chosen, name = tests.chosen(path, place), Path(path).stem
    of_plane, of_solids = ([item for item in chosen if bool(re.search("solid|front", item.path.stem)) == is_solid] for is_solid in (False, True))
    lines = before.splitlines()
    row = {"file": path, "line": number + 1, "kind": kind, "old": lines[number].strip(), "new": new.strip(), "start": began, "tests": len(chosen)}
    lines[number] = new
    try:
        file.write_text("\n".join(lines) + "\n")
        if not build(*programs_of(of_plane, "quick")) and not build("dim=3", "program"):
            return row | {"end": "does not compile"}
        row["build"] = round(time.time() - began)
        found = tests.found_by(of_plane)
        found = found or next((f"unit {unit}" for unit in units_of(name) if build(f"build/quick/{unit}") and fails(f"build/quick/{unit}")), None)
        if not found and build("dim=3", *programs_of(of_solids, "quick3d")):
            found = tests.found_by(of_solids)
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
    for place, fault in list(enumerate(draw(tests.asked.draw, tests.asked.seed, TREE)))[first:last]:
        if (fault[0], fault[1] + 1, fault[3].strip()) in known or time.time() > began + 60 * tests.asked.minutes:
            continue
        row = judge(fault, place, tests)
        row["seconds"] = round(time.time() - row.pop("start"))
        tests.rows.append(row)
        with LEDGER.open("a") as file:
            file.write(json.dumps(row) + "\n")
        print({key: row[key] for key in ("file", "line", "kind", "end", "seconds")}, flush=True)


def show(rows):
    """Print the table and the survivors; the percentage that is killed of those that compile."""
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
    return 100 * killed / max(counted, 1)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--draw", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", default=":", help="places among the drawn ones, as A:B")
    parser.add_argument("--whole", action="store_true")
    parser.add_argument("--minutes", type=float, default=1e9, help="begin no other fault after this time")
    parser.add_argument("--show", action="store_true")
    parser.add_argument("--least", type=float, metavar="P", help="with --show: of the drawn ones only; exit code 1 where some have not run, or less than P percent are killed")
    asked = parser.parse_args()
    rows = [json.loads(line) for line in LEDGER.read_text().splitlines()] if LEDGER.exists() else []
    if not asked.show:
        prepare(asked)
        os.chdir(TREE)
        os.environ.update({"HAMPM": f"build/{BUILDS[0]}", "HAMPM3D": f"build/{BUILDS[1]}"})
        whole = ["tests", "--ignore=tests/setup", "--ignore=tests/unit"] if asked.whole else [f"tests/{folder}" for folder in FOLDERS]
        pytest.main(["-q", "-s", "-p", "no:cacheprovider", "-p", "no:xdist", f"--basetemp={FOLDER}/tmp", "-m", "not verify", *whole], plugins=[Tests(asked, rows)])
    elif asked.least is not None:
        places = {(fault[0], fault[1] + 1, fault[3].strip()) for fault in draw(asked.draw, asked.seed, TREE)}
        rows = [row for row in rows if (row["file"], row["line"], row["new"]) in places]
        if len(rows) < len(places):
            sys.exit(f"{len(places) - len(rows)} of {len(places)} faults have not run")
    percent = show(rows)
    if asked.least is not None and percent < asked.least:
        sys.exit(f"{percent:.1f} % killed, {asked.least:g} % asked")


if __name__ == "__main__":
    main()
