#!/usr/bin/env python3
"""Whether estimated errors cover the true ones: random cracked specimens of many kinds, each with a reference. Writes every column of every
specimen (estimates_<label>.csv), and by kind and by column how many are covered and how large the estimate is over the error. References are kept
in references.json beside the tables. A program of before, with the references of another one:

    LABEL=before REFERENCE=build/release/hampm bench/estimate_coverage.py --program old/hampm --number 16
"""

import csv
import json
import os
import re
import tempfile
from math import sqrt
from statistics import median

from estimate_specimens import KINDS, make
from program_runs import Program
from tables import command_line, write

PART_OF_LARGEST = 0.05     # of a mode, below which its sharpness is not asked: there is next to nothing of it
FIELDS = ["kind", "number", "column", "value", "estimate", "truth", "doubt", "size"]


def run(program, text):
    """The last values of the columns of a scene, or the reason why there are none; no run takes more than a minute of processor time."""
    with tempfile.TemporaryDirectory() as folder:
        done = Program(program, folder)(text, words=("--time-limit", 60), codes=range(256))
        if done.code:
            return f"exit {done.code}: " + " ".join(done.message.split())[:300]
        return {name: float(value) for name, value in done.last.items()}


def reference(program, specimen, kept):
    """K_I, K_II and J at each tip, and how far each may be off; kept in a file, as they do not depend on what is measured."""
    key = json.dumps([specimen.truths, specimen.factors, specimen.modulus])
    if key not in kept:
        found = [run(program, text) for text in specimen.truths]
        kept[key] = next((f for f in found if isinstance(f, str)), None) or [tips(f, specimen) for f in found]
    return kept[key]


def tips(columns, specimen):
    """By tip: its values."""
    found = []
    for suffix in [""] + [f"_tip{n}" for n in range(2, 9)]:
        if f"K_I{suffix}" not in columns:
            break
        k = [columns.get(f"K_{mode}{suffix}", 0.0) * factor for mode, factor in zip(("I", "II"), specimen.factors)]
        if specimen.modulus:
            by_k = sum(v**2 for v in k) / specimen.modulus
            by_j = columns[f"J{suffix}"] * specimen.truth_modulus / specimen.modulus if specimen.factors == (1.0, 1.0) else by_k
            parts = [v**2 / specimen.modulus for v in k]
        else:
            by_k = columns[f"G{suffix}"]
            by_j = columns[f"J{suffix}"]
            parts = [abs(columns.get(f"G_domain_{mode}{suffix}", 0.0)) for mode in ("I", "II")]
        found.append({"K": k, "J": by_j, "G": by_k, "parts": parts})
    return found


def compare(specimen, columns, truths):
    """Rows of all columns that have an estimate: value, estimate, truth, and how far the latter may be off."""
    rows = []
    for number, (coarse, fine) in enumerate(zip(*truths)):
        suffix = "" if number == 0 else f"_tip{number + 1}"
        size_k = sqrt(sum(v**2 for v in fine["K"]))
        known = {"J": (fine["J"], coarse["J"], fine["J"]), "G": (fine["J"], coarse["J"], fine["J"])}
        for mode, name in enumerate(("I", "II")):
            known[f"K_{name}"] = (fine["K"][mode], coarse["K"][mode], size_k)
            for estimator in ("domain", "vcct"):
                known[f"G_{estimator}_{name}"] = (fine["parts"][mode], coarse["parts"][mode], fine["J"])
        for column, (value, other, size) in known.items():
            if column + suffix not in columns or f"{column}_error{suffix}" not in columns:
                continue
            off = abs(fine["J"] - fine["G"]) / fine["J"] * (0.5 if column[0] == "K" else 1)
            doubt = abs(value - other) + (specimen.doubt + off) * size
            found = columns[column + suffix]
            if column[:2] == "G_":
                found = abs(found)
            rows.append([specimen.kind, specimen.number, column + suffix, found, columns[f"{column}_error{suffix}"], value, doubt, size])
    return rows


def errors(row):
    """The true error of a row, less what the reference may be off by."""
    return abs(row["value"] - row["truth"])


def summary(rows, by):
    """Covered, median of estimate over error, and of the error, for each group of rows."""
    groups = {}
    for row in rows:
        groups.setdefault(by(row), []).append(row)
    for name, group in groups.items():
        there = [r for r in group if r["estimate"] == r["estimate"]]
        covered = [errors(r) <= r["estimate"] + r["doubt"] for r in there]
        sharp = [r["estimate"] / max(errors(r), 1e-12 * r["size"]) for r in there if abs(r["truth"]) > PART_OF_LARGEST * r["size"]]
        yield name, len(group), len(there), 100 * sum(covered) / max(len(there), 1), median(sharp) if sharp else float("nan"), \
            100 * median(errors(r) / r["size"] for r in group)


def read(path):
    """The rows of a table of specimens, with numbers for numbers."""
    with open(path, newline="") as file:
        return [{name: value if name in ("kind", "column") else float(value) for name, value in row.items()} for row in csv.DictReader(file)]


def column_of(row):
    return re.sub(r"_tip\d+$", "", row["column"])


def tables(label, rows, folder):
    head = ["columns", "with an estimate", "covered [%]", "median estimate/error", "median error [%]"]
    for name, by in (("kind", lambda r: r["kind"]), ("column", column_of), ("kind_and_column", lambda r: f"{r['kind']}, {column_of(r)}")):
        write([[name, *head]] + [[key, n, there, f"{covered:.0f}", f"{sharp:.1f}", f"{error:.2f}"]
                                 for key, n, there, covered, sharp, error in summary(rows, by)], f"estimates_{label}_by_{name}", folder)


def main():
    arguments = command_line(__doc__, list(KINDS), "results/estimates", number=(16, "specimens of each kind"),
                             first=(0, "the number of the first"))
    label = os.environ.get("LABEL", "after")
    memory = arguments.output / "references.json"
    kept = json.loads(memory.read_text()) if memory.exists() else {}
    truth_program = os.environ.get("REFERENCE", str(arguments.program.resolve()))
    path = arguments.output / f"estimates_{label}.csv"
    rows = []
    for kind in arguments.part:
        for number in range(arguments.first, arguments.first + arguments.number):
            specimen = make(kind, number)
            truths = reference(truth_program, specimen, kept)
            if isinstance(truths, str):
                print(f"{specimen.name}: no reference: {truths}", flush=True)
                continue
            memory.write_text(json.dumps(kept))
            columns = run(str(arguments.program.resolve()), specimen.scene)
            if isinstance(columns, str):
                print(f"{specimen.name}: no result: {columns}", flush=True)
                continue
            rows += compare(specimen, columns, truths)
            with open(path, "w", newline="") as file:
                csv.writer(file).writerows([FIELDS] + rows)
    tables(label, read(path), arguments.output)


if __name__ == "__main__":
    main()
