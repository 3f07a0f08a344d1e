"""A second opinion on a static model of the plane: its quantities by the program and by finite elements of NGSolve.

    .venv/bin/python tests/second_opinion/judge.py model.nml
    .venv/bin/python tests/second_opinion/judge.py model.nml --order 5 --levels 4 --program build/quick/hampm

`--levels N` lists by the way what the program finds with cells of 1, 1/2, 1/4, ... of the size. Exit code 1 where a quantity disagrees, 3 where the model is not judged.
"""

import argparse
import sys
from pathlib import Path

from opinion_compare import answers, table
from opinion_program import PROGRAM, finer, run
from opinion_scene import Outside, read

ORDER = 4


def judge(path, order=ORDER, program=PROGRAM):
    """Rows of the table of a model, what is not judged and why, and the runs. Raises `Outside`."""
    scene = read(path)
    first = run(path, program=program)
    if first.code != 0:
        raise Outside(f"the program ends with {first.code}: {first.said.splitlines()[-1] if first.said else ''}")
    second = run(path, *finer(path, 2), program=program)
    found, unknown = answers(scene, order)
    same = not any(hold.turns and hold.snapped for hold in scene.holds)      # pins end at nodes, in finer cells at others
    finer_rows = {2: second.row} if same else {}
    rows = table(found, first.row, finer_rows)
    if any(row.verdict == "disagree" and not row.has_bar for row in rows):      # two sizes may agree by chance
        rows = table(found, first.row, {**finer_rows, 4: run(path, *finer(path, 4), program=program).row})
    return rows, unknown, first, second


def text(rows):
    """The table as text."""
    lines = ["| quantity | hampm | ± error | finite elements | ± error | off over both errors | verdict |", "|---|---|---|---|---|---|---|"]
    for row in rows:
        both = row.program_error + row.own_error
        ratio = abs(row.program - row.own) / both if both else 0.0
        lines.append(f"| {row.column} | {row.program:.6g} | {row.program_error:.2g}{'' if row.has_bar else ' (finer cells)'} | {row.own:.6g} | {row.own_error:.2g} | {ratio:.2f} | {row.verdict} |")
    return "\n".join(lines)


def levels(path, rows, number, program):
    """What the program finds with finer cells."""
    lines = ["| quantity | finite elements | " + " | ".join(f"cells of 1/{2**k}" for k in range(number)) + " |", "|---" * (number + 2) + "|"]
    found = [run(path, *finer(path, 2**k), program=program).row for k in range(number)]
    for row in rows:
        name, _, tip = row.column.partition("_tip")
        error = f"{name}_error" + (f"_tip{tip}" if tip else "")
        lines.append(f"| {row.column} | {row.own:.6g} | " + " | ".join(f"{one.get(row.column, float('nan')):.6g}" + (f" ± {one[error]:.2g}" if error in one else "") for one in found) + " |")
    return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("model", type=Path)
    parser.add_argument("--order", type=int, default=ORDER, metavar="N", help="of the elements; one less tells their error")
    parser.add_argument("--levels", type=int, default=0, metavar="N")
    parser.add_argument("--program", type=Path, default=PROGRAM, metavar="FILE")
    options = parser.parse_args()
    try:
        rows, unknown, first, _ = judge(options.model, options.order, options.program)
    except Outside as reason:
        print(f"not judged: {reason}")
        sys.exit(3)
    print(first.said)
    print(text(rows))
    for what, why in unknown.items():
        print(f"{what}: not judged: {why}")
    if options.levels:
        print(levels(options.model, rows, options.levels, options.program))
    sys.exit(any(row.verdict == "disagree" for row in rows))


if __name__ == "__main__":
    main()
