"""How commands end, and tell what is wrong: those of the package, which `postprocess/` and `batch/` stand for."""

import sys
from argparse import ArgumentParser, ArgumentTypeError, Namespace, RawDescriptionHelpFormatter
from collections.abc import Callable, Iterable, Mapping, Sequence
from difflib import get_close_matches
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

from .errors import ResultError, printable

if TYPE_CHECKING:
    from .history import History


class Asked(list[str]):
    """What a function is asked for in place of a command line: names of files, and options by name, whose mistakes are exceptions."""

    def __init__(self, what: str, files: Iterable[str], options: Mapping[str, Any]):
        super().__init__(files)
        self.what, self.options = what, options


class Parser(ArgumentParser):
    """Reads a command line, or what a function is asked for."""

    _asked: Asked | None = None

    def __init__(self, description: str | None):
        super().__init__(description=description, formatter_class=RawDescriptionHelpFormatter)

    def parse_args(self, args: Sequence[str] | None = None, namespace: Any = None) -> Namespace:  # type: ignore[override]
        """The values of all options."""
        if not isinstance(args, Asked):
            return super().parse_args(args, namespace)
        self._asked = args
        return super().parse_args([*(word for name, value in args.options.items() for word in self._words(name, value)), "--", *args], namespace)

    def error(self, message: str) -> NoReturn:
        """Tell of a mistake: to the terminal, or to the function that asks."""
        if self._asked is None:
            super().error(message)
        raise ResultError(f"{self._asked.what}: {message}")

    def _words(self, name: str, value: Any) -> list[str]:
        """An option as words of a command line: one for true, none for false and None, several for what may be repeated."""
        known = {option.lstrip("-").replace("-", "_"): action for action in self._actions for option in action.option_strings}
        if name not in known:
            close = get_close_matches(name, known, 1)
            self.error(f"there is no option '{name}'; " + (f"did you mean '{close[0]}'?" if close else f"there are {', '.join(known)}"))
        option = known[name].option_strings[-1]
        if value is None or value is False:
            return []
        if known[name].nargs == 0:
            return [option]
        values = [value] if isinstance(value, (str, Path)) or not isinstance(value, Iterable) else list(value)
        if type(known[name]).__name__ == "_AppendAction":
            return [f"{option}={item}" for item in values]
        return [option, *map(str, values)] if known[name].nargs else [f"{option}={','.join(map(str, values))}"]


def whole(text: str) -> int:
    """A whole number above zero, of an option."""
    if not text.isdecimal() or int(text) == 0:
        raise ArgumentTypeError(f"{text} is no whole number above zero")
    return int(text)


def run(main: Callable[[], int | None]) -> NoReturn:
    """Call main() as a program: its return value or a ResultError's code becomes the exit code."""
    try:
        sys.exit(main())
    except ResultError as error:
        tell(error)
        sys.exit(error.exit_code)
    except BrokenPipeError:  # the reader of our output, such as `head`, has seen enough
        sys.stderr.close()
        sys.exit(0)


def tell(message: object) -> None:
    """Print a message for the user, with the name of the script in front."""
    print(printable(f"{Path(sys.argv[0]).name}: {message}".encode(errors="replace").decode(), keep="\n"), file=sys.stderr)


def refuse_to_replace(output: str | Path, files: Iterable[str | Path]) -> None:
    """Refuse to write over a file that is read."""
    if Path(output).exists() and any(Path(output).samefile(path) for path in files):
        raise ResultError(f"{output}: is read, and is not replaced; name another file")


def add_strict(parser: ArgumentParser) -> None:
    """The option of what gives static values."""
    from .history import REST
    parser.add_argument("--strict", action="store_true",
                        help=f"exit with code 1 where a run is not at rest: distance_to_equilibrium above {REST:g}")


def tell_of_motion(histories: "Iterable[History]", strict: bool) -> int:
    """Warn of each run whose last values are not those at rest. Returns the exit code."""
    moving = [history for history in histories if history.is_moving()]
    for history in moving:
        tell(f"warning: {history.path}: {history.motion()}; run longer, or damp more")
    return 1 if moving and strict else 0
