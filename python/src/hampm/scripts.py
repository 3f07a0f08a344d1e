"""How the scripts of `postprocess/` and `batch/` end, and tell what is wrong."""

import sys
from argparse import ArgumentParser
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

from .errors import ResultError, printable

if TYPE_CHECKING:
    from .history import History


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
