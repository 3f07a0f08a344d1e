"""Write the history of a hampm result as text, time and the columns asked for, in full precision; or its snapshots for ParaView (-o A.pvd)."""

from __future__ import annotations

import sys
from argparse import Namespace
from collections.abc import Iterable, Iterator, Sequence
from contextlib import nullcontext
from typing import Any

from ..errors import UNREADABLE, ResultError
from ..history import History
from ..scripts import Parser, refuse_to_replace
from ..snapshots import Snapshots


def main(arguments: Sequence[str] | None = None) -> None:
    options = parse(arguments)
    if options.output.endswith(".pvd"):
        return write_series(options)
    history = History(options.file, may_be_empty=True)
    if options.normalised:
        history.g_ref()
    lines: Iterable[Any]
    if options.attribute:
        lines = [attribute(history, options.attribute, options.normalised)]
    else:
        names = [name for name in history.select(options.columns) if name != "time"]
        lines = names if options.list else table(history, ["time", *names], options.normalised)
    refuse_to_replace(options.output, [options.file])
    try:
        with nullcontext(sys.stdout) if options.output == "-" else open(options.output, "w") as stream:
            stream.writelines(f"{line}\n" for line in lines)
            stream.flush()
    except BrokenPipeError:
        raise
    except OSError as error:
        raise ResultError(f"{options.output}: cannot be written ({error.strerror})", UNREADABLE) from error


def write_series(options: Namespace) -> None:
    """The snapshots for ParaView."""
    given = [word for word, is_given in (("--columns", options.columns != ["*"]), ("--normalised", options.normalised), ("--list", options.list),
                                         ("--attribute", options.attribute)) if is_given]
    if given:
        raise ResultError(f"{given[0]}: is of the history, and a .pvd has the snapshots")
    try:
        Snapshots(options.file).to_paraview(options.output)
    except OSError as error:
        raise ResultError(f"{options.output}: cannot be written ({error.strerror})", UNREADABLE) from error


def parse(arguments: Sequence[str] | None) -> Namespace:
    parser = Parser(__doc__)
    parser.add_argument("file", metavar="FILE.h5", help="result file of hampm")
    parser.add_argument("--columns", nargs="+", default=["*"], metavar="NAME",
                        help="columns to write after the time, * and ? allowed (default: all)")
    parser.add_argument("-o", "--output", default="-", metavar="FILE",
                        help="text file to write (default: -, standard output); a .pvd has the snapshots, as ParaView before 5.13 reads them")
    parser.add_argument("--normalised", action="store_true", help="divide every G_* by G_ref")
    other = parser.add_mutually_exclusive_group()
    other.add_argument("--list", action="store_true", help="write only the names of the columns, one a line")
    other.add_argument("--attribute", metavar="NAME", help="write only this attribute of /history")
    return parser.parse_args(arguments)


def table(history: History, names: Sequence[str], normalised: bool) -> Iterator[str]:
    """The header, `# time [s] ...`, and one line for every sample."""
    ratio = {name: normalised and name.startswith("G_") for name in names}
    columns = [history.g_ratio(name) if ratio[name] else history.columns[name] for name in names]
    yield "# " + " ".join(f"{name} [{'1' if ratio[name] else history.units[name]}]" for name in names)
    for row in zip(*(column.tolist() for column in columns)):
        yield " ".join(map(repr, row))


def attribute(history: History, name: str, normalised: bool) -> Any:
    """Value of an attribute of /history."""
    if name not in history.attributes:
        raise ResultError(f"{history.path}: /history has no attribute '{name}'; it has {', '.join(history.attributes)}")
    value = history.attributes[name]
    return value / history.g_ref() if normalised and name.startswith("G_") else value
