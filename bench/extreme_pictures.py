"""The pictures of docs/evidence/stability.md, from the cells of the atlas of extremes."""

import sys

import numpy as np
from mass_matrices import KINDS, SCHEMES
from tables import ROOT

sys.path.insert(0, str(ROOT / "postprocess"))

from pictures import COLOURS as PALETTE  # noqa: E402
from pictures import STYLE, plt  # noqa: E402

COLOURS = {"stable": PALETTE[0], "warned": PALETTE[4], "refused": "0.75", "stopped": PALETTE[3], "defect": "black"}
MARKS = dict(zip(SCHEMES, "sodv"))


def draw(results, folder):
    """Draw what there are results for."""
    with plt.rc_context(STYLE):
        if "courant" in results:
            limits(results["courant"], folder / "stability_limit.png")
            outcomes(results["courant"], folder / "stability_map.png")
        errors(results, folder / "stability_errors.png")


def save(figure, path):
    figure.savefig(path, dpi=110, bbox_inches="tight")
    plt.close(figure)


def limits(cells, path):
    """Measured limits of the time step beside theory."""
    figure, axes = plt.subplots(figsize=(7, 3.6))
    for k, scheme in enumerate(SCHEMES):
        for frame, filled in (("total", True), ("updated", False)):
            found = {c.name: [float(x) for x in c.message.split(", ")] for c in cells if c.name.startswith("limit")}
            x = np.arange(len(KINDS)) + 0.17 * (k - 1.5) + (0.04 if filled else -0.04)
            y = [found[f"limit, {kind}, {scheme}, {frame}"] for kind in KINDS]
            axes.plot(x, [m for m, _ in y], MARKS[scheme], color=PALETTE[k], mfc=None if filled else "none", ms=6,
                      label=f"{scheme}, {frame}")
            axes.hlines([m / ratio for m, ratio in y], x - 0.07, x + 0.07, color="0.2", lw=1.2, zorder=0)
    axes.set(xticks=range(len(KINDS)), xticklabels=KINDS, ylabel="largest stable Courant number\n(dilatational wave)", ylim=(0, None))
    axes.legend(fontsize=7, ncol=2, title="lines: theory", title_fontsize=7)
    save(figure, path)


def outcomes(cells, path):
    """What became of each run over its courant number."""
    rows = [(kind, scheme) for kind in KINDS for scheme in SCHEMES]
    figure, axes = plt.subplots(figsize=(7, 5))
    for cell in cells:
        kind, scheme, frame, number = ([*cell.name.split(", "), ""])[:4]
        if kind == "limit" or frame != "updated":
            continue
        axes.plot(float(number), rows.index((kind, scheme)), "s", color=COLOURS[cell.outcome], ms=6)
    for kind, scheme in rows:
        limit = next(c for c in cells if c.name == f"limit, {kind}, {scheme}, updated")
        axes.plot([float(limit.message.split(",")[0])] * 2, np.array([-0.5, 0.5]) + rows.index((kind, scheme)), "k", lw=1.5)
    axes.set(xscale="log", yticks=range(len(rows)), xlabel="Courant number (dilatational wave)", ylim=(len(rows) - 0.5, -0.5))
    axes.set_yticklabels([", ".join(row) for row in rows], fontsize=7)
    for outcome in ("stable", "warned", "stopped", "refused"):
        axes.plot([], [], "s", color=COLOURS[outcome], label=outcome)
    axes.plot([], [], "k", lw=1.5, label="limit of a bar of 20 cells")
    axes.legend(fontsize=7, loc="lower center", bbox_to_anchor=(0.5, 1), ncol=5)
    save(figure, path)


def errors(results, path):
    """How near to its bound each stable or warned cell is, by part, and how many ended otherwise."""
    parts = list(results)
    figure, axes = plt.subplots(figsize=(7, 4))
    place = np.random.default_rng(1)
    for k, part in enumerate(parts):
        for outcome in ("stable", "warned", "defect"):
            y = [max(c.value / c.bound, 1e-12) for c in results[part] if c.outcome == outcome and c.value is not None]
            y = [min(v, 1e3) for v in y]
            axes.plot(k + place.uniform(-0.3, 0.3, len(y)), y, ".", color=COLOURS[outcome], ms=4)
    axes.axhline(1, color="0.2", lw=1)
    axes.set(yscale="log", ylabel="error over the largest that counts as stable [–]", xticks=range(len(parts)), ylim=(5e-13, 2e3))
    axes.set_xticklabels(parts, rotation=30, fontsize=8)
    for outcome in ("stable", "warned", "defect"):
        axes.plot([], [], ".", color=COLOURS[outcome], label=outcome)
    axes.legend(fontsize=7, loc="lower center", bbox_to_anchor=(0.5, 1), ncol=3)
    save(figure, path)
