"""Strength of the tests: small faults are drawn at random from all of src/, one at a time, and the tests are asked to find them.

    make mutants                             200 of seed 1; what ran before is kept in build/mutants/ledger.jsonl
    python tests/mutants.py --draw 200 --seed 1 [--only A:B] [--whole] [--minutes M] [--show]

A fault is an operator, a sign, a constant, an index, a condition or a line that is missing, in a statement that computes (no declarations, texts, comments). The tree
is a copy of the last commit in build/mutants with quick builds of both programs; after an edit make compiles what has changed. First the tests run
that the table "you changed X, run Y" of CONTRIBUTING.md names (NEAR), and with --whole all of `make test` where these find nothing. What does not
compile is not counted. Tests that fail without a fault in these builds are left out. --show prints the table and the survivors of what has run."""

import argparse
import collections
import functools
import json
import os
import random
import re
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
FOLDER = ROOT / "build/mutants"
TREE, LEDGER = FOLDER / "tree", FOLDER / "ledger.jsonl"
ENVIRONMENT = os.environ | {"HAMPM": "build/quick/hampm", "HAMPM3D": "build/quick3d/hampm3d", "OMP_WAIT_POLICY": "passive"}

# What to change, and for what, in the part of a statement that is no text
CHANGES = [("sign", r"(?<=[\w)] )\+(?= [\w(])", "-"), ("sign", r"(?<=[\w)] )-(?= [\w(])", "+"), ("operator", r"(?<=[\w)])\*(?=[\w(])", "/"),
           ("operator", r"\bmin\(", "max("), ("operator", r"\bmax\(", "min("), ("condition", r"(?<= )<(?= )", ">="), ("condition", r"(?<= )>(?= )", "<="),
           ("condition", r"(?<= )<=(?= )", "<"), ("condition", r"(?<= )>=(?= )", ">"), ("condition", r"(?<= )==(?= )", "/="), ("condition", r"(?<= )/=(?= )", "=="),
           ("condition", r"\.and\.", ".or."), ("condition", r"\.or\.", ".and."), ("condition", r"\.not\. ?", ""), ("constant", r"\b0\.5_dp\b", "0.25_dp"),
           ("constant", r"\b2\.0_dp\b|\b2\*", "3*"), ("constant", r"(?<![\w.])(\d+)\.(\d+)_dp\b", r"1\1.\2_dp"), ("index", r"(?<=\w )[+-] 1\b(?!\.)", ""),
           ("index", r"(?<=[(, ])([a-z]\w*)(?=\)\s*[=*+,-])", r"\1 + 1")]
STATEMENT = re.compile(r"^\s+(call \w[\w%]*\(.*\)|[a-z][\w%]*(\(.*\))? = .*)$")
NO_CODE = re.compile(r"::|^\s*(!|use\b|implicit|end\b|module|contains|private|public|import|subroutine|function|type\b|interface|class|case|block|select|else\s*$|stop|error)|=>")

# What is asked first of a fault in a folder of src/: tests and, by -k, which of them
NEAR = {"fracture growth": (["tests/program", "tests/regression", "tests/cases"], "growth or front or crack or fatigue or regression or estimate or stress"),
        "element points law time solve problem": (["tests/regression", "tests/program", "tests/cases"],
                                                  "regression or law or implicit or static or solid or physics or contact or rest or step or loads or pressure"),
        "geometry mesh adapt interface": (["tests/cases", "tests/program"], "cut or refin or contact or cohesive or solid or quadratic or travel or interface or checkpoint"),
        "input setup": (["tests/cli", "tests/cases", "tests/program"], ""), "output report": (["tests/output", "tests/cli", "tests/postprocess", "tests/program"],
                                                                                          "output or column or result or checkpoint or probe or stop or told or summary or cli"),
        "": (["tests/cli", "tests/regression", "tests/program"], "cli or regression or checkpoint or stop or run or growth or permission or observer or static")}


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
def all_faults():
    """Faults of all of src/ by kind: (file, number of the line, kind, new line)."""
    by_kind = collections.defaultdict(list)
    for path in sorted((ROOT / "src").rglob("*.f90")):
        is_continued = False
        for number, line in enumerate(path.read_text().splitlines()):
            for kind, new in faults_of(line, is_continued):
                by_kind[kind].append((str(path.relative_to(ROOT)), number, kind, new))
            is_continued = code_of(line).rstrip().endswith("&")
    return by_kind


def draw(count, seed):
    """Faults that are drawn, each kind as often."""
    drawn, by_kind = random.Random(seed), all_faults()
    return [drawn.choice(by_kind[drawn.choice(sorted(by_kind))]) for _ in range(count)]


def inside(*command, **options):
    return subprocess.run(command, cwd=TREE, capture_output=True, text=True, env=ENVIRONMENT, **options)


def build():
    jobs = f"-j{os.cpu_count()}"
    return all(inside("make", "-s", jobs, "build=quick", *more, "program", *(["build/quick/results_driver"] if not more else [])).returncode == 0
               for more in ([], ["dim=3"]))


def failing(tests, words, left_out, *more):
    """Tests that fail, in their order; the first one alone with -x among `more`."""
    choice = ["-k", words] if words else []
    without = [f"--deselect={name}" for name in left_out]
    run = inside(sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-n", str(os.cpu_count()), "-m", "not verify", "--tb=no", *more,
                 *choice, *without, *tests, timeout=3600)
    return re.findall(r"^(?:FAILED|ERROR) (\S+)", run.stdout, re.M)


def near(path):
    folder = Path(path).parts[1] if len(Path(path).parts) > 2 else ""
    return next((of for names, of in NEAR.items() if folder in names.split()), NEAR[""])


def prepare():
    """The copy and its builds, and the tests that fail in it without a fault."""
    if not TREE.exists():
        FOLDER.mkdir(parents=True, exist_ok=True)
        subprocess.run(["git", "clone", "-q", "--no-hardlinks", ROOT, TREE], check=True)
        (TREE / ".venv").symlink_to(ROOT / ".venv")
    if not build():
        sys.exit("the copy in build/mutants/tree does not build")
    known = FOLDER / "fail_without.json"
    if not known.exists():
        known.write_text(json.dumps(failing(sorted({test for tests, _ in NEAR.values() for test in tests}), "", [])))
    return json.loads(known.read_text())


def judge(fault, left_out, is_whole):
    """Build and test one fault: its row of the ledger."""
    path, number, kind, new = fault
    file = TREE / path
    before = file.read_text()
    lines = before.splitlines()
    row = {"file": path, "line": number + 1, "kind": kind, "old": lines[number].strip(), "new": new.strip(), "start": time.time()}
    lines[number] = new
    try:
        file.write_text("\n".join(lines) + "\n")
        if not build():
            return row | {"end": "does not compile"}
        tests, words = near(path)
        found = failing(tests, words, left_out, "-x")
        if not found and is_whole:
            found = failing(["tests"], "", left_out, "-x", "--ignore=tests/setup", "--ignore=tests/unit")
            return row | {"end": "killed by the whole" if found else "survived all", "by": found[:1]}
        return row | {"end": "killed" if found else "survived", "by": found[:1]}
    finally:
        file.write_text(before)


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
        first, last = (int(part) if part else None for part in asked.only.split(":"))
        left_out, began = prepare(), time.time()
        known = {(row["file"], row["line"], row["new"]) for row in rows}
        for fault in draw(asked.draw, asked.seed)[first:last]:
            if (fault[0], fault[1] + 1, fault[3].strip()) in known or time.time() > began + 60 * asked.minutes:
                continue
            rows.append(judge(fault, left_out, asked.whole))
            rows[-1]["seconds"] = round(time.time() - rows[-1].pop("start"))
            with LEDGER.open("a") as file:
                file.write(json.dumps(rows[-1]) + "\n")
            print({key: rows[-1][key] for key in ("file", "line", "kind", "end", "seconds")}, flush=True)
    show(rows)


if __name__ == "__main__":
    main()
