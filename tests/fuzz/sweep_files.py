#!/usr/bin/env python3
"""Read sweep files that are changed at random: each is a sweep, or every mistake in it is said in one line of its own.

    .venv/bin/python tests/fuzz/sweep_files.py --cases 100000 --seed 1
"""

import argparse
import random
import re
import sys
import tempfile
from collections import Counter
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "python/src"))

from hampm.batch.declaration import Reader, namelist_keys  # noqa: E402
from hampm.errors import ResultError  # noqa: E402
from hampm.program import program_of_scripts  # noqa: E402

BASE = """\
namelist: scene.nml
output: out
product:
  grid.cell, grid.cells:
    - [5e-3, [20, 3]]
    - [2.5e-3, [40, 5]]
  method.mass: [lumped, consistent]
cases:
  - {method.scheme: usl, method.courant: 0.05}
  - {$n: 3, run.end_time: "${n * 1e-3}"}
set:
  method.frame: total
  output.history_interval: ${2 * 1e-5}
columns: [J, "G_*"]
derived:
  top: max J
  when: first time J > ${1e-3 + 2}
mean: 2e-4
threads: 1
memory: 500
runtime: 60
checkpoint: 600
"""
PIECES = ["", "[]", "{}", "null", "~", "true", "nan", ".inf", "1e999", "-1", "0", "1e-400", "9" * 400, "'", '"', "[", "{", "- ", ": ", "&a ",
          "*a", "&a [*a]", "<<: *a", "!!python/object:os.system ", "!!binary aGk=", '"\\0"', '"\\u202e"', "\t", "\r", "\x07", "\ufeff", "%YAML 9",
          "---\n", "...\n", "? ", "|\n", ">\n", "#", "../..", "/", "é", "\U0001f600", "[" * 3000, "{a: " * 1500, "grid", "grid.", ".cell",
          "grid.cell", "body(0).velocity", "output.file", "[1, [2, 3]]", "{a: 1}", "x" * 5000, "[" + "1, " * 3000 + "1]", "product", "output: 3", "${", "}", "${n}", "${9**9**9**9}", "$n", "${()", "max J",
          "  mass.x: 1\n", "J\nK", "\x00"]


def changed(source):
    """A sweep file with one to four changes."""
    text = BASE
    for _ in range(source.randint(1, 4)):
        kind, at = source.randrange(6), source.randrange(len(text) + 1)
        lines = text.splitlines(keepends=True) or [""]
        line = source.randrange(len(lines))
        if kind == 0:
            text = text[:at] + source.choice(PIECES) + text[at:]
        elif kind == 1:
            text = text[:at] + text[at + source.randint(1, 20):]
        elif kind == 2:
            lines.insert(source.randrange(len(lines) + 1), lines[line])
            text = "".join(lines)
        elif kind == 3:
            text = "".join(lines[:line] + lines[line + 1:])
        elif kind == 4:
            lines[line] = re.sub(r":.*", lambda _: ": " + source.choice(PIECES), lines[line])
            text = "".join(lines)
        else:
            words = re.findall(r"[\w.]+", text) or ["a"]
            text = text.replace(source.choice(words), source.choice(PIECES), 1)
    return text.encode("utf-8", "surrogatepass")


def try_sweeps(folder, cases, seed, groups):
    """How many were read and refused, and what went wrong with which."""
    folder, source, ends, findings = Path(folder), random.Random(seed), Counter(), []
    (folder / "scene.nml").write_text("&run end_time = 1.0 /\n")
    path = folder / "sweep.yaml"
    for _ in range(cases):
        text = changed(source)
        path.write_bytes(text)
        try:
            sweep = Reader(path, groups).sweep()
            ends["read"] += 1
            if any("/" in name or name in (".", "..") or len(name) > 200 for name in sweep.cases):
                findings.append((text, "a case whose name is none of a folder"))
        except ResultError as error:
            ends["refused"] += 1
            if not all(re.match(rf"{re.escape(str(path))}(:\d+)?: .", line) and line.isprintable() for line in str(error).split("\n")):
                findings.append((text, str(error)))
        except Exception as error:
            findings.append((text, f"{type(error).__name__}: {error}"))
    return ends, findings


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cases", type=int, default=1000, metavar="N")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--program", type=Path, default=program_of_scripts())
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        ends, findings = try_sweeps(folder, options.cases, options.seed, namelist_keys(options.program))
    for text, what in findings[:10]:
        print(f"{what[:300]!r}\n{text[:600]!r}\n")
    print(f"{sum(ends.values()) + len(findings)} sweep files: {ends['read']} read, {ends['refused']} refused, {len(findings)} findings")
    return 1 if findings else 0


if __name__ == "__main__":
    sys.exit(main())
