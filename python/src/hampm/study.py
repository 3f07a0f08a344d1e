"""Inverse questions: the value of a key at which a column comes to a value, and keys with which a column follows a measured curve."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from .arrays import Array
from .batch.derived import OVER, derive
from .errors import ResultError
from .history import History
from .scene import Scene
from .sweep import Sweep
from .tables import Table

Quantity = str | Callable[[History], float]


@dataclass(frozen=True)
class Solution:
    """The value of a key at which a quantity comes to a target.

    key, value  of the model
    error       of the value, from the estimated error of the quantity and its slope, and from where the search ended; None where that of the quantity is not known
    history     of the run with this value
    tried       (value, quantity) of all runs, in their order
    """

    key: str
    value: float
    error: float | None
    history: History = field(repr=False)
    tried: list[tuple[float, float]] = field(repr=False)

    def __str__(self) -> str:
        error = "" if self.error is None else f" +- {self.error:.2g}"
        return f"{self.key} = {self.value:.6g}{error}, after {len(self.tried)} runs"


@dataclass(frozen=True)
class Fit:
    """Keys with which a column follows a curve best.

    values      key -> value
    errors      key -> its error: one standard deviation, from what is left of the curve, and what the estimated errors of the column may move it by
    covariance  of the values, in the order of the keys
    history     of the run with these values
    residuals   computed less measured, in the unit of the column
    runs        number of runs
    """

    values: dict[str, float]
    errors: dict[str, float]
    covariance: Array = field(repr=False)
    history: History = field(repr=False)
    residuals: Array = field(repr=False)
    runs: int = 0

    def _table(self) -> Table[list[str]]:
        return Table(("key", "value", "error"), [[key, f"{value:.6g}", f"{self.errors[key]:.2g}"] for key, value in self.values.items()])

    def __str__(self) -> str:
        return str(self._table())

    def _repr_html_(self) -> str:
        return self._table()._repr_html_()


class Study:
    """Runs of a model that look for values of its keys. They are cases of a sweep in the folder `output`: none is run twice, also by another study there.

        study = hampm.Study("dcb.nml", output="results/toughness")
        print(study.solve("growth.toughness", "max load", 1250.0, between=(50, 400)))
        print(study.fit({"material.young": 200e9}, time, displacement, column="load_displacement"))

    scene     the model
    computed  key -> function of own names, as in a `Sweep`: Study(scene, output, computed={"crack.points": lambda a: ...}).solve("$a", ...)
    threads   of a run
    """

    def __init__(self, scene: Scene | str | Path, output: str | Path, computed: Mapping[Any, Callable[..., Any]] | None = None, threads: int = 1,
                 program: str | Path | None = None):
        self.scene = scene.copy() if isinstance(scene, Scene) else Scene(scene, program=program)
        self.output, self.computed, self.threads, self.program = Path(output), dict(computed or {}), threads, program

    def histories(self, settings: Sequence[Mapping[str, Any]]) -> list[History]:
        """The histories of the model with these settings, each {key: value}. The error of a run that has none is raised."""
        sweep = Sweep(self.scene, [{**one, **self.computed} for one in settings], self.output, self.program).run(threads=self.threads, progress=False)
        for error in sweep.failures.values():
            raise error
        return list(sweep.histories().values())

    def solve(self, key: str, quantity: Quantity, target: float, between: tuple[float, float], rtol: float = 1e-3) -> Solution:
        """The value of a key, between two values, at which a quantity comes to a target, by bracketing (Brent's method).

        quantity  a column (its mean over the last tenth of the run), words of derived columns such as "max load", "J at 1e-4", "first time K_I > 1e6", or a
                  function of the history
        rtol      part of the value by which it may be wrong where the search ends
        """
        from scipy.optimize import brentq
        tried: dict[float, tuple[float, float | None]] = {}

        def excess(value: float) -> float:
            if value not in tried:
                history, = self.histories([{key: value}])
                tried[value] = value_of(history, quantity)
                if not math.isfinite(tried[value][0]):
                    raise ResultError(f"{key} = {value:g}: '{quantity}' has no value in {history.path}")
            return tried[value][0] - target

        ends = [float(value) for value in between]
        if excess(ends[0]) * excess(ends[1]) > 0:
            raise ResultError(f"{quantity} is {tried[ends[0]][0]:.6g} with {key} = {ends[0]:g} and {tried[ends[1]][0]:.6g} with {ends[1]:g}: {target:g} is not between them")
        found = float(brentq(excess, *ends, xtol=rtol * min(filter(None, map(abs, ends)), default=1.0), rtol=max(rtol, 1e-12)))
        excess(found)
        other = min((value for value in tried if tried[value][0] != tried[found][0]), key=lambda value: abs(value - found), default=found)
        slope = (tried[other][0] - tried[found][0]) / (other - found) if other != found else math.inf
        uncertain = tried[found][1]
        error = None if uncertain is None else uncertain / abs(slope) + abs(tried[found][0] - target) / abs(slope)
        history, = self.histories([{key: found}])
        return Solution(key, found, error, history, [(value, got) for value, (got, _) in tried.items()])

    def fit(self, start: Mapping[str, float], x: Any, y: Any, column: str, over: str = "time", sigma: float | Any = None,
            bounds: Mapping[str, tuple[float, float]] | None = None, step: float = 1e-3, rtol: float = 1e-4) -> Fit:
        """Values of keys with which a column follows a measured curve (x, y), by least squares (scipy.optimize.least_squares).

        start   key -> value to begin with, not zero
        over    the column that x is of; the computed curve is linear between its samples
        sigma   standard deviation of y, a number or one for each; without it that of what is left
        bounds  key -> (least, largest)
        step    part of the values by which they are changed for derivatives
        rtol    part of the values below which a step ends the search
        """
        from scipy.optimize import least_squares
        keys, first = list(start), np.array([float(value) for value in start.values()])
        x, y = np.asarray(x, dtype=float), np.asarray(y, dtype=float)
        if x.shape != y.shape or x.ndim != 1 or x.size <= len(keys) or not np.all(first) or not keys:
            raise ResultError("a fit needs keys that begin with values other than zero, and a curve of more points than keys")
        weight = 1 / np.broadcast_to(np.asarray(np.abs(y).max() or 1.0 if sigma is None else sigma, dtype=float), y.shape)
        runs: dict[tuple[float, ...], History] = {}

        def curves(points: Sequence[Array]) -> list[Array]:
            new = [tuple(map(float, point * first)) for point in points]
            missing = [point for point in dict.fromkeys(new) if point not in runs]
            runs.update(zip(missing, self.histories([dict(zip(keys, point)) for point in missing]) if missing else []))
            return [_curve(runs[point], over, column, x) for point in new]

        def residuals(point: Array) -> Array:
            return weight * (curves([point])[0] - y)

        def jacobian(point: Array) -> Array:
            steps = step * np.eye(len(keys))
            own, *moved = curves([point, *(point + one for one in steps)])
            return np.array([weight * (other - own) / step for other in moved]).T

        limits = np.array([(bounds or {}).get(key, (-np.inf, np.inf)) for key in keys], dtype=float).T / first
        result = least_squares(residuals, np.ones(len(keys)), jac=jacobian, bounds=(limits.min(axis=0), limits.max(axis=0)), xtol=rtol, ftol=1e-12, gtol=None)
        if not result.success:
            raise ResultError(f"the fit has not come to an end: {result.message}")
        inverse = np.linalg.pinv(result.jac)
        spread = 1.0 if sigma is not None else float(np.sum(result.fun**2)) / (x.size - len(keys))
        covariance = inverse @ inverse.T * spread * np.outer(first, first)
        history = runs[tuple(map(float, result.x * first))]
        error = history.error_of(column)
        moved = np.abs(inverse * first[:, None]) @ np.abs(weight * np.nan_to_num(_curve(history, over, error, x))) if error else np.zeros(len(keys))
        errors = np.sqrt(np.diag(covariance)) + moved
        return Fit(dict(zip(keys, (result.x * first).tolist())), dict(zip(keys, errors.tolist())), covariance, history, result.fun / weight, len(runs))


def value_of(history: History, quantity: Quantity) -> tuple[float, float | None]:
    """A quantity of a run and its estimated error, None where that is not known: that of its column, or how far the quantity moves with its column."""
    if not isinstance(quantity, str):
        return float(quantity(history)), None
    if quantity in history:
        return history.value(quantity)
    columns = [name for name in history if name in quantity.split() and name not in ("max", "min", "mean", "last", "first", "time")]
    error = history.error_of(columns[0]) if len(columns) == 1 else None
    own = _derived(history, quantity)
    if error is None or not (OVER.fullmatch(quantity) or columns):
        return own, None
    moved = [_derived(history.with_columns({**history.columns, columns[0]: history[columns[0]] + sign * np.nan_to_num(history[error])}), quantity) for sign in (-1, 1)]
    return own, max(abs(value - own) for value in moved)


def _derived(history: History, quantity: str) -> float:
    value, _ = derive(quantity, history, {})
    return math.nan if value == "" else float(value)


def _curve(history: History, over: str, column: str, x: Array) -> Array:
    """A column at places of another one, linear between samples."""
    at, values = history[over].astype(float), history[column].astype(float)
    order = np.argsort(at, kind="stable")
    if x.min() < at.min() - 1e-9 * np.ptp(at) or x.max() > at.max() + 1e-9 * np.ptp(at):
        raise ResultError(f"{history.path}: {over} is from {at.min():.6g} to {at.max():.6g}, and the curve from {x.min():.6g} to {x.max():.6g}")
    return np.interp(x, at[order], values[order])
