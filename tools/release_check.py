#!/usr/bin/env python3
"""Run the parts of a release, each of at most 40 minutes, and keep a ledger of them: docs/evidence/release.csv, from which docs/evidence/release.md is written.

    tools/release_check.py [PART ...]    run these parts, or all, without those that have passed on this commit; --again: with these
    tools/release_check.py --list        print the table of the parts
    tools/release_check.py --page        write the page only

The parts are those of tools/release_parts.toml. They run on a clean checkout; a part that changes files of it has these put back, and the changes stay in
build/release_check/PART.diff, beside PART.log. A commit is the last one that changes more than RECORDS, which a release writes itself. What is stopped by hand or
by its limit of time has not passed: the next call runs it again, and goes on with the others. The exit code is 0 where each part has passed on this commit.
"""

import argparse
import csv
import os
import platform
import re
import shutil
import signal
import subprocess
import sys
import time
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
RECORDS = "docs/evidence/release.csv", "docs/evidence/release.md", "VERSION", "CITATION.cff", "codemeta.json", "CHANGELOG.md"
FIELDS = ["part", "commit", "machine", "date", "seconds", "result", "failed"]
BEGIN, END = "<!-- release -->", "<!-- end of release -->"
MOST = 40.0       # minutes of a part
SHOWN = 3         # failures of a part that the ledger names


class Ledger:
    """The parts, and what has come of them, in the checkout `root`."""

    def __init__(self, root, parts):
        self.root, self.parts = root, tomllib.loads(parts.read_text())["part"]
        self.path, self.page, self.logs = root / RECORDS[0], root / RECORDS[1], root / "build/release_check"
        self.commit = self.git("log", "-1", "--format=%h", "--abbrev=12", "--", ".", *(f":!{name}" for name in RECORDS)).strip()
        self.rows = []
        if self.path.exists():
            with open(self.path, newline="") as file:
                self.rows = list(csv.DictReader(file))

    def git(self, *words):
        return subprocess.run(["git", *words], cwd=self.root, capture_output=True, text=True, check=True).stdout

    def changed(self):
        """Files that differ from the commit, or are new, without the ledger and its page."""
        lines = self.git("status", "--porcelain", "--untracked-files=all").splitlines()
        return [line for line in lines if line[3:] not in RECORDS[:2]]

    def last(self, part):
        """The last row of a part on this commit, else of any; None where it has never run."""
        rows = [row for row in self.rows if row["part"] == part]
        return next((row for row in reversed(rows) if row["commit"] == self.commit), rows[-1] if rows else None)

    def has_passed(self, part):
        row = self.last(part)
        return row is not None and row["commit"] == self.commit and row["result"] == "passed"

    def run(self, part):
        """Run the commands of a part, and add its row."""
        date, start = time.strftime("%Y-%m-%d"), time.monotonic()
        missing = [name for name in part.get("needs", []) if not (os.geteuid() == 0 if name == "root" else shutil.which(name, path=path_of_tools()))]
        result, failed = ("not possible here", f"needs {', '.join(missing)}") if missing else self.outcome(part)
        if not missing:
            failed = "; ".join(word for word in (failed, self.put_back(part["name"])) if word)
        self.rows.append({"part": part["name"], "commit": self.commit, "machine": machine(), "date": date, "seconds": f"{time.monotonic() - start:.0f}",
                          "result": result, "failed": failed})
        with open(self.path, "w", newline="") as file:
            writer = csv.DictWriter(file, FIELDS, lineterminator="\n")
            writer.writeheader()
            writer.writerows(self.rows)
        self.write_page()
        print(f"{part['name']}: {result}{': ' * bool(failed)}{failed}", flush=True)
        return result

    def outcome(self, part):
        """The result of the commands, and what has failed."""
        log = self.logs / f"{part['name']}.log"
        log.parent.mkdir(parents=True, exist_ok=True)
        minutes = part.get("minutes", MOST)
        with open(log, "wb") as file:
            process = subprocess.Popen(["sh", "-ec", "\n".join(part["commands"])], cwd=self.root, stdin=subprocess.DEVNULL, stdout=file, stderr=file, start_new_session=True)
            try:
                code = process.wait(60 * minutes)
                return ("failed", failures(log.read_text(errors="replace")) or f"exit code {code}") if code else ("passed", "")
            except subprocess.TimeoutExpired:
                return "stopped", f"not done after {minutes:g} minutes"
            except KeyboardInterrupt:
                return "stopped", "by hand"
            finally:
                end(process)

    def put_back(self, name):
        """Undo what a part has changed in the checkout; which files these were, and which new ones it has left."""
        changed = self.changed()
        files, new = ([line[3:] for line in changed if (line[:2] == "??") == is_new] for is_new in (False, True))
        if files:
            (self.logs / f"{name}.diff").write_text(self.git("diff", "--binary", "HEAD", "--", *files))
            self.git("checkout", "HEAD", "--", *files)
        return "; ".join(f"{words}: {', '.join(names)}" for words, names in (("wrote anew", files), ("left", new)) if names)

    def table(self):
        """Rows of a part each, with the group that it belongs to."""
        for part in self.parts:
            row = self.last(part["name"])
            if row is None:
                yield part["group"], [part["name"], part["what"], "not run", "", ""]
                continue
            result = row["result"] if row["commit"] == self.commit else f"{row['result']}, on another commit"
            yield part["group"], [part["name"], part["what"], result, f"{row['date']}, {row['seconds']} s", row["failed"]]

    def write_page(self):
        rows, lines = list(self.table()), []
        passed = sum(map(self.has_passed, (part["name"] for part in self.parts)))
        lines += ["| commit | parts | passed on it |", "|---|---|---|", f"| `{self.commit}` | {len(rows)} | {passed} |", ""]
        for group in dict.fromkeys(group for group, _ in rows):
            lines += [f"**{group}**", "", "<!-- source: tools/release_check.py -->", "| part | what it runs | result | when | what failed |", "|---|---|---|---|---|"]
            lines += ["| " + " | ".join(str(cell).replace("|", "\\|") for cell in row) + " |" for of, row in rows if of == group] + [""]
        text = self.page.read_text()
        head, _, rest = text.partition(BEGIN)
        self.page.write_text("\n".join([head + BEGIN, *lines[:-1], END + rest.partition(END)[2]]))


def path_of_tools():
    """PATH with the folders of tools that only root uses."""
    return os.pathsep.join([os.environ.get("PATH", ""), "/usr/sbin", "/sbin"])


def end(process):
    """End a process and what it started."""
    try:
        os.killpg(process.pid, signal.SIGTERM)
    except ProcessLookupError:
        return
    for _ in range(50):
        time.sleep(0.1)
        process.poll()
        try:
            os.killpg(process.pid, 0)
        except ProcessLookupError:
            return
    os.killpg(process.pid, signal.SIGKILL)
    process.wait()


def failures(log):
    """What a log says has failed: tests by their names, else its last line."""
    names = list(dict.fromkeys(re.findall(r"^(?:FAILED|ERROR) (\S+)", log, re.MULTILINE)))
    if names:
        return ", ".join(names[:SHOWN]) + (f" and {len(names) - SHOWN} more" if len(names) > SHOWN else "")
    lines = [line.strip() for line in log.splitlines() if line.strip()]
    return lines[-1][:200] if lines else ""


def machine():
    """Processor and system."""
    cpuinfo = Path("/proc/cpuinfo")
    model = re.search(r"model name\s*: (.*)", cpuinfo.read_text()) if cpuinfo.exists() else None
    return f"{model[1] if model else platform.machine()}, {os.cpu_count()} cores"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("part", nargs="*", metavar="PART")
    parser.add_argument("--again", action="store_true", help="run parts that have passed on this commit, too")
    parser.add_argument("--list", action="store_true", help="print the table of the parts")
    parser.add_argument("--page", action="store_true", help="write docs/evidence/release.md only")
    parser.add_argument("--parts", type=Path, metavar="FILE", default=ROOT / "tools/release_parts.toml")
    parser.add_argument("--root", type=Path, metavar="FOLDER", default=ROOT, help="the checkout")
    options = parser.parse_args()
    ledger = Ledger(options.root.resolve(), options.parts)
    signal.signal(signal.SIGTERM, signal.getsignal(signal.SIGINT))   # both end the part that runs
    names = [part["name"] for part in ledger.parts]
    if unknown := sorted({*options.part} - {*names}):
        parser.error(f"no part {', '.join(unknown)}; there are {', '.join(names)}")
    if options.page:
        return ledger.write_page()
    if options.list:
        for _, row in ledger.table():
            print("  ".join(map(str, (row[0], row[2], row[4]))).rstrip())
    else:
        if files := ledger.changed():
            sys.exit("release_check.py: the checkout is not clean:\n" + "\n".join(files[:20]))
        for part in ledger.parts:
            if part["name"] in (options.part or names) and (options.again or not ledger.has_passed(part["name"])):
                if ledger.run(part) == "stopped" and ledger.rows[-1]["failed"].startswith("by hand"):
                    break
    left = [name for name in names if not ledger.has_passed(name)]
    if left:
        sys.exit(f"release_check.py: not passed on {ledger.commit}: {', '.join(left)}")


if __name__ == "__main__":
    main()
