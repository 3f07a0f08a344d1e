#!/usr/bin/env python3
"""List the cases that a sweep declares, after looking for mistakes in it. Nothing is run.

A sweep is a YAML file; docs/batches.md explains its keys:

    namelist: dcb.nml                 the scene, beside the sweep file
    output: ../results/sweep          folder of the cases and the table
    product:                          every value with every other one; keys are those of --set
      method.mass: [lumped, consistent]
      grid.cell, grid.cells:          keys that change together
        - [2.5e-3, [40, 5]]
        - [1.25e-3, [80, 9]]
    cases:                            a list of cases, beside the product or in its place
      - {method.scheme: usl, method.courant: 0.05}
    columns: [G_vcct_I, J]     of the history, for the table: last values; default: all
    mean: 2e-4                        and means over so much time at the end [s]; default: none
    threads: 1                        of a case
    memory: 500                       of a case [MB]; default: what `hampm --check` says it needs
    runtime: 60                       of a case at most [minutes], for clusters
    checkpoint: 600                   wall time between checkpoints [s]; 0: none
"""

import argparse
import hashlib
import json
import math
import os
import re
import subprocess
from dataclasses import dataclass
from difflib import get_close_matches
from itertools import product
from pathlib import Path

from declaration import ROOT, UNREADABLE, ResultError, printable, read_yaml, run
from program import find_program
from upgrade import new_key

PROGRAM = find_program(ROOT)
KEYS = ("namelist", "output", "product", "cases", "columns", "mean", "threads", "memory", "runtime", "checkpoint")
MOST_CASES = 100_000
WRITTEN = "table.csv", "table.h5", "progress"  # files in the folder of a sweep
OWN_KEY = "output.file"  # the runs of a sweep name their results themselves


@dataclass(frozen=True)
class Sweep:
    """A sweep as declared.

    path, namelist, output   absolute paths
    cases                    name -> {group.key: value}, both as text
    columns                  patterns of columns of the history
    mean                     time at the end over which means are taken [s]; None: no means
    threads, memory, runtime of a case; memory [MB] is None where it is not declared, runtime in minutes
    checkpoint               wall time between checkpoints [s]
    units                    of the keys that cases set
    """

    path: Path
    namelist: Path
    output: Path
    cases: dict
    columns: tuple
    mean: float | None
    threads: int
    memory: int | None
    runtime: int
    checkpoint: float
    units: dict

    @property
    def keys(self):
        """All keys that any case sets, in the order of the file."""
        return list(dict.fromkeys(key for settings in self.cases.values() for key in settings))

    def folder(self, name):
        """Where a case is run and leaves its result."""
        return self.output / "cases" / name


def main(arguments=None):
    options = parse(arguments)
    sweep = read_sweep(options.sweep, options.program)
    for name, settings in sweep.cases.items():
        print(name, *(f"{key}={value}" for key, value in settings.items()))


def parse(arguments):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sweep", metavar="SWEEP.yaml", type=Path)
    parser.add_argument("--program", metavar="FILE", type=Path, default=PROGRAM, help="hampm, whose keys are allowed")
    return parser.parse_args(arguments)


def read_sweep(path, program=PROGRAM):
    """The sweep that a file declares. ResultError names all mistakes, each with its line and what would be right."""
    path = Path(path).resolve()
    return Reader(path, namelist_keys(program)).sweep()


def namelist_keys(program):
    """'group' -> its keys, each with its unit, from the program's own reference, which has all that --set takes."""
    try:
        text = subprocess.run([program, "--keys"], check=True, capture_output=True, text=True).stdout
    except (OSError, subprocess.CalledProcessError) as error:
        raise ResultError(f"{program}: cannot be run ({error}); build it with make", UNREADABLE) from error
    groups = {}
    for name, key, unit in re.findall(r"^## &(\w+)|^\| `(\w+)` \|[^|]*\| *([^|]*?) *\|", text, re.MULTILINE):
        if name:
            keys = groups[name] = {}
        else:
            keys[key] = unit or "1"
    return groups


def case_name(settings):
    """Name of a case: what it sets, as far as a file name can say it, and a number that follows from it alone."""
    words = "_".join(f"{key.rpartition('.')[2]}-{value.replace(',', 'x')}" for key, value in settings.items())
    words = re.sub(r"[^A-Za-z0-9.+_-]", "", words)[:80]
    digest = hashlib.sha256(json.dumps(sorted(settings.items())).encode()).hexdigest()
    return f"{words}_{digest[:8]}"


class Reader:
    """Takes a declaration apart and notes what is wrong with it."""

    def __init__(self, path, groups):
        self.path, self.groups, self.mistakes, self.units = path, groups, [], {}
        self.items = read_yaml(path)
        if not isinstance(self.items, dict):
            raise ResultError(f"{path}:1: not keys and values; a sweep begins with 'namelist: FILE'")

    def sweep(self):
        for key in self.items:
            if key not in KEYS:
                self.note(key, f"a sweep has no key '{key}'{meant(key, KEYS)}; it has {', '.join(KEYS)}")
        folder = self.path.parent
        sweep = Sweep(
            path=self.path, namelist=folder / self.file("namelist"), output=(folder / self.file("output")).resolve(),
            cases=self.cases(), columns=self.columns(), mean=self.number("mean", float, None),
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

    def note(self, text, mistake):
        self.mistakes.append(f"{self.path}:{getattr(text, 'line', 1)}: {printable(mistake)}")

    def label(self, name):
        """A key of the sweep as it stands in the file, with its line."""
        return next(key for key in self.items if key == name)

    def file(self, name):
        value = self.items.get(name)
        if not isinstance(value, str) or not value or not value.isprintable():
            self.note(value, f"{name}: a path is needed, from the folder of this file: '{name}: FILE'")
            return ""
        return value

    def number(self, name, kind, default, least=None):
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

    def columns(self):
        value = self.items.get("columns", ["*"])
        value = value if isinstance(value, list) else [value]
        if not value or not all(isinstance(item, str) and item for item in value):
            self.note(self.label("columns"), "columns: a list of names is needed, such as [G_vcct_I, J]")
        return tuple(map(str, value))

    def cases(self):
        """Name -> settings of all cases, the product's first."""
        cases, count = {}, len(self.mistakes)
        for line, settings in [*self.combined(), *self.listed()]:
            name = case_name(settings)
            if name in cases:
                self.note(line, f"the case {', '.join(f'{k}={v}' for k, v in settings.items())} is there already")
            cases[name] = settings
        if not cases and len(self.mistakes) == count:
            self.note(None, "there are no cases: 'product' or 'cases' is needed")
        return cases

    def combined(self):
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

    def axis(self, label, values):
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

    def listed(self):
        """(where it is declared, settings) of every case of the list."""
        cases = self.items.get("cases", [])
        if not isinstance(cases, list) or not all(isinstance(case, dict) and case for case in cases):
            self.note(self.label("cases"), "cases: a list of settings is needed, such as '- {grid.cell: 1e-3}'")
            return []
        return [(next(iter(case)), {self.key(key, key): self.value(key, value, key) for key, value in case.items()})
                for case in cases]

    def key(self, key, where):
        """A key of --set in lower case; a mistake where hampm has none of this name."""
        key = str(key).strip().lower()
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

    def value(self, key, value, where):
        """A value as text for --set; a list of numbers or names becomes one with commas."""
        parts = value if isinstance(value, list) else [value]
        if not all(isinstance(part, str) for part in parts):
            self.note(where, f"{key}: {shown(value)}: a value is a number, a name or a list of these")
            return ""
        return ",".join(str(part).strip() for part in parts)


def meant(word, known):
    close = get_close_matches(word, known, 1)
    return f"; did you mean '{close[0]}'?" if close else ""


def shown(value):
    """A value as YAML writes it."""
    return json.dumps(value, ensure_ascii=False).replace('"', "")


if __name__ == "__main__":
    run(main)
