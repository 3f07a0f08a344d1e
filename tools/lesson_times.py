"""How long the lessons take: reading, at 200 words a minute, and their commands, in seconds of the processor; as the table of docs/lessons/README.md.

    .venv/bin/python tools/lesson_times.py [--run] [LESSON ...]

With --run the commands of each lesson (0 to 22, default: all) are run with one thread, in the folder of this repository; without, the times
stay those of the table. What a lesson says of its time stands beside them: it has the exercises in it, which nobody has timed.
"""

import argparse
import os
import re
import resource
import subprocess
import sys
from pathlib import Path

from notebooks import LESSONS, ROOT, SHELL, commands_of

PAGE = LESSONS / "README.md"
WORDS_A_MINUTE = 200
TABLE = re.compile(r"(<!-- source: tools/lesson_times.py -->\n)((?:\|.*\n)+)")
HEAD = "| lesson | words | reading [min] | commands [s] | with exercises |\n|---|---|---|---|---|\n"


def pages():
    """Number -> page of each lesson."""
    found = {int(path.name.partition("_")[0]): path for path in LESSONS.glob("[0-9]*_*.md")}
    return dict(sorted(found.items()))


def words(page):
    """Of the text that is read: without commands, formulas, tables and answers that are folded."""
    text = re.sub(r"<details>.*?</details>|^```.*?^```|\$`.*?`\$|^\|[^\n]*$", " ", page.read_text(), flags=re.DOTALL | re.MULTILINE)
    return len(re.findall(r"\w+", text))


def said(page):
    """What the lesson says of its time."""
    return re.search(r"\*\*Time\*\*:\s+(.*?)\.", page.read_text(), re.DOTALL)[1].replace("\n", " ")


def seconds(page):
    """Processor time of all commands."""
    commands = [command for block in SHELL.findall(page.read_text()) for command in commands_of(block)]
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    for command in commands:
        wanted = re.search(r" +# exit code (\d+)$", command)
        done = subprocess.run(command, shell=True, cwd=ROOT, capture_output=True, text=True, env=os.environ | {"OMP_NUM_THREADS": "1"})
        if done.returncode != (int(wanted[1]) if wanted else 0):
            sys.exit(f"{page.name}: {command}\n{done.stderr}")
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def measured():
    """Number -> seconds as the table has them."""
    rows = TABLE.search(PAGE.read_text())
    return {int(row[0]): row[1] for row in re.findall(r"^\| (\d+) \|.*\| ([\d.]+) \| [^|]* \|$", rows[2] if rows else "", re.MULTILINE)}


def table(times):
    """The rows of all lessons."""
    return HEAD + "".join(f"| {number} | {words(page)} | {round(words(page) / WORDS_A_MINUTE)} | {times[number]} | {said(page)} |\n"
                          for number, page in pages().items() if number in times)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("lessons", nargs="*", type=int, metavar="LESSON")
    parser.add_argument("--run", action="store_true")
    options = parser.parse_args()
    times = measured()
    for number, page in pages().items():
        if options.run and (number in options.lessons or not options.lessons):
            times[number] = f"{seconds(page):.0f}"
            print(f"{page.stem}: {times[number]} s", file=sys.stderr, flush=True)
            PAGE.write_text(TABLE.sub(lambda match: match[1] + table(times), PAGE.read_text()))
    print(table(times), end="")


if __name__ == "__main__":
    main()
