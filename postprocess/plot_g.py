#!/usr/bin/env python3
"""Picture of the dynamic energy release rate G(t)/G_ref, or of other columns over time, of one or more hampm results."""

import argparse
from pathlib import Path

from history import UNREADABLE, History, ResultError, lowpass, read_curve, run
from pictures import COLOURS, DASHES, TIME_UNITS, add_picture_options, add_time_unit, legend_below, names, plt, positive, write

WIDE = 2.2  # width of the first curve, so that it can be seen below others that coincide with it


def main(arguments=None):
    options = parse(arguments)
    histories = [History(path) for path in options.files]
    write(lambda: draw(histories, options), options, "_G")


def parse(arguments):
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("files", nargs="+", metavar="FILE.h5", help="result file of hampm")
    parser.add_argument("--estimator", action="append", metavar="NAME",
                        help="column of G to draw, such as G_nodal_force_I or nodal_force_I, * and ? allowed; "
                             "may be repeated (default: every G_* column)")
    parser.add_argument("--column", action="append", metavar="NAME",
                        help="draw columns such as K_I instead, in their own unit, * and ? allowed; may be repeated")
    parser.add_argument("--scale", type=positive, metavar="VALUE",
                        help="with --column: what the columns and the reference curve are divided by (default: 1)")
    parser.add_argument("--label", metavar="TEXT", help="with --column: of the vertical axis (default: what they are)")
    parser.add_argument("--converged", type=float, metavar="VALUE",
                        help="converged static G/G_ref, drawn as a horizontal line")
    parser.add_argument("--reference", metavar="FILE.csv", help="reference curve: rows of time [s], G/G_ref; with --column not divided yet")
    parser.add_argument("--reference-name", metavar="TEXT", help="of that curve in the legend (default: of its file)")
    parser.add_argument("--lowpass", type=positive, metavar="HZ",
                        help="remove what is above this frequency from every curve, without delay")
    add_time_unit(parser)
    add_picture_options(parser, "_G")
    options = parser.parse_args(arguments)
    if options.column and (options.estimator or options.converged is not None):
        parser.error("--column draws other columns than --estimator and --converged are about")
    if not options.column and (options.scale or options.label):
        parser.error("--scale and --label need --column")
    return options


def draw(histories, options):
    """The figure: curves of all files, the reference curve, and the static values as horizontal lines."""
    figure, axes = plt.subplots(figsize=(6.3, 4), layout="constrained")
    scale, unit = TIME_UNITS[options.time_unit]

    def curve(t, g, **style):
        axes.plot(t * scale, lowpass(t, g, options.lowpass) if options.lowpass else g, **style)

    if options.reference:
        t, value = read_curve(options.reference)
        curve(t, value / (options.scale or 1), color="0.15", linewidth=0.9, zorder=3,
              label=options.reference_name or f"reference: {Path(options.reference).stem}")
    shown = [(history, name, column) for history, name in zip(histories, names(histories))
             for column in columns(history, options)]
    for k, ((history, name, column), (colour, dash)) in enumerate(zip(shown, styles(shown))):
        value = history.columns[column] / (options.scale or 1) if options.column else history.g_ratio(column)
        curve(history.times, value, color=colour, linestyle=dash, linewidth=None if k else WIDE,
              label=f"{name}: {words(column)}")
    if not options.column:
        draw_static_values(axes, histories, options.converged)

    axes.set_xlim(0, max(history.times[-1] for history in histories) * scale or None)
    axes.set_xlabel(f"time $t$ [{unit}]")
    axes.set_ylabel(vertical_label(histories[0], options))
    filtered = f"below {options.lowpass / 1e3:g} kHz" if options.lowpass else None
    title = ", ".join(filter(None, [options.title, filtered]))
    if title:
        figure.suptitle(title)
    figure.set_figheight(3.7 + 0.2 * legend_below(figure, *axes.get_legend_handles_labels()))
    return figure


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
    if history.times.size == 0:
        raise ResultError(f"{history.path}: /history holds no samples yet", UNREADABLE)
    if options.column:
        return history.select(options.column)
    history.g_ref()
    return history.select([pattern if pattern.startswith("G_") else f"G_{pattern}" for pattern in options.estimator or ["G_*"]])


def vertical_label(history, options):
    """What the curves are."""
    if not options.column:
        return r"energy release rate $G/G_\mathrm{ref}$ [–]"
    first = columns(history, options)[0]
    scale = f"{options.scale:g} " if options.scale else ""
    return options.label or f"{history.long_names[first]} [{scale}{history.units[first]}]"


def styles(shown):
    """Colour and dash of each curve: its own of both as long as they last, then a colour for each file, a dash for each column."""
    if len(shown) <= len(COLOURS):
        return list(zip(COLOURS, DASHES))
    files = list(dict.fromkeys(name for _, name, _ in shown))
    kinds = list(dict.fromkeys(column for _, _, column in shown))
    return [(COLOURS[files.index(name) % len(COLOURS)], DASHES[kinds.index(column) % len(DASHES)]) for _, name, column in shown]


def words(estimator):
    """G_nodal_force_I -> nodal force I."""
    return estimator.removeprefix("G_").replace("_", " ")


if __name__ == "__main__":
    run(main)
