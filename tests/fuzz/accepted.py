"""How many scenes at random the program accepts as they are drawn, and what refuses the others.

    .venv/bin/python tests/fuzz/accepted.py --cases 900 --seed 900

Scenes are those of `combinations.py` (`drawn_scenes.draw`), of that seed and number, before any repair. One that is refused is counted as refused by what is not built where
all rows of docs/reference/key_rules.md that refuse it say so, else by mechanics or places: geometry, and values against each other. The rows are listed by how many scenes each refuses,
and by how many it, or a set of rows that are not built, refuses alone.
"""

import argparse
import random
import re
import subprocess
import tempfile
from collections import Counter
from pathlib import Path

from combinations import PROGRAM
from drawn_scenes import draw, text_of

NOT_BUILT = " (not built)"


def shortened(text):
    """A message without marks, names, indices and numbers, and without what may be used instead."""
    return re.sub(r"\s+", " ", re.sub(r"`|\(\d+\)|(?<=&material )'[^']*' |(?<=&crack )'[^']*' |(?<=&constraint )'[^']*' |[-+]?\b\d[\d.e+-]*", "", text.partition("; use ")[0])).strip(" .")


def keys_in(text):
    """The groups and keys that a message names, in their order."""
    return re.findall(r"&(\w+) (\w+)", shortened(text))


def not_built(program):
    """Of the rows that are not built the reasons and, where there is none, the keys that they name."""
    page = subprocess.run([program, "--rules"], capture_output=True, text=True, check=True).stdout
    lines = page.replace("\n  ", " ").splitlines()  # a row may have several
    rows = [line.removeprefix("- ").partition(NOT_BUILT) for line in lines if line.startswith("- ") and NOT_BUILT in line]
    return [shortened(rest.removeprefix(": ")) if rest.startswith(":") else keys_in(subject) for subject, _, rest in rows]


def refusals(program, scene, folder):
    """The messages that refuse a model, without its places; none where it is accepted."""
    (folder / "case.nml").write_text(scene if isinstance(scene, str) else text_of(scene))
    run = subprocess.run([program, "--check", "--quiet", "case.nml"], cwd=folder, capture_output=True, text=True)
    if run.returncode == 0:
        return ()
    return tuple(sorted({re.sub(r"^hampm: (case\.nml:\d+: )?", "", line) for line in run.stderr.splitlines() if line.startswith("hampm: ") and "warning" not in line}))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cases", type=int, default=900, metavar="N")
    parser.add_argument("--seed", type=int, default=900, metavar="N")
    parser.add_argument("--program", type=Path, default=PROGRAM, metavar="FILE")
    options = parser.parse_args()
    program = options.program.resolve()
    rows = not_built(program)

    def is_built(message):
        return not any(row in shortened(message) if isinstance(row, str) else row == keys_in(message) for row in rows)

    ends, rows_by_count, alone = Counter(), Counter(), Counter()
    with tempfile.TemporaryDirectory() as folder:
        for number in range(options.cases):
            found = refusals(program, draw(random.Random(f"{options.seed} {number}")), Path(folder))
            texts = sorted({("" if is_built(message) else "not built: ") + shortened(message) for message in found})
            rows_by_count.update(texts)
            only = all(text.startswith("not built") for text in texts)
            ends["accepted" if not found else "refused by what is not built only" if only else "refused by mechanics or places"] += 1
            if found and only:
                alone[tuple(texts)] += 1
    for name, count in ends.most_common():
        print(f"{count:5d}  {name}")
    print("\nscenes that rows, or sets of rows, that are not built refuse alone")
    for texts, count in alone.most_common():
        print(f"{count:5d}  " + "\n       ".join(texts))
    print("\nscenes that a message refuses, with others or alone")
    for text, count in rows_by_count.most_common():
        print(f"{count:5d}  {text}")


if __name__ == "__main__":
    main()
