"""Picture of fatigue: growth per load cycle over the range of K, both logarithmic, with estimated errors; a curve for each tip.

It is `hampm plot g --column growth_rate --x delta_K --log --errors`, whose options it has.
"""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Sequence

from .pictures import write
from .plot_g import figure, parse as parse_curves


def main(arguments: Sequence[str] | None = None) -> None:
    write(figure, parse(arguments), "_rate")


def parse(arguments: Sequence[str] | None) -> Namespace:
    return parse_curves(arguments, __doc__, "_rate", column=["growth_rate"], x="delta_K", log=True, errors=True, label="growth per load cycle $da/dN$ [m]")
