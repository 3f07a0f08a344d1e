"""Cases that differ by a few values, run one behind the other or several at a time."""

from __future__ import annotations

import hashlib
import json
import os
import re
import sys
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING

from .errors import FileError, HampmError, Message
from .history import History
from .namelist import shown
from .program import CHECKOUT, find_program, key_table
from .running import run
from .scene import Scene
from .stored import ResultError, opened
from .tables import Table

if TYPE_CHECKING:
    import pandas


class Sweep:
    """Every value with every other one of a model: a folder for each case, which `run` fills.

        sweep = Sweep("dcb.nml", {"method.mass": ["lumped", "consistent"],
                                  ("grid.cell", "grid.cells"): [(2.5e-3, (40, 5)), (1.25e-3, (80, 9))]}, output="results/sweep")
        sweep.run(jobs=2)
        sweep.to_pandas()

    Keys are those of `--set`; those that change together stand in a tuple, and so do their values. A case that has ended is not run again, one
    that was stopped goes on. Batches of thousands of cases, on clusters, are for `batch/` (docs/how-to/batches.md).

    cases     name -> {key: value}
    failures  name -> `HampmError`, of the cases of the last `run` that did not succeed
    """

    def __init__(self, scene: Scene | str | Path, values: Mapping | Sequence[Mapping], output: str | Path, program: str | Path | None = None):
        self.scene = scene if isinstance(scene, Scene) else Scene(scene, program=program)
        self.output, self.program, self.failures = Path(output), program, {}
        self.cases = {}
        for settings in _combined(values) if isinstance(values, Mapping) else map(dict, values):
            self.scene.with_settings(settings)   # raises where a key is not there
            name = case_name(settings)
            if name in self.cases:
                raise ValueError(f"the case {settings} is there already")
            self.cases[name] = settings

    @classmethod
    def read(cls, path: str | Path, program: str | Path | None = None) -> Sweep:
        """The sweep that a YAML file declares (docs/how-to/batches.md), by `batch/` of the checkout in which this package is. Its results are where
        `make sweep` leaves them, too."""
        place = CHECKOUT / "batch"
        if not (place / "sweep.py").exists():
            raise FileError([Message("files of sweeps are read by batch/ of a checkout of hampm, where this package is not", file=str(path))])
        sys.path.append(str(place))
        try:
            from sweep import read_sweep
        finally:
            sys.path.remove(str(place))
        declared = read_sweep(path, find_program(program))
        sweep = cls(Scene(declared.namelist, program=program), [], declared.output, program)
        sweep.cases = {name: {str(key): _value(key, text, program) for key, text in settings.items()} for name, settings in declared.cases.items()}
        return sweep

    def __len__(self):
        return len(self.cases)

    def result(self, name: str) -> Path:
        """Path of the result of a case."""
        return self.output / "cases" / name / "result.h5"

    def run(self, jobs: int | None = None, threads: int = 1, progress: bool = True) -> Sweep:
        """Run the cases that have not ended, so many at a time (default: as there are processors for their threads). What goes wrong in one
        does not stop the others: it is in `failures`."""
        self.failures = {}
        todo = [name for name in self.cases if not self._has_ended(name)]
        done = len(self.cases) - len(todo)
        with ThreadPoolExecutor(jobs or max(1, (os.cpu_count() or 1) // max(threads, 1))) as pool:
            for name, error in pool.map(lambda name: (name, self._run(name, threads)), todo):
                done += 1
                if error is not None:
                    self.failures[name] = error
                if progress:
                    print(f"{done} of {len(self)}: {name}{f': {error}' if error is not None else ''}", flush=True)
        return self

    def histories(self) -> dict[str, History]:
        """Name -> history of the cases that have one."""
        found = {}
        for name in self.cases:
            try:
                found[name] = History(self.result(name))
            except ResultError:
                continue
        return found

    def to_pandas(self, columns: Sequence[str] = ("K_*", "G", "J"), part: float = 0.1) -> pandas.DataFrame:
        """A row for each case that has a result: its settings, and of the columns that match the means over the last part of its run, with
        their estimated errors as `..._error`; `attrs["units"]` has the units."""
        import pandas
        rows, units = {}, {}
        for name, history in self.histories().items():
            rows[name] = {key: shown(value) if isinstance(value, (list, tuple)) else value for key, value in self.cases[name].items()}
            for column in _known(history, columns):
                rows[name][column], error = history.value(column, part)
                units[column] = history.units[column]
                if error is not None:
                    rows[name][history.error_of(column)] = error
                    units[history.error_of(column)] = history.units[column]
        frame = pandas.DataFrame.from_dict(rows, orient="index")
        frame.attrs["units"] = units
        return frame

    def __repr__(self):
        return str(self._table())

    def _repr_html_(self):
        return self._table()._repr_html_()

    def _table(self):
        keys = list(dict.fromkeys(key for settings in self.cases.values() for key in settings))
        return Table(("case", *keys, "state"),
                     [[name, *(shown(settings[key]) if key in settings else "" for key in keys), self._state(name)]
                      for name, settings in self.cases.items()])

    def _state(self, name):
        if name in self.failures:
            return type(self.failures[name]).__name__
        return "done" if self._has_ended(name) else "to do"

    def _model(self, name):
        scene = self.scene.with_settings(self.cases[name])
        scene.output.file = "result.h5"
        return scene

    def _has_ended(self, name):
        """Whether a result is there, of this very model."""
        model = self.result(name).with_name("model.nml")
        try:
            if History(self.result(name)).attributes.get("ended") != "done":
                return False
            if model.exists():
                return model.read_text() == str(self._model(name))
            with opened(self.result(name)) as stored:
                return _without_checkpoints(stored.text("input/namelist")) == _without_checkpoints(self._model(name).check(warn=False).namelist)
        except (ResultError, HampmError):
            return False

    def _run(self, name, threads):
        scene, model = self._model(name), self.result(name).with_name("model.nml")
        model.parent.mkdir(parents=True, exist_ok=True)
        goes_on = model.exists() and model.read_text() == str(scene)
        if not goes_on:
            self.result(name).unlink(missing_ok=True)
        scene.write(model)
        try:
            run(scene, output=model.parent, threads=threads, resume=goes_on, progress=False, program=self.program)
        except HampmError as error:
            return error


def case_name(settings: Mapping) -> str:
    """Name of a case: what it sets, as far as the name of a folder can say it, and a number that follows from it alone."""
    words = "_".join(f"{key.rpartition('.')[2]}-{re.sub(', ', 'x', shown(value))}" for key, value in settings.items())
    words = re.sub(r"[^A-Za-z0-9.+_-]", "", words)[:80]
    digest = hashlib.sha256(json.dumps(sorted((key, shown(value)) for key, value in settings.items())).encode()).hexdigest()
    return f"{words}_{digest[:8]}"


def _without_checkpoints(namelist):
    """A namelist as used without what does not change the results."""
    return re.sub(r"(?m)^ *checkpoint_\w+ = .*$", "", namelist)


def _value(place, text, program):
    """The value of a key from its text, as --set takes it."""
    group, _, key = place.partition(".")
    about = key_table(program)[group.partition("(")[0]]["keys"][key]
    one = {"integer": int, "real": lambda word: float(re.sub("[dD]", "e", word)), "logical": lambda word: word.strip(".").lower().startswith("t"),
           "text": lambda word: word.strip().strip("'\"")}[about["type"]]
    return [one(word) for word in text.split(",")] if about["most"] > 1 else one(str(text))


def _combined(values):
    """The settings of every combination."""
    axes = []
    for keys, choices in values.items():
        together = keys if isinstance(keys, tuple) else (keys,)
        rows = [choice if isinstance(keys, tuple) else (choice,) for choice in choices]
        if any(len(row) != len(together) for row in rows):
            raise ValueError(f"{keys}: each value is a tuple of {len(together)}, one for each key")
        axes.append([dict(zip(together, row)) for row in rows])
    return [{key: value for part in parts for key, value in part.items()} for parts in product(*axes)]


def _known(history, columns):
    """Those of the columns that a history has, without estimated errors."""
    names = []
    for pattern in columns:
        try:
            names += history.select([pattern])
        except ResultError:
            continue
    return dict.fromkeys(names)
