#!/usr/bin/env python3
"""Draw what runs reach that are asked for an error, and what they cost over the best mesh by hand, from the table of bench/accuracy.py --csv.

    tools/accuracy_picture.py docs/evidence/accuracy_models.csv --output docs/images/accuracy.png
"""

import argparse
import csv
import sys
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "postprocess"))

from pictures import COLOURS, STYLE, plt  # noqa: E402

LEAST = 1e-4    # of errors that are drawn [%]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("table", type=Path)
    parser.add_argument("--output", type=Path, required=True)
    arguments = parser.parse_args()
    with arguments.table.open() as file:
        rows = [{name: float(row[name]) for name in ("seed", "asked", "reached", "told", "seconds", "best")} for row in csv.DictReader(file) if row["code"] != "2"]
    targets = sorted({row["asked"] for row in rows})
    compared = [row for row in rows if row["best"] == row["best"] and row["seed"] == rows[-1]["seed"]]     # of the last seed alone, by the choice of now
    with plt.rc_context(STYLE):
        figure, (left, right) = plt.subplots(1, 2, figsize=(9, 4.2))
        for target, colour in zip(targets, COLOURS):
            of_target = [row for row in rows if row["asked"] == target]
            spread = np.exp(np.linspace(-0.25, 0.25, len(of_target)))
            left.loglog(100 * target * spread, [max(100 * row["reached"], LEAST) for row in of_target], ".", color=colour, markersize=5)
            known = [row for row in compared if row["asked"] == target]
            right.loglog([row["best"] for row in known], [row["seconds"] for row in known], ".", color=colour, markersize=6, label=f"{100 * target:g} % asked")
            left.plot(100 * target * np.exp([-0.35, 0.35]), [100 * target] * 2, "k-", linewidth=0.8)
        left.set(xlabel="error asked [%]", ylabel="error reached [%]", xticks=[100 * target for target in targets], xticklabels=[f"{100 * target:g}" for target in targets])
        left.minorticks_off()
        left.set_title(f"{sum(row['reached'] <= row['asked'] for row in rows)} of {len(rows)} within", fontsize=9)
        ends = np.array([min(row["best"] for row in compared) / 1.5, max(row["seconds"] for row in compared) * 1.5])
        for factor, line in ((1, "k-"), (2, "k--"), (4, "k:")):
            right.loglog(ends, factor * ends, line, linewidth=0.8)
        right.set(xlim=ends, ylim=ends, xlabel="best mesh by hand [s]", ylabel="chosen, with all tries [s]")
        right.set_title(f"cost over the best: median {np.median([row['seconds'] / row['best'] for row in compared]):.2g}, lines of 1, 2 and 4", fontsize=9)
        right.legend(fontsize=8, loc="lower right")
        figure.tight_layout()
        figure.savefig(arguments.output, dpi=90)


if __name__ == "__main__":
    main()
