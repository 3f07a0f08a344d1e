"""The columns of results: unit, meaning and symbol of each, as docs/reference/results.md lists them."""

import json
import re
from dataclasses import dataclass
from difflib import get_close_matches
from functools import cache
from pathlib import Path
from typing import Any

from .errors import ColumnError

SYMBOL = re.compile(r"(G|J|K)(?:_(.*?))??(?:_(I{1,3}|\d+))?((?:_(?:tip|front)\d+)?)$")
SYMBOLS = {"delta_K": r"$\Delta K$", "growth_rate": "$da/dN$", "ratio_of_K": r"$K_\mathrm{min}/K_\mathrm{max}$"}
ENDING = re.compile(r"_(tip|front|crack)\d+$")


@dataclass(frozen=True)
class Column:
    """A column of a history, or of the values along a front.

    name      as it was asked for
    unit      '1' where it has none
    meaning   in words
    recorded  in which runs
    symbol    for pictures, with formulas between $
    """

    name: str
    unit: str
    meaning: str
    recorded: str
    symbol: str

    def __str__(self) -> str:
        return f"{self.name} [{self.unit}]: {self.meaning} ({self.recorded})"


def describe(name: str) -> Column:
    """Unit, meaning and symbol of a column by its name, such as "K_I" or "G_error_tip2"; `KeyError` where no run has it."""
    base = ENDING.sub("", name)
    for known in _table():
        if re.fullmatch(re.sub("<name>", r".+", known["name"]), base):
            return Column(name, known["unit"], known["meaning"], known["recorded"], symbol(name))
    if base.endswith("_error"):
        of = describe(base.removesuffix("_error"))
        return Column(name, of.unit, f"estimated error of {of.name}", of.recorded, symbol(name))
    close = get_close_matches(base, [known["name"] for known in _table()], 1)
    raise ColumnError(f"there is no column '{name}'" + (f"; did you mean '{close[0]}'?" if close else "; docs/reference/results.md lists them"))


def symbol(name: str) -> str:
    """A column as it is written in a picture: K_I -> $K_{\\mathrm{I}}$, G_vcct_I_tip2 -> $G_{\\mathrm{I}}$ VCCT, tip 2."""
    found = SYMBOL.match(name)
    if (base := ENDING.sub("", name)) in SYMBOLS:
        return SYMBOLS[base] + re.sub(r".*_(tip|front|crack)(\d+)$", r", \1 \2", name.removeprefix(base))
    tip = ENDING.search(name)
    ending = tip[0] if tip else ""
    if found and not name.removesuffix(ending).endswith("_error"):
        letter, more, part, _ = found.groups()
        shown = f"${letter}_{{\\mathrm{{{part}}}}}$" if part else f"${letter}$"
        shown += " " + more.replace("_", " ").replace("vcct", "VCCT") if more else ""
    else:
        shown = name.removesuffix(ending).replace("_", " ")
    return shown + re.sub(r"_(tip|front|crack)(\d+)", r", \1 \2", ending)


@cache
def _table() -> list[dict[str, Any]]:
    return json.loads((Path(__file__).parent / "columns.json").read_text(encoding="utf-8"))
