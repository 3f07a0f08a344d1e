"""What all pictures share: their look, the options for the file that is written, and words for files and units.

They are drawn without a display. Colours are Okabe and Ito's, told apart with any colour vision; the dashes keep curves
legible in grey.
"""

import argparse
import math
import textwrap
from collections import Counter
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

from history import UNREADABLE, ResultError, printable  # noqa: E402

COLOURS = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9"]
DASHES = ["-", (0, (6, 2)), (0, (3, 3)), (0, (6, 2, 1.2, 2)), (0, (1.2, 1.8)), (0, (9, 3))]
STYLE = {
    "font.size": 10, "axes.titlesize": 11, "legend.fontsize": 9, "axes.spines.top": False, "axes.spines.right": False,
    "axes.grid": True, "grid.color": "0.9", "grid.linewidth": 0.6, "axes.axisbelow": True, "lines.linewidth": 1.4,
    "svg.fonttype": "none", "pdf.fonttype": 42,
}
TIME_UNITS = {"s": (1.0, "s"), "ms": (1e3, "ms"), "us": (1e6, "µs")}
PREFIXES = {-4: "p", -3: "n", -2: "µ", -1: "m", 0: "", 1: "k", 2: "M", 3: "G"}  # by powers of 1000
MM = 1e3  # per metre
NO_BREAK, THIN_SPACE = "\u00a0", "\u2009"


def add_picture_options(parser, suffix):
    """Options of every picture; `suffix` is what the name of the first file gets by default, such as _G."""
    parser.add_argument("-o", "--output", type=picture, metavar="FILE",
                        help=f"picture to write, .png, .pdf or .svg (default: <first file>{suffix}.png beside it)")
    parser.add_argument("--dpi", type=positive, default=200, metavar="N", help="points per inch of a .png (default: %(default)g)")
    parser.add_argument("--title", metavar="TEXT", help="title of the picture")


def add_time_unit(parser):
    parser.add_argument("--time-unit", choices=TIME_UNITS, default="ms", help="unit of the time axis (default: ms)")


def time_axis(results, unit):
    """By what times are multiplied and what their axis is called: at rest they only tell how large the loads are."""
    if all(result.is_static for result in results):
        return 1.0, "time of the loads, at rest [s]"
    factor, unit = TIME_UNITS[unit]
    return factor, f"time $t$ [{unit}]"


def write(draw, options, suffix):
    """Draw a figure in the common style by draw() and save it as the options say; print where."""
    first = Path(options.files[0])
    output = Path(options.output or first.with_name(f"{first.stem}{suffix}.png"))
    with plt.rc_context(STYLE):
        save(draw(), output, options.dpi)
    print(output)


def save(figure, output, dpi):
    """Write a figure to a file or stream."""
    try:
        figure.savefig(output, dpi=dpi)
    except OSError as error:
        raise ResultError(f"{output}: cannot be written ({error.strerror})", UNREADABLE) from error
    finally:
        plt.close(figure)


def wrapped(words, unit, width=38):
    """The label of an axis, in lines of so many characters, with the unit whole on the last."""
    lines = textwrap.wrap(f"{words} [{unit.replace(' ', NO_BREAK)}]", width, break_long_words=False)
    return "\n".join(lines).replace(NO_BREAK, " ")


def legend_below(figure, handles, labels, narrow=42):
    """A legend under the figure, in two columns where labels are shorter than `narrow`; the rows it has."""
    across = 2 if max(map(len, labels)) < narrow else 1
    figure.legend(handles, labels, loc="outside lower center", ncols=across, frameon=False, handlelength=3.2)
    return -(-len(labels) // across)


def ending(suffix):
    """The type of an argument that names a file with this suffix."""
    def name(text):
        if Path(text).suffix != suffix:
            raise argparse.ArgumentTypeError(f"{text} does not end in {suffix}")
        return text
    return name


def positive(text):
    value = float(text)
    if not 0 < value < float("inf"):
        raise argparse.ArgumentTypeError(f"{text} is not a positive number")
    return value


def picture(text):
    if Path(text).suffix not in (".png", ".pdf", ".svg"):
        raise argparse.ArgumentTypeError(f"{text} does not end in .png, .pdf or .svg")
    return text


def names(results):
    """File stems, with the folder in front where stems are not enough to tell files apart."""
    count = Counter(result.stem for result in results)
    return [result.stem if count[result.stem] == 1 else printable(f"{result.path.resolve().parent.name}/{result.stem}")
            for result in results]


def picture_names(results):
    """The same for pictures."""
    return [verbatim(name) for name in names(results)]


def verbatim(text):
    """A text of a file or its name for a picture: no $ makes a formula of it, and a legend shows one that begins with _ too."""
    text = printable(text).replace("$", r"\$")
    return THIN_SPACE + text if text.startswith("_") else text


def prefixed(largest, unit):
    """Factor and unit with a prefix that bring a largest value to between 1 and 1000; 1 and the unit where none fits."""
    power = math.floor(math.log10(largest) / 3 + 1e-9) if largest > 0 and math.isfinite(largest) else 0
    return (1e3**-power, PREFIXES[power] + unit) if power in PREFIXES and unit not in ("1", "") else (1.0, unit)


def round_off(value):
    """The largest of 1, 2, 5 times a power of ten that is not above a value."""
    power = 10.0 ** math.floor(math.log10(value))
    return power * max(factor for factor in (1, 2, 5) if factor * power <= value * (1 + 1e-12))
