"""Which settings are worth their cost: the Pareto front of measured rows, and the cheapest row of a given accuracy.

Rows are dictionaries, such as those of a CSV file; `cost` and `error` are names of columns, whose values are numbers or
their text. An error counts without its sign. A row without a number in either, such as that of a run that failed, is left out.
"""

import math


def front(rows, cost, error):
    """Rows that no other beats, by rising cost: each has a smaller error than all that cost no more. Of equal rows the first."""
    kept = []
    for row in sorted(measured(rows, cost, error), key=lambda row: (number(row, cost), size(row, error))):
        if not kept or size(row, error) < size(kept[-1], error):
            kept.append(row)
    return kept


def cheapest(rows, cost, error, limit):
    """The row of least cost whose error is not above `limit`, of equal costs that of the least error; None where there is none."""
    good = [row for row in front(rows, cost, error) if size(row, error) <= limit]
    return good[0] if good else None


def measured(rows, cost, error):
    """Rows that have both numbers."""
    return [row for row in rows if math.isfinite(number(row, cost)) and math.isfinite(number(row, error))]


def number(row, column):
    """A value as a number; NaN where there is none."""
    try:
        return float(row.get(column))
    except (TypeError, ValueError):
        return math.nan


def size(row, error):
    """An error without its sign."""
    return abs(number(row, error))
