"""Cases that differ by a few values, run one behind the other or several at a time."""

from __future__ import annotations

import os
import pickle
import re
import subprocess
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import Executor, ProcessPoolExecutor, ThreadPoolExecutor, as_completed
from inspect import signature
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .batch.case import failure_of, result_of
from .batch.declaration import OWN_KEY, Declaration, named, short
from .batch.progress import begin_to_count
from .errors import ColumnError, HampmError, ResultError
from .history import History, error_name
from .namelist import flat, plain, shown
from .program import find_program, key_table
from .scene import Scene
from .tables import Table

if TYPE_CHECKING:
    import pandas

PACKAGES = str(Path(__file__).resolve().parents[1])


class Sweep:
    """Every value with every other one of a model: a folder for each case, which `run` fills.

        sweep = Sweep("dcb.nml", {"method.mass": ["lumped", "consistent"],
                                  ("grid.cell", "grid.cells"): [(2.5e-3, (40, 5)), (1.25e-3, (80, 9))]}, output="results/sweep")
        sweep.run(jobs=2)
        sweep.to_pandas()

    Keys are those of `--set`; those that change together stand in a tuple, and so do their values. A list of {key: value} is one of cases. A name of
    one's own begins with $; a function computes a key of own names, its arguments: {"$angle": [0, 30], "crack.points": lambda angle: ...}. A case that
    has ended is not run again, one that was stopped goes on. Cases, folders and what is written there are those of the batches of `batch/`
    (docs/how-to/batches.md), which run thousands of cases, also on clusters.

    scene     the model, with what `accuracy` asks, as in `hampm.run`
    cases     name -> {key: value} of what the case is declared by, own names too, as it was given
    labels    name -> what is different in the case: "angle=30 cell=0.001"
    output    folder of the results
    declared  the same as `batch/` has it
    """

    def __init__(self, scene: Scene | str | Path, values: Mapping[Any, Any] | Sequence[Mapping[str, Any]], output: str | Path,
                 program: str | Path | None = None, accuracy: Mapping[str, float] | None = None):
        self.scene = scene.copy() if isinstance(scene, Scene) else Scene(scene, program=program)
        if accuracy:
            self.scene = self.scene.with_accuracy(accuracy)
        self.output, self.program = Path(output).resolve(), program or self.scene.program
        given = [{key: flat(value) for key, value in settings.items()} for settings in (_combined(values) if isinstance(values, Mapping) else values)]
        texts: list[tuple[dict[str, str], dict[str, str], dict[str, str]]] = []
        given, functions = [{key: value for key, value in settings.items() if not callable(value)} for settings in given], [
            {key: value for key, value in settings.items() if callable(value)} for settings in given]
        for declared, computing in zip(given, functions):
            own = {key: value for key, value in declared.items() if key.startswith("$")}
            settings = {key: value for key, value in declared.items() if key not in own} | _computed(computing, own)
            self.scene.with_settings(settings)   # raises where a key is not there
            texts.append(({key.lower(): _text(value) for key, value in settings.items()}, {key: _text(value) for key, value in own.items()},
                          {key if key in own else key.lower(): _text(value) for key, value in declared.items()}))
            if OWN_KEY in texts[-1][0]:
                raise ValueError(f"{OWN_KEY}: the results of a sweep are named by their folders")
            if any(texts[-1][0] == before for before, *_ in texts[:-1]):
                raise ValueError(f"the case {declared} is there already")
        cases, names, varying = named(texts)
        read = self.scene.path.resolve() if self.scene.path and self.scene.is_as_read() else None
        namelist = read or self.output / "cases/model.nml"
        self.cases: dict[str, dict[str, Any]] = dict(zip(cases, given))
        self.declared = Declaration(path=namelist, namelist=namelist, output=self.output, cases=cases, names=names, varying=varying)

    @classmethod
    def read(cls, path: str | Path, program: str | Path | None = None) -> Sweep:
        """The sweep that a YAML file declares (docs/how-to/batches.md). Its results are those of `make sweep`."""
        from .batch.declaration import read_sweep
        declared = read_sweep(path, program)
        sweep = cls(Scene(declared.namelist, program=program), [], declared.output, program)
        sweep.declared = declared
        sweep.cases = {name: {key: _number(text) for key, text in declared.names[name].items()} |
                       {str(key): _value(key, text, program) for key, text in settings.items()} for name, settings in declared.cases.items()}
        return sweep

    def __len__(self) -> int:
        return len(self.cases)

    @property
    def labels(self) -> dict[str, str]:
        """Name -> what is different in a case, in few words."""
        words = short(self.declared.varying)
        return {name: " ".join(f"{word}={_brief(values[key])}" for key, word in words.items() if key in values) or name
                for name, values in ((name, {key if key.startswith("$") else key.lower(): value for key, value in values.items()}) for name, values in self.cases.items())}

    @property
    def failures(self) -> dict[str, HampmError]:
        """Name -> `HampmError`, of the cases that were run and have not come to a result: refused, failed, or not finished."""
        found = {name: failure_of(self._record(name)) for name in self.cases}
        return {name: error for name, error in found.items() if error is not None}

    def result(self, name: str) -> Path:
        """Path of the result of a case."""
        return result_of(self.declared.folder(name))

    def run(self, jobs: int | None = None, threads: int | None = None, progress: bool = True) -> Sweep:
        """Run the cases that have not ended, so many at a time (default: as there are processors for their threads), each on `threads` (default: 1, or as
        declared). What goes wrong in one does not stop the others: it is in `failures`; those that were refused or failed would do so again, and are run
        again only after `forget`. An interrupt stops the cases that run, with checkpoints."""
        self._write_model()
        self.declared.adopt()
        todo = [name for name in self.cases if "outcome" not in self._record(name)]
        begin_to_count(self.output, len(self), len(self) - len(todo))
        threads = threads or self.declared.threads
        running: list[subprocess.Popen[str]] = []
        with ThreadPoolExecutor(jobs or max(1, (os.cpu_count() or 1) // threads)) as pool:
            ends = [pool.submit(self._run, name, threads, running) for name in todo]
            try:
                for said in (end.result() for end in as_completed(ends)):
                    if progress:
                        print(said, flush=True)
            except BaseException:
                pool.shutdown(wait=False, cancel_futures=True)
                for process in running:
                    process.terminate()
                raise
        return self

    def forget(self, names: Iterable[str] | None = None) -> list[str]:
        """Have the next `run` run cases again from their beginning: those that are named, or the ones that were refused or failed. Returns their names."""
        return self.declared.forget(names)

    def history(self, name: str | None = None, /, **settings: Any) -> History:
        """The history of a case: by its name, or by what it is declared by, in the words of its label: `sweep.history(angle=30, cell=1e-3)`."""
        return History(self.result(self._named(settings) if name is None else name))

    def _named(self, settings: Mapping[str, Any]) -> str:
        words = {word: key for key, word in short(dict.fromkeys(key for values in self.cases.values() for key in values)).items()}
        if unknown := [word for word in settings if word not in words]:
            raise ColumnError(f"cases have no '{unknown[0]}'; they have {', '.join(words)}")
        found = [name for name, values in self.cases.items() if all(words[word] in values and values[words[word]] == flat(value) for word, value in settings.items())]
        if len(found) != 1:
            raise ColumnError(f"{len(found)} cases have {', '.join(f'{word}={_brief(flat(value))}' for word, value in settings.items())}; one is asked for")
        return found[0]

    def map(self, function: Callable[[History], Any], jobs: int | None = None) -> dict[str, Any]:
        """Name -> what a function makes of the history of a case, of those that have a result, so many at a time (default: as there are processors).
        A function of a module runs in processes of its own, another, such as a lambda, in threads."""
        try:
            pickle.dumps(function)
            pool: type[Executor] = ProcessPoolExecutor
        except (pickle.PicklingError, AttributeError, TypeError):
            pool = ThreadPoolExecutor
        histories = self.histories()
        with pool(jobs or os.cpu_count() or 1) as workers:  # type: ignore[call-arg]
            return dict(zip(histories, workers.map(function, histories.values())))

    def histories(self) -> dict[str, History]:
        """Name -> history of the cases that have one."""
        found = {}
        for name in self.cases:
            try:
                found[name] = History(self.result(name))
            except ResultError:
                continue
        return found

    def to_pandas(self, columns: Sequence[str] = ("K_*", "G", "J"), part: float = 0.1, index: str = "case") -> pandas.DataFrame:
        """A row for each case that has a result: what it is declared by, numbers as numbers and several as a tuple, own names without $, and of the columns that
        match the means over the last part of its run, with their estimated errors as `..._error`; `attrs["units"]` has the units.

        index  "case": names of the cases; "settings": what varies, of several a MultiIndex, for `unstack`, `xs` and `to_xarray`
        """
        import pandas
        if index not in ("case", "settings"):
            raise ResultError(f"index '{index}': there are 'case' and 'settings'")
        rows: dict[str, dict[str, Any]] = {}
        units: dict[str, str] = {}
        for name, history in self.histories().items():
            rows[name] = {key.lstrip("$"): tuple(value) if isinstance(value, list) else value for key, value in self.cases[name].items()}
            for column in _known(history, columns):
                for key, value in zip((column, error_name(column)), history.value(column, part)):
                    if value is not None:
                        rows[name][key], units[key] = value, history.units[column]
        frame = pandas.DataFrame(list(rows.values()), index=pandas.Index(list(rows), name="case"))
        varying = [key.lstrip("$") for key in dict.fromkeys(key for values in self.cases.values() for key in values)
                   if len({_text(values.get(key)) for values in self.cases.values()}) > 1]
        if index == "settings" and varying and rows:
            frame = frame.set_index(varying)
        frame.attrs["units"] = units
        return frame

    def __repr__(self) -> str:
        return str(self._table())

    def _repr_html_(self) -> str:
        return self._table()._repr_html_()

    def _table(self) -> Table[list[str]]:
        keys = list(dict.fromkeys(key for settings in self.cases.values() for key in settings))
        return Table((*(key.lstrip("$") for key in keys), "state"),
                     [[*(_brief(settings[key]) if key in settings else "" for key in keys), self._state(name)]
                      for name, settings in self.cases.items()])

    def _state(self, name: str) -> str:
        record = self._record(name)
        return str(record.get("outcome") or ("not finished" if record else "to do"))

    def _record(self, name: str) -> dict[str, Any]:
        """What is known of a case of this very model."""
        namelist = self.declared.namelist
        is_written = namelist.is_file() and (not self._is_own() or namelist.read_text() == str(self.scene))
        return self.declared.record(name) if is_written else {}

    def _is_own(self) -> bool:
        """Whether the file of the model is one that this sweep writes: the model is not as it was read."""
        return self.declared.namelist == self.output / "cases/model.nml"

    def _write_model(self) -> None:
        (self.output / "cases").mkdir(parents=True, exist_ok=True)
        if self._is_own():
            self.scene.write(self.declared.namelist)

    def _run(self, name: str, threads: int, running: list[subprocess.Popen[str]]) -> str:
        """Run a case, as a batch does, in a process of its own. Returns what is said of its end."""
        declared = self.declared
        words = [declared.folder(name), declared.namelist, "--program", find_program(self.program, self.scene.dimensions()), "--threads", threads,
                 "--checkpoint", declared.checkpoint, "--set", *(f"{key}={value}" for key, value in declared.cases[name].items())]
        process = subprocess.Popen([sys.executable, "-m", "hampm.batch", *map(str, words)], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                                   stderr=subprocess.STDOUT, text=True, errors="replace",
                                   env=os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, [PACKAGES, os.environ.get("PYTHONPATH", "")]))})
        running.append(process)
        said = process.communicate()[0].strip()
        running.remove(process)
        return said


def _computed(functions: Mapping[Any, Callable[..., Any]], own: Mapping[str, Any]) -> dict[str, Any]:
    """The keys that functions compute of own names."""
    found: dict[str, Any] = {}
    for keys, function in functions.items():
        names = list(signature(function).parameters)
        if missing := [name for name in names if f"${name}" not in own]:
            raise ValueError(f"{keys}: there is no ${missing[0]}, which its function takes")
        values = function(*(own[f"${name}"] for name in names))
        found |= dict(zip(keys, map(flat, values))) if isinstance(keys, tuple) else {keys: flat(values)}
    return found


def _number(text: str) -> Any:
    """A number where a text is one."""
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return text


def _brief(value: Any) -> str:
    """A value in six digits, for tables."""
    return ", ".join(map(_brief, value)) if isinstance(value, list) else f"{value:.6g}" if isinstance(value, float) else shown(value)


def _text(value: Any) -> str:
    """A value as `--set` takes it."""
    value = "" if value is None else plain(value)
    return ",".join(map(_text, value)) if isinstance(value, list) else value if isinstance(value, str) else shown(value)


def _value(place: str, text: str, program: str | Path | None) -> Any:
    """The value of a key from its text, as --set takes it."""
    group, _, key = place.partition(".")
    about = key_table(program)[group.partition("(")[0]]["keys"][key]
    kinds: dict[str, Callable[[str], Any]] = {
        "integer": int, "real": lambda word: float(re.sub("[dD]", "e", word)), "logical": lambda word: word.strip(".").lower().startswith("t"),
        "text": lambda word: word.strip().strip("'\"")}
    one = kinds[about["type"]]
    return [one(word) for word in text.split(",")] if about["most"] > 1 else one(str(text))


def _combined(values: Mapping[Any, Any]) -> list[dict[str, Any]]:
    """The settings of every combination."""
    axes = []
    for keys, choices in values.items():
        if callable(choices):
            axes.append([{keys: choices}])
            continue
        together = keys if isinstance(keys, tuple) else (keys,)
        choices = plain(choices)
        if not isinstance(choices, list):
            raise ValueError(f"{keys}: {choices!r}: a list of values is needed, such as [{choices!r}]")
        rows = [choice if isinstance(keys, tuple) else (choice,) for choice in choices]
        if any(len(row) != len(together) for row in rows):
            raise ValueError(f"{keys}: each value is a tuple of {len(together)}, one for each key")
        axes.append([dict(zip(together, row)) for row in rows])
    return [{key: value for part in parts for key, value in part.items()} for parts in product(*axes)]


def _known(history: History, columns: Sequence[str]) -> dict[str, None]:
    """Those of the columns that a history has, without estimated errors."""
    names: list[str] = []
    for pattern in columns:
        try:
            names += history.select([pattern])
        except ResultError:
            continue
    return dict.fromkeys(names)
