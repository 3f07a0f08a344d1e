"""What the scripts share: histories and curves, which the package `hampm` reads, and how scripts end and tell what is wrong."""

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parent.parent / "tools"))
from stored import UNREADABLE, USAGE, ResultError, opened, printable  # noqa: F401  (the scripts take them from here)

from hampm.history import ERROR, OF_TIP, REST, History, error_name, is_error, is_rate, matches  # noqa: F401
from hampm.signals import Mode, first_frequency, fit_modes, lowpass, moving_mean, read_curve  # noqa: F401


def run(main):
    """Call main() as a program: its return value or a ResultError's code becomes the exit code."""
    try:
        sys.exit(main())
    except ResultError as error:
        sys.exit(report(error))
    except BrokenPipeError:  # the reader of our output, such as `head`, has seen enough
        sys.stderr.close()
        sys.exit(0)


def refuse_to_replace(output, files):
    """Refuse to write over a file that is read."""
    if Path(output).exists() and any(Path(output).samefile(path) for path in files):
        raise ResultError(f"{output}: is read, and is not replaced; name another file")


def report(error):
    """Print a ResultError for the user and return its exit code."""
    tell(error)
    return error.exit_code


def tell(message):
    """Print a message for the user, with the name of the script in front."""
    print(printable(f"{Path(sys.argv[0]).name}: {message}".encode(errors="replace").decode(), keep="\n"), file=sys.stderr)


def add_strict(parser):
    """The option of what gives static values."""
    parser.add_argument("--strict", action="store_true",
                        help=f"exit with code 1 where a run is not at rest: distance_to_equilibrium above {REST:g}")


def tell_of_motion(histories, strict):
    """Warn of each run whose last values are not those at rest. Returns the exit code."""
    moving = [history for history in histories if history.is_moving()]
    for history in moving:
        tell(f"warning: {history.path}: {history.motion()}; run longer, or damp more")
    return 1 if moving and strict else 0
