#!/usr/bin/env python3
"""Draw estimated errors against true ones, from the tables of bench/estimate_coverage.py: one panel for each, before and after.

    tools/estimate_picture.py docs/evidence/estimates_before.csv docs/evidence/estimates_after.csv --output docs/images/estimates.png
"""

import argparse
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT / "postprocess"), str(ROOT / "bench")]

from estimate_coverage import column_of, errors, read, summary  # noqa: E402
from pictures import COLOURS as PALETTE  # noqa: E402
from pictures import STYLE, plt  # noqa: E402

LEAST, MOST = 1e-3, 1e2    # [%]
COLOURS = dict(zip(["J", "G", "K", "G_domain", "G_vcct"], PALETTE))
WORDS = {"J": "$J$", "G": "$G$", "K": "$K$", "G_domain": "$G$, parts of $J$", "G_vcct": "$G$ by VCCT"}


def family(row):
    """The column without its mode."""
    return column_of(row).removesuffix("_II").removesuffix("_I")


def panel(axes, path):
    rows = [row for row in read(path) if row["estimate"] == row["estimate"]]
    for name, colour in COLOURS.items():
        found = [row for row in rows if family(row) == name]
        axes.loglog([max(100 * errors(row) / row["size"], LEAST) for row in found],
                    [min(max(100 * row["estimate"] / row["size"], LEAST), MOST) for row in found], ".",
                    color=colour, markersize=4, label=WORDS[name])
    axes.loglog([LEAST, MOST], [LEAST, MOST], "k-", linewidth=0.8)
    axes.loglog([LEAST, MOST / 3], [3 * LEAST, MOST], "k:", linewidth=0.8)
    _, n, _, covered, sharp, _ = next(summary(rows, lambda row: ""))
    specimens = len({(row["kind"], row["number"]) for row in rows})
    axes.set_title(f"{path.stem.removeprefix('estimates_')}: {covered:.0f} % of {n} values of {specimens} specimens covered,\n"
                   f"median estimate {sharp:.1f} times the error", fontsize=9)
    axes.set(xlim=(LEAST, MOST), ylim=(LEAST, MOST), xlabel="true error [% of both modes together]")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("tables", nargs="+", type=Path)
    parser.add_argument("--output", type=Path, required=True)
    arguments = parser.parse_args()
    with plt.rc_context(STYLE):
        figure, panels = plt.subplots(1, len(arguments.tables), figsize=(9, 4.6), sharey=True, squeeze=False)
        for axes, path in zip(panels[0], arguments.tables):
            panel(axes, path)
        panels[0][0].set_ylabel("estimated error [%]")
        panels[0][-1].legend(fontsize=8, loc="lower right")
        figure.tight_layout()
        figure.savefig(arguments.output, dpi=90)


if __name__ == "__main__":
    main()
