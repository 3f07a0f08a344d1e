"""Columns of a sweep's table that follow from the history of a case, or from other columns:

    t_start: first time K_I > ${0.9*K_c}      linear between samples; blank where it never comes to that
    K_max: max K_I                            also min, last, first
    J_rest: mean J between 1e-4 and 2e-4      of what is linear between samples; also max and min between times
    J_mid: J at 1e-4
    ratio: ${J / G_ref}                       of columns of the row, such as settings, last values, attributes and derived ones above
"""

import math
import operator
import re
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from ..errors import ResultError
from ..history import History
from .arithmetic import EXPRESSION, ExpressionError, evaluate, substitute


NAME = re.compile(r"[A-Za-z]\w*")
NUMBER = r"([-+]?(?:\d+\.?\d*|\.\d+)(?:[eEdD][-+]?\d+)?)"
FORMS = ("first time COLUMN > NUMBER", "max|min|mean|last|first COLUMN", "max|min|mean COLUMN between TIME and TIME", "COLUMN at TIME", "${EXPRESSION}")
SIGNS = {">": operator.gt, ">=": operator.ge, "<": operator.lt, "<=": operator.le}
CROSSING = re.compile(rf"first time (\w+) *(>=|<=|>|<) *{NUMBER}")
OVER = re.compile(rf"(max|min|mean|last|first) (\w+)(?: between {NUMBER} and {NUMBER})?")
AT = re.compile(rf"(\w+) at {NUMBER}")


def mistake(text: str) -> str:
    """What is wrong with the text of a derived column; '' where it is of one of the forms."""
    if EXPRESSION.fullmatch(text):
        return ""
    plain = EXPRESSION.sub("1", text)
    found = OVER.fullmatch(plain)
    if CROSSING.fullmatch(plain) or AT.fullmatch(plain) or (found and not (found[3] and found[1] in ("last", "first"))):
        return ""
    return f"'{text}' is none of: {'; '.join(FORMS)}"


def derive(text: str, history: History, row: Mapping[str, object]) -> tuple[float | str, str]:
    """The value of a derived column and the unit that it has, or '' where there is none. ResultError where a column is missing."""
    def known(name: str) -> str:
        for key in (name, f"${name}"):
            if row.get(key, "") != "":
                return str(row[key])
        raise ExpressionError(f"there is no {name}")
    try:
        if whole := EXPRESSION.fullmatch(text):
            return float(evaluate(whole[1], known)), "1"
        text = substitute(text, known)
    except ExpressionError as error:
        raise ResultError(str(error)) from error
    if found := CROSSING.fullmatch(text):
        return first_time(history.times, samples(history, found[1]), found[2], number(found[3])), "s"
    if found := AT.fullmatch(text):
        values, time = samples(history, found[1]), number(found[2])
        inside = history.times[0] <= time <= history.times[-1]
        return float(np.interp(time, history.times, values)) if inside else "", history.units[found[1]]
    found = OVER.fullmatch(text)
    if found is None:
        raise ResultError(mistake(text))
    values = samples(history, found[2])
    between = tuple(map(number, found.groups()[2:])) if found[3] else (-math.inf, math.inf)
    return over(found[1], history.times, values, *between), history.units[found[2]]


def samples(history: History, column: str) -> NDArray[np.float64]:
    if column not in history.columns:
        raise ResultError(f"no column '{column}'; it has {', '.join(history.columns)}")
    return history.columns[column].astype(float)


def number(text: str) -> float:
    return float(text.lower().replace("d", "e"))


def first_time(times: NDArray[np.float64], values: NDArray[np.float64], sign: str, limit: float) -> float | str:
    """When what is linear between samples is first beyond a limit [s]; '' where it never is."""
    beyond = np.flatnonzero(SIGNS[sign](values, limit))
    if not beyond.size:
        return ""
    k = beyond[0]
    if k == 0 or not np.isfinite(values[k - 1]):
        return float(times[k])
    return float(times[k - 1] + (times[k] - times[k - 1]) * (limit - values[k - 1]) / (values[k] - values[k - 1]))


def over(what: str, times: NDArray[np.float64], values: NDArray[np.float64], begin: float, end: float) -> float | str:
    """Maximum, minimum, mean over time, first or last value of what is linear between samples, in a span of time; '' outside of the run."""
    begin, end = max(begin, times[0]), min(end, times[-1])
    if begin > end:
        return ""
    inside = (times > begin) & (times < end)
    t = np.concatenate([[begin], times[inside], [end]])
    y = np.concatenate([[np.interp(begin, times, values)], values[inside], [np.interp(end, times, values)]])
    if what == "mean":
        return float(np.sum((y[1:] + y[:-1]) / 2 * np.diff(t)) / (end - begin)) if end > begin else float(y[0])
    return float({"max": np.max(y), "min": np.min(y), "first": y[0], "last": y[-1]}[what])
