#!/usr/bin/env python3
"""Picture of the dynamic energy release rate G(t)/G_ref, or of other columns over time, of one or more hampm results.

Where a file has no G_ref (no `reference` in &energy_release), G is drawn in J/m2. Columns of different units have axes of
their own, below each other. --growth shows how cracks grow: G beside the toughness, speed and length.
"""

import argparse
import re
from pathlib import Path

from growing_tips import columns_over_time
from history import OF_TIP, History, ResultError, is_error, lowpass, read_curve, run
from pictures import (COLOURS, DASHES, add_picture_options, add_time_unit, legend_below, picture_names, plt, positive, prefixed, time_axis, verbatim,
                      wrapped, write)

import numpy as np

WIDE, THIN = 2.6, 1.1  # width of the first curve and of the last, so that each can be seen below others that coincide with it
MODE_AND_TIP = re.compile(r"(_I{1,2})?(_tip\d+)?$")
GROWTH_WORDS = {"J/m2": "$G$ and toughness", "m/s": "speed of the tip", "m": "length of the crack", "1": "factor of the loads"}
FEW = 40               # samples up to which a curve has a mark at each, and a bar for the estimated error


def main(arguments=None):
    options = parse(arguments)
    histories = [History(path) for path in options.files]
    write(lambda: draw(histories, options), options, "_G")


def parse(arguments):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="+", metavar="FILE.h5", help="result file of hampm")
    parser.add_argument("--estimator", action="append", metavar="NAME",
                        help="column of G to draw, such as G_vcct_I or vcct_I, * and ? allowed; "
                             "may be repeated (default: every G_* column)")
    parser.add_argument("--column", action="append", metavar="NAME",
                        help="draw columns such as K_I instead, in their own unit, * and ? allowed; may be repeated")
    parser.add_argument("--growth", action="store_true",
                        help="draw how cracks grow: G of the tips and its estimated error, toughness, speed, load factor, length")
    parser.add_argument("--scale", type=positive, metavar="VALUE",
                        help="with --column: what the columns and the reference curve are divided by (default: 1)")
    parser.add_argument("--label", metavar="TEXT", help="with --column: of the vertical axis (default: what they are)")
    parser.add_argument("--errors", action="store_true",
                        help="draw the estimated error of each column, where the file has it, as a band, or bars on few samples")
    parser.add_argument("--converged", type=float, metavar="VALUE",
                        help="converged static G/G_ref, drawn as a horizontal line")
    parser.add_argument("--reference", metavar="FILE.csv", help="reference curve: rows of time [s], G/G_ref; with --column not "
                        "divided yet, in the unit of the first column")
    parser.add_argument("--reference-name", metavar="TEXT", help="of that curve in the legend (default: of its file)")
    parser.add_argument("--lowpass", type=positive, metavar="HZ",
                        help="remove what is above this frequency from every curve, without delay")
    add_time_unit(parser)
    add_picture_options(parser, "_G")
    options = parser.parse_args(arguments)
    if options.growth and (options.column or options.scale or options.label or options.reference):
        parser.error("--growth chooses columns and their axes")
    options.errors |= options.growth
    if (options.column or options.growth) and (options.estimator or options.converged is not None):
        parser.error(f"--{'column' if options.column else 'growth'} draws other columns than --estimator and --converged are about")
    if not options.column and (options.scale or options.label):
        parser.error("--scale and --label need --column")
    return options


def draw(histories, options):
    """The figure: curves of all files, the reference curve, and the static values as horizontal lines."""
    shown = [Curve(history, name, column) for history, name in zip(histories, picture_names(histories))
             for column in columns(history, options)]
    scales = scales_of(shown, options)
    figure, panels = plt.subplots(len(scales), squeeze=False, sharex=True, figsize=(6.3, 4), layout="constrained")
    panels = dict(zip(scales, panels[:, 0]))
    unit_of_time, label_of_time = time_axis(histories, options.time_unit)

    def curve(axes, t, value, **style):
        axes.plot(t * unit_of_time, smooth(t, value, options), **style)

    if options.reference:
        unit_of_first, scale = next(iter(scales.items()))
        t, value = read_curve(options.reference)
        if options.lowpass and np.any(np.diff(t) <= 0):
            raise ResultError(f"{options.reference}: times have to rise for --lowpass")
        curve(panels[unit_of_first], t, value * (scale.factor if options.column else 1), color="0.15", linewidth=0.9, zorder=3,
              label=options.reference_name or verbatim(f"reference: {Path(options.reference).stem}"))
    for item, (colour, dash), width in zip(shown, styles(shown, options), np.linspace(WIDE, THIN, len(shown))):
        axes, times, factor = panels[item.unit], item.history.times, scales[item.unit].factor_of(item.history)
        value, is_few = item.values * factor, times.size <= FEW
        curve(axes, times, value, color=colour, linestyle=dash, linewidth=width, marker="o" if is_few else None, markersize=3.5,
              label=f"{item.name}: {words(item.column)}")
        if options.errors and (error := item.history.error_of(item.column)):
            middle, about = smooth(times, value, options), smooth(times, item.history.columns[error] * factor, options)
            if is_few:
                axes.errorbar(times * unit_of_time, middle, about, color=colour, linestyle="none", capsize=3, linewidth=1)
            else:
                axes.fill_between(times * unit_of_time, middle - about, middle + about, color=colour, alpha=0.2, linewidth=0)
    if not (options.column or options.growth):
        draw_static_values(next(iter(panels.values())), histories, options.converged)

    for name, axes in panels.items():
        axes.set_ylabel(scales[name].label)
    last = max(history.times[-1] for history in histories) * unit_of_time
    axes.set_xlim(*((-0.02 * last, 1.02 * last) if max(history.times.size for history in histories) <= FEW else (0, last or None)))
    axes.set_xlabel(label_of_time)
    filtered = f"below {options.lowpass / 1e3:g} kHz" if options.lowpass else None
    title = ", ".join(filter(None, [options.title, filtered]))
    if title:
        figure.suptitle(title)
    handles, labels = [sum(parts, []) for parts in zip(*(axes.get_legend_handles_labels() for axes in panels.values()))]
    figure.set_figheight(3.7 + 2.4 * (len(panels) - 1) + 0.2 * legend_below(figure, handles, labels))
    return figure


class Curve:
    """A column of a file that is drawn: history, name of the file, column, values and unit."""

    def __init__(self, history, name, column):
        self.history, self.name, self.column = history, name, column
        self.values, self.unit = history.columns[column], verbatim(history.units[column])


class Scale:
    """What the values of one unit are multiplied by, and the label of their axis; over G_ref the factor is one of the file."""

    def __init__(self, factor, label, is_ratio=False):
        self.factor, self.label, self.is_ratio = factor, label, is_ratio

    def factor_of(self, history):
        return 1 / history.g_ref() if self.is_ratio else self.factor


def scales_of(shown, options):
    """The scale of each unit that the curves have."""
    units = list(dict.fromkeys(item.unit for item in shown))
    if options.label and len(units) > 1:
        raise ResultError(f"--label is of one axis, and the columns have the units {', '.join(units)}")
    if not (options.column or options.growth) and has_reference(shown, options):
        return {unit: Scale(1.0, r"energy release rate $G/G_\mathrm{ref}$ [–]", is_ratio=True) for unit in units}
    return {unit: scale_of([item for item in shown if item.unit == unit], unit, options) for unit in units}


def has_reference(shown, options):
    """Whether all files have a G_ref; one that has is not drawn beside one that has not."""
    without = [item.history for item in shown if "G_ref" not in item.history.attributes]
    if without and (options.converged is not None or options.reference or any(item.history not in without for item in shown)):
        without[0].g_ref()  # which says what is missing
    return not without


def scale_of(shown, unit, options):
    """The scale of the columns of one unit: that of --scale, else a prefix of the unit where the label is not given."""
    if options.label:
        return Scale(1 / (options.scale or 1), options.label)
    what = GROWTH_WORDS.get(unit, unit) if options.growth else common_name(shown) if options.column else "energy release rate $G$"
    if options.scale:
        return Scale(1 / options.scale, wrapped(what, f"{options.scale:g} {unit}"))
    factor, prefixed_unit = prefixed(max(np.abs(item.values[np.isfinite(item.values)]).max(initial=0.0) for item in shown), unit)
    return Scale(factor, wrapped(what, "–" if unit == "1" else prefixed_unit))


def common_name(shown):
    """What columns are, in the words that their long names begin with, up to a comma; else the names of all."""
    parts = [verbatim(item.history.long_names[item.column]).split(", ") for item in shown]
    common = parts[0]
    for other in parts[1:]:
        common = [a for k, a in enumerate(common) if other[:k + 1] == common[:k + 1]]
    return ", ".join(common or dict.fromkeys(words(item.column) for item in shown))


def smooth(t, value, options):
    """Values without what is above the frequency of --lowpass, if any."""
    return lowpass(t, value, options.lowpass) if options.lowpass else value


def draw_static_values(axes, histories, converged):
    """Horizontal lines: the beam on an elastic foundation, eq. (33), of each scene, and the converged static value."""
    if converged is not None:
        axes.axhline(converged, color="0.65", linewidth=1.2, label=f"converged static value: {converged:.4g}")
    beams = {round(ratio, 6) for ratio in (history.beam_ratio() for history in histories) if ratio is not None}
    for ratio in sorted(beams):
        axes.axhline(ratio, color="0.25", linestyle=(0, (5, 3)), linewidth=1.0,
                     label=f"beam on elastic foundation: {ratio:.4g}")


def columns(history, options):
    """Columns to draw; the pattern of an estimator may leave out the leading G_."""
    if options.growth:
        return columns_over_time(history)
    if options.column:
        return history.select(options.column)
    patterns = [pattern if pattern.startswith("G_") else f"G_{pattern}" for pattern in options.estimator or ["G_*"]]
    chosen = history.select(patterns)
    return [name for name in chosen if is_estimator(name) or name in patterns] or chosen


def is_estimator(name):
    """Whether a column is an energy release rate by one estimator and mode, at any tip, not that of both modes."""
    return name.startswith("G_") and not is_error(name) and OF_TIP.sub("", name) != "G"


def styles(shown, options):
    """Colour and dash of each curve: its own of both as long as they last. Then of one file a colour for each quantity, a dash for each mode
    and tip; of several a colour for each file and a dash for each column, or the other way round if there are more columns than files. Of cracks
    that grow a colour for each tip, and dashes for the toughness."""
    if options.growth:
        parts = [((item.name, OF_TIP.search(item.column)[0]), item.column.startswith("toughness")) for item in shown]
        return coloured(parts, [False, True])
    if len(shown) <= len(COLOURS):
        return list(zip(COLOURS, DASHES))
    files, kinds = ({part(item) for item in shown} for part in (lambda item: item.name, lambda item: item.column))
    if len(files) == 1:
        return coloured([(MODE_AND_TIP.sub("", item.column), MODE_AND_TIP.search(item.column)[0]) for item in shown])
    return coloured([(item.column, item.name) if len(kinds) > len(files) else (item.name, item.column) for item in shown])


def coloured(parts, dashed=()):
    """Colours by the first of two parts, dashes by the second, whose values may be given in order."""
    hues, kinds = (list(dict.fromkeys(values)) for values in zip(*parts))
    kinds = list(dashed) or kinds
    return [(COLOURS[hues.index(hue) % len(COLOURS)], DASHES[kinds.index(kind) % len(DASHES)]) for hue, kind in parts]


def words(estimator):
    """G_vcct_I -> VCCT I, G_stress_closure_I -> stress closure I."""
    return (estimator if OF_TIP.sub("", estimator) == "G" else estimator.removeprefix("G_")).replace("_", " ").replace("vcct", "VCCT")


if __name__ == "__main__":
    run(main)
