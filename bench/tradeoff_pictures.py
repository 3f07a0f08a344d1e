"""Draw the pictures of docs/evidence/tradeoff.md from the tables that stand there: the front, and the cheapest settings of five families.

    .venv/bin/python bench/tradeoff_pictures.py DOCUMENT.md --output DIR

A picture a study, DIR/static.png and so on. Left the sustained error over the processor time, right over the particles; black and stepped
what no other setting beats in both. A family has one colour in all pictures.
"""

import argparse
import re
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "postprocess"))
from pareto import front, number, size  # noqa: E402
from pictures import COLOURS, STYLE, name_curves, plt, save  # noqa: E402

FAMILIES = dict(zip(["uniform", "at rest", "the paper's third alternative", "batch, uniform", "batch, refined", "refined at the tip", "implicit steps"],
                    COLOURS))
MOST = 5
MARKERS = dict(zip(FAMILIES, "os^Dv*P"))
COSTS = {"CPU s": "processor time [s]", "particles": "particles"}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("document", type=Path, help="page with the tables")
    parser.add_argument("--output", type=Path, required=True, metavar="DIR", help="folder of the pictures")
    arguments = parser.parse_args()
    arguments.output.mkdir(parents=True, exist_ok=True)
    text = arguments.document.read_text(encoding="utf-8")
    for study in re.findall(r"^<!-- (\w+) advice -->$", text, re.MULTILINE):
        output = arguments.output / f"{study}.png"
        with plt.rc_context(STYLE):
            save(draw(rows_of(text, f"{study} front"), rows_of(text, f"{study} advice")), output, 110)
        print(output)


def rows_of(text, name):
    """The rows of the table between the markers of a name, by the heads of their columns, with numbers free of their units and marks."""
    table = re.search(rf"<!-- {name} -->\n(.*?)<!-- end of {name} -->", text, re.DOTALL)[1]
    head, _, *rows = [[cell.strip(" *") for cell in line.strip("| ").split("|")] for line in table.splitlines() if line.startswith("|")]
    found = [dict(zip(head, row)) for row in rows]
    return [row | {"sustained": row["sustained"].removesuffix(" %")} for row in found if row.get("sustained")]


def draw(best, advice):
    """The figure: the front and the families over both costs."""
    families = [name for name in FAMILIES if any(row["group"] == name for row in advice)][:MOST]
    figure, axes = plt.subplots(1, 2, figsize=(11.0, 4.0), sharey=True, layout="constrained")
    for panel, (cost, words) in zip(axes, COSTS.items()):
        for family in families:
            rows = front([row for row in advice if row["group"] == family], cost, "sustained")
            panel.plot([number(row, cost) for row in rows], [size(row, "sustained") for row in rows], marker=MARKERS[family], markersize=5,
                       color=FAMILIES[family], linewidth=1.0, drawstyle="steps-post", label=family)
        rows = [row for row in front(best + advice, cost, "sustained") if size(row, "sustained") > 0]
        panel.step([number(row, cost) for row in rows], [size(row, "sustained") for row in rows], where="post", color="0.15", linewidth=1.2,
                   zorder=1, label="front of all settings")
        panel.set(xscale="log", yscale="log", xlabel=words)
        panel.yaxis.set_major_formatter("{x:g}")
    axes[0].set_ylabel("sustained error [%]")
    name_curves(figure, axes)
    return figure


if __name__ == "__main__":
    main()
