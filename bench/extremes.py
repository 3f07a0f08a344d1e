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
warned, the cell is a defect; so is any other end than exit code 0, 2 or 3 with a cause. With a defect the script ends with 1.

Run by `make extremes`, or for some parts: .venv/bin/python bench/extremes.py strain turn --output results/extremes
"""

import csv
import sys
from collections import Counter

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
    """A line for each part and quantity, as Markdown."""
    lines = ["| part | what is looked at | cells | stable | warned | refused | stopped | defects | worst of the stable | bound |",
             "|---|---|---|---|---|---|---|---|---|---|"]
    for part, cells in results.items():
        count = Counter(cell.outcome for cell in cells)
        worst = {}
        for cell in cells:
            if cell.outcome == "stable" and cell.value is not None:
                worst[cell.quantity] = max(worst.get(cell.quantity, cell), cell, key=lambda c: c.value / c.bound)
        for k, (quantity, cell) in enumerate(worst.items()):
            numbers = [len(cells)] + [count[o] or "" for o in OUTCOMES] if k == 0 else [""] * 6
            lines.append(f"| {part if k == 0 else ''} | {quantity} | " + " | ".join(map(str, numbers)) +
                         f" | {cell.value:.1e} | {cell.bound:g} |")
    return lines


def causes(results):
    """What the program has said, with an example of the cells that it said it of, as Markdown."""
    said = {}
    for part, cells in results.items():
        for cell in cells:
            if cell.message and cell.outcome in ("warned", "refused", "stopped"):
                said.setdefault((part, cell.outcome, extreme_scenes.kind_of(cell.message)), []).append(cell.name)
    lines = ["| part | outcome | cells | of which one | what the program says |", "|---|---|---|---|---|"]
    for (part, outcome, message), names in said.items():
        lines.append(f"| {part} | {outcome} | {len(names)} | {names[0]} | {message} |")
    return lines


def limits(cells):
    """The limits of the time step over theory, by mass matrix, scheme and frame, as Markdown."""
    found = {tuple(cell.name.split(", ")[1:]): cell for cell in cells if cell.name.startswith("limit")}
    lines = ["| mass | frame | " + " | ".join(extreme_scenes.SCHEMES) + " |", "|---|---|" + "---|" * len(extreme_scenes.SCHEMES)]
    for kind in extreme_scenes.KINDS:
        for frame in extreme_scenes.FRAMES:
            row = [found.get((kind, scheme, frame)) for scheme in extreme_scenes.SCHEMES]
            lines.append(f"| {kind} | {frame} | " + " | ".join(c.message if c else "" for c in row) + " |")
    return lines


def all_saved(folder):
    """The cells of all parts that have results, by part."""
    return {part: cells for part in PARTS if (cells := load(part, folder))}


def document(results):
    """Write the tables of all parts that have results into the document."""
    text = DOCUMENT.read_text()
    text = rewrite("atlas", atlas(results), text, DOCUMENT)
    text = rewrite("messages", causes(results), text, DOCUMENT)
    if "courant" in results:
        text = rewrite("limits", limits(results["courant"]), text, DOCUMENT)
    DOCUMENT.write_text(text)


def main():
    arguments = command_line(__doc__, list(PARTS), "results/extremes",
                             document=(0, "1: write the tables of docs/evidence/stability.md"),
                             draw=(0, "1: run nothing, draw the pictures of docs/evidence/stability.md from the tables in the folder"))
    if arguments.draw:
        draw(all_saved(arguments.output), arguments.output)
        return
    runner = Runner(arguments.program, arguments.output.resolve())
    defects = 0
    for part in arguments.part:
        cells = PARTS[part](runner)
        save(part, cells, arguments.output)
        defects += sum(cell.outcome == "defect" for cell in cells)
    if arguments.document:
        document(all_saved(arguments.output))
    if defects:
        sys.exit(f"{defects} of the cells are defects")


if __name__ == "__main__":
    main()
