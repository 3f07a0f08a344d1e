"""What goes wrong in a model or a run, as exceptions, and what a run warns of."""

from collections.abc import Iterable
from dataclasses import dataclass

USAGE, UNREADABLE = 2, 4  # exit codes: the request makes no sense, or what a file holds; a file cannot be read or written


class ResultError(Exception):
    """What is wrong with a file or a request, in words for the user, and the exit code of scripts that goes with it."""

    def __init__(self, message: object, exit_code: int = USAGE):
        super().__init__(message)
        self.exit_code = exit_code


class ColumnError(ResultError, KeyError):
    """A column that is not there."""

    __str__ = Exception.__str__


def printable(text: object, keep: str = "") -> str:
    """A text without what a terminal takes for a command: what does not print, such as an end of a line that is not to be kept, is a question mark."""
    return "".join(letter if letter.isprintable() or letter in keep else "?" for letter in str(text))


@dataclass(frozen=True)
class Message:
    """What hampm says of a model: where it stands, what it is about, and why.

    file, line    where it stands; line is None where there is none
    option        the option of the command line, such as --set, or the key that &accuracy has chosen, in place of these
    group, key    that it is about, '' where none is
    value         of the key, as it was written
    reason        what is wrong or to be known, and what would be right
    """

    reason: str
    file: str = ""
    line: int | None = None
    option: str = ""
    group: str = ""
    key: str = ""
    value: str = ""

    def __str__(self) -> str:
        where = self.option or self.file + (f":{self.line}" if self.line else "")
        about = f"&{self.group} {self.key}".strip() + (f" = {self.value}" if self.value else "") if self.group else ""
        if self.reason.startswith("&") or not about:
            about = ""
        return ": ".join(part for part in (where, about, self.reason) if part)


class HampmError(Exception):
    """A run or a check that did not succeed. `exit_code` is that of the program, `messages` what it said."""

    exit_code = 1

    def __init__(self, messages: Iterable[Message], exit_code: int | None = None):
        self.messages = tuple(messages)
        self.exit_code = self.exit_code if exit_code is None else exit_code
        super().__init__(self.messages, self.exit_code)

    def __str__(self) -> str:
        return "\n".join(map(str, self.messages))


class ModelError(HampmError):
    """The model, or the command line, is refused: each mistake is a `Message` of its own."""

    exit_code = 2


class ComputationError(HampmError):
    """The computation went wrong: step, time, place and likely cause. What was recorded before is in the result file."""

    exit_code = 3


class FileError(HampmError):
    """A file could not be read or written, or there is an old result that is not to be replaced."""

    exit_code = 4


class Stopped(HampmError):
    """The run was stopped before its end; `run(..., resume=True)` goes on from its checkpoint."""

    exit_code = 5


class HampmWarning(UserWarning):
    """What a run or a check warns of: where numbers mean something else than one may think."""


BY_EXIT_CODE = {kind.exit_code: kind for kind in (ModelError, ComputationError, FileError, Stopped)}


def error_of(exit_code: int, messages: Iterable[Message]) -> HampmError:
    """The exception for an exit code of the program."""
    return BY_EXIT_CODE.get(exit_code, HampmError)(messages, exit_code)
