"""Report of one or more hampm runs as one HTML file that needs no other: results, pictures and the scene as it was used.

For each run: how far it came, the energy release rates at its end and their peaks beside references, with their estimated errors
where the file holds them, how its cracks have grown, energies and how their balance closes, the pictures of G(t), growth, paths, energy,
mesh and energy density as far as the result file holds what they show, what a reader should know before trusting it, version and host, and the namelist. Several
runs are compared in a table and a picture at the top. A run with damping that is not at rest is named; --strict means all runs.
"""

from __future__ import annotations

import base64
import io
import re
from argparse import Namespace
from collections.abc import Callable, Iterable, Iterator, Sequence
from html import escape
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from ..columns import symbol
from ..errors import UNREADABLE, ResultError
from ..history import History
from ..scripts import Parser, add_strict, tell_of_motion
from ..stored import opened
from ..stored_model import StoredModel
from . import plot_energy
from . import plot_field
from . import plot_front
from . import plot_g
from . import plot_mesh
from . import plot_path
from .frames import Frames, frames_of
from .growing_tips import GrowingTip, growing_tips
from .pictures import MM, STYLE, ending, names, plt, positive, save

PART = 0.1      # last part of the run that the means are taken over
SPREAD = 0.05   # of J over its domains, above which it is worth a notice
LOSS = 0.1      # of the energy to the method, likewise
OF_CRACK = re.compile(r"(J|J_domain_dependence|K_I{1,3})(_(tip|front)\d+)?$")  # columns that are tabulated beside G
WINDOW = 5      # half width of what is shown around a crack tip, in root cells
PAGE = """<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>{title}</title><style>
body {{ font: 15px/1.45 sans-serif; max-width: 62em; margin: 2em auto; padding: 0 1em; color: #222 }}
table {{ border-collapse: collapse; margin: 0.6em 0 }}
td, th {{ padding: 0.15em 0.9em 0.15em 0; text-align: left; border-bottom: 1px solid #ddd }}
td + td, th + th {{ text-align: right }} img {{ max-width: 100% }}
.notice {{ color: #a33c00 }} pre {{ background: #f5f5f5; padding: 0.8em }}
</style></head><body>
{body}
</body></html>
"""


def main(arguments: Sequence[str] | None = None) -> int:
    options = parse(arguments)
    runs = [Run(path) for path in options.files]
    title = options.title or ", ".join(dict.fromkeys(item.title for item in runs))
    output = Path(options.output or runs[0].path.with_name(f"{runs[0].path.stem}_report.html"))
    body = [f"<h1>{escape(title)}</h1>", *(comparison(runs, options.dpi) if len(runs) > 1 else [])]
    for item, name in zip(runs, names([item.history for item in runs])):
        body += section(item, name, options.dpi)
    try:
        output.write_text(PAGE.format(title=escape(title), body="\n".join(body)), encoding="utf-8")
    except OSError as error:
        raise ResultError(f"{output}: cannot be written ({error.strerror})", UNREADABLE) from error
    print(output)
    moving = [item.history for item in runs if options.strict or item.is_damped()]
    return tell_of_motion(moving, options.strict)


def parse(arguments: Sequence[str] | None) -> Namespace:
    parser = Parser(__doc__)
    parser.add_argument("files", nargs="+", metavar="FILE.h5", help="result file of hampm")
    parser.add_argument("-o", "--output", type=ending(".html"), metavar="FILE.html",
                        help="report to write (default: <first file>_report.html beside it)")
    parser.add_argument("--dpi", type=positive, default=110, metavar="N",
                        help="points per inch of the pictures (default: %(default)g)")
    parser.add_argument("--title", metavar="TEXT", help="title of the report (default: that of the scene)")
    add_strict(parser)
    return parser.parse_args(arguments)


class Run:
    """A result file: its history, scene, energies, what wrote it, and its snapshots, None where it has none."""

    def __init__(self, path: str | Path) -> None:
        self.path, self.history = Path(path), History(path)
        with opened(path) as stored:
            if not stored.has("input/namelist"):
                raise ResultError(f"{path}: has no dataset /input/namelist: not a result file", UNREADABLE)
            self.namelist = stored.text("input/namelist")
            self.origin = {name: str(value) for name, value in stored.attributes("input").items() if name != "compiler_options"}
        self.scene = StoredModel(self.namelist, path)
        self.title = self.scene.text("run", "title") or self.path.stem
        self.balance = plot_energy.Balance(self.history)
        self.frames: Any = snapshots(path)
        self.tips = growing_tips(self.history)

    def last(self, column: str) -> float:
        return self.history.columns[column][-1]

    def count(self, column: str) -> str:
        """The last value of a column of whole numbers, in words."""
        return whole(self.last(column)) if column in self.history.columns else "–"

    def mean(self, column: str) -> float:
        """Mean over the last part of the run."""
        return self.history.late_mean(column, PART)

    def peak(self, column: str) -> int:
        """Number of the sample in which a column is largest, whatever its sign."""
        values = np.abs(self.history.columns[column])
        return int(np.argmax(np.where(np.isfinite(values), values, -1.0)))

    def rates(self) -> list[str]:
        """Names of the columns that are energy release rates."""
        return [name for name in self.history.columns if plot_g.is_estimator(name)]

    def is_damped(self) -> bool:
        """Whether the bodies are brought to rest, so that the last values are meant as those at rest."""
        return any(self.scene.numbers("damping", "rate"))


def snapshots(path: str | Path) -> Frames | None:
    try:
        return frames_of(path)
    except ResultError:
        return None


def comparison(runs: Sequence[Run], dpi: float) -> list[str]:
    """All runs beside each other: the means of G at the end, the work that they were, and the curves."""
    columns = list(dict.fromkeys(name for item in runs for name in item.rates()))
    heading = ["run", *(symbol(name) for name in columns), "particles", "steps"]
    rows = [[name, *(value_of(item, column) for column in columns), item.count("particles"), item.count("step")]
            for item, name in zip(runs, names([item.history for item in runs]))]
    lines = [table([heading, *rows]), f"<p>G: means over the last {PART:.0%} of the run, over G_ref where there is one.</p>"]
    drawable = [item.history for item in runs if item.rates()]
    with_reference = [history for history in drawable if "G_ref" in history.attributes]
    return lines + (curves(with_reference or drawable, dpi) if drawable else [])


def value_of(item: Run, column: str) -> str:
    if column not in item.history.columns:
        return "–"
    g_ref, error = item.history.g_scale(), item.history.error_of(column)
    return with_error(item.mean(column) / g_ref, item.mean(error) / g_ref if error else None)


def with_error(value: float, error: float | None) -> str:
    """A value as text, with its estimated error where that is known."""
    return f"{value:.5g}" + (f" ± {error:.2g}" if error is not None else "")


def section(item: Run, name: str, dpi: float) -> list[str]:
    """The report of one run."""
    lines = [f"<h2>{escape(name)}: {escape(item.title)}</h2>",
             *(f'<p class="notice">{escape(text)}.</p>' for text in notices(item)), table(extent(item))]
    if item.rates():
        lines += ["<h3>Energy release rate</h3>", table(release_rates(item)), *curves([item.history], dpi), *along_fronts(item, dpi)]
    if item.tips:
        lines += ["<h3>Growth</h3>", table(growth(item)), table(price(item)), *growth_pictures(item, dpi)]
    lines += ["<h3>Energy</h3>", table(energies(item)),
              picture(lambda: plot_energy.draw([item.balance], plot_energy.parse([str(item.path)])), "energies over time", dpi)]
    if item.frames:
        lines += ["<h3>Last snapshot</h3>", *last_snapshot(item, dpi)]
    return [*lines, "<h3>Program</h3>", table(item.origin.items()), "<h3>Scene as it was used</h3>",
            f"<pre>{escape(item.namelist.strip())}</pre>"]


def extent(item: Run) -> Iterator[tuple[str, ...]]:
    """How far the run came, and how large it was."""
    history = item.history
    if history.is_static:
        yield "kind", "equilibrium at rest; times tell how large the loads are"
    yield "time reached", f"{history.times[-1]:.6g} s"
    end = item.scene.numbers("run", "end_time")
    yield "end_time of the scene", f"{end[0]:.6g} s" if end else "–"
    if "dt" in history.columns and not history.is_static:
        steps = history.columns["dt"][history.columns["dt"] > 0]
        yield "time step, least and largest", f"{steps.min():.4g} s, {steps.max():.4g} s" if steps.size else "–"
    for column, words in [("step", "steps"), ("particles", "particles, first and last"), ("cells", "cells, first and last")]:
        if column in history.columns:
            first, last = history.columns[column][[0, -1]]
            yield "load steps" if column == "step" and history.is_static else words, whole(last) if column == "step" else f"{whole(first)}, {whole(last)}"
    if "finest_cell" in history.columns:
        yield "smallest occupied cell", f"{item.last('finest_cell'):.4g} m"
    if (distance := history.distance_to_equilibrium()) is not None:
        yield "distance to equilibrium, relative", f"{distance:.2g}"


def release_rates(item: Run) -> Iterator[tuple[str, ...]]:
    """Last value, mean and peak of each estimator, of K and the spread of J, and the references."""
    history, g_ref = item.history, item.history.attributes.get("G_ref")
    yield "quantity", "last value", f"mean of the last {PART:.0%}", "mean over G_ref", "peak", "at time [s]"
    for name in [*item.rates(), *filter(OF_CRACK.match, history.columns)]:
        values, error, peak = history.columns[name], history.error_of(name), item.peak(name)
        errors = history.columns[error] if error else [None] * values.size
        tip = re.sub(r"_(tip|front)", r", \1 ", plot_g.tip_of(name))
        yield (f"{history.long_names[name]}{tip} [{history.units[name]}]", with_error(values[-1], errors[-1]),
               with_error(item.mean(name), item.mean(error) if error else None),
               value_of(item, name) if g_ref and not name.startswith("K") else "–",
               with_error(values[peak], errors[peak]), f"{history.times[peak]:.5g}")
    if g_ref:
        yield "G_ref [J/m2]", f"{g_ref:.5g}", "–", "1", "–", "–"
    if g_ref and (beam := history.beam_ratio()) is not None:
        yield "beam on elastic foundation, (33) [J/m2]", f"{beam * g_ref:.5g}", "–", f"{beam:.5g}", "–", "–"


def growth(item: Run) -> Iterator[tuple[Any, ...]]:
    """How each tip has grown."""
    yield ("tip", "crack, first [m]", "crack, last [m]", "place at the end [m]", "starts at [s]", "at rest from [s]",
           "largest mean speed over a cell [m/s]", "mean G/toughness in growth")
    for tip in item.tips:
        length, starts, rests = tip.column("crack_length"), tip.starts(), tip.rests()
        yield (tip.number, f"{length[0]:.6g}", f"{length[-1]:.6g}", f"{tip.places[-1, 0]:.5g}, {tip.places[-1, 1]:.5g}",
               *("–" if time is None else f"{time:.5g}" for time in (starts, rests)),
               f"{tip.mean_speed().max():.5g}" if tip.has("tip_speed") else "–",
               drive(tip))


def price(item: Run) -> Iterator[tuple[str, ...]]:
    """What growth took, and by what the loads are multiplied at the end."""
    history = item.history
    for name, words in [("load_factor", "factor of the loads"), ("fracture_energy", "energy dissipated by growth"),
                        ("integral_of_G", "integral of G over their area")]:
        if name in history.columns:
            yield words, f"{history.columns[name][-1]:.5g}" + (f" {history.units[name]}" if history.units[name] != "1" else "")


def drive(tip: GrowingTip) -> str:
    """Mean of G over toughness, with the greatest distance from 1, over the samples in which a tip grows by its toughness."""
    if not (tip.has("toughness") and tip.has("G")):
        return "–"
    grows = np.any(np.diff(tip.places, axis=0, append=tip.places[-1:]) != 0, axis=1) & (tip.column("toughness") > 0)
    ratio = tip.column("G")[grows] / tip.column("toughness")[grows]
    return f"{np.mean(ratio):.4g} (within {np.max(np.abs(ratio - 1)):.2g} of 1)" if ratio.size and np.all(np.isfinite(ratio)) else "–"


def growth_pictures(item: Run, dpi: float) -> Iterator[str]:
    file = str(item.path)
    yield picture(lambda: plot_g.draw([item.history], plot_g.parse([file, "--growth"])), "growth over time", dpi)
    if item.frames:
        options = plot_path.parse([file])
        yield picture(lambda: plot_path.draw(item.frames, [item.history], [], options), "paths of the cracks", dpi)


def energies(item: Run) -> Iterator[tuple[str, ...]]:
    """Energies at the end, and how they balance."""
    balance = item.balance
    yield "energy", "at the end [J]", "of the largest [%]"
    parts = {plot_energy.WORDS[name]: values for name, values in balance.parts.items()}
    for words, values in ({"supplied: work and initial energy": balance.supplied} | parts).items():
        yield words, f"{values[-1]:.5g}", f"{100 * values[-1] / balance.largest:.4g}"
    if balance.missing is not None:
        yield "not accounted for, at most", f"{balance.missing * balance.largest:.2g}", f"{100 * balance.missing:.2g}"


def notices(item: Run) -> Iterator[str]:
    """What a reader should know before trusting the run."""
    told = item.history.attributes
    if told.get("ended", "done") != "done":
        yield f"The computation failed: {told['ended']}"
    yield from told.get("warnings", "").splitlines()
    end = item.scene.numbers("run", "end_time")
    if end and item.history.times[-1] < end[0] * (1 - 1e-6):
        yield f"The run ended at {item.history.times[-1]:.6g} s, before its end_time of {end[0]:.6g} s"
    if item.is_damped() and item.history.is_moving():
        yield item.history.motion().capitalize()
    if bad := [name for name, values in item.history.columns.items() if not np.all(np.isfinite(values))]:
        yield f"Not finite somewhere: {', '.join(bad)}"
    loss = item.balance.parts["numerical_loss"] / item.balance.largest
    if (worst := loss[np.argmax(np.abs(loss))]) and abs(worst) > LOSS:
        yield f"The method {'lost' if worst > 0 else 'gained'} {abs(worst):.0%} of the largest energy"
    if "J_domain_dependence" in item.history.columns and abs(j := item.mean("J")) > 0 and (spread := item.mean("J_domain_dependence") / abs(j)) > SPREAD:
        yield f"J differs by {spread:.0%} between its domains: the field around the tip is not resolved, or the discs reach too far"
    if item.frames is None:
        yield "The file holds no snapshots (snapshot_interval in &output), so there are no pictures of mesh and fields"


def curves(histories: Sequence[History], dpi: float) -> list[str]:
    options = plot_g.parse(["--errors", *(str(history.path) for history in histories)])
    return [picture(lambda: plot_g.draw(histories, options), "G over time", dpi)]


def along_fronts(item: Run, dpi: float) -> Iterator[str]:
    """G along each crack front of a solid, at the end."""
    with opened(item.path) as stored:
        fronts = sum(name.startswith("arc") for name in stored.names("front"))
    for number in range(1, fronts + 1):
        options = plot_front.parse([str(item.path), "--number", str(number)])
        yield picture(lambda: plot_front.draw_measured(plot_front.measured(options)[1], options), "G along the front", dpi)


def last_snapshot(item: Run, dpi: float) -> Iterator[str]:
    """Energy density, around a crack tip too, and the mesh there below R where the mesh follows it."""
    file, window = str(item.path), ["--window", str(WINDOW * item.scene.cell() * MM)]

    def field(words: str, *arguments: str) -> str:
        return picture(lambda: plot_field.draw([item.frames], plot_field.parse([file, "--log", *arguments])), words, dpi)

    yield field("energy density")
    if item.frames.crack_plane():
        yield field("energy density around the crack tip", *window)
    if item.frames.crack_plane() and item.scene.text("refine", "indicator") == "gradient":
        yield picture(lambda: plot_mesh.draw([item.frames], plot_mesh.parse([file, *window])), "mesh around the crack tip", dpi)


def picture(draw: Callable[[], Figure], words: str, dpi: float) -> str:
    """A figure as an image within the page."""
    stream = io.BytesIO()
    with plt.rc_context(STYLE):
        save(draw(), stream, dpi)
    return f'<p><img alt="{words}" src="data:image/png;base64,{base64.b64encode(stream.getvalue()).decode()}"></p>'


def table(rows: Iterable[Iterable[Any]]) -> str:
    """Rows of text; the first is a heading where it has more than two columns."""
    cells = [[escape(str(word)) for word in row] for row in rows]
    kinds = ["th" if len(row) > 2 and k == 0 else "td" for k, row in enumerate(cells)]
    return "<table>\n" + "\n".join("<tr>" + "".join(f"<{kind}>{word}</{kind}>" for word in row) + "</tr>"
                                   for kind, row in zip(kinds, cells)) + "\n</table>"


def whole(value: float) -> str:
    return f"{value:,.0f}".replace(",", " ")
