"""The program: where it is, and how it is run."""

import json
import os
import shutil
import subprocess
from functools import cache
from pathlib import Path

from .errors import FileError, Message, error_of

CHECKOUT = Path(__file__).resolve().parents[3]


def find_program(program: str | Path | None = None) -> Path:
    """Path of the program: the one that is named, else by the environment variable HAMPM, else of the checkout in which this package is
    (`build/release/hampm`), else `hampm` in PATH."""
    if program is None:
        built = CHECKOUT / "build/release/hampm"
        program = os.environ.get("HAMPM") or (built if built.exists() else shutil.which("hampm"))
    if program is None:
        raise FileError([Message("the program hampm is not found: build it with `make program`, or set HAMPM to its path")])
    path = Path(program)
    if not path.is_file() and shutil.which(str(program)):
        path = Path(shutil.which(str(program)))
    if not path.is_file():
        raise FileError([Message("no such program", file=str(program))])
    return path.resolve()


def call(words, program=None, cwd=None):
    """Run the program with these words to its end; exit code, standard output and standard error as text."""
    done = subprocess.run([find_program(program), *map(str, words)], cwd=cwd, capture_output=True, stdin=subprocess.DEVNULL)
    return done.returncode, done.stdout.decode(errors="replace"), done.stderr.decode(errors="replace")


def messages_of(said):
    """The messages in what the program wrote to standard error: errors, and warnings without their word."""
    lines = [line.removeprefix("hampm: ") for line in said.splitlines() if line.strip()]
    errors = [Message(line) for line in lines if not line.startswith("warning: ")]
    return errors, [line.removeprefix("warning: ") for line in lines if line.startswith("warning: ")]


@cache
def _groups(program):
    code, text, said = call(["--keys", "--json"], program)
    if code != 0:
        raise error_of(code, messages_of(said)[0])
    return {group["group"]: group | {"keys": {key["key"]: key for key in group["keys"]}} for group in json.loads(text)}


def key_table(program: str | Path | None = None) -> dict:
    """Group -> its description as `hampm --keys --json` has it, with its `keys` by name: type, unit, default, what is allowed, meaning."""
    return _groups(find_program(program))


def version(program: str | Path | None = None) -> str:
    """Version of the program."""
    return call(["--version"], program)[1].split()[-1]
