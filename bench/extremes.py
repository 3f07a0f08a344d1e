"""What the program does at the extremes: a matrix of small runs, each of which has to be stable, refused or stopped.

    courant    schemes, mass matrices and frames from courant 0.05 to past the limit, which is found by bisection
    poisson    Poisson's ratio up to 0.4999
    contrast   two bodies whose stiffnesses or densities differ by up to 1e6
    points     1 to 25 particles a cell
    position   bodies anywhere in their cells
    levels     refinement by up to 12 levels
    damping    none to far over-critical
    strain     strains from 1e-90 to 0.5
    turn       rotations by full turns
    units      one scene in units from nanometres to kilometres, microseconds to years
    small      one element, one particle, one body in an empty lattice
    long       ten million steps
    release    a loaded body that is let go
    rest       equilibrium: Poisson's ratio, strain, position, contrast, and what has none
    paths      cracks that ignore the grid: places, shapes, methods, materials, speeds, loads and friction
    shapes     polygons at any angle and place, strips of a tenth of a cell, sharp wedges
    meeting    bodies that fly into each other: contrast, speed, gap, contact
    growing    cracks that grow: toughness, speed, increment

A run that ends with exit code 0 has a number with a bound from theory. Where the number is beyond it and the program has not
warned, the cell is a defect; so is any other end than exit code 0, 2 or 3 with a cause. With a defect that is not known (KNOWN) the
script ends with 1.

Run by `make extremes`, or for some parts: .venv/bin/python bench/extremes.py strain turn --output results/extremes
"""

import csv
import re
import sys
from collections import Counter
from pathlib import Path

import extreme_bodies
import extreme_scenes
from extreme_paths import paths
from extreme_pictures import draw
from extreme_scenes import Cell, Runner
from tables import ROOT, command_line, rewrite

DOCUMENT = ROOT / "docs/evidence/stability.md"
PARTS = extreme_scenes.PARTS | {"paths": paths} | extreme_bodies.PARTS
HEAD = ("part", "case", "outcome", "what", "value", "bound", "message")
OUTCOMES = ("stable", "warned", "refused", "stopped", "defect")
SHOWN = 8  # messages on the page
# Defects that are known, with what they are; docs/evidence/stability.md tells of them
KNOWN = {("paths", f"poisson 0.49, 9 a cell, {law}, at rest"): "nearly incompressible cells lock: the error of G is 1.53 times the estimated one, the bound 1.5"
         for law in ("linear_elastic", "neo_hookean")}
ROUNDING = "contact amplifies the rounding of numbers in other units: estimated errors differ by up to 6.4e-9, the bound is 1e-10"
SCALES = ("time 1e-06, mass 1e-20", "time 1, mass 1", "time 3.15576e+07, mass 1e+20")
KNOWN |= {("units", f"crack with contact, consistent mass, length {length}, {scale}"): ROUNDING for length in ("1e-09", "1", "1000") for scale in SCALES
          if (length, scale) != ("1", "time 1, mass 1")}


def row(part, cell):
    return (part, cell.name, cell.outcome, cell.quantity, "" if cell.value is None else f"{cell.value:.2e}",
            "" if cell.bound is None else f"{cell.bound:g}", cell.message)


def save(part, cells, folder):
    """Write the cells of a part as a table, and print its defects."""
    with open(folder / f"{part}.csv", "w", newline="") as file:
        csv.writer(file).writerows([HEAD] + [row(part, cell) for cell in cells])
    count = Counter(cell.outcome for cell in cells)
    print(f"{part:9} {len(cells):4} cells: " + ", ".join(f"{count[o]} {o}" for o in OUTCOMES if count[o]), flush=True)
    for cell in cells:
        if cell.outcome == "defect":
            print("   DEFECT " + ", ".join(filter(None, row(part, cell)[1:]))[:240].replace("\n", " "), flush=True)


def load(part, folder):
    """The cells of a part as they were saved; none where it has not been run."""
    path = folder / f"{part}.csv"
    if not path.exists():
        return []
    with open(path, newline="") as file:
        return [Cell(r["case"], r["outcome"], r["what"], float(r["value"]) if r["value"] else None,
                     float(r["bound"]) if r["bound"] else None, r["message"]) for r in csv.DictReader(file)]


def atlas(results):
    """A row for each part: its cells by outcome, and how much of its bound the worst stable one takes."""
    table = [("part", "cells", *OUTCOMES, "largest part of a bound", "of what")]
    for part, cells in results.items():
        count, worst = Counter(cell.outcome for cell in cells), max(worst_of(cells).values(), key=share, default=None)
        table.append((part, len(cells), *(count[outcome] for outcome in OUTCOMES), *((f"{share(worst):.2g}", worst.quantity) if worst else ("", ""))))
    return table


def quantities(results):
    """A row for each part and quantity: the worst of the stable cells and its bound."""
    return [("part", "quantity", "worst of the stable", "bound")] + [
        (part, quantity, f"{cell.value:.1e}", f"{cell.bound:g}") for part, cells in results.items() for quantity, cell in worst_of(cells).items()]


def worst_of(cells):
    """Quantity -> the stable cell that is nearest to its bound."""
    worst = {}
    for cell in cells:
        if cell.outcome == "stable" and cell.value is not None:
            worst[cell.quantity] = max(worst.get(cell.quantity, cell), cell, key=share)
    return worst


def share(cell):
    """The part of its bound that the value of a cell takes."""
    return cell.value / cell.bound


def messages(results):
    """What the program has said, with an example of the cells that it said it of."""
    found = {}
    for part, cells in results.items():
        for cell in cells:
            if cell.message and cell.outcome in ("warned", "refused", "stopped"):
                found.setdefault((part, cell.outcome, extreme_scenes.kind_of(cell.message)), []).append(cell.name)
    return [("part", "outcome", "cells", "one of them", "message")] + [
        (part, outcome, len(names), names[0], message) for (part, outcome, message), names in found.items()]


def common(table):
    """The messages as the page has them: the beginning of each, with all parts, outcomes and cells that have it; the most frequent ones."""
    begins = {}
    for part, outcome, cells, _, message in table[1:]:
        words = re.sub(r"'[^']*'", "'...'", message.removeprefix("warning: "))
        row = begins.setdefault((outcome, re.split(r"[:;.(] |, (?:in|#)", words)[0]), [[], 0])
        row[0] += [part] * (part not in row[0])
        row[1] += int(cells)
    shown = sorted(begins.items(), key=lambda item: -item[1][1])[:SHOWN]
    return [("outcome", "cells", "parts", "the message begins")] + [
        (outcome, count, ", ".join(parts), f"`{begin}`") for (outcome, begin), (parts, count) in shown]


def markdown(table):
    """A table as lines of Markdown; zeros are left out."""
    lines = ["| " + " | ".join(map(str, row)) + " |" for row in table]
    return [lines[0], "|---" * len(table[0]) + "|", *(re.sub(r"\| 0 (?=\|)", "| ", re.sub(r"\| 0 (?=\|)", "| ", line)) for line in lines[1:])]


def limits(cells):
    """The limits of the time step over theory, by mass matrix, scheme and frame, as Markdown."""
    found = {tuple(cell.name.split(", ")[1:]): cell for cell in cells if cell.name.startswith("limit")}
    lines = ["| mass | frame | " + " | ".join(extreme_scenes.SCHEMES) + " |", "|---|---|" + "---|" * len(extreme_scenes.SCHEMES)]
    for kind in extreme_scenes.KINDS:
        rows = {}  # -> the frames that have it
        for frame in extreme_scenes.FRAMES:
            row = [found.get((kind, scheme, frame)) for scheme in extreme_scenes.SCHEMES]
            rows.setdefault(" | ".join(c.message if c else "" for c in row), []).append(frame)
        lines += [f"| {kind} | {', '.join(frames)} | {row} |" for row, frames in rows.items()]
    return lines


def all_saved(folder):
    """The cells of all parts that have results, by part."""
    return {part: cells for part in PARTS if (cells := load(part, folder))}


def written(tables, page, folder):
    """Write the tables, name -> rows, into CSV files; return the page with those of its tables that follow from them."""
    for name, table in tables.items():
        with open(folder / f"stability_{name}.csv", "w", newline="") as file:
            csv.writer(file, lineterminator="\n").writerows(table)
    page = rewrite("atlas", markdown([row[:-1] for row in tables["atlas"]]), page, DOCUMENT)
    return rewrite("messages", markdown(common(tables["messages"])), page, DOCUMENT)


def document(results):
    """Write the tables of all parts that have results: CSV files beside the document, and what it has of them."""
    page = written({"atlas": atlas(results), "quantities": quantities(results), "messages": messages(results)}, DOCUMENT.read_text(), DOCUMENT.parent)
    if "courant" in results:
        page = rewrite("limits", limits(results["courant"]), page, DOCUMENT)
    DOCUMENT.write_text(page)


def main():
    arguments = command_line(__doc__, list(PARTS), "results/extremes",
                             document=(0, "1: write docs/evidence/stability_*.csv and the tables of docs/evidence/stability.md"),
                             draw=(0, "1: run nothing, draw the pictures of docs/evidence/stability.md from the tables in the folder"))
    if arguments.draw:
        draw(all_saved(arguments.output), arguments.output)
        return
    runner = Runner(arguments.program, arguments.output.resolve())
    defects = []
    for part in arguments.part:
        cells = PARTS[part](runner)
        save(part, cells, arguments.output)
        defects += [(part, cell.name) for cell in cells if cell.outcome == "defect"]
    if arguments.document:
        document(all_saved(arguments.output))
    if new := [defect for defect in defects if defect not in KNOWN]:
        sys.exit(f"{len(new)} of the cells are defects that are not known (KNOWN in {Path(__file__).name})")


if __name__ == "__main__":
    main()
