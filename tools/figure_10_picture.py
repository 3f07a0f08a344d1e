"""Draw docs/images/fig10.png: G(t) of the four methods by (14) and by J, and what the paper's text says of its curves at rest.

    .venv/bin/python tools/figure_10_picture.py docs/evidence/figure_10_paper.csv CASE.h5 ... --output FILE

The text gives the size of an error in whole percent, and not its sign: a mark above and one below the beam on an elastic foundation, with bars
of half a percent. A case of the table is the name of a result file, whose colour its marks have.
"""

import argparse
import csv
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "postprocess"))
import plot_g  # noqa: E402
from history import History  # noqa: E402
from pictures import COLOURS, STYLE, plt, save  # noqa: E402


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("paper", type=Path, help="table of what the paper says")
    parser.add_argument("results", type=Path, nargs="+", metavar="CASE.h5")
    parser.add_argument("--output", type=Path, required=True, metavar="FILE")
    arguments = parser.parse_args()
    with open(arguments.paper, newline="", encoding="utf-8") as file:
        rows = {row["case"]: row for row in csv.DictReader(file)}
    options = plot_g.parse([*map(str, arguments.results), "--estimator", "stress_closure_I", "--estimator", "domain_I", "--converged", "1.28737",
                            "--title", "Fig. 10 of Tan & Nairn, by (14) and by J; diamonds: at rest, by its text"])
    with plt.rc_context(STYLE):
        figure = plot_g.draw([History(path) for path in arguments.results], options)
        mark(figure.axes[0], [(rows[path.stem], colour) for path, colour in zip(arguments.results, COLOURS)])
        save(figure, arguments.output, 150)


def mark(axes, rows):
    """Marks of the paper's values at rest beside each other near the right edge."""
    left, right = axes.get_xlim()
    for k, (row, colour) in enumerate(rows):
        place, below, above = left + (right - left) * (0.80 + 0.05 * k), float(row["g_if_below"]), float(row["g_if_above"])
        bar = 0.01 * float(row["accuracy_percent"]) * (below + above) / 2
        axes.errorbar([place, place], [below, above], bar, color=colour, linestyle=":", linewidth=0.8, marker="D", markersize=3, capsize=2, zorder=4)
        axes.annotate(f"{row['error_percent']} %", (place, above), xytext=(0, 5), textcoords="offset points", ha="center", fontsize=7, color=colour)


if __name__ == "__main__":
    main()
