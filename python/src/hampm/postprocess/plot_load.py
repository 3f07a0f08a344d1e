"""Picture of the load over the displacement of cracks at rest, and the curve on which G is the toughness: a colour for each file.

Load and displacement are those of the `&probe` with quantity 'load_line' that has the larger values, or that --probe names; without one,
the load factor over the opening of the mouth. The curve of the toughness has both, times the root of toughness over G, at the tip where
this is least: at that load the crack would grow. It is drawn of linear elastic models without contact, cohesion, eigenstrains and loads that are held alone.
"""

from __future__ import annotations

import re
from argparse import Namespace
from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from ..arrays import Array
from ..errors import ResultError
from ..history import History
from ..scripts import tell
from ..stored import opened
from ..stored_model import StoredModel
from .growing_tips import growing_tips
from .pictures import COLOURS, name_curves, picture_names, picture_parser, plt, prefixed, wrapped, write

OF_PROBE = re.compile(r"load_displacement_(.*)_([xy])$")


def main(arguments: Sequence[str] | None = None) -> None:
    write(figure, parse(arguments), "_load")


def parse(arguments: Sequence[str] | None) -> Namespace:
    parser = picture_parser(__doc__, "_load")
    parser.add_argument("--probe", metavar="NAME", help="of the load line (default: that with the larger displacement)")
    return parser.parse_args(arguments)


def figure(options: Namespace) -> Figure:
    """The picture that these options ask for."""
    histories = [History(path) for path in options.files]
    columns = [columns_of(history, options.probe) for history in histories]
    if len({tuple(history.units[name] for name in names) for history, names in zip(histories, columns)}) > 1:
        raise ResultError("some files have a load line, and others have none")
    drawn, axes = plt.subplots(figsize=(6.3, 4), layout="constrained")
    labels = []
    for place in (0, 1):
        largest = max(np.abs(history.columns[names[place]]).max() for history, names in zip(histories, columns))
        name, unit = columns[0][place], histories[0].units[columns[0][place]]
        factor, prefixed_unit = prefixed(largest, unit)
        words = name.replace("_", " ") if name == "load_factor" else re.split(", |; ", histories[0].long_names[name])[0]
        labels.append((factor, wrapped(words, "\u2013" if unit == "1" else prefixed_unit)))
    for history, names, name, colour in zip(histories, columns, picture_names(histories), COLOURS):
        x, y = (factor * history.columns[column] for column, (factor, _) in zip(names, labels))
        axes.plot(x, y, color=colour, marker="o", markersize=3.5, label=name if len(histories) > 1 else "run")
        ratio = factor_to_toughness(history)
        if ratio is not None and np.isfinite(ratio).any():
            axes.plot(ratio * x, ratio * y, color=colour, linestyle="--", linewidth=1.0, label=f"{name}: G = toughness" if len(histories) > 1 else "$G$ = toughness")
    axes.set(xlabel=labels[0][1], ylabel=labels[1][1], title=options.title or "")
    name_curves(drawn, [axes])
    return drawn


def columns_of(history: History, probe: str | None) -> tuple[str, str]:
    """Names of the columns of the displacement and the load."""
    found = [match for match in map(OF_PROBE.match, history.columns) if match and probe in (None, match[1])]
    if not found:
        if probe:
            raise ResultError(f"{history.path}: no load line is named '{probe}'")
        return history.select(["mouth_opening"])[0], history.select(["load_factor"])[0]
    match = max(found, key=lambda one: np.abs(history.columns[one[0]]).max())
    return match[0], f"load_{match[1]}_{match[2]}"


def factor_to_toughness(history: History) -> Array | None:
    """By what the loads of each row would be multiplied until G of a tip is its toughness; None where models are not linear, or do not tell it."""
    tips = [tip for tip in growing_tips(history) if tip.has("G") and tip.has("toughness")]
    if not tips or not is_linear(history):
        return None
    ratios = [np.where((tip.column("G") > 0) & (tip.column("toughness") > 0), tip.column("toughness") / np.maximum(tip.column("G"), np.finfo(float).tiny), np.inf)
              for tip in tips]
    least = np.sqrt(np.min(ratios, axis=0))
    return np.where(np.isfinite(least), least, np.nan)


def is_linear(history: History) -> bool:
    """Whether stresses are proportional to the loads, at rest; says why where not."""
    with opened(history.path) as stored:
        model = StoredModel(stored.text("input/namelist"), history.path)
    laws = {model.text("material", "law", n) for n in range(1, model.count("material") + 1)}
    causes = {"it is in motion": not model.is_static(), f"a law is {', '.join(sorted(laws - {'linear_elastic'}))}": laws != {"linear_elastic"},
              "bodies may touch": model.text("contact", "bodies") not in ("", "bonded"),    # faces of a crack, without a gap at the start, touch in proportion
              "faces hold each other": model.count("cohesive"),
              "some loads or motions are held": any(model.text(group, "held", n) == ".true." for group in ("load", "constraint") for n in range(1, model.count(group) + 1)),
              "it has an eigenstrain": any(any(model.numbers("body", key, n)) for key in ("eigenstrain", "profile_eigenstrain") for n in model.body_groups())}
    if cause := next((cause for cause, holds in causes.items() if holds), None):
        tell(f"{history.path}: the curve on which G is the toughness is left out: {cause}")
    return cause is None
