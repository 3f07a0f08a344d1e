"""What all pictures share: their look, the options for the file that is written, and words for files and units.

They are drawn without a display. Colours are Okabe and Ito's, told apart with any colour vision; the dashes keep curves
legible in grey. Curves have their names beside their ends, where there are few enough of them.
"""

from __future__ import annotations

import argparse
import math
import re
import textwrap
from argparse import ArgumentParser, Namespace
from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import pyplot
from matplotlib.axes import Axes
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from matplotlib.text import Annotation

from ..errors import UNREADABLE, ResultError, printable
from ..scripts import Parser

plt = pyplot         # of all modules that draw
COLOURS = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000", "#8C8C8C"]
DASHES = ["-", (0, (6, 2)), (0, (3, 3)), (0, (6, 2, 1.2, 2)), (0, (1.2, 1.8)), (0, (9, 3)), (0, (4, 1.2)), (0, (9, 2, 3, 2))]
MOST_NAMED = 8      # curves of a panel whose names stand beside their ends
LINE_OF_TEXT = 0.165  # height, of letters as they are unless a style has others [inch]
STYLE = {
    "font.size": 10, "axes.titlesize": 11, "legend.fontsize": 9, "axes.spines.top": False, "axes.spines.right": False,
    "axes.grid": True, "grid.color": "0.9", "grid.linewidth": 0.6, "axes.axisbelow": True, "lines.linewidth": 1.4,
    "svg.fonttype": "none", "svg.hashsalt": "hampm", "pdf.fonttype": 42,
}
STYLES = {"paper": {"font.size": 8, "axes.titlesize": 8, "legend.fontsize": 7, "lines.linewidth": 1.0, "axes.linewidth": 0.6}, "dark": {},
          "slide": {"font.size": 15, "axes.titlesize": 15, "legend.fontsize": 14, "lines.linewidth": 2.2, "axes.linewidth": 1.2}}
FORMATS = "png", "pdf", "svg"
INCH = {"mm": 1 / 25.4, "cm": 1 / 2.54, "in": 1.0}
TIME_UNITS = {"s": (1.0, "s"), "ms": (1e3, "ms"), "us": (1e6, "µs"), "ns": (1e9, "ns")}
PREFIXES = {-4: "p", -3: "n", -2: "µ", -1: "m", 0: "", 1: "k", 2: "M", 3: "G"}  # by powers of 1000
MM = 1e3  # per metre
DRAWING, ON_COLOURS = "drawing", "on colours"
SIZES = "fontsize", "linewidth", "markersize", "markeredgewidth"   # of artists [points]
GREY, DARKEST = 0.02, 0.08   # difference of red, green and blue below which a colour is grey; what white becomes in the style dark
NO_BREAK, THIN_SPACE = "\u00a0", "\u2009"


def add_picture_options(parser: ArgumentParser, suffix: str) -> None:
    """Options of every picture; `suffix` is what the name of the first file gets by default, such as _G."""
    parser.add_argument("-o", "--output", type=picture, metavar="FILE",
                        help=f"picture to write, .png, .pdf or .svg (default: <first file>{suffix}.png beside it)")
    parser.add_argument("--format", type=formats, default=[], metavar="FORMAT,...", help="write so many files that end in these, such as pdf,svg,png")
    add_look(parser)
    parser.add_argument("--dpi", type=positive, default=200, metavar="N", help="points per inch of a .png (default: %(default)g)")
    parser.add_argument("--title", metavar="TEXT", help="title of the picture")


def add_look(parser: ArgumentParser) -> None:
    """Options of every picture and film: its style and its size."""
    parser.add_argument("--style", choices=STYLES, help="small letters and thin lines for a paper, large ones for a slide, or light on dark")
    parser.add_argument("--size", type=size_of, metavar="WIDTH[xHEIGHT]", help="of the picture, such as 84mm or 16x9cm (default: what suits it)")


def picture_parser(description: str | None, suffix: str, files: str = "result file of hampm", metavar: str = "FILE.h5", nargs: int | str = "+") -> Parser:
    """The parser of a command that draws files, with the options of every picture."""
    parser = Parser(description)
    parser.add_argument("files", nargs=nargs, metavar=metavar, help=files)
    add_picture_options(parser, suffix)
    return parser


def add_time_unit(parser: ArgumentParser) -> None:
    parser.add_argument("--time-unit", choices=TIME_UNITS, help="unit of the time axis (default: the one that suits)")


def time_axis(results: Sequence[Any], unit: str | None) -> tuple[float, str]:
    """By what times are multiplied and what their axis is called: at rest they only tell how large the loads are, in load steps where
    these are the same in all."""
    if all(result.is_static for result in results):
        steps = {round(result.columns["step"][-1] / result.times[-1], 9) if "step" in result.columns and result.times[-1] > 0 else 0
                 for result in results}
        return (steps.pop(), "load step") if len(steps) == 1 and 0 not in steps else (1.0, "time of the loads, at rest [s]")
    factor, unit = time_unit(max(result.times[-1] for result in results), unit)
    return factor, f"time $t$ [{unit}]"


def time_unit(longest: float, unit: str | None = None) -> tuple[float, str]:
    """By what times are multiplied and the unit that they have then: the one asked for, else the one that suits a longest time [s]."""
    suited = next((name for name, (factor, _) in TIME_UNITS.items() if longest * factor >= 1), "ns") if longest > 0 else "s"
    return TIME_UNITS[unit or suited]


def write(figure: Callable[[Namespace], Figure], options: Namespace, suffix: str, quiet: bool = False) -> None:
    """Draw a figure by figure(options) and save it as the options say, without a display; print where."""
    first = Path(options.files[0])
    output = Path(options.output or first.with_name(f"{first.stem}{suffix}.png"))
    plt.switch_backend("Agg")
    with plt.rc_context(STYLE | STYLES.get(options.style, {})):
        drawn = in_style(figure, options)
        for path in [output.with_suffix("." + ending) for ending in options.format] or [output]:
            save(drawn, path, options.dpi)
            if not quiet:
                print(path)


def in_style(figure: Callable[[Namespace], Figure], options: Namespace) -> Figure:
    """The figure of these options, of the size and in the style that they ask for: it is as large as its letters, unless a size is given."""
    letters = plt.rcParams["font.size"] / STYLE["font.size"]
    drawn = figure(options)
    own = drawn.get_size_inches()
    size = letters * own
    if options.size:
        width, height = options.size
        keeps_shape = is_drawing(drawn) or any(axes.get_aspect() != "auto" for axes in drawn.axes)
        size = width, height or size[1] * (width / size[0] if keeps_shape else 1)
    if is_drawing(drawn):
        enlarge(drawn, min(np.divide(size, own)))
    drawn.set_size_inches(size)
    if options.style == "dark":
        for artist in drawn.findobj(lambda one: not isinstance(one, (Figure, Axes))):    # which hand on the colour of their background
            invert_greys(artist)
    return drawn


def is_drawing(figure: Figure) -> bool:
    """Whether a figure is a drawing, of which all keeps its proportions, letters too: it says so by its label."""
    return figure.get_label() == DRAWING


def enlarge(figure: Figure, factor: float) -> None:
    """Letters, lines, marks and distances in points of a drawing, by a factor."""
    arrows: list[Any] = [artist for artist in figure.findobj(Annotation) if artist.arrow_patch is not None]
    for arrow in arrows:
        arrow.arrowprops["mutation_scale"] *= factor    # of its head
    for axis in (axis for axes in figure.axes for axis in (axes.xaxis, axes.yaxis)):
        axis.labelpad *= factor
        axis.set_tick_params(**{name: factor * plt.rcParams[f"xtick.major.{name}"] for name in ("size", "pad", "width")})
    for artist in {*figure.findobj(), *(arrow.arrow_patch for arrow in arrows)}:
        for name in SIZES:
            if hasattr(artist, f"set_{name}"):
                getattr(artist, f"set_{name}")(factor * getattr(artist, f"get_{name}")())
        if isinstance(artist, Annotation) and artist.anncoords == "offset points":
            artist.set_position(tuple(factor * np.array(artist.get_position())))


def invert_greys(artist: Any) -> None:
    """Black as white and white as black, but for what lies between: colours stay, and those of fields and of lines on them."""
    if artist.get_gid() == ON_COLOURS or getattr(artist, "get_array", lambda: None)() is not None:
        return
    names = "color", "facecolor", "edgecolor", "markerfacecolor", "markeredgecolor"
    before = {name: getattr(artist, f"get_{name}")() for name in names if hasattr(artist, f"get_{name}")}    # all of them: one may follow another
    for name, of in before.items():
        try:
            colours = np.atleast_2d(np.array([to_rgba(one) for one in (of if np.ndim(of) > 1 else [of])]))
        except ValueError:      # a word such as "none" or "auto", or none of a colour
            continue
        grey = np.ptp(colours[:, :3], axis=1) < GREY if colours.size else np.array([False])
        if grey.any():
            colours[grey, :3] = DARKEST + (1 - DARKEST) * (1 - colours[grey, :3])
            getattr(artist, f"set_{name}")(colours if np.ndim(of) > 1 else tuple(colours[0]))


def save(figure: Figure, output: Any, dpi: float) -> None:
    """Write a figure to a file or stream."""
    try:
        figure.savefig(output, dpi=dpi)
    except OSError as error:
        raise ResultError(f"{output}: cannot be written ({error.strerror})", UNREADABLE) from error
    finally:
        plt.close(figure)    # which can be saved again


def wrapped(words: str, unit: str, width: int = 38) -> str:
    """The label of an axis, in lines of so many characters, with the unit whole on the last."""
    lines = textwrap.wrap(f"{words} [{typeset(unit).replace(' ', NO_BREAK)}]", width, break_long_words=False)
    return "\n".join(lines).replace(NO_BREAK, " ")


def typeset(unit: str) -> str:
    """A unit as it is printed: J/m2 as J/m², Pa m^0.5 as Pa√m."""
    return re.sub(r"(?<=[a-zA-Z])([23])\b", lambda power: "²³"[int(power[1]) - 2], unit).replace(" m^0.5", "√m")


def name_curves(figure: Figure, panels: Sequence[Axes], says_it: bool = False) -> int:
    """Write the label of each curve beside its right end, in its colour. Where a panel has too many of them, or where they end elsewhere,
    they stand in one legend below. A curve that is alone needs no label where its axis `says_it`. Returns the rows of the legend."""
    lines = {axes: [line for line in axes.lines if not str(line.get_label()).startswith("_")] for axes in panels}
    if all(sum(line.get_transform() == axes.transData for line in of) <= MOST_NAMED and all(ends_at_right(axes, line) for line in of)
           for axes, of in lines.items()):
        for axes, of in lines.items():
            write_beside(axes, of if len(of) > 1 or not says_it else [])
        return 0
    named = {label: handle for axes in panels for handle, label in zip(*axes.get_legend_handles_labels())}
    return legend_below(figure, list(named.values()), list(named))


def ends_at_right(axes: Axes, line: Any) -> bool:
    """Whether the last point of a curve is at the right edge, as the whole of a horizontal line is."""
    if line.get_transform() != axes.transData:
        return True
    left, right = axes.get_xlim()
    x = np.asarray(line.get_xdata(), dtype=float)
    return x.size > 0 and x[-1] >= right - 0.08 * (right - left) and x[-1] >= np.nanmax(x)


def write_beside(axes: Axes, lines: Sequence[Any]) -> None:
    """Labels of curves beside the right edge, as high as these end there, one below the other where they would be on each other."""
    whole: Any = axes.figure
    height = axes.get_position().height * whole.get_figheight()
    labels = [textwrap.fill(line.get_label(), 26 + len(line.get_label()) - shown_length(line.get_label())) for line in lines]
    to_panel = axes.transScale + axes.transLimits
    ends = [to_panel.transform((axes.get_xlim()[1], last_of(line)))[1] for line in lines]
    sizes = [LINE_OF_TEXT * (1 + label.count("\n")) / height for label in labels]
    order = sorted(range(len(lines)), key=lambda k: -round(30 * ends[k]))
    places, top = {}, np.inf
    for k in order:
        places[k] = min(ends[k], top - sizes[k] / 2)
        top = places[k] - sizes[k] / 2
    bottom = -0.02
    for k in reversed(order):  # what has come below the panel is moved up, and what is above it with it
        places[k] = max(places[k], bottom + sizes[k] / 2)
        bottom = places[k] + sizes[k] / 2
    for k, (line, label) in enumerate(zip(lines, labels)):
        axes.annotate(label, (1, min(max(ends[k], 0), 1)), xycoords="axes fraction", xytext=(1.035, places[k]), textcoords="axes fraction",
                      va="center", fontsize=plt.rcParams["legend.fontsize"], color=line.get_color(), annotation_clip=False,
                      arrowprops={"arrowstyle": "-", "color": line.get_color(), "linewidth": 0.7, "shrinkA": 1, "shrinkB": 0,
                                  "relpos": (0, 0.5)})


def shown_length(label: str) -> int:
    """How many letters a label has, of which parts are formulas."""
    return len(re.sub(r"\\mathrm|[{}$_]", "", label))


def last_of(line: Any) -> float:
    """The last value of a curve that is a number."""
    y = np.asarray(line.get_ydata(), dtype=float)
    known = y[np.isfinite(y)]
    return known[-1] if known.size else 0.0


def legend_below(figure: Figure, handles: Sequence[Any], labels: Sequence[str], narrow: int = 42) -> int:
    """A legend under the figure, in two columns where labels are shorter than `narrow`; the rows it has."""
    across = 2 if max(map(shown_length, labels)) < narrow else 1
    figure.legend(handles, labels, loc="outside lower center", ncols=across, frameon=False, handlelength=3.2)
    return -(-len(labels) // across)


def ending(*suffixes: str) -> Callable[[str], str]:
    """The type of an argument that names a file with one of these suffixes."""
    def name(text: str) -> str:
        if Path(text).suffix not in suffixes:
            raise argparse.ArgumentTypeError(f"{text} does not end in {' or '.join(suffixes)}")
        return text
    return name


def positive(text: str) -> float:
    value = float(text)
    if not 0 < value < float("inf"):
        raise argparse.ArgumentTypeError(f"{text} is not a positive number")
    return value


def size_of(text: str) -> tuple[float, float | None]:
    """A width, or width and height, with a unit [inch]; the height is none where it is not given."""
    found: Any = re.fullmatch(r"([\d.]+)(?:mm|cm|in)?(?:x([\d.]+))?(mm|cm|in)", text)
    try:
        width, height = (value and positive(value) * INCH[found[3]] for value in found.groups()[:2])
    except (AttributeError, ValueError, argparse.ArgumentTypeError):
        raise argparse.ArgumentTypeError(f"{text} is no size, such as 84mm or 16x9cm") from None
    return width, height


def formats(text: str) -> list[str]:
    """Endings of pictures."""
    if unknown := [word for word in text.split(",") if word not in FORMATS]:
        raise argparse.ArgumentTypeError(f"'{unknown[0]}' is none of {', '.join(FORMATS)}")
    return text.split(",")


def picture(text: str) -> str:
    if Path(text).suffix not in (".png", ".pdf", ".svg"):
        raise argparse.ArgumentTypeError(f"{text} does not end in .png, .pdf or .svg")
    return text


def names(results: Sequence[Any]) -> list[str]:
    """File stems, with the folder in front where stems are not enough to tell files apart."""
    count = Counter(result.stem for result in results)
    return [result.stem if count[result.stem] == 1 else printable(f"{result.path.resolve().parent.name}/{result.stem}")
            for result in results]


def picture_names(results: Sequence[Any]) -> list[str]:
    """The same for pictures."""
    return [verbatim(name) for name in names(results)]


def verbatim(text: str) -> str:
    """A text of a file or its name for a picture: no $ makes a formula of it, and a legend shows one that begins with _ too."""
    text = printable(text).replace("$", r"\$")
    return THIN_SPACE + text if text.startswith("_") else text


def prefixed(largest: float, unit: str) -> tuple[float, str]:
    """Factor and unit with a prefix that bring a largest value to between 1 and 1000; 1 and the unit where none fits."""
    power = math.floor(math.log10(largest) / 3 + 1e-9) if largest > 0 and math.isfinite(largest) else 0
    return (1e3**-power, PREFIXES[power] + unit) if power in PREFIXES and unit not in ("1", "") else (1.0, unit)


def round_off(value: float) -> float:
    """The largest of 1, 2, 5 times a power of ten that is not above a value."""
    power = 10.0 ** math.floor(math.log10(value))
    return power * max(factor for factor in (1, 2, 5) if factor * power <= value * (1 + 1e-12))
