"""The program: where it is, and how it is run."""

import json
import os
import shutil
import subprocess
from collections.abc import Iterable
from functools import cache
from pathlib import Path
from typing import Any

from .errors import FileError, Message, error_of

ROOT = Path(__file__).resolve().parents[3]   # of the checkout, or PREFIX/share/hampm of an installation
BUILT = ROOT / "build/release/hampm"


def find_program(program: str | Path | None = None) -> Path:
    """Path of the program: the one that is named, else by the environment variable HAMPM, else of the checkout in which this package is
    (`build/release/hampm`), or that has been installed with it (PREFIX/bin), else `hampm` in PATH."""
    if program is None:
        places = BUILT, *([ROOT.parent.parent / "bin/hampm"] if ROOT.parent.name == "share" else [])
        program = os.environ.get("HAMPM") or next((place for place in places if place.is_file()), None) or shutil.which("hampm")
    if program is None:
        raise FileError([Message("the program hampm is not found: build it with `make program`, or set HAMPM to its path")])
    path = Path(program)
    if not path.is_file():
        path = Path(shutil.which(str(program)) or program)
    if not path.is_file():
        raise FileError([Message("no such program", file=str(program))])
    return path.resolve()


def program_of_scripts() -> Path:
    """The program that scripts run when none is named; where there is none, the place of the one that would be built."""
    try:
        return find_program()
    except FileError:
        return BUILT


def call(words: Iterable[object], program: str | Path | None = None, cwd: str | Path | None = None) -> tuple[int, str, str]:
    """Run the program with these words to its end; exit code, standard output and standard error as text."""
    done = subprocess.run([find_program(program), *map(str, words)], cwd=cwd, capture_output=True, stdin=subprocess.DEVNULL)
    return done.returncode, done.stdout.decode(errors="replace"), done.stderr.decode(errors="replace")


def messages_of(said: str) -> tuple[list[Message], list[str]]:
    """The messages in what the program wrote to standard error: errors, and warnings without their word."""
    lines = [line.removeprefix("hampm: ") for line in said.splitlines() if line.strip()]
    errors = [Message(line) for line in lines if not line.startswith("warning: ")]
    return errors, [line.removeprefix("warning: ") for line in lines if line.startswith("warning: ")]


@cache
def _groups(program: Path) -> dict[str, Any]:
    code, text, said = call(["--keys", "--json"], program)
    if code != 0:
        raise error_of(code, messages_of(said)[0])
    try:
        return {group["group"]: group | {"keys": {key["key"]: key for key in group["keys"]}} for group in json.loads(text)}
    except (ValueError, TypeError, KeyError) as error:
        raise FileError([Message("is no hampm, or one of an earlier version: it does not tell its keys by --keys --json", file=str(program))]) from error


def key_table(program: str | Path | None = None) -> dict[str, Any]:
    """Group -> its description as `hampm --keys --json` has it, with its `keys` by name: type, unit, default, what is allowed, meaning."""
    return _groups(find_program(program))


def version(program: str | Path | None = None) -> str:
    """Version of the program."""
    return call(["--version"], program)[1].split()[-1]
