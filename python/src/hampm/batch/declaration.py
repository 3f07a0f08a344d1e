"""What a sweep declares: its cases, and what is wanted of them.

A sweep is a YAML file; docs/how-to/batches.md explains its keys:

    namelist: dcb.nml                 the scene, beside the sweep file
    output: ../results/sweep          folder of the cases and the table
    product:                          every value with every other one; keys are those of --set
      method.mass: [lumped, consistent]
      grid.cell, grid.cells:          keys that change together
        - [2.5e-3, [40, 5]]
        - [1.25e-3, [80, 9]]
      $n: [10, 20]                    a name of one's own, for arithmetic
    cases:                            a list of cases, beside the product or in its place
      - {method.scheme: usl, method.courant: 0.05}
    set:                              of all cases; '${...}' is arithmetic with numbers, names and keys of the case
      load.ramp_time: ${1e-4 * n}
    accuracy: {K_I: 0.01}             an error that is asked of a column, of all cases: &accuracy
    columns: [G_vcct_I, J]            of the history, for the table: last values; default: all
    derived:                          further columns of the table
      t_start: first time K_I > 1e6
    mean: 2e-4                        and means over so much time at the end [s]; default: none
    threads: 1                        of a case
    memory: 500                       of a case [MB]; default: what `hampm --check` says it needs
    runtime: 60                       of a case at most [minutes], for clusters
    checkpoint: 600                   wall time between checkpoints [s]; 0: none
"""

import fcntl
import hashlib
import json
import math
import os
import re
import shutil
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from difflib import get_close_matches
from itertools import product
from pathlib import Path
from typing import Any

from ..errors import UNREADABLE, HampmError, ResultError, printable
from ..former_names import new_key
from ..program import key_table
from .arithmetic import EXPRESSION, ExpressionError, substitute
from .case import identity, record_of
from .derived import NAME, mistake

KEYS = ("namelist", "output", "product", "cases", "set", "accuracy", "columns", "derived", "mean", "threads", "memory", "runtime", "checkpoint")
MOST_CASES = 100_000
WRITTEN = "table.csv", "table.h5", "progress"  # files in the folder of a sweep
OWN_KEY = "output.file"  # the runs of a sweep name their results themselves


@dataclass(frozen=True)
class Declaration:
    """A sweep as declared.

    path, namelist, output   absolute paths: of the file that declares it, of the model, of the folder of the results
    cases                    name -> {group.key: value}, both as text, as `--set` takes them
    names                    name of a case -> {'$name': value} of the sweep's own names
    varying                  keys and own names that are not the same in all cases, without those of `set`
    columns                  patterns of columns of the history
    derived                  name -> text, of derived columns
    mean                     time at the end over which means are taken [s]; None: no means
    threads, memory, runtime of a case; memory [MB] is None where it is not declared, runtime in minutes
    checkpoint               wall time between checkpoints [s]
    units                    of the keys that cases set
    """

    path: Path
    namelist: Path
    output: Path
    cases: dict[str, dict[str, str]]
    names: dict[str, dict[str, str]]
    varying: tuple[str, ...]
    columns: tuple[str, ...] = ("*",)
    derived: dict[str, str] = field(default_factory=dict)
    mean: float | None = None
    threads: int = 1
    memory: int | None = None
    runtime: int = 60
    checkpoint: float = 600.0
    units: dict[str, str] = field(default_factory=dict)

    @property
    def keys(self) -> list[str]:
        """All own names and keys that any case sets, in the order of the file."""
        return list(dict.fromkeys(key for of in (self.names, self.cases) for settings in of.values() for key in settings))

    def values(self, name: str) -> dict[str, str]:
        """Own names and keys of a case, each with its value."""
        return self.names[name] | self.cases[name]

    def label(self, name: str) -> str:
        """What is different in a case, in words."""
        values = self.values(name)
        return " ".join(f"{word}={values[key]}" for key, word in short(self.varying).items() if key in values) or name

    def adopt(self) -> None:
        """Cases are named by what varies: where that is other than it was, have their folders follow, unless somebody runs them."""
        folder = self.output / "cases"
        present = {path.name.rpartition("_")[2]: path for path in folder.iterdir()} if folder.is_dir() else {}
        for name in self.cases:
            old = present.get(name.rpartition("_")[2])
            if old and old.name not in self.cases and not self.folder(name).exists() and is_free(old):
                old.rename(self.folder(name))

    def folder(self, name: str) -> Path:
        """Where a case is run and leaves its result."""
        return self.output / "cases" / name

    def record(self, name: str) -> dict[str, Any]:
        """What is known of how a case has gone, of the model as it is now (`case.record_of`)."""
        return record_of(self.folder(name), identity(self.namelist, self.cases[name]))

    def forget(self, names: Iterable[str] | None = None) -> list[str]:
        """Forget how cases ended, and what they have computed, so that they are run again from their beginning: those that are named, or the ones that
        were refused or failed. Returns their names."""
        self.adopt()
        if names is None:
            names = [name for name in self.cases if self.record(name).get("outcome") in ("refused", "failed")]
        names = list(names)
        for name in names:
            if name not in self.cases:
                raise ResultError(f"the sweep has no case '{name}'{meant(name, self.cases)}")
        for name in names:
            shutil.rmtree(self.folder(name), ignore_errors=True)
        return names


def read_sweep(path: str | Path, program: str | Path | None = None) -> Declaration:
    """The sweep that a file declares. ResultError names all mistakes, each with its line and what would be right."""
    path = Path(path).resolve()
    return Reader(path, namelist_keys(program)).sweep()


def namelist_keys(program: str | Path | None = None) -> dict[str, dict[str, str]]:
    """'group' -> its keys, each with its unit, '1' where it has none."""
    try:
        table = key_table(program)
    except (HampmError, OSError) as error:
        raise ResultError(f"{program or 'hampm'}: cannot be run ({error}); build it with make", UNREADABLE) from error
    return {name: {key: about["unit"] or "1" for key, about in group["keys"].items()} for name, group in table.items()}


def named(found: Iterable[tuple[Mapping[str, str], Mapping[str, str], Mapping[str, str]]]) -> \
        tuple[dict[str, dict[str, str]], dict[str, dict[str, str]], tuple[str, ...]]:
    """Name -> settings and name -> own names of cases, and which keys vary. Of each case are given its settings, its own names, and those of both that
    it has been declared by, in place of what all have in common."""
    found = list(found)
    keys = dict.fromkeys(key for _, _, declared in found for key in declared)
    varying = tuple(key for key in keys if len({declared.get(key) for _, _, declared in found}) > 1)
    named = {case_name(settings, declared, varying): (dict(settings), dict(own)) for settings, own, declared in found}
    return {name: settings for name, (settings, _) in named.items()}, {name: own for name, (_, own) in named.items()}, varying


def case_name(settings: Mapping[str, str], values: Mapping[str, str] | None = None, varying: Sequence[str] | None = None) -> str:
    """Name of a case: what varies of its values, as far as a file name can say it, and a number that follows from what it sets alone."""
    values = settings if values is None else values
    words = "_".join(f"{word}-{values[key].replace(',', 'x')}" for key, word in short(varying or values).items() if key in values)
    words = re.sub(r"\d+\.\d{5,}([eE][-+]?\d+)?", lambda found: f"{float(found[0]):.4g}", words)   # such as those that a program has computed
    words = re.sub(r"[^A-Za-z0-9.+_-]", "", words)[:80] or "case"
    digest = hashlib.sha256(json.dumps(sorted(settings.items())).encode()).hexdigest()
    return f"{words}_{digest[:8]}"


def short(keys: Iterable[str]) -> dict[str, str]:
    """Keys and own names -> the words for them: the last part, where it is that of one alone."""
    keys = list(keys)
    last = [key.lstrip("$").rpartition(".")[2] for key in keys]
    return {key: word if last.count(word) == 1 else key for key, word in zip(keys, last)}


def is_free(folder: Path) -> bool:
    """Whether nobody runs the case of a folder."""
    try:
        with open(folder / "lock", "a") as file:
            fcntl.lockf(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        return False
    return True


class Reader:
    """Takes a declaration apart and notes what is wrong with it."""

    def __init__(self, path: Path, groups: Mapping[str, Mapping[str, str]]):
        self.path, self.groups = path, groups
        self.mistakes: list[str] = []
        self.units: dict[str, str] = {}
        try:
            from .yaml_text import read_yaml
        except ImportError as missing:
            raise ResultError(f"{path}: sweeps need PyYAML ({missing}): tools/setup.sh batch, or pip install pyyaml") from missing
        self.items: Any = read_yaml(path)
        if not isinstance(self.items, dict):
            raise ResultError(f"{path}:1: not keys and values; a sweep begins with 'namelist: FILE'")

    def sweep(self) -> Declaration:
        for key in self.items:
            if key not in KEYS:
                self.note(key, f"a sweep has no key '{key}'{meant(key, KEYS)}; it has {', '.join(KEYS)}")
        folder = self.path.parent
        cases, names, varying = self.cases()
        sweep = Declaration(
            path=self.path, namelist=folder / self.file("namelist"), output=(folder / self.file("output")).resolve(),
            cases=cases, names=names, varying=varying, columns=self.columns(), derived=self.derived(), mean=self.number("mean", float, None),
            threads=self.number("threads", int, 1), memory=self.number("memory", int, None),
            runtime=self.number("runtime", int, 60), checkpoint=self.number("checkpoint", float, 600.0, least=0), units=self.units)
        if sweep.namelist != folder and not os.path.isfile(sweep.namelist):
            self.note(self.items["namelist"], f"namelist: there is no file {sweep.namelist}")
        for name in WRITTEN:
            if (sweep.output / name).resolve() in (sweep.namelist.resolve(), self.path):
                self.note(self.items["output"], f"output: {sweep.output / name} would be replaced by what the sweep writes; name another folder")
        if self.mistakes:
            raise ResultError("\n".join(self.mistakes))
        return sweep

    def note(self, text: Any, mistake: str) -> None:
        self.mistakes.append(f"{self.path}:{getattr(text, 'line', 1)}: {printable(mistake)}")

    def label(self, name: str) -> Any:
        """A key of the sweep as it stands in the file, with its line."""
        return next(key for key in self.items if key == name)

    def file(self, name: str) -> str:
        value = self.items.get(name)
        if not isinstance(value, str) or not value or not value.isprintable():
            self.note(value, f"{name}: a path is needed, from the folder of this file: '{name}: FILE'")
            return ""
        return value

    def number(self, name: str, kind: type, default: Any, least: float | None = None) -> Any:
        if name not in self.items:
            return default
        text = self.items[name]
        try:
            value = kind(text)
            if math.isfinite(value) and (value > 0 if least is None else value >= least):
                return value
        except (TypeError, ValueError, OverflowError):
            pass
        self.note(self.label(name), f"{name}: {shown(text)}: one {'whole ' if kind is int else ''}number is needed, "
                                    f"{'above 0' if least is None else f'{least} or more'}")
        return default

    def columns(self) -> tuple[str, ...]:
        value = self.items.get("columns", ["*"])
        value = value if isinstance(value, list) else [value]
        if not value or not all(isinstance(item, str) and item for item in value):
            self.note(self.label("columns"), "columns: a list of names is needed, such as [G_vcct_I, J]")
        return tuple(map(str, value))

    def derived(self) -> dict[str, str]:
        """Name -> text of the derived columns."""
        items = self.items.get("derived", {})
        if not isinstance(items, dict):
            self.note(self.label("derived"), "derived: names with texts are needed, such as 'K_max: max K_I'")
            return {}
        for name, text in items.items():
            if not NAME.fullmatch(name):
                self.note(name, f"derived: '{name}': a name is of letters, digits and _")
            elif not isinstance(text, str) or (what := mistake(text)):
                self.note(name, f"derived: {name}: {what if isinstance(text, str) else f'{shown(text)} is no text'}")
        return {str(name): str(text) for name, text in items.items()}

    def cases(self) -> tuple[dict[str, dict[str, str]], dict[str, dict[str, str]], tuple[str, ...]]:
        """Name -> settings and name -> own names of all cases, the product's first; and what varies."""
        count = len(self.mistakes)
        common = self.accuracy() | self.settings("set", self.items.get("set", {}))
        found, seen = [], set()
        for line, declared in [*self.combined(), *self.listed()]:
            values = self.computed(declared | {key: value for key, value in common.items() if key not in declared}, line)
            settings = {key: value for key, value in values.items() if not key.startswith("$")}
            same = tuple(sorted(settings.items()))
            if same in seen:
                self.note(line, f"the case {', '.join(f'{k}={v}' for k, v in settings.items())} is there already")
            seen.add(same)
            found.append((settings, {key: values[key] for key in values if key.startswith("$")}, {key: values[key] for key in declared}))
        if not found and len(self.mistakes) == count:
            self.note(None, "there are no cases: 'product' or 'cases' is needed")
        return named(found)

    def accuracy(self) -> dict[str, str]:
        """The error that is asked of a column as settings of all cases."""
        items = self.items.get("accuracy", {})
        if "accuracy" in self.items and (not isinstance(items, dict) or len(items) != 1):
            self.note(self.label("accuracy"), "accuracy: a column with its error is needed, such as 'accuracy: {K_I: 0.01}'; groups &accuracy of the "
                                              "namelist ask for more than one")
            return {}
        return {self.key(key, key): self.value(key, value, name) for name, error in items.items() for key, value in (("accuracy.quantity", name), ("accuracy.error", error))}

    def settings(self, where: str, items: Any) -> dict[str, str]:
        """Keys and own names with their values as texts, of a case or of all."""
        if not isinstance(items, dict):
            self.note(self.label(where), f"{where}: keys with values are needed, such as 'grid.cell: 1e-3'")
            return {}
        return {self.key(key, key): self.value(key, value, key) for key, value in items.items()}

    def computed(self, values: Mapping[str, str], line: Any) -> dict[str, str]:
        """Values with those of their expressions, which may name keys and own names of the same case."""
        done: dict[str, str] = {}
        begun = set()

        def value_of(name: str) -> str:
            key = f"${name}" if "." not in name else name.lower()
            if key not in values:
                raise ExpressionError(f"the case has no {key}; it has {', '.join(values)}")
            if key not in done:
                if key in begun:
                    raise ExpressionError(f"{key} depends on itself")
                begun.add(key)
                done[key] = substitute(values[key], value_of)
            return done[key]
        for key, value in values.items():
            try:
                if EXPRESSION.search(value):
                    value_of(key.lstrip("$"))
                else:
                    done[key] = value
            except ExpressionError as error:
                self.note(line, f"{key}: {error}")
                return dict(values)
        return {key: done[key] for key in values}

    def combined(self) -> list[tuple[Any, dict[str, str]]]:
        """(where it is declared, settings) of every combination of the product."""
        axes = self.items.get("product", {})
        if not isinstance(axes, dict):
            self.note(self.label("product"), "product: keys with lists of values are needed, such as 'grid.cell: [1e-3, 2e-3]'")
            return []
        axes = [self.axis(keys, values) for keys, values in axes.items()]
        seen = [key for axis in axes if axis for key in axis[0]]
        for key in sorted({key for key in seen if seen.count(key) > 1}):
            self.note(self.label("product"), f"product: '{key}' stands in two of its keys")
        if math.prod(map(len, axes)) > MOST_CASES:
            self.note(self.label("product"), f"product: it makes {math.prod(map(len, axes))} cases; at most {MOST_CASES} can be run")
            return []
        return [(self.label("product"), {key: value for part in parts for key, value in part.items()})
                for parts in product(*axes)] if axes else []

    def axis(self, label: str, values: Any) -> list[dict[str, str]]:
        """The settings of each value of a key, or of keys that change together ('grid.cell, grid.cells')."""
        keys = [self.key(key, label) for key in label.split(",")]
        if not isinstance(values, list) or not values:
            self.note(label, f"{label}: a list of values is needed, such as [1e-3, 2e-3]")
            return []
        rows = values if len(keys) > 1 else [[value] for value in values]
        for row in rows:
            if not isinstance(row, list) or len(row) != len(keys):
                self.note(label, f"{label}: {shown(row)}: each value is a list of {len(keys)}, one for each key")
                return []
        return [{key: self.value(key, value, label) for key, value in zip(keys, row)} for row in rows]

    def listed(self) -> list[tuple[Any, dict[str, str]]]:
        """(where it is declared, settings) of every case of the list."""
        cases = self.items.get("cases", [])
        if not isinstance(cases, list) or not all(isinstance(case, dict) and case for case in cases):
            self.note(self.label("cases"), "cases: a list of settings is needed, such as '- {grid.cell: 1e-3}'")
            return []
        return [(next(iter(case)), self.settings("cases", case)) for case in cases]

    def key(self, key: str, where: Any) -> str:
        """A key of --set in lower case, or an own name; a mistake where hampm has none of this name."""
        key = str(key).strip()
        if key.startswith("$"):
            if not NAME.fullmatch(key[1:]):
                self.note(where, f"'{key}': a name of one's own is $ and letters, digits and _, such as $n")
            return key
        key = key.lower()
        group, _, name = key.partition(".")
        group = re.sub(r"\(\d+\)$", "", group)
        if not name:
            self.note(where, f"'{key}': a key is GROUP.KEY, such as grid.cell")
        elif group not in self.groups:
            self.note(where, f"'{key}': hampm has no group &{group}{meant(group, self.groups)}")
        elif name not in self.groups[group]:
            new = new_key(group, name)
            hint = f"; it is called {new} now: tools/upgrade.py rewrites the file" if new != name else meant(name, self.groups[group])
            self.note(where, f"'{key}': &{group} has no key '{name}'{hint}")
        elif key == OWN_KEY:
            self.note(where, f"'{key}': the results of a sweep are named by their folders")
        else:
            self.units[key] = self.groups[group][name]
        return key

    def value(self, key: str, value: Any, where: Any) -> str:
        """A value as text for --set; a list of numbers or names becomes one with commas."""
        parts = value if isinstance(value, list) else [value]
        if not all(isinstance(part, str) for part in parts):
            self.note(where, f"{key}: {shown(value)}: a value is a number, a name or a list of these")
            return ""
        text = ",".join(str(part).strip() for part in parts)
        if "${" in EXPRESSION.sub("", text):
            self.note(where, f"{key}: {shown(text)}: an expression is not closed: '${{...}}'; between {{ }} or [ ] it needs quotes")
        return text


def meant(word: str, known: Iterable[str]) -> str:
    """What may be meant by a word that is not known, as the end of a sentence."""
    close = get_close_matches(word, list(known), 1)
    return f"; did you mean '{close[0]}'?" if close else ""


def shown(value: object) -> str:
    """A value as YAML writes it."""
    return json.dumps(value, ensure_ascii=False).replace('"', "")
