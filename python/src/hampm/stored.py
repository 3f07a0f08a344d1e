"""What result files hold, looked at where it is read: types, shapes, ranges and finiteness of datasets and attributes.

Whatever is not as hampm writes it is a `ResultError` that names the file, the dataset and what is wrong.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from .arrays import Array
from .errors import UNREADABLE, USAGE, ResultError, printable

BEYOND = 1e200            # sizes from which numbers cannot be computed with
LARGEST = 2**35           # bytes of one dataset
NAME = re.compile(r"[A-Za-z0-9_]+")  # of a column or a field
KINDS = {"O": "texts or references", "S": "texts", "U": "texts", "b": "truth values", "c": "complex numbers", "V": "compounds", "M": "dates"}


@contextmanager
def opened(path: str | Path) -> Iterator[Stored]:
    """A result file, open for reading, as `Stored`."""
    if not Path(path).is_file():
        raise ResultError(f"{path}: no such file", UNREADABLE)
    try:
        with h5py.File(path, "r") as file:
            yield Stored(file, path)
    except (OSError, RuntimeError) as error:
        whole = Path(path).with_suffix("")
        hint = f": it is the unfinished file of a run, {whole.name} is what was whole last" if Path(path).suffix == ".part" and whole.is_file() else ""
        raise ResultError(f"{path}: cannot be read as HDF5{hint} ({' '.join(str(error).split())})", UNREADABLE) from error


class Stored:
    """A result file that is open: its datasets and attributes, each as it has to be."""

    def __init__(self, file: Any, path: str | Path):
        self._file, self.path = file, path

    def wrong(self, name: str, what: str, exit_code: int = USAGE) -> ResultError:
        """The error of a dataset or group."""
        return ResultError(" ".join(f"{self.path}: /{name} {what}".split("\n")), exit_code)

    def has(self, name: str) -> bool:
        """Whether there is something of this name."""
        try:
            return self._file.get(name) is not None
        except (KeyError, OSError, RuntimeError, TypeError):
            return False

    def has_group(self, name: str) -> bool:
        """Whether there is a group of this name."""
        return self.has(name) and isinstance(self._file[name], h5py.Group)

    def names(self, group: str) -> list[str]:
        """Names of the datasets of a group; none where it is not there."""
        if not self.has(group):
            return []
        if not self.has_group(group):
            raise self.wrong(group, "is no group")
        found = [plain(name) for name in self._file[group] if self.has(f"{group}/{name}") and
                 isinstance(self._file[f"{group}/{name}"], h5py.Dataset)]
        for name in found:
            if not NAME.fullmatch(name):
                raise self.wrong(group, f"has a column '{printable(name)[:40]}'; names are of letters, digits and _")
        return found

    def numbers(self, name: str, dims: int = 1, whole: bool = False, finite: bool = False, least: float = -BEYOND, most: float = BEYOND,
                first: int = 0, count: int | None = None) -> Array:
        """Real numbers with so many dimensions, or the part of them from a row on: finite ones in a range, if asked for, and whole numbers."""
        item = self._dataset(name, dims)
        if count is not None and not 0 <= first <= first + count <= item.shape[0]:
            raise self.wrong(name, f"has {item.shape[0]} rows, and {count} from {first} on are asked for")
        if item.dtype.kind not in "iuf":
            raise self.wrong(name, f"holds {KINDS.get(item.dtype.kind, item.dtype)}, not numbers")
        if item.nbytes > LARGEST:
            raise self.wrong(name, f"would be {item.nbytes / 2**30:.3g} GiB")
        try:
            values = item[()] if count is None else item[first:first + count]
        except (OSError, RuntimeError, ValueError, MemoryError) as error:
            raise self.wrong(name, f"cannot be read ({error})", UNREADABLE) from error
        known = values[np.isfinite(values)]
        if (finite or whole) and known.size < values.size:
            raise self.wrong(name, "holds values that are not finite")
        if np.any((known < least) | (known > most)):
            worst = known[np.argmax(np.abs(known.astype(float)))]
            raise self.wrong(name, f"holds {worst:g}, and values are between {least:g} and {most:g}")
        if whole and np.any(np.asarray(known) % 1 != 0):
            raise self.wrong(name, "holds numbers that are not whole")
        return values.astype(np.int64) if whole else values

    def _dataset(self, name: str, dims: int) -> Any:
        """A dataset with so many dimensions."""
        if not self.has(name) or not isinstance(self._file[name], h5py.Dataset):
            raise self.wrong(name, "is missing")
        item = self._file[name]
        try:
            shape, _ = item.shape, item.dtype
        except (TypeError, OSError, ValueError) as error:
            raise self.wrong(name, f"is of a type that is not known ({error})") from error
        if shape is None or len(shape) != dims:
            raise self.wrong(name, f"has the shape {shape}, and {dims} dimension{'s' * (dims != 1)} are asked for")
        return item

    def dims(self, name: str) -> int:
        """Number of dimensions of a dataset."""
        try:
            return len(self._file[name].shape or ())
        except (TypeError, KeyError, OSError, ValueError, AttributeError):
            return 0

    def text(self, name: str) -> str:
        """A text."""
        item = self._dataset(name, self.dims(name))
        if item.dtype.kind not in "OS" or item.size != 1 or h5py.check_string_dtype(item.dtype) is None:
            raise self.wrong(name, "is no text")
        try:
            return plain(np.asarray(item[()]).reshape(-1)[0])
        except (OSError, RuntimeError, ValueError) as error:
            raise self.wrong(name, f"cannot be read ({error})", UNREADABLE) from error

    def attributes(self, name: str, texts: Sequence[str] = (), numbers: Sequence[str] = ()) -> dict[str, Any]:
        """Attributes of a group or dataset as plain values; those named have to be texts or numbers where they are there."""
        found = {}
        try:
            for key, value in self._file[name].attrs.items():
                found[plain(key)] = plain(value)
        except (OSError, RuntimeError, TypeError, ValueError, KeyError) as error:
            raise self.wrong(name, f"has an attribute that cannot be read ({error})") from error
        for key in texts:
            if not isinstance(found.get(key, ""), str):
                raise self.wrong(name, f"has an attribute {key} that is no text")
        for key in numbers:
            if isinstance(found.get(key, 0.0), bool) or not isinstance(found.get(key, 0.0), (int, float)):
                raise self.wrong(name, f"has an attribute {key} that is no number")
        return found


def plain(value: Any) -> Any:
    """An attribute or a text as a plain value: Fortran writes arrays of one element and padded texts."""
    if isinstance(value, np.ndarray) and value.size == 1:
        value = value.reshape(-1)[0]
    value = value.item() if isinstance(value, np.generic) else value
    value = value.decode(errors="replace") if isinstance(value, bytes) else value
    return printable(value.encode(errors="replace").decode().rstrip("\0 "), keep="\n\t") if isinstance(value, str) else value
