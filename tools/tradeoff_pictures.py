"""Draw the pictures of docs/evidence/tradeoff.md from the tables beside it: the front, and the cheapest settings of five families.

    .venv/bin/python tools/tradeoff_pictures.py docs/evidence --output DIR

The folder has tradeoff_front.csv and tradeoff_advice.csv.

A picture a study, DIR/static.png and so on. Left the sustained error over the processor time, right over the particles; black and stepped
what no other setting beats in both. A family has one colour in all pictures.
"""

import argparse
import csv
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "postprocess"))
from pareto import front, number, size  # noqa: E402
from pictures import COLOURS, STYLE, name_curves, plt, save  # noqa: E402

FAMILIES = dict(zip(["uniform", "at rest", "quadratic cells", "Richardson, uniform", "Richardson, refined", "refined at the tip", "implicit steps"],
                    COLOURS))
MOST = 5
MARKERS = dict(zip(FAMILIES, "os^Dv*P"))
COSTS = {"cpu_seconds": "processor time [s]", "particles": "particles"}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("tables", type=Path, help="folder of the tables")
    parser.add_argument("--output", type=Path, required=True, metavar="DIR", help="folder of the pictures")
    arguments = parser.parse_args()
    arguments.output.mkdir(parents=True, exist_ok=True)
    best, advice = (arguments.tables / f"tradeoff_{name}.csv" for name in ("front", "advice"))
    with open(best, newline="", encoding="utf-8") as file:
        studies = dict.fromkeys(row["study"] for row in csv.DictReader(file))
    for study in studies:
        output = arguments.output / f"{study}.png"
        with plt.rc_context(STYLE):
            save(draw(rows_of(best, study), rows_of(advice, study)), output, 110)
        print(output)


def rows_of(path, study):
    """The rows of one study in a table, without those that nothing was found for."""
    with open(path, newline="", encoding="utf-8") as file:
        return [row for row in csv.DictReader(file) if row["study"] == study and row["setting"]]


def draw(best, advice):
    """The figure: the front and the families over both costs."""
    families = [name for name in FAMILIES if any(row["group"] == name for row in advice)][:MOST]
    figure, axes = plt.subplots(1, 2, figsize=(11.0, 4.0), sharey=True, layout="constrained")
    for panel, (cost, words) in zip(axes, COSTS.items()):
        for family in families:
            rows = front([row for row in advice if row["group"] == family], cost, "sustained_percent")
            panel.plot([number(row, cost) for row in rows], [size(row, "sustained_percent") for row in rows], marker=MARKERS[family], markersize=5,
                       color=FAMILIES[family], linewidth=1.0, drawstyle="steps-post", label=family)
        rows = [row for row in front(best + advice, cost, "sustained_percent") if size(row, "sustained_percent") > 0]
        panel.step([number(row, cost) for row in rows], [size(row, "sustained_percent") for row in rows], where="post", color="0.15", linewidth=1.2,
                   zorder=1, label="front of all settings")
        panel.set(xscale="log", yscale="log", xlabel=words)
        panel.yaxis.set_major_formatter("{x:g}")
    axes[0].set_ylabel("sustained error [%]")
    name_curves(figure, axes)
    return figure


if __name__ == "__main__":
    main()
