"""Picture of where the energy of one or more hampm runs goes over time, and of how the balance closes: a column for each file.

Above: the energy supplied (external work, and what the bodies had at the start), and what has become of it: kinetic and strain
energy, the losses to damping and to the method. Below: the loss to the method, in percent of the largest energy supplied or stored.
With `energy_balance` it is booked term by term and the title says what the sum misses; without, it is what the
sum misses.
"""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..history import History
from .pictures import COLOURS, DASHES, add_time_unit, name_curves, picture_names, picture_parser, plt, prefixed, time_axis, write

PARTS = ("kinetic_energy", "strain_energy", "damping_loss", "numerical_loss", "fracture_energy")
WORDS = {"kinetic_energy": "kinetic energy", "strain_energy": "strain energy", "damping_loss": "taken by damping",
         "numerical_loss": "lost by the method", "fracture_energy": "dissipated by growth"}
SOME_LACK = ("numerical_loss", "fracture_energy")
LEAST = 1e-3  # loss to which the lower axis reaches at least [%]: rounding is not shown as if it were one


def main(arguments: Sequence[str] | None = None) -> None:
    write(figure, parse(arguments), "_energy")


def figure(options: Namespace) -> Figure:
    """The picture that these options ask for."""
    return draw([Balance(History(path)) for path in options.files], options)


def parse(arguments: Sequence[str] | None) -> Namespace:
    parser = picture_parser(__doc__, "_energy")
    parser.add_argument("--relative", action="store_true", help="divide by the largest energy supplied or stored")
    parser.add_argument("--stacked", action="store_true", help="stack what has become of the energy as areas")
    add_time_unit(parser)
    return parser.parse_args(arguments)


class Balance:
    """The energies of a run over time [J].

    supplied   external work and the energy at the start
    parts      what has become of it by name: those of PARTS, `numerical_loss` as booked or else what the others miss
    largest    of what was supplied or stored
    missing    what the parts miss of `supplied` at most, over `largest`; None where `numerical_loss` is not booked
    """

    def __init__(self, history: History) -> None:
        self.stem, self.path, self.times, self.history = history.stem, history.path, history.times, history
        booked = [name for name in PARTS if name not in SOME_LACK or name in history.columns]
        columns = {name: history.columns[name] for name in history.select([*booked, "external_work"])}
        stored = columns["kinetic_energy"] + columns["strain_energy"]
        work = columns.pop("external_work")
        self.supplied = work - work[0] + stored[0]  # at rest the first row is loaded already
        self.parts = columns
        self.largest = max(np.abs(self.supplied).max(), stored.max(), np.finfo(float).tiny)
        rest = self.supplied - sum(columns.values())
        self.missing = np.abs(rest).max() / self.largest if "numerical_loss" in columns else None
        self.parts.setdefault("numerical_loss", rest)


def draw(balances: Sequence[Balance], options: Namespace) -> Figure:
    """The figure: a column for each result, energies above the loss to the method."""
    figure, axes = plt.subplots(2, len(balances), figsize=(3.4 + 4.6 * len(balances), 5.6), squeeze=False, sharex="col",
                                sharey="row", height_ratios=(1, 0.4), layout="constrained")
    largest = max(balance.largest for balance in balances)
    factor, unit = prefixed(largest, "J")
    for balance, name, (upper, lower) in zip(balances, picture_names(balances), axes.T):
        scale, label = time_axis([balance.history], options.time_unit)
        draw_parts(upper, balance, scale, 1 / balance.largest if options.relative else factor, options.stacked)
        upper.set_title(f"{name}\n{closure(balance)}")
        loss = 100 * balance.parts["numerical_loss"] / balance.largest
        lower.plot(balance.times * scale, loss, color=look("numerical_loss")["color"], linewidth=1.0)
        lower.set_xlim(0, balance.times[-1] * scale or None)
        lower.set_xlabel(label)
    axes[0, 0].set_ylabel("energy over the largest [–]" if options.relative else f"energy [{unit}]")
    low, high = axes[1, 0].get_ylim()
    axes[1, 0].set(ylabel="lost by the\nmethod [%]", ylim=(min(low, -LEAST), max(high, LEAST)))
    if options.title:
        figure.suptitle(options.title)
    name_curves(figure, axes[0, -1:])
    return figure


def draw_parts(axes: Axes, balance: Balance, scale: float, factor: float, stacked: bool) -> None:
    """What was supplied as a line, and what has become of it as lines or as areas on each other."""
    times = balance.times * scale
    if stacked:
        axes.stackplot(times, *(factor * values for values in balance.parts.values()), alpha=0.55, linewidth=0,
                       labels=[WORDS[name] for name in balance.parts], colors=[look(name)["color"] for name in balance.parts])
    else:
        for name, values in balance.parts.items():
            axes.plot(times, factor * values, label=WORDS[name], **look(name))
    axes.plot(times, factor * balance.supplied, color="black", linewidth=1.0, label="supplied: work and initial energy")


def look(name: str) -> dict[str, Any]:
    """Colour and dash of a part."""
    return {"color": COLOURS[PARTS.index(name)], "linestyle": DASHES[PARTS.index(name)]}


def closure(balance: Balance) -> str:
    """How the balance closes, in words."""
    if balance.missing is None:
        return "losses of the method not booked"
    return f"the balance closes to {balance.missing:.0e} of the largest"
