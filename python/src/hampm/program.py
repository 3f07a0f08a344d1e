"""The programs, of the plane and for solids: where they are, and how they are run."""

import json
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterable
from functools import cache
from pathlib import Path
from typing import Any

from .errors import FileError, Message, error_of

ROOT = Path(__file__).resolve().parents[3]   # of the checkout, or PREFIX/share/hampm of an installation
BUILT = ROOT / "build/release/hampm"
PACKED = Path(__file__).resolve().parent / "bin"    # of a wheel
SOLID = 3           # dimensions of the models of the program for solids
NUMBER = r"[-+]?\.?\d[-+.\ded]*"
PLACES = re.compile(rf"&(?:grid\b[^/&]*?\bcells|body\b[^/&]*?\b(?:lower|center))\s*=\s*({NUMBER}(?:[\s,]+{NUMBER})*)", re.IGNORECASE)


def find_program(program: str | Path | None = None, dimensions: int = 2) -> Path:
    """Path of the program: the one that is named, else by the environment variable HAMPM, else the one that is in this package, where a wheel
    has brought it, else of the checkout in which this package is (`build/release/hampm`), or that has been installed with it (PREFIX/bin),
    else `hampm` in the environment of this Python, else in PATH. Models in three dimensions are of the program for solids: HAMPM3D,
    `build/release3d/hampm3d`, or `hampm3d` in these places."""
    if program is None:
        name, variable, built, how = ("hampm", "HAMPM", BUILT, "make program") if dimensions < SOLID else \
            ("hampm3d", "HAMPM3D", ROOT / "build/release3d/hampm3d", "make program dim=3")
        places = PACKED / name, built, *([ROOT.parent.parent / "bin" / name] if ROOT.parent.name == "share" else []), Path(sys.prefix, "bin", name)
        program = os.environ.get(variable) or next((place for place in places if place.is_file()), None) or shutil.which(name)
        if program is None:
            raise FileError([Message(f"the program {name} is not found: build it with `{how}`, or set {variable} to its path")])
    path = Path(program)
    if not path.is_file():
        path = Path(shutil.which(str(program)) or program)
    if not path.is_file():
        raise FileError([Message("no such program", file=str(program))])
    return path.resolve()


def dimensions_of(namelist: str) -> int:
    """Of the model of a namelist: 3 where its grid has as many numbers of cells, or a body a place of as many."""
    found = PLACES.findall("\n".join(line.partition("!")[0] for line in namelist.splitlines()))
    return SOLID if any(len(re.split(r"[\s,]+", values)) == SOLID for values in found) else 2


def program_of_model(namelist: str | Path) -> Path:
    """The program that runs the model of a file."""
    return find_program(dimensions=dimensions_of(Path(namelist).read_text(errors="replace")))


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
    try:
        return _groups(find_program(program))
    except FileError as missing:
        if program is not None:
            raise
        try:
            return _groups(find_program(dimensions=SOLID))     # which has the same keys
        except FileError:
            raise missing from None                        # the one that is not there, unless both are


def version(program: str | Path | None = None) -> str:
    """Version of the program."""
    return call(["--version"], program)[1].split()[-1]
