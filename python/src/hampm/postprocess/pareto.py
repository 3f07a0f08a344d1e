"""Which settings are worth their cost: the Pareto front of measured rows, and the cheapest row of a given accuracy.

Rows are dictionaries, such as those of a CSV file; `cost` and `error` are names of columns, whose values are numbers or
their text. An error counts without its sign. A row without a number in either, such as that of a run that failed, is left out.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any


def front(rows: Iterable[Mapping[str, Any]], cost: str, error: str) -> list[Mapping[str, Any]]:
    """Rows that no other beats, by rising cost: each has a smaller error than all that cost no more. Of equal rows the first."""
    kept: list[Mapping[str, Any]] = []
    for row in sorted(measured(rows, cost, error), key=lambda row: (number(row, cost), size(row, error))):
        if not kept or size(row, error) < size(kept[-1], error):
            kept.append(row)
    return kept


def cheapest(rows: Iterable[Mapping[str, Any]], cost: str, error: str, limit: float) -> Mapping[str, Any] | None:
    """The row of least cost whose error is not above `limit`, of equal costs that of the least error; None where there is none."""
    good = [row for row in front(rows, cost, error) if size(row, error) <= limit]
    return good[0] if good else None


def measured(rows: Iterable[Mapping[str, Any]], cost: str, error: str) -> list[Mapping[str, Any]]:
    """Rows that have both numbers."""
    return [row for row in rows if math.isfinite(number(row, cost)) and math.isfinite(number(row, error))]


def number(row: Mapping[str, Any], column: str) -> float:
    """A value as a number; NaN where there is none."""
    value: Any = row.get(column)
    try:
        return float(value)
    except (TypeError, ValueError):
        return math.nan


def size(row: Mapping[str, Any], error: str) -> float:
    """An error without its sign."""
    return abs(number(row, error))
