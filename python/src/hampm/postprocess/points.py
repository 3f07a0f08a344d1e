"""Points in CSV files, such as those of a crack that was measured."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ..arrays import Array
from ..errors import UNREADABLE, ResultError


def read_points(path: str | Path, columns: Sequence[int]) -> Array:
    """Points (n, 2) from two columns, counted from 1, of a CSV file with # comments, perhaps with a row of names above them."""
    try:
        with open(path, encoding="utf-8") as file:
            rows = [line.split(",") for line in file if line.strip() and not line.lstrip().startswith("#")]
        named = rows and any(not is_number(row[column - 1]) for row in rows[:1] for column in columns if column <= len(row))
        points = np.array([[float(row[column - 1]) for column in columns] for row in rows[1 if named else 0:]])
    except OSError as error:
        raise ResultError(f"{path}: cannot be read ({error.strerror or error})", UNREADABLE) from error
    except IndexError as error:
        raise ResultError(f"{path}: has rows without a column {max(columns)}") from error
    except ValueError as error:
        raise ResultError(f"{path}: not rows of numbers ({error})") from error
    if not points.size or not np.all(np.isfinite(points)):
        raise ResultError(f"{path}: {'has values that are not finite' if points.size else 'has no points'}")
    return points


def is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True
