"""Picture of the dynamic energy release rate G(t)/G_ref, or of other columns over time or over each other, of one or more hampm results.

The commands `hampm plot rate`, `load` and `resistance` are this one with other columns.

Where a file has no G_ref (no `reference` in &energy_release), G is drawn in J/m2. Columns of different units have axes of
their own, below each other. --growth shows how cracks grow: G beside the toughness, speed and length. --x draws over another column:
the load over the opening, K over the length of the crack, G over its speed. `mean_tip_speed` is the tip_speed as mean over a cell.
"""

from __future__ import annotations

import re
from argparse import Namespace
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..arrays import Array
from ..columns import symbol as words
from ..errors import ResultError
from ..history import OF_TIP, History, is_error
from ..signals import lowpass, read_curve
from .growing_tips import add_derived, columns_over_time
from .pictures import (COLOURS, DASHES, add_time_unit, name_curves, picture_names, picture_parser, plt, positive, prefixed, time_axis,
                       verbatim, wrapped, write)

WIDE, THIN = 2.4, 1.2  # width of the first curve of a panel and of the last, so that each can be seen below others that coincide with it
ALONE = 1.5            # width of a curve that is alone
UNIT_WORDS = {"J/m2": "energy release rate", "Pa m^0.5": "stress intensity factor", "m": "length", "J": "energy", "N": "force",
              "m/s": "speed"}
MODE_AND_TIP = re.compile(r"(_I{1,2})?(_tip\d+)?$")
GROWTH_WORDS = {"J/m2": "$G$ and toughness", "m/s": "speed of the tip, mean over a cell", "m": "length of the crack", "1": "load factor"}
FEW = 40               # samples up to which a curve has a mark at each, and a bar for the estimated error


def main(arguments: Sequence[str] | None = None) -> None:
    write(figure, parse(arguments), "_G")


def figure(options: Namespace) -> Figure:
    """The picture that these options ask for."""
    return draw([History(path) for path in options.files], options)


def parse(arguments: Sequence[str] | None, description: str | None = __doc__, suffix: str = "_G", **columns: Any) -> Namespace:
    """The options; of another command, which describes itself, some of them stand."""
    parser = picture_parser(description, suffix)
    parser.add_argument("--estimator", action="append", metavar="NAME",
                        help="column of G to draw, such as G_vcct_I or vcct_I, * and ? allowed; "
                             "may be repeated (default: every G_* column)")
    parser.add_argument("--column", action="append", metavar="NAME",
                        help="draw columns such as K_I instead, in their own unit, * and ? allowed; may be repeated")
    parser.add_argument("--x", metavar="NAME", help="column to draw over, instead of over time; of each tip its own where there is one")
    parser.add_argument("--growth", action="store_true",
                        help="draw how cracks grow: G of the tips and its estimated error, toughness, speed, load factor, length")
    parser.add_argument("--scale", type=positive, metavar="VALUE",
                        help="with --column: what the columns and the reference curve are divided by (default: 1)")
    parser.add_argument("--label", metavar="TEXT", help="with --column: of the vertical axis (default: what they are)")
    parser.add_argument("--errors", action="store_true",
                        help="draw the estimated error of each column, where the file has it, as a band, or bars on few samples")
    parser.add_argument("--converged", type=static_value, action="append", metavar="[NAME=]VALUE",
                        help="converged static G/G_ref, drawn as a horizontal line with this name; may be repeated")
    parser.add_argument("--reference", metavar="FILE.csv", help="reference curve: rows of time [s], G/G_ref; with --column not "
                        "divided yet, in the unit of the first column")
    parser.add_argument("--reference-name", metavar="TEXT", help="of that curve in the legend (default: of its file)")
    parser.add_argument("--lowpass", type=positive, metavar="HZ",
                        help="remove what is above this frequency from every curve, without delay")
    parser.add_argument("--log", action="store_true", help="logarithmic axes; leaves out what is not above zero")
    add_time_unit(parser)
    parser.set_defaults(**columns)
    options = parser.parse_args(arguments)
    if options.growth and (options.column or options.scale or options.label or options.reference):
        parser.error("--growth chooses columns and their axes")
    options.errors |= options.growth
    if (options.column or options.growth) and (options.estimator or options.converged is not None):
        parser.error(f"--{'column' if options.column else 'growth'} draws other columns than --estimator and --converged are about")
    if not options.column and (options.scale or options.label):
        parser.error("--scale and --label need --column")
    return options


def static_value(text: str) -> tuple[str, float]:
    """A value with a name."""
    name, _, value = text.rpartition("=")
    return name or "converged static value", float(value)


def draw(histories: Sequence[History], options: Namespace) -> Figure:
    """The figure: curves of all files, the reference curve, and the static values as horizontal lines."""
    for history in histories:
        add_derived(history)
    shown = [Curve(history, name, column) for history, name in zip(histories, picture_names(histories))
             for column in columns(history, options)]
    scales = scales_of(shown, options)
    figure, panels = plt.subplots(len(scales), squeeze=False, sharex=True, figsize=(7.6, 1.3 + 2.4 * len(scales)), layout="constrained")
    panels = dict(zip(scales, panels[:, 0]))
    unit_of_x, label_of_x = abscissa(shown, options) if options.x else time_axis(histories, options.time_unit)

    def curve(axes: Axes, x: Any, t: Array, value: Array, **style: Any) -> None:
        if options.log:
            x, value = (np.where((x > 0) & (value > 0), of, np.nan) for of in (x, value))
        axes.plot(x * unit_of_x, smooth(t, value, options), **style)

    if options.reference:
        unit_of_first, scale = next(iter(scales.items()))
        t, value = read_curve(options.reference)
        if options.lowpass and np.any(np.diff(t) <= 0):
            raise ResultError(f"{options.reference}: times have to rise for --lowpass")
        curve(panels[unit_of_first], t, t, value * (scale.factor if options.column else 1), color="0.15", linewidth=0.9, zorder=3,
              label=options.reference_name or verbatim(f"reference: {Path(options.reference).stem}"))
    labels, widths = labels_of(shown), widths_of(shown)
    for item, (colour, dash), label, width in zip(shown, styles(shown, options), labels, widths):
        axes, times, factor = panels[item.unit], item.history.times, scales[item.unit].factor_of(item.history)
        x, value, is_few = item.over(options.x), item.values * factor, times.size <= FEW
        curve(axes, x, times, value, color=colour, linestyle=dash, linewidth=width, marker="o" if is_few else None, markersize=3.5,
              label=label)
        if options.errors and (error := item.history.error_of(item.column)):
            middle, about = smooth(times, value, options), smooth(times, item.history.columns[error] * factor, options)
            if is_few or options.x:
                error_of_x = item.history.error_of(item.column_over(options.x))
                beside = item.history.columns[error_of_x] * unit_of_x if options.x and error_of_x else None
                axes.errorbar(x * unit_of_x, middle, about, beside, color=colour, linestyle="none", capsize=3, linewidth=1)
            else:
                axes.fill_between(x * unit_of_x, middle - about, middle + about, color=colour, alpha=0.2, linewidth=0)
    if not (options.column or options.growth):
        draw_static_values(next(iter(panels.values())), histories, options.converged)

    for name, axes in panels.items():
        axes.set_ylabel(scales[name].label)
        if options.log:
            axes.set(xscale="log", yscale="log")
    if not (options.x or options.log):
        last = max(history.times[-1] for history in histories) * unit_of_x
        axes.set_xlim(*((-0.02 * last, 1.02 * last) if max(history.times.size for history in histories) <= FEW else (0, last or None)))
    axes.set_xlabel(label_of_x)
    filtered = f"low-pass filter at {options.lowpass / 1e3:g} kHz" if options.lowpass else None
    title = ", ".join(filter(None, [options.title, filtered]))
    if title:
        figure.suptitle(title)
    figure.set_figheight(figure.get_figheight() + 0.2 * name_curves(figure, list(panels.values()), len(histories) == 1))
    return figure


def abscissa(shown: Sequence[Curve], options: Namespace) -> tuple[float, str]:
    """By what the values of the column of --x are multiplied, and the label of their axis."""
    columns = {item.column_over(options.x): item for item in shown}
    name, item = next(iter(columns.items()))
    unit = verbatim(item.history.units[name])
    largest = max(np.abs(values[np.isfinite(values)]).max(initial=0.0) for values in (other.over(options.x) for other in shown))
    factor, prefixed_unit = prefixed(largest, unit)
    return factor, wrapped(short_name(item.history, name), "–" if unit == "1" else prefixed_unit, 60)


def short_name(history: History, column: str) -> str:
    """What a column is, in the first words of its long name, where these are few, else by its own name."""
    name = verbatim(re.split(", |; ", history.long_names[column])[0])
    return name if len(name) < 40 else words(column)


class Curve:
    """A column of a file that is drawn: history, name of the file, column, values and unit."""

    def __init__(self, history: History, name: str, column: str) -> None:
        self.history, self.name, self.column = history, name, column
        self.values, self.unit = history.columns[column], verbatim(history.units[column])
        if column.startswith("toughness"):
            self.values = np.where(self.values > 0, self.values, np.nan)  # none applies

    def column_over(self, name: str | None) -> str:
        """The column of this name of the tip of the curve where there is one, else of the run; time where no name is given."""
        ending = tip_of(self.column)
        return name + ending if name and name + ending in self.history.columns else self.history.select([name or "time"])[0]

    def over(self, name: str | None) -> Array:
        """The values over which the curve is drawn."""
        return self.history.columns[self.column_over(name)]


class Scale:
    """What the values of one unit are multiplied by, and the label of their axis; over G_ref the factor is one of the file."""

    def __init__(self, factor: float, label: str, is_ratio: bool = False) -> None:
        self.factor, self.label, self.is_ratio = factor, label, is_ratio

    def factor_of(self, history: History) -> float:
        return 1 / history.g_ref() if self.is_ratio else self.factor


def scales_of(shown: Sequence[Curve], options: Namespace) -> dict[str, Scale]:
    """The scale of each unit that the curves have."""
    units = list(dict.fromkeys(item.unit for item in shown))
    if options.label and len(units) > 1:
        raise ResultError(f"--label is of one axis, and the columns have the units {', '.join(units)}")
    if not (options.column or options.growth) and has_reference(shown, options):
        return {unit: Scale(1.0, r"energy release rate $G/G_\mathrm{ref}$ [–]", is_ratio=True) for unit in units}
    return {unit: scale_of([item for item in shown if item.unit == unit], unit, options) for unit in units}


def has_reference(shown: Sequence[Curve], options: Namespace) -> bool:
    """Whether all files have a G_ref; one that has is not drawn beside one that has not."""
    without = [item.history for item in shown if "G_ref" not in item.history.attributes]
    if without and (options.converged is not None or options.reference or any(item.history not in without for item in shown)):
        without[0].g_ref()  # which says what is missing
    return not without


def scale_of(shown: Sequence[Curve], unit: str, options: Namespace) -> Scale:
    """The scale of the columns of one unit: that of --scale, else a prefix of the unit where the label is not given."""
    if options.label:
        return Scale(1 / (options.scale or 1), options.label)
    what = GROWTH_WORDS.get(unit, unit) if options.growth else common_name(shown) if options.column else "energy release rate $G$"
    if options.scale:
        return Scale(1 / options.scale, wrapped(what, f"{options.scale:g} {unit}"))
    factor, prefixed_unit = prefixed(max(np.abs(item.values[np.isfinite(item.values)]).max(initial=0.0) for item in shown), unit)
    return Scale(factor, wrapped(what, "–" if unit == "1" else prefixed_unit))


def common_name(shown: Sequence[Curve]) -> str:
    """What columns are, in the words that their long names begin with, up to a comma, where these are the same; else by their unit, or
    the names of all."""
    names = list(dict.fromkeys(short_name(item.history, item.column) for item in shown))
    if len(names) == 1:
        return names[0]
    return UNIT_WORDS.get(shown[0].history.units[shown[0].column]) or ", ".join(dict.fromkeys(words(item.column) for item in shown))


def labels_of(shown: Sequence[Curve]) -> list[str]:
    """What tells each curve from the others of its panel: its file, its column, or both."""
    labels = []
    for item in shown:
        beside = [other for other in shown if other.unit == item.unit]
        one_file, one_column = len({other.name for other in beside}) == 1, len({other.column for other in beside}) == 1
        labels.append(words(item.column) if one_file else item.name if one_column else f"{item.name}: {words(item.column)}")
    return labels


def widths_of(shown: Sequence[Curve]) -> list[float]:
    """Widths of curves, falling within each panel."""
    of_panel = {unit: [item for item in shown if item.unit == unit] for unit in dict.fromkeys(item.unit for item in shown)}
    widths = {id(item): width for items in of_panel.values()
              for item, width in zip(items, np.linspace(WIDE, THIN, len(items)) if len(items) > 1 else [ALONE])}
    return [widths[id(item)] for item in shown]


def smooth(t: Array, value: Array, options: Namespace) -> Array:
    """Values without what is above the frequency of --lowpass, if any."""
    return lowpass(t, value, options.lowpass) if options.lowpass else value


def draw_static_values(axes: Axes, histories: Sequence[History], converged: Sequence[tuple[str, float]] | None) -> None:
    """Horizontal lines: the beam on an elastic foundation, eq. (33), of each scene, and the converged static value."""
    for name, value in converged or []:
        axes.axhline(value, color="0.5", linewidth=1.2, label=f"{name}: {value:.4g}")
    beams = {round(ratio, 6) for ratio in (history.beam_ratio() for history in histories) if ratio is not None}
    for ratio in sorted(beams):
        axes.axhline(ratio, color="0.25", linestyle=(0, (5, 3)), linewidth=1.0,
                     label=f"beam on elastic foundation: {ratio:.4g}")


def columns(history: History, options: Namespace) -> list[str]:
    """Columns to draw; the pattern of an estimator may leave out the leading G_."""
    if options.growth:
        return columns_over_time(history)
    if options.column:
        return history.select(options.column)
    patterns = [pattern if pattern.startswith("G_") else f"G_{pattern}" for pattern in options.estimator or ["G_*"]]
    chosen = history.select(patterns)
    return [name for name in chosen if is_estimator(name) or name in patterns] or chosen


def tip_of(column: str) -> str:
    """What the name of a column says of its tip, such as _tip2; nothing of the first."""
    found = OF_TIP.search(column)
    return found[0] if found else ""


def is_estimator(name: str) -> bool:
    """Whether a column is an energy release rate by one estimator and mode, at any tip, not that of both modes, nor its mean over an advance."""
    return name.startswith("G_") and not is_error(name) and OF_TIP.sub("", name) not in ("G", "G_moving_average")


def styles(shown: Sequence[Curve], options: Namespace) -> list[tuple[str, Any]]:
    """Colour and dash of each curve: its own of both as long as they last, of one file or one column. Of more, of one file a colour for
    each quantity, a dash for each mode and tip; of several a colour for each file and a dash for each column, or in one panel the other
    way round if there are more columns than files. Of cracks that grow a colour for each tip, and dashes for the toughness."""
    if options.growth:
        parts = [((item.name, tip_of(item.column)), item.column.startswith("toughness")) for item in shown]
        return coloured(parts, [False, True])
    files, kinds = {item.name for item in shown}, {item.column for item in shown}
    if len(shown) <= len(COLOURS) and min(len(files), len(kinds)) == 1:
        return list(zip(COLOURS, DASHES))
    if len(files) == 1:
        return coloured([(of, item.column.removeprefix(of)) for item in shown for of in [MODE_AND_TIP.sub("", item.column)]])
    one_panel = len({item.unit for item in shown}) == 1
    return coloured([(item.column, item.name) if len(kinds) > len(files) and one_panel else (item.name, item.column) for item in shown])


def coloured(parts: Sequence[tuple[Any, Any]], dashed: Sequence[Any] = ()) -> list[tuple[str, Any]]:
    """Colours by the first of two parts, dashes by the second, whose values may be given in order."""
    hues, kinds = (list(dict.fromkeys(values)) for values in zip(*parts))
    kinds = list(dashed) or kinds
    return [(COLOURS[hues.index(hue) % len(COLOURS)], DASHES[kinds.index(kind) % len(DASHES)]) for hue, kind in parts]
