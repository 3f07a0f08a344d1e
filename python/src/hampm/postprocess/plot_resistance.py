"""Picture of the resistance of a crack that grows: G with its estimated error, and the toughness, over the extension; for each tip.

It is `hampm plot g --column G --column toughness --x extension --errors`, whose options it has.
"""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Sequence

from .pictures import write
from .plot_g import figure, parse as parse_curves


def main(arguments: Sequence[str] | None = None) -> None:
    write(figure, parse(arguments), "_resistance")


def parse(arguments: Sequence[str] | None) -> Namespace:
    return parse_curves(arguments, __doc__, "_resistance", column=["G", "toughness"], x="extension", errors=True)
